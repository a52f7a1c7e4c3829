#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Turns the results.json of `brume bench` into Markdown tables and one SVG for the documentation.

  bench/error_table.py RESULTS.json [--svg FILE.svg] [--clock] [--error flip] [--targets N]

Standard output: how many times less time than the baseline each method needs for the smallest error
that both reach, a table of seconds to error for each scene, and what holds at the end of the renders.
Times are the processor's (--clock: of the wall). Where the baseline never gets down to an error,
`> N x` divides the time of its whole render by the other's time to that error: at least so many times
longer. Seconds are read off the line, straight in logarithms, through the means over the seeds.
"""
import argparse
import json
import math
import pathlib
import sys

from svg_plot import grid_of_plots, short

ERRORS = {"relmse": "relMSE", "flip": "FLIP"}


def label(curve, all_threads):
    threads = curve["threads"]
    return curve["method"] + (f", {threads} threads" if threads and len(all_threads) > 1 else "")


def mean_curves(scene, time, error):
    """{method: [(seconds, error), ...]}: means over the seeds, moment by moment."""
    threads = {c["threads"] for c in scene["curves"] if c["threads"]}
    groups = {}
    for curve in scene["curves"]:
        points = [(p[time], p[error]) for p in curve["points"] if p.get(time, 0) > 0]
        if points:
            groups.setdefault(label(curve, threads), []).append(points)
    def mean(moment):
        return tuple(sum(values) / len(values) for values in zip(*moment))
    return {name: [mean(moment) for moment in zip(*seeds)] for name, seeds in groups.items()}


def reach(curve, target):
    """Seconds until the error is down to the target, or None."""
    for i, (seconds, error) in enumerate(curve):
        if error > target:
            continue
        if i == 0:
            return seconds
        before_seconds, before_error = curve[i - 1]
        low = max(error, 0.01 * target)  # what is not positive has no logarithm
        share = math.log(before_error / target) / math.log(before_error / low)
        return before_seconds * (seconds / before_seconds) ** share
    return None


def floor_of(scene):
    """Below a tenth of the reference's own relMSE, which is subtracted, what is left says little."""
    return 0.1 * scene["reference noise"] if scene["reference noise is known"] else 0


def targets_of(curves, baseline, most, floor):
    """Errors 1, 0.3, 0.1, ... down to the floor that a curve passes after its first point: the last ones, from two
    of the baseline's and two that it shares with another method on."""
    def passed(curve):
        first = curve[0][1]
        least = max(floor, min((error for _, error in curve if error > 0), default=first))
        ladder = [digit * 10.0 ** e for e in range(3, -13, -1) for digit in (3, 1)]
        return [t for t in ladder if least <= t < first]
    everyone = sorted({t for curve in curves.values() for t in passed(curve)}, reverse=True)
    own = passed(curves[baseline]) if baseline in curves else []
    others = {t for name, curve in curves.items() if name != baseline for t in passed(curve)}
    start = max(0, len(everyone) - most)
    for wanted in (own, [t for t in own if t in others]):
        if wanted:
            start = min(start, max(0, everyone.index(wanted[-1]) - 1))
    return everyone[start:]


def ratio(curves, baseline, name, target):
    """How many times longer the baseline takes, as text; "" where nothing can be said."""
    own = reach(curves[name], target)
    if own is None or baseline not in curves:
        return ""
    base = reach(curves[baseline], target)
    if base is not None:
        return f"{short(base / own)} x"
    whole = curves[baseline][-1][0] / own
    return f"> {short(whole)} x" if whole > 1 else ""


def scene_table(curves, baseline, targets, time_name, error_name):
    rows = [f"| {time_name} to {error_name} | " + " | ".join(map(short, targets)) + " |",
            "|---|" + "---|" * len(targets)]
    for name, curve in curves.items():
        cells = []
        for target in targets:
            seconds = reach(curve, target)
            factor = "" if name == baseline else ratio(curves, baseline, name, target)
            cells.append("-" if seconds is None else f"{short(seconds)} ({factor})" if factor
                         else short(seconds))
        rows.append(f"| {name} | " + " | ".join(cells) + " |")
    return rows


def summary_table(scenes, baseline, methods, error_name):
    """Ratios in front: each scene at the smallest error that the baseline and another method reach."""
    rows = [f"| scene | {error_name} | " + " | ".join(f"{baseline} / {m}" for m in methods) + " |",
            "|---|---|" + "---|" * len(methods)]
    for name, curves, targets in scenes:
        reached = [t for t in targets if baseline in curves and reach(curves[baseline], t) is not None
                   and any(m in curves and reach(curves[m], t) is not None for m in methods)]
        if not reached:
            rows.append(f"| {name} | | " + " | ".join("" for _ in methods) + " |")
            continue
        cells = []
        for method in methods:
            factor = ratio(curves, baseline, method, reached[-1]) if method in curves else ""
            cells.append(factor or ("not reached" if method in curves else ""))
        rows.append(f"| {name} | {short(reached[-1])} | " + " | ".join(cells) + " |")
    return rows


