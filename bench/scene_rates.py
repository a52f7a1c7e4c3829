#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Rays and paths per second and core on every scene of scenes/, path-traced by "volpath".

    bench/scene_rates.py [--seconds 1] [--json FILE] [SCENE ...]

One thread. Each scene is rendered twice, with few and with more samples, and the difference of the counters is divided by
that of the processor times, so that reading, building and writing are left out. Prints a Markdown table: rays are those
that look for a surface and those that look for an obstacle, a path begins at the camera, segments lie between scatterings.
"""
import argparse
import json
import pathlib
import resource
import subprocess
import tempfile

import common


def run(brume, scene, samples, folder):
    """Processor seconds and counters of one render."""
    stats = folder / "stats.json"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [brume, scene, "--integrator", "volpath", "--resolution", "64x48", "--spp", str(samples), "--threads", "1",
         "--quiet", "--stats", stats, "--outfile", folder / "image.exr"],
        check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, json.loads(stats.read_text())["frames"][0]["counters"]


def measure(brume, scene, wanted, folder):
    """Rates of one scene: rays, paths, segments per second."""
    few, many = 1, 4
    first, counted = run(brume, scene, few, folder)
    while True:
        seconds, counters = run(brume, scene, many, folder)
        if seconds - first >= wanted or many >= 4096:
            break
        many *= 4
    cpu = seconds - first
    gained = {name: counters[name] - counted[name] for name in counters}
    rays = gained["Rays/intersection"] + gained["Rays/shadow"]
    return rays / cpu, gained["Rays/camera"] / cpu, gained["Paths/segments"] / cpu


def markdown(rows):
    return ["| scene | rays/s | paths/s | segments/s |", "|---|---|---|---|"] + \
        [f"| {name} | {rays / 1e6:.2f} M | {paths / 1e6:.3f} M | {segments / 1e6:.2f} M |"
         for name, rays, paths, segments in rows]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=1, help="processor seconds of the longer render, at least")
    parser.add_argument("--json", type=pathlib.Path)
    options = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for scene in options.scenes or sorted((common.ROOT / "scenes").glob("*.pbrt")):
            rates = measure(common.built("brume"), scene, options.seconds, pathlib.Path(folder))
            rows.append([scene.stem, *rates])
    print("\n".join(markdown(rows)))
    if options.json:
        options.json.write_text(json.dumps({"machine": common.machine(), "rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
