"""The output. In: bytes under names; out: files, whole or not at all, in a folder or at an address, and never outside.

A file of a folder is written without its name and takes it when it and the others of its photo are complete. Stores of objects,
such as S3, have them whole or not at all by themselves. Names come from `names`, relative and without dots; what may still lead out
of the folder is a link in it, and no such link is followed.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import secrets
import stat
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any

from graphstipple._errors import GraphStippleError, ImageFileError
from graphstipple.batches.addresses import is_address, opened, reason, shown

OF_THE_OUTPUT = {
    getattr(errno, name) for name in ("ENOSPC", "EDQUOT", "EROFS", "EIO", "ESTALE", "ENOTCONN", "ENODEV") if hasattr(errno, name)
}
"""What is wrong with the whole output, and not with one file: nothing more can be written."""

OBJECTS = {"s3", "s3a", "gs", "gcs", "az", "abfs", "abfss", "adl", "oss"}
"""Stores without folders, whose objects are whole or not there."""


class OutputLostError(GraphStippleError, OSError):
    """The output is full or gone, so that nothing more can be written."""


@dataclass(frozen=True)
class Store:
    """An output.

    Parameters
    ----------
    root : str
        A folder, or an address.
    force : bool
        Whether files that are read-only are overwritten.
    run : str
        By what unfinished files of this run are told from those of others.
    """

    root: str = field(repr=False)
    force: bool = False
    run: str = field(default_factory=lambda: secrets.token_hex(6))

    @property
    def folder(self) -> Path | None:
        """The folder, unless it is an address of another kind."""
        if self.root.startswith("file://"):
            return Path(opened(self.root)[1])
        return None if is_address(self.root) else Path(self.root)

    def make(self) -> None:
        """Make the folder, if it is one.

        Raises
        ------
        ImageFileError
            If it cannot be made.
        """
        folder = self.folder
        if folder is None:
            opened(self.root)
            return
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ImageFileError(f"{shown(self.root)}: the folder cannot be made ({reason(error)})") from error

    def hash_of(self, name: str) -> str | None:
        """Return the hash of a file; None if there is none that can be read."""
        try:
            folder = self.folder
            if folder is not None:
                return None if self._leads_out(folder, name) else hash_of((folder / name).read_bytes())
            file_system, path = opened(self.root)
            return hash_of(file_system.cat_file(_joined(path, name)))
        except Exception:  # whatever it is: it is drawn again, and writing it says what is wrong
            return None

    def check(self, names: Sequence[str]) -> None:
        """Check what can be told of files before they are drawn.

        Raises
        ------
        OutputLostError
            If the output is gone.
        ImageFileError
            If one of them may not be written.
        """
        folder = self.folder
        if folder is None:
            return
        if not folder.is_dir():
            raise OutputLostError(f"{shown(self.root)}: the output is gone")
        for name in names:
            path = folder / name
            if self._leads_out(folder, name):
                raise ImageFileError(f"{path}: a link leads out of the output")
            with contextlib.suppress(FileNotFoundError, NotADirectoryError):
                before = path.lstat()
                if stat.S_ISDIR(before.st_mode):
                    raise ImageFileError(f"{path}: this is a folder, not a file")
                if not (self.force or stat.S_ISLNK(before.st_mode)) and not _may_be_written(path, before):
                    raise ImageFileError(f"{path}: the file is read-only: force=True overwrites it")

    def write(self, files: Mapping[str, bytes]) -> None:
        """Write the files of one photo, whole or not at all.

        Raises
        ------
        OutputLostError
            If nothing more can be written.
        ImageFileError
            If one of these files cannot.
        """
        folder = self.folder
        if folder is None:
            self._put(files)
            return
        self.check(list(files))
        try:
            with contextlib.ExitStack() as unfinished:
                paths = {name: folder / name for name in files}
                parts = {name: path.with_name(self._part()) for name, path in paths.items()}
                for name, data in files.items():
                    unfinished.enter_context(_laid_out(parts[name], data))
                for name, path in paths.items():
                    parts[name].replace(path)
        except OSError as error:
            first = folder / next(iter(files))
            if error.errno in OF_THE_OUTPUT or not folder.is_dir():
                told = "there is no space left" if error.errno in (errno.ENOSPC, errno.EDQUOT) else reason(error)
                raise OutputLostError(f"{first}: nothing can be written to the output any more ({told})") from error
            raise ImageFileError(f"{first}: the file cannot be written ({reason(error)})") from error

    def mark(self) -> Path | None:
        """Return an empty file in the folder, if it is one, by which others see that it is the same."""
        folder = self.folder
        if folder is None:
            return None
        path = folder / f"{self._begin}mark.part"
        try:
            path.touch()
        except OSError as error:
            raise ImageFileError(f"{folder}: nothing can be written to the output ({reason(error)})") from error
        return path

    def sweep(self) -> None:
        """Remove what workers that were killed may have left of files without their names."""
        folder = self.folder
        if folder is None:
            return
        for root, _, files in os.walk(folder):
            for name in files:
                if name.startswith(self._begin):
                    Path(root, name).unlink(missing_ok=True)

    @property
    def _begin(self) -> str:
        return f".graphstipple-{self.run}-"

    def _part(self) -> str:
        """Return what a file is called before it has its name: short, since that may be as long as can be."""
        return f"{self._begin}{secrets.token_hex(8)}.part"

    def _leads_out(self, folder: Path, name: str) -> bool:
        """Whether a folder on the way to a file is a link to elsewhere."""
        if "/" not in name:
            return False
        root, parent = os.path.realpath(folder), os.path.realpath((folder / name).parent)
        return parent != root and not parent.startswith(root.rstrip(os.sep) + os.sep)

    def _put(self, files: Mapping[str, bytes]) -> None:
        """Write files to an address."""
        for name, data in files.items():
            try:
                file_system, path = opened(self.root)
                part = None if self.root.split("://")[0] in OBJECTS else self._part()
                _put(file_system, _joined(path, name), data, part)
            except Exception as error:
                told = f"{shown(self.root).rstrip('/')}/{name}"
                raise OutputLostError(f"{told}: nothing can be written to the output any more ({reason(error)})") from error


def hash_of(data: bytes) -> str:
    """Return the hash of a file's bytes, as manifests have it."""
    return f"sha256:{hashlib.sha256(data).hexdigest()}"


def _put(file_system: Any, path: str, data: bytes, part: str | None) -> None:
    """Write a file, first under another name where there is one."""
    if part is None:
        file_system.pipe_file(path, data)
        return
    folder = str(PurePosixPath(path).parent)
    file_system.makedirs(folder, exist_ok=True)
    part = f"{folder}/{part}"
    try:
        file_system.pipe_file(part, data)
        file_system.mv(part, path)
    except BaseException:
        with contextlib.suppress(Exception):
            file_system.rm(part)
        raise


@contextlib.contextmanager
def _laid_out(part: Path, data: bytes) -> Iterator[None]:
    """Write a file but for its name; what has not taken its name at the end is removed."""
    part.parent.mkdir(parents=True, exist_ok=True)
    try:
        with open(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666), "wb") as file:  # noqa: PTH123  # of a descriptor
            file.write(data)
        yield
    finally:
        with contextlib.suppress(OSError):
            part.unlink()


def _may_be_written(path: Path, before: os.stat_result) -> bool:
    return bool(before.st_mode & 0o222) and os.access(path, os.W_OK)


def _joined(path: str, name: str) -> str:
    return f"{path.rstrip('/')}/{name}"
