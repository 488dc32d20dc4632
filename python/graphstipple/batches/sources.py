"""Photos. In: paths, folders, globs and addresses as somebody names them, and lists; out: photos, with their places in a tree.

A place is where the drawing lies in the output: a relative path that never leads out of it. Of a folder it is the path in the
folder, of a glob the path from where the first wildcard stands, of a line of a list the whole path. What this module does not do:
open photos.
"""

from __future__ import annotations

import glob
import os
import posixpath
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePath
from typing import NamedTuple
from urllib.parse import unquote, urlsplit

from graphstipple._errors import GraphStippleError, ImageFileError, ImageFileNotFoundError, InvalidInputError
from graphstipple.batches.addresses import is_address, opened, reason, shown

SUFFIXES = {
    ".apng",
    ".avif",
    ".bmp",
    ".dds",
    ".dib",
    ".gif",
    ".heic",
    ".heif",
    ".j2k",
    ".jfif",
    ".jp2",
    ".jpe",
    ".jpeg",
    ".jpf",
    ".jpg",
    ".jpx",
    ".mpo",
    ".pbm",
    ".pcx",
    ".pgm",
    ".png",
    ".pnm",
    ".ppm",
    ".qoi",
    ".ras",
    ".sgi",
    ".tif",
    ".tiff",
    ".webp",
}
"""Suffixes of what is drawn of a folder, where many files may be others; what is named itself is drawn, whatever it is called."""

ONE_BY_ONE = ("http://", "https://")
"""Begins of addresses that have no folders."""


class Photo(NamedTuple):
    """A photo that was found."""

    address: str
    """Its path, or its address, credentials included."""
    place: str
    """Its path in the tree, with slashes."""


def find(named: Iterable[str], *, recursive: bool, output: str) -> Iterator[Photo]:
    """Yield the photos that were named, those of a folder in the order of their names.

    What lies in the output, which may be in a folder that is drawn, is no photo of it.

    Raises
    ------
    ImageFileNotFoundError
        If nothing is there.
    InvalidInputError
        If a glob matches nothing.
    ImageFileError
        If a folder cannot be read.
    """
    for name in named:
        if is_address(name):
            yield from _of_address(name, recursive)
        elif Path(name).is_dir():
            yield from _of_folder(Path(name), recursive, output)
        elif os.path.lexists(name):
            yield Photo(name, Path(name).name)
        elif glob.has_magic(name):
            yield from _of_glob(name)
        else:
            raise ImageFileNotFoundError(f"{name}: there is no such file or folder")


def of_list(lines: Iterable[str]) -> Iterator[Photo]:
    """Yield the photos that the lines of a list name.

    Raises
    ------
    InvalidInputError
        For a line that names no file.
    """
    for line in lines:
        name = line.rstrip("\r\n")
        if name.strip():
            yield Photo(name, _inside(_path_of(name) if is_address(name) else name))


def _inside(path: str) -> str:
    """Return a path without what would lead out of the folder that it is taken in: a root, a drive, and dots."""
    pure = PurePath(os.path.normpath(path))
    parts = [part for part in pure.parts[bool(pure.anchor) :] if part not in ("..", ".")]
    if not parts or "\0" in path:
        raise InvalidInputError(f"{path!r} names no file")
    return "/".join(parts)


def _path_of(address: str) -> str:
    """Return the path of an address, with its bucket or host."""
    parts = urlsplit(shown(address))
    path = unquote(parts.path) if address.startswith(ONE_BY_ONE) else parts.path
    return f"{parts.netloc}/{path.lstrip('/')}"


def _is_photo(name: str) -> bool:
    return not name.startswith(".") and posixpath.splitext(name)[1].lower() in SUFFIXES


def _of_folder(folder: Path, recursive: bool, output: str) -> Iterator[Photo]:
    out = None if is_address(output) else os.path.realpath(output)

    def failed(error: OSError) -> None:
        raise ImageFileError(f"{error.filename}: the folder cannot be read ({reason(error)})")

    # Links to folders are not followed: they may lead in circles.
    for root, folders, files in os.walk(folder, onerror=failed):
        if os.path.realpath(root) == out and Path(root) != folder:
            folders.clear()
            continue
        folders[:] = sorted(name for name in folders if recursive and not name.startswith("."))
        for name in sorted(files):
            path = Path(root, name)
            # A pipe would be waited for.
            if _is_photo(name) and (path.is_file() or path.is_symlink()):
                yield Photo(str(path), path.relative_to(folder).as_posix())


def _of_glob(pattern: str) -> Iterator[Photo]:
    parts = Path(pattern).parts
    fixed = next(place for place, part in enumerate(parts) if glob.has_magic(part))
    root, rest = Path(*parts[:fixed]), str(Path(*parts[fixed:]))
    shows_hidden = any(part.startswith(".") for part in parts[fixed:])
    found = False
    try:
        for path in sorted(root.glob(rest)):
            place = path.relative_to(root)
            if path.is_file() and (shows_hidden or not any(part.startswith(".") for part in place.parts)):
                found = True
                yield Photo(str(path), place.as_posix())
    except ValueError as error:
        raise InvalidInputError(f"{pattern}: {reason(error)}") from error
    if not found:
        raise InvalidInputError(f"{pattern}: no file matches it")


def _of_address(address: str, recursive: bool) -> Iterator[Photo]:
    if address.startswith(ONE_BY_ONE):
        yield Photo(address, _inside(posixpath.basename(_path_of(address).rstrip("/"))))
        return
    file_system, path = opened(address)
    try:
        if file_system.isdir(path):
            root, found = path.rstrip("/"), file_system.find(path, maxdepth=None if recursive else 1)
            chosen = (it for it in found if _is_photo(posixpath.basename(it)))
            begin = address.rstrip("/")
        elif glob.has_magic(path) and not file_system.exists(path):
            fixed = next(place for place, part in enumerate(path.split("/")) if glob.has_magic(part))
            root = "/".join(path.split("/")[:fixed])
            begin = address[: -len(path) + len(root)].rstrip("/")
            chosen = (it for it in file_system.glob(path) if not file_system.isdir(it))
        else:
            yield Photo(address, posixpath.basename(path))
            return
        places = sorted(it.removeprefix(root).lstrip("/") for it in chosen)
    except GraphStippleError:
        raise
    except Exception as error:  # file systems have errors of their own
        raise ImageFileError(f"{shown(address)}: it cannot be listed ({reason(error)})") from error
    if not places:
        raise InvalidInputError(f"{shown(address)}: there is no photo")
    for place in places:
        yield Photo(f"{begin}/{place}", _inside(place))
