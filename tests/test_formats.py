"""Every format, opened by a program that is not ours and compared with our own raster; sizes on paper, layers, stable bytes."""

from __future__ import annotations

import functools
import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import ezdxf.bbox
import ezdxf.units
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from tests import oracles, readers
from tests.soundness import noise
from tests.support import options_with, photo

import graphstipple as gs

INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"
SVG = "{http://www.w3.org/2000/svg}"

FINE = 4
"""Other programs paint this many times as large and are averaged: how they antialias, and the few sides that they give small
circles, hardly counts then."""

MEAN_TOLERANCE = 2.5
"""Mean difference of two pictures, of 255: above what sampling leaves (about 1), well below a missing layer."""

PIXEL_TOLERANCE = 48.0
"""Largest difference of a pixel, of 255: several small dots in it, each with its own error of sampling."""

SUFFIXES = ("svg", "svgz", "pdf", "eps", "dxf", "png")
STYLES: list[dict[str, Any]] = [
    {"style": "flat", "only": "black"},
    {"style": "flat", "only": "white"},
    {"style": "flat", "only": "black,white"},
    {"style": "layered"},
]
styles = pytest.mark.parametrize("style", STYLES, ids=["black", "white", "both", "layered"])


@functools.cache
def drawn(name: str) -> gs.Drawing:
    """Draw a photo or an awkward image; the tests share it and only read."""
    dark_to_light = np.tile(np.linspace(20, 235, 48).astype(np.uint8), (36, 1))
    images: dict[str, tuple[NDArray[np.uint8], gs.Options]] = {
        "camera": (np.ascontiguousarray(photo("camera")[::2, ::2][:224]), gs.Options()),
        "black": (np.zeros((30, 40), np.uint8), gs.Options()),
        "white": (np.full((30, 40), 255, np.uint8), gs.Options()),
        "one pixel": (np.zeros((1, 1), np.uint8), gs.Options()),
        "a row": (noise(3, 40, 1), options_with(density=1.0)),
        "a column": (noise(4, 1, 40), options_with(density=1.0)),
        "dots at the frame": (
            dark_to_light,
            options_with("paper", nodes_per_pixel=0.3, alpha=1.0, stipple_scale=2.0, tolerance=0.25),
        ),
    }
    image, options = images[name]
    return gs.draw(image, options=options)


MM_PER_PIXEL = 25.4 / 96
"""Of a drawing that is written without a size."""

AWKWARD = ("black", "white", "one pixel", "a row", "a column", "dots at the frame")


def painted(path: Path, width: int) -> NDArray[np.uint8]:
    """Paint a file by a program that is not ours, at a width in pixels."""
    match path.suffix:
        case ".svg":
            # Where two inks meet, antialiasing lets the paper shine through, in a line as thin as pixels are.
            return finer(lambda path, width: readers.svg(path.read_text("utf-8"), width), path, width)
        case ".pdf":
            return finer(readers.pdf, path, width)
        case ".png":
            return readers.png(path)
        case _:
            # The reader does not antialias.
            return finer(readers.postscript, path, width)


def finer(paint: Callable[[Path, int], NDArray[np.uint8]], path: Path, width: int, factor: int = 2) -> NDArray[np.uint8]:
    """Paint a file as many times as large, and average."""
    return np.round(oracles.box_average(paint(path, factor * width), factor)).astype(np.uint8)


def painted_dxf(path: Path, drawing: gs.Drawing, width: int, *, black_paper: bool) -> NDArray[np.uint8]:
    """Paint a DXF of a drawing without margins: its layers in their order, each by the even-odd rule in the ink of its name."""
    document = readers.dxf(path)
    rings = readers.dxf_rings(document)
    # Without antialiasing, and so as fine again.
    scale = 2 * width / drawing.width
    height = round(scale * drawing.height)
    pixels = np.full((height, 2 * width), 255, np.uint8)
    for layer in document.layers:
        name = layer.dxf.name
        pixel_rings = [scale * (ring / MM_PER_PIXEL * [1, -1] + [0, drawing.height]) for ring in rings.get(name, [])]
        black = black_paper if name == "paper" else "black" in name
        pixels[readers.fill(pixel_rings, 2 * width, height)] = 0 if black else 255
    return np.round(oracles.box_average(pixels, 2)).astype(np.uint8)


