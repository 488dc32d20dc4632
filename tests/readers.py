"""Files of drawings, opened by programs that are not ours: each gives grey values (height, width), 0 black and 255 white."""

from __future__ import annotations

import base64
import contextlib
import io
import math
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import ezdxf
import ezdxf.path
import numpy as np
import pypdfium2
import resvg_py
from ezdxf.document import Drawing as DxfDocument
from ezdxf.entities import DXFGraphic, Spline
from numpy.typing import NDArray
from PIL import Image

POINTS_PER_MM = 72 / 25.4

GHOSTSCRIPT = shutil.which("gs")
"""Where ghostscript is, if it is installed."""

RSVG = shutil.which("rsvg-convert")
"""Where librsvg is, if it is installed."""

INKSCAPE = shutil.which("inkscape")
"""Where Inkscape is, if it is installed."""

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
"""Where Chromium is, if it is installed."""

Grey = NDArray[np.uint8]
Ring = NDArray[np.float64]


def svg(document: str, width: int) -> Grey:
    """Paint an SVG on white paper by resvg."""
    png = bytes(resvg_py.svg_to_bytes(svg_string=document, width=width, background="#ffffff"))
    return np.asarray(Image.open(io.BytesIO(png)).convert("L"))


def librsvg(path: Path, width: int) -> Grey:
    """Paint an SVG on white paper by librsvg."""
    assert RSVG is not None
    command = [RSVG, "--unlimited", "--background-color=white", f"--width={width}", "--keep-aspect-ratio", str(path)]
    run = subprocess.run(command, check=True, capture_output=True)
    return np.asarray(Image.open(io.BytesIO(run.stdout)).convert("L"))


def inkscape(path: Path, width: int) -> Grey:
    """Paint an SVG on white paper by Inkscape."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.png"
        inkscape_do(path, f"--export-width={width}", "--export-background=white", f"--export-filename={out}")
        return png(out)


def inkscape_do(path: Path, *arguments: str) -> None:
    """Open a file in Inkscape without its window, with a profile of its own."""
    assert INKSCAPE is not None
    with tempfile.TemporaryDirectory() as profile:
        environment = {**os.environ, "INKSCAPE_PROFILE_DIR": profile, "SELF_CALL": "1"}
        subprocess.run([INKSCAPE, *arguments, str(path)], check=True, capture_output=True, env=environment, timeout=120)


@contextlib.contextmanager
def chromium() -> Iterator[Callable[[str, int, int], Grey]]:
    """Start a browser, and give what paints an SVG on a white page at a size in pixels."""
    from playwright.sync_api import sync_playwright  # it is slow to import

    with sync_playwright() as playwright:
        # Where tests run as root, Chromium's sandbox does not work.
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        try:
            page = browser.new_page()

            def paint(document: str, width: int, height: int) -> Grey:
                page.set_viewport_size({"width": width, "height": height})
                source = base64.b64encode(document.encode()).decode()
                style = f"display:block;width:{width}px;height:{height}px"
                page.set_content(f'<body style="margin:0"><img style="{style}" src="data:image/svg+xml;base64,{source}">')
                page.wait_for_function("document.images[0].complete && document.images[0].naturalWidth > 0")
                return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("L"))

            yield paint
        finally:
            browser.close()


def pdf(path: Path, width: int, mode: str = "L") -> NDArray[np.uint8]:
    """Paint the first page of a PDF by pdfium, in grey, or in the colours of another of Pillow's modes."""
    document = pypdfium2.PdfDocument(path)
    try:
        page = document[0]
        # A hair less: pdfium rounds the number of pixels up.
        return np.asarray(page.render(scale=(width - 1e-3) / page.get_width()).to_pil().convert(mode))
    finally:
        document.close()


def pdf_size(path: Path) -> tuple[float, float]:
    """Width and height of the first page in points."""
    document = pypdfium2.PdfDocument(path)
    try:
        return document[0].get_size()
    finally:
        document.close()


def png(path: Path) -> Grey:
    """Read a PNG by Pillow."""
    with Image.open(path) as image:
        return np.asarray(image.convert("L"))


# DXF -----------------------------------------------------------------------------------------------------------------------------


def dxf(path: Path) -> DxfDocument:
    """Read a DXF by ezdxf; what its audit finds is an error."""
    document = ezdxf.readfile(path)
    audit = document.audit()
    assert not audit.errors, [error.message for error in audit.errors]
    assert not audit.fixes, [fix.message for fix in audit.fixes]
    return document


