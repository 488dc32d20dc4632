"""The studio's server: one page, its files, uploads, and a socket to a desk for each page that is open.

The event loop only carries messages; desks work in threads of their own. In: what passed `guard`; out: messages of the desks.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import mimetypes
import os
import re
import socket
import struct
from collections import deque
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

import anyio
import uvicorn
from starlette.applications import Starlette
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect
from uvicorn.protocols.http.h11_impl import H11Protocol

from graphstipple._errors import InvalidInputError
from graphstipple._memory import half_of_the_memory
from graphstipple.studio.desk import MOST_UPLOADED, Budget, Desk
from graphstipple.studio.guard import Guard

PAGE = Path(__file__).parent / "page"
"""The files of the page."""

MOST_PAGES = 8
"""Pages that may be open at a time, each with a desk of its own."""

MOST_SAID = 1 << 20
"""Bytes of a message on the socket."""

PATIENCE = 5.0
"""Seconds that a request, or the next part of an upload, may take to come."""

MOST_SECONDS = 300.0
"""Seconds that a whole upload may take."""

LINGER = 15.0
"""Seconds that a desk is kept for a page that reloads, or whose connection broke."""

FULL = 4000
"""Close code of a socket for which there is no desk; its reason is a sentence for the user."""

TAKEN = 4001
"""Close code of a socket whose page has one already, as a tab that was duplicated: it takes a name of its own."""

MOST_CONNECTIONS = 96
"""Connections at a time, with or without a request on them; more are closed at once."""

MOST_UPLOADS = 2
"""Uploads that are taken at a time; others wait, unread."""

UNREAD = 30.0
"""Seconds after which a page that does not read what is sent to it counts as gone."""

_PAGE_ID = re.compile(r"[A-Za-z0-9-]{8,64}")


class _Impatient(H11Protocol):
    """HTTP on a connection that is closed where a request is begun and does not come, or where there are too many."""

    _timer: asyncio.TimerHandle | None = None
    _has_left = False
    """Whether the connection is no longer HTTP's: it was turned away, or became a WebSocket."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # as uvicorn has it
        """Wait for a request."""
        if len(self.connections) >= MOST_CONNECTIONS:
            self._has_left = True
            transport.abort()
            return
        super().connection_made(transport)
        self._wait()

    def data_received(self, data: bytes) -> None:
        """Take a part of a request; one that has come needs no timer."""
        if self._has_left:
            return
        try:
            super().data_received(data)
        except Exception:
            # Of what comes after an answer, h11 refuses some in its own way.
            self.transport.abort()
            return
        if self._is_busy():
            self._end_wait()
        elif self._timer is None:
            self._wait()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no more."""
        self._end_wait()
        if not self._has_left:
            super().connection_lost(exc)

    def handle_websocket_upgrade(self, event: Any) -> None:
        """Wait no more: the connection is a WebSocket's, if its handshake is one."""
        self._end_wait()
        self._has_left = True
        super().handle_websocket_upgrade(event)
        if not getattr(self.transport.get_protocol(), "handshake_initiated", True):
            # It is not to the taste of the library for WebSockets, which would wait for the rest of it for ever.
            self.transport.abort()

    def _is_busy(self) -> bool:
        # There is none before the first request.
        cycle: Any = self.cycle
        return self._has_left or (cycle is not None and not cycle.response_complete)

    def _wait(self) -> None:
        self._timer = self.loop.call_later(PATIENCE, self._give_up)

    def _end_wait(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _give_up(self) -> None:
        self._timer = None
        if not self._is_busy():
            self.transport.close()


class _Seat:
    """A page with its desk: what is to be sent to it, and whether it is there."""

    def __init__(self, studio: Studio) -> None:
        self._loop = asyncio.get_running_loop()
        self._outbox: deque[tuple[dict[str, Any], bytes | None]] = deque()
        self._filled = asyncio.Event()
        self.here = False
        self.leaving: asyncio.TimerHandle | None = None
        self.uploading = False
        self.desk = Desk(self._from_desk, studio.photo, studio.budget)

    def _from_desk(self, message: dict[str, Any], data: bytes | None) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self._put, message, data)

    def _put(self, message: dict[str, Any], data: bytes | None) -> None:
        if not self.here:
            # Whoever comes back is told everything anew.
            return
        if message["type"] in {"picture", "progress"}:
            # A slow page sees the latest.
            self._outbox = deque(item for item in self._outbox if item[0]["type"] != message["type"])
        self._outbox.append((message, data))
        self._filled.set()

    def sit(self) -> None:
        """Begin with a page that has just come."""
        self.here = True
        self._outbox.clear()
        if self.leaving is not None:
            self.leaving.cancel()
            self.leaving = None

    async def next(self) -> tuple[dict[str, Any], bytes | None]:
        """Return the next message to the page, when there is one."""
        while not self._outbox:
            self._filled.clear()
            await self._filled.wait()
        return self._outbox.popleft()