def end_table(scene, time):
    threads = {c["threads"] for c in scene["curves"] if c["threads"]}
    rows = ["| at the end | seconds | relMSE | FLIP | mean / reference | peak memory |",
            "|---|---|---|---|---|---|"]
    for curve in scene["curves"]:
        name = label(curve, threads) + (f", seed {curve['seed']}" if curve["threads"] else "")
        if not curve["points"]:
            rows.append(f"| {name} | {curve.get('failure', 'no images')} | | | | |")
            continue
        p = curve["points"][-1]
        memory = f"{curve['peak memory'] / 2**20:.0f} MiB" if curve.get("peak memory") else ""
        rows.append(f"| {name} | {short(p.get(time, p['seconds']))} | {short(p['relmse'])} | "
                    f"{short(p['flip'])} | {p['mean ratio']:.3f} | {memory} |")
    return rows


def slope(points, first, last):
    """Exponent of relMSE over passes between two numbers of passes: a straight line in logarithms."""
    logs = [(math.log(p["samples"]), math.log(p["relmse"])) for p in points
            if first <= p["samples"] <= last and p["relmse"] > 0]
    if len(logs) < 3:
        return None
    x, y = (sum(v) / len(logs) for v in zip(*logs))
    return sum((a - x) * (b - y) for a, b in logs) / sum((a - x) ** 2 for a, _ in logs)


def progress_table(scenes):
    """How the error of renders that estimate it themselves falls with the passes, and what they say."""
    rows = []
    for scene in scenes:
        for curve in scene["curves"]:
            points = [p for p in curve["points"] if p["relmse"] > floor_of(scene)]
            told = [(p["estimated error"], p["relative error"]) for p in points
                    if p.get("estimated error") and p.get("relative error")]
            passes = [p["samples"] for p in curve["points"] if p.get("samples")]
            if not told or not passes or passes[-1] < 100:
                continue
            ratios = [a / b for a, b in told]
            decades = [slope(points, passes[-1] / 10 ** (d + 1), passes[-1] / 10 ** d)
                       for d in (2, 1, 0)]
            rows.append(f"| {scene['name']} | {curve['method']} | {passes[-1]:.0f} | "
                        + " | ".join("" if d is None else f"{d:.2f}" for d in decades)
                        + f" | {min(ratios):.2f} ... {max(ratios):.2f} |")
    if not rows:
        return []
    return ["", "How relMSE falls: exponents of the number of samples or passes over the last three decades, and the "
            "relative error that the render itself estimates (`--error`) over the true one, least and largest.", "",
            "| scene | method | passes | first | second | last decade | estimated / true |",
            "|---|---|---|---|---|---|---|"] + rows


def markdown(results, time, error, most):
    """The lines of the page, and the panels of the plot."""
    machine, baseline = results["machine"], results["baseline"]
    time_name = "processor seconds" if time == "cpu seconds" else "seconds"
    scenes, details, panels = [], [], []
    for scene in results["scenes"]:
        curves = mean_curves(scene, time, error)
        panels.append((scene["name"], curves))
        if not curves:
            details += ["", f"**{scene['name']}**: nothing was measured."]
            continue
        floor = floor_of(scene) if error == "relmse" else 0
        targets = targets_of(curves, baseline, most, floor)
        scenes.append((scene["name"], curves, targets_of(curves, baseline, 99, floor)))
        width, height = scene["resolution"]
        noise = (f"the reference's own relMSE of {short(scene['reference noise'])} is subtracted"
                 if scene["reference noise is known"] else "the reference's noise is not known")
        details += ["", f"**{scene['name']}** ({width} x {height} pixels; {noise})", ""]
        if targets:
            details += scene_table(curves, baseline, targets, time_name, ERRORS[error]) + [""]
        details += end_table(scene, time)
    methods = list(dict.fromkeys(n for _, curves, _ in scenes for n in curves if n != baseline))
    lines = [f"brume {results['brume']}, {results['date']}; {machine['processor']}, "
             f"{machine['processors']} processors, load average {machine['load']:.1f}. "
             f"{time_name.capitalize()} until the error is reached, {baseline} over the method: "
             f"2 x is half of {baseline}'s time.", ""]
    return (lines + summary_table(scenes, baseline, methods, ERRORS[error])
            + progress_table(results["scenes"]) + details, panels, time_name)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", type=pathlib.Path, metavar="RESULTS.json")
    parser.add_argument("--svg", type=pathlib.Path, help="where the plot goes")
    parser.add_argument("--clock", action="store_true", help="seconds of the wall's clock")
    parser.add_argument("--error", choices=list(ERRORS), default="relmse")
    parser.add_argument("--targets", type=int, default=4, help="errors in each table")
    arguments = parser.parse_args()
    results = json.loads(arguments.results.read_text())
    if not results.get("scenes"):
        sys.exit(f"{arguments.results} has no scenes")
    time = "seconds" if arguments.clock else "cpu seconds"
    lines, panels, time_name = markdown(results, time, arguments.error, arguments.targets)
    print("\n".join(lines))
    if arguments.svg:
        arguments.svg.write_text(grid_of_plots(panels, time_name, ERRORS[arguments.error]))


if __name__ == "__main__":
    main()
