"""The paper's figures, from omni-bench paper."""
import math

from matplotlib.ticker import MultipleLocator

from plots.documents import Unusable, columns, finite, group, number, objects, table, word
from plots.sheet import (DARK, DASHDOT, DASHED, DOTTED, GREY, OTHER, OURS, dots, label_ends, make_logarithmic,
                         new_chart, new_figure, place_labels, wrap)

ERROR_MAX_mm, CURVE_STEPS, LABEL_LETTERS = 16, 100, 20
LIFT_LEAST_N = 0.05  # the colours' range is at least this
DECAYS = (("paper_law_N", "paper's law", {"color": OTHER, "linestyle": DASHED}),
          ("twin_radial_N", "twin, radial", {"color": OURS, "linewidth": 2}),
          ("twin_tangential_N", "twin, tangential", {"color": GREY}),
          ("ours_radial_N", "○ ours, radial",
           {"color": DARK, "linestyle": "none", "marker": "o", "markerfacecolor": "none"}))
FORCES = (("radial", "Radial, weight and snapping included", "I_z, A"), ("tangential", "Tangential", "I_x or I_y, A"))
FORCE_STYLES = ({"color": OURS, "linewidth": 2}, {"color": OTHER, "linestyle": DASHED},
                {"color": GREY, "linestyle": DOTTED}, {"color": DARK, "linestyle": DASHDOT})
MAGNET_MAPS = ((3, "The twin"), (2, "The paper's dipole law"))  # column of the sizes


def paper_table(document, name, *keys):
    """Rows of a side table that have the numbers `keys`, each preceded by them."""
    rows = [(finite(row, *keys), row) for row in table(document, name)]
    rows = [(*values, row) for values, row in rows if values]
    if not rows:
        raise Unusable(f'has no usable table "{name}"; make it again with omni-bench paper')
    return rows


def section_rows(document, section):
    return [row for row in objects(document["rows"]) if row.get("section") == section]


def quantities(document, section, name, *keys):
    """The numbers `keys` of the rows of a quantity, each followed by its row."""
    rows = [row for row in section_rows(document, section) if word(row, "quantity") == name]
    return [(*finite(row, *keys), row) for row in rows if finite(row, *keys)]


def draw_tracking(document):
    """One panel per condition: the paper's method on the twin as a distribution, the paper's mean and ours."""
    bins = paper_table(document, "tracking distribution", "from_mm", "to_mm", "share_pct")
    means = {word(row, "condition"): (paper_mm, ours_mm)
             for paper_mm, ours_mm, row in quantities(document, "tracking", "mean_mm", "paper", "ours")}
    conditions = group(bins, lambda row: word(row[-1], "condition"))
    known = [means[condition] for condition in conditions if condition in means]
    papers, ours = (" and ".join(f"{mean[place]:.2g}" for mean in known) for place in (0, 1))
    figure = new_figure(document, f"Mean error in the paper: {papers} mm; ours on the twin: {ours} mm (simulation)",
                        "After Fig. 6; grey: the paper's method on the twin", 120 + 140 * len(conditions))
    top = 1.35 * max(1, *(share for _, _, share, _ in bins))
    boxes = figure.subplots(len(conditions), 1, sharex=True, squeeze=False).flatten()
    for axes, (condition, rows) in zip(boxes, conditions.items()):
        low, high, share = columns(rows, 3)
        axes.bar(low, share, [to - start for start, to in zip(low, high)], align="edge", color="#d0d0d0",
                 edgecolor=GREY, linewidth=0.6)
        for place, name, colour, style in ((0, "paper's mean", OTHER, DASHED), (1, "our mean", OURS, "-")):
            if condition in means:
                mean_mm = means[condition][place]
                axes.axvline(mean_mm, color=colour, linestyle=style, linewidth=2)
                axes.annotate(f"{name} {mean_mm:.2g} mm", (mean_mm, top), (4, -4), textcoords="offset points",
                              color=colour, va="top")
        axes.set(title=condition, ylabel="poses per 0.5 mm, %", xlim=(0, ERROR_MAX_mm), ylim=(0, top))
    boxes[-1].set_xlabel("distance to the truth, mm")
    return figure


def draw_forces(document):
    """One panel per direction: force against current, the paper's numbers as marks, models as lines."""
    points = paper_table(document, "force lines", "current_A", "force_N")
    fits = quantities(document, "forces", "rms deviation from the text, %", "twin_fitted", "twin_41mm")
    title = "Force on the magnet on top of the sphere (simulation)"
    if fits:
        title = (f"The twin is {fits[0][0]:.0f} % off the paper's forces with fitted geometry, {fits[0][1]:.0f} % with "
                 "contact at 41 mm (simulation)")
    figure = new_figure(document, title,
                        "After Fig. 8: the magnet on top of the sphere; marks: numbers in the paper's text", 520)
    for axes, (direction, panel, x_label) in zip(figure.subplots(len(FORCES), 1), FORCES):
        series = group((point for point in points if point[2].get("direction") == direction),
                       lambda point: (point[2].get("of_text") is True, word(point[2], "series")))
        labels, models, texts = [], 0, 0
        for (of_text, name), marks in series.items():
            if of_text:
                dots(axes, *columns(marks), DARK, hollow=texts > 0, marker="oDs^"[texts % 4])
                texts += 1
            else:
                line, style = sorted(mark[:2] for mark in marks), FORCE_STYLES[models % len(FORCE_STYLES)]
                axes.plot(*zip(*line), **style)
                labels.append(("\n".join(wrap(name, LABEL_LETTERS)), line[-1][1], style["color"]))
                models += 1
        axes.set(title=panel, xlabel=x_label, ylabel="force, N")
        label_ends(axes, labels)
    return figure


