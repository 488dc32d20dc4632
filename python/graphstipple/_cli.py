"""The console script: the same command line as the native binary's, by the same Rust code."""

from __future__ import annotations

import os
import sys

from graphstipple import _core

INTERRUPTED = 130
"""The exit code of a run that was stopped."""


def main() -> int:
    """Run the command line on the program's arguments and return its exit code."""
    code = _core.cli(["graphstipple", *sys.argv[1:]])
    if code == INTERRUPTED:
        # A thread of Pillow's may be at work still, which the interpreter must not wait for, nor take away what it works with.
        os._exit(code)
    return code