def check_same(theirs: NDArray[Any], ours: NDArray[Any]) -> None:
    assert theirs.shape == ours.shape
    difference = np.abs(theirs.astype(float) - ours)
    assert difference.mean() < MEAN_TOLERANCE
    assert difference.max() < PIXEL_TOLERANCE


def reference(drawing: gs.Drawing) -> NDArray[np.floating]:
    """Our own raster, fine and averaged."""
    return oracles.box_average(drawing.rasterize(FINE * drawing.width), FINE)


# Pictures ------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["camera", *AWKWARD])
@pytest.mark.parametrize("suffix", ["svg", "pdf", "eps", "dxf"])
@styles
def test_every_vector_format_shows_the_picture(name: str, suffix: str, style: dict[str, Any], tmp_path: Path) -> None:
    drawing = drawn(name)
    path = tmp_path / f"drawing.{suffix}"
    drawing.save(path, **style)
    width = FINE * drawing.width
    fine = painted_dxf(path, drawing, width, black_paper=style.get("only") == "white") if suffix == "dxf" else painted(path, width)
    check_same(oracles.box_average(fine, FINE), reference(drawing))


@pytest.mark.skipif(readers.GHOSTSCRIPT is None, reason="ghostscript is not installed")
@pytest.mark.parametrize("name", ["camera", "dots at the frame"])
@styles
def test_ghostscript_shows_the_picture(name: str, style: dict[str, Any], tmp_path: Path) -> None:
    drawing = drawn(name)
    path = tmp_path / "drawing.eps"
    drawing.save(path, **style)
    fine = finer(readers.ghostscript, path, FINE * drawing.width)
    check_same(oracles.box_average(fine, FINE), reference(drawing))


@pytest.mark.parametrize("name", ["camera", *AWKWARD])
def test_png_is_the_raster(name: str, tmp_path: Path) -> None:
    drawing = drawn(name)
    for width in (None, 3 * drawing.width):
        drawing.save(tmp_path / "drawing.png", width)
        np.testing.assert_array_equal(readers.png(tmp_path / "drawing.png"), drawing.rasterize(width))


@pytest.mark.parametrize("name", ["camera", *AWKWARD])
def test_one_bit_png_is_the_raster_at_half_coverage(name: str, tmp_path: Path) -> None:
    drawing = drawn(name)
    width = 2 * drawing.width
    drawing.save(tmp_path / "drawing.png", width, one_bit=True)
    with Image.open(tmp_path / "drawing.png") as image:
        assert image.mode == "1"
        pixels = np.asarray(image)
    grey = drawing.rasterize(width)
    assert pixels.shape == grey.shape
    # A pixel that is half covered may fall on either side.
    clear = np.abs(grey.astype(float) - 127.5) > 1
    np.testing.assert_array_equal(pixels[clear], grey[clear] > 127)


def test_dots_at_the_frame_lie_inside() -> None:
    drawing = drawn("dots at the frame")
    dots = drawing.stipples
    sides = [dots["x"], dots["y"], drawing.width - dots["x"], drawing.height - dots["y"]]
    gap = np.min(sides, axis=0) - dots["radius"]
    assert gap.min() > -1e-9
    assert set(dots["ink"][gap < 0.5]) == {0, 1}


@pytest.mark.parametrize("name", ["camera", "dots at the frame"])
def test_flat_and_layered_differ_at_antialiased_pixels_only(name: str) -> None:
    drawing = drawn(name)
    for width in (drawing.width, FINE * drawing.width):
        layered = readers.svg(drawing.svg(style="layered"), width).astype(int)
        around = np.lib.stride_tricks.sliding_window_view(np.pad(layered, 1, "edge"), (3, 3))
        edge = around.max(axis=(2, 3)) > around.min(axis=(2, 3))
        for only in ("black", "white", "black,white"):
            flat = readers.svg(drawing.svg(only=only), width)
            assert not ((flat != layered) & ~edge).any()
            assert np.abs(flat.astype(int) - layered).mean() < 0.5


@pytest.mark.parametrize("suffix", ["svg", "pdf", "eps", "png"])
@pytest.mark.parametrize("name", ["black", "dots at the frame"])
def test_a_margin_is_empty_paper(name: str, suffix: str, tmp_path: Path) -> None:
    drawing = drawn(name)
    path = tmp_path / f"drawing.{suffix}"
    margin = 3
    scale = 1 if suffix == "png" else FINE
    drawing.save(path, margin=margin)
    width = scale * (drawing.width + 2 * margin)
    pixels = painted(path, width)
    assert pixels.shape == (scale * (drawing.height + 2 * margin), width)
    inner = pixels[scale * margin : -scale * margin, scale * margin : -scale * margin].astype(float)
    outer = pixels.astype(float)
    outer[scale * margin : -scale * margin, scale * margin : -scale * margin] = 255
    assert outer.min() > 200
    check_same(oracles.box_average(inner, scale), reference(drawing) if scale > 1 else drawing.rasterize())


