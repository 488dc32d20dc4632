"""The studio's server by plain sockets: who is let in, what is taken, what is said where it cannot begin, how it ends."""

from __future__ import annotations

import base64
import os
import socket
import stat
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from PIL import Image
from tests import commands, studio, support
from tests.studio import CONSOLE_SCRIPT, Running, answer, ask, cookie_of, running

PAGE = "page-of-a-test"


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    folder = tmp_path_factory.mktemp("studio")
    Image.fromarray(support.photo("astronaut", 96, 64)).save(folder / "photo.png")
    with running("photo.png", cwd=folder) as server:
        yield server


@pytest.fixture(scope="module")
def cookie(server: Running) -> str:
    return cookie_of(server)


def of_page(server: Running, cookie: str, **more: str) -> dict[str, str]:
    """Return the headers of the page's own requests."""
    return {"Cookie": cookie, "Origin": f"http://{server.host}", **more}


class Socket:
    """A WebSocket's handshake by hand, and its first messages."""

    def __init__(self, server: Running, headers: dict[str, str], page: str = PAGE) -> None:
        key = base64.b64encode(os.urandom(16)).decode()
        lines = {"Host": server.host, "Connection": "Upgrade", "Upgrade": "websocket"}
        lines |= {"Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": key, **headers}
        self.plain = socket.create_connection(("127.0.0.1", server.port), timeout=60)
        head = "".join(f"{name}: {value}\r\n" for name, value in lines.items())
        self.plain.sendall(f"GET /socket?page={page} HTTP/1.1\r\n{head}\r\n".encode())
        self._received = b""
        self.head = self._until(b"\r\n\r\n").decode("latin-1")
        self.status = int(self.head.split()[1])

    def _until(self, end: bytes) -> bytes:
        while end not in self._received:
            part = self.plain.recv(1 << 16)
            if not part:
                break
            self._received += part
        head, _, self._received = self._received.partition(end)
        return head

    def _take(self, size: int) -> bytes:
        while len(self._received) < size:
            part = self.plain.recv(1 << 16)
            if not part:
                raise EOFError
            self._received += part
        taken, self._received = self._received[:size], self._received[size:]
        return taken

    def message(self) -> tuple[int, bytes]:
        """Return the kind and the payload of the next frame: 1 text, 2 binary, 8 the end."""
        first, size = self._take(2)
        if size > 125:
            size = int.from_bytes(self._take(2 if size == 126 else 8), "big")
        return first & 15, self._take(size)

    def send(self, payload: bytes, kind: int = 1) -> None:
        """Send a frame, masked by nothing."""
        size = len(payload)
        if size < 126:
            length = bytes([0x80 | size])
        elif size <= 0xFFFF:
            length = b"\xfe" + size.to_bytes(2, "big")
        else:
            length = b"\xff" + size.to_bytes(8, "big")
        self.plain.sendall(bytes([0x80 | kind]) + length + bytes(4) + payload)

    def until(self, text: bytes) -> bytes:
        """Return the first message that has this in it."""
        while True:
            kind, payload = self.message()
            if kind == 8:
                raise EOFError
            if text in payload:
                return payload

    def ask(self, payload: bytes) -> bytes:
        """Send a text after which nothing comes but the end."""
        self.send(payload)
        return self.until(b"never")

    def close(self) -> None:
        self.plain.close()


def test_the_token_is_exchanged_for_a_cookie(server: Running) -> None:
    given = ask(server, f"/?token={server.token}")
    assert (given.status, given.headers["location"]) == (303, "/")
    assert server.token not in given.body.decode()
    name, *attributes = given.headers["set-cookie"].split("; ")
    assert name.startswith(f"graphstipple-studio-{server.port}=")
    assert server.token not in name
    assert {it.lower() for it in attributes} == {"httponly", "samesite=strict", "path=/"}
    page = ask(server, headers={"Cookie": name})
    assert page.status == 200
    assert b"<html" in page.body
    # A reload of the printed address does no harm; and a wrong token is wrong for whoever is in already.
    assert ask(server, f"/?token={server.token}", headers={"Cookie": name}).status == 303
    assert ask(server, "/?token=x", headers={"Cookie": name}).status == 403
    # A browser that comes from a file or another site would not send the cookie where it is redirected to.
    for site in ("cross-site", "same-site"):
        given = ask(server, f"/?token={server.token}", headers={"Sec-Fetch-Site": site})
        assert (given.status, "set-cookie" in given.headers) == (200, True)
        assert server.token not in given.body.decode()


