"""Where drawings are written to: files that are kept, links, devices and pipes, and what signals leave behind."""

from __future__ import annotations

import io
import os
import signal
import stat
import subprocess
import sys
import sysconfig
import threading
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from tests.commands import FAILURE, USAGE, assert_one_sentence, done, native_binary, run
from tests.support import linux, photo, wait_until, waits

import graphstipple as gs

CONSOLE_SCRIPT = Path(sysconfig.get_path("scripts")) / "graphstipple"

posix = pytest.mark.skipif(os.name != "posix", reason="links, devices, pipes and signals are POSIX's")


@pytest.fixture(scope="module", params=["native", "console script"])
def program(request: pytest.FixtureRequest) -> Path:
    """Each way in."""
    return native_binary() if request.param == "native" else CONSOLE_SCRIPT


@pytest.fixture(scope="module")
def drawing() -> gs.Drawing:
    return gs.draw(photo("astronaut", 96, 64))


@pytest.fixture
def desk(tmp_path: Path) -> Path:
    """A folder with a small photo in it."""
    Image.fromarray(photo("coffee", 90, 60)).save(tmp_path / "photo.png")
    return tmp_path


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


# What is there ----------------------------------------------------------------------------------------------------------------


@posix
def test_a_file_keeps_its_permissions_and_links_stay(drawing: gs.Drawing, tmp_path: Path) -> None:
    file, link, twin = tmp_path / "a.svg", tmp_path / "link.svg", tmp_path / "twin.svg"
    file.write_text("before")
    file.chmod(0o640)
    link.symlink_to("a.svg")
    os.link(file, twin)
    drawing.save(link)
    assert link.is_symlink()
    assert (file.read_text(), mode(file)) == (drawing.svg(), 0o640)
    # A new file took the place of the old one, which has another name still.
    assert twin.read_text() == "before"


@posix
@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root gives files away")
def test_a_file_keeps_its_owner(drawing: gs.Drawing, tmp_path: Path) -> None:
    file = tmp_path / "a.svg"
    file.write_text("")
    os.chown(file, 1234, 5678)
    file.chmod(0o604)
    drawing.save(file)
    assert (file.stat().st_uid, file.stat().st_gid, mode(file)) == (1234, 5678, 0o604)


def test_a_read_only_file_is_overwritten_by_force_alone(program: Path, desk: Path, drawing: gs.Drawing) -> None:
    for name in ("a.svg", "b.png"):
        (desk / name).write_text("before")
        (desk / name).chmod(0o444)
    for arguments in (["-o", "a.svg"], ["-o", "c.svg", "--preview", "b.png"]):
        result = run(program, "photo.png", *arguments, cwd=desk)
        assert_one_sentence(result, FAILURE)
        name = "a.svg" if arguments[-1] == "a.svg" else "b.png"
        assert result.stderr.decode() == f"graphstipple: error: {name}: the file is read-only: --force overwrites it\n"
    # Before the work begins: this photo cannot even be read.
    (desk / "none.png").write_bytes(b"")
    assert b"read-only" in run(program, "none.png", "-o", "a.svg", cwd=desk).stderr
    with pytest.raises(gs.ImageFileError, match=r"a\.svg: the file is read-only: force=True overwrites it"):
        drawing.save(desk / "a.svg")
    assert (desk / "a.svg").read_text() == "before"
    if os.name == "posix":
        drawing.save(desk / "a.svg", force=True)
        assert ((desk / "a.svg").read_text(), mode(desk / "a.svg")) == (drawing.svg(), 0o444)
        done(program, "photo.png", "-o", "a.svg", "--preview", "b.png", "--force", cwd=desk)
        assert (desk / "a.svg").read_text() != drawing.svg()
        assert mode(desk / "b.png") == 0o444
    assert names(desk) == ["a.svg", "b.png", "none.png", "photo.png"]


