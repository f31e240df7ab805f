#!/usr/bin/env python3
"""Writes voxmap-pointshell.svg, the README's picture of the method, to standard output.

A plane section: the lower body is a voxmap whose free voxels store their distance to the surface; the upper body is a
pointshell, one point in each voxel of its own grid that its outline passes, with normals into the body. Needs nothing
but Python 3:  docs/images/voxmap_pointshell.py > docs/images/voxmap-pointshell.svg
"""

import math

CELL, COLUMNS, ROWS, RANGE = 26, 31, 12, 3
FORCE_LAYER = 1
MAP = [(-5, -5), (COLUMNS + 5, -5), (COLUMNS + 5, 2.3), (25.4, 2.3), (22.6, 5.6), (19.4, 5.6),
       (16.6, 1.6), (8.7, 1.6), (7.3, 4.4), (-5, 4.4)]
SHELL = [(-3.6, -1.9), (3.1, -1.9), (3.9, -1.1), (3.9, 2.2), (-3.6, 2.2)]
PLACE, TURN = (12.75, 6.2), math.radians(-15)


def inside(polygon, x, y):
    result = False
    for (x0, y0), (x1, y1) in zip(polygon, polygon[1:] + polygon[:1]):
        if (y0 > y) != (y1 > y) and x < x0 + (y - y0) * (x1 - x0) / (y1 - y0):
            result = not result
    return result


def clipped(x0, y0, x1, y1, left, low):
    """The part of a segment in the cell at (left, low), as two parameters, or None."""
    enter, leave = 0.0, 1.0
    for start, step, least in ((x0, x1 - x0, left), (y0, y1 - y0, low)):
        if step == 0:
            if not least <= start < least + 1:
                return None
            continue
        a, b = sorted(((least - start) / step, (least + 1 - start) / step))
        enter, leave = max(enter, a), min(leave, b)
    return (enter, leave) if enter < leave else None


def cells(polygon, columns, rows):
    """The cells that the outline passes, each with the mean of its normals to the left, into the body."""
    found = {}
    for (x0, y0), (x1, y1) in zip(polygon, polygon[1:] + polygon[:1]):
        length = math.hypot(x1 - x0, y1 - y0)
        for i in columns:
            for j in rows:
                part = clipped(x0, y0, x1, y1, i, j)
                if part:
                    share = (part[1] - part[0]) * length
                    nx, ny = found.get((i, j), (0, 0))
                    found[i, j] = (nx - share * (y1 - y0) / length, ny + share * (x1 - x0) / length)
    return found


def onto(polygon, x, y):
    """The nearest point of the outline."""
    def along(a, b):
        (x0, y0), (x1, y1) = a, b
        t = ((x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)) / ((x1 - x0) ** 2 + (y1 - y0) ** 2)
        t = max(0, min(1, t))
        return x0 + t * (x1 - x0), y0 + t * (y1 - y0)
    places = [along(a, b) for a, b in zip(polygon, polygon[1:] + polygon[:1])]
    return min(places, key=lambda place: math.hypot(place[0] - x, place[1] - y))


def moved(x, y):
    c, s = math.cos(TURN), math.sin(TURN)
    return PLACE[0] + c * x - s * y, PLACE[1] + s * x + c * y


