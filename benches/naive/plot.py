"""The figure: time against hard cases survived, one point for each variant, as an SVG that needs nothing else."""

WIDTH, HEIGHT = 720, 420
LEFT, RIGHT, TOP, BOTTOM = 70, 30, 50, 60


def ticks(low, high, step):
    first = int(-(-low // step))
    return [index * step for index in range(first, int(high // step) + 1)]


def step_for(span):
    for step in [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000]:
        if span / step <= 8:
            return step
    return 10000


def spread(wanted, gap):
    """Heights near the wanted ones, in the same order, at least `gap` apart."""
    placed = []
    for height in wanted:
        placed.append(max(height, placed[-1] + gap) if placed else height)
    return placed


def plot(figures):
    rows = figures["variants"]
    of = figures["of"]
    times = [row["time"] for row in rows.values()]
    cases = [row["survived"]["single"] for row in rows.values()]
    x_low, x_high = min(times) - 0.03, max(times) + 0.1
    y_low, y_high = min(cases) - 4, of + 1

    def x(time):
        return LEFT + (time - x_low) / (x_high - x_low) * (WIDTH - LEFT - RIGHT)

    def y(count):
        return TOP + (y_high - count) / (y_high - y_low) * (HEIGHT - TOP - BOTTOM)

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" '
           'font-size="12">', f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>',
           f'<text x="{LEFT}" y="24" font-size="15">What robustness costs, and what it buys (single precision)</text>']
    for tick in ticks(x_low, x_high, step_for(x_high - x_low)):
        out.append(f'<path d="M{x(tick):.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#ddd"/>')
        out.append(f'<text x="{x(tick):.1f}" y="{HEIGHT - BOTTOM + 18}" text-anchor="middle">{tick:.2f}</text>')
    for tick in ticks(y_low, y_high, step_for(y_high - y_low)):
        out.append(f'<path d="M{LEFT} {y(tick):.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>')
        out.append(f'<text x="{LEFT - 8}" y="{y(tick) + 4:.1f}" text-anchor="end">{tick:g}</text>')
    out.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2:.0f}" y="{HEIGHT - 16}" text-anchor="middle">'
               'time relative to naive code (geometric mean over the scenes)</text>')
    out.append(f'<text transform="translate(20 {(TOP + HEIGHT - BOTTOM) / 2:.0f}) rotate(-90)" text-anchor="middle">'
               f'hard cases survived of {of}</text>')

    by_height = sorted(rows.items(), key=lambda item: -item[1]["survived"]["single"])
    heights = spread([y(row["survived"]["single"]) for _, row in by_height], 15)
    for (name, row), height in zip(by_height, heights):
        at = x(row["time"]), y(row["survived"]["single"])
        color = {"robust": "#0a7", "naive": "#c33"}.get(name, "#36a")
        label = name.replace("robust - ", "without ")
        out.append(f'<path d="M{at[0]:.1f} {at[1]:.1f}L{at[0] + 14:.1f} {height:.1f}" stroke="#999"/>')
        out.append(f'<circle cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="4.5" fill="{color}"><title>{label}: {row["time"]} '
                   f'times naive, {row["survived"]["single"]} of {of}</title></circle>')
        out.append(f'<text x="{at[0] + 17:.1f}" y="{height + 4:.1f}">{label}</text>')
    out.append("</svg>")
    return "\n".join(out) + "\n"
