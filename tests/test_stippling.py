"""Smooth parts: what must hold for their dots, whatever the tones, and flat greys as whole drawings."""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import Delaunay, cKDTree
from tests import oracles
from tests.soundness import check_picture

import graphstipple as gs
from graphstipple import stages
from graphstipple_eval import evenness

SEEDS = st.integers(0, 2**32 - 1)


class Case(NamedTuple):
    """Sites with grounds, and what is made of them."""

    size: tuple[int, int]
    sites: np.ndarray
    edges: np.ndarray
    tones: np.ndarray
    grounds: np.ndarray
    labels: np.ndarray
    areas: np.ndarray
    found: stages.Stippled

    @property
    def lacks(self) -> np.ndarray:
        return np.where(self.grounds == 2, 0.0, np.abs(self.tones.astype(np.float64) - self.grounds))

    @property
    def dots(self) -> np.ndarray:
        return (self.grounds != 2) & (self.found.labels != self.grounds)


def case(seed: int, n: int, width: int, height: int, noise: float, stippling: float) -> Case:  # noqa: PLR0917
    """Stipple a slope of tones with noise that grows across the canvas, on relaxed random sites."""
    random = np.random.default_rng(seed)
    sites = stages.relax(random.uniform(0.01, 0.99, (n, 2)) * [width, height], width, height, 2)
    edges = stages.triangulate(sites, width, height)
    across = sites / [width, height]
    tones = random.random() + (across - 0.5) @ random.uniform(-0.6, 0.6, 2) + noise * across[:, 0] * random.normal(0, 1, n)
    tones = np.clip(tones, 0, 1).astype(np.float32)
    grounds, areas = stages.grounds(sites, edges, tones, stippling), stages.cells(sites, width, height).areas
    labels = (random.random(n) < tones).astype(np.uint8)
    found = stages.stipple(sites, grounds, tones, width, height, labels=labels, areas=areas)
    return Case((width, height), sites, edges, tones, grounds, labels, areas, found)


CASES = st.builds(
    case,
    seed=SEEDS,
    n=st.integers(3, 400),
    width=st.integers(10, 50),
    height=st.integers(10, 50),
    noise=st.sampled_from([0.0, 0.03, 0.3]),
    stippling=st.sampled_from([0.3, 0.5, 1.0]),
)


@given(made=CASES)
def test_no_dot_is_beside_its_own_label(made):
    ends = np.concatenate([made.edges, made.edges[:, ::-1]])
    here, there = ends[made.dots[ends[:, 0]]].T
    assert (made.found.labels[there] == made.grounds[here]).all()
    assert not made.dots[there].any()


@given(made=CASES)
def test_structured_parts_stay_as_they_are(made):
    structured, found = made.grounds == 2, made.found
    np.testing.assert_array_equal(found.labels[structured], made.labels[structured])
    np.testing.assert_array_equal(found.places[structured], made.sites[structured])
    np.testing.assert_array_equal(found.areas[~made.dots], made.areas[~made.dots])
    # What the labels were in smooth parts does not matter.
    other = np.where(structured, made.labels, 1 - made.labels)
    again = stages.stipple(made.sites, made.grounds, made.tones, *made.size, labels=other, areas=made.areas)
    for one, same in zip(again, found, strict=True):
        np.testing.assert_array_equal(one, same)


@given(made=CASES)
def test_places_are_inside_and_turn_no_triangle_over(made):
    width, height = made.size
    places = made.found.places
    assert (places > 0).all()
    assert (places < [width, height]).all()
    if len(made.sites) < 4:
        return
    edges = {tuple(edge) for edge in oracles.sorted_edges(made.edges).tolist()}
    triangles = np.sort(Delaunay(made.sites).simplices, axis=1)
    joined = [all((t[a], t[b]) in edges for a, b in ((0, 1), (0, 2), (1, 2))) for t in triangles.tolist()]
    assert len(joined) < 40 or sum(joined) > len(joined) / 2

    def turns(points: np.ndarray) -> np.ndarray:
        (x0, y0), (x1, y1), (x2, y2) = points[triangles[joined]].transpose(1, 2, 0)
        return (x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0)

    assert (turns(places) * turns(made.sites) > 0).all()


