"""What a run needs beside the program: Monado with simulated devices, omnid with the digital twin, a folder for sockets and records."""
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time

from simulated import hand, roots

ROOT = pathlib.Path(__file__).resolve().parents[2]
SYSTEM = ("Monado(XRT)", "Monado: Simulated HMD")
# Where the base stands in STAGE: on a desk before the simulated headset. z of the base is y of STAGE.
BASE_STAGE_m = (0.1, 0.74, -0.5)
BASE_STAGE_wxyz = (0.7071067811865476, -0.7071067811865476, 0.0, 0.0)
# Where Monado's simulated controllers are, which never move.
CONTROLLER_STAGE_m = {"left": (-0.2, 1.3, -0.5), "right": (0.2, 1.3, -0.5)}
SIMULATED = {"XRT_COMPOSITOR_NULL": "1", "SIMULATED_ENABLE": "1", "SIMULATED_LEFT": "simple", "SIMULATED_RIGHT": "simple"}
OURS, WITNESS, VALIDATION = "XR_APILAYER_OMNI_stylus", "XR_APILAYER_OMNI_witness", "XR_APILAYER_LUNARG_core_validation"


def stage_of(point_base_m):
    x, y, z = point_base_m
    return (BASE_STAGE_m[0] + x, BASE_STAGE_m[1] + z, BASE_STAGE_m[2] - y)


def wait_until(condition, seconds, step_s=0.05):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(step_s)
    return bool(condition())


def end_process(process, seconds=5):
    """SIGTERM to the whole group, and SIGKILL to what ignores it."""
    for number in (signal.SIGTERM, signal.SIGKILL):
        if process.poll() is None:
            try:
                os.killpg(process.pid, number)
                process.wait(seconds)
            except (ProcessLookupError, subprocess.TimeoutExpired):
                pass
    return process.poll()


