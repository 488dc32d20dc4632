"""Photos for the tests, where things are, and how hypothesis looks for examples."""

from __future__ import annotations

import contextlib
import dataclasses
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skimage.data
from hypothesis import HealthCheck, settings
from numpy.typing import NDArray

import graphstipple as gs

# The same examples every time, so that a change of code is the only thing that can turn a test red;
# GRAPHSTIPPLE_EXPLORE=1 looks for new ones.
slow = [HealthCheck.too_slow]
settings.register_profile("fixed", deadline=None, derandomize=True, max_examples=25, database=None, suppress_health_check=slow)
settings.register_profile("explore", deadline=None, max_examples=300, suppress_health_check=slow)
settings.load_profile("explore" if os.environ.get("GRAPHSTIPPLE_EXPLORE") else "fixed")

ROOT = Path(__file__).resolve().parents[1]
PHOTOS = ("astronaut", "camera", "chelsea", "coffee", "rocket")
on_every_photo = pytest.mark.parametrize("name", PHOTOS)

linux = pytest.mark.skipif(sys.platform != "linux", reason="it looks into /proc")

GOLDEN = ROOT / "tests" / "golden"
"""Inputs and expected drawings that Python and Rust tests share."""

GOLDEN_CASES: dict[str, dict[str, object]] = {
    "camera": {"density": 1.0},
    "coffee": {"nodes": 1500, "relax": 2, "lattice": "square"},
    "chelsea": {"preset": "paper"},
    "rocket": {"preset": "scratchboard"},
    "astronaut": {"preset": "linocut"},
}
"""What `options_with` is given for every golden drawing, by the name of its files, which is also that of the photo."""

PUBLISHED = tuple(field.name for field in dataclasses.fields(gs.Published))
"""Names of the published method's parameters."""


def options_with(preset: str = "default", **changes: Any) -> gs.Options:
    """Return a preset's options with single ones changed, parameters of its published method among them: no name means both."""
    start = gs.Options.preset(preset)
    published = {name: changes.pop(name) for name in PUBLISHED if name in changes}
    return start.replace(published=start.published.replace(**published), **changes)


def photo(name: str, width: int | None = None, height: int | None = None) -> NDArray[np.uint8]:
    """Return one of scikit-image's public-domain photos, whole, or a crop from its middle."""
    image = np.asarray(getattr(skimage.data, name)())
    if width is None or height is None:
        return image
    top, left = (image.shape[0] - height) // 2, (image.shape[1] - width) // 2
    return np.ascontiguousarray(image[top : top + height, left : left + width])


def photo_luma(name: str, width: int | None = None, height: int | None = None) -> NDArray[np.float32]:
    """Return the same as a field."""
    image = photo(name, width, height).astype(np.float64) / 255
    return (image if image.ndim == 2 else image @ np.array([0.299, 0.587, 0.114])).astype(np.float32)


def wait_until(condition: Callable[[], object], patience: int = 120) -> None:
    """Wait for what another process or thread does; give up after so many seconds."""
    pause = threading.Event()
    for _ in range(100 * patience):
        if condition():
            return
        pause.wait(0.01)
    pytest.fail(f"it did not happen within {patience} s")


@contextlib.contextmanager
def hears_ctrl_c() -> Iterator[None]:
    """Let programs that are started here hear of Ctrl-C, which those in the background of a shell do not."""
    handler = signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)


def waits(process: subprocess.Popen[bytes]) -> bool:
    """Whether all threads of a process wait for something (Linux)."""
    states = [path.read_text().rpartition(")")[2].split()[0] for path in Path(f"/proc/{process.pid}/task").glob("*/stat")]
    return all(state == "S" for state in states)
