#!/usr/bin/env python3
"""Draws the README's chart beside OpenSceneGraph and VTK from the tables of docs/results: peer_chart.py [OUT.svg]."""
import math
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
DRAWN = ("docs/results/drawing.md", "640×360: mean, median, processor", 1)
CULLED = ("docs/results/culling-study.md", "| ms ; false positives | P-38", 4)
NAMES = {"Sightline": "Sightline", "production": "Sightline", "VTK": "VTK", "OpenSceneGraph": "OpenSceneGraph",
         "Open CASCADE": "Open CASCADE"}
INK, PALE, OURS, THEIRS = "#24292f", "#d0d7de", "#0a7d4f", "#8c959f"


def rows(page, heading, column):
    """Name and first number of a column, for the rows of the first table whose head has `heading`."""
    lines = (ROOT / page).read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if heading in line)
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            return
        cells = [re.sub(r"\*", "", cell).strip() for cell in line.strip("|").split("|")]
        yield cells[0], float(re.match(r"[\d.]+", cells[column]).group())


def bars(entries, x0, title, label, scale):
    """SVG of one panel: names in `label` pixels, bars and values."""
    yield f'<text x="{x0}" y="24" font-weight="bold">{title}</text>'
    for i, (name, value) in enumerate(entries):
        y = 44 + 30 * i
        colour = OURS if name.startswith("Sightline") else THEIRS
        yield f'<text x="{x0}" y="{y + 14}">{name}</text>'
        yield f'<rect x="{x0 + label}" y="{y}" width="{120 * scale(value):.1f}" height="18" fill="{colour}"/>'
        yield f'<text x="{x0 + label + 6 + 120 * scale(value):.1f}" y="{y + 14}">{value:.3g}</text>'


def main():
    drawn = [(re.sub(r" [\d.]+", "", name), value) for name, value in rows(*DRAWN)]
    culled = [(NAMES[re.sub(r" \(.*", "", name)], value) for name, value in rows(*CULLED)
              if re.sub(r" \(.*", "", name) in NAMES]
    culled.sort(key=lambda entry: entry[1])
    longest = max(value for _, value in drawn)
    low, high = min(value for _, value in culled) / 2, max(value for _, value in culled)
    panels = [*bars(drawn, 10, "Draw three plant models: ms a frame", 275, lambda v: v / longest),
              *bars(culled, 500, "Cull 713,435 boxes: ms a view, log scale", 125,
                    lambda v: math.log(v / low) / math.log(high / low))]
    out = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "images" / "peers.svg"
    out.write_text('<svg xmlns="http://www.w3.org/2000/svg" width="880" height="176" viewBox="0 0 880 176" '
                   f'font-family="sans-serif" font-size="13" fill="{INK}">\n'
                   f'<rect width="880" height="176" fill="#ffffff" stroke="{PALE}"/>\n' + "\n".join(panels)
                   + "\n</svg>\n")


main()
