"""The methods that drawings are compared with: what each promises, and that a picture comes of every photo."""

from __future__ import annotations

import io
import os
import re
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
import resvg_py
from PIL import Image
from tests.support import photo_luma

from graphstipple import GraphStippleError, InvalidInputError
from graphstipple_eval import installation
from graphstipple_eval.baselines import (
    METHODS,
    capacity,
    density,
    dots,
    halftone,
    linde_buzo_gray,
    multi_class,
    priority,
    programs,
    weighted_voronoi,
)
from graphstipple_eval.method import Method, Photo, Picture

BY_NAME = {method.name: method for method in METHODS}
BUDGETED = ("sps", "wvs", "wvs-squared", "lbg", "mlbg-equal", "ccvt")
STIPPLING = (*BUDGETED, "mlbg")
DOTS = 600


def needs(name: str) -> pytest.MarkDecorator:
    """Skip a test where a program is not installed."""
    missing = BY_NAME[name].missing()
    return pytest.mark.skipif(missing is not None, reason=missing or "")


methods = pytest.mark.parametrize("method", [pytest.param(method, id=method.name, marks=needs(method.name)) for method in METHODS])
stippling_methods = pytest.mark.parametrize("name", STIPPLING)


def photo_of(tone: np.ndarray) -> Photo:
    """Return a photo of a tone that 8 bits can hold."""
    grey = np.rint(np.asarray(tone) * 255).astype(np.uint8)
    return Photo("test", "0" * 64, grey, (grey / np.float32(255)).astype(np.float32))


@pytest.fixture(scope="module")
def face() -> Photo:
    """A face, 96 x 128 pixels."""
    return photo_of(photo_luma("astronaut")[60:156, 160:288])


@pytest.fixture(scope="module")
def pictures(face: Photo) -> dict[str, Picture]:
    """What the stippling methods make of the face."""
    return {name: BY_NAME[name].draw(face, DOTS) for name in STIPPLING}


def painted(svg: str, width: int, height: int) -> np.ndarray:
    """Paint an SVG at sixteen times its size, where resvg's polygons are close to circles, and average."""
    # Points of potrace and millimetres of inksep are pixels.
    dpi = 25.4 if "mm" in svg else 72
    png = bytes(resvg_py.svg_to_bytes(svg_string=svg, width=16 * width, height=16 * height, dpi=dpi, background="#ffffff"))
    grey = np.asarray(Image.open(io.BytesIO(png)).convert("L")) / 255
    return grey.reshape(height, 16, width, 16).mean(axis=(1, 3))


def circle_centres(svg: str) -> np.ndarray:
    """Return the centres of the circles of an SVG, (n, 2)."""
    return np.array(re.findall(r'<circle cx="([^"]+)" cy="([^"]+)"', svg), float).reshape(-1, 2)


# What holds for all ---------------------------------------------------------------------------------------------------------------


def test_methods_have_names_and_sources() -> None:
    assert len(BY_NAME) == len(METHODS) == 12
    for method in METHODS:
        assert re.fullmatch(r"[a-z]+(-[a-z]+)*", method.name)
        assert method.title
        assert method.source
    assert {method.name for method in METHODS if method.is_budgeted} == {*BUDGETED, "inksep"}


def test_what_is_missing_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installation, "find_program", lambda name: None)
    monkeypatch.setattr(installation.importlib.util, "find_spec", lambda name: None)
    for name in ("potrace", "vtracer", "inksep"):
        assert str(BY_NAME[name].missing()).startswith(f"{name} is not installed: ")
    assert all(method.missing() is None for method in METHODS if method.name not in {"potrace", "vtracer", "inksep"})