# Layers --------------------------------------------------------------------------------------------------------------------------

FLAT_LAYERS = {
    "black": ["black-regions", "black-stipples"],
    "white": ["paper", "white-regions", "white-stipples"],
    "black,white": ["underlay", "black-regions", "black-stipples", "white-regions", "white-stipples"],
}


@pytest.mark.parametrize("only", FLAT_LAYERS)
def test_layers_of_a_flat_drawing(only: Any, tmp_path: Path) -> None:
    drawing, ids = drawn("camera"), FLAT_LAYERS[only]
    labels = [name.capitalize().replace("-", " ") for name in ids]

    groups = ElementTree.fromstring(drawing.svg(only=only)).findall(f"{SVG}g")
    assert [group.get("id") for group in groups] == ids
    assert [group.get(f"{INKSCAPE}label") for group in groups] == labels
    assert {group.get(f"{INKSCAPE}groupmode") for group in groups} == {"layer"}

    drawing.save(tmp_path / "drawing.pdf", only=only)
    assert pdf_layers(tmp_path / "drawing.pdf") == labels

    drawing.save(tmp_path / "drawing.eps", only=only)
    assert re.findall(r"%%BeginObject: (.*)", (tmp_path / "drawing.eps").read_text("ascii")) == labels

    drawing.save(tmp_path / "drawing.dxf", only=only)
    document = readers.dxf(tmp_path / "drawing.dxf")
    own = [layer.dxf.name for layer in document.layers if layer.dxf.name.lower() not in {"0", "defpoints"}]
    assert own == [name for name in ids if name != "underlay"]
    circles = {entity.dxf.layer for entity in document.modelspace() if entity.dxftype() == "CIRCLE"}
    assert {name for name in ids if name.endswith("stipples")} <= circles


def test_layers_of_a_layered_drawing(tmp_path: Path) -> None:
    drawing = drawn("camera")
    groups = ElementTree.fromstring(drawing.svg(style="layered")).findall(f"{SVG}g")
    ids = [group.get("id") or "" for group in groups]
    assert ids[0] == "paper"
    assert len(set(ids)) == len(ids)
    # Odd levels are black, even ones white.
    for name in ids[1:]:
        found = re.fullmatch(r"level-(\d+)-(black|white)-(regions|stipples)", name)
        assert found is not None, name
        assert found[2] == ("black" if int(found[1]) % 2 else "white")
    assert {group.get(f"{INKSCAPE}groupmode") for group in groups} == {"layer"}
    drawing.save(tmp_path / "drawing.pdf", style="layered")
    assert pdf_layers(tmp_path / "drawing.pdf") == [group.get(f"{INKSCAPE}label") for group in groups]


def pdf_layers(path: Path) -> list[str]:
    """Names of the optional content groups: their dictionaries are plain text."""
    objects = re.findall(rb"<<(.*?)>>", path.read_bytes(), re.S)
    names = [re.search(rb"/Name \((.*?)\)", text) for text in objects if b"/Type /OCG" in text]
    return [found[1].decode() for found in names if found]


@functools.cache
def drawn_anew(threads: int) -> gs.Drawing:
    """Draw a photo, each time from the start."""
    return gs.draw(np.ascontiguousarray(photo("coffee", 96, 64)), options=gs.Options(threads=threads))


@pytest.mark.parametrize("suffix", [*SUFFIXES, "json"])
@styles
def test_the_same_bytes_in_every_run(suffix: str, style: dict[str, Any], tmp_path: Path) -> None:
    written = []
    for threads in (1, 3):
        drawn_anew(threads).save(tmp_path / f"{threads}.{suffix}", width="120mm", margin="5mm", **style)
        written.append((tmp_path / f"{threads}.{suffix}").read_bytes())
    assert written[0] == written[1]
    # Neither when nor where: what is packed has no such words.
    assert not re.search(rb"CreationDate|ModDate|TDCREATE|/tmp/|20\d\d-\d\d", written[0])


