"""SVG that people edit and send: single marks, dots as strokes, compression, paper and underlay, in programs that are not ours."""

from __future__ import annotations

import gzip
import io
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pypdfium2
import pytest
import resvg_py
from PIL import Image
from tests import readers
from tests.support import photo

import graphstipple as gs

SVG = "{http://www.w3.org/2000/svg}"

STYLES: list[dict[str, Any]] = [{}, {"only": "white"}, {"only": "black,white"}, {"style": "layered"}]
styles = pytest.mark.parametrize("style", STYLES, ids=["black", "white", "both", "layered"])


@pytest.fixture(scope="module")
def portrait() -> gs.Drawing:
    """Many dots of both inks."""
    return gs.draw(np.ascontiguousarray(photo("astronaut")[:256, 64:320]), options=gs.Options.preset("portrait"))


def same(loaded: gs.Drawing, drawing: gs.Drawing) -> bool:
    """Whether two drawings are one: their JSON has all of it."""
    return loaded.json() == drawing.json()


# Elements ------------------------------------------------------------------------------------------------------------------------


@styles
def test_marks_are_elements_and_read_back(portrait: gs.Drawing, style: dict[str, Any], tmp_path: Path) -> None:
    portrait.save(tmp_path / "marks.svg", elements="marks", **style)
    assert same(gs.load(tmp_path / "marks.svg"), portrait)
    root = ElementTree.parse(tmp_path / "marks.svg").getroot()
    elements = {node.get("id", ""): node for node in root.iter() if node.tag in {f"{SVG}circle", f"{SVG}path"}}
    layers = [group.get("id") for group in ElementTree.fromstring(portrait.svg(**style)).findall(f"{SVG}g")]
    assert [group.get("id") for group in root.findall(f"{SVG}g")] == layers
    for name, node in elements.items():
        ink, kind, number = name.split("-")
        if kind == "stipple":
            x, y, radius, code = portrait.stipples[int(number)]
            scale = 16
            circle = [float(node.get(name, "")) / scale for name in ("cx", "cy", "r")]
            assert circle == pytest.approx([x, y, radius], abs=1e-9)
        else:
            code = portrait.regions[int(number)].ink
        assert ink == ("black", "white")[code]
    wanted = {"white": [1], "black,white": [0, 1]}.get(style.get("only", ""), [0, 1] if "style" in style else [0])
    dots = sum("-stipple-" in name for name in elements)
    assert dots == np.isin(portrait.stipples["ink"], wanted).sum()


def test_a_picture_of_marks_is_that_of_layers(portrait: gs.Drawing) -> None:
    for style in STYLES[2:]:
        ours, theirs = (readers.svg(portrait.svg(elements=elements, **style), 512).astype(int) for elements in ("layers", "marks"))
        # Marks that share a pixel are blended one by one.
        assert np.abs(ours - theirs).mean() < 0.3


@pytest.mark.skipif(readers.INKSCAPE is None, reason="Inkscape is not installed")
@pytest.mark.parametrize("style", [{}, {"style": "layered"}], ids=["flat", "layered"])
def test_a_dot_is_picked_and_moved_in_inkscape(portrait: gs.Drawing, style: dict[str, Any], tmp_path: Path) -> None:
    portrait.save(tmp_path / "drawing.svg", elements="marks", **style)
    # A black dot with bare paper a pixel around it.
    dots = portrait.stipples
    paper = portrait.rasterize() == 255
    number = next(
        i
        for i in np.flatnonzero((dots["ink"] == 0) & (dots["radius"] < 1.5))
        if paper[tuple(np.s_[max(0, int(v) - 3) : int(v) + 4] for v in (dots["y"][i], dots["x"][i]))].sum() > 30
    )
    out = tmp_path / "moved.svg"
    actions = (
        f"select-by-id:black-stipple-{number};transform-translate:0.5,0;export-filename:{out};export-plain-svg:false;export-do"
    )
    readers.inkscape_do(tmp_path / "drawing.svg", f"--actions={actions}")
    before, after = (
        {node.get("id"): node.attrib for node in ElementTree.parse(path).iter(f"{SVG}circle")}
        for path in (tmp_path / "drawing.svg", out)
    )
    moved = [name for name in before if abs(float(before[name]["cx"]) - float(after[name]["cx"])) > 1e-3]
    assert before.keys() == after.keys()
    assert moved == [f"black-stipple-{number}"]
    # Half a pixel is eight units of the layer.
    assert float(after[moved[0]]["cx"]) - float(before[moved[0]]["cx"]) == pytest.approx(8, abs=1e-3)


