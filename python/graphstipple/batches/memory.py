"""Memory. In: the bytes of a photo's file, and the options; out: how much a drawing of it takes, before anything is decoded.

Workers are each granted a share of the whole. A photo that needs more goes back, and is begun again when so much is free: its size
is known where its file is read, and that is where it is drawn.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterable

from graphstipple import _core

BYTES_A_PIXEL = 21
"""13 of the drawing and at most 8 of decoding: docs/performance.md, docs/formats.md."""

BYTES_A_NODE = 300
"""283 of a site, and its part of the lattice, likewise."""


def needed(data: bytes, options: _core.Options) -> int | None:
    """Return how many bytes a drawing takes with its file; None if the file does not say how large the photo is."""
    from PIL import Image  # noqa: PLC0415  # the command line starts without it

    try:
        with warnings.catch_warnings():
            # Of sizes, the core has a rule of its own.
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(data)) as image:
                width, height = image.size
    except Image.DecompressionBombError:
        return None
    except Exception:  # whatever it is, the core says it
        # What Pillow does not know and the core does is a TIFF.
        return None if data[:2] in (b"II", b"MM") else len(data)
    return len(data) + of_size(width, height, options)


def of_size(width: int, height: int, options: _core.Options) -> int:
    """Return how many bytes a drawing of a photo of so many pixels takes."""
    return width * height * BYTES_A_PIXEL + int(options.most_nodes(width, height)) * BYTES_A_NODE


class Admission:
    """Memory that photos have at the same time.

    Parameters
    ----------
    total : int
        All of it, in bytes.
    workers : int
        How many share it.
    """

    def __init__(self, total: int, workers: int) -> None:
        self.total = total
        self.share = total // workers
        """What a photo is granted whose size is not known yet."""

    def grants(self, wanted: int, granted: Iterable[int]) -> bool:
        """Whether so much can be granted beside what others have."""
        return wanted <= self.total - sum(granted)
