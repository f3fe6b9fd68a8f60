"""What all pictures share: the sheet with its title and the origin of its data, axes, and labels beside what they name.

A picture is read at 400 to 800 pixels width, by colour-blind people and in grey print. So a title says what to see,
names stand beside lines and marks, ours is blue and strong, others differ by dashes and the marks' shapes.
"""
import itertools
import re
import textwrap

import matplotlib
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from matplotlib.transforms import Bbox

from plots.documents import word

# Colours that most eyes can distinguish [Okabe & Ito]; text in GREY is readable on white.
OURS, OTHER, DARK, GREY, PALE = "#0072b2", "#d55e00", "#222222", "#666666", "#a0a0a0"
DASHED, DOTTED, DASHDOT = (0, (5, 2)), (0, (1.2, 1.6)), (0, (6, 2, 1.2, 2))
WIDTH_PT, POINTS_PER_INCH = 450, 72  # 600 pixels wide
MARGIN_PT, TITLE_PT, NOTE_PT, LABEL_PT, FOOTER_PT, MARK_PT = 5, 10.5, 8.5, 8.5, 6.5, 5
SIDE_PT = 12             # of the axes: another font may be wider
LINE = 1.3               # from line to line, of the height of letters
LAYOUT_DIGITS = 5        # of places, as shares of a sheet
SHIFTS = 200             # of labels that overlap, at most
ALONG = 30               # points of a line that labels should not cover
LETTER = 0.6             # mean width of a letter, of its height
FEW_DECADES = 300        # an axis that spans less is marked at 2 and 5 as well
LOG_ROOM = 1.6           # around the values of a logarithmic axis
SHARED = {"svg.hashsalt": "omni", "svg.fonttype": "none", "text.parse_math": False, "font.size": 9, "axes.titlesize": 9,
          "axes.titlelocation": "left", "axes.grid": True, "axes.axisbelow": True, "axes.edgecolor": "#888888",
          "grid.color": "#e4e4e4", "lines.markersize": MARK_PT, "lines.linewidth": 1.5}

# Where a label may be, the nearest first: offset in points, then the label's alignment.
LABEL_PLACES = (((7, 0), "left", "center"), ((-7, 0), "right", "center"), ((0, 6), "center", "bottom"),
                ((0, -6), "center", "top"), ((5, 5), "left", "bottom"), ((5, -5), "left", "top"),
                ((-5, 5), "right", "bottom"), ((-5, -5), "right", "top"), ((0, 16), "center", "bottom"),
                ((0, -16), "center", "top"), ((16, 12), "left", "bottom"))


def use_settings():
    matplotlib.rcdefaults()  # no setting of this machine
    matplotlib.rcParams.update(SHARED)


def wrap(text, letters):
    """Lines of so many letters at most; a number stays with its unit."""
    return textwrap.wrap(re.sub(r"(?<=\d) (?=(us|ms|mm|N|N/m|A|°C|%)(\W|$))", "\u00a0", text), letters)


def wrap_sheet(text, letters_pt):
    return wrap(text, int((WIDTH_PT - 2 * MARGIN_PT) / (LETTER * letters_pt)))


def new_figure(document, title, note, height_pt):
    """A figure with its title and a note on top, and the origin of its data at the bottom."""
    figure = Figure(figsize=(WIDTH_PT / POINTS_PER_INCH, height_pt / POINTS_PER_INCH), dpi=POINTS_PER_INCH)
    left, top, bottom = MARGIN_PT / WIDTH_PT, MARGIN_PT, MARGIN_PT
    for text, letters_pt, colour in ((title, TITLE_PT, "black"), (note, NOTE_PT, GREY)):
        lines = wrap_sheet(text, letters_pt)
        figure.text(left, 1 - top / height_pt, "\n".join(lines), fontsize=letters_pt, color=colour, va="top")
        top += LINE * letters_pt * len(lines)
    command = word(document, "command") or "omni-bench " + word(document, "name")
    commit, machine = word(document, "commit") or "unknown", word(document, "machine") or "unknown machine"
    lines = wrap_sheet(f"{command}; commit {commit}; {machine}", FOOTER_PT)
    figure.text(left, MARGIN_PT / height_pt, "\n".join(lines), fontsize=FOOTER_PT, color=GREY, va="bottom")
    bottom += LINE * FOOTER_PT * len(lines) + MARGIN_PT
    left = SIDE_PT / WIDTH_PT
    free = (left, bottom / height_pt, 1 - 2 * left, 1 - (top + bottom + MARGIN_PT) / height_pt)
    figure.set_layout_engine(ConstrainedLayoutEngine(rect=free))
    return figure