# Dots as strokes -----------------------------------------------------------------------------------------------------------------


@styles
def test_strokes_are_small_and_keep_the_ink(portrait: gs.Drawing, style: dict[str, Any], tmp_path: Path) -> None:
    portrait.save(tmp_path / "strokes.svg", dots="strokes", **style)
    loaded = gs.load(tmp_path / "strokes.svg")
    # What was rounded is not rounded again, and is a drawing like any other.
    assert loaded.svg(dots="strokes", **style) == (tmp_path / "strokes.svg").read_text("utf-8")
    loaded.save(tmp_path / "circles.svg", **style)
    assert same(gs.load(tmp_path / "circles.svg"), loaded)
    before, after = portrait.stipples, loaded.stipples
    assert len(before) == len(after)
    np.testing.assert_allclose(after["radius"], before["radius"], rtol=1 / 64)
    np.testing.assert_allclose(after["x"] - after["radius"], before["x"] - before["radius"], atol=1e-9)
    np.testing.assert_array_equal(after["y"], before["y"])
    assert len(np.unique(after["radius"])) < 400
    for ink in (0, 1):
        area = [np.sum(dots["radius"][dots["ink"] == ink] ** 2) for dots in (before, after)]
        assert area[1] == pytest.approx(area[0], rel=1e-3)


def test_strokes_take_a_quarter_of_the_bytes(portrait: gs.Drawing) -> None:
    def per_dot(svg: str) -> float:
        layers = re.findall(r'<g id="[^"]*-stipples".*?</g>', svg, re.S)
        return sum(map(len, layers)) / len(portrait.stipples)

    assert per_dot(portrait.svg(style="layered")) > 45
    assert per_dot(portrait.svg(style="layered", dots="strokes")) < 17


@pytest.fixture(scope="module")
def in_browser() -> Iterator[Callable[[str, int, int], Any]]:
    """Chromium."""
    if readers.CHROMIUM is None:
        pytest.skip("Chromium is not installed")
    with readers.chromium() as paint:
        yield paint


def painter(program: str, request: pytest.FixtureRequest) -> Callable[[Path, int], Any]:
    """Return what paints a square SVG by a program, or skip the test."""
    if program == "Chromium":
        in_browser = request.getfixturevalue("in_browser")
        return lambda path, width: in_browser(path.read_text("utf-8"), width, width)
    if program == "resvg":
        return lambda path, width: readers.svg(path.read_text("utf-8"), width)
    where, paint = {"librsvg": (readers.RSVG, readers.librsvg), "Inkscape": (readers.INKSCAPE, readers.inkscape)}[program]
    if where is None:
        pytest.skip(f"{program} is not installed")
    return paint


