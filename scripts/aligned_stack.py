#!/usr/bin/env python3
"""Looks for instructions that need more alignment than the stack has on Windows.

  scripts/aligned_stack.py BUILD

Windows aligns stacks to 16 bytes. GCC bug 54412: g++ for Windows keeps vectors of 32 and 64 bytes on the stack as if it
were aligned to these, and a program crashes or not by chance. Distributions patch that; this reads the code of all object
files below BUILD and fails where a function that does not align its stack moves such a vector, by an instruction that
needs alignment, from or to an address that it computes from rsp. What another function does with a pointer into
the stack is not seen.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

FUNCTION = re.compile(r"^[0-9a-f]+ <(.+)>:$")
ALIGNED_MOVE = re.compile(r"\b(vmovap[sd]|vmovdqa(?:32|64)?|vmovnt\w+)\s.*%[yz]mm")
BASE = re.compile(r"\((%\w+)")
REALIGNS = re.compile(r"\band\s+\$0xf+[ec8]0,%[er]sp|\band\s+\$0xf+[048c]00,%[er]sp")
ADDRESS = re.compile(r"\b(?:lea\s+[-0-9a-fx]*\((?P<base>%r\w+)\)|mov\s+(?P<whole>%r\w+)),(?P<to>%r\w+)$")
WRITTEN = re.compile(r",(%r\w+)$")


def wrong_moves(lines):
    """Moves of a function that need an aligned stack; none where it aligns it."""
    found, of_stack = [], {"%rsp"}
    for line in lines:
        if REALIGNS.search(line):
            return []
        base = BASE.search(line)
        if ALIGNED_MOVE.search(line) and base and base.group(1) in of_stack:
            found.append(line.strip())
        address, written = ADDRESS.search(line), WRITTEN.search(line)
        if address and (address["base"] or address["whole"]) in of_stack:
            of_stack.add(address["to"])
        elif written and written.group(1) != "%rsp":
            of_stack.discard(written.group(1))
    return found


SAMPLE = """
wrong_of_stack:\n sub $0x48,%rsp\n vmovapd %ymm0,0x20(%rsp)\n ret
wrong_of_frame:\n mov %rsp,%rbp\n sub $0x48,%rsp\n vmovdqa %ymm0,-0x20(%rbp)\n ret
wrong_of_address:\n lea 0x20(%rsp),%rax\n vmovdqa64 (%rax),%zmm1\n ret
right_of_function:\n and $-32,%rsp\n vmovapd %ymm0,0x20(%rsp)\n ret
right_of_address:\n lea 0x5f(%rsp),%rbx\n and $-64,%rbx\n vmovapd %ymm0,(%rbx)\n ret
right_of_other_memory:\n mov 0x20(%rsp),%rax\n vmovapd %ymm0,(%rax)\n vmovupd %ymm0,(%rsp)\n ret
"""


def check_itself():
    """A check that finds nothing must have been able to find something."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "sample.obj"
        subprocess.run(["x86_64-w64-mingw32-as", "-o", str(file)], input=SAMPLE, text=True, check=True)
        found = {name for name, lines in functions(code_of(file)) if wrong_moves(lines)}
    if found != {"wrong_of_stack", "wrong_of_frame", "wrong_of_address"}:
        sys.exit(f"aligned_stack: finds {sorted(found)} in its own sample")


def code_of(file):
    return subprocess.run(["x86_64-w64-mingw32-objdump", "-d", "--no-show-raw-insn", "--demangle", str(file)],
                          capture_output=True, text=True, check=True).stdout


def functions(text):
    name, lines = None, []
    for line in text.splitlines():
        match = FUNCTION.match(line)
        if match:
            yield name, lines
            name, lines = match.group(1), []
        else:
            lines.append(line)
    yield name, lines


def main():
    build = pathlib.Path(sys.argv[1])
    check_itself()
    wide = wrong = 0
    for file in sorted(build.rglob("*.obj")):
        text = code_of(file)
        if "%ymm" not in text and "%zmm" not in text:
            continue
        wide += 1
        for name, lines in functions(text):
            moves = wrong_moves(lines)
            if moves:
                wrong += 1
                print(f"{file}: {name}: the stack is not aligned for: {moves[0]}", file=sys.stderr)
    if wide == 0:
        sys.exit(f"aligned_stack: no object below {build} has wide instructions: nothing was checked")
    print(f"{wide} objects with wide instructions: {wrong} functions need a stack that is aligned further than it is")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
