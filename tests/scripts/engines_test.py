"""scripts/engines judges what programs were given; here a recorded run of omni_touch on Monado, and what is made wrong in it."""
import copy
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import types
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SAMPLE = pathlib.Path(__file__).resolve().parent / "engines_sample"
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "tests/engines/godot")]
import relief  # noqa: E402
from simulated import film, given, hand, programs, roots, runs, stand, table  # noqa: E402

SECOND = 1_000_000_000
TOUCH = next(program for program in programs.PROGRAMS if program.name == "omni_touch")
TURNS = [{"owner": "pen", "from": 2 * SECOND, "to": 12 * SECOND}, {"owner": "controller", "from": 13 * SECOND, "to": 14 * SECOND},
         {"owner": "pen", "from": 15 * SECOND, "to": 30 * SECOND}]


def sample():
    return given.read_lines(SAMPLE / "witness.jsonl"), hand.Truth(SAMPLE / "truth.csv")


def row_of(lines, truth, mode="pen first"):
    """As runs.row makes it."""
    play = types.SimpleNamespace(lines=lambda: lines, turns=TURNS, place=types.SimpleNamespace(
        folder=SAMPLE, validation="above", validation_errors=lambda: 0),
        changes=[{"to": owner, "s": 0.1} for owner in table.OWNERS[mode]])
    return runs.row(play, TOUCH, mode, types.SimpleNamespace(suite="trixie"), False, truth)


class Judge(unittest.TestCase):
    def test_a_recorded_run_is_as_expected(self):
        row = row_of(*sample())
        self.assertEqual(row["problems"], [])
        self.assertEqual(row["profiles"], ["logitech/mx_ink_stylus_logitech", "khr/simple_controller", "logitech/mx_ink_stylus_logitech"])
        self.assertEqual((row["presses"], row["presses_true"], row["haptics"]), (3, 3, 3))
        self.assertLess(row["still_mm"], 2)
        self.assertGreater(row["poses"], 20)

    def broken(self, change):
        lines, truth = sample()
        lines = copy.deepcopy(lines)
        change(lines)
        return "; ".join(row_of(lines, truth)["problems"])

    def test_a_pen_that_is_shifted_is_found(self):
        def shift(lines):
            for line in given.of(lines, "pose"):
                line["p"][0] += 0.004
        self.assertRegex(self.broken(shift), r"the pen at rest is off by \d")

    def test_a_controller_that_is_shifted_is_found(self):
        def shift(lines):
            for line in given.of(lines, "pose"):
                line["p"][1] += 0.0015
        self.assertIn("the controller's pose is off by 1.5 mm", self.broken(shift))

    def test_poses_that_are_not_tracked_are_found(self):
        def clear(lines):
            for line in given.of(lines, "pose"):
                line["flags"] &= ~given.POSITION_TRACKED
        self.assertIn("only 0% of the pen's poses are TRACKED", self.broken(clear))

    def test_a_press_that_is_lost_is_found(self):
        def lose(lines):
            lines[:] = [line for line in lines if line["what"] not in ("bool", "float") or line["t"] > 6 * SECOND]
        self.assertIn("3 in the twin's record, 2 in the program", self.broken(lose))

    def test_a_left_hand_that_changes_is_found(self):
        def take(lines):
            given.of(lines, "profile", hand="left")[-1]["profile"] = "/interaction_profiles/oculus/touch_controller"
        self.assertIn("the left hand changed", self.broken(take))

    def test_vibrations_that_fail_are_found(self):
        def fail(lines):
            for line in given.of(lines, "haptic"):
                line["result"] = -1
        self.assertIn("no vibration was sent", self.broken(fail))

    def test_every_other_fact_of_a_row_is_judged(self):
        good = row_of(*sample())
        for change, words in (({"validation_errors": 2}, "2 errors of core_validation"), ({"ended_by_itself": True}, "ended by itself"),
                              ({"graphics": True, "frames": 0}, "no frame"), ({"pulses": 0}, "reached the coils"),
                              ({"changes": [{"to": "pen", "s": 1}]}, "the right hand went pen instead"),
                              ({"changes": [{"missed": "it hung"}]}, "it hung"),
                              ({"profiles": [*good["profiles"][:2] * 2, good["profiles"][0]]}, "changed by itself"), ({"mode": "layer"}, "no hand pressed"),
                              ({"presses_game": 2}, "2 the game"), ({"tracked": 0.5}, "only 50%"), ({"still_mm": None}, "off by None")):
            self.assertIn(words, "; ".join(table.problems({**good, **change}, runs.PRESSES)))

    def test_the_table_has_a_line_for_each_row_and_names_what_is_wrong(self):
        good = row_of(*sample())
        bad = {**good, "problems": ["it hung"]}
        lines = table.text([good, bad]).splitlines()
        self.assertEqual(len(lines), 4)
        self.assertTrue(lines[1].endswith("ok") and lines[2].endswith("FAILED"))
        self.assertEqual(lines[3], "omni_touch, trixie, pen first: it hung")
        self.assertTrue(all(isinstance(value, (str, int, float)) for value in table.flat(good).values()))