class Studio:
    """The application.

    Parameters
    ----------
    port : int
        The port that it is reached at.
    photo : tuple of str and bytes, optional
        The photo that every page begins with: its name, as the command line knows it, and its file.
    """

    def __init__(self, port: int, photo: tuple[str, bytes] | None) -> None:
        self.photo = photo
        self.budget = Budget(half_of_the_memory(), MOST_UPLOADED)
        self._seats: dict[str, _Seat] = {}
        self._uploads = asyncio.Semaphore(MOST_UPLOADS)
        self._files = {path.name: (path.read_bytes(), _mime(path)) for path in sorted(PAGE.iterdir()) if path.is_file()}
        routes = [
            Route("/", self._front),
            Route("/alive", self._alive),
            Route("/photo", self._upload, methods=["POST"]),
            Route("/importance", self._upload, methods=["POST"]),
            Route("/{name}", self._file),
            WebSocketRoute("/socket", self._socket),
        ]
        application = Starlette(routes=routes, lifespan=self._life)
        application.router.redirect_slashes = False
        self.guard = Guard(application, port)
        self.address = f"http://127.0.0.1:{port}/?token={self.guard.token}"

    @contextlib.asynccontextmanager
    async def _life(self, app: Starlette) -> AsyncIterator[None]:
        yield
        desks = [seat.desk for seat in self._seats.values()]
        for desk in desks:
            desk.close()
        for desk in desks:
            await asyncio.to_thread(desk.join, 2.0)

    async def _front(self, request: Request) -> Response:
        return self._response("index.html")

    async def _file(self, request: Request) -> Response:
        return self._response(request.path_params["name"])

    def _response(self, name: str) -> Response:
        # Names of a table, never of the file system.
        if name not in self._files:
            return Response("not found\n", status_code=404, media_type="text/plain")
        content, mime = self._files[name]
        return Response(content, media_type=mime)

    async def _alive(self, request: Request) -> Response:
        return Response(status_code=204)

    async def _upload(self, request: Request) -> Response:
        """Take a photo or a map; what comes of it is said on the socket."""
        page, name = request.query_params.get("page", ""), request.query_params.get("name", "")
        seat = self._seats.get(page)
        if seat is None or not seat.here:
            return _refused(404, "this page has no desk: reload it")
        if seat.uploading:
            return _refused(409, "this page sends another file already: wait until that has come")
        seat.uploading = True
        try:
            async with self._uploads:
                with anyio.fail_after(MOST_SECONDS):
                    body = await _body(request)
        except TimeoutError:
            return _refused(408, "the file came too slowly")
        except ClientDisconnect:
            return Response(status_code=400)
        finally:
            seat.uploading = False
        if body is None:
            return _refused(413, f"the file is too large: at most {MOST_UPLOADED >> 20} MiB are taken")
        kind = "open" if request.url.path == "/photo" else "importance"
        seat.desk.receive({"type": kind, "name": name}, body)
        return Response(status_code=202)

    async def _socket(self, websocket: WebSocket) -> None:
        page = websocket.query_params.get("page", "")
        if not _PAGE_ID.fullmatch(page):
            await websocket.close()
            return
        await websocket.accept()
        seat = self._seats.get(page)
        if seat is None and len(self._seats) >= MOST_PAGES:
            # One of those whose pages have gone makes room.
            gone = next((name for name, it in self._seats.items() if not it.here), None)
            if gone is None:
                await websocket.close(FULL, f"{MOST_PAGES} pages of the studio are open already: close one")
                return
            self._leave(gone)
        if seat is not None and seat.here:
            await websocket.close(TAKEN, "another tab has this page's name")
            return
        if seat is None:
            seat = self._seats[page] = _Seat(self)
        seat.sit()
        seat.desk.greet()
        tasks = {asyncio.create_task(_send_all(websocket, seat)), asyncio.create_task(_take_all(websocket, seat))}
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            seat.here = False
            if self._seats.get(page) is seat:
                seat.leaving = asyncio.get_running_loop().call_later(LINGER, self._leave, page)

    def _leave(self, page: str) -> None:
        """Forget a page that has gone."""
        seat = self._seats.pop(page)
        if seat.leaving is not None:
            seat.leaving.cancel()
        seat.desk.close()


