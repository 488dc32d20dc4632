"""Addresses of fsspec, such as s3://bucket/photos. In: text; out: whether it is one, what may be shown of it, and what opens it."""

from __future__ import annotations

import re
from typing import Any

from graphstipple._errors import InvalidInputError, MissingPackageError

_ADDRESS = re.compile(r"[A-Za-z][A-Za-z0-9+.:-]+://")
"""A letter alone is a drive."""

_SECRETS = re.compile(r"(?<=//)(?:[^/@\s:]*:(?!\d+/)[^@\s]*|[^/@\s]*)@")
"""A user, and what may follow: secrets of S3 have slashes in them; a number and a slash are a port."""

_QUERY = re.compile(r"(://[^\s?'\"]*)\?[^\s'\"]*")
"""Signatures stand there."""


def is_address(text: str) -> bool:
    """Whether it is an address, and not a path."""
    return _ADDRESS.match(text) is not None


def shown(text: str) -> str:
    """Return an address, or a sentence with addresses, without credentials."""
    return _QUERY.sub(r"\1", _SECRETS.sub("", text))


def opened(address: str) -> tuple[Any, str]:
    """Return the file system of an address, and the path in it.

    Raises
    ------
    MissingPackageError
        If fsspec, or what it needs for this kind of address, is not installed.
    InvalidInputError
        If there is no such kind.
    """
    try:
        import fsspec.core  # noqa: PLC0415  # paths do not need it

        file_system, path = fsspec.core.url_to_fs(address)
    except ImportError as error:
        raise MissingPackageError(f"{shown(address)}: a package is missing to open it ({shown(str(error))})") from error
    except ValueError as error:
        raise InvalidInputError(f"{shown(address)}: it cannot be opened ({shown(str(error))})") from error
    return file_system, path


def reason(error: BaseException) -> str:
    """Return what an error of files says, as part of a sentence and without credentials."""
    if isinstance(error, FileNotFoundError):
        return "the file does not exist"
    if isinstance(error, IsADirectoryError):
        return "this is a folder, not a file"
    text = (error.strerror if isinstance(error, OSError) else None) or str(error) or type(error).__name__
    text = " ".join(shown(text).split())
    return text[:1].lower() + text[1:]
