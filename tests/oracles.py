"""Slow, readable NumPy/SciPy twins of the stages (the method), to test the Rust code against.

Nothing here is shared with the package: each function follows the text of the design, not the code. Points are `(n, 2)` arrays of
x, y in pixels; rasters are row-major; the pixel in column c and row r covers [c, c+1) x [r, r+1).
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.ndimage
import scipy.sparse
import scipy.spatial
import shapely
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


# Lattice (2.1) -------------------------------------------------------------------------------------------------------------------


# How far inside the canvas all sites lie, in pixels.
MARGIN = 1e-3


def lattice(width: int, height: int, density: float = 1.0, kind: str = "hexagonal") -> tuple[Floats, Integers]:
    """Return sites row by row, and edges between those that are one spacing apart."""
    if kind == "square":
        spacing = row_height = 1.0 / math.sqrt(density)
        first, shift = spacing / 2, 0.0
    else:
        spacing = math.sqrt(2.0 / (math.sqrt(3.0) * density))
        row_height = spacing * math.sqrt(3.0) / 2
        first, shift = spacing / 4, spacing / 2
    sites = []
    for row in range(math.ceil(height / row_height) + 1):
        y = (row + 0.5) * row_height
        for column in range(math.ceil(width / spacing) + 1):
            x = first + (row % 2) * shift + column * spacing
            if x <= width - MARGIN and y <= height - MARGIN:
                sites.append((x, y))
    points = np.array(sites, dtype=np.float64).reshape(-1, 2)
    if len(points) < 2:
        return points, np.zeros((0, 2), np.int64)
    return points, sorted_edges(scipy.spatial.cKDTree(points).query_pairs(1.01 * spacing, output_type="ndarray"))


def sorted_edges(edges: ArrayLike) -> Integers:
    """Return every edge as (lower, higher), in ascending order: one form, so that two sets of edges compare as arrays."""
    array = np.sort(np.asarray(edges, dtype=np.int64).reshape(-1, 2), axis=1)
    return array[np.lexsort((array[:, 1], array[:, 0]))]


# Cells (2.2) ---------------------------------------------------------------------------------------------------------------------


def sample_points(width: int, height: int, samples_per_pixel: int) -> Floats:
    """Return the centres of the samples, row by row."""
    x = (np.arange(width * samples_per_pixel) + 0.5) / samples_per_pixel
    y = (np.arange(height * samples_per_pixel) + 0.5) / samples_per_pixel
    return np.stack([a.ravel() for a in np.meshgrid(x, y)], axis=1)


def squared_distances(sites: Floats, width: int, height: int, owner: ArrayLike, samples_per_pixel: int) -> Floats:
    """Return the squared distance from every sample to the site `owner` names, in the owners' shape."""
    owner = np.asarray(owner)
    delta = sample_points(width, height, samples_per_pixel) - np.asarray(sites)[owner.ravel().astype(np.int64)]
    return (delta**2).sum(axis=1).reshape(owner.shape)


def owners(sites: Floats, width: int, height: int, samples_per_pixel: int = 2) -> Integers:
    """Find the nearest site of every sample by a k-d tree; of up to 8 equally near ones, that with the lowest index."""
    sites = np.asarray(sites, dtype=np.float64)
    points = sample_points(width, height, samples_per_pixel)
    _, candidates = scipy.spatial.cKDTree(sites).query(points, k=np.arange(1, min(8, len(sites)) + 1))
    candidates = np.sort(candidates, axis=1)
    squared = ((points[:, None, :] - sites[candidates]) ** 2).sum(axis=2)
    nearest = candidates[np.arange(len(points)), squared.argmin(axis=1)]
    return nearest.reshape(height * samples_per_pixel, width * samples_per_pixel)


def bilinear(field: NDArray[np.floating], x: float, y: float) -> float:
    """Interpolate the field between pixel centres; constant beyond the outermost ones."""
    rows, columns = field.shape
    p, q = min(max(x - 0.5, 0.0), columns - 1.0), min(max(y - 0.5, 0.0), rows - 1.0)
    c, r = int(p), int(q)
    c1, r1, u, v = min(c + 1, columns - 1), min(r + 1, rows - 1), p - c, q - r
    top = field[r, c] * (1 - u) + field[r, c1] * u
    bottom = field[r1, c] * (1 - u) + field[r1, c1] * u
    return float(top * (1 - v) + bottom * v)


@dataclass
class Cells:
    """What the samples of each site come to."""

    counts: Integers
    areas: Floats
    centroids: Floats
    means: Floats | None


def cells(owner: Integers, sites: Floats, field: NDArray[np.floating] | None, samples_per_pixel: int) -> Cells:
    """Sum over the samples that each site owns."""
    sites = np.asarray(sites, dtype=np.float64)
    n, s = len(sites), samples_per_pixel
    height, width = owner.shape[0] // s, owner.shape[1] // s
    flat, points = owner.ravel(), sample_points(width, height, s)
    counts = np.bincount(flat, minlength=n)
    some = counts > 0
    centroids = sites.copy()
    for axis in range(2):
        centroids[some, axis] = np.bincount(flat, points[:, axis], minlength=n)[some] / counts[some]
    means = None
    if field is not None:
        samples = np.asarray(field, np.float64).repeat(s, axis=0).repeat(s, axis=1)
        means = np.array([bilinear(field, x, y) for x, y in sites])
        means[some] = np.bincount(flat, samples.ravel(), minlength=n)[some] / counts[some]
    return Cells(counts, counts / s**2, centroids, means)


