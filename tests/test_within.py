"""The finest drawing within a limit: it fits, little is left over, and its options give it again without the limit."""

import json
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from tests.commands import USAGE, assert_one_sentence, done, native_binary, run
from tests.support import photo

import graphstipple as gs

MOST_TRIALS = 8
ENOUGH = 0.98
NAMES = ["astronaut", "camera", "coffee", "chelsea", "rocket"]


@pytest.fixture(scope="module")
def command() -> Path:
    return native_binary()


@pytest.mark.parametrize(
    ("name", "part", "suffix", "preset"),
    [
        *((name, part, "svg", "default") for name in NAMES for part in (0.5, 0.15)),
        *(("coffee", 0.5, suffix, "default") for suffix in ("pdf", "json")),
        *(("camera", 0.9, "svg", preset) for preset in ("default", "paper", "linocut")),
    ],
)
def test_bytes_are_kept_within_two_percent(name, part, suffix, preset, tmp_path):
    image, path = photo(name, 240, 180), tmp_path / f"drawing.{suffix}"

    def bytes_of(drawing: gs.Drawing) -> bytes:
        drawing.save(path)
        return path.read_bytes()

    options = gs.Options.preset(preset)
    most = int(len(bytes_of(gs.draw(image, options=options))) * part)
    drawing = gs.draw(image, options=options, max_bytes=most, written={"suffix": suffix})
    written, within = bytes_of(drawing), drawing.stats["within"]
    size = len(written)
    assert size <= most
    assert within["bytes"] == size
    assert within["trials"] <= MOST_TRIALS
    assert (within["tolerance"], drawing.stats["nodes"]) == (drawing.options.tolerance, within["nodes"])
    # A node more or less changes small drawings by more than that: then all trials were made.
    assert size >= ENOUGH * most or within["trials"] >= MOST_TRIALS - 1
    assert size >= 0.9 * most
    assert bytes_of(gs.draw(image, options=drawing.options)) == written


@settings(max_examples=12)
@given(
    name=st.sampled_from(NAMES),
    preset=st.sampled_from(["default", "paper", "portrait", "linocut", "scratchboard"]),
    limit=st.sampled_from([("max_points", 200), ("max_points", 1500), ("max_bytes", 6_000), ("max_bytes", "20kB")]),
    suffix=st.sampled_from(["svg", "pdf", "dxf", "png", "json"]),
)
def test_no_limit_is_exceeded(name, preset, limit, suffix):
    image, options = photo(name, 96, 72), gs.Options.preset(preset)
    what, most = limit
    try:
        drawing = gs.draw(image, options=options, **{what: most}, written={"suffix": suffix})
    except gs.InvalidInputError as refused:
        least = re.fullmatch(rf"{what} is \d+, but it must be at least (\d+): the coarsest drawing .*", str(refused))
        assert least
        assert int(least[1]) > (20_000 if most == "20kB" else most)
        return
    within = drawing.stats["within"]
    assert 1 <= within["trials"] <= MOST_TRIALS
    assert within["points"] == drawing.stats["coordinates"]
    assert within[what.removeprefix("max_")] <= (20_000 if most == "20kB" else most)
    assert gs.draw(image, options=drawing.options).json() == drawing.json()
    if within["trials"] == 1:
        assert drawing.options == options


def test_a_session_and_draw_find_the_same_and_the_session_goes_on(small):
    session = gs.Session(small)
    plain = session.draw().svg()
    most = len(plain) // 2
    found = session.draw(max_bytes=most)
    assert found.svg() == gs.draw(small, max_bytes=most).svg()
    assert session.draw().svg() == plain
    assert session.draw(max_points=10**9).stats["within"]["trials"] == 1
    assert session.draw().stats["within"] is None


def test_the_settings_of_the_file_count(tmp_path, small):
    written = {"suffix": "pdf", "page": "A4", "style": "layered", "min_dot": "8mm"}
    drawing = gs.draw(small, max_bytes="6kB", written=written)
    drawing.save(tmp_path / "out.pdf", page="A4", style="layered")
    assert drawing.stats["within"]["bytes"] == (tmp_path / "out.pdf").stat().st_size <= 6000
    assert drawing.stats["dots_enlarged"] + drawing.stats["dots_dropped"] > 0
    plain = gs.draw(small, options=drawing.options).with_min_dot("8mm", page="A4")
    assert plain.svg() == drawing.svg()
    assert drawing.stats["seconds"]["total"] >= plain.stats["seconds"]["total"] / 100
    assert {"saliency", "diffusion", "outlines", "decoding"} <= set(drawing.stats["seconds"])


def test_fewer_nodes_take_the_place_of_those_asked_for_a_pixel(small):
    drawing = gs.draw(small, options=gs.Options(nodes_per_pixel=0.3), max_points=150)
    assert drawing.stats["within"]["points"] <= 150
    assert drawing.options.nodes is not None
    assert drawing.options.nodes_per_pixel is None


def test_the_total_has_all_that_was_done_once(small):
    drawing = gs.draw(small, max_points=300)
    assert drawing.stats["within"]["trials"] > 1
    of_finest, of_others = drawing._core.stats()["seconds"], drawing._seconds
    assert {"decoding", "diffusion"} <= set(of_others)
    assert "total" not in of_others
    assert drawing.stats["seconds"]["total"] == pytest.approx(of_finest["total"] + sum(of_others.values()))


