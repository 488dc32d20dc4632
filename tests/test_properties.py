"""What must hold for every drawing: ownership, graphs, tone, areas, the border, the raster, the SVG."""

from __future__ import annotations

import functools
import json
from xml.etree import ElementTree

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from tests import oracles, readers
from tests.soundness import check_picture, noise, polygons
from tests.support import PHOTOS, on_every_photo, options_with, photo, photo_luma

import graphstipple as gs
from graphstipple import stages

# Random pictures of a few pixels often come out blank, which is told and is not what these tests are about.
pytestmark = pytest.mark.filterwarnings("ignore:the whole drawing is:graphstipple.GraphStippleWarning")

SEEDS = st.integers(0, 2**32 - 1)
EXTREME_SIZES = [(1, 5000), (5000, 1), (3, 3), (2, 2), (1, 2), (2, 1), (7, 1), (3, 200)]


@functools.cache
def drawn(name: str, width: int = 120, height: int = 90, **changes: object) -> gs.Drawing:
    """Draw a crop; the tests share it and only read."""
    return gs.draw(photo(name, width, height), options=options_with(**changes))


# Graphs --------------------------------------------------------------------------------------------------------------------------


def check_graph(graph: gs.Graph, width: int, height: int) -> None:
    """Sites inside and all different; every edge once, between different nodes; planar; components maximal and of one label."""
    n = len(graph.sites)
    assert len(np.unique(graph.sites, axis=0)) == n
    assert (graph.sites > 0).all()
    assert (graph.sites < [width, height]).all()
    edges = oracles.sorted_edges(graph.edges)
    assert len(np.unique(edges, axis=0)) == len(edges)
    assert (edges[:, 0] < edges[:, 1]).all()
    assert not len(edges) or edges.max() < n
    assert len(edges) <= max(3 * n - 3, 0)
    lines = shapely.linestrings(graph.sites[edges])
    first, second = shapely.STRtree(lines).query(lines, predicate="crosses")
    assert len(first) == len(second) == 0
    assert set(np.unique(graph.labels)) <= {0, 1}
    assert (graph.tone >= 0).all()
    assert (graph.tone <= 1).all()
    np.testing.assert_array_equal(graph.components, oracles.components(edges, graph.labels))
    assert len(oracles.components(edges, np.zeros(n))) == n
    assert oracles.components(edges, np.zeros(n)).max() == 0


@given(
    seed=SEEDS,
    width=st.integers(1, 50),
    height=st.integers(1, 50),
    density=st.floats(0.05, 3.0),
    relax=st.integers(0, 3),
    scale=st.floats(0.1, 4.0),
)
def test_random_images_give_sound_graphs_and_pictures(seed, width, height, density, relax, scale):  # noqa: PLR0917
    drawing = gs.draw(noise(seed, width, height), options=options_with(density=density, relax=relax, stipple_scale=scale))
    check_graph(drawing.graph, width, height)
    check_picture(drawing, width, height)
    stats = drawing.stats
    assert stats["stipples"] == len(drawing.stipples)
    assert stats["regions"] == len(drawing.regions)
    assert stats["stipples"] + stats["regions"] == drawing.graph.components.max() + 1
    assert stats["nodes"] == len(drawing.graph.sites)