@methods
@pytest.mark.parametrize(
    ("tone", "count"),
    [
        (np.zeros((24, 40)), 100),
        (np.ones((24, 40)), 100),
        (np.full((1, 1), 0.4), 1),
        (np.zeros((1, 1)), 5),
        (np.tile(np.linspace(0, 1, 200), (3, 1)), 60),
        (np.full((30, 30), 64 / 255), 1),
        (np.full((16, 16), 128 / 255), 600),
        (1 - np.eye(20)[:, ::-1] * (np.arange(20) == 3), 50),
    ],
    ids=["black", "white", "one pixel", "one black pixel", "3 x 200", "one dot", "more dots than pixels", "a speck"],
)
def test_every_photo_gives_a_picture(method: Method, tone: np.ndarray, count: int) -> None:
    photo = photo_of(tone)
    picture = method.draw(photo, count)
    assert picture.raster.shape == photo.tone.shape
    assert picture.raster.dtype == np.float32
    assert picture.raster.min() >= 0
    assert picture.raster.max() <= 1
    if tone.min() == 1:
        assert picture.raster.min() == 1
    if picture.counts.stipples is not None and not method.name.startswith("mlbg"):
        assert picture.counts.stipples <= max(1.1 * count, count + 1)
        assert (picture.counts.stipples > 0) == (tone.min() < 1)
    if picture.svg is not None:
        height, width = photo.tone.shape
        assert np.abs(painted(picture.svg, width, height).mean() - picture.raster.mean()) < 0.04


@pytest.mark.parametrize("count", [0, -3, 2.5, None])
@pytest.mark.parametrize("name", BUDGETED)
def test_a_number_of_dots_that_is_none_is_an_error(name: str, count: object, face: Photo) -> None:
    with pytest.raises(InvalidInputError, match="but it must be a whole number of at least 1"):
        BY_NAME[name].draw(face, count)  # type: ignore[arg-type]


@methods
def test_pictures_are_the_same_in_every_run(method: Method, face: Photo) -> None:
    small = photo_of(face.tone[20:60, 30:80])
    first, second = (method.draw(small, 150) for _ in range(2))
    np.testing.assert_array_equal(first.raster, second.raster)
    assert (first.svg, first.counts, first.settings) == (second.svg, second.counts, second.settings)


@pytest.mark.parametrize("name", BUDGETED)
def test_the_budget_is_met(name: str, pictures: dict[str, Picture]) -> None:
    found = pictures[name].counts.coordinates
    assert found is not None
    tolerance = {"wvs": 0, "wvs-squared": 0, "ccvt": 0, "sps": 0.01}.get(name, 0.04)
    assert abs(found - DOTS) <= tolerance * DOTS


@stippling_methods
def test_the_coordinates_are_those_written(name: str, pictures: dict[str, Picture]) -> None:
    svg, counts = pictures[name].svg, pictures[name].counts
    assert svg is not None
    assert counts.stipples == len(circle_centres(svg))
    rings = [ring for data in re.findall(r' d="([^"]*)"', svg) for ring in data.split("Z") if ring]
    assert counts.coordinates == counts.stipples + sum(ring.count(",") for ring in rings)
    assert counts.coordinates <= 1.5 * counts.stipples


@stippling_methods
def test_dots_lie_on_the_canvas(name: str, pictures: dict[str, Picture], face: Photo) -> None:
    svg = pictures[name].svg
    assert svg is not None
    centres = circle_centres(svg)
    assert len(centres) == pictures[name].counts.stipples
    height, width = face.tone.shape
    assert centres.min() >= 0
    assert (centres <= [width, height]).all()


@stippling_methods
def test_the_svg_is_the_picture(name: str, pictures: dict[str, Picture], face: Photo) -> None:
    height, width = face.tone.shape
    svg = pictures[name].svg
    assert svg is not None
    difference = painted(svg, width, height) - pictures[name].raster
    assert np.abs(difference).mean() < 0.012
    assert abs(difference.mean()) < 0.005


@pytest.mark.parametrize(
    ("name", "bound"),
    [("sps", 0.12), ("wvs", 0.02), ("wvs-squared", 0.04), ("lbg", 0.04), ("mlbg", 0.02), ("mlbg-equal", 0.02), ("ccvt", 0.04)],
)
def test_the_mean_tone_is_kept(name: str, bound: float, pictures: dict[str, Picture], face: Photo) -> None:
    # Dots that overlap lose ink, so pictures of black dots are a little too light; `sps` clusters them in dark areas.
    error = float(pictures[name].raster.mean() - face.tone.mean())
    assert -0.02 < error < bound


