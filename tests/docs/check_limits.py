"""Checks the sizes of classes and functions outside tests/ and apps/study/: check_limits.py REPOSITORY.

A class has at most 25 data members and 35 functions, a function at most 60 lines of code and six parameters. EXCEPTIONS names what
exceeds a limit, and why. An entry whose thing no longer exceeds it, or has grown since, fails too.

The scanner reads the source as clang-format lays it out, without expanding macros.
"""
import pathlib
import re
import sys

MEMBERS, FUNCTIONS, LINES, PARAMETERS = "data members", "functions", "lines", "parameters"
LIMITS = {MEMBERS: 25, FUNCTIONS: 35, LINES: 60, PARAMETERS: 6}
# The limit, "folder name" as a regular expression, the largest size, and the reason.
EXCEPTIONS = [
    (FUNCTIONS, "engine Engine", 62, "the façade"),
    (FUNCTIONS, "core Scene", 101, "the model's edits and questions, of which most are a line"),
    (MEMBERS, "core Scene", 28, "its arrays, which append() takes over one by one"),
    (FUNCTIONS, "core Snapshot", 53, "accessors of its arrays"),
    (FUNCTIONS, "core LargeArray", 41, "what std::vector has"),
    (FUNCTIONS, "importers/json Value", 74, "operators and conversions for each type of number"),
    (FUNCTIONS, "culling/frustum (Avx2|Avx512|Scalar|Simd128)", 49, "one function for each instruction"),
    (FUNCTIONS, "importers/slc PagedPart", 40, "a file with pages, and what is checked of each array"),
    (LINES, r"raytrace (enter_lanes|Packets::walk_together|Solids::\w+)", 65, "kernels whose values stay in registers"),
    (PARAMETERS, r"bindings/(c|wasm) sl_\w+", 9, "C has no default values and no overloads"),
    (MEMBERS, "bindings/c sl_import_report", 30, "flat, as structs of C grow at their end"),
    (PARAMETERS, r"bindings/python \w+(: lambda)?", 10, "keyword arguments of Python"),
    (LINES, r"bindings/python bind_\w+", 82, "a list of bindings"),
    (PARAMETERS, "core View::asymmetric", 7, "a pose and the six sides, as glFrustum() has them"),
    (PARAMETERS, "core fitting_of", 7, "a direction and a lens, of which most calls leave out three"),
    (PARAMETERS, "culling/queries rectangle_view", 7, "a view, its size and two corners"),
    (PARAMETERS, "gl on_message", 7, "GL's own callback"),
    (PARAMETERS, "gl Texture2D::create", 7, "GL's own description of a texture"),
    (PARAMETERS, "culling/occlusion InnerOccluders::InnerOccluders", 8, "a solid, its placement and where occluders go"),
    (PARAMETERS, "culling/occlusion (inner_occluders_of|add_inner_occluders|add_fronts)", 7, "the same three"),
    (PARAMETERS, "culling/occlusion (DepthTest::DepthTest|OcclusionTest::OcclusionTest)", 7, "an image, its depths and errors"),
]
SKIPPED = {"build", "out", "tests", "study", "node_modules"}
TOKEN = re.compile(
    r"""(?P<none>//[^\n]*|/\*.*?\*/|^[ \t]*\#(?:[^\n\\]|\\.)*)
      |(?P<text>R"(?P<mark>[^(]*)\(.*?\)(?P=mark)"|"(?:\\.|[^"\\])*"|(?<![0-9a-fA-F])'(?:\\.|[^'\\])+')
      |(?P<word>[A-Za-z_]\w*|\d[\w.']*)|(?P<sign>::|->|<=>|<=|>=|==|&&|\[\[|\]\]|[^\s\w])""",
    re.S | re.M | re.X)
BRANCH = re.compile(r"^[ \t]*#[ \t]*(if|el|endif)")
CLASSES = {"class", "struct", "union"}
NO_MEMBERS = CLASSES | {"using", "typedef", "friend", "static_assert", "enum", ";"}
NAME = re.compile(r"(?:\w+ :: )*(?:operator.*|(?:~ )?(?!alignas|decltype|explicit|requires)\b\w+)$")
CLOSING = {"(": ")", "[": "]", "{": "}", "[[": "]]"}


def tokens(text):
    """(token, line) of the code; of alternatives of the preprocessor, the first."""
    found, line, at, skipped = [], 1, 0, [False]
    for match in TOKEN.finditer(text):
        line += text.count("\n", at, match.start())
        at = match.start()
        branch = match["none"] and BRANCH.match(match["none"])
        if branch and branch[1] == "if":
            skipped.append(skipped[-1])
        elif branch and branch[1] == "el":
            skipped[-1] = True
        elif branch:
            skipped.pop()
        elif not match["none"] and not skipped[-1]:
            found.append(('""' if match["text"] else match[0], line))
    return found


