"""What subcommands in Python have in common: arguments that are told in one sentence where they are wrong, and signals."""

from __future__ import annotations

import argparse
import contextlib
import signal
import sys
from collections.abc import Callable, Iterator
from typing import NoReturn

FAILURE, USAGE = 1, 2
"""Exit codes."""


def tell(kind: str, sentence: str) -> None:
    """Say something in one line on standard error, if anybody is there."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        sys.stderr.write(f"graphstipple: {kind}: {' '.join(sentence.split())}\n")
        sys.stderr.flush()


class Parser(argparse.ArgumentParser):
    """Arguments, told in one sentence where they are wrong."""

    def error(self, message: str) -> NoReturn:
        """Exit with what is wrong."""
        tell("error", f"{message} (see {self.prog} --help)")
        sys.exit(USAGE)


@contextlib.contextmanager
def stopped_by_signals(stop: Callable[[int, object], None]) -> Iterator[None]:
    """Have the signals that ask a program to stop handled by a function."""
    signals = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name)]
    # What is ignored, as SIGHUP is by nohup, stays so.
    before = {number: signal.signal(number, stop) for number in signals if signal.getsignal(number) != signal.SIG_IGN}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