def test_every_answer_has_the_headers_that_keep_others_out(server: Running, cookie: str) -> None:
    for answered in [
        ask(server, headers={"Cookie": cookie}),
        ask(server, "/studio.js", headers={"Cookie": cookie}),
        ask(server, "/nothing", headers={"Cookie": cookie}),
        ask(server),
        ask(server, f"/?token={server.token}"),
        ask(server, "/photo", method="POST", headers=of_page(server, cookie), body=b"x"),
    ]:
        assert answered.headers["content-security-policy"] == (
            "default-src 'self'; img-src 'self' blob: data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
        )
        assert answered.headers["x-content-type-options"] == "nosniff"
        assert answered.headers["referrer-policy"] == "no-referrer"
        assert answered.headers["cache-control"] == "no-store"
        assert "server" not in answered.headers
        assert "access-control-allow-origin" not in answered.headers


@pytest.mark.parametrize("path", ["/", "/index.html", "/studio.js", "/alive", "/nothing", "/enter.js"])
def test_without_the_cookie_nothing_is_shown(server: Running, path: str) -> None:
    for headers in [{}, {"Cookie": f"graphstipple-studio-{server.port}="}, {"Cookie": f"graphstipple-studio-{server.port}=é"}]:
        given = ask(server, path, headers=headers)
        assert given.status == 403
        assert "set-cookie" not in given.headers
    for token in ["", "x", server.token[:-1], server.token + "x", "%00", "%C3%A9"]:
        assert ask(server, f"{path}?token={token}").status == 403


def test_the_cookie_may_stand_among_others(server: Running, cookie: str) -> None:
    name = cookie.split("=", maxsplit=1)[0]
    assert ask(server, headers={"Cookie": f'other=1; {name}=wrong; {cookie}; quoted="a b"'}).status == 200
    assert ask(server, headers={"Cookie": f"x{cookie}"}).status == 403


def test_other_names_of_this_machine_are_refused(server: Running, cookie: str) -> None:
    port = server.port
    for host in ["evil.example", f"evil.example:{port}", "127.0.0.1", f"127.0.0.1:{port}.evil.example", f"0.0.0.0:{port}", ""]:
        assert ask(server, headers={"Cookie": cookie, "Host": host}).status == 403, host
        # The right token does not help.
        assert ask(server, f"/?token={server.token}", headers={"Host": host}).status == 403, host
    twice = [("Host", server.host), ("Host", "evil.example"), ("Cookie", cookie)]
    assert ask(server, headers=twice).status in {400, 403}
    assert ask(server, headers={"Cookie": cookie, "Host": f"LOCALHOST:{port}"}).status == 200
    # Whoever has it in the target, as proxies do, has to have it in the header too.
    assert ask(server, f"http://127.0.0.1:{port}/", headers={"Cookie": cookie, "Host": "evil.example"}).status == 403


def test_other_origins_are_refused(server: Running, cookie: str) -> None:
    ours = f"http://{server.host}"
    foreign = [
        "null",
        "https://evil.example",
        f"https://{server.host}",
        "http://127.0.0.1",
        f"{ours}0",
        f"http://localhost:{server.port}",
    ]
    for origin in foreign:
        # Wherever it is sent: on GET, too.
        assert ask(server, headers={"Cookie": cookie, "Origin": origin}).status == 403, origin
        post = ask(server, f"/photo?page={PAGE}", method="POST", headers={"Cookie": cookie, "Origin": origin}, body=b"x")
        assert post.status == 403, origin
        with socket_of(server, {"Cookie": cookie, "Origin": origin}) as plain:
            assert plain.status == 403, origin
    for method in ("POST", "PUT", "DELETE", "OPTIONS", "PATCH"):
        assert ask(server, "/photo", method=method, headers={"Cookie": cookie}, body=b"x").status == 403, method
    assert ask(server, headers={"Cookie": cookie, "Origin": ours}).status == 200
    twice = [("Cookie", cookie), ("Origin", ours), ("Origin", "https://evil.example")]
    assert ask(server, headers=twice).status == 403


