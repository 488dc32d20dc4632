"""The drawing as Python users hold it: files, pictures, data, progress, interrupts."""

import os
import re
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from tests.support import options_with

import graphstipple as gs
from graphstipple import drawing as drawing_module

# A drawing that takes seconds: to be interrupted, or watched.
LONG = """
import signal
# A test run in the background of a shell hands down an ignored Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)
import graphstipple as gs, numpy as np
noise = np.random.default_rng(1).integers(0, 256, (2000, 3000)).astype(np.uint8)
options = gs.Options(published=gs.Options().published.replace(density=1.0), relax=20)
"""


@pytest.fixture(scope="module")
def drawing(small: np.ndarray) -> gs.Drawing:
    return gs.draw(small)


def test_everything_promised_exists() -> None:
    assert all(hasattr(gs, name) for name in gs.__all__)
    assert all(hasattr(gs.stages, name) for name in gs.stages.__all__)
    assert all(hasattr(gs.metrics, name) for name in gs.metrics.__all__)
    assert re.fullmatch(r"\d+\.\d+\.\d+.*", gs.__version__)


HEAVY = {"PIL", "cv2", "json", "numpy", "scipy", "shapely"}
"""Packages that take long to import."""

ON_DEMAND = {f"graphstipple.{name}" for name in ("importance", "metrics", "stages", "subject")}
"""Parts of the package that a drawing does not need."""


