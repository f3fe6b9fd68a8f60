"""scripts/drawings and docs/howto/build-a-base.md: drawings as of their numbers, and every number as of its source."""
import importlib.machinery
import importlib.util
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import types
import unittest
import xml.etree.ElementTree as xml

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT, DEVICE, DRAWN = ROOT / "scripts/drawings", ROOT / "manifests/device", ROOT / "docs/drawings"
PAGE = ROOT / "docs/howto/build-a-base.md"
SHEET, SCALES = (297, 210), {"coil-former": 2, "hull": 1, "sensors": 0.5, "pen": 1}
DRAWINGS = (*SCALES, "wiring", "set-up")
KEY = re.compile(r"\b(omni|build|marks|room|twin|firmware|layer|scene|tracker)((?:\.\w+|\[\w+\])+)")
CODE = {"layer": ("layer/src/spaces/base_pose.cc", ("kInFront_m", "kBelow_m")),
        "scene": ("service/scene/reach.cc", ("kReach_m",)), "tracker": ("service/tracker/tracker.h", ("reach_max_m",))}
NOT_BUILT = {"set-up": "Nothing here has been built with this firmware yet: simulated."}
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "scripts"))
loader = importlib.machinery.SourceFileLoader("drawings", str(SCRIPT))
drawings = importlib.util.module_from_spec(importlib.util.spec_from_loader("drawings", loader))
loader.exec_module(drawings)


