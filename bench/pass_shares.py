#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Where the time of a pass of "pvpm" goes.

  bench/pass_shares.py [--passes N] [--json FILE] [SCENE.pbrt ...]

Runs brume under `perf record` on one thread and sorts every sample by the innermost function of PHASES on its
stack. What is not a part of a pass (reading the scene, the pilots that choose radii and shares, writing the image) is left
out of the shares. The scenes are those of bench/photons.json unless others are named.
"""
import argparse
import collections
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import common

SCENES = ["scenes/fog_box.pbrt", "scenes/dense_fog.pbrt", "scenes/caustic_fog.pbrt", "scenes/smoke_grid.pbrt",
          "../shared/pbrt-v2-scenes/spotfog.pbrt", "../shared/pbrt-v2-scenes/smoke-2.pbrt"]
# (Phase, functions).
PHASES = [
    ("Embree", r"libembree"),
    ("photons on beams", r"gather(Group|Some|Beams|Homogeneous|InMedia)|::findTiles|BeamQuadtree::(forEach|lookup)|"
                         r"searchBall|Pvpm::gather"),
    ("light along beams", r"UnscatteredLight::|estimateInscattering|ScatteringDistanceSampler"),
    ("photons on visible points", r"SurfacePhotonMap::radiance"),
    ("direct light on surfaces", r"estimateDirect|CameraPaths::direct"),
    ("tracing photons", r"PhotonTracer::trace\b|PhotonTracer::traceChunk"),
    ("sorting photons", r"VolumePhotons::|SurfacePhotonMap::SurfacePhotonMap|PhotonKdTree::PhotonKdTree"),
    ("tree of beams", r"BeamQuadtree::BeamQuadtree|BeamQuadtree::build|placesOf"),
    ("camera paths", r"traceCameraBeams|traceTile|CameraPaths::"),
    ("the rest", r"Pvpm::renderPass"),
]
EVALUATION = {
    "Embree and beams": ["Embree", "photons on beams", "light along beams"],
    "Embree, beams and visible points": ["Embree", "photons on beams", "light along beams", "photons on visible points",
                                         "direct light on surfaces"],
}
# Frames of what runs in a parallel loop, on one thread as well.
PARALLEL = re.compile(r"start_for|task_dispatcher")
PASS = re.compile(r"Pvpm::renderPass")
ALONE = "outside of parallel loops"
MATCHERS = [(name, re.compile(pattern)) for name, pattern in PHASES]
OUTSIDE = re.compile(r"firstRadii|learnShares")  # pilots, before the first pass


def phase_of(stack):
    """The phase of a sample, its frames innermost first; None outside of passes."""
    if any(OUTSIDE.search(frame) for frame in stack):
        return None
    return next((name for frame in stack for name, pattern in MATCHERS if pattern.search(frame)), None)


def shares(scene, passes):
    """Of the phases in the passes of one render, and of what no second thread could share; of 1."""
    with tempfile.TemporaryDirectory() as folder:
        data = pathlib.Path(folder) / "perf.data"
        subprocess.run(["perf", "record", "--quiet", "--call-graph", "dwarf,65528", "-F", "97", "-o", data,
                        common.built("brume"), scene, "--integrator", "pvpm", "--passes", str(passes),
                        "--threads", "1", "--quiet", "--outfile", pathlib.Path(folder) / "image.exr"],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        script = subprocess.run(["perf", "script", "-i", data, "-F", "ip,sym,dso"], check=True, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
    counts, whole, alone = collections.Counter(), 0, 0
    for sample in script.split("\n\n"):
        stack = sample.splitlines()
        phase = phase_of(stack)
        if phase is None:
            continue
        counts[phase] += 1
        if any(PASS.search(frame) for frame in stack):  # some stacks end early
            whole += 1
            alone += not any(PARALLEL.search(frame) for frame in stack)
    samples = sum(counts.values())
    if whole == 0:
        sys.exit(f"{scene}: perf saw no pass")
    return {name: counts[name] / samples for name, _ in PHASES} | {ALONE: alone / whole}


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--passes", type=int, default=24)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    arguments = parser.parse_args()
    found = {scene.stem: shares(scene, arguments.passes)
             for scene in arguments.scenes or [common.ROOT / name for name in SCENES]}
    width = max(map(len, [*EVALUATION, *(name for name, _ in PHASES)]))
    print(" " * width, *(f"{scene:>12}" for scene in found))
    for name, _ in PHASES:
        print(f"{name:{width}}", *(f"{of[name]:12.1%}" for of in found.values()))
    for title, parts in EVALUATION.items():
        print(f"{title:{width}}", *(f"{sum(of[name] for name in parts):12.1%}" for of in found.values()))
    print(f"{ALONE:{width}}", *(f"{of[ALONE]:12.1%}" for of in found.values()))
    if arguments.json:
        arguments.json.write_text(json.dumps({"machine": common.machine(), "shares": found}, indent=1) + "\n")


if __name__ == "__main__":
    main()
