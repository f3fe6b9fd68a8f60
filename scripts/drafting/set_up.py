"""The whole set-up, for those who have never seen one: person, headset, pen, base, supply and computer."""
import math

from drafting import person
from drafting.sheet import Sheet
from drafting.style import SMALL, TEXT, label

PAPER = (240, 170)  # mm: letters of 12 and 11 pixels where the picture is 800 wide
CORE, SCALE = (101, 53), 0.2  # of the view: x towards the person, z up
DESK_FROM, DESK_TO, DESK_THICK = -475, 432, 25  # free, mm, as all lengths below
TIP = 18  # the pen's above the hull
COMPUTER = (-470, -310, 235)  # from, to, height
SUPPLY = (-272, -180, 62)
BUTTON = (195, 245, 24)
SOFTWARE = ("application", "Omni's layer", "OpenXR runtime", "omnid")


def base(v, facts):
    mm = facts.mm
    hull, neck, foot = (mm(f"{part}_radius_m") for part in ("omni.hull.hull", "build.neck.outer", "build.foot.outer"))
    v.block(-neck, -math.sqrt(hull ** 2 - neck ** 2), neck, mm("build.foot.top_m"), "paper")
    v.circle("edge", 0, 0, hull, "paper")
    v.circle("thin", 0, 0, mm("omni.coils[0].shell_radius_max_m"), "coil-z")
    v.circle("thin", 0, 0, mm("omni.core.core_radius_m"), "iron")
    v.block(-foot, mm("build.foot.top_m"), foot, mm("build.foot.bottom_m"), "paper")
    for sensor in facts.omni.sensors:
        _, y, z = (1e3 * value for value in sensor.position_base_m)
        v.block(-y - 5, z - 2, -y + 5, z + 2, "accent", "thin")


def pen_parts(facts):
    mm = facts.mm
    half, radius = mm("omni.magnet.half_height_m"), mm("omni.magnet.radius_m")
    face = mm("omni.magnet.tip_offset_m") - half
    back = face + 2 * half
    flange = back + mm("build.pen.flange_m")
    return ((face, back, radius, "accent"), (back, flange, radius, "wall"),
            (flange, flange + mm("build.pen.grip_length_m"), mm("build.pen.grip_diameter_m") / 2, "box"))


def computer(s, v, desk):
    left, right, height = COMPUTER
    v.block(left, desk, right, desk + height, "wall")
    (x, y), step = v.at(left, desk), v.scale * height / len(SOFTWARE)
    for i, words in enumerate(reversed(SOFTWARE)):
        s.rect("thin", x + 1, y + 1 + step * i, v.scale * (right - left) - 2, step - 2, "paper")
        s.text(x + v.scale * (right - left) / 2, y + step * (i + 0.5) - 1.1, words, SMALL, "middle")
    s.text(x + v.scale * (right - left) / 2, y + v.scale * height + 2, "computer", TEXT, "middle", bold=True)


def supply(s, v, facts, desk):
    left, right, height = SUPPLY
    v.block(left, desk, right, desk + height, "paper")
    x, y = v.at((left + right) / 2, desk)
    s.text(x, y + 7, "supply", SMALL, "middle")
    s.text(x, y + 2.5, f"{label(s.size('supply', 'omni.limits.supply_V', ''))} V", SMALL, "middle")
    left, right, height = BUTTON
    middle = (left + right) / 2
    v.block(left, desk, right, desk + height, "paper")
    v.block(middle - 8, desk + height, middle + 8, desk + height + 7, "paper")
    v.wall(middle, desk + height + 7, 19, 19, 0, 180, fill="coil-z")
    v.line("edge", middle - 19, desk + height + 7, middle + 19, desk + height + 7)
    s.text(*v.at(right + 12, desk + 8), "emergency stop", SMALL)


def cables(s, v, desk):
    s.curve("hidden", [(23, 85), (23, 105), (23, 124), (25.5, 133), (34, 136), (60, 136), (120, 136), (160, 136),
                       (168, 135.8), (173.5, 134.6), (176.5, 132.4)])
    usb = ((COMPUTER[1], 28), (-300, 72), (-250, 88), (-180, 72), (-130, 34), (-85, 24))
    power = ((SUPPLY[1], 24), (-150, 8), (-115, 5), (-85, 12))
    for cable in (usb, power):
        v.curve("edge", [(x, desk + up) for x, up in cable])
    v.line("edge", SUPPLY[1], desk + 5, BUTTON[0], desk + 5)


