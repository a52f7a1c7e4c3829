#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Where the time of "pvpm" and of "volpath" goes.

  bench/pass_shares.py [--integrator pvpm | volpath] [--passes N] [--json FILE] [SCENE.pbrt ...]

Runs brume under `perf record` on one thread and sorts every sample by the innermost function of the method's phases on
its stack. What comes before the first pass (reading the scene, the pilots that choose radii and shares) and after the
last (writing the image) is left out of the shares. The scenes are those of bench/photons.json unless others are named.
"""
import argparse
import collections
import dataclasses
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import common

SCENES = ["scenes/fog_box.pbrt", "scenes/dense_fog.pbrt", "scenes/caustic_fog.pbrt", "scenes/smoke_grid.pbrt",
          "../shared/pbrt-v2-scenes/spotfog.pbrt", "../shared/pbrt-v2-scenes/smoke-2.pbrt"]


@dataclasses.dataclass
class Method:
    passes: int
    options: list
    whole: str  # the function that holds all passes
    onlyBelow: bool  # the functions of the phases run elsewhere, too
    before: str  # functions that belong to no pass
    phases: list  # (name, functions)
    totals: dict  # sums of phases

    def __post_init__(self):
        self.matchers = [(name, re.compile(pattern)) for name, pattern in self.phases]


METHODS = {
    "pvpm": Method(24, [], "Pvpm::renderPass", False, "firstRadii|learnShares", [
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
    ], {
        "Embree and beams": ["Embree", "photons on beams", "light along beams"],
        "Embree, beams and visible points": ["Embree", "photons on beams", "light along beams",
                                             "photons on visible points", "direct light on surfaces"],
    }),
    "volpath": Method(64, ["--resolution", "64x48"], "renderPortions", True, r"(?!)", [
        ("Embree", r"libembree"),
        ("media along rays", r"MediumAlongRay|MediumPiece|Volume::|Volumes::|VolumeGrid|DensityGrid|SlabWalk|[cC]ubics|"
                             r"Homogeneous|Exponential|avx2::|sse|Cloud|Noise|noise"),
        ("choice and sampling of lights", r"Light(Tree|Clusters|Map)|Receiver|SegmentLights|Equiangular|TowardsLights|"
                                          r"EmissionSampler|Light::|Distribution|sampleSolidAngle|sampleArea|pdfArea|"
                                          r"samplePosition|VolPath::(sampleLight|sampleEmission|equiangularLight)"),
        ("materials and phase functions", r"B[sx]df|Brdf|Phase|Material|Texture|MipMap|Microfacet|Fresnel"),
        ("hit points", r"[iI]nteraction|Quadric|TriangleMesh|Triangles|EmbreeAccelerator|Scene::|pointError|Shape"),
        ("random numbers", r"ScrambledSequence|PixelStream|Sampler|Rng"),
        ("the path itself", r"VolPath::"),
        ("camera, film, the rest", r"renderPortions"),
    ], {"Embree, media and lights": ["Embree", "media along rays", "choice and sampling of lights"]}),
}
# Frames of what runs in a parallel loop, on one thread as well.
PARALLEL = re.compile(r"start_for|task_dispatcher")
ALONE = "outside of parallel loops"


def phase_of(method, stack):
    """The phase of a sample, its frames innermost first; None outside of passes."""
    if any(re.search(method.before, frame) for frame in stack):
        return None
    return next((name for frame in stack for name, pattern in method.matchers if pattern.search(frame)), None)


def shares(scene, integrator, passes):
    """Of the phases in the passes of one render, and of what no second thread could share; of 1."""
    method = METHODS[integrator]
    with tempfile.TemporaryDirectory() as folder:
        data = pathlib.Path(folder) / "perf.data"
        subprocess.run(["perf", "record", "--quiet", "--call-graph", "dwarf,65528", "-F", "97", "-o", data,
                        common.built("brume"), scene, "--integrator", integrator,
                        "--passes", str(passes or method.passes), *method.options,
                        "--threads", "1", "--quiet", "--outfile", pathlib.Path(folder) / "image.exr"],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        script = subprocess.run(["perf", "script", "-i", data, "-F", "ip,sym,dso"], check=True, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
    counts, whole, alone = collections.Counter(), 0, 0
    for sample in script.split("\n\n"):
        stack = sample.splitlines()
        inside = any(method.whole in frame for frame in stack)  # some stacks end early
        phase = phase_of(method, stack)
        if phase is None or (method.onlyBelow and not inside):
            continue
        counts[phase] += 1
        if inside:
            whole += 1
            alone += not any(PARALLEL.search(frame) for frame in stack)
    samples = sum(counts.values())
    if whole == 0:
        sys.exit(f"{scene}: perf saw no pass")
    return {name: counts[name] / samples for name, _ in method.phases} | {ALONE: alone / whole}


def table(integrator, found):
    """Rows of text: a phase and its share in each scene, sums last."""
    method = METHODS[integrator]
    rows = [(name, [f"{of[name]:.1%}" for of in found.values()]) for name, _ in method.phases]
    rows += [(f"**{title}**", [f"**{sum(of[name] for name in parts):.0%}**" for of in found.values()])
             for title, parts in method.totals.items()]
    return rows + [(ALONE, [f"{of[ALONE]:.1%}" for of in found.values()])]


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--integrator", choices=list(METHODS), default="pvpm")
    parser.add_argument("--passes", type=int)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    arguments = parser.parse_args()
    found = {scene.stem: shares(scene, arguments.integrator, arguments.passes)
             for scene in arguments.scenes or [common.ROOT / name for name in SCENES]}
    rows = table(arguments.integrator, found)
    width = max(len(name) for name, _ in rows)
    print(" " * width, *(f"{scene:>12}" for scene in found))
    for name, values in rows:
        print(f"{name:{width}}", *(f"{value:>12}" for value in values))
    if arguments.json:
        arguments.json.write_text(json.dumps({"machine": common.machine(), "shares": found}, indent=1) + "\n")


if __name__ == "__main__":
    main()
