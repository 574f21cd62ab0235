"""Small charts side by side, as an SVG that needs nothing else; in the style of naive/plot.py, whose ticks these are."""

import math

from plot import step_for, ticks

WIDTH, HEIGHT = 440, 300
LEFT, RIGHT, TOP, BOTTOM = 60, 24, 40, 46
COLOR = "#36a"


def short(number):
    """A count as people write it: 820, 6.6 k, 4.8 M."""
    for unit, name in [(1e9, " G"), (1e6, " M"), (1e3, " k")]:
        if number >= unit:
            return f"{number / unit:.3g}{name}"
    return f"{number:g}"


class Axis:
    """From values to places, linear or logarithmic."""

    def __init__(self, values, start, end, log):
        low, high = min(values), max(values)
        self.log, self.start, self.end = log, start, end
        self.low, self.high = (math.log10(low), math.log10(high)) if log else (low, high * 1.05)

    def __call__(self, value):
        at = math.log10(value) if self.log else value
        return self.start + (at - self.low) / (self.high - self.low) * (self.end - self.start)

    def ticks(self):
        if not self.log:
            return ticks(self.low, self.high, step_for(self.high - self.low))
        decades = [10 ** exponent for exponent in range(math.ceil(self.low), math.floor(self.high) + 1)]
        # Within two decades one line each tells too little.
        steps = (1, 2, 5) if self.high - self.low < 2 else (1,)
        finer = [decade * step for decade in [decades[0] / 10, *decades] for step in steps] if decades else []
        return [tick for tick in finer if self.low - 1e-9 <= math.log10(tick) <= self.high + 1e-9]


class Panel:
    """One chart: its frame, and what is drawn into it."""

    def __init__(self, title, x_name, y_name, x_values, y_values, log_x=False, log_y=False):
        self.x = Axis(x_values, LEFT, WIDTH - RIGHT, log_x)
        self.y = Axis(y_values, HEIGHT - BOTTOM, TOP, log_y)
        self.title, self.names = title, (x_name, y_name)
        self.out = []

    def line(self, xs, ys, dashed=False):
        path = "L".join(f"{self.x(x):.1f} {self.y(y):.1f}" for x, y in zip(xs, ys))
        if dashed:
            self.out.append(f'<path d="M{path}" fill="none" stroke="#999" stroke-dasharray="5 4"/>')
            return
        self.out.append(f'<path d="M{path}" fill="none" stroke="{COLOR}" stroke-width="2"/>')
        for x, y in zip(xs, ys):
            self.out.append(f'<circle cx="{self.x(x):.1f}" cy="{self.y(y):.1f}" r="4" fill="{COLOR}"><title>'
                            f'{short(x)} {self.names[0]}: {y:g} {self.names[1]}</title></circle>')

    def bars(self, names, lengths):
        """Horizontal bars from the top, instead of a vertical axis."""
        self.y, left = None, LEFT + 120
        self.x.start = left
        gap = (HEIGHT - BOTTOM - TOP) / len(names)
        for i, (name, length) in enumerate(zip(names, lengths)):
            top = TOP + i * gap
            self.out.append(f'<rect x="{left}" y="{top + 3:.1f}" width="{self.x(length) - left:.1f}" '
                            f'height="{gap - 6:.1f}" fill="{COLOR}"/>')
            self.out.append(f'<text x="{left - 8}" y="{top + gap / 2 + 4:.1f}" text-anchor="end">{name}</text>')
            self.out.append(f'<text x="{self.x(length) - 5:.1f}" y="{top + gap / 2 + 4:.1f}" text-anchor="end" '
                            f'fill="#fff">{length:.2f}</text>')

    def svg(self):
        out = [f'<text x="12" y="24" font-size="14">{self.title}</text>']
        for tick in self.x.ticks():
            out.append(f'<path d="M{self.x(tick):.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#ddd"/>')
            out.append(f'<text x="{self.x(tick):.1f}" y="{HEIGHT - BOTTOM + 17}" text-anchor="middle">'
                       f'{short(tick)}</text>')
        for tick in self.y.ticks() if self.y else []:
            out.append(f'<path d="M{LEFT} {self.y(tick):.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>')
            out.append(f'<text x="{LEFT - 8}" y="{self.y(tick) + 4:.1f}" text-anchor="end">{tick:g}</text>')
        x_name, y_name = self.names
        out.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 10}" text-anchor="middle">{x_name}</text>')
        out.append(f'<text transform="translate(16 {(TOP + HEIGHT - BOTTOM) / 2}) rotate(-90)" text-anchor="middle">'
                   f'{y_name}</text>')
        return out + self.out


def drawing(title, panels):
    """Two panels in each row, below a title."""
    head = 34
    rows = -(-len(panels) // 2)
    width, height = 2 * WIDTH, head + rows * HEIGHT
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
           'font-size="12">', f'<rect width="{width}" height="{height}" fill="#fff"/>',
           f'<text x="12" y="24" font-size="16">{title}</text>']
    for i, panel in enumerate(panels):
        out += [f'<g transform="translate({i % 2 * WIDTH} {head + i // 2 * HEIGHT})">', *panel.svg(), "</g>"]
    return "\n".join([*out, "</svg>"]) + "\n"
