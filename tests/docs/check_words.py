#!/usr/bin/env python3
"""Checks words of sources and pages: check_words.py ROOT.

- No comment begins as a fragment: "Of …", "The same …", "Those of …", "That of …", "Told …". It is a sentence of its own.
- Words of our own that the field has terms for do not come back; REPLACED names the terms.
- Nor do names of our own in code, outside its comments and texts; RENAMED says what they are called.
"""
import os
import pathlib
import re
import sys

SOURCES = {".h", ".cpp", ".c", ".inc", ".glsl", ".vert", ".geom", ".frag", ".comp", ".py", ".pyi", ".sh", ".js", ".mjs", ".cmake",
           ".in", ".txt"}
SKIPPED = {".git", "build", "out", "node_modules"}
FRAGMENT = re.compile(r"^[ \t]*(?://+!?<?|#|\*)\s?(Of (?!Open\b)|The same\b|Those (?:of|that)\b|That of\b|Made by who\b|Told\b)", re.M)
# In lower case. Rules begin with letters, so that a search skips to them.
REPLACED = {
    r"rehears\w*": "warm up, warm-up",
    r"nearness\b": "reciprocal depth",
    r"stand-ins?\b": "placeholder",
    r"anyhow\b": "write the sentence anew",
    r"count not\b(?! at)": "do not count",
    r"for_people\b": "standard",
    r"relief\b": "depth shading, edge lines",
    r"owners? of pixels\b": "visible in the id image",
}
RENAMED = {
    r"\w*[Ff]igures\w*": "results, times, counts, statistics: what they are",
    r"Squares?|SquareRule|BoxSquares": "point splat; tile or cell",
    r"landings?|k?Landing": "new scene version, swapped in",
    r"coming_?": "incoming",
}
CODE = {".h", ".cpp", ".c", ".inc", ".js", ".mjs", ".glsl", ".vert", ".geom", ".frag", ".comp"}
# Comments and texts of code, which are left out, and names.
TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|([A-Za-z_]\w*)', re.S)
# The words of these rules themselves, and what names were before.
EXEMPT = {"tests/docs/check_words.py", "CHANGELOG.md"}


def files(root):
    for folder, folders, names in os.walk(root):
        folders[:] = sorted(set(folders) - SKIPPED)
        for path in (pathlib.Path(folder, name) for name in sorted(names)):
            if path.suffix in SOURCES | {".md"} and path.relative_to(root).as_posix() not in EXEMPT:
                yield path


def line_of(text, at):
    return text.count("\n", 0, at) + 1


def old_words(root):
    words = [(re.compile(word), term) for word, term in REPLACED.items()]
    for path in files(root):
        text = path.read_text(errors="replace")
        place = path.relative_to(root).as_posix()
        if path.suffix != ".md":
            for found in FRAGMENT.finditer(text):
                yield f"{place}:{line_of(text, found.start(1))}: a comment that begins with '{found[1]}' is no sentence"
        lower = text.lower()
        for word, term in words:
            for found in word.finditer(lower):
                yield f"{place}:{line_of(lower, found.start())}: '{found[0]}': {term}"


def old_names(root):
    names, terms = re.compile("|".join(f"({name})" for name in RENAMED)), list(RENAMED.values())
    for path in files(root):
        place = path.relative_to(root).as_posix()
        if path.suffix not in CODE:
            continue
        text = path.read_text(errors="replace")
        if not any(names.fullmatch(word) for word in set(re.findall(r"\w+", text))):
            continue
        for token in TOKEN.finditer(text):
            found = token[1] and names.fullmatch(token[1])
            if found:
                yield f"{place}:{line_of(text, token.start())}: '{found[0]}': {terms[found.lastindex - 1]}"


def main():
    root = pathlib.Path(sys.argv[1])
    found = [*old_words(root), *old_names(root)]
    for problem in found:
        print(problem, file=sys.stderr)
    return 1 if found else 0


sys.exit(main())