@pytest.mark.parametrize("name", ["wvs-squared", "lbg", "mlbg", "mlbg-equal", "ccvt"])
def test_tones_are_kept_where_they_are(name: str) -> None:
    ramp = photo_of(np.tile(np.linspace(0.3, 0.95, 160), (60, 1)))
    raster = BY_NAME[name].draw(ramp, 500).raster
    strips = [part.mean() for part in np.split(raster - ramp.tone, 5, axis=1)]
    assert np.abs(strips).max() < 0.06


# Dots -----------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("radius", [0.3, 0.5, 1.0, 2.0, 5.0])
def test_discs_have_their_ink(radius: float) -> None:
    step = np.ceil(2 * radius + 1)
    side = int(240 / step)
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2) * step + radius + 1
    positions = grid + np.random.default_rng(0).random(grid.shape) * 0.9
    count = len(positions)
    picture = dots.picture(dots.Dots(positions, np.full(count, radius), np.zeros(count, np.uint8)), 256, 256, {})
    assert (1 - picture.raster).sum() == pytest.approx(count * np.pi * radius**2, rel=0.01)


@pytest.mark.parametrize("radius", [0.4, 0.5, 0.6])
def test_discs_in_the_middle_of_pixels_have_their_ink(radius: float) -> None:
    middles = np.stack(np.meshgrid(np.arange(2, 62, 2), np.arange(2, 62, 2)), axis=-1).reshape(-1, 2) + 0.5
    count = len(middles)
    picture = dots.picture(dots.Dots(middles, np.full(count, radius), np.zeros(count, np.uint8)), 64, 64, {})
    assert (1 - picture.raster).sum() == pytest.approx(count * np.pi * radius**2, rel=0.02)


def test_later_dots_cover_earlier_ones() -> None:
    centre = np.array([[10.0, 10.0]] * 3)
    rings = dots.Dots(centre, np.array([8.0, 5.0, 2.0]), np.array([0, 1, 0], np.uint8))
    raster = dots.picture(rings, 20, 20, {}).raster
    assert [raster[10, 10], raster[10, 13], raster[10, 16], raster[10, 19]] == [0, 1, 0, 1]


def test_parts_of_dots_are_bounded_and_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    generator = np.random.default_rng(2)
    radii = np.where(np.arange(200) % 50 == 0, 25, generator.random(200) * 4)
    many = dots.Dots(generator.random((200, 2)) * 40 - 5, radii, generator.integers(0, 2, 200, np.uint8))
    whole = dots.picture(many, 30, 30, {}).raster
    monkeypatch.setattr(dots, "SAMPLES_AT_ONCE", 500)
    np.testing.assert_array_equal(dots.picture(many, 30, 30, {}).raster, whole)
    assert max(len(disc) for disc, _ in dots.covered(many.positions, radii, (240, 240), 8)) <= 1000


def test_painting_matches_a_loop() -> None:
    generator = np.random.default_rng(3)
    few = dots.Dots(generator.random((12, 2)) * 14 - 2, generator.random(12) * 3, generator.integers(0, 2, 12, np.uint8))
    samples = np.full((30, 36), 7, np.uint8)
    dots.paint(few, samples, 3)
    expected, offsets = np.full((30, 36), 7, np.uint8), dots.sample_offsets(30)
    for (x, y), radius, ink in zip(few.positions, few.radii, few.inks, strict=True):
        for row in range(30):
            for column in range(36):
                if np.hypot((column + offsets[row]) / 3 - x, (row + 0.5) / 3 - y) <= radius:
                    expected[row, column] = ink
    np.testing.assert_array_equal(samples, expected)


# Densities ------------------------------------------------------------------------------------------------------------------------