class socket_of:  # noqa: N801  # it is used as a function
    """A WebSocket that is closed in the end."""

    def __init__(self, server: Running, headers: dict[str, str], page: str = PAGE) -> None:
        self.socket = Socket(server, headers, page)

    def __enter__(self) -> Socket:
        return self.socket

    def __exit__(self, *_: object) -> None:
        self.socket.close()


def test_the_socket_needs_cookie_and_origin(server: Running, cookie: str) -> None:
    ours = f"http://{server.host}"
    for headers in [{}, {"Cookie": cookie}, {"Origin": ours}, {"Origin": ours, "Cookie": cookie, "Host": "evil.example"}]:
        with socket_of(server, headers) as plain:
            assert plain.status == 403, headers
            assert "websocket-accept" not in plain.head.lower()
    for page in ["", "short", "a" * 65, "../../../../x", "a%20b%20c%20d"]:
        with socket_of(server, of_page(server, cookie), page) as plain:
            assert plain.status == 403, page
    with socket_of(server, of_page(server, cookie)) as plain:
        assert plain.status == 101
        assert b'"ready"' in plain.message()[1]


def test_what_is_said_on_the_socket_is_taken_or_refused(server: Running, cookie: str) -> None:
    with socket_of(server, of_page(server, cookie)) as plain:
        plain.until(b'"type":"photo"')
        for nonsense in [b"{", b"[]", b"null", b'"draw"', b"[" * 100_000, b'{"type":"open","name":"/etc/passwd"}', b'{"type":5}']:
            plain.send(nonsense)
            assert b"refused" in plain.until(b'"of":')
        plain.send(b"\x00\x01\x02", kind=2)
        assert b"refused" in plain.until(b'"of":')
        # A path is no importance.
        plain.send(b'{"type":"draw","id":1,"look":{"importance":"photo.png"}}')
        assert b"importance is 'photo.png', but it must be" in plain.until(b'"of":')
        plain.send(b'{"type":"draw","id":2,"look":{"options":{"nodes":1000000000}}}')
        assert b"of memory" in plain.until(b'"of":')
        plain.send(b'{"type":"draw","id":3,"look":{"options":{"nodes":500}}}')
        plain.until(b'"drawn"')
        # Too much at once ends the socket, and nothing else.
        with pytest.raises((EOFError, OSError)):
            plain.ask(b'{"type":"' + b"x" * (2 << 20) + b'"}')
    assert ask(server, headers={"Cookie": cookie}).status == 200


def test_uploads_are_counted_as_they_come(server: Running, cookie: str) -> None:
    headers = of_page(server, cookie)
    target = f"/photo?page={PAGE}&name=notes.txt"
    with socket_of(server, headers) as plain:
        plain.until(b'"type":"photo"')
        for length in ["268435457", "9" * 18]:
            declared = ask(server, target, method="POST", headers={**headers, "Content-Length": length}, body=b"x")
            assert declared.status == 413, length
            assert b"at most 256 MiB are taken" in declared.body
        # Without a length; the client may not come to read the answer when it goes on sending.
        chunk = b"%x\r\n" % (1 << 20) + bytes(1 << 20) + b"\r\n"
        with socket.create_connection(("127.0.0.1", server.port), timeout=60) as sending:
            head = "".join(f"{name}: {value}\r\n" for name, value in {"Host": server.host, **headers}.items())
            sending.sendall(f"POST {target} HTTP/1.1\r\n{head}Transfer-Encoding: chunked\r\n\r\n".encode())
            for _ in range(257):
                sending.sendall(chunk)
            assert answer(sending).status == 413
        # What is no image comes to the reader's sentence on the page.
        taken = ask(server, target, method="POST", headers=headers, body=b"these are notes")
        assert (taken.status, taken.body) == (202, b"")
        assert b"notes.txt: " in plain.until(b'"refused"')
    assert ask(server, "/photo?page=nobody-is-here", method="POST", headers=headers, body=b"x").status == 404
    assert ask(server, "/photo", headers={"Cookie": cookie}).status == 404


