"""Pictures of the pen: where it is, where an application sees it, the base in a headset's space, walls."""
from matplotlib.ticker import LogLocator

from plots.documents import (Unusable, all_points, columns, finite, group, kind_of, number, objects, positive,
                             read_series, table, word)
from plots.sheet import (DARK, DASHED, GREY, OTHER, OURS, PALE, along, dots, make_logarithmic, new_chart, new_figure,
                         place_labels)

TRACKING_HEAD_PT, TRACKING_PANEL_PT, TRACKING_LINE_PT = 80, 24, 16
NOISES = {"none": "no noise", "UHP": "low noise", "LP": "low power"}
GEOMETRIES = {"self": "own calibration", "exact": "exact geometry", "none": "nominal geometry"}
TRACKING_MARKS = (("mean_mm", "o", False), ("p95_mm", "o", True), ("max_mm", "D", False))
REST_ms = 0.8  # of the loop's lag: half a tick and the coil
ROOM_BELOW = 0.35  # for a name under the lowest line
OFFERED, RULE = "offered_N_m", "start_N_m"
ALIGN_MARKS = {"touch": "o", "sweep": "s", "fingertip": "^"}


def conditions_of(row):
    """What holds for a row of omni-bench tracking, in words."""
    amplitude_A = number(row, "actuation_A") or 0
    hidden = amplitude_A and word(row, "currents") == "hidden"
    parts = ("pen moving" if row.get("moving") is True else "pen at rest",
             NOISES.get(word(row, "noise"), word(row, "noise")), f"{word(row, 'model')} model",
             GEOMETRIES.get(word(row, "calibrated"), ""), "in a room" if row.get("room") is True else "",
             f"±{amplitude_A:g} A{' hidden' if hidden else ''}" if amplitude_A else "0 A")
    return [part for part in parts if part]


def tracking_title(rows):
    """The product in use: it has calibrated itself, in a room, the pen moves under current."""
    for row in rows:
        if word(row, "model") == "default" and word(row, "calibrated") == "self" and row.get("room") is True \
                and row.get("moving") is True and positive(row, "actuation_A"):
            return (f"In a room, moving and under current, the tracked pen is {number(row, 'mean_mm'):.2g} mm off on "
                    "average (simulation)")
    return "Position error of the tracker by condition (simulation)"


def draw_tracking(document):
    """A panel for what is common, in it one line per row: mean, 95 % and worst error."""
    rows = [row for row in objects(document["rows"]) if positive(row, "mean_mm", "p95_mm")]
    if not rows:
        raise Unusable("no row has mean_mm, p95_mm; make it with omni-bench tracking")
    panels = group(rows, lambda row: (row.get("moving") is not True, word(row, "noise") == "none"))
    panels = [panels[key] for key in sorted(panels)]
    figure = new_figure(document, tracking_title(rows), "● mean, ○ 95 %, ◆ worst; the product's model is blue; "
                        "low noise, low power: settings of the sensors",
                        TRACKING_HEAD_PT + TRACKING_PANEL_PT * len(panels) + TRACKING_LINE_PT * len(rows))
    boxes = figure.subplots(len(panels), 1, sharex=True, squeeze=False,
                            height_ratios=[len(panel) for panel in panels]).flatten()
    make_logarithmic(boxes[0], x=[number(row, key) for row in rows for key, *_ in TRACKING_MARKS if positive(row, key)])
    for axes, panel in zip(boxes, panels):
        conditions = [conditions_of(row) for row in panel]
        common = [part for part in conditions[0] if all(part in parts for parts in conditions)]
        names = [", ".join(part for part in parts if part not in common) for parts in conditions]
        axes.set_title(", ".join(common), loc="right")
        axes.set_yticks(range(len(panel)), names)
        axes.set_ylim(len(panel) - 0.5, -0.5)
        for place, row in enumerate(panel):
            colour = OURS if word(row, "model").startswith("default") else GREY
            marks = [(number(row, key), marker, hollow) for key, marker, hollow in TRACKING_MARKS
                     if positive(row, key)]
            axes.plot([value for value, *_ in marks], [place] * len(marks), color=PALE, linewidth=1)
            for value, marker, hollow in marks:
                dots(axes, [value], [place], colour, hollow, marker)
    boxes[-1].set_xlabel("position error, mm")
    return figure


def is_predicted(point):
    return word(point[2], "method") == "layer"