def test_progress_goes_through_all_trials_and_never_back(small):
    told: list[float] = []
    drawing = gs.draw(small, max_points=300, progress=lambda stage, fraction: told.append(fraction))
    assert drawing.stats["within"]["trials"] > 1
    assert told == sorted(told)
    assert told[-1] == 1.0


def test_what_the_callback_raises_ends_the_search(small):
    def stop(stage, fraction):
        raise KeyboardInterrupt

    session = gs.Session(small)
    with pytest.raises(KeyboardInterrupt):
        session.draw(max_points=300, progress=stop)
    assert session.draw().svg() == gs.draw(small).svg()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            {"max_bytes": 0},
            "max_bytes is 0, but it must be a number of bytes, at least 1, or one with a unit such as 100kB, 1MB or 100KiB",
        ),
        ({"max_bytes": "lots"}, 'max_bytes is "lots", but it must be a number of bytes, at least 1'),
        ({"max_points": 1.5}, "max_points is 1.5, but it must be a whole number, at least 1"),
        ({"max_points": "20k"}, 'max_points is "20k", but it must be a whole number, at least 1'),
        ({"max_points": 9, "written": {"suffix": "sgv"}}, r"suffix is sgv, but it must be .*; did you mean \.svg\?"),
        ({"max_points": 9, "written": {"suffix": 3}}, "suffix is 3, but it must be a str"),
        (
            {"max_points": 9, "written": {"stile": "flat"}},
            "there is no setting stile of how a drawing is written; did you mean style",
        ),
        ({"max_points": 9, "written": "svg"}, "written is 'svg', but it must be a mapping of settings by name"),
        ({"written": {}}, "written is given, but it must be left out unless max_bytes or max_points is given"),
        (
            {"max_points": 1},
            r"max_points is 1, but it must be at least \d+: the coarsest drawing that was tried has so many points",
        ),
    ],
)
def test_limits_that_cannot_be_are_told(small, arguments, message):
    with pytest.raises(gs.InvalidInputError, match=f"^{message}"):
        gs.draw(small, **arguments)


def test_numpy_numbers_are_numbers(small):
    assert gs.draw(small, max_points=np.int64(10**6), max_bytes=np.float64(1e9)).stats["within"]["trials"] == 1


def test_the_command_finds_what_python_finds(command, tmp_path):
    Image.fromarray(photo("coffee", 200, 150)).save(tmp_path / "coffee.png")
    result = done(command, "coffee.png", "-o", "out.svg", "--max-bytes", "20kB", "--stats", cwd=tmp_path)
    stats = json.loads(result.stdout)
    drawing = gs.draw(tmp_path / "coffee.png", max_bytes=20_000)
    assert (tmp_path / "out.svg").read_text() == drawing.svg()
    assert stats["within"] == drawing.stats["within"]
    assert 0.95 * 20_000 < (tmp_path / "out.svg").stat().st_size <= 20_000
    # And with the options that it found, without the limit.
    nodes, tolerance = drawing.options.nodes, drawing.options.tolerance
    done(command, "coffee.png", "-o", "again.svg", "--nodes", nodes, "--tolerance", tolerance, cwd=tmp_path)
    assert (tmp_path / "again.svg").read_bytes() == (tmp_path / "out.svg").read_bytes()
    # A least dot comes before the measure, the preview after.
    arguments = ["--min-dot", "0.5mm", "--width", "100mm", "--preview", "p.png"]
    done(command, "coffee.png", "-o", "dots.pdf", "--max-bytes", "10k", *arguments, cwd=tmp_path)
    written = {"suffix": "pdf", "width": "100mm", "min_dot": "0.5mm"}
    drawing = gs.draw(tmp_path / "coffee.png", max_bytes=10_000, written=written)
    drawing.save(tmp_path / "dots-python.pdf", width="100mm")
    assert (tmp_path / "dots.pdf").read_bytes() == (tmp_path / "dots-python.pdf").read_bytes()
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "p.png").convert("L")), drawing.rasterize())


def test_an_impossible_limit_writes_nothing(command, tmp_path):
    Image.fromarray(photo("coffee", 60, 40)).save(tmp_path / "coffee.png")
    result = run(command, "coffee.png", "-o", "out.svg", "--max-bytes", "100", cwd=tmp_path)
    assert_one_sentence(result, USAGE)
    assert "--max-bytes is 100, but it must be at least" in result.stderr.decode()
    assert not (tmp_path / "out.svg").exists()


def test_a_large_photo_is_read_again_where_fewer_nodes_ask_for_it(command, tmp_path):
    Image.fromarray(photo("chelsea", 400, 300)).resize((1600, 1200)).save(tmp_path / "large.png")
    drawing = gs.draw(tmp_path / "large.png", max_points=1000, options=gs.Options(nodes=100_000))
    assert drawing.stats["reduction"] > 1
    assert drawing.stats["within"]["points"] <= 1000
    assert gs.draw(tmp_path / "large.png", options=drawing.options).svg() == drawing.svg()
    with (tmp_path / "large.png").open("rb") as piped:
        arguments = [command, "-", "-o", "-", "--max-points", "1000", "--nodes", "100k"]
        made = subprocess.run(arguments, stdin=piped, capture_output=True, check=True, timeout=120)
    assert made.stdout.decode() == drawing.svg()
