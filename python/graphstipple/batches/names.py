"""Names of drawings. In: photos with their places; out: a name for each and format, no two of which any system takes for one.

File systems differ in what they take for the same name: some do not tell case apart, some not the ways in which Unicode writes one
character. So names that differ by no more are refused everywhere, before anything is drawn.
"""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Iterable, Sequence
from pathlib import Path, PurePosixPath

from graphstipple._errors import InvalidInputError
from graphstipple.batches.addresses import is_address, shown
from graphstipple.batches.sources import Photo


def of(place: str, suffixes: Sequence[str]) -> tuple[str, ...]:
    """Return the names of a photo's drawings, one for each format."""
    path = PurePosixPath(place)
    return tuple(str(path.with_name(f"{path.stem}.{suffix}")) for suffix in suffixes)


def key(name: str) -> str:
    """Return what names have in common that a file system may take for one."""
    return unicodedata.normalize("NFC", unicodedata.normalize("NFD", name).casefold())


def check(photos: Iterable[Photo], suffixes: Sequence[str], output: str, others: Iterable[str] = ()) -> None:
    """Check that every drawing has a place of its own, and takes that of no photo, nor of one of the other files of the run.

    Raises
    ------
    InvalidInputError
        For the first that has not.
    """
    root = None if is_address(output) else os.path.realpath(output)
    taken: dict[str, str] = {}
    folders: dict[str, str] = {}
    kept = {key(path): path for path in (_in_output(other, output, root) for other in others) if path is not None}
    in_output: dict[str, str] = {}
    real_folders: dict[str, str | None] = {}
    for photo in photos:
        same = _in_output(photo.address, output, root, real_folders)
        if same is not None:
            in_output[key(same)] = photo.address
        name = of(photo.place, suffixes[:1])[0]
        # With the same stem they collide in every format.
        stem = key(name)
        if stem in taken:
            both = f"{shown(taken[stem])} and {shown(photo.address)}"
            raise InvalidInputError(f"{both} would both be drawn to {name}: rename one, or draw them in two runs")
        taken[stem] = photo.address
        for folder in PurePosixPath(name).parents:
            if folder.name and folders.setdefault(key(str(folder)), photo.address) != photo.address:
                break
    is_one_format = len(suffixes) == 1
    for stem, address in taken.items():
        for suffix in suffixes:
            name = stem if is_one_format else key(of(stem, [suffix])[0])
            if name in kept:
                raise InvalidInputError(f"{shown(address)} would be drawn over {kept[name]}")
            if name in in_output:
                raise InvalidInputError(
                    f"{shown(address)} would be drawn over the photo {shown(in_output[name])}: choose another folder or format"
                )
            if name in folders:
                raise InvalidInputError(
                    f"{shown(address)} would be drawn to {name}, which has to be a folder for {shown(folders[name])}"
                )


def _in_output(address: str, output: str, root: str | None, folders: dict[str, str | None] | None = None) -> str | None:
    """Return the name that a file has in the output, if it lies there; `folders` keeps what was found of whole folders."""
    if root is None or is_address(address):
        begin = output.rstrip("/") + "/"
        return address.removeprefix(begin) if address.startswith(begin) else None
    folders = {} if folders is None else folders
    folder, name = os.path.split(address)
    if folder not in folders:
        real = os.path.realpath(folder)
        inside = real == root or real.startswith(root.rstrip(os.sep) + os.sep)
        folders[folder] = Path(real).relative_to(root).as_posix() if inside else None
    place = folders[folder]
    return None if place is None else str(PurePosixPath(place, name))
