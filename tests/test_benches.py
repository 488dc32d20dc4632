"""Whether the benchmarks in Python still run, on tiny photos. No time that they measure can fail a test.

Those in Rust run under `cargo test`.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from benches import document, measured
from tests.commands import native_binary
from tests.support import ROOT


def smoke_run(name: str) -> str:
    """Run a benchmark with `--smoke` and return what it prints."""
    environment = {**os.environ, "GRAPHSTIPPLE_BINARY": str(native_binary())}
    command = [sys.executable, ROOT / "benches" / name, "--smoke"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=900, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_peers_run() -> None:
    table = smoke_run("peers.py")
    for name in ("graphstipple", "inksep", "stippler", "textbook", "mkbitmap", "potrace", "vtracer"):
        assert f"\n{name} " in table
    assert "ours: times as long as potrace" in table


def test_ratios_run() -> None:
    table = smoke_run("ratios.py")
    for title in ("Python", "session redrawn", "command line"):
        assert title in table


def test_callgrind_runs() -> None:
    printed = smoke_run("callgrind.py")
    assert "triangulation" in printed or "valgrind is not installed" in printed


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
    assert measured.measure([sys.executable, "-c", "import time; time.sleep(60)"], 0.2).failure == "stopped after 0 s"


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