class Stand:
    """Logs and records stay in `folder`, which is emptied first; sockets do not."""

    def __init__(self, root, built, folder, validation=None, with_layer=True):
        self.root, self.built, self.folder = root, built, pathlib.Path(folder)
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        self.run = pathlib.Path(tempfile.mkdtemp(prefix="omni-engines-"))  # short: paths of sockets
        (self.run / "omni").mkdir(mode=0o700)
        self.validation, self.with_layer = validation, with_layer  # validation: None, "above" or "below"
        self.processes = []
        self.service = self.monado = None
        self._display, self._xauthority = "", ""
        self._shared = set()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in reversed(self.processes):
            end_process(process)
        shutil.rmtree(self.run, ignore_errors=True)

    def seen(self):
        """Real folders that programs in the root reach, each once and none within another."""
        wanted = {ROOT, self.run, self.folder.resolve(), *self._shared}
        wanted |= {(self.built / name).resolve() for name in ("bin", "lib", "share", "share/openxr/1/api_layers/explicit.d")}
        wanted |= {self.built.absolute()}
        return [path for path in sorted(wanted) if not any(path != other and other in path.parents for other in wanted)]

    def log(self, name):
        return open(self.folder / f"{name}.txt", "wb")

    def start(self, name, argv, env=None, **popen):
        """A program in the root, whose /root keeps compiled shaders."""
        own = {"HOME": "/root", "XDG_RUNTIME_DIR": str(self.run), **(env or {})}
        with self.log(name) as log:
            process = self.root.start(argv, own, self.seen(), stdout=log, stderr=subprocess.STDOUT, **popen)
        self.processes.append(process)
        return process

    def start_monado(self):
        self.monado = self.start("monado", ["monado-service"], SIMULATED, stdin=subprocess.PIPE)  # it ends at the end of its input
        if not wait_until(lambda: (self.run / "monado_comp_ipc").exists() and "service has started" in self.output("monado"), 30):
            raise roots.Missing(f"Monado did not start: {self.folder}/monado.txt")

    def use_display(self, display, xauthority):
        """A person's X display: its socket and its key."""
        self._display = display
        self._shared.add(pathlib.Path("/tmp/.X11-unix"))
        if xauthority and os.path.exists(xauthority):
            self._xauthority = str(shutil.copy(xauthority, self.run / "xauthority"))

    def display(self):
        """The environment of a window; without a person's display, of an X server without a screen in the root."""
        if self._display:
            return {"DISPLAY": self._display, **({"XAUTHORITY": self._xauthority} if self._xauthority else {})}
        process = self.start("display", ["Xvfb", "-displayfd", "1", "-screen", "0", "1024x768x24"])
        numbers = lambda: re.findall(r"^(\d+)$", self.output("display"), re.M)
        if not wait_until(lambda: numbers() or process.poll() is not None, 20) or not numbers():
            raise roots.Missing(f"Xvfb did not start: {self.folder}/display.txt")
        return {"DISPLAY": ":" + numbers()[0]}

    def output(self, name):
        """What a program has printed."""
        return (self.folder / f"{name}.txt").read_text(errors="replace")

    def program_environment(self, witness):
        """What the loader needs: which layers, in which order from the program down."""
        order = [WITNESS, OURS] if self.with_layer else [WITNESS]
        order = {"above": [VALIDATION, *order], "below": [*order, VALIDATION], None: order}[self.validation]
        layers = self.built / "share/openxr/1/api_layers"
        return {"OMNI_SOCKET": str(self.run / "omni/omnid.sock"), "OMNI_WITNESS_FILE": str(witness),
                "XR_RUNTIME_JSON": "/usr/share/openxr/1/openxr_monado.json",
                "XR_API_LAYER_PATH": f"{layers / 'explicit.d'}:{layers / 'witness.d'}:{roots.VALIDATION_FOLDER}",
                "XR_ENABLE_API_LAYERS": ":".join(order), "XR_CORE_VALIDATION_EXPORT_TYPE": "text",
                "XR_CORE_VALIDATION_FILE_NAME": str(self.folder / "validation.txt")}

    def validation_errors(self):
        """core_validation makes its file at the first error."""
        file = self.folder / "validation.txt"
        return file.read_text(errors="replace").count("VALID_ERROR") if file.exists() else 0

    # The service, outside the root: it is a program of this computer.

    def write_settings(self, application, scene):
        config = self.run / "config/omni"
        (config / "apps.d").mkdir(parents=True)
        (config / "apps.d/10-engines.toml").write_text(f'application = "{application}"\nscene = "{scene}"\n')
        alignment = (f'format = 1\n\n[[alignments]]\nruntime = "{SYSTEM[0]}"\nsystem = "{SYSTEM[1]}"\nspace = 3\n'
                     f'position_space_m = {list(BASE_STAGE_m)}\norientation_space_wxyz = {list(BASE_STAGE_wxyz)}\n'
                     'method = "touch"\ndate = "2026-01-01"\nsamples = 1\nrms_mm = 0.0\nexpected_error_mm = 1.0\n'
                     'rotation_deg = 0.0\nrecentred = 0\n')
        (config / "alignments.toml").write_text(alignment)
        first = {"name": "engines", "repeat": False,
                 "hand": {"stiffness_N_m": 200, "damping_Ns_m": 3, "mass_kg": 0.12, "tremor_m": 5e-5},
                 "waypoints": [{"s": 1, "tip_m": list(hand.ABOVE), "axis": list(hand.DOWN), "present": False}]}
        (self.run / "hand.json").write_text(json.dumps(first))

    def start_service(self):
        """omnid on the twin, with a hand that this process leads. The pen is away."""
        environment = {**os.environ, "OMNI_SOCKET": str(self.run / "omni/omnid.sock"), "XDG_CONFIG_HOME": str(self.run / "config"),
                       "XDG_STATE_HOME": str(self.run / "state"), "XDG_CACHE_HOME": str(self.run / "cache")}
        with self.log("omnid") as log:
            self.service = subprocess.Popen(
                [str(self.built / "bin/omnid"), "--device", "twin", "--twin-script", str(self.run / "hand.json"),
                 "--twin-hand", str(self.run / "omni/hand.sock"), "--twin-record", str(self.folder / "truth.csv"),
                 "--record", str(self.folder / "loop.csv"), "--replace"],
                env=environment, stdout=log, stderr=subprocess.STDOUT, start_new_session=True)
        self.processes.append(self.service)
        if not wait_until(lambda: (self.run / "omni/hand.sock").exists() and (self.run / "omni/omnid.sock").exists(), 30):
            raise roots.Missing(f"omnid did not start: {self.folder}/omnid.txt")
        return hand.Hand(self.run / "omni/hand.sock")

    def stop_service(self):
        if self.service:
            end_process(self.service)
