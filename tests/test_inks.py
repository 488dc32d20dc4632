"""Drawings of several inks: what they look like, what they hold, what their files say, and what is refused."""

from __future__ import annotations

import functools
import io
import itertools
import json
import pickle
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest
import resvg_py
import shapely
from PIL import Image
from tests.commands import USAGE, assert_one_sentence, done, native_binary, run
from tests.soundness import AREA_TOLERANCE, check_picture
from tests.support import photo

import graphstipple as gs

INKS, PAPER = "black=#1d1d1b,pink=#ff48b0,blue=#0078bf", "#f4efe2"
KINDS: dict[str, dict[str, Any]] = {
    "solid": {"inks": INKS, "paper": PAPER},
    "overprint": {"inks": "#00aeef,#ec008c,#fff200,#1d1d1b", "overprint": True},
    "levels": {"levels": 5},
    "extracted": {"extract_inks": 6},
    "one": {"inks": "#2a4d69", "paper": PAPER},
    "extracted overprint": {"extract_inks": 3, "overprint": True},
}
on_every_kind = pytest.mark.parametrize("kind", KINDS)
WIDTH, HEIGHT = 192, 144


@functools.cache
def drawn(kind: str, **changes: Any) -> gs.Drawing:
    """Draw a crop of a photo; the tests share it and only read."""
    return gs.draw(photo("astronaut", WIDTH, HEIGHT), options=gs.Options(**KINDS[kind], **changes))


def rgb(colour: str) -> npt.NDArray[np.float64]:
    return np.array(list(bytes.fromhex(colour.removeprefix("#"))), float)


def blurred(picture: npt.NDArray[np.uint8], sigma: float) -> npt.NDArray[np.float64]:
    return cv2.GaussianBlur(picture.astype(float), (0, 0), sigma, borderType=cv2.BORDER_REFLECT)


@on_every_kind
def test_pictures_are_sound(kind: str) -> None:
    check_picture(drawn(kind), WIDTH, HEIGHT)


@on_every_kind
def test_areas_of_all_inks_and_the_paper_add_up_to_the_canvas(kind: str) -> None:
    drawing = drawn(kind)
    canvas = WIDTH * HEIGHT
    areas = {name: drawing.to_shapely(name) for name in [*drawing.inks, drawing.paper[0]]}
    assert all(area.is_valid for area in areas.values())
    together = sum(area.area for area in areas.values())
    if not drawing.overprint:
        assert together == pytest.approx(canvas, abs=AREA_TOLERANCE * canvas)
        for one, other in itertools.combinations(areas.values(), 2):
            assert one.intersection(other).area <= AREA_TOLERANCE * canvas
        return
    # Inks lie over each other, and where none does there is paper.
    laid = shapely.union_all([areas[name] for name in drawing.inks])
    assert together > canvas
    assert laid.area + areas["paper"].area == pytest.approx(canvas, abs=1e-4 * canvas)


@on_every_kind
def test_a_plate_is_what_its_ink_covers(kind: str) -> None:
    drawing = drawn(kind)
    for name, colour in drawing.inks.items():
        plate = drawing.plate(name)
        assert plate.inks == {name: colour} if colour != "#000000" else list(plate.inks) == ["black"]
        assert plate.to_shapely().area == pytest.approx(drawing.to_shapely(name).area, rel=1e-9)
        check_picture(plate, WIDTH, HEIGHT)


def test_a_picture_has_the_colours_of_its_inks_alone() -> None:
    drawing = drawn("solid")
    assert drawing.inks == {"black": "#1d1d1b", "pink": "#ff48b0", "blue": "#0078bf"}
    assert drawing.paper == ("paper", PAPER)
    pixels = drawing.rasterize(8 * WIDTH)
    assert pixels.shape == (8 * HEIGHT, 8 * WIDTH, 3)
    colours, counts = np.unique(pixels.reshape(-1, 3), axis=0, return_counts=True)
    expected = {tuple(rgb(colour)): name for name, colour in [*drawing.inks.items(), drawing.paper]}
    plain = {
        expected[tuple(colour)]: count
        for colour, count in zip(colours.astype(float), counts, strict=True)
        if tuple(colour) in expected
    }
    # The rest is edges.
    assert sum(plain.values()) > 0.75 * pixels[:, :, 0].size
    for name in expected.values():
        share = drawing.to_shapely(name).area / (WIDTH * HEIGHT)
        assert plain[name] / pixels[:, :, 0].size == pytest.approx(share, rel=0.35, abs=0.01)


