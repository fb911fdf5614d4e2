#!/usr/bin/python3
"""Draws the pictures of README and docs from the data of a report (`tactbench report ... --format json`), as SVG.
Arguments: `array` or `loops`, the report's JSON, the SVG to write. The same data give the same bytes."""

import json
import sys

INK, GREY, LOADING, UNLOADING = "#1a1a1a", "#666666", "#00669f", "#b84300"
COLOURS = ((0.0, (68, 1, 84)), (0.25, (59, 82, 139)), (0.5, (33, 145, 140)), (0.75, (94, 201, 98)), (1.0, (253, 231, 37)))
SHADES = 40
LEVEL_PSI = 20


def colour(share):
    share = min(1.0, max(0.0, share))
    for (low, first), (high, second) in zip(COLOURS, COLOURS[1:]):
        if share <= high:
            part = (share - low) / (high - low)
            return "#%02x%02x%02x" % tuple(round(a + part * (b - a)) for a, b in zip(first, second))
    raise AssertionError(share)


def text(x, y, words, size=12, anchor="start", fill=INK, weight="normal"):
    return (f'<text x="{x:g}" y="{y:g}" font-size="{size}" text-anchor="{anchor}" fill="{fill}" '
            f'font-weight="{weight}">{words}</text>')


def array_map(x, y, side, values, columns, low, high):
    """All taxels as squares; taxels of one shade are one path."""
    size = side / columns
    paths = {}
    for i, value in enumerate(values):
        shade = min(SHADES - 1, max(0, int((value - low) / (high - low) * SHADES)))
        paths.setdefault(shade, []).append(f"M{i % columns} {i // columns}h1v1h-1z")
    drawn = "".join(f'<path fill="{colour((shade + 0.5) / SHADES)}" d="{"".join(paths[shade])}"/>' for shade in sorted(paths))
    return (f'<g transform="translate({x:g} {y:g}) scale({size:g})" shape-rendering="crispEdges">{drawn}</g>'
            f'<rect x="{x:g}" y="{y:g}" width="{side:g}" height="{side:g}" fill="none" stroke="{GREY}"/>')


def scale(x, y, height, low, high, unit):
    """What the colours mean."""
    each = height / SHADES
    bars = "".join(f'<rect x="{x:g}" y="{y + height - (i + 1) * each:.2f}" width="10" height="{each + 0.3:.2f}" '
                   f'fill="{colour((i + 0.5) / SHADES)}"/>' for i in range(SHADES))
    return bars + text(x + 14, y + 10, f"{high:g} {unit}", 11) + text(x + 14, y + height, f"{low:g} {unit}", 11)


class Plot:
    """A chart's axes: where a value lies on the paper."""

    def __init__(self, x, y, width, height, most_x, most_y):
        self.x, self.y, self.width, self.height, self.most_x, self.most_y = x, y, width, height, most_x, most_y

    def at(self, value_x, value_y):
        return self.x + self.width * value_x / self.most_x, self.y + self.height * (1 - value_y / self.most_y)

    def axes(self, ticks_x, ticks_y, label_x, label_y):
        out = [f'<path fill="none" stroke="{INK}" d="M{self.x:g} {self.y:g}v{self.height:g}h{self.width:g}"/>']
        for tick in ticks_x:
            x, y = self.at(tick, 0)
            out.append(f'<path stroke="#dddddd" d="M{x:.1f} {self.y:g}V{y:.1f}"/>' + text(x, y + 15, tick, 11, "middle"))
        for tick in ticks_y:
            x, y = self.at(0, tick)
            out.append(f'<path stroke="#dddddd" d="M{x:.1f} {y:.1f}h{self.width:g}"/>' + text(x - 6, y + 4, tick, 11, "end"))
        out.append(text(self.x + self.width / 2, self.y + self.height + 30, label_x, 11, "middle"))
        middle = self.y + self.height / 2
        out.append(f'<g transform="translate({self.x - 30:g} {middle:g}) rotate(-90)">{text(0, 0, label_y, 11, "middle")}</g>')
        return "".join(out)

    def line(self, xs, ys, stroke, dashes=""):
        points = " ".join("%.1f,%.1f" % self.at(a, b) for a, b in zip(xs, ys))
        dash = f' stroke-dasharray="{dashes}"' if dashes else ""
        return f'<polyline fill="none" stroke="{stroke}" stroke-width="1.8"{dash} points="{points}"/>'

    def dots(self, xs, ys, fill):
        return "".join('<circle cx="%.1f" cy="%.1f" r="1.7" fill="%s"/>' % (*self.at(a, b), fill) for a, b in zip(xs, ys))