@pytest.mark.parametrize(
    ("program", "style"),
    [("resvg", {}), *((program, {"style": "layered"}) for program in ("resvg", "librsvg", "Inkscape", "Chromium"))],
    ids=lambda it: it if isinstance(it, str) else it.get("style", "flat"),
)
def test_strokes_look_like_dots(
    portrait: gs.Drawing, program: str, style: dict[str, Any], request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    paint = painter(program, request)
    portrait.save(tmp_path / "strokes.svg", width=256, dots="strokes", **style)
    theirs = paint(tmp_path / "strokes.svg", 1024).astype(float) / 255
    ours = portrait.rasterize(1024) / 255
    assert theirs.shape == ours.shape == (1024, 1024)
    assert abs(theirs.mean() - ours.mean()) < 0.002
    # No dot is missing anywhere: means of 32 x 32 pixels.
    means = [picture.reshape(32, 32, 32, 32).mean(axis=(1, 3)) for picture in (theirs, ours)]
    assert np.abs(means[0] - means[1]).max() < 0.02


def test_strokes_and_marks_do_not_go_together(portrait: gs.Drawing) -> None:
    with pytest.raises(gs.InvalidInputError, match="dots is strokes, but it must be left out when elements is marks"):
        portrait.svg(elements="marks", dots="strokes")


# Compressed ----------------------------------------------------------------------------------------------------------------------


def test_svgz_is_the_svg(portrait: gs.Drawing, tmp_path: Path) -> None:
    for settings in ({}, {"style": "layered", "dots": "strokes", "paper": "#fed"}):
        portrait.save(tmp_path / "drawing.svgz", **settings)  # type: ignore[arg-type]
        packed = (tmp_path / "drawing.svgz").read_bytes()
        assert gzip.decompress(packed).decode() == portrait.svg(**settings)  # type: ignore[arg-type]
        # Neither a name nor a time.
        assert packed[3:8] == bytes(5)
        portrait.save(tmp_path / "again.svgz", **settings)  # type: ignore[arg-type]
        assert (tmp_path / "again.svgz").read_bytes() == packed
    portrait.save(tmp_path / "drawing.svgz")
    assert same(gs.load(tmp_path / "drawing.svgz"), portrait)


def test_a_bomb_is_refused(tmp_path: Path) -> None:
    chunk = gzip.compress(bytes(1 << 24))
    # 1.1 GB of zeros in about a megabyte.
    (tmp_path / "bomb.svgz").write_bytes(chunk * 66)
    with pytest.raises(gs.ImageFileError, match="unpacks to more than 1073741824 bytes"):
        gs.load(tmp_path / "bomb.svgz")
    (tmp_path / "other.svgz").write_bytes(b"<svg/>")
    with pytest.raises(gs.ImageFileError, match="it is no gzip"):
        gs.load(tmp_path / "other.svgz")


# Paper and underlay --------------------------------------------------------------------------------------------------------------

PAPER = "#c86432"


def coloured(path: Path, width: int) -> Any:
    """Paint a file in colour over mid-green, which no paper here has."""
    if path.suffix == ".png":
        return np.asarray(Image.open(path).convert("RGB")).astype(int)
    if path.suffix == ".pdf":
        document = pypdfium2.PdfDocument(path)
        page = document[0]
        image = page.render(scale=(width - 1e-3) / page.get_width(), fill_color=(0, 128, 0, 255)).to_pil()
        return np.asarray(image.convert("RGB")).astype(int)
    png = bytes(resvg_py.svg_to_bytes(svg_string=path.read_text("utf-8"), width=width, background="#008000"))
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)


@pytest.mark.parametrize("suffix", ["svg", "pdf", "png"])
@styles
def test_paper_covers_the_page_in_every_style(suffix: str, style: dict[str, Any], tmp_path: Path) -> None:
    drawing = gs.draw(np.ascontiguousarray(photo("camera", 96, 64)))
    path = tmp_path / f"drawing.{suffix}"
    drawing.save(path, margin=8, paper=PAPER, **style)
    picture = coloured(path, 112)
    assert picture.shape == (80, 112, 3)
    paper, black, white = np.array([200, 100, 50]), np.zeros(3), np.full(3, 255)
    margin = np.ones((80, 112), bool)
    margin[8:-8, 8:-8] = False
    assert np.abs(picture[margin] - paper).max() <= 1
    inner = picture[8:-8, 8:-8]
    ends = {"white": (paper, white), "black,white": (black, white)}.get(style.get("only", ""), (black, paper))
    share = drawing.rasterize()[..., None] / 255
    expected = ends[0] * (1 - share) + ends[1] * share
    assert np.abs(inner - expected).mean() < (1 if suffix == "png" else 4)


