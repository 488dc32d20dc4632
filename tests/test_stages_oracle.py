"""Every stage against its oracle, on random input and on crops of real photos."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from tests import oracles
from tests.support import on_every_photo, options_with, photo, photo_luma

import graphstipple as gs
from graphstipple import stages

SEEDS = st.integers(0, 2**32 - 1)
KINDS = ("hexagonal", "square")


def scattered(seed: int, n: int, width: float, height: float, how: str) -> np.ndarray:
    """`n` different sites inside the canvas: evenly, in clumps, or nearly all in one corner."""
    random = np.random.default_rng(seed)
    even = random.random((n, 2)) * [width, height]
    if how == "clumps":
        centres = random.random((3, 2)) * [width, height]
        even = centres[random.integers(0, 3, n)] + random.normal(0, 0.04 * min(width, height), (n, 2))
    if how == "corner":
        even[1:] *= 0.05
    return np.clip(even, [1e-3, 1e-3], [width - 1e-3, height - 1e-3]) + random.random((n, 2)) * 1e-4


HOWS = st.sampled_from(["evenly", "clumps", "corner"])


# Lattice -------------------------------------------------------------------------------------------------------------------------


@given(
    width=st.integers(3, 60),
    height=st.integers(3, 60),
    density=st.floats(0.2, 4.0),
    kind=st.sampled_from(KINDS),
)
def test_lattice(width, height, density, kind):
    found, (sites, edges) = stages.lattice(width, height, density, kind), oracles.lattice(width, height, density, kind)
    np.testing.assert_allclose(found.sites, sites, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(oracles.sorted_edges(found.edges), edges)
    assert found.sites.dtype == np.float64
    assert found.edges.dtype == np.uint32
    assert (found.edges[:, 0] < found.edges[:, 1]).all()


# Owners and cells ----------------------------------------------------------------------------------------------------------------


@given(seed=SEEDS, n=st.integers(1, 200), width=st.integers(1, 40), height=st.integers(1, 40), how=HOWS, s=st.integers(1, 4))
def test_owners(seed, n, width, height, how, s):  # noqa: PLR0917
    sites = scattered(seed, n, width, height, how)
    found = stages.owners(sites, width, height, s)
    assert found.shape == (height * s, width * s)
    assert found.dtype == np.uint32
    np.testing.assert_array_equal(found, oracles.owners(sites, width, height, s))


@given(seed=SEEDS, n=st.integers(1, 60), s=st.sampled_from([1, 2, 4]))
def test_owners_give_ties_to_the_lowest_index(seed, n, s):
    # Halves of pixels, each at most once: every distance is exact and many are equal.
    halves = np.random.default_rng(seed).choice(23 * 17, n, replace=False)
    sites = np.stack([halves % 23 + 1, halves // 23 + 1], axis=1) / 2.0
    np.testing.assert_array_equal(stages.owners(sites, 12, 9, s), oracles.owners(sites, 12, 9, s))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("density", [0.05, 0.3, 1.0, 2.5])
def test_owners_on_a_lattice_are_nearest(kind, density):
    # Here many samples lie on the bisectors up to rounding, so distances are compared and not indices.
    width, height, s = 50, 31, 2
    sites = stages.lattice(width, height, density, kind).sites
    found, expected = stages.owners(sites, width, height, s), oracles.owners(sites, width, height, s)
    distances = [oracles.squared_distances(sites, width, height, owner, s) for owner in (found, expected)]
    np.testing.assert_allclose(*distances, rtol=0, atol=1e-9)


@given(seed=SEEDS, n=st.integers(1, 300), how=HOWS, s=st.integers(1, 3))
def test_cells(seed, n, how, s):
    width, height = 23, 17
    sites, field = scattered(seed, n, width, height, how), np.random.default_rng(seed).random((height, width), np.float32)
    found = stages.cells(sites, width, height, field, s)
    expected = oracles.cells(oracles.owners(sites, width, height, s), sites, field, s)
    np.testing.assert_array_equal(found.counts, expected.counts)
    np.testing.assert_allclose(found.areas, expected.areas, rtol=1e-6)
    np.testing.assert_allclose(found.centroids, expected.centroids, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found.means, expected.means, rtol=0, atol=1e-6)
    assert found.counts.sum() == width * height * s**2


@given(seed=SEEDS, n=st.integers(1, 150), how=HOWS, steps=st.integers(0, 3))
def test_relax(seed, n, how, steps):
    sites = scattered(seed, n, 31, 22, how)
    np.testing.assert_allclose(stages.relax(sites, 31, 22, steps), oracles.relax(sites, 31, 22, steps), rtol=0, atol=1e-6)


# Diffusion -----------------------------------------------------------------------------------------------------------------------


@given(
    seed=SEEDS,
    kind=st.sampled_from([*KINDS, "delaunay"]),
    density=st.floats(0.1, 3.0),
    alpha=st.one_of(st.sampled_from(["tonal", "dynamic"]), st.floats(0.0, 1.0)),
    by_area=st.booleans(),
    k1=st.floats(0.0, 20.0),
    k2=st.floats(0.0, 3.0),
    shading=st.floats(0.0, 1.0),
    base=st.floats(0.0, 1.0),
    detail_gain=st.floats(0.0, 12.0),
    hops=st.integers(1, 3),
    order=st.sampled_from(["rows", "global"]),
)
def test_diffuse_on_noise(seed, kind, density, alpha, by_area, k1, k2, shading, base, detail_gain, hops, order):  # noqa: PLR0917
    if kind == "delaunay":
        sites = scattered(seed, int(30 + 300 * density), 40, 25, "evenly")
        edges = oracles.delaunay_edges(sites, 40, 25)
    else:
        sites, edges = oracles.lattice(30, 20, density, kind)
    random = np.random.default_rng(seed)
    # Tone that leans to one side and reaches both ends, as saturated photos do; noise keeps near ties away.
    values = np.clip(random.random(len(sites)) ** random.uniform(0.3, 3), 0, 1).astype(np.float32)
    areas = random.random(len(sites)) ** 3 if by_area else None
    tuning = {"k1": k1, "k2": k2, "shading": shading, "base": base, "detail_gain": detail_gain, "hops": hops}
    how = {"areas": areas, "alpha": alpha, "order": order, **tuning}
    found = stages.diffuse(sites, edges.astype(np.uint32), values, **how)
    assert found.dtype == np.uint8
    np.testing.assert_array_equal(found, oracles.diffuse(sites, edges, values, **how))


@pytest.mark.parametrize(("order", "alpha"), [("rows", "tonal"), ("global", 1.0)])
@pytest.mark.parametrize("kind", [*KINDS, "delaunay"])
def test_diffuse_many_nodes(kind, order, alpha):
    """Four bands; on the Delaunay graph, whose nodes are in no order, edges join all of them."""
    if kind == "delaunay":
        sites = scattered(3, 70_000, 300, 235, "evenly")
        edges = oracles.sorted_edges(stages.triangulate(sites, 300, 235))
    else:
        sites, edges = oracles.lattice(300, 235, 1.0, kind)
    assert len(oracles.bands(len(sites))) == 4
    random = np.random.default_rng(4)
    values, areas = random.random(len(sites), np.float32), 0.5 + random.random(len(sites))
    how = {"areas": areas, "alpha": alpha, "order": order}
    found = stages.diffuse(sites, edges.astype(np.uint32), values, **how)
    np.testing.assert_array_equal(found, oracles.diffuse(sites, edges, values, **how))


@on_every_photo
@pytest.mark.parametrize("alpha", ["tonal", "dynamic", 1.0])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("density", [0.3, 1.7])
@pytest.mark.parametrize("order", ["rows", "global"])
def test_diffuse_on_photos(name, alpha, kind, density, order):
    width, height = 64, 48
    sites, edges = oracles.lattice(width, height, density, kind)
    values = stages.cells(sites, width, height, photo_luma(name, width, height)).means
    # Equal values side by side tie up to rounding, and a tie broken the other way changes all that follows: a thousandth of
    # noise takes the ties away.
    values = (0.999 * values + 0.001 * np.random.default_rng(0).random(len(values))).astype(np.float32)
    found = stages.diffuse(sites, edges.astype(np.uint32), values, alpha=alpha, order=order)
    np.testing.assert_array_equal(found, oracles.diffuse(sites, edges, values, alpha=alpha, order=order))


@given(n=st.integers(1, 80), eighths=st.integers(0, 8), alpha=st.sampled_from([0.0, 0.5, 1.0]))
def test_diffuse_breaks_exact_ties_by_index(n, eighths, alpha):
    # On a path each node has one or two neighbours at distance 1, and all numbers stay short binary fractions: ties are exact.
    sites = np.stack([np.arange(n) + 0.5, np.full(n, 0.5)], axis=1)
    edges = np.stack([np.arange(n - 1), np.arange(1, n)], axis=1).astype(np.uint32)
    values = np.full(n, eighths / 8, np.float32)
    found = stages.diffuse(sites, edges, values, alpha=alpha, order="global")
    np.testing.assert_array_equal(found, oracles.diffuse(sites, edges, values, alpha=alpha, order="global"))


def test_diffuse_between_nodes_hundreds_of_pixels_apart():
    sites = scattered(5, 60, 30_000, 20_000, "evenly")
    edges, values = oracles.delaunay_edges(sites, 30_000, 20_000), np.random.default_rng(5).random(60, np.float32)
    found = stages.diffuse(sites, edges.astype(np.uint32), values, alpha=1.0, order="global")
    np.testing.assert_array_equal(found, oracles.diffuse(sites, edges, values, alpha=1.0, order="global"))


def test_diffuse_without_edges_is_a_threshold():
    values = np.array([0.0, 0.49, 0.5, 1.0], np.float32)
    found = stages.diffuse(scattered(0, 4, 9, 9, "evenly"), np.zeros((0, 2), np.uint32), values)
    np.testing.assert_array_equal(found, [0, 0, 1, 1])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("density", [0.5, 1.5])
@pytest.mark.parametrize("order", ["rows", "global"])
def test_lattice_labels(kind, density, order):
    """The tall lattice has several bands."""
    random = np.random.default_rng(2)
    for width, height in [(40, 30), (9, 330)]:
        importance = random.random((height, width), np.float32) ** 2
        how = options_with(lattice=kind, density=density, importance_order=order)
        sites, labels, factor = stages.lattice_labels(importance, how)
        assert factor == 1
        expected, edges = oracles.lattice(width, height, density, kind)
        np.testing.assert_allclose(sites, expected, rtol=0, atol=1e-9)
        # How fine the samples are is the pipeline's choice, but some whole number a pixel must explain the labels.
        diffused = oracles.diffuse_in_rows if order == "rows" else functools.partial(oracles.diffuse, order="global")
        grids = (stages.cells(sites, width, height, importance, samples).means for samples in (1, 2, 3, 4, 6, 8))
        assert any(np.array_equal(diffused(sites, edges, means, alpha=1.0), labels) for means in grids)


@given(
    seed=SEEDS,
    kind=st.sampled_from(KINDS),
    alpha=st.one_of(st.sampled_from(["tonal", "dynamic"]), st.floats(0.0, 1.0)),
    k1=st.floats(0.0, 1000.0),
    k2=st.floats(0.0, 1000.0),
    shading=st.floats(0.0, 1.0),
    base=st.floats(0.0, 1.0),
    detail_gain=st.floats(0.0, 12.0),
    hops=st.integers(1, 3),
)
def test_lattice_labels_in_rows(seed, kind, alpha, k1, k2, shading, base, detail_gain, hops):  # noqa: PLR0917
    importance = np.random.default_rng(seed).random((15, 20), np.float32)
    tuning = {"k1": k1, "k2": k2, "shading": shading, "base": base, "detail_gain": detail_gain, "hops": hops}
    sites, labels, _ = stages.lattice_labels(importance, options_with(lattice=kind, density=1.0, importance_alpha=alpha, **tuning))
    _, edges = oracles.lattice(20, 15, 1.0, kind)
    means = stages.cells(sites, 20, 15, importance, stages.samples_per_pixel(1.0)).means
    np.testing.assert_array_equal(oracles.diffuse_in_rows(sites, edges, means, alpha=alpha, **tuning), labels)


# Triangulation -------------------------------------------------------------------------------------------------------------------


@given(seed=SEEDS, n=st.integers(3, 300), width=st.integers(2, 80), height=st.integers(2, 80), how=HOWS)
def test_triangulate(seed, n, width, height, how):
    sites = scattered(seed, n, width, height, how)
    found = stages.triangulate(sites, width, height)
    assert found.dtype == np.uint32
    assert (found[:, 0] < found[:, 1]).all()
    np.testing.assert_array_equal(oracles.sorted_edges(found), oracles.delaunay_edges(sites, width, height))


@on_every_photo
def test_triangulate_relaxed_sites_of_a_photo(name):
    width, height = 120, 90
    sites, labels, _ = stages.lattice_labels(np.sqrt(photo_luma(name, width, height)) * 0.5, options_with(density=1.0))
    sites = stages.relax(sites[labels == 1], width, height, 2, 3)
    # Centroids of samples often lie on one circle exactly; a shift far below a sample leaves one right answer.
    sites = sites + np.random.default_rng(0).uniform(-1e-4, 1e-4, sites.shape)
    found = oracles.sorted_edges(stages.triangulate(sites, width, height))
    np.testing.assert_array_equal(found, oracles.delaunay_edges(sites, width, height))


def check_edges_up_to_ties(found: np.ndarray, sites: np.ndarray, width: int, height: int) -> None:
    """Check for the oracle's edges, but for pairs of cells that meet in a corner, where four sites or more lie on one circle."""
    edges, expected = (
        {tuple(edge) for edge in oracles.sorted_edges(e).tolist()} for e in (found, oracles.delaunay_edges(sites, width, height))
    )
    for pair in edges ^ expected:
        assert oracles.shared_edge(sites, pair, width, height) < 1e-6


