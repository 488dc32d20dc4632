"""What every test may use: public-domain photos that come in scikit-image's wheel, the weights of LPIPS, a browser."""

import os
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from playwright.sync_api import Browser, sync_playwright
from skimage import data
from tests import readers

from graphstipple.metrics._weights import cache_folder

PHOTOS = ("astronaut", "camera", "chelsea", "coffee", "rocket")


@pytest.fixture(scope="session")
def photos() -> dict[str, npt.NDArray[np.uint8]]:
    """All five photos by name, (height, width) or (height, width, 3)."""
    return {name: getattr(data, name)() for name in PHOTOS}


@pytest.fixture(scope="session", params=PHOTOS)
def photo(request: pytest.FixtureRequest, photos: dict[str, npt.NDArray[np.uint8]]) -> npt.NDArray[np.uint8]:
    """Each photo in turn."""
    return photos[request.param]


@pytest.fixture(scope="session")
def astronaut(photos: dict[str, npt.NDArray[np.uint8]]) -> npt.NDArray[np.uint8]:
    """(512, 512, 3)."""
    return photos["astronaut"]


@pytest.fixture(scope="session")
def small(astronaut: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return a face, (96, 128, 3): quick to draw."""
    return np.ascontiguousarray(astronaut[60:156, 160:288])


@pytest.fixture(scope="session")
def weights() -> Path:
    """Return the cache folder with the weights of LPIPS in it: the command fetches them where they are missing."""
    run = subprocess.run([sys.executable, "-m", "graphstipple.metrics", "fetch"], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    return cache_folder()


@pytest.fixture
def s3(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Return the address of an S3 server on this machine, to which all of S3 goes."""
    files = pytest.importorskip("s3fs").S3FileSystem
    server = pytest.importorskip("moto.server").ThreadedMotoServer("127.0.0.1", 0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "of-a-test")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "of-a-test")
    monkeypatch.setenv("AWS_DEFAULT_REGION", "us-east-1")
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://{host}:{port}")
    # What another test has left, which has asked another server.
    urllib.request.urlopen(urllib.request.Request(f"http://{host}:{port}/moto-api/reset", method="POST")).close()
    files.clear_instance_cache()
    yield f"http://{host}:{port}"
    server.stop()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Chromium; skips without it, but not where everything is to be tested."""
    if readers.CHROMIUM is None:
        if os.environ.get("CI"):
            pytest.fail("no Chromium: CI has to install it")
        pytest.skip("no Chromium is installed")
    arguments = ["--no-sandbox"] if os.geteuid() == 0 else []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=readers.CHROMIUM, args=arguments)
        yield browser
        browser.close()
