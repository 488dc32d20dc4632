"""Sessions: the same drawings as from the start, whatever changed in between, and whatever went wrong."""

import dataclasses
import json
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
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from tests.support import options_with, photo

import graphstipple as gs

# Another value of every option, and of every parameter of the published method.
CHANGES: dict[str, Any] = {
    "nodes": 700,
    "fineness": 0.6,
    "nodes_per_pixel": 0.2,
    "detail": 0.4,
    "floor": 0.3,
    "midtones": 0.1,
    "relax": 2,
    "stippling": 0.7,
    "shading": 0.6,
    "crispness": 1.0,
    "cohesion": 0.5,
    "sharpen": 0.5,
    "local_contrast": 0.2,
    "tone_tolerance": None,
    "tolerance": 0.6,
    "wobble": 0.3,
    "edge": "torn",
    "refine": 0,
    "split": 0,
    "stipple_scale": 0.5,
    "stipple_min": 0.3,
    "stipple_max": 0.6,
    "irregularity": 0.9,
    "seed": 7,
    "white_point": 0.9,
    "black_point": 0.1,
    "linear": True,
    "gamma": 1.6,
    "contrast": 0.6,
    "invert": True,
    "backdrop": "ink",
    "background": "#000",
    "inks": "#c80000",
    "levels": 4,
    "extract_inks": 5,
    "overprint": True,
    "paper": "#eeeecc",
    "threads": 1,
    "lattice": "square",
    "density": 0.7,
    "k1": 3.0,
    "k2": 0.4,
    "base": 0.6,
    "detail_gain": 1.0,
    "hops": 2,
    "importance_alpha": "dynamic",
    "alpha": "dynamic",
    "importance_order": "global",
    "order": "global",
    "error_weighting": "value",
    "crossings": "midpoint",
}


def same(made: gs.Drawing, expected: gs.Drawing) -> bool:
    """Whether two drawings agree in files, data and counts, but for seconds."""
    counts = [{name: value for name, value in drawing.stats.items() if name != "seconds"} for drawing in (made, expected)]
    return (
        made.svg() == expected.svg()
        and made.json() == expected.json()
        and made.options == expected.options
        and counts[0] == counts[1]
        and all(np.array_equal(*pair) for pair in zip(made.graph, expected.graph, strict=True))
        and np.array_equal(made.importance, expected.importance)
    )


def stages(drawing: gs.Drawing) -> set[str]:
    return set(drawing.stats["seconds"]) - {"total"}


def transparent() -> np.ndarray:
    """Return a photo that shows the background in a half of it, (48, 64, 4)."""
    image = np.dstack([photo("astronaut", 64, 48), np.full((48, 64), 255, np.uint8)])
    image[:, 32:, 3] = np.linspace(0, 255, 32).astype(np.uint8)
    return image


def test_every_option_is_changed() -> None:
    groups = (gs.Options(), gs.Options().published)
    fields = {field.name: getattr(group, field.name) for group in groups for field in dataclasses.fields(group)}
    del fields["published"]
    assert list(CHANGES) == list(fields)
    assert all(fields[name] != value for name, value in CHANGES.items())


@given(
    importance=st.sampled_from(["saliency", "none", "constant:0.4", "map", "callable"]),
    start=st.sampled_from(["default", "paper", "stipple", "linocut"]),
    steps=st.lists(st.lists(st.sampled_from(list(CHANGES)), min_size=1, max_size=3), min_size=1, max_size=6),
)
def test_a_session_draws_what_draw_draws(importance, start, steps):
    image = transparent()
    wanted = {"map": image[::2, ::2, 1] / 255, "callable": np.sqrt}.get(importance, importance)
    session = gs.Session(image, wanted)
    changed: set[str] = set()
    for flipped in [[], *steps]:
        changed ^= set(flipped)
        try:
            options = options_with(start, **{name: CHANGES[name] for name in changed})
        except gs.InvalidInputError:
            continue
        try:
            expected = gs.draw(image, wanted, options)
        except gs.InvalidInputError as refused:
            with pytest.raises(gs.InvalidInputError, match=re.escape(str(refused))):
                session.draw(options)
        else:
            assert same(session.draw(options), expected)


def test_another_background_reads_the_photo_again(small: np.ndarray) -> None:
    session = gs.Session(small)
    session.draw()
    assert stages(session.draw(gs.Options(background="black"))) >= {"decoding", "saliency", "lattice", "outlines"}
    assert stages(session.draw(gs.Options(background="#000000", threads=2))) == set()


def test_the_order_of_nodes_reaches_both_diffusions(astronaut: np.ndarray) -> None:
    # Several bands.
    several = {"density": 1.0, "nodes": 20_000}
    session = gs.Session(astronaut[:256, :256])
    orders = [{}, {"order": "global"}, {"importance_order": "global"}]
    drawings = [session.draw(options_with(**several, **order)) for order in orders]
    assert len({drawing.svg() for drawing in drawings}) == 3
    assert ["importance" in drawing.stats["seconds"] for drawing in drawings] == [True, False, True]
    for drawing in drawings:
        for threads in (1, 2):
            assert gs.draw(astronaut[:256, :256], options=drawing.options.replace(threads=threads)).svg() == drawing.svg()
    # The tone's diffusion alone.
    sites, edges, tone = drawings[0].graph.sites, drawings[0].graph.edges, drawings[0].graph.tone
    assert not np.array_equal(*(gs.stages.diffuse(sites, edges, tone, order=order) for order in ("rows", "global")))


