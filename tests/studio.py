"""Starting the studio's server as a user does, and speaking to it as a browser would, or would not."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from tests.support import hears_ctrl_c

CONSOLE_SCRIPT = Path(sys.executable).with_name("graphstipple")

ADDRESS = re.compile(r"http://127\.0\.0\.1:(\d+)/\?token=([\w-]{40,})")


class Running(NamedTuple):
    """A server that runs."""

    process: subprocess.Popen[str]
    port: int
    token: str

    @property
    def address(self) -> str:
        """The address that it has printed."""
        return f"http://127.0.0.1:{self.port}/?token={self.token}"

    @property
    def host(self) -> str:
        """Its name and port."""
        return f"127.0.0.1:{self.port}"

    def end(self) -> int:
        """Stop it as Ctrl-C does, and return its exit code."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        return self.process.wait(60)


def start(*arguments: object, cwd: Path | None = None, port: int = 0, environment: dict[str, str] | None = None) -> Running:
    """Start a server, by default on any port and without a browser."""
    command = [CONSOLE_SCRIPT, "studio", *map(str, arguments), "--port", str(port), "--no-browser"]
    with hears_ctrl_c():
        process = subprocess.Popen(
            command,
            cwd=cwd,
            env={**os.environ, **(environment or {})},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
    assert process.stdout is not None
    line = process.stdout.readline()
    found = ADDRESS.search(line)
    assert found, line + process.communicate(timeout=60)[1]
    return Running(process, int(found[1]), found[2])


@contextlib.contextmanager
def running(*arguments: object, cwd: Path | None = None, port: int = 0) -> Iterator[Running]:
    """Start a server, and stop it in the end: cleanly, without a word."""
    server = start(*arguments, cwd=cwd, port=port)
    try:
        yield server
    finally:
        code = server.end()
        output, errors = server.process.communicate(timeout=60)
    assert (code, output, errors) == (0, "", "")


class Answer(NamedTuple):
    """What came back on a plain socket."""

    status: int
    headers: dict[str, str]
    body: bytes


def ask(
    server: Running,
    target: str = "/",
    *,
    method: str = "GET",
    headers: dict[str, str] | list[tuple[str, str]] | None = None,
    body: bytes = b"",
) -> Answer:
    """Send a request as it stands, with the server's own Host unless another is given, and return what comes back."""
    lines = list(headers.items()) if isinstance(headers, dict) else list(headers or [])
    names = {name.lower() for name, _ in lines}
    if "host" not in names:
        lines.insert(0, ("Host", server.host))
    if body and not names & {"content-length", "transfer-encoding"}:
        lines.append(("Content-Length", str(len(body))))
    head = "".join(f"{name}: {value}\r\n" for name, value in [*lines, ("Connection", "close")])
    with socket.create_connection(("127.0.0.1", server.port), timeout=60) as plain:
        plain.sendall(f"{method} {target} HTTP/1.1\r\n{head}\r\n".encode() + body)
        return answer(plain)


def answer(plain: socket.socket) -> Answer:
    """Return what comes on a socket until it is closed."""
    received = b""
    with contextlib.suppress(ConnectionResetError):
        while part := plain.recv(1 << 16):
            received += part
    head, _, body = received.partition(b"\r\n\r\n")
    first, *lines = head.decode("latin-1").split("\r\n")
    fields = dict(line.split(": ", 1) for line in lines)
    return Answer(int(first.split()[1]), {name.lower(): value for name, value in fields.items()}, body)


def cookie_of(server: Running) -> str:
    """Return the cookie that the token is exchanged for, as a browser sends it."""
    given = ask(server, f"/?token={server.token}")
    return given.headers["set-cookie"].split(";")[0]
