#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The scripts of bench/: figures of which the answer is known, through their command lines."""
import copy
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as xml

BENCH = pathlib.Path(__file__).resolve().parents[2] / "bench"


def call(script, *arguments, stdin=None):
    return subprocess.run([sys.executable, BENCH / script, *map(str, arguments)], input=stdin,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)


def rows_of(output):
    """Markdown tables: {first cell: [other cells]} (the last row of a name counts)."""
    rows = {}
    for line in output.splitlines():
        if line.startswith("|"):
            cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
            rows[cells[0]] = cells[1:]
    return rows


def curve(method, seed, points):
    return {"method": method, "threads": 1, "seed": seed, "peak memory": 2**20,
            "points": [{"seconds": 2 * s, "cpu seconds": s, "relmse": e, "flip": e, "mean ratio": 1}
                       for s, e in points]}


# Error = 1 / seconds for the baseline, 1 / (4 seconds) for the other: a quarter of the time. Two seeds
# of the other have 0.8 and 1.2 times the error.
BASE = [(2.0 ** i, 2.0 ** -i) for i in range(-4, 6)]
OTHER = [(s, e / 4) for s, e in BASE]
RESULTS = {
    "title": "t", "brume": "1", "date": "now", "baseline": "base",
    "machine": {"processor": "p", "processors": 2, "memory": 1, "system": "s", "load": 0.5},
    "scenes": [{"name": "ball", "resolution": [4, 3], "reference noise": 1e-3,
                "reference noise is known": True,
                "curves": [curve("base", 1, BASE),
                           curve("other", 1, [(s, 0.8 * e) for s, e in OTHER]),
                           curve("other", 2, [(s, 1.2 * e) for s, e in OTHER])]}]}


class WithFolder(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)

    def file(self, name, content):
        path = self.folder / name
        path.write_text(json.dumps(content))
        return path


class ErrorTable(WithFolder):
    def table(self, results, *options):
        done = call("error_table.py", self.file("results.json", results), *options)
        self.assertEqual(done.returncode, 0, done.stdout)
        return rows_of(done.stdout)

    def test_ratios_and_seconds(self):
        rows = self.table(RESULTS)
        targets = [float(t) for t in rows["processor seconds to relMSE"]]
        for target, base in zip(targets, rows["base"]):
            if base != "-":
                self.assertAlmostEqual(float(base) * target, 1, delta=0.01)
        self.assertEqual(rows["ball"][1], "4 x")

    def test_wall_clock_and_flip(self):
        rows = self.table(RESULTS, "--clock", "--error", "flip")
        targets = [float(t) for t in rows["seconds to FLIP"]]
        self.assertAlmostEqual(float(rows["base"][0]) * targets[0], 2, delta=0.02)

    def test_a_baseline_that_never_gets_there_gives_a_bound(self):
        results = copy.deepcopy(RESULTS)
        results["scenes"][0]["curves"] = [curve("base", 1, BASE[:6]), curve("other", 1, OTHER)]
        done = call("error_table.py", self.file("results.json", results), "--targets", 6).stdout
        # The baseline ends after 2 seconds; the other reaches 0.3 after 1 / (4 * 0.3), 0.1 after 2.5.
        self.assertIn("| 0.833 (> 2.4 x) | 2.5 |", done)

    def test_scenes_without_baseline_or_curves(self):
        results = copy.deepcopy(RESULTS)
        results["scenes"][0]["curves"] = [curve("other", 1, OTHER)]
        results["scenes"].append(dict(results["scenes"][0], name="empty", curves=[
            {"method": "broken", "threads": 1, "seed": 1, "points": [], "failure": "it crashed"}]))
        rows = self.table(results)
        self.assertGreaterEqual(len(rows["processor seconds to relMSE"]), 2)

    def test_rates_and_estimated_errors(self):
        results = copy.deepcopy(RESULTS)
        points = [dict(seconds=n, relmse=n ** (-2 / 3), flip=0.1, samples=n,
                       **{"cpu seconds": n, "mean ratio": 1, "relative error": n ** (-1 / 3),
                          "estimated error": (0.9 if n < 100 else 1.1) * n ** (-1 / 3)})
                  for n in (2 ** k for k in range(13))]
        results["scenes"][0]["curves"] = [{"method": "passes", "threads": 1, "seed": 1, "points": points}]
        done = call("error_table.py", self.file("results.json", results)).stdout
        self.assertIn("| ball | passes | 4096 | -0.67 | -0.67 | -0.67 | 0.90 ... 1.10 |", done)

    def test_nothing_is_read_off_far_below_the_reference_noise(self):
        results = copy.deepcopy(RESULTS)
        results["scenes"][0]["curves"] = [curve("base", 1, BASE + [(512, 2e-5)])]
        targets = [float(t) for t in self.table(results)["processor seconds to relMSE"]]
        self.assertEqual(min(targets), 1e-4)  # a tenth of the noise
        results["scenes"][0]["reference noise"] = 0
        targets = [float(t) for t in self.table(results)["processor seconds to relMSE"]]
        self.assertEqual(min(targets), 3e-5)

    def test_errors_below_the_reference_noise_are_not_drawn(self):
        results = copy.deepcopy(RESULTS)
        results["scenes"][0]["curves"] = [curve("base", 1, BASE + [(64, -1e-3)])]
        svg = self.folder / "plot.svg"
        self.table(results, "--svg", svg)
        circles = xml.parse(svg).getroot().findall("{http://www.w3.org/2000/svg}circle")
        self.assertEqual(len(circles), len(BASE))
        heights = [float(c.get("cy")) for c in circles]
        self.assertEqual(heights, sorted(heights), "errors that fall are drawn downwards")


