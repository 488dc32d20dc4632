"""Batches by processes of this machine: what is drawn, kept and refused, and what happens when something goes wrong."""

from __future__ import annotations

import errno
import http.server
import json
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from tests import batches, commands
from tests.batches import FLAGS, OPTIONS
from tests.support import hears_ctrl_c, wait_until

import graphstipple as gs
from graphstipple import _core
from graphstipple._flags import flat, of_options
from graphstipple.batches import command, engines, local, memory, names, sources
from graphstipple.batches.addresses import shown
from graphstipple.batches.memory import Admission
from graphstipple.batches.run import Asked, Run
from graphstipple.batches.sources import Photo
from graphstipple.batches.store import OutputLostError, Store
from graphstipple.batches.work import Task

needs_links = pytest.mark.skipif(os.name != "posix", reason="links need a privilege elsewhere")


@pytest.fixture(scope="module")
def photos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return batches.make(tmp_path_factory.mktemp("photos"))


@pytest.fixture
def few(tmp_path: Path) -> Path:
    """Return a folder with some photos, all of them good."""
    return batches.make(tmp_path / "few", 6)


def records(manifest: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in manifest.read_text(encoding="ascii").splitlines()]


def test_two_hundred_photos_ten_of_them_bad(photos: Path, tmp_path: Path) -> None:
    done = batches.batch(photos, "-o", "out", "-j", "2", *FLAGS, cwd=tmp_path)
    assert done.returncode == 1
    assert done.stdout == ""
    assert "graphstipple: error: 10 of 200 photos failed; out/manifest.jsonl says why, and the first are:" in done.stderr
    assert done.stderr.count("not an image") == 5
    assert batches.drawn(tmp_path / "out") == batches.expected()

    made = records(tmp_path / "out" / "manifest.jsonl")
    assert len(made) == 200
    assert sum("error" in record for record in made) == 10
    good = next(record for record in made if "error" not in record)
    assert set(good) == {"photo", "photo_hash", "options", "version", "outputs", "counts", "seconds"}
    assert good["options"] == {"nodes": 150}
    assert good["version"] == gs.__version__

    # Nothing is done again but what has failed.
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*.svg")}
    again = batches.batch(photos, "-o", "out", "-j", "2", *FLAGS, cwd=tmp_path)
    assert again.returncode == 1
    assert "190 kept, 10 failed" in again.stderr
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*.svg")} == before