def test_no_path_leads_to_a_file(server: Running, cookie: str) -> None:
    for path in [
        "/../desk.py",
        "/%2e%2e/desk.py",
        "/..%2fdesk.py",
        "/photo.png",
        "//etc/passwd",
        "/%00",
        "/example.jpg%00.js",
        "/page/",
    ]:
        found = ask(server, path, headers={"Cookie": cookie})
        assert found.status in {404, 405}, path
        assert b"import" not in found.body


def test_pages_are_limited_and_forgotten(server: Running, cookie: str) -> None:
    headers = of_page(server, cookie)
    sockets = [Socket(server, headers, f"page-number-{i}") for i in range(8)]
    for plain in sockets:
        assert b'"ready"' in plain.message()[1]
    with socket_of(server, headers, "page-number-8") as plain:
        kind, reason = plain.message()
        assert (kind, int.from_bytes(reason[:2], "big")) == (8, 4000)
        assert reason[2:] == b"8 pages of the studio are open already: close one"
    # The name of a page that is there belongs to it.
    with socket_of(server, headers, "page-number-0") as plain:
        kind, reason = plain.message()
        assert (kind, int.from_bytes(reason[:2], "big")) == (8, 4001)
    # A page that comes back in time finds its desk; one that has gone makes room.
    sockets[0].close()
    support.wait_until(lambda: begins(server, headers, "page-number-0") == b'"fresh":false')
    sockets[1].close()
    support.wait_until(lambda: begins(server, headers, "page-number-9") == b'"fresh":true')
    for plain in sockets[2:]:
        plain.close()


def begins(server: Running, headers: dict[str, str], page: str) -> bytes | None:
    """Return whether a page's desk is a fresh one, as it is told; None if it gets none."""
    with socket_of(server, headers, page) as plain:
        _, payload = plain.message()
        return next((text for text in (b'"fresh":false', b'"fresh":true') if text in payload), None)


def test_whoever_is_slow_holds_nobody_up(server: Running, cookie: str, monkeypatch: pytest.MonkeyPatch) -> None:
    headers = of_page(server, cookie)
    with socket_of(server, headers) as page:
        page.until(b'"type":"photo"')
        head = "".join(f"{name}: {value}\r\n" for name, value in {"Host": server.host, **headers}.items())
        slow = []
        for begin in [
            "GET / HT",
            f"GET / HTTP/1.1\r\n{head}X: ",
            f"POST /photo?page={PAGE} HTTP/1.1\r\n{head}Content-Length: 9\r\n\r\nab",
        ]:
            slow.append(socket.create_connection(("127.0.0.1", server.port), timeout=60))
            slow[-1].sendall(begin.encode())
        assert ask(server, headers={"Cookie": cookie}).status == 200
        page.send(b'{"type":"draw","id":3,"look":{"options":{"nodes":500}}}')
        page.until(b'"drawn"')
        # The first two are closed without a word, the upload with one.
        assert [plain.recv(1) for plain in slow[:2]] == [b"", b""]
        late = answer(slow[2])
        assert (late.status, late.body) == (408, b'{"sentence":"the file came too slowly"}')
        for plain in slow:
            plain.close()


def test_it_listens_on_this_machine_alone(server: Running) -> None:
    table = Path("/proc/net/tcp")
    if not table.exists():
        pytest.skip("it looks into /proc")
    lines = [line.split() for line in table.read_text().splitlines()[1:]]
    listening = [fields[1] for fields in lines if fields[3] == "0A" and fields[1].endswith(f":{server.port:04X}")]
    assert listening == [f"0100007F:{server.port:04X}"]
    arguments = Path(f"/proc/{server.process.pid}/cmdline").read_bytes()
    assert server.token.encode() not in arguments


