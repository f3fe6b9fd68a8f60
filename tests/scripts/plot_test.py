"""scripts/plot: what its pictures say, that they are reproducible, and what it refuses.

Exit status 77: not run, since the Python of scripts/plot has no matplotlib.
"""
import glob
import itertools
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as xml

PLOT = os.path.join(os.path.dirname(__file__), "..", "..", "scripts", "plot")
IMAGES = os.path.join(os.path.dirname(__file__), "..", "..", "docs", "images")
NOT_RUN = 77
SVG = "{http://www.w3.org/2000/svg}"
NARROW, NARROW_WIDTH, WIDTH = " .,:;'()fijlrt-", 0.38, 0.64  # letters, of a text's height
ASCENT, DESCENT = 0.75, 0.2  # above and below the line
LACKING = (None, float("nan"), float("inf"), "fast", True)  # what stands where a number should

def interpreter():
    with open(PLOT, encoding="utf-8") as script:
        return script.readline().removeprefix("#!").strip()

def document(name, rows, **tables):
    return {"name": name, "command": f"omni-bench {name} --seed 7", "commit": "c0ffee", "machine": "a test's machine",
            "rows": rows, "tables": {key.replace("_", " "): side for key, side in tables.items()}}

def solver():
    return document("solver", [
        {"method": "omni", "model": "default", "start": "warm", "us_median": 1.1, "rms_mm": 0.18},
        {"method": "omni", "model": "dipole", "start": "warm", "us_median": 0.6, "rms_mm": 3.7},
        {"method": "ceres-analytic", "model": "full", "start": "cold", "us_median": 44, "rms_mm": 0.18}])

def tracking():
    return document("tracking", [
        {"model": "default", "noise": "UHP", "actuation_A": 4, "currents": "hidden", "calibrated": "self",
         "moving": True, "room": True,
         "mean_mm": 0.2, "p95_mm": 0.5, "max_mm": 1.1, "us_median": 1.234},
        {"model": "dipole", "noise": "none", "actuation_A": 0, "mean_mm": 3, "p95_mm": 6, "max_mm": 9}])

def stability():
    return document("stability", [], offered=[
        {"noise_mm": noise_mm, "delay_ms": delay_ms, "offered_N_m": 900 / (1 + delay_ms),
         "start_N_m": 600 / (1 + delay_ms)} for noise_mm in (0, 0.02, 0.1, 0.3, 1) for delay_ms in (0, 1, 5)])

def collision():
    return document("collision", [
        {"engine": engine, "mesh": mesh, "triangles": n, "us_median": 1e-4 * n} for engine in ("omni-proxy", "bullet")
        for mesh in ("lump", "sheet") for n in (1000, 10000)])

def deformable():
    return document("deformable", [
        {"method": "omni", "tets": 1871, "us_median": 0.3, "error_pct": 1.3},
        {"method": "study-projective", "tets": 588, "us_median": 2500, "error_pct": 280}])

def layer():
    return document("layer", [], motions=[
        {"motion": motion, "method": method, "horizon_ms": ms, "error_mm_p95": 0.05 * ms}
        for motion in ("extrusion", "free strokes, seed 1", "free strokes, seed 2") for method in ("layer", "hold last")
        for ms in (10, 20, 40)])

def align():
    return document("align", [
        {"method": "touch, 6 DoF", "predicted_mm": 2.4, "error_mm_median": 2.2, "error_mm_p95": 4.1},
        {"method": "sweep", "predicted_mm": 1.2, "error_mm_median": 1.1, "error_mm_p95": 2.3}])