class Source:
    """Calls report(limit, name, size, line) for each class and function of a file."""

    def __init__(self, text, report):
        self.code = tokens(text)
        self.report = report
        self.at = 0  # the index of the token that is read next

    def balanced(self, at):
        """The index behind the bracket that closes the one at `at`."""
        opened, depth = self.code[at][0], 0
        for index in range(at, len(self.code)):
            depth += (self.code[index][0] == opened) - (self.code[index][0] == CLOSING[opened])
            if depth == 0:
                return index + 1
        raise ValueError(f"line {self.code[at][1]}: '{opened}' is never closed")

    def behind(self, index):
        """The index of the next token outside of brackets and lists of template arguments."""
        if self.code[index][0] in CLOSING:
            return self.balanced(index)
        depth, end = 0, index
        while self.code[end][0] not in (";", "{", "}", ")", "&&") or end == index:
            depth += (self.code[end][0] == "<") - (self.code[end][0] == ">")
            if depth <= 0:
                return end + 1
            end = self.balanced(end) if self.code[end][0] in CLOSING else end + 1
        return index + 1  # a comparison

    def count(self, begin):
        """How many parts commas make of what the bracket at `begin` holds."""
        commas, index, end = 0, begin + 1, self.balanced(begin) - 1
        while index < end:
            commas += self.code[index][0] == ","
            index = self.behind(index)
        return commas + (end > begin + 1)

    def body(self, name):
        """Passes over a function's body, and reports it and the lambdas in it."""
        begin, self.at = self.at, self.balanced(self.at)
        self.report(LINES, name, len({line for _, line in self.code[begin + 1:self.at - 1]}), self.code[begin][1])
        for index in range(begin, self.at - 1):
            if self.code[index][0] == "]" and self.code[index + 1][0] == "(":
                if self.code[self.balanced(index + 1)][0] in ("{", "->", "mutable", "noexcept"):
                    self.report(PARAMETERS, f"{name}: lambda", self.count(index + 1), self.code[index][1])

    def scope(self, name, sizes=None):
        """Passes over declarations and the bracket that closes their scope; sizes: those of a class so far, by limit."""
        while self.at < len(self.code) and self.code[self.at][0] != "}":
            self.declaration(name, sizes)
        self.at += 1

    def declaration(self, scope, sizes):
        words = []  # without what brackets hold
        name = None  # of a function
        commas = 0
        while self.at < len(self.code) and self.code[self.at][0] != "}":
            token, line = self.code[self.at]
            if token == "{":
                if self.brace(scope, sizes, words, name):
                    return
            elif token == "template":
                self.at = self.behind(self.at + 1)
            elif words[-1:] == ["operator"]:
                words[-1] += token
                self.at = self.balanced(self.at) if token in CLOSING else self.at + 1
            else:
                named = NAME.search(" ".join(words))
                if token == "(" and name is None and "=" not in words and named and self.code[self.at + 1][0] != "*":
                    name = joined(scope, named[0].replace(" ", ""))
                    self.report(PARAMETERS, name, self.count(self.at), line)
                commas += token == ","
                if token != "<":
                    words.append(token)
                self.at = self.behind(self.at)
                if token == ":" and words[0] in ("public", "private", "protected"):
                    return
                if token == ";":
                    break
        if sizes is not None and words and words[0] not in NO_MEMBERS:
            if name is not None:
                sizes[FUNCTIONS] += words[-2] not in ("default", "delete")
            elif "static" not in words:
                sizes[MEMBERS] += 1 + commas

    def brace(self, scope, sizes, words, name):
        """Passes over what a brace opens; true if a declaration ends with it."""
        before = self.code[self.at - 1][0]
        initialises = ":" in words and re.match(r"[\w>]", before) and before not in ("const", "noexcept", "override")
        if name is not None and not initialises:
            self.body(name)
            if sizes is not None:
                sizes[FUNCTIONS] += 1
            return True
        if "namespace" in words or words == ["extern", '""']:
            self.at += 1
            self.scope(scope)
            return True
        if name is None and CLASSES & set(words) and not {"enum", "="} & set(words):
            line = self.code[self.at][1]
            head = words[:words.index(":")] if ":" in words else words
            name = joined(scope, [word for word in head if re.match(r"\w", word) and word != "final"][-1])
            self.at += 1
            inner = {MEMBERS: 0, FUNCTIONS: 0}
            self.scope(name, inner)
            for limit, size in inner.items():
                self.report(limit, name, size, line)
            words.clear()  # What may follow is a member of this class.
            return False
        self.at = self.balanced(self.at)
        return False


def joined(scope, name):
    return f"{scope}::{name}" if scope else name


def main(root):
    found = {}
    for path in sorted(path for suffix in ("h", "cpp", "h.in") for path in root.rglob("*." + suffix)):
        place = path.relative_to(root)
        if SKIPPED & set(place.parts):
            continue
        room = place.parent.as_posix().removesuffix("/internal").removesuffix("/detail")

        def report(limit, name, size, line):
            if size > LIMITS[limit]:
                found.setdefault((limit, f"{room} {name}"), []).append((size, f"{place}:{line}"))

        Source(path.read_text(), report).scope("")
    wrong = []
    for (limit, name), sizes in found.items():
        allowed = max([LIMITS[limit], *(size for other, names, size, _ in EXCEPTIONS if other == limit and re.fullmatch(names, name))])
        wrong += [f"{where}: {name} has {size} {limit}, and at most {allowed} are allowed" for size, where in sizes if size > allowed]
    for limit, names, size, _ in EXCEPTIONS:
        most = max((size for (other, name), sizes in found.items() if other == limit and re.fullmatch(names, name) for size, _ in sizes), default=0)
        if most < size:
            wrong.append(f"EXCEPTIONS: {names} may have {size} {limit} and has {most or 'no more than others'}")
    for line in wrong:
        print(line, file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
