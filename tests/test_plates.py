"""Plates: a file for each ink, separations, traps and registration marks."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from PIL import Image
from tests import readers
from tests.commands import USAGE, assert_one_sentence, done, native_binary, run
from tests.support import photo

import graphstipple as gs

INKS = "black,pink=#ff48b0,blue=#0078bf"
NAMES = ["black", "pink", "blue"]
SEPARATIONS = {"black": "Black", "pink": "pink", "blue": "blue"}
"""A press has a black of its own."""

EMPTY = ("Cyan", "Magenta", "Yellow")
WIDTH = 60
"""Of the drawings, in mm."""

FINE = 1200
"""Dots per inch of separations."""

NEAR = 0.004
"""How far the area of a plate may be from that of the drawing, as a part of the page: what ghostscript adds along edges."""

needs_ghostscript = pytest.mark.skipif(readers.GHOSTSCRIPT is None, reason="ghostscript is not installed")


def drawn(**options: Any) -> gs.Drawing:
    return gs.draw(photo("astronaut", 96, 96), options=gs.Options(nodes=1500, **options))


@pytest.fixture(scope="module")
def solid() -> gs.Drawing:
    return drawn(inks=INKS)


@pytest.fixture(scope="module")
def overprint() -> gs.Drawing:
    return drawn(inks=INKS, overprint=True)


def share(drawing: gs.Drawing, ink: str) -> float:
    """Which part of the canvas an ink covers."""
    return float(drawing.to_shapely(ink).area) / (drawing.width * drawing.height)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


# A file for each ink ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", ["svg", "svgz", "pdf", "eps", "dxf", "png", "json"])
def test_every_ink_has_a_file_in_every_format(solid, overprint, tmp_path, suffix):
    for drawing in (solid, overprint):
        drawing.save(tmp_path / ("{ink}." + suffix), width=f"{WIDTH}mm")
        assert names(tmp_path) == sorted(f"{name}.{suffix}" for name in NAMES)
        for name in NAMES:
            path = tmp_path / f"{name}.{suffix}"
            if suffix == "json":
                plate = gs.load(path)
                assert list(plate.inks) == [name]
                assert share(plate, name) == pytest.approx(share(drawing, name), abs=1e-9)
            else:
                alone = tmp_path.parent / f"alone.{suffix}"
                drawing.save(alone, width=f"{WIDTH}mm", only=name, paper="none")
                assert path.read_bytes() == alone.read_bytes()


def test_plates_have_no_paper_and_are_those_that_are_asked_for(tmp_path):
    drawing = drawn(inks=INKS, paper="#f4efe2")
    drawing.save(tmp_path / "plate-{ink}.svg", only="blue,pink")
    assert names(tmp_path) == ["plate-blue.svg", "plate-pink.svg"]
    assert 'id="paper"' in drawing.svg()
    assert 'id="paper"' not in (tmp_path / "plate-blue.svg").read_text()


def test_black_and_white_have_plates_too(tmp_path):
    drawing = drawn()
    drawing.save(tmp_path / "{ink}.svg", only="black,white")
    assert (tmp_path / "black.svg").read_text() == drawing.svg()
    assert (tmp_path / "white.svg").read_text() == drawing.svg(only="white")
    drawing.save(tmp_path / "{ink}.pdf")
    assert names(tmp_path) == ["black.pdf", "black.svg", "white.svg"]


def test_a_film_is_black_and_white_pixels(solid, overprint, tmp_path):
    for drawing in (solid, overprint):
        drawing.save(tmp_path / "{ink}.png", width=f"{WIDTH}mm", dpi=600, one_bit=True)
        for name in NAMES:
            film = Image.open(tmp_path / f"{name}.png")
            assert film.mode == "1"
            assert 1 - np.asarray(film).mean() == pytest.approx(share(drawing, name), abs=0.002)
    with pytest.raises(gs.InvalidInputError, match="one_bit is True, but it must be left out where a file has several inks"):
        solid.save(tmp_path / "all.png", one_bit=True)


def test_either_all_plates_are_written_or_none(solid, tmp_path):
    (tmp_path / "pink.svg").mkdir()
    with pytest.raises(gs.ImageFileError, match="this is a folder"):
        solid.save(tmp_path / "{ink}.svg")
    assert names(tmp_path) == ["pink.svg"]
    for path, told in [
        (tmp_path / "{ink}" / "a.svg", "may stand in the name of the file, but not in that of a folder"),
        (tmp_path / "{ink}.gif", "suffix must be"),
    ]:
        with pytest.raises(gs.InvalidInputError, match=told):
            solid.save(path)
    with pytest.raises(gs.InvalidInputError, match="style is layered, but it must be flat where each ink has a file"):
        solid.save(tmp_path / "{ink}.svg", style="layered")
    assert names(tmp_path) == ["pink.svg"]


# On the command line ----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def picture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("photo") / "photo.png"
    Image.fromarray(photo("astronaut", 96, 96)).save(path)
    return path


def test_the_command_writes_the_same_plates(solid, picture, tmp_path):
    # The map of an array and that of its file are the same.
    done(
        native_binary(),
        picture,
        "-o",
        tmp_path / "{ink}.pdf",
        "--nodes",
        1500,
        "--inks",
        INKS,
        "--trap",
        "0.3mm",
        "--width",
        "60mm",
    )
    assert names(tmp_path) == ["black.pdf", "blue.pdf", "pink.pdf"]
    ours = tmp_path / "ours"
    ours.mkdir()
    solid.save(ours / "{ink}.pdf", width="60mm", trap="0.3mm")
    for name in names(ours):
        assert (ours / name).read_bytes() == (tmp_path / name).read_bytes()


def test_inks_of_the_photo_name_its_plates(picture, tmp_path):
    done(native_binary(), picture, "-o", tmp_path / "{ink}.svg", "--nodes", 1500, "--extract-inks", 3)
    assert len(names(tmp_path)) == 3
    assert all(re.fullmatch(r"([0-9a-f]{6}|black)\.svg", name) for name in names(tmp_path))


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ("-o {ink}/a.svg", "may stand in the name of the file, but not in that of a folder"),
        ("-o {ink}.svg --preview {ink}.png", "{ink}.png: {ink} is for the drawing's own file: there is one preview for all inks"),
        ("-o {ink}.svg --inks black,pink=#ff48b0 --preview pink.svg", "the suffix of a preview must be .png"),
        ("-o {ink}.png --inks black,pink=#ff48b0 --preview pink.png", "pink.png: the preview must be another file than the output"),
        ("-o {ink}.svg --pen 0.3mm --width 60mm", "{ink} must be left out with --pen: a plot has a layer for the pen of each ink"),
        ("-o {ink}.svg --style layered", "--style is layered, but it must be flat where each ink has a file of its own"),
        ("-o {ink}.svg --trap 0.2mm", "--trap is 0.2mm, but it must be left out for a drawing of one ink: no two inks touch in it"),
        (
            "-o a.svg --trap 0.2mm --inks black,pink=#ff48b0 --overprint",
            "--trap is 0.2mm, but it must be left out for inks over each other",
        ),
        ("-o a.svg --trap 0mm --levels 4", "--trap is 0mm, but it must be above 0 and at most 5mm"),
        ("-o a.svg --trap 6mm --levels 4", "--trap is 6mm, but it must be above 0 and at most 5mm"),
        ("-o a.svg --trap 2 --levels 4", "--trap is 2, but it must have a unit: 2mm, or 2px for pixels of 1/96 inch"),
        ("-o a.svg --trap wide --levels 4", '--trap is "wide", but it must be a number, at least 0'),
        ("-o a.svg --trap 1mm --levels 4 --style layered", "--trap is 1mm, but it must be left out when style is layered"),
        ("-o a.svg --pen 0.3mm --width 60mm --registration-marks", "--registration-marks must be left out with --pen"),
        ("-o a.svg --width 90mm --page 100x100mm --registration-marks", "the page 100x100mm has room for 80 x 80 mm"),
        ("-o {ink}.png --inks black,photo=#ff48b0", "photo.png: the drawing would replace an image that it is made from"),
    ],
)
def test_what_is_wrong_is_one_sentence_and_nothing_is_written(picture, tmp_path, arguments, told):
    (tmp_path / "photo.png").write_bytes(picture.read_bytes())
    result = run(native_binary(), "photo.png", *arguments.split(), cwd=tmp_path)
    assert_one_sentence(result, USAGE if "room" not in told else result.returncode)
    assert told in result.stderr.decode()
    assert names(tmp_path) == ["photo.png"]


def test_extracted_inks_take_no_files_place(picture, tmp_path):
    done(native_binary(), picture, "-o", tmp_path / "{ink}.png", "--nodes", 1500, "--extract-inks", 3)
    inks = names(tmp_path)
    at = tmp_path / "at"
    at.mkdir()
    preview = at / inks[0]
    result = run(native_binary(), picture, "-o", at / "{ink}.png", "--nodes", 1500, "--extract-inks", 3, "--preview", preview)
    assert_one_sentence(result, USAGE)
    assert "the preview must be another file than the output" in result.stderr.decode()
    assert names(at) == []


def test_a_batch_has_no_place_for_an_ink(picture, tmp_path):
    with pytest.raises(gs.InvalidInputError, match="the output of a batch is a folder"):
        gs.batch([picture], tmp_path / "{ink}")
    assert names(tmp_path) == []


# Separations ------------------------------------------------------------------------------------------------------------------


@needs_ghostscript
@pytest.mark.parametrize("suffix", ["pdf", "eps"])
@pytest.mark.parametrize("way", ["solid", "overprint"])
def test_separations_have_the_areas_of_the_drawing(request, tmp_path, way, suffix):
    drawing: gs.Drawing = request.getfixturevalue(way)
    path = tmp_path / f"all.{suffix}"
    drawing.save(path, width=f"{WIDTH}mm")
    plates = readers.separations(path, FINE)
    assert set(plates) == {*SEPARATIONS.values(), *EMPTY}
    for name in NAMES:
        assert plates[SEPARATIONS[name]] == pytest.approx(share(drawing, name), abs=NEAR), name
    # What is on the page is on the plates of its inks and on no other.
    assert all(plates[name] == 0 for name in EMPTY)
    drawing.save(tmp_path / f"{{ink}}.{suffix}", width=f"{WIDTH}mm")
    for name in NAMES:
        alone = readers.separations(tmp_path / f"{name}.{suffix}", FINE)
        assert set(alone) == {SEPARATIONS[name], *EMPTY, "Black"}
        assert alone[SEPARATIONS[name]] == pytest.approx(share(drawing, name), abs=NEAR), name


@needs_ghostscript
def test_a_paper_is_on_no_plate_of_an_ink(tmp_path):
    drawing = drawn(inks=INKS, paper="#f4efe2", overprint=True)
    drawing.save(tmp_path / "all.pdf", width=f"{WIDTH}mm")
    plates = readers.separations(tmp_path / "all.pdf", FINE)
    for name in NAMES[1:]:
        assert plates[name] == pytest.approx(share(drawing, name), abs=NEAR), name


@pytest.mark.parametrize("paper", [None, "#f4efe2"])
def test_viewers_show_the_mixture(tmp_path, paper):
    drawing = drawn(inks=INKS, overprint=True, **({} if paper is None else {"paper": paper}))
    drawing.save(tmp_path / "all.pdf")
    shown = readers.pdf(tmp_path / "all.pdf", 4 * drawing.width, "RGB")
    ours = drawing.rasterize(4 * drawing.width)
    flat = np.abs(shown.astype(int) - ours).max(axis=2)
    # Multiplied in other values than light, mixtures of two differ a little in their darkest channels.
    assert np.median(flat) <= 1
    assert np.mean(flat > 40) < 0.1


def test_black_and_white_have_no_separations(tmp_path):
    drawn().save(tmp_path / "a.pdf")
    drawn().save(tmp_path / "a.eps")
    assert b"Separation" not in (tmp_path / "a.pdf").read_bytes() + (tmp_path / "a.eps").read_bytes()
    assert b"%%LanguageLevel: 1\n" in (tmp_path / "a.eps").read_bytes()


# Traps ------------------------------------------------------------------------------------------------------------------------

TRAP = 0.4
LIGHTEST_FIRST = ["pink", "blue", "black"]


def trapped(drawing: gs.Drawing, ink: str, mm: float = TRAP) -> shapely.Geometry:
    """What an ink covers of darker ones, in pixels of the canvas, by shapely."""
    darker = LIGHTEST_FIRST[LIGHTEST_FIRST.index(ink) + 1 :]
    if not darker:
        return shapely.Polygon()
    others = shapely.union_all([shapely.make_valid(drawing.to_shapely(other)) for other in darker])
    shared = shapely.make_valid(drawing.to_shapely(ink)).boundary.intersection(others.boundary.buffer(1e-6))
    return shared.buffer(mm / WIDTH * drawing.width).intersection(others)


@needs_ghostscript
@pytest.mark.parametrize("suffix", ["pdf", "eps"])
def test_trapped_plates_are_larger_by_the_trap(solid, tmp_path, suffix):
    solid.save(tmp_path / f"all.{suffix}", width=f"{WIDTH}mm", trap=f"{TRAP}mm")
    solid.save(tmp_path / f"{{ink}}.{suffix}", width=f"{WIDTH}mm", trap=f"{TRAP}mm")
    together = readers.separations(tmp_path / f"all.{suffix}", FINE)
    canvas = solid.width * solid.height
    for name in NAMES:
        expected = share(solid, name) + trapped(solid, name).area / canvas
        alone = readers.separations(tmp_path / f"{name}.{suffix}", FINE)
        assert together[SEPARATIONS[name]] == pytest.approx(expected, abs=NEAR), name
        assert alone[SEPARATIONS[name]] == pytest.approx(expected, abs=NEAR), name
    assert trapped(solid, "pink").area > 0.01 * canvas


def test_trapped_plates_hold_the_plates_and_grow_in_darker_inks_alone(solid, tmp_path):
    pixels = {"width": f"{WIDTH}mm", "dpi": 1200, "one_bit": True}
    solid.save(tmp_path / "plain-{ink}.png", **pixels)
    solid.save(tmp_path / "trap-{ink}.png", trap=f"{TRAP}mm", **pixels)
    covered = {path.stem: ~np.asarray(Image.open(path)) for path in tmp_path.iterdir()}
    for place, name in enumerate(LIGHTEST_FIRST):
        plain, trap = covered[f"plain-{name}"], covered[f"trap-{name}"]
        assert not (plain & ~trap).any()
        darker = [covered[f"plain-{other}"] for other in LIGHTEST_FIRST[place + 1 :]]
        beyond = trap & ~plain
        allowed = np.any(darker, axis=0) if darker else np.zeros_like(plain)
        # A pixel on an edge belongs to either side.
        assert np.count_nonzero(beyond & ~allowed) <= 5e-4 * plain.size
        assert beyond.mean() == pytest.approx(trapped(solid, name).area / (solid.width * solid.height), abs=0.002)
    assert np.array_equal(covered["plain-black"], covered["trap-black"])


def test_a_trapped_picture_is_the_same_picture(solid, tmp_path):
    solid.save(tmp_path / "plain.png", width="400px")
    solid.save(tmp_path / "trap.png", width="400px", trap="2px")
    assert (tmp_path / "plain.png").read_bytes() == (tmp_path / "trap.png").read_bytes()
    # Vector files put the lightest inks lowest.
    svg = solid.svg(trap=2)
    ids = re.findall(r'<g id="([a-z-]+)"', svg)
    assert [name.split("-")[0] for name in ids] == sorted((name.split("-")[0] for name in ids), key=LIGHTEST_FIRST.index)
    assert {"pink-trap", "blue-trap"} <= set(ids)
    assert "black-trap" not in ids
    assert np.abs(readers.svg(svg, 960).astype(int) - readers.svg(solid.svg(), 960)).mean() < 1


# Registration marks -----------------------------------------------------------------------------------------------------------


def marks_of(grey: NDArray[np.uint8], width: int) -> NDArray[np.bool_]:
    """What is dark in the margins of a picture whose drawing is so wide."""
    # Edges of the drawing may shine into the next pixels.
    across = (grey.shape[1] - width) // 2 - 2
    dark = grey < 200
    dark[across:-across, across:-across] = False
    return dark


def test_every_plate_has_its_marks_at_the_same_place(solid, tmp_path):
    solid.save(tmp_path / "{ink}.png", width=f"{WIDTH}mm", dpi=300, registration_marks=True, one_bit=True)
    width = round(WIDTH / 25.4 * 300)
    films = [readers.png(tmp_path / f"{name}.png") for name in NAMES]
    assert {film.shape for film in films} == {(width + 2 * 118, width + 2 * 118)}
    first, *others = (marks_of(film, width) for film in films)
    assert all(np.array_equal(first, other) for other in others)
    # Four circles with a cross each, of lines of 0.2 mm.
    one = 2 * np.pi * 2.5 * 0.2 + 2 * 8 * 0.2 - 5 * 0.2**2
    assert first.sum() / (300 / 25.4) ** 2 == pytest.approx(4 * one, rel=0.15)
    for turned in (first[::-1], first[:, ::-1]):
        assert np.count_nonzero(first != turned) < 0.1 * first.sum()


@pytest.mark.parametrize("margin", ["0", "25mm"])
def test_all_formats_have_the_same_marks(solid, tmp_path, margin):
    # resvg takes an SVG in px.
    solid.save(tmp_path / "a.svg", width=WIDTH / 25.4 * 96, margin=margin, registration_marks=True)
    solid.save(tmp_path / "a.pdf", width=f"{WIDTH}mm", margin=margin, registration_marks=True)
    page = WIDTH + 2 * max(10, float(margin.removesuffix("mm")))
    pixels = 10 * round(page)
    shown = [readers.svg((tmp_path / "a.svg").read_text(), pixels), readers.pdf(tmp_path / "a.pdf", pixels)]
    found = [marks_of(grey, 10 * WIDTH) for grey in shown]
    assert readers.pdf_size(tmp_path / "a.pdf")[0] == pytest.approx(page / 25.4 * 72, abs=1e-3)
    # Lines of 2 pixels may be one more in another program.
    assert np.mean(found[0] != found[1]) < 5e-3
    both = found[0] & found[1]
    assert both.sum() > 0.7 * found[0].sum()
    assert found[0].mean() > 1e-3
    middle = pixels // 2
    # The mark of the left side is 5 mm from the drawing.
    columns = np.flatnonzero(found[0][middle - 60 : middle + 60, :middle].any(axis=0))
    assert columns.mean() == pytest.approx((pixels - 10 * WIDTH) / 2 - 50, abs=3)


@needs_ghostscript
def test_marks_are_on_all_separations(solid, tmp_path):
    solid.save(tmp_path / "a.pdf", width=f"{WIDTH}mm", registration_marks=True)
    plates = readers.separations(tmp_path / "a.pdf", 600)
    mark = plates["Cyan"]
    assert mark > 0
    assert {round(plates[name], 6) for name in ("Magenta", "Yellow")} == {round(mark, 6)}
    bare = tmp_path / "bare.pdf"
    solid.save(bare, width=f"{WIDTH}mm", margin="10mm")
    for name, area in readers.separations(bare, 600).items():
        assert plates[name] - area == pytest.approx(mark, abs=1e-5), name


def test_a_black_and_white_file_with_marks_is_read_back(tmp_path):
    drawing = drawn()
    drawing.save(tmp_path / "a.svg", registration_marks=True)
    assert 'id="registration-marks"' in (tmp_path / "a.svg").read_text()
    assert gs.load(tmp_path / "a.svg").json() == drawing.json()


def test_marks_show_on_a_paper_of_their_colour(tmp_path):
    drawing = drawn()
    drawing.save(tmp_path / "a.png", only="white", paper="black", registration_marks=True, width="300px")
    page = readers.png(tmp_path / "a.png")
    assert page[:30].max() > 200
    assert page[0].max() == 0