def dxf_rings(document: DxfDocument, flatness: float = 0.005) -> dict[str, list[Ring]]:
    """Return the closed outlines of every layer, in millimetres, y running up; flat to within `flatness` mm."""
    rings: dict[str, list[Ring]] = {}
    for entity in document.modelspace():
        assert isinstance(entity, DXFGraphic)
        assert entity.dxftype() in {"CIRCLE", "POLYLINE", "LWPOLYLINE", "SPLINE"}, entity.dxftype()
        is_closed = entity.dxftype() == "CIRCLE" or getattr(entity, "is_closed", False) or getattr(entity, "closed", False)
        assert is_closed, "an outline is open"
        # A path would have a spline's curves only roughly.
        outline = entity if isinstance(entity, Spline) else ezdxf.path.make_path(entity)
        points = [(point.x, point.y) for point in outline.flattening(flatness)]
        rings.setdefault(entity.dxf.layer, []).append(np.array(points))
    return rings


def fill(rings: list[Ring], width: int, height: int) -> NDArray[np.bool_]:
    """Return the pixels whose centres lie inside, by the even-odd rule; rings are in pixels, y running down."""
    if not rings:
        return np.zeros((height, width), bool)
    begin = np.concatenate(rings)
    end = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    upper, lower = np.minimum(begin[:, 1], end[:, 1]), np.maximum(begin[:, 1], end[:, 1])
    first = np.clip(np.ceil(upper - 0.5), 0, height).astype(int)
    count = np.maximum(np.clip(np.ceil(lower - 0.5), 0, height).astype(int) - first, 0)
    edge = np.repeat(np.arange(len(begin)), count)
    row = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + first[edge]
    share = (row + 0.5 - begin[edge, 1]) / (end[edge, 1] - begin[edge, 1])
    x = begin[edge, 0] + share * (end[edge, 0] - begin[edge, 0])
    column = np.clip(np.ceil(x - 0.5), 0, width).astype(int)
    crossings = np.zeros((height, width + 1), int)
    np.add.at(crossings, (row, column), 1)
    return (np.cumsum(crossings, axis=1)[:, :width] % 2).astype(bool)


# EPS -----------------------------------------------------------------------------------------------------------------------------


def ghostscript(path: Path, width: int) -> Grey:
    """Paint an EPS by ghostscript, without antialiasing: `width` should be some times what is wanted."""
    assert GHOSTSCRIPT is not None
    left, bottom, right, top = bounding_box(path.read_text("ascii"))
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.png"
        size = f"-g{width}x{round((top - bottom) / (right - left) * width)}"
        command = [GHOSTSCRIPT, "-q", "-dSAFER", "-dBATCH", "-dNOPAUSE", "-sDEVICE=pnggray", size]
        resolution = f"-r{72 * width / (right - left):.9f}"
        # By itself, ghostscript paints every pixel that a shape touches.
        setup = f"0 0 .setfilladjust2 {-left} {-bottom} translate"
        subprocess.run([*command, resolution, f"-sOutputFile={out}", "-c", setup, "-f", str(path)], check=True, capture_output=True)
        return png(out)


def separations(path: Path, dots_per_inch: int) -> dict[str, float]:
    """Return which part of the page each plate of a PDF or EPS covers, by ghostscript's separations, without antialiasing."""
    assert GHOSTSCRIPT is not None
    with tempfile.TemporaryDirectory() as folder:
        command = [GHOSTSCRIPT, "-q", "-dSAFER", "-dBATCH", "-dNOPAUSE", "-dEPSCrop", "-sDEVICE=tiffsep", f"-r{dots_per_inch}"]
        # By itself, ghostscript paints every pixel that a shape touches.
        setup = ["-c", "0 0 .setfilladjust2", "-f", str(path)]
        subprocess.run([*command, f"-sOutputFile={folder}/page.tif", *setup], check=True, capture_output=True, timeout=120)
        plates = {file.stem.removeprefix("page(").removesuffix(")"): png(file) for file in Path(folder).glob("page(*).tif")}
        return {name: float(1 - plate.mean() / 255) for name, plate in plates.items()}


def bounding_box(program: str) -> tuple[float, float, float, float]:
    """Return left, bottom, right and top of an EPS in points: the exact ones if it tells them."""
    found = re.search(r"^%%HiResBoundingBox: (.*)$", program, re.M) or re.search(r"^%%BoundingBox: (.*)$", program, re.M)
    assert found is not None
    left, bottom, right, top = (float(value) for value in found[1].split())
    return left, bottom, right, top


