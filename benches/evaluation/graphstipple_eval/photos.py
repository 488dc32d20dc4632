"""Photos of the comparison: found, decoded by graphstipple, reduced to a size.

Every method works on grey levels, so a photo is its luma: decoded by the same Rust code as in `graphstipple.draw` (orientation,
colour profile, transparency over white), reduced, and rounded to 8 bits once.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

import graphstipple as gs
from graphstipple_eval import files
from graphstipple_eval.method import Photo

SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".webp")
"""Files of a folder that are taken as photos: what `graphstipple.draw` reads."""


@dataclass(frozen=True)
class PhotoFile:
    """A photo at a size, as an 8-bit grey PNG in the folder of its pictures.

    Parameters
    ----------
    name : str
        The original file's name without suffix.
    checksum : str
        SHA-256 of the original file.
    size : int
        The size asked for: the longest side in pixels. A smaller photo is not enlarged.
    width, height : int
        The photo's own size at this size.
    path : Path
        The PNG.
    """

    name: str
    checksum: str
    size: int
    width: int
    height: int
    path: Path

    @property
    def folder(self) -> Path:
        """The folder of the photo's pictures at this size."""
        return self.path.parent

    def read(self) -> Photo:
        """Return the photo as methods take it."""
        with Image.open(self.path) as image:
            pixels = np.asarray(image)
        return Photo(self.name, self.checksum, pixels, gs.stages.tone(pixels))


def find(places: Sequence[Path]) -> list[Path]:
    """Return the photos in the folders, not in folders inside them, and the files; sorted by name.

    Raises
    ------
    InvalidInputError
        If a place does not exist, a folder has no photo, two photos have one name, or a name is not UTF-8.
    """
    found: dict[Path, None] = {}
    for place in places:
        if place.is_dir():
            inside = [path for path in sorted(place.iterdir()) if path.suffix.lower() in SUFFIXES and path.is_file()]
            if not inside:
                raise gs.InvalidInputError(f"the folder {place} holds no photo: none of its files ends in {', '.join(SUFFIXES)}")
            found.update((path.resolve(), None) for path in inside)
        elif place.is_file():
            found[place.resolve()] = None
        else:
            raise gs.InvalidInputError(f"{place} does not exist: give folders of photos, or photos")
    by_name: dict[str, Path] = {}
    for path in found:
        try:
            path.name.encode()
        except UnicodeEncodeError:
            raise gs.InvalidInputError(f"the name of the photo {path.name!r} is not UTF-8: rename it") from None
        # Folders and pages are named after photos, and some file systems do not tell upper from lower case.
        other = by_name.setdefault(path.stem.casefold(), path)
        if other != path:
            raise gs.InvalidInputError(f"two photos have the name {path.stem!r}, {other} and {path}: rename one")
    return sorted(found, key=lambda path: (path.stem.casefold(), path))


def reduced(luma: npt.NDArray[np.float32], size: int) -> npt.NDArray[np.uint8]:
    """Return luma in [0, 1] as 8-bit grey levels, its longest side at most `size` pixels (Lanczos filter)."""
    height, width = luma.shape
    scale = min(1.0, size / max(width, height))
    if scale < 1:
        small = (max(1, round(width * scale)), max(1, round(height * scale)))
        luma = np.asarray(Image.fromarray(luma).resize(small, Image.Resampling.LANCZOS))
    return np.round(np.clip(luma, 0, 1) * 255).astype(np.uint8)


def decode(paths: Sequence[Path], sizes: Sequence[int], least_side: int, folder: Path) -> list[tuple[PhotoFile, bytes]]:
    """Read every photo and reduce it to every size, for `write` to write it to `folder/NAME-SIZE/photo.png`.

    Parameters
    ----------
    paths : sequence of Path
        Photos, as `find` returns them.
    sizes : sequence of int
        Longest sides in pixels.
    least_side : int
        The shortest side that the metrics can do with, in pixels.
    folder : Path
        Where to.

    Returns
    -------
    list of (PhotoFile, bytes)
        The photos and the contents of their files; size by size, in the order of `paths`.

    Raises
    ------
    InvalidInputError
        If there are photos that cannot be read, or have a side below `least_side` at a size; it names all of them.
    """
    decoded: dict[tuple[int, Path], tuple[PhotoFile, bytes]] = {}
    refused: list[str] = []
    for path in paths:
        try:
            luma = gs.stages.tone(path)
            original = files.checksum(path.read_bytes())
        except (gs.GraphStippleError, OSError) as error:
            refused.append(str(error))
            continue
        for size in sizes:
            pixels = reduced(luma, size)
            height, width = pixels.shape
            if min(height, width) < least_side:
                refused.append(
                    f"{path} is {width} x {height} pixels at size {size}, but the metrics need at least {least_side} a side"
                )
                break
            target = folder / f"{path.stem}-{size}" / "photo.png"
            decoded[size, path] = (PhotoFile(path.stem, original, size, width, height, target), png(pixels))
    if refused:
        raise gs.InvalidInputError("; ".join(refused))
    return [decoded[size, path] for size in sizes for path in paths]


def write(decoded: Sequence[tuple[PhotoFile, bytes]]) -> list[PhotoFile]:
    """Write the photos that `decode` read, and return them.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    for photo, content in decoded:
        files.write(photo.path, content)
    return [photo for photo, _ in decoded]


def png(pixels: npt.NDArray[np.uint8]) -> bytes:
    """Return grey levels (height, width) as a PNG file."""
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, "PNG")
    return buffer.getvalue()
