"""Drawings in processes: forked, with pickles of drawings, sessions and options, and where there are few threads or none."""

from __future__ import annotations

import copy
import dataclasses
import json
import multiprocessing
import os
import pickle
import subprocess
import sys
import textwrap
import threading
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from tests.commands import native_binary
from tests.support import linux, options_with, photo

import graphstipple as gs
from graphstipple import stages
from graphstipple.drawing import RecordedOptions

PROTOCOLS = range(2, pickle.HIGHEST_PROTOCOL + 1)

WAIT = 60
"""Seconds after which a child counts as hung."""

posix = pytest.mark.skipif(os.name != "posix", reason="forks and signals are POSIX's")


@pytest.fixture(scope="module")
def picture() -> NDArray[np.uint8]:
    return photo("astronaut", 128, 96)


@pytest.fixture(scope="module")
def drawing(picture: NDArray[np.uint8]) -> gs.Drawing:
    return gs.draw(picture)


# After a fork -----------------------------------------------------------------------------------------------------------------

WAYS: dict[str, Callable[[gs.Drawing, NDArray[np.uint8], Path], object]] = {
    "draw": lambda drawing, picture, folder: gs.draw(picture).svg(),
    "draw on one thread": lambda drawing, picture, folder: gs.draw(picture, options=gs.Options(threads=1)).svg(),
    "session": lambda drawing, picture, folder: gs.Session(picture).draw(gs.Options(shading=0.5)).svg(),
    "load": lambda drawing, picture, folder: gs.load(folder / "given.json").svg(),
    "read": lambda drawing, picture, folder: gs.draw(folder / "given.jpg").svg(),
    "rasterize": lambda drawing, picture, folder: drawing.rasterize(700).tobytes(),
    "save": lambda drawing, picture, folder: (drawing.save(folder / "made.png"), (folder / "made.png").read_bytes())[1],
    "svg": lambda drawing, picture, folder: drawing.svg(style="layered"),
    "least dots": lambda drawing, picture, folder: drawing.with_min_dot(1.0).stats["dots_enlarged"],
    "tone": lambda drawing, picture, folder: stages.tone(picture, gs.Options(gamma=1.5)).tobytes(),
    "saliency": lambda drawing, picture, folder: gs.saliency(picture).tobytes(),
    "polygons": lambda drawing, picture, folder: drawing.to_shapely().wkb,
    "pickle": lambda drawing, picture, folder: pickle.loads(pickle.dumps(drawing)).svg(),
}