class Records(unittest.TestCase):
    def test_a_line_that_was_cut_is_left_out(self):
        whole = (SAMPLE / "witness.jsonl").read_text()
        cut = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / "cut.jsonl"
        cut.write_text(whole + '{"what": "pose", "t": 1')
        self.assertEqual(given.read_lines(cut), given.read_lines(SAMPLE / "witness.jsonl"))

    def test_the_last_report_of_a_program_is_read_among_other_lines(self):
        self.assertEqual(given.last_report('{"presses": 1}\nWARNING: x\n{"presses": 2}\n{"pres'), {"presses": 2})
        self.assertEqual(given.last_report("WARNING: x"), {})

    def test_an_aim_has_the_bytes_of_the_protocol(self):
        text = (ROOT / "service/protocol/hand_aim.h").read_text()
        packet = hand.packet((1, 2, 3))
        self.assertIn(f"sizeof(HandAim) == {len(packet)}", text)
        self.assertIn(f"kHandMagic = 0x{hand.MAGIC:08X}", text)
        self.assertIn(f"kHandVersion = {hand.VERSION};", text)

    def test_the_tip_lies_before_the_grip_as_the_profiles_have_it(self):
        simple = json.loads((ROOT / "layer/profiles/khr_simple.json").read_text())
        grip = next(pose for pose in simple["poses"] if pose["path"] == "/input/grip/pose")
        self.assertEqual(grip["position_tool_m"], [0, 0, given.GRIP_BEHIND_TIP_m])


class Scene(unittest.TestCase):
    def test_the_relief_is_what_its_program_writes(self):
        self.assertEqual((ROOT / "tests/engines/godot/relief.glb").read_bytes(), relief.glb())

    def test_godot_draws_it_where_the_base_is_aligned(self):
        place = ", ".join(str(x) for x in stand.BASE_STAGE_m)
        self.assertIn(f"const BASE_m := Vector3({place})", (ROOT / "tests/engines/godot/main.gd").read_text())


class Film(unittest.TestCase):
    """scripts/headset --film: the hand, the corner, the times of the pictures."""

    def test_the_hand_presses_slides_and_never_jumps(self):
        times = [i / 100 for i in range(int(100 * film.SECONDS) + 1)]
        points = [film.aim_at(t) for t in times]
        self.assertEqual((points[0], points[-1]), (hand.ABOVE, hand.ABOVE))
        fastest_m_s = max(100 * math.dist(a, b) for a, b in zip(points, points[1:]))
        self.assertLess(fastest_m_s, 0.05)
        depths = [relief.height_m(math.hypot(x, y)) - z for x, y, z in points]
        self.assertGreater(sum(depth > 0 for depth in depths), len(depths) / 2, "most of the time it touches")
        self.assertAlmostEqual(max(depths), film.FIRM_m)

    def test_the_one_in_the_documents_has_its_length_and_a_size_that_loads(self):
        data = (ROOT / "docs/images/headset.webp").read_bytes()
        at, shown_ms = 12, 0
        while at < len(data):
            size = int.from_bytes(data[at + 4:at + 8], "little")
            if data[at:at + 4] == b"ANMF":
                shown_ms += int.from_bytes(data[at + 20:at + 23], "little")
            at += 8 + size + size % 2
        self.assertAlmostEqual(shown_ms / 1000, film.SECONDS, delta=0.5)
        self.assertLessEqual(len(data), film.LARGEST_bytes)

    def test_a_corner_that_shows_another_force_is_found(self):
        truth = types.SimpleNamespace(t=[i * SECOND // 100 for i in range(1000)], force=[min(1.0, i / 400) for i in range(1000)])
        exact = [(t, force) for t, force in zip(truth.t, truth.force)][100:]
        late = [(t + SECOND // 10, force) for t, force in exact[:-20]]
        self.assertEqual(film.as_recorded(exact, truth), 1)
        self.assertEqual(film.as_recorded(late, truth), 1)
        self.assertLess(film.as_recorded([(t, force + 0.1) for t, force in exact], truth), 0.2)
        self.assertEqual(film.as_recorded([(20 * SECOND, 1.0)], truth), 0, "nothing was recorded then")

    def test_a_picture_stays_until_the_next_one(self):
        lines = film.concat_list([(SECOND, "00000.png"), (3 * SECOND // 2, "00001.png")], "/f").splitlines()
        self.assertEqual(lines, ["ffconcat version 1.0", "file /f/00000.png", "duration 0.500", "file /f/00001.png", "duration 0.100"])

    def test_the_newest_force_of_a_growing_record_is_read_by_whole_lines(self):
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        record = folder / "truth.csv"
        record.write_text("t_ns,coil_force_x_N,coil_force_y_N,coil_force_z_N\n1,0,0,0.5\n2,0,0")
        growing = hand.Growing(record)
        self.addCleanup(growing.file.close)
        self.assertEqual(growing.newest(), (0, 0, 0.5))
        with open(record, "a") as file:
            file.write(",0.75\n")
        self.assertEqual(growing.newest(), (0, 0, 0.75))


class Commands(unittest.TestCase):
    def listed(self, *words):
        return subprocess.run([ROOT / "scripts/engines", *words], text=True, capture_output=True)

    def test_the_list_has_every_program_in_every_run(self):
        rows = self.listed("--list").stdout.splitlines()
        self.assertEqual(len(rows), sum(len(program.suites) for program in programs.PROGRAMS) * len(runs.MODES))
        self.assertEqual(self.listed("--list", "--suite", "sid", "--program", "Godot", "--run", "layer").stdout, "sid  Godot  layer\n")

    def test_programs_are_of_suites_that_there_are(self):
        for program in programs.PROGRAMS:
            self.assertTrue(set(program.suites) <= set(roots.PACKAGES), program.name)
            for suite in program.suites:
                self.assertIn(program.package, ("", *roots.PACKAGES[suite].split()))

    def test_an_unknown_program_is_refused(self):
        self.assertEqual(self.listed("--program", "hello").returncode, 2)


if __name__ == "__main__":
    unittest.main()