def imported(program: str) -> set[str]:
    """Return what a program imports in a fresh interpreter, of the above."""
    lines = ["import sys", "before = set(sys.modules)", program, "print(*(set(sys.modules) - before))"]
    run = subprocess.run([sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    return set(run.stdout.split()) & (HEAVY | ON_DEMAND)


def test_importing_is_light() -> None:
    assert imported("import graphstipple") == set()
    assert imported("import graphstipple as gs\ngs.__version__, gs.GraphStippleError, dir(gs)") == set()


def test_drawing_needs_numpy_alone(small: np.ndarray, tmp_path: Path) -> None:
    Image.fromarray(small).save(tmp_path / "photo.png")
    lines = [
        "import graphstipple as gs, numpy as np",
        f"for photo in (np.linspace(0, 1, 4800).reshape(60, 80), {str(tmp_path / 'photo.png')!r}):",
        "    drawing = gs.Session(photo).draw(gs.draw(photo, options=gs.Options.preset('linocut')).options)",
        "    drawing.save('out.svg'), drawing.save('out.png'), drawing.rasterize(), drawing.stats, drawing.graph, drawing.stipples",
        "    gs.load('out.svg').options",
    ]
    folder = f"import os; os.chdir({str(tmp_path)!r})"
    assert imported("\n".join([folder, *lines])) == {"numpy"}


@pytest.mark.parametrize(
    ("name", "use"),
    [
        ("stages", "assert gs.stages.tone(grey).shape == (2, 2) and gs.stages is sys.modules['graphstipple.stages']"),
        ("metrics", "assert gs.metrics.psnr(grey, grey) == np.inf and gs.metrics is sys.modules['graphstipple.metrics']"),
        (
            "importance",
            "assert gs.saliency(grey).shape == (2, 2) and gs.saliency is sys.modules['graphstipple.importance'].saliency",
        ),
        ("subject", "assert gs.find_subject(grey) is None and gs.subject.SIDE > 100"),
    ],
)
def test_what_a_drawing_does_not_need_is_imported_when_it_is_used(name: str, use: str) -> None:
    start = ["import graphstipple as gs, numpy as np", "grey = np.array([[0.0, 0.5], [0.5, 1.0]])"]
    check = ["assert set(gs.__all__) <= set(dir(gs))", f"assert not {ON_DEMAND} & set(sys.modules)"]
    assert imported("\n".join([*start, *check, use])) & ON_DEMAND == {f"graphstipple.{name}"}
    assert imported(f"import graphstipple.{name}") & ON_DEMAND == {f"graphstipple.{name}"}


def test_a_star_imports_all_names() -> None:
    imported("from graphstipple import *\nassert callable(draw) and callable(saliency) and callable(stages.tone) and metrics.psnr")


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'graphstipple' has no attribute 'drew'"):
        gs.drew  # noqa: B018
    assert not hasattr(gs, "_later")
    with pytest.raises(ImportError, match="cannot import name 'drew'"):
        exec("from graphstipple import drew")


def test_size_and_rasters(drawing: gs.Drawing) -> None:
    assert (drawing.width, drawing.height) == (128, 96)
    own = drawing.rasterize()
    assert own.shape == (96, 128)
    assert own.dtype == np.uint8
    assert drawing.rasterize(256).shape == (192, 256)
    assert drawing.rasterize(width=np.int64(64)).shape == (48, 64)
    for wrong in [0, -5, 1.5, "wide", True, 2**40]:
        with pytest.raises(gs.InvalidInputError, match="width"):
            drawing.rasterize(wrong)  # type: ignore[arg-type]


def test_tone_is_kept(astronaut: np.ndarray) -> None:
    tone = np.asarray(Image.fromarray(astronaut).convert("L")).mean()
    for importance in ("saliency", "none"):
        # A hundredth of the way from black to white, as the default tone tolerance has it.
        assert gs.draw(astronaut, importance=importance).rasterize().mean() == pytest.approx(tone, abs=2.55)


def test_save_by_suffix(drawing: gs.Drawing, tmp_path: Path) -> None:
    drawing.save(tmp_path / "out.svg")
    assert (tmp_path / "out.svg").read_text() == drawing.svg()
    drawing.save(str(tmp_path / "out.png"))
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "out.png")), drawing.rasterize())
    drawing.save(tmp_path / "wide.PNG", width=300)
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "wide.PNG")), drawing.rasterize(300))
    drawing.save(tmp_path / "narrow.png", np.int64(64))
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "narrow.png")), drawing.rasterize(64))
    others = {"out.pdf": b"%PDF-", "out.eps": b"%!PS-Adobe", "out.dxf": b"999\ngraphstipple ", "out.json": b"{"}
    for name, beginning in others.items():
        drawing.save(tmp_path / name)
        assert (tmp_path / name).read_bytes().startswith(beginning)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(["narrow.png", "out.png", "out.svg", "wide.PNG", *others])


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"width": "wide"}, 'width is "wide", but it must be a number'),
        ({"width": "-5mm"}, 'width is "-5mm", but it must be'),
        ({"width": 0}, "width is 0"),
        ({"width": float("inf")}, "width is inf, but it must be a number, at least 0, with mm, cm, in, pt or px"),
        ({"width": True}, "width is True, but it must be a number, at least 0, with mm, cm, in, pt or px"),
        ({"width": [5]}, r"width is \[5\], but it must be a number, at least 0, with mm, cm, in, pt or px"),
        ({"margin": "1 parsec"}, 'margin is "1 parsec", but it must be'),
        ({"margin": -1}, "margin is -1"),
        ({"page": "A9"}, 'page is "A9", but it must be A3, A4'),
        ({"page": 4}, "page is 4, but it must be A3, A4"),
        ({"page": "A6", "width": "200mm"}, "page"),
        ({"page": "A6", "margin": "60mm"}, "margin of 60mm"),
        ({"dpi": 0}, "dpi is 0"),
        ({"dpi": "fine"}, 'dpi is "fine", but it must be a number between 1 and 10000 pixels per inch'),
        ({"style": "round"}, 'style is "round", but it must be "flat" or "layered"'),
        ({"style": 1}, 'style is 1, but it must be "flat" or "layered"'),
        ({"only": "red"}, "only is red, but it must be inks of the drawing or its paper, .*: black, white"),
        ({"style": "layered", "only": "white"}, "only is white"),
        ({"one_bit": "yes"}, 'one_bit is "yes", but it must be True or False'),
    ],
)
def test_sizes_and_styles_that_are_none(drawing: gs.Drawing, tmp_path: Path, wrong: dict[str, Any], message: str) -> None:
    for suffix in ("svg", "pdf", "png"):
        with pytest.raises(gs.InvalidInputError, match=message):
            drawing.save(tmp_path / f"out.{suffix}", **wrong)
    if not {"dpi", "one_bit"} & set(wrong):
        with pytest.raises(gs.InvalidInputError, match=message):
            drawing.svg(**wrong)
    assert list(tmp_path.iterdir()) == []


def test_what_cannot_be_saved_leaves_nothing_behind(drawing: gs.Drawing, tmp_path: Path) -> None:
    for name in ["out.bmp", "out"]:
        with pytest.raises(gs.InvalidInputError):
            drawing.save(tmp_path / name)
    with pytest.raises(FileNotFoundError) as missing:
        drawing.save(tmp_path / "no" / "such" / "folder.svg")
    assert isinstance(missing.value, gs.GraphStippleError)
    (tmp_path / "folder.svg").mkdir()
    with pytest.raises(gs.ImageFileError):
        drawing.save(tmp_path / "folder.svg")
    assert [path.name for path in tmp_path.iterdir()] == ["folder.svg"]
    with pytest.raises(gs.InvalidInputError, match="width"):
        drawing.save(tmp_path / "out.png", width=0)


