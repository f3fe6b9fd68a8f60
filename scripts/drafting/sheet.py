"""A sheet: lines, circles, arcs, curves and texts, in mm from its lower left corner, and the list of its dimensions."""
import math

from drafting.style import PAPER, SMALL, TEXT, number
from drafting.view import View


class Sheet:
    """scale: of a drawing that is also written as DXF, else None."""

    def __init__(self, facts, name, scale=None, paper=PAPER):
        self.facts, self.name, self.scale, self.paper = facts, name, scale, paper
        self.items, self.rows = [], []

    def title_block(self, title, sources):
        x, y, width = 183, 4, self.paper[0] - 4 - 183
        self.rect("edge", 4, 4, self.paper[0] - 8, self.paper[1] - 8)
        self.rect("edge", x, y, width, 24, "box")
        for up in (8, 16):
            self.line("thin", x, y + up, x + width, y + up)
        if self.scale:
            self.line("thin", x + 70, y + 16, x + 70, y + 24)
            self.text(x + 72, y + 18.4, f"{number(max(self.scale, 1))} : {number(max(1 / self.scale, 1))}, in mm", TEXT)
        self.text(x + 2, y + 18.4, title, TEXT, bold=True)
        self.text(x + 2, y + 10.5, "from " + sources, SMALL)
        self.text(x + 2, y + 2.5, "Omni: not built yet, simulated only. scripts/drawings", SMALL, colour="mark")

    def line(self, style, x0, y0, x1, y1):
        self.items.append(("line", style, x0, y0, x1, y1))

    def circle(self, style, x, y, r, fill=None):
        self.items.append(("circle", style, x, y, r, fill))

    def arc(self, style, x, y, r, start, end):
        """Counterclockwise, degrees."""
        self.items.append(("arc", style, x, y, r, start, end))

    def curve(self, style, points, fill=None, closed=False):
        """Through the points, smoothly; style None: filled only. Not in a DXF."""
        self.items.append(("curve", style, points, fill, closed))

    def polygon(self, style, points, fill=None):
        """Closed. Not in a DXF."""
        self.items.append(("polygon", style, points, fill))

    def swath(self, fill, width, x, y, r, start, end):
        """A broad arc, or with r = 0 a broad line from (x, y) to (start, end): the filled section of a wall. Not in a
        DXF."""
        self.items.append(("swath", fill, width, x, y, r, start, end))

    def rect(self, style, x, y, width, height, fill=None):
        if fill:
            self.swath(fill, height, x, y + height / 2, 0, x + width, y + height / 2)
        for a, b, c, d in ((0, 0, 1, 0), (1, 0, 1, 1), (1, 1, 0, 1), (0, 1, 0, 0)):
            self.line(style, x + a * width, y + b * height, x + c * width, y + d * height)

    def text(self, x, y, words, size=SMALL, anchor="start", colour="text", bold=False):
        if words:
            self.items.append(("text", colour, x, y, words, size, anchor, bold))

    def notes(self, x, y, *lines, step=5):
        """Texts below each other."""
        for i, words in enumerate(lines):
            self.text(x, y - step * i, words)

    def arrow(self, x, y, dx, dy):
        """A head at (x, y) that points along (dx, dy)."""
        long, wide = 2.2, 0.45
        scale = 1 / math.hypot(dx, dy)
        dx, dy = dx * scale, dy * scale
        self.items.append(("head", "size", x, y, x - long * dx - wide * dy, y - long * dy + wide * dx,
                           x - long * dx + wide * dy, y - long * dy - wide * dx))

    def table(self, x, y, columns, rows, step=4.5):
        """columns: (heading, width); y: the top."""
        for row, cells in enumerate([[heading for heading, _ in columns], *rows]):
            left, base = x, y - step * (row + 0.75)
            for cell, (_, width) in zip(cells, columns):
                self.text(left + width - 1, base, cell, SMALL, "end", bold=row == 0)
                left += width
            if row == 0:
                self.line("thin", x, y - step, left, y - step)

    def size(self, name, formula, unit="mm"):
        """Adds a dimension to the list; returns its value."""
        value = self.facts(formula) * {"mm": 1e3, "deg": 180 / math.pi, "": 1}[unit]
        self.rows.append((self.name, name, value, unit, formula))
        return value

    def view(self, x, y, scale=None):
        return View(self, x, y, scale or self.scale)
