"""The weights of LPIPS in the user's cache folder: plain arrays, one file a network."""

from __future__ import annotations

import os
import sys
import zipfile
import zlib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

import numpy as np

from graphstipple._errors import MissingWeightsError
from graphstipple.metrics._networks import NETWORKS, Net, Weights

FETCH = "python -m graphstipple.metrics fetch"
"""The command that fills the cache folder."""


def cache_folder() -> Path:
    """Return the folder of the weights, which may not exist yet.

    Returns
    -------
    Path
        What the environment variable GRAPHSTIPPLE_CACHE says, else the folder ``graphstipple`` in the user's cache folder.
    """
    given = os.environ.get("GRAPHSTIPPLE_CACHE")
    if given:
        return Path(given)
    if sys.platform == "win32":
        local = os.environ.get("LOCALAPPDATA")
        return (Path(local) if local else Path.home() / "AppData" / "Local") / "graphstipple"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "graphstipple"
    cache = os.environ.get("XDG_CACHE_HOME", "")
    # A relative path there is to be ignored, says the XDG Base Directory Specification.
    return (Path(cache) if Path(cache).is_absolute() else Path.home() / ".cache") / "graphstipple"


def weights_file(folder: Path, net: Net) -> Path:
    """Return where a network's weights are in a cache folder."""
    return folder / f"lpips-{net}.npz"


def read_weights(folder: Path, net: Net) -> Weights:
    """Return a network's weights.

    Parameters
    ----------
    folder : Path
        The cache folder.
    net : {"alex", "vgg"}
        The network.

    Returns
    -------
    Weights

    Raises
    ------
    MissingWeightsError
        If they are not there, or not whole.
    """
    path = weights_file(folder, net)
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            weights = {name: arrays[name] for name in arrays}
    except FileNotFoundError:
        raise MissingWeightsError(f"LPIPS needs weights that are not in {folder}: run `{FETCH}`") from None
    # What np.load raises depends on where a file is damaged: TypeError and AttributeError are those of an array without names.
    except (OSError, ValueError, EOFError, KeyError, TypeError, AttributeError, zipfile.BadZipFile, zlib.error) as error:
        raise MissingWeightsError(f"{path} cannot be read as weights of LPIPS ({error}): run `{FETCH}`") from error
    fault = fault_of(weights, net)
    if fault is not None:
        raise MissingWeightsError(f"{path} does not hold the weights of LPIPS ({fault}): run `{FETCH}`")
    return weights


load_weights = lru_cache(read_weights)
"""The same, read once a process."""


def fault_of(arrays: Mapping[str, object], net: Net) -> str | None:
    """Return what is wrong with a network's weights, or None.

    Parameters
    ----------
    arrays : mapping of str to object
        What may be weights.
    net : {"alex", "vgg"}
        The network whose arrays, shapes and finite values they must have.

    Returns
    -------
    str, optional
        A clause for an error message.
    """
    for name, shape in NETWORKS[net].shapes().items():
        array = arrays.get(name)
        if not isinstance(array, np.ndarray):
            return f"{name} is missing"
        if array.dtype != np.float32 or array.shape != shape:
            return f"{name} is {array.dtype} of shape {array.shape}, not float32 of shape {shape}"
        if not np.isfinite(array).all():
            return f"{name} is not finite"
    return None
