"""The drawing as data: sound at every tolerance, with fewer points that stay in place, and the same after saving and loading."""

from __future__ import annotations

import functools
import itertools
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from tests.soundness import AREA_TOLERANCE, check_picture, noise, polygons
from tests.support import on_every_photo, options_with, photo

import graphstipple as gs
from graphstipple import stages

# Random pictures of a few pixels often come out blank, which is told and is not what these tests are about.
pytestmark = pytest.mark.filterwarnings("ignore:the whole drawing is:graphstipple.GraphStippleWarning")

TOLERANCES = (0.0, 0.1, 0.25, 0.5, 1.0)
on_every_tolerance = pytest.mark.parametrize("tolerance", TOLERANCES)
on_any_tolerance = st.sampled_from(TOLERANCES)
twice_as_many = settings(max_examples=2 * settings.default.max_examples)

COMPARED_AREA = 20.0
"""Regions above this area in px^2 keep it within `KEPT_AREA` of it."""

KEPT_AREA = 0.02

MOVED = 0.6
"""How far, in pixels, a stipple may be from where it is at another tolerance: one at the frame has moved in, more or less."""


@functools.cache
def drawn(name: str, tolerance: float = 0.5, width: int | None = 256, height: int | None = 192) -> gs.Drawing:
    """Draw a crop of a photo, or all of it; the tests share it and only read."""
    return gs.draw(photo(name, width, height), options=gs.Options(tolerance=tolerance))


def check_same_marks(simple: gs.Drawing | stages.Outline, exact: gs.Drawing | stages.Outline) -> None:
    """Check that fewer points draw the same regions, of the same areas, and the same stipples, in whatever order."""
    # Stipples lie on a grid that is as fine as the tolerance needs.
    assert len(simple.stipples) == len(exact.stipples)
    if len(exact.stipples):
        simple_centres, exact_centres = (np.stack([dots["x"], dots["y"]], axis=1) for dots in (simple.stipples, exact.stipples))
        distance, match = cKDTree(simple_centres).query(exact_centres)
        assert len(set(match.tolist())) == len(match)
        assert distance.max() < MOVED
        np.testing.assert_array_equal(simple.stipples["ink"][match], exact.stipples["ink"])
        assert np.abs(simple.stipples["radius"][match] - exact.stipples["radius"]).max() < MOVED

    simple_inks, exact_inks = (np.array([region.ink for region in picture.regions]) for picture in (simple, exact))
    np.testing.assert_array_equal(np.bincount(simple_inks, minlength=2), np.bincount(exact_inks, minlength=2))
    shapes, references = np.array(polygons(simple)), polygons(exact)
    tree = shapely.STRtree(shapes)
    for reference, region in zip(references, exact.regions, strict=True):
        if reference.area > COMPARED_AREA:
            near = tree.query(reference)
            shared = shapely.area(shapely.intersection(shapes[near], reference))
            found = near[np.argmax(shared)]
            assert shared.max() > 0.5 * reference.area
            assert simple_inks[found] == region.ink
            assert len(simple.regions[found].holes) == len(region.holes)
            assert shapes[found].area == pytest.approx(reference.area, rel=KEPT_AREA)


# Sound geometry ------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["astronaut", "coffee"])
@pytest.mark.parametrize("tolerance", [0.25, 1.0])
def test_photos_are_sound_at_small_and_large_tolerances(name: str, tolerance: float) -> None:
    drawing = drawn(name, tolerance)
    check_picture(drawing, drawing.width, drawing.height)
    check_same_marks(drawing, drawn(name, 0.0))


SCATTERED: dict[str, Any] = {
    "seed": st.integers(0, 2**32 - 1),
    "n": st.integers(3, 300),
    "width": st.integers(1, 60),
    "height": st.integers(1, 60),
    "share": st.floats(0.0, 1.0),
}


def scattered(
    seed: int, n: int, width: int, height: int, share: float
) -> tuple[np.random.Generator, NDArray[np.float64], NDArray[np.uint8]]:
    """Return sites anywhere on a canvas, labels of which such a share is 1, and the generator that goes on."""
    random = np.random.default_rng(seed)
    sites = 0.01 + random.uniform(0, 1, (n, 2)) * (np.array([width, height]) - 0.02)
    return random, sites, (random.random(n) < share).astype(np.uint8)