async def _send_all(websocket: WebSocket, seat: _Seat) -> None:
    """Send what the desk says, until the page goes, or does not read it any more."""
    with contextlib.suppress(WebSocketDisconnect, RuntimeError, TimeoutError):  # it has gone already
        while True:
            message, data = await seat.next()
            text = json.dumps(message, separators=(",", ":"))
            with anyio.fail_after(UNREAD):
                if data is None:
                    await websocket.send_text(text)
                else:
                    header = text.encode("ascii")
                    await websocket.send_bytes(struct.pack("<I", len(header)) + header + data)


async def _take_all(websocket: WebSocket, seat: _Seat) -> None:
    """Hand the page's messages to its desk, until it goes."""
    while (received := await websocket.receive())["type"] != "websocket.disconnect":
        try:
            message = json.loads(received.get("text") or "")
        except (ValueError, RecursionError):
            message = None
        kind = message.get("type") if isinstance(message, dict) else None
        # Files come by uploads, which are counted.
        seat.desk.receive(None if kind in ("open", "importance", "hello") else message)


async def _body(request: Request) -> bytes | None:
    """Return the body of a request as far as it may be taken; None if it is larger.

    Raises
    ------
    TimeoutError
        If no part of it comes for long.
    """
    declared = request.headers.get("content-length", "0")
    if not declared.isascii() or not declared.isdecimal() or int(declared[:20]) > MOST_UPLOADED:
        return None
    parts: list[bytes] = []
    size = 0
    stream = request.stream().__aiter__()
    while True:
        try:
            with anyio.fail_after(PATIENCE):
                part = await stream.__anext__()
        except StopAsyncIteration:
            return b"".join(parts)
        size += len(part)
        if size > MOST_UPLOADED:
            return None
        parts.append(part)


def _refused(status: int, sentence: str) -> Response:
    # What of the body is still to come is not waited for.
    return JSONResponse({"sentence": sentence}, status_code=status, headers={"Connection": "close"})


def _mime(path: Path) -> str:
    known = {".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8", ".html": "text/html; charset=utf-8"}
    return known.get(path.suffix) or mimetypes.guess_type(path.name)[0] or "application/octet-stream"


def listen(port: int) -> socket.socket:
    """Return a socket that listens on this machine alone.

    Raises
    ------
    InvalidInputError
        If the port is taken, or not to be had.
    """
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    if os.name == "posix":
        # A port of a studio that has just ended; elsewhere this would share it with one that has not.
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind(("127.0.0.1", port))
        listener.listen()
    except OSError as error:
        listener.close()
        reason = error.strerror or str(error)
        raise InvalidInputError(f"port {port} cannot be had ({reason.lower()}): choose another, or --port 0 for any") from error
    return listener


class _Server(uvicorn.Server):
    """A server that leaves signals to whoever runs it."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Do nothing: uvicorn's own would raise them again when it has ended."""
        yield


def serve(studio: Studio, listener: socket.socket) -> uvicorn.Server:
    """Return a server for a studio, to be run."""
    config = uvicorn.Config(
        studio.guard,
        http=_Impatient,
        ws="websockets-sansio",
        ws_max_size=MOST_SAID,
        # Pictures are compressed already, and do not travel far.
        ws_per_message_deflate=False,
        lifespan="on",
        log_level="critical",
        log_config=None,
        access_log=False,
        # What another header says of where a request comes from is nothing to go by.
        proxy_headers=False,
        server_header=False,
        backlog=MOST_CONNECTIONS,
        workers=1,
        timeout_graceful_shutdown=3,
    )
    # What others do to a connection is nothing to print.
    logging.getLogger("asyncio").setLevel(logging.CRITICAL + 1)
    return _Server(config)