def test_unpainted_is_transparent(tmp_path: Path) -> None:
    drawing = gs.draw(np.ascontiguousarray(photo("camera", 96, 64)))
    svg = drawing.svg()
    assert "<rect" not in svg
    assert "style=" not in svg
    drawing.save(tmp_path / "drawing.svg", margin=8)
    assert (coloured(tmp_path / "drawing.svg", 112)[:8] == [0, 128, 0]).all()
    # Layered, white is painted on the canvas alone.
    drawing.save(tmp_path / "drawing.svg", margin=8, style="layered")
    picture = coloured(tmp_path / "drawing.svg", 112)
    assert (picture[:8] == [0, 128, 0]).all()
    inner = picture[8:-8, 8:-8]
    assert (inner.max(axis=2) == inner.min(axis=2)).all()


@pytest.mark.parametrize("value", [0, 255])
@styles
def test_an_empty_canvas_reads_back(value: int, style: dict[str, Any], tmp_path: Path) -> None:
    drawing = gs.draw(np.full((8, 8), value, np.uint8))
    drawing.save(tmp_path / "drawing.svg", **style)
    assert same(gs.load(tmp_path / "drawing.svg"), drawing)


def lighter(paint: Callable[[str, int, int], Any], drawing: gs.Drawing, scale: int) -> tuple[Any, Any]:
    """Return by how much every pixel of both inks is lighter than black alone on white: as it is, and without the underlay."""
    width, height = scale * drawing.width, scale * drawing.height
    document = drawing.svg(only="black,white")
    bare = re.sub(r'<g id="underlay".*?</g>', "", document, flags=re.S)
    assert bare != document
    black, with_underlay, without = (paint(svg, width, height).astype(int) for svg in (drawing.svg(), document, bare))
    return with_underlay - black, without - black


def by_resvg(document: str, width: int, height: int) -> Any:
    """Paint by resvg; the height follows."""
    return readers.svg(document, width)[:height]


@pytest.mark.parametrize("scale", [1, 2, 3])
@pytest.mark.parametrize("program", ["resvg", "Chromium"])
def test_no_hairline_shows_between_the_inks(program: str, scale: int, portrait: gs.Drawing, request: pytest.FixtureRequest) -> None:
    paint = by_resvg if program == "resvg" else request.getfixturevalue("in_browser")
    with_underlay, without = lighter(paint, portrait, scale)
    assert (without > 12).mean() > 0.1
    if program == "resvg":
        assert with_underlay.max() <= 2
    else:
        # In Chromium two shapes that share an edge do not cover a pixel of it by exactly one: there are single pixels, no lines.
        assert (with_underlay > 2).mean() < 0.003
        assert (with_underlay > 12).mean() < 1e-4
    assert abs(with_underlay.mean()) < 0.5


def test_a_paper_of_the_ink_is_refused(portrait: gs.Drawing, tmp_path: Path) -> None:
    for settings, told in (
        ({"paper": "black"}, "paper is black, but it must be another colour than black"),
        ({"paper": "#fff", "only": "white"}, "paper is #fff, but it must be another colour than white"),
        ({"paper": "red"}, 'paper is "red", but it must be "none", or a colour: white, black, #rrggbb or #rgb'),
    ):
        with pytest.raises(gs.InvalidInputError, match=re.escape(told)):
            portrait.save(tmp_path / "out.svg", **settings)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_what_a_person_adds_is_named(tmp_path: Path) -> None:
    svg = gs.draw(np.ascontiguousarray(photo("camera", 96, 64))).svg(elements="marks")
    for added, named in (
        ("<text>x</text>", "the element <text> in line "),
        ('<g id="mine"/>', 'the element <g id="mine"> in line '),
    ):
        (tmp_path / "drawing.svg").write_text(svg.replace("</svg>", f"{added}</svg>"))
        with pytest.raises(gs.ImageFileError, match=re.escape(named)):
            gs.load(tmp_path / "drawing.svg")
