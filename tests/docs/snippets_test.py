#!/usr/bin/env python3
"""The blocks of code in the documents do what they are shown for.

What a block is, its fence says (sh, toml, json, c, cpp, or text: output that nobody types), or, without a fence, its
form. An HTML comment directly before it may begin with
    snippet: run         a shell block that is also run, in a home folder of its own, with our programs in PATH
    snippet: prologue    C or C++ that stands before the block when it is compiled; missing } are added
"""

import base64
import collections
import json
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import tomllib
import unittest

sys.dont_write_bytecode = True
from doc_files import ROOT, Block, documents, split, where

LONG_s = 600  # it only ends what hangs

BUILD = pathlib.Path(os.environ.get("OMNI_BINARY_DIR") or ROOT / "build" / "release")

# Blocks without a fence: the first form that fits is what they are.
COMMAND = r"(\w+=\S* )*(\S*/)?(omni[\w-]*|scripts/[\w-]+|cmake|ctest|export|sudo|systemctl|teensy_loader_cli)\b"
FORMS = [
    ("sh", re.compile(COMMAND)),
    ("cpp", re.compile(r"(typedef|void|Xr\w+) [\w ]*[({]")),
    ("json", re.compile(r"[{\"]")),
    ("toml", re.compile(r"\[|\w+ = ")),
    ("text", re.compile(r"\w+( \w+)* {2,}\S")),  # output in columns
    ("text", re.compile(r"\w+ -> \w+")),  # a diagram
]
# Prologues of blocks in documents without comments, by document.
PROLOGUES = {"docs/architecture.md": '#include "service/loop/tick.h"\nnamespace omni::loop {\n'}
XR_HEADERS = "".join(f"#include <openxr/omni_{name}.h>\n"
                     for name in ("force_feedback", "haptic_scene", "stylus_interaction"))

# What members of a glTF document are tried in: a triangle over the base, and an image of one pixel.
TRIANGLE = [0, 0.05, 0, 0, 0.05, 0.01, 0.01, 0.05, 0] + [0, 0, 1, 0, 0, 1]  # positions, texture coordinates
PIXEL = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg=="
SCENE = {
    "asset": {"version": "2.0"},
    "scene": 0,
    "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
    "materials": [{}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                  {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3, "type": "VEC2"}],
    "bufferViews": [{"buffer": 0, "byteLength": 60}],
    "buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64,"
                 + base64.b64encode(struct.pack("<15f", *TRIANGLE)).decode()}],
    "textures": [{"source": 0}] * 4,
    "images": [{"uri": "data:image/png;base64," + PIXEL}],
}


def kind_of(path, block):
    if block.language:
        return block.language
    if block.language is None and path.is_relative_to(ROOT / "docs" / "theory"):
        return "text"  # formulas
    forms = (kind for kind, form in FORMS if block.language is None and form.match(block.text))
    return next(forms, "unknown")


def run(words, **options):
    """What is wrong with the words' run, or None."""
    done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=LONG_s, **options)
    return None if done.returncode == 0 else f"exit status {done.returncode}: {done.stderr}{done.stdout}"


def check_shell(block, _):
    if problem := run(["bash", "-n"], input=block.text):
        return problem
    for name in re.findall(r"(?<![\w/.-])(?:scripts|manifests|firmware|layer|scenes|tests)/[\w./-]+", block.text):
        if not (ROOT / name).exists():
            return f"there is no {name}"
    if "snippet: run" not in block.mark:
        return None
    with tempfile.TemporaryDirectory() as home:
        work = pathlib.Path(home) / "omni"  # looks like the source tree
        (work / "build").mkdir(parents=True)
        (work / "build" / "release").symlink_to(BUILD)
        for entry in ROOT.iterdir():
            if entry.name not in ("build", ".git"):
                (work / entry.name).symlink_to(entry)
        (work / "run").mkdir(mode=0o700)
        environment = {"HOME": home, "XDG_RUNTIME_DIR": str(work / "run"), "PATH": f"{BUILD}/bin:{os.environ['PATH']}"}
        return run(["bash", "-e", "-c", block.text], cwd=work, env=environment)


def same_structure(name, members):
    """Checks that structure `name` has these members in a header too, and no others."""
    yield f"static_assert(sizeof(documented::{name}) == sizeof({name}));"
    for member in re.findall(r"(\w+)(?:\[\w*\])?;", members):
        yield f"static_assert(offsetof(documented::{name}, {member}) == offsetof({name}, {member}));"
        yield f"static_assert(std::is_same_v<decltype(documented::{name}::{member}), decltype({name}::{member})>);"