def test_a_port_in_use(server: Running) -> None:
    result = commands.run(CONSOLE_SCRIPT, "studio", "--port", server.port, "--no-browser")
    commands.assert_one_sentence(result, commands.FAILURE)
    assert (
        f"port {server.port} cannot be had (address already in use): choose another, or --port 0 for any" in result.stderr.decode()
    )


@pytest.mark.parametrize(
    ("arguments", "code", "sentence"),
    [
        (["no.jpg"], 1, "no.jpg: the file does not exist"),
        (["notes.txt"], 1, "notes.txt: "),
        (["."], 1, ".: "),
        (["--port", "65536"], 2, "it is 65536, but it must be a whole number between 0 and 65535"),
        (["--port", "-1"], 2, "--port"),
        (["--port", "x"], 2, "it is x, but it must be a whole number"),
        (["a.png", "b.png"], 2, "unrecognized arguments: b.png"),
        (["--nonsense"], 2, "unrecognized arguments: --nonsense"),
    ],
)
def test_what_cannot_begin(arguments: list[str], code: int, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("notes")
    result = commands.run(CONSOLE_SCRIPT, "studio", *arguments, "--no-browser", cwd=tmp_path)
    commands.assert_one_sentence(result, code)
    assert result.stderr.decode().startswith("graphstipple: error: ")
    assert sentence in result.stderr.decode()


def test_without_its_packages_it_says_what_to_install(tmp_path: Path) -> None:
    (tmp_path / "uvicorn.py").write_text("raise ImportError('No module named uvicorn', name='uvicorn')")
    (tmp_path / "anywidget.py").write_text("raise ImportError('No module named anywidget', name='anywidget')")
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    command = [CONSOLE_SCRIPT, "studio", "--no-browser"]
    result = subprocess.run(command, env=environment, capture_output=True, timeout=60, check=False)
    commands.assert_one_sentence(result, commands.FAILURE)
    assert b"(No module named uvicorn): pip install graphstipple[studio]" in result.stderr
    code = "import graphstipple as gs\nfrom graphstipple import *\n"
    code += "try: gs.Studio()\nexcept gs.MissingPackageError as error: print(error)"
    result = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, timeout=60, check=True)
    assert b"pip install graphstipple[studio]" in result.stdout


def test_the_native_binary_says_where_the_studio_is() -> None:
    result = commands.run(commands.native_binary(), "studio", "photo.jpg")
    commands.assert_one_sentence(result, commands.USAGE)
    assert b"pip install graphstipple[studio]" in result.stderr


@support.linux
def test_the_browser_is_opened_by_a_file_that_only_the_user_can_read(tmp_path: Path) -> None:
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\nprintf "%s" "$1" > {tmp_path}/part && mv {tmp_path}/part {tmp_path}/opened\n')
    browser.chmod(0o700)
    command = [CONSOLE_SCRIPT, "studio", "--port", "0"]
    environment = {**os.environ, "BROWSER": str(browser), "TMPDIR": str(tmp_path)}
    with support.hears_ctrl_c():
        process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    found = studio.ADDRESS.search(process.stdout.readline())
    assert found
    support.wait_until((tmp_path / "opened").exists)
    opened = (tmp_path / "opened").read_text()
    assert opened.startswith("file://")
    assert found[2] not in opened
    page = Path(opened.removeprefix("file://"))
    assert stat.S_IMODE(page.stat().st_mode) == 0o600
    assert stat.S_IMODE(page.parent.stat().st_mode) == 0o700
    assert f"url=http://127.0.0.1:{found[1]}/?token={found[2]}" in page.read_text()
    assert Running(process, int(found[1]), found[2]).end() == 0
    assert process.communicate()[1] == ""
    assert not page.exists()