def test_levels_are_greys_and_two_of_them_are_black_and_white() -> None:
    drawing = drawn("levels")
    assert drawing.inks == {"black": "#000000", "grey-25": "#404040", "grey-50": "#808080", "grey-75": "#bfbfbf"}
    pixels = drawing.rasterize()
    assert (pixels[:, :, :1] == pixels).all()
    two = gs.draw(photo("camera", 96, 96), options=gs.Options(levels=2))
    plain = gs.draw(photo("camera", 96, 96))
    assert two.inks == plain.inks == {"black": "#000000"}
    assert two.paper == plain.paper == ("white", "#ffffff")
    without = [json.loads(it.json()) for it in (two, plain)]
    for it in without:
        it.pop("options", None)
        it.pop("provenance", None)
    assert two.regions[0].area == plain.regions[0].area
    assert (two.rasterize() == plain.rasterize()).all()


@pytest.mark.parametrize("paper", [None, PAPER])
@pytest.mark.parametrize("overprint", [False, True])
def test_an_svg_looks_as_its_raster(paper: str | None, overprint: bool) -> None:
    options = gs.Options(inks="#00aeef,#ec008c,#fff200", paper=paper, overprint=overprint)
    drawing = gs.draw(photo("astronaut", WIDTH, HEIGHT), options=options)
    png = bytes(resvg_py.svg_to_bytes(svg_string=drawing.svg(paper=paper or "white"), width=4 * WIDTH, dpi=96))
    shown = np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(float)
    made = drawing.rasterize(4 * WIDTH).astype(float)
    # Edges are blended otherwise; the rest differs by how a product is rounded.
    assert np.median(np.abs(shown - made)) <= 1
    np.testing.assert_allclose(shown.mean(axis=(0, 1)), made.mean(axis=(0, 1)), atol=4)


def flat(colour: tuple[float, float, float], side: int = 160) -> npt.NDArray[np.uint8]:
    return np.broadcast_to(np.rint(colour).astype(np.uint8), (side, side, 3)).copy()


@pytest.mark.parametrize("shares", [(0.1, 0.2, 0.1), (0.05, 0.05, 0.8), (0.33, 0.33, 0.34), (0.0, 0.5, 0.0)])
def test_a_flat_colour_that_the_inks_can_mix_is_mixed(shares: tuple[float, float, float]) -> None:
    inks = np.array([rgb(colour) for colour in ("#1d1d1b", "#ff48b0", "#0078bf")])
    colour = np.array(shares) @ inks + (1 - sum(shares)) * rgb(PAPER)
    options = gs.Options(inks=INKS, paper=PAPER, sharpen=0, local_contrast=0)
    drawing = gs.draw(flat(tuple(colour)), options=options)
    mean = drawing.rasterize()[16:-16, 16:-16].reshape(-1, 3).mean(axis=0)
    np.testing.assert_allclose(mean, colour, atol=8)


def test_a_colour_out_of_reach_is_the_nearest_that_can_be_mixed() -> None:
    options = gs.Options(inks="#ff0000,#0000ff", paper="white")
    mean = gs.draw(flat((0, 255, 0)), options=options).rasterize().reshape(-1, 3).mean(axis=0)
    # Of red, blue and white nothing is as near to green as these: no error may pile up.
    again = gs.draw(flat((0, 255, 0), 320), options=options).rasterize().reshape(-1, 3).mean(axis=0)
    np.testing.assert_allclose(mean, again, atol=12)
    assert mean[1] > 60