@pytest.fixture(scope="module")
def folder(picture: NDArray[np.uint8], drawing: gs.Drawing, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("given")
    drawing.save(folder / "given.json")
    Image.fromarray(picture).save(folder / "given.jpg")
    return folder


@posix
@pytest.mark.parametrize("way", WAYS)
def test_everything_works_in_a_forked_child(way: str, picture: NDArray[np.uint8], drawing: gs.Drawing, folder: Path) -> None:
    # What the parent has done before must not matter.
    expected = WAYS[way](drawing, picture, folder)
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    child = context.Process(target=lambda: sender.send(WAYS[way](drawing, picture, folder)))
    child.start()
    try:
        assert receiver.poll(WAIT), "the child hangs"
        assert receiver.recv() == expected
        child.join(WAIT)
        assert child.exitcode == 0
    finally:
        child.kill()


def _texts(path: Path) -> list[str]:
    """Return what a file says, if it is still there."""
    try:
        return [path.read_text()]
    except OSError:
        return []


# Pickles and copies -----------------------------------------------------------------------------------------------------------


def copies(thing: Any) -> list[Any]:
    """Return a thing as every pickle and every copy has it."""
    return [*(pickle.loads(pickle.dumps(thing, protocol)) for protocol in PROTOCOLS), copy.copy(thing), copy.deepcopy(thing)]


def test_options_come_through() -> None:
    options = options_with("portrait", nodes=3000, gamma=1.25, threads=2, hops=3)
    for made in [*copies(options), *copies(options.published)]:
        assert made in (options, options.published)
    for made in copies(options):
        assert dataclasses.asdict(made) == dataclasses.asdict(options)
        assert made.replace(gamma=1.0).gamma == 1.0


def test_recorded_options_come_through(drawing: gs.Drawing, tmp_path: Path) -> None:
    document = json.loads(drawing.json())
    document["options"]["sparkle"] = 3
    (tmp_path / "later.json").write_text(json.dumps(document))
    later = gs.load(tmp_path / "later.json")
    assert isinstance(later.options, RecordedOptions)
    for options in [*copies(later.options), *(made.options for made in copies(later))]:
        assert isinstance(options, RecordedOptions)
        assert dict(options) == dict(later.options)
        with pytest.raises(gs.InvalidInputError, match="sparkle"):
            gs.draw(np.zeros((8, 8), np.uint8), options=options)


@pytest.mark.parametrize("kind", ["drawn", "from a session", "least dots", "loaded", "irregular"])
def test_a_drawing_comes_through(kind: str, picture: NDArray[np.uint8], drawing: gs.Drawing, tmp_path: Path) -> None:
    if kind == "from a session":
        drawing = gs.Session(picture, "none").draw(gs.Options.preset("paper"))
    elif kind == "least dots":
        drawing = drawing.with_min_dot(1.5)
    elif kind == "loaded":
        drawing.save(tmp_path / "a.svg")
        drawing = gs.load(tmp_path / "a.svg")
    elif kind == "irregular":
        drawing = gs.draw(picture, options=gs.Options(irregularity=0.6, seed=3))
    for made in copies(drawing):
        assert made.svg() == drawing.svg()
        assert made.json() == drawing.json()
        assert made.stats == drawing.stats
        assert made.options == drawing.options
        assert made.version == drawing.version
        assert made._core.warnings == drawing._core.warnings
        assert (made.rasterize() == drawing.rasterize()).all()
        assert (made.stipples == drawing.stipples).all()
    assert len(pickle.dumps(drawing)) < len(drawing.json()) + 3000


def test_a_pickled_drawing_says_why_it_has_no_graph(drawing: gs.Drawing) -> None:
    made = pickle.loads(pickle.dumps(drawing))
    for name in ("graph", "importance"):
        with pytest.raises(gs.GraphStippleError, match=f"loaded from a file or a pickle, which hold no {name}"):
            getattr(made, name)
    # A drawing never changes, so its copies need not.
    assert copy.copy(drawing) is drawing
    assert copy.deepcopy([drawing])[0].graph is drawing.graph


@pytest.mark.parametrize(
    "importance",
    ["saliency", "none", "constant:0.3", None, np.linspace(0.2, 1, 48 * 30).reshape(30, 48), lambda luma: 1 - luma],
    ids=["saliency", "none", "constant", "default", "map", "callable"],
)
def test_a_session_comes_through(importance: Any, picture: NDArray[np.uint8]) -> None:
    session = gs.Session(picture, importance)
    session.draw()
    changes = [
        gs.Options(),
        gs.Options(gamma=1.4, nodes=900),
        gs.Options.preset("paper"),
        gs.Options(extract_inks=3),
        gs.Options(background="black"),
    ]
    expected = [session.draw(options).svg() for options in changes]
    for made in copies(session):
        assert repr(made) == repr(session)
        assert [made.draw(options).svg() for options in changes] == expected


def test_a_session_of_a_file_is_read_again_where_it_may_have_to_be(picture: NDArray[np.uint8], tmp_path: Path) -> None:
    clear = np.dstack([picture, np.linspace(0, 255, 128).astype(np.uint8)[None].repeat(96, 0)])
    Image.fromarray(clear).save(tmp_path / "clear.png")
    expected = [gs.draw(clear, options=gs.Options(background=colour)).svg() for colour in ("white", "black")]
    for image in (tmp_path / "clear.png", str(tmp_path / "clear.png"), Image.open(tmp_path / "clear.png"), clear):
        for made in copies(gs.Session(image)):
            again = pickle.loads(pickle.dumps(made))
            assert [again.draw(gs.Options(background=colour)).svg() for colour in ("white", "black")] == expected
    grey = np.ascontiguousarray(clear[:, :, [1, 3]])
    made = pickle.loads(pickle.dumps(gs.Session(grey)))
    assert made.draw(gs.Options(background="black")).svg() == gs.draw(grey, options=gs.Options(background="black")).svg()
    called = pickle.loads(pickle.dumps(gs.Session(clear, lambda luma: luma)))
    assert called.draw().svg() == gs.draw(clear, lambda luma: luma).svg()
    with pytest.raises(gs.InvalidInputError, match="a callable, which was not pickled with the session"):
        called.draw(gs.Options(background="black"))


def test_a_pickled_session_is_as_large_as_its_photo(picture: NDArray[np.uint8]) -> None:
    height, width = picture.shape[:2]
    assert len(pickle.dumps(gs.Session(picture[:, :, 0]))) < 4 * height * width + 3000
    # Of its colours may be drawn later.
    assert len(pickle.dumps(gs.Session(picture))) < (4 + 3) * height * width + 3000
    wide = np.kron(picture[:, :, 0], np.ones((12, 12), np.uint8))
    # What may be reduced by another factor goes with it.
    session = gs.Session(wide, "none")
    few, many = gs.Options(nodes=1000), gs.Options(nodes=100_000)
    made = pickle.loads(pickle.dumps(session))
    assert [made.draw(options).svg() for options in (few, many)] == [
        gs.draw(wide, "none", options).svg() for options in (few, many)
    ]


def test_a_damaged_pickle_is_told_in_one_sentence(drawing: gs.Drawing, picture: NDArray[np.uint8]) -> None:
    make, (packed, seconds, decoder) = drawing.__reduce__()  # type: ignore[misc]
    document, stats, warnings = packed
    for damaged in (document[:-9], document.replace(b'"width"', b'"wider"', 1), b"", b"\xff\xfe"):
        with pytest.raises(gs.InvalidInputError, match=r"^the pickled drawing is damaged: [^\n]+$"):
            make((damaged, stats, warnings), seconds, decoder)
    for damaged in ("", "[]", '{"seconds": 3}', '{"seconds": {"total": []}}', '{"nodes": [1]}'):
        with pytest.raises(gs.InvalidInputError, match="damaged: its stats are no numbers by name"):
            make((document, damaged, warnings), seconds, decoder)
    make, (packed, *rest) = gs.Session(picture).__reduce__()  # type: ignore[misc]
    luma = packed[0].luma
    for wrong in (luma + 1, luma * np.nan):
        with pytest.raises(gs.InvalidInputError, match="must be between 0 and 1"):
            type(packed[0])(wrong, packed[0].size, 1)
    with pytest.raises(gs.InvalidInputError, match="which are not 128 x 96 pixels reduced by 2"):
        type(packed[0])(luma, packed[0].size, 2)
    with pytest.raises(gs.InvalidInputError, match="importance is blue"):
        make((packed[0], "blue", packed[2]), *rest)


def _drawn(session: gs.Session, options: gs.Options) -> gs.Drawing:
    return session.draw(options)


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_process_pools_carry_all_of_them(method: str, picture: NDArray[np.uint8]) -> None:
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"there is no {method} here")
    session = gs.Session(picture)
    changes = [gs.Options(nodes=nodes) for nodes in (500, 1000, 1500)]
    expected = [session.draw(options) for options in changes]
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context(method)) as pool:
        made = list(pool.map(_drawn, [session] * 3, changes, timeout=WAIT))
    for found, wanted, options in zip(made, expected, changes, strict=True):
        assert found.svg() == wanted.svg()
        assert found.options == options
        assert found.stats["nodes"] == wanted.stats["nodes"]