@posix
def test_a_device_is_written_to(program: Path, desk: Path, drawing: gs.Drawing) -> None:
    for name in ("null.svg", "null.png"):
        (desk / name).symlink_to("/dev/null")
    done(program, "photo.png", "-o", "null.svg", "--preview", "null.png", cwd=desk)
    drawing.save(desk / "null.png")
    assert Path("/dev/null").is_char_device()
    assert all((desk / name).is_symlink() for name in ("null.svg", "null.png"))
    assert names(desk) == ["null.png", "null.svg", "photo.png"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no device that is always full")
def test_a_device_that_takes_nothing_is_one_sentence(program: Path, desk: Path, drawing: gs.Drawing) -> None:
    (desk / "full.svg").symlink_to("/dev/full")
    result = run(program, "photo.png", "-o", "full.svg", "--preview", "a.png", cwd=desk)
    assert_one_sentence(result, FAILURE)
    assert b"no space left" in result.stderr
    with pytest.raises(gs.ImageFileError, match="no space left"):
        drawing.save(desk / "full.svg")
    # The preview, which was complete, is not there either.
    assert names(desk) == ["full.svg", "photo.png"]


@posix
def test_a_pipe_is_written_to(program: Path, desk: Path, drawing: gs.Drawing) -> None:
    pipe = desk / "pipe.png"
    os.mkfifo(pipe)
    read: list[bytes] = []
    for write in (
        lambda: done(program, "photo.png", "-o", "a.png", "--preview", "pipe.png", cwd=desk),
        lambda: drawing.save(pipe, width=2000),
    ):
        reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()))
        reader.start()
        write()
        reader.join(60)
    assert read[0] == (desk / "a.png").read_bytes()
    assert read[1] == drawing._core.encode("png", {"width": 2000})
    assert stat.S_ISFIFO(pipe.stat().st_mode)


@posix
@pytest.mark.skipif(not Path("/dev/fd").exists(), reason="descriptors have no names here")
def test_what_standard_output_leads_to_is_not_replaced(program: Path, desk: Path) -> None:
    (desk / "out.svg").symlink_to("/dev/stdout")
    with (desk / "log").open("w") as log:
        log.write("before\n")
        log.flush()
        subprocess.run([program, "photo.png", "-o", "out.svg"], cwd=desk, stdout=log, check=True, timeout=60)
    before, _, svg = (desk / "log").read_text().partition("\n")
    assert (before, svg) == ("before", gs.draw(desk / "photo.png").svg())
    piped = subprocess.run([program, "photo.png", "-o", "out.svg"], cwd=desk, capture_output=True, check=True, timeout=60)
    assert piped.stdout.decode() == svg


@posix
def test_a_dangling_link_makes_its_target(drawing: gs.Drawing, tmp_path: Path) -> None:
    (tmp_path / "link.svg").symlink_to("later.svg")
    drawing.save(tmp_path / "link.svg")
    assert (tmp_path / "link.svg").is_symlink()
    assert (tmp_path / "later.svg").read_text() == drawing.svg()


@pytest.mark.parametrize(
    ("output", "preview"),
    [
        ("a.png", "a.png"),
        ("a.png", "./a.png"),
        ("sub/../a.png", "a.png"),
        ("a.png", "link.png"),
        ("link.png", "dangling.png"),
        ("old.png", "./old.png"),
        ("old.png", "twin.png"),
        ("here/a.png", "a.png"),
    ],
)
@posix
def test_two_outputs_are_two_files(program: Path, desk: Path, output: str, preview: str) -> None:
    (desk / "sub").mkdir()
    (desk / "here").symlink_to(".")
    (desk / "link.png").symlink_to("a.png")
    (desk / "dangling.png").symlink_to("sub/../a.png")
    (desk / "old.png").write_text("before")
    os.link(desk / "old.png", desk / "twin.png")
    before = names(desk)
    result = run(program, "photo.png", "-o", output, "--preview", preview, cwd=desk)
    assert_one_sentence(result, USAGE)
    assert b"the preview must be another file than the output" in result.stderr
    assert names(desk) == before
    assert (desk / "old.png").read_text() == "before"


# Signals ----------------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def noise() -> bytes:
    """Return a photo, larger than a pipe holds at once."""
    file = io.BytesIO()
    Image.fromarray(np.random.default_rng(2).integers(0, 256, (400, 480), np.uint8)).save(file, "PNG")
    assert len(file.getvalue()) > 2 * PIPE
    return file.getvalue()


PIPE = 2**16
"""Bytes that a pipe holds. Who has written more than these knows that the other end has begun to read, and listens to signals."""

signals = pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT], ids=lambda number: number.name)


def start(program: Path, folder: Path, *arguments: str) -> subprocess.Popen[bytes]:
    """Start a program that reads its photo from a pipe, and listens to all signals."""
    # What is ignored here, as under nohup, would be ignored there.
    before = {number: signal.signal(number, signal.SIG_DFL) for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT)}
    try:
        pipe = subprocess.PIPE
        return subprocess.Popen([program, "-", *arguments], cwd=folder, stdin=pipe, stdout=pipe, stderr=pipe)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def give(process: subprocess.Popen[bytes], photo_file: bytes) -> None:
    """Write all of a photo to a program, and close the pipe."""
    process.stdin.write(photo_file)
    process.stdin.close()
    process.stdin = None


def ended(process: subprocess.Popen[bytes]) -> int:
    """Return how a process ended, after it said nothing of how it is made."""
    printed = process.communicate(timeout=120)
    assert b"Traceback" not in b"".join(printed)
    return process.returncode


