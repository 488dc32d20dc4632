"""Whether the benchmarks in Python still run, on tiny photos. No time that they measure can fail a test.

Those in Rust run under `cargo test`.
"""

from __future__ import annotations

import importlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from benches import document, measured
from tests import readers
from tests.commands import native_binary
from tests.support import ROOT


def smoke_run(name: str) -> str:
    """Run a benchmark with `--smoke` and return what it prints."""
    environment = {**os.environ, "GRAPHSTIPPLE_BINARY": str(native_binary())}
    command = [sys.executable, ROOT / "benches" / name, "--smoke"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=900, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def figures(table: str, name: str) -> list[float]:
    """Return the numbers in the row of a table that begins with a name."""
    row = next(line for line in table.splitlines() if line.startswith(f"{name} "))
    return [float(word) for word in row.removeprefix(name).replace(",", " ").split() if re.fullmatch(r"[\d.]+", word)]


@pytest.fixture
def peers(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Return the script as a module; it imports the ones beside it."""
    monkeypatch.syspath_prepend(ROOT / "benches")
    return importlib.import_module("peers")


def test_peers_run(peers: ModuleType) -> None:
    table = smoke_run("peers.py")
    for name in ("graphstipple", "textbook"):
        seconds, runs, processor, ratio, marks, points, kilobytes, megabytes = figures(table, name)
        assert min(seconds, processor, ratio, marks, kilobytes, megabytes) > 0
        assert (runs, ratio) == (1, 1) or name == "textbook"
        # Circles are single pairs, as many as were asked for.
        assert points >= marks if name == "graphstipple" else points == marks == peers.TINY_COORDINATES
    # Those of others are measured where they are installed.
    for name in ("inksep", "stippler", "mkbitmap", "potrace", "vtracer"):
        missing = re.search(rf"^{name} .*(is not installed|installs nothing)", table, re.MULTILINE)
        assert missing or len(figures(table, name)) == 8


def test_a_peer_that_is_missing_or_fails_is_told_with_its_reason(peers: ModuleType) -> None:
    ours = peers.Row(peers.Program("graphstipple", "ours", lambda _: []), [measured.Measured(2.0, 1.0, 10**6, None, "")], 3, 4, 500)
    slow = peers.Row(peers.Program("slow", "stippler", lambda _: []), [measured.Measured(60.0, 60.0, 10**6, None, "")], 3, 4, 500)
    broken = peers.Row(peers.Program("broken", "tracer", lambda _: []), failure="exit code 1, and said: no")
    assert figures(peers.table("photo", [ours, slow, broken]), "slow")[3] == 30
    assert re.search("^broken +exit code 1, and said: no$", peers.table("photo", [ours, slow, broken]), re.MULTILINE)
    told = peers.targets({"photo": [ours, slow, broken]})
    assert re.search(r"^slow: times as long as ours +30\.00 +photo +>= 20 +met$", told, re.MULTILINE)
    assert re.search(r"^ours: times as long as broken +- +not measured$", told, re.MULTILINE)


def test_ratios_run() -> None:
    table = smoke_run("ratios.py")
    for title in ("Python, with saliency", "session redrawn", "command line, start to file"):
        row = next(line for line in table.splitlines() if line.startswith(title))
        ratio, limit = re.search(r" (\d+\.\d+) +<= (\d+\.?\d*)  (?:met|missed)", row).groups()
        assert float(ratio) > 0
        assert float(limit) > 0


def test_plots_run() -> None:
    table = smoke_run("plots.py")
    for title in ("order of 500 dots / spade's bulk load", "their tour / 0.7124 sqrt"):
        row = next(line for line in table.splitlines() if line.startswith(title))
        ratio, limit = re.search(r" (\d+\.\d+) +<= (\d+\.?\d*)  (?:met|missed)", row).groups()
        assert float(ratio) > 0
        assert float(limit) > 1
    moved = re.search(r"^areas of (\d+) vertices moved in / drawing them +(\d+\.\d+) ", table, re.MULTILINE)
    assert int(moved[1]) > 100
    assert float(moved[2]) > 0
    beside = re.search(r"^ +50 +(\d+\.\d+) +(\d+\.\d+)(.+)$", table, re.MULTILINE)
    # Of 50 dots in a square metre.
    assert 4 < float(beside[2]) < 7
    theirs = beside[3].split()
    assert beside[3] == "  vpype is not installed" or (len(theirs) == 4 and float(theirs[3]) < 1.1)


def test_batch_runs() -> None:
    pytest.importorskip("distributed")
    table = smoke_run("batch.py")
    for name in ("photos a second, one process of one thread", "two / one", "client, processor ms a photo"):
        assert figures(table, name)[0] > 0


def test_the_studio_runs() -> None:
    if readers.CHROMIUM is None:
        pytest.skip("no Chromium is installed")
    table = smoke_run("studio.py")
    row = re.search(r"^ +60 x 45 +(\d+)((?: +-?\d+\.\d+){7})$", table, re.MULTILINE)
    assert row
    assert int(row[1]) > 0
    whole, _, session, *_ = map(float, row[2].split())
    assert whole > session >= 0
    assert re.search(r"^60 x 45: beyond Session.draw, median, s +\d+\.\d+ +<= 0.1 +(met|missed)$", table, re.MULTILINE)


def test_callgrind_runs() -> None:
    printed = smoke_run("callgrind.py")
    if shutil.which("valgrind") is None:
        pytest.skip("valgrind is not installed: it counts nothing")
    assert min(figures(printed, "triangulation")) > 0


def test_measuring_a_command() -> None:
    done = measured.measure([sys.executable, "-c", "print('x' * 10); bytearray(50_000_000)"], 60)
    assert done.failure is None
    assert done.stdout == "xxxxxxxxxx\n"
    assert done.memory > 50e6
    assert done.seconds > 0
    # What this process holds is not counted in.
    held = bytearray(200_000_000)
    assert measured.measure([sys.executable, "-IS", "-c", ""], 60).memory < len(held) / 4


def test_a_command_that_fails_or_takes_too_long_says_so() -> None:
    assert measured.measure([sys.executable, "-c", "raise SystemExit('broken')"], 60).failure == "exit code 1, and said: broken"
    assert (
        measured.measure([sys.executable, "-c", "import threading; threading.Event().wait()"], 0.2).failure == "stopped after 0 s"
    )


def test_tables_are_put_under_their_commands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "performance.md"
    other = "<!-- run: other -->\nkept\n<!-- end -->\n"
    path.write_text(f"before\n<!-- run: python -V -->\nold\n<!-- end -->\nbetween\n{other}", "utf-8")
    monkeypatch.setattr(document, "DOCUMENT", path)
    document.put("python -V", "new \\1")
    made = "<!-- run: python -V -->\n```text\nnew \\1\n```\n<!-- end -->"
    assert path.read_text("utf-8") == f"before\n{made}\nbetween\n{other}"


def test_the_document_has_tables_that_can_be_made_anew() -> None:
    commands = [match["command"] for match in document.TABLE.finditer(document.DOCUMENT.read_text("utf-8"))]
    assert len(set(commands)) == len(commands) > 3