def test_cells_match_a_loop() -> None:
    generator = np.random.default_rng(4)
    values = generator.random((9, 12))
    field = density.Density(values, 1)
    assert field.samples_per_pixel == 1
    sites = generator.random((7, 2)) * [12, 9]
    runs = field.runs(sites)
    cells = field.cells(sites, runs)
    axes = field.axes(cells, runs)
    rows, columns = np.mgrid[:9, :12]
    points = np.stack([columns + 0.5, rows + 0.5], axis=-1).reshape(-1, 2)
    nearest = np.argmin(((points[:, np.newaxis] - sites) ** 2).sum(axis=2), axis=1)
    for number in range(7):
        own, mass = points[nearest == number], values.ravel()[nearest == number]
        assert cells.masses[number] == pytest.approx(mass.sum())
        assert cells.areas[number] == len(own)
        centroid = mass @ own / mass.sum()
        np.testing.assert_allclose(cells.centroids[number], centroid)
        covariance = np.einsum("n,ni,nj", mass, own - centroid, own - centroid)
        main = np.linalg.eigh(covariance)[1][:, -1]
        assert abs(main @ axes[number]) == pytest.approx(1)


def test_drawn_points_follow_the_density() -> None:
    values = np.zeros((4, 4))
    values[1, 2], values[3, 0] = 3, 1
    points = density.draw_points(values, 4000, np.random.default_rng(5))
    pixels, counts = np.unique(np.floor(points), axis=0, return_counts=True)
    np.testing.assert_array_equal(pixels, [[0, 3], [2, 1]])
    np.testing.assert_array_equal(counts, [1000, 3000])
    assert len(density.draw_points(np.zeros((4, 4)), 10, np.random.default_rng(5))) == 0


def test_the_z_order_takes_quarter_after_quarter() -> None:
    row, column = np.mgrid[:4, :4]
    expected = [[0, 1, 4, 5], [2, 3, 6, 7], [8, 9, 12, 13], [10, 11, 14, 15]]
    np.testing.assert_array_equal(density.z_order(row, column), expected)


# The methods one by one -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (2, 3), (31, 47), (47, 31)])
def test_floyd_steinberg_matches_a_loop(shape: tuple[int, int]) -> None:
    tone = np.random.default_rng(6).random(shape).astype(np.float32)
    height, width = shape
    values = tone.astype(float)
    for row in range(height):
        for column in range(width):
            white = values[row, column] >= 0.5
            error = values[row, column] - white
            values[row, column] = white
            for down, right, weight in ((0, 1, 7), (1, -1, 3), (1, 0, 5), (1, 1, 1)):
                if row + down < height and 0 <= column + right < width:
                    values[row + down, column + right] += error * weight / 16
    np.testing.assert_array_equal(halftone.floyd_steinberg(tone), values)


def test_the_threshold_is_a_half() -> None:
    tones = np.array([[0, 0.4, 0.5, 0.6, 1]], np.float32)
    picture = BY_NAME["threshold"].draw(Photo("test", "", np.zeros((1, 5), np.uint8), tones), 1)
    np.testing.assert_array_equal(picture.raster, [[0, 0, 1, 1, 1]])


def test_priority_diffusion_keeps_ink_and_extremes() -> None:
    generator = np.random.default_rng(7)
    tone = np.clip(np.linspace(-0.2, 1.2, 60) + generator.normal(0, 0.02, (40, 60)), 0, 1)
    is_dot = priority.diffuse(tone, 0)
    assert is_dot.mean() == pytest.approx(1 - tone.mean(), abs=0.01)
    assert is_dot[tone == 0].mean() > 0.97
    assert is_dot[tone == 1].mean() < 0.03


