"""What shells and `man` read of the command, tried with those that are installed."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tests.commands import USAGE, assert_one_sentence, done, native_binary, run

import graphstipple as gs

SHELLS = ["bash", "zsh", "fish"]


@pytest.fixture(scope="module")
def command() -> Path:
    return native_binary()


def installed(name: str) -> str:
    """Return a program's path, or skip the test."""
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"{name} is not installed")
    return found


def script(command: Path, shell: str, folder: Path) -> Path:
    """Write the completions of a shell to a file."""
    path = folder / f"completions.{shell}"
    path.write_bytes(done(command, "--completions", shell).stdout)
    return path


@pytest.mark.parametrize("shell", SHELLS)
def test_completions_are_read_by_their_shell(command, tmp_path, shell):
    result = subprocess.run([installed(shell), "-n", script(command, shell, tmp_path)], capture_output=True, check=True, timeout=60)
    assert result.stderr == b""


@pytest.mark.parametrize("shell", SHELLS)
def test_completions_are_the_same_every_time_and_from_pip(command, shell):
    expected = done(command, "--completions", shell).stdout
    assert b"local-contrast" in expected
    assert done(command, f"--completions={shell}").stdout == expected
    assert done(Path(sys.executable), "-m", "graphstipple", "--completions", shell).stdout == expected


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--preset", "po"], ["portrait", "poster"]),
        (["--style", "l"], ["layered"]),
        (["--white-point", ""], ["auto"]),
        (["--page", "le"], ["legal", "letter"]),
        (["--max-b"], ["--max-bytes"]),
        (["--local"], ["--local-contrast"]),
    ],
    ids=" ".join,
)
def test_bash_completes(command, tmp_path, words, expected):
    path = script(command, "bash", tmp_path)
    line = " ".join(f"'{word}'" for word in ["graphstipple", *words])
    lines = [
        f"source '{path}'",
        "complete -p graphstipple >/dev/null || exit 1",
        f"COMP_WORDS=({line}); COMP_CWORD={len(words)}",
        f"_graphstipple graphstipple '{words[-1]}' '{words[-2] if len(words) > 1 else 'graphstipple'}'",
        "printf '%s\\n' \"${COMPREPLY[@]}\"",
    ]
    result = subprocess.run([installed("bash"), "-c", "\n".join(lines)], capture_output=True, check=True, timeout=60)
    assert sorted(result.stdout.decode().split()) == expected


@pytest.mark.parametrize("arguments", [["--completions", "tcsh"], ["--completions"], ["--completions=basj"]], ids=" ".join)
def test_other_shells_are_refused_in_one_sentence(command, arguments):
    result = run(command, *arguments)
    assert_one_sentence(result, USAGE)
    assert "it must be bash, zsh or fish" in result.stderr.decode()


def test_the_manual_page_is_read_by_man(command, tmp_path):
    page = tmp_path / "graphstipple.1"
    page.write_bytes(done(command, "--man").stdout)
    assert page.read_bytes() == done(command, "--man").stdout
    text = page.read_text()
    flags = set(re.findall(r"--[a-z][a-z-]+", done(command, "--help-all").stdout.decode()))
    assert flags <= set(re.findall(r"--[a-z][a-z-]+", text.replace("\\-", "-")))
    checked = [[installed("groff"), "-man", "-ww", "-z", page]]
    if shutil.which("mandoc"):
        checked.append(["mandoc", "-Tlint", "-W", "warning", page])
    for arguments in checked:
        result = subprocess.run(arguments, capture_output=True, check=False, timeout=60)
        assert (result.returncode, result.stderr) == (0, b""), result.stdout


def test_a_misspelt_preset_is_answered_with_the_nearest():
    with pytest.raises(gs.InvalidInputError, match=r"^preset is potrait, but it must be default, .*; did you mean portrait\?$"):
        gs.Options.preset("potrait")
    with pytest.raises(gs.InvalidInputError, match=r'; did you mean "layered"\?$'):
        gs.draw(np.eye(2)).svg(style="layerd")


def test_whole_floats_are_whole_numbers_in_python_and_text_is_none():
    assert gs.Options(nodes=1e5) == gs.Options(nodes=100_000)
    for wrong in ("100k", "1e5", 1e5 + 0.5):
        with pytest.raises(gs.InvalidInputError, match="it must be None or a whole number"):
            gs.Options(nodes=wrong)
