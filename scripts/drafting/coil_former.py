"""Coil former and winding."""
import math

from drafting.sheet import Sheet
from drafting.style import COILS, FILL, SMALL, TEXT


def draw(facts):
    s = Sheet(facts, "coil-former", 2)
    s.title_block("Coil former and winding", "omni.toml: core, coils; build.toml: wire, former")
    mm, layers = facts.mm, facts.omni.coils[0].layers
    v = s.view(88, 111)
    core, outer, pitch = mm("omni.core.core_radius_m"), mm("omni.coils[0].shell_radius_max_m"), mm("pitch_m()")
    wire = mm("build.wire.outer_m") / 2
    s.text(8, 199, "Section in the plane y = 0 (x to the right, z up)", TEXT, bold=True)
    v.circle("edge", 0, 0, core, "iron")
    for layer in range(layers):
        s.swath(FILL["coil-y"], 2 * pitch, *v.at(0, 0), 2 * mm(f"shell_m(1, {layer})"), 0, 360)
    for k, axis in ((0, 0), (2, 90)):
        for layer in range(layers):
            middle, edge = mm(f"shell_m({k}, {layer})"), math.degrees(facts.edge_angle(k, layer))
            for side in (axis, axis + 180):
                v.wall(0, 0, middle + pitch / 2, pitch, side - 90 + edge, side + 90 - edge, "thin")
                for end in (side - 90 + edge, side + 90 - edge):
                    c, d = math.cos(math.radians(end)), math.sin(math.radians(end))
                    low, high = middle - pitch / 2, middle + pitch / 2
                    v.line("thin", low * c, low * d, high * c, high * d)
            count = facts.turns_in(k, layer)
            for n in range(count):
                along = math.radians(edge) * ((2 * n + 1) / count - 1)
                u, w = middle * math.sin(along), middle * math.cos(along)
                style = f"coil-{COILS[k]}"
                for sign in (1, -1):
                    v.circle(style, *((u, sign * w) if k == 0 else (sign * w, u)), wire, style)
    for layer in range(layers):
        for r in (-pitch / 2, pitch / 2):
            v.circle("coil-y", 0, 0, mm(f"shell_m(1, {layer})") + r)
    v.cross(0, 0, outer + 3)
    half = mm("omni.coils[0].band_half_width_m")
    for sign in (1, -1):
        v.line("hidden", sign * half, -outer - 2, sign * half, outer + 2)
    top = v.at(0, outer)[1]
    v.across("band of a coil in the model", "2 * omni.coils[0].band_half_width_m", -half, half, outer + 2, top + 9)
    bottom = v.at(0, -outer)[1]
    v.across("core", "2 * omni.core.core_radius_m", -core, core, 0, bottom - 7, "\u00d8")
    v.across("winding", "2 * omni.coils[0].shell_radius_max_m", -outer, outer, 0, bottom - 14, "\u00d8")
    s.text(8, 188, "x: turns (orange) and caps (grey)", SMALL, colour="coil-x")
    s.text(8, 183.5, "z: turns (blue) and caps", SMALL, colour="coil-z")
    s.text(8, 179, "y: whole rings", SMALL, colour="coil-y")
    free = math.sqrt(3) * half
    v.leader("corner that no band covers begins at R", "sqrt(3) * omni.coils[0].band_half_width_m",
             (free * math.sqrt(2 / 3), free / math.sqrt(3)), (122, 189), "corners free from R")
    last = mm("shell_m(0, 5)")
    v.leader("wire", "build.wire.outer_m", (last * math.sin(0.2), -last * math.cos(0.2)), (127, 38), "wire \u00d8")
    # The first cap: the others follow from the table.
    s.text(172, 199, "Cap of layer 1 (x); all others as in the table", TEXT, bold=True)
    c = s.view(188, 170)
    inner, angle = core, 90 - math.degrees(facts.edge_angle(0, 0))
    c.wall(0, -inner, inner + pitch, pitch, 90 - angle, 90 + angle)
    a = math.radians(90 - angle)
    for sign in (1, -1):
        c.line("edge", sign * inner * math.cos(a), inner * math.sin(a) - inner, sign * (inner + pitch) * math.cos(a),
               (inner + pitch) * math.sin(a) - inner)
    c.line("centre", 0, -inner - 1, 0, pitch + 2)
    edge, rim = mm("edge_m(0, 0)"), mm("edge_radius_m(0, 0)")
    c.across("cap 1: edge, at mid-thickness", "2 * edge_radius_m(0, 0)", -rim, rim, edge - inner, 152, "\u00d8")
    c.upright("cap 1: edge above the core's centre", "edge_m(0, 0)", -inner, edge - inner, (0, rim), 215)
    inside = lambda angle: (inner * math.cos(angle), inner * math.sin(angle) - inner)
    c.leader("cap: thickness", "pitch_m()", (inside(1.9)[0], inside(1.9)[1] + pitch), (181, 183), "t ")
    c.leader("cap 1: inner radius", "omni.core.core_radius_m", inside(1.2), (191, 146), "R")
    p = s.view(254, 165)
    big, small = (inner + pitch) * math.cos(a), inner * math.cos(a)
    notch, deep = mm("build.former.notch_m"), mm("build.former.notch_depth_m")
    gap = math.degrees(math.asin(notch / 2 / big))
    p.arc("edge", 0, 0, big, gap, 360 - gap)
    p.arc("hidden", 0, 0, small, gap, 360 - gap)
    for sign in (1, -1):
        p.line("edge", big - deep, sign * notch / 2, big * math.cos(math.radians(gap)), sign * notch / 2)
    p.line("edge", big - deep, -notch / 2, big - deep, notch / 2)
    p.cross(0, 0, big + 2)
    p.upright("cap: slot for the wire", "build.former.notch_m", -notch / 2, notch / 2, big, 283)
    p.across("cap: depth of the slot", "build.former.notch_depth_m", big - deep, big, notch / 2, 190, beside=-5.5)
    rows = []
    for layer in range(layers):
        for k in range(3):
            shell = 3 * layer + k
            low = s.size(f"layer {shell + 1} ({COILS[k]}): inner radius", f"shell_m({k}, {layer}) - pitch_m() / 2")
            high = s.size(f"layer {shell + 1} ({COILS[k]}): edge above the centre", f"edge_m({k}, {layer})")
            wide = s.size(f"layer {shell + 1} ({COILS[k]}): edge, diameter", f"2 * edge_radius_m({k}, {layer})")
            turns = s.size(f"layer {shell + 1} ({COILS[k]}): turns", f"turns_in({k}, {layer})", "")
            rows.append([str(shell + 1), COILS[k], f"{low:.2f}", f"{high:.2f}", f"{wide:.2f}", f"{turns:.0f}"])
    columns = [("layer", 14), ("coil", 13), ("inner R", 21), ("edge", 18), ("edge \u00d8", 21), ("turns", 18)]
    s.table(183, 139, columns, rows, 5.3)
    s.text(8, 21, f"{6 * layers} caps: two per layer, either side of the turns.", SMALL)
    s.text(8, 16, "Edges: cut on a cone to the centre, values at mid-thickness.", SMALL)
    return s
