#!/usr/bin/env python3
"""README's table of figures is made of rows of docs/benchmarks/*.json. figures_test.py --print prints it."""

import re
import sys
import unittest

sys.dont_write_bytecode = True
from doc_files import ROOT, script

results = script("results")

LUMP = {"mesh": "lump", "triangles": "1002252"}
LOCATE = {"call": "xrLocateSpace (pen)"}

# What it is; the figure; for each name in it the table, the row (or rows, of which the largest counts), column and scale.
FIGURES = [
    ("error of the pen's position, waved in a room", "{mean:.2f} mm (p95 {p95:.2f} mm)", {
        "mean": ("room", {"condition": "room", "force": "false"}, "mean_mm", 1),
        "p95": ("room", {"condition": "room", "force": "false"}, "p95_mm", 1)}),
    ("pressing on a box, up to 15 A in the coils", "{mean:.2f} mm (p95 {p95:.2f} mm)", {
        "mean": ("room", {"condition": "room", "force": "true"}, "mean_mm", 1),
        "p95": ("room", {"condition": "room", "force": "true"}, "p95_mm", 1)}),
    ("in the shipped scenes: clay, dragon, race", "{clay:.2f}, {dragon:.2f}, {race:.2f} mm", {
        "clay": ("room", {"condition": "scene-extrusion"}, "mean_mm", 1),
        "dragon": ("room", {"condition": "scene-dragon"}, "mean_mm", 1),
        "race": ("room", {"condition": "scene-racetrack"}, "mean_mm", 1)}),
    ("cold starts that fail, of a million", "{failures:.0f}", {
        "failures": ("solver", {"variant": "global, any tilt"}, "failures", 1)}),
    ("error of the force on the pen, p95", "{force:.1f} %", {
        "force": ("room", {"condition": "room", "force": "true"}, "force_error_p95_pct", 1)}),
    ("a tick of the service, of 1,000 us", "median {median:.1f} us, p99 {p99:.1f} us", {
        "median": ("tick", {}, "us_median", 1), "p99": ("tick", {}, "us_p99", 1)}),
    ("nearest point of a million triangles; Embree, Bullet", "{omni:.1f} us; {embree:.1f} us, {bullet:.0f} us", {
        "omni": ("collision", {"engine": "omni-closest", **LUMP}, "us_median", 1),
        "embree": ("collision", {"engine": "embree-warm", **LUMP}, "us_median", 1),
        "bullet": ("collision", {"engine": "bullet", **LUMP}, "us_median", 1)}),
    ("xrLocateSpace of the pen; without the layer", "{layer:.1f} us; {bare:.1f} us", {
        "layer": ("layer", {"method": "layer", "horizon_ms": "11", **LOCATE}, "ns_median", 1e-3),
        "bare": ("layer", {"method": "no layer", "horizon_ms": "11", **LOCATE}, "ns_median", 1e-3)}),
    ("from the sensors to the application's pose", "{ms:.1f} ms", {
        "ms": ("layer/latency", {}, "ms_p50", 1)}),
    ("half force gone after kill -9 of an application", "p99 {p99:.0f} ms", {
        "p99": ("safety", {"what": "half force gone after kill -9"}, "p99_ms", 1)}),
    ("read of an untagged scene of 102 MB", "{kB:.0f} kB", {
        "kB": ("scene", {"scene": "textured-100MB"}, "bytes_read", 1e-3)}),
]


def value(rows, where, column):
    chosen = [row[column] for row in rows if all(results.printed(row.get(key)) == word for key, word in where.items())]
    if not chosen:
        raise AssertionError(f"no row has {where}")
    return max(chosen)


def figures():
    lines = ["| simulated | |", "|---|---|"]
    for what, figure, sources in FIGURES:
        values = {key: scale * value(results.rows_of(table), where, column) for key, (table, where, column, scale) in sources.items()}
        lines.append(f"| {what} | {figure.format(**values)} |")
    return "\n".join(lines) + "\n"


class Readme(unittest.TestCase):
    maxDiff = None

    def test_figures_are_those_of_the_benchmarks(self):
        readme = (ROOT / "README.md").read_text(encoding="utf-8")
        shown = re.search(r"\| simulated \|.*?\n(?=\n)", readme, flags=re.S)
        self.assertIsNotNone(shown, "README has no table of figures")
        self.assertEqual(shown[0], figures(), "figures_test.py --print prints what belongs there")

    def test_is_read_in_two_minutes(self):
        readme = (ROOT / "README.md").read_text(encoding="utf-8")
        seen = re.sub(r"\]\([^)]*\)", "]", readme)  # links without their targets
        self.assertLessEqual(len([word for word in seen.split() if re.search(r"\w", word)]), 600)


if __name__ == "__main__":
    if sys.argv[1:] == ["--print"]:
        print(figures(), end="")
    else:
        unittest.main()