@pytest.mark.parametrize("named", [None, "/nonexistent/browser"])
def test_without_a_browser_it_says_so_and_goes_on(named: str | None) -> None:
    environment = {name: value for name, value in os.environ.items() if name not in {"DISPLAY", "WAYLAND_DISPLAY", "BROWSER"}}
    if named is not None:
        environment["BROWSER"] = named
        environment["PATH"] = ""
    command = [CONSOLE_SCRIPT, "studio", "--port", "0"]
    with support.hears_ctrl_c():
        process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stderr is not None
    found = studio.ADDRESS.search(process.stdout.readline())
    assert found
    told = process.stderr.readline()
    assert told.startswith("graphstipple: warning: there is no display" if named is None else "graphstipple: warning: no browser")
    server = Running(process, int(found[1]), found[2])
    assert ask(server, headers={"Cookie": cookie_of(server)}).status == 200
    assert server.end() == 0
    process.communicate()


def test_ctrl_c_ends_it_while_it_draws(tmp_path: Path) -> None:
    Image.fromarray(support.photo("astronaut")).save(tmp_path / "photo.png")
    with running("photo.png", cwd=tmp_path) as server:
        page = Socket(server, of_page(server, cookie_of(server)))
        page.until(b'"type":"photo"')
        page.send(b'{"type":"draw","id":3,"look":{"options":{"nodes":2000000}}}')
        page.until(b'"progress"')
    page.close()


def test_handshakes_that_are_none_end_at_once(server: Running, cookie: str) -> None:
    upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "x" * 24}
    head = "".join(f"{name}: {value}\r\n" for name, value in {"Host": server.host, **upgrade}.items())
    many = "".join(f"X-{i}: 1\r\n" for i in range(140))
    for target, more in [
        ("/" + "a" * 9000, ""),
        ("/socket", many),
        ("/socket", "Content-Length: 5\r\n"),
        ("/socket", "X: " + "a" * 9000 + "\r\n"),
    ]:
        with socket.create_connection(("127.0.0.1", server.port), timeout=60) as plain:
            plain.sendall(f"GET {target} HTTP/1.1\r\n{head}{more}\r\n".encode())
            try:
                received = plain.recv(1 << 16)
            except ConnectionResetError:
                received = b""
            # Refused, or closed without a word; nobody waits.
            assert not received or received.split()[1] in {b"400", b"403"}, target[:20]
    assert ask(server, headers={"Cookie": cookie}).status == 200


def test_connections_are_limited(cookie: str, server: Running) -> None:
    idle = [socket.create_connection(("127.0.0.1", server.port), timeout=60) for _ in range(150)]
    # Those that are too many are closed at once; the others wait for their time.
    closed = 0
    for plain in idle[100:]:
        try:
            closed += plain.recv(1) == b""
        except ConnectionResetError:
            closed += 1
    assert closed == 50
    for plain in idle:
        plain.close()
    support.wait_until(lambda: is_let_in(server, cookie))


def is_let_in(server: Running, cookie: str) -> bool:
    try:
        return ask(server, headers={"Cookie": cookie}).status == 200
    except (OSError, IndexError):
        return False


def test_it_begins_with_a_photo_that_can_be_read_once(tmp_path: Path) -> None:
    if not hasattr(os, "mkfifo"):
        pytest.skip("no pipes with names here")
    Image.fromarray(support.photo("astronaut", 96, 64)).save(tmp_path / "photo.png")
    os.mkfifo(tmp_path / "pipe")
    with (
        subprocess.Popen(["sh", "-c", "cat photo.png > pipe"], cwd=tmp_path),
        running("pipe", cwd=tmp_path) as server,
        socket_of(server, of_page(server, cookie_of(server))) as plain,
    ):
        assert b'"width":96' in plain.until(b'"type":"photo"')


@support.linux
def test_what_cannot_be_told_is_one_sentence(tmp_path: Path) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("there is no /dev/full")
    with Path("/dev/full").open("wb") as full:
        command = [CONSOLE_SCRIPT, "studio", "--port", "0", "--no-browser"]
        result = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, timeout=60, check=False)
    assert (result.returncode, result.stderr.count(b"\n")) == (1, 1), result.stderr
    assert b"the address cannot be printed (no space left on device)" in result.stderr
