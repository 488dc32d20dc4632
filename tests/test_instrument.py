"""What the evaluation measures beyond `graphstipple.metrics`: FLIP against a twin of its definition, evenness on known dots."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import correlate1d
from tests import support

import graphstipple as gs
from graphstipple_eval import evenness, results
from graphstipple_eval.baselines import METHODS
from graphstipple_eval.baselines.halftone import floyd_steinberg
from graphstipple_eval.flip import PIXELS_PER_DEGREE, Flip
from graphstipple_eval.method import Photo

Array = np.ndarray[Any, np.dtype[np.float64]]

# FLIP


def linear(encoded: Array) -> Array:
    """Return linear light of what is sRGB-encoded."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def separable(values: Array, rows: Array, columns: Array) -> Array:
    return correlate1d(correlate1d(values, columns, axis=0, mode="nearest"), rows, axis=1, mode="nearest")


def lightness(luminance: Array) -> Array:
    """L* of CIELAB, of luminance relative to white."""
    cube = (6 / 29) ** 3
    return 116 * np.where(luminance > cube, np.cbrt(luminance), luminance / (3 * (6 / 29) ** 2) + 4 / 29) - 16


def hunt_lab(red: float, green: float, blue: float) -> Array:
    """L*, and a* and b* with the Hunt effect, of a colour in linear light."""
    to_xyz = np.array(
        [
            [10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
            [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
            [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382],
        ]
    )
    relative = to_xyz @ [red, green, blue] / (to_xyz @ [1, 1, 1])
    x, y, z = (lightness(relative) + 16) / 116
    light = 116 * y - 16
    return np.array([light, 0.01 * light * 500 * (x - y), 0.01 * light * 200 * (y - z)])


def twin(picture: Array, reference: Array, pixels_per_degree: float) -> float:
    """The mean of LDR-FLIP of grey pictures, from Andersson et al. 2020.

    Grey has no chroma, so opponent colours come down to one channel, luminance, and HyAB to the difference of lightness.
    """
    both = [linear(values) for values in (reference, picture)]

    # What the eye resolves: the contrast sensitivity of the achromatic channel is one Gaussian.
    spread = 0.0047
    radius = math.ceil(3 * math.sqrt(0.04 / (2 * math.pi**2)) * pixels_per_degree)  # the widest channel's
    at = np.arange(-radius, radius + 1) / pixels_per_degree
    seen = np.exp(-(math.pi**2) * at**2 / spread)
    seen /= seen.sum()
    first, second = (lightness(np.clip(separable(values, seen, seen), 0, 1)) for values in both)

    # Differences become at most 1; large ones are squeezed into the last twentieth.
    green, blue = hunt_lab(0, 1, 0), hunt_lab(0, 0, 1)
    most = (abs(green[0] - blue[0]) + math.hypot(*(green - blue)[1:])) ** 0.7
    colour = np.abs(first - second) ** 0.7
    knee = 0.4 * most
    colour = np.where(colour < knee, 0.95 / knee * colour, 0.95 + (colour - knee) / (most - knee) * 0.05)

    # Edges and points of the luminance: derivatives of a Gaussian, their positive and negative parts each of sum 1.
    deviation = 0.5 * 0.082 * pixels_per_degree
    radius = math.ceil(3 * deviation)
    at = np.arange(-radius, radius + 1).astype(float)
    smooth = np.exp(-(at**2) / (2 * deviation**2))
    edge = -at * smooth
    point = (at**2 / deviation**2 - 1) * smooth
    smooth /= smooth.sum()
    edge, point = (np.where(w > 0, w / w[w > 0].sum(), w / -w[w < 0].sum()) for w in (edge, point))
    strengths = [
        [np.hypot(separable(values, kernel, smooth), separable(values, smooth, kernel)) for kernel in (edge, point)]
        for values in both
    ]
    off = [np.abs(one - other) for one, other in zip(*strengths, strict=True)]
    feature = np.sqrt(np.maximum(*off) / math.sqrt(2))
    return float(np.mean(colour ** (1 - feature)))


def test_flip_is_its_published_definition() -> None:
    tone = support.photo_luma("camera", 181, 200).astype(np.float64)
    random = np.random.default_rng(6)
    pictures = {
        "drawing": gs.draw(tone.astype(np.float32)).rasterize() / 255,
        "halftone": floyd_steinberg(tone.astype(np.float32)).astype(np.float64),
        "noise": np.clip(tone + 0.1 * random.standard_normal(tone.shape), 0, 1),
        "white": np.ones_like(tone),
        "another photo": support.photo_luma("coffee", 181, 200).astype(np.float64),
    }
    compare = Flip(tone)
    for name, picture in pictures.items():
        expected = {f"flip_{pixels}": twin(picture, tone, pixels) for pixels in PIXELS_PER_DEGREE}
        assert compare(picture) == pytest.approx(expected, abs=1e-4), name


def test_flip_of_equal_pictures_is_0_and_of_black_against_white_nearly_1() -> None:
    tone = support.photo_luma("astronaut", 90, 70)
    assert Flip(tone)(tone) == {"flip_40": 0, "flip_80": 0, "flip_160": 0}
    black = np.zeros((50, 60))
    for first, second in ((black, 1 - black), (1 - black, black)):
        # Without an edge nothing adds to the difference of lightness, which is less than that of green and blue.
        assert list(Flip(first)(second).values()) == pytest.approx([twin(second, first, 80)] * 3, abs=1e-4)
        assert 0.96 < twin(second, first, 80) < 1


def test_flip_of_a_halftone_falls_with_distance_and_that_of_a_wrong_tone_stays() -> None:
    checkers = (np.indices((160, 170)) // 2).sum(axis=0) % 2.0
    tone = np.full(checkers.shape, 1.055 * 0.5 ** (1 / 2.4) - 0.055)  # half of the light, in which they melt
    halftone = Flip(tone)(checkers)
    assert halftone["flip_40"] > 2 * halftone["flip_80"] > 2 * halftone["flip_160"]
    tone = np.full(checkers.shape, 0.5)
    assert list(Flip(tone)(tone + 0.25).values()) == pytest.approx([Flip(tone)(tone + 0.25)["flip_40"]] * 3, abs=1e-4)
    assert Flip(tone)(tone + 0.25)["flip_80"] > Flip(tone)(tone + 0.125)["flip_80"] > 0.1


def test_flip_changes_no_picture_and_takes_every_type_of_float() -> None:
    tone, picture = support.photo_luma("coffee", 64, 50), np.random.default_rng(1).random((50, 64))
    compare, before = Flip(tone), picture.copy()
    found = compare(picture)
    assert compare(picture) == found == Flip(tone.astype(np.float64))(picture.astype(np.float32))
    np.testing.assert_array_equal(picture, before)
    assert all(type(value) is float for value in found.values())


def test_a_new_version_of_flip_measures_everything_again(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "flip-evaluator" in results.versions()
    before = results.fingerprint()
    found = results._package_versions()
    monkeypatch.setattr(results, "_package_versions", lambda: {**found, "flip-evaluator": "0.0"})
    assert results.fingerprint() != before


# Evenness


def lattice(columns: int, rows: int, step: float = 1.0) -> Array:
    """Dots of a hexagonal lattice."""
    row, column = np.mgrid[:rows, :columns].reshape(2, -1)
    return np.stack([column + 0.5 * (row % 2) + 0.25, (row + 0.5) * math.sqrt(3) / 2], axis=1) * step


HEIGHT = 40 * math.sqrt(3) / 2
"""Of 40 rows, a step apart."""


def one_ink(positions: Array, width: float, height: float) -> dict[str, float]:
    return evenness.measures(np.column_stack([positions, np.zeros(len(positions))]), math.ceil(width), math.ceil(height))


@pytest.mark.parametrize("step", [0.7, 8])
def test_a_hexagonal_lattice_is_even(step: float) -> None:
    found = evenness.ratios(lattice(40, 40, step), math.ceil(40 * step), math.ceil(HEIGHT * step))
    assert 1200 < len(found) < 1600  # without the border
    np.testing.assert_allclose(found, 1, atol=0.02)
    assert found.std() < 2e-3


def test_dots_at_random_and_on_a_square_grid() -> None:
    random = one_ink(np.random.default_rng(0).random((20000, 2)) * 500, 500, 500)
    # With one density for all it would be 0.465 and 0.243; a denser patch is taken for a higher density.
    assert random["evenness"] == pytest.approx(0.453, abs=0.01)
    assert random["evenness_deviation"] == pytest.approx(0.213, abs=0.01)
    square = one_ink(np.stack(np.mgrid[:30, :30], axis=-1).reshape(-1, 2) * 3.0 + 1.5, 90, 90)
    assert square == pytest.approx({"evenness": math.sqrt(math.sqrt(3) / 2), "evenness_deviation": 0}, abs=1e-6)


def test_evenness_matches_a_loop_where_dots_are_as_dense_everywhere() -> None:
    """With jittered dots far from the border, against distances one by one and the density of the whole canvas."""
    jittered = lattice(60, 60, 10) + np.random.default_rng(2).normal(0, 1, (3600, 2))
    width, height = 600, math.ceil(600 * math.sqrt(3) / 2)
    inside = ((jittered > 40) & (jittered < np.array([width, height]) - 40)).all(axis=1)
    nearest = [np.partition(np.hypot(*(jittered - dot).T), 1)[1] for dot in jittered[inside]]
    expected = np.array(nearest) / 10
    found = one_ink(jittered, width, height)
    assert found["evenness"] == pytest.approx(expected.mean(), abs=0.01)
    assert found["evenness_deviation"] == pytest.approx(expected.std(), abs=0.01)


def test_a_density_that_changes_is_not_uneven() -> None:
    x, y = np.random.default_rng(3).random((2, 4000)) * 100
    thrown = evenness.ratios(np.stack([x, y], axis=1), 100, 100).mean()
    # The same lattice, stretched more and more to the right alike in both directions, as by an analytic function.
    plane = lattice(80, 40, 1 / 40)
    bent = np.exp(plane[:, 0]) * np.exp(1j * (plane[:, 1] + 0.35))
    positions = np.stack([bent.real, bent.imag], axis=1) * 50
    found = evenness.ratios(positions, 400, 400)
    assert thrown < 0.5
    assert found.mean() == pytest.approx(0.98, abs=0.02)
    assert found.std() < 0.02


def test_dots_beside_a_gap_do_not_count_and_narrow_lines_do() -> None:
    dots = lattice(40, 40, 10)
    width, height = 400, math.ceil(10 * HEIGHT)
    wide = evenness.ratios(dots[(dots[:, 0] < 150) | (dots[:, 0] > 250)], width, height)
    assert wide.min() > 0.98
    narrow = evenness.ratios(dots[(dots[:, 0] < 180) | (dots[:, 0] > 200)], width, height)
    assert narrow.min() < 0.9
    assert len(narrow) > len(wide)


def test_inks_are_apart_and_their_dots_count_alike() -> None:
    even, random = lattice(40, 40, 10), np.random.default_rng(5).random((400, 2)) * [400, 10 * HEIGHT]
    width, height = 400, math.ceil(10 * HEIGHT)
    dots = np.column_stack([np.concatenate([even, random]), np.repeat([0, 1], [len(even), len(random)])])
    found = evenness.measures(dots, width, height)
    both = np.concatenate([evenness.ratios(even, width, height), evenness.ratios(random, width, height)])
    assert found == pytest.approx({"evenness": both.mean(), "evenness_deviation": both.std()})


@pytest.mark.parametrize(
    "positions",
    [np.empty((0, 2)), np.ones((1, 2)), np.ones((9, 2)), np.repeat(np.arange(30.0), 2).reshape(-1, 2), lattice(4, 4)],
    ids=["none", "one", "one place", "a line", "few"],
)
def test_too_few_dots_have_no_evenness(positions: Array) -> None:
    assert one_ink(positions, 40, 40) == {}


def test_dots_at_one_place_are_at_distance_0() -> None:
    assert one_ink(np.repeat(lattice(40, 40), 2, axis=0), 40, HEIGHT)["evenness"] == 0


def test_drawings_with_dots_have_evenness_and_good_stipplers_are_even() -> None:
    tone = np.full((128, 128), 0.8, np.float32)
    photo = Photo("grey", "", np.full((128, 128), 204, np.uint8), tone)
    names = ("lbg", "wvs", "wvs-squared", "sps", "ccvt", "mlbg", "floyd-steinberg", "threshold")
    dots = {method.name: method.draw(photo, 900).dots for method in METHODS if method.name in names}
    assert dots["floyd-steinberg"] is dots["threshold"] is None
    found = {name: evenness.measures(drawn, 128, 128) for name, drawn in dots.items() if drawn is not None}
    for name in ("lbg", "wvs", "wvs-squared"):
        assert found[name]["evenness"] > 0.8
        assert found[name]["evenness_deviation"] < 0.12
    assert all(0.2 < found[name]["evenness"] < 1 for name in ("sps", "ccvt", "mlbg"))
