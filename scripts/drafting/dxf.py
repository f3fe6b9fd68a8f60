"""Writes a sheet as DXF."""
from drafting.style import STYLES, number


def write(sheet):
    """R12 (AC1009), in mm of the part: the sheet's coordinates over its scale."""
    out, n = [], lambda value: number(value / sheet.scale)
    put = lambda *pairs: out.extend(f"{code}\n{value}" for code, value in pairs)
    put((0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1009"), (9, "$EXTMIN"), (10, 0), (20, 0), (9, "$EXTMAX"),
        (10, n(sheet.paper[0])), (20, n(sheet.paper[1])), (0, "ENDSEC"), (0, "SECTION"), (2, "TABLES"))
    kinds = {"CONTINUOUS": [], "CENTER": [5, -1, 1, -1], "HIDDEN": [2, -1]}
    put((0, "TABLE"), (2, "LTYPE"), (70, len(kinds)))
    for kind, dashes in kinds.items():
        put((0, "LTYPE"), (2, kind), (70, 0), (3, kind), (72, 65), (73, len(dashes)), (40, n(sum(map(abs, dashes)))),
            *((49, n(dash)) for dash in dashes))
    put((0, "ENDTAB"), (0, "TABLE"), (2, "LAYER"), (70, len(STYLES)))
    for name, (_, _, _, colour, kind) in STYLES.items():
        put((0, "LAYER"), (2, name.upper()), (70, 0), (62, colour), (6, kind))
    put((0, "ENDTAB"), (0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES"))
    line = lambda layer, x0, y0, x1, y1: put(
        (0, "LINE"), (8, layer), (10, n(x0)), (20, n(y0)), (11, n(x1)), (21, n(y1)))
    codes = str.maketrans({"\u00d8": "%%c", "\u00b1": "%%p", "\u00b0": "%%d", "\u2212": "-", "\u25a1": "sq."})
    for kind, style, *rest in sheet.items:
        layer = style.upper()
        if kind == "line":
            line(layer, *rest)
        elif kind == "head":
            x, y, a, b, c, d = rest
            line(layer, x, y, a, b), line(layer, a, b, c, d), line(layer, c, d, x, y)
        elif kind in ("circle", "arc"):
            put((0, kind.upper()), (8, layer), (10, n(rest[0])), (20, n(rest[1])), (40, n(rest[2])))
            if kind == "arc":
                put((50, number(rest[3] % 360)), (51, number(rest[4] % 360)))
        elif kind == "text":
            x, y, words, size, anchor, _ = rest
            put((0, "TEXT"), (8, layer), (10, n(x)), (20, n(y)), (40, n(size * 0.73)), (1, words.translate(codes)))
            if anchor != "start":
                put((72, {"middle": 1, "end": 2}[anchor]), (11, n(x)), (21, n(y)))
    put((0, "ENDSEC"), (0, "EOF"))
    return "\n".join(out) + "\n"