@given(
    **SCATTERED,
    scale=st.floats(0.1, 4.0),
    tolerance=on_any_tolerance,
)
@twice_as_many
def test_any_labels_are_sound_at_every_tolerance(  # noqa: PLR0917
    tolerance: float, seed: int, n: int, width: int, height: int, share: float, scale: float
) -> None:
    _, sites, labels = scattered(seed, n, width, height, share)
    exact, simple = (
        stages.outline(sites, labels, width, height, stipple_scale=scale, tolerance=value) for value in (0.0, tolerance)
    )
    check_picture(simple, width, height)
    check_same_marks(simple, exact)


@given(
    seed=st.integers(0, 2**32 - 1),
    width=st.integers(1, 80),
    height=st.integers(1, 80),
    density=st.floats(0.05, 2.0),
    tolerance=on_any_tolerance,
)
@twice_as_many
def test_random_images_are_sound_at_every_tolerance(tolerance: float, seed: int, width: int, height: int, density: float) -> None:
    image = noise(seed, width, height)
    exact, simple = (gs.draw(image, options=options_with(density=density, tolerance=value)) for value in (0.0, tolerance))
    check_picture(simple, width, height)
    check_same_marks(simple, exact)
    assert simple.stats["coordinates"] <= exact.stats["coordinates"]


def test_irregular_dots_are_regions_as_large_as_round_ones() -> None:
    image = photo("coffee", 128, 96)
    round_dots, irregular, other = (
        gs.draw(image, options=gs.Options(**options)) for options in ({}, {"irregularity": 1.0}, {"irregularity": 1.0, "seed": 1})
    )
    check_picture(irregular, irregular.width, irregular.height)
    assert irregular.stats["stipples"] == 0
    assert irregular.stats["regions"] == round_dots.stats["regions"] + round_dots.stats["stipples"]
    assert irregular.stats["vertices"] == round_dots.stats["vertices"]
    # Painted, they hold the same ink.
    assert irregular.rasterize(512).mean() == pytest.approx(round_dots.rasterize(512).mean(), abs=0.1)
    assert irregular.rasterize().tobytes() != other.rasterize().tobytes()
    # A least dot does not act on them.
    assert irregular.with_min_dot(3.0).stats["regions"] == irregular.stats["regions"]


# Fewer points --------------------------------------------------------------------------------------------------------------------


@on_every_photo
@pytest.mark.parametrize(("tolerance", "points", "pairs", "difference"), [(0.25, 0.52, 0.6, 4), (0.5, 0.42, 0.5, 7)])
def test_a_tolerance_saves_most_points_and_hardly_shows(
    name: str, tolerance: float, points: float, pairs: float, difference: float
) -> None:
    drawing, exact = drawn(name, tolerance, None, None), drawn(name, 0.0, None, None)
    stats = drawing.stats
    assert stats["vertices"] == exact.stats["vertices"]
    # A dot is one point either way.
    assert stats["anchors"] - stats["stipples"] <= points * (stats["vertices"] - stats["stipples"])
    assert stats["coordinates"] - stats["stipples"] <= pairs * (stats["vertices"] - stats["stipples"])
    assert np.abs(drawing.rasterize().astype(float) - exact.rasterize()).mean() < difference


@pytest.mark.parametrize("name", ["camera", "rocket"])
def test_more_tolerance_means_fewer_points(name: str) -> None:
    coordinates = [drawn(name, tolerance).stats["coordinates"] for tolerance in TOLERANCES]
    assert coordinates == sorted(coordinates, reverse=True)
    assert coordinates[-1] < 0.7 * coordinates[0]


# shapely -------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["camera", "rocket"])
def test_to_shapely_divides_the_canvas(name: str) -> None:
    drawing = drawn(name)
    black, white = drawing.to_shapely(), drawing.to_shapely("white")
    canvas = drawing.width * drawing.height
    for ink, shape in enumerate((black, white)):
        assert shape.geom_type == "MultiPolygon"
        assert shape.is_valid, shapely.is_valid_reason(shape)
        regions = [region for region in drawing.regions if region.ink == ink]
        stipples = drawing.stipples[drawing.stipples["ink"] == ink]
        assert len(shape.geoms) == len(regions) + len(stipples)
        areas = [polygon.area for polygon in shape.geoms]
        assert areas[: len(regions)] == pytest.approx([region.area for region in regions])
        centres = shapely.points(stipples["x"], stipples["y"])
        assert shapely.contains(np.array(shape.geoms[len(regions) :]), centres).all()
    assert black.area + white.area == pytest.approx(canvas, rel=AREA_TOLERANCE)
    assert shapely.intersection(black, white).area <= AREA_TOLERANCE * canvas


