"""``graphstipple studio``: the studio's server, and a browser that opens it.

In: arguments; out: the exit code. What goes wrong is one sentence on standard error, as with drawings: 1 failed, 2 wrong usage.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
import tempfile
import threading
import webbrowser
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from graphstipple import _core
from graphstipple._errors import GraphStippleError, ImageFileError, MissingPackageError
from graphstipple._inputs import MAX_PIXELS, path_to_read
from graphstipple._subcommand import FAILURE, Parser, stopped_by_signals, tell
from graphstipple.options import Options

if TYPE_CHECKING:
    import uvicorn

PORT = 8765
"""The port where no other is asked for: always the same, so that a page finds a studio that was started anew."""

MOST_PORTS = 65535

MOST_BYTES = 1 << 30
"""Bytes of the photo that is begun with: it is kept."""


def main(arguments: list[str]) -> int:
    """Run the command and return its exit code: 0 when Ctrl-C has stopped it."""
    given = _parser().parse_args(arguments)
    try:
        return _run(given.photo, given.port, browse=given.browser)
    except GraphStippleError as error:
        tell("error", str(error))
        return FAILURE


def _parser() -> Parser:
    parser = Parser(
        prog="graphstipple studio",
        description="Opens a page in the browser on which options are turned and the drawing is seen. It is served on this "
        "machine, to this user alone, until Ctrl-C.",
    )
    parser.add_argument("photo", nargs="?", metavar="PHOTO", help="image to begin with; others can be dropped on the page")
    parser.add_argument("--port", type=_port, default=PORT, metavar="N", help="port to serve on, 0 for any [default %(default)s]")
    parser.add_argument(
        "--no-browser", dest="browser", action="store_false", help="open no browser, only print the address to open"
    )
    return parser


def _port(text: str) -> int:
    if not (text.isascii() and text.isdecimal() and int(text) <= MOST_PORTS):
        raise argparse.ArgumentTypeError(f"it is {text}, but it must be a whole number between 0 and {MOST_PORTS}")
    return int(text)


def _run(photo: str | None, port: int, *, browse: bool) -> int:
    try:
        from graphstipple.studio import server  # noqa: PLC0415  # its packages may be missing
    except ImportError as error:
        raise MissingPackageError(
            f"the studio needs packages that are not installed ({error}): pip install graphstipple[studio]"
        ) from error
    begun = None if photo is None else (photo, _file(photo))
    listener = server.listen(port)
    studio = server.Studio(listener.getsockname()[1], begun)
    running = server.serve(studio, listener)
    _print(f"The studio is at {studio.address} (Ctrl-C stops it)")
    with _stopping(running), _browser(studio.address) if browse else contextlib.nullcontext():
        running.run(sockets=[listener])
    return 0


def _print(line: str) -> None:
    """Print a line at once, also where it goes into a file: whoever started this waits for it.

    Raises
    ------
    GraphStippleError
        If it cannot be printed.
    """
    try:
        print(line, flush=True)  # noqa: T201  # it is what was asked for
    except OSError as error:
        # What is left of the line is not tried again at the end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise GraphStippleError(f"the address cannot be printed ({(error.strerror or str(error)).lower()})") from error


def _file(photo: str) -> bytes:
    """Return the bytes of an image file that can be read; of a pipe too, which can be read once.

    Raises
    ------
    ImageFileError
        If it cannot.
    """
    path, options = path_to_read(photo), Options()._checked
    reading = _core.Reading(options.background, options, MAX_PIXELS, False)
    try:
        with Path(path).open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError:
        # The core says what is wrong.
        _core.read_photo(path, reading)
        raise
    if len(data) > MOST_BYTES:
        raise ImageFileError(f"{photo}: the file is too large: at most {MOST_BYTES >> 30} GiB are read")
    _, warning, _ = _core.read_photo(path, reading, data)
    if warning:
        tell("warning", warning)
    return data


@contextlib.contextmanager
def _stopping(running: uvicorn.Server) -> Iterator[None]:
    """Let signals end the server."""

    def stop(number: int, frame: object) -> None:
        # The second time nobody wants to wait.
        running.force_exit = running.should_exit
        running.should_exit = True

    with stopped_by_signals(stop):
        yield


@contextlib.contextmanager
def _browser(address: str) -> Iterator[None]:
    """Open the address in a browser, through a file that only the user can read: arguments of programs everybody can."""
    if not _has_display():
        tell("warning", "there is no display to open a browser on: open the address yourself, or say --no-browser")
        yield
        return
    with contextlib.ExitStack() as stack:
        try:
            folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="graphstipple-studio-"))
            page = Path(folder) / "open.html"
            page.touch(mode=0o600)
            page.write_text(_redirect(address), encoding="utf-8")
        except OSError as error:
            told = (error.strerror or str(error)).lower()
            tell(
                "warning", f"no browser is opened, since there is no place for a temporary file ({told}): open the address yourself"
            )
        else:
            # Some browsers are waited for.
            threading.Thread(target=_open, args=(page.as_uri(),), daemon=True).start()
        yield


def _redirect(address: str) -> str:
    """Return a page that leads to the address."""
    target = escape(address, quote=True)
    head = '<!doctype html><meta charset="utf-8"><meta name="referrer" content="no-referrer"><title>graphstipple</title>'
    return f'{head}<meta http-equiv="refresh" content="0; url={target}"><a href="{target}">go on</a>\n'


def _has_display() -> bool:
    """Whether a browser has somewhere to show itself; one that the user names may need nothing."""
    windows = not sys.platform.startswith(("linux", "freebsd", "openbsd", "netbsd"))
    return windows or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))


def _open(page: str) -> None:
    try:
        opened = webbrowser.open(page)
    except (webbrowser.Error, OSError):
        opened = False
    if not opened:
        tell("warning", "no browser was found: open the address yourself, or say --no-browser")
