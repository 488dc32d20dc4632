"""Files that are whole or not there at all, and their checksums."""

from __future__ import annotations

import hashlib
import os
import tempfile
from pathlib import Path


def write(path: Path, content: bytes) -> None:
    """Write a file by way of a temporary one beside it; leave a file that has this content already untouched.

    Raises
    ------
    OSError
        If the folder cannot be made or written to.
    """
    if path.is_file() and path.read_bytes() == content:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        # mkstemp makes files for their owner alone; a report is to be shown to others.
        Path(temporary).chmod(0o644)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def checksum(content: bytes) -> str:
    """Return the SHA-256 of the content, hexadecimal."""
    return hashlib.sha256(content).hexdigest()
