"""Memory: how much the machine has, and how much is told to people."""

from __future__ import annotations

import os

WITHOUT_A_LOOK = 4 << 30
"""Memory, where the system does not say how much it has."""


def half_of_the_memory() -> int:
    """Return half of the machine's memory, in bytes."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2
    except (AttributeError, ValueError, OSError):
        return WITHOUT_A_LOOK


def in_words(count: float) -> str:
    """Return a number of bytes as people write it."""
    for unit, size in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= size:
            return f"{count / size:.3g} {unit}"
    return f"{count:.0f} bytes"