def test_saved_text_is_what_the_methods_return(tmp_path: Path) -> None:
    drawing = drawn("camera")
    drawing.save(tmp_path / "drawing.svg", "200mm", margin="1cm", page="A3", only="black,white")
    assert (tmp_path / "drawing.svg").read_text("utf-8") == drawing.svg(width="200mm", margin="1cm", page="A3", only="black,white")
    drawing.save(tmp_path / "drawing.json")
    assert (tmp_path / "drawing.json").read_text("utf-8") == drawing.json()


# Sizes on paper ------------------------------------------------------------------------------------------------------------------


def millimetres(text: str | None) -> float:
    """Read a length of an SVG; the renderer knows px, which are 1/96 inch, as plain numbers."""
    found = re.fullmatch(r"([\d.]+)(mm|cm|in|pt|px|)", text or "")
    assert found is not None, text
    return float(found[1]) * {"mm": 1, "cm": 10, "in": 25.4, "pt": 25.4 / 72, "px": 25.4 / 96, "": 25.4 / 96}[found[2]]


SIZES: list[tuple[dict[str, Any], tuple[float, float], float]] = [
    # For a canvas of 256 x 224: the page in millimetres, and the width of the drawing on it.
    ({"width": "200mm"}, (200, 175), 200),
    ({"width": "20cm", "margin": "10mm"}, (220, 195), 200),
    ({"width": "4in"}, (101.6, 88.9), 101.6),
    ({"width": 512}, (512 * 25.4 / 96, 448 * 25.4 / 96), 512 * 25.4 / 96),
    ({"page": "A4"}, (297, 210), 240),
    ({"page": "A4", "margin": "20mm"}, (297, 210), 170 / 224 * 256),
    ({"page": "letter", "width": "100mm"}, (279.4, 215.9), 100),
    ({"page": "300x400mm", "margin": "50mm"}, (300, 400), 200),
]


@pytest.mark.parametrize(("sizes", "page", "width"), SIZES, ids=[str(size[0]) for size in SIZES])
def test_sizes_are_written_into_every_vector_format(
    sizes: dict[str, Any], page: tuple[float, float], width: float, tmp_path: Path
) -> None:
    drawing = drawn("camera")
    assert (drawing.width, drawing.height) == (256, 224)

    root = ElementTree.fromstring(drawing.svg(**sizes))
    assert (millimetres(root.get("width")), millimetres(root.get("height"))) == pytest.approx(page, abs=0.01)
    left, top, box_width, box_height = (float(value) for value in (root.get("viewBox") or "").split())
    # The user unit stays the pixel of the canvas, whose corner is the origin.
    assert page[0] / box_width == pytest.approx(width / 256, rel=1e-3)
    assert page[1] / box_height == pytest.approx(width / 256, rel=1e-3)
    assert (left, top) == pytest.approx(((256 - box_width) / 2, (224 - box_height) / 2), abs=1e-3)

    drawing.save(tmp_path / "drawing.pdf", **sizes)
    assert readers.pdf_size(tmp_path / "drawing.pdf") == pytest.approx([v * readers.POINTS_PER_MM for v in page], abs=0.01)

    drawing.save(tmp_path / "drawing.eps", **sizes)
    program = (tmp_path / "drawing.eps").read_text("ascii")
    box = readers.bounding_box(program)
    assert box == pytest.approx([0, 0, *(v * readers.POINTS_PER_MM for v in page)], abs=0.01)
    # In whole points, it holds the page.
    whole = re.search(r"^%%BoundingBox: 0 0 (\d+) (\d+)$", program, re.M)
    assert whole is not None
    assert [int(side) for side in whole.groups()] == [math.ceil(side) for side in box[2:]]


@pytest.mark.parametrize("suffix", ["pdf", "eps"])
@pytest.mark.parametrize(("sizes", "page", "width"), SIZES, ids=[str(size[0]) for size in SIZES])
def test_a_drawing_lies_in_the_middle_of_its_page(
    sizes: dict[str, Any], page: tuple[float, float], width: float, suffix: str, tmp_path: Path
) -> None:
    gs.draw(np.zeros((224, 256), np.uint8)).save(path := tmp_path / f"drawing.{suffix}", **sizes)
    pixels = readers.pdf(path, 800) if suffix == "pdf" else readers.postscript(path, 800)
    assert pixels.shape[0] == pytest.approx(800 * page[1] / page[0], abs=1)
    for axis, side, length in ((0, page[0], width), (1, page[1], width / 256 * 224)):
        black = np.flatnonzero((pixels < 128).any(axis=axis))
        expected = ((side - length) / 2, (side + length) / 2)
        # pdfium makes a page as high as whole pixels are.
        assert (black[0], black[-1] + 1) == pytest.approx([value / page[0] * 800 for value in expected], abs=1.5)


