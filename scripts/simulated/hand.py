"""Leads the hand of the digital twin (service/protocol/hand_aim.h), and reads what the twin itself recorded."""
import bisect
import csv
import math
import socket
import struct
import time

MAGIC, VERSION = 0x41484D4F, 1
ABOVE = (0.0, 0.0, 0.075)   # of the base: over the scene, in the air
DOWN = (0.0, 0.0, -1.0)


def circling(seconds, radius_m=0.008, turns_s=0.2):
    """A place near ABOVE, where a hand that waits is."""
    angle = 2 * math.pi * turns_s * seconds
    return (ABOVE[0] + radius_m * math.cos(angle), ABOVE[1] + radius_m * math.sin(angle), ABOVE[2])


def packet(tip_m, axis=DOWN, present=True):
    return struct.pack("<4I6d", MAGIC, VERSION, 1 if present else 0, 0, *tip_m, *axis)


class Hand:
    """An arm goes smoothly to the newest aim, so that aims may come at any rate."""

    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.socket.connect(str(path))

    def aim(self, tip_m, axis=DOWN, present=True):
        self.socket.send(packet(tip_m, axis, present))

    def away(self):
        self.aim(ABOVE, present=False)

    def move(self, start, end, seconds, meanwhile=lambda: None):
        """Along a line, at rest at both ends."""
        begin = time.monotonic()
        while True:
            part = min(1.0, (time.monotonic() - begin) / seconds)
            smooth = part * part * (3 - 2 * part)
            self.aim([a + smooth * (b - a) for a, b in zip(start, end)])
            meanwhile()
            if part == 1:
                return
            time.sleep(0.01)

    def close(self):
        self.socket.close()


class Truth:
    """The twin's record: where the pen was, and what pushed it."""

    def __init__(self, path):
        self.t, self.tip, self.axis, self.speed, self.force, self.present = [], [], [], [], [], []
        with open(path, newline="") as file:
            for row in csv.DictReader(file):
                if None in row.values() or None in row:
                    continue  # the last line of a record that still grows
                vector = lambda name, unit: tuple(float(row[f"{name}_{axis}{unit}"]) for axis in "xyz")
                self.t.append(int(row["t_ns"]))
                self.tip.append(vector("tip", "_m"))
                self.axis.append(vector("axis", ""))
                self.speed.append(math.dist(vector("velocity", "_m_s"), (0, 0, 0)))
                self.force.append(math.dist(vector("coil_force", "_N"), (0, 0, 0)))
                self.present.append(row["present"] == "1")

    def at(self, t_ns):
        """Index of the tick at a time; None: outside the record, or no pen."""
        index = bisect.bisect_left(self.t, t_ns)
        if index == len(self.t) or self.t[index] - t_ns > 5_000_000 or not self.present[index]:
            return None
        return index

    def presses(self, over_N=0.15, under_N=0.08, apart_ns=250_000_000):
        """How often the tip was pressed, by omnid's default thresholds. A vibration under the tip is no release."""
        count, pressed_at = 0, None
        for t, force in zip(self.t, self.force):
            if pressed_at is None or t - pressed_at > apart_ns:
                if force > over_N:
                    count, pressed_at = count + 1, t
            elif force > under_N:
                pressed_at = t
        return count


class Growing:
    """The newest force in a record of the twin that is still written."""

    def __init__(self, path):
        self.file = open(path, "rb")
        self.names = None
        self.rest = b""
        self.force = None

    def newest(self):
        """(x, y, z) in N, in the base's axes; None: no row yet."""
        *lines, self.rest = (self.rest + self.file.read()).split(b"\n")
        if lines and self.names is None:
            self.names = lines.pop(0).decode().split(",")
        if lines:
            row = dict(zip(self.names, lines[-1].decode().split(",")))
            self.force = tuple(float(row[f"coil_force_{axis}_N"]) for axis in "xyz")
        return self.force


def pulses(path):
    """How many vibrations the loop has played: the last line of omnid's record that is whole."""
    last = 0
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            if None not in row.values():
                last = int(row["haptic_pulses"])
    return last