@pytest.mark.parametrize("kind", KINDS)
def test_triangulate_a_lattice_finds_its_edges(kind):
    sites, edges = oracles.lattice(20, 14, 1.0, kind)
    found = stages.triangulate(sites, 20, 14)
    assert {tuple(edge) for edge in edges.tolist()} <= {tuple(edge) for edge in oracles.sorted_edges(found).tolist()}
    check_edges_up_to_ties(found, sites, 20, 14)


@pytest.mark.parametrize(
    ("sites", "expected"),
    [
        ([[3, 4]], []),
        ([[3, 4], [8, 2]], [[0, 1]]),
        ([[1, 2], [5, 2], [3, 2], [9, 2]], [[0, 2], [1, 2], [1, 3]]),
        ([[1, 1], [2, 2], [3, 3], [7, 7]], [[0, 1], [1, 2], [2, 3]]),
        ([[5, 1], [5, 6]], [[0, 1]]),
    ],
    ids=["one", "two", "a row", "a diagonal", "a column"],
)
def test_triangulate_few_or_collinear_sites(sites, expected):
    found = oracles.sorted_edges(stages.triangulate(np.array(sites, np.float64), 10, 8))
    np.testing.assert_array_equal(found, np.array(expected).reshape(-1, 2))


def test_many_collinear_sites():
    # spade alone is quadratic on collinear input: with it, this would run for most of an hour.
    n = 200_000
    sites = np.stack([np.arange(n) + 0.5, np.full(n, 0.5)], axis=1)
    assert len(stages.triangulate(sites, n, 1)) == n - 1


