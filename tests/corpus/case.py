"""What a row of the corpus is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tests.corpus.colour import Luma

CLOSE = 0.002
"""How far, in the mean over all pixels, a photo may be from what an independent reader makes of it."""
CLOSE_CMYK = 0.02
"""The same for inks, of which there is no one right conversion."""


@dataclass(frozen=True)
class Drawn:
    """It is read as this luma, (height, width)."""

    luma: Luma
    tolerance: float = CLOSE


@dataclass(frozen=True)
class Warned(Drawn):
    """It is read as this luma, and a warning says what is wrong with the file."""

    words: tuple[str, ...] = ("cut short",)


@dataclass(frozen=True)
class Refused:
    """It is refused in a sentence with these words and without those, in any case of letters; one of `any_of` must be there too."""

    words: tuple[str, ...] = ()
    without: tuple[str, ...] = ("damaged", "cut short")
    any_of: tuple[str, ...] = ()


@dataclass(frozen=True)
class Made:
    """A file and what should come of it."""

    data: bytes
    expect: Drawn | Refused
    witness: Luma | None = None
    """What another program reads, where one reads the file rightly and the expectation is not already its own."""


@dataclass(frozen=True)
class Case:
    """A file that can be made."""

    name: str
    """Of the test, and of the file without its suffix."""
    container: str
    pixel_type: str
    """What the table of formats says about it: cases with the same words share a row."""
    make: Callable[[], Made]
