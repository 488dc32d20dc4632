"""Make the table of file sizes: ``python docs/file_sizes.py`` writes it into docs/howto/small-files.md, between its marks.

The photo is one that scikit-image's wheel holds (public domain), so anyone gets the same numbers.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from skimage import data

import graphstipple as gs

PAGE = Path(__file__).resolve().parent / "howto" / "small-files.md"

BEGIN, END = "<!-- The table of sizes begins: made by docs/file_sizes.py. -->", "<!-- The table of sizes ends. -->"

NODES = (10_000, 30_000, 100_000)
"""Nodes of the drawings with the default's options; those of the presets have the middle number."""

FILES: dict[str, tuple[str, dict[str, Any]]] = {
    ".svg": ("svg", {}),
    ".svg, strokes": ("svg", {"dots": "strokes"}),
    ".svg, layered": ("svg", {"style": "layered"}),
    ".svg, layered, strokes": ("svg", {"style": "layered", "dots": "strokes"}),
    ".svg, marks": ("svg", {"elements": "marks"}),
    ".svgz": ("svgz", {}),
    ".svgz, layered, strokes": ("svgz", {"style": "layered", "dots": "strokes"}),
    ".pdf": ("pdf", {}),
}
"""What is measured: a heading, a suffix and settings."""


def sizes(drawing: gs.Drawing) -> list[str]:
    """Return the kilobytes of every file of a drawing."""
    told = []
    with tempfile.TemporaryDirectory() as folder:
        for suffix, settings in FILES.values():
            path = Path(folder) / f"drawing.{suffix}"
            drawing.save(path, **settings)
            told.append(f"{path.stat().st_size / 1000:.0f}")
    return told


def main() -> None:
    """Write the table."""
    photo = data.astronaut()
    cases = {f"default, {nodes:,} nodes": gs.Options(nodes=nodes) for nodes in NODES}
    names = [preset.name for preset in gs.presets() if preset.name != "default"]
    cases |= {f"{name}, {NODES[1]:,} nodes": gs.Options.preset(name).replace(nodes=NODES[1]) for name in names}
    rows = []
    for name, options in cases.items():
        drawing = gs.draw(photo, options=options)
        rows.append([name, f"{len(drawing.stipples):,}", f"{len(drawing.regions):,}", *sizes(drawing)])
    head = ["Options", "Dots", "Regions", *FILES]
    lines = [" | ".join(row) for row in [head, ["---"] + ["---:"] * (len(head) - 1), *rows]]
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    table = "\n".join(f"| {line} |" for line in lines)
    PAGE.write_text(f"{before}{BEGIN}\n\n{table}\n\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
