"""The evaluation: photos, methods, budgets, results that are kept, failures, interruptions; the cross-validation; the ablation."""

from __future__ import annotations

import csv
import dataclasses
import html
import json
import math
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from PIL import Image
from tests import support

import graphstipple as gs
from graphstipple_eval import (
    ablation,
    baselines,
    cli,
    cross_validation,
    files,
    labyrinth,
    ours,
    photos,
    quoted,
    report,
    results,
    run,
    tables,
)
from graphstipple_eval.baselines import programs
from graphstipple_eval.method import Counts, Method, Photo, Picture
from graphstipple_eval.ours import Sweep
from graphstipple_eval.photos import PhotoFile
from graphstipple_eval.results import Failure, Result
from graphstipple_eval.selection import Selection, parse_budget, parse_names

COMMAND = [sys.executable, "-m", "graphstipple_eval"]


def write_photo(path: Path, name: str = "astronaut", width: int = 200, height: int = 176) -> Path:
    """Write a crop from the middle of one of the photos."""
    Image.fromarray(support.photo(name, width, height)).save(path)
    return path


def evaluate(*arguments: object, environment: dict[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    """Run the command to its end."""
    return subprocess.run(
        [*COMMAND, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
        env=os.environ | (environment or {}),
    )


# Photos


def test_photos_of_folders_and_single_ones_are_found_once_and_sorted(tmp_path: Path) -> None:
    (tmp_path / "in" / "deeper.png").mkdir(parents=True)
    for name in ("b.png", "A.JPG", "notes.txt"):
        (tmp_path / "in" / name).touch()
    (tmp_path / "c.webp").touch()
    found = photos.find([tmp_path / "c.webp", tmp_path / "in", tmp_path / "in" / "b.png"])
    assert [path.name for path in found] == ["A.JPG", "b.png", "c.webp"]


@pytest.mark.parametrize(
    ("names", "place", "sentence"),
    [
        (["notes.txt"], ".", "holds no photo"),
        (["a.png"], "b.png", "does not exist"),
        (["a.png", "A.jpg"], ".", "two photos have the name"),
    ],
)
def test_photos_that_cannot_be_taken_are_named(tmp_path: Path, names: list[str], place: str, sentence: str) -> None:
    for name in names:
        (tmp_path / name).touch()
    with pytest.raises(gs.InvalidInputError, match=sentence):
        photos.find([tmp_path / place])


def test_a_photo_whose_name_is_not_utf_8_is_refused(tmp_path: Path) -> None:
    name = os.fsdecode(b"caf\xe9.png")
    try:
        (tmp_path / name).touch()
    except OSError:
        pytest.skip("this file system has no such names")
    with pytest.raises(gs.InvalidInputError, match=r"the name of the photo 'caf\\udce9\.png' is not UTF-8") as refused:
        photos.find([tmp_path])
    str(refused.value).encode()


def test_a_reduced_photo_has_the_size_and_the_mean_of_the_whole_one() -> None:
    luma = support.photo_luma("coffee")
    small = photos.reduced(luma, 150)
    assert small.shape == (100, 150)
    assert small.dtype == np.uint8
    assert small.mean() / 255 == pytest.approx(luma.mean(), abs=0.002)
    # Overshoot of the filter at hard edges is clipped, not wrapped around.
    assert set(np.unique(photos.reduced(np.ones((300, 300), np.float32), 100))) == {255}


def test_a_smaller_photo_is_not_enlarged() -> None:
    luma = support.photo_luma("coffee", 90, 60)
    assert np.array_equal(photos.reduced(luma, 200), np.round(luma * 255))


def test_a_prepared_photo_is_upright_and_read_back_as_it_was_written(tmp_path: Path) -> None:
    exif = Image.Exif()
    exif[0x0112] = 6  # a camera held upright: the file has the photo on its side
    Image.fromarray(support.photo("coffee", 200, 176)).save(tmp_path / "upright.png", exif=exif)
    (prepared,) = photos.write(photos.decode([tmp_path / "upright.png"], [512], 161, tmp_path / "out"))
    assert (prepared.width, prepared.height) == (176, 200)
    assert prepared.checksum == files.checksum((tmp_path / "upright.png").read_bytes())
    photo = prepared.read()
    luma = gs.stages.tone(tmp_path / "upright.png")
    assert np.abs(photo.tone - luma).max() <= 0.5 / 255 + 1e-6
    assert np.array_equal(photo.tone, gs.stages.tone(photo.pixels))


def test_sizes_come_one_after_the_other(tmp_path: Path) -> None:
    paths = [write_photo(tmp_path / f"{name}.png", name, 300, 300) for name in ("camera", "coffee")]
    prepared = photos.write(photos.decode(paths, [200, 250], 161, tmp_path / "out"))
    assert [(photo.name, photo.size, photo.width) for photo in prepared] == [
        ("camera", 200, 200),
        ("coffee", 200, 200),
        ("camera", 250, 250),
        ("coffee", 250, 250),
    ]
    assert prepared[0].path == tmp_path / "out" / "camera-200" / "photo.png"


def test_all_photos_that_are_too_small_or_unreadable_are_named_in_one_line(tmp_path: Path) -> None:
    good, small = write_photo(tmp_path / "good.png"), write_photo(tmp_path / "small.png", height=160)
    broken, away = tmp_path / "broken.png", tmp_path / "away.png"
    broken.write_bytes(good.read_bytes()[:500])
    with pytest.raises(gs.InvalidInputError) as refused:
        photos.decode([away, broken, good, small], [512, 600], 161, tmp_path / "out")
    first, second, third = str(refused.value).split("; ")
    assert str(away) in first
    assert str(broken) in second
    assert third.startswith(f"{small} is 200 x 160 pixels at size 512, but the metrics need at least 161 a side")
    assert "\n" not in str(refused.value)


def test_a_file_with_the_same_content_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "folder" / "file"
    files.write(path, b"one")
    os.utime(path, (1, 1))
    files.write(path, b"one")
    assert path.stat().st_mtime == 1
    files.write(path, b"two")
    assert path.read_bytes() == b"two"
    assert list(path.parent.iterdir()) == [path]


# Our own methods


@pytest.fixture(scope="module")
def small_photo() -> Photo:
    pixels = support.photo("astronaut", 200, 176)
    return Photo("astronaut", "0" * 64, pixels, gs.stages.tone(pixels))


def flat(settings: dict[str, Any]) -> dict[str, object]:
    """Return settings with the published method's as `published.NAME`."""
    published = {f"published.{name}": value for name, value in settings["published"].items()}
    return {**settings, **published, "published": None}


@pytest.fixture(scope="module")
def pictures(small_photo: Photo) -> dict[str, Picture]:
    """Return the pictures of all our methods."""
    return {method.name: method.draw(small_photo, 0) for method in ours.methods(None)}


def test_our_methods_have_equal_nodes_and_ablations_change_one_thing(small_photo: Photo, pictures: dict[str, Picture]) -> None:
    default, paper = pictures[ours.DEFAULT], pictures[ours.PAPER]
    assert default.svg == gs.draw(small_photo.pixels).svg()
    assert paper.settings["published"] == dataclasses.asdict(gs.Published())
    assert paper.settings["tolerance"] == 0
    for picture in pictures.values():
        assert picture.counts.nodes == pytest.approx(0.3 * small_photo.tone.size, rel=0.02)
        assert picture.raster.shape == small_photo.tone.shape
    changed = {
        name: {key: value for key, value in flat(pictures[name].settings).items() if value != flat(paper.settings)[key]}
        for name in ours.ABLATIONS
    }
    assert changed == {
        "paper-constant-importance": {"importance": "constant:1"},
        "paper-no-relaxation": {"relax": 0},
        "paper-alpha-1": {"published.alpha": 1.0},
    }
    assert pictures["paper-alpha-1"].counts.nodes == paper.counts.nodes


def test_the_defaults_without_an_idea_have_the_paper_s_values_of_its_options_and_every_idea_is_there(
    pictures: dict[str, Picture],
) -> None:
    default, paper = (flat(dataclasses.asdict(options)) for options in (gs.Options(), gs.Options.preset("paper")))
    differing = {option for option, value in default.items() if value != paper[option]}
    differing -= {"published.density", "nodes"}
    set_back = set()
    for name in ours.WITHOUT:
        settings = flat(pictures[name].settings)
        changed = {option for option in default if settings[option] != flat(pictures[ours.DEFAULT].settings)[option]}
        assert changed, name
        assert {option: settings[option] for option in changed} == {option: paper[option] for option in changed}
        assert not changed & set_back
        set_back |= changed
    assert set_back == differing


def test_the_counts_are_those_of_the_drawing(small_photo: Photo, pictures: dict[str, Picture]) -> None:
    picture = pictures[ours.DEFAULT]
    stats = gs.draw(small_photo.pixels).stats
    for name in ("stipples", "regions", "vertices", "anchors", "coordinates", "nodes"):
        assert getattr(picture.counts, name) == stats[name]


# Labyrinths


def test_small_regions_have_2_to_12_nodes_and_are_counted_per_1000_nodes() -> None:
    nodes = np.array([1, 2, 12, 13, 1, 5])
    components = np.repeat(np.arange(6, dtype=np.uint32), nodes)
    assert labyrinth.small_regions(np.random.default_rng(1).permutation(components)) == 1000 * 3 / nodes.sum()
    assert labyrinth.small_regions(np.zeros(7, np.uint32)) == pytest.approx(1000 / 7)
    assert labyrinth.small_regions(np.arange(7, dtype=np.uint32)) == 0


def test_every_curve_counts_once_in_the_boundary_and_the_frame_does_not() -> None:
    left = np.array([[0, 0], [4, 0], [4, 8], [0, 8]], np.float64)
    right = np.array([[4, 0], [10, 0], [10, 8], [4, 8]], np.float64)
    square = np.array([[6, 2], [9, 2], [9, 5], [6, 5]], np.float64)  # in the right one, with a hole that is a region too
    triangle = np.array([[7, 3], [8, 3], [8, 4]], np.float64)
    assert labyrinth.boundary_length([left, right], 10, 8) == 8
    assert labyrinth.boundary_length([left, right, square, triangle], 10, 8) == pytest.approx(8 + 12 + 2 + math.sqrt(2))
    assert labyrinth.boundary_length([np.array([[0, 0], [10, 0], [10, 8], [0, 8]], np.float64)], 10, 8) == 0


def test_the_measures_of_a_drawing_are_those_of_its_graph_and_its_curves(small_photo: Photo, pictures: dict[str, Picture]) -> None:
    drawing = gs.draw(small_photo.pixels)
    found = labyrinth.measures(drawing)
    frame = shapely.box(0, 0, drawing.width, drawing.height).exterior
    curves = shapely.union_all([shapely.LinearRing(region.exterior) for region in drawing.regions]).difference(frame)
    nodes = len(drawing.graph.sites)
    assert found["boundary"] * nodes == pytest.approx(curves.length, rel=1e-6)
    sizes = np.bincount(drawing.graph.components)
    assert found["small_regions"] == 1000 * sum(2 <= size <= 12 for size in sizes) / nodes
    assert pictures[ours.DEFAULT].labyrinth == found


def test_a_straight_edge_is_no_labyrinth() -> None:
    pixels = np.zeros((150, 200), np.uint8)
    pixels[:, 90:] = 255
    drawing = gs.draw(pixels, options=support.options_with("paper", alpha=0.0))
    found = labyrinth.measures(drawing)
    assert found["small_regions"] == 0
    assert found["boundary"] * drawing.stats["nodes"] == pytest.approx(150, rel=0.15)


@pytest.mark.parametrize(("budget", "names"), [(1500, ()), (12_000, (ours.DEFAULT, ours.PAPER))])
def test_a_fixed_budget_is_met_by_each_of_our_methods(small_photo: Photo, budget: int, names: tuple[str, ...]) -> None:
    methods = [method for method in ours.methods(budget) if not names or method.name in names]
    assert len(methods) == (len(names) or len([ours.DEFAULT, ours.PAPER, *ours.ABLATIONS, *ours.WITHOUT]))
    for method in methods:
        picture = method.draw(small_photo, budget)
        assert picture.counts.coordinates == pytest.approx(budget, rel=ours.COORDINATES_TOLERANCE)
        assert "note" not in picture.settings


def test_a_budget_that_cannot_be_met_is_said(small_photo: Photo) -> None:
    paper = next(method for method in ours.methods(1) if method.name == ours.PAPER)
    beyond = 10 * small_photo.tone.size  # a lattice of one node a pixel does not have so many
    picture = paper.draw(small_photo, beyond)
    assert picture.counts.coordinates is not None
    assert picture.counts.coordinates < beyond
    assert str(picture.settings["note"]).startswith(f"{picture.counts.coordinates} coordinates instead of {beyond}")


@pytest.mark.parametrize(
    ("text", "values", "names"),
    [
        ("sharpen=0,2.5,6", (0.0, 2.5, 6.0), ["sharpen=0", "sharpen=2.5", "sharpen=6"]),
        ("background=black", ("black",), ["background=black"]),
        ("published.k1=0,1,2", (0.0, 1.0, 2.0), ["published.k1=0", "published.k1=1", "published.k1=2"]),
        ("published.alpha=dynamic,1", ("dynamic", 1.0), ["published.alpha=dynamic", "published.alpha=1"]),
        ("published.lattice=square", ("square",), ["published.lattice=square"]),
        ("published.density=null,2", (None, 2.0), ["published.density=None", "published.density=2"]),
        ("invert=true,false", (True, False), ["invert=True", "invert=False"]),
        ("nodes=null,5000", (None, 5000), ["nodes=None", "nodes=5000"]),
    ],
)
def test_a_sweep_is_read_by_json_or_as_text(text: str, values: tuple[object, ...], names: list[str]) -> None:
    sweep = Sweep.parse(text)
    assert sweep.values == values
    assert [method.name for method in sweep.methods(None)] == names


def test_a_sweep_changes_its_option_alone(small_photo: Photo, pictures: dict[str, Picture]) -> None:
    default = pictures[ours.DEFAULT]
    picture, same = (method.draw(small_photo, 0) for method in Sweep.parse("relax=3,1").methods(None))
    assert {key: value for key, value in picture.settings.items() if value != default.settings[key]} == {"relax": 3}
    assert same.svg == default.svg
    (picture,) = (method.draw(small_photo, 0) for method in Sweep.parse("published.alpha=0.5").methods(None))
    expected, found = flat(default.settings), flat(picture.settings)
    assert {key: value for key, value in found.items() if value != expected[key]} == {"published.alpha": 0.5}
    assert picture.svg != default.svg


def test_a_sweep_is_brought_to_the_budget_unless_it_sets_the_nodes(small_photo: Photo) -> None:
    budget = 5000
    for method in Sweep.parse("tolerance=0,1").methods(budget):
        picture = method.draw(small_photo, budget)
        assert method.is_budgeted
        assert picture.counts.coordinates == pytest.approx(budget, rel=ours.COORDINATES_TOLERANCE)
    for text, nodes in (("nodes=3000", 3000), ("nodes_per_pixel=0.1", 0.1 * small_photo.tone.size)):
        (method,) = Sweep.parse(text).methods(budget)
        assert not method.is_budgeted
        assert method.draw(small_photo, 0).counts.nodes == pytest.approx(nodes, rel=0.02)


# Which methods


def test_all_means_what_can_run_and_the_default_drawing_is_always_there(monkeypatch: pytest.MonkeyPatch) -> None:
    def nothing(photo: Photo, dots: int) -> Picture:
        raise AssertionError

    here = Method("here", "Here", "-", nothing)
    away = Method("away", "Away", "-", nothing, missing=lambda: "the program away is not installed")
    monkeypatch.setattr(baselines, "METHODS", (here, away))
    everything = Selection(None, (), "coordinates")
    assert [method.name for method in everything.compared] == [ours.DEFAULT, ours.PAPER, *ours.ABLATIONS, *ours.WITHOUT, "here"]
    assert everything.missing == {"away": "the program away is not installed"}
    one = Selection(("here",), (Sweep("relax", (0,)),), "coordinates")
    assert list(one.all()) == [ours.DEFAULT, "here", "relax=0"]
    assert one.missing == {}
    with pytest.raises(gs.InvalidInputError, match="the method away cannot run here: the program away is not installed"):
        Selection(("away",), (), "coordinates")


def test_budgets() -> None:
    counts = {"coordinates": 900, "stipples": 30, "regions": 20}
    assert Selection(("paper",), (), parse_budget("coordinates")).dots(counts) == 900
    assert Selection(("paper",), (), parse_budget("marks")).dots(counts) == 50
    assert Selection(("paper",), (), parse_budget("1234")).dots(counts) == 1234
    assert Selection(("paper",), (), 1234).dots(None) == 1234
    assert Selection(("paper",), (), "marks").dots(None) is None
    assert parse_names("a,b,a") == ("a", "b")
    assert parse_names("all") is None
    assert Selection((), (Sweep("relax", (0,)),), 1234).all()["relax=0"].is_budgeted
    assert not Selection((), (Sweep("relax", (0,)),), "marks").all()["relax=0"].is_budgeted


# Runs, in this process


class Inline(Executor):
    """Runs a task at once, here."""

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(function(*arguments, **named))
        return future


@dataclass
class Recorder:
    """A method that draws dots in a row and keeps what it was asked for."""

    calls: list[tuple[str, int]] = field(default_factory=list)

    def draw(self, photo: Photo, dots: int) -> Picture:
        self.calls.append((photo.name, dots))
        raster = np.ones_like(photo.tone)
        raster.flat[:dots] = 0
        return Picture(raster, Counts(stipples=dots, coordinates=dots), "<svg/>", {"dots": dots})


@pytest.fixture
def recorder(monkeypatch: pytest.MonkeyPatch) -> Recorder:
    """Two methods in place of the baselines, one with a budget and one without, and metrics that take no time."""
    recorder = Recorder()
    budgeted = Method("dots", "dots", "-", recorder.draw, is_budgeted=True)
    plain = Method("plain", "plain", "-", lambda photo, dots: recorder.draw(photo, 7))
    monkeypatch.setattr(baselines, "METHODS", (budgeted, plain))
    monkeypatch.setattr(run, "Comparison", lambda tone: lambda picture: {"tone_error": float(picture.mean() - tone.mean())})
    monkeypatch.setattr(run, "Flip", lambda tone: lambda picture: {"flip_80": 0.25})
    run._photo.cache_clear()
    return recorder


@pytest.fixture
def two(tmp_path: Path) -> list[PhotoFile]:
    """Two small photos, prepared."""
    paths = [write_photo(tmp_path / f"{name}.png", name, 64, 48) for name in ("camera", "coffee")]
    return photos.write(photos.decode(paths, [64], 48, tmp_path / "out" / report.PICTURES))


def run_here(two: list[PhotoFile], tmp_path: Path, names: str = "dots,plain", budget: str = "coordinates") -> run.Outcome:
    """Run methods in this process."""
    selection = Selection(parse_names(names), (), parse_budget(budget))
    return run.run(two, selection, tmp_path / "out", Inline(), lambda *_: None)


def states(folder: Path) -> dict[Path, tuple[int, int]]:
    """Return which files there are, and when each was written."""
    return {path: (path.stat().st_mtime_ns, path.stat().st_ino) for path in folder.rglob("*") if path.is_file()}


def test_dots_are_as_many_as_the_default_drawing_has_coordinates_or_marks(
    two: list[PhotoFile], tmp_path: Path, recorder: Recorder
) -> None:
    stats = {photo.name: gs.draw(photo.read().pixels).stats for photo in two}
    run_here(two, tmp_path)
    assert recorder.calls == [(name, n) for name, entry in stats.items() for n in (entry["coordinates"], 7)]
    recorder.calls.clear()
    # What does not depend on the budget is kept.
    outcome = run_here(two, tmp_path, budget="marks")
    assert recorder.calls == [(name, entry["stipples"] + entry["regions"]) for name, entry in stats.items()]
    assert outcome.kept == 4
    recorder.calls.clear()
    run_here(two, tmp_path, budget="150")
    assert recorder.calls == [("camera", 150), ("coffee", 150)]


def test_a_result_tells_all_that_it_depends_on(two: list[PhotoFile], tmp_path: Path, recorder: Recorder) -> None:
    outcome = run_here(two, tmp_path)
    assert [(result.photo, result.method) for result in outcome.results] == [
        (photo, method) for photo in ("camera", "coffee") for method in (ours.DEFAULT, "dots", "plain")
    ]
    result = outcome.results[1]
    assert result.dots == recorder.calls[0][1]
    assert result.checksum == files.checksum((tmp_path / "camera.png").read_bytes())
    assert result.versions["graphstipple"] == gs.__version__
    assert result.code == results.fingerprint()
    assert result.settings == {"dots": result.dots}
    assert result.svg_bytes == len("<svg/>")
    assert {name: files.checksum((tmp_path / "out" / name).read_bytes()) for name in result.files} == result.files
    with Image.open(tmp_path / "out" / result.png) as picture:
        pixels = np.asarray(picture)
    assert np.count_nonzero(pixels == 0) == result.dots
    assert result.metrics["tone_error"] == pytest.approx(pixels.mean() / 255 - two[0].read().tone.mean(), abs=1e-6)
    assert Result.of_json(json.loads((tmp_path / "out" / result.png).with_suffix(".json").read_text())) == result
    assert outcome.results[2].dots is None


def test_a_second_run_computes_nothing(two: list[PhotoFile], tmp_path: Path, recorder: Recorder) -> None:
    first = run_here(two, tmp_path)
    calls, before = len(recorder.calls), states(tmp_path)
    second = run_here(two, tmp_path)
    assert len(recorder.calls) == calls
    assert states(tmp_path) == before
    assert (first.kept, second.kept) == (0, 6)
    assert second.results == first.results


@pytest.mark.parametrize("harm", ["no json", "broken json", "no picture", "other picture"])
def test_only_what_is_missing_or_damaged_is_computed(two: list[PhotoFile], tmp_path: Path, recorder: Recorder, harm: str) -> None:
    first = run_here(two, tmp_path)
    picture = tmp_path / "out" / first.results[1].png
    match harm:
        case "no json":
            picture.with_suffix(".json").unlink()
        case "broken json":
            picture.with_suffix(".json").write_text("{")
        case "no picture":
            picture.unlink()
        case "other picture":
            Image.new("L", (64, 48)).save(picture)
    recorder.calls.clear()
    second = run_here(two, tmp_path)
    assert [name for name, _ in recorder.calls] == ["camera"]
    assert second.kept == 5
    assert second.results[1].files == first.results[1].files


def test_another_photo_of_the_same_name_is_not_mistaken_for_it(two: list[PhotoFile], tmp_path: Path, recorder: Recorder) -> None:
    run_here(two, tmp_path)
    write_photo(tmp_path / "camera.png", "chelsea", 64, 48)
    recorder.calls.clear()
    other = photos.write(photos.decode([tmp_path / "camera.png"], [64], 48, tmp_path / "out" / report.PICTURES))
    outcome = run_here(other, tmp_path)
    assert outcome.kept == 0
    assert len(recorder.calls) == 2


@pytest.mark.parametrize(
    "change",
    [
        {"checksum": "1"},
        {"size": 65},
        {"method": "other"},
        {"dots": 2},
        {"dots": None},
        {"fingerprint": "other"},
        {"version": "1.16"},
        {"version": None},
    ],
)
def test_every_part_of_a_key_counts(change: dict[str, Any]) -> None:
    parts: dict[str, Any] = {"checksum": "0", "size": 64, "method": "dots", "dots": 1, "fingerprint": "f", "version": "1.15"}
    assert results.key(*parts.values()) != results.key(*(parts | change).values())


def test_the_fingerprint_is_of_the_code_that_draws(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = results.fingerprint()
    assert results.fingerprint() == before
    copy = tmp_path / "graphstipple_eval"
    for name in ("__init__.py", "ours.py", "report.py"):
        files.write(copy / name, b"")
    monkeypatch.setattr(results.graphstipple_eval, "__file__", str(copy / "__init__.py"))
    small = results.fingerprint()
    assert small != before
    (copy / "report.py").write_text("changed")
    assert results.fingerprint() == small
    (copy / "ours.py").write_text("changed")
    assert results.fingerprint() != small


def test_a_new_version_of_a_program_computes_its_own_pictures_again(
    two: list[PhotoFile], tmp_path: Path, recorder: Recorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = {"plain": "1.0"}
    monkeypatch.setattr(programs, "versions", lambda: found)
    first = run_here(two, tmp_path)
    assert first.results[0].versions["plain"] == "1.0"
    recorder.calls.clear()
    found["plain"] = "1.1"
    second = run_here(two, tmp_path)
    assert second.kept == 4
    assert recorder.calls == [("camera", 7), ("coffee", 7)]
    assert second.results[2].versions["plain"] == "1.1"


def test_a_method_that_fails_is_reported_and_the_rest_goes_on(
    two: list[PhotoFile], tmp_path: Path, recorder: Recorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(photo: Photo, dots: int) -> Picture:
        if photo.name == "camera":
            raise ZeroDivisionError("no dot\nat all")
        return recorder.draw(photo, 3)

    def too_small(photo: Photo, dots: int) -> Picture:
        return Picture(np.ones((2, 2), np.float32), Counts())

    def too_light(photo: Photo, dots: int) -> Picture:
        return Picture(photo.tone + np.float32(1), Counts())

    wrong = {"fails": fails, "too-small": too_small, "too-light": too_light}
    monkeypatch.setattr(baselines, "METHODS", tuple(Method(name, name, "-", draw) for name, draw in wrong.items()))
    outcome = run_here(two, tmp_path, "all")
    reasons = {(failure.photo, failure.method): failure.reason for failure in outcome.failures}
    assert reasons["camera", "fails"] == "ZeroDivisionError: no dot at all"
    assert reasons["coffee", "too-small"] == "the picture has the shape (2, 2), but the photo has (48, 64)"
    assert "but they must be in [0, 1]" in reasons["coffee", "too-light"]
    assert len(reasons) == 5
    assert [result.photo for result in outcome.results if result.method == "fails"] == ["coffee"]
    # A failure is not kept: the next run tries again.
    assert run_here(two, tmp_path, "all").kept == 2 * len(ours.methods(None)) + 1


def test_without_a_default_drawing_there_is_no_budget(
    two: list[PhotoFile], tmp_path: Path, recorder: Recorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ours, "_draw", lambda *_: 1 / 0)
    outcome = run_here(two[:1], tmp_path)
    assert [result.method for result in outcome.results] == ["plain"]
    assert outcome.failures[1] == Failure("camera", 64, "dots", "there is no budget, because graphstipple failed on this photo")


# The report's words


def words(path: Path) -> str:
    """Return the text of a page."""
    text = html.unescape(re.sub(r"<[^>]*>", "", path.read_text()))
    return " ".join(text.replace("\N{MULTIPLICATION SIGN}", "x").split())


@pytest.mark.usefixtures("recorder")
def test_the_report_says_which_photos_are_smaller_than_a_size(two: list[PhotoFile], tmp_path: Path) -> None:
    write_photo(tmp_path / "coffee.png", "coffee", 80, 60)
    found = photos.find([tmp_path / "camera.png", tmp_path / "coffee.png"])
    both = photos.write(photos.decode(found, [64, 72, 90], 48, tmp_path / "out" / report.PICTURES))
    selection = Selection(("plain",), (), "coordinates")
    report.write(tmp_path / "out", both, selection, run.run(both, selection, tmp_path / "out", Inline(), lambda *_: None))
    index = words(tmp_path / "out" / "index.html")
    for card in (
        "camera, 64 px 64 x 48",
        "camera, 72 px 64 x 48, its own size",
        "coffee, 72 px 72 x 54",
        "coffee, 90 px 80 x 60, its own",
    ):
        assert card in index
    assert "64 px: quality As the paper" in index
    assert "72 px: quality 1 of 2 photos is smaller than this and at its own size." in index
    assert "90 px: quality 2 of 2 photos are smaller than this and at their own size." in index


@pytest.mark.usefixtures("recorder")
def test_the_report_says_whether_sweeps_are_brought_to_the_budget(two: list[PhotoFile], tmp_path: Path) -> None:
    sweeps = (Sweep("relax", (0,)), Sweep("nodes", (500,)))
    for budget in (600, "marks"):
        selection = Selection(("plain",), sweeps, parse_budget(str(budget)))
        outcome = run.run(two, selection, tmp_path / "out", Inline(), lambda *_: None)
        report.write(tmp_path / "out", two, selection, outcome)
        index, protocol = words(tmp_path / "out" / "index.html"), words(tmp_path / "out" / "protocol.html")
        is_fixed = budget == 600
        assert ("other values of relax, brought to 600 coordinates; means" in index) == is_fixed
        assert ("other values of nodes, not brought to the budget, because" in index) == is_fixed
        assert ("other values of relax; means" in index) != is_fixed
        assert ("those of sweeps among them" in protocol) == is_fixed
        written = {result.method: result.counts["coordinates"] for result in outcome.results if result.photo == "camera"}
        assert (written["relax=0"] == pytest.approx(600, rel=ours.COORDINATES_TOLERANCE)) == is_fixed


# Tables


def result_of(photo: str, method: str, **metrics: float) -> Result:
    written = {"a.png": ""}
    return Result("k", photo, "c", 64, 64, 48, method, None, {}, {}, "f", written, 1.0, None, {"stipples": 2}, metrics, {}, {})


def test_tables_are_means_with_the_best_of_each_column() -> None:
    methods = [Method(name, name, "-", Recorder().draw) for name in ("one", "two", "part", "none")]
    made = [
        result_of("a", "one", near_psnr=8.0, near_ssim=0.1),
        result_of("b", "one", near_psnr=10.0, near_ssim=0.3),
        result_of("a", "two", near_psnr=math.inf, near_ssim=0.2001),
        result_of("b", "two", near_psnr=12.0, near_ssim=0.2001),
        result_of("a", "part", near_psnr=99.0, near_ssim=0.9),
    ]
    table = tables.table(methods, made, (tables.QUALITY[2], tables.QUALITY[3], tables.QUALITY[0]))
    assert [row.name for row in table.rows] == ["one", "two", "part"]
    assert table.rows[0].values == (9.0, 0.2, None)
    assert table.rows[0].best == (False, True, False)
    assert table.rows[1].best == (True, True, False)  # 0.2001 is printed as 0.200
    assert table.rows[2].best == (False, False, False)  # a mean over fewer photos is not compared
    assert [row.remark for row in table.rows] == ["", "", "1 of 2 photos"]
    assert table.columns[0].text(math.inf) == "∞"
    assert table.columns[0].text(None) == "\N{EN DASH}"
    assert tables.COUNTS[0].text(1234567) == "1\N{NARROW NO-BREAK SPACE}234\N{NARROW NO-BREAK SPACE}567"
    assert tables.QUALITY[-1].text(-0.00125) == "\N{MINUS SIGN}0.0013"


def test_an_infinite_metric_survives_its_file(tmp_path: Path) -> None:
    result = result_of("a", "one", near_psnr=math.inf)
    files.write(tmp_path / "a.png", b"")
    result = Result(**(vars(result) | {"files": {"a.png": files.checksum(b"")}}))
    results.save(result, tmp_path / "a.json")
    assert json.loads((tmp_path / "a.json").read_text())["metrics"] == {"near_psnr": "inf"}
    assert results.load(tmp_path / "a.json", tmp_path) == result


def test_quoted_figures_name_methods_that_exist() -> None:
    assert set(quoted.ABLATIONS) == {ours.PAPER, *ours.ABLATIONS}
    assert set(quoted.ABLATIONS) <= {method.name for method in ours.methods(None)}


def test_the_table_of_ideas_has_the_default_first_and_stands_only_where_one_is_left_out() -> None:
    everything = ours.methods(None)
    assert [method.name for method in tables.ideas(everything)] == [ours.DEFAULT, *ours.WITHOUT, ours.PAPER]
    some = [method for method in everything if method.name in {ours.DEFAULT, "no-area"}]
    assert [method.name for method in tables.ideas(some)] == [ours.DEFAULT, "no-area"]
    assert [method.name for method in tables.compared(some)] == [ours.DEFAULT]
    assert tables.ideas([method for method in everything if method.name not in ours.WITHOUT]) == []


# Cross-validation

PAPER_FIGURES = np.tile([0.6, 0.4, 0.2, 14.0, 0.03, 1000.0], (3, 1))
"""Three photos with the same figures: near and far LPIPS, near SSIM, far PSNR, tone error, vertices."""


def test_a_score_is_0_for_the_paper_s_figures_and_1_at_the_targets_and_no_target_counts_for_more_than_its_share() -> None:
    assert cross_validation.score(PAPER_FIGURES, PAPER_FIGURES) == 0
    at_targets = PAPER_FIGURES * [0.88, 0.75, 1.35, 1, 5, 5] + [0, 0, 0, 2.5, 0, 0]
    assert cross_validation.score(at_targets, PAPER_FIGURES) == pytest.approx(1)
    assert tables.gains(cross_validation.FIGURES, at_targets, PAPER_FIGURES) == pytest.approx([-0.12, -0.25, 0.35, 2.5, 0.12, 4])
    assert cross_validation.score(at_targets + np.array([0, 0, 0, 99, 0, 0]), PAPER_FIGURES) == pytest.approx((3 + 1.5) / 4)
    assert cross_validation.score(at_targets - np.array([0, 0, 0, 5, 0, 0]), PAPER_FIGURES) == pytest.approx((3 - 1) / 4)


def test_a_setting_is_chosen_on_the_other_photos() -> None:
    psnr = np.array([0.0, 0, 0, 1, 0, 0])
    on_all = PAPER_FIGURES + psnr
    on_the_first = PAPER_FIGURES + 3 * psnr * np.array([[1], [0], [0]])
    assert cross_validation.chosen(np.array([PAPER_FIGURES, on_all, on_the_first]), PAPER_FIGURES) == [1, 2, 2]
    assert cross_validation.chosen(np.array([on_all, on_all]), PAPER_FIGURES) == [0, 0, 0]
    text = cross_validation.summary(["a", "b", "c"], {ours.DEFAULT: on_all, ours.PAPER: PAPER_FIGURES, "shading=0.7": on_the_first})
    assert "| shading=0.7 | +0.0 % | +0.0 % | +0.0 % | +1.00 | +0.0000 | +0.0 % | 0.100 |" in text
    assert "| a | graphstipple | +0.0 % | +0.0 % | +0.0 % | +1.00 |" in text
    assert "| b | shading=0.7 | +0.0 % | +0.0 % | +0.0 % | +0.00 |" in text
    assert "| all, left out |  | +0.0 % | +0.0 % | +0.0 % | +0.33 |" in text


def test_the_grid_is_made_of_options_and_leaves_out_their_defaults_and_what_they_may_not_be(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert set(cross_validation.GRID) <= {field.name for field in dataclasses.fields(gs.Options)}
    monkeypatch.setattr(cross_validation, "GRID", {"contrast": (0.7, 1, 1.4, 100), "cohesion": (0.333333,), "stipple_scale": (1,)})
    assert cross_validation.sweeps() == (Sweep("contrast", (0.7, 1.4)), Sweep("cohesion", (0.0667,)))


def test_one_photo_is_too_few_to_leave_one_out(tmp_path: Path) -> None:
    write_photo(tmp_path / "astronaut.png")
    command = [sys.executable, "-m", "graphstipple_eval.cross_validation", tmp_path]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    assert_one_line(ended, 1, "cross_validation: there is one photo, but one is left out")


# Ablation


def cells(text: str) -> dict[str, list[str]]:
    """Return the rows of a table in Markdown by their first cell, the rule under the head left out."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line.startswith("|")]
    return {row[0].replace("`", ""): row[1:] for row in rows if row[0].strip("-") or not row[1].startswith("-")}


def test_gains_leave_out_photos_without_the_figure() -> None:
    share, difference = tables.Figure("a", lambda _: 0.0), tables.Figure("b", lambda _: 0.0, is_relative=False, digits=2)
    reference = np.array([[2.0, 1.0], [4.0, 5.0], [6.0, np.nan]])
    own = np.array([[3.0, 2.0], [6.0, np.nan], [9.0, 7.0]])
    assert tables.gains((share, difference), own, reference).tolist() == [0.5, 1.0]
    assert tables.gains((share, difference), reference, reference).tolist() == [0, 0]
    assert (share.gain_text(0.5), difference.gain_text(-1), share.text(2)) == ("+50.0 %", "-1.00", "2.000")
    assert np.isnan(tables.gains((difference,), own[1:, 1:], reference[1:, 1:])).tolist() == [True]


def test_the_page_of_steps_has_a_row_and_a_paragraph_for_every_step() -> None:
    page = (support.ROOT / "docs" / "steps.md").read_text(encoding="utf-8")
    (head, titles), *rows = cells(page).items()
    assert [head, *titles[:-1]] == ["", *(figure.title for figure in ablation.FIGURES)]
    assert [name for name, _ in rows] == [f"{ours.DEFAULT}, as it is", *ours.WITHOUT, ours.PAPER]
    paragraphs = page.split("## The steps")[1].split("\n\n")[1:]
    assert [re.search(r"`([^`]+)`", paragraph).group(1) for paragraph in paragraphs[: len(ours.WITHOUT)]] == list(ours.WITHOUT)
    sections = re.findall(r"^#+ (.*)$", (support.ROOT / "docs" / "method.md").read_text(encoding="utf-8"), re.MULTILINE)
    anchors = {title.lower().replace(" ", "-") for title in sections}
    assert set(re.findall(r"\(method\.md#([^)]+)\)", page)) <= anchors


def ablated(photo: str, method: str, by: float, evenness: float | None) -> Result:
    """Return a result whose metrics are 0.5 + `by`, PSNR 20 - `by`."""
    names = ("flip_40", "flip_80", "flip_160", "near_lpips_alex", "near_lpips_vgg", "far_lpips_alex", "near_ssim", "local_tone")
    metrics = {**dict.fromkeys(names, 0.5 + by), "far_psnr": 20 - by, "farther_psnr": 20 - 2 * by}
    made = result_of(photo, method, **metrics)
    return dataclasses.replace(made, counts={"coordinates": 1000}, evenness={} if evenness is None else {"evenness": evenness})


def test_the_ablation_has_a_row_a_step_and_counts_photos(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ours, "WITHOUT", ("no-emphasis", "no-stippling"))
    made = []
    for photo, by in (("a", 0.1), ("b", 0.2), ("c", -0.15)):
        made += [ablated(photo, ours.DEFAULT, 0, 0.8), ablated(photo, "no-emphasis", by, 0.9 if photo == "a" else None)]
        made += [ablated(photo, "no-stippling", 0, None), ablated(photo, ours.PAPER, 0.25, 0.7)]
    text = ablation.summary(made)
    assert text.startswith("## Without each step: means over 3 photos, against the default\n")
    (head, titles), *rows = cells(text).items()
    assert head == ""
    assert (titles[1], titles[-1]) == ("FLIP 80", "FLIP 80 worse / better")
    same = ["+0.0 %"] * 6 + ["+0.00"] * 2 + ["+0.0 %"]
    assert rows == [
        ("graphstipple, as it is", [*["0.500"] * 6, "20.00", "20.00", "0.500", "0.800", "1000", ""]),
        ("no-emphasis", [*["+10.0 %"] * 6, "-0.05", "-0.10", "+10.0 %", "+0.100", "+0.0 %", "2 / 1"]),
        ("no-stippling", [*same, "", "+0.0 %", "0 / 0"]),
        ("paper", [*["+50.0 %"] * 6, "-0.25", "-0.50", "+50.0 %", "-0.100", "+0.0 %", "3 / 0"]),
    ]


def quick_metrics(tone: np.ndarray) -> Callable[[np.ndarray], dict[str, float]]:
    """Return all metrics of pictures of a photo: figures that tell pictures apart, and take no time."""

    def of(picture: np.ndarray) -> dict[str, float]:
        off = float(np.abs(picture - tone).mean())
        names = (
            "near_lpips_alex",
            "near_lpips_vgg",
            "near_psnr",
            "near_ssim",
            "near_msssim",
            "far_lpips_alex",
            "far_psnr",
            "far_ssim",
        )
        names += ("far_msssim", "tone_error", "farther_psnr", "farther_ssim", "local_tone", "flip_40", "flip_80", "flip_160")
        return {name: off ** (1 + i / 10) for i, name in enumerate(names)}

    return of


def test_the_ablation_s_command_prints_what_the_report_s_results_say(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(run, "processes", lambda jobs: Inline())
    monkeypatch.setattr(run, "Comparison", quick_metrics)
    monkeypatch.setattr(run, "Flip", lambda tone: lambda picture: {})
    run._photo.cache_clear()
    monkeypatch.setattr(ours, "WITHOUT", ("no-stippling", "unsimplified"))
    paths = [write_photo(tmp_path / f"{name}.png", name, 168, 162) for name in ("camera", "coffee")]
    arguments = [*map(str, paths), "--size", "168", "--out", str(tmp_path / "out")]
    ablation.main(arguments)
    text = capsys.readouterr().out
    assert (tmp_path / "out" / "ablation.md").read_text() == text
    pictures = json.loads((tmp_path / "out" / "results.json").read_text())["pictures"]
    table = cells(text)
    assert list(table) == ["", f"{ours.DEFAULT}, as it is", "no-stippling", "unsimplified", ours.PAPER]
    titles = table.pop("")
    by_method = {
        name: [entry for entry in pictures if entry["method"] == name] for name in (ours.DEFAULT, *ours.WITHOUT, ours.PAPER)
    }
    assert [len(entries) for entries in by_method.values()] == [2, 2, 2, 2]
    for name, group, title, kind in (
        ("flip_40", "metrics", "FLIP 40", "share"),
        ("flip_160", "metrics", "FLIP 160", "share"),
        ("near_ssim", "metrics", "SSIM near", "share"),
        ("far_psnr", "metrics", "PSNR far, dB", "difference"),
        ("coordinates", "counts", "coordinates", "share"),
    ):
        at = titles.index(title)
        mean = {method: np.mean([entry[group][name] for entry in entries]) for method, entries in by_method.items()}
        default = mean[ours.DEFAULT]
        assert float(table["graphstipple, as it is"][at]) == pytest.approx(default, abs=0.5 if group == "counts" else 0.01)
        for method in (*ours.WITHOUT, ours.PAPER):
            gain = mean[method] - default
            assert table[method][at] == (f"{100 * gain / default:+.1f} %" if kind == "share" else f"{gain:+.2f}")
    # Nothing but points is taken away by simplification.
    assert float(table["unsimplified"][titles.index("coordinates")].removesuffix(" %")) > 20
    worse, better = map(int, table[ours.PAPER][-1].split(" / "))
    flips = [[entry["metrics"]["flip_80"] for entry in by_method[name]] for name in (ours.PAPER, ours.DEFAULT)]
    assert (worse, better) == (np.greater(*flips).sum(), np.less(*flips).sum())
    # The folder is a report that graphstipple-eval goes on with.
    assert (tmp_path / "out" / report.MARKER).is_file()
    before = states(tmp_path / "out")
    ablation.main(arguments)
    assert capsys.readouterr().out == text
    assert states(tmp_path / "out") == before


# The command


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with one photo."""
    folder = tmp_path_factory.mktemp("photos")
    write_photo(folder / "astronaut.png")
    return folder


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--methods", "nothing"], "there is no method 'nothing'"),
        (["--methods", "all,lbg"], "all stands alone"),
        (["--size", "512,big"], "--size is 'big'"),
        (["--size", "160"], "--size is '160', but it must be a whole number of at least 161"),
        (["--budget", "0"], "the budget is '0'"),
        (["--budget", "dots"], "the budget is 'dots'"),
        (["--jobs", "0"], "--jobs is '0'"),
        (["--sweep", "shadnig=1"], "there is no option 'shadnig' to sweep over: it must be one of nodes, fineness, "),
        (["--sweep", "k1=1"], ", threads, published.lattice, published.density, published.k1, "),
        (["--sweep", "published=1"], "there is no option 'published' to sweep over"),
        (["--sweep", "published.k9=1"], "there is no option 'published.k9' to sweep over"),
        (["--sweep", "published.k1=-1"], "published.k1 is -1"),
        (["--sweep", "shading=-1"], "shading is -1"),
        (["--sweep", "shading=much"], 'shading is "much"'),
        (["--sweep", "shading"], "no sweep"),
        (["--sweep", "shading=1,,2"], "no sweep"),
        (["--sweep", "published.detail_gain=6,6.0"], "a value twice"),
        (["--sweep", "relax=0", "--sweep", "relax=1"], "two sweeps are over one option"),
        (["--colour"], "--colour"),
    ],
)
def test_wrong_arguments_are_one_line_and_exit_code_2(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], sentence: str
) -> None:
    assert cli.main([str(folder), "--out", str(tmp_path / "out"), *arguments]) == cli.USAGE
    said = capsys.readouterr()
    assert said.out == ""
    assert sentence in said.err
    assert said.err.startswith("graphstipple-eval: ")
    assert said.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def assert_one_line(ended: subprocess.CompletedProcess[str], code: int, sentence: str) -> None:
    assert ended.returncode == code, ended.stderr
    assert sentence in ended.stderr
    assert ended.stderr.count("\n") == 1
    assert ended.stdout == ""


@pytest.mark.usefixtures("weights")
def test_the_command_itself_says_what_is_wrong_in_one_line(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "broken.png").write_bytes(b"\x89PNG\r\n")
    assert_one_line(evaluate(folder, tmp_path / "broken.png", "--out", tmp_path / "out"), cli.USAGE, "broken.png")
    assert not (tmp_path / "out").exists()


def test_without_photos_there_is_nothing_to_evaluate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for arguments, sentence in (
        ([], "the following arguments are required"),
        ([str(tmp_path / "none"), "--out", str(tmp_path / "out")], "does not exist"),
    ):
        assert cli.main(arguments) == cli.USAGE
        said = capsys.readouterr()
        assert sentence in said.err
        assert (said.out, said.err.count("\n")) == ("", 1)
    assert not (tmp_path / "out").exists()


def test_a_folder_that_is_no_report_or_cannot_be_written_to_is_refused_and_left_as_it_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mine" / "pictures").mkdir(parents=True)  # a report has such a folder too
    (tmp_path / "mine" / "photos").mkdir()
    (tmp_path / "mine" / "photos" / "notes.html").write_text("mine")
    before = states(tmp_path)
    # Before photos are looked for: there is none.
    assert cli.main([str(tmp_path / "none"), "--out", str(tmp_path / "mine")]) == cli.USAGE
    assert "holds other things than a report" in capsys.readouterr().err
    assert cli.main([str(tmp_path / "none"), "--out", str(tmp_path / "mine" / "photos" / "notes.html" / "out")]) == cli.USAGE
    assert "notes.html is a file: give a folder" in capsys.readouterr().err
    monkeypatch.setattr(os, "access", lambda path, mode: path != tmp_path)
    assert cli.main([str(tmp_path / "none"), "--out", str(tmp_path / "new" / "out")]) == cli.USAGE
    assert f"{tmp_path} cannot be written to" in capsys.readouterr().err
    assert states(tmp_path) == before
    assert not (tmp_path / "new").exists()


def test_missing_weights_stop_it_at_once(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GRAPHSTIPPLE_CACHE", str(tmp_path))
    assert cli.main([str(folder), "--out", str(tmp_path / "out")]) == cli.USAGE
    assert "python -m graphstipple.metrics fetch" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.usefixtures("weights")
def test_a_picture_that_fails_is_said_at_the_end_and_in_the_report(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "potrace").write_text("#!/bin/sh\necho it is broken >&2\nexit 3\n")
    (tmp_path / "potrace").chmod(0o755)
    path = os.pathsep.join([str(tmp_path), os.environ["PATH"]])
    ended = evaluate(folder, "--methods", "potrace", "--out", tmp_path / "out", environment={"PATH": path})
    assert ended.returncode == cli.FAILED
    assert ended.stdout.startswith("1 picture, 0 of them from before: ")
    reason = "potrace failed with exit code 3 and said: it is broken"
    assert ended.stderr.splitlines()[-1] == (
        f"graphstipple-eval: 1 picture failed, as the report says; for example potrace on astronaut at 512: {reason}"
    )
    assert reason in words(tmp_path / "out" / "index.html")


def wait_for_result(process: subprocess.Popen[str], out: Path) -> None:
    """Wait until a picture is done and others are not."""
    support.wait_until(lambda: process.poll() is not None or list(out.glob("pictures/*/*.json")))
    assert process.poll() is None, "it ended before it made anything"


@pytest.mark.usefixtures("weights")
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_what_is_done_survives_an_interruption(folder: Path, tmp_path: Path, how: signal.Signals) -> None:
    # So many that they are not all done before the signal arrives.
    values = [0, *range(2, 8)]
    sweep, total = "relax=" + ",".join(map(str, values)), len(values) + 2
    arguments = [folder, "--methods", "paper", "--sweep", sweep, "--out", tmp_path, "--jobs", "2"]
    # A shell that runs the tests in the background has them ignore Ctrl-C, and what they start would too.
    handler = signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        process = subprocess.Popen([*COMMAND, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    finally:
        signal.signal(signal.SIGINT, handler)
    with process:
        wait_for_result(process, tmp_path)
        process.send_signal(how)
        _, said = process.communicate(timeout=60)
    if how == signal.SIGINT:
        assert process.returncode == cli.INTERRUPTED
        assert said.splitlines()[-1].startswith("graphstipple-eval: interrupted")
        assert "Traceback" not in said
    before = {path: state for path, state in states(tmp_path).items() if path.suffix == ".json"}
    assert 0 < len(before) < total
    ended = evaluate(*arguments)
    assert ended.returncode == cli.DONE, ended.stderr
    assert f"{total} pictures, {len(before)} of them from before" in ended.stdout
    after = states(tmp_path)
    assert {path: after[path] for path in before} == before
    assert json.loads((tmp_path / "results.json").read_text())["failures"] == []


@pytest.mark.usefixtures("weights")
def test_a_whole_run_and_its_files(folder: Path, tmp_path: Path) -> None:
    sweeps = ["--sweep", "relax=0", "--sweep", "published.k1=2"]
    arguments = [folder, "--methods", "paper", *sweeps, "--out", tmp_path / "out"]
    one = evaluate(*arguments, "--jobs", "1")
    assert one.returncode == cli.DONE, one.stderr
    assert [line.split("]")[0] for line in one.stderr.splitlines()] == ["[1/4", "[2/4", "[3/4", "[4/4"]
    content = json.loads((tmp_path / "out" / "results.json").read_text())
    assert [picture["method"] for picture in content["pictures"]] == [ours.DEFAULT, "paper", "relax=0", "published.k1=2"]
    default, swept = (content["pictures"][i]["settings"] for i in (0, 3))
    assert default["published"] == dataclasses.asdict(gs.Options().published)
    assert swept == {**default, "published": {**default["published"], "k1": 2.0}}
    assert 'id="table-sweep-published.k1-512"' in (tmp_path / "out" / "index.html").read_text()
    (page,) = (tmp_path / "out").glob("photos/*.html")
    assert page.read_text().count("published.k1 <b>2.0</b>") == 1
    with (tmp_path / "out" / "results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    for row, picture in zip(rows, content["pictures"], strict=True):
        assert (row["photo"], row["method"], row["key"]) == (picture["photo"], picture["method"], picture["key"])
        for name, value in {**picture["metrics"], "seconds": picture["seconds"]}.items():
            assert float(row[name]) == value
        assert int(row["coordinates"]) == picture["counts"]["coordinates"]
        own = {**picture["labyrinth"], **picture["evenness"]}
        assert {name: float(row[name]) for name in own} == own
        assert {"small_regions", "evenness", "evenness_deviation"} <= own.keys()
        seen = {"farther_psnr", "farther_ssim", "local_tone", "flip_40", "flip_80", "flip_160"}
        assert all(math.isfinite(figure.read(Result.of_json(picture))) for figure in ablation.FIGURES)
        assert all(0 < picture["metrics"][name] < (1 if name != "farther_psnr" else 50) for name in seen)
    assert (tmp_path / "out" / report.MARKER).is_file()
    before = states(tmp_path)
    again = evaluate(*arguments)
    assert again.returncode == cli.DONE
    assert "4 of them from before" in again.stdout
    assert states(tmp_path) == before
    # Two processes make the same pictures as one.
    other = evaluate(*arguments[:-1], tmp_path / "other", "--jobs", "2")
    assert other.returncode == cli.DONE
    for first, second in zip(
        content["pictures"], json.loads((tmp_path / "other" / "results.json").read_text())["pictures"], strict=True
    ):
        assert {**first, "seconds": 0} == {**second, "seconds": 0}
