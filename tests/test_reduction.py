"""Photos with far more pixels than their nodes can use: reduced while they are read, and drawn on the whole canvas."""

import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from tests import commands, soundness
from tests.support import options_with, photo

import graphstipple as gs
from graphstipple import _core
from graphstipple._inputs import NOTHING, read_photo

WHITE = (255, 255, 255)

FACTORS = {4000: 3, 20_000: 2, 100_000: 1}
"""By how much the photo below is reduced for so many nodes; no side can be divided by any of them without a remainder."""


@pytest.fixture(scope="module")
def large() -> NDArray[np.uint8]:
    """Return photos side by side, (1399, 1801, 3)."""
    row = np.hstack([photo("astronaut"), photo("coffee", 512, 400)[:, ::-1].repeat(2, axis=0)[:512], photo("astronaut")[::-1]])
    return np.ascontiguousarray(np.tile(row, (3, 2, 1))[:1399, :1801])


def boxed(values: NDArray[Any], factor: int) -> NDArray[np.float32]:
    """Return the means of boxes, the slow way: the last of a row or column take the remainder."""
    edges = [np.arange(max(1, side // factor)) * factor for side in values.shape]
    sums = np.add.reduceat(np.add.reduceat(values.astype(np.float64), edges[0], axis=0), edges[1], axis=1)
    sizes = [np.diff([*edge, side]) for edge, side in zip(edges, values.shape, strict=True)]
    return (sums / np.outer(*sizes)).astype(np.float32)


def reading(options: gs.Options | None) -> _core.Reading:
    """Return how a photo is read that is drawn with these options, or with none."""
    return _core.Reading(WHITE, options._checked if options else None, _core.MAX_PIXELS, False)


def same(made: gs.Drawing, expected: gs.Drawing) -> bool:
    """Whether two drawings agree in files, data and counts, but for seconds and what has decoded the file."""
    counts = [
        {name: value for name, value in drawing.stats.items() if name not in {"seconds", "decoder"}} for drawing in (made, expected)
    ]
    return (
        made.svg() == expected.svg()
        and made.json() == expected.json()
        and counts[0] == counts[1]
        and all(np.array_equal(*pair) for pair in zip(made.graph, expected.graph, strict=True))
        and np.array_equal(made.importance, expected.importance)
    )


@pytest.mark.parametrize(("nodes", "factor"), FACTORS.items())
def test_each_pixel_that_is_drawn_is_the_mean_of_a_box(large: NDArray[np.uint8], nodes: int, factor: int) -> None:
    seen: list[NDArray[np.float32]] = []

    def importance(luma: NDArray[np.float32]) -> str:
        seen.append(luma)
        return "none"

    drawing = gs.draw(large, importance, gs.Options(nodes=nodes))
    expected = boxed(gs.stages.tone(large), factor)
    np.testing.assert_array_equal(seen[0], expected)
    assert drawing.stats["reduction"] == factor
    assert drawing.stats["node_budget"] == nodes
    assert drawing.stats["nodes"] == pytest.approx(nodes, rel=0.01)
    assert drawing.options == gs.Options(nodes=nodes)


def test_files_images_and_arrays_give_one_drawing(large: NDArray[np.uint8], tmp_path: Path) -> None:
    options = gs.Options(nodes=4000)
    by_array = gs.draw(large, options=options)
    paths = [tmp_path / f"photo.{suffix}" for suffix in ("png", "tif")]
    for path in paths:
        Image.fromarray(large).save(path)
    for other in [*paths, Image.fromarray(large), large.astype(np.uint16) * 257, large[:, ::-1][:, ::-1]]:
        assert same(gs.draw(other, options=options), by_array)
    wide = gs.draw(large / np.float32(255), options=options)
    assert wide.stats["reduction"] == by_array.stats["reduction"] == 3
    # And on the command line.
    written = commands.done(commands.native_binary(), paths[0], "-o", "-", "--nodes", 4000).stdout.decode()
    assert written == by_array.svg()


@pytest.mark.parametrize("importance", ["saliency", "none", "map"])
@pytest.mark.parametrize("options", [{"nodes": 4000}, {"nodes": 900, "irregularity": 0.5, "tolerance": 0.0}])
def test_drawings_fill_the_whole_canvas(large: NDArray[np.uint8], importance: str, options: dict[str, Any], tmp_path: Path) -> None:
    given: Any = {"map": large[::2, ::2, 1]}.get(importance, importance)
    drawing = gs.draw(large, given, gs.Options(**options))
    assert (drawing.width, drawing.height, drawing.stats["reduction"]) == (1801, 1399, 3)
    assert (drawing.stats["width"], drawing.stats["height"]) == (1801, 1399)
    soundness.check_picture(drawing, 1801, 1399)
    sites = drawing.graph.sites
    assert (sites.min(axis=0) > 0).all()
    assert (sites.max(axis=0) < [1801, 1399]).all()
    assert (sites.max(axis=0) > [1740, 1340]).all()
    assert drawing.importance.shape == (1399, 1801)
    np.testing.assert_array_equal(drawing.importance[::3, ::3][:466, :600], drawing.importance[2::3, 2::3][:466, :600])
    assert (drawing.importance[-1] == drawing.importance[-4]).all()
    for suffix in ("svg", "json"):
        path = tmp_path / f"drawing.{suffix}"
        drawing.save(path)
        again = gs.load(path)
        assert (again.svg(), again.json()) == (drawing.svg(), drawing.json())


def test_lengths_in_options_are_pixels_of_the_canvas(large: NDArray[np.uint8]) -> None:
    plain = gs.draw(large, options=gs.Options(nodes=4000)).stipples["radius"]
    assert plain.max() > 7
    limited = gs.draw(large, options=gs.Options(nodes=4000, stipple_min=3.0, stipple_max=7.0)).stipples["radius"]
    assert limited.max() <= 7
    assert np.median(limited) >= 3
    # Half as many lattice nodes to a pixel are as many on the raster as they would be on the canvas.
    sparse = gs.draw(large, "none", options_with(density=0.005))
    assert sparse.stats["reduction"] == 3
    assert sparse.stats["density"] == 0.005
    assert sparse.stats["lattice_nodes"] == pytest.approx(0.005 * 1801 * 1399, rel=0.01)


@pytest.mark.parametrize("importance", ["saliency", "callable", "map"])
def test_a_session_draws_what_draw_draws_at_every_number_of_nodes(large: NDArray[np.uint8], importance: str) -> None:
    given: Any = {"callable": lambda luma: 1 - luma, "map": large[..., 1]}.get(importance, importance)
    session = gs.Session(large, given)
    # Only another reduction reads the photo again. None at all is slow, and tried once.
    whole = [({"nodes": 100_000}, True)] if importance == "saliency" else []
    changes: list[tuple[dict[str, Any], bool]] = [
        ({"nodes": 4000}, True),
        ({"nodes": 4000, "shading": 0.4}, False),
        *whole,
        ({"nodes": 20_000}, True),
        ({"fineness": 0.1}, False),
        ({"nodes_per_pixel": 0.002}, True),
    ]
    for change, is_read_again in changes:
        options = gs.Options(**change)
        drawing = session.draw(options)
        assert same(drawing, gs.draw(large, given, options))
        assert ("decoding" in drawing.stats["seconds"]) == is_read_again, change


def test_a_map_is_reduced_by_its_own_size(large: NDArray[np.uint8], small: NDArray[np.uint8], tmp_path: Path) -> None:
    path = tmp_path / "map.png"
    Image.fromarray(large).save(path)
    grey = np.asarray(Image.fromarray(large).convert("L"))
    session, of_file = gs.Session(small, grey), gs.Session(small, path)
    for nodes in (2000, 30_000, 900):
        options = gs.Options(nodes=nodes)
        drawing = gs.draw(small, grey, options)
        assert drawing.stats["reduction"] == 1
        assert same(session.draw(options), drawing)
        assert same(of_file.draw(options), gs.draw(small, path, options))
    factors = [read_photo(grey, reading(gs.Options(nodes=nodes)))[0].factor for nodes in (2000, 30_000)]
    assert factors == [3, 2]


def test_threads_with_different_reductions_share_a_session(large: NDArray[np.uint8]) -> None:
    options = [gs.Options(nodes=nodes) for nodes in (4000, 20_000)]
    expected = [gs.draw(large, options=one) for one in options]
    session = gs.Session(large)
    wrong: list[object] = []

    def work(start: int) -> None:
        try:
            wrong.extend(i for i in range(start, start + 4) if not same(session.draw(options[i % 2]), expected[i % 2]))
        except BaseException as error:
            wrong.append(error)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_what_is_read_without_options_is_whole(large: NDArray[np.uint8]) -> None:
    assert gs.stages.tone(large).shape == (1399, 1801)
    whole = _core.photo(large, NOTHING, reading(None))
    assert (whole.size, whole.factor, whole.luma.shape) == ((1801, 1399), 1, (1399, 1801))
    reduced = _core.photo(large, NOTHING, reading(gs.Options(nodes=4000)))
    assert (reduced.size, reduced.factor, reduced.luma.shape) == ((1801, 1399), 3, (466, 600))
