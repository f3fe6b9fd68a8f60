"""Writes a sheet as SVG."""
import html
import math

from drafting.style import FILL, STYLES, number as X


def write(sheet):
    width, height = sheet.paper
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{4 * width}" '
           f'height="{4 * height}" font-family="DejaVu Sans, Verdana, sans-serif" fill="none">',
           f"<title>{html.escape(sheet.name)}</title>", "<style>"]
    for name, (colour, thick, dashes, _, _) in STYLES.items():
        dash = f";stroke-dasharray:{dashes}" if dashes else ""
        out.append(f".{name}{{stroke:{colour};stroke-width:{thick}{dash}}} text.{name}{{stroke:none;fill:{colour}}} "
                   f"path.head{{fill:{STYLES['size'][0]};stroke:none}}")
    out += ["</style>", f'<rect width="{width}" height="{height}" fill="#ffffff"/>']
    out += [ELEMENTS[kind](lambda y: X(height - y), *rest) for kind, *rest in sheet.items]
    return "\n".join(out + ["</svg>", ""])


# Elements: Y writes a height above the sheet's lower edge.

def filled(fill):
    return f' fill="{FILL.get(fill, fill)}"' if fill else ""


def line(Y, style, x0, y0, x1, y1):
    return f'<path class="{style}" d="M{X(x0)} {Y(y0)}L{X(x1)} {Y(y1)}"/>'


def circle(Y, style, x, y, r, fill):
    return f'<circle class="{style}" cx="{X(x)}" cy="{Y(y)}" r="{X(r)}"{filled(fill)}/>'


def arc_path(Y, x, y, r, start, end):
    at = lambda degrees: (x + r * math.cos(math.radians(degrees)), y + r * math.sin(math.radians(degrees)))
    (x0, y0), (x1, y1) = at(start), at(end)
    return f"M{X(x0)} {Y(y0)}A{X(r)} {X(r)} 0 {int((end - start) % 360 > 180)} 0 {X(x1)} {Y(y1)}"


def arc(Y, style, *shape):
    return f'<path class="{style}" d="{arc_path(Y, *shape)}"/>'


def curve(Y, style, points, fill, closed):
    """Cubic pieces whose slope in a point is that of the line between its two neighbours [Catmull & Rom]."""
    count = len(points)
    at = (lambda i: points[i % count]) if closed else (lambda i: points[max(0, min(count - 1, i))])
    path = f"M{X(points[0][0])} {Y(points[0][1])}"
    for i in range(count if closed else count - 1):
        (px, py), (ax, ay), (bx, by), (nx, ny) = (at(i + step) for step in (-1, 0, 1, 2))
        path += (f"C{X(ax + (bx - px) / 6)} {Y(ay + (by - py) / 6)} {X(bx - (nx - ax) / 6)} {Y(by - (ny - ay) / 6)} "
                 f"{X(bx)} {Y(by)}")
    stroke = f' class="{style}" stroke-linecap="round" stroke-linejoin="round"' if style else ""
    return f'<path{stroke} d="{path}{"z" if closed else ""}"{filled(fill)}/>'


def polygon(Y, style, points, fill):
    path = "L".join(f"{X(x)} {Y(y)}" for x, y in points)
    return f'<path class="{style}" d="M{path}z" stroke-linejoin="round"{filled(fill)}/>'


def head(Y, _, x, y, a, b, c, d):
    return f'<path class="head" d="M{X(x)} {Y(y)}L{X(a)} {Y(b)} {X(c)} {Y(d)}z"/>'


def swath(Y, fill, width, x, y, r, start, end):
    colour = FILL.get(fill, fill)
    if r and end - start >= 360:
        return f'<circle cx="{X(x)}" cy="{Y(y)}" r="{X(r)}" stroke="{colour}" stroke-width="{X(width)}"/>'
    path = arc_path(Y, x, y, r, start, end) if r else f"M{X(x)} {Y(y)}L{X(start)} {Y(end)}"
    return f'<path d="{path}" stroke="{colour}" stroke-width="{X(width)}"/>'


def text(Y, style, x, y, words, size, anchor, bold):
    weight = ' font-weight="bold"' if bold else ""
    return (f'<text class="{style}" x="{X(x)}" y="{Y(y)}" font-size="{size}" text-anchor="{anchor}"{weight}>'
            f"{html.escape(words)}</text>")


ELEMENTS = {element.__name__: element for element in (line, circle, arc, curve, polygon, head, swath, text)}