@given(made=CASES)
def test_dots_carry_what_the_ground_lacks(made):
    """In every part of one ground that hangs together and has a dot; dots that are too small to draw hardly occur."""
    parts = oracles.components(made.edges, made.grounds)
    lacking, carried = (np.bincount(parts, values) for values in (made.lacks * made.areas, made.found.areas * made.dots))
    has_dots = np.bincount(parts, made.dots) > 0
    around = oracles.mean_around(oracles.adjacency(len(parts), made.edges), made.areas)
    one_too_small = oracles.LEAST_INK * np.array([around[parts == part].max() for part in range(len(lacking))])
    lost = (lacking - carried)[has_dots]
    assert (lost >= -1e-9).all()
    assert (lost <= (0.01 * lacking + one_too_small)[has_dots]).all()


@given(made=CASES)
def test_any_dots_give_a_sound_picture(made):
    found, (width, height) = made.found, made.size
    picture = stages.outline(made.sites, found.labels, width, height, areas=found.areas, places=found.places)
    check_picture(picture, width, height)
    x, y, radius = (picture.stipples[name].astype(np.float64) for name in ("x", "y", "radius"))
    assert (np.minimum(x, y) >= radius).all()
    assert (np.minimum(width - x, height - y) >= radius).all()
    for i, j in cKDTree(np.column_stack([x, y])).query_pairs(2 * radius.max(initial=0)) if len(x) else []:
        assert np.hypot(x[i] - x[j], y[i] - y[j]) > radius[i] + radius[j]


@functools.cache
def pipeline_sites(width: int, height: int) -> np.ndarray:
    """Make the sites that a drawing of a flat photo has."""
    kept = stages.lattice_labels(np.full((height, width), 0.3, np.float32), gs.Options(nodes_per_pixel=0.3))
    return stages.relax(kept.sites[kept.labels == 1], width, height)


@pytest.mark.parametrize("tones", [(0.0, 0.45), (0.1, 0.3), (0.35, 0.45), (0.9, 0.7), (0.55, 0.95)])
def test_dots_have_room_for_their_ink(tones):
    width, height = 90, 80
    sites = pipeline_sites(width, height)
    values = np.interp(sites @ [0.8, 0.6], [0, 0.8 * width + 0.6 * height], tones).astype(np.float32)
    grounds = stages.grounds(sites, stages.triangulate(sites, width, height), values, 1.0)
    np.testing.assert_array_equal(grounds, int(tones[0] > 0.5))
    labels, places, areas = stages.stipple(sites, grounds, values, width, height, labels=grounds)
    picture = stages.outline(sites, labels, width, height, areas=areas, places=places)
    dots = labels != grounds
    assert len(picture.stipples) == dots.sum() > 300
    assert (picture.stipples["ink"] == 1 - grounds[0]).all()
    centres = np.column_stack([picture.stipples["x"], picture.stipples["y"]])
    _, nearest = cKDTree(centres).query(places[dots])
    assert len(np.unique(nearest)) == dots.sum()
    wanted, radii = np.sqrt(areas[dots] / np.pi), picture.stipples["radius"][nearest]
    assert (radii <= wanted * (1 + 1e-5)).all()
    # A centre on a coarse grid may cost 3 %.
    assert (radii >= 0.97 * wanted).mean() >= 0.97
    assert (radii**2).sum() == pytest.approx((wanted**2).sum(), rel=0.01)


# Flat greys ----------------------------------------------------------------------------------------------------------------------

LEVELS = (3, 13, 20, 60, 100, 127, 128, 150, 200, 240, 242, 253)


@functools.cache
def flat(level: int) -> gs.Drawing:
    return gs.draw(np.full((160, 160), level, np.uint8))