@pytest.mark.parametrize(("sizes", "page", "width"), SIZES, ids=[str(size[0]) for size in SIZES])
def test_dxf_is_in_millimetres(sizes: dict[str, Any], page: tuple[float, float], width: float, tmp_path: Path) -> None:
    drawing = gs.draw(np.zeros((224, 256), np.uint8))
    drawing.save(tmp_path / "drawing.dxf", **sizes)
    document = readers.dxf(tmp_path / "drawing.dxf")
    box = ezdxf.bbox.extents(document.modelspace())
    height = width / 256 * 224
    expected = ((page[0] - width) / 2, (page[1] - height) / 2, (page[0] + width) / 2, (page[1] + height) / 2)
    assert (box.extmin.x, box.extmin.y, box.extmax.x, box.extmax.y) == pytest.approx(expected, abs=0.01)
    assert document.units == ezdxf.units.MM
    assert document.header["$MEASUREMENT"] == 1
    assert document.header["$EXTMAX"][:2] == pytest.approx(page, abs=0.001)


def test_a_dxf_has_every_boundary_once(tmp_path: Path) -> None:
    drawn("camera").save(path := tmp_path / "drawing.dxf", only="black,white")
    document = readers.dxf(path)
    colours = {layer.dxf.name: layer.color for layer in document.layers if layer.dxf.name.lower() not in {"0", "defpoints"}}
    assert colours == {"black-regions": 7, "black-stipples": 7, "white-regions": 1, "white-stipples": 1}
    drawn("camera").save(path)
    model = readers.dxf(path).modelspace()
    rings = [frozenset(line.get_points("xy")) for line in model.query("LWPOLYLINE")]
    circles = [(*circle.dxf.center, circle.dxf.radius) for circle in model.query("CIRCLE")]
    assert len(rings) + len(circles) == len(model)
    assert len(set(rings)) == len(rings) > 20
    assert len(set(circles)) == len(circles) > 50


def test_png_pixels_and_resolution(tmp_path: Path) -> None:
    drawing = drawn("camera")
    cases: list[tuple[dict[str, Any], tuple[int, int], float | None]] = [
        ({}, (256, 224), None),
        ({"width": 512}, (512, 448), None),
        ({"width": "512px", "dpi": 300}, (512, 448), 300),
        ({"width": "2in"}, (600, 525), 300),
        ({"width": "2in", "dpi": 100}, (200, 175), 100),
        ({"width": "2in", "margin": "0.5in", "dpi": 100}, (300, 275), 100),
        ({"page": "A6", "dpi": 100}, (583, 413), 100),
        ({"margin": 10}, (276, 244), None),
    ]
    for sizes, pixels, dpi in cases:
        drawing.save(tmp_path / "drawing.png", **sizes)
        with Image.open(tmp_path / "drawing.png") as image:
            assert (image.size, image.mode) == (pixels, "L"), sizes
            if dpi is None:
                assert "dpi" not in image.info, sizes
            else:
                assert image.info["dpi"] == pytest.approx((dpi, dpi), rel=1e-3), sizes


def test_a_size_does_not_change_the_drawing(tmp_path: Path) -> None:
    drawing = drawn("camera")
    before = drawing.json()
    for suffix in (*SUFFIXES, "json"):
        drawing.save(tmp_path / f"drawing.{suffix}", "50mm", style="layered")
    assert drawing.json() == before


# Small files ---------------------------------------------------------------------------------------------------------------------

PAIRS = {"m": 1, "l": 1, "t": 1, "h": 1, "v": 1, "q": 2, "s": 2, "c": 3}
NUMBERS = {"m": 2, "l": 2, "t": 2, "h": 1, "v": 1, "q": 4, "s": 4, "c": 6}


def coordinate_pairs(data: str) -> int:
    """Count the coordinate pairs of path data."""
    pairs = 0
    for letter, numbers in re.findall(r"([a-z])([^a-z]*)", data):
        if letter != "z":
            count = len(re.findall(r"-?(?:\d+\.?\d*|\.\d+)", numbers))
            assert count % NUMBERS[letter] == 0, (letter, numbers)
            pairs += count // NUMBERS[letter] * PAIRS[letter]
    return pairs


