#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the files of scenes/data: grids of smoke and flame, a slide, the pattern of a lamp; and the
drifting smoke of scenes/report/data beside it.

A grid is the beginning of a Volume; the scene includes it and goes on with the other parameters. All
fields are analytic, with value noise from a hash, so that every machine writes the same files:
scripts/make_scene_data.py scenes/data
"""
import math
import pathlib
import struct
import sys
import zlib


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
    density = smooth(1.25, 0.25, r + 1.7 * (curls - 0.5)) * smooth(0, 0.04, y) * smooth(1, 0.75, y)
    return density * (0.35 + 0.65 * (1 - y))


def flame(x, y, z):
    """A teardrop with licking edges."""
    x += 0.3 * y * (noise([0, 4 * y, 1]) - 0.5) + 0.10 * y * math.sin(7 * y)
    z += 0.3 * y * (noise([5, 4 * y, 2]) - 0.5)
    radius = 0.55 * math.sin(math.pi * min(1, y**0.6 + 0.06)) * (1 - 0.45 * y) + 0.02
    r = math.hypot(x, z) / radius
    licks = turbulence([4 * x + 3, 3 * y, 4 * z + 8])
    return smooth(1.15, 0.05, r + 0.8 * (licks - 0.5)) * smooth(0, 0.05, y) * smooth(1, 0.8, y)


def drifts(x, y, z):
    """Smoke that fills a room in sheets and curls, denser below; x, z in [-1, 1], y in [0, 1]."""
    bend = [noise([2 * x + 3, 3 * y + k, 2 * z + 7 * k]) - 0.5 for k in (1, 2)]
    sheet = turbulence([1.6 * x + 2 * bend[0] + 4, 4 * y + bend[1] + 1, 1.6 * z + 2 * bend[1] + 6])
    return smooth(0.32, 0.72, sheet) * (1.1 - 0.6 * y)


def write_grid(path, field, nx, ny, nz):
    lines = []
    for k in range(nz):
        for j in range(ny):
            row = []
            for i in range(nx):
                x, y, z = (2 * (i + 0.5) / nx - 1, (j + 0.5) / ny, 2 * (k + 0.5) / nz - 1)
                row.append(f"{field(x, y, z):.2f}".removeprefix("0").replace(".00", "0"))
            lines.append(" ".join(row))
    text = f'Volume "volumegrid" "integer nx" {nx} "integer ny" {ny} "integer nz" {nz}\n"float density" [\n'
    path.write_text("# Made by scripts/make_scene_data.py.\n" + text + "\n".join(lines) + "\n]\n")


def window(x, y):
    """A window with coloured panes for the projector; x, y in [0, 1]."""
    pane = (min(2, int(3 * x)), min(2, int(3 * y)))
    u, v = 3 * x - pane[0], 3 * y - pane[1]
    if not (0.1 < u < 0.9 and 0.1 < v < 0.9):
        return (0, 0, 0)
    colours = [(1, 0.35, 0.2), (1, 0.85, 0.35), (0.35, 0.6, 1), (0.45, 1, 0.5)]
    return colours[(pane[0] + 2 * pane[1]) % 4]


def lamp(x, y):
    """The intensity of a slatted lamp by direction: x goes round the pole, y from pole to pole."""
    slats = 1 if (8 * x) % 1 < 0.5 else 0.15
    value = slats * math.sin(math.pi * y) ** 2
    return (value, value, value)


def write_png(path, colour, width, height):
    rows = b""
    for j in range(height):
        pixels = [colour((i + 0.5) / width, (j + 0.5) / height) for i in range(width)]
        rows += b"\0" + bytes(round(255 * c) for pixel in pixels for c in pixel)

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(rows, 9))
        + chunk(b"IEND", b"")
    )


def main():
    folder = pathlib.Path(sys.argv[1])
    write_grid(folder / "smoke.pbrt", smoke, 28, 40, 28)
    write_grid(folder / "flame.pbrt", flame, 24, 36, 24)
    write_grid(folder.parent / "report" / "data" / "drifts.pbrt", drifts, 26, 18, 26)
    write_png(folder / "window.png", window, 64, 64)
    write_png(folder / "lamp.png", lamp, 64, 32)


if __name__ == "__main__":
    main()