@pytest.mark.parametrize("level", LEVELS)
def test_a_flat_grey_is_even_dots_of_its_tone(level):
    drawing = flat(level)
    assert drawing.rasterize().mean() / 255 == pytest.approx(level / 255, abs=0.01)
    assert (drawing.stipples["ink"] == int(level < 128)).all()
    sizes = np.bincount(drawing.graph.components)
    assert ((sizes >= 2) & (sizes <= 12)).sum() <= len(drawing.graph.sites) / 1000
    dots = np.column_stack([drawing.stipples[name].astype(np.float64) for name in ("x", "y", "ink")])
    found = evenness.measures(dots, 160, 160)
    if 13 <= level <= 242:
        assert found["evenness"] >= 0.8
        assert found["evenness_deviation"] <= 0.12


def test_lighter_greys_are_drawn_lighter():
    means = [flat(level).rasterize().mean() for level in LEVELS]
    assert (np.diff(means) > 0).all()


# Bad arguments -------------------------------------------------------------------------------------------------------------------

SITES = np.array([[2.0, 2.0], [8.0, 3.0], [3.0, 8.0], [8.0, 8.0], [5.0, 5.0]])
EDGES = stages.triangulate(SITES, 10, 10)
GIVEN = {"grounds": np.zeros(5, np.uint8), "tones": np.full(5, 0.3), "labels": np.zeros(5, np.uint8), "areas": np.full(5, 20.0)}
NOT_A_NUMBER = [0.3, 0.3, np.nan, 0.3, 0.3]


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        *(({name: values[1:]}, f"there are 4 {name} for 5 nodes") for name, values in GIVEN.items()),
        ({"grounds": [0, 3, 0, 0, 0]}, "the ground of node 1 is 3, but it must be 0, 1 or 2"),
        ({"labels": [0, 0, 2, 0, 0]}, r"the label of node 2 is 2, but it must be 0 \(black\) or 1 \(white\)"),
        ({"tones": NOT_A_NUMBER}, "the tone of node 2 is NaN, but it must be finite"),
        ({"areas": [20, -1, 20, 20, 20]}, "the cell area of node 1 is -1, but it must be at least 0"),
        ({"areas": [20, 20, 20, np.inf, 20]}, "the cell area of node 3 is inf, but it must be at least 0"),
    ],
    ids=range(9),
)
def test_stipple_refuses_what_breaks_its_rules(changes, match):
    given_ones = {**GIVEN, **changes}
    with pytest.raises(gs.InvalidInputError, match=match):
        stages.stipple(
            SITES, given_ones["grounds"], given_ones["tones"], 10, 10, labels=given_ones["labels"], areas=given_ones["areas"]
        )


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: stages.grounds(SITES, EDGES, [0.3] * 4), "there are 4 tones for 5 nodes"),
        (lambda: stages.grounds(SITES, EDGES, NOT_A_NUMBER), "the tone of node 2 is NaN, but it must be finite"),
        (lambda: stages.grounds(SITES, EDGES, [0.3] * 5, 1.5), r"stippling is 1\.5, but it must be between 0 and 1"),
        (lambda: stages.clean(EDGES, [0.3] * 4, [0] * 5), "there are 4 tones for 5 nodes"),
        (lambda: stages.clean(EDGES, NOT_A_NUMBER, [0] * 5), "the tone of node 2 is NaN, but it must be finite"),
        (lambda: stages.clean(EDGES, [0.3] * 5, [0, 0, 2, 0, 0]), "the label of node 2 is 2"),
        (lambda: stages.refine(EDGES, [0.3] * 5, [0] * 5, grounds=[0] * 4), "there are 4 grounds for 5 nodes"),
        (lambda: stages.refine(EDGES, NOT_A_NUMBER, [0] * 5), "the value of node 2 is NaN, but it must be finite"),
        (lambda: stages.refine(EDGES, [0.3] * 5, [0, 0, 2, 0, 0]), "the label of node 2 is 2"),
        (
            lambda: stages.refine(EDGES, [0.3] * 5, [0] * 5, areas=[1, 1, -1, 1, 1]),
            "the area of node 2 is -1, but it must be at least 0",
        ),
        (lambda: stages.outline(SITES, [0] * 5, 10, 10, places=SITES[1:]), "there are 4 places for 5 nodes"),
    ],
    ids=range(11),
)
def test_other_stages_refuse_what_breaks_their_rules(call, match):
    with pytest.raises(gs.InvalidInputError, match=match):
        call()
