#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes scenes/report/data/statue.pbrt: a robed figure on a plinth, as a coarse closed mesh that Loop
subdivision refines when the scene is read.

The surface is that of a smooth union of spheres and round cones, made into quads by naive surface
nets: one vertex for each cell of a grid that the surface crosses, one quad for each edge. Units: the
figure is 1 high, stands on y = 0, looks along -z. Usage: scripts/make_statue.py > FILE
"""
import math

CELLS = 36          # per unit of height; main() checks that the mesh is closed
BLEND = 0.04        # width of the smooth union
LEVELS = 3          # of subdivision


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def round_cone(p, a, b, ra, rb):
    """Distance to a segment whose radius goes from ra to rb: about a round cone."""
    pa, ba = sub(p, a), sub(b, a)
    h = max(0.0, min(1.0, dot(pa, ba) / dot(ba, ba)))
    d = (pa[0] - ba[0] * h, pa[1] - ba[1] * h, pa[2] - ba[2] * h)
    return math.sqrt(dot(d, d)) - (ra + (rb - ra) * h)


def smooth_min(a, b):
    h = max(0.0, min(1.0, 0.5 + 0.5 * (b - a) / BLEND))
    return b + (a - b) * h - BLEND * h * (1 - h)


# from, to, radius there
PARTS = [
    ((0, 0.08, 0), (0, 0.45, 0.01), 0.155, 0.095),        # robe
    ((0, 0.45, 0.01), (0, 0.66, 0), 0.09, 0.11),          # chest
    ((-0.09, 0.71, 0), (0.09, 0.71, 0), 0.05, 0.05),      # shoulders
    ((0, 0.72, 0), (0, 0.82, -0.01), 0.04, 0.035),        # neck
    ((0, 0.865, -0.015), (0, 0.905, -0.01), 0.062, 0.066),  # head
    ((0, 0.80, 0.04), (0, 0.9, 0.035), 0.045, 0.06),      # hair
    ((0.13, 0.70, 0), (0.2, 0.53, -0.03), 0.042, 0.036),  # left arm
    ((0.2, 0.53, -0.03), (0.11, 0.44, -0.15), 0.036, 0.028),
    ((-0.13, 0.70, 0), (-0.24, 0.80, -0.06), 0.042, 0.034),  # right arm, raised
    ((-0.24, 0.80, -0.06), (-0.21, 0.97, -0.1), 0.032, 0.026),
    ((-0.21, 1.0, -0.1), (-0.21, 1.03, -0.1), 0.034, 0.03),  # what the hand holds
    ((0, 0.04, 0), (0, 0.02, 0), 0.2, 0.215),             # plinth
]


def field(p):
    d = 1e9
    for a, b, ra, rb in PARTS:
        d = smooth_min(d, round_cone(p, a, b, ra, rb))
    # Folds of the robe.
    if 0.1 < p[1] < 0.5:
        fade = math.sin(math.pi * (p[1] - 0.1) / 0.4)
        d += 0.008 * fade * math.cos(9 * math.atan2(p[2], p[0]) + 6 * p[1])
    return d


def surface_net(lo, hi, n):
    """Vertices and quads; n cells along each axis."""
    step = [(hi[k] - lo[k]) / n[k] for k in range(3)]
    at = lambda i, j, k: (lo[0] + i * step[0], lo[1] + j * step[1], lo[2] + k * step[2])
    value = {(i, j, k): field(at(i, j, k))
             for i in range(n[0] + 1) for j in range(n[1] + 1) for k in range(n[2] + 1)}
    corners = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    edges = [(a, b) for a in corners for b in corners
             if a < b and sum(abs(x - y) for x, y in zip(a, b)) == 1]
    vertices, index, quads = [], {}, []

    def vertex(cell):
        if cell not in index:
            crossings = []
            for a, b in edges:
                pa = tuple(c + o for c, o in zip(cell, a))
                pb = tuple(c + o for c, o in zip(cell, b))
                va, vb = value[pa], value[pb]
                if (va < 0) != (vb < 0):
                    t = va / (va - vb)
                    crossings.append([x + (y - x) * t for x, y in zip(at(*pa), at(*pb))])
            index[cell] = len(vertices)
            vertices.append([sum(c[k] for c in crossings) / len(crossings) for k in range(3)])
        return index[cell]

    # An edge of the grid that the surface crosses is shared by four cells: one quad.
    for (i, j, k), v in sorted(value.items()):
        for axis in range(3):
            end = [i, j, k]
            end[axis] += 1
            w = value.get(tuple(end))
            if w is None or (v < 0) == (w < 0):
                continue
            u1, u2 = [(axis + 1) % 3, (axis + 2) % 3]
            around = []
            for d1, d2 in ((0, 0), (1, 0), (1, 1), (0, 1)):
                cell = [i, j, k]
                cell[u1] -= d1
                cell[u2] -= d2
                around.append(vertex(tuple(cell)))
            quads.append(around if v < 0 else around[::-1])
    return vertices, quads


def main():
    lo, hi = (-0.32, -0.22, -0.28), (0.32, 1.1, 0.28)
    cells = [round((h - l) * CELLS) for l, h in zip(lo, hi)]
    vertices, quads = surface_net(lo, hi, cells)
    triangles = []
    for a, b, c, d in quads:
        triangles += [(a, b, c), (a, c, d)]
    sides = [(t[i], t[(i + 1) % 3]) for t in triangles for i in range(3)]
    distinct = set(sides)
    if len(distinct) != len(sides) or any((b, a) not in distinct for a, b in sides):
        raise SystemExit("not a closed mesh: choose another CELLS")
    print("# Made by scripts/make_statue.py: %d triangles, %d after subdivision." %
          (len(triangles), len(triangles) * 4 ** LEVELS))
    print('Shape "loopsubdiv" "integer nlevels" [%d]' % LEVELS)
    print('"integer indices" [')
    for i in range(0, len(triangles), 8):
        print(" ".join("%d %d %d" % t for t in triangles[i:i + 8]))
    print(']\n"point P" [')
    for i in range(0, len(vertices), 6):
        print(" ".join("%.4g %.4g %.4g" % tuple(v) for v in vertices[i:i + 6]))
    print("]")


main()