def paper():
    conditions = ("no actuation", "+-4 A saw-tooth")
    rows = [{"section": "tracking", "condition": condition, "quantity": "mean_mm", "paper": 4.9, "ours": 0.2}
            for condition in conditions]
    rows += [{"section": "decay", "gap_mm": 10, "paper_N": 0.835}]
    rows += [{"section": section} for section in ("forces", "heat", "magnets")]
    return document("paper", rows, tracking_distribution=[
        {"condition": condition, "from_mm": mm, "to_mm": mm + 0.5, "share_pct": 8} for condition in conditions
        for mm in (3, 3.5, 4)], force_lines=[
        {"direction": direction, "series": series, "of_text": series == "numbers in the text", "current_A": current_A,
         "force_N": 0.1 * current_A} for direction in ("radial", "tangential")
        for series in ("numbers in the text", "twin, fitted geometry") for current_A in (-15, 15)], decay_curve=[
        {"gap_mm": mm, "paper_law_N": 2 - 0.06 * mm, "twin_radial_N": 2 - 0.05 * mm,
         "twin_tangential_N": 2 - 0.055 * mm, "ours_radial_N": 2 - 0.05 * mm} for mm in (0, 10, 30)], heat_in_the_text=[
        {"run": "15 A for 25 s", "time_s": 65, "body_C": 39}], heat_curves=[
        {"run": run, "time_s": s, "body_C": 24 + 0.1 * s, "copper_C": 24 + s}
        for run in ("15 A for 25 s", "5 A for 15 min") for s in (0, 1, 2)], magnet_of_the_paper=[
        {"radius_mm": 15, "height_mm": 7}], magnet_sizes=[
        {"radius_mm": radius, "height_mm": height, "paper_law_N": 0.1 * radius, "twin_N": 0.01 * (radius - height),
         "ours_N": 0} for radius in (5, 15, 25) for height in (1, 7, 21)])

# Picture -> what must stand in it: axis labels with units, and names of series.
WORDS = {
    "solver": (solver, "median time of a solve, us", "error, mm rms", "omni, default", "omni, dipole",
               "ceres-analytic, full", "0.18", "simulation"),
    "tracking": (tracking, "position error, mm", "● mean, ○ 95 %, ◆ worst", "simulation",
                 "pen moving, low noise, default model, own calibration, in a room, ±4 A hidden",
                 "pen at rest, no noise, dipole model, 0 A"),
    "stability": (stability, "lag, ms", "stiffness, N/m", "allowed", "simple rule", "from 900 to 150 N/m", "0 mm",
                  "0.02 mm", "0.1 mm", "0.3 mm", "1 mm", "simulation"),
    "collision": (collision, "triangles", "median time, us", "omni-proxy takes 0.1 us on 1,000 triangles", "bullet",
                  "10,000"),
    "deformable": (deformable, "median time of a tick, us", "neo-Hookean, %", "a tick of 1 kHz", "omni, 1,871",
                   "projective, 588", "takes 0.3 us", "1.3 %"),
    "layer": (layer, "horizon, ms", "position error, mm", "extrusion", "free strokes", "within 2.0 mm", "simulation"),
    "align": (align, "predicted error, mm", "true error, mm", "touch", "sweep", "filled: median, hollow: 95 %",
              "error = predicted", "is 0.9 to 0.9 times", "simulation"),
    "fig6-tracking": (paper, "distance to the truth, mm", "poses per 0.5 mm, %", "paper's mean 4.9 mm",
                      "our mean 0.2 mm", "the paper's method on the twin", "no actuation", "+-4 A saw-tooth",
                      "simulation"),
    "fig8-forces": (paper, "I_z, A", "I_x or I_y, A", "force, N", "numbers in the paper's text",
                    "twin, fitted geometry", "simulation"),
    "decay": (paper, "gap, mm", "force, N", "paper's law", "twin, radial", "twin, tangential", "ours, radial",
              "numbers in the paper's text", "simulation"),
    "fig9-heat": (paper, "time, s", "temperature, °C", "body", "copper", "15 A for 25 s", "5 A for 15 min",
                  "simulation"),
    "fig5-magnets": (paper, "magnet radius, mm", "magnet height, mm", "net lift, N", "paper's magnet", "best",
                     "volume of the paper's magnet", "simulation"),
}
MAKERS = tuple(dict.fromkeys(entry[0] for entry in WORDS.values()))
NO_TWIN = ("collision", "deformable")

