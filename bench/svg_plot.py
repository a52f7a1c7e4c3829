# SPDX-License-Identifier: Apache-2.0
"""Log-log plots as SVG text, for the documentation: panels in a grid under one legend."""
import math
from html import escape

COLOURS = ["#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#17becf", "#8c564b", "#e377c2"]
WIDTH, PANEL_HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 330, 250, 52, 10, 26, 36


def short(value):
    """A number in three digits; powers of ten where zeros would fill it."""
    if value and not 1e-3 <= abs(value) < 1e5:
        return f"{value:.2g}".replace("e-0", "e-").replace("e+0", "e")
    return f"{value:.3g}"


class _Axis:
    """Positions of values between two ends in logarithms, with a margin."""

    def __init__(self, values, begin, end):
        low, high = min(values), max(values)
        self.low, self.high, self.begin, self.end = low / 1.2, high * 1.2, begin, end

    def at(self, value):
        share = math.log(value / self.low) / math.log(self.high / self.low)
        return self.begin + share * (self.end - self.begin)

    def ticks(self):
        digits = [1] if self.high / self.low > 300 else [1, 2, 5] if self.high / self.low < 30 else [1, 3]
        decades = range(math.floor(math.log10(self.low)), math.ceil(math.log10(self.high)) + 1)
        all_ticks = [digit * 10.0 ** e for e in decades for digit in digits]
        return [t for t in all_ticks if self.low <= t <= self.high]


def _text(x, y, content, **attributes):
    extra = "".join(f' {name.replace("_", "-")}="{value}"' for name, value in attributes.items())
    return f'<text x="{x:.1f}" y="{y:.1f}"{extra}>{escape(content)}</text>'


def _panel(title, curves, colour_of, x_name, y_name, left, top):
    """curves: {name: [(x, y), ...]}; points that are not positive have no logarithm and are left out."""
    curves = {n: [p for p in c if p[0] > 0 and p[1] > 0] for n, c in curves.items()}
    curves = {n: c for n, c in curves.items() if c}
    x0, x1 = left + LEFT, left + WIDTH - RIGHT
    y0, y1 = top + PANEL_HEIGHT - BOTTOM, top + TOP
    out = [f'<rect x="{x0}" y="{y1}" width="{x1 - x0}" height="{y0 - y1}" fill="none" stroke="#888"/>',
           _text((x0 + x1) / 2, y1 - 8, title, text_anchor="middle", font_weight="bold")]
    if not curves:
        return out + [_text((x0 + x1) / 2, (y0 + y1) / 2, "nothing measured", text_anchor="middle")]
    x = _Axis([p[0] for c in curves.values() for p in c], x0, x1)
    y = _Axis([p[1] for c in curves.values() for p in c], y0, y1)
    for t in x.ticks():
        out += [f'<path d="M{x.at(t):.1f} {y0}V{y1}" stroke="#e4e4e4"/>',
                _text(x.at(t), y0 + 14, short(t), text_anchor="middle")]
    for t in y.ticks():
        out += [f'<path d="M{x0} {y.at(t):.1f}H{x1}" stroke="#e4e4e4"/>',
                _text(x0 - 5, y.at(t) + 4, short(t), text_anchor="end")]
    middle = (y0 + y1) / 2
    out += [_text((x0 + x1) / 2, y0 + 29, x_name, text_anchor="middle"),
            _text(left + 11, middle, y_name, text_anchor="middle",
                  transform=f"rotate(-90 {left + 11} {middle:.1f})")]
    for name, curve in curves.items():
        path = "L".join(f"{x.at(p[0]):.1f} {y.at(p[1]):.1f}" for p in curve)
        out.append(f'<path d="M{path}" fill="none" stroke="{colour_of[name]}" stroke-width="1.8"/>')
        out += [f'<circle cx="{x.at(p[0]):.1f}" cy="{y.at(p[1]):.1f}" r="2.2" fill="{colour_of[name]}"/>'
                for p in curve]
    return out


def grid_of_plots(panels, x_name, y_name, columns=3):
    """panels: [(title, {name: [(x, y), ...]}), ...]; the same name has the same colour in all."""
    names = list(dict.fromkeys(name for _, curves in panels for name in curves))
    colour_of = {name: COLOURS[i % len(COLOURS)] for i, name in enumerate(names)}
    columns = min(columns, len(panels))
    width = max(columns * WIDTH, 160 * len(names) + LEFT)
    height = -(-len(panels) // columns) * PANEL_HEIGHT + 30
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
           f'font-family="sans-serif" font-size="11">',
           f'<rect width="{width}" height="{height}" fill="white"/>']
    for i, (title, curves) in enumerate(panels):
        out += _panel(title, curves, colour_of, x_name, y_name,
                      i % columns * WIDTH, i // columns * PANEL_HEIGHT)
    at = LEFT
    for name in names:
        out += [f'<path d="M{at} {height - 16}h22" stroke="{colour_of[name]}" stroke-width="3"/>',
                _text(at + 28, height - 12, name, font_size="12")]
        at += 160
    return "\n".join(out + ["</svg>"]) + "\n"