def test_only_what_has_changed_is_drawn_again(few: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"

    def drawn(**more: object) -> set[str]:
        results = list(gs.batch(few, out, **{"options": OPTIONS, **more}))
        assert all(result.error is None for result in results)
        return {Path(result.photo).name for result in results if not result.kept}

    everything = {Path(batches.name_of(number)).name for number in range(6)}
    assert drawn() == everything
    assert drawn() == set()
    Image.fromarray(batches.pixels(99)).save(few / "photo 001.png")
    assert drawn() == {"photo 001.png"}
    (out / "photo 002.svg").write_text("changed")
    (out / "photo 003.svg").unlink()
    assert drawn() == {"photo 002.png", "photo 003.png"}
    # Threads make no difference, other options do.
    assert drawn(options=OPTIONS.replace(threads=1)) == set()
    assert drawn(redo=True) == everything
    assert drawn(options=OPTIONS.replace(gamma=2)) == everything
    assert drawn(options=OPTIONS.replace(gamma=2), settings={"width": "20cm"}) == everything
    # A crash leaves half a line.
    manifest = out / "manifest.jsonl"
    last = manifest.read_bytes().splitlines(keepends=True)[-1]
    manifest.write_bytes(manifest.read_bytes()[: -len(last) // 2])
    assert len(drawn(options=OPTIONS.replace(gamma=2), settings={"width": "20cm"})) == 1
    assert drawn(options=OPTIONS.replace(gamma=2), settings={"width": "20cm"}) == set()


def test_a_manifest_is_not_appended_to_what_is_none(few: Path, tmp_path: Path) -> None:
    other = tmp_path / "notes.txt"
    other.write_text("mine\n")
    with pytest.raises(gs.InvalidInputError, match="this is no manifest"):
        gs.batch(few, tmp_path / "out", manifest=other)
    assert other.read_text() == "mine\n"


def test_every_format_of_one_drawing_is_as_by_itself(few: Path, tmp_path: Path) -> None:
    suffixes = [suffix for suffix, *_ in _core.formats()]
    flags = ["--preset", "scratchboard", "--width", "30mm", "--min-dot", "0.1mm", *FLAGS]
    done = batches.batch("few/photo 001.png", "-o", "out", "--format", ",".join(suffixes), "--dpi", "200", *flags, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for suffix in suffixes:
        pixels = ["--dpi", "200"] if suffix == "png" else []
        commands.done(batches.CONSOLE_SCRIPT, few / "photo 001.png", "-o", f"one.{suffix}", *flags, *pixels, cwd=tmp_path)
        assert (tmp_path / "out" / f"photo 001.{suffix}").read_bytes() == (tmp_path / f"one.{suffix}").read_bytes(), suffix


def test_every_flag_of_a_drawing_is_taken() -> None:
    words = of_options(flat(gs.Options(threads=1)._checked.values()))
    words += ["--preset", "poster", "--force", "--allow-damaged", "--max-pixels", "10M", "--max-bytes", "1MB", "--max-points", "9k"]
    words += [
        "--importance",
        "none",
        "--subject",
        "auto",
        "--width",
        "20cm",
        "--margin",
        "5mm",
        "--page",
        "A4",
        "--dpi",
        "600",
        "--min-dot",
        "0.3mm",
    ]
    words += ["--style", "flat", "--only", "black,white", "--elements", "layers", "--dots", "circles"]
    words += ["--curves", "splines", "--one-bit", "--linear", "--invert", "--registration-marks"]
    words += ["--process", "vinyl", "--min-feature", "1mm", "--min-gap", "1mm", "--min-area", "9mm2", "--islands", "bridge"]
    # The node budget is one or the other, and what is off needs no flag.
    place = words.index("--nodes-per-pixel")
    del words[place : place + 2]
    words = [word for place, word in enumerate(words) if "False" not in (word, words[min(place + 1, len(words) - 1)])]
    parser = command._parser(with_all=False)
    taken = parser.parse_intermixed_args(["a.jpg", "-o", "out", *words])
    # Where there are several inks, they keep no rules.
    named = {
        flag for flag, *_ in parser.parse_intermixed_args(["a.jpg", "-o", "out", *words, "--overprint", "--trap", "1mm"]).flags
    }
    assert named == {name for name, *_ in _core.flags(True)} - {"nodes-per-pixel"}
    recipe = _core.Recipe([word for flag in taken.flags for word in (f"--{flag[0]}", *flag[1:])], ["png", "dxf"])
    assert recipe.options.values()["invert"] is True


def test_python_and_a_map(few: Path, tmp_path: Path) -> None:
    map_ = tmp_path / "none"
    Image.fromarray(np.tile(np.linspace(0, 255, 40).astype(np.uint8), (30, 1))).save(map_, "PNG")
    options = gs.Options(nodes=200, published=gs.Options().published.replace(k1=2.5), invert=True)
    results = list(
        gs.batch([few / "photo 001.png", str(few / "deep")], tmp_path / "out", options, map_, settings={"dots": "strokes"})
    )
    assert sorted(result.outputs[0] for result in results) == ["er/photo 000.svg", "er/photo 004.svg", "photo 001.svg"]
    for result in results:
        drawing = gs.draw(result.photo, map_, options)
        assert (tmp_path / "out" / result.outputs[0]).read_text() == drawing.svg(dots="strokes")
        assert result.counts["stipples"] == drawing.stats["stipples"]
    assert "importance_hash" in records(tmp_path / "out" / "manifest.jsonl")[0]["options"]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["few"], "the following arguments are required: -o/--output"),
        (["-o", "out"], "there is no photo to draw"),
        (["few", "-o", "out", "--nodes", "many"], '--nodes is "many", but it must be auto or a whole number'),
        (["few", "-o", "out", "--format", "svg,gif"], "suffix"),
        (["few", "-o", "out", "--format", "svg,svg"], "each must be named once"),
        (["few", "-o", "out", "--dpi", "300"], "--dpi is 300, but it must be left out unless the file is a .png"),
        (["few", "-o", "out", "--engrave"], "unrecognized arguments: --engrave"),
        (["few", "-o", "out", "--preview", "a.png"], "unrecognized arguments: --preview"),
        (["no*.jpg", "-o", "out"], "no*.jpg: no file matches it"),
        (["few", "-o", "out", "-j", "0"], "it is 0, but it must be a whole number, at least 1"),
        (["few", "-o", "out", "--memory", "much"], "memory is much, but it must be a number of bytes"),
        (["few", "-o", "out", "--threads", "1000"], "threads is 1000, but it must be at most"),
        (["few", "-o", "out", "--dashboard"], "--dashboard is given, but it must be left out unless --cluster is"),
        (["few", "-o", "out", "--tls-ca", "ca.pem"], "--tls-ca, --tls-cert and --tls-key belong together"),
        (["few", "-o", "few", "--format", "png"], "would be drawn over the photo"),
        (["few", "-o", "out", "--manifest", "out/photo 001.svg"], "would be drawn over"),
    ],
)
def test_wrong_usage_is_one_sentence(arguments: list[str], told: str, few: Path, tmp_path: Path) -> None:
    done = commands.run(batches.CONSOLE_SCRIPT, "batch", *arguments, cwd=tmp_path)
    commands.assert_one_sentence(done, commands.USAGE)
    assert told in done.stderr.decode()
    assert not list(tmp_path.rglob("*.svg"))


@pytest.mark.parametrize("arguments", [["missing", "-o", "out"], ["few", "-o", "file"], ["--from", "missing", "-o", "out"]])
def test_what_cannot_be_is_one_sentence(arguments: list[str], few: Path, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    commands.assert_one_sentence(commands.run(batches.CONSOLE_SCRIPT, "batch", *arguments, cwd=tmp_path), commands.FAILURE)


def test_the_native_binary_says_where_batches_are() -> None:
    done = commands.run(commands.native_binary(), "batch", "photos", "-o", "out")
    commands.assert_one_sentence(done, commands.USAGE)
    assert b"comes with Python's command" in done.stderr or b"come with Python's command" in done.stderr


def test_lists_globs_and_folders(few: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (few / "notes.txt").touch()
    (few / ".hidden.png").touch()

    def places(*named: str, recursive: bool = True) -> list[str]:
        return [photo.place for photo in sources.find(named, recursive=recursive, output="out")]

    everything = [batches.name_of(number) for number in (0, 4, 1, 2, 3, 5)]
    assert sorted(places("few")) == sorted(places(str(few))) == sorted(everything)
    assert places("few", recursive=False) == everything[2:]
    assert places("few/**/photo 00[04].png") == ["deep/er/photo 000.png", "deep/er/photo 004.png"]
    assert places("few/photo 001.png") == ["photo 001.png"]
    # What is drawn already is no photo, where the output is in the folder.
    inside = [photo.place for photo in sources.find(["few"], recursive=True, output="few/deep")]
    assert inside == everything[2:]
    (tmp_path / "list").write_text(f"few/photo 001.png\n\n{few}/photo 002.png\n../{tmp_path.name}/few/photo 003.png\n")
    done = batches.batch("--from", "list", "-o", "out", *FLAGS, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    listed = set(batches.drawn(tmp_path / "out"))
    assert listed == {"few/photo 001.svg", f"{few}/photo 002.svg".lstrip("/"), f"{tmp_path.name}/few/photo 003.svg"}


@given(st.text(alphabet=st.sampled_from("./\\ab\u00e9 :~"), min_size=1, max_size=30))
def test_no_line_of_a_list_leads_out(line: str) -> None:
    try:
        found = list(sources.of_list([line]))
    except gs.InvalidInputError:
        return
    for photo in found:
        parts = photo.place.split("/")
        assert ".." not in parts
        assert not Path(photo.place).is_absolute()
        assert os.path.normpath(Path("/out", *parts)).startswith("/out/")


def collision(*places: str) -> str:
    with pytest.raises(gs.InvalidInputError) as raised:
        names.check([Photo(f"in/{place}", place) for place in places], ["svg", "png"], "out")
    return str(raised.value)


def test_names_that_collide_are_refused() -> None:
    assert collision("a.jpg", "a.png") == (
        "in/a.jpg and in/a.png would both be drawn to a.svg: rename one, or draw them in two runs"
    )
    assert "B/x.jpg and in/b/X.jpg" in collision("B/x.jpg", "b/X.jpg")
    assert "would both be drawn" in collision("stra\u00dfe.jpg", "STRASSE.jpg")
    assert "would both be drawn" in collision("caf\u00e9.jpg", "cafe\u0301.jpg")
    assert "has to be a folder" in collision("a.jpg", "a.svg/b.jpg")
    names.check([Photo(place, place) for place in ("a.jpg", "b/a.jpg", "a.b.jpg", "ab.jpg")], ["svg", "png"], "out")


def test_nothing_begins_where_names_collide(few: Path, tmp_path: Path) -> None:
    Image.fromarray(batches.pixels(1)).save(few / "photo 001.bmp")
    with pytest.raises(gs.InvalidInputError, match=r"would both be drawn to photo 001\.svg"):
        gs.batch(few, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@needs_links
def test_links_are_not_followed_out_of_the_output(few: Path, tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "mine.svg").write_text("mine")
    out = tmp_path / "out"
    out.mkdir()
    (out / "deep").symlink_to(tmp_path / "elsewhere")
    (out / "photo 001.svg").symlink_to(tmp_path / "mine.svg")
    results = list(gs.batch(few, out, OPTIONS))
    failed = sorted(result.error for result in results if result.error is not None)
    assert [error.endswith("a link leads out of the output") for error in failed] == [True, True]
    assert list((tmp_path / "elsewhere").rglob("*")) == []
    # A link in place of a drawing goes, and not what it leads to.
    assert (tmp_path / "mine.svg").read_text() == "mine"
    assert (out / "photo 001.svg").read_bytes() == batches.expected(6)["photo 001.svg"]
    (out / "manifest.jsonl").unlink()
    (out / "manifest.jsonl").symlink_to(tmp_path / "elsewhere" / "manifest.jsonl")
    with pytest.raises(gs.InvalidInputError, match="a link leads out of the output"):
        gs.batch(few, out, OPTIONS)


def test_pipes_and_folders_are_no_photos(few: Path, tmp_path: Path) -> None:
    (few / "folder.png").mkdir()
    os.mkfifo(few / "pipe.png")
    results = list(gs.batch([few, few / "pipe.png"], tmp_path / "out", OPTIONS))
    assert [result.error for result in results if result.error] == [f"{few}/pipe.png: this is no file"]
    assert len(results) == 7


def test_files_that_are_read_only_are_overwritten_by_force_alone(few: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "photo 001.svg").write_text("mine")
    (out / "photo 001.svg").chmod(0o444)
    (result,) = gs.batch(few / "photo 001.png", out, OPTIONS)
    assert "read-only" in str(result.error)
    assert (out / "photo 001.svg").read_text() == "mine"
    (result,) = gs.batch(few / "photo 001.png", out, OPTIONS, settings={"force": True})
    assert result.error is None


def test_a_worker_that_is_killed_costs_no_photo(photos: Path, tmp_path: Path) -> None:
    results = []
    for result in gs.batch(photos, tmp_path / "out", OPTIONS, processes=2):
        results.append(result)
        if len(results) == 50:
            os.kill(multiprocessing.active_children()[0].pid, signal.SIGKILL)
    batches.check(results)
    assert batches.drawn(tmp_path / "out") == batches.expected()


def test_a_photo_that_ends_its_workers_is_given_up(tmp_path: Path) -> None:
    addresses = ["a", "deadly", f"once:{tmp_path / 'mark'}", "b", "c"]
    tasks = (Task(address, (address,)) for address in addresses)
    came = {task.address: done for task, done in local.draw(tasks, batches.deadly, 2, Admission(100, 2), local.Stop())}
    assert set(came) == set(addresses)
    assert came.pop("deadly").sentence == "deadly: it ended its worker each time that it was tried"
    assert {done.kind for done in came.values()} == {"drawn"}


def test_photos_are_admitted_by_their_memory(tmp_path: Path) -> None:
    log = tmp_path / "log"
    wanted = [10, 60, 90, 10, 10, 80, 100, 30, 101, 10]
    tasks = (Task(str(log), (str(size),)) for size in wanted)
    came = list(local.draw(tasks, batches.greedy, 3, Admission(100, 4), local.Stop()))
    assert [(task.names, done.sentence) for task, done in came if done.kind == "failed"] == [
        (("101",), f"{log}: it needs about 101 bytes of memory, but 100 bytes are allowed: raise memory")
    ]
    spans = [[int(word) for word in line.split()] for line in log.read_text().splitlines()]
    assert len(spans) == len(wanted) - 1
    for begin, _, _ in spans:
        assert sum(granted for first, last, granted in spans if first <= begin <= last) <= 100


def test_memory_is_that_of_the_documents(few: Path, tmp_path: Path) -> None:
    options = _core.Options({})
    hundred = memory.of_size(12_000, 8_400, options)
    assert 2.1e9 < hundred < 2.4e9
    data = (few / "photo 001.png").read_bytes()
    assert 20 * 16 * memory.BYTES_A_PIXEL < memory.needed(data, options) < 1e6
    assert memory.needed(b"II*\0no size", options) is None
    assert memory.needed(b"no image", options) == 8
    (result,) = gs.batch(few / "photo 001.png", tmp_path / "out", memory="10kB")
    assert re.search(r"it needs about \d+ kB of memory, but 10 kB are allowed", str(result.error))


def test_processes_times_threads_are_at_most_the_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engines, "cores", lambda: 8)
    assert engines.shares(100, None, None) == (8, 1)
    assert engines.shares(100, 3, None) == (3, 2)
    assert engines.shares(2, None, None) == (2, 4)
    assert engines.shares(100, 8, 3) == (2, 3)
    assert engines.shares(100, 100, None) == (8, 1)
    with pytest.raises(gs.InvalidInputError, match="at most 8"):
        engines.shares(100, None, 9)


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EIO])
def test_a_full_output_ends_the_batch_and_leaves_nothing(number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = Store(str(tmp_path))
    store.write({"a/one.svg": b"1", "a/one.png": b"2"})
    replace = Path.replace

    def full(path: Path, target: Path) -> Path:
        if target.suffix == ".png":
            raise OSError(number, os.strerror(number))
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(OutputLostError, match="nothing can be written to the output any more"):
        store.write({"a/two.png": b"2", "a/two.svg": b"1"})
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == ["one.png", "one.svg"]


def test_an_output_that_is_gone_ends_the_batch(photos: Path, tmp_path: Path) -> None:
    results = gs.batch(photos, tmp_path / "out", OPTIONS, processes=1, manifest=tmp_path / "manifest.jsonl")
    next(results)
    (tmp_path / "out").rename(tmp_path / "gone")
    with pytest.raises(OutputLostError, match="the output is gone"):
        list(results)
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(os.name != "posix", reason="signals to a group")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_run_that_is_stopped_goes_on_later(number: signal.Signals, photos: Path, tmp_path: Path) -> None:
    arguments = [batches.CONSOLE_SCRIPT, "batch", photos, "-o", "out", "-j", "2", "--quiet", *FLAGS]
    with hears_ctrl_c():
        process = subprocess.Popen(arguments, cwd=tmp_path, stderr=subprocess.PIPE, start_new_session=True)
    manifest = tmp_path / "out" / "manifest.jsonl"
    wait_until(lambda: manifest.exists() and manifest.read_bytes().count(b"\n") > 3)
    os.killpg(process.pid, number)
    _, told = process.communicate(timeout=60)
    assert process.returncode == 128 + number
    assert told.decode().startswith("graphstipple: stopping: what is being drawn is drawn to the end; once more drops it\n")
    drawn = batches.drawn(tmp_path / "out")
    assert len(drawn) < 190
    assert drawn.items() <= batches.expected().items()
    assert sum("error" not in record for record in records(manifest)) == len(drawn)
    again = batches.batch(photos, "-o", "out", "-j", "2", *FLAGS, cwd=tmp_path)
    assert f"{len(drawn)} kept" in again.stderr
    assert batches.drawn(tmp_path / "out") == batches.expected()


class _Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.text += data


@needs_links
def test_the_sheet_shows_names_and_runs_nothing(tmp_path: Path) -> None:
    evil = "<script>alert(1)<!script> \"'&amp; 100%#?.png"
    folder = tmp_path / "in" / "javascript:x"
    folder.mkdir(parents=True)
    Image.fromarray(batches.pixels(1)).save(folder / evil)
    (folder / "<img src=x onerror=alert(1)>.png").write_text("bad")
    done = batches.batch("in", "-o", "out", "--sheet", "sheet.html", "--format", "pdf,svg", *FLAGS, cwd=tmp_path)
    assert done.returncode == 1
    page = (tmp_path / "sheet.html").read_text(encoding="utf-8")
    tags = _Tags()
    tags.feed(page)
    assert {tag for tag, _ in tags.found} <= {"html", "meta", "title", "style", "figure", "figcaption", "img", "a", "span"}
    assert "default-src 'none'" in page
    sources_ = [attributes["src"] for tag, attributes in tags.found if tag == "img"]
    assert len(sources_) == 3
    assert all(source.startswith(("in/javascript%3Ax/", "out/javascript%3Ax/")) for source in sources_)
    assert not any(name.startswith("on") for _, attributes in tags.found for name in attributes)
    assert evil in tags.text
    # Nothing half-made is left beside it.
    assert {path.name for path in tmp_path.iterdir()} == {"in", "out", "sheet.html"}


@pytest.fixture
def web(few: Path) -> Iterator[str]:
    """Return the host of a server on this machine with some photos."""

    class Handler(http.server.SimpleHTTPRequestHandler):
        def __init__(self, *arguments: object) -> None:
            super().__init__(*arguments, directory=str(few))

        def log_message(self, *arguments: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"127.0.0.1:{server.server_address[1]}"
        server.shutdown()


def test_credentials_of_addresses_are_told_nowhere(web: str, tmp_path: Path) -> None:
    pytest.importorskip("aiohttp")
    pytest.importorskip("fsspec")
    good = f"http://user:pass-word@{web}/photo%20001.png?token=to-ken"
    bad = f"http://user:pass-word@{web}/missing.png?token=to-ken"
    done = batches.batch(good, bad, "-o", "out", "--sheet", "sheet.html", *FLAGS, cwd=tmp_path)
    assert done.returncode == 1
    told = done.stderr + (tmp_path / "out" / "manifest.jsonl").read_text() + (tmp_path / "sheet.html").read_text()
    assert "missing.png" in told
    assert not [secret for secret in ("pass-word", "to-ken", "user") if secret in told]
    assert batches.drawn(tmp_path / "out") == {"photo 001.svg": batches.expected(6)["photo 001.svg"]}


@pytest.mark.parametrize(
    ("address", "told"),
    [
        ("s3://key:se/cr+et@bucket/a@2x.jpg", "s3://bucket/a@2x.jpg"),
        ("s3://bucket/a@2x.jpg", "s3://bucket/a@2x.jpg"),
        ("http://host:80/a@2x.jpg", "http://host:80/a@2x.jpg"),
        ("https://user@host/a.jpg?X-Amz-Signature=1", "https://host/a.jpg"),
        ("cannot open 'sftp://me:pw@host:22/a.jpg' (denied)", "cannot open 'sftp://host:22/a.jpg' (denied)"),
        ("photos/who?.jpg", "photos/who?.jpg"),
    ],
)
def test_what_is_shown_of_addresses(address: str, told: str) -> None:
    assert shown(address) == told


def test_from_s3_to_s3(tmp_path: Path, photos: Path, s3: str) -> None:
    import s3fs

    files = s3fs.S3FileSystem()
    files.mkdir("photos")
    files.mkdir("drawings")
    files.pipe({f"photos/in/{path.relative_to(photos).as_posix()}": path.read_bytes() for path in photos.rglob("*.png")})
    arguments = ("s3://photos/in", "-o", "s3://drawings/out", "-j", "2", *FLAGS)
    done = batches.batch(*arguments, cwd=tmp_path)
    assert "190 drawn, 10 failed: manifest.jsonl" in done.stderr
    files.invalidate_cache()
    found = {name.removeprefix("drawings/out/"): data for name, data in files.cat(files.find("drawings/out")).items()}
    assert found == batches.expected()
    again = batches.batch(*arguments, cwd=tmp_path)
    assert "190 kept, 10 failed" in again.stderr
    missing = batches.batch("s3://photos/in", "-o", "s3://nowhere/out", "-j", "1", "--quiet", *FLAGS, cwd=tmp_path)
    assert missing.returncode == 1
    assert "nothing can be written to the output any more" in missing.stderr


def test_a_script_without_a_main_is_told_what_is_wrong(few: Path, tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(f"import graphstipple as gs\nprint(list(gs.batch({str(few)!r}, 'out', processes=1)))\n")
    done = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].endswith("a script has to call graphstipple.batch under if __name__ == '__main__':")


def test_a_generator_that_is_left_ends_its_workers(photos: Path, tmp_path: Path) -> None:
    results = gs.batch(photos, tmp_path / "out", OPTIONS, processes=2)
    next(results)
    results.close()
    assert multiprocessing.active_children() == []
    assert batches.drawn(tmp_path / "out").items() <= batches.expected().items()


def test_a_run_is_checked_before_it_begins(few: Path, tmp_path: Path) -> None:
    (tmp_path / "map.png").write_text("no image")
    with pytest.raises(gs.ImageFileError, match="not an image"):
        Run(Asked([str(few)], str(tmp_path / "out"), [("importance", str(tmp_path / "map.png"))]))
    assert not (tmp_path / "out").exists()