def test_path_data_is_short() -> None:
    root = ElementTree.fromstring(drawn("camera").svg())
    regions = next(group for group in root.findall(f"{SVG}g") if group.get("id") == "black-regions")
    data = "".join(path.get("d") or "" for path in regions.iter(f"{SVG}path"))
    # A hole that is a dot is a circle of two arcs: dots are counted on their own.
    data = re.sub(r"m[^a-z]*a[^z]*z", "", data)
    assert len(data) <= 6 * coordinate_pairs(data)


def test_json_is_for_programs() -> None:
    drawing = drawn("camera")
    document = json.loads(drawing.json())
    assert document["canvas"] == {"width": drawing.width, "height": drawing.height}
    assert document["version"] == gs.__version__
    assert document["options"]["tolerance"] == 0.5
    assert len(document["stipples"]) == len(drawing.stipples)
    assert len(document["regions"]) == len(drawing.regions)
    dot, expected = document["stipples"][0], drawing.stipples[0]
    assert [dot["x"], dot["y"], dot["radius"], dot["ink"]] == list(expected.tolist())


# DXF -----------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["camera", *AWKWARD])
def test_splines_of_a_dxf_enclose_what_its_polylines_do(name: str, tmp_path: Path) -> None:
    drawing = drawn(name)
    found = []
    for curves in ("polylines", "splines"):
        drawing.save(path := tmp_path / f"{curves}.dxf", curves=curves, width="200mm")
        document = readers.dxf(path)
        kinds = {entity.dxftype() for entity in document.modelspace()}
        assert kinds <= {"CIRCLE", "LWPOLYLINE" if curves == "polylines" else "SPLINE"}
        found.append(readers.dxf_rings(document, 0.002))
    polylines, splines = found
    assert polylines.keys() == splines.keys()
    # A polyline lies so far from its curve, in millimetres.
    off = 0.05 * 200 / drawing.width
    for layer, rings in polylines.items():
        assert len(splines[layer]) == len(rings)
        for polyline, spline in zip(rings, splines[layer], strict=True):
            length = np.hypot(*np.diff(polyline, axis=0, append=polyline[:1]).T).sum()
            assert abs(shoelace(spline) - shoelace(polyline)) < 1.1 * off * length
        assert sum(map(shoelace, splines[layer])) == pytest.approx(sum(map(shoelace, rings)), rel=0.01)


def shoelace(ring: NDArray[np.float64]) -> float:
    """Return the signed area of a ring."""
    following = np.roll(ring, -1, axis=0)
    return float(np.sum(ring[:, 0] * following[:, 1] - ring[:, 1] * following[:, 0]) / 2)


@pytest.mark.parametrize(("page", "sides"), [("A4", (210, 297)), ("300x200mm", (300, 200)), (None, (200, 224 / 256 * 200))])
def test_a_dxf_is_printed_on_its_page(page: str | None, sides: tuple[float, float], tmp_path: Path) -> None:
    width = None if page else "200mm"
    drawn("camera").save(path := tmp_path / "drawing.dxf", page=page, width=width)
    landscape = drawn("camera").width > drawn("camera").height and page == "A4"
    expected = sides[::-1] if landscape else sides
    document = readers.dxf(path)
    for layout in document.layouts:
        settings = layout.dxf_layout.dxf
        assert (settings.paper_width, settings.paper_height) == pytest.approx(expected, abs=1e-3)
        assert (settings.plot_rotation, settings.plot_paper_units) == (0, 1)
        assert {settings.left_margin, settings.right_margin, settings.top_margin, settings.bottom_margin} == {0}
    assert tuple(document.header["$PLIMMAX"]) == pytest.approx(expected, abs=1e-3)


# Limits of other programs --------------------------------------------------------------------------------------------------------


def test_a_boundary_too_long_for_programs_is_told_of(tmp_path: Path) -> None:
    drawing = gs.draw(noise(5, 400, 400), options=options_with("paper", nodes_per_pixel=0.9))
    for suffix in ("svg", "pdf", "eps", "dxf"):
        with pytest.warns(
            gs.GraphStippleWarning, match=r"a boundary has \d+ points, but Illustrator leaves out .* more than 32000"
        ):
            drawing.save(tmp_path / f"drawing.{suffix}")
    # Warnings are errors: there is none of pixels and data.
    drawing.save(tmp_path / "drawing.png")
    drawing.save(tmp_path / "drawing.json")
