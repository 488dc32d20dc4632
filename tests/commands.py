"""Running the command line in tests."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
from tests.support import ROOT

FAILURE, USAGE = 1, 2
"""Exit codes."""


def native_binary() -> Path:
    """Return the native binary: GRAPHSTIPPLE_BINARY, or the newest one under target/."""
    given = os.environ.get("GRAPHSTIPPLE_BINARY")
    if given:
        return Path(given)
    found = [path for kind in ("release", "debug") if (path := ROOT / "target" / kind / "graphstipple").is_file()]
    if not found:
        pytest.fail("no native binary: build it (cargo build --release) or set GRAPHSTIPPLE_BINARY")
    return max(found, key=lambda path: path.stat().st_mtime)


def run(
    program: Path, *arguments: object, cwd: Path | None = None, columns: int | None = None
) -> subprocess.CompletedProcess[bytes]:
    """Run a program to its end, in a terminal of so many columns where they are given."""
    command = [program, *map(str, arguments)]
    environment = {**os.environ, **({} if columns is None else {"COLUMNS": str(columns)})}
    return subprocess.run(
        command, cwd=cwd, env=environment, capture_output=True, timeout=120, stdin=subprocess.DEVNULL, check=False
    )


def done(
    program: Path, *arguments: object, cwd: Path | None = None, columns: int | None = None
) -> subprocess.CompletedProcess[bytes]:
    """Run a program that must succeed."""
    result = run(program, *arguments, cwd=cwd, columns=columns)
    assert result.returncode == 0, result.stderr.decode()
    return result


def assert_one_sentence(result: subprocess.CompletedProcess[bytes], code: int) -> None:
    """Check that a run failed with this code, and said why in one line of standard error."""
    assert result.returncode == code, result.stderr.decode()
    message = result.stderr.decode()
    assert message.endswith("\n")
    assert "panicked" not in message
    assert result.stdout == b""
    assert message.count("\n") == 1
    assert 15 < len(message) < 400
