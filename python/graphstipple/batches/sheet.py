"""A contact sheet. In: results; out: a page of HTML with photos and drawings beside each other, without scripts.

Names come from anybody: all are escaped, and the page lets nothing run and nothing load but pictures.
"""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterable
from html import escape
from pathlib import Path
from urllib.parse import quote

from graphstipple._errors import ImageFileError
from graphstipple.batches.addresses import is_address, reason
from graphstipple.batches.run import BatchResult

SHOWN_BY_BROWSERS = (".svg", ".png")
"""Drawings that are shown; others are links."""

HEAD = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy"
  content="default-src 'none'; img-src file: https: http: 'self'; style-src 'unsafe-inline'">
<meta name="viewport" content="width=device-width">
<title>graphstipple: photos and drawings</title>
<style>
body { margin: 1rem; font: 14px/1.4 system-ui, sans-serif; color: #222; background: #fff; }
figure { display: inline-grid; grid-template-columns: 1fr 1fr; gap: 4px; width: min(100%, 30rem); margin: 0 1rem 1.5rem 0;
  vertical-align: top; }
figure img { width: 100%; }
figcaption { grid-column: 1 / -1; overflow-wrap: anywhere; }
.error { color: #a00; }
</style>
"""


def write(path: str, output: str, results: Iterable[BatchResult]) -> None:
    """Write the sheet of a run with this output.

    Raises
    ------
    ImageFileError
        If it cannot be written.
    """
    file, folder = Path(path), Path(os.path.realpath(Path(path).parent))
    part = file.with_name(f".graphstipple-{secrets.token_hex(8)}.part")
    try:
        with part.open("x", encoding="utf-8", errors="replace") as sheet:
            sheet.write(HEAD)
            for result in sorted(results, key=lambda result: result.photo):
                sheet.write(_figure(result, output, folder))
        part.replace(file)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise ImageFileError(f"{path}: the sheet cannot be written ({reason(error)})") from error


def _figure(result: BatchResult, output: str, folder: Path) -> str:
    name = escape(result.photo)
    photo = f'<img src="{_link(result.photo, folder)}" alt="{name}" loading="lazy">'
    if result.error is not None:
        return f'<figure>{photo}<figcaption class="error">{escape(result.error)}</figcaption></figure>\n'
    links = {it: _link(f"{output.rstrip('/')}/{it}", folder) for it in result.outputs}
    shown = next((it for it in result.outputs if it.endswith(SHOWN_BY_BROWSERS)), None)
    drawing = "<span></span>" if shown is None else f'<img src="{links[shown]}" alt="drawing of {name}" loading="lazy">'
    files = " ".join(f'<a href="{link}">{escape(it)}</a>' for it, link in links.items())
    return f"<figure>{photo}{drawing}<figcaption>{name} {files}</figcaption></figure>\n"


def _link(path: str, folder: Path) -> str:
    """Return the address of a file for a page in a folder, for an attribute."""
    if is_address(path):
        return escape(quote(path, safe=":/@%+~"))
    return escape(quote(os.path.relpath(os.path.realpath(path), folder).replace(os.sep, "/").encode("utf-8", "surrogateescape")))
