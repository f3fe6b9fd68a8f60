"""Hull, neck and foot."""
import math

from drafting.sheet import Sheet
from drafting.style import TEXT, label

MARKS = "2 * hypot(marks.marks[0].position_base_m[0], marks.marks[0].position_base_m[1])"  # diameter of their ring


def base_outline(v, facts, fill):
    """Hull, neck and foot in section, about the z axis."""
    mm = facts.mm
    hull, wall = mm("omni.hull.hull_radius_m"), mm("build.hull.wall_m")
    neck, neck_wall = mm("build.neck.outer_radius_m"), mm("build.neck.wall_m")
    foot, top, bottom, foot_wall = (
        mm(f"build.foot.{key}") for key in ("outer_radius_m", "top_m", "bottom_m", "wall_m"))
    joint = -math.sqrt(hull ** 2 - neck ** 2)
    open_deg = math.degrees(math.asin(joint / hull))
    v.wall(0, 0, hull, wall, open_deg, 180 - open_deg, fill=fill)
    for sign in (1, -1):
        v.block(sign * (neck - neck_wall), joint, sign * neck, top, fill)
        v.block(sign * (neck - neck_wall), top, sign * foot, top - foot_wall, fill)
        v.block(sign * (foot - foot_wall), top - foot_wall, sign * foot, bottom + foot_wall, fill)
    v.block(-foot, bottom, foot, bottom + foot_wall, fill)
    return joint


def draw(facts):
    s = Sheet(facts, "hull", 1)
    s.title_block("Hull, neck and foot", "omni.toml: hull; build.toml: hull to fan")
    mm = facts.mm
    v = s.view(99, 154)
    hull, wall = mm("omni.hull.hull_radius_m"), mm("build.hull.wall_m")
    neck, foot = mm("build.neck.outer_radius_m"), mm("build.foot.outer_radius_m")
    top, bottom, foot_wall = mm("build.foot.top_m"), mm("build.foot.bottom_m"), mm("build.foot.wall_m")
    s.text(8, 199, "Section in the plane y = 0 (x to the right, z up)", TEXT, bold=True)
    joint = base_outline(v, facts, "wall")
    winding, core = mm("omni.coils[0].shell_radius_max_m"), mm("omni.core.core_radius_m")
    v.circle("coil-y", 0, 0, winding, "coil-y")
    v.circle("edge", 0, 0, core, "iron")
    for sign in (1, -1):
        v.wall(0, 0, hull - wall, hull - wall - winding, *((-40, -5) if sign > 0 else (185, 220)), "thin", "box")
        v.line("edge", sign * (hull - wall), 0, sign * hull, 0)
    side, fan, deep = mm("build.fan.side_m"), mm("build.fan.top_m"), mm("build.fan.depth_m")
    v.block(-side / 2, fan - deep, side / 2, fan, "box", "thin")
    inner, outer = mm("build.board.inner_radius_m"), mm("build.board.outer_radius_m")
    for plane in (0, 4):
        z = mm(f"omni.sensors[{plane}].position_base_m[2]") - mm("build.board.chip_above_m")
        for sign in (1, -1):
            v.block(sign * inner, z - mm("build.board.thickness_m"), sign * outer, z, "coil-z", "thin")
    v.line("centre", 0, hull + 4, 0, bottom - 4)
    v.line("centre", -hull - 5, 0, hull + 5, 0)
    ring = mm(MARKS) / 2
    dimple = mm("build.dimple.diameter_m")
    for x, z in ((ring, top), (-ring, top), (0, hull)):
        v.circle("mark", x, z, dimple / 2)
        v.line("centre", x, z - 4, x, z + 4)
    # heights, at the right
    v.upright("hull: top above the core's centre", "omni.hull.hull_radius_m", 0, hull, (hull + 3, 0), 146)
    v.upright("foot: top below the core's centre", "-build.foot.top_m", top, 0, (foot, hull + 3), 190)
    v.upright("foot: bottom below the core's centre", "-build.foot.bottom_m", bottom, 0, (foot, hull + 3), 203)
    v.upright("foot: wall", "build.foot.wall_m", bottom, bottom + foot_wall, (foot, foot), 195, right=False, shift=-4.2)
    v.upright("fan: top below the core's centre", "-build.fan.top_m", fan, 0, (-side / 2, -hull), 24, right=False)
    v.upright("fan: depth", "build.fan.depth_m", fan - deep, fan, -side / 2, 60, right=False)
    # widths, below
    low = v.at(0, bottom)[1]
    v.across("neck", "2 * build.neck.outer_radius_m", -neck, neck, (-55, -55), v.at(0, -56)[1], "\u00d8")
    v.across("fan", "build.fan.side_m", -side / 2, side / 2, (fan - deep, fan - deep), low - 4, "\u25a1 ")
    v.across("ring of the marks", MARKS, -ring, ring,
             (top, top), low - 11, "\u00d8", above=0.8)
    v.across("foot", "2 * build.foot.outer_radius_m", -foot, foot, bottom, low - 18, "\u00d8")
    # walls and radii
    aim = lambda r, deg: (r * math.cos(math.radians(deg)), r * math.sin(math.radians(deg)))
    v.leader("hull: outer radius", "omni.hull.hull_radius_m", aim(hull, 140), (52, 187), "R",
             f" \u00b1{label(s.size('hull: tolerance of the radius', 'build.hull.tolerance_m'))}")
    v.leader("hull: wall", "build.hull.wall_m", aim(hull, 158), (48, 173), "wall ")
    v.leader("winding", "omni.coils[0].shell_radius_max_m", aim(winding, 30), (150, 178), "winding R")
    v.leader("hull: ribs", "build.hull.rib_m", (-winding * 0.98 - 0.6, -9), (50, 143), "8 ribs, ", " wide")
    v.leader("neck: wall", "build.neck.wall_m", (-neck + 1, -40), (58, 117), "wall ")
    v.leader("dimple of a mark", "build.dimple.diameter_m", (ring + dimple / 2, top), (208, 92), "dimple \u00d8",
             f", {label(s.size('dimple: depth', 'build.dimple.depth_m'))} deep")
    v.point((neck - 4, joint - 2), (140, 122), "air slots: lower half only")
    s.size("hull: width of the air slots", "build.hull.slot_m")
    v.point((outer, mm("omni.sensors[0].position_base_m[2]") - 3), (208, 83), "boards of the sensors")
    v.point((side / 2 - 3, fan - deep / 2), (208, 74), "fan, blows upwards")
    s.notes(208, 199, "Upper half: closed, smooth.", "Lower half: the winding is bonded to",
            "8 ribs; air passes between them.")
    s.notes(208, 181, f"Plastic for {label(facts('omni.limits.temperature_max_C'))} \u00b0C and more, no PLA.",
            "No steel below the winding:", "screws of brass or plastic.")
    s.notes(208, 163, "Air intakes all round the foot.")
    return s
