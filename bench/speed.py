#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Builds the benchmarks, measures brume's speed in one go and prints it as ratios.

  bench/speed.py [--json FILE] [--mesh-mb N] [--spp N] [--scenes FOLDER] [--no-build]

Rows: parsing and memory with a generated mesh, start-up with a 1 KB scene, and the share of two
path-traced scenes that is spent inside Embree. docs/benchmarks.md says what each figure means.
"""
import argparse
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import common

BUILD = common.BUILDS[0]
SCENES = pathlib.Path(os.environ.get("BRUME_PBRT_SCENES", common.ROOT.parent / "shared" / "pbrt-v2-scenes"))
REAL_SCENES = ["killeroo-simple", "room-path"]
RUNS = 20

VIEW = """LookAt 0.5 -1.2 1.2  0.5 0.5 0  0 0 1
Camera "perspective" "float fov" 45
Sampler "lowdiscrepancy" "integer pixelsamples" 1
Film "image" "integer xresolution" 16 "integer yresolution" 16
WorldBegin
LightSource "point" "point from" [0.5 0 3] "color I" [9 9 9]
"""


def build():
    options = ["-DCMAKE_BUILD_TYPE=Release", "-DBRUME_BENCH=ON", "-DBRUME_TESTS=OFF"]
    for command in (["cmake", "-S", common.ROOT, "-B", BUILD, *options],
                    ["cmake", "--build", BUILD, "--parallel", str(os.cpu_count())]):
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def write_mesh(path, megabytes):
    """A wavy grid of triangles as a scene file; returns the bytes that brume keeps of it."""
    side = int(math.sqrt(megabytes * 1e6 / 75))  # bytes per point: itself and two triangles
    with open(path, "w") as out:
        out.write(VIEW + 'Shape "trianglemesh" "point P" [\n')
        waves = [math.sin(40 * x / side) for x in range(side)]
        for y in range(side):
            height, v = 0.02 * math.cos(31 * y / side), y / (side - 1)
            out.write("".join(f"{x / (side - 1):.6g} {v:.6g} {height * wave:.6g}\n"
                              for x, wave in enumerate(waves)))
        out.write('] "integer indices" [\n')
        for y in range(side - 1):
            row = range(y * side, y * side + side - 1)
            out.write("".join(f"{i} {i + 1} {i + side + 1}\n{i} {i + side + 1} {i + side}\n"
                              for i in row))
        out.write("]\nWorldEnd\n")
    points, triangles = side * side, 2 * (side - 1) ** 2
    return 12 * points + 12 * triangles  # three floats, three integers


def write_small(path):
    """A scene of 1 KB: a handful of shapes."""
    text = VIEW
    for i in range(9):
        text += f'Translate 0.1 0.05 {i % 3 / 10:.2f} Shape "sphere" "float radius" 0.0{i + 1}\n'
    text += "WorldEnd\n"
    path.write_text(text + "#" * max(0, 1023 - len(text)) + "\n")


def run(*command):
    """Runs a program quietly; returns its seconds by the clock and by the processor."""
    begin = time.monotonic()
    child = subprocess.Popen([str(c) for c in command], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    seconds = time.monotonic() - begin
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        sys.exit(f"{command[0]} ended with {child.returncode}")
    return seconds, usage.ru_utime + usage.ru_stime


def measure_mesh(folder, megabytes):
    scene, stats = folder / "mesh.pbrt", folder / "stats.json"
    geometry = write_mesh(scene, megabytes)
    size, best = scene.stat().st_size, None
    for _ in range(3):  # the best of three: what else runs on the machine only ever adds
        run(common.built("brume"), "--quiet", "-o", folder / "mesh.exr", "--stats", stats, scene)
        frame = json.loads(stats.read_text())["frames"][0]
        if best is None or frame["seconds"]["parse"] < best["seconds"]["parse"]:
            best = frame
    peak, embree = best["peak memory"], best["accelerator memory"]
    return {"file_bytes": size, "parse_seconds": best["seconds"]["parse"],
            "parse_mb_per_second": size / 1e6 / best["seconds"]["parse"],
            "build_seconds": best["seconds"]["build"],
            "geometry_bytes": geometry, "embree_bytes": embree, "peak_bytes": peak,
            "peak_to_limit": peak / (1.5 * geometry + embree)}


def measure_parser(megabytes):
    """Bytes of text per second of processor time: what else runs on the machine counts less."""
    output = subprocess.run(
        [common.built("brume_micro"), "--benchmark_format=json",
         f"--benchmark_filter=parseMesh/MB:{megabytes}$"],
        check=True, stdout=subprocess.PIPE, text=True).stdout
    return json.loads(output)["benchmarks"][0]["bytes_per_second"] / 1e6


def measure_start(folder):
    scene = folder / "small.pbrt"
    write_small(scene)
    program, result = common.built("brume"), {"file_bytes": scene.stat().st_size}
    for name, arguments in {
            "version": ["--version"],
            "check": ["--quiet", "--check", scene],
            "render": ["--quiet", "-o", folder / "small.exr", scene]}.items():
        times = [run(program, *arguments) for _ in range(RUNS)]
        result[name] = {"median_seconds": statistics.median(t[0] for t in times),
                        "least_seconds": min(t[0] for t in times),
                        "median_cpu_seconds": statistics.median(t[1] for t in times)}
    return result


def measure_embree(folder, scenes, samples):
    """What brume_embree_share reports of each scene, or null where it is not at hand."""
    results = {}
    for name in REAL_SCENES:
        scene, results[name] = scenes / f"{name}.pbrt", None
        if not scene.exists():
            continue
        output = subprocess.run(
            [common.built("brume_embree_share"), "--spp", str(samples), scene],
            cwd=folder, check=True, stdout=subprocess.PIPE, text=True).stdout
        results[name] = dict(json.loads(output.strip().splitlines()[-1]), scene=scene.name)
    return results


def print_table(report):
    def row(name, value, limit=""):
        print(f"{name:<46}{value:>14}  {limit}")

    mesh, start = report["mesh"], report["start"]
    row("parsing a trianglemesh", f"{mesh['parse_mb_per_second']:.0f} MB/s", "at least 100 MB/s")
    row("  by processor time, from memory", f"{report['parse_mb_per_cpu_second']:.0f} MB/s")
    row("peak / (1.5 geometry + Embree)", f"{mesh['peak_to_limit']:.2f}", "below 1")
    for part in ("geometry", "embree", "peak"):
        row(f"  {part}", f"{mesh[part + '_bytes'] / 1e6:.0f} MB")
    for name, limit in (("version", ""), ("check", "below 50 ms"), ("render", "below 50 ms")):
        time_of = start[name]
        row(f"start-up, {name}: median of {RUNS}", f"{1e3 * time_of['median_seconds']:.1f} ms",
            limit)
        row("  of it processor time", f"{1e3 * time_of['median_cpu_seconds']:.1f} ms")
    for name, share in report["embree"].items():
        if share is None:
            row(f"{name}: inside Embree", "skipped", f"no {name}.pbrt at hand (--scenes)")
            continue
        row(f"{name}: inside Embree", f"{share['embree_share']:.1%}", "at least 40 %")
        row("  rays per second of processor time", f"{share['rays_per_second'] / 1e6:.2f} M")
        if "rays_per_second_in_embree" in share:
            row("  the same rays in Embree alone",
                f"{share['rays_per_second_in_embree'] / 1e6:.2f} M")
    print(common.machine_line(report["machine"]))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", default=BUILD / "speed.json", help="where the figures go")
    parser.add_argument("--mesh-mb", type=float, default=100, help="size of the mesh file")
    parser.add_argument("--spp", type=int, default=8, help="samples per pixel of the real scenes")
    parser.add_argument("--scenes", default=SCENES, type=pathlib.Path,
                        help="folder of the real scenes")
    parser.add_argument("--no-build", action="store_true", help="use the build that is there")
    arguments = parser.parse_args()
    if not arguments.no_build:
        build()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        report = {"machine": common.machine(),
                  "mesh": measure_mesh(folder, arguments.mesh_mb),
                  "parse_mb_per_cpu_second": measure_parser(100),
                  "start": measure_start(folder),
                  "embree": measure_embree(folder, arguments.scenes.resolve(), arguments.spp)}
    pathlib.Path(arguments.json).write_text(json.dumps(report, indent=2) + "\n")
    print_table(report)


if __name__ == "__main__":
    main()
