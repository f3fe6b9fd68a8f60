"""scripts/check finds what it is there to find."""
import functools
import importlib.machinery
import importlib.util
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
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
            failed, _ = check.each({"one.cc": (folder, check.syntax_words(words))})
            self.assertEqual([path.name for path in pathlib.Path(folder).iterdir()], ["one.cc"])  # nothing is written
            return failed

    def test_a_source_that_includes_what_it_uses_passes(self):
        self.assertEqual(self.compile("#include <vector>\nint Size() { return static_cast<int>(std::vector<int>(3).size()); }\n"), {})

    def test_a_missing_include_is_found(self):
        failed = self.compile("int Size() { return static_cast<int>(std::vector<int>(3).size()); }\n")
        self.assertIn("vector", failed["one.cc"])

    def test_all_that_fail_are_named(self):
        jobs = {name: ("/", ["sh", "-c", f"echo {name}; exit {status}"]) for name, status in (("a", 0), ("b", 1), ("c", 2))}
        self.assertEqual(check.each(jobs), ({"b": "b\n", "c": "c\n"}, 0))

    def test_what_there_is_no_time_for_is_counted(self):
        jobs = {name: ("/", ["false"]) for name in "abc"}
        self.assertEqual(check.each(jobs, time.monotonic() - 1), ({}, 3))


class Threads(unittest.TestCase):
    def counted(self, text):
        """The census of a program of this text: its key, or nothing if it was not alone."""
        with tempfile.TemporaryDirectory() as folder:
            source, program, census = (pathlib.Path(folder) / name for name in ("one.cc", "one", "census"))
            source.write_text(text)
            check.must(["c++", "-std=c++20", "-o", str(program), str(source),
                        str(check.ROOT / "tests/support/thread_census.cc"), "-pthread"])
            subprocess.run([str(program), "--gtest_filter=A.B", "more"], env={**os.environ, "OMNI_THREAD_CENSUS": str(census)})
            return [check.key_of(line.split("\t")) for line in census.read_text().splitlines()] if census.exists() else []

    def test_a_program_that_starts_a_thread_or_a_process_was_not_alone(self):
        for text in ("#include <thread>\nint main() { std::thread([] {}).join(); }\n",
                     "#include <future>\nint main() { return std::async(std::launch::async, [] { return 0; }).get(); }\n",
                     "#include <pthread.h>\nvoid* Run(void*) { return nullptr; }\n"
                     "int main() { pthread_t id; pthread_create(&id, nullptr, Run, nullptr); return pthread_join(id, nullptr); }\n",
                     "#include <cstdlib>\nint main() { return std::system(\"true\"); }\n",
                     "#include <sys/wait.h>\n#include <unistd.h>\nint main() { if (fork() == 0) _exit(0); return wait(nullptr) < 0; }\n",
                     "#include <pty.h>\n#include <sys/wait.h>\n#include <unistd.h>\nint main() { int terminal; "
                     "if (forkpty(&terminal, nullptr, nullptr, nullptr) == 0) _exit(0); return wait(nullptr) < 0; }\n"):
            self.assertEqual(self.counted(text), [], text)

    def test_a_program_that_does_not_was(self):
        text = "#include <mutex>\nint main() { std::mutex one; one.lock(); one.unlock(); }\n"
        self.assertEqual(self.counted(text), [("one", "--gtest_filter=A.B")])

    def test_one_that_ends_in_a_crash_is_not_counted(self):
        self.assertEqual(self.counted("#include <cstdlib>\nint main() { std::abort(); }\n"), [])


class JoinedSources(unittest.TestCase):
    BAD = "int Read() {\n  const int* p = nullptr;\n  return *p;\n}\n"

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "service/Unity").mkdir(parents=True)
        (self.folder / "service/bad.cc").write_text(self.BAD)
        joined = self.folder / "service/Unity/unity_0_cxx.cxx"
        joined.write_text(f'#include "{self.folder}/service/bad.cc"\n')
        self.entry = {"directory": str(self.folder), "file": str(joined),
                      "command": f"c++ -include pch.h -fpch-preprocess -o one.o -c {joined}"}

    def test_each_source_is_looked_at_once(self):
        alone = {**self.entry, "file": str(self.folder / "service/bad.cc")}
        self.assertEqual(len(check.joined_commands([self.entry, alone, self.entry], self.folder)), 1)

    @unittest.skipUnless(shutil.which("clang-tidy"), "clang-tidy is not installed")
    def test_what_was_clean_is_known_until_what_is_read_changes(self):
        source, header = self.folder / "service/one.cc", self.folder / "service/one.h"
        source.write_text('#include "one.h"\nint Twice(int x) { return 2 * x; }  // of x\n')
        header.write_text("int Twice(int x);\n")
        command = f"c++ -std=c++20 -o one.o -c {source}"
        ran = self.folder / "ran"

        def check_it(words=()):
            ran.unlink(missing_ok=True)
            clean = check.Clean(self.folder / "clean")
            known = functools.partial(clean.path, str(self.folder), command, str(source), list(words))
            status = "1" if "bad" in source.read_text() else "0"
            check.each({"one": (str(self.folder), ["sh", "-c", f"touch {ran}; exit {status}"], known)})
            return ran.exists()

        self.assertTrue(check_it())
        self.assertFalse(check_it())
        self.assertTrue(check_it(["--checks=-*"]))
        header.write_text("int Twice(int x);  // NOLINT\n")
        self.assertTrue(check_it())
        self.assertFalse(check_it())
        header.write_text(header.read_text() + "#define UNUSED(x) x\n")
        self.assertTrue(check_it(), "clang-tidy looks at macros that nothing uses, too")
        source.write_text(source.read_text() + "// bad\n")
        self.assertTrue(check_it())
        self.assertTrue(check_it(), "what has findings is checked each time")

    @unittest.skipUnless(shutil.which("clang-tidy"), "clang-tidy is not installed")
    def test_the_analyzer_sees_into_joined_sources(self):
        entries = check.joined_commands([self.entry], self.folder)
        (self.folder / "compile_commands.json").write_text(json.dumps(entries))
        words = check.tidy_words(self.folder, [self.folder / "service/bad.cc"])
        failed, _ = check.each({"one": (str(check.ROOT), words + [entries[0]["file"]])})
        self.assertIn("clang-analyzer-core.NullDereference", failed["one"])


if __name__ == "__main__":
    unittest.main()
