"""Other programs: where they are, how they come to be there, and what is said of one that is missing.

Methods use what their user has installed: commands on the PATH or beside this Python, where pip puts them, and modules of this
Python. Speed is measured of a version that is named, so a `Folder` has its own programs of PyPI, and those of Debian where the
system has none; it installs them when they are first asked for. Neither the system nor this Python's environment is ever changed.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from graphstipple import GraphStippleError


@dataclass(frozen=True)
class Program:
    """A program, and where it comes from: PyPI or Debian.

    Parameters
    ----------
    name : str
        What it is called, and its first command or its module.
    advice : str
        How its user installs it; the end of a sentence.
    commands : tuple of str
        Commands that it consists of; none if it is a module of Python.
    requirement : str, optional
        What pip installs in a `Folder`. Newer versions may be faster or slower, so one is named.
    packages : tuple of str
        Packages of Debian that have it with its libraries.
    """

    name: str
    advice: str
    commands: tuple[str, ...] = ()
    requirement: str | None = None
    packages: tuple[str, ...] = ()


PROGRAMS = {
    program.name: program
    for program in (
        Program(
            "potrace",
            "install the package potrace of Debian or Homebrew",
            commands=("potrace", "mkbitmap"),
            packages=("potrace", "libpotrace0"),
        ),
        Program("vtracer", "pip install vtracer", requirement="vtracer==0.6.15"),
        Program("inksep", "pip install inksep", commands=("inksep",), requirement="inksep==1.0.0"),
        Program("stippler", "pip install stippler", commands=("stippler",), requirement="stippler==0.2.1.1"),
    )
}
"""All that are known, by name."""


# What the user has ----------------------------------------------------------------------------------------------------------------


def find_program(name: str) -> str | None:
    """Return where a command is: on the PATH, or beside this Python, where pip puts it."""
    return shutil.which(name, path=os.pathsep.join([os.environ.get("PATH", os.defpath), str(Path(sys.executable).parent)]))


def is_installed(name: str) -> bool:
    """Return whether the user has one of `PROGRAMS`."""
    found = find_program(name) if PROGRAMS[name].commands else importlib.util.find_spec(name)
    return found is not None


def missing(name: str) -> str | None:
    """Return None if the user has one of `PROGRAMS`, or the sentence that says how to install it."""
    return None if is_installed(name) else f"{name} is not installed: {PROGRAMS[name].advice}"


def run(command: Sequence[str], stdin: bytes = b"") -> bytes:
    """Return what a program writes.

    Raises
    ------
    GraphStippleError
        If it fails; with the last line of what it says.
    """
    done = subprocess.run(command, input=stdin, capture_output=True, check=False)
    if done.returncode != 0:
        said = _last_line(done.stderr) or "nothing"
        raise GraphStippleError(f"{Path(command[0]).name} failed with exit code {done.returncode} and said: {said}")
    return done.stdout


def _last_line(stderr: bytes) -> str | None:
    lines = stderr.decode(errors="replace").strip().splitlines()
    return lines[-1] if lines else None


@cache
def program_version(program: str) -> str:
    """Return the version of a command: the second word of what it says of itself. Each is asked once a process.

    Raises
    ------
    GraphStippleError
        If it fails or says no such thing.
    """
    words = run([program, "--version"]).decode(errors="replace").split()
    if len(words) < 2:
        raise GraphStippleError(f"{Path(program).name} does not tell its version")
    return words[1].rstrip(".")


def version(name: str) -> str | None:
    """Return the version of one of `PROGRAMS` that the user has; None if there is none, or if it does not tell."""
    if not PROGRAMS[name].commands:
        return importlib.metadata.version(name) if is_installed(name) else None
    program = find_program(name)
    try:
        return program_version(program) if program is not None else None
    except GraphStippleError:  # it will fail in the same way when it is to draw
        return None


# What is installed to be measured -------------------------------------------------------------------------------------------------


class Folder:
    """Programs in a folder of their own, installed when they are first asked for.

    Parameters
    ----------
    path : Path
        The folder; made when it is needed.
    refusal : str, optional
        Why nothing may be installed; the end of a sentence. None if it may.

    Attributes
    ----------
    python : Path
        The Python that has the modules.
    """

    def __init__(self, path: Path, refusal: str | None = None) -> None:
        self.python = path / "python" / "bin" / "python"
        self._debian = path / "debian"
        self._refusal = refusal

    def find(self, command: str) -> str | None:
        """Return where a command is: one of PyPI in the folder only, since another may have another version."""
        of_pypi = any(command in program.commands for program in PROGRAMS.values() if program.requirement is not None)
        beside = shutil.which(command, path=str(self.python.parent if of_pypi else self._debian / "usr" / "bin"))
        return beside if of_pypi else find_program(command) or beside

    @property
    def environment(self) -> list[str]:
        """What a command begins with, so that programs of Debian find their libraries; empty if none was unpacked."""
        libraries = [str(path) for path in self._debian.glob("usr/lib/*-linux-gnu")]
        return ["env", f"LD_LIBRARY_PATH={':'.join(libraries)}"] if libraries else []

    def missing(self, name: str) -> str | None:
        """Return None if one of `PROGRAMS` is there, if need be after installing it, or why it is not."""
        program = PROGRAMS[name]
        if self._has(program):
            return None
        if self._refusal is not None:
            return f"{name} is not installed, and {self._refusal}"
        try:
            if program.requirement is not None:
                failed = f"pip install {program.requirement} failed"
                self._install(program.requirement)
            else:
                failed = f"{name} is not installed, and its Debian packages cannot be had"
                self._unpack(program.packages)
        except (OSError, subprocess.CalledProcessError) as error:
            said = _last_line(error.stderr) if isinstance(error, subprocess.CalledProcessError) else None
            return f"{failed}: {said or error}"
        return None if self._has(program) else f"{program.requirement or ' '.join(program.packages)} has no program"

    def _has(self, program: Program) -> bool:
        if program.commands:
            return all(self.find(command) is not None for command in program.commands)
        try:
            return subprocess.run([self.python, "-c", f"import {program.name}"], capture_output=True, check=False).returncode == 0
        except OSError:
            return False

    def _install(self, requirement: str) -> None:
        if not self.python.exists():
            _check([sys.executable, "-m", "venv", self.python.parents[1]])
        _check([self.python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", requirement])

    def _unpack(self, packages: Sequence[str]) -> None:
        self._debian.mkdir(parents=True, exist_ok=True)
        _check(["apt-get", "download", *packages], self._debian)
        for package in self._debian.glob("*.deb"):
            _check(["dpkg", "-x", package, self._debian])


def _check(command: Sequence[str | Path], folder: Path | None = None) -> None:
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