def page(width, height, title, parts):
    return (f'<svg xmlns="http://www.w3.org/2000/svg" role="img" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
            f'font-family="DejaVu Sans, Liberation Sans, Arial, sans-serif"><title>{title}</title>'
            f'<rect width="{width}" height="{height}" fill="#ffffff"/>' + "\n".join(parts) + "</svg>\n")


def draw_array(report):
    """Left the array under an even pressure, loading and unloading; right the loop of one taxel; below, after compensation."""
    frames, columns = report["results"]["frames"], report["results"]["model"]["columns"]
    frame = next(each for each in frames if each["pressure_psi"] == LEVEL_PSI)
    loop = next(each for each in report["sections"]["raw"]["loops"] if each["name"] == "median")
    taxel, side = loop["taxel"], 150
    most_v = 4.0
    psi = [each["pressure_psi"] for each in frames]
    parts = [text(20, 24, f"Simulated sensor, {len(frame['raw_up_v'])} taxels, all at {LEVEL_PSI} psi: all should read the same",
                  14, weight="bold")]
    for row, (name, keys, most, unit) in enumerate((
            ("before compensation", ("raw_up_v", "raw_down_v"), most_v, "V"),
            ("after compensation", ("comp_up_psi", "comp_down_psi"), 2 * LEVEL_PSI, "psi"))):
        top = 72 + row * 232
        parts.append(text(20, top - 24, name, 13, weight="bold"))
        for i, (key, words) in enumerate(zip(keys, ("loading", "unloading"))):
            parts.append(text(20 + i * (side + 20), top - 6, words, 11, fill=(LOADING, UNLOADING)[i]))
            parts.append(array_map(20 + i * (side + 20), top, side, frame[key], columns, 0, most))
        parts.append(scale(30 + 2 * (side + 20) - 18, top, side, 0, most, unit))
        plot = Plot(475, top, 265, side, 60, 4 if unit == "V" else 60)
        parts.append(text(475, top - 6, f"one taxel (row {taxel // columns}, column {taxel % columns})", 11))
        parts.append(plot.axes((0, 20, 40, 60), (0, 1, 2, 3, 4) if unit == "V" else (0, 20, 40, 60), "pressure in psi",
                               "output in V" if unit == "V" else "reading in psi"))
        for key, stroke, dashes in zip(keys, (LOADING, UNLOADING), ("", "6 3")):
            parts.append(plot.line(psi, [each[key][taxel] for each in frames], stroke, dashes))
    return page(760, 496, f"A simulated tactile array at {LEVEL_PSI} psi and the loop of one taxel, before and after compensation", parts)


def draw_loops(report):
    """The mean taxel along the descending sequence: the external loop, inner branches, and the curves of ELAM."""
    trace = next(each for each in report["results"]["traces"] if each["sequence"] == "descending")
    plot = Plot(55, 40, 600, 290, 60, 4)
    psi, output, model = trace["pressure_psi"], trace["measured_v"], trace["model_v"]
    parts = [text(55, 24, "Simulated sensor, mean taxel: one pressure, several outputs", 14, weight="bold"),
             plot.axes(range(0, 61, 10), range(0, 5), "pressure in psi", "output in V")]
    parts.append(plot.line(psi, model, GREY))
    for rising, fill in ((True, LOADING), (False, UNLOADING)):
        chosen = [i for i in range(1, len(psi)) if (psi[i] > psi[i - 1]) == rising]
        parts.append(plot.dots([psi[i] for i in chosen], [output[i] for i in chosen], fill))
    for i, (words, fill) in enumerate((("output while loading", LOADING), ("output while unloading", UNLOADING), ("ELAM", GREY))):
        parts.append(f'<circle cx="430" cy="{250 + 18 * i}" r="3.5" fill="{fill}"/>' + text(440, 254 + 18 * i, words, 11))
    return page(680, 375, "Loops of the mean taxel of a simulated array, measured and by ELAM", parts)


def main():
    kind, source, target = sys.argv[1:]
    with open(source) as file:
        report = json.load(file)
    assert report["identification"]["simulated"], "these pictures say that the data are simulated"
    with open(target, "w") as file:
        file.write({"array": draw_array, "loops": draw_loops}[kind](report))


if __name__ == "__main__":
    main()
