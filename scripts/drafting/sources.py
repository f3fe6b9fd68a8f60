"""The files that the numbers come from."""
import json
import pathlib
import re
import tomllib
import types

ROOT = pathlib.Path(__file__).resolve().parents[2]
FILES = ("omni", "build", "marks", "room", "twin")  # of manifests/device
CODE = {  # name in a formula -> sources whose constants it has
    "firmware": ("firmware/core/link/settings.h", "firmware/core/safety/self_test.cc"),
    "layer": ("layer/src/spaces/base_pose.cc",),
    "scene": ("service/scene/reach.cc",),
    "tracker": ("service/tracker/tracker.h",),
}
PINS = "firmware/board/teensy40/chip/pins.h"


def text_of(path):
    return (ROOT / path).read_text(encoding="utf-8")


def tree(table):
    return json.loads(json.dumps(table), object_hook=lambda keys: types.SimpleNamespace(**keys))


def constants(paths):
    """Numbers that the sources give a name, by it."""
    found = re.findall(r"\b(?:float|double) (\w+) = ([-+.\de]+)F?;", "".join(map(text_of, paths)))
    return types.SimpleNamespace(**{name: float(value) for name, value in found})


def pins():
    """The Teensy's pins, by signal."""
    return {name: int(pin) for name, pin in re.findall(r"\{Signal::k(\w+), (\d+), Pad::", text_of(PINS))}


def read(folder):
    """Everything that a formula may name."""
    names = {name: tree(tomllib.loads((folder / f"{name}.toml").read_text(encoding="utf-8"))) for name in FILES}
    names |= {name: constants(paths) for name, paths in CODE.items()}
    names["firmware"].pin = pins()
    return names