class Compare(WithFolder):
    TIMES = [100.0, 101.0, 99.0, 100.5, 99.5]

    def compare(self, factor, *options):
        machine = {"processor": "p", "processors": 2, "load": 0.5, "brume": "1", "date": "now"}
        old = self.file("old.json", {"machine": machine, "times": {"a": self.TIMES}, "rates": {}})
        new = self.file("new.json", {"machine": dict(machine, processor="q"), "rates": {},
                                     "times": {"a": [factor * t for t in self.TIMES]}})
        return call("compare.py", old, new, *options)

    def test_verdicts(self):
        for factor, word in ((1, "same"), (1.3, "slower"), (0.7, "faster")):
            done = self.compare(factor)
            self.assertIn(f"{factor:5.3f}", done.stdout)
            self.assertIn(word, done.stdout)
            self.assertIn("Two kinds of processor", done.stdout)

    def test_fails_above(self):
        self.assertEqual(self.compare(1.3, "--fail-above", 1.1).returncode, 1)
        self.assertEqual(self.compare(1.05, "--fail-above", 1.1).returncode, 0)

    def test_takes_the_output_of_the_program(self):
        runs = [{"name": "a", "run_name": "a", "run_type": "iteration", "cpu_time": t,
                 "real_time": t, "time_unit": "us"} for t in self.TIMES]
        file = self.file("google.json", {"context": {}, "benchmarks": runs})
        done = call("compare.py", file, file)
        self.assertIn("1e+05 ns", done.stdout)
        self.assertIn("same", done.stdout)


class PlotBeams(unittest.TestCase):
    def test_draws_the_table_of_growth(self):
        table = "\n".join(f"| {what} | {n}^2 | 1e+0{n // 16} | {n / 8} | 9.0 | {n}.0 | 6 | 1 | 1 |"
                          for what in ("beams", "photons", "radius") for n in (32, 64))
        done = call("plot_beams.py", stdin=table)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertEqual(len(xml.fromstring(done.stdout).findall("{http://www.w3.org/2000/svg}polyline")), 6)


class Report(unittest.TestCase):
    def test_the_page_says_what_the_figures_say(self):
        done = call("report.py", "--check")
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main()
