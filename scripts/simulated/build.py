"""Builds what scripts/engines and scripts/headset run."""
import os
import subprocess

from simulated import stand

TARGETS = ["XrApiLayer_omni", "XrApiLayer_omni_witness", "omnid", "omni-twin", "omni_probe", "omni_touch"]


def build():
    """As the person who called sudo, whose build tree it is."""
    person = ["sudo", "-u", os.environ["SUDO_USER"]] if os.environ.get("SUDO_USER") else []
    for words in (["scripts/setup", "demo"], ["scripts/configure", "release", "tests"],
                  ["cmake", "--build", "--preset", "release", "--target", *TARGETS]):
        subprocess.run([*person, *words], cwd=stand.ROOT, check=True)
    return stand.ROOT / "build/release"
