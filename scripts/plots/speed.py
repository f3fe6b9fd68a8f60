"""Pictures of run times: solvers, collision, soft bodies."""
import itertools

from plots.documents import all_points, columns, number, objects, read_series, word
from plots.sheet import (DARK, DASHDOT, DASHED, DOTTED, GREY, OTHER, OURS, along, dots, label_ends, make_logarithmic,
                         new_chart, place_labels)

AS_GOOD = 1.05      # times our error: as accurate
TICK_us = 1000
SOLVER_HEAD_PT, SOLVER_LINE_PT = 100, 22
PEER_STYLES = (DASHED, DOTTED, DASHDOT, "-", DASHED)
PEER_MARKS = "sD^vP"
STUDY = "study-"


def is_ours(name):
    return name.removeprefix(STUDY).startswith("omni")


def solver_title(rows):
    """Our warm solve beside the fastest peer's that is as accurate."""
    warm = [row for row in rows if word(row, "start") == "warm"]
    ours = next((row for row in warm if word(row, "method") == "omni" and word(row, "model") == "default"), None)
    peers = [number(row, "us_median") for row in warm
             if ours and not is_ours(word(row, "method")) and number(row, "rms_mm") <= AS_GOOD * number(ours, "rms_mm")]
    if not peers:
        return "Run time of a solve, by method (simulation)"
    return (f"Our warm solve takes {number(ours, 'us_median'):.2g} us, the fastest peer of that accuracy "
            f"{min(peers):.2g} us (simulation)")


def draw_solver(document):
    """One line per method and model: the times of its solves, warm and cold; right of it their error."""
    rows = [{**row, "line": f"{word(row, 'method')}, {word(row, 'model')}"} for row in objects(document["rows"])
            if word(row, "method")]
    lines = read_series(document, rows, "line", "us_median", "rms_mm")
    # The most accurate first, of these the fastest.
    order = sorted(lines, key=lambda line: (float(f"{min(mm for _, mm, _ in lines[line]):.2g}"),
                                            min(us for us, *_ in lines[line])))
    axes = new_chart(document, solver_title([row for *_, row in all_points(lines)]),
                     "● warm start, ○ cold start; a mark per variant; ours is blue", "median time of a solve, us", "",
                     SOLVER_HEAD_PT + SOLVER_LINE_PT * len(lines))
    make_logarithmic(axes, x=columns(all_points(lines))[0])
    axes.set_yticks(range(len(order)), order)
    axes.set_ylim(len(order) - 0.5, -0.5)
    axes.text(1.02, 1.02, "error, mm rms", color=GREY, va="bottom", transform=axes.transAxes)
    for place, line in enumerate(order):
        colour = OURS if is_ours(line) else DARK
        for us, _, row in lines[line]:
            dots(axes, [us], [place], colour, hollow=word(row, "start") == "cold")
        errors = list(dict.fromkeys(f"{mm:.2g}" for mm in sorted(mm for _, mm, _ in lines[line])))
        axes.text(1.02, place, " to ".join(errors[:1] + errors[1:][-1:]), color=colour, va="center",
                  transform=axes.get_yaxis_transform())
    return axes.figure


def draw_collision(document):
    """Time of a tick over the number of triangles, one line per engine; parts of ours are not drawn."""
    # One family of meshes: others do not lie on the same line.
    lumps = [row for row in objects(document["rows"])
             if word(row, "mesh") == "lump" and not word(row, "engine").startswith(STUDY)]
    engines = read_series(document, lumps, "engine", "triangles", "us_median")
    points = all_points(engines)
    few, many = (end(columns(points)[0]) for end in (min, max))
    first = next(iter(engines))
    us = [point[1] for point in sorted(engines[first], key=lambda point: point[0])]
    axes = new_chart(document,
                     f"{first} takes {us[0]:.2g} us on {few:,.0f} triangles and {us[-1]:.2g} us on {many:,.0f}",
                     "omni-proxy is the whole tick, the others are the query alone", "triangles", "median time, us",
                     320)
    peers = 0
    labels = []
    for engine, marks in engines.items():
        line = sorted(point[:2] for point in marks)
        style = {"color": OURS, "marker": "o", "linewidth": 2.5 if engine == first else 1.5}
        if not is_ours(engine):
            style = {"color": GREY, "linestyle": PEER_STYLES[peers % len(PEER_STYLES)],
                     "marker": PEER_MARKS[peers % len(PEER_MARKS)]}
            peers += 1
        axes.plot(*zip(*line), **style)
        labels.append((engine, line[-1][1], OURS if is_ours(engine) else DARK))
    make_logarithmic(axes, x=columns(points)[0], y=columns(points)[1])
    return label_ends(axes, labels)


def draw_deformable(document):
    """Time of a tick against error of the force, of rows both timed and judged; one line per method."""
    methods = read_series(document, objects(document["rows"]), "method", "us_median", "error_pct")
    points = all_points(methods)
    title = "Time of a tick against error of the force"
    if "omni" in methods:
        us, pct, _ = methods["omni"][0]
        title = f"A tick of omni takes {us:.2g} us and its force is off by {pct:.2g} % at most"
    axes = new_chart(document, title, "one ball; further left is faster, lower is more accurate; numbers: tetrahedra",
                     "median time of a tick, us", "error of the force against neo-Hookean, %", 320)
    make_logarithmic(axes, x=[*columns(points)[0], TICK_us], y=columns(points)[1])
    axes.axvline(TICK_us, color=OTHER, linestyle=DOTTED)
    axes.annotate("a tick of 1 kHz", (TICK_us, 0.03), (-5, 0), textcoords="offset points", color=OTHER, ha="right",
                  xycoords=axes.get_xaxis_transform())
    labels, taken, peers = [], list(points), 0
    for method, marks in methods.items():
        ours = is_ours(method)
        line = sorted(marks, key=lambda mark: number(mark[2], "tets") or 0)
        colour, marker = (OURS, "o") if ours else (DARK, PEER_MARKS[peers % len(PEER_MARKS)])
        peers += not ours
        axes.plot(*columns(line), color=colour, marker=marker, linewidth=1, linestyle="none" if ours else DASHED,
                  markerfacecolor="white" if method.startswith(STUDY) else colour)
        if not ours:
            taken += [point for one, other in itertools.pairwise(line) for point in along(one, other)]
        for place, (us, pct, row) in enumerate(line):
            tets = number(row, "tets")
            parts = [method.removeprefix(STUDY)] if ours or place == 0 else []
            parts += [f"{tets:,.0f}"] if tets is not None else []
            labels.append((", ".join(parts), us, pct, colour))
    return place_labels(axes, labels, taken)