# Threads ----------------------------------------------------------------------------------------------------------------------

EVERYTHING = """
    import io, sys, numpy as np, graphstipple as gs
    from graphstipple import stages
    picture = np.random.default_rng(3).integers(0, 256, (60, 80), np.uint8)
    drawing = gs.draw(picture)
    drawing.save("a.png"); drawing.save("a.json")
    assert gs.load("a.json").svg() == drawing.svg()
    assert gs.draw("a.png", "none").rasterize(100).shape == (75, 100)
    stages.tone(picture, gs.Options(gamma=2.0))
    session = gs.Session(picture)
    assert session.draw().with_min_dot(1.0).svg()
    print(hash(drawing.svg()))
"""


def ran(program: str, folder: Path, **environment: str) -> str:
    """Run a Python program that must succeed, and return what it prints."""
    result = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)],
        cwd=folder,
        env={**os.environ, "PYTHONHASHSEED": "1", "OPENBLAS_NUM_THREADS": "1", **environment},
        capture_output=True,
        text=True,
        timeout=WAIT,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    return result.stdout


@pytest.mark.parametrize("number", ["100000", "-1", "0", "many", ""])
def test_an_absurd_number_of_threads_in_the_environment_is_ignored(number: str, tmp_path: Path) -> None:
    assert ran(EVERYTHING, tmp_path, RAYON_NUM_THREADS=number) == ran(EVERYTHING, tmp_path)


