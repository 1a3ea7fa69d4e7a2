"""Plots errors over time as an SVG file, with logarithmic axes."""

import math

WIDTH, HEIGHT = 460, 360  # of a panel
LEFT, RIGHT, TOP, BOTTOM = 76, 16, 40, 56  # margins of the axes in a panel
COLORS = ["#1f6fb4", "#d2691e", "#777777", "#2e8b57", "#8e44ad"]


class Axis:
    """Maps values to positions, logarithmically, with 12 % of the range free on both sides."""

    def __init__(self, values, begin, end):
        low, high = math.log10(min(values)), math.log10(max(values))
        margin = 0.12 * max(high - low, 0.5)
        self.low, self.high, self.begin, self.end = low - margin, high + margin, begin, end

    def at(self, value):
        return self.begin + (math.log10(value) - self.low) / (self.high - self.low) * (self.end - self.begin)

    def ticks(self):
        """Yields (value, whether it has a label): powers of ten, and their multiples if there are less than 2."""
        powers = range(math.floor(self.low), math.ceil(self.high) + 1)
        values = [(10.0**p * m, m) for p in powers for m in range(1, 10)]
        values = [(v, m) for v, m in values if self.low <= math.log10(v) <= self.high]
        labeled = {1} if sum(m == 1 for _, m in values) >= 2 else {1, 2, 5}
        for value, multiple in values:
            yield value, multiple in labeled


def text(x, y, content, anchor="middle", size=13, color="#222222", extra=""):
    return (f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" fill="{color}"{extra}>{content}'
            "</text>")


def label(value):
    """A decimal number, or a power of ten."""
    if 0.01 <= value < 1000:
        return f"{value:g}"
    exponent = math.floor(math.log10(value) + 1e-9)
    mantissa = value / 10.0**exponent
    sign = "\N{MINUS SIGN}" if exponent < 0 else ""
    power = f'10<tspan dy="-5" font-size="9">{sign}{abs(exponent)}</tspan>'
    return power if abs(mantissa - 1) < 0.01 else f"{mantissa:.0f} \N{MIDDLE DOT} {power}"


def grid(x, y, left):
    """Lines and labels of the axes of a panel that begins at `left`."""
    top, bottom = TOP, HEIGHT - BOTTOM
    parts = []
    for value, is_labeled in x.ticks():
        at, color = x.at(value), "#cccccc" if is_labeled else "#eeeeee"
        parts.append(f'<line x1="{at:.1f}" y1="{top}" x2="{at:.1f}" y2="{bottom}" stroke="{color}"/>')
        if is_labeled:
            parts.append(text(at, bottom + 18, label(value), size=12))
    for value, is_labeled in y.ticks():
        at, color = y.at(value), "#cccccc" if is_labeled else "#eeeeee"
        parts.append(f'<line x1="{left + LEFT}" y1="{at:.1f}" x2="{left + WIDTH - RIGHT}" y2="{at:.1f}" '
                     f'stroke="{color}"/>')
        if is_labeled:
            parts.append(text(left + LEFT - 6, at + 4, label(value), "end", 12))
    parts.append(f'<rect x="{left + LEFT}" y="{top}" width="{WIDTH - LEFT - RIGHT}" height="{bottom - top}" '
                 'fill="none" stroke="#666666"/>')
    return parts


def panel(title, curves, colors, left):
    """`curves`: {program: [(spp, seconds, error)]}."""
    points = [point for curve in curves.values() for point in curve if point[2] > 0]
    x = Axis([seconds for _, seconds, _ in points], left + LEFT, left + WIDTH - RIGHT)
    y = Axis([error for _, _, error in points], HEIGHT - BOTTOM, TOP)
    middle = left + (LEFT + WIDTH - RIGHT) / 2
    parts = [*grid(x, y, left), text(middle, TOP - 14, title, size=15),
             text(middle, HEIGHT - 14, "seconds of rendering"),
             text(left + 16, (TOP + HEIGHT - BOTTOM) / 2, "relative mean squared error",
                  extra=f' transform="rotate(-90 {left + 16} {(TOP + HEIGHT - BOTTOM) / 2:.1f})"')]
    for program, curve in curves.items():
        places = [(spp, x.at(seconds), y.at(error)) for spp, seconds, error in curve if error > 0]
        line = " ".join(f"{px:.1f},{py:.1f}" for _, px, py in places)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{colors[program]}" stroke-width="2"/>')
        for spp, px, py in places:
            parts.append(f'<circle cx="{px:.1f}" cy="{py:.1f}" r="4" fill="{colors[program]}"/>')
            if program == next(iter(curves)):
                parts.append(text(px - 7, py + 15, spp, "end", 11, colors[program]))
    return parts


def legend(names, colors, width):
    """Lines of names below the panels, and their number."""
    x, line, parts = LEFT, 0, []
    for name in names:
        length = 36 + 7.5 * len(name) + 26
        if x > LEFT and x + length > width:
            x, line = LEFT, line + 1
        y = HEIGHT + 12 + 20 * line
        parts.append(f'<line x1="{x}" y1="{y}" x2="{x + 28}" y2="{y}" stroke="{colors[name]}" stroke-width="3"/>')
        parts.append(text(x + 36, y + 4, name, "start"))
        x += length
    return parts, line + 1


def write_plot(path, curves):
    """`curves`: {scene: {program: [(spp, seconds, error)]}}, Sheaf first. Its points are labeled with their spp."""
    names = list(dict.fromkeys(name for of_scene in curves.values() for name in of_scene))
    colors = {name: COLORS[i % len(COLORS)] for i, name in enumerate(names)}
    width = WIDTH * len(curves)
    names_below, lines = legend(names, colors, width)
    height = HEIGHT + 12 + 20 * lines
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif">',
             "<title>Relative mean squared error over time of rendering</title>",
             f'<rect width="{width}" height="{height}" fill="#ffffff"/>']
    for i, (scene, of_scene) in enumerate(curves.items()):
        parts += panel(scene, of_scene, colors, i * WIDTH)
    path.write_text("\n".join([*parts, *names_below, "</svg>"]) + "\n", encoding="utf-8")
