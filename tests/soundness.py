"""What makes a vector result sound, checked by shapely, and random images that put it to the test."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from tests import oracles

import graphstipple as gs
from graphstipple import stages

# Flattened neighbours share their points, so areas are exact; the last bits are lost in sums over the canvas.
AREA_TOLERANCE = 1e-6


def noise(seed: int, width: int, height: int) -> NDArray[np.uint8]:
    """Blobs of many sizes and depths, and pure noise in between."""
    random = np.random.default_rng(seed)
    coarse = random.random((height // 4 + 1, width // 4 + 1)).repeat(4, axis=0).repeat(4, axis=1)[:height, :width]
    return (255 * np.clip(coarse + random.normal(0, random.uniform(0, 0.4), (height, width)), 0, 1)).astype(np.uint8)


def polygons(picture: gs.Drawing | stages.Outline) -> list[shapely.Polygon]:
    """Return the regions, in their order."""
    return [shapely.Polygon(region.exterior, region.holes) for region in picture.regions]


def check_picture(picture: gs.Drawing | stages.Outline, width: int, height: int) -> None:
    """Check the vector result, for all tests: simple rings, disjoint marks, whole canvas."""
    canvas, shapes = shapely.box(0, 0, width, height), polygons(picture)
    for region, shape in zip(picture.regions, shapes, strict=True):
        rings = [region.exterior, *region.holes]
        assert all(len(ring) >= 3 and shapely.LinearRing(ring).is_simple for ring in rings)
        assert oracles.signed_area(region.exterior) > 0
        assert all(oracles.signed_area(hole) < 0 for hole in region.holes)
        assert shape.is_valid, shapely.is_valid_reason(shape)
        assert shape.area == pytest.approx(region.area, rel=1e-9)
        assert (np.min(region.exterior, axis=0) >= 0).all()
        assert (np.max(region.exterior, axis=0) <= [width, height]).all()
    first, second = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    pairs = first < second
    shared = shapely.intersection(np.array(shapes)[first[pairs]], np.array(shapes)[second[pairs]])
    assert shapely.area(shared).sum() <= AREA_TOLERANCE * canvas.area

    # What no region covers is the dots, one each: together they fill the canvas.
    rest = canvas.area - sum(shape.area for shape in shapes)
    gaps = canvas.difference(shapely.union_all(shapes))
    gaps = [gap for gap in getattr(gaps, "geoms", [gaps]) if gap.area > 1e-12 * canvas.area]
    assert sum(gap.area for gap in gaps) == pytest.approx(rest, abs=AREA_TOLERANCE * canvas.area)
    assert len(gaps) == len(picture.stipples)
    if not gaps:
        return
    dots = np.array([oracles.dot(row, width, height) for row in picture.stipples[["x", "y", "radius"]].tolist()])
    nearest = shapely.STRtree(gaps).nearest(dots)
    assert len(set(nearest.tolist())) == len(dots)
    outlines = np.array(gaps)[nearest]
    # A dot's outline is a polygon within 0.05 px of its circle, of the same area unless the frame cuts it.
    assert (shapely.area(shapely.symmetric_difference(outlines, dots)) <= 0.06 * shapely.length(dots)).all()
    radii = picture.stipples["radius"]
    uncut = np.isclose(shapely.area(dots), np.pi * radii**2, rtol=1e-9)
    uncut &= shapely.within(outlines, canvas.buffer(-1e-9))
    np.testing.assert_allclose(shapely.area(outlines)[uncut], np.pi * radii[uncut] ** 2, rtol=1e-6)