@linux
def test_no_thread_stays_behind(tmp_path: Path) -> None:
    count = """
    import os, threading
    pause = threading.Event()
    while len(os.listdir("/proc/self/task")) > 1:
        pause.wait(0.01)
    print("alone")
    """
    # rayon's own pool would stay until the process ends.
    *_, after = ran(textwrap.dedent(EVERYTHING) + textwrap.dedent(count), tmp_path).split()
    assert after == "alone"


@linux
def test_one_thread_is_the_one_that_works(tmp_path: Path) -> None:
    Image.fromarray(photo("astronaut")).save(tmp_path / "photo.png")
    command = [native_binary(), "photo.png", "-o", "a.svg", "--quiet", "--threads"]
    for threads in (1, 3):
        most = 0
        with subprocess.Popen([*command, str(threads)], cwd=tmp_path) as process:
            while process.poll() is None:
                status = "".join(_texts(Path(f"/proc/{process.pid}/status")))
                found = [int(line.split()[1]) for line in status.splitlines() if line.startswith("Threads:")]
                most = max([most, *found])
        # And the one that waits.
        assert (process.returncode, most) == (0, threads + 1)


NO_THREADS = """
    #define _GNU_SOURCE
    #include <dlfcn.h>
    #include <errno.h>
    #include <pthread.h>
    #include <stdlib.h>
    int pthread_create(pthread_t *thread, const pthread_attr_t *attr, void *(*start)(void *), void *argument) {
        static int left = -1;
        static int (*real)(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
        if (left < 0) left = atoi(getenv("THREADS_LEFT"));
        if (left == 0) return EAGAIN;
        left--;
        if (!real) real = dlsym(RTLD_NEXT, "pthread_create");
        return real(thread, attr, start, argument);
    }
"""


@pytest.fixture(scope="module")
def few_threads(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a library that lets a process start THREADS_LEFT threads and no more, as a limit on a user's processes does."""
    folder = tmp_path_factory.mktemp("threads")
    (folder / "few.c").write_text(textwrap.dedent(NO_THREADS))
    try:
        made = subprocess.run(["cc", "-shared", "-fPIC", "-o", "few.so", "few.c", "-ldl"], cwd=folder, check=False)
    except FileNotFoundError:
        pytest.skip("there is no C compiler")
    assert made.returncode == 0
    return folder / "few.so"


@linux
@pytest.mark.parametrize("left", [0, 1, 5])
def test_where_no_thread_can_be_had_work_is_done_without(left: int, few_threads: Path, tmp_path: Path) -> None:
    limits = {"LD_PRELOAD": str(few_threads), "THREADS_LEFT": str(left)}
    assert ran(EVERYTHING, tmp_path, **limits) == ran(EVERYTHING, tmp_path)
    Image.fromarray(photo("coffee", 150, 110)).save(tmp_path / "photo.png")
    for name, environment in (("few.svg", limits), ("all.svg", {})):
        command = [native_binary(), "photo.png", "-o", name, "--preview", f"{name}.png"]
        result = subprocess.run(
            command, cwd=tmp_path, env={**os.environ, **environment}, capture_output=True, timeout=WAIT, check=False
        )
        assert (result.returncode, result.stderr) == (0, b"")
    assert (tmp_path / "few.svg").read_bytes() == (tmp_path / "all.svg").read_bytes()


def test_threads_may_draw_at_once(picture: NDArray[np.uint8], drawing: gs.Drawing) -> None:
    made: list[str] = []
    threads = [threading.Thread(target=lambda: made.append(gs.draw(picture).svg())) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(WAIT)
    assert made == [drawing.svg()] * 6
