"""Our SVG, PDF and EPS, painted by the programs that people have, beside our own raster.

Each program that is installed paints each format that it reads, 8 times as fine as the photo; box means of that are compared with
ours. The table in `docs/output.md` is what a run found: `GRAPHSTIPPLE_UPDATE_RENDERERS=1 pytest tests/test_renderers.py` writes it
anew, and fails, so that it does not pass unnoticed.
"""

from __future__ import annotations

import functools
import os
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from tests import oracles, readers
from tests.support import ROOT, photo

import graphstipple as gs

OUTPUT = ROOT / "docs" / "output.md"
UPDATE = bool(os.environ.get("GRAPHSTIPPLE_UPDATE_RENDERERS"))
BEGIN, END = "<!-- The renderers begin: made by tests/test_renderers.py. -->", "<!-- The renderers end. -->"

FINE = 8
"""Pixels of a renderer to a pixel of the photo: 768 to the inch. Some programs blacken every pixel that a shape touches, which at
that size is a hair."""

MEAN_TOLERANCE, PIXEL_TOLERANCE = 8.0, 80.0
"""Of 255. Ghostscript and poppler's own rasterizer thicken every shape by half a pixel of theirs; a missing layer is far above."""

SUFFIXES = ("svg", "pdf", "eps")


def told(*command: str) -> str:
    """Return the version that a program tells of itself."""
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    found = re.search(r"\d+(\.\d+)+", done.stdout + done.stderr)
    assert found is not None, command
    return found[0]


def painted_by(*command: str) -> Callable[[Path, int, Path], None]:
    """Return what paints a file by a program: its arguments, with {file}, {width}, {dpi} and {png} in their places."""

    def paint(path: Path, width: int, png: Path) -> None:
        values = {"file": str(path), "width": str(width), "dpi": str(96 * FINE), "png": str(png), "stem": str(png.with_suffix(""))}
        subprocess.run([part.format(**values) for part in command], check=True, capture_output=True, timeout=300)

    return paint


def by_resvg(path: Path, width: int, png: Path) -> None:
    """Paint by the package of resvg."""
    store(readers.svg(path.read_text("utf-8"), width), png)


def by_pdfium(path: Path, width: int, png: Path) -> None:
    """Paint by the package of pdfium."""
    store(readers.pdf(path, width), png)


def store(values: NDArray[np.uint8], png: Path) -> None:
    """Write what a package painted."""
    Image.fromarray(values).save(png)


GHOSTSCRIPT = (
    "gs",
    "-q",
    "-dSAFER",
    "-dBATCH",
    "-dNOPAUSE",
    "-dEPSCrop",
    "-sDEVICE=pnggray",
    "-r{dpi}",
    "-sOutputFile={png}",
    "{file}",
)
INKSCAPE = (
    "inkscape",
    "{file}",
    "--export-type=png",
    "--export-width={width}",
    "--export-background=white",
    "--export-filename={png}",
)
CAIROSVG = ("cairosvg", "{file}", "-f", "png", "--output-width", "{width}", "-b", "white", "-o", "{png}")


@dataclass(frozen=True)
class Program:
    """What paints files."""

    name: str
    needs: str
    """Its executable, or the Python package that it is."""
    suffixes: tuple[str, ...]
    paint: Callable[[Path, int, Path], None]
    version: Callable[[], str]

    def is_there(self) -> bool:
        """Whether it is installed."""
        if self.needs.startswith("import "):
            try:
                metadata.version(self.needs.removeprefix("import "))
            except metadata.PackageNotFoundError:
                return False
            return True
        return shutil.which(self.needs) is not None


