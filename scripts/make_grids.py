#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the density grids of scenes/grids: a plume of smoke and a flame.

Each is one line of parameters for a volumegrid, to be included after its other parameters. The
fields are analytic with a few octaves of value noise from a hash, so that every machine writes the
same files: scripts/make_grids.py scenes/grids
"""
import math
import pathlib
import sys


def hashed(x, y, z):
    """A number in [0, 1) for each lattice point."""
    n = (x * 73856093 ^ y * 19349663 ^ z * 83492791) & 0xFFFFFFFF
    n = ((n ^ (n >> 13)) * 1274126177) & 0xFFFFFFFF
    n = ((n ^ (n >> 16)) * 2246822519) & 0xFFFFFFFF
    return ((n ^ (n >> 15)) & 0xFFFFFF) / 0x1000000


def noise(p):
    """Trilinear value noise with smooth weights, in [0, 1]."""
    base = [math.floor(c) for c in p]
    w = [(c - b) ** 2 * (3 - 2 * (c - b)) for c, b in zip(p, base)]
    total = 0.0
    for corner in range(8):
        bits = [(corner >> axis) & 1 for axis in range(3)]
        weight = math.prod(w[a] if bits[a] else 1 - w[a] for a in range(3))
        total += weight * hashed(*(b + bit for b, bit in zip(base, bits)))
    return total


def turbulence(p):
    """Four octaves, in [0, 1]."""
    total = sum(0.5**i * noise([c * 2**i + 17 * i for c in p]) for i in range(4))
    return total / 1.875


def smooth(lo, hi, x):
    t = min(1.0, max(0.0, (x - lo) / (hi - lo)))
    return t * t * (3 - 2 * t)


def smoke(x, y, z):
    """A plume that sways and widens on its way up; x, z in [-1, 1], y in [0, 1]."""
    x += 0.25 * math.sin(5 * y) * y + 0.5 * (noise([0.3, 3 * y, 0.7]) - 0.5)
    z += 0.25 * math.cos(4 * y) * y
    radius = 0.12 + 0.5 * y**0.8
    r = math.hypot(x, z) / radius
    curls = turbulence([3 * x + 9, 6 * y + 2, 3 * z + 5])
    density = smooth(1.0, 0.2, r + 1.6 * (curls - 0.5)) * smooth(0, 0.04, y) * smooth(1, 0.75, y)
    return density * (0.35 + 0.65 * (1 - y))


def flame(x, y, z):
    """A teardrop with licking edges."""
    x += 0.3 * y * (noise([0, 4 * y, 1]) - 0.5) + 0.10 * y * math.sin(7 * y)
    z += 0.3 * y * (noise([5, 4 * y, 2]) - 0.5)
    radius = 0.55 * math.sin(math.pi * min(1, y**0.6 + 0.06)) * (1 - 0.45 * y) + 0.02
    r = math.hypot(x, z) / radius
    licks = turbulence([4 * x + 3, 3 * y, 4 * z + 8])
    return smooth(1.0, 0.35, r + 0.9 * (licks - 0.5)) * smooth(0, 0.05, y) * smooth(1, 0.8, y)


def write(path, field, nx, ny, nz):
    lines = []
    for k in range(nz):
        for j in range(ny):
            row = []
            for i in range(nx):
                x, y, z = (2 * (i + 0.5) / nx - 1, (j + 0.5) / ny, 2 * (k + 0.5) / nz - 1)
                row.append(f"{field(x, y, z):.2f}".removeprefix("0").replace(".00", "0"))
            lines.append(" ".join(row))
    text = f'"integer nx" {nx} "integer ny" {ny} "integer nz" {nz}\n"float density" [\n'
    path.write_text("# Made by scripts/make_grids.py.\n" + text + "\n".join(lines) + "\n]\n")


def main():
    folder = pathlib.Path(sys.argv[1])
    write(folder / "smoke.pbrt", smoke, 28, 40, 28)
    write(folder / "flame.pbrt", flame, 24, 36, 24)


if __name__ == "__main__":
    main()
