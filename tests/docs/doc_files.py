"""Reads our Markdown documents: blocks of code on one side, prose on the other."""

import dataclasses
import importlib.machinery
import importlib.util
import os
import pathlib
import re
import textwrap

ROOT = pathlib.Path(os.environ.get("OMNI_SOURCE_DIR") or pathlib.Path(__file__).resolve().parents[2])


def documents():
    files = [ROOT / name for name in ("README.md", "CHANGELOG.md", "SECURITY.md")]
    for folder in ("docs", "layer", "firmware"):
        files += sorted((ROOT / folder).rglob("*.md"))
    return files


def script(name):
    """scripts/NAME as a module."""
    loader = importlib.machinery.SourceFileLoader(name, str(ROOT / "scripts" / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module


def where(path, line):
    return f"{path.relative_to(ROOT)}:{line}"


@dataclasses.dataclass
class Block:
    """A block of code: language is "" after a fence without one, and None if the block is indented."""

    line: int
    language: str | None
    mark: str  # the HTML comment directly before it, or ""
    lines: list = dataclasses.field(default_factory=list)

    @property
    def text(self):
        return textwrap.dedent("\n".join(self.lines)).strip("\n") + "\n"


def split(text):
    """Blocks of code, and the lines of prose with their numbers; HTML comments are neither."""
    blocks, prose = [], []
    state, block, mark, was_blank = "prose", None, "", True
    for number, line in enumerate(text.splitlines(), 1):
        fence = re.match(r"\s*```(\w*)\s*$", line)
        if state == "fence":
            if fence:
                state = "prose"
            else:
                block.lines.append(line)
            continue
        if state == "comment":
            mark += "\n" + line
            state = "prose" if "-->" in line else "comment"
            continue
        if fence or (line.startswith("    ") and state == "prose" and was_blank):
            state = "fence" if fence else "indented"
            block = Block(number + 1 if fence else number, fence[1] if fence else None, mark)
            blocks.append(block)
            mark = ""
        elif state == "indented" and line.strip() and not line.startswith("    "):
            state = "prose"
        if state == "indented":
            block.lines.append(line)
        elif line.lstrip().startswith("<!--"):
            mark = line
            state = "prose" if "-->" in line else "comment"
        elif state == "prose":
            mark = "" if line.strip() else mark
            prose.append((number, line))
        was_blank = not line.strip()
    return blocks, prose