def relax(sites: Floats, width: int, height: int, steps: int = 1, samples_per_pixel: int = 2) -> Floats:
    """Do Lloyd steps: every site goes to the centroid of its samples, but not nearer to the frame than the margin."""
    for _ in range(steps):
        sites = cells(owners(sites, width, height, samples_per_pixel), sites, None, samples_per_pixel).centroids
        sites = np.clip(sites, MARGIN, np.array([width, height]) - MARGIN)
    return sites


# Diffusion (2.3) -----------------------------------------------------------------------------------------------------------------


def adjacency(n: int, edges: ArrayLike) -> list[list[int]]:
    """List the neighbours of every node, ascending."""
    rows: list[list[int]] = [[] for _ in range(n)]
    for i, j in np.asarray(edges, dtype=np.int64).reshape(-1, 2).tolist():
        rows[i].append(j)
        rows[j].append(i)
    return [sorted(row) for row in rows]


def local_means(neighbours: list[list[int]], values: list[float], hops: int) -> list[float]:
    """Average over each node and all nodes up to `hops` steps away."""
    means = []
    for node in range(len(values)):
        seen, frontier = {node}, {node}
        for _ in range(hops):
            frontier = {k for j in frontier for k in neighbours[j]} - seen
            seen |= frontier
        means.append(math.fsum(values[j] for j in seen) / len(seen))
    return means