def labelled_sites(  # noqa: PLR0917
    random: np.random.Generator, n: int, width: int, height: int, share: float, spread: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return sites, three quarters of them in a part of the canvas as small as `spread`, and labels, a `share` of them white."""
    sites = random.uniform(0, 1, (n, 2))
    sites[n // 4 :] = random.uniform(0, 1 - spread, 2) + spread * sites[n // 4 :]
    sites = 0.01 + sites * (np.array([width, height]) - 0.02)
    return sites, (random.random(n) < share).astype(np.uint8)


@given(
    seed=SEEDS,
    n=st.integers(3, 300),
    width=st.integers(1, 60),
    height=st.integers(1, 60),
    share=st.floats(0.0, 1.0),
    spread=st.floats(0.02, 1.0),
    scale=st.floats(0.1, 4.0),
    least=st.sampled_from([0.0, 1000.0]),
    irregularity=st.sampled_from([0.0, 0.3, 1.0]),
)
def test_any_labels_on_any_sites_give_a_sound_picture(  # noqa: PLR0917
    seed, n, width, height, share, spread, scale, least, irregularity
):
    sites, labels = labelled_sites(np.random.default_rng(seed), n, width, height, share, spread)
    shaping = {"stipple_scale": scale, "stipple_min": least, "irregularity": irregularity, "seed": seed}
    check_picture(stages.outline(sites, labels, width, height, **shaping), width, height)


@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 300),
    width=st.integers(2, 60),
    height=st.integers(2, 60),
    share=st.floats(0.0, 1.0),
    spread=st.floats(0.2, 1.0),
    tolerance=st.sampled_from([0.0, 0.25, 1.0]),
)
def test_any_tones_give_a_sound_picture(seed, n, width, height, share, spread, tolerance):  # noqa: PLR0917
    random = np.random.default_rng(seed)
    sites, labels = labelled_sites(random, n, width, height, share, spread)
    # On the side of their label or not, near middle grey or far.
    tones = np.clip(labels + random.normal(0, 0.6, n), 0, 1)
    check_picture(stages.outline(sites, labels, width, height, tones=tones, tolerance=tolerance), width, height)


@pytest.mark.parametrize(
    ("sites", "labels", "scale"),
    [
        ([[6.0, 9.0], [2.5, 8.5], [6.5, 4.5]], [1, 1, 0], 1.0),
        ([[8.0, 3.0], [1.0, 9.5], [3.0, 3.0], [1.0, 4.5]], [1, 0, 0, 1], 1.5),
        ([[7.5, 4.0], [6.0, 4.5], [7.0, 3.5], [1.0, 3.0]], [0, 1, 1, 0], 4.0),
    ],
)
def test_a_dot_on_the_frame_may_be_larger_than_what_surrounds_it(sites, labels, scale):
    check_picture(stages.outline(sites, labels, 10, 10, stipple_scale=scale), 10, 10)


@pytest.mark.parametrize("node", [2, 5])
def test_a_dot_without_area_is_the_least_that_the_grid_holds(node):
    # A cell may own no sample.
    sites = [[2, 2], [8, 2], [5, 9.5], [2, 8], [8, 8], [5, 5]]
    areas = np.full(6, 10.0)
    areas[node] = 0.0
    picture = stages.outline(sites, (np.arange(6) == node).astype(np.uint8), 10, 10, areas=areas)
    (dot,) = picture.stipples
    assert (dot["radius"], dot["ink"]) == (1 / 1024, 1)
    assert np.hypot(dot["x"] - sites[node][0], dot["y"] - sites[node][1]) < 0.002
    (black,) = picture.regions
    assert (black.ink, len(black.holes)) == (0, 1)
    assert black.area == pytest.approx(100 - np.pi / 1024**2, abs=1e-8)


@pytest.mark.parametrize("area", [np.nan, -1.0, np.inf])
def test_areas_that_are_none_are_refused(area):
    with pytest.raises(gs.InvalidInputError):
        stages.outline([[2, 2], [8, 2], [5, 9.5], [5, 5]], [0, 0, 0, 1], 10, 10, areas=[10, 10, 10, area])


@given(seed=SEEDS, n=st.integers(1, 300), s=st.integers(1, 4))
def test_every_sample_is_owned_once(seed, n, s):
    sites = np.random.default_rng(seed).uniform(0.01, 0.99, (n, 2)) * [37, 21]
    owner, cells = stages.owners(sites, 37, 21, s), stages.cells(sites, 37, 21, None, s)
    np.testing.assert_array_equal(np.bincount(owner.ravel(), minlength=n), cells.counts)
    assert cells.areas.sum() == pytest.approx(37 * 21, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        *((name, {"alpha": 1.0}) for name in PHOTOS),
        *((name, {"density": 1.0}) for name in ("camera", "rocket")),
        *((name, {"lattice": "square", "density": 2.0, "relax": 0}) for name in ("astronaut", "chelsea")),
    ],
)
def test_photos_give_sound_graphs_and_pictures(name, changes):
    drawing = drawn(name, **changes)
    check_graph(drawing.graph, drawing.width, drawing.height)
    check_picture(drawing, drawing.width, drawing.height)


# Tone ----------------------------------------------------------------------------------------------------------------------------


@functools.cache
def tone_graph() -> tuple[np.ndarray, np.ndarray]:
    """Make the Delaunay graph of a seeded random 30 % of lattice sites after one Lloyd step."""
    sites = stages.lattice(160, 120).sites
    chosen = np.random.default_rng(0).choice(len(sites), int(0.3 * len(sites)), replace=False)
    sites = stages.relax(sites[np.sort(chosen)], 160, 120)
    return sites, stages.triangulate(sites, 160, 120)


@pytest.mark.parametrize("value", np.arange(1, 10) / 10)
def test_alpha_1_keeps_a_flat_tone(value):
    sites, edges = tone_graph()
    labels = stages.diffuse(sites, edges, np.full(len(sites), value, np.float32), alpha=1.0)
    assert abs(labels.mean() - value) < 0.02


@on_every_photo
def test_alpha_1_keeps_the_tone_of_photos(name):
    sites, edges = tone_graph()
    means = stages.cells(sites, 160, 120, photo_luma(name, 160, 120)).means
    labels = stages.diffuse(sites, edges, means, alpha=1.0)
    assert abs(labels.mean() - means.mean()) < 0.02


@pytest.mark.parametrize("value", [0, 255])
@pytest.mark.parametrize("size", [(60, 40), (1, 1), (5, 1), (2, 2)])
def test_black_and_white_are_one_region(value, size):
    for made_with in (gs.Options(), gs.Options.preset("paper"), gs.Options(nodes=3), options_with(relax=3, lattice="square")):
        drawing = gs.draw(np.full(size[::-1], value, np.uint8), options=made_with)
        assert (drawing.stats["regions"], drawing.stats["stipples"]) == (1, 0)
        # The border is part of it: no fringe.
        assert (drawing.rasterize() == value).all()
        assert (drawing.rasterize(3 * size[0]) == value).all()
        check_picture(drawing, *size)


def white_share(drawing: gs.Drawing) -> float:
    """Share of the canvas that is white, by area."""
    dots = [oracles.dot((row["x"], row["y"], row["radius"]), drawing.width, drawing.height).area for row in drawing.stipples]
    white = sum(region.area for region in drawing.regions if region.ink == 1)
    white += sum(area for area, ink in zip(dots, drawing.stipples["ink"], strict=True) if ink == 1)
    return white / (drawing.width * drawing.height)


@pytest.mark.parametrize("value", [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9])
def test_flat_images_give_their_tone_without_stippling(value):
    # Saliency is 0 everywhere here, so without the starvation rules nothing would be drawn.
    drawing = gs.draw(np.full((90, 120), value, np.float32), options=options_with(alpha=1.0, stippling=0))
    assert drawing.stats["nodes"] == pytest.approx(0.3 * 90 * 120, rel=0.02)
    # Labels keep it, and outlines do not quite.
    assert white_share(drawing) == pytest.approx(value, abs=0.025)


@pytest.mark.parametrize(("value", "expected"), [(0.1, 0.0), (0.2, 0.03), (0.3, 0.26), (0.4, 0.53), (0.45, 0.7), (0.49, 0.725)])
def test_dynamic_alpha_treats_black_and_white_alike(value, expected):
    # It drops half the error of a flat field, and all of it where the label fell on the other side, so the tone of flat
    # greys is not kept; but dark and light are each other's mirror image.
    plain = options_with(alpha="dynamic", refine=0, split=0, stippling=0)
    dark, light = (gs.draw(np.full((90, 120), v, np.float32), options=plain) for v in (value, 1 - value))
    assert white_share(dark) == pytest.approx(1 - white_share(light), abs=0.005)
    assert white_share(dark) == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize("size", [(1, 1), (2, 1), (2, 2), (3, 3), (5, 4)])
def test_tiny_images_give_their_tone(size):
    # Even a single pixel has nodes enough for a dot with room for a third of the canvas.
    for value in (0.0, 0.05, 0.2, 0.3, 0.7, 0.8, 0.95, 1.0):
        drawing = gs.draw(np.full(size[::-1], value, np.float32))
        assert white_share(drawing) == pytest.approx(value, abs=0.0015)
        assert drawing.rasterize(64 * size[0]).mean() / 255 == pytest.approx(white_share(drawing), abs=0.001)
    # Nearer to middle grey its dots are as large as their neighbours let them: at most as large as asked for, in both inks alike.
    for value in (0.35, 0.4, 0.45):
        dark, light = (white_share(gs.draw(np.full(size[::-1], v, np.float32))) for v in (value, 1 - value))
        assert dark == pytest.approx(1 - light, abs=1e-3)
        assert 0.34 < dark < value + 1e-3


@pytest.mark.parametrize("size", EXTREME_SIZES)
@pytest.mark.parametrize("changes", [{}, {"density": 1.0}, {"density": 0.02, "relax": 2}, {"lattice": "square", "nodes": 3}])
def test_extreme_shapes(size, changes):
    image = noise(size[0], *size)
    drawing = gs.draw(image, options=options_with(**changes))
    check_graph(drawing.graph, *size)
    check_picture(drawing, *size)
    assert drawing.rasterize().shape == (size[1], size[0])
    assert ElementTree.fromstring(drawing.svg()).get("viewBox") == f"0 0 {size[0]} {size[1]}"


# Node budget ---------------------------------------------------------------------------------------------------------------------


@on_every_photo
@pytest.mark.parametrize("changes", [{"nodes": 900}, {"nodes": 3000, "density": 2.0}, {"nodes_per_pixel": 0.15}, {}])
def test_node_budget(name, changes):
    drawing = drawn(name, 160, 120, **changes)
    # Without any of the three the budget is 0.3 nodes a pixel.
    budget = changes.get("nodes", changes.get("nodes_per_pixel", 0.3) * 160 * 120)
    assert drawing.stats["nodes"] == pytest.approx(budget, rel=0.02)


def test_a_density_alone_sets_no_budget():
    assert drawn("camera", density=1.0).stats["node_budget"] is None
    assert gs.draw(photo("camera", 120, 90), options=gs.Options.preset("paper")).stats["node_budget"] is None


# Border --------------------------------------------------------------------------------------------------------------------------


def frame_blocks(values: np.ndarray, depth: int, thickness: int = 2, length: int = 12) -> np.ndarray:
    """Means over blocks `thickness` deep and `length` long of the frame that lies `depth` pixels inside."""
    inner = values[depth : values.shape[0] - depth, depth : values.shape[1] - depth]
    strips = [inner[:thickness], inner[-thickness:], inner[:, :thickness].T, inner[:, -thickness:].T]
    return np.concatenate(
        [strip[:, : strip.shape[1] // length * length].reshape(thickness, -1, length).mean(axis=(0, 2)) for strip in strips]
    )


def fringe(error: np.ndarray) -> float:
    """Compare the outermost 2 px with the 20 frames inside it, in mean in spread: 1 is as far as the farthest strays."""
    blocks = [frame_blocks(error, depth) for depth in range(0, 42, 2)]
    strays = []
    for statistic in (np.array([b.mean() for b in blocks]), np.array([b.std() for b in blocks])):
        inside = statistic[1:]
        strays.append(abs(statistic[0] - inside.mean()) / np.abs(inside - inside.mean()).max())
    return max(strays)


@on_every_photo
@pytest.mark.parametrize(
    "made_with", [options_with(alpha=1.0), options_with("paper"), options_with("paper", alpha=1.0)], ids=range(3)
)
def test_no_fringe_at_the_border(name, made_with):
    # What the raster has more or less than the photo. The frames of a photo are no random draws, so half as far again is allowed.
    width, height = 240, 180
    raster = gs.draw(photo(name, width, height), options=made_with).rasterize() / 255.0
    tone = photo_luma(name, width, height)
    assert fringe(raster - tone) < 1.5
    # A line one pixel wide would be seen.
    for line in (0, 1):
        framed = np.pad(raster[1:-1, 1:-1], 1, constant_values=line)
        assert fringe(framed - tone) > 1.5


# Raster and SVG ------------------------------------------------------------------------------------------------------------------


@on_every_photo
@pytest.mark.parametrize("changes", [{"density": 1.0}, {"alpha": 1.0}])
def test_raster_is_what_resvg_paints(name, changes):
    drawing = drawn(name, **changes)
    # Fine enough that antialiasing and the few sides that resvg gives a small circle hardly count.
    theirs = oracles.box_average(readers.svg(drawing.svg(), 8 * drawing.width), 8)
    fine = oracles.box_average(drawing.rasterize(8 * drawing.width), 8)
    assert fine.shape == theirs.shape == (drawing.height, drawing.width)
    assert np.abs(fine - theirs).mean() < 2
    assert np.abs(fine - theirs).max() < 32
    assert abs(fine.mean() - theirs.mean()) < 0.5
    # At the image's own size a pixel that several boundaries cross shows the levels blended, by either renderer.
    plain = drawing.rasterize()
    assert np.abs(plain - readers.svg(drawing.svg(), drawing.width).astype(float)).mean() < 4
    assert abs(plain.mean() - theirs.mean()) < 1


@pytest.mark.parametrize("name", ["camera", "coffee"])
def test_raster_is_the_covered_area(name):
    """The layered picture of the raster equals the flat one: each pixel is white by as much as white regions and dots cover it."""
    drawing = drawn(name, 40, 30, density=1.0)
    shapes = [shape for shape, region in zip(polygons(drawing), drawing.regions, strict=True) if region.ink == 1]
    shapes += [oracles.dot((r["x"], r["y"], r["radius"]), 40, 30) for r in drawing.stipples if r["ink"] == 1]
    white = shapely.union_all(shapes)
    shapely.prepare(white)
    x, y = np.meshgrid(np.arange(40), np.arange(30))
    covered = 255 * shapely.area(shapely.intersection(white, shapely.box(x, y, x + 1, y + 1)))
    fine = oracles.box_average(drawing.rasterize(160), 4)
    assert np.abs(fine - covered).mean() < 2
    assert np.abs(fine - covered).max() < 24
    assert np.abs(drawing.rasterize() - covered).mean() < 3


@pytest.mark.parametrize("width", [30, 61, 120, 500])
def test_raster_sizes(width):
    drawing = drawn("coffee")
    assert drawing.rasterize(width).shape == (int(width * 90 / 120 + 0.5), width)
    assert drawing.rasterize(width).dtype == np.uint8
    assert drawing.rasterize(width).mean() == pytest.approx(drawing.rasterize().mean(), abs=2)


def test_svg_is_valid_and_says_how_it_was_made():
    drawing = drawn("rocket", density=0.8, relax=2, k2=0.25)
    root = ElementTree.fromstring(drawing.svg())
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    assert (root.get("width"), root.get("height"), root.get("viewBox")) == ("120", "90", "0 0 120 90")
    metadata = root.find("{http://www.w3.org/2000/svg}metadata")
    made = json.loads("".join(metadata.itertext()))
    assert made["version"] == gs.__version__
    assert made["importance"] == "saliency"
    assert made["options"]["published"]["k2"] == 0.25
    assert "threads" not in made["options"]
    published = gs.Published(**made["options"].pop("published"))
    again = gs.draw(photo("rocket", 120, 90), options=gs.Options(published=published, **made["options"]))
    assert again.svg() == drawing.svg()


@pytest.mark.parametrize("name", ["chelsea", "coffee"])
@pytest.mark.parametrize("changes", [{}, {"density": 1.0}, {"nodes_per_pixel": 0.25, "relax": 2}])
def test_the_drawing_does_not_depend_on_the_number_of_threads(name, changes):
    image = photo(name, 300, 200)
    drawings = [gs.draw(image, options=options_with(threads=threads, **changes)) for threads in (1, 2, 4, None)]
    assert len({drawing.svg() for drawing in drawings}) == 1
    assert len({drawing.rasterize().tobytes() for drawing in drawings}) == 1


MAP_ALONE = {"detail": 0.0, "floor": 0.0, "midtones": 0.0}
"""Options that take the importance as it is given."""


def test_an_inverted_photo_has_inverted_tones_at_the_same_nodes():
    image = photo("camera", 80, 60)
    plain = gs.draw(image)
    inverted = gs.draw(255 - image, importance=plain.importance, options=gs.Options(invert=True, **MAP_ALONE))
    assert (inverted.graph.sites == plain.graph.sites).all()
    np.testing.assert_allclose(inverted.graph.tone, plain.graph.tone, atol=1e-6)
