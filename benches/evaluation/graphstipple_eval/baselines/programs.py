"""Vector pictures by programs that are not part of this project: potrace, vtracer and inksep, each where it is installed.

- potrace (Selinger 2003) traces a bitmap; with its defaults. The bitmap is the tone cut at Otsu's threshold (1979).
- vtracer traces clusters of pixels; in black and white, else with its defaults. It cuts the tone itself, at the middle.
- inksep relaxes dots as Secord (2002) and pushes dark ones apart; darker dots are larger, up to five times the diameter of the
  smallest. With its defaults, but without a border, and with a smallest dot for which dots that lie as dense as the darkness have
  its ink.

The traced SVG files are painted by resvg at four times the size, since it makes polygons of curves, and averaged; the dots of
inksep are painted as all dots here.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import io
import math
import re
import tempfile
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import numpy.typing as npt
import resvg_py
from PIL import Image
from skimage.filters import threshold_otsu

from graphstipple_eval import installation
from graphstipple_eval.baselines.dots import BLACK, Dots, box_average, check_dots, equal_black_dots, picture
from graphstipple_eval.method import Counts, Method, Photo, Picture
from graphstipple_eval.photos import png

MAGNIFICATION = 4
"""How much larger than the photo resvg paints: then its polygons lie within a hundredth of a pixel from the curves."""

INKSEP_RANGE = 4.0
"""Largest over smallest diameter, less 1: the default of inksep."""

INKSEP_SEED = 1

SVG_NAMESPACE = "{http://www.w3.org/2000/svg}"

NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
ARC = re.compile(rf"{NUMBER}(?:[\s,]*{NUMBER}){{2}}[\s,]*[01][\s,]*[01][\s,]*{NUMBER}[\s,]*{NUMBER}")


def count_coordinates(path_data: str) -> int:
    """Return how many coordinate pairs SVG path data hold, control points included.

    A horizontal or vertical line and an arc count one, as they end in one point; closing a path counts none.
    """
    count = 0
    for command, arguments in re.findall(r"([MmLlHhVvCcSsQqTtAaZz])([^MmLlHhVvCcSsQqTtAaZz]*)", path_data):
        if command in "Aa":
            count += len(ARC.findall(arguments))
        else:
            count += len(re.findall(NUMBER, arguments)) // (1 if command in "HhVv" else 2)
    return count


def versions() -> dict[str, str]:
    """Return the versions of the programs that are installed, by the names of their methods."""
    found = {method.name: installation.version(method.name) for method in METHODS}
    return {name: version for name, version in found.items() if version is not None}


def grey_png(photo: Photo) -> bytes:
    """Return the tone in 8 bits as a PNG file."""
    return png(np.rint(photo.tone * 255).astype(np.uint8))


def traced(svg: str, photo: Photo, settings: dict[str, object]) -> Picture:
    """Return the picture that an SVG of black paths on nothing is."""
    height, width = photo.tone.shape
    size = {"width": width * MAGNIFICATION, "height": height * MAGNIFICATION}
    # At 72 dots an inch, the points in which potrace writes sizes are pixels.
    png = bytes(resvg_py.svg_to_bytes(svg_string=svg, **size, dpi=72, background="#ffffff"))
    samples = np.asarray(Image.open(io.BytesIO(png)).convert("L"))
    paths = [path.get("d", "") for path in ElementTree.fromstring(svg).iter(f"{SVG_NAMESPACE}path")]
    return Picture(
        raster=box_average(samples, MAGNIFICATION) / np.float32(255),
        counts=Counts(regions=len(paths), coordinates=sum(map(count_coordinates, paths))),
        svg=svg,
        settings=settings,
    )


def otsu_bitmap(tone: npt.NDArray[np.float32]) -> tuple[npt.NDArray[np.bool_], float]:
    """Return which pixels are white, and the threshold: Otsu's, or the middle for a photo of one tone, which has no two classes."""
    threshold = 0.5
    if tone.min() < tone.max():
        threshold = float(threshold_otsu(tone))  # type: ignore[no-untyped-call]
    return tone > threshold, threshold


