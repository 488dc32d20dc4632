"""Where drawings are written to: files that are kept, links, devices and pipes, and what signals leave behind."""

from __future__ import annotations

import os
import random
import signal
import stat
import subprocess
import sys
import sysconfig
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from tests.commands import FAILURE, USAGE, assert_one_sentence, done, native_binary, run
from tests.support import photo

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
def noise(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a photo whose files are slow to write."""
    folder = tmp_path_factory.mktemp("noise")
    values: NDArray[np.uint8] = np.random.default_rng(2).integers(0, 256, (160, 200), np.uint8)
    Image.fromarray(values).save(folder / "photo.png")
    return folder


@posix
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT], ids=lambda number: number.name)
def test_signals_leave_nothing_behind(program: Path, noise: Path, number: signal.Signals, request: pytest.FixtureRequest) -> None:
    # What is ignored here, as under nohup, would be ignored there.
    before = signal.signal(number, signal.SIG_DFL) if signal.getsignal(number) == signal.SIG_IGN else None
    if before is not None:
        request.addfinalizer(lambda: signal.signal(number, before))
    command = [program, "photo.png", "-o", "a.png", "--width", "7000px", "--preview", "b.png"]
    began = time.monotonic()
    subprocess.run(command, cwd=noise, check=True, timeout=60)
    takes = time.monotonic() - began
    whole = {name: (noise / name).read_bytes() for name in ("a.png", "b.png")}
    codes = set()
    moments = random.Random(int(number))
    for _ in range(8):
        for name in whole:
            (noise / name).unlink(missing_ok=True)
        process = subprocess.Popen(command, cwd=noise, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        if program == CONSOLE_SCRIPT:
            # Python does not listen before it has begun.
            time.sleep(0.15 * takes)
        time.sleep(moments.uniform(0.03, takes))
        process.send_signal(number)
        printed = process.communicate(timeout=60)
        codes.add(process.returncode)
        left = [name for name in names(noise) if name != "photo.png"]
        # All or nothing, and never anything under another name.
        assert left in ([], ["a.png", "b.png"]), left
        assert all((noise / name).read_bytes() == whole[name] for name in left)
        assert b"Traceback" not in b"".join(printed)
    # A process that has not begun to listen is ended by the signal itself.
    assert codes <= {0, 128 + number, -number}
    assert 128 + number in codes


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a process that is killed leaves what it was writing")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL], ids=lambda number: number.name)
def test_a_process_that_is_killed_leaves_nothing_behind(tmp_path: Path, number: signal.Signals) -> None:
    # Nobody listens here: what is not complete has no name.
    program = """
import numpy as np, graphstipple as gs
drawing = gs.draw(np.random.default_rng(2).integers(0, 256, (160, 200), np.uint8))
drawing.save("a.png", width=5000)
print("now", flush=True)
while True:
    drawing.save("a.png", width=5000)
"""
    moments = random.Random(int(number))
    for _ in range(5):
        with subprocess.Popen([sys.executable, "-c", program], cwd=tmp_path, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "now\n"
            time.sleep(moments.uniform(0, 0.6))
            process.send_signal(number)
            assert process.wait(60) == -number
        assert names(tmp_path) == ["a.png"]
        with Image.open(tmp_path / "a.png") as image:
            image.load()


@posix
def test_what_is_ignored_stays_ignored(program: Path, noise: Path) -> None:
    for number in (signal.SIGHUP, signal.SIGTERM):
        process = subprocess.Popen(
            [program, "photo.png", "-o", "ignored.png", "--width", "6000px"],
            cwd=noise,
            preexec_fn=lambda number=number: signal.signal(number, signal.SIG_IGN),  # type: ignore[misc]  # noqa: PLW1509
        )
        for _ in range(10):
            time.sleep(0.05)
            process.send_signal(number)
        assert process.wait(60) == 0
        (noise / "ignored.png").unlink()


@posix
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT], ids=lambda number: number.name)
def test_waiting_for_a_reader_can_be_interrupted(program: Path, desk: Path, number: signal.Signals) -> None:
    os.mkfifo(desk / "pipe.svg")
    Image.fromarray(np.random.default_rng(5).integers(0, 256, (400, 500), np.uint8)).save(desk / "noise.png")
    for arguments in (["photo.png", "-o", "pipe.svg", "--preview", "b.png"], ["noise.png", "-o", "-"]):
        with subprocess.Popen([program, *arguments], cwd=desk, stdout=subprocess.PIPE) as process:
            # Nobody reads, neither the pipe nor standard output, which takes some of it.
            time.sleep(2)
            assert process.poll() is None
            process.send_signal(number)
            assert process.wait(5) == 128 + number
    assert names(desk) == ["noise.png", "photo.png", "pipe.svg"]


@posix
def test_saving_to_a_pipe_can_be_interrupted_in_python(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.svg")
    program = """
import signal, numpy as np, graphstipple as gs
signal.signal(signal.SIGINT, signal.default_int_handler)
drawing = gs.draw(np.zeros((8, 8), np.uint8))
print("now", flush=True)
try:
    drawing.save("pipe.svg")
except KeyboardInterrupt:
    print("interrupted")
"""
    with subprocess.Popen([sys.executable, "-c", program], cwd=tmp_path, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "now\n"
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=10)[0] == "interrupted\n"