def test_image_and_importance_are_read_once(small: np.ndarray, tmp_path: Path) -> None:
    path = tmp_path / "photo.png"
    Image.fromarray(small).save(path)
    seen: list[np.ndarray] = []

    def importance(luma: np.ndarray) -> np.ndarray:
        seen.append(luma)
        return 1 - luma

    expected = [gs.draw(path, lambda luma: 1 - luma, gs.Options(gamma=gamma)) for gamma in (1, 1.5)]
    session = gs.Session(path, importance)
    path.unlink()
    assert all(same(session.draw(gs.Options(gamma=gamma)), drawing) for gamma, drawing in zip((1, 1.5), expected, strict=True))
    assert len(seen) == 1
    np.testing.assert_array_equal(seen[0], gs.stages.tone(small))
    with pytest.raises(gs.ImageFileNotFoundError):
        session.draw(gs.Options(background="black"))
    assert same(session.draw(), expected[0])


def test_repr_says_size_and_importance(small: np.ndarray) -> None:
    assert repr(gs.Session(small)) == "<graphstipple.Session 128 x 96: importance saliency>"
    assert repr(gs.Session(small, "constant:0.5")) == "<graphstipple.Session 128 x 96: importance constant:0.5>"
    assert repr(gs.Session(small, np.ones((2, 2)))) == "<graphstipple.Session 128 x 96: importance map>"


def test_what_cannot_be_drawn_is_refused_at_once(small: np.ndarray, tmp_path: Path) -> None:
    with pytest.raises(gs.ImageFileNotFoundError):
        gs.Session(tmp_path / "missing.png")
    with pytest.raises(gs.InvalidInputError, match="importance is salience"):
        gs.Session(small, "salience")
    with pytest.raises(gs.InvalidInputError, match="importance has the shape"):
        gs.Session(small, np.ones((2, 2, 3)))
    session = gs.Session(small)
    with pytest.raises(gs.InvalidInputError, match="options is of type dict, but it must be"):
        session.draw({"gamma": 1})  # type: ignore[arg-type]


def test_progress_ends_at_one_and_what_it_raises_stops(small: np.ndarray, astronaut: np.ndarray) -> None:
    reports: list[tuple[str, float]] = []
    session = gs.Session(astronaut)
    session.draw(progress=lambda *report: reports.append(report))
    assert len(reports) > 3
    assert reports[-1] == ("outlines", 1.0)
    fractions = [fraction for _, fraction in reports]
    assert fractions == sorted(fractions)

    class StopError(Exception):
        pass

    def stop(stage: str, fraction: float) -> None:
        raise StopError

    options = gs.Options(gamma=1.3)
    with pytest.raises(StopError):
        session.draw(options, progress=stop)
    assert same(session.draw(options), gs.draw(astronaut, options=options))


def test_a_callback_may_draw(small: np.ndarray) -> None:
    session = gs.Session(small)
    inner: list[gs.Drawing] = []

    def again(stage: str, fraction: float) -> None:
        if not inner:
            inner.append(session.draw(gs.Options(relax=0)))

    assert same(session.draw(progress=again), gs.draw(small))
    assert same(inner[0], gs.draw(small, options=gs.Options(relax=0)))


def test_threads_share_a_session(small: np.ndarray) -> None:
    options = [gs.Options(gamma=1 + i % 3 / 4, background=["white", "black"][i % 2]) for i in range(6)]
    image = transparent()
    expected = [gs.draw(image, options=one) for one in options]
    session = gs.Session(image)
    wrong: list[object] = []

    def work(start: int) -> None:
        try:
            for i in range(start, start + 12):
                if not same(session.draw(options[i % 6]), expected[i % 6]):
                    wrong.append(i)
        except BaseException as error:
            wrong.append(error)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX signals")
def test_ctrl_c_leaves_the_session_usable() -> None:
    program = """
import json, signal
signal.signal(signal.SIGINT, signal.default_int_handler)
import graphstipple as gs, numpy as np
noise = np.random.default_rng(1).integers(0, 256, (700, 900)).astype(np.uint8)
session = gs.Session(noise, "none")
def say(stage, fraction):
    if stage == "importance":
        print("now", flush=True)
try:
    session.draw(gs.Options(published=gs.Options().published.replace(density=4.0), relax=20), progress=say)
except KeyboardInterrupt:
    print("interrupted", flush=True)
options = gs.Options(nodes=2000, relax=0)
print(json.dumps(session.draw(options).svg() == gs.draw(noise, "none", options).svg()))
"""
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "now\n"
        os.kill(process.pid, signal.SIGINT)
        rest, errors = process.communicate(timeout=300)
    assert process.returncode == 0, errors
    assert "interrupted" in rest
    assert json.loads(rest.splitlines()[-1]) is True
