"""The film of scripts/headset: what the hand does, and how pictures become a file."""
import bisect
import math
import pathlib
import subprocess

import relief
from simulated import hand

SECONDS = 20.0
RATE_Hz = 10
FEWEST_Hz = 5  # pictures, of a machine that keeps up
REHEARSED_s, STEADY_s = 8.5, 5
LARGEST_bytes = 3_000_000
SHOWN_LATE_ns = 500_000_000  # up to which a number in the corner may be older than its picture, one frame of a slow machine included
WITHIN_N = 0.03


def on(r_m, angle_rad=0.0, depth_m=0.0):
    """A point of the base on the relief, or below it."""
    return (r_m * math.cos(angle_rad), r_m * math.sin(angle_rad), relief.height_m(r_m) - depth_m)


LEANING = (-0.32, 0.22, -math.sqrt(1 - 0.32**2 - 0.22**2))  # out of the tip: as a right hand holds a pen

# When the hand is where; between two of them it goes smoothly. It pushes `depth` below the surface, and the arm's spring gives way.
HOVER_m, LIGHT_m, FIRM_m = -0.012, 0.004, 0.009
LEGS = [(0.0, hand.ABOVE), (1.5, on(0.0, 0, HOVER_m)), (3.0, on(0.0, 0, LIGHT_m)), (4.0, on(0.0, 0, LIGHT_m)), (5.0, on(0.0, 0, FIRM_m)),
        (6.5, on(0.0, 0, FIRM_m)), (7.5, on(0.0, 0, HOVER_m)), (8.5, on(0.018, math.pi, HOVER_m)), (9.5, on(0.018, math.pi, LIGHT_m))]
LEGS += [(9.5 + 4.0 * i / 20, on(abs(0.018 * (i / 10 - 1)), math.pi if i < 10 else 0.0, LIGHT_m)) for i in range(1, 21)]
LEGS += [(13.5 + 4.5 * i / 24, on(0.018 - 0.010 * min(1, i / 6), 2 * math.pi * i / 24, LIGHT_m + 0.001)) for i in range(1, 25)]
LEGS += [(19.0, on(0.008, 0, HOVER_m)), (SECONDS, hand.ABOVE)]


def aim_at(seconds):
    """Where the hand wants the tip: straight between two points of LEGS; the arm itself is smooth."""
    for (begin, start), (end, stop) in zip(LEGS, LEGS[1:]):
        if seconds <= end:
            part = (seconds - begin) / (end - begin)
            return tuple(a + part * (b - a) for a, b in zip(start, stop))
    return LEGS[-1][1]


def as_recorded(pictures, truth):
    """The share of pictures whose corner shows a force that the twin's record has within the time before."""
    good = 0
    for t, newtons in pictures:
        begin = bisect.bisect_left(truth.t, t - SHOWN_LATE_ns)
        recent = truth.force[begin:bisect.bisect_right(truth.t, t + SHOWN_LATE_ns // 5)]
        good += bool(recent) and min(recent) - WITHIN_N <= newtons <= max(recent) + WITHIN_N
    return good / len(pictures)


def concat_list(pictures, folder):
    """For ffmpeg's concat: each picture as long as it was the newest. `pictures`: (ns, file)."""
    lines = ["ffconcat version 1.0"]
    for (t, file), (following, _) in zip(pictures, [*pictures[1:], (pictures[-1][0] + int(1e9 / RATE_Hz), None)]):
        lines += [f"file {folder}/{file}", f"duration {1e-9 * (following - t):.3f}"]
    return "\n".join(lines) + "\n"


def assemble(root, folder, pictures, seen, target):
    """An animated WebP that repeats; the root's ffmpeg makes it."""
    listing = pathlib.Path(folder) / "film.txt"
    listing.write_text(concat_list(pictures, folder))
    made = pathlib.Path(folder) / "film.webp"
    words = ["ffmpeg", "-y", "-loglevel", "error", "-safe", "0", "-f", "concat", "-i", str(listing), "-vf", f"fps={RATE_Hz}",
             "-c:v", "libwebp_anim", "-quality", "55", "-compression_level", "5", "-loop", "0", str(made)]
    with root.start(words, {}, seen, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        problem = process.communicate()[0]
    if process.returncode or made.stat().st_size > LARGEST_bytes:
        return problem.strip() or f"{made.stat().st_size} bytes are more than {LARGEST_bytes}"
    target.write_bytes(made.read_bytes())
    return ""