def freeze_layout(figure):
    """Keeps the places that the layout's solver has found, but for its last digits, which differ from run to run."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for axes in figure.axes:
        axes.set_position([round(part, LAYOUT_DIGITS) for part in axes.get_position().bounds])


def new_chart(document, title, note, x_label, y_label, height_pt=300):
    axes = new_figure(document, title, note, height_pt).add_subplot()
    axes.set(xlabel=x_label, ylabel=y_label)
    return axes


def make_logarithmic(axes, **values):
    """Axes x=, y= logarithmic around these values, marked in plain numbers."""
    for direction, along in values.items():
        low, high = min(along) / LOG_ROOM, max(along) * LOG_ROOM
        axes.set(**{direction + "scale": "log", direction + "lim": (low, high)})
        axis = axes.xaxis if direction == "x" else axes.yaxis
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high / low < FEW_DECADES else (1,)))
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}" if value >= 1 else f"{value:g}"))


def dots(axes, x, y, colour, hollow=False, marker="o"):
    axes.plot(x, y, linestyle="none", marker=marker, color=colour, markerfacecolor="white" if hollow else colour)


def label_ends(axes, labels):
    """Writes (text, y, colour) right of the axes at the height of y, or as near to it as the other labels allow."""
    labels = sorted(labels, key=lambda label: label[1])
    texts = [axes.text(1.02, 0.5, text, color=colour, fontsize=LABEL_PT, va="center", transform=axes.transAxes)
             for text, _, colour in labels]
    axes.figure.draw_without_rendering()  # fixes the layout
    half = [text.get_window_extent().height / 2 + 1 for text in texts]
    at = [axes.transData.transform((axes.get_xlim()[1], y))[1] for _, y, _ in labels]
    for _ in range(SHIFTS):
        for lower, upper in itertools.pairwise(range(len(at))):
            overlap = max(0, half[lower] + half[upper] - (at[upper] - at[lower]))
            at[lower], at[upper] = at[lower] - overlap / 2, at[upper] + overlap / 2
        at = [min(max(y, axes.bbox.y0 + room), axes.bbox.y1 - room) for y, room in zip(at, half)]
    for text, y in zip(texts, at):
        text.set_y((y - axes.bbox.y0) / axes.bbox.height)
    return axes.figure


def place_labels(axes, labels, points, **style):
    """Writes (text, x, y, colour) beside their points, where each covers no point, no other label and no edge."""
    axes.figure.draw_without_rendering()  # fixes the layout
    taken = [marker_box(axes, *point[:2]) for point in points]
    for text, x, y, colour in labels:
        label = axes.annotate(text, (x, y), (0, 0), textcoords="offset points", fontsize=LABEL_PT, color=colour,
                              **style)
        label.set_in_layout(False)
        boxes = [label_box(label, *place) for place in LABEL_PLACES]
        best = next((i for i, box in enumerate(boxes) if is_free(axes, box, taken)), 0)
        taken.append(label_box(label, *LABEL_PLACES[best]))
    return axes.figure


def along(one, other):
    """Points on the line between two points of logarithmic axes, which labels should not cover."""
    shares = [i / ALONG for i in range(ALONG + 1)]
    return [[a ** (1 - share) * b ** share for a, b in zip(one[:2], other[:2])] for share in shares]


def marker_box(axes, x, y):
    x, y = axes.transData.transform((x, y))
    return Bbox.from_extents(x - MARK_PT, y - MARK_PT, x + MARK_PT, y + MARK_PT)


def label_box(label, offset, horizontal, vertical):
    label.set(position=offset, ha=horizontal, va=vertical)
    return label.get_window_extent()


def is_free(axes, box, taken):
    corners = all(axes.bbox.contains(*corner) for corner in (box.min, box.max))
    return corners and not any(box.overlaps(other) for other in taken)