@on_every_kind
def test_the_blurred_picture_follows_the_photo(kind: str) -> None:
    """Against the nearest ink for every pixel: mean distance after a blur of 3 px."""
    picture = photo("astronaut", WIDTH, HEIGHT)
    drawing = drawn(kind)
    made = drawing.rasterize()
    colours = np.array([rgb(colour) for colour in [*drawing.inks.values(), drawing.paper[1]]])
    if drawing.overprint:
        colours = np.unique(made.reshape(-1, 3), axis=0).astype(float)
    nearest = np.linalg.norm(picture[:, :, None].astype(float) - colours, axis=3).argmin(axis=2) if len(colours) < 40 else None
    error = np.linalg.norm(blurred(made, 3) - blurred(picture, 3), axis=2).mean()
    if nearest is not None:
        posterized = colours[nearest]
        assert error < np.linalg.norm(blurred(posterized, 3) - blurred(picture, 3), axis=2).mean()
    # A single ink has no way to follow colours.
    assert error < 60 or len(drawing.inks) == 1


def test_extracted_inks_are_those_of_the_photo_and_the_same_again() -> None:
    picture = np.concatenate([flat(colour, 64) for colour in ((200, 40, 40), (40, 80, 200), (250, 240, 220))], axis=1)
    found = gs.draw(picture, options=gs.Options(extract_inks=3)).inks
    nearest = [
        min(np.abs(rgb(ink) - colour).max() for ink in found.values()) for colour in ((200, 40, 40), (40, 80, 200), (250, 240, 220))
    ]
    assert max(nearest) <= 12
    assert found == gs.draw(picture, options=gs.Options(extract_inks=3, threads=2)).inks


@on_every_kind
def test_the_same_whatever_the_threads_and_in_a_session(kind: str) -> None:
    picture = photo("astronaut", WIDTH, HEIGHT)
    expected = drawn(kind)
    two = gs.draw(picture, options=gs.Options(**KINDS[kind], threads=2))
    session = gs.Session(picture)
    session.draw()
    again = session.draw(gs.Options(**KINDS[kind]))
    unpickled = pickle.loads(pickle.dumps(session)).draw(gs.Options(**KINDS[kind]))
    fresh = pickle.loads(pickle.dumps(gs.Session(picture))).draw(gs.Options(**KINDS[kind]))
    for made in (two, again, unpickled, fresh):
        assert made.rasterize().tobytes() == expected.rasterize().tobytes()
        assert made.regions[0].area == expected.regions[0].area
    assert again.svg() == unpickled.svg() == fresh.svg() == expected.svg()
    # And back: what a drawing in black and white is made of is as it was.
    assert session.draw().svg() == gs.draw(picture).svg()