def test_an_existing_file_is_replaced_whole(drawing: gs.Drawing, tmp_path: Path) -> None:
    path = tmp_path / "out.svg"
    path.write_text("x" * 10_000_000)
    drawing.save(path)
    assert path.read_text() == drawing.svg()
    assert len(list(tmp_path.iterdir())) == 1


def test_marks_as_data(drawing: gs.Drawing) -> None:
    stipples, regions = drawing.stipples, drawing.regions
    assert stipples.dtype.names == ("x", "y", "radius", "ink")
    assert len(stipples) == drawing.stats["stipples"]
    assert len(regions) == drawing.stats["regions"]
    assert (stipples["radius"] > 0).all()
    assert set(stipples["ink"]) <= {0, 1}
    assert ((stipples["x"] >= 0) & (stipples["x"] <= drawing.width)).all()
    for region in regions:
        assert region.exterior.shape[1] == 2
        assert len(region.exterior) >= 3
        assert region.area > 0
        assert region.ink in {0, 1}
        assert all(hole.shape[1] == 2 for hole in region.holes)
    assert regions[-1].area == regions[len(regions) - 1].area
    assert [region.ink for region in regions[:3]] == [regions[i].ink for i in range(3)]
    with pytest.raises(IndexError):
        regions[len(regions)]


def test_graph_and_importance(drawing: gs.Drawing) -> None:
    graph = drawing.graph
    nodes = drawing.stats["nodes"]
    assert graph.sites.shape == (nodes, 2)
    assert graph.edges.dtype == np.uint32
    assert graph.edges.max() < nodes
    assert (graph.edges[:, 0] < graph.edges[:, 1]).all()
    assert graph.tone.shape == graph.labels.shape == graph.components.shape == (nodes,)
    assert set(np.unique(graph.labels)) <= {0, 1}
    assert len(np.unique(graph.components)) == drawing.stats["stipples"] + drawing.stats["regions"]
    assert drawing.importance.shape == (96, 128)


def test_the_stages_make_the_same_drawing(small: np.ndarray) -> None:
    made_with = options_with(density=1.0)
    drawing = gs.draw(small, options=made_with)
    tone = gs.stages.tone(small)
    np.testing.assert_array_equal(gs.stages.importance(tone, gs.saliency(small), made_with), drawing.importance)
    first = gs.stages.lattice_labels(drawing.importance, made_with)
    height, width = small.shape[:2]
    samples = gs.stages.samples_per_pixel(1.0)
    sites = gs.stages.relax(first.sites[first.labels == 1], width, height, 1, samples)
    np.testing.assert_array_equal(sites, drawing.graph.sites)
    np.testing.assert_array_equal(gs.stages.triangulate(sites, width, height), drawing.graph.edges)
    cells = gs.stages.cells(sites, width, height, gs.stages.emphasize(tone, made_with), samples)
    tones = cells.means
    np.testing.assert_array_equal(tones, drawing.graph.tone)
    edges, plain = drawing.graph.edges, gs.stages.cells(sites, width, height, tone, samples).means
    grounds = gs.stages.grounds(sites, edges, plain)
    smooth = grounds < 2
    assert 0.1 < smooth.mean() < 0.9
    shapes = np.where(smooth, grounds, tones).astype(np.float32)
    labels = gs.stages.diffuse(sites, edges, shapes, areas=cells.areas)
    labels[smooth] = grounds[smooth]
    mean = np.average(plain[~smooth], weights=cells.areas[~smooth])
    labels, _ = gs.stages.refine(edges, shapes, labels, areas=cells.areas, grounds=grounds, mean=mean)
    labels = gs.stages.clean(edges, plain, gs.stages.split(edges, shapes, labels))
    labels, places, areas = gs.stages.stipple(sites, grounds, plain, width, height, labels=labels, areas=cells.areas)
    np.testing.assert_array_equal(labels, drawing.graph.labels)
    np.testing.assert_array_equal(gs.stages.components(drawing.graph.edges, labels), drawing.graph.components)
    outline = gs.stages.outline(sites, labels, width, height, areas=areas, tones=tones, places=places)
    np.testing.assert_array_equal(outline.stipples, drawing.stipples)
    assert [region.area for region in outline.regions] == [region.area for region in drawing.regions]


def test_a_callable_makes_the_importance_from_the_luma(small: np.ndarray) -> None:
    seen: list[np.ndarray] = []

    def left_half(luma: np.ndarray) -> np.ndarray:
        seen.append(luma)
        map_ = np.full_like(luma, 0.1)
        map_[:, :64] = 1.0
        return map_

    drawing = gs.draw(small, importance=left_half)
    np.testing.assert_array_equal(seen[0], gs.stages.tone(small))
    assert drawing.svg() == gs.draw(small, importance=left_half(seen[0])).svg()
    # A map is a factor: what it finds unimportant gets far fewer nodes.
    left = (drawing.graph.sites[:, 0] < 64).mean()
    assert left > 0.7
    assert gs.draw(small, importance=lambda _: "none").svg() == gs.draw(small, importance="none").svg()
    with pytest.raises(gs.InvalidInputError, match="importance has the shape"):
        gs.draw(small, importance=lambda luma: np.stack([luma, luma]))


