"""Sizes on paper, as the command line writes them into every format and other programs read them."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import ezdxf
import ezdxf.bbox
import numpy as np
import pypdfium2
import pytest
from numpy.typing import NDArray
from PIL import Image
from tests.commands import FAILURE, USAGE, assert_one_sentence, done, native_binary, run
from tests.support import photo

WIDTH, HEIGHT = 200, 150
MM_PER_PX = 25.4 / 96
POINTS_PER_MM = 72 / 25.4


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make a folder with a photo in it."""
    folder = tmp_path_factory.mktemp("sizes")
    Image.fromarray(photo("astronaut", WIDTH, HEIGHT)).save(folder / "photo.png")
    return folder


def draw(folder: Path, name: str, *arguments: object) -> Path:
    done(native_binary(), "photo.png", "-o", name, *arguments, cwd=folder)
    return folder / name


def pdf_page(path: Path) -> pypdfium2.PdfPage:
    document = pypdfium2.PdfDocument(path)
    assert len(document) == 1
    return document[0]


def grey(image: Image.Image) -> NDArray[np.float64]:
    return np.asarray(image.convert("L")).astype(np.float64)


def averaged(picture: NDArray[np.float64], factor: int) -> NDArray[np.float64]:
    height, width = picture.shape
    return picture.reshape(height // factor, factor, width // factor, factor).mean((1, 3))


SIZES = {
    "plain": ([], (WIDTH * MM_PER_PX, HEIGHT * MM_PER_PX), (0, 0)),
    "width": (["--width", "80mm"], (80, 60), (0, 0)),
    "margin": (["--width", "4in", "--margin", "1.5cm"], (131.6, 106.2), (15, 15)),
    "sheet": (["--page", "A4", "--margin", "10mm"], (297, 210), (21.83333, 10)),
    "width on a sheet": (["--page", "letter", "--width", "100mm"], (279.4, 215.9), (89.7, 70.45)),
    "upright size": (["--page", "100x200mm", "--width", "192px"], (100, 200), (24.6, 80.95)),
}
"""Arguments, and in mm the page and the upper left corner of the drawing on it."""

on_every_size = pytest.mark.parametrize(("arguments", "page", "corner"), SIZES.values(), ids=SIZES)


@on_every_size
def test_a_pdf_has_the_size_of_its_page(folder, arguments, page, corner):
    found = pdf_page(draw(folder, "out.pdf", *arguments))
    np.testing.assert_allclose(found.get_size(), np.array(page) * POINTS_PER_MM, atol=0.01)
    # Black ink lies where the drawing does, to the pixel of the page's raster.
    picture = grey(found.render(scale=300 / 72).to_pil())
    rows, columns = (np.flatnonzero((picture < 64).any(axis)) for axis in (1, 0))
    inner = [side - 2 * margin for side, margin in zip(page, corner, strict=True)]
    for hit, begin, size in ((columns, corner[0], inner[0]), (rows, corner[1], inner[1])):
        low, high = (value * 300 / 25.4 for value in (begin, begin + size))
        slack = 0.03 * (high - low) + 1
        assert low - 1 <= hit[0] <= low + slack
        assert high - slack <= hit[-1] <= high + 1


@on_every_size
def test_an_eps_has_the_bounding_box_of_its_page(folder, arguments, page, corner):
    text = draw(folder, "out.eps", *arguments).read_text()
    assert text.startswith("%!PS-Adobe-3.0 EPSF-3.0\n")
    exact = re.search(r"^%%HiResBoundingBox: 0 0 (\S+) (\S+)$", text, re.MULTILINE)
    whole = re.search(r"^%%BoundingBox: 0 0 (\d+) (\d+)$", text, re.MULTILINE)
    np.testing.assert_allclose([float(exact[1]), float(exact[2])], np.array(page) * POINTS_PER_MM, atol=0.01)
    for side in (1, 2):
        assert 0 <= int(whole[side]) - float(exact[side]) < 1


@on_every_size
def test_a_dxf_is_in_millimetres(folder, arguments, page, corner):
    document = ezdxf.readfile(draw(folder, "out.dxf", *arguments))
    auditor = document.audit()
    assert not auditor.errors
    assert not auditor.fixes
    assert document.units == ezdxf.units.MM
    assert document.header["$MEASUREMENT"] == 1
    np.testing.assert_allclose(document.header["$EXTMAX"][:2], page, atol=1e-3)
    box = ezdxf.bbox.extents(document.modelspace(), fast=False)
    inner = [side - 2 * margin for side, margin in zip(page, corner, strict=True)]
    for axis in (0, 1):
        # The drawing's black reaches nearly everywhere; nothing reaches beyond.
        assert corner[axis] - 1e-3 <= box.extmin[axis] <= corner[axis] + 0.03 * inner[axis]
        assert corner[axis] + 0.97 * inner[axis] <= box.extmax[axis] <= corner[axis] + inner[axis] + 1e-3


def test_a_dxf_has_every_boundary_once(folder):
    model = ezdxf.readfile(draw(folder, "out.dxf")).modelspace()
    polylines = [tuple(line.get_points("xy")) for line in model.query("LWPOLYLINE")]
    circles = [(*circle.dxf.center, circle.dxf.radius) for circle in model.query("CIRCLE")]
    assert len(polylines) + len(circles) == len(model)
    assert len(set(circles)) == len(circles) > 50
    assert len({frozenset(points) for points in polylines}) == len(polylines) > 20
    assert all(line.closed and len(line) >= 3 for line in model.query("LWPOLYLINE"))
    both = ezdxf.readfile(draw(folder, "both.dxf", "--inks", "both"))
    names = {layer.dxf.name: layer.color for layer in both.layers if layer.dxf.name not in ("0", "Defpoints")}
    assert names == {"black-regions": 7, "black-stipples": 7, "white-regions": 1, "white-stipples": 1}


@pytest.mark.parametrize(
    ("arguments", "size", "dpi"),
    [
        ([], (WIDTH, HEIGHT), None),
        (["--width", 300], (300, 225), None),
        (["--width", "300px", "--margin", 10], (320, 245), None),
        (["--width", "300px", "--dpi", 150], (300, 225), 150),
        (["--width", "4in"], (1200, 900), 300),
        (["--width", "4in", "--margin", "0.5in", "--dpi", 100], (500, 400), 100),
        (["--page", "A6", "--dpi", 254], (1480, 1050), 254),
    ],
    ids=str,
)
def test_a_png_has_pixels_and_a_resolution(folder, arguments, size, dpi):
    with Image.open(draw(folder, "out.png", *arguments)) as image:
        assert (image.size, image.mode) == (size, "L")
        told = image.info.get("dpi")
    if dpi is None:
        assert told is None
    else:
        # The format counts whole pixels per metre.
        np.testing.assert_allclose(told, dpi, atol=0.02)


def test_one_bit_is_black_and_white_of_the_same_picture(folder):
    arguments = ["--width", "50mm", "--margin", "2mm"]
    image = Image.open(draw(folder, "bits.png", *arguments, "--one-bit"))
    assert (image.mode, image.size) == ("1", (639, 491))
    np.testing.assert_allclose(image.info["dpi"], 300, atol=0.02)
    whole = np.asarray(Image.open(draw(folder, "grey.png", *arguments)))
    np.testing.assert_array_equal(np.asarray(image), whole >= 128)
    assert whole[:24].min() == whole[:, -24:].min() == 255, "the margin is white"


def test_a_margin_does_not_change_the_drawing(folder):
    plain = np.asarray(Image.open(draw(folder, "plain.png", "--width", 500)))
    wide = np.asarray(Image.open(draw(folder, "wide.png", "--width", 500, "--margin", 33)))
    np.testing.assert_array_equal(wide[33:-33, 33:-33], plain)


# The same picture ----------------------------------------------------------------------------------------------------------------

STYLES = [[], ["--style", "layered"], ["--inks", "white"], ["--inks", "both"]]
on_every_style = pytest.mark.parametrize("style", STYLES, ids=" ".join)


@on_every_style
def test_a_pdf_is_the_picture_of_the_png(folder, style):
    arguments = ["--page", "200x200px", "--margin", "5px"]
    expected = averaged(grey(Image.open(draw(folder, "out.png", "--page", "800x800px", "--margin", "20px"))), 4)
    found = averaged(grey(pdf_page(draw(folder, "out.pdf", *arguments, *style)).render(scale=4 * 96 / 72).to_pil()), 4)
    assert found.shape == expected.shape
    # Two inks beside each other leave a seam around every dot.
    assert np.abs(found - expected).mean() < (3 if "both" in style else 2)
    assert np.abs(found - expected).max() < 64


@pytest.mark.skipif(shutil.which("gs") is None, reason="ghostscript is not installed")
@on_every_style
def test_an_eps_is_the_picture_of_the_png(folder, style):
    path = draw(folder, "out.eps", "--margin", "5px", *style)
    command = ["gs", "-q", "-dNOPAUSE", "-dBATCH", "-dSAFER", "-sDEVICE=pnggray", "-r768", "-dEPSCrop", "-sOutputFile=eps.png"]
    subprocess.run([*command, path.name], cwd=folder, check=True, timeout=120)
    expected = averaged(grey(Image.open(draw(folder, "out.png", "--width", 1600, "--margin", 40))), 8)
    found = averaged(grey(Image.open(folder / "eps.png")), 8)
    assert found.shape == expected.shape
    # PostScript paints every pixel that a shape touches, half a pixel of the fine raster more than there is.
    assert np.abs(found - expected).mean() < 8


@pytest.mark.parametrize("suffix", ["pdf", "eps", "dxf", "png"])
def test_the_same_bytes_every_time(folder, suffix):
    arguments = ["--width", "100mm", "--margin", "1mm"]
    first, second = (draw(folder, f"{name}.{suffix}", *arguments, "--threads", n).read_bytes() for name, n in (("a", 1), ("b", 3)))
    assert first == second
    assert not re.search(rb"CreationDate|ModDate|TDCREATE|photo|20\d\d-\d\d", first)


# Layers --------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("style", "labels"),
    [
        ([], ["Black regions", "Black stipples"]),
        (["--inks", "white"], ["Paper", "White regions", "White stipples"]),
        (["--inks", "both"], ["Underlay", "Black regions", "Black stipples", "White regions", "White stipples"]),
    ],
    ids=["black", "white", "both"],
)
def test_layers_have_names(folder, style, labels):
    assert re.findall(rb"/OCG\s*/Name \((.*?)\)", draw(folder, "out.pdf", *style).read_bytes()) == [x.encode() for x in labels]
    assert re.findall(r"%%BeginObject: (.*)", draw(folder, "out.eps", *style).read_text()) == labels
    model = ezdxf.readfile(draw(folder, "out.dxf", *style)).modelspace()
    # A DXF has outlines, which nothing shines through.
    outlined = [label for label in labels if label != "Underlay"]
    assert list(dict.fromkeys(entity.dxf.layer for entity in model)) == [x.lower().replace(" ", "-") for x in outlined]