def test_to_shapely_without_marks_of_an_ink() -> None:
    drawing = gs.draw(np.zeros((20, 30), np.uint8))
    assert drawing.to_shapely("white").is_empty
    assert drawing.to_shapely("black").equals(shapely.MultiPolygon([shapely.box(0, 0, 30, 20)]))
    with pytest.raises(gs.InvalidInputError, match='ink is \'both\', but it must be "black" or "white"'):
        drawing.to_shapely("both")  # type: ignore[arg-type]


def test_to_shapely_without_shapely_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    # None is what Python takes for a module that is not there.
    monkeypatch.setitem(sys.modules, "shapely", None)
    with pytest.raises(gs.MissingPackageError, match="pip install shapely") as missing:
        drawn("camera").to_shapely()
    assert isinstance(missing.value, ImportError)


# Saving and loading --------------------------------------------------------------------------------------------------------------

FILES: list[tuple[str, dict[str, Any]]] = [
    ("json", {}),
    ("svg", {}),
    ("svg", {"style": "layered"}),
    ("svg", {"only": "white"}),
    ("svg", {"only": "black,white"}),
    ("svg", {"width": "200mm"}),
    ("svg", {"page": "A4", "margin": "10mm", "style": "layered"}),
]
files = pytest.mark.parametrize(("suffix", "how"), FILES, ids=[f"{suffix} {how}" for suffix, how in FILES])


def check_same_drawing(loaded: gs.Drawing, drawing: gs.Drawing) -> None:
    assert (loaded.width, loaded.height) == (drawing.width, drawing.height)
    assert loaded.version == drawing.version == gs.__version__
    # Threads are not part of a drawing.
    assert loaded.options == drawing.options.replace(threads=None)
    np.testing.assert_array_equal(loaded.stipples, drawing.stipples)
    assert len(loaded.regions) == len(drawing.regions)
    for one, other in zip(loaded.regions, drawing.regions, strict=True):
        assert (one.ink, one.area) == (other.ink, other.area)
        np.testing.assert_array_equal(one.exterior, other.exterior)
        assert len(one.holes) == len(other.holes)
        for hole, other_hole in zip(one.holes, other.holes, strict=True):
            np.testing.assert_array_equal(hole, other_hole)
    hows: list[dict[str, Any]] = [{}, {"only": ",".join((*drawing.inks, drawing.paper[0]))}, {"style": "layered"}]
    # Inks over each other are flat.
    for how in hows[: 2 if drawing.options.overprint else 3]:
        assert loaded.svg(**how) == drawing.svg(**how)
    assert loaded.json() == drawing.json()
    np.testing.assert_array_equal(loaded.rasterize(), drawing.rasterize())
    for name in ("width", "height", "stipples", "regions", "anchors", "coordinates"):
        assert loaded.stats[name] == drawing.stats[name]


@files
@pytest.mark.parametrize(("name", "tolerance"), [("camera", 0.5), ("coffee", 0.0)])
def test_photos_survive_a_file(name: str, tolerance: float, suffix: str, how: dict[str, Any], tmp_path: Path) -> None:
    drawing = drawn(name, tolerance)
    drawing.save(tmp_path / f"drawing.{suffix}", **how)
    check_same_drawing(gs.load(tmp_path / f"drawing.{suffix}"), drawing)


@files
def test_irregular_dots_survive_a_file(suffix: str, how: dict[str, Any], tmp_path: Path) -> None:
    drawing = gs.draw(photo("coffee", 128, 96), options=gs.Options(irregularity=1.0, seed=3, stipple_max=1.5))
    assert not len(drawing.stipples)
    drawing.save(tmp_path / f"drawing.{suffix}", **how)
    check_same_drawing(gs.load(tmp_path / f"drawing.{suffix}"), drawing)


EDGES = pytest.mark.parametrize("edge", ["smooth", "inked", "torn"])


@EDGES
@pytest.mark.parametrize("wobble", [0.2, 1.0])
def test_edges_drawn_by_hand_are_sound_and_keep_the_tone(edge: str, wobble: float) -> None:
    image = photo("astronaut", 200, 160)
    plain, wobbly, again, other = (
        gs.draw(image, options=gs.Options(**options))
        for options in (
            {"edge": edge},
            {"edge": edge, "wobble": wobble, "threads": 1},
            {"edge": edge, "wobble": wobble, "threads": 2},
            {"edge": edge, "wobble": wobble, "seed": 1},
        )
    )
    assert plain.rasterize().tobytes() == gs.draw(image).rasterize().tobytes()
    check_picture(wobbly, wobbly.width, wobbly.height)
    assert wobbly.rasterize(800).tobytes() == again.rasterize(800).tobytes() != other.rasterize(800).tobytes()
    assert wobbly.stats["vertices"] == plain.stats["vertices"]
    # Of 255: within 1 % of white.
    assert wobbly.rasterize(800).mean() == pytest.approx(plain.rasterize(800).mean(), abs=2.55)