def test_a_session_with_an_importance_of_a_callable_reads_colour_without_calling_it_again() -> None:
    calls = []

    def importance(luma: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        calls.append(luma.shape)
        return 0.2 + 0.8 * luma

    picture = photo("astronaut", WIDTH, HEIGHT)
    session = gs.Session(picture, importance)
    made = session.draw(gs.Options(extract_inks=4))
    assert len(calls) == 1
    assert made.svg() == gs.draw(picture, importance, gs.Options(extract_inks=4)).svg()


@on_every_kind
@pytest.mark.parametrize("suffix", ["json"])
def test_loading_gives_the_drawing_back(kind: str, suffix: str, tmp_path: Path) -> None:
    drawing = drawn(kind)
    drawing.save(tmp_path / f"a.{suffix}")
    loaded = gs.load(tmp_path / f"a.{suffix}")
    assert (loaded.inks, loaded.paper, loaded.overprint) == (drawing.inks, drawing.paper, drawing.overprint)
    loaded.save(tmp_path / f"b.{suffix}")
    assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()
    assert loaded.svg() == drawing.svg()


@pytest.mark.parametrize("kind", ["solid", "overprint", "extracted"])
@pytest.mark.parametrize("suffix", ["svg", "pdf", "eps", "dxf", "png", "json"])
def test_the_command_line_writes_what_python_writes(kind: str, suffix: str, tmp_path: Path) -> None:
    Image.fromarray(photo("astronaut", WIDTH, HEIGHT)).save(tmp_path / "photo.png")
    flags = [
        word
        for name, value in KINDS[kind].items()
        for word in ([f"--{name.replace('_', '-')}"] + ([] if value is True else [value]))
    ]
    for number, program in enumerate((native_binary(), Path(sys.executable).parent / "graphstipple")):
        done(program, "photo.png", "-o", f"{number}.{suffix}", *flags, "--quiet", cwd=tmp_path)
    gs.draw(tmp_path / "photo.png", options=gs.Options(**KINDS[kind])).save(
        tmp_path / f"2.{suffix}", paper=KINDS[kind].get("paper") if suffix in {"svg", "pdf", "eps", "png"} else None
    )
    first, second, third = ((tmp_path / f"{number}.{suffix}").read_bytes() for number in range(3))
    assert first == second
    assert first == third


def test_only_writes_the_inks_that_are_named(tmp_path: Path) -> None:
    drawing = drawn("solid")
    svg = drawing.svg(only="pink")
    assert 'id="pink-regions"' in svg
    assert 'id="blue-' not in svg
    assert drawing.svg(only=["blue", "pink"]) == drawing.svg(only="pink,blue")
    assert drawing.svg(only="black,pink,blue") == drawing.svg()
    with pytest.raises(
        gs.InvalidInputError,
        match=r"^only is mauve, but it must be inks of the drawing or its paper, with .* them: black, pink, blue, paper$",
    ):
        drawing.save(tmp_path / "none.svg", only="mauve")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"inks": "#000,#000000"}, "inks of different names and colours"),
        ({"inks": "a=#111,a=#222"}, "inks of different names and colours"),
        ({"inks": "#ffffff"}, "nothing of the drawing would be seen"),
        ({"inks": PAPER, "paper": PAPER}, "nothing of the drawing would be seen"),
        ({"inks": ",".join(f"#0000{k:02x}" for k in range(16))}, "16 inks, but it must be 1 to 15 inks"),
        ({"inks": ",".join(f"#0000{k:02x}" for k in range(7)), "overprint": True}, "1 to 6 inks with overprint"),
        ({"inks": "Pink=#f0f"}, "a name"),
        ({"inks": "../x=#f0f"}, "a name"),
        ({"inks": ""}, "colours with commas between them"),
        ({"inks": "paper=#f0f"}, "colours with commas between them"),
        ({"levels": 1}, "between 2 and 16"),
        ({"levels": 17}, "between 2 and 16"),
        ({"extract_inks": 0}, "between 1 and 15"),
        ({"extract_inks": 7, "overprint": True}, "at most 6"),
        ({"levels": 3, "inks": "#f00"}, "left out"),
        ({"overprint": True}, "left out"),
        ({"paper": "cream"}, "#rrggbb"),
    ],
    ids=str,
)
def test_bad_inks_are_refused_in_one_sentence(options: dict[str, Any], sentence: str, tmp_path: Path) -> None:
    with pytest.raises(gs.InvalidInputError) as error:
        gs.draw(flat((9, 99, 200), 16), options=gs.Options(**options))
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)
    Image.fromarray(flat((9, 99, 200), 16)).save(tmp_path / "photo.png")
    flags = [
        word
        for name, value in options.items()
        for word in ([f"--{name.replace('_', '-')}"] + ([] if value is True else [str(value)]))
    ]
    assert_one_sentence(run(native_binary(), "photo.png", "-o", "a.svg", *flags, cwd=tmp_path), USAGE)
    assert [path.name for path in tmp_path.iterdir()] == ["photo.png"]


def test_a_drawing_may_be_smaller_than_a_file_allows() -> None:
    picture = photo("astronaut", WIDTH, HEIGHT)
    made = gs.draw(picture, options=gs.Options(**KINDS["solid"]), max_bytes="60kB")
    assert len(made.svg().encode()) <= 60_000
    assert list(made.inks) == ["black", "pink", "blue"]


@pytest.mark.parametrize("make", [lambda it: Image.fromarray(it).convert("L"), lambda it: it[:, :, 0]], ids=["pil", "array"])
def test_a_grey_photo_is_drawn_of_its_greys(make: Callable[[npt.NDArray[np.uint8]], Any]) -> None:
    made = gs.draw(make(photo("astronaut", 96, 96)), options=gs.Options(inks="#777,#000"))
    assert set(made.inks) == {"777777", "000000"}
    assert made.to_shapely("000000").area > 0
