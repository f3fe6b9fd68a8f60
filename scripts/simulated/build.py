"""Builds what scripts/engines and scripts/headset run."""
import subprocess

from simulated import stand

TARGETS = ["XrApiLayer_omni", "XrApiLayer_omni_witness", "omnid", "omni-twin", "omni_probe", "omni_touch"]


def build():
    subprocess.run([stand.ROOT / "scripts/setup", "demo"], check=True)
    subprocess.run([stand.ROOT / "scripts/configure", "release", "tests"], check=True)
    subprocess.run(["cmake", "--build", "--preset", "release", "--target", *TARGETS], cwd=stand.ROOT, check=True)
    return stand.ROOT / "build/release"