@pytest.mark.parametrize("log_scale", [0.0, 1.2])
def test_priority_diffusion_matches_a_loop(log_scale: float) -> None:
    tone = np.random.default_rng(10).random((11, 14))
    values, is_open, expected = tone.copy(), np.ones(tone.shape, bool), np.zeros(tone.shape, bool)
    ties = np.random.default_rng(priority.SEED).permutation(17 * 20).reshape(17, 20)[3:-3, 3:-3] / (17 * 20)
    rows, columns = np.indices(tone.shape)
    while is_open.any():
        order = np.where(is_open, np.rint(np.abs(values - 0.5) * 510) + ties, -1)
        before, was_open = values.copy(), is_open.copy()
        taken = [
            (row, column)
            for row, column in np.argwhere(is_open)
            if order[row, column] == order[max(row - 3, 0) : row + 4, max(column - 3, 0) : column + 4].max()
        ]
        for row, column in taken:
            is_open[row, column] = False
        reached = np.zeros(tone.shape, bool)
        for row, column in taken:
            expected[row, column] = before[row, column] < 0.5
            error = before[row, column] - (not expected[row, column])
            square = (rows - row) ** 2 + (columns - column) ** 2
            near = was_open & is_open & (square <= 3.5**2)
            weights = np.clip(before if error > 0 else 1 - before, 1e-3, 1)[near] / square[near]
            if near.any():
                values[near] += error * np.exp(log_scale if error > 0 else -log_scale) * weights / weights.sum()
                reached |= near
        values[reached] = np.clip(values[reached], 1 / 255, 254 / 255)
    np.testing.assert_array_equal(priority.diffuse(tone, log_scale), expected)


def test_larger_scales_of_errors_leave_fewer_dots(face: Photo) -> None:
    found = [priority.diffuse(face.tone.astype(np.float64), log_scale).sum() for log_scale in (-4, -1, 0, 1, 4)]
    assert found == sorted(found, reverse=True)
    assert found[0] > 5 * found[-1]


@pytest.mark.parametrize("count", [40, 600, 3000, 6000])
def test_the_scale_of_errors_gives_the_number(count: int, face: Photo) -> None:
    picture = BY_NAME["sps"].draw(face, count)
    assert picture.counts.stipples == pytest.approx(count, rel=0.01, abs=1)
    assert "note" not in picture.settings
    assert (picture.settings["grid"] == [128, 96]) == (count > 40)


def test_more_dots_than_the_pixels_allow_are_noted(face: Photo) -> None:
    picture = BY_NAME["sps"].draw(face, 20_000)
    assert picture.counts.stipples < 128 * 96
    assert str(picture.settings["note"]).startswith(f"{picture.counts.stipples:,} dots instead of 20,000")


def test_lloyd_steps_end_at_centroids(face: Photo) -> None:
    field = density.Density(1 - face.tone.astype(np.float64), 300)
    start = density.draw_points(1 - face.tone, 300, np.random.default_rng(1))
    sites, steps = weighted_voronoi.relax(field, start)
    assert 5 < steps <= weighted_voronoi.MOST_STEPS

    def off(positions: np.ndarray) -> float:
        centroids = field.cells(positions, field.runs(positions)).centroids
        return float(np.hypot(*(centroids - positions).T).mean())

    assert off(sites) < 0.05 * off(start)


def test_the_squared_weight_makes_dots_as_dense_as_the_darkness() -> None:
    tone = np.full((80, 160), 0.2)
    tone[:, 80:] = 0.8
    share = {}
    for name in ("wvs", "wvs-squared"):
        svg = BY_NAME[name].draw(photo_of(tone), 800).svg
        assert svg is not None
        share[name] = np.mean(circle_centres(svg)[:, 0] < 80)
    assert share["wvs-squared"] == pytest.approx(0.8, abs=0.02)
    assert share["wvs"] == pytest.approx(2 / 3, abs=0.03)


def test_linde_buzo_gray_cells_hold_the_ink_of_a_dot(face: Photo, pictures: dict[str, Picture]) -> None:
    field = density.Density(1 - face.tone.astype(np.float64), DOTS)
    svg = pictures["lbg"].svg
    assert svg is not None
    sites = dots.keep_inside(circle_centres(svg), field.width, field.height)
    masses = field.cells(sites, field.runs(sites)).masses
    assert masses.std() / masses.mean() < 0.2


@pytest.mark.parametrize("count", [1, 2, 3, 5, 10, 30])
def test_linde_buzo_gray_meets_a_handful(count: int, face: Photo) -> None:
    found = BY_NAME["lbg"].draw(face, count).counts.stipples
    assert found is not None
    assert abs(found - count) <= (0 if count < 3 else 1)