def marks_of(svg):
    """How often a marker or another shape is used."""
    return len(re.findall(r"<use ", svg))

def plain(element):
    return "".join(element.itertext()).replace("\u00a0", " ")

def texts_of(svg):
    """The texts, those of more lines joined."""
    return [" ".join(plain(text) for text in group.iter(SVG + "text")) for group in groups_of(svg, "text_")]

def groups_of(svg, kind):
    return [group for group in xml.fromstring(svg).iter(SVG + "g") if group.get("id", "").startswith(kind)]

def box_of(text):
    """left, top, right, bottom of a text."""
    style = text.get("style")
    height = float(re.search(r"([\d.]+)px", style)[1])
    anchor = re.search(r"text-anchor: (\w+)", style)
    width = height * sum(NARROW_WIDTH if letter in NARROW else WIDTH for letter in plain(text))
    before = {"middle": width / 2, "end": width}.get(anchor and anchor[1], 0)
    x, y = map(float, re.search(r"(?:translate\(|rotate\(\S+ )(\S+) ([^)]+)\)", text.get("transform")).groups())
    if "rotate(-90" in text.get("transform", ""):
        return x - ASCENT * height, y - width + before, x + DESCENT * height, y + before
    return x - before, y - ASCENT * height, x - before + width, y + DESCENT * height

def overlap(one, other):
    return min(one[2], other[2]) > max(one[0], other[0]) and min(one[3], other[3]) > max(one[1], other[1])

def layout_faults(svg):
    """Texts that lie on each other or beyond the sheet."""
    root = xml.fromstring(svg)
    _, _, width, height = map(float, root.get("viewBox").split())
    boxes = [(plain(text), box_of(text)) for text in root.iter(SVG + "text")]
    faults = [f"{text} is beyond the sheet" for text, (left, top, right, bottom) in boxes
              if min(left, top) < 0 or right > width or bottom > height]
    return faults + [f"{one} and {other} overlap" for (one, first), (other, second) in itertools.combinations(boxes, 2)
                     if overlap(first, second)]

def axis_faults(svg):
    """Axes marked with numbers that have no label with a unit."""
    faults = []
    for axis in groups_of(svg, "matplotlib.axis_"):
        marks, labels = ([plain(text) for group in axis if re.match(kind, group.get("id", ""))
                          for text in group.iter(SVG + "text")] for kind in ("[xy]tick_", "text_"))
        label = " ".join(labels)
        numbers = any(re.fullmatch(r"[−-]?[\d.,]+", mark) for mark in marks)
        if numbers and not re.fullmatch(r".+, [^ ,]+|triangles", label):
            faults.append(f"the axis with {', '.join(marks)} is named {label or 'nothing'}")
    return faults

