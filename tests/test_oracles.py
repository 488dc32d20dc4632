"""The oracles against themselves: two ways to the same answer each, so that an oracle's slip is not taken for the code's."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from tests import oracles
from tests.support import photo_luma


def test_owners_match_brute_force_with_ties_to_the_lowest_index():
    random = np.random.default_rng(1)
    for n in (1, 2, 3, 40):
        sites = random.integers(0, 12, (n, 2)) / 2  # Halves: distances are exact, and ties are many.
        points = oracles.sample_points(6, 5, 2)
        brute = ((points[:, None] - sites[None]) ** 2).sum(axis=2).argmin(axis=1).reshape(10, 12)
        assert (((found := oracles.owners(sites, 6, 5, 2)) == brute) | (n > 8)).all()
        # Above 8 sites more than 8 can coincide in distance, but never in the distance itself.
        assert (oracles.squared_distances(sites, 6, 5, found, 2) == oracles.squared_distances(sites, 6, 5, brute, 2)).all()


def test_delaunay_with_mirrors_is_the_graph_of_neighbouring_cells():
    for seed in range(10):
        sites = np.random.default_rng(seed).random((60, 2)) * [30, 20]
        pairs = itertools.combinations(range(60), 2)
        expected = oracles.sorted_edges([pair for pair in pairs if oracles.shared_edge(sites, pair, 30, 20) > 1e-9])
        np.testing.assert_array_equal(oracles.delaunay_edges(sites, 30, 20), expected)


@pytest.mark.parametrize("kind", ["hexagonal", "square"])
@pytest.mark.parametrize("density", [0.1, 1.0, 3.0])
def test_the_lattice_has_its_density_and_equal_edges(kind, density):
    sites, edges = oracles.lattice(60, 50, density, kind)
    assert len(sites) == pytest.approx(60 * 50 * density, rel=0.06)
    lengths = np.linalg.norm(sites[edges[:, 0]] - sites[edges[:, 1]], axis=1)
    assert np.ptp(lengths) < 1e-9
    assert np.bincount(edges.ravel()).max() == (4 if kind == "square" else 6)


def test_diffusion_with_alpha_0_is_a_threshold_and_with_alpha_1_keeps_the_sum():
    sites, edges = oracles.lattice(30, 20)
    values = np.random.default_rng(3).random(len(sites)).astype(np.float32)
    np.testing.assert_array_equal(oracles.diffuse(sites, edges, values, alpha=0.0), values >= 0.5)
    assert abs(oracles.diffuse(sites, edges, values, alpha=1.0, order="global").mean() - values.mean()) < 0.03


def test_diffusion_by_a_scan_instead_of_a_heap():
    """The definition word for word: look at every unlabelled node, take the one farthest from 0.5."""
    sites, edges = oracles.lattice(14, 12)
    values = photo_luma("camera", 14, 12).ravel()[: len(sites)]
    values = np.pad(values, (0, len(sites) - len(values))) * np.float32(0.9) + np.float32(0.1) * np.random.default_rng(0).random(
        len(sites), np.float32
    )
    n, rows = len(sites), oracles.adjacency(len(sites), edges)
    start = values.astype(np.float64)
    now, labels = start.copy(), np.full(n, -1)
    while (labels < 0).any():
        i = min((j for j in range(n) if labels[j] < 0), key=lambda j: (-abs(now[j] - 0.5), j))
        labels[i] = now[i] >= 0.5
        to = np.array([j for j in rows[i] if labels[j] < 0], dtype=int)
        if not len(to):
            continue
        mean = start[[i, *rows[i]]].mean()
        alpha = 0.5 + 6 * abs(start[i] - mean) if (labels[i] == 1) == (start[i] >= 0.5) else 0.0
        weight = np.exp(-((abs(start[i] - start[to]) + 0.1 * np.linalg.norm(sites[i] - sites[to], axis=1)) ** 2))
        now[to] += weight / weight.sum() * alpha * (now[i] - labels[i])
    np.testing.assert_array_equal(oracles.diffuse(sites, edges, values, alpha="dynamic", order="global"), labels)


def test_components_are_numbered_by_their_lowest_node():
    edges = [[0, 1], [1, 2], [2, 3], [3, 4], [0, 5]]
    np.testing.assert_array_equal(oracles.components(edges, [0, 1, 1, 0, 0, 0]), [0, 1, 1, 2, 2, 0])


def test_areas():
    assert oracles.signed_area([[0, 0], [2, 0], [2, 3], [0, 3]]) == 6
    assert oracles.dot((5, 5, 2), 10, 10).area == pytest.approx(4 * math.pi, rel=1e-12)
    assert oracles.dot((0, 0, 2), 10, 10).area == pytest.approx(math.pi, rel=1e-4)


def test_only_slopes_lie_on_a_plane():
    random = np.random.default_rng(2)
    for _ in range(20):
        points = random.random((7, 2)) * 3
        slope, bump = points @ random.normal(0, 1, 2) + 0.3, np.zeros(7)
        bump[random.integers(7)] = 0.1
        assert oracles.off_plane(points, slope) == pytest.approx(0, abs=1e-20)
        assert 0 < oracles.off_plane(points, bump) < bump.var()
        assert oracles.off_plane(points, slope + bump) == pytest.approx(oracles.off_plane(points, bump))
    line = np.outer(np.arange(4), [1.0, 2.0])
    assert oracles.off_plane(line, np.arange(4.0)) == pytest.approx(0, abs=1e-20)
    assert oracles.off_plane(line, np.array([0.0, 1, 1, 0])) == pytest.approx(0.25)


def test_every_side_of_an_edge_is_a_triangle_or_the_frame():
    sites = np.random.default_rng(4).random((80, 2)) * [30, 20]
    left = oracles.left_of_edges(sites, 30, 20)
    assert {tuple(sorted(edge)) for edge in left} == {tuple(edge) for edge in oracles.delaunay_edges(sites, 30, 20).tolist()}
    for (a, b), c in left.items():
        assert (b, a) in left
        if isinstance(c, int):
            assert oracles.signed_area(sites[[a, b, c]]) > 0
            assert left[b, c] == a
        else:
            # Both cells touch that side.
            middle, axis = sites[[a, b]].mean(axis=0), "yx".index(c)
            assert min(middle[axis], [30, 20][axis] - middle[axis]) < 6
    assert {c for c in left.values() if not isinstance(c, int)} == {"x", "y"}
