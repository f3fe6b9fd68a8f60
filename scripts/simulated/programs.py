"""The programs, and what their actions mean. Facts about others' programs are from their sources: hello_xr of OpenXR-SDK-Source."""
from dataclasses import dataclass


@dataclass(frozen=True)
class Program:
    name: str
    package: str      # of Debian; empty: ours
    suites: tuple
    argv: tuple       # {built}, {run}: folders
    poses: dict       # action -> "tip" or "grip", what it is bound to
    select: tuple     # actions of which one is a press
    graphics: bool    # it submits frames
    project: str = ""  # a folder of ours that is copied to {run}/project first: the program writes into it


PROGRAMS = (
    Program("hello_xr", "libopenxr-utils", ("trixie", "sid"), ("hello_xr", "-g", "Vulkan2"), {"hand_pose": "grip"},
            ("grab_object",), True),
    Program("omni_touch", "", ("trixie", "sid"), ("{built}/bin/omni_touch", "--seconds", "600"), {"pose": "tip"},
            ("select", "force"), False),
    # Its default action map; default_pose is the aim of every profile. It needs a window beside the headset.
    Program("Godot", "godot", ("sid",),
            ("godot", "--path", "{run}/project", "--rendering-method", "mobile", "--audio-driver", "Dummy"),
            {"default_pose": "tip", "aim_pose": "tip", "grip_pose": "grip"}, ("trigger", "select_button"), True, "tests/engines/godot"),
)