class PlotTest(unittest.TestCase):
    drawn = None

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def write(self, content, name="rows.json"):
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(content if isinstance(content, str) else json.dumps(content))
        return path

    def plot(self, *words, **environment):
        return subprocess.run([PLOT, *words], capture_output=True, text=True, check=False, cwd=self.folder,
                              env={**os.environ, **environment})

    def draw(self, *contents, output="out"):
        """Name -> text of every picture that comes of these documents, all drawn by one process."""
        folder = os.path.join(self.folder, output)
        done = self.plot(*(self.write(content, f"{k}.json") for k, content in enumerate(contents)), "-o", folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr, "")
        pictures = {}
        for path in done.stdout.split():
            with open(path, encoding="utf-8") as file:
                pictures[os.path.basename(path).removesuffix(".svg")] = file.read()
        return pictures

    def assert_refused(self, done, *parts):
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertEqual(done.stdout, "")
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        for part in ("plot: ", *parts):
            self.assertIn(part, done.stderr)

    def all_pictures(self):
        """Those of all documents; drawn once."""
        if PlotTest.drawn is None:
            PlotTest.drawn = self.draw(*(make() for make in MAKERS))
        return PlotTest.drawn

    def test_pictures_name_axes_series_and_origin(self):
        pictures = self.all_pictures()
        self.assertEqual(set(pictures), set(WORDS))
        for name, svg in pictures.items():
            lines = texts_of(svg)
            make, *words = WORDS[name]
            for part in (*words, f"omni-bench {make()['name']} --seed 7", "commit c0ffee", "a test's machine"):
                self.assertTrue(any(part in line for line in lines), f"{name}: {part} is not in {lines}")
            self.assertEqual(any("simulation" in line for line in lines), name not in NO_TWIN, name)
            self.assertNotIn("nan", svg, name)

    def test_a_document_alone_gives_its_own_pictures(self):
        for make in MAKERS:
            self.assertEqual(set(self.draw(make())), {name for name, entry in WORDS.items() if entry[0] is make})

    def test_texts_neither_overlap_nor_leave_the_sheet(self):
        for name, svg in self.all_pictures().items():
            self.assertEqual(layout_faults(svg), [], name)

    def test_axes_have_labels_with_units(self):
        for name, svg in self.all_pictures().items():
            self.assertEqual(axis_faults(svg), [], name)

    def test_a_colour_map_has_a_bar_with_a_unit(self):
        svg = self.all_pictures()["fig5-magnets"]
        bars = [axes for axes in groups_of(svg, "axes_") if "net lift, N" in map(plain, axes.iter(SVG + "text"))]
        self.assertEqual(len(bars), len(groups_of(svg, "QuadMesh_")))
        self.assertEqual(len(bars), 2)

    def test_pictures_of_the_documents_are_legible(self):
        paths = glob.glob(os.path.join(IMAGES, "bench-*.svg")) + glob.glob(os.path.join(IMAGES, "paper", "*.svg"))
        self.assertEqual(len(paths), len(WORDS))
        for path in paths:
            with open(path, encoding="utf-8") as file:
                svg = file.read()
            self.assertEqual(layout_faults(svg) + axis_faults(svg), [], path)

    def test_faults_of_the_layout_are_found(self):
        text = '<text style="font: 10px x; text-anchor: {}" transform="translate({} 20)">words</text>'
        for texts, fault in ((text.format("start", 90), "words is beyond the sheet"),
                             (text.format("middle", 40) + text.format("end", 50), "words and words overlap")):
            svg = f'<svg xmlns="{SVG[1:-1]}" viewBox="0 0 100 50">{texts}</svg>'
            self.assertEqual(layout_faults(svg), [fault])
        axis = f'<svg xmlns="{SVG[1:-1]}"><g id="matplotlib.axis_1"><g id="xtick_1"><text>5</text></g>{{}}</g></svg>'
        self.assertEqual(len(axis_faults(axis.format('<g id="text_1"><text>time</text></g>'))), 1)
        self.assertEqual(axis_faults(axis.format('<g id="text_1"><text>time, s</text></g>')), [])

    def test_a_title_says_what_the_rows_say(self):
        content = solver()
        content["rows"].append({**content["rows"][2], "start": "warm", "us_median": 7})
        lines = texts_of(self.draw(content)["solver"])
        self.assertIn("Our warm solve takes 1.1 us, the fastest peer of that accuracy 7 us (simulation)", lines)

    def test_what_all_rows_of_a_panel_share_is_its_title(self):
        content = tracking()
        content["rows"].append({**content["rows"][0], "actuation_A": 0})
        lines = texts_of(self.draw(content)["tracking"])
        for part in ("pen moving, low noise, default model, own calibration, in a room", "±4 A hidden", "0 A"):
            self.assertIn(part, lines)

    def test_other_meshes_are_not_on_the_line(self):
        rows = collision()
        only_lumps = {**rows, "rows": [row for row in rows["rows"] if row["mesh"] == "lump"]}
        self.assertEqual(self.draw(rows), self.draw(only_lumps))

    def test_same_rows_give_the_same_bytes(self):
        self.assertEqual(self.draw(*(make() for make in MAKERS), output="second"), self.all_pictures())

    def test_dots_are_drawn(self):
        content = solver()
        before = marks_of(self.draw(content)["solver"])
        content["rows"].append({"method": "omni", "model": "default", "start": "warm", "us_median": 9, "rms_mm": 0.2})
        self.assertEqual(marks_of(self.draw(content)["solver"]), before + 1)

    def test_what_is_no_number_is_left_out(self):
        contents = [make() for make in MAKERS]
        for content in contents:
            for rows in (content["rows"], *content["tables"].values()):
                for like in rows[:1]:
                    keys = [key for key, value in like.items() if isinstance(value, (int, float))]
                    rows += [{**like, **{key: lacking for key in keys}} for lacking in LACKING if keys]
                rows += [3, None, "row", [], {}]
        self.assertEqual(self.draw(*contents), self.all_pictures())

    def test_words_of_formulas_are_plain_text(self):
        content = solver()
        content["machine"] = "$x_1$ \\frac{1} & <b>"
        self.assertTrue(any("$x_1$ \\frac{1} & <b>" in line for line in texts_of(self.draw(content)["solver"])))

    def test_documents_without_usable_rows_are_refused(self):
        for content in (make() for make in MAKERS):
            empty = document(content["name"], [{"method": "omni", "us_median": None}])
            path = self.write(empty)
            self.assert_refused(self.plot(path), path, f"omni-bench {content['name']}")

    def test_a_paper_without_side_tables_is_refused(self):
        path = self.write({**paper(), "rows": [{"section": "heat"}], "tables": {}})
        self.assert_refused(self.plot(path), path, "heat curves", "omni-bench paper")

    def test_one_section_of_the_paper_is_one_figure(self):
        content = paper()
        content["rows"] = [row for row in content["rows"] if row["section"] == "decay"]
        self.assertEqual(list(self.draw(content)), ["decay"])

    def test_what_is_no_document_is_refused(self):
        no_document = ("[]", '{"name": "solver"}', '{"name": "solver", "rows": 3}')
        for content, part in (("[1", "no JSON"), ("[" * 100_000, "no JSON"), *((text, "no benchmark document")
                              for text in no_document), ({"rows": []}, "no picture"),
                              (document("loop", [{"scene": "x"}]), "omni-bench loop")):
            path = self.write(content)
            self.assert_refused(self.plot(path), path, part)

    def test_paths_that_do_not_work_are_named(self):
        missing = os.path.join(self.folder, "missing.json")
        self.assert_refused(self.plot(missing), missing, "No such file", "check the path")
        path = self.write(solver())
        self.assert_refused(self.plot(path, "-o", path), path, "check the path")

    def test_two_files_do_not_overwrite_each_other(self):
        one, other = self.write(solver(), "a.json"), self.write(solver(), "b.json")
        done = self.plot(one, other)
        self.assertEqual(done.returncode, 1)
        for part in (one, other, "two folders"):
            self.assertIn(part, done.stderr)

    def test_wrong_arguments(self):
        for words in ([], ["--nonsense", "x.json"], ["x.json", "-o"]):
            self.assertEqual(self.plot(*words).returncode, 2, words)

    def test_missing_matplotlib_is_named(self):
        self.write("raise ImportError('not here')\n", "matplotlib.py")
        done = self.plot(self.write(solver()), PYTHONPATH=self.folder)
        self.assert_refused(done, "python3-matplotlib")

if __name__ == "__main__":
    if subprocess.run([interpreter(), "-c", "import matplotlib"], capture_output=True, check=False).returncode != 0:
        print("not run: matplotlib is not installed; apt-get install python3-matplotlib")
        sys.exit(NOT_RUN)
    unittest.main()
