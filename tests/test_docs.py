"""The documentation says what is so: its commands and examples run, its links lead somewhere, its figures are the program's.

Every `sh` and `python` block of the README and of the pages is run, those of one page in their order, in a folder with a small
photo. What no test can run is named in `NOT_RUN`.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest
from PIL import Image
from tests.support import ROOT, photo

import graphstipple as gs
from graphstipple import _core

NOT_RUN = {
    "make ": "builds, or runs the tests themselves",
    "pip install ": "asks the package index",
    "python -m graphstipple.metrics fetch": "downloads weights; tests/test_metrics.py fetches them",
    "python3.13 tools/lock.py ": "asks the package index",
    "graphstipple batch s3://": "asks a store; tests/test_batch.py draws from one to one on this machine",
    "dask ": "runs until it is stopped; tests/test_batch_dask.py starts a scheduler and workers",
    "kubectl ": "asks a cluster",
    "graphstipple studio ": "serves until it is stopped; tests/test_studio_page.py does what a user does",
    "cargo ": "builds; `make test` and `make lint` do",
    ".venv/bin/": "measures or compares for minutes; tests/test_benches.py and tests/test_evaluation.py run it on tiny photos",
    "GRAPHSTIPPLE_UPDATE_GOLDEN=1 ": "writes the golden files anew",
}
"""Commands that no block is run with, by how they begin, each with its reason."""

IS_NO_CODE = {"text", "bibtex", "{toctree}", "{eval-rst}"}
"""What else may stand between fences: output, references, and what Sphinx reads."""

README_LINES = 180
IMAGE_BYTES = 300_000

FILES = sorted(
    ROOT / name
    for name in subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.md"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    if (ROOT / name).exists()
)
PAGES = [path for path in FILES if path.parent == ROOT or path.is_relative_to(ROOT / "docs")]


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def blocks(path: Path) -> Iterator[tuple[str, str]]:
    """Yield every fenced block of a page: its language and its text."""
    for match in re.finditer(r"^```(\S*)[^\n]*\n(.*?)^```$", path.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL):
        yield match[1], match[2]


def is_run(block: str) -> bool:
    """Whether a shell block is run: all of its commands are, or none of them can be."""
    commands = [line for line in block.splitlines() if line.strip() and not line.startswith("#")]
    not_run = [line for line in commands if line.startswith(tuple(NOT_RUN))]
    assert len(not_run) in {0, len(commands)}, f"runs in part: {commands}"
    return not not_run


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Go to a folder with a photo and a map, with a home of its own and the installed command at hand."""
    Image.fromarray(photo("astronaut")[20:200, 100:340]).save(tmp_path / "photo.jpg")
    Image.fromarray(np.tile(np.linspace(0, 255, 60).astype(np.uint8), (45, 1))).save(tmp_path / "map.png")
    for folder in (".local/share/man/man1", ".local/share/bash-completion/completions", ".zfunc", ".config/fish/completions"):
        (tmp_path / "home" / folder).mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    return tmp_path


@pytest.mark.parametrize("path", [path for path in PAGES if any(kind in {"sh", "python"} for kind, _ in blocks(path))], ids=name_of)
def test_every_example_runs(path: Path, desk: Path) -> None:
    names: dict[str, object] = {"__name__": "__main__"}
    for kind, text in blocks(path):
        if kind == "python":
            exec(compile(text, path.name, "exec"), names)
        elif kind == "sh" and is_run(text):
            run = subprocess.run(
                ["bash", "-euo", "pipefail", "-c", text], cwd=desk, capture_output=True, text=True, timeout=120, check=False
            )
            assert run.returncode == 0, f"{text}\n{run.stderr}"


@pytest.mark.parametrize("path", PAGES, ids=name_of)
def test_every_block_says_what_it_is(path: Path) -> None:
    assert {kind for kind, _ in blocks(path)} <= IS_NO_CODE | {"sh", "python", "toml"}


def test_what_is_not_run_is_there() -> None:
    lines = [line for path in PAGES for kind, text in blocks(path) if kind == "sh" for line in text.splitlines()]
    assert [start for start in NOT_RUN if not any(line.startswith(start) for line in lines)] == []


def test_the_readme_is_short() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= README_LINES


def prose(path: Path) -> str:
    """Return a page without code."""
    text = re.sub(r"^```.*?^```$", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"^ {4}.*$", "", text, flags=re.MULTILINE)


