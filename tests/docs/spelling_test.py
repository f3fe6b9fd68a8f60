#!/usr/bin/env python3
"""Spelling of the documents and of the page: British English as in hunspell-en-gb, and our terms in words.txt."""

import html
import re
import subprocess
import sys
import unittest

sys.dont_write_bytecode = True
from doc_files import ROOT, documents, split, where

WORDS = ROOT / "tests" / "docs" / "words.txt"
PAGE = ROOT / "service" / "page" / "index.html"


def words_of(text):
    """The words of prose, hyphenated ones whole. What has a digit, a dot, a slash or an inner capital is a name."""
    text = re.sub(r"\]\([^)]*\)", "] ", text)  # targets of links
    text = re.sub(r"https?://\S+|<[^>]*>|&\w+;", " ", text)
    for token in re.split(r"[\s|()\[\]{}\"“”,;:!?*=+<>]+", text):
        token = re.sub(r"['’]s?$", "", token.strip(".'’-"))
        if len(token) > 1 and not re.search(r"[^A-Za-zÀ-ÿ'’-]|[a-z][A-Z]", token):
            yield token


def prose_of(path):
    """(line number, words) without code spans, which may run over the end of a line, and without measured tables."""
    text = path.read_text(encoding="utf-8")
    text = re.sub(r"<!-- results: .*?<!-- end -->", lambda table: "\n" * table[0].count("\n"), text, flags=re.S)
    lines = split(text)[1]
    text = re.sub(r"`[^`\n]*(\n[^`\n]+)*`", lambda span: " x_ " + "\n" * span[0].count("\n"),
                  "\n".join(line for _, line in lines))
    return [(number, words_of(line)) for (number, _), line in zip(lines, text.split("\n"), strict=True)]


def strings_of_page():
    """The visible strings of the page with their lines: text, and the attributes that browsers show or read out."""
    text = PAGE.read_text(encoding="utf-8")
    text = re.sub(r"<code>.*?</code>|<style.*?</style>|<script.*?</script>", " ", text, flags=re.S)
    shown = r'>([^<]+)<|<meta name="description" content="([^"]*)"|\b(?:title|alt|aria-label|placeholder)="([^"]*)"'
    return [(text.count("\n", 0, found.start()) + 1, words_of(html.unescape(found[found.lastindex]))) 
            for found in re.finditer(shown, text)]


def unknown_of(words):
    """Those that are not in the dictionary."""
    command = ["hunspell", "-d", "en_GB", "-i", "UTF-8", "-l"]
    try:
        checked = subprocess.run(command, input="\n".join(sorted(words)) + "\n", capture_output=True, encoding="utf-8",
                                 check=False)
    except FileNotFoundError:
        raise AssertionError("install hunspell and hunspell-en-gb (scripts/setup)") from None
    if checked.returncode != 0:
        raise AssertionError("install hunspell-en-gb (scripts/setup): " + checked.stderr.strip())
    return set(checked.stdout.split())


def misspelled(words, terms):
    """Words that are neither terms nor in the dictionary nor made of such, and the terms that are needed."""
    unknown = unknown_of({part for word in words for part in word.split("-")})
    wrong, needed = set(), set()
    for word in words:
        spellings = {word, word[0].lower() + word[1:]}
        for part in [word] if spellings & terms else word.split("-"):
            spellings = {part, part[:1].lower() + part[1:]}
            if part in unknown or "-" in part:
                needed |= spellings & terms
                wrong |= set() if spellings & terms else {word}
    return wrong, needed


class Spelling(unittest.TestCase):
    maxDiff = None

    def test_documents_and_page(self):
        used = {}  # word: where it occurs first
        for path in documents():
            for number, words in prose_of(path):
                for word in words:
                    used.setdefault(word, where(path, number))
        for number, words in strings_of_page():
            for word in words:
                used.setdefault(word, where(PAGE, number))
        terms = WORDS.read_text(encoding="utf-8").split()
        self.assertEqual(terms, sorted(set(terms)), "words.txt is sorted, one word a line")
        wrong, needed = misspelled(used, set(terms))
        self.assertEqual("\n".join(sorted(f"{used[word]}: {word}" for word in wrong)), "",
                         "misspelled; a term of ours goes into tests/docs/words.txt")
        self.assertEqual(sorted(set(terms) - needed), [], "words.txt has words that no document needs")

    def test_mistakes_are_found(self):
        words = list(words_of("The [pen's](pen.md) x_T, omnid.service and B2: recieve half-centred, Neo-Hookean"))
        self.assertEqual(words, ["The", "pen", "and", "recieve", "half-centred", "Neo-Hookean"])
        self.assertEqual(misspelled(words, {"neo-Hookean", "pan"}), ({"recieve"}, {"neo-Hookean"}))
        self.assertEqual(unknown_of(["colour", "color", "metre", "center"]), {"color", "center"})


if __name__ == "__main__":
    unittest.main()
