#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures, and writes the measured parts of docs/benchmarks.md.

  bench/report.py --run PART ... | all     measures these parts, keeps their figures in bench/measured, writes the page
  bench/report.py --errors RESULTS.json    takes the errors against time from a finished `brume bench`
  bench/report.py                          writes the page from the figures that are kept
  bench/report.py --check                  exit code 1 when the page is not what the figures say

Each part stands in the page between <!-- measured: PART --> and <!-- end -->; what is between is written
by this script alone. A part names the machine it was measured on. The programs must be built
(bench/speed.py or ./check does so). "errors" takes an hour and needs ../shared for two of its scenes.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import common
import compare
import error_table
import pass_shares
import plan_gains
import scene_rates
from svg_plot import grid_of_plots, short

PAGE = common.ROOT / "docs" / "benchmarks.md"
IMAGES = common.ROOT / "docs" / "images"
MEASURED = common.ROOT / "bench" / "measured"

# What a reader compares: (what, benchmark, what it is divided by). Ratios of processor times.
MICRO_RATIOS = [
    ("closest hit, random rays: scene / Embree alone", "closestHitInScene/random", "closestHitInEmbree/random"),
    ("closest hit, coherent rays: scene / Embree alone", "closestHitInScene/coherent", "closestHitInEmbree/coherent"),
    ("occlusion: scene / Embree alone", "occlusionInScene", "occlusionInEmbree"),
    ("free flight, homogeneous / Embree's random ray", "freeFlight/homogeneous", "closestHitInEmbree/random"),
    ("free flight, exponential / Embree's random ray", "freeFlight/exponential", "closestHitInEmbree/random"),
    ("free flight, dense grid of 64^3 / Embree's random ray", "freeFlight/grid64", "closestHitInEmbree/random"),
    ("beam pairs: plain scan / quadtree", "findBeamPairs<LinearBeams>/1000", "findBeamPairs<BeamQuadtree>/1000"),
    ("beam pairs: raster / quadtree", "findBeamPairs<RasterBeams>/20000", "findBeamPairs<BeamQuadtree>/20000"),
    ("beam pairs: with evaluation / without", "evaluateBeamPairs", "findBeamPairs<BeamQuadtree>/20000"),
    ("50 nearest photons: nanoflann / kd-tree", "nearestByNanoflann/50", "nearestPhotons/50"),
    ("photons within a radius (50): nanoflann / kd-tree", "withinByNanoflann/50", "photonsWithin/50"),
    ("building: nanoflann / kd-tree", "buildNanoflann", "buildPhotonTree"),
]


def kept(part):
    file = MEASURED / f"{part}.json"
    return json.loads(file.read_text()) if file.exists() else None


def keep(part, figures):
    MEASURED.mkdir(exist_ok=True)
    (MEASURED / f"{part}.json").write_text(json.dumps(figures, indent=1) + "\n")


def output_of(program, *arguments):
    return subprocess.run([common.built(program), *map(str, arguments)], check=True,
                          stdout=subprocess.PIPE, text=True).stdout


def script(name, *arguments):
    subprocess.run([sys.executable, common.ROOT / "bench" / name, *map(str, arguments)], check=True)


# --- errors against time ----------------------------------------------------------------------------

def rounded(value):
    """Five digits are enough to plot, and make small files."""
    if isinstance(value, float):
        return float(f"{value:.5g}")
    if isinstance(value, list):
        return [rounded(v) for v in value]
    if isinstance(value, dict):
        return {k: rounded(v) for k, v in value.items() if k not in ("counters", "times to error")}
    return value


def take_errors(file):
    MEASURED.mkdir(exist_ok=True)
    text = json.dumps(rounded(json.loads(file.read_text())))
    (MEASURED / "errors.json").write_text(text.replace('{"method"', '\n {"method"') + "\n")


def run_errors():
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([common.built("brume"), "bench", common.ROOT / "bench" / "photons.json", "-o", folder],
                       check=True)
        take_errors(pathlib.Path(folder) / "results.json")


def show_errors(results):
    lines, _, _ = error_table.markdown(results, "cpu seconds", "relmse", 4)
    return ["![relMSE against processor seconds](images/bench_errors.svg)", ""] + lines


def draw_errors():
    if results := kept("errors"):
        _, panels, time_name = error_table.markdown(results, "cpu seconds", "relmse", 4)
        (IMAGES / "bench_errors.svg").write_text(grid_of_plots(panels, time_name, "relMSE"))


# --- single parts -----------------------------------------------------------------------------------

def run_micro():
    script("compare.py", "--store")


