"""The console script: the same command line as the native binary's, by the same Rust code."""

from __future__ import annotations

import sys

from graphstipple import _core


def main() -> int:
    """Run the command line on the program's arguments and return its exit code."""
    return _core.cli(["graphstipple", *sys.argv[1:]])
