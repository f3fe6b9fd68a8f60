"""scripts/check finds what it is there to find."""
import importlib.machinery
import importlib.util
import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("check", str(ROOT / "scripts/check"))
check = importlib.util.module_from_spec(importlib.util.spec_from_loader("check", loader))
loader.exec_module(check)


class Sources(unittest.TestCase):
    def compile(self, text):
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder) / "one.cc"
            source.write_text(text)
            words = ["ccache", "c++", "-std=c++20", "-Wall", "-Werror", "-MD", "-MT", "one.o", "-MF", "one.d", "-o",
                     "one.o", "-c", str(source)]
            failed = check.each({"one.cc": (folder, check.syntax_words(words))})
            self.assertEqual([path.name for path in pathlib.Path(folder).iterdir()], ["one.cc"])  # nothing is written
            return failed

    def test_a_source_that_includes_what_it_uses_passes(self):
        self.assertEqual(self.compile("#include <vector>\nint Size() { return static_cast<int>(std::vector<int>(3).size()); }\n"), {})

    def test_a_missing_include_is_found(self):
        failed = self.compile("int Size() { return static_cast<int>(std::vector<int>(3).size()); }\n")
        self.assertIn("vector", failed["one.cc"])

    def test_all_that_fail_are_named(self):
        jobs = {name: ("/", ["sh", "-c", f"echo {name}; exit {status}"]) for name, status in (("a", 0), ("b", 1), ("c", 2))}
        self.assertEqual(check.each(jobs), {"b": "b\n", "c": "c\n"})


if __name__ == "__main__":
    unittest.main()
