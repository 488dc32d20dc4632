"""Who is let in: every request passes here before anything else looks at it. SECURITY.md says against whom, and what is left.

In: a request as it came. Out: the same request to the application, or a refusal: 403, without a word on what would have been right.
"""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Iterable
from urllib.parse import parse_qs

from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import HTMLResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket

HEADERS = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' blob: data:; frame-ancestors 'none'; base-uri 'none'; "
    "form-action 'none'",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""Headers of every response."""

TOKEN = "token"
"""The parameter of the address that is printed."""

ENTER = "/enter.js"
"""The script that goes on from a page of another site, by which a strict cookie would not be sent."""

_GOING_ON = f'<!doctype html><meta charset="utf-8"><title>graphstipple</title><script src="{ENTER}"></script>\n'

NOT_LET_IN = "This page opens by the address that graphstipple studio prints when it starts."


class Guard:
    """ASGI middleware that lets in who has the token, from the pages of this server alone.

    Parameters
    ----------
    app : ASGI application
        What is guarded.
    port : int
        The port that the server listens on: part of its name, of its origin, and of the cookie's name, since browsers send cookies
        to every port of a host.
    """

    def __init__(self, app: ASGIApp, port: int) -> None:
        self.app = app
        self.token = secrets.token_urlsafe(32)
        self.hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}
        if port == 80:
            # Browsers leave out the port that http has anyway.
            self.hosts |= {"127.0.0.1", "localhost"}
        self.cookie = f"graphstipple-studio-{port}"
        self._session = secrets.token_urlsafe(32)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(HEADERS)
            await send(message)

        connection = HTTPConnection(scope)
        if self._is_from_here(connection, scope) and self._has_cookie(connection):
            await self.app(scope, receive, send_with_headers)
        elif scope["type"] == "websocket":
            # Before it is accepted: the handshake is answered with 403.
            await WebSocket(scope, receive, send).close()
        else:
            await self._answer(connection, scope)(scope, receive, send_with_headers)

    def _answer(self, connection: HTTPConnection, scope: Scope) -> Response:
        """Return the cookie for the token, or a refusal."""
        from_elsewhere = connection.headers.get("sec-fetch-site", "none") in {"cross-site", "same-site"}
        given = parse_qs(scope["query_string"].decode("latin-1")).get(TOKEN, [""])
        is_front = scope["path"] == "/" and scope["method"] == "GET" and self._is_from_here(connection, scope)
        if is_front and _is_one_of(given, self.token):
            # A browser that comes from another site, or from a file, would not send the cookie along where it is redirected to.
            response: Response = HTMLResponse(_GOING_ON) if from_elsewhere else RedirectResponse("/", status_code=303)
            response.set_cookie(self.cookie, self._session, httponly=True, samesite="strict", path="/")
            return response
        response = HTMLResponse(_refusal(script=is_front and from_elsewhere and given == [""]), status_code=403)
        # A body that is still to come is not waited for.
        response.headers["Connection"] = "close"
        return response

    def _is_from_here(self, connection: HTTPConnection, scope: Scope) -> bool:
        """Whether a request names this server, and comes from one of its pages where it says, or has to say, where from."""
        hosts, origins = connection.headers.getlist("host"), connection.headers.getlist("origin")
        if len(hosts) != 1 or hosts[0].lower() not in self.hosts:
            return False
        has_to_say = scope["type"] == "websocket" or scope["method"] not in {"GET", "HEAD"}
        if not origins:
            return not has_to_say
        return origins == [f"http://{hosts[0].lower()}"]

    def _has_cookie(self, connection: HTTPConnection) -> bool:
        """Whether the cookie is there. A path that sets the cookie anew is not needed then, but its token must not stay there."""
        if connection.scope["path"] == "/" and TOKEN in parse_qs(connection.scope["query_string"].decode("latin-1")):
            return False
        # Each of several cookies of the name: those of other pages on this host may stand before ours.
        pairs = (pair.strip().partition("=") for header in connection.headers.getlist("cookie") for pair in header.split(";"))
        return _is_one_of((value for name, _, value in pairs if name == self.cookie), self._session)


def _refusal(*, script: bool) -> str:
    """Return a page that says that nobody is let in; with a script for those who come from another site with a cookie."""
    head = f'<!doctype html><html lang="en"><meta charset="utf-8"><title>graphstipple</title><p>{NOT_LET_IN}</p>'
    return head + (f'<script src="{ENTER}"></script>\n' if script else "\n")


def _is_one_of(given: Iterable[str], secret: str) -> bool:
    """Whether one of them is the secret, in a time that says nothing of how near it comes."""
    found = False
    for text in given:
        found |= hmac.compare_digest(text.encode("utf-8", "surrogateescape"), secret.encode())
    return found
