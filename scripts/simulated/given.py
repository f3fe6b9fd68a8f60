"""What a program was given (the lines of tests/engines/witness), and how that compares with the twin's truth."""
import json
import math
import statistics

from simulated import stand

POSITION_VALID, POSITION_TRACKED = 2, 8  # XrSpaceLocationFlags
GRIP_BEHIND_TIP_m = 0.05                 # docs/howto/openxr-layer.md, Poses
STILL_m_s = 0.02
PRESSED = 0.5                            # of a float


def read_lines(path):
    """The lines of a witness; the last one may be cut."""
    lines = []
    with open(path, encoding="utf-8", errors="replace") as file:
        for line in file:
            try:
                lines.append(json.loads(line))
            except json.JSONDecodeError:
                pass
    return lines


def last_report(text):
    """The last JSON object that a program of ours printed on a line of its own; {}: none."""
    for line in reversed(text.splitlines()):
        if line.startswith("{"):
            try:
                return json.loads(line)
            except json.JSONDecodeError:
                pass
    return {}


def of(lines, what, **wanted):
    return [line for line in lines if line["what"] == what and all(line.get(key) == value for key, value in wanted.items())]


def profiles(lines, hand):
    """The profiles of a hand in turn, without repetitions, by their last two words."""
    found = []
    for line in of(lines, "profile", hand=hand):
        name = "/".join(line["profile"].split("/")[-2:]) or "none"
        if not found or found[-1] != name:
            found.append(name)
    return found


def frames(lines):
    """Number of frames, and of those per second between first and last."""
    times = [line["t"] for line in of(lines, "frame", result=0)]
    if len(times) < 2:
        return len(times), 0.0
    return len(times), (len(times) - 1) / (1e-9 * (times[-1] - times[0]))


def _presses(lines, actions, hand):
    """Action -> how often it was pressed, and whether it is now."""
    found = {}
    for line in lines:
        if line["what"] in ("bool", "float") and line["hand"] == hand and line["action"] in actions:
            count, before = found.get(line["action"], (0, False))
            pressed = line["active"] and line["value"] >= PRESSED
            found[line["action"]] = (count + (pressed and not before), pressed)
    return found


def presses(lines, actions, hand="right"):
    """Of the action that was pressed most often: a program reads one or the other."""
    return max((count for count, _ in _presses(lines, actions, hand).values()), default=0)


def is_pressed(lines, actions, hand="right"):
    return any(pressed for _, pressed in _presses(lines, actions, hand).values())


def haptics(lines, hand="right"):
    return len(of(lines, "haptic", hand=hand, result=0))


def true_place(truth, index, pose):
    tip, axis = truth.tip[index], truth.axis[index]
    behind = GRIP_BEHIND_TIP_m if pose == "grip" else 0.0
    return stand.stage_of([t - behind * a for t, a in zip(tip, axis)])


def in_turns(turns, owner, t_ns):
    return any(turn["owner"] == owner and turn["from"] <= t_ns <= turn["to"] for turn in turns)


def pose_errors(lines, truth, poses, turns, hand="right"):
    """Distances in mm between the poses of the pen that a program was given and the true ones, at the times for which it asked.
    `poses`: action -> "tip" or "grip"; `turns`: who had the hand, and from when to when."""
    still, all_of_them, tracked = [], [], 0
    for line in of(lines, "pose", hand=hand):
        if line["action"] not in poses or not in_turns(turns, "pen", line["t"]) or not line["flags"] & POSITION_VALID:
            continue
        index = truth.at(line["for"])
        if index is None:
            continue
        error_mm = 1e3 * math.dist(line["p"], true_place(truth, index, poses[line["action"]]))
        all_of_them.append(error_mm)
        tracked += bool(line["flags"] & POSITION_TRACKED)
        if truth.speed[index] < STILL_m_s:
            still.append(error_mm)
    return {"poses": len(all_of_them), "tracked": round(tracked / len(all_of_them), 3) if all_of_them else 0.0,
            "still_mm": round(statistics.median(still), 2) if still else None,
            "p95_mm": round(sorted(all_of_them)[int(0.95 * (len(all_of_them) - 1))], 2) if all_of_them else None}


def controller_off_mm(lines, poses, turns, hand="right"):
    """How far the runtime's own controller seemed to be from where the simulation has it, at most; None: no pose."""
    off = [1e3 * math.dist(line["p"], stand.CONTROLLER_STAGE_m[hand]) for line in of(lines, "pose", hand=hand)
           if line["action"] in poses and line["flags"] & POSITION_VALID and in_turns(turns, "controller", line["t"])]
    return round(max(off), 2) if off else None