PROGRAMS = (
    Program("resvg", "import resvg-py", ("svg",), by_resvg, lambda: metadata.version("resvg-py")),
    Program(
        "rsvg-convert",
        "rsvg-convert",
        ("svg",),
        painted_by("rsvg-convert", "-w", "{width}", "-b", "white", "-o", "{png}", "{file}"),
        lambda: told("rsvg-convert", "--version"),
    ),
    Program("CairoSVG", "cairosvg", ("svg",), painted_by(*CAIROSVG), lambda: told("cairosvg", "--version")),
    Program("pdfium", "import pypdfium2", ("pdf",), by_pdfium, lambda: metadata.version("pypdfium2")),
    Program(
        "pdftocairo",
        "pdftocairo",
        ("pdf",),
        painted_by("pdftocairo", "-png", "-gray", "-singlefile", "-r", "{dpi}", "{file}", "{stem}"),
        lambda: told("pdftocairo", "-v"),
    ),
    Program(
        "mutool",
        "mutool",
        ("pdf",),
        painted_by("mutool", "draw", "-q", "-c", "gray", "-r", "{dpi}", "-o", "{png}", "{file}"),
        lambda: told("mutool", "-v"),
    ),
    Program("Ghostscript", "gs", ("pdf", "eps"), painted_by(*GHOSTSCRIPT), lambda: told("gs", "--version")),
    Program("Inkscape", "inkscape", ("svg", "pdf"), painted_by(*INKSCAPE), lambda: told("inkscape", "--version")),
)


@functools.cache
def drawn() -> gs.Drawing:
    """Draw a face and a sky, for every test here."""
    return gs.draw(np.ascontiguousarray(photo("camera")[::2, ::2]))


@functools.cache
def differences(program: Program, suffix: str, folder: Path) -> tuple[float, float]:
    """Return mean and largest difference of grey, of 255, to our own raster."""
    drawing = drawn()
    path, png = folder / f"drawing.{suffix}", folder / f"{program.name}-{suffix}.png"
    drawing.save(path)
    program.paint(path, FINE * drawing.width, png)
    theirs = readers.png(png)
    assert theirs.shape == (FINE * drawing.height, FINE * drawing.width)
    ours = oracles.box_average(drawing.rasterize(FINE * drawing.width), FINE)
    off = np.abs(oracles.box_average(theirs, FINE) - ours)
    return float(off.mean()), float(off.max())


CASES = [(program, suffix) for program in PROGRAMS for suffix in program.suffixes]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("renderers")


@pytest.mark.parametrize(("program", "suffix"), CASES, ids=[f"{program.name}-{suffix}" for program, suffix in CASES])
def test_a_program_paints_the_picture(program: Program, suffix: str, folder: Path) -> None:
    if not program.is_there():
        pytest.skip(f"{program.name} is not installed")
    mean, largest = differences(program, suffix, folder)
    assert mean < MEAN_TOLERANCE
    assert largest < PIXEL_TOLERANCE


def rows(folder: Path) -> list[str]:
    """Return the rows of the table: a program each, with the mean and the largest difference in every format."""
    lines = []
    for program in PROGRAMS:
        cells = [
            "-" if suffix not in program.suffixes else "{:.1f}, {:.0f}".format(*differences(program, suffix, folder))
            for suffix in SUFFIXES
        ]
        lines.append(f"| {program.name} {program.version()} | {' | '.join(cells)} |")
    return lines


def test_the_table_of_the_docs_is_what_a_run_finds(folder: Path) -> None:
    missing = [program.name for program in PROGRAMS if not program.is_there()]
    if missing:
        pytest.skip(f"not installed: {', '.join(missing)}")
    text = OUTPUT.read_text("utf-8")
    before, _, rest = text.partition(BEGIN)
    table, _, after = rest.partition(END)
    found = rows(folder)
    if UPDATE:
        head = ["", "| Program | SVG | PDF | EPS |", "|---|---|---|---|"]
        OUTPUT.write_text(before + BEGIN + "\n".join([*head, *found, ""]) + END + after, "utf-8")
        pytest.fail("the table was written anew")
    # Other versions paint otherwise: each program has its row, and no cell is empty that is not empty here.
    for program, row in zip(PROGRAMS, found, strict=True):
        of_docs = next((line for line in table.splitlines() if line.startswith(f"| {program.name} ")), None)
        assert of_docs is not None, program.name
        if of_docs.startswith(f"| {program.name} {program.version()} |"):
            assert of_docs == row