def time_text(nanoseconds):
    for unit, size in (("ms", 1e6), ("us", 1e3)):
        if nanoseconds >= size:
            return f"{short(nanoseconds / size)} {unit}"
    return f"{short(nanoseconds)} ns"


def rate_text(rates):
    def amount(value):
        for letter, size in (("G", 1e9), ("M", 1e6), ("k", 1e3)):
            if value >= size:
                return f"{short(value / size)} {letter}"
        return short(value)
    words = {"items_per_second": "/s", "bytes_per_second": "B/s", "pairs/s": "pairs/s", "paths/s": "paths/s"}
    return ", ".join(amount(value) + words[name] for name, value in rates.items())


def show_micro(summary):
    medians = {name: compare.statistics.median(times) for name, times in summary["times"].items()}
    lines = [common.machine_line(summary["machine"]) + ".", "", "| ratio of processor times | |", "|---|---|"]
    for what, over, under in MICRO_RATIOS:
        if over in medians and under in medians:
            lines.append(f"| {what} | **{short(medians[over] / medians[under])}** |")
    lines += ["", "| benchmark | processor time | per second |", "|---|---|---|"]
    return lines + [f"| `{name}` | {time_text(medians[name])} | {rate_text(summary['rates'].get(name, {}))} |"
                    for name in sorted(medians)]


# --- the plan, speed, beams, techniques ---------------------------------------------------------------

def run_plan():
    MEASURED.mkdir(exist_ok=True)
    script("plan_gains.py", "--json", MEASURED / "plan.json")


def show_plan(figures):
    return [common.machine_line(figures["machine"]) + ".", ""] + plan_gains.markdown(figures["rows"])


def run_speed():
    MEASURED.mkdir(exist_ok=True)
    script("speed.py", "--no-build", "--json", MEASURED / "speed.json")


def show_speed(figures):
    mesh, start = figures["mesh"], figures["start"]
    rows = [("peak / (1.5 geometry + Embree)", f"{mesh['peak_to_limit']:.2f}", "below 1"),
            ("peak / (geometry + Embree)",
             f"{mesh['peak_bytes'] / (mesh['geometry_bytes'] + mesh['embree_bytes']):.2f}", "")]
    for name, share in figures["embree"].items():
        if share:
            rows.append((f"{name}: share inside Embree", f"{share['embree_share']:.0%}", "at least 40 %"))
            rows.append((f"{name}: rays per second of processor time, all / in Embree",
                         f"{share['rays_per_second'] / 1e6:.2f} M / "
                         f"{share['rays_per_second_in_embree'] / 1e6:.2f} M", ""))
    rows.append((f"parsing a mesh of {mesh['file_bytes'] / 1e6:.0f} MB, by the clock",
                 f"{mesh['parse_mb_per_second']:.0f} MB/s", "at least 100 MB/s"))
    rows.append(("the same from memory, by processor time", f"{figures['parse_mb_per_cpu_second']:.0f} MB/s", ""))
    for name, aim in (("version", ""), ("check", "below 50 ms"), ("render", "below 50 ms")):
        rows.append((f"start-up, `--{name}`" if name != "render" else "start-up, a render of 16 x 16",
                     f"{1e3 * start[name]['median_seconds']:.1f} ms, of it processor "
                     f"{1e3 * start[name]['median_cpu_seconds']:.1f} ms", aim))
    return [common.machine_line(figures["machine"]) + ".", "", "| figure | value | aim |", "|---|---|---|"] + \
        [f"| {' | '.join(row)} |" for row in rows]


def run_beams():
    tables = {mode: [line for line in output_of("brume_beams", mode).splitlines() if line.startswith("|")]
              for mode in ("report", "splat")}
    keep("beams", {"machine": common.machine(), **tables})


def show_beams(figures):
    return [common.machine_line(figures["machine"]) + ".", "", *figures["report"], "", *figures["splat"]]


def run_shares(integrator, part):
    MEASURED.mkdir(exist_ok=True)
    script("pass_shares.py", "--integrator", integrator, "--json", MEASURED / f"{part}.json")


def show_shares(integrator, figures):
    scenes = figures["shares"]
    return [common.machine_line(figures["machine"]) + ".", "",
            "| phase | " + " | ".join(scenes) + " |", "|---|" + "---|" * len(scenes)] + \
        [f"| {name} | {' | '.join(values)} |" for name, values in pass_shares.table(integrator, scenes)]


