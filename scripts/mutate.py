#!/usr/bin/env python3
"""Mutation testing: breaks one line of a file at a time and runs the tests, which should notice.

  scripts/mutate.sh core/joints.cpp                        mutants of one file, against the tests of core
  scripts/mutate.sh --minutes 20 --seed 2 culling/*/*.cpp  a random choice of all of them
  scripts/mutate.sh render/shaders/shading.glsl:27,30-32   those lines only

Mutants: relations (< becomes <=), arithmetic (+ becomes -), logic (&& becomes ||), constants (one more, one less, zero,
the other sign), negated conditions, dropped statements. Asserts are no part of a release build and stay as they are. One
that does not compile does not count; one whose tests take five times as long as the tests of the unbroken tree is
killed. Everything happens in a copy of the tree, build/mutants, which stays for the next run; the tree itself is never
touched.
"""
import argparse
import difflib
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
COPY = ROOT / "build" / "mutants"

# clang-format puts spaces around binary operators, so "a < b" is a relation and "vector<int>" is not.
SWAPS = {" < ": [" <= ", " >= "], " <= ": [" < "], " > ": [" >= ", " <= "], " >= ": [" > "], " == ": [" != "],
         " != ": [" == "], " + ": [" - "], " - ": [" + "], " * ": [" / "], " / ": [" * "], " && ": [" || "],
         " || ": [" && "], " += ": [" -= "], " -= ": [" += "], "++": ["--"], " % ": [" / "]}
NUMBER = re.compile(r"(?<![\w.])(\d[\d']*\.?\d*(?:[eE][-+]?\d+)?)(?=[fuULl]*\b|[^\w.]|$)")
STATEMENT = re.compile(r"^\s+(?!return\b|using\b|const\b|constexpr\b|static\b|auto\b|throw\b|case\b|break\b|continue\b)"
                       r"[\w.:\[\]\->*()]+(?: [-+*/|&^]?= |\(|\+\+|--).*;$")
CONDITION = re.compile(r"\b(?:if|while) \(")


def code_of(line):
    """The line with the insides of strings, alignments and its comment blanked, at the same columns."""
    line = re.sub(r"alignas\(\d+\)", lambda m: "_" * len(m.group()), line)
    line = re.sub(r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])\'', lambda m: "_" * len(m.group()), line)
    return re.sub(r"//.*", lambda m: " " * len(m.group()), line)


def closing(code, start):
    """Column of the parenthesis that closes the one at `start`; None when it is on another line."""
    depth = 0
    for column in range(start, len(code)):
        depth += {"(": 1, ")": -1}.get(code[column], 0)
        if depth == 0:
            return column
    return None


def variants(number):
    digits = number.replace("'", "")
    if re.fullmatch(r"\d+", digits):
        return {str(n) for n in (int(digits) + 1, int(digits) - 1, 0, -int(digits))} - {digits}
    value = float(digits)
    return {repr(v) for v in (value + 1.0, value - 1.0, 0.0, -value) if v != value}


def mutants_of(lines, chosen):
    """(line index, what was done, mutated line) for every mutant."""
    comment = False
    for i, line in enumerate(lines):
        code = code_of(line)
        text = code.strip()
        if comment or text.startswith("/*"):
            comment = "*/" not in text
            continue
        if (chosen and i + 1 not in chosen) or re.match(r"$|#|namespace|template|static_assert|assert\(|layout", text):
            continue
        for old, replacements in SWAPS.items():
            for at in [m.start() for m in re.finditer(re.escape(old), code)]:
                for new in replacements:
                    yield i, f"{old.strip()} to {new.strip()}", line[:at] + new + line[at + len(old):]
        for number in NUMBER.finditer(code):
            for new in sorted(variants(number.group(1))):
                yield i, f"{number.group(1)} to {new}", line[:number.start()] + new + line[number.end():]
        for condition in CONDITION.finditer(code):
            start = condition.end() - 1
            end = closing(code, start)
            if end is not None and ";" not in code[start:end]:
                yield i, "negated", f"{line[:start]}(!{line[start:end + 1]}){line[end + 1:]}"
        before = next((code_of(l).strip() for l in reversed(lines[:i]) if code_of(l).strip()), ";")
        if STATEMENT.match(code.rstrip()) and before[-1] in ";{}:":
            yield i, "dropped", re.match(r"\s*", line).group() + ";"