def run(*arguments):
    command = [sys.executable, str(SCRIPT), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def tables():
    found = {name: tomllib.loads((DEVICE / f"{name}.toml").read_text(encoding="utf-8"))
             for name in ("omni", "build", "marks", "room", "twin")}
    for name, (path, keys) in CODE.items():
        source = (ROOT / path).read_text(encoding="utf-8")
        found[name] = {key: float(re.search(rf"double {key} = ([\d.]+);", source)[1]) for key in keys}
    return found


def steps(path):
    """".sensors[0].position_base_m[2]" -> sensors, 0, position_base_m, 2."""
    return [int(part[1:-1]) if part[0] == "[" else part[1:] for part in re.findall(r"\.\w+|\[\w+\]", path)]


def reach(table, path):
    for step in path:
        table = table[step]
    return table


def rows():
    return [line.split("\t") for line in run("--list").stdout.splitlines()]


# -- the numbers once more: other formulas than the script's where there are any --------------------------------------

class Again:
    def __init__(self):
        self.raw = tables()
        self.omni, self.build, self.twin = self.raw["omni"], self.raw["build"], self.raw["twin"]
        settings = "".join((ROOT / "firmware/core" / name).read_text(encoding="utf-8")
                           for name in ("link/settings.h", "safety/self_test.cc"))
        named = {name: json.loads(json.dumps(table), object_hook=lambda keys: types.SimpleNamespace(**keys))
                 for name, table in self.raw.items()}
        named["firmware"] = types.SimpleNamespace(**{
            key: float(re.search(rf"\bfloat {key} = ([\d.]+)", settings)[1])
            for key in ("power_max_W", "supply_min_V", "supply_max_V", "kMeasuredTolerance")})
        functions = {name: getattr(self, name) for name in dir(self) if not name.startswith("_")}
        self._names = {**functions, **named, "sqrt": math.sqrt, "hypot": math.hypot, "pi": math.pi, "sum": sum,
                       "range": range}
        self._L = {}

    def __call__(self, formula, k=None):
        return eval(formula, {"__builtins__": {}, **self._names, "k": k})  # formulas of our own files

    def pitch_m(self):
        return (self.omni["coils"][0]["shell_radius_max_m"] - self.omni["coils"][0]["shell_radius_min_m"]) / 18

    def shell_m(self, k, layer):
        return self.omni["coils"][k]["shell_radius_min_m"] + self.pitch_m() * (3 * layer + k) + self.pitch_m() / 2

    def turns_in(self, k, layer):
        fewest, more = divmod(self.omni["coils"][k]["turns"], 6)
        return fewest + (1 if layer + more >= 6 else 0)

    def _edge(self, k, layer):
        arc = self.build["former"]["turn_pitch_m"] * self.turns_in(k, layer)
        return arc / self.shell_m(k, layer) / 2

    def edge_m(self, k, layer):
        return self.shell_m(k, layer) * math.sin(self._edge(k, layer))

    def edge_radius_m(self, k, layer):
        return math.sqrt(self.shell_m(k, layer) ** 2 - self.edge_m(k, layer) ** 2)

    def _places(self, k, model):
        """Latitude of every turn on its shell: (R, angle)."""
        places, band = [], self.omni["coils"][k]["band_half_width_m"]
        for layer in range(6):
            R, n = self.shell_m(k, layer), self.turns_in(k, layer)
            for i in range(n):
                if model:
                    places.append((R, math.asin((-band + (i + 0.5) * 2 * band / n) / R)))
                else:
                    places.append((R, (i - (n - 1) / 2) * self.build["former"]["turn_pitch_m"] / R))
        return places

    def length_m(self, k):
        return sum(2 * math.pi * R * math.cos(angle) for R, angle in self._places(k, False))

    def model_length_m(self, k):
        return sum(2 * math.pi * R * math.cos(angle) for R, angle in self._places(k, True))

    def _inductances(self, k, model):
        """Neumann's integral for each pair; the core by its orders, with Legendre's polynomials written out."""
        if (k, model) in self._L:
            return self._L[k, model]
        turns = [(R * math.cos(angle), R * math.sin(angle)) for R, angle in self._places(k, model)]
        half = 100
        cosines = [math.cos(math.pi * (i + 0.5) / half) for i in range(half)]
        air = 0.0
        for i, (r, y) in enumerate(turns):
            air += 4e-7 * math.pi * r * (math.log(8 * r / (self.build["wire"]["bare_m"] / 2)) - 1.75)  # a round wire
            for s, z in turns[:i]:
                p, q = r * r + s * s + (y - z) ** 2, 2 * r * s
                air += 2 * 4e-7 * math.pi * r * s * math.pi / half * sum(c / math.sqrt(p - q * c) for c in cosines)
        slopes = {1: lambda x: 1, 3: lambda x: (15 * x ** 2 - 3) / 2,
                  5: lambda x: (315 * x ** 4 - 210 * x ** 2 + 15) / 8}
        core, a, kappa = 0.0, self.omni["core"]["core_radius_m"], self.omni["core"]["core_kappa"]
        mu_r = (1 + 2 * kappa) / (1 - kappa)
        for l, slope in slopes.items():
            b = sum(2e-7 * math.pi * r * r * slope(z / math.hypot(r, z)) / math.hypot(r, z) ** (l + 2)
                    for r, z in turns)
            core += l * (mu_r - 1) / (l * mu_r + l + 1) * 1e7 * b * b * a ** (2 * l + 1) / (l * l)
        self._L[k, model] = air, core
        return air, core

    def inductance_H(self, k):
        return sum(self._inductances(k, False))

    def model_inductance_H(self, k):
        return sum(self._inductances(k, True))

    def inductance_at_H(self, k, Hz):
        air, core = self._inductances(k, False)
        w = self.twin["core"]["core_permeability"] / (4e-7 * math.pi * self.twin["core"]["core_conductivity_S_m"] *
                                                       self.omni["core"]["core_radius_m"] ** 2)
        x = math.sqrt(math.pi * Hz / w)  # sqrt(s/w) = x + j x
        return air + core * ((1 - x / 2) * (1 + x) - x * x / 2) / ((1 + x) ** 2 + x * x)

    def resistance_ohm(self, k, C):
        return self.omni["coils"][k]["resistance_20C_ohm"] * (1 + 0.00393 * (C - 20))

    def _section(self):
        return math.pi * (self.build["wire"]["bare_m"] / 2) ** 2

    def wire_ohm(self, k, C):
        length = self.length_m(k) + 2 * self.build["wire"]["lead_m"]
        return 1 / 58e6 * (1 + 0.00393 * (C - 20)) * length / self._section()

    def mass_kg(self, k):
        return self.build["wire"]["density_kg_m3"] * self._section() * self.length_m(k)

    def hot_C(self, k, from_C, s):
        T, count = from_C, 20000
        for _ in range(count):
            power_W = self.omni["limits"]["supply_V"] ** 2 / self.resistance_ohm(k, T)
            T += s / count * power_W / self.omni["heat"]["copper_J_K"]
        return T

    def duty(self, k, A, C):
        return A * self.resistance_ohm(k, C) / self.omni["limits"]["supply_V"]

    def lean(self):
        """By bisection: the pen is turned until the nib is as deep in the hull as the rim."""
        magnet, R = self.omni["magnet"], self.omni["hull"]["hull_radius_m"]
        b, nib = magnet["half_height_m"], magnet["tip_offset_m"] - magnet["half_height_m"]

        def centre(angle):  # distance of the magnet's centre at which the rim touches: |centre + rim| = R
            x = magnet["radius_m"] * math.cos(angle) - b * math.sin(angle)
            y = -magnet["radius_m"] * math.sin(angle) - b * math.cos(angle)
            return math.sqrt(R * R - x * x) - y

        low, high = 0.0, 1.0
        for _ in range(60):
            angle = (low + high) / 2
            d = centre(angle)
            deep = R + nib - math.hypot(b * math.sin(angle), d - b * math.cos(angle))
            low, high = (angle, high) if deep > 0 else (low, angle)
        return angle, centre(angle)


# -- a reader of DXF --------------------------------------------------------------------------------------------------

def read_dxf(text):
    """(kind, {code: value}) of every entity."""
    lines = text.split("\n")
    assert lines.pop() == "" and len(lines) % 2 == 0, "codes and values come in pairs"
    pairs = [(int(code), value) for code, value in zip(lines[::2], lines[1::2])]
    assert pairs[-1] == (0, "EOF") and (1, "AC1009") in pairs
    entities, inside = [], False
    for code, value in pairs:
        if code == 2 and value == "ENTITIES":
            inside = True
        elif code == 0 and value == "ENDSEC":
            inside = False
        elif inside and code == 0:
            entities.append((value, {}))
        elif inside:
            entities[-1][1][code] = value
    return entities, {value for code, value in pairs if code == 2}


class Drawings(unittest.TestCase):
    def test_committed_ones_are_those_of_the_numbers(self):
        done = run("--check")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(sorted(path.name for path in DRAWN.iterdir()),
                         sorted([*(f"{name}.svg" for name in DRAWINGS), *(f"{name}.dxf" for name in SCALES)]))

    def test_sources_exist_and_values_are_theirs(self):
        raw, again = tables(), Again()
        listed = rows()
        self.assertGreater(len(listed), 150)
        self.assertEqual({row[0] for row in listed}, set(DRAWINGS))
        for drawing, name, value, formula in listed:
            keys = KEY.findall(formula)
            self.assertTrue(keys or "(" in formula, (drawing, name, formula))
            for table, path in keys:
                reach(raw[table], steps(path))  # KeyError: there is no such key
            number, _, unit = value.partition(" ")
            wanted = again(formula) * {"mm": 1e3, "deg": 180 / math.pi, "": 1}[unit]
            delta = max(6e-4, 1e-3 * abs(wanted) if "inductance" in formula else 0)
            self.assertAlmostEqual(float(number), wanted, delta=delta, msg=name)

    def test_each_key_changes_what_names_it(self):
        before = {(row[0], row[1]): (row[2], row[3]) for row in rows()}
        keys = {(table, path) for _, formula in before.values() for table, path in KEY.findall(formula)
                if table in ("build", "marks", *CODE)}
        keys |= {("omni", ".hull.hull_radius_m"), ("omni", ".magnet.tip_offset_m"), ("omni", ".core.core_radius_m")}
        for table, path in sorted(keys):
            facts, way = drawings.Facts(DEVICE), steps(path)
            node = facts.names[table]
            for step in way[:-1]:
                node = node[step] if isinstance(step, int) else getattr(node, step)
            value = reach(tables()[table], way)
            if isinstance(way[-1], int):
                node[way[-1]] = value * 1.01
            else:
                setattr(node, way[-1], value * 1.01)
            sheets = [drawing.draw(facts) for drawing in drawings.DRAWINGS]
            after = {(drawing, name): drawings.number(new) for s in sheets for drawing, name, new, _, _ in s.rows}
            for key, (before_it, formula) in before.items():
                if table + path in formula and value != 0:
                    self.assertNotEqual(after[key], before_it.split()[0], (table + path, key))

    def test_a_changed_file_changes_the_drawing(self):
        with tempfile.TemporaryDirectory() as folder:
            source, out = pathlib.Path(folder) / "device", pathlib.Path(folder) / "out"
            shutil.copytree(DEVICE, source)
            text = (source / "omni.toml").read_text(encoding="utf-8")
            (source / "omni.toml").write_text(text.replace("hull_radius_m = 0.0375", "hull_radius_m = 0.0385"))
            self.assertEqual(run("--from", source, "--to", out).returncode, 0)
            self.assertIn("R38.5", (out / "hull.svg").read_text(encoding="utf-8"))
            self.assertIn("R37.5", (DRAWN / "hull.svg").read_text(encoding="utf-8"))
            stale = run("--check", "--from", source)
            self.assertEqual(stale.returncode, 1)
            for name in ("hull.svg", "hull.dxf", "pen.svg", "sensors.svg", "set-up.svg"):
                self.assertIn(name, stale.stderr)
            self.assertNotIn("coil-former", stale.stderr)
            self.assertEqual(run("--check", "--from", source, "--to", out).returncode, 0)
            self.assertEqual(run("--to").returncode, 2)

    def test_a_distance_that_is_not_its_formula_is_refused(self):
        facts = drawings.Facts(DEVICE)
        view = drawings.hull.Sheet(facts, "test", 1).view(50, 50)
        view.across("core", "2 * omni.core.core_radius_m", -15, 15, 0, 20)
        with self.assertRaisesRegex(ValueError, "core is 30 mm, but drawn as 31 mm"):
            view.across("core", "2 * omni.core.core_radius_m", -15, 16, 0, 20)

    def test_svg_is_xml_and_no_texts_overlap(self):
        for path in sorted(DRAWN.glob("*.svg")):
            text = path.read_text(encoding="utf-8")
            root = xml.fromstring(text)
            _, _, wide, high = map(float, root.get("viewBox").split())
            boxes = []
            for element in root.iter("{http://www.w3.org/2000/svg}text"):
                x, y, size = (float(element.get(key)) for key in ("x", "y", "font-size"))
                width = 0.6 * size * len(element.text)
                x -= {"start": 0, "middle": width / 2, "end": width}[element.get("text-anchor")]
                boxes.append((x, y - 0.75 * size, x + width, y + 0.2 * size, element.text))
            self.assertGreater(len(boxes), 15, path.name)
            for i, (left, top, right, bottom, words) in enumerate(boxes):
                self.assertTrue(4 < left and right < wide - 4 and 4 < top and bottom < high - 4, (path.name, words))
                for l, t, r, b, other in boxes[:i]:
                    self.assertFalse(left < r and l < right and top < b and t < bottom, (path.name, words, other))
            self.assertIn('fill="#ffffff"', text)
            self.assertIn(NOT_BUILT.get(path.stem, "not built yet, simulated only"), text)

    def test_the_set_up_says_what_the_pages_say(self):
        text = (DRAWN / "set-up.svg").read_text(encoding="utf-8")
        for words, page, same in (("Other magnets: a metre away", "calibrate", "other magnets a metre away"),
                                  (">450 mm in front of you<", "align", "0.45 m in front"),
                                  (">350 mm<", "align", "0.35 m below")):
            self.assertIn(words, text)
            self.assertIn(same, " ".join((ROOT / f"docs/howto/{page}.md").read_text(encoding="utf-8").split()))

    def test_the_pen_of_the_set_up_hovers(self):
        """Its magnet is outside the hull and within the forces' reach."""
        facts, set_up = drawings.Facts(DEVICE), drawings.set_up
        polygons = [item for item in set_up.draw(facts).items if item[0] == "polygon"]
        magnet = next(points for _, _, points, fill in polygons if fill == "accent")
        for x, y in magnet:
            up_mm = math.dist((x, y), set_up.CORE) / set_up.SCALE - facts.mm("omni.hull.hull_radius_m")
            self.assertTrue(1 < up_mm < facts.mm("scene.kReach_m"), up_mm)

    def test_dxf_parses_and_lies_within_its_sheet(self):
        for name, scale in SCALES.items():
            entities, names = read_dxf((DRAWN / f"{name}.dxf").read_text(encoding="utf-8"))
            self.assertGreater(len(entities), 50)
            for kind, values in entities:
                self.assertIn(kind, ("LINE", "CIRCLE", "ARC", "TEXT"))
                self.assertIn(values[8], names)  # its layer is in the table
                reach_mm = float(values[40]) if kind == "CIRCLE" else 0.0
                self.assertGreaterEqual(reach_mm, 0)
                for code in (10, 20, 11, 21):
                    if code not in values:
                        self.assertIn(kind, ("CIRCLE", "ARC", "TEXT"))
                        self.assertIn(code, (11, 21))
                        continue
                    number, limit = float(values[code]), SHEET[code // 20] / scale
                    self.assertTrue(math.isfinite(number) and reach_mm <= number <= limit - reach_mm + 1e-3,
                                    (name, kind, values))
                if kind == "ARC":
                    self.assertTrue(float(values[40]) > 0 and all(0 <= float(values[code]) < 360 for code in (50, 51)))
                if kind == "TEXT":
                    self.assertTrue(values[1].isascii() and values[1], values)

    def test_dxf_has_the_size_of_the_part(self):
        omni = tables()["omni"]
        read = lambda name: read_dxf((DRAWN / f"{name}.dxf").read_text(encoding="utf-8"))[0]
        radii = {name: [float(values[40]) for kind, values in read(name) if kind in ("CIRCLE", "ARC")]
                 for name in SCALES}
        for name, value in (("hull", omni["hull"]["hull_radius_m"]), ("sensors", omni["hull"]["hull_radius_m"]),
                            ("pen", omni["hull"]["hull_radius_m"]), ("coil-former", omni["core"]["core_radius_m"])):
            self.assertIn(1e3 * value, radii[name], name)
        wires = radii["coil-former"].count(1e3 * tables()["build"]["wire"]["outer_m"] / 2)
        self.assertEqual(wires, 2 * (omni["coils"][0]["turns"] + omni["coils"][2]["turns"]))

    def test_pins_are_those_of_the_firmware(self):
        source = (ROOT / "firmware/board/teensy40/chip/pins.h").read_text(encoding="utf-8")
        text = (DRAWN / "wiring.svg").read_text(encoding="utf-8")
        pin = lambda signal: re.search(rf"Signal::k{signal}, (\d+),", source)[1]
        for k in range(3):
            for words in (f"PWM {pin(f'BridgePwm{k}')}, DIR {pin(f'BridgeDirection{k}')}",
                          f"SLP {pin(f'BridgeAwake{k}')}", f"FLT {pin(f'CoilFault{k}')}, with ALERT"):
                self.assertIn(f">{words}<", text)
        self.assertIn(f">2: pin {pin('EmergencyStop')} to ground<", text)

    def test_the_copper_fits(self):
        """Radially; and the turns of a layer within its caps, beside each other along the sphere."""
        again = Again()
        outer = again.build["wire"]["outer_m"]
        self.assertLess(outer + again.build["former"]["tape_m"], again.pitch_m())
        for k in range(3):
            for layer in range(6):
                arc = 2 * again.shell_m(k, layer) * math.asin(again.edge_m(k, layer) / again.shell_m(k, layer))
                self.assertGreater(arc, again.turns_in(k, layer) * outer)
        self.assertLess(again.omni["coils"][0]["shell_radius_max_m"],
                        again.omni["hull"]["hull_radius_m"] - again.build["hull"]["wall_m"])

    def test_the_fuse_blows_by_a_short_not_by_work(self):
        again = Again()
        supply, limits = again.build["supply"], again.omni["limits"]
        for k in range(3):
            carried = again.duty(k, limits["current_max_A"], limits["temperature_derate_C"]) * limits["current_max_A"]
            self.assertLess(carried, supply["fuse_hold_share"] * supply["fuse_A"])
            short = limits["supply_V"] / again.resistance_ohm(k, limits["temperature_max_C"])
            self.assertGreater(short, supply["fuse_share"] * supply["fuse_A"])
            self.assertLess(again.hot_C(k, limits["temperature_max_C"], supply["fuse_open_s"]),
                            again.build["wire"]["enamel_C"])


class Page(unittest.TestCase):
    UNITS = {"mm": 1e3, "mH": 1e3, "mT": 1e3, "g": 1e3, "uF": 1e6, "%": 100, "deg": 180 / math.pi}
    PLAIN = {"A", "A/s", "V", "W", "ohm", "m", "K/s", "C", "s", "J", ""}

    def sourced(self):
        """(line, value cell, formula) of every table row that names a formula."""
        heading = None
        for number, line in enumerate(PAGE.read_text(encoding="utf-8").splitlines(), 1):
            cells = [cell.strip() for cell in line.strip().strip("|").split("|")] if line.startswith("|") else None
            if cells is None:
                heading = None
            elif heading is None:
                heading = cells
            elif heading[-1] == "from" and cells[-1].startswith("`"):
                place = next(i for i, name in enumerate(heading) if name in ("value", "size", "x / y / z"))
                yield number, cells[place], cells[-1].strip("`")

    def test_numbers_are_those_of_their_sources(self):
        raw, again, found = tables(), Again(), list(self.sourced())
        self.assertGreater(len(found), 60)
        for line, cell, formula in found:
            for table, path in KEY.findall(formula.replace("[k]", "[0]")):
                if table != "firmware":
                    reach(raw[table], steps(path))
            match = re.fullmatch(r"([-\d. /]+?) ?([a-zA-Z%][a-zA-Z/]*)?", cell)
            self.assertTrue(match, (line, cell))
            unit = match[2] or ""
            self.assertTrue(unit in self.UNITS or unit in self.PLAIN, (line, unit))
            numbers = match[1].split(" / ")
            per_coil = re.search(r"\bk\b(?! in)", re.sub(r"sum\(\[.*?\]\)", "", formula))
            self.assertEqual(len(numbers), 3 if per_coil else 1, (line, formula))
            for k, written in enumerate(numbers):
                value = again(formula, k) * self.UNITS.get(unit, 1)
                digits = len(written.partition(".")[2])
                step = 10.0 ** -digits
                if digits == 0 and abs(value) >= 1000:
                    step = 10  # such numbers are rounded to tens
                allowed = 0.51 * step + (2e-3 * abs(value) if "inductance" in formula else 1e-9)
                self.assertLessEqual(abs(float(written) - value), allowed,
                                     f"line {line}: {written} {unit} is {value:.5g} by {formula}")

    def test_links_and_lines(self):
        text = PAGE.read_text(encoding="utf-8")
        for target in re.findall(r"\]\(([^)#]+)(?:#[\w-]+)?\)", text):
            self.assertTrue((PAGE.parent / target).exists(), target)
        for drawing in DRAWINGS:
            self.assertIn(f"(../drawings/{drawing}.svg)", text)
        anchors = {re.sub(r"[^\w -]", "", line.lstrip("# ")).lower().replace(" ", "-") for line in text.splitlines()
                   if line.startswith("#")}
        for anchor in re.findall(r"\]\(#([\w-]+)\)", text):
            self.assertIn(anchor, anchors)
        for line in text.splitlines():
            self.assertTrue(len(line) <= 140 or line.startswith("|"), line)

    def test_what_the_self_test_prints_is_quoted_as_it_is(self):
        source = (ROOT / "service/tools/device/device_text.cc").read_text(encoding="utf-8")
        quoted = re.findall(r"^       ok    (.{12}) ", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
        names = re.findall(r'JudgeFaults\("(.+?)"|return \{"(.+?)", ', source)
        self.assertLessEqual({words.strip() for words in quoted}, {one or two for one, two in names})
        self.assertEqual(len(set(quoted)), 8)
        faults = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "firmware/wire").glob("names*"))
        for fault in ("supply low", "coil open", "driver fault", "current off its model", "current sensor",
                      "fan stands", "emergency stop"):
            self.assertIn(f'"{fault}"', faults)
            self.assertIn(f"`{fault}`", PAGE.read_text(encoding="utf-8"))


if __name__ == "__main__":
    unittest.main()