def test_linde_buzo_gray_splits_keeps_and_removes() -> None:
    # Three cells of 4 x 4 pixels with 16, 8 and 1 px^2 of ink.
    values = np.ones((4, 12))
    values[:, 4:8], values[:, 8:] = 0.5, 1 / 16
    field = density.Density(values, 3)
    sites = np.array([[2.0, 2.0], [6.0, 2.0], [10.0, 2.0]])
    runs = field.runs(sites)
    cells = field.cells(sites, runs)
    after, changed = linde_buzo_gray.next_sites(field, runs, cells, cells.centroids, dot_areas=8.0, hysteresis=0.1)
    assert changed
    assert len(after) == 3
    np.testing.assert_allclose(after[0], [6, 2])
    np.testing.assert_allclose(after[1:].mean(axis=0), [2, 2])
    assert np.hypot(*(after[1] - after[2])) == pytest.approx(np.sqrt(16 / np.pi))
    each = np.array([16.0, 8.0, 1.0])
    _, changed = linde_buzo_gray.next_sites(field, runs, cells, cells.centroids, dot_areas=each, hysteresis=0.1)
    assert not changed


def test_dark_areas_are_white_dots_on_black() -> None:
    tone = np.full((64, 128), 0.15)
    tone[:, 64:] = 0.85
    picture = BY_NAME["mlbg-equal"].draw(photo_of(tone), 900)
    dark, light = picture.raster[8:-8, 8:56], picture.raster[8:-8, 72:-8]
    assert dark.mean() == pytest.approx(0.15, abs=0.03)
    assert light.mean() == pytest.approx(0.85, abs=0.03)
    # Most of a dark area is black, of a light area white: the ground between the dots is filled.
    assert np.median(dark) == 0
    assert np.median(light) == 1
    assert picture.settings["largest_diameter"] == pytest.approx(2 * float(str(picture.settings["least_diameter"])))


def test_black_lies_where_black_ground_is_nearer() -> None:
    # A wall of dots between dark ground and light.
    tone = np.full((10, 30), 0.3)
    tone[:, 15:] = 0.6
    column = np.arange(0.5, 10)
    wall = dots.Dots(np.stack([np.full(10, 15.0), column], axis=1), np.full(10, 2.0), np.zeros(10, np.uint8))
    black = multi_class.black_ground(wall, tone)
    assert black[:, : 8 * 15 - 2].all()
    assert not black[:, 8 * 15 + 2 :].any()
    (ring,), regions = multi_class.outlines(black, 4)
    assert regions == 1
    assert len(ring) == 4
    np.testing.assert_allclose([ring.min(axis=(0, 1)), ring.max(axis=(0, 1))], [[-1, -1], [119, 80]], atol=2)


@pytest.mark.parametrize(("tone", "expected"), [(0.0, True), (1.0, False)])
def test_ground_of_one_ink_is_all_or_nothing(tone: float, expected: bool) -> None:
    one = dots.Dots(np.array([[6.0, 6.0]]), np.array([3.0]), np.zeros(1, np.uint8))
    assert (multi_class.black_ground(one, np.full((12, 12), tone)) == expected).all()
    everywhere = dots.Dots(np.array([[6.0, 6.0]]), np.array([30.0]), np.zeros(1, np.uint8))
    assert not multi_class.black_ground(everywhere, np.full((12, 12), tone)).any()


def test_a_budget_that_is_out_of_reach_is_noted() -> None:
    picture = BY_NAME["mlbg-equal"].draw(photo_of(np.zeros((40, 40))), 60)
    assert picture.counts.coordinates == 4
    assert picture.settings["note"] == "4 coordinates instead of 60, the nearest of 2 draws"


def test_what_is_left_out_would_not_show(face: Photo, pictures: dict[str, Picture]) -> None:
    tone = face.tone.astype(np.float64)
    placed, _ = multi_class.place(tone, multi_class.LEAST_DIAMETER)
    samples = np.where(multi_class.black_ground(placed, tone), dots.BLACK, dots.WHITE).astype(np.uint8)
    dots.paint(placed, samples, dots.SAMPLES_PER_PIXEL)
    picture = pictures["mlbg"]
    assert picture.counts.stipples < 0.6 * len(placed.radii)
    whole = dots.box_average(samples, dots.SAMPLES_PER_PIXEL)
    assert np.abs(picture.raster - whole).mean() < 1e-3