def synchronise():
    """Makes the copy equal to the tree. Unchanged files keep their times, so that little is built."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True,
                            check=True).stdout.split("\n")
    names = {name for name in listed if name and (ROOT / name).is_file()}
    for name in names:
        target = COPY / name
        if not target.is_file() or target.read_bytes() != (ROOT / name).read_bytes():
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, target)
    for path in [p for p in COPY.rglob("*") if p.is_file()]:
        name = path.relative_to(COPY)
        if name.parts[0] != "build" and str(name) not in names:
            path.unlink()


def run(command, limit=None):
    """The exit status, None after `limit` seconds, and what was printed."""
    process = subprocess.Popen(command, cwd=COPY, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                               errors="replace", start_new_session=True)
    try:
        printed, _ = process.communicate(timeout=limit)
        return process.returncode, printed
    except subprocess.TimeoutExpired:
        return None, ""
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def parse_file(argument):
    """FILE or FILE:LINE,FIRST-LAST."""
    name, _, lines = argument.partition(":")
    chosen = set()
    for part in filter(None, lines.split(",")):
        first, _, last = part.partition("-")
        chosen |= set(range(int(first), int(last or first) + 1))
    path = pathlib.Path(name).resolve()
    if not path.is_file() or ROOT not in path.parents:
        sys.exit(f"mutate: {name}: no such file in this tree")
    return str(path.relative_to(ROOT)), chosen


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE[:LINE,FIRST-LAST]")
    parser.add_argument("--minutes", type=float, default=10, help="budget, of trying mutants (default 10)")
    parser.add_argument("--seed", type=int, default=1, help="of the order in which they are tried (default 1)")
    parser.add_argument("--tests", help="ctest's -R (default: the tests of the files' folders)")
    parser.add_argument("--targets", nargs="+", help="what to build (default: the test programs of these folders)")
    parser.add_argument("--json", help="write the report to this file")
    args = parser.parse_args()
    files = [parse_file(argument) for argument in args.files]

    synchronise()
    ccache = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    status, printed = run(["cmake", "--preset", "release", *ccache])
    if status != 0:
        sys.exit(f"mutate: cannot be configured\n{printed}")
    known = run(["ninja", "-C", "build/release", "-t", "targets", "all"])[1]
    programs = {name: [t for t in (f"{name}_tests", f"{name}_gl_tests") if f"\n{t}: " in known]
                for name in {part for file, _ in files for part in file.split("/")[:-1]}}
    # A file's tests are named after the innermost of its folders that has some: analysis/measure is measure.
    folders = sorted({next((part for part in reversed(name.split("/")[:-1]) if programs[part]), "") for name, _ in files})
    if "" in folders and not (args.targets and args.tests):
        sys.exit("mutate: no test programs named after a folder of every file; give --targets and --tests")
    tests = args.tests or f"^({'|'.join(folders)})(_gl)?\\."
    targets = args.targets or [target for name in folders for target in programs[name]]
    build = ["ninja", "-C", "build/release", *targets]
    test = ["ctest", "--test-dir", "build/release", "-j2", "--stop-on-failure", "--no-tests=error", "-R", tests]
    status, printed = run(build)
    if status != 0:
        sys.exit(f"mutate: the tree itself cannot be built\n{printed[-3000:]}")
    start = time.monotonic()
    status, printed = run(test)
    if status != 0:
        sys.exit(f"mutate: the tests fail without a mutant\n{printed[-3000:]}")
    limit = max(30.0, 5.0 * (time.monotonic() - start))

    candidates = []
    for name, chosen in files:
        lines = (COPY / name).read_text().split("\n")
        candidates += [(name, *mutant) for mutant in mutants_of(lines, chosen)]
    random.Random(args.seed).shuffle(candidates)
    print(f"{len(candidates)} mutants, seed {args.seed}, tests {tests}", flush=True)

    report = {"seed": args.seed, "tests": tests, "mutants": len(candidates), "tried": 0, "killed": 0, "survivors": []}
    end = time.monotonic() + 60.0 * args.minutes
    for name, index, what, mutated in candidates:
        if time.monotonic() > end:
            break
        file = COPY / name
        whole = file.read_text()
        lines = whole.split("\n")
        place = f"{name}:{index + 1}"
        try:
            file.write_text("\n".join(lines[:index] + [mutated] + lines[index + 1:]))
            status, _ = run(build, 600)
            if status != 0:
                print(f"no build  {place}  {what}", flush=True)
                continue
            status, _ = run(test, limit)
        finally:
            file.write_text(whole)
        report["tried"] += 1
        report["killed"] += status != 0
        print(f"{'survived' if status == 0 else 'killed  '}  {place}  {what}", flush=True)
        if status == 0:
            diff = "\n".join(difflib.unified_diff([lines[index]], [mutated], place, what, lineterm="", n=0))
            report["survivors"].append({"place": place, "what": what, "diff": diff})
    for survivor in report["survivors"]:
        print("\n" + survivor["diff"])
    print(f"\n{report['killed']} killed of {report['tried']} tried")
    if args.json:
        pathlib.Path(args.json).write_text(json.dumps(report, indent=1) + "\n")


if __name__ == "__main__":
    main()
