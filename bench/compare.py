#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares micro-benchmarks with a stored baseline: ratios with their confidence intervals.

  bench/compare.py --store [--filter REGEX] [--repetitions N] [FILE]   measures, and keeps it as the baseline
  bench/compare.py         [--filter REGEX] [--repetitions N] [FILE]   measures, and prints new / baseline
  bench/compare.py OLD.json NEW.json     compares two baselines, or two outputs of brume_micro

FILE defaults to bench/baseline.json, which the repository holds; it names its machine. Processor times
are compared, because a busy machine disturbs them less than the clock. A ratio below 1 is faster. The
interval holds the true ratio of the medians with 95 % confidence if repetitions are independent
(bootstrap); "same" means that it contains 1. On a shared machine whole runs may be slow together: two
runs that differ by a few per cent with narrow intervals should be measured again, in turn (--rounds).
Exit code 1 when something is slower than --fail-above.
"""
import argparse
import json
import pathlib
import random
import re
import statistics
import subprocess
import sys

import common

BASELINE = common.ROOT / "bench" / "baseline.json"
RESAMPLES = 2000
CONFIDENCE = 0.95
NANOSECONDS = {"ns": 1, "us": 1e3, "ms": 1e6, "s": 1e9}
PER_SECOND = ("items_per_second", "bytes_per_second", "pairs/s", "paths/s")


def measure(arguments):
    """Runs brume_micro round after round, so that a slow minute of the machine hits all alike."""
    summary = {"machine": common.machine(), "times": {}, "rates": {}}
    for _ in range(arguments.rounds):
        output = subprocess.run(
            [common.built("brume_micro"), "--benchmark_format=json",
             f"--benchmark_filter={arguments.filter}",
             f"--benchmark_repetitions={arguments.repetitions}",
             f"--benchmark_min_time={arguments.min_time}",
             "--benchmark_enable_random_interleaving=true"],
            check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout
        of_round = summarise(json.loads(output))
        for name, times in of_round["times"].items():
            summary["times"].setdefault(name, []).extend(times)
        summary["rates"].update(of_round["rates"])
    return summary


def summarise(report):
    """Processor times [ns] of each benchmark's repetitions, and the median of what it counts per second."""
    if "times" in report:
        return report
    times, rates = {}, {}
    for run in report["benchmarks"]:
        if run.get("run_type", "iteration") != "iteration" or "error_occurred" in run:
            continue
        name = run.get("run_name", run["name"])
        times.setdefault(name, []).append(float(f"{run['cpu_time'] * NANOSECONDS[run['time_unit']]:.5g}"))
        for rate in PER_SECOND:
            if rate in run:
                rates.setdefault(name, {}).setdefault(rate, []).append(run[rate])
    medians = {name: {rate: float(f"{statistics.median(values):.4g}") for rate, values in of.items()}
               for name, of in rates.items()}
    return {"times": times, "rates": medians}


def write(summary, file):
    """One line for each benchmark: a change of one is a change of its line."""
    def block(of):
        return ",\n".join(f'  {json.dumps(name)}: {json.dumps(value)}' for name, value in sorted(of.items()))
    parts = [f'"{key}": {{\n{block(summary[key])}\n}}' for key in ("machine", "times", "rates")]
    file.write_text("{\n" + ",\n".join(parts) + "\n}\n")


def tell_machines(old, new):
    for name, summary in (("baseline", old), ("new", new)):
        if "machine" in summary:
            print(f"{name}: {common.machine_line(summary['machine'])}")
    processors = [s["machine"]["processor"] for s in (old, new) if "machine" in s]
    if len(set(processors)) > 1:
        print("Two kinds of processor: the ratios are theirs as well.")


def ratio_with_interval(old, new, rng):
    """Median of new over median of old, and its bootstrap interval."""
    def resample(values):
        return statistics.median(rng.choices(values, k=len(values)))
    ratios = sorted(resample(new) / resample(old) for _ in range(RESAMPLES))
    cut = int((1 - CONFIDENCE) / 2 * RESAMPLES)
    return statistics.median(new) / statistics.median(old), ratios[cut], ratios[-1 - cut]


def verdict(low, high):
    if min(low, high) <= 1 <= max(low, high):
        return "same"
    return "faster" if high < 1 else "slower"


def compare(old, new):
    """Prints a line for each benchmark that both have; returns the largest ratio that is not noise."""
    rng = random.Random(1)
    old_times, new_times = old["times"], new["times"]
    names = [name for name in new_times if name in old_times]
    if not names:
        sys.exit("the two have no benchmark in common")
    width = max(map(len, names))
    print(f"{'benchmark':<{width}}  {'baseline':>12}  {'new':>12}  ratio  95 % interval")
    worst, logs = 0, []
    for name in names:
        a, b = old_times[name], new_times[name]
        if min(len(a), len(b)) < 3:
            sys.exit(f"{name}: an interval needs at least 3 repetitions of both")
        ratio, low, high = ratio_with_interval(a, b, rng)
        word = verdict(low, high)
        if word == "slower":
            worst = max(worst, ratio)
        logs.append(ratio)
        print(f"{name:<{width}}  {statistics.median(a):>9.4g} ns  {statistics.median(b):>9.4g} ns  "
              f"{ratio:5.3f}  {low:.3f} .. {high:.3f}  {word}")
    print(f"{'geometric mean':<{width}}  {'':>12}  {'':>12}  {statistics.geometric_mean(logs):5.3f}")
    for name in sorted(old_times.keys() - new_times.keys()):
        print(f"{name}: only in the baseline")
    return worst


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=pathlib.Path, metavar="FILE")
    parser.add_argument("--store", action="store_true", help="keep what is measured as the baseline")
    parser.add_argument("--filter", default=".", help="regular expression for names of benchmarks")
    parser.add_argument("--repetitions", type=int, default=5, help="of each benchmark in a round")
    parser.add_argument("--rounds", type=int, default=2, help="runs of the program")
    parser.add_argument("--min-time", type=float, default=0.05, help="seconds of one repetition")
    parser.add_argument("--fail-above", type=float, default=float("inf"), metavar="RATIO")
    arguments = parser.parse_args()
    if len(arguments.files) == 2:
        old, new = (summarise(json.loads(file.read_text())) for file in arguments.files)
    else:
        if len(arguments.files) > 2:
            parser.error("at most two files")
        baseline = arguments.files[0] if arguments.files else BASELINE
        if not arguments.store and not baseline.exists():
            sys.exit(f"there is no baseline {baseline}; bench/compare.py --store makes it")
        new = measure(arguments)
        if arguments.store:
            write(new, baseline)
            print(f"stored {baseline}: {len(new['times'])} benchmarks")
            return
        old = summarise(json.loads(baseline.read_text()))
        old["times"] = {name: times for name, times in old["times"].items()
                        if re.search(arguments.filter, name)}
    tell_machines(old, new)
    if compare(old, new) > arguments.fail_above:
        sys.exit(1)


if __name__ == "__main__":
    main()
