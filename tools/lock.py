"""Write requirements-dev.lock: the newest development environment for every Python that is supported.

Run as ``python tools/lock.py python3.10 python3.11 python3.12 python3.13`` (Python 3.11 or newer; the interpreters, oldest first,
need pip). Every interpreter's pip is asked what it would install for the project's own dependencies, ``studio``, ``dask`` and
``dev``; where the answers differ, markers say which Python gets which version, and the newest one's answer holds for newer Pythons
too.
"""

import json
import subprocess
import sys
from pathlib import Path

import tomllib

ROOT = Path(__file__).resolve().parent.parent
HEAD = """\
# The development environment, pinned: what `make` installs into .venv, for CPython 3.10 to 3.13 on Linux and macOS.
# Made by `python tools/lock.py python3.10 python3.11 python3.12 python3.13` from pyproject.toml; do not edit by hand.
"""


def resolve(python: str, requirements: list[str]) -> tuple[str, dict[str, str]]:
    """Return the interpreter's version and the version of every package that its pip would install."""
    version = subprocess.check_output([python, "-c", "import sys; print('%d.%d' % sys.version_info[:2])"], text=True).strip()
    command = [python, "-m", "pip", "install", "--quiet", "--dry-run", "--ignore-installed", "--report", "-", *requirements]
    report = json.loads(subprocess.check_output(command, text=True))
    metadata = [item["metadata"] for item in report["install"]]
    return version, {entry["name"].lower().replace("_", "-"): entry["version"] for entry in metadata}


def lines(resolved: list[tuple[str, dict[str, str]]]) -> list[str]:
    """Return the pins of all packages, with markers where Pythons differ."""
    pythons = [python for python, _ in resolved]
    result = []
    for name in sorted({name for _, packages in resolved for name in packages}):
        versions = [packages.get(name) for _, packages in resolved]
        first = 0
        while first < len(versions):
            last = first
            while last + 1 < len(versions) and versions[last + 1] == versions[first]:
                last += 1
            markers = []
            if first > 0:
                markers.append(f'python_version >= "{pythons[first]}"')
            if last + 1 < len(versions):
                markers.append(f'python_version < "{pythons[last + 1]}"')
            if versions[first] is not None:
                result.append(f"{name}=={versions[first]}" + (f" ; {' and '.join(markers)}" if markers else ""))
            first = last + 1
    return result


def main() -> None:
    """Ask every interpreter named on the command line and write the file."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    requirements = project["dependencies"] + extras["studio"] + extras["dask"] + extras["dev"]
    resolved = [resolve(python, requirements) for python in sys.argv[1:]]
    (ROOT / "requirements-dev.lock").write_text(HEAD + "\n".join(lines(resolved)) + "\n")


if __name__ == "__main__":
    main()
