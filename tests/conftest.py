"""Photos that every test may draw: public-domain pictures that come in scikit-image's wheel."""

import numpy as np
import numpy.typing as npt
import pytest
from skimage import data

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