def keep_away(s, x, y):
    """A horseshoe magnet, crossed out."""
    s.swath("wall", 2.6, x, y - 1, 3.2, 180, 360)
    for r in (1.9, 4.5):
        s.arc("edge", x, y - 1, r, 180, 360)
    for left in (x - 4.5, x + 1.9):
        s.rect("edge", left, y - 1, 2.6, 4.4, "wall")
        s.rect("edge", left, y + 2, 2.6, 1.4, "paper")
    s.circle("coil-z", x, y, 7.5)
    s.line("coil-z", x - 5.3, y + 5.3, x + 5.3, y - 5.3)


def labels(s, v, eye, facts):
    mm, hull = facts.mm, facts.mm("omni.hull.hull_radius_m")
    front, up = mm("layer.kInFront_m"), mm("layer.kBelow_m")
    out = lambda r, deg: (r * math.cos(math.radians(deg)), r * math.sin(math.radians(deg)))
    s.text(6, 161.5, "The set-up, from the side", 5, bold=True)
    s.text(6, 155.5, "Nothing here has been built with this firmware yet: simulated.", TEXT, colour="size", bold=True)
    s.notes(62, 138.2, "to the headset: by cable or wireless")
    s.text(*eye.at(-38, 16), "headset", SMALL, "middle")
    eye.circle("size", 0, 0, 4, "accent")
    v.across("core in front of the eyes", "layer.kInFront_m", 0, front, (150, up), v.at(0, up)[1],
             suffix=" mm in front of you")
    v.upright("core below the eyes", "layer.kBelow_m", 0, up, (-hull, 0), 46, suffix=" mm")
    s.notes(47.2, 82.6, "below", "the eyes", step=4.4)
    v.leader("forces reach above the hull", "scene.kReach_m", out(hull + mm("scene.kReach_m"), 118), (89, 110),
             "forces within ", " mm")
    s.text(89, 105.6, "above the ball", SMALL, "end")
    v.leader("the pen is tracked within, from the core", "tracker.reach_max_m", out(mm("tracker.reach_max_m"), 60),
             (138, 110), "tracked within ", " mm")
    s.text(138, 105.6, "around its centre", SMALL)
    v.point(out(hull, 150), (80, 62), f"base: {len(facts.omni.coils)} coils,")
    s.text(80, 57.7, f"{len(facts.omni.sensors)} sensors", SMALL, "end")
    v.point((60, 142), (120, 88), "pen: nothing but a magnet")
    s.text(69, 46, "USB", SMALL)
    steel = s.size("steel frame below the core", "-room.steel[0].position_base_m[2]")
    s.notes(25, 19.5,
            "Other magnets: a metre away while you calibrate. Steel near the base: leave it where it was then.",
            f"A desk frame of steel {label(steel)} mm below the core is part of the simulation.",
            f"{label(front)} and {label(up)} mm: where Omni expects the base, until you align it with the headset.",
            step=4.7)


def draw(facts):
    s = Sheet(facts, "set-up", paper=PAPER)
    mm, desk, hull = facts.mm, facts.mm("build.foot.bottom_m"), facts.mm("omni.hull.hull_radius_m")
    v = s.view(*CORE, SCALE)
    tip = s.view(*v.at(0, hull + TIP), SCALE)
    eye = s.view(*v.at(mm("layer.kInFront_m"), mm("layer.kBelow_m")), SCALE)
    person.arm(tip)
    person.body(eye)
    person.head(eye)
    reach = mm("scene.kReach_m")
    v.wall(0, 0, hull + reach, reach, 0, 180, "thin", "coil-z")
    v.arc("hidden", 0, 0, mm("tracker.reach_max_m"), 58, 115)
    v.block(DESK_FROM, desk - DESK_THICK, DESK_TO, desk, "wall")
    cables(s, v, desk)
    base(v, facts)
    computer(s, v, desk)
    supply(s, v, facts, desk)
    person.hand(tip, pen_parts(facts))
    keep_away(s, 14, 13)
    labels(s, v, eye, facts)
    return s
