"""A view of a part on a sheet, with dimensions that must be those of their formulas."""
import math

from drafting.style import SMALL, TEXT, label


def pair(one_or_two):
    return one_or_two if isinstance(one_or_two, tuple) else (one_or_two, one_or_two)


class View:
    """A view of the part, in mm of the part; (x, y): where its origin lies on the sheet."""

    def __init__(self, sheet, x, y, scale):
        self.sheet, self.x, self.y, self.scale = sheet, x, y, scale

    def at(self, x, y):
        return self.x + self.scale * x, self.y + self.scale * y

    def line(self, style, x0, y0, x1, y1):
        self.sheet.line(style, *self.at(x0, y0), *self.at(x1, y1))

    def circle(self, style, x, y, r, fill=None):
        self.sheet.circle(style, *self.at(x, y), self.scale * r, fill)

    def arc(self, style, x, y, r, start, end):
        self.sheet.arc(style, *self.at(x, y), self.scale * r, start, end)

    def curve(self, style, points, fill=None, closed=False):
        self.sheet.curve(style, [self.at(*point) for point in points], fill, closed)

    def polygon(self, style, points, fill=None):
        self.sheet.polygon(style, [self.at(*point) for point in points], fill)

    def wall(self, x, y, outer, thickness, start, end, style="edge", fill="wall"):
        """The section of a shell."""
        self.sheet.swath(fill, self.scale * thickness, *self.at(x, y), self.scale * (outer - thickness / 2), start, end)
        for r in (outer, outer - thickness):
            self.arc(style, x, y, r, start, end)

    def block(self, x0, y0, x1, y1, fill="wall", style="edge"):
        left, low = self.at(min(x0, x1), min(y0, y1))
        self.sheet.rect(style, left, low, self.scale * abs(x1 - x0), self.scale * abs(y1 - y0), fill)

    def cross(self, x, y, r):
        self.line("centre", x - r, y, x + r, y)
        self.line("centre", x, y - r, x, y + r)

    # Dimensions. The drawn distance must be that of the formula.
    def distance(self, name, formula, drawn):
        value = self.sheet.size(name, formula)
        if abs(value - abs(drawn)) > 1e-6:
            raise ValueError(f"{self.sheet.name}: {name} is {value:g} mm, but drawn as {abs(drawn):g} mm")
        return value

    def span(self, a, b, begins, at, place):
        """The lines of a dimension from a to b, on the sheet; `begins`: where its two extension lines do;
        place(along, off): x and y."""
        s, inside = self.sheet, b - a > 6
        for along, begin in zip((a, b), begins):
            if abs(begin - at) > 1:
                way = math.copysign(1, at - begin)
                s.line("size", *place(along, begin + 0.8 * way), *place(along, at + way))
        s.line("size", *place(a - (0 if inside else 4), at), *place(b + (0 if inside else 4), at))
        s.arrow(*place(a, at), *place(-1 if inside else 1, 0))
        s.arrow(*place(b, at), *place(1 if inside else -1, 0))

    def across(self, name, formula, x0, x1, y, at, prefix="", suffix="", beside=0, above=1.0):
        """Horizontal; at: the dimension line's height on the sheet; y: where its extension lines begin (one for both or
        two). beside: the text stands right (> 0) or left (< 0) of the arrows, by so much."""
        words = prefix + label(self.distance(name, formula, x1 - x0)) + suffix
        a, b = sorted(self.at(x, 0)[0] for x in (x0, x1))
        self.span(a, b, [self.at(0, begin)[1] for begin in pair(y)], at, lambda along, off: (along, off))
        if beside > 0:
            self.sheet.text(b + beside, at - 1.2, words, TEXT, "start", "size")
        elif beside < 0:
            self.sheet.text(a + beside, at - 1.2, words, TEXT, "end", "size")
        else:
            self.sheet.text((a + b) / 2, at + above, words, TEXT, "middle", "size")

    def upright(self, name, formula, y0, y1, x, at, prefix="", suffix="", right=True, shift=0):
        """Vertical; at: the dimension line's place across the sheet."""
        words = prefix + label(self.distance(name, formula, y1 - y0)) + suffix
        a, b = sorted(self.at(0, y)[1] for y in (y0, y1))
        self.span(a, b, [self.at(begin, 0)[0] for begin in pair(x)], at, lambda along, off: (off, along))
        self.sheet.text(at + (1.2 if right else -1.2), (a + b) / 2 - 1.2 + shift, words, TEXT,
                        "start" if right else "end", "size")

    def leader(self, name, formula, tip, to, prefix="", suffix="", unit="mm"):
        """An arrow to the point `tip` of the part from the text at `to` on the sheet."""
        self.point(tip, to, prefix + label(self.sheet.size(name, formula, unit)) + suffix, TEXT, "size")

    def point(self, tip, to, words, size=SMALL, colour="text"):
        """A text with an arrow, without a number of its own."""
        x, y = self.at(*tip)
        s, left = self.sheet, to[0] < x
        end = to[0] + (1 if left else -1)
        s.line("size", x, y, *(end, to[1] + 1.1))
        s.arrow(x, y, x - end, y - to[1] - 1.1)
        s.text(*to, words, size, "end" if left else "start", colour)