def test_a_drawing_knows_what_made_it(small: np.ndarray) -> None:
    made_with = options_with(k1=0.5, tolerance=0.5, threads=2)
    drawing = gs.draw(small, options=made_with)
    assert drawing.options == made_with
    assert drawing.version == gs.__version__
    assert repr(drawing) == (f"<graphstipple.Drawing 128 x 96: {len(drawing.stipples)} stipples, {len(drawing.regions)} regions>")


def test_stats(drawing: gs.Drawing) -> None:
    stats = drawing.stats
    for name in ["stipples", "regions", "nodes", "vertices", "anchors", "coordinates", "width", "height"]:
        assert isinstance(stats[name], int), name
    seconds = stats["seconds"]
    assert {"decoding", "saliency", "total"} <= set(seconds)
    assert seconds["total"] >= max(value for name, value in seconds.items() if name != "total")


def test_notebooks_get_exactly_one_picture(drawing: gs.Drawing, monkeypatch: pytest.MonkeyPatch, small: np.ndarray) -> None:
    # The layered picture brings its own paper: black ink alone is lost on a dark page.
    assert drawing._repr_svg_() == drawing.svg(style="layered")
    assert drawing._repr_png_() is None
    monkeypatch.setattr(drawing_module, "HEAVY_SVG_BYTES", 1000)
    heavy = gs.draw(small)
    assert heavy._repr_svg_() is None
    png = heavy._repr_png_()
    assert png is not None
    assert png.startswith(b"\x89PNG")


def test_progress_runs_from_zero_to_one(astronaut: np.ndarray) -> None:
    reports: list[tuple[str, float]] = []
    gs.draw(astronaut, options=options_with(density=1.0), progress=lambda stage, fraction: reports.append((stage, fraction)))
    stages = list(dict.fromkeys(stage for stage, _ in reports))
    assert stages[0] == "decoding"
    assert len(stages) > 2
    assert stages[-1] == "outlines"
    fractions = [fraction for _, fraction in reports]
    assert fractions == sorted(fractions)
    assert fractions[0] == 0
    assert fractions[-1] == 1
    assert len(reports) > 3


def test_an_exception_in_the_callback_stops_the_work() -> None:
    noise = np.random.default_rng(1).integers(0, 256, (300, 400)).astype(np.uint8)

    class StopError(Exception):
        pass

    reports = []

    def stop(stage: str, fraction: float) -> None:
        reports.append(stage)
        if fraction > 0:
            raise StopError

    with pytest.raises(StopError):
        gs.draw(noise, importance="none", options=options_with(density=1.0, relax=5), progress=stop)
    # Nothing is told after it, and the last stage was not reached.
    assert "outlines" not in reports
    before = len(reports)
    gs.draw(noise)
    assert len(reports) == before


def test_other_threads_run_while_drawing(astronaut: np.ndarray) -> None:
    was_done: list[bool] = []
    done, may_go = threading.Event(), threading.Lock()

    def look() -> None:
        with may_go:
            was_done.append(done.is_set())

    may_go.acquire()
    thread = threading.Thread(target=look)
    thread.start()
    before = sys.getswitchinterval()
    # Python itself gives the lock to no other thread for so long: the other one runs only while the drawing lets go of it.
    sys.setswitchinterval(600)
    try:
        may_go.release()
        gs.draw(astronaut, importance="none", options=options_with(density=2.0, threads=1))
        done.set()
    finally:
        sys.setswitchinterval(before)
        thread.join()
    assert was_done == [False]


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX signals")
@pytest.mark.parametrize("at", ["saliency", "importance", "relaxation"])
def test_ctrl_c_stops_the_work(at: str) -> None:
    program = LONG + (
        f"def say(stage, fraction):\n    print(stage, flush=True)\n    if stage == {at!r}:\n        print('now', flush=True)\n"
        "try:\n    gs.draw(noise, options=options, progress=say)\n"
        "except KeyboardInterrupt:\n    print('interrupted', flush=True)\n"
    )
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        while process.stdout.readline() not in {"now\n", ""}:
            pass
        os.kill(process.pid, signal.SIGINT)
        rest, errors = process.communicate(timeout=120)
    *stages, last = rest.splitlines()
    assert last == "interrupted", errors
    assert process.returncode == 0, errors
    # Ten seconds of work were still to be done.
    assert "outlines" not in stages