def draw_decay(document):
    rows = paper_table(document, "decay curve", "gap_mm", *(key for key, *_ in DECAYS))
    text = list(filter(None, (finite(row, "gap_mm", "paper_N") for row in section_rows(document, "decay"))))
    far = max(section_rows(document, "decay"), key=lambda row: number(row, "gap_mm") or 0)
    title = "Force against gap, 2 N at contact (simulation)"
    if finite(far, "gap_mm", "paper_N", "twin_radial_N", "twin_tangential_N"):
        title = (f"Of 2 N at contact {far['paper_N']:.2g} N are left at {far['gap_mm']:g} mm in the paper, in the "
                 f"simulation {far['twin_tangential_N']:.2g} N (tangential) and {far['twin_radial_N']:.2g} N (radial)")
    axes = new_chart(document, title, "◆ numbers in the paper's text; twin and ours: simulation", "gap, mm", "force, N")
    for column, (key, _, style) in enumerate(DECAYS, 1):
        axes.plot([row[0] for row in rows], [row[column] for row in rows], **style)
    dots(axes, *columns(text), DARK, marker="D")
    make_logarithmic(axes, y=[value for row in rows for value in row[1:-1] if value > 0] or [1])
    last = max(rows, key=lambda row: row[0])
    return label_ends(axes, [(name, last[column], style["color"])
                             for column, (_, name, style) in enumerate(DECAYS, 1)])


def draw_heat(document):
    """One panel per run: the body and the copper of coil y, with the text's numbers."""
    points = paper_table(document, "heat curves", "time_s", "body_C", "copper_C")
    text = group(paper_table(document, "heat in the text", "time_s", "body_C"), lambda point: word(point[-1], "run"))
    runs = group(points, lambda point: word(point[-1], "run"))
    figure = new_figure(document, f"The base gets up to {max(point[1] for point in points):.0f} °C outside, its copper "
                        f"inside {max(point[2] for point in points):.0f} °C (simulation)",
                        "After Fig. 9: current in coil y alone; ● numbers in the paper's text", 80 + 180 * len(runs))
    for axes, (run, curve) in zip(figure.subplots(len(runs), 1, squeeze=False).flatten(), runs.items()):
        time_s, body_C, copper_C = columns(curve, 3)
        axes.plot(time_s, copper_C, color=OTHER, linestyle=DASHED)
        axes.plot(time_s, body_C, color=OURS, linewidth=2)
        dots(axes, *columns(text.get(run, ())), DARK)
        axes.set(title=run, xlabel="time, s", ylabel="temperature, °C")
        label_ends(axes, [("copper", copper_C[-1], OTHER), ("body", body_C[-1], OURS)])
    return figure


def draw_magnets(document):
    sizes = paper_table(document, "magnet sizes", "radius_mm", "height_mm", "paper_law_N", "twin_N")
    magnet = paper_table(document, "magnet of the paper", "radius_mm", "height_mm")[0][:2]
    best = {column: max(sizes, key=lambda size: size[column]) for column, _ in MAGNET_MAPS}
    paper_N = min(sizes, key=lambda size: math.dist(size[:2], magnet))[3]
    figure = new_figure(document, f"On the twin the paper's magnet is lifted by {paper_N:.2g} N, the best size by "
                        f"{best[3][3]:.2g} N (simulation)", "After Fig. 5: net lift at 5 A by the magnet's size; "
                        "white: not lifted; dashed: of the volume of the paper's magnet", 300)
    for axes, (column, title) in zip(figure.subplots(1, 2, sharey=True), MAGNET_MAPS):
        draw_map(figure, axes, [(size[0], size[1], size[column]) for size in sizes])
        draw_map_marks(axes, columns(sizes)[0], magnet, best[column][:2])
        axes.set(title=title, xlabel="magnet radius, mm")
        if column == MAGNET_MAPS[0][0]:
            axes.set_ylabel("magnet height, mm")
    return figure


def draw_map(figure, axes, cells):
    """The brighter, the more lift; sizes that are not lifted are white."""
    radii, heights = (sorted(set(values)) for values in columns(cells))
    lift_N = {(radius, height): force for radius, height, force in cells if force > 0}
    grid = [[lift_N.get((radius, height), float("nan")) for radius in radii] for height in heights]
    mesh = axes.pcolormesh(radii, heights, grid, cmap="cividis", vmin=0, vmax=max([LIFT_LEAST_N, *lift_N.values()]),
                           shading="nearest", edgecolors="face", linewidth=0.5)
    axes.grid(False)
    figure.colorbar(mesh, ax=axes, label="net lift, N", location="bottom")


def draw_map_marks(axes, radii, magnet, best):
    """The paper's magnet, other sizes of its volume, and the size that is lifted best."""
    limits = axes.axis()
    curve = [min(radii) + (max(radii) - min(radii)) * i / CURVE_STEPS for i in range(CURVE_STEPS + 1)]
    axes.plot(curve, [magnet[0] ** 2 * magnet[1] / radius ** 2 for radius in curve], color="white", linestyle=DASHED)
    for (radius, height), marker in ((magnet, "o"), (best, "D")):
        axes.plot(radius, height, linestyle="none", marker=marker, markersize=6, color="black", markeredgecolor="white")
    axes.axis(limits)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MultipleLocator(5))
    place_labels(axes, [("paper's magnet", *magnet, "black"), ("best", *best, "black")], [magnet, best],
                 bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1})
