"""What is built from this repository and measured by scripts: the native binary, and the benchmarks in Rust."""

from __future__ import annotations

import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def native_binary() -> Path:
    """Return the native binary: GRAPHSTIPPLE_BINARY, or that of a release build.

    Raises
    ------
    SystemExit
        If there is none.
    """
    binary = Path(os.environ.get("GRAPHSTIPPLE_BINARY", ROOT / "target" / "release" / "graphstipple"))
    if not binary.is_file():
        sys.exit("there is no native binary: cargo build --release, or set GRAPHSTIPPLE_BINARY")
    return binary


def bench_command(bench: str, is_smoke_run: bool) -> list[str]:
    """Return how cargo builds and runs a benchmark: optimized, or as `cargo test` does, which a smoke run makes do with."""
    # As `make test` builds them, so that nothing is built twice.
    tested = ["test", "--release", "--workspace", "--exclude", "graphstipple-core"]
    kind = tested if is_smoke_run else ["bench", "--package", "graphstipple-bench"]
    return ["cargo", *kind, "--locked", "--bench", bench]
