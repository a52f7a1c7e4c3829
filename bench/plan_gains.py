#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What each rule of the plan saves: a scene where it applies, and the same scene where it cannot.

  bench/plan_gains.py [--runs N] [--json FILE] [--filter REGEX] [--fail-above RATIO] [--brume FILE]

The second scene shows the same image, but for differences far below a grey level: what was idle does
just so little that it has to be kept (a light of 1e-12, a medium of 1e-7), or something needs it that is out
of view or two pixels wide. Processor times of whole runs on one thread, the least of N, the two scenes in turn. The plan must
name the rule for the first scene and not for the second. Exit code 1 when a scene with the rule takes
more than --fail-above times the time without; before that is said it is measured ten times as often, since
what else runs on the machine can only make times longer.
"""
import argparse
import dataclasses
import json
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile

import common

HEAD = """Film "image" "integer xresolution" 96 "integer yresolution" 96
Sampler "random" "integer pixelsamples" 16
LookAt 0 1 -5  0 .5 0  0 1 0
Camera "perspective" "float fov" 45
"""
LAMP = 'LightSource "point" "point from" [0 4 -4] "color I" [9 9 9]\n'
BALL = """Material "matte" "color Kd" [.6 .5 .4]
Shape "sphere"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-9 -1 -9  9 -1 -9  9 -1 9  -9 -1 9]
"""
ASIDE = "AttributeBegin Translate 0 .5 -8 {} Shape \"disk\" \"float radius\" .01 AttributeEnd\n"
SEEN = "AttributeBegin Translate 1.2 1.6 -1 {} Shape \"disk\" \"float radius\" .03 AttributeEnd\n"
ABOVE = ('Shape "trianglemesh" "integer indices" [0 1 2] '
         '"point P" [0 900 0  .01 900 0  0 900 .01]\n')


@dataclasses.dataclass
class Rule:
    name: str
    applies: str
    never: str
    plan: str  # what the plan says of the first scene alone
    runs: float = 1  # share of the runs: less for long ones


def scene(world, integrator='SurfaceIntegrator "directlighting"', fov=45):
    return f"{HEAD.replace('45', str(fov))}{integrator}\nWorldBegin\n{world}WorldEnd\n"


def grid(folder, side, share, empty):
    """A ball of smoke that takes this share of a grid's cells, around it the value for empty ones."""
    file = folder / f"grid_{side}_{share}_{empty}.pbrt"
    radius = (share * 3 / (4 * 3.14159265)) ** (1 / 3) * side
    middle = (side - 1) / 2
    lines = []
    for z in range(side):
        for y in range(side):
            rest = radius**2 - (z - middle) ** 2 - (y - middle) ** 2
            lines.append(" ".join("1" if (x - middle) ** 2 < rest else f"{empty:g}"
                                  for x in range(side)))
    file.write_text(
        f'Volume "volumegrid" "integer nx" {side} "integer ny" {side} "integer nz" {side} '
        '"point p0" [-2 -1 -2] "point p1" [2 3 2] "color sigma_s" [2 2 2] "color sigma_a" [.2 .2 .2]\n'
        '"float density" [\n' + "\n".join(lines) + "]\n")
    return f'Include "{file.name}"\n'


def texture_world(folder):
    size = 2048
    file = folder / "noise.tga"
    if not file.exists():
        head = struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, size, size, 24, 32)
        file.write_bytes(head + os.urandom(3 * size * size))
    return ('Texture "t" "color" "imagemap" "string filename" "noise.tga"\n'
            'MakeNamedMaterial "textured" "string type" "matte" "texture Kd" "t"\n')


def measured_world(folder):
    file = folder / "measured.binary"
    if not file.exists():
        count = 90 * 90 * 180
        file.write_bytes(struct.pack("<3i", 90, 90, 180) + 3 * count * struct.pack("<d", 100.))
    return 'MakeNamedMaterial "measured" "string type" "measured" "string filename" "measured.binary"\n'


def mesh_object(side):
    points = " ".join(f"{x} {(x * 7 + y * 3) % 5} {y}" for y in range(side) for x in range(side))
    faces = []
    for y in range(side - 1):
        for x in range(side - 1):
            i = y * side + x
            faces.append(f"{i} {i + 1} {i + side} {i + 1} {i + side + 1} {i + side}")
    return (f'ObjectBegin "o"\nShape "trianglemesh" "point P" [{points}] "integer indices" '
            f'[{" ".join(faces)}]\nObjectEnd\n')


