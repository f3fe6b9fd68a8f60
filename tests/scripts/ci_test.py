"""The rows of .ci/run are those of the workflow, and call only what README and CONTRIBUTING name."""
import os
import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROWS = re.search(r'^rows="\n(.*?)^"$', (ROOT / ".ci/run").read_text(), re.M | re.S)[1].splitlines()


class Rows(unittest.TestCase):
    def test_the_workflow_has_the_same(self):
        matrix = re.search(r"^\s*row: \[(.*)\]$", (ROOT / ".github/workflows/ci.yml").read_text(), re.M)[1]
        self.assertEqual(matrix.split(", "), [row.split()[0] for row in ROWS])

    def test_each_is_a_command_that_people_have(self):
        for row in ROWS:
            self.assertIn(row.split()[1], ("scripts/test", "scripts/check"))
        self.assertIn("    scripts/test --all", (ROOT / "README.md").read_text())

    def test_an_unknown_one_is_refused(self):
        done = subprocess.run([ROOT / ".ci/run", "tset"], text=True, capture_output=True)
        self.assertEqual(done.returncode, 2)
        self.assertIn("there is no row tset; the rows are test sources", done.stderr)


class Tests(unittest.TestCase):
    def test_what_is_left_to_all_is_there(self):
        """Each expression of tests/only_all.txt matches tests of the whole build, and leaves most."""
        listed = subprocess.run(["ctest", "-N"], cwd=os.environ["OMNI_BINARY_DIR"], text=True, capture_output=True).stdout
        names = re.findall(r"Test +#\d+: (\S+)", listed)
        if "layer.faults" not in names:
            self.skipTest("not everything is configured")
        left = [line for line in (ROOT / "tests/only_all.txt").read_text().splitlines() if not line.startswith("#")]
        for expression in left:
            self.assertTrue(any(re.search(expression, name) for name in names), expression)
        kept = [name for name in names if not any(re.search(expression, name) for expression in left)]
        self.assertGreater(len(kept), 0.75 * len(names))


class Setup(unittest.TestCase):
    """scripts/setup lists what each script needs: more for more."""

    def packages(self, *words):
        listed = subprocess.run([ROOT / "scripts/setup", "--list", *words], text=True, capture_output=True, check=True)
        return set(listed.stdout.split())

    def test_each_has_what_the_smaller_ones_have(self):
        for smaller, larger in (("demo", "tests"), ("tests", "all"), ("tests", "check"), ("try", "all"), ("tests", "deep")):
            self.assertLess(self.packages(smaller), self.packages(larger), (smaller, larger))
        self.assertEqual(self.packages(), self.packages("tests"))

    def test_people_who_try_it_install_no_test_browser_or_emulator(self):
        for name in ("try", "demo", "tests"):
            self.assertTrue(self.packages(name).isdisjoint({"chromium", "qemu-system-arm", "gcc-arm-none-eabi", "clang-tidy"}))
        self.assertNotIn("libgtest-dev", self.packages("try") | self.packages("demo"))


if __name__ == "__main__":
    unittest.main()