# Components ----------------------------------------------------------------------------------------------------------------------


@given(seed=SEEDS, n=st.integers(1, 400), share=st.floats(0.0, 1.0))
def test_components(seed, n, share):
    sites, random = scattered(seed, max(n, 3), 50, 40, "evenly"), np.random.default_rng(seed)
    edges, labels = oracles.delaunay_edges(sites, 50, 40), (random.random(len(sites)) < share).astype(np.uint8)
    found = stages.components(edges.astype(np.uint32), labels)
    assert found.dtype == np.uint32
    np.testing.assert_array_equal(found, oracles.components(edges, labels))


def test_components_of_isolated_nodes():
    np.testing.assert_array_equal(stages.components(np.zeros((0, 2), np.uint32), np.zeros(3, np.uint8)), [0, 1, 2])


# Saliency ------------------------------------------------------------------------------------------------------------------------


def check_saliency(found: np.ndarray, gray: np.ndarray) -> None:
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, oracles.saliency(gray))


@on_every_photo
def test_saliency_is_opencvs(name):
    gray = np.rint(photo_luma(name) * 255).astype(np.uint8)
    check_saliency(gs._core.saliency(gray.astype(np.float32) / 255), gray)
    check_saliency(gs.saliency(gray), gray)


def test_saliency_where_sums_are_rounded():
    # Nearly white, so that the sums of a megapixel exceed 2^24 by far.
    y, x = np.mgrid[:900, :1200]
    gray = (255 - (x * x + y * 3) % 7 - ((x // 97 + y // 61) % 2) * 4).astype(np.uint8)
    check_saliency(gs._core.saliency(gray.astype(np.float32) / 255), gray)


@example(seed=0, width=1, height=40, flat=False)
@example(seed=0, width=40, height=1, flat=False)
@example(seed=0, width=1, height=1, flat=True)
@given(seed=SEEDS, width=st.integers(1, 90), height=st.integers(1, 90), flat=st.booleans())
def test_saliency_of_noise_and_of_small_images(seed, width, height, flat):
    random = np.random.default_rng(seed)
    gray = np.full((height, width), random.integers(256)) if flat else random.integers(0, 256, (height, width))
    gray = gray.astype(np.uint8)
    check_saliency(gs._core.saliency(gray.astype(np.float32) / 255), gray)


REFINEMENTS = st.fixed_dictionaries(
    {
        "sweeps": st.integers(0, 8),
        "crispness": st.floats(0, 4),
        "cohesion": st.floats(0, 2),
        "mean": st.none() | st.floats(0, 1),
        "tone_tolerance": st.just(0.01),
    }
)


@given(
    seed=SEEDS, n=st.integers(3, 400), low=st.floats(0.0, 0.6), smooth=st.sampled_from([None, 0, 0.4, 1]), parameters=REFINEMENTS
)
def test_refine(seed, n, low, smooth, parameters):
    sites, random = scattered(seed, n, 50, 40, "evenly"), np.random.default_rng(seed)
    edges = oracles.delaunay_edges(sites, 50, 40).astype(np.uint32)
    tones = (low + 0.4 * random.random(len(sites))).astype(np.float32)
    labels, areas = (random.random(len(sites)) < tones).astype(np.uint8), random.random(len(sites))
    grounds = None if smooth is None else np.where(random.random(len(sites)) < smooth, labels, oracles.STRUCTURED)
    found = stages.refine(edges, tones, labels, areas=areas, grounds=grounds, **parameters)
    expected, shift = oracles.refine(edges, tones, labels, areas, parameters, grounds=grounds)
    np.testing.assert_array_equal(found.labels, expected)
    assert found.shift == pytest.approx(shift, abs=1e-9)


def test_refinement_needs_one_of_each_a_node():
    with pytest.raises(gs.InvalidInputError, match="there are 1 values for 2 nodes"):
        stages.refine([[0, 1]], [0.5], [1, 0])
    with pytest.raises(gs.InvalidInputError, match=r"the mean is 1\.5, but it must be between 0 and 1"):
        stages.refine([[0, 1]], [0.5, 0.5], [1, 0], mean=1.5)


@given(seed=SEEDS, n=st.integers(3, 600), low=st.floats(0.0, 0.6), most=st.integers(0, 12))
def test_split(seed, n, low, most):
    sites, random = scattered(seed, n, 50, 40, "evenly"), np.random.default_rng(seed)
    edges = oracles.delaunay_edges(sites, 50, 40).astype(np.uint32)
    tones = (low + 0.4 * random.random(len(sites))).astype(np.float32)
    labels = (random.random(len(sites)) < tones).astype(np.uint8)
    found = stages.split(edges, tones, labels, most)
    np.testing.assert_array_equal(found, oracles.split(edges, tones, labels, most))
    assert found.sum() == labels.sum()


# Smooth parts --------------------------------------------------------------------------------------------------------------------


def sloped(seed: int, sites: np.ndarray, noise: float) -> np.ndarray:
    """Tones of a slope, with noise that grows from left to right."""
    random = np.random.default_rng(seed)
    across = sites / sites.max(axis=0)
    slope = random.random() + (across - 0.5) @ random.uniform(-0.7, 0.7, 2)
    return np.clip(slope + noise * across[:, 0] * random.normal(0, 1, len(sites)), 0, 1).astype(np.float32)


@given(seed=SEEDS, n=st.integers(3, 300), noise=st.sampled_from([0.0, 0.02, 0.1, 0.4]), how=HOWS)
@pytest.mark.parametrize("stippling", [0, 0.05, 0.3, 0.5, 0.9, 1])
def test_grounds(stippling, seed, n, noise, how):
    sites = scattered(seed, n, 50, 40, how)
    edges, tones = oracles.delaunay_edges(sites, 50, 40).astype(np.uint32), sloped(seed, sites, noise)
    expected, margin = oracles.grounds(sites, edges, tones, stippling)
    # The Rust stage rounds means to 32 bits.
    assume(margin > 1e-6)
    found = stages.grounds(sites, edges, tones, stippling)
    assert found.dtype == np.uint8
    np.testing.assert_array_equal(found, expected)


def test_grounds_on_both_sides_of_an_edge():
    sites = scattered(3, 900, 60, 40, "evenly")
    edges = stages.triangulate(sites, 60, 40)
    tones = np.where(sites[:, 0] < 30, 0.2, 0.7).astype(np.float32)
    found, (expected, margin) = stages.grounds(sites, edges, tones, 0.5), oracles.grounds(sites, edges, tones, 0.5)
    assert margin > 1e-6
    np.testing.assert_array_equal(found, expected)
    assert (np.bincount(found, minlength=3) > 90).all()


@given(seed=SEEDS, n=st.integers(3, 400), white=st.booleans(), pure=st.floats(0.3, 1.0), share=st.floats(0.0, 0.5))
def test_clean(seed, n, white, pure, share):
    sites, random = scattered(seed, n, 50, 40, "evenly"), np.random.default_rng(seed)
    edges = oracles.delaunay_edges(sites, 50, 40).astype(np.uint32)
    nearly_black = oracles.PURE * random.choice([0.0, 0.9, 1.1], n, p=[0.6, 0.3, 0.1])
    tones = np.where(random.random(n) < pure, nearly_black, random.uniform(0.1, 0.9, n))
    labels = (tones >= 0.5) ^ (random.random(n) < share)
    tones, labels = (np.abs(int(white) - values).astype(kind) for values, kind in ((tones, np.float32), (labels, np.uint8)))
    found = stages.clean(edges, tones, labels)
    assert found.dtype == np.uint8
    np.testing.assert_array_equal(found, oracles.clean(edges, tones, labels))


@pytest.mark.parametrize("first", [0, 1])
def test_clean_where_specks_of_both_labels_meet(first):
    tones = np.array([first, 1 - first], np.float32)
    expected = oracles.clean([[0, 1]], tones, 1 - tones)
    np.testing.assert_array_equal(expected, tones)
    np.testing.assert_array_equal(stages.clean([[0, 1]], tones, (1 - tones).astype(np.uint8)), expected)


def stippling_of(seed: int, n: int, how: str, noise: float, ground: str) -> tuple[np.ndarray, ...]:
    """Sites, grounds, tones, labels and areas. On islands of a few nodes many dots are too small to draw."""
    random = np.random.default_rng(seed)
    sites = scattered(seed, n, 50, 40, how)
    if how == "evenly":
        # Centroids of samples often lie on one circle exactly.
        sites = np.clip(stages.relax(sites, 50, 40) + random.uniform(-1e-2, 1e-2, sites.shape), 1e-3, [50 - 1e-3, 40 - 1e-3])
    tones = sloped(seed, sites, noise)
    grounds = stages.grounds(sites, stages.triangulate(sites, 50, 40), tones, 1.0 if ground != "found" else 0.5)
    if ground == "patch":
        grounds[np.linalg.norm(sites - sites[0], axis=1) < random.uniform(3, 15)] = oracles.STRUCTURED
    labels = (random.random(n) < tones).astype(np.uint8)
    if ground == "islands":
        tones, labels = 0.1 * tones, 0 * labels
        grounds = np.where(random.random(n) < 0.6, oracles.STRUCTURED, labels)
    return sites, grounds, tones, labels, stages.cells(sites, 50, 40).areas


@given(
    seed=SEEDS,
    n=st.integers(3, 300),
    how=st.sampled_from(["evenly", "corner"]),
    noise=st.sampled_from([0.0, 0.02, 0.1]),
    ground=st.sampled_from(["all", "patch", "found", "islands"]),
)
def test_stipple(seed, n, how, noise, ground):
    sites, grounds, tones, labels, areas = stippling_of(seed, n, how, noise, ground)
    found = stages.stipple(sites, grounds, tones, 50, 40, labels=labels, areas=areas)
    expected = oracles.stipple(sites, grounds, tones, labels, areas, 50, 40)
    np.testing.assert_allclose(found.places, expected.places, rtol=0, atol=1e-6)
    dots = np.flatnonzero((grounds != oracles.STRUCTURED) & (found.labels != grounds))
    # All are chosen ones; what they lack of the ink is that of those too small to draw.
    is_drawn = np.isin(expected.nodes, dots)
    assert is_drawn.sum() == len(dots)
    lost = expected.lacking - found.areas[dots].sum()
    assert -1e-9 <= lost <= expected.least[~is_drawn].sum() + 1e-9
    np.testing.assert_array_equal(found.labels, expected.labels)
    np.testing.assert_allclose(found.areas, expected.areas, rtol=0, atol=1e-6)


def test_a_dot_that_has_handed_on_is_full_however_sums_are_rounded():
    sites = np.array([[4.58, 3.32], [1.86, 5.21], [3.48, 3.31], [1.77, 1.74], [3.15, 5.29], [1.14, 2.27]])
    black, tones, areas = np.zeros(6, np.uint8), np.full(6, 0.3), np.full(6, 6.0)
    for moved in (0, 1e-13):
        found = stages.stipple(sites + moved, black, tones, 6, 6, labels=black, areas=areas)
        expected = oracles.stipple(sites + moved, black, tones, black, areas, 6, 6)
        np.testing.assert_allclose(found.areas, expected.areas, rtol=0, atol=1e-6)


# Bad arguments -------------------------------------------------------------------------------------------------------------------

GOOD = np.array([[1.0, 1.0], [5.0, 2.0], [3.0, 6.0]])
NO_EDGES = np.zeros((0, 2), np.uint32)


@pytest.mark.parametrize(
    "call",
    [
        lambda: stages.triangulate(np.concatenate([GOOD, GOOD[1:2]]), 8, 8),
        lambda: stages.triangulate([[1.0, 1.0], [np.nan, 2.0], [3.0, 6.0]], 8, 8),
        lambda: stages.triangulate(np.zeros((3, 3)), 8, 8),
        lambda: stages.owners(GOOD, 0, 8),
        lambda: stages.owners(np.zeros((0, 2)), 8, 8),
        lambda: stages.owners([[np.inf, 0.0]], 8, 8),
        lambda: stages.cells(GOOD, 8, 8, np.zeros((7, 8), np.float32)),
        lambda: stages.cells(GOOD, 8, 8, np.full((8, 8), np.nan, np.float32)),
        lambda: stages.diffuse(GOOD, [[0, 3]], [0.1, 0.2, 0.3]),
        lambda: stages.diffuse(GOOD, NO_EDGES, [0.1, 0.2]),
        lambda: stages.diffuse(GOOD, NO_EDGES, [0.1, np.nan, 0.2]),
        lambda: stages.diffuse(GOOD, NO_EDGES, [0.1, 0.2, 0.3], alpha="dynamical"),
        lambda: stages.diffuse(GOOD, NO_EDGES, [0.1, 0.2, 0.3], k1=-1),
        lambda: stages.diffuse(GOOD, NO_EDGES, [0.1, 0.2, 0.3], hops=0),
        lambda: stages.split([[0, 1]], [0.1, 0.2, 0.3], [0, 1]),
        lambda: stages.split([[0, 1]], [0.1, 0.2], [0, 2]),
        lambda: stages.split([[0, 2]], [0.1, 0.2], [0, 1]),
        lambda: stages.split([[0, 1]], [0.1, 0.2], [0, 1], most=13),
        lambda: stages.components([[0, 9]], np.zeros(3, np.uint8)),
        lambda: stages.lattice(10, 10, np.nan),
        lambda: stages.lattice(10, 10, 0.0),
        lambda: stages.lattice(0, 10),
        lambda: stages.lattice(10, 10, 1.0, "triangular"),
        lambda: stages.relax(GOOD, 8, 8, -1),
    ],
    ids=range(24),
)
def test_bad_arguments_raise_one_clear_sentence(call):
    with pytest.raises(gs.GraphStippleError) as caught:
        call()
    message = str(caught.value)
    assert len(message) > 10
    assert "\n" not in message
    assert "panicked" not in message


# The pipeline's own data ---------------------------------------------------------------------------------------------------------


@on_every_photo
@pytest.mark.parametrize(
    "changes",
    [
        {"density": 1.0, "stippling": 0},
        {"density": 1.0},
        {"density": 0.4, "relax": 3},
        {"nodes_per_pixel": 0.3, "lattice": "square"},
        {"stippling": 1},
    ],
    ids=range(5),
)
def test_a_drawing_is_what_the_stages_say(name, changes):
    width, height = 80, 60
    drawing = gs.draw(photo(name, width, height), options=options_with(**changes))
    graph = drawing.graph
    np.testing.assert_array_equal(oracles.components(graph.edges, graph.labels), graph.components)
    check_edges_up_to_ties(graph.edges, graph.sites, width, height)
    # Equal tones tie up to rounding, so the diffusion is compared with the Rust stage here and with the oracle above.
    samples = stages.samples_per_pixel(drawing.stats["density"])
    areas = stages.cells(graph.sites, width, height, samples_per_pixel=samples).areas
    tone, saliency = photo_luma(name, width, height), gs.saliency(photo(name, width, height))
    plain = stages.cells(graph.sites, width, height, tone, samples).means
    grounds = stages.grounds(graph.sites, graph.edges, plain, drawing.options.stippling)
    structured = grounds == oracles.STRUCTURED
    drawn = np.where(structured, graph.tone, grounds).astype(np.float32)
    diffused = np.where(structured, stages.diffuse(graph.sites, graph.edges, drawn, areas=areas), grounds)
    mean = tone.mean(dtype=np.float64)
    if not structured.all():
        mean = np.average(plain[structured], weights=areas[structured]) if structured.any() else None
    refined, shift = stages.refine(graph.edges, drawn, diffused, areas=areas, grounds=grounds, mean=mean)
    assert shift == pytest.approx(drawing.stats["tone_shift"], abs=1e-6)
    labels = stages.split(graph.edges, drawn, refined)
    np.testing.assert_array_equal(oracles.split(graph.edges, drawn, refined, 4), labels)
    assert labels.sum() == refined.sum()
    if drawing.options.stippling > 0:
        labels = stages.clean(graph.edges, plain, labels)
        labels = stages.stipple(graph.sites, grounds, plain, width, height, labels=labels, areas=areas).labels
    np.testing.assert_array_equal(labels, graph.labels)
    # The refinement is what brings the mean of structured parts to that of the photo there.
    if structured.any():
        assert abs(np.average(refined[structured], weights=areas[structured]) - mean) <= 2 * drawing.options.tone_tolerance
    np.testing.assert_array_equal(drawing.importance, stages.importance(tone, saliency, drawing.options))
    means = stages.cells(graph.sites, width, height, stages.emphasize(tone, drawing.options), samples).means
    np.testing.assert_array_equal(means, graph.tone)


# Emphasis and importance ---------------------------------------------------------------------------------------------------------


@on_every_photo
@pytest.mark.parametrize("nodes_per_pixel", [0.05, 0.3, 1.0])
def test_emphasis_and_importance(name, nodes_per_pixel):
    tone = photo_luma(name, 90, 70)
    how = gs.Options(nodes_per_pixel=nodes_per_pixel, sharpen=2.0, local_contrast=1.0, detail=0.6, floor=0.2, midtones=0.5)
    spacing = np.sqrt(2 / np.sqrt(3) / nodes_per_pixel)
    emphasized = stages.emphasize(tone, how)
    np.testing.assert_allclose(emphasized, oracles.emphasize(tone, spacing, 2.0, 1.0), rtol=0, atol=2e-5)
    map_ = gs.saliency(photo(name, 90, 70))
    shares = {"detail": 0.6, "floor": 0.2, "midtones": 0.5}
    for is_saliency in (True, False):
        found = stages.importance(tone, map_, how, is_saliency=is_saliency)
        expected = oracles.importance(tone, map_, spacing, shares, emphasized, is_saliency=is_saliency)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-4)
