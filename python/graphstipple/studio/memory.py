"""How much the studio takes at most."""

from __future__ import annotations

import os

MOST_UPLOADED = 256 << 20
"""Bytes of a photo or a map that are taken from a page."""

WITHOUT_A_LOOK = 4 << 30
"""Memory, where the system does not say how much it has."""


def half_of_the_memory() -> int:
    """Return half of the machine's memory, in bytes."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2
    except (AttributeError, ValueError, OSError):
        return WITHOUT_A_LOOK