def rules(folder):
    spots = "".join(f'LightSource "spot" "point from" [{i} 40 0] "point to" [{i} 99 0] "color I" [9 9 9]\n'
                    for i in range(64))
    def black(power):
        return f'LightSource "point" "point from" [0 4 -3] "color I" [{power} {power} {power}]\n' * 64
    def box(sigma, x0=-9.0, x1=9.0):
        return (f'Volume "homogeneous" "point p0" [{x0} -1 -4] "point p1" [{x1} 9 4] '
                f'"color sigma_s" [{sigma} {sigma} {sigma}]\n')
    single = 'SurfaceIntegrator "directlighting" VolumeIntegrator "single"'
    pvpm = ('GlobalIntegrator "pvpm" "integer passes" 8 "integer photonsperpass" 20000 '
            '"float radius" .1 "float surfaceradius" .1')
    photonmap = ('SurfaceIntegrator "photonmap" "bool finalgather" "false" '
                 '"integer causticphotons" 20000 "integer indirectphotons" 0')
    plain = ASIDE.format('Material "matte"')  # the same shapes on both sides: the same tree of them
    seen = SEEN.format('Material "matte"')
    # Above the view, it sends the lamp's light to the floor behind the camera.
    mirror = ('AttributeBegin Material "mirror" Translate 0 4 -3 Rotate -20 1 0 0 '
              'Shape "disk" "float radius" .3 AttributeEnd\n')
    textures, measured, mesh = texture_world(folder), measured_world(folder), mesh_object(300)
    result = [
        Rule("textures that no surface uses are not read (one image of 2048 x 2048)",
             scene(LAMP + textures + BALL + seen),
             scene(LAMP + textures + BALL + SEEN.format('NamedMaterial "textured"')),
             "texture: used by no surface", .5),
        Rule("textures that no ray meets are not read (one image of 2048 x 2048)",
             scene(LAMP + textures + BALL + ASIDE.format('NamedMaterial "textured"') + seen),
             scene(LAMP + textures + BALL + ASIDE.format('NamedMaterial "textured"') +
                   SEEN.format('NamedMaterial "textured"')),
             "skip  1 file of textures and materials: no ray met them", .5),
        Rule("materials that no surface uses are not built (one MERL table)",
             scene(LAMP + measured + BALL + seen),
             scene(LAMP + measured + BALL + SEEN.format('NamedMaterial "measured"')),
             "material: used by no surface"),
        Rule("materials that no ray meets are not built (one MERL table)",
             scene(LAMP + measured + BALL + ASIDE.format('NamedMaterial "measured"') + seen),
             scene(LAMP + measured + BALL + ASIDE.format('NamedMaterial "measured"') +
                   SEEN.format('NamedMaterial "measured"')),
             "skip  1 file of textures and materials: no ray met them"),
        Rule("objects that nothing instances are not built (180,000 triangles)",
             scene(LAMP + mesh + BALL),
             scene(LAMP + mesh + BALL + 'AttributeBegin Translate 0 0 -900 ObjectInstance "o" AttributeEnd\n'),
             "object: defined and never instanced"),
        Rule("rays carry no footprint where no texture looks at it",
             scene(LAMP + BALL + plain),
             scene(LAMP + BALL + 'Texture "u" "color" "uv"\n' +
                   ASIDE.format('Material "matte" "texture Kd" "u"')),
             "skip  ray footprints"),
        Rule("black lights are not sampled (64)", scene(LAMP + black("0") + BALL),
             scene(LAMP + black("1e-12") + BALL), "64 lights: emitting nothing"),
        Rule("lights that shine past all surfaces and media are not sampled (64 spots)",
             scene(LAMP + spots + BALL), scene(LAMP + spots + BALL + ABOVE),
             "64 lights: shining past all"),
        Rule("volumes that do nothing are not there", scene(LAMP + box("0") + BALL, single),
             scene(LAMP + box("1e-7") + BALL, single), "volume: neither absorbing"),
        Rule("pixels without medium ask no volume integrator: `single`, a tenth of the image in fog",
             scene(LAMP + box(".2", 1.6) + BALL, single),
             scene(LAMP + box(".2", 1.6) + box("1e-7", -9, 1.6) + BALL, single),
             "build media: 1 volume"),
        Rule("pixels without medium have no beam: `pvpm`, a tenth of the image in fog",
             scene(LAMP + box(".2", 1.6) + BALL, pvpm),
             scene(LAMP + box(".2", 1.6) + box("1e-7", -9, 1.6) + BALL, pvpm),
             "build media: 1 volume", .5),
        Rule("no specular surface, no caustic map: `photonmap`", scene(LAMP + BALL, photonmap),
             scene(LAMP + BALL + mirror, photonmap), "skip  caustic photon map", .5),
        Rule("no specular surface, no caustic photons: `pvpm`", scene(LAMP + BALL + plain + box(".2"), pvpm),
             scene(LAMP + BALL + ASIDE.format('Material "mirror"') + box(".2"), pvpm), "skip  caustic photons", .5),
        Rule("nothing diffuse, no visible points and no photons on surfaces: `pvpm`",
             scene(LAMP + box(".2"), pvpm),
             scene(LAMP + box(".2") + ASIDE.format('Material "matte"'), pvpm),
             "skip  visible points and photons on surfaces", .5),
        Rule("no scattering medium, no beams and no photons in media: `pvpm`",
             scene(LAMP + BALL, pvpm), scene(LAMP + BALL + box("1e-7"), pvpm),
             "skip  camera beams and photons in media", .5),
    ]
    # Through a small mirror in the view beams go everywhere: every photon may be seen.
    many = pvpm.replace("20000", "200000")
    def small(material):
        return (f'AttributeBegin Material "{material}" Translate 0 .7 -2 '
                'Shape "sphere" "float radius" .02 AttributeEnd\n')
    result.append(Rule("photons in media that no beam can receive are left out: `pvpm`, a view of 12 degrees",
                       scene(LAMP + box(".2") + small("matte"), many, 12),
                       scene(LAMP + box(".2") + small("mirror"), many, 12), "", .5))
    for method, integrator in (("single", single), ("volpath", 'GlobalIntegrator "volpath"')):
        for share in (.05, .2):
            name = f"empty space in a grid of 64^3 is stepped over: `{method}`, {share:.0%} of it occupied"
            result.append(Rule(name, scene(LAMP + grid(folder, 64, share, 0), integrator),
                               scene(LAMP + grid(folder, 64, share, 1e-7), integrator), "", .5))
    return result


