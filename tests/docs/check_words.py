#!/usr/bin/env python3
"""Checks words of sources and pages: check_words.py ROOT.

- No comment begins as a fragment: "Of …", "The same …", "Those of …", "That of …", "Told …". It is a sentence of its own.
- Words of our own that the field has terms for do not come back; REPLACED names the terms.
"""
import pathlib
import re
import sys

SOURCES = {".h", ".cpp", ".c", ".inc", ".glsl", ".vert", ".geom", ".frag", ".comp", ".py", ".pyi", ".sh", ".js", ".mjs", ".cmake",
           ".in", ".txt"}
SKIPPED = {".git", "build", "out", "node_modules"}
FRAGMENT = re.compile(r"^\s*(?://+!?<?|#|\*)\s?(Of [a-z]|The same\b|Those (?:of|that)\b|That of\b|Made by who\b|Told\b)")
REPLACED = {
    r"\brehears\w*": "warm up, warm-up",
    r"\bnearness\b": "reciprocal depth",
    r"\bstand-ins?\b": "placeholder",
    r"\banyhow\b": "write the sentence anew",
    r"\bcount not\b(?! at)": "do not count",
    r"\bfor_people\b": "standard",
    r"\brelief\b": "depth shading, edge lines",
    r"\bowners? of pixels\b": "visible in the id image",
}
# The words of these rules themselves, and what names were before.
EXEMPT = {"tests/docs/check_words.py", "CHANGELOG.md"}


def files(root):
    for path in sorted(root.rglob("*")):
        parts = path.relative_to(root).parts
        if path.is_file() and not SKIPPED & set(parts) and path.suffix in SOURCES | {".md"} and "/".join(parts) not in EXEMPT:
            yield path


def problems(root):
    words = [(re.compile(word, re.IGNORECASE), term) for word, term in REPLACED.items()]
    for path in files(root):
        for number, line in enumerate(path.read_text(errors="replace").splitlines(), 1):
            place = f"{path.relative_to(root)}:{number}"
            fragment = path.suffix != ".md" and FRAGMENT.match(line)
            if fragment:
                yield f"{place}: a comment that begins with '{fragment[1]}' is no sentence"
            for word, term in words:
                found = word.search(line)
                if found:
                    yield f"{place}: '{found[0]}': {term}"


def main():
    root = pathlib.Path(sys.argv[1])
    found = list(problems(root))
    for problem in found:
        print(problem, file=sys.stderr)
    return 1 if found else 0


sys.exit(main())