def links(path: Path) -> list[str]:
    """Return what a page's links and images lead to."""
    return re.findall(r"\]\(([^()\s]+)\)", prose(path))


def anchors(path: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub and the site name them."""
    found: set[str] = set()
    for heading in re.findall(r"^#{1,6} +(.+?) *$", prose(path), re.MULTILINE):
        text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").replace("*", "")
        slug = re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")
        numbers = (f"{slug}-{number}" if number else slug for number in range(len(found) + 1))
        found.add(next(name for name in numbers if name not in found))
    return found


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_every_link_leads_somewhere(path: Path) -> None:
    for link in links(path):
        parts = urlsplit(link)
        if parts.scheme:
            assert parts.scheme == "https", link
            assert re.fullmatch(r"[a-z0-9-]+(\.[a-z0-9-]+)+", parts.netloc), link
            continue
        target = (path.parent / parts.path).resolve() if parts.path else path
        assert target.exists(), f"{link} leads nowhere"
        assert target.is_relative_to(ROOT), f"{link} leads out of the repository"
        if parts.fragment:
            assert parts.fragment in anchors(target), f"{link}: no such heading"


def test_images_are_small_and_used() -> None:
    shown = {(path.parent / link).resolve() for path in PAGES for link in links(path) if not urlsplit(link).scheme}
    for image in (ROOT / "docs" / "images").iterdir():
        assert image.stat().st_size < IMAGE_BYTES, image.name
        assert image in shown or image.name in (ROOT / "docs" / "conf.py").read_text(encoding="utf-8"), f"{image.name} is not shown"


def test_the_python_page_has_every_public_name() -> None:
    text = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    named = {name.removeprefix("graphstipple.") for name in re.findall(r"^\.\. [\w:]+:: ([\w.]+)$", text, re.MULTILINE)}
    for module in (gs, gs.stages, gs.metrics):
        assert set(module.__all__) <= named, module.__name__


DEFAULTS = gs.Options()


def declared(file: str, name: str) -> float:
    """Return the version that a file of the project asks for."""
    found = re.search(rf'^{name} = "(?:>=)?([\d.]+)"', (ROOT / file).read_text(encoding="utf-8"), re.MULTILINE)
    assert found
    return float(found[1])


FIGURES = {
    "README.md": [
        (r"Python ([\d.]+) or newer", declared("pyproject.toml", "requires-python")),
        (r"\(([\d.]+) or newer\)", declared("Cargo.toml", "rust-version")),
    ],
    "CONTRIBUTING.md": [(r"Python ([\d.]+) or newer", declared("pyproject.toml", "requires-python"))],
    "docs/formats.md": [(r"65,535 pixels a side and (\d+) million in all", _core.MAX_PIXELS // 10**6)],
    "docs/method.md": [
        (r"`stippling` ([\d.]+) is the default", DEFAULTS.stippling),
        (r"The default is tonal with shading = ([\d.]+)", DEFAULTS.shading),
        (r"k1 = (\d+), k2", DEFAULTS.published.k1),
        (r"k2 = ([\d.]+), base", DEFAULTS.published.k2),
        (r"base = ([\d.]+), and lambda", DEFAULTS.published.base),
        (r"lambda = (\d+), which", DEFAULTS.published.detail_gain),
    ],
    "docs/output.md": [(r"At ([\d.]+), the default", DEFAULTS.tolerance)],
    "CHANGELOG.md": [(r"`tolerance`, ([\d.]+) px by default", DEFAULTS.tolerance)],
}
"""Figures in running text, by page: a pattern and what the program has."""


@pytest.mark.parametrize(("page", "pattern", "value"), [(page, *figure) for page, said in FIGURES.items() for figure in said])
def test_figures_are_those_of_the_program(page: str, pattern: str, value: float) -> None:
    found = re.findall(pattern, (ROOT / page).read_text(encoding="utf-8"))
    assert [float(number) for number in found] == [value]


def test_the_default_number_of_nodes_is_said_alike() -> None:
    meaning = _core.options_schema()["properties"]["nodes"]["x-absent"]["meaning"]
    share, least, most = re.fullmatch(r"([\d.]+) a pixel, ([\d,]+) to ([\d,]+)", meaning).groups()
    method = (ROOT / "docs" / "method.md").read_text(encoding="utf-8")
    assert f"`fineness` times {share} nodes a pixel, at most `fineness` times {most}, at least `fineness` times {least}" in method