def render(brume, text, folder):
    """Processor seconds of one run, and its plan and counters."""
    (folder / "scene.pbrt").write_text(text)
    command = [brume, "scene.pbrt", "--threads", "1", "--quiet", "-o", "image.exr", "--stats", "stats.json"]
    child = subprocess.Popen(list(map(str, command)), cwd=folder, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        sys.exit(f"brume ended with {child.returncode}")
    frame = json.loads((folder / "stats.json").read_text())["frames"][0]
    return usage.ru_utime + usage.ru_stime, frame


def measure(rule, brume, folder, runs, fail_above):
    best = [float("inf"), float("inf")]
    enough = max(1, round(runs * rule.runs))
    for run in range(10 * enough):
        if run >= enough and best[0] <= fail_above * best[1]:
            break
        for i, text in enumerate((rule.applies, rule.never)):
            seconds, frame = render(brume, text, folder)
            best[i] = min(best[i], seconds)
            if rule.plan and any(rule.plan in line for line in frame["plan"]) != (i == 0):
                sys.exit(f"{rule.name}: the plan {'lacks' if i == 0 else 'has'} \"{rule.plan}\"")
    return {"rule": rule.name, "with": best[0], "without": best[1]}


def markdown(rows):
    lines = ["| rule | without / with | processor seconds with | without |", "|---|---|---|---|"]
    for row in rows:
        lines.append(f"| {row['rule']} | **{row['without'] / row['with']:.2f}** | {row['with']:.3f} "
                     f"| {row['without']:.3f} |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=6, help="of each scene, half for the long ones")
    parser.add_argument("--json", type=pathlib.Path, help="where the figures go; with --filter the other rows stay")
    parser.add_argument("--filter", default=".", help="regular expression for rules")
    parser.add_argument("--fail-above", type=float, default=float("inf"), metavar="RATIO")
    parser.add_argument("--brume", type=pathlib.Path, help="the program; default: that of the build")
    arguments = parser.parse_args()
    brume = (arguments.brume or common.built("brume")).resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        rows = [measure(rule, brume, folder, arguments.runs, arguments.fail_above) for rule in rules(folder)
                if re.search(arguments.filter, rule.name)]
    if not rows:
        sys.exit("no rule has such a name")
    print("\n".join(markdown(rows)))
    if arguments.json:
        machine = common.machine()
        if arguments.filter != "." and arguments.json.exists():
            measured = {row["rule"] for row in rows}
            old = json.loads(arguments.json.read_text())["rows"]
            rows = [row for row in old if row["rule"] not in measured] + rows
        arguments.json.write_text(json.dumps({"machine": machine, "rows": rows}, indent=1) + "\n")
    slower = [r["rule"] for r in rows if r["with"] > arguments.fail_above * r["without"]]
    for rule in slower:
        print(f"slower with the rule: {rule}")
    sys.exit(1 if slower else 0)


if __name__ == "__main__":
    main()
