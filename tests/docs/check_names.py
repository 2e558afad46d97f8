#!/usr/bin/env python3
"""Checks that what the Markdown pages of a source tree name still exists: check_names.py ROOT.

- Paths and names of source files, wherever they stand. A page may leave out leading folders. Upper case, <thing> and x stand for any name.
- Tools (sightline-*) and subcommands of sightline-bench and sightline-study.
- Names of C++ in backticks that have "::" or begin with k, as constants do.
- Options of tools in code: those beside a tool's name in this tool's sources, all others in any tool or script.
- Names that begin with SIGHTLINE_: options of CMake, variables of the environment.
- Pages that sources name: docs/….md.

Lines with "→" say what a name was before, and are left out.
"""
import fnmatch
import os
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "cmake"))
import settings  # noqa: E402

SKIPPED = {".git", "build", "out", "node_modules", "__pycache__"}
MADE = ("build/", "gpu-kit/")
SOURCE = r"h|cpp|inc|glsl|vert|geom|frag|comp|py|pyi|sh|js|mjs|cmake|slurm"
PATH = re.compile(r"(?<![\w./:$…@'-])(?!\.\.)[\w.*<>-]+(?:/[\w.*<>-]+)*")
PLACEHOLDER = re.compile(r"<\w+>|\b[A-Z][A-Z0-9_]*(?![\w.])|\bx(?=[_.]|$)")
CODE = re.compile(r"```\w*\n(.*?)```|`([^`]+)`|^ {4}(\S.*)$", re.S | re.M)
TOOL = re.compile(r"\b(sightline-[a-z]+(?:-[a-z]+)*)\b(?!\.\w)")
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z0-9-]+")
SUBCOMMAND = re.compile(r'(?:\{(?="[^{}]*\badd_\w+\})|subcommand\()"([a-z][a-z-]+)"')
WITH_SUBCOMMANDS = {"sightline-bench": "apps/bench", "sightline-study": "apps/study"}
# Where a tool declares options, beside apps/NAME.cpp, apps/NAME/ and what all tools share.
SHARED = ["apps/common", "apps/mpi", "apps/paged_replay.cpp"]
ELSEWHERE = {"sightline-stability": ["apps/bench/stability"], "sightline-bench": ["apps/bench"], "sightline-study": ["apps/study", "apps/bench"]}


class Tree:
    """The files of the tree, and their texts."""

    def __init__(self, root):
        self.root = root
        self.files, self.folders = set(), set()
        for folder, folders, names in os.walk(root):
            folders[:] = [name for name in folders if name not in SKIPPED]
            at = pathlib.Path(folder).relative_to(root).as_posix()
            prefix = "" if at == "." else at + "/"
            self.folders.add(at)
            self.files |= {prefix + name for name in names}
        self.paths = sorted(self.files | self.folders)
        self.top = {path for path in self.folders if "/" not in path} - {"."}

    def pages(self):
        return sorted(path for path in self.files if path.endswith(".md"))

    def text(self, *places):
        """All that stands in the files that are, or lie below, these places."""
        chosen = (path for path in sorted(self.files) if any(path == place or path.startswith(place + "/") for place in places))
        return "\n".join((self.root / path).read_text(errors="replace") for path in chosen if not path.endswith(".md"))

    def has(self, path):
        """Whether a path, or a pattern of one, is that of a file or folder, or the end of one."""
        if not re.search(r"[*?]", path):
            return path in self.files or path in self.folders or any(known.endswith("/" + path) for known in self.paths)
        return any(fnmatch.fnmatch(known, path) or fnmatch.fnmatch(known, "*/" + path) for known in self.paths)


def stale_paths(tree, page, text):
    for name in PATH.findall(text):
        path = re.sub(r"^(?:\./|sightline/(?=\w+/))", "", name.rstrip("./"))
        names_file = re.search(rf"\.({SOURCE})$", path)
        if not path.startswith(MADE) and (names_file or ("/" in name and path.split("/")[0] in tree.top)):
            pattern = PLACEHOLDER.sub("*", path)
            if not tree.has(pattern) and not tree.has(pattern.removeprefix("sightline/") + ".in"):
                yield f"{page}: nothing in the tree is {name}"