@given(
    **SCATTERED,
    wobble=st.floats(0.0, 1.0),
    edge=st.sampled_from(["smooth", "inked", "torn"]),
)
@twice_as_many
def test_any_labels_are_sound_however_edges_wobble(  # noqa: PLR0917
    edge: str, wobble: float, seed: int, n: int, width: int, height: int, share: float
) -> None:
    random, sites, labels = scattered(seed, n, width, height, share)
    tones = random.random(n).astype(np.float32)
    outline = stages.outline(sites, labels, width, height, tones=tones, wobble=wobble, edge=edge, seed=seed)
    check_picture(outline, width, height)


COLOURS = "#1d1d1b,pink=#ff48b0,#0078bf"


@EDGES
@pytest.mark.parametrize("overprint", [False, True])
@pytest.mark.parametrize("wobble", [0.2, 1.0])
def test_edges_of_many_inks_drawn_by_hand_are_sound_and_survive_files(
    edge: str, wobble: float, overprint: bool, tmp_path: Path
) -> None:
    options = gs.Options(inks=COLOURS, paper="#f4efe2", overprint=overprint, wobble=wobble, edge=edge)  # type: ignore[arg-type]
    drawing = gs.draw(photo("astronaut", 160, 120), options=options)
    canvas = drawing.width * drawing.height
    areas = {name: drawing.to_shapely(name) for name in (*drawing.inks, drawing.paper[0])}
    assert all(area.is_valid and area.area > 0 for area in areas.values())
    if not overprint:
        check_picture(drawing, drawing.width, drawing.height)
        assert sum(area.area for area in areas.values()) == pytest.approx(canvas, rel=AREA_TOLERANCE)
        for one, other in itertools.combinations(areas.values(), 2):
            assert shapely.intersection(one, other).area <= AREA_TOLERANCE * canvas
    drawing.save(tmp_path / "drawing.json")
    loaded = gs.load(tmp_path / "drawing.json")
    loaded.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "drawing.json").read_bytes()
    check_same_drawing(loaded, drawing)


@EDGES
def test_edges_drawn_by_hand_survive_files_rules_and_plots(edge: str, tmp_path: Path) -> None:
    drawing = gs.draw(photo("coffee", 128, 96), options=gs.Options(wobble=0.5, edge=edge))
    for suffix in ("svg", "json"):
        drawing.save(tmp_path / f"drawing.{suffix}")
        check_same_drawing(gs.load(tmp_path / f"drawing.{suffix}"), drawing)
    assert drawing.plot("0.5mm", width="100mm").stats["paths"] > 0
    for process in ("vinyl", "stencil"):
        rules = gs.Rules.process(process)
        kept, _ = drawing.enforce(rules, width="200mm")
        check_picture(kept, kept.width, kept.height)
        assert not kept.check(rules, width="200mm").violations


@files
@pytest.mark.parametrize(
    "image",
    [np.zeros((4, 6), np.uint8), np.full((4, 6), 255, np.uint8), np.zeros((1, 1), np.uint8), noise(1, 30, 1), noise(2, 14, 11)],
    ids=["black", "white", "one pixel", "a row", "noise"],
)
def test_awkward_drawings_survive_a_file(image: np.ndarray, suffix: str, how: dict[str, Any], tmp_path: Path) -> None:
    awkward = options_with(density=2.0, nodes_per_pixel=1.0, alpha=1.0, stipple_scale=2.0, gamma=1.1, invert=True, threads=2)
    drawing = gs.draw(image, importance="none", options=awkward)
    drawing.save(tmp_path / f"drawing.{suffix}", **how)
    check_same_drawing(gs.load(tmp_path / f"drawing.{suffix}"), drawing)


def test_a_loaded_drawing_knows_what_it_does_not_have(tmp_path: Path) -> None:
    drawing = drawn("camera")
    drawing.save(tmp_path / "drawing.json")
    loaded = gs.load(str(tmp_path / "drawing.json"))
    for attribute in ("graph", "importance"):
        with pytest.raises(gs.GraphStippleError, match=f"loaded from a file or a pickle, which hold no {attribute}"):
            getattr(loaded, attribute)
    assert "seconds" not in loaded.stats
    assert repr(loaded) == repr(drawing)
    assert loaded.to_shapely().equals(drawing.to_shapely())