# Dots ----------------------------------------------------------------------------------------------------------------------------


def test_dots_have_a_least_radius_on_paper(folder):
    def stats(*arguments: object) -> dict[str, float]:
        return json.loads(done(native_binary(), "photo.png", "-o", "dots.dxf", "--stats", *arguments, cwd=folder).stdout)

    before = stats("--width", "100mm")
    assert (before["dots_enlarged"], before["dots_dropped"]) == (0, 0)
    radii = [circle.dxf.radius for circle in ezdxf.readfile(folder / "dots.dxf").modelspace().query("CIRCLE")]
    assert min(radii) < 0.4
    after = stats("--width", "100mm", "--min-dot", "0.4mm")
    assert after["dots_enlarged"] > 0
    assert after["stipples"] == before["stipples"] - after["dots_dropped"]
    radii = [circle.dxf.radius for circle in ezdxf.readfile(folder / "dots.dxf").modelspace().query("CIRCLE")]
    assert min(radii) >= 0.4 - 1e-3
    # The same length on larger paper is fewer pixels.
    large = stats("--width", "1000mm", "--min-dot", "0.4mm")
    assert large["dots_enlarged"] + large["dots_dropped"] < after["dots_enlarged"] + after["dots_dropped"]


# Errors --------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (
            ["-o", "no.pdf", "--page", "A4", "--width", "300mm"],
            FAILURE,
            "the drawing would be 300 x 225 mm, but the page A4 has room for 297 x 210 mm inside its margins",
        ),
        (
            ["-o", "no.svg", "--page", "A6", "--margin", "6cm"],
            FAILURE,
            "the margin of 6cm leaves nothing of the page A6: 148 x 105 mm",
        ),
        (["-o", "no.png", "--width", "60in", "--dpi", "2000"], FAILURE, "the image would be 120000 x 90000 pixels"),
        (["-o", "no.png", "--width", "60000"], FAILURE, "the raster would be 60000 x 45000 pixels"),
        (["-o", "no.dxf", "--width", "0"], USAGE, "--width is 0px, but it must be between 0.1mm and 100000mm"),
        (["-o", "no.png", "--dpi", "20000"], USAGE, "--dpi is 20000, but it must be between 1 and 10000 pixels per inch"),
        (["-o", "no.eps", "--dpi", "300"], USAGE, "--dpi is 300, but it must be left out unless the file is a .png"),
        (["-o", "no.pdf", "--one-bit"], USAGE, "--one-bit is True, but it must be left out unless the file is a .png"),
        (["-o", "no.svg", "--min-dot", "2000mm"], USAGE, "--min-dot is 2000mm, but it must be at most 1000mm"),
        (
            ["-o", "no.svg", "--width", "5 feet"],
            USAGE,
            '--width is "5 feet", but it must be a number, at least 0, with mm, cm',
        ),
        (
            ["-o", "no.svg", "--page", "A0"],
            USAGE,
            '--page is "A0", but it must be A3, A4, A5, A6, letter, legal, tabloid, or',
        ),
        (["-o", "no.svg", "--style", "layered", "--inks", "white"], USAGE, "a layered drawing has both inks"),
    ],
    ids=lambda value: " ".join(value[2:]) if isinstance(value, list) else "",
)
def test_sizes_that_cannot_be(folder, arguments, code, message):
    result = run(native_binary(), "photo.png", *arguments, cwd=folder)
    assert_one_sentence(result, code)
    assert message in result.stderr.decode()
    assert not list(folder.glob("no.*"))
