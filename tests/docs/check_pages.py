#!/usr/bin/env python3
"""Checks the Markdown pages of a source tree: check_pages.py ROOT.

- Links to files of the tree lead to files that exist.
- Each C++ or C snippet of the pages about embedding is part of a program in examples/, line by line but for indentation.
  A line of "..." stands for left out lines.
- Each CMake snippet of these pages names targets and components that the sources have.
"""
import pathlib
import re
import sys

SNIPPETS_FROM_EXAMPLES = ["docs/tutorial.md"]


def pages(root):
    return [root / name for name in ("README.md", "CONTRIBUTING.md")] + sorted((root / "docs").rglob("*.md"))


def broken_links(root):
    for page in pages(root):
        text = re.sub(r"```.*?```", "", page.read_text(), flags=re.S)
        for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text):
            if not re.match(r"[a-z]+:", target) and not (page.parent / target).exists():
                yield f"{page.relative_to(root)}: no file {target}"


def lines_of(text):
    return [line.strip() for line in text.splitlines() if line.strip()]


def is_part(snippet, program):
    """Whether the lines are in the program, in order: those between two "..." one after the other."""
    parts, at = [[]], 0
    for line in snippet:
        if line == "...":
            parts.append([])
        else:
            parts[-1].append(line)
    for part in parts:
        places = range(at, len(program) - len(part) + 1)
        found = next((i for i in places if program[i : i + len(part)] == part), None)
        if found is None:
            return False
        at = found + len(part)
    return True


def stray_snippets(root):
    programs = [lines_of(path.read_text()) for path in sorted((root / "examples").glob("*.c*"))]
    for name in SNIPPETS_FROM_EXAMPLES:
        for language, snippet in re.findall(r"```(cpp|c)\n(.*?)```", (root / name).read_text(), flags=re.S):
            if not any(is_part(lines_of(snippet), program) for program in programs):
                yield f"{name}: no example has this {language} snippet:\n{snippet}"


def unknown_targets(root):
    folders = {path.parent.name for path in root.glob("*/CMakeLists.txt")}
    for name in SNIPPETS_FROM_EXAMPLES:
        for snippet in re.findall(r"```cmake\n(.*?)```", (root / name).read_text(), flags=re.S):
            for target in re.findall(r"sightline::(\w+)", snippet):
                if target not in folders:
                    yield f"{name}: no folder {target} for sightline::{target}"


def main():
    root = pathlib.Path(sys.argv[1])
    problems = [*broken_links(root), *stray_snippets(root), *unknown_targets(root)]
    for problem in problems:
        print(problem, file=sys.stderr)
    return 1 if problems else 0


sys.exit(main())
