"""The convolutional networks whose features LPIPS compares: AlexNet and VGG16, without their classifiers.

Features are arrays (height, width, channels) of float32. A convolution is one matrix product a band of rows, on the band's
patches as rows: NumPy's BLAS does the work, and memory stays near that of the features themselves.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view

Net: TypeAlias = Literal["alex", "vgg"]

Features: TypeAlias = npt.NDArray[np.float32]

Weights: TypeAlias = dict[str, npt.NDArray[np.float32]]
"""Arrays by name, of the shapes that `Network.shapes` gives."""

BAND_VALUES = 2**22
"""Values in a band's patches, 16 MB: with fewer the matrix product is slower, with more memory grows for no gain."""


@dataclass(frozen=True)
class Convolution:
    """A convolution of size x size, zeros beyond the border, followed by max(0, x)."""

    channels: int
    size: int = 3
    stride: int = 1
    padding: int = 1


@dataclass(frozen=True)
class Block:
    """Convolutions whose last result LPIPS compares; before them, a maximum over `pooling` x `pooling` at every second place."""

    convolutions: tuple[Convolution, ...]
    pooling: int | None = None


@dataclass(frozen=True)
class Network:
    """A network as blocks.

    Parameters
    ----------
    blocks : tuple of Block
        In order.
    least_side : int
        The shortest side, in pixels, that leaves every block something to work on.
    """

    blocks: tuple[Block, ...]
    least_side: int

    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Return the shapes of the weights by name.

        Returns
        -------
        dict of str to tuple of int
            ``kernel_i`` (size, size, channels in, channels out) and ``bias_i`` (channels out,) of every convolution in order,
            and ``head_j`` (channels,), LPIPS's factors for the features of block j.
        """
        shapes: dict[str, tuple[int, ...]] = {}
        channels, index = 3, 0
        for number, block in enumerate(self.blocks):
            for convolution in block.convolutions:
                shapes[f"kernel_{index}"] = (convolution.size, convolution.size, channels, convolution.channels)
                shapes[f"bias_{index}"] = (convolution.channels,)
                channels, index = convolution.channels, index + 1
            shapes[f"head_{number}"] = (channels,)
        return shapes


NETWORKS: dict[Net, Network] = {
    # Krizhevsky 2014.
    "alex": Network(
        (
            Block((Convolution(64, size=11, stride=4, padding=2),)),
            Block((Convolution(192, size=5, padding=2),), pooling=3),
            Block((Convolution(384),), pooling=3),
            Block((Convolution(256),)),
            Block((Convolution(256),)),
        ),
        least_side=31,
    ),
    # Simonyan and Zisserman 2015.
    "vgg": Network(
        (
            Block((Convolution(64),) * 2),
            Block((Convolution(128),) * 2, pooling=2),
            Block((Convolution(256),) * 3, pooling=2),
            Block((Convolution(512),) * 3, pooling=2),
            Block((Convolution(512),) * 3, pooling=2),
        ),
        least_side=16,
    ),
}


def block_features(network: Network, weights: Weights, image: Features) -> Iterator[Features]:
    """Yield the features that each block of a network makes of an image, one after the other to save memory.

    Parameters
    ----------
    network : Network
        The architecture.
    weights : Weights
        Of the shapes ``network.shapes()``.
    image : array of float32, (height, width, 3)
        At least ``network.least_side`` pixels a side.

    Yields
    ------
    array of float32, (height, width, channels)
        At least 0.
    """
    features, index = image, 0
    for block in network.blocks:
        if block.pooling is not None:
            features = pool(features, block.pooling)
        for convolution in block.convolutions:
            features = convolve(features, weights[f"kernel_{index}"], weights[f"bias_{index}"], convolution)
            index += 1
        yield features


def convolve(features: Features, kernel: Features, bias: Features, convolution: Convolution) -> Features:
    """Return max(0, features * kernel + bias), where * is the cross-correlation with zeros beyond the border.

    Parameters
    ----------
    features : array of float32, (height, width, channels in)
        What is convolved.
    kernel : array of float32, (size, size, channels in, channels out)
        Rows, columns.
    bias : array of float32, (channels out,)
        Added at every place.
    convolution : Convolution
        Size, stride and padding.

    Returns
    -------
    array of float32, (rows, columns, channels out)
    """
    size, stride, padding = convolution.size, convolution.stride, convolution.padding
    height, width, _ = features.shape
    rows, columns = ((side + 2 * padding - size) // stride + 1 for side in (height, width))
    matrix = kernel.reshape(-1, kernel.shape[-1])
    result = np.empty((rows, columns, kernel.shape[-1]), np.float32)
    step = max(1, BAND_VALUES // (columns * len(matrix)))
    for start in range(0, rows, step):
        band = result[start : start + step]
        top = start * stride - padding
        bottom = top + (len(band) - 1) * stride + size
        beyond = ((max(-top, 0), max(bottom - height, 0)), (padding, padding), (0, 0))
        padded = np.pad(features[max(top, 0) : bottom], beyond)
        patches = sliding_window_view(padded, (size, size), axis=(0, 1))[::stride, ::stride]
        # (row, column, channel, y, x) to the order of the kernel's own axes; the reshape copies.
        np.matmul(patches.transpose(0, 1, 3, 4, 2).reshape(-1, len(matrix)), matrix, out=band.reshape(-1, len(bias)))
        band += bias
        np.maximum(band, 0, out=band)
    return result


def pool(features: Features, size: int) -> Features:
    """Return the maximum over every window of size x size pixels that lies inside, at every second row and column.

    Parameters
    ----------
    features : array of float32, (height, width, channels)
        At least `size` pixels a side.
    size : int
        Side of the window in pixels.

    Returns
    -------
    array of float32, (rows, columns, channels)
    """
    rows, columns = ((side - size) // 2 + 1 for side in features.shape[:2])
    result = np.zeros((rows, columns, features.shape[2]), np.float32)  # features are at least 0
    for y in range(size):
        for x in range(size):
            np.maximum(result, features[y : y + 2 * rows - 1 : 2, x : x + 2 * columns - 1 : 2], out=result)
    return result