def test_what_is_no_drawing_is_not_loaded(tmp_path: Path) -> None:
    with pytest.raises(gs.InvalidInputError, match=r"\.json"):
        gs.load(tmp_path / "drawing.png")
    with pytest.raises(gs.ImageFileNotFoundError, match="does not exist"):
        gs.load(tmp_path / "drawing.json")
    contents = {
        "empty.svg": "",
        "empty.json": "",
        "other.json": '{"a": 1}',
        "list.json": "[]",
        "other.svg": '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 5 5"><path d="M0 0H5V5z"/></svg>',
        "text.svg": "not a drawing",
    }
    for name, text in contents.items():
        (tmp_path / name).write_text(text)
        with pytest.raises(gs.ImageFileError, match=name) as refused:
            gs.load(tmp_path / name)
        assert "\n" not in str(refused.value)
    (tmp_path / "bytes.json").write_bytes(b"\xff\xfe\x00\x80")
    with pytest.raises(gs.ImageFileError, match="bytes"):
        gs.load(tmp_path / "bytes.json")


def test_a_damaged_drawing_is_an_error_and_no_crash(tmp_path: Path) -> None:
    text = gs.draw(photo("camera", 40, 30)).json()
    path = tmp_path / "drawing.json"
    random = np.random.default_rng(0)
    refused = 0
    for _ in range(200):
        begin = int(random.integers(0, len(text)))
        end = begin + int(random.integers(1, 20))
        path.write_text(text[:begin] + "".join(random.choice(list("0123456789-,.[]{}e"), end - begin)) + text[end:])
        try:
            loaded = gs.load(path)
        except gs.GraphStippleError:
            refused += 1
        else:
            loaded.svg()
            loaded.rasterize()
    assert refused > 100


# The least dot -------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("length", "size", "pixels"),
    [
        (0.8, {}, 0.8),
        ("0.8px", {}, 0.8),
        ("0.3mm", {"width": "32mm"}, 1.2),
        ("0.3mm", {"page": "42x34mm", "margin": "5mm"}, 1.2),
        (2, {"width": 256}, 1.0),
        (0, {}, 0.0),
    ],
)
def test_no_dot_is_smaller_than_the_least(length: Any, size: dict[str, Any], pixels: float) -> None:
    drawing = drawn("astronaut", width=128, height=96)
    assert (drawing.width, drawing.height) == (128, 96)
    changed = drawing.with_min_dot(length, **size)
    before, after = drawing.stipples, changed.stipples
    assert (after["radius"] >= pixels * (1 - 1e-9)).all()
    stats = changed.stats
    assert stats["dots_dropped"] == len(before) - len(after)
    small = int((before["radius"] < pixels).sum())
    assert stats["dots_enlarged"] + stats["dots_dropped"] == small
    assert stats["stipples"] == len(after)
    assert stats["regions"] == len(changed.regions)
    # Those that are large enough stay as they are, and the picture is as sound as before.
    large = {tuple(dot) for dot in before[before["radius"] >= pixels].tolist()}
    assert large <= {tuple(dot) for dot in after.tolist()}
    check_picture(changed, changed.width, changed.height)
    assert changed.options == drawing.options
    assert changed.graph.sites.shape == drawing.graph.sites.shape


def test_dots_are_dropped_where_there_is_no_room() -> None:
    drawing = drawn("astronaut")
    changed = drawing.with_min_dot(6)
    assert changed.stats["dots_dropped"] > 0
    assert drawing.with_min_dot(0.6).stats["dots_enlarged"] > 0
    assert "dots_dropped" not in drawing.stats or drawing.stats["dots_dropped"] == 0
    check_picture(changed, changed.width, changed.height)


@pytest.mark.parametrize("length", ["thick", -1, float("nan"), True, None, "0.3 miles"])
def test_a_least_dot_that_is_none(length: Any) -> None:
    with pytest.raises(gs.InvalidInputError, match="min_dot is"):
        drawn("astronaut").with_min_dot(length)


@pytest.mark.parametrize("density", [0.3, 4.0, 16.0])
def test_polygons_have_the_area_of_the_picture_however_close_nodes_are(density: float) -> None:
    options = options_with(density=density, nodes_per_pixel=0.9 * density)
    drawing = gs.draw(photo("camera", 60, 45), options=options)
    white, black = (drawing.to_shapely(ink).area / (60 * 45) for ink in ("white", "black"))
    assert white + black == pytest.approx(1, abs=1e-9)
    assert white == pytest.approx(drawing.rasterize(60 * 16).mean() / 255, abs=0.002)
