#!/usr/bin/env python3
"""docs/benchmarks.md is short, and shows what docs/benchmarks/*.json have."""

import json
import re
import sys
import unittest

sys.dont_write_bytecode = True
from doc_files import ROOT, script

results = script("results")
PAGE = (ROOT / "docs/benchmarks.md").read_text(encoding="utf-8")


class Page(unittest.TestCase):
    maxDiff = None

    def test_tables_are_those_of_the_rows(self):
        self.assertEqual(PAGE, results.filled(PAGE), "scripts/results page fills them")

    def test_is_short(self):
        self.assertLessEqual(len([word for word in PAGE.split() if re.search(r"\w", word)]), 2500)
        for place, table in results.PLACE.findall(PAGE):
            rows = [line for line in table.splitlines() if line.startswith("|")][2:]
            self.assertTrue(1 <= len(rows) <= 10, place)

    def test_every_document_has_a_place(self):
        shown = {place.split(";")[0].split("/")[0] for place, _ in results.PLACE.findall(PAGE)}
        kept = {path.stem for path in results.KEPT.glob("*.json")}
        self.assertEqual(kept - shown - {"track-4-5", "track-5-4", "track-5-5", "ipc", "loop", "numbers"}, set())


class Rows(unittest.TestCase):
    def test_each_document_says_how_it_was_made(self):
        for path in results.KEPT.glob("*.json"):
            kept = json.loads(path.read_text(encoding="utf-8"))
            self.assertRegex(kept["commit"], r"^[0-9a-f]{7,}$", path.name)
            self.assertRegex(kept["date"], r"^\d{4}-\d\d-\d\d$", path.name)
            self.assertEqual(path.read_text(encoding="utf-8"), results.one_row_a_line(kept))

    def test_what_ages_it_is_known_and_there(self):
        for path in results.KEPT.glob("*.json"):
            for module in results.MODULES[path.stem.split("-")[0]].split():
                self.assertTrue((ROOT / module).is_dir(), f"{path.stem}: {module}")

    def test_a_neutral_commit_ages_nothing(self):
        kept = {"name": "room", "commit": results.git("rev-parse", "HEAD~20").stdout.strip()}
        commits = results.commits_since(kept, [])
        if not commits:
            self.skipTest("the last commits change nothing of it")
        self.assertEqual(results.commits_since(kept, [commits[0].split()[0]]), commits[1:])


if __name__ == "__main__":
    unittest.main()