def run_techniques():
    rows = []
    for line in output_of("brume_volpath_techniques").splitlines()[1:]:
        found = re.fullmatch(r"(\S+)\s+(.*?)\s+([\d.]+)\s+(\S+)\s+(\S+)\s+(\S+)", line.strip())
        rows.append([found[i] for i in range(1, 6)])
    keep("techniques", {"machine": common.machine(), "rows": rows})


def show_techniques(figures):
    lines = [common.machine_line(figures["machine"]) + ".", "",
             "| scene | switched off or changed | noise x us: this / first row of the scene | us | noise | noise x us |",
             "|---|---|---|---|---|---|"]
    first = {}
    for name, setting, us, noise, product in figures["rows"]:
        on = first.setdefault(name, float(product))
        shown = re.sub(r'"\w+ (\w+)" "(\w+)"', r"\1 \2", setting).replace(" false", "")
        lines.append(f"| {name} | {shown} | {short(float(product) / on)} | {us} | {noise} | {product} |")
    if "lights-10" in first and "lights-1000" in first:
        lines += ["", f"1,000 lights take **{first['lights-1000'] / first['lights-10']:.2f}** times as long as 10 to the same noise."]
    return lines


def run_flights():
    text = output_of("brume_free_flights")
    rays = [int(found) for found in re.findall(r"([\d]+) ns in", text)]
    rows = []
    for found in re.finditer(r"^(\S.*?)  +(\d+) +(\d+) +(\d+) +([\d.]+)$", text, re.MULTILINE):
        size = re.match(r"grid (\d+)\^3$", found[1])
        rows.append([found[1], int(found[3]), float(found[5]) if size else None])
    keep("flights", {"machine": common.machine(), "embree": rays, "rows": rows})


def show_flights(figures):
    small, large = figures["embree"]
    lines = [common.machine_line(figures["machine"]) + f". Embree's nearest hit: {small} ns in 10,000 triangles, "
             f"{large} ns in 1,000,000.", "",
             "| medium | a free flight | / Embree's ray, 10,000 triangles | / 1,000,000 | depth of a whole chord, per voxel of an axis |",
             "|---|---|---|---|---|"]
    for name, flight, voxel in figures["rows"]:
        lines.append(f"| {name} | {flight} ns | {short(flight / small)} | {short(flight / large)} | "
                     f"{'' if voxel is None else f'{voxel:.0f} ns'} |")
    return lines


def run_rates():
    MEASURED.mkdir(exist_ok=True)
    script("scene_rates.py", "--json", MEASURED / "rates.json")


def show_rates(figures):
    return [common.machine_line(figures["machine"]) + ".", "", *scene_rates.markdown(figures["rows"])]


PARTS = {
    "errors": (run_errors, show_errors),
    "micro": (run_micro, show_micro),
    "plan": (run_plan, show_plan),
    "speed": (run_speed, show_speed),
    "beams": (run_beams, show_beams),
    "shares": (lambda: run_shares("pvpm", "shares"), lambda figures: show_shares("pvpm", figures)),
    "volpath": (lambda: run_shares("volpath", "volpath"), lambda figures: show_shares("volpath", figures)),
    "techniques": (run_techniques, show_techniques),
    "flights": (run_flights, show_flights),
    "rates": (run_rates, show_rates),
}


def page_with_figures(page):
    """The page with each part replaced by what its kept figures say; parts without any stay."""
    for part, (_, show) in PARTS.items():
        figures = json.loads(compare.BASELINE.read_text()) if part == "micro" and compare.BASELINE.exists() \
            else kept(part)
        mark = re.compile(rf"(<!-- measured: {part} -->\n).*?(<!-- end -->)", re.DOTALL)
        if figures is None:
            continue
        if not mark.search(page):
            sys.exit(f"{PAGE} has no place for \"{part}\"")
        text = "\n".join(show(figures)) + "\n"
        page = mark.sub(lambda found: found[1] + text + found[2], page)
    return page


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", nargs="+", default=[], choices=[*PARTS, "all"], metavar="PART",
                        help=", ".join(PARTS) + " or all")
    parser.add_argument("--errors", type=pathlib.Path, metavar="RESULTS.json")
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    for part in PARTS if "all" in arguments.run else arguments.run:
        print(f"measuring: {part}", file=sys.stderr)
        PARTS[part][0]()
    if arguments.errors:
        take_errors(arguments.errors)
    old = PAGE.read_text()
    new = page_with_figures(old)
    if arguments.check:
        sys.exit("docs/benchmarks.md is not what bench/measured says: run bench/report.py" if new != old else 0)
    PAGE.write_text(new)
    draw_errors()


if __name__ == "__main__":
    main()
