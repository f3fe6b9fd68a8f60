"""Debian roots with a runtime, the loader and programs that use them, and how to run a program in one.

A root lies in ${XDG_CACHE_HOME:-~/.cache}/omni/engines/SUITE and is used again until its list of packages changes."""
import os
import pathlib
import shutil
import subprocess
import sys

PACKAGES = {
    "trixie": "monado-service libopenxr1-monado libopenxr-loader1 libopenxr-utils openxr-layer-corevalidation mesa-vulkan-drivers",
    "sid": "monado-service libopenxr1-monado libopenxr-loader1 libopenxr-utils openxr-layer-corevalidation mesa-vulkan-drivers"
           " xvfb godot ffmpeg",
}
# What a table names; package -> word.
SHOWN = {"monado-service": "Monado", "libopenxr-loader1": "loader", "mesa-vulkan-drivers": "Mesa", "godot": "Godot"}
VALIDATION_FOLDER = "/usr/share/openxr/1/api_layers/explicit.d"


class Missing(Exception):
    """Something that the user has to provide; the text says what and how."""


def mirror():
    """The mirror of this computer's own apt, for whatever suite."""
    if shutil.which("apt-get"):
        listed = subprocess.run(["apt-get", "indextargets", "--format", "$(ORIGIN) $(SUITE) $(SITE) $(REPO_URI)", "Created-By: Packages"],
                                text=True, capture_output=True).stdout
        for line in listed.splitlines():
            words = line.split()
            if words and words[0] == "Debian" and "security" not in line:
                return words[-1]
    raise Missing("apt knows no Debian mirror: run `apt-get update`, on a Debian")


class Root:
    def __init__(self, suite, apt_options=()):
        cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache")
        self.suite = suite
        self.folder = cache / "omni/engines" / suite
        self.apt_options = apt_options

    def _stamp(self):
        return self.folder / "omni-packages"

    def ready(self):
        return self._stamp().is_file() and self._stamp().read_text().split() == PACKAGES[self.suite].split()

    def make(self):
        """Makes it, unless it is there."""
        if os.geteuid() != 0:
            raise Missing("needs root, for mounts and chroot: sudo")
        if self.ready():
            return
        if not shutil.which("mmdebstrap"):
            raise Missing("mmdebstrap is not installed: apt install mmdebstrap")
        print(f"making {self.folder} (once; some minutes)", file=sys.stderr)
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.parent.mkdir(parents=True, exist_ok=True)
        command = ["mmdebstrap", "--quiet", "--variant=minbase", '--aptopt=APT::Install-Recommends "false"']
        command += [f"--aptopt={option}" for option in self.apt_options]
        command += ["--include=" + ",".join(PACKAGES[self.suite].split()), self.suite, str(self.folder), mirror()]
        done = subprocess.run(command, text=True, capture_output=True)
        if done.returncode:
            last = "\n".join(done.stderr.strip().splitlines()[-5:])
            raise Missing(f"mmdebstrap: {last}" + ("\n(an old mirror: --apt-option 'Acquire::Check-Valid-Until \"false\"')"
                                                   if "expired" in done.stderr else ""))
        self._stamp().write_text(PACKAGES[self.suite] + "\n")

    def versions(self):
        """Word of SHOWN -> version of its package."""
        status = (self.folder / "var/lib/dpkg/status").read_text()
        found = {}
        for entry in status.split("\n\n"):
            fields = dict(line.split(": ", 1) for line in entry.splitlines() if ": " in line and not line.startswith(" "))
            if fields.get("Package") in SHOWN:
                found[SHOWN[fields["Package"]]] = fields["Version"]
        return found

    def start(self, argv, env, seen, **popen):
        """Runs argv in the root, where the folders of `seen` are under the same paths as outside. All that it starts ends
        with its process group."""
        mounts = [f'mount --bind {path} "$root{path}"' for path in seen]
        for path in seen:
            (self.folder / str(path).lstrip("/")).mkdir(parents=True, exist_ok=True)
        script = "\n".join(["set -e", 'root=$1; shift', 'mount --rbind /dev "$root/dev"', 'mount -t proc proc "$root/proc"', *mounts,
                            'exec /usr/sbin/chroot "$root" "$@"'])
        environment = {"PATH": "/usr/bin:/bin:/usr/sbin:/usr/games", "LC_ALL": "C.UTF-8",
                       "VK_DRIVER_FILES": "/usr/share/vulkan/icd.d/lvp_icd.json", **env}
        return subprocess.Popen(["unshare", "-m", "sh", "-c", script, "sh", str(self.folder), *argv], env=environment,
                                start_new_session=True, **popen)