def test_only_dots_that_change_a_sample_are_kept() -> None:
    centre = np.array([[10.0, 10.0], [10.0, 10.0], [10.0, 10.0], [4.0, 4.0]])
    placed = dots.Dots(centre, np.array([5.0, 4.0, 3.0, 2.0]), np.array([0, 0, 1, 1], np.uint8))
    samples = np.ones((160, 160), np.uint8)
    shown = multi_class.paint_what_shows(placed, samples)
    np.testing.assert_array_equal(shown.radii, [5, 3])
    expected = np.ones((160, 160), np.uint8)
    dots.paint(placed, expected, 8)
    np.testing.assert_array_equal(samples, expected)


def test_multi_class_sizes_are_those_of_the_paper(face: Photo, pictures: dict[str, Picture]) -> None:
    one, many = BY_NAME["mlbg"].draw(face, 1), pictures["mlbg"]
    np.testing.assert_array_equal(one.raster, many.raster)
    assert one.svg is not None
    radii = np.array(re.findall(r' r="([^"]+)"', one.svg), float)
    assert 0.5 <= radii.min() < radii.max() <= 1


def test_exchanged_points_are_nearer_and_none_is_lost(face: Photo) -> None:
    generator = np.random.default_rng(8)
    points = density.draw_points(1 - face.tone.astype(np.float64), 40 * 32, generator).reshape(40, 32, 2)
    after, sites, sweeps = capacity.settle(points, generator)
    assert 1 < sweeps < capacity.MOST_SWEEPS
    assert after.shape == points.shape
    np.testing.assert_array_equal(np.sort(after.reshape(-1, 2), axis=0), np.sort(points.reshape(-1, 2), axis=0))
    np.testing.assert_allclose(sites, after.mean(axis=1))
    # Nothing is left to gain: of no two sites could two points change places and lie nearer to their owners.
    distances = ((after[:, :, np.newaxis] - sites) ** 2).sum(axis=3)
    for one in range(40):
        for other in range(one):
            leaving = (distances[one, :, other] - distances[one, :, one]).min()
            coming = (distances[other, :, one] - distances[other, :, other]).min()
            assert leaving + coming > -1e-6


def test_matchings_hold_every_pair_once() -> None:
    pairs = np.random.default_rng(9).permutation(np.stack(np.triu_indices(9, 1), axis=1))
    parts = list(capacity.matchings(pairs, 9))
    for part in parts:
        assert len(np.unique(part)) == part.size
    np.testing.assert_array_equal(np.sort(np.concatenate(parts), axis=0), np.sort(pairs, axis=0))


def test_capacity_constrained_dots_are_limited(monkeypatch: pytest.MonkeyPatch, face: Photo) -> None:
    monkeypatch.setattr(capacity, "MOST_DOTS", 50)
    picture = BY_NAME["ccvt"].draw(face, 51)
    assert picture.counts.stipples == picture.settings["most_dots"] == 50
    assert picture.settings["note"] == "50 dots instead of 51: more take too long"
    assert "note" not in BY_NAME["ccvt"].draw(face, 50).settings


# Programs -------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("data", "count"),
    [
        ("", 0),
        ("M0 0", 1),
        ("M10,20 30,40z", 2),
        ("M2040 4438 c-41 -5 -81 -9 -87 -10 -7 -1 -13 -5 -13 -10z", 7),
        ("m.5.5-1e-3-2l1 2h3v-4z", 5),
        ("M0 0Q1 1 2 2T3 3S4 4 5 5H1 2V3", 9),
        ("M0 0A5 5 0 0 1 10 10a1 1 0 01.5.5 2 2 30 1 0-1-1", 4),
        ("M0 0 L1e5 1E-5 Z M 1 1", 3),
    ],
)
def test_coordinates_of_path_data(data: str, count: int) -> None:
    assert programs.count_coordinates(data) == count


