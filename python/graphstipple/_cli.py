"""The console script: the same command line as the native binary's, by the same Rust code, and what only Python can do."""

from __future__ import annotations

import os
import signal
import sys
from importlib import import_module
from types import FrameType

from graphstipple import _core

BY_SIGNAL = 128
"""Exit codes above this are those of runs that a signal stopped."""


def main() -> int:
    """Run the command line on the program's arguments and return its exit code."""
    if sys.argv[1:2] in (["batch"], ["studio"]):
        try:
            name = "batches" if sys.argv[1] == "batch" else "studio"
            # A drawing needs neither.
            return int(import_module(f"graphstipple.{name}.command").main(sys.argv[2:]))
        except KeyboardInterrupt:
            # Before they have begun; then they have an end of their own.
            return BY_SIGNAL + signal.SIGINT
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        # What is ignored, as SIGHUP is by nohup, stays so.
        if number is not None and signal.getsignal(number) == signal.SIG_DFL:
            signal.signal(number, _stop)
    code = _core.cli(["graphstipple", *sys.argv[1:]])
    if code > BY_SIGNAL:
        # A thread of Pillow's may be at work still, which the interpreter must not wait for, nor take away what it works with.
        os._exit(code)
    return code


def _stop(number: int, frame: FrameType | None) -> None:
    """Ask the run to stop."""
    raise SystemExit(BY_SIGNAL + number)