def source_of(block, path):
    """The block as a source. What it declares and a header too must be the same in both."""
    text = block.text.rstrip()
    given = re.search(r"snippet: prologue\n(.*?)-->", block.mark, re.S)
    prologue = given[1] if given else PROLOGUES.get(str(path.relative_to(ROOT)), "")
    checks = [f"static_assert(std::is_same_v<decltype(&{name}), PFN_{name}>);"
              for name in re.findall(r"^XrResult (xr\w+)\(", text, re.M)]
    checks += [f"using Same{name} = decltype(&{name});"  # ambiguous if the parameters differ
               for name in re.findall(r"^void (\w+)\(", text, re.M)]
    if structure := re.match(r"typedef struct (\w+) \{(.*?)\}", text, re.S):
        checks += same_structure(structure[1], structure[2])
        prologue += "namespace documented {"
        text += "}"
    body = "\n".join([prologue, f'#line {block.line} "{path.relative_to(ROOT)}"', text, *checks, ""])
    if block.language == "c":
        body = f'extern "C" {{\n{body}}}\n'
    body += "}" * (body.count("{") - body.count("}"))
    return "#include <cstddef>\n#include <type_traits>\n" + XR_HEADERS + body


def check_cpp(block, path):
    return run(["c++", "-std=c++20", "-fsyntax-only", "-Wall", "-Wno-unused", f"-I{ROOT}", f"-I{ROOT}/layer/include",
                "-isystem", "/usr/include/eigen3", "-x", "c++", "-"], input=source_of(block, path))


def check_toml(block, _):
    try:
        tomllib.loads(block.text)
    except tomllib.TOMLDecodeError as error:
        return str(error)
    return None


def check_json(block, path):
    text = block.text.strip()
    try:
        value = json.loads(text if text.startswith("{") else "{" + text + "}")
    except json.JSONDecodeError as error:
        return str(error)
    return check_scene(value) if path.name == "scenes.md" else None


def check_scene(members):
    """What omni scene explain warns of in a glTF document with these members, or None."""
    document = SCENE | members
    if "extensions" in members and "meshes" not in members:
        mesh = document["meshes"][0] | {"extensions": {"MPEG_haptic_material": {"hapticMaterialIndex": 0}}}
        document["meshes"] = [mesh]
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "scene.gltf"
        file.write_text(json.dumps(document))
        done = subprocess.run([BUILD / "bin" / "omni", "scene", "explain", file], capture_output=True, text=True,
                              check=False, timeout=LONG_s, env=os.environ | {"HOME": folder, "XDG_CACHE_HOME": folder})
    warnings = re.findall(r"^warning .*", done.stdout, re.M)
    if "haptic tag" not in done.stdout:
        warnings.append("nothing of it can be touched\n" + done.stdout)
    return done.stderr + "\n".join(warnings) if done.returncode or warnings else None


CHECKS = {"sh": check_shell, "c": check_cpp, "cpp": check_cpp, "toml": check_toml, "json": check_json,
          "text": lambda block, path: None}


def problem_with(path, block):
    kind = kind_of(path, block)
    if kind not in CHECKS:
        return f"{kind} kind of block: give it a fence with one of {', '.join(CHECKS)}"
    return CHECKS[kind](block, path)


class Snippets(unittest.TestCase):
    maxDiff = None

    @classmethod
    def setUpClass(cls):
        if not (BUILD / "bin" / "omni").exists():
            raise AssertionError(f"no bin/omni in {BUILD}: build it, or set OMNI_BINARY_DIR")

    def test_each_block_is_valid(self):
        problems, counts = [], collections.Counter()
        for path in documents():
            for block in split(path.read_text(encoding="utf-8"))[0]:
                counts[kind_of(path, block)] += 1
                if problem := problem_with(path, block):
                    problems.append(f"{where(path, block.line)}: {problem.strip()}")
        print("[ figure   ]", ", ".join(f"{number} {kind}" for kind, number in sorted(counts.items())))
        self.assertEqual("\n".join(problems), "")
        self.assertGreater(counts.total(), 150, "the documents are found and read")

    def test_mistakes_are_found(self):
        for kind, text, mark, message in (
                ("sh", "omni watch | (", "", "syntax error"),
                ("sh", "scripts/tests", "", "there is no scripts/tests"),
                ("sh", "omni wach", "<!-- snippet: run -->", "wach"),
                ("toml", "scale = 1,5", "", "Expected newline"),
                ("json", '"nodes": [...]', "", "Expecting value"),
                ("json", '"nodes": [{"mesh": 0, "extras": {"haptic": {"stiffnes": 1}}}]', "", "did you mean"),
                ("c", "XrResult xrStopForceFeedbackOMNIX1(XrSession session);", "", "static assertion failed"),
                ("c", "typedef struct XrForceFeedbackReachOMNIX1 {int x;} XrForceFeedbackReachOMNIX1;", "",
                 "has no member"),
                ("cpp", "int one() { return two; }", "", "two"),
                (None, "who knows", "", "unknown")):
            with self.subTest(text):
                problem = problem_with(ROOT / "docs" / "scenes.md", Block(1, kind, mark, [text]))
                self.assertIn(message, problem or "no problem")


if __name__ == "__main__":
    unittest.main()
