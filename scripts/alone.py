#!/usr/bin/env python3
"""Compiles sources alone, without code: proves that each includes what it uses though builds compile batches.

  scripts/alone.py BUILD [SLICE COUNT]     of a configured build tree; every COUNT-th source, from the SLICE-th (1) on

Prints the compiler's errors and exits 1 when there are any.
"""
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys


def sources_and_commands(build):
    """(source, folder, command) of each source: batches stand for those that they include."""
    for entry in json.loads((build / "compile_commands.json").read_text()):
        file = pathlib.Path(entry["file"])
        command = re.sub(r" -o \S+ -c \S+$", " -fsyntax-only -O0 ", entry["command"])
        command = re.sub(r"^\S*ccache ", "", command)
        if re.fullmatch(r"unity_\d+_c(xx)?\.c(xx)?", file.name):
            for source in re.findall(r'^#include "(.+)"', file.read_text(), re.M):
                yield source, entry["directory"], command
        else:
            yield str(file), entry["directory"], command


def check(job):
    source, folder, command = job
    done = subprocess.run(f"{command} '{source}'", shell=True, cwd=folder, capture_output=True, text=True)
    return done.returncode == 0, source, done.stderr


def main():
    if len(sys.argv) not in (2, 4):
        sys.exit(__doc__)
    build = pathlib.Path(sys.argv[1])
    first, step = (int(sys.argv[2]) - 1, int(sys.argv[3])) if len(sys.argv) == 4 else (0, 1)
    jobs = sorted(set(sources_and_commands(build)))[first::step]
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