@posix
@signals
def test_a_signal_while_the_photo_comes_in_leaves_nothing(
    program: Path, noise: bytes, tmp_path: Path, number: signal.Signals
) -> None:
    process = start(program, tmp_path, "-o", "a.png")
    process.stdin.write(noise[: PIPE + 1])
    process.stdin.flush()
    process.send_signal(number)
    assert ended(process) == 128 + number
    assert names(tmp_path) == []


@posix
@signals
def test_a_signal_at_work_leaves_all_or_nothing(program: Path, noise: bytes, tmp_path: Path, number: signal.Signals) -> None:
    process = start(program, tmp_path, "-o", "a.png", "--width", "3000px", "--preview", "b.png")
    give(process, noise)
    process.send_signal(number)
    code = ended(process)
    assert (code, names(tmp_path)) in [(128 + number, []), (0, ["a.png", "b.png"])]


@posix
@signals
def test_a_signal_while_files_are_written_leaves_all_or_nothing(
    program: Path, noise: bytes, tmp_path: Path, number: signal.Signals
) -> None:
    os.mkfifo(tmp_path / "pipe.png")
    process = start(program, tmp_path, "-o", "pipe.png", "--width", "3000px", "--preview", "b.png")
    give(process, noise)
    with (tmp_path / "pipe.png").open("rb") as pipe:
        assert pipe.read(8) == b"\x89PNG\r\n\x1a\n"
        process.send_signal(number)
        assert process.wait(120) == 128 + number
    assert ended(process) == 128 + number
    assert names(tmp_path) == ["pipe.png"]


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a process that is killed leaves what it was writing")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL], ids=lambda number: number.name)
@pytest.mark.parametrize("lines", [1, 100, 3000])
def test_a_process_that_is_killed_leaves_nothing_behind(tmp_path: Path, number: signal.Signals, lines: int) -> None:
    # Nobody listens here: what is not complete has no name. Lines are printed while it is being written.
    program = """
import threading, numpy as np, graphstipple as gs
drawing = gs.draw(np.random.default_rng(2).integers(0, 256, (160, 200), np.uint8))
drawing.save("a.png", width=5000)
def tell():
    while True:
        print("now", flush=True)
threading.Thread(target=tell, daemon=True).start()
while True:
    drawing.save("a.png", width=5000)
"""
    with subprocess.Popen([sys.executable, "-c", program], cwd=tmp_path, stdout=subprocess.PIPE, text=True) as process:
        assert [process.stdout.readline() for _ in range(lines)] == ["now\n"] * lines
        process.send_signal(number)
        assert process.wait(60) == -number
    assert names(tmp_path) == ["a.png"]
    with Image.open(tmp_path / "a.png") as image:
        image.load()


@posix
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP], ids=lambda number: number.name)
def test_what_is_ignored_stays_ignored(program: Path, noise: bytes, tmp_path: Path, number: signal.Signals) -> None:
    process = subprocess.Popen(
        [program, "-", "-o", "a.png", "--width", "1000px"],
        cwd=tmp_path,
        stdin=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(number, signal.SIG_IGN),  # type: ignore[misc]  # noqa: PLW1509
    )
    process.stdin.write(noise[: PIPE + 1])
    process.stdin.flush()
    process.send_signal(number)
    process.stdin.write(noise[PIPE + 1 :])
    process.stdin.close()
    process.send_signal(number)
    assert process.wait(120) == 0
    assert names(tmp_path) == ["a.png"]


@linux
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT], ids=lambda number: number.name)
@pytest.mark.parametrize("output", ["pipe.svg", "-"])
def test_waiting_for_a_reader_can_be_interrupted(
    program: Path, noise: bytes, tmp_path: Path, number: signal.Signals, output: str
) -> None:
    # Nobody reads, neither the pipe nor standard output, which takes some of it.
    os.mkfifo(tmp_path / "pipe.svg")
    process = start(program, tmp_path, "-o", output, *(["--preview", "b.png"] if output != "-" else []))
    give(process, noise)
    wait_until(lambda: waits(process))
    process.send_signal(number)
    assert process.wait(120) == 128 + number
    assert ended(process) == 128 + number
    assert names(tmp_path) == ["pipe.svg"]


@linux
def test_saving_to_a_pipe_can_be_interrupted_in_python(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.svg")
    program = """
import signal, numpy as np, graphstipple as gs
signal.signal(signal.SIGINT, signal.default_int_handler)
drawing = gs.draw(np.zeros((8, 8), np.uint8))
try:
    print("now", flush=True)
    drawing.save("pipe.svg")
except KeyboardInterrupt:
    print("interrupted")
"""
    with subprocess.Popen([sys.executable, "-c", program], cwd=tmp_path, stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"now\n"
        wait_until(lambda: waits(process))
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=60)[0] == b"interrupted\n"
