"""A person with a headset, whose hand holds the pen: curves by eye, in mm, seen from the person's left."""
import math

LEAN = math.radians(35)  # of the pen from the vertical, towards the person

# The hand, from the pen's tip. What lies further back comes first.
LITTLE = ((158, 14), (140, 1), (120, -5), (100, -13), (82, -18), (66, -18), (56, -13), (55, -5), (62, 2), (84, 14),
          (110, 24))
RING = ((110, 12), (92, 4), (74, -4), (58, -9), (45, -8), (39, -1), (43, 7), (58, 15), (84, 26))
MIDDLE = ((104, 24), (84, 20), (66, 12), (50, 5), (36, 3), (25, 9), (22, 18), (30, 24), (50, 30), (84, 40))
INDEX = ((86, 44), (70, 60), (52, 64), (40, 58), (31, 46), (25, 34), (21, 25), (15, 22), (8, 26), (6, 35), (9, 50),
         (16, 67), (24, 79), (34, 85), (46, 85), (60, 82), (74, 84), (88, 85), (104, 79), (126, 69), (158, 62))
THUMB = ((92, 62), (86, 54), (76, 51), (66, 53), (56, 55), (45, 54), (34, 49), (27, 42), (25, 35), (30, 30), (40, 28),
         (52, 30), (64, 30), (80, 25), (98, 17), (116, 11), (134, 9))
PALM = ((150, 20), (130, 50), (110, 60))  # closes THUMB and INDEX, without a line
NAIL = ((29, 43), (36, 38), (44, 41), (49, 48))
CREASE = ((60, 49), (62, 45), (62, 41))

# The arm, from the pen's tip as well; head and body, from the eye.
CUFF = ((152, 68), (166, 72), (171, 34), (168, -4), (154, -1), (157, 34))
ARM = ((168, 70), (230, 54), (310, 22), (372, -2), (410, 20), (446, 62), (490, 92), (540, 98), (588, 74), (602, 24),
       (566, -24), (504, -72), (452, -112), (410, -126), (372, -120), (320, -92), (240, -42), (166, -2))
BACK = ((160, -190), (196, -226), (214, -310), (216, -400), (212, -478))
CHEST = ((52, -178), (40, -214), (30, -280), (32, -380), (38, -478))
FACE = ((52, -178), (46, -140), (36, -119), (14, -116), (-6, -112), (-14, -100), (-13, -88), (-19, -80), (-15, -72),
        (-19, -64), (-18, -54), (-30, -47), (-31, -40), (-22, -20), (-12, 2), (-15, 24), (-10, 58), (14, 98), (62, 122),
        (116, 112), (154, 72), (166, 20), (158, -30), (140, -66), (134, -106), (140, -160), (160, -190))
EAR = ((92, 4), (100, 12), (112, 8), (115, -6), (109, -18), (104, -30), (96, -30))
VISOR = ((12, 44), (-40, 46), (-78, 40), (-88, 10), (-86, -22), (-72, -40), (-36, -42), (-22, -34), (8, -40), (16, 0))


def hand(view, parts):
    """parts: (begin, end, half the width, fill) of the pen, along its axis from the tip."""
    for finger in (LITTLE, RING, MIDDLE):
        view.curve("edge", finger, "paper")
    view.curve(None, INDEX + PALM, "paper", closed=True)
    view.curve("edge", INDEX)
    c, s = math.cos(LEAN), math.sin(LEAN)
    for begin, end, half, fill in parts:
        corners = ((begin, half), (end, half), (end, -half), (begin, -half))
        view.polygon("edge", [(along * s - aside * c, along * c + aside * s) for along, aside in corners], fill)
    view.curve(None, THUMB + PALM, "paper", closed=True)
    view.curve("edge", THUMB)
    for fine in (NAIL, CREASE):
        view.curve("thin", fine)
    view.curve("edge", CUFF, "wall", closed=True)


def arm(view):
    view.curve("edge", ARM, "box")


def body(view):
    view.curve(None, BACK + BACK[-1:] * 2 + CHEST[-1:] * 2 + CHEST[::-1], "box")
    view.curve("thin", BACK)
    view.curve("thin", CHEST)


def head(view):
    view.curve("thin", FACE, "box")
    view.curve("thin", EAR)
    view.polygon("edge", [(8, 26), (164, 40), (166, 20), (14, -2)], "wall")
    view.curve("edge", VISOR, "coil-z", closed=True)
