"""LPIPS 0.1, the learned perceptual distance (Zhang et al. 2018), on NumPy alone."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from graphstipple._errors import InvalidInputError
from graphstipple.metrics._networks import NETWORKS, Features, Net, block_features
from graphstipple.metrics._similarity import Field, checked, checked_pair
from graphstipple.metrics._weights import cache_folder, load_weights

SHIFT, SCALE = np.array([[-0.030, -0.088, -0.188], [0.458, 0.448, 0.450]], np.float32)
"""What LPIPS 0.1 takes from red, green and blue in [-1, 1] before the network, and what it divides them by."""

EPSILON = np.float32(1e-10)
"""Keeps the direction of a place without features finite; LPIPS's own."""

BAND_ROWS = 32
"""Rows of features that are compared at once: the temporary arrays stay small beside the features."""


class Lpips:
    """LPIPS of any number of pictures against one reference, whose features are computed once.

    Parameters
    ----------
    reference : array of floats, (height, width)
        In [0, 1]; at least 31 px a side for AlexNet, 16 for VGG16.
    net : {"alex", "vgg"}
        The network: AlexNet or VGG16.

    Raises
    ------
    InvalidInputError
        If the array has a wrong shape, type or value, or no such network exists.
    MissingWeightsError
        If the weights are not in the cache folder.

    Notes
    -----
    Grey is repeated to three channels, brought to [-1, 1], and taken through the network; at every pixel of five of its layers
    the features are brought to length 1. The distance is the squared difference of the two pictures' features, weighted by
    channel with the linear heads of LPIPS 0.1, summed over channels, averaged over pixels and added up over the layers.

    The reference's features stay in memory: 128 MB for VGG16 at 512 x 512, 11 MB for AlexNet.
    """

    def __init__(self, reference: npt.NDArray[np.floating[Any]], net: Net = "alex") -> None:
        if net not in NETWORKS:
            raise InvalidInputError(f"net is {net!r}, but it must be {' or '.join(map(repr, NETWORKS))}")
        self._network = NETWORKS[net]
        self._values = checked(reference, "reference", self._network.least_side, f"LPIPS ({net})")
        self._weights = load_weights(cache_folder(), net)
        self._directions = [_directions(features) for features in self._features(self._values)]

    def __call__(self, picture: npt.NDArray[np.floating[Any]]) -> float:
        """Return the distance of a picture from the reference.

        Parameters
        ----------
        picture : array of floats, (height, width)
            In [0, 1], of the reference's shape.

        Returns
        -------
        float
            At least 0; lower is nearer, 0 for equal pictures.

        Raises
        ------
        InvalidInputError
            If the array has a wrong shape, type or value.
        """
        values, _ = checked_pair(picture, self._values)
        distance = 0.0
        for number, (features, reference) in enumerate(zip(self._features(values), self._directions, strict=True)):
            head = self._weights[f"head_{number}"]
            total = 0.0
            for start in range(0, len(features), BAND_ROWS):
                band = slice(start, start + BAND_ROWS)
                total += float(np.sum(np.square(_directions(features[band]) - reference[band]) @ head, dtype=np.float64))
            distance += total / (features.shape[0] * features.shape[1])
        return distance

    def _features(self, values: Field) -> Iterator[Features]:
        grey = (2 * values - 1).astype(np.float32)[:, :, np.newaxis]
        return block_features(self._network, self._weights, (grey - SHIFT) / SCALE)


def lpips(picture: npt.NDArray[np.floating[Any]], reference: npt.NDArray[np.floating[Any]], net: Net = "alex") -> float:
    """Return the learned perceptual distance LPIPS 0.1 (Zhang et al. 2018) of two pictures.

    Parameters
    ----------
    picture, reference : array of floats, (height, width)
        In [0, 1], of one shape; at least 31 px a side for AlexNet, 16 for VGG16.
    net : {"alex", "vgg"}
        The network: AlexNet or VGG16. `Lpips` is faster for several pictures of one photo.

    Returns
    -------
    float
        At least 0; lower is nearer, 0 for equal pictures.

    Raises
    ------
    InvalidInputError
        If an array has a wrong shape, type or value, or no such network exists.
    MissingWeightsError
        If the weights are not in the cache folder.
    """
    checked_pair(picture, reference)
    return Lpips(reference, net)(picture)


def _directions(features: Features) -> Features:
    """Return the features of every pixel brought to length 1."""
    lengths: Features = np.sqrt(np.einsum("yxc,yxc->yx", features, features))
    directions: Features = features / (lengths + EPSILON)[:, :, np.newaxis]
    return directions
