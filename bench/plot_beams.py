#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the table of `brume_beams growth` (standard input) as an SVG (standard output).

Three panels: nanoseconds per photon against beams, photons and radius, log-log, each with the line
that docs/beam_quadtree.md fits: the pairs' share of the cost.
"""
import math
import sys

WIDTH, HEIGHT, LEFT, TOP, PANEL, PLOT_HEIGHT = 860, 300, 60, 40, 250, 200
NS_RANGE = (30, 20000)


def rows():
    for line in sys.stdin:
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if len(cells) == 9 and cells[0] in ("beams", "photons", "radius"):
            yield {"varied": cells[0], "beams": int(cells[1].split("^")[0]) ** 2,
                   "photons": float(cells[2]), "radius": float(cells[3]),
                   "pairs": float(cells[4]), "ns": float(cells[5])}


def scale(value, low, high, length):
    return length * (math.log(value) - math.log(low)) / (math.log(high) - math.log(low))


def y_of(ns):
    return TOP + PLOT_HEIGHT - scale(ns, *NS_RANGE, PLOT_HEIGHT)


def panel(index, name, unit, table):
    left = LEFT + index * (PANEL + 20)
    low, high = min(r[name] for r in table), max(r[name] for r in table)
    x_of = lambda v: left + 10 + scale(v, low, high, PANEL - 20)
    out = [f'<rect x="{left}" y="{TOP}" width="{PANEL}" height="{PLOT_HEIGHT}" fill="none" stroke="#888"/>',
           f'<text x="{left + PANEL / 2}" y="{TOP - 12}" text-anchor="middle">{name}{unit}</text>']
    for row in table:
        label = f"{row[name]:.0e}".replace("e+0", "e") if row[name] >= 1000 else f"{row[name]:g}"
        out.append(f'<text x="{x_of(row[name]):.1f}" y="{TOP + PLOT_HEIGHT + 16}" '
                   f'text-anchor="middle" font-size="10">{label}</text>')
    for key, colour in (("ns", "#c33"), ("pairs", "#36c")):
        points = [(x_of(r[name]), y_of(max(r[key] * (1 if key == "ns" else 5.8), NS_RANGE[0])))
                  for r in table]
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        out.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
        out += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.5" fill="{colour}"/>' for x, y in points]
    return out


def main():
    table = list(rows())
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
           f'font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>']
    for ns in (100, 1000, 10000):
        out.append(f'<text x="{LEFT - 6}" y="{y_of(ns) + 4:.1f}" text-anchor="end" '
                   f'font-size="10">{ns}</text>')
        out.append(f'<line x1="{LEFT}" x2="{LEFT + 3 * PANEL + 40}" y1="{y_of(ns):.1f}" '
                   f'y2="{y_of(ns):.1f}" stroke="#ddd"/>')
    panels = [("beams", "", "beams"), ("photons", "", "photons"), ("radius", ", pixels", "radius")]
    for index, (name, unit, varied) in enumerate(panels):
        out += panel(index, name, unit, [r for r in table if r["varied"] == varied])
    out += [f'<text x="{LEFT}" y="{HEIGHT - 12}"><tspan fill="#c33">measured, ns per photon</tspan>'
            f'<tspan dx="24" fill="#36c">5.8 ns times pairs per photon</tspan></text>', "</svg>"]
    print("\n".join(out))


if __name__ == "__main__":
    main()
