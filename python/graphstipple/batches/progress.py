"""How far a run is. In: results; out: on a terminal a bar with rate and time left, elsewhere a line every ten seconds."""

from __future__ import annotations

import contextlib
import shutil
import sys
import threading
import time
from types import TracebackType

LINE_EVERY = 10.0
"""Seconds, where lines stay."""

BAR_EVERY = 0.2
"""Seconds, where they do not."""


class Progress:
    """Tells how far it is, as long as it is entered.

    Parameters
    ----------
    total : int
        How many photos there are.
    quiet : bool
        Whether nothing is told.
    """

    def __init__(self, total: int, *, quiet: bool) -> None:
        self._total = total
        self._done = self._kept = self._failed = 0
        self._bar = bool(sys.stderr and sys.stderr.isatty())
        self._began = time.monotonic()
        self._ended = threading.Event()
        self._thread = None if quiet else threading.Thread(target=self._tell, daemon=True)

    def count(self, *, kept: bool, failed: bool) -> None:
        """Count a photo."""
        self._done += 1
        self._kept += kept
        self._failed += failed

    def line(self) -> str:
        """Return how far it is, in words."""
        spent = time.monotonic() - self._began
        drawn = self._done - self._kept
        words = [f"{self._done} of {self._total} photos"]
        if self._failed:
            words.append(f"{self._failed} failed")
        # What is kept says nothing about how long the others take.
        if drawn and spent > 0 and self._done < self._total:
            rate = drawn / spent
            words.append(f"{rate:.1f} a second" if rate >= 1 else f"{rate * 60:.1f} a minute")
            words.append(f"{_clock((self._total - self._done) / rate)} left")
        return ", ".join(words)

    def _tell(self) -> None:
        while not self._ended.wait(BAR_EVERY if self._bar else LINE_EVERY):
            with contextlib.suppress(OSError, ValueError):
                sys.stderr.write(self._painted() if self._bar else f"graphstipple: {self.line()}\n")
                sys.stderr.flush()

    def _painted(self) -> str:
        line = self.line()
        width = shutil.get_terminal_size().columns - len(line) - 4
        full = max(width, 0) * self._done // self._total
        bar = f"[{'#' * full}{'.' * (width - full)}] " if width > 0 else ""
        return f"\r{bar}{line}\x1b[K"

    def __enter__(self) -> Progress:
        if self._thread:
            self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._ended.set()
        if self._thread:
            self._thread.join()
            if self._bar:
                with contextlib.suppress(OSError, ValueError):
                    sys.stderr.write("\r\x1b[K")
                    sys.stderr.flush()


def _clock(seconds: float) -> str:
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"
