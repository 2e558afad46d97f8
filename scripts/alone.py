#!/usr/bin/env python3
"""Compiles sources and public headers alone, without code: proves that each includes what it uses though builds compile
batches.

  scripts/alone.py BUILD [--compiler clang++] [--slice N/COUNT] [--changed COMMITS]

BUILD is a configured build tree. --slice checks every COUNT-th source alone, from the N-th (1) on; --changed adds those
that the last COMMITS commits changed, which break most often. Prints the compiler's errors and exits 1 when there are any.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys


# What g++ was configured with and clang does not know is no fault: its options, the warnings that it does not have, and
# quadmath.h, which lies among g++'s own headers and is taken from there after clang's own.
GCC_HEADERS = subprocess.run(["gcc", "-print-file-name=include"], capture_output=True, text=True).stdout.strip()
CLANG_OPTIONS = ("-Wno-unknown-warning-option -Wno-ignored-optimization-argument -Wno-bitwise-instead-of-logical "
                 f"-idirafter {GCC_HEADERS} ")


def sources_and_commands(build, compiler):
    """(source, folder, command) of each source: batches stand for those that they include."""
    for entry in json.loads((build / "compile_commands.json").read_text()):
        file = pathlib.Path(entry["file"])
        command = re.sub(r" -o \S+ -c \S+$", " -fsyntax-only -O0 ", entry["command"])
        command = re.sub(r"^\S*ccache ", "", command)
        if compiler and file.suffix != ".c":
            command = re.sub(r"^\S+", compiler, command) + (CLANG_OPTIONS if "clang" in compiler else "")
        if re.fullmatch(r"unity_\d+_c(xx)?\.c(xx)?", file.name):
            for source in re.findall(r'^#include "(.+)"', file.read_text(), re.M):
                yield source, entry["directory"], command
        else:
            yield str(file), entry["directory"], command


def changed_files(commits):
    """Files of the checkout that the last commits changed, as absolute paths; all history where it is shorter."""
    since = subprocess.run(["git", "rev-list", f"--max-count={commits + 1}", "HEAD"], capture_output=True, text=True, check=True)
    files = subprocess.run(["git", "diff", "--name-only", since.stdout.split()[-1], "HEAD"], capture_output=True, text=True, check=True)
    return {str(pathlib.Path(file).resolve()) for file in files.stdout.splitlines()}


def check(job):
    source, folder, command = job
    done = subprocess.run(f"{command} '{source}'", shell=True, cwd=folder, capture_output=True, text=True)
    return done.returncode == 0, source, done.stderr


def main():
    line = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    line.add_argument("build", type=pathlib.Path)
    line.add_argument("--compiler")
    line.add_argument("--slice", default="1/1", type=lambda text: tuple(map(int, text.split("/"))))
    line.add_argument("--changed", type=int, default=0)
    options = line.parse_args()
    first, step = options.slice
    everything = sorted(set(sources_and_commands(options.build, options.compiler)))
    changed = changed_files(options.changed) if options.changed else set()
    jobs = [job for index, job in enumerate(everything) if index % step == first - 1 or job[0] in changed]
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for passed, source, errors in pool.map(check, jobs):
            if not passed:
                failed += 1
                print(f"{source} does not compile alone:\n{errors}", file=sys.stderr)
    print(f"{len(jobs) - failed} of {len(jobs)} sources compile alone")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