def bands(count: int) -> list[range]:
    """Cut nodes into runs of consecutive ones, at least 4096 and 64 times the root of their number in each."""
    size = max(1, -(-count // max(1, count // max(4096, 64 * math.isqrt(count)))))
    return [range(first, min(first + size, count)) for first in range(0, count, size)]


def passed_on(alpha: str | float, tuning: tuple[float, float, float], start: float, mean: float, label: int) -> float:
    """Return the share of its error that a node passes on; `tuning` is shading, base and detail gain."""
    shading, base, detail_gain = tuning
    if alpha == "tonal":
        tone = min(max(start, 0.0), 1.0)
        return shading * tone**1.5 * (1 - tone) ** 2 / ((3 / 7) ** 1.5 * (4 / 7) ** 2)
    if alpha == "dynamic":
        return base + detail_gain * abs(start - mean) if label == int(start >= 0.5) else 0.0
    return float(alpha)


def diffuse(
    sites: ArrayLike,
    edges: ArrayLike,
    values: ArrayLike,
    *,
    areas: ArrayLike | None = None,
    alpha: float | str = "tonal",
    k1: float = 1.0,
    k2: float = 0.1,
    shading: float = 0.15,
    base: float = 0.5,
    detail_gain: float = 6.0,
    hops: int = 1,
    order: str = "rows",
) -> NDArray[np.uint8]:
    """Diffuse errors, by a heap whose stale entries are skipped when they surface, or by number in bands that start early."""
    points = np.asarray(sites, dtype=np.float64).tolist()
    start: list[float] = np.asarray(values, dtype=np.float32).astype(np.float64).tolist()
    cells = None if areas is None else np.asarray(areas, dtype=np.float64).tolist()
    neighbours = adjacency(len(start), edges)
    means, tuning = local_means(neighbours, start, hops), (shading, base, detail_gain)
    labels: list[int | None] = [None] * len(start)

    def label(i: int, current: list[float], open_ones: list[int]) -> None:
        labels[i] = int(current[i] >= 0.5)
        share = passed_on(alpha, tuning, start[i], means[i], labels[i])
        exponents = [(k1 * abs(start[i] - start[j]) + k2 * math.dist(points[i], points[j])) ** 2 for j in open_ones]
        weights = [math.exp(min(exponents) - e) for e in exponents]
        for j, weight in zip(open_ones, weights, strict=True):
            ratio = 1.0 if cells is None or cells[i] == cells[j] else min(cells[i] / cells[j], 16.0)
            current[j] += weight / math.fsum(weights) * share * (current[i] - labels[i]) * ratio

    if order == "rows":
        for band in bands(len(start)):
            current = list(start)
            found = labels[: band.start]
            for i in range(max(0, band.start - len(bands(len(start))[0]) // 4), band.stop):
                later = [j for j in neighbours[i] if j > i]
                if band.start == 0 and 3 * (len(neighbours[i]) - len(later)) < len(neighbours[i]):
                    # The share does not depend on the side of the label here.
                    current[i] += 0.5 * noise(i) * passed_on(alpha, tuning, start[i], means[i], int(start[i] >= 0.5))
                label(i, current, later)
            labels[: band.start] = found
        return np.array(labels, dtype=np.uint8)

    current = list(start)
    heap = [(-abs(value - 0.5), i) for i, value in enumerate(current)]
    heapq.heapify(heap)
    while heap:
        key, i = heapq.heappop(heap)
        if labels[i] is None and key == -abs(current[i] - 0.5):
            open_ones = [j for j in neighbours[i] if labels[j] is None]
            label(i, current, open_ones)
            for j in open_ones:
                heapq.heappush(heap, (-abs(current[j] - 0.5), j))
    return np.array(labels, dtype=np.uint8)


MASK = (1 << 64) - 1


def mixed(number: int) -> int:
    """Finish SplitMix64."""
    z = (number + 1) * 0x9E3779B97F4A7C15 & MASK
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9 & MASK
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB & MASK
    return z ^ (z >> 31)


def noise(number: int) -> float:
    """Scale what SplitMix64 makes of a number to [-1, 1), by its highest 24 bits."""
    return (mixed(number) >> 40) / 2**23 - 1


def diffuse_in_rows(
    sites: ArrayLike,
    edges: ArrayLike,
    values: ArrayLike,
    *,
    alpha: float | str = 1.0,
    k1: float = 1.0,
    k2: float = 0.1,
    shading: float = 0.15,
    base: float = 0.5,
    detail_gain: float = 6.0,
    hops: int = 1,
) -> NDArray[np.uint8]:
    """Scan the rows of a lattice to and fro, in bands of 128 that start 16 rows early, mirrored at the top."""
    points = np.asarray(sites, dtype=np.float64).tolist()
    start: list[float] = np.asarray(values, dtype=np.float32).astype(np.float64).tolist()
    neighbours = adjacency(len(start), edges)
    means, tuning = local_means(neighbours, start, hops), (shading, base, detail_gain)
    rows: list[list[int]] = []
    for node, (_, y) in enumerate(points):
        if not rows or points[rows[-1][0]][1] != y:
            rows.append([])
        rows[-1].append(node)
    labels = [0] * len(start)
    margin = min(8, min(len(row) for row in rows[:2]) - 1)
    # How many columns further right than a node its lower neighbours are, in rows of either kind.
    shifted = len(rows) > 1 and points[rows[0][0]][0] != points[rows[1][0]][0]
    beside = {0: (-1, 0), 1: (0, 1)} if shifted else {0: (0,), 1: (0,)}
    here = points[rows[0][0]]
    along = math.dist(here, points[rows[0][1]]) if len(rows[0]) > 1 else 0.0
    across = min((math.dist(here, points[other]) for other in rows[1]), default=0.0) if len(rows) > 1 else 0.0
    for first in range(0, len(rows), 128):
        own = list(range(first, min(first + 128, len(rows))))
        before = [abs(first - k) for k in range(min(16, len(rows) - 1), 0, -1)]
        beyond = [own[-1] + 1] if own[-1] + 1 < len(rows) else [own[-1] - 1] if own[-1] else []
        order = [
            [*row[:margin][::-1], *row, *row[len(row) - margin :][::-1]] for row in (rows[k] for k in [*before, *own, *beyond])
        ]
        received = {p: 0.5 * noise(p) if before else 0.0 for p in range(len(order[0]) + 1)}
        for step, row in enumerate([*before, *own]):
            nodes, below = order[step], order[step + 1] if step + 1 < len(order) else []
            passed: dict[int, float] = {}
            carried, way = 0.0, 1 if row % 2 == 0 else -1
            for p in range(len(nodes))[::way]:
                i = nodes[p]
                current = start[i] + received.get(p, 0.0) + carried
                label, carried = int(current >= 0.5), 0.0
                if step >= len(before) and margin <= p < len(nodes) - margin:
                    labels[i] = label
                ahead = [(p + way, nodes[p + way], along)] if 0 <= p + way < len(nodes) else []
                down = [(p + side, below[p + side], across) for side in beside[row % 2] if 0 <= p + side < len(below)]
                open_ones = [*ahead, *down]
                share = passed_on(alpha, tuning, start[i], means[i], label)
                exponents = [(k1 * abs(start[i] - start[j]) + k2 * distance) ** 2 for _, j, distance in open_ones]
                units = [(mixed(i) >> 20 * place & 0xFFFFF) / 2**20 for place in range(len(open_ones))]
                weights = [math.exp(min(exponents) - e) * (0.5 + unit) for e, unit in zip(exponents, units, strict=True)]
                for k, ((q, _, _), weight) in enumerate(zip(open_ones, weights, strict=True)):
                    given = weight / math.fsum(weights) * share * (current - label)
                    if k < len(ahead):
                        carried = given
                    else:
                        passed[q] = passed.get(q, 0.0) + given
            received = passed
    return np.array(labels, dtype=np.uint8)


# Second graph (2.4) --------------------------------------------------------------------------------------------------------------


def delaunay_edges(sites: ArrayLike, width: float, height: float) -> Integers:
    """Find the pairs of sites that are Delaunay neighbours among all sites and their mirror images across the four sides.

    Inside the canvas no image is nearer than its original, so these are the pairs whose cells share an edge inside the canvas.
    """
    sites = np.asarray(sites, dtype=np.float64)
    triangles = scipy.spatial.Delaunay(with_images(sites, width, height)).simplices
    edges = np.concatenate([triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    return np.unique(sorted_edges(edges[(edges < len(sites)).all(axis=1)]), axis=0)


def with_images(sites: Floats, width: float, height: float) -> Floats:
    """Return the sites and, behind them, their mirror images across the left, right, top and bottom side."""
    images = [sites]
    for axis, limit in ((0, 0.0), (0, width), (1, 0.0), (1, height)):
        image = sites.copy()
        image[:, axis] = 2 * limit - image[:, axis]
        images.append(image)
    return np.concatenate(images)


def shared_edge(sites: Floats, pair: tuple[int, int], width: float, height: float) -> float:
    """Measure the edge inside the canvas that the Voronoi cells of two sites share: their bisector, cut by all other sites."""
    first, second = sites[pair[0]], sites[pair[1]]
    along = np.array([first[1] - second[1], second[0] - first[0]])
    along /= np.linalg.norm(along)
    middle = (first + second) / 2
    others = np.delete(sites, pair, axis=0)
    # The point middle + t * along is no nearer to another site, and inside the canvas, where offset + slope * t >= 0.
    offset = ((others - middle) ** 2).sum(axis=1) - ((first - middle) ** 2).sum()
    offset = np.concatenate([offset, middle, [width, height] - middle])
    slope = np.concatenate([-2 * (others - first) @ along, along, -along])
    if (offset[slope == 0] < 0).any():
        return 0.0
    rising, falling = slope > 0, slope < 0
    low = (-offset[rising] / slope[rising]).max(initial=-np.inf)
    high = (-offset[falling] / slope[falling]).min(initial=np.inf)
    return max(float(high - low), 0.0)


# Components (2.5) ----------------------------------------------------------------------------------------------------------------


def components(edges: ArrayLike, labels: ArrayLike) -> Integers:
    """Return the component of every node, numbered in the order of their lowest nodes."""
    labels = np.asarray(labels)
    i, j = np.asarray(edges, dtype=np.int64).reshape(-1, 2).T
    like = labels[i] == labels[j]
    ones = np.ones(like.sum(), np.int8)
    matrix = scipy.sparse.coo_matrix((ones, (i[like], j[like])), shape=(len(labels), len(labels)))
    _, found = scipy.sparse.csgraph.connected_components(matrix, directed=False)
    _, first, inverse = np.unique(found, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[inverse]


def refine(
    edges: ArrayLike,
    tones: ArrayLike,
    labels: ArrayLike,
    areas: ArrayLike,
    parameters: dict[str, Any],
    *,
    grounds: ArrayLike | None = None,
) -> tuple[Integers, float]:
    """Ask every node again whether it is white, in the order of their numbers: one block. Those with a ground are not asked."""
    labels, areas = np.array(labels, np.int64), np.array(areas, np.float64)
    is_asked = np.ones(len(labels), bool) if grounds is None else np.asarray(grounds) == STRUCTURED
    areas[~is_asked] = 0.0
    tones = np.asarray(tones, np.float32).astype(np.float64)
    near: list[list[int]] = [[] for _ in labels]
    for i, j in np.asarray(edges, dtype=np.int64).reshape(-1, 2).tolist():
        near[i].append(j)
        near[j].append(i)
    shift, gain, last = 0.0, 1.5, 0.0
    sweeps: list[tuple[float, Integers, float]] = []
    for _ in range(parameters["sweeps"]):
        changed = 0
        for node, others in enumerate(near):
            if not is_asked[node] or (others and (labels[others] != labels[node]).all()):
                continue
            lack = np.mean(tones[others] - labels[others]) if others else 0.0
            company = np.mean(labels[others] - 0.5) if others else 0.0
            wish = parameters["crispness"] * (tones[node] - 0.5) + lack + parameters["cohesion"] * company
            wish += shift + (0.2 * abs(shift) + 0.005) * noise(node)
            changed += int((wish > 0) != (labels[node] == 1))
            labels[node] = wish > 0
        off = 0.0 if parameters["mean"] is None or not areas.any() else areas @ labels / areas.sum() - parameters["mean"]
        over = off - np.clip(off, -parameters["tone_tolerance"], parameters["tone_tolerance"])
        sweeps.append((abs(over), labels.copy(), float(shift)))
        if over == 0 and changed <= len(labels) / 1000:
            break
        gain /= 2 if over * last < 0 else 1
        shift, last = shift - gain * over, over
    if not sweeps:
        return labels, 0.0
    _, labels, shift = sweeps[-1] if sweeps[-1][0] == 0 else min(sweeps, key=lambda sweep: sweep[0])
    return labels, shift


def split(edges: ArrayLike, tones: ArrayLike, labels: ArrayLike, most: int) -> Integers:
    """Take apart dots that fused by chance, with sets."""
    before, labels = np.asarray(labels).astype(np.int64), np.array(labels, np.int64)
    tones = np.asarray(tones, np.float32)
    near: list[set[int]] = [set() for _ in labels]
    for i, j in np.asarray(edges, dtype=np.int64).reshape(-1, 2).tolist():
        near[i].add(j)
        near[j].add(i)
    ids = components(edges, before)
    for component in np.flatnonzero(np.isin(np.bincount(ids), range(2, most + 1))):
        fused = set(np.flatnonzero(ids == component).tolist())
        label = before[min(fused)]
        other_side = {node: (tones[node] >= 0.5) != label for node in range(len(tones))}
        reached = {node for one in fused for node in near[one]} - fused
        if not all(other_side[node] for node in fused) or any(labels[node] != label for node in fused):
            continue
        if any(labels[node] == label for node in reached):
            continue
        order = sorted(range(len(tones)), key=lambda node: (abs(tones[node] - np.float32(label)), node))
        kept: set[int] = set()
        for node in (node for node in order if node in fused):
            kept |= set() if near[node] & kept else {node}
        within_two = reached | {node for one in reached for node in near[one]}
        free = [node for node in order if node in within_two and labels[node] != label and other_side[node]]
        places: set[int] = set()
        for node in free:
            taken = {other for other in near[node] - fused if labels[other] == label} | (near[node] & (kept | places))
            if len(places) < len(fused - kept) and not taken:
                places.add(node)
        if len(places) == len(fused - kept):
            labels[list(fused - kept)] = 1 - label
            labels[list(places)] = label
    return labels


# Smooth parts and their dots -----------------------------------------------------------------------------------------------------


STRUCTURED = 2
ROUGHNESS, STEP = 0.02, 0.5 / 255
MAJORITIES, COHESION, COHESION_SWEEPS = 2, 0.1, 2
PURE = 0.5 / 255


def mean_around(neighbours: list[list[int]], values: Floats) -> Floats:
    """Average over every node and its neighbours."""
    return np.array([values[[node, *row]].mean() for node, row in enumerate(neighbours)])


def off_plane(points: Floats, tones: Floats) -> float:
    """Return the mean squared distance of tones from their best plane; of those on one line, from their best line."""
    shape = np.column_stack([np.ones(len(points)), points - points[0]])
    plane = np.linalg.lstsq(shape, tones, rcond=None)[0]
    return float(((tones - shape @ plane) ** 2).mean())


def grounds(sites: ArrayLike, edges: ArrayLike, tones: ArrayLike, stippling: float) -> tuple[Integers, float]:
    """Return the ground of every node, and how near the nearest decision was: by a difference of tones, at any node."""
    sites, tones = np.asarray(sites, np.float64), np.asarray(tones, np.float32).astype(np.float64)
    neighbours = adjacency(len(sites), edges)
    around = mean_around(neighbours, mean_around(neighbours, tones))
    ground, margin = (around >= 0.5).astype(np.int64), np.abs(around - 0.5).min()
    for _ in range(COHESION_SWEEPS):
        company = np.array([ground[row].mean() - 0.5 if row else 0.0 for row in neighbours])
        wish = around - 0.5 + COHESION * company
        ground, margin = (wish >= 0).astype(np.int64), min(margin, np.abs(wish).min())
    if stippling in {0, 1}:
        return np.where(stippling == 1, ground, STRUCTURED), margin
    around_it = [[node, *row] for node, row in enumerate(neighbours)]
    off = np.array([off_plane(sites[near], tones[near]) for near in around_it])
    off = np.sqrt(mean_around(neighbours, mean_around(neighbours, off)))
    limit = STEP + 2 * np.minimum(around, 1 - around) * ROUGHNESS * stippling / (1 - stippling)
    smooth = off <= limit
    for _ in range(MAJORITIES):
        # A node counts half among its neighbours, which breaks ties.
        smooth = np.array([smooth[row].sum() + smooth[node] / 2 > len(row) / 2 for node, row in enumerate(neighbours)])
    return np.where(smooth, ground, STRUCTURED), min(margin, np.abs(off - limit).min())


def clean(edges: ArrayLike, tones: ArrayLike, labels: ArrayLike) -> Integers:
    """Turn every component around that lies wholly on the pure tone of the other label."""
    tones, labels = np.asarray(tones, np.float32), np.array(labels, np.int64)
    is_speck = np.where(labels == 0, tones >= np.float32(1) - np.float32(PURE), tones <= np.float32(PURE))
    ids = components(edges, labels)
    on_pure = np.bincount(ids, ~is_speck) == 0
    return np.where(on_pure[ids], 1 - labels, labels)


SMALLEST, LARGEST = 0.2, 1.0
LEAST_INK, LEAST_LACK = 0.1, 0.5 / 255
PACKING = 0.75
STEPS, MAKING_ROOM, HANDING_ON = 3, 3, 2
ROOM_TO_SPARE, MOST_SHARING = 1.05, 12
STAR_FILL = 0.99 / 1.055
LEAST_TRIANGLE, LEAST_WAY = 0.1, 0.1


def left_of_edges(sites: Floats, width: float, height: float) -> dict[tuple[int, int], int | str]:
    """Find what lies to the left of every edge, in either direction: a third site, or the frame, which "x" or "y" runs along."""
    count = len(sites)
    triangulated = scipy.spatial.Delaunay(with_images(sites, width, height))
    left: dict[tuple[int, int], int | str] = {}
    for triangle, corners in zip(triangulated.simplices.tolist(), triangulated.points[triangulated.simplices], strict=True):
        a, b, c = triangle if signed_area(corners) > 0 else triangle[::-1]
        for first, second, third in ((a, b, c), (b, c, a), (c, a, b)):
            if first < count and second < count:
                left[first, second] = third if third < count else "yyxx"[third // count - 1]
    return left


@dataclass
class Dots:
    """The chosen ones, and what they carry in the end."""

    nodes: list[int]
    """In the order of their numbers."""
    lacking: float
    """What the grounds lack that are connected to a dot, in px^2."""
    least: Floats
    """The ink of every dot below which it is not drawn."""
    labels: Integers
    places: Floats
    areas: Floats


def stipple(  # noqa: PLR0917
    sites: ArrayLike, grounds: ArrayLike, tones: ArrayLike, labels: ArrayLike, areas: ArrayLike, width: float, height: float
) -> Dots:
    """Choose dots, move them to the middle of their ink, and give them its area. Points are complex numbers."""
    ground, cells = np.asarray(grounds, np.int64), np.asarray(areas, np.float64)
    tone = np.asarray(tones, np.float32).astype(np.float64)
    shown = np.where(ground == STRUCTURED, labels, ground)
    lacks = np.where(ground == STRUCTURED, 0.0, np.clip(np.where(ground == 1, 1 - tone, tone), 0, 1))
    left = left_of_edges(np.asarray(sites, np.float64), width, height)
    near = adjacency(len(cells), [edge for edge in left if edge[0] < edge[1]])
    alike = [[other for other in row if ground[other] == ground[node]] for node, row in enumerate(near)]
    within = [ground[node] != STRUCTURED and len(row) >= 3 and all(shown[row] == ground[node]) for node, row in enumerate(near)]
    around = mean_around(near, cells)
    fixed = np.asarray(sites, np.float64) @ [1, 1j]

    nodes = chosen(fixed, alike, lacks, around, [bool(w) and lack >= LEAST_LACK for w, lack in zip(within, lacks, strict=True)])
    owners = fewest_hops(alike, nodes)
    places = Places(left, near, fixed, cells, complex(width, height))
    beside = [node for node, row in enumerate(near) if within[node] and node not in nodes and set(row) & set(nodes)]

    def shared() -> dict[int, dict[int, float]]:
        found = {}
        for node in sorted(owners):
            dots = list(dict.fromkeys([owners[node], *(owners[other] for other in alike[node])]))[:MOST_SHARING]
            found[node] = sharing(fixed[node], cells[node], dots, places.at)
        # All at once, after every node was asked.
        owners.update({node: next(iter(parts)) for node, parts in found.items()})
        return found

    def carried() -> tuple[dict[int, float], dict[int, complex]]:
        inks, moments = dict.fromkeys(nodes, 0.0), dict.fromkeys(nodes, 0j)
        for node, parts in shares.items():
            for dot, share in parts.items():
                inks[dot] += share * lacks[node] * cells[node]
                moments[dot] += share * lacks[node] * cells[node] * fixed[node]
        return inks, moments

    shares = shared()
    for _ in range(STEPS):
        inks, moments = carried()
        for dot in (dot for dot in nodes if inks[dot] > 0):
            places.move(dot, moments[dot] / inks[dot])
        for node in (node for node in beside if node not in places.at_frame):
            places.move(node, sum(places.at[other] for other in near[node]) / len(near[node]))
        shares = shared()
    inks, _ = carried()
    for dot in nodes * MAKING_ROOM:
        make_room(dot, ROOM_TO_SPARE * math.sqrt(inks[dot] / math.pi) / STAR_FILL, places, set(beside))
    most = {dot: math.pi * (STAR_FILL * places.room(dot)) ** 2 for dot in nodes}
    groups = [list(parts) for parts in shares.values()]
    for _ in range(HANDING_ON):
        inks = handed_on(inks, most, groups)

    drawn = [dot for dot in nodes if inks[dot] > 0 and inks[dot] >= LEAST_INK * around[dot]]
    found, marks = shown.copy(), cells.copy()
    found[drawn], marks[drawn] = 1 - ground[drawn], [inks[dot] for dot in drawn]
    points = np.column_stack([places.at.real, places.at.imag])
    lacking = math.fsum(lacks[node] * cells[node] for node in owners)
    return Dots(nodes, lacking, LEAST_INK * around[nodes], found, points, marks)


def chosen(sites: NDArray[np.complex128], alike: list[list[int]], lacks: Floats, around: Floats, possible: list[bool]) -> list[int]:
    """Choose dots in the order of nodes: none that a dot before reaches, over nodes of its ground that are too near to it."""
    lack = np.maximum(mean_around(alike, lacks), LEAST_LACK)
    wanted = np.sqrt(PACKING * around * (SMALLEST + (LARGEST - SMALLEST) * np.minimum(2 * lack, 1)) / lack)
    nodes: list[int] = []
    taken: set[int] = set()
    for node in range(len(lacks)):
        if not possible[node] or node in taken:
            continue
        nodes.append(node)
        too_near = set(np.flatnonzero(np.abs(sites - sites[node]) < (wanted + wanted[node]) / 2).tolist())
        reached, frontier = {node}, {node}
        while frontier:
            frontier = {other for one in frontier for other in alike[one]} & too_near - reached
            reached |= frontier
        taken |= reached | set(alike[node])
    return nodes


def fewest_hops(alike: list[list[int]], nodes: list[int]) -> dict[int, int]:
    """Return the dot of every node that one reaches, ring by ring; of equally near ones that of the neighbour found first."""
    owners, ring = {node: node for node in nodes}, nodes
    while ring:
        reached = []
        for node in ring:
            for other in (other for other in alike[node] if other not in owners):
                owners[other] = owners[node]
                reached.append(other)
        ring = reached
    return owners


def sharing(site: complex, cell: float, dots: list[int], places: NDArray[np.complex128]) -> dict[int, float]:
    """Return the part of a node that each dot has, of the nearest and those whose bisector with it cuts a cell as wide as high."""
    first = min(dots, key=lambda dot: abs(site - places[dot]))

    def before(dot: int, other: int) -> float:
        """Return how far the node lies before the bisector, in widths of its cell; without a cell far on either side."""
        between = places[other] - places[dot]
        off = (((places[dot] + places[other]) / 2 - site) * between.conjugate()).real
        width = abs(between) * math.sqrt(cell)
        return off / width if width > 0 else math.copysign(math.inf, off)

    parts = dict.fromkeys([first, *(dot for dot in dots if dot != first and before(first, dot) < 0.5)], 1.0)
    for dot, other in itertools.permutations(parts, 2):
        parts[dot] *= min(max(0.5 + before(dot, other), 0.0), 1.0)
    total = sum(parts.values())
    return {dot: part / total for dot, part in parts.items()} if total > 0 else {first: 1.0}


class Places:
    """Where nodes are drawn."""

    def __init__(
        self,
        left: dict[tuple[int, int], int | str],
        near: list[list[int]],
        sites: NDArray[np.complex128],
        cells: Floats,
        corner: complex,
    ):
        self.at, self.sites, self.cells, self.corner = sites.copy(), sites, cells, corner
        self.at_frame = {end for edge, beside in left.items() if isinstance(beside, str) for end in edge}
        # The sides of the star of every node; those of its edges that have the frame beside them, and the axis along it.
        self.rim = [[(a, left[node, a]) for a in row if not isinstance(left[node, a], str)] for node, row in enumerate(near)]
        self.along = [
            [(a, axis) for a in row for axis in (left[node, a], left[a, node]) if isinstance(axis, str)]
            for node, row in enumerate(near)
        ]

    def room(self, node: int) -> float:
        """Return how far a node is from the rim of its star and from the frame."""
        here, there = self.at[node], self.corner - self.at[node]
        return min([here.real, here.imag, there.real, there.imag, *(self.to_side(node, side) for side in self.rim[node])])

    def to_side(self, node: int, side: tuple[int, int]) -> float:
        """Return how far a node is from a side, seen with the side along the real axis."""
        start, end = self.at[list(side)]
        if start == end:
            return float(abs(self.at[node] - start))
        seen = (self.at[node] - start) * (end - start).conjugate() / abs(end - start)
        return float(abs(seen - min(max(seen.real, 0.0), abs(end - start))))

    def is_sound(self, node: int) -> bool:
        """Whether a node is inside, its triangles are large enough, and neighbours along the frame are in order."""
        x, y = self.at[node].real, self.at[node].imag
        if not (0 < x < self.corner.real and 0 < y < self.corner.imag) or self.cells[node] == 0:
            return False
        for a, b in self.rim[node]:
            one, other = self.at[a] - self.at[node], self.at[b] - self.at[node]
            if (one.conjugate() * other).imag <= LEAST_TRIANGLE * self.cells[node]:
                return False
        for a, axis in self.along[node]:
            before, now = self.sites[a] - self.sites[node], self.at[a] - self.at[node]
            ways = (before.real, now.real) if axis == "x" else (before.imag, now.imag)
            if ways[1] * np.sign(ways[0]) < LEAST_WAY * abs(ways[0]):
                return False
        return True

    def move(self, node: int, to: complex, suits: Callable[[], bool] = lambda: True) -> None:
        """Move a node all the way, half of it, a quarter, or not at all."""
        start = self.at[node]
        for part in (1, 0.5, 0.25):
            self.at[node] = start + part * (to - start)
            if self.is_sound(node) and suits():
                return
        self.at[node] = start


def make_room(dot: int, needed: float, places: Places, movable: set[int]) -> None:
    """Push sides that are too near outwards, side by side, and the dot away from those that stay too near."""
    if places.room(dot) >= needed:
        return

    def outwards(side: tuple[int, int]) -> complex:
        along = places.at[side[1]] - places.at[side[0]]
        missing = needed - places.to_side(dot, side)
        return -1j * along / abs(along) * missing if missing > 0 and abs(along) > 0 else 0j

    for side in places.rim[dot]:
        way = outwards(side)
        if way == 0:
            continue
        for end in (end for end in side if end in movable):
            places.move(end, places.at[end] + way)
        if (way := outwards(side)) != 0:
            before = places.room(dot)
            places.move(dot, places.at[dot] - way, lambda before=before: places.room(dot) > before)


def handed_on(inks: dict[int, float], most: dict[int, float], groups: list[list[int]]) -> dict[int, float]:
    """Hand the ink that dots have no room for to those that have some, as many parts to each as they share nodes."""
    over = {dot: max(ink - most[dot], 0.0) for dot, ink in inks.items()}
    takers: dict[int, list[int]] = {dot: [] for dot in inks if over[dot] > 0}
    for group in groups:
        for dot in (dot for dot in group if dot in takers):
            takers[dot] += [other for other in group if inks[other] < most[other]]
    # Who has handed on is full, and not nearly.
    after = {dot: most[dot] if takers.get(dot) else ink for dot, ink in inks.items()}
    for dot, others in takers.items():
        for other in others:
            after[other] += over[dot] / len(others)
    return after


# Saliency and luma ---------------------------------------------------------------------------------------------------------------


def emphasize(tone: ArrayLike, spacing: float, sharpen: float, local_contrast: float) -> Floats:
    """Unsharp masking at two scales, by SciPy."""
    tone = np.asarray(tone, np.float64)
    added = sum(a * (tone - blurred(tone, s * spacing)) for a, s in ((sharpen, 0.5), (local_contrast, 1.5)))
    return np.clip(tone + added, 0.0, 1.0)


def blurred(field: Floats, sigma: float) -> Floats:
    """Blur by a Gaussian cut at three sigmas, mirrored at the borders."""
    return scipy.ndimage.gaussian_filter(field, sigma, mode="reflect", radius=math.ceil(3 * sigma))


def importance(
    tone: ArrayLike, map_: ArrayLike, spacing: float, options: dict[str, float], emphasized: ArrayLike, *, is_saliency: bool
) -> Floats:
    """The mix of a floor, the map and local detail, less in black and white."""
    tone, map_, emphasized = (np.asarray(a, np.float64) for a in (tone, map_, emphasized))
    off = np.maximum(np.abs(tone - blurred(tone, 0.5 * spacing)) - 1 / 255, 0.0)
    detail = blurred(off, 0.5 * spacing)
    strong = np.sort(detail.ravel())[int(0.99 * (detail.size - 1))]
    detail = np.minimum(detail / strong, 1.0)
    guess, factor = (map_, 1.0) if is_saliency else (1.0, map_)
    mixed = options["floor"] + (1 - options["floor"]) * ((1 - options["detail"]) * guess + options["detail"] * detail)
    return np.clip(factor * mixed * (1 - options["midtones"] * (2 * emphasized - 1) ** 2), 0.0, 1.0)


def saliency(luma: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Compute OpenCV's fine-grained saliency."""
    import cv2

    done, result = cv2.saliency.StaticSaliencyFineGrained_create().computeSaliency(np.ascontiguousarray(luma))
    assert done
    return result


def luma(image: NDArray[np.generic]) -> Floats:
    """Return Rec. 601 luma in [0, 1] of the encoded values."""
    scale = np.iinfo(image.dtype).max if np.issubdtype(image.dtype, np.integer) else 1
    values = image.astype(np.float64) / scale
    return values if values.ndim == 2 else values[..., :3] @ np.array([0.299, 0.587, 0.114])


# Drawing (2.5) -------------------------------------------------------------------------------------------------------------------


def signed_area(ring: ArrayLike) -> float:
    """Return the shoelace sum; positive when the ring turns from +x towards +y."""
    x, y = np.asarray(ring, dtype=np.float64).T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2)


def dot(circle: tuple[float, float, float], width: float, height: float, sides: int = 720) -> shapely.Geometry:
    """Return a stipple as a polygon of a true circle's area, cut off at the frame."""
    x, y, radius = circle
    angle = np.arange(sides) * 2 * math.pi / sides
    r = radius * math.sqrt(2 * math.pi / (sides * math.sin(2 * math.pi / sides)))
    polygon = shapely.Polygon(np.stack([x + r * np.cos(angle), y + r * np.sin(angle)], axis=1))
    return polygon.intersection(shapely.box(0, 0, width, height))


def box_average(raster: NDArray[np.generic], factor: int) -> Floats:
    """Average over blocks of `factor` x `factor` pixels."""
    rows, columns = raster.shape[0] // factor, raster.shape[1] // factor
    return raster.reshape(rows, factor, columns, factor).astype(np.float64).mean(axis=(1, 3))