def known_options(tree, tool):
    name = tool.removeprefix("sightline-")
    text = tree.text(f"apps/{name}.cpp", f"apps/{name}", *SHARED, *ELSEWHERE.get(tool, []))
    listed = {"--" + setting.name.replace("_", "-") for setting in settings.read(tree.root / "engine/internal/settings.inc")[1]}
    return set(re.findall(r'"(--[a-z][a-z0-9-]+)', text)) | listed | {"--help", "--help-all", "--version"}


class Names:
    """What tools there are, and what they take."""

    def __init__(self, tree):
        self.tree = tree
        builds = "\n".join((tree.root / path).read_text(errors="replace") for path in sorted(tree.files)
                           if path.endswith((".txt", ".cmake", ".in", "package.json")) or path.startswith(("scripts/", "cmake/")))
        self.tools = set(TOOL.findall(builds)) | {"sightline-" + name for name in re.findall(r"sightline_tool\((\w+)", builds)}
        self.subcommands = {tool: set(SUBCOMMAND.findall(tree.text(place))) for tool, place in WITH_SUBCOMMANDS.items()}
        self.options = {}
        self.any_option = set(OPTION.findall(tree.text("apps", "scripts", "tests", ".ci", "bindings/wasm")))
        everything = tree.text(*tree.top, *tree.files)
        self.words = set(re.findall(r"\w+", everything))
        self.pages = set(re.findall(r"\bdocs/[\w/-]+\.md\b", everything))

    def of(self, tool):
        if tool not in self.options:
            self.options[tool] = known_options(self.tree, tool)
        return self.options[tool]


def stale_commands(names, page, code):
    """Looks at one line of code, or at what stands in one pair of backticks."""
    for tool in TOOL.findall(code):
        if tool not in names.tools and "pkg-config" not in code:
            yield f"{page}: no tool {tool}"
    for part in re.split(r"[|;&]|(?= sightline-)", code.split("#")[0]):
        tool = TOOL.search(part)
        foreign = not tool and not part.strip().startswith(("--", "scripts/"))
        if foreign or (tool and tool[1] not in names.tools):
            continue
        allowed = names.of(tool[1]) if tool and not part.strip().startswith("scripts/") else names.any_option
        for option in OPTION.findall(part):
            if option not in allowed:
                yield f"{page}: {tool[1] if tool else 'no tool'} has no option {option}" if tool else f"{page}: no tool has the option {option}"
        word = re.search(rf"^{tool[1]} ([a-z][a-z-]+)(?=\s|$)", part.strip()) if tool and tool[1] in WITH_SUBCOMMANDS else None
        if word and word[1] not in names.subcommands[tool[1]]:
            yield f"{page}: {tool[1]} has no subcommand {word[1]}"


def stale_names(names, page, text):
    table = re.search(r"^## [^\n]*`(sightline-\w+)`\n\n(\|.*?)\n\n", text, re.M | re.S)
    if table and table[1] in names.subcommands:
        rows = re.findall(r"^\| `([a-z-]+)` \|", table[2], re.M)
        yield from (f"{page}: {table[1]} has no subcommand {row}" for row in rows if row not in names.subcommands[table[1]])
    for block, span, indented in CODE.findall(text):
        for line in (block.splitlines() if block else [span.replace("\n", " ") or indented]):
            yield from stale_commands(names, page, line)
        if re.search(r"::|^k[A-Z]\w+$", span):
            yield from (f"{page}: nothing is named {word} ({span})" for word in re.findall(r"\b[A-Za-z]\w+", span) if word not in names.words)
    for variable in re.findall(r"\bSIGHTLINE_\w*[A-Z]\b", text):
        if variable not in names.words:
            yield f"{page}: nothing is named {variable}"


def main():
    tree = Tree(pathlib.Path(sys.argv[1]))
    names = Names(tree)
    problems = [f"sources name {page}, which is no page" for page in sorted(names.pages) if not tree.has(page)]
    for page in tree.pages():
        text = "\n".join(line for line in (tree.root / page).read_text().splitlines() if "→" not in line)
        problems += dict.fromkeys([*stale_paths(tree, page, text), *stale_names(names, page, text)])
    for problem in problems:
        print(problem, file=sys.stderr)
    return 1 if problems else 0


sys.exit(main())
