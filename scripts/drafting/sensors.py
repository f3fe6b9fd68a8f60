"""Sensors and marks."""
import math

from drafting.hull import MARKS, base_outline
from drafting.sheet import Sheet
from drafting.style import TEXT

SENSORS = "2 * hypot(omni.sensors[0].position_base_m[0], omni.sensors[0].position_base_m[1])"  # diameter of their ring


def draw(facts):
    s = Sheet(facts, "sensors", 0.5)
    s.title_block("Sensors and marks", "omni, marks.toml; build.toml: board, foot")
    mm = facts.mm
    marks = [[s.size(f"mark {i + 1}: {axis}", f"marks.marks[{i}].position_base_m[{n}]") for n, axis in enumerate("xyz")]
             for i in range(len(facts.names["marks"].marks))]
    sensors = [[s.size(f"sensor {i}: {axis}", f"omni.sensors[{i}].position_base_m[{n}]")
                for n, axis in enumerate("xyz")] for i in range(len(facts.omni.sensors))]
    styles = ["coil-z" if z == sensors[0][2] else "coil-y" for _, _, z in sensors]
    foot, hull = mm("build.foot.outer_radius_m"), mm("omni.hull.hull_radius_m")
    inner, outer = mm("build.board.inner_radius_m"), mm("build.board.outer_radius_m")
    s.text(8, 199, "From above (x to the right, y away from the user)", TEXT, bold=True)
    v = s.view(60, 140)
    v.circle("edge", 0, 0, foot)
    v.circle("thin", 0, 0, inner)
    v.circle("thin", 0, 0, outer)
    v.circle("edge", 0, 0, hull, "box")
    v.cross(0, 0, foot + 6)
    ring, far = math.hypot(*sensors[0][:2]), math.hypot(*marks[0][:2])
    v.circle("centre", 0, 0, ring)

    def named(x, y, beyond, words, style):
        r = math.hypot(x, y)
        at = v.at(x * (1 + beyond / r), y * (1 + beyond / r))
        s.text(at[0], at[1] - 1.2, words, TEXT, "middle", style, True)

    for i, (x, y, _) in enumerate(sensors):
        v.block(x - 4, y - 4, x + 4, y + 4, styles[i], styles[i])
        named(x, y, -14, str(i), styles[i])
    for i, (x, y, z) in enumerate(marks):
        v.circle("mark", x, y, 2.5)
        if z < 0:
            named(x, y, 16, f"M{i + 1}", "mark")
        else:
            s.text(v.x + 2, v.y + 2, f"M{i + 1}", TEXT, "start", "mark", True)
    v.across("ring of the sensors", SENSORS, -ring, ring, 0, 86, "\u00d8")
    v.across("board: outer", "2 * build.board.outer_radius_m", -outer, outer, 0, 79.5, "\u00d8")
    v.across("ring of the marks", MARKS, -far, far, 0, 73, "\u00d8")
    v.across("foot", "2 * build.foot.outer_radius_m", -foot, foot, 0, 66.5, "\u00d8")
    v.leader("board: inner", "2 * build.board.inner_radius_m", (inner * math.cos(1.9), inner * math.sin(1.9)),
             (20, 190), "\u00d8")
    s.line("size", 14, 46, 24, 46)
    s.arrow(24, 46, 1, 0)
    s.text(25.5, 44.8, "x", TEXT, colour="size")
    s.line("size", 14, 46, 14, 56)
    s.arrow(14, 56, 0, 1)
    s.text(14, 57.5, "y", TEXT, "middle", "size")
    s.notes(32, 52, "Each sensor's own x, y, z arrows lie along the base's.",
            "Its chip is on top of the carrier, the carrier on top of the board.",
            "Sensors 0 to 3: upper board. Sensors 4 to 7: lower board.",
            "M1 to M5: dimples for omni align, M5 on top of the hull.")
    s.text(124, 199, "From the front (x to the right, z up)", TEXT, bold=True)
    w = s.view(168, 160)
    base_outline(w, facts, "box")
    for plane in (0, 4):
        board = sensors[plane][2] - mm("build.board.chip_above_m")
        w.block(-outer, board - mm("build.board.thickness_m"), outer, board, styles[plane], "thin")
    for (x, _, z), style in zip(sensors, styles):
        w.block(x - 3, z - 0.5, x + 3, z + 0.5, style, style)
    for x, _, z in marks:
        w.circle("mark", x, z, 1.5)
    w.line("centre", 0, hull + 5, 0, mm("build.foot.bottom_m") - 5)
    w.line("centre", -hull - 6, 0, hull + 6, 0)
    level = hull + 5
    w.upright("marks 1 to 4 below the core's centre", "-marks.marks[0].position_base_m[2]", marks[0][2], 0,
              (foot, level), 214, right=False)
    w.upright("sensors 0 to 3 below the core's centre", "-omni.sensors[0].position_base_m[2]", sensors[0][2], 0,
              (ring + 4, level), 217)
    w.upright("sensors 4 to 7 below the core's centre", "-omni.sensors[4].position_base_m[2]", sensors[4][2], 0,
              (sensors[4][0] + 4, level), 226)
    w.leader("chip above its board", "build.board.chip_above_m", (-ring, sensors[0][2] - 1), (148, 88), "chip ",
             " above board")
    w.leader("board: thickness", "build.board.thickness_m", (outer - 4, sensors[4][2] - 3), (212, 88), "board ")
    columns = [("", 13), ("x", 16), ("y", 16), ("z", 14)]
    cells = lambda name, rows: [[f"{name}{i}", f"{x:.2f}", f"{y:.2f}", f"{z:.1f}"] for i, (x, y, z) in rows]
    s.text(234, 199, "Sensors", TEXT, bold=True)
    s.table(232, 196, columns, cells("", enumerate(sensors)))
    s.text(234, 149, "Marks", TEXT, bold=True)
    s.table(232, 146, columns, cells("M", enumerate(marks, 1)))
    return s