def main():
    top = ROWS * CELL
    out = []

    def pixel(x, y):
        return f"{x * CELL:.1f}", f"{top - y * CELL:.1f}"

    def arrow(x, y, dx, dy, kind):
        (x0, y0), (x1, y1) = pixel(x, y), pixel(x + dx, y + dy)
        out.append(f'<line x1="{x0}" y1="{y0}" x2="{x1}" y2="{y1}" class="{kind}" marker-end="url(#{kind})"/>')

    surface = set(cells(MAP, range(-4, COLUMNS + 4), range(-4, ROWS)))
    distance = {}
    for i in range(COLUMNS):
        for j in range(ROWS):
            if (i, j) in surface:
                distance[i, j] = 0
            elif inside(MAP, i + 0.5, j + 0.5):
                distance[i, j] = -1
            else:
                distance[i, j] = min(max(abs(i - a), abs(j - b)) for a, b in surface)
    fills = {-1: "#6d7680", 0: "#a9b2bb", 1: "#f6c177", 2: "#cfe3f5", 3: "#e6f1fa"}
    for (i, j), d in sorted(distance.items()):
        if d > RANGE:
            continue
        x, y = i * CELL, top - (j + 1) * CELL
        out.append(f'<rect x="{x}" y="{y}" width="{CELL}" height="{CELL}" fill="{fills[d]}" class="cell"/>')
        if d >= 0:
            out.append(f'<text x="{x + CELL - 3}" y="{y + CELL - 4}" class="d">{d}</text>')
    out.append(f'<polygon points="{" ".join(",".join(pixel(x, y)) for x, y in MAP)}" class="map"/>')
    out.append(f'<polygon points="{" ".join(",".join(pixel(*moved(x, y))) for x, y in SHELL)}" class="shell"/>')

    c, s = math.cos(TURN), math.sin(TURN)
    for (i, j), (nx, ny) in sorted(cells(SHELL, range(-5, 6), range(-4, 4)).items()):
        length = math.hypot(nx, ny)
        x, y = moved(*onto(SHELL, i + 0.5, j + 0.5))
        nx, ny = (c * nx - s * ny) / length, (s * nx + c * ny) / length
        touches = distance.get((math.floor(x), math.floor(y)), 99) <= FORCE_LAYER
        if touches:
            arrow(x, y, 1.7 * nx, 1.7 * ny, "force")
        else:
            arrow(x, y, 0.75 * nx, 0.75 * ny, "normal")
        px, py = pixel(x, y)
        out.append(f'<circle cx="{px}" cy="{py}" r="{5 if touches else 3.6}" class="{"hit" if touches else "point"}"/>')

    legend = [
        (f'<rect width="18" height="18" fill="{fills[-1]}" class="cell"/>', "inside"),
        (f'<rect width="18" height="18" fill="{fills[0]}" class="cell"/>', "surface voxel, distance 0"),
        (f'<rect width="18" height="18" fill="{fills[1]}" class="cell"/>', "force layer, here distance 1"),
        (f'<rect width="18" height="18" fill="{fills[2]}" class="cell"/>', "free, farther away"),
        ('<circle cx="9" cy="9" r="3.6" class="point"/>', "shell point and normal"),
        ('<circle cx="9" cy="9" r="5" class="hit"/>', "point in contact, force"),
    ]
    for k, (sign, text) in enumerate(legend):
        x, y = 14 + (k // 2) * 270, top + 16 + (k % 2) * 28
        out.append(f'<g transform="translate({x},{y})">{sign}<text x="26" y="14" class="legend">{text}</text></g>')
    x, y = pixel(17.6, 10.2)
    out.append(f'<text x="{x}" y="{y}" class="name">moving body: pointshell</text>')
    x, y = pixel(1.2, 0.3)
    out.append(f'<text x="{x}" y="{y}" class="name light">static body: voxmap</text>')

    width, height = COLUMNS * CELL, top + 78
    print(f'''<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img"
 aria-label="Section through a voxmap with distance layers and a pointshell with normals">
<defs>
<marker id="normal" viewBox="0 0 6 6" refX="5" refY="3" markerWidth="5" markerHeight="5" orient="auto"><path d="M0 0L6 3L0 6z" fill="#20528c"/></marker>
<marker id="force" viewBox="0 0 6 6" refX="5" refY="3" markerWidth="4" markerHeight="4" orient="auto"><path d="M0 0L6 3L0 6z" fill="#c62828"/></marker>
</defs>
<style>
.cell {{ stroke: #fff; stroke-width: 1 }} .d {{ font: 9px sans-serif; fill: #44505c; text-anchor: end }}
.map {{ fill: none; stroke: #1f262d; stroke-width: 2 }} .shell {{ fill: #8ab4e0; fill-opacity: .35; stroke: #20528c; stroke-width: 2 }}
.normal {{ stroke: #20528c; stroke-width: 1.6 }} .force {{ stroke: #c62828; stroke-width: 2.6 }}
.point {{ fill: #20528c }} .hit {{ fill: #c62828 }}
.legend {{ font: 15px sans-serif; fill: #1f262d }} .name {{ font: bold 16px sans-serif; fill: #20528c }} .light {{ fill: #fff }}
</style>
<rect width="{width}" height="{height}" fill="#fff"/>''')
    print("\n".join(out))
    print("</svg>")


if __name__ == "__main__":
    main()
