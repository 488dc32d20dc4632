"""The manifest: a line of JSON for every photo. In: what came of photos; out: lines, and which photos need nothing more.

A line is appended when its photo is done, so that a run that was stopped or crashed goes on where it ended; a half last line is no
line.
"""

from __future__ import annotations

import json
import os
import weakref
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from graphstipple import _core
from graphstipple._errors import ImageFileError, InvalidInputError
from graphstipple.batches.addresses import reason


class Earlier(NamedTuple):
    """What an earlier run has made of a photo, with the same options and version."""

    photo_hash: str
    outputs: dict[str, str]
    """The hash of every file, by its name."""


class Manifest:
    """A manifest that lines are appended to.

    Parameters
    ----------
    path : Path
        The file.
    options : Mapping
        What the photos of this run are drawn with.

    Raises
    ------
    ImageFileError
        If the file cannot be read or written.
    InvalidInputError
        If it is something else.
    """

    def __init__(self, path: Path, options: Mapping[str, Any]) -> None:
        self._path = path
        self._options = dict(options)
        self._earlier: dict[str, Earlier] = {}
        try:
            # With both in one descriptor, what is read is what is appended to.
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | getattr(os, "O_CLOEXEC", 0), 0o666)
        except OSError as error:
            raise ImageFileError(f"{path}: the manifest cannot be written ({reason(error)})") from error
        # A run that is never begun closes it, too.
        self._closing = weakref.finalize(self, os.close, self._file)
        self._read()

    def _read(self) -> None:
        ends_whole = True
        with open(os.dup(self._file), "rb") as file:  # noqa: PTH123  # of a descriptor
            for number, line in enumerate(file):
                ends_whole = line.endswith(b"\n")
                record = _record(line)
                if record is None and number == 0 and ends_whole:
                    raise InvalidInputError(f"{self._path}: this is no manifest: name another file")
                if record is not None:
                    self._take(record)
        if not ends_whole:
            self._append(b"\n")

    def _take(self, record: dict[str, Any]) -> None:
        outputs = record.get("outputs")
        if not isinstance(outputs, dict) or not outputs:
            return
        name = next(iter(outputs))
        # The last line of a photo counts.
        self._earlier.pop(name, None)
        if record.get("version") == _core.__version__ and record.get("options") == self._options:
            self._earlier[name] = Earlier(str(record.get("photo_hash")), outputs)

    def earlier(self, names: Sequence[str]) -> Earlier | None:
        """Return what has been made already under these names."""
        found = self._earlier.get(names[0])
        return found if found is not None and tuple(found.outputs) == tuple(names) else None

    def append(self, record: Mapping[str, Any]) -> None:
        """Append what came of a photo.

        Raises
        ------
        ImageFileError
            If it cannot be written.
        """
        whole = {"photo": None, "photo_hash": None, "options": self._options, "version": _core.__version__, **record}
        self._append(json.dumps(whole, separators=(",", ":")).encode("ascii") + b"\n")

    def _append(self, line: bytes) -> None:
        try:
            os.write(self._file, line)
        except OSError as error:
            raise ImageFileError(f"{self._path}: the manifest cannot be written ({reason(error)})") from error

    def close(self) -> None:
        """Close the file."""
        self._closing()


def _record(line: bytes) -> dict[str, Any] | None:
    """Return what a line says, if it is one of a manifest."""
    try:
        record = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return record if isinstance(record, dict) and "photo" in record else None