class PostScript:
    """A reader of the little PostScript that our files are made of: procedures, matrices, greys, paths and fills."""

    STEPS = 8
    """Chords of a Bezier curve; a circle has four times as many."""

    def __init__(self, program: str, width: int) -> None:
        left, bottom, right, top = bounding_box(program)
        scale = width / (right - left)
        self.pixels: Grey = np.full((round((top - bottom) * scale), width), 255, np.uint8)
        # From user space to pixels: factors and offsets of x and y. Files neither turn nor shear.
        self.matrix = (scale, -scale, -left * scale, top * scale)
        self.grey = 0.0
        self.saved: list[tuple[tuple[float, float, float, float], float]] = []
        self.stack: list[Any] = []
        self.names: dict[str, list[Any]] = {}
        # The path, in user space: nothing changes the matrix before it is filled.
        self.rings: list[list[tuple[float, float]]] = []
        tokens = re.findall(r"[{}]|/?[^\s{}/]+", re.sub(r"%.*", "", program))
        self.run(self.parse(iter(tokens)))

    def parse(self, tokens: Iterator[str]) -> list[Any]:
        """Return tokens up to a closing brace, numbers as numbers and procedures as lists."""
        program: list[Any] = []
        for token in tokens:
            if token == "}":
                break
            if token == "{":
                program.append(self.parse(tokens))
            elif re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", token, re.I):
                program.append(float(token))
            else:
                program.append(token)
        return program

    def run(self, program: list[Any]) -> None:
        """Execute; an operator that is not known here is an error."""
        for token in program:
            if not isinstance(token, str) or token.startswith("/"):
                self.stack.append(token)
            elif token in self.names:
                self.run(self.names[token])
            elif token not in {"bind", "begin", "end", "showpage", self.dictionary}:
                getattr(self, f"do_{token}")()

    dictionary = ""
    """Name of the dictionary that the procedures are in: the only one."""

    def pop(self, count: int) -> list[Any]:
        """Take values off the stack."""
        assert len(self.stack) >= count, "the stack is empty"
        values = self.stack[len(self.stack) - count :]
        del self.stack[len(self.stack) - count :]
        return values

    def do_dict(self) -> None:
        self.pop(1)

    def do_def(self) -> None:
        if not isinstance(self.stack[-1], list):
            (name,) = self.pop(1)
            self.dictionary = name[1:]
            return
        name, procedure = self.pop(2)
        self.names[name[1:]] = procedure

    def do_dup(self) -> None:
        self.stack.append(self.stack[-1])

    def do_index(self) -> None:
        (place,) = self.pop(1)
        self.stack.append(self.stack[-1 - int(place)])

    def do_add(self) -> None:
        self.stack.append(sum(self.pop(2)))

    def do_gsave(self) -> None:
        self.saved.append((self.matrix, self.grey))

    def do_grestore(self) -> None:
        self.matrix, self.grey = self.saved.pop()

    def do_translate(self) -> None:
        x, y = self.pop(2)
        self.matrix = (*self.matrix[:2], self.matrix[2] + self.matrix[0] * x, self.matrix[3] + self.matrix[1] * y)

    def do_scale(self) -> None:
        x, y = self.pop(2)
        self.matrix = (self.matrix[0] * x, self.matrix[1] * y, *self.matrix[2:])

    def do_setgray(self) -> None:
        (self.grey,) = self.pop(1)

    def do_setrgbcolor(self) -> None:
        self.grey = float(np.dot(self.pop(3), (0.299, 0.587, 0.114)))

    def do_moveto(self) -> None:
        self.rings.append([tuple(self.pop(2))])

    def do_rlineto(self) -> None:
        self.rings[-1].append(tuple(np.add(self.rings[-1][-1], self.pop(2))))

    def do_rcurveto(self) -> None:
        begin = np.array(self.rings[-1][-1])
        points = np.array([begin, *(begin + np.reshape(self.pop(6), (3, 2)))])
        t = np.linspace(0, 1, self.STEPS + 1)[1:, np.newaxis]
        weights = np.hstack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3])
        self.rings[-1].extend((x, y) for x, y in weights @ points)

    def do_arc(self) -> None:
        x, y, radius, begin, end = self.pop(5)
        for angle in np.radians(np.linspace(begin, end, 4 * self.STEPS + 1)):
            self.rings[-1].append((x + radius * math.cos(angle), y + radius * math.sin(angle)))

    do_arcn = do_arc

    def do_closepath(self) -> None:
        self.rings[-1].append(self.rings[-1][0])

    def do_fill(self) -> None:
        scale, offset = np.array(self.matrix[:2]), np.array(self.matrix[2:])
        height, width = self.pixels.shape
        rings = [np.array(ring) * scale + offset for ring in self.rings]
        # By the even-odd rule; files are made so that the nonzero rule, which they ask for, fills the same.
        self.pixels[fill(rings, width, height)] = round(255 * self.grey)
        self.rings = []


def postscript(path: Path, width: int) -> Grey:
    """Paint an EPS by the reader above, without antialiasing."""
    return PostScript(path.read_text("ascii"), width).pixels
