#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares micro-benchmarks with a stored baseline: ratios with their confidence intervals.

  bench/compare.py --store [--filter REGEX] [--repetitions N] [FILE]   measures, and keeps it as the baseline
  bench/compare.py         [--filter REGEX] [--repetitions N] [FILE]   measures, and prints new / baseline
  bench/compare.py OLD.json NEW.json                                   compares two outputs of brume_micro

FILE defaults to build-bench/baseline.json. Processor times are compared, because a busy machine
disturbs them less than the clock. A ratio below 1 is faster. The interval holds the true ratio of the
medians with 95 % confidence if repetitions are independent (bootstrap); "same" means that it
contains 1. On a shared machine whole runs may be slow together: two runs that differ by a few per
cent with narrow intervals should be measured again, in turn (--rounds). Exit code 1 when something
is slower than --fail-above.
"""
import argparse
import json
import pathlib
import random
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = ROOT / "build-bench"
RESAMPLES = 2000
CONFIDENCE = 0.95


def measure(arguments):
    """Runs brume_micro round after round, so that a slow minute of the machine hits all alike."""
    runs = []
    for _ in range(arguments.rounds):
        output = subprocess.run(
            [BUILD / "bench" / "brume_micro", "--benchmark_format=json",
             f"--benchmark_filter={arguments.filter}",
             f"--benchmark_repetitions={arguments.repetitions}",
             f"--benchmark_min_time={arguments.min_time}",
             "--benchmark_enable_random_interleaving=true"],
            check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout
        runs.append(json.loads(output))
    joined = runs[0]
    for run in runs[1:]:
        joined["benchmarks"] += run["benchmarks"]
    return joined


def times_of(report):
    """Processor times [ns] of each benchmark's repetitions."""
    scale = {"ns": 1, "us": 1e3, "ms": 1e6, "s": 1e9}
    times = {}
    for run in report["benchmarks"]:
        if run.get("run_type", "iteration") == "iteration" and "error_occurred" not in run:
            name = run.get("run_name", run["name"])
            times.setdefault(name, []).append(run["cpu_time"] * scale[run["time_unit"]])
    return times


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
    old_times, new_times = times_of(old), times_of(new)
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
    for name in old_times.keys() - new_times.keys():
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
        old, new = (json.loads(file.read_text()) for file in arguments.files)
    else:
        if len(arguments.files) > 2:
            parser.error("at most two files")
        baseline = arguments.files[0] if arguments.files else BUILD / "baseline.json"
        if not arguments.store and not baseline.exists():
            sys.exit(f"there is no baseline {baseline}; bench/compare.py --store makes it")
        if not (BUILD / "bench" / "brume_micro").exists():
            sys.exit(f"{BUILD}/bench/brume_micro is not built; bench/speed.py builds it")
        new = measure(arguments)
        if arguments.store:
            baseline.write_text(json.dumps(new, indent=1) + "\n")
            print(f"stored {baseline}: {len(times_of(new))} benchmarks")
            return
        old = json.loads(baseline.read_text())
    if compare(old, new) > arguments.fail_above:
        sys.exit(1)


if __name__ == "__main__":
    main()