def trace_by_potrace(photo: Photo, dots: int) -> Picture:
    """Return the picture of potrace."""
    program = installation.find_program("potrace")
    assert program is not None
    white, threshold = otsu_bitmap(photo.tone)
    bitmap = io.BytesIO()
    Image.fromarray(white).save(bitmap, "PPM")
    svg = installation.run(potrace_command(program, "-", "-"), bitmap.getvalue()).decode()
    return traced(svg, photo, {"version": installation.program_version(program), "threshold": threshold})


def trace_by_vtracer(photo: Photo, dots: int) -> Picture:
    """Return the picture of vtracer."""
    vtracer = importlib.import_module("vtracer")
    svg = vtracer.convert_raw_image_to_svg(grey_png(photo), img_format="png", colormode="binary")
    return traced(svg, photo, {"version": importlib.metadata.version("vtracer")})


def inksep_smallest_dot(darkness: npt.NDArray[np.float64], dots: int) -> float:
    """Return the diameter in px of the smallest of dots that lie as dense as the darkness, if together they have its ink."""
    ink = darkness.sum()
    mean_square = (darkness * (1 + INKSEP_RANGE * darkness) ** 2).sum() / ink
    return math.sqrt(4 * ink / (math.pi * dots * mean_square))


def inksep_options(darkness: npt.NDArray[np.float64], dots: int) -> dict[str, object]:
    """Return the options of inksep's command with which the dots have the ink of the darkness, which is not 0 everywhere."""
    # At 25.4 dots an inch, its millimetres are pixels.
    return {
        "--stipples": dots,
        "--min-dot": inksep_smallest_dot(darkness, dots),
        "--dot-range": INKSEP_RANGE,
        "--dpi": 25.4,
        "--border": 0,
        "--seed": INKSEP_SEED,
    }


def inksep_command(program: str, grey: Path, drawn: Path, options: dict[str, object]) -> list[str]:
    """Return the command that stipples the file `grey` to the SVG file `drawn`."""
    return [program, str(grey), str(drawn), "--no-preview", *(str(part) for option in options.items() for part in option)]


def potrace_command(program: str, bitmap: str, drawn: str) -> list[str]:
    """Return the command that traces the file `bitmap` to the SVG file `drawn`; "-" is standard input and output."""
    return [program, "--svg", "--output", drawn, bitmap]


def stipple_by_inksep(photo: Photo, dots: int) -> Picture:
    """Return the picture of inksep."""
    program = installation.find_program("inksep")
    assert program is not None
    count = check_dots(dots)
    height, width = photo.tone.shape
    darkness = 1 - photo.tone.astype(np.float64)
    if not darkness.any():
        # It refuses a white photo.
        return picture(equal_black_dots(np.empty((0, 2)), 0.0), width, height, {})
    options = inksep_options(darkness, count)
    with tempfile.TemporaryDirectory() as folder:
        grey, drawn = Path(folder, "grey.png"), Path(folder, "dots.svg")
        grey.write_bytes(grey_png(photo))
        installation.run(inksep_command(program, grey, drawn, options))
        svg = drawn.read_text("utf-8")
    circles = list(ElementTree.fromstring(svg).iter(f"{SVG_NAMESPACE}circle"))
    marks = np.array([[float(circle.get(name, "0")) for name in ("cx", "cy", "r")] for circle in circles]).reshape(-1, 3)
    found = Dots(marks[:, :2], marks[:, 2], np.full(len(marks), BLACK, np.uint8))
    settings = {"version": installation.program_version(program), **{name[2:]: value for name, value in options.items()}}
    drawing = picture(found, width, height, settings)
    return replace(drawing, svg=svg)


METHODS = (
    Method(
        "potrace",
        "potrace",
        "Selinger 2003, the program; Otsu 1979",
        trace_by_potrace,
        missing=lambda: installation.missing("potrace"),
    ),
    Method(
        "vtracer",
        "vtracer",
        "the program of visioncortex",
        trace_by_vtracer,
        missing=lambda: installation.missing("vtracer"),
    ),
    Method(
        "inksep",
        "inksep",
        "the program of its contributors; after Secord 2002",
        stipple_by_inksep,
        is_budgeted=True,
        missing=lambda: installation.missing("inksep"),
    ),
)
