"""The rows of scripts/engines: what is expected of each, as a table for people and as JSON."""

CONTROLLER = "khr/simple_controller"
STILL_mm, PEN = 3.0, "pen"  # one sigma up to which a pose counts as TRACKED
OWNERS = {"no layer": ["controller"], "layer": ["controller"], "pen first": ["pen", "controller", "pen"],
          "controller first": ["controller", "pen", "controller"]}
LEFT = ([CONTROLLER], [])


def problems(row, presses):
    """What is not as it should be, in words; `presses`: as many as the hand made."""
    found = [change["missed"] for change in row["changes"] if "missed" in change]
    owners = [change["to"] for change in row["changes"] if "to" in change]
    if owners != OWNERS[row["mode"]]:
        found.append(f"the right hand went {' > '.join(owners) or 'nowhere'} instead of {' > '.join(OWNERS[row['mode']])}")
    seen = ["controller" if profile == CONTROLLER else "pen" for profile in row["profiles"]]
    if owners == OWNERS[row["mode"]] and seen not in (owners, ["controller", *owners]):  # until omnid has answered it is the controller's
        found.append(f"the right hand changed by itself: {' > '.join(seen)}")
    if row["ended_by_itself"]:
        found.append("the program has ended by itself")
    if row["graphics"] and not row["frames"]:
        found.append("no frame")
    if row["profiles_left"] not in LEFT:
        found.append(f"the left hand changed: {row['profiles_left']}")
    if row["validation_errors"]:
        found.append(f"{row['validation_errors']} errors of core_validation")
    if row["controller_off_mm"] is None or row["controller_off_mm"] > 1:
        found.append(f"the controller's pose is off by {row['controller_off_mm']} mm")
    if PEN in OWNERS[row["mode"]]:
        found += of_pen(row, presses)
    elif row["presses"]:
        found.append(f"{row['presses']} presses, but no hand pressed")
    return found


def of_pen(row, presses):
    if "presses_true" not in row:
        return ["the twin left no record"]
    found = []
    if row["still_mm"] is None or row["still_mm"] > STILL_mm:
        found.append(f"the pen at rest is off by {row['still_mm']} mm")
    if row["tracked"] < 0.9:
        found.append(f"only {row['tracked']:.0%} of the pen's poses are TRACKED")
    # A machine that stalls may let go of a force and take it up again: then the record has more.
    if row["presses"] != row["presses_true"] or row["presses_true"] < presses:
        found.append(f"{presses} presses of the hand, {row['presses_true']} in the twin's record, {row['presses']} in the program")
    if row.get("presses_game", row["presses"]) != row["presses"]:
        found.append(f"{row['presses']} presses reached the engine, {row['presses_game']} the game")
    if not row["haptics"]:
        found.append("no vibration was sent")
    elif not row["pulses"]:
        found.append("no vibration reached the coils")
    return found


COLUMNS = (
    ("program", lambda r: r["program"]),
    ("suite", lambda r: r["suite"]),
    ("run", lambda r: r["mode"]),
    ("frames", lambda r: str(r["frames"]) if r["graphics"] else "none"),
    ("a second", lambda r: f"{r['frames_s']:.0f}" if r["graphics"] else ""),
    ("right hand's profiles", lambda r: " > ".join(name.split("/")[-1].replace("_controller", "").replace("_logitech", "")
                                                   for name in r["profiles"])),
    ("still mm", lambda r: number(r.get("still_mm"))),
    ("p95 mm", lambda r: number(r.get("p95_mm"))),
    ("tracked", lambda r: f"{r['tracked']:.0%}" if "tracked" in r else ""),
    ("presses", lambda r: f"{r['presses']}/{r['presses_true']}" if "presses_true" in r else str(r["presses"])),
    ("vibrations", lambda r: str(r["haptics"])),
    ("validation", lambda r: f"{r['validation_errors']} {r['validation']}"),
    ("", lambda r: "ok" if not r["problems"] else "FAILED"),
)


def number(value):
    return "" if value is None else f"{value:.1f}"


def text(rows):
    """Lines in columns, and below what is wrong."""
    cells = [[title for title, _ in COLUMNS]] + [[show(row) for _, show in COLUMNS] for row in rows]
    widths = [max(len(line[i]) for line in cells) for i in range(len(COLUMNS))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip() for line in cells]
    for row in rows:
        lines += [f"{row['program']}, {row['suite']}, {row['mode']}: {problem}" for problem in row["problems"]]
    return "\n".join(lines)


def flat(row):
    """A row of docs/benchmarks: numbers and words only."""
    seconds = [change["s"] for change in row["changes"] if "to" in change]
    kept = {"program": row["program"], "suite": row["suite"], "run": row["mode"], "frames": row["frames"], "frames_s": row["frames_s"],
            "profiles": " > ".join(row["profiles"]), "hand_over_s": max(seconds[1:], default=None), "still_mm": row.get("still_mm"),
            "p95_mm": row.get("p95_mm"), "tracked": row.get("tracked"), "presses": row["presses"],
            "presses_true": row.get("presses_true"), "vibrations": row["haptics"], "validation": row["validation"],
            "validation_errors": row["validation_errors"], "problems": "; ".join(row["problems"])}
    return {key: value for key, value in kept.items() if value is not None and value != ""}