@needs("potrace")
def test_potrace_traces_the_bitmap_of_otsus_threshold(face: Photo) -> None:
    picture = BY_NAME["potrace"].draw(face, 1)
    white, _ = programs.otsu_bitmap(face.tone)
    assert np.abs(picture.raster - white).mean() < 0.05
    assert picture.counts.regions == picture.svg.count("<path") > 0
    assert picture.counts.coordinates > picture.counts.regions


@needs("vtracer")
def test_vtracer_traces_what_is_darker_than_the_middle(face: Photo) -> None:
    picture = BY_NAME["vtracer"].draw(face, 1)
    assert np.abs(picture.raster - (face.tone >= 0.5)).mean() < 0.06
    assert picture.counts.coordinates > picture.counts.regions > 0


@needs("inksep")
def test_inksep_draws_the_dots(face: Photo) -> None:
    picture = BY_NAME["inksep"].draw(face, 200)
    assert picture.counts.stipples == 200
    assert abs(picture.raster.mean() - face.tone.mean()) < 0.15


def write_programs(folder: Path, scripts: Mapping[str, str]) -> None:
    """Write programs by their names."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, script in scripts.items():
        (folder / name).write_text(f"#!/bin/sh\n{script}\n")
        (folder / name).chmod(0o755)


def test_programs_that_are_installed_and_work_tell_their_versions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_programs(tmp_path, {"potrace": "echo potrace 1.16. Copyright", "inksep": "exit 3"})
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setattr(installation.importlib.util, "find_spec", lambda name: None)
    assert programs.versions() == {"potrace": "1.16"}
    monkeypatch.setattr(installation, "find_program", lambda name: None)
    assert programs.versions() == {}


def test_a_program_that_fails_is_one_sentence() -> None:
    with pytest.raises(GraphStippleError, match=r"failed with exit code 3 and said: no such thing$"):
        installation.run([sys.executable, "-c", "import sys; print('no such thing', file=sys.stderr); sys.exit(3)"])


def test_a_folder_has_its_own_programs_of_pypi_and_takes_others_from_the_path_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, own, unpacked = tmp_path / "path", tmp_path / "python" / "bin", tmp_path / "debian" / "usr" / "bin"
    folder = installation.Folder(tmp_path, "nothing may be installed")
    write_programs(path, {"inksep": ""})
    monkeypatch.setenv("PATH", str(path))
    for name in installation.PROGRAMS:
        if folder.find(name) is None:
            assert folder.missing(name) == f"{name} is not installed, and nothing may be installed"
    assert folder.find("inksep") is None
    write_programs(own, {"inksep": "", "python": ""})
    assert folder.find("inksep") == str(own / "inksep")
    assert folder.missing("inksep") is folder.missing("vtracer") is None
    write_programs(unpacked, {"potrace": "", "mkbitmap": ""})
    assert folder.missing("potrace") is None
    assert folder.find("mkbitmap") == str(unpacked / "mkbitmap")
    write_programs(path, {"mkbitmap": ""})
    assert folder.find("mkbitmap") == str(path / "mkbitmap")
    assert folder.environment == []
    libraries = unpacked.parent / "lib" / "some-linux-gnu"
    libraries.mkdir(parents=True)
    assert folder.environment == ["env", f"LD_LIBRARY_PATH={libraries}"]


def test_a_program_that_cannot_be_installed_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = installation.Folder(tmp_path)
    write_programs(tmp_path / "python" / "bin", {"python": "echo not there >&2; exit 1"})
    assert folder.missing("stippler") == "pip install stippler==0.2.1.1 failed: not there"
    write_programs(tmp_path / "python" / "bin", {"python": ""})
    assert folder.missing("stippler") == "stippler==0.2.1.1 has no program"
    write_programs(tmp_path / "path", {"apt-get": "echo no network >&2; exit 100"})
    monkeypatch.setenv("PATH", str(tmp_path / "path"))
    monkeypatch.setattr(installation, "find_program", lambda name: None)
    assert folder.missing("potrace") == "potrace is not installed, and its Debian packages cannot be had: no network"
