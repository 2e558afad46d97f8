#!/usr/bin/env python3
"""Checks the Markdown pages of a source tree: check_pages.py ROOT.

- Links lead to files and headings that exist, and docs/README.md leads to every page.
- The glossary defines each term once.
- The README has at most 100 lines, a page of docs/guide at most 1,200 words, all pages together at most 58,000.
- Each C++ or C snippet of the pages about embedding is part of a program in examples/, line by line but for indentation.
  A line of "..." stands for left out lines.
- Each CMake snippet of these pages names targets and components that the sources have.
"""
import pathlib
import re
import sys

SNIPPETS_FROM_EXAMPLES = ["docs/guide/tutorial.md"]
MOST_README_LINES, MOST_GUIDE_WORDS, MOST_WORDS = 100, 1200, 58000


def pages(root):
    return [root / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")] + sorted((root / "docs").rglob("*.md"))


def links(page):
    """Links of a page to files, as they are written, without those in blocks of code."""
    text = re.sub(r"```.*?```", "", page.read_text(), flags=re.S)
    targets = re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text)
    return [target for target in targets if not re.match(r"[a-z]+:", target)]


def broken_links(root):
    for page in pages(root):
        for target in links(page):
            if not (page.parent / target).exists():
                yield f"{page.relative_to(root)}: no file {target}"


def headings(page):
    """The anchors of a page's headings, as GitHub makes them."""
    titles = re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", page.read_text(), flags=re.S), flags=re.M)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def broken_anchors(root):
    for page in pages(root):
        for target, anchor in re.findall(r"\]\(([^)#\s:]*)#([^)\s]+)\)", page.read_text()):
            there = page.parent / target if target else page
            if there.suffix == ".md" and there.exists() and anchor not in headings(there):
                yield f"{page.relative_to(root)}: no heading {target}#{anchor}"


def lost_pages(root):
    """Pages below docs/ that no way of links leads to from its README."""
    lost = {page.resolve() for page in (root / "docs").rglob("*.md")}
    waiting = [root / "docs" / "README.md"]
    while waiting:
        page = waiting.pop().resolve()
        if page in lost:
            lost.remove(page)
            waiting += [page.parent / target for target in links(page)]
    yield from (f"{page.relative_to(root.resolve())}: docs/README.md does not lead here" for page in sorted(lost))


def long_pages(root):
    lines = len((root / "README.md").read_text().splitlines())
    if lines > MOST_README_LINES:
        yield f"README.md: {lines} lines, expected at most {MOST_README_LINES}"
    for page in sorted((root / "docs" / "guide").glob("*.md")):
        words = len(page.read_text().split())
        if words > MOST_GUIDE_WORDS:
            yield f"{page.relative_to(root)}: {words} words, expected at most {MOST_GUIDE_WORDS}"
    words = sum(len(page.read_text().split()) for page in pages(root))
    if words > MOST_WORDS:
        yield f"all pages: {words} words, expected at most {MOST_WORDS}"


def doubled_terms(root):
    """Terms that the glossary defines more than once."""
    rows = re.findall(r"^\| ([^|]+) \|", (root / "docs" / "develop" / "glossary.md").read_text(), flags=re.M)[2:]
    terms = [term.strip("` ") for row in rows for term in row.split(",")]
    yield from (f"docs/develop/glossary.md: {term} is defined twice" for term in sorted(set(terms)) if terms.count(term) > 1)


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
    folders = {path.parent.name for depth in ("*", "*/*") for path in root.glob(depth + "/CMakeLists.txt")}
    for name in SNIPPETS_FROM_EXAMPLES:
        for snippet in re.findall(r"```cmake\n(.*?)```", (root / name).read_text(), flags=re.S):
            for target in re.findall(r"sightline::(\w+)", snippet):
                if target not in folders:
                    yield f"{name}: no folder {target} for sightline::{target}"


def main():
    root = pathlib.Path(sys.argv[1])
    checks = (broken_links, broken_anchors, lost_pages, long_pages, doubled_terms, stray_snippets, unknown_targets)
    problems = [problem for check in checks for problem in check(root)]
    for problem in problems:
        print(problem, file=sys.stderr)
    return 1 if problems else 0


sys.exit(main())
