#!/usr/bin/env python3
"""Counts the instructions that kernels execute, scalar and in vectors, on emulated processors.

    scripts/kernel_counts.py [arm64] [x86-64]

Test programs that scripts/arm64.sh and scripts/setup.sh built run the same tests twice under qemu-user, with each form as
the widest (SIGHTLINE_ISA), and a plugin counts (count_instructions.c). In the second run the wider form does the work that
the plain one did in the first. Compilers draw random arguments in orders of their own, so two processors are not given
quite the same boxes and rays.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
BUILD = HERE.parent / "build"
# The test programs, what runs them, and their wider form.
MACHINES = {"arm64": (BUILD / "linux-arm64/tests", ["qemu-aarch64", "-L", str(BUILD / "arm64-root")], "neon"),
            "x86-64": (BUILD / "release/tests", ["qemu-x86_64"], "avx2")}
SUITES = {
    "culling_tests": "CpuCuller.* SlotList.* DepthPyramid.* OccluderPolygons.* TriangleTest.* OccluderRaster.* "
                     "SolidOccluders.QuadsAreSeen* OcclusionTest.FiltersSets SampleTest.FiltersSets "
                     "OccludedBoxes.FrontsAreEnteredFirst",
    "lod_tests": "SurfaceDeviation.IsTheSameInEveryFormOfTheKernels",
    "raytrace_tests": "ExtremeRays.* ExactVisibility.*",
}
# Names of what the kernels' files hold, and the rows of the table in which they are counted.
FORMS = {"scalar": r"\bScalar\b|raytrace::Lanes<", "neon": r"\b(Simd128|Neon|PacketForm|Registers)\b",
         "avx2": r"\b(Avx2|PacketForm|Float8)\b"}
ROWS = [
    ("frustum: tree and lists", r"Traversal<|Extraction<|cull_items<|ItemTester<|TraversalInput"),
    ("frustum: boxes of leaves", r"make_frustum_kernels<"),
    ("boxes against depths", r"\bbehind<|\bseen<|unoccluded_|SmallBox|culling::BoxForm<|in_front<|keys_of_face<"),
    ("boxes in the image: rectangles, areas, squares", r"ScreenBoxes<|BoxRectangles"),
    ("occluder raster", r"fill_area<|cover_polygons<|seen_quads<|AreaRows<|AreaFiller<"),
    ("triangles of meshes", r"shown_triangles<|ScreenTriangles<"),
    ("rows of depths", r"distances<sightline::culling|coarser_row<|make_occlusion_kernels<"),
    ("packets of rays", r"Packets<|Solids<|_lanes<"),
    ("single rays", r"Tracing<|\bBlockForm<"),
    ("distances of surfaces", r"lod::"),
]


def counts_of(tests, emulator, form, plugin, folder):
    """Instructions by the function's name."""
    found = {}
    for program, suites in SUITES.items():
        for suite in suites.split():
            log = folder / "counts"
            command = [*emulator, "-plugin", str(plugin), "-d", "plugin", "-D", str(log), "-E", f"SIGHTLINE_ISA={form}",
                       str(tests / program), "--gtest_brief=1", f"--gtest_filter={suite}"]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            text = subprocess.run(["c++filt"], input=log.read_text(), text=True, capture_output=True, check=True).stdout
            for line in text.splitlines():
                count, name = line.split(" ", 1)
                found[name] = found.get(name, 0) + int(count)
    return found


def rows_of(found, form):
    rows = dict.fromkeys((label for label, _ in ROWS), 0)
    for name, count in found.items():
        if not re.search(FORMS[form], name):
            continue
        for label, pattern in ROWS:
            if re.search(pattern, name):
                rows[label] += count
                break
        else:
            print(f"kernel_counts: in no row: {name}", file=sys.stderr)
    return rows


def main():
    machines = sys.argv[1:] or list(MACHINES)
    columns = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        plugin = folder / "count.so"
        subprocess.run(["cc", "-shared", "-fPIC", "-O2", "-o", plugin, HERE / "count_instructions.c"], check=True)
        for machine in machines:
            tests, emulator, wider = MACHINES[machine]
            columns.append([rows_of(counts_of(tests, emulator, form, plugin, folder), form) for form in ("scalar", wider)])
    print("| millions of instructions |" + "".join(f" {m}: scalar, {MACHINES[m][2]} (ratio) |" for m in machines))
    print("| --- |" + " --- |" * len(machines))
    for label, _ in ROWS:
        cells = [(plain[label] / 1e6, wide[label] / 1e6) for plain, wide in columns]
        print(f"| {label} |" + "".join(f" {a:.1f}, {b:.1f} ({a / b if b else 0:.1f}) |" for a, b in cells))


if __name__ == "__main__":
    main()
