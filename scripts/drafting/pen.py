"""The pen, and how it touches the hull."""
import math

from drafting.sheet import Sheet
from drafting.style import SMALL, TEXT


def draw(facts):
    s = Sheet(facts, "pen", 1)
    s.title_block("Pen", "omni.toml: magnet, hull; build.toml: pen")
    mm = facts.mm
    radius, b, tip = mm("omni.magnet.radius_m"), mm("omni.magnet.half_height_m"), mm("omni.magnet.tip_offset_m")
    hull, core = mm("omni.hull.hull_radius_m"), mm("omni.core.core_radius_m")
    flange, grip, length = mm("build.pen.flange_m"), mm("build.pen.grip_diameter_m") / 2, mm("build.pen.grip_length_m")
    nib, face, back = tip - b, tip - b, tip + b
    s.text(8, 199, "Section (the tip points to the left)", TEXT, bold=True)
    v = s.view(52, 166)
    v.block(face, -radius, back, radius, "coil-y")
    v.block(back, -radius, back + flange, radius)
    v.block(back + flange, -grip, back + flange + length, grip)
    v.arc("edge", face, 0, nib, 90, 270)
    v.line("centre", -8, 0, back + flange + length + 6, 0)
    v.line("centre", tip, -radius - 3, tip, radius + 3)
    s.text(v.x + tip - 1.9, v.y + 4, "N", TEXT, "middle", bold=True)
    s.text(v.x + tip + 1.9, v.y + 4, "S", TEXT, "middle", bold=True)
    high, low = v.at(0, radius)[1], v.at(0, -radius)[1]
    v.across("tip before the magnet's centre", "omni.magnet.tip_offset_m", 0, tip, (0, radius), high + 9, beside=-5.5)
    v.across("magnet: height", "2 * omni.magnet.half_height_m", face, back, -radius, low - 7)
    v.across("nib before the magnet's face", "omni.magnet.tip_offset_m - omni.magnet.half_height_m", 0, face,
             (0, -radius), low - 14, beside=-5.5)
    v.across("flange", "build.pen.flange_m", back, back + flange, radius, high + 5, beside=5)
    v.across("grip: length", "build.pen.grip_length_m", back + flange, back + flange + length, -grip, low - 7)
    v.upright("magnet: diameter", "2 * omni.magnet.radius_m", -radius, radius, face, 34, "\u00d8", right=False)
    v.upright("grip: diameter", "build.pen.grip_diameter_m", -grip, grip, back + flange + length, 172, "\u00d8")
    s.notes(196, 186, "Magnet: its north pole faces the tip.", "It is glued to the flange by its back;",
            "nothing beside its rim or before its face", "but the nib: half a plastic ball, not steel.")
    s.notes(196, 163, "Flange and grip: printed, no iron.")

    def contact(x, up, words, nib_shown, lean=0.0):
        """The magnet `up` above the core's centre, leaning about it."""
        c, view = (math.cos(lean), math.sin(lean)), s.view(x, 52)
        put = lambda a, d: (a * c[0] + d * c[1], up - a * c[1] + d * c[0])
        view.arc("edge", 0, 0, hull, 25, 155)
        view.arc("hidden", 0, 0, core, 25, 155)
        view.line("centre", 0, 0, 0, up + 14)
        view.line("centre", -5, 0, 5, 0)
        corners = [put(a, d) for a, d in ((-radius, -b), (radius, -b), (radius, b), (-radius, b))]
        for one, two in zip(corners, corners[1:] + corners[:1]):
            view.line("edge", *one, *two)
        view.line("centre", *put(0, -b - 4), *put(0, b + 8))
        view.circle("size", *put(0, 0), 0.5)
        if nib_shown:
            turn = math.degrees(-lean)
            view.arc("edge", *put(0, -b), nib, 180 + turn, 360 + turn)
        s.text(x, 117, words, SMALL, "middle", bold=True)
        return view, put

    s.text(8, 126, "On the hull", TEXT, bold=True)
    bare, _ = contact(56, hull + b, "bare magnet: model and paper", False)
    bare.upright("contact of the bare magnet, from the core's centre",
                 "omni.hull.hull_radius_m + omni.magnet.half_height_m", 0, hull + b, (-5, -radius), 18, right=False)
    bare.leader("hull", "omni.hull.hull_radius_m", (hull * math.cos(0.75), hull * math.sin(0.75)), (90, 100), "hull R")
    upright, _ = contact(148, hull + tip, "upright, with nib", True)
    upright.upright("contact of an upright pen, from the core's centre",
                    "omni.hull.hull_radius_m + omni.magnet.tip_offset_m", 0, hull + tip, (-5, -radius), 112,
                    right=False)
    lean, centre = facts.lean()
    leaning, put = contact(240, 1e3 * centre, "nib and rim touch", True, lean)
    leaning.leader("lean at which nib and rim both touch", "lean()[0]", put(0, b + 7), (262, 110), "lean ", "\u00b0",
                   "deg")
    s.notes(8, 32, "Leaning further, the rim touches alone, as if the nib were not there: "
            "touch the hull so for omni calibrate.")
    return s