def draw_layer(document):
    """One panel per kind of motion: error of a pose over the prediction time, predicted and held."""
    rows = [row for row in table(document, "motions") if word(row, "method")]
    motions = read_series(document, rows, "motion", "horizon_ms", "error_mm_p95")
    kinds = group(all_points(motions), lambda point: kind_of(word(point[2], "motion")))
    longest = max(point[0] for point in all_points(motions))
    # The kind that a held pose is furthest from.
    hardest = max(kinds, key=lambda kind: max(point[1] for point in kinds[kind]))
    ends = {ours: max((point[1] for point in kinds[hardest] if is_predicted(point) is ours), default=0)
            for ours in (True, False)}
    figure = new_figure(document, f"{longest:g} ms ahead, 95 % of predicted poses are within {ends[True]:.1f} mm, "
                        f"of held ones within {ends[False]:.1f} mm ({hardest}; simulation)",
                        "95 % of the errors; solid: predicted, dashed: newest pose held", 250)
    boxes = figure.subplots(1, len(kinds), sharex=True, sharey=True, squeeze=False).flatten()
    make_logarithmic(boxes[0], y=columns(all_points(motions))[1])
    for axes, (kind, points) in zip(boxes, kinds.items()):
        for (_, ours), marks in group(points, lambda point: (word(point[2], "motion"), is_predicted(point))).items():
            axes.plot(*zip(*sorted(mark[:2] for mark in marks)), color=OURS if ours else GREY,
                      marker="o" if ours else "s", linestyle="-" if ours else DASHED)
        axes.set(title=kind, xlabel="horizon, ms", xlim=(0, longest * 1.1))
    boxes[0].set_ylabel("position error, mm")
    return figure


def draw_align(document):
    """The true error over the error predicted by omni align: medians filled, 95 % hollow."""
    rows = [{**row, "kind": kind_of(word(row, "method"))} for row in objects(document["rows"])]
    kinds = read_series(document, rows, "kind", "predicted_mm", "error_mm_median", "error_mm_p95")
    points = all_points(kinds)
    ratios = [median_mm / predicted_mm for predicted_mm, median_mm, *_ in points]
    axes = new_chart(document, f"The median true error is {min(ratios):.1f} to {max(ratios):.1f} times the error that "
                     "omni align predicts (simulation)", "filled: median, hollow: 95 %; a mark per row of the table",
                     "predicted error, mm", "true error, mm")
    predicted_mm, median_mm, p95_mm = columns(points, 3)
    make_logarithmic(axes, x=predicted_mm, y=median_mm + p95_mm)
    ends = [min(predicted_mm), max(predicted_mm)]
    axes.plot(ends, ends, color=GREY, linestyle=DASHED)
    middle = (ends[0] * ends[1] ** 2) ** (1 / 3)
    labels = [("error = predicted", middle, middle, GREY)]
    for kind, marks in kinds.items():
        colour = OTHER if kind == "sweep" else OURS if kind == "touch" else DARK
        x, median, p95 = columns(marks, 3)
        for y, hollow in ((p95, True), (median, False)):
            dots(axes, x, y, colour, hollow, ALIGN_MARKS.get(kind, "D"))
        labels.append((kind, *max(marks, key=lambda mark: mark[0])[:2], colour))
    marks = [(x, y) for x, *others, _ in points for y in others]
    return place_labels(axes, labels, marks + along(ends[:1] * 2, ends[1:] * 2))


def draw_stability(document):
    """One panel per noise: the stiffness bound over the loop's lag, and that of the simple rule."""
    points = []
    for row in table(document, "offered"):
        place, stiffness = finite(row, "noise_mm", "delay_ms"), positive(row, OFFERED, RULE)
        if place and stiffness and place[1] + REST_ms > 0:
            points.append((place[0], place[1] + REST_ms, *stiffness))
    if not points:
        raise Unusable("has no table of offers; make it with omni-bench stability")
    panels = group(sorted(points), lambda point: point[0])
    offers_N_m = [point[2] for point in points]
    figure = new_figure(document, f"The stiffness that a wall may have falls from {max(offers_N_m):,.0f} to "
                        f"{min(offers_N_m):.0f} N/m with the loop's lag and the position's noise (simulation)",
                        "a panel per noise of the position; lag: delay, half a tick and the coil", 230)
    boxes = figure.subplots(1, len(panels), sharex=True, sharey=True, squeeze=False).flatten()
    values_N_m = [value for point in points for value in point[2:]]
    make_logarithmic(boxes[0], x=[point[1] for point in points], y=[*values_N_m, ROOM_BELOW * min(values_N_m)])
    boxes[0].xaxis.set_major_locator(LogLocator())
    for axes, (noise_mm, marks) in zip(boxes, panels.items()):
        _, lag_ms, offered, rule = columns(marks, 4)
        axes.plot(lag_ms, offered, color=OURS, linewidth=2.5)
        axes.plot(lag_ms, rule, color=DARK, linestyle=DASHED, linewidth=1.2)
        axes.set(title=f"{noise_mm:g} mm", xlabel="lag, ms")
    boxes[0].set_ylabel("stiffness, N/m")
    # The last panel, of the lowest lines, has room for their names.
    for text, y, colour, offset, vertical in (("allowed", offered[0], OURS, 4, "bottom"),
                                              ("simple rule", rule[0], DARK, -6, "top")):
        axes.annotate(text, (lag_ms[0], y), (0, offset), textcoords="offset points", color=colour, va=vertical)
    return figure
