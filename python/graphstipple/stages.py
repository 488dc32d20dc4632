"""The stages of the method, each callable alone on arrays.

In the order of the pipeline: `tone`, `emphasize`, `importance`, `lattice`, `lattice_labels` (lattice, cell means, diffusion and
node budget in one), `relax`, `triangulate`, `cells`, `grounds`, `diffuse`, `refine`,
`split`, `clean`, `stipple`, `components`, `outline`. They are the functions
that `graphstipple.draw` runs. `colour` stands beside `tone`. `offset` is what plots and rules stand on.

Points are (n, 2) as x, y in pixels, edges (m, 2) as node numbers, fields (height, width) in [0, 1]. Other array types are
converted by copying. Every function raises `InvalidInputError` for arrays that break its rules.
"""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from graphstipple import _core
from graphstipple._errors import InvalidInputError
from graphstipple._inputs import ImageLike, read_colour, read_luma, unmasked
from graphstipple.drawing import RecordedOptions, Region, known, stipple_array
from graphstipple.options import Options, Published

__all__ = [
    "Cells",
    "Lattice",
    "LatticeLabels",
    "Outline",
    "Refined",
    "Stippled",
    "cells",
    "clean",
    "colour",
    "components",
    "diffuse",
    "emphasize",
    "grounds",
    "importance",
    "lattice",
    "lattice_labels",
    "offset",
    "outline",
    "owners",
    "refine",
    "relax",
    "samples_per_pixel",
    "split",
    "stipple",
    "tone",
    "triangulate",
]


_OURS = Options()
"""Where the stages' parameters have their defaults from."""


class Lattice(NamedTuple):
    """A regular graph."""

    sites: npt.NDArray[np.float64]
    """Position of every node, (n, 2)."""
    edges: npt.NDArray[np.uint32]
    """Every edge once, (m, 2), lower node first."""


class LatticeLabels(NamedTuple):
    """A lattice diffused on importance."""

    sites: npt.NDArray[np.float64]
    """Position of every lattice node, (n, 2)."""
    labels: npt.NDArray[np.uint8]
    """1 for every node that is kept, (n,)."""
    factor: float
    """The factor on the importance that meets the node budget; 1 without one."""


class Cells(NamedTuple):
    """What the samples say of every site's Voronoi cell."""

    areas: npt.NDArray[np.float64]
    """Area in px^2, (n,)."""
    centroids: npt.NDArray[np.float64]
    """Mean position of the samples, (n, 2); the site itself if it owns none."""
    means: npt.NDArray[np.float32]
    """Mean of the field over the samples, (n,); its bilinear value at a site that owns none; empty without a field."""
    counts: npt.NDArray[np.uint32]
    """Number of samples, (n,)."""


class Refined(NamedTuple):
    """Labels refined."""

    labels: npt.NDArray[np.uint8]
    """0 black, 1 white, (n,)."""
    shift: float
    """What was added for white so that they have their mean; a drawing's is ``stats["tone_shift"]``."""


class Stippled(NamedTuple):
    """Labels with the dots of smooth parts, and how nodes are drawn."""

    labels: npt.NDArray[np.uint8]
    """0 black, 1 white, (n,): in smooth parts the ground, and dots of the other label, none beside another."""
    places: npt.NDArray[np.float64]
    """Where every node is drawn, (n, 2) in pixels: dots and the nodes around them have left their sites."""
    areas: npt.NDArray[np.float64]
    """Area of every node's mark in px^2, (n,): a dot's is the ink that it stands for."""


class Outline(NamedTuple):
    """The marks of a labelled graph."""

    stipples: npt.NDArray[np.void]
    """Structured array with x, y, radius and ink, as `graphstipple.Drawing.stipples`."""
    regions: list[Region]
    """As `graphstipple.Drawing.regions`."""


def tone(image: ImageLike, options: Options | RecordedOptions | None = None) -> npt.NDArray[np.float32]:
    """Return the tone of an image: its luma (Rec. 601, of sRGB-encoded values) under `linear`, `gamma`, `contrast` and `invert`.

    Parameters
    ----------
    image : path, PIL image or array
        As for `graphstipple.draw`.
    options : Options, optional
        By default ``Options()``, which leaves the luma as it is.

    Returns
    -------
    ndarray of float32, (height, width)
        0 black, 1 white.

    Raises
    ------
    InvalidInputError, ImageFileError
        As `graphstipple.draw`.
    """
    options = known(options)
    return _core.adjust(read_luma(image, options._checked.background), options._checked)


def colour(image: ImageLike, options: Options | RecordedOptions | None = None) -> npt.NDArray[np.float32]:
    """Return the colour of an image: sRGB-encoded red, green and blue, upright, transparent parts laid on the background.

    The luma that `tone` begins with is its Rec. 601 luma, up to rounding. Values are those of the photo: no option changes them.

    Parameters
    ----------
    image : path, PIL image or array
        As for `graphstipple.draw`.
    options : Options, optional
        By default ``Options()``; only `background` is used.

    Returns
    -------
    ndarray of float32, (height, width, 3)
        In [0, 1].

    Raises
    ------
    InvalidInputError, ImageFileError
        As `graphstipple.draw`.

    Examples
    --------
    >>> import numpy as np, graphstipple as gs
    >>> gs.stages.colour(np.array([[[255, 0, 51, 255], [0, 0, 0, 0]]], np.uint8)).round(3).tolist()
    [[[1.0, 0.0, 0.20000000298023224], [1.0, 1.0, 1.0]]]
    """
    return read_colour(image, known(options)._checked.background)


def emphasize(tone: npt.ArrayLike, options: Options | RecordedOptions | None = None) -> npt.NDArray[np.float32]:
    """Return the tone with details emphasized as `sharpen` and `local_contrast` say, at the spacing of the nodes.

    Parameters
    ----------
    tone : array_like, (height, width)
        In [0, 1].
    options : Options, optional
        By default ``Options()``; the node budget gives the spacing.

    Returns
    -------
    ndarray of float32, (height, width)
    """
    return _core.emphasize(_field("tone", tone), known(options)._checked)


def importance(
    tone: npt.ArrayLike, map_: npt.ArrayLike, options: Options | RecordedOptions | None = None, *, is_saliency: bool = True
) -> npt.NDArray[np.float32]:
    """Return the importance that the nodes are chosen by: a map with the photo's detail mixed in (docs/method.md).

    Parameters
    ----------
    tone : array_like, (height, width)
        In [0, 1], before `emphasize`.
    map_ : array_like, (rows, columns)
        In [0, 1]; resampled to the tone.
    options : Options, optional
        By default ``Options()``; `detail`, `floor`, `midtones`, the emphasis and the node budget count.
    is_saliency : bool
        Whether the map is a saliency map, which is mixed with the detail, or a map of one's own, which is a factor on it.

    Returns
    -------
    ndarray of float32, (height, width)
    """
    return _core.mixed_importance(_field("tone", tone), _field("map_", map_), not is_saliency, known(options)._checked)


def lattice(
    width: int, height: int, density: float = 1.0, kind: Literal["hexagonal", "square"] = _OURS.published.lattice
) -> Lattice:
    """Return the regular first graph over a canvas (docs/method.md).

    Parameters
    ----------
    width, height : int
        Canvas in pixels.
    density : float
        Nodes per pixel, above 0, at most 16.
    kind : {"hexagonal", "square"}
        Six or four neighbours a node.

    Returns
    -------
    Lattice
    """
    options = Options(published=Published(lattice=kind, density=density))
    return Lattice(*_core.lattice(_count("width", width), _count("height", height), options._checked))


def lattice_labels(importance: npt.ArrayLike, options: Options | RecordedOptions | None = None) -> LatticeLabels:
    """Return the lattice and which of its nodes the importance keeps under the node budget (docs/method.md, first diffusion).

    Parameters
    ----------
    importance : array_like, (height, width)
        In [0, 1]; its size is the canvas.
    options : Options, optional
        The node budget and, of `published`, the lattice and the parameters of the diffusion.

    Returns
    -------
    LatticeLabels
    """
    return LatticeLabels(*_core.lattice_labels(_field("importance", importance), known(options)._checked))


def samples_per_pixel(density: float) -> int:
    """Return how many samples a pixel, along one axis, give every cell of a lattice of this density at least four.

    Parameters
    ----------
    density : float
        Nodes per pixel.

    Returns
    -------
    int
    """
    return _core.samples_per_pixel(density)


def cells(sites: npt.ArrayLike, width: int, height: int, field: npt.ArrayLike | None = None, samples_per_pixel: int = 2) -> Cells:
    """Return areas, centroids and field means of the sites' Voronoi cells, by a raster pass (docs/method.md).

    Parameters
    ----------
    sites : array_like, (n, 2)
        Positions inside the canvas.
    width, height : int
        Canvas in pixels.
    field : array_like, (height, width), optional
        Values in [0, 1] to average.
    samples_per_pixel : int
        Samples a pixel along one axis, 1 to 16.

    Returns
    -------
    Cells
    """
    values = None if field is None else _field("field", field)
    samples = _count("samples_per_pixel", samples_per_pixel)
    return Cells(*_core.cells(_sites(sites), _count("width", width), _count("height", height), values, samples))


def owners(sites: npt.ArrayLike, width: int, height: int, samples_per_pixel: int = 1) -> npt.NDArray[np.uint32]:
    """Return the nearest site of every sample of a grid (docs/method.md).

    Parameters
    ----------
    sites : array_like, (n, 2)
        Positions inside the canvas.
    width, height : int
        Canvas in pixels.
    samples_per_pixel : int
        Samples a pixel along one axis, 1 to 16; sample (column, row) lies at ((column + 0.5) / s, (row + 0.5) / s).

    Returns
    -------
    ndarray of uint32, (height * s, width * s)
    """
    samples = _count("samples_per_pixel", samples_per_pixel)
    return _core.owners(_sites(sites), _count("width", width), _count("height", height), samples)


def relax(sites: npt.ArrayLike, width: int, height: int, steps: int = 1, samples_per_pixel: int = 2) -> npt.NDArray[np.float64]:
    """Return the sites after Lloyd steps: each moves every site to the centroid of its cell (docs/method.md).

    Parameters
    ----------
    sites : array_like, (n, 2)
        Positions inside the canvas.
    width, height : int
        Canvas in pixels.
    steps : int
        How often.
    samples_per_pixel : int
        As for `cells`.

    Returns
    -------
    ndarray of float64, (n, 2)
    """
    samples = _count("samples_per_pixel", samples_per_pixel)
    canvas = _count("width", width), _count("height", height)
    return _core.relax(_sites(sites), *canvas, _count("steps", steps), samples)


def triangulate(sites: npt.ArrayLike, width: int, height: int) -> npt.NDArray[np.uint32]:
    """Return the Delaunay edges of sites, correct to the canvas border (docs/method.md).

    Parameters
    ----------
    sites : array_like, (n, 2)
        Different positions inside the canvas, not all in one line.
    width, height : int
        Canvas in pixels. Pairs of sites whose cells touch only outside it are not neighbours.

    Returns
    -------
    ndarray of uint32, (m, 2)
        Every edge once, lower node first.
    """
    return _core.triangulate(_sites(sites), _count("width", width), _count("height", height))


def diffuse(
    sites: npt.ArrayLike,
    edges: npt.ArrayLike,
    values: npt.ArrayLike,
    *,
    areas: npt.ArrayLike | None = None,
    alpha: Literal["tonal", "dynamic"] | float = _OURS.published.alpha,
    shading: float = _OURS.shading,
    k1: float = _OURS.published.k1,
    k2: float = _OURS.published.k2,
    base: float = _OURS.published.base,
    detail_gain: float = _OURS.published.detail_gain,
    hops: int = _OURS.published.hops,
    order: Literal["rows", "global"] = _OURS.published.order,
) -> npt.NDArray[np.uint8]:
    """Return a label for every node by priority error diffusion (docs/method.md).

    Parameters
    ----------
    sites : array_like, (n, 2)
        Positions in pixels.
    edges : array_like, (m, 2)
        Every edge once, in either direction.
    values : array_like, (n,)
        Starting values, finite; tone lies in [0, 1].
    areas : array_like, (n,), optional
        Cell area of every node in px^2, for errors that are weighted by area; without, they count by their value.
    shading
        As in `graphstipple.Options`.
    alpha, k1, k2, base, detail_gain, hops, order
        As in `graphstipple.Published`. Rows are nodes with consecutive numbers.

    Returns
    -------
    ndarray of uint8, (n,)
        0 black, 1 white.
    """
    published = Published(alpha=alpha, k1=k1, k2=k2, base=base, detail_gain=detail_gain, hops=hops, order=order)
    options = Options(shading=shading, published=published)
    starting = _array("values", values, np.float32, 1)
    cell_areas = None if areas is None else _array("areas", areas, np.float64, 1)
    return _core.diffuse(_sites(sites), _edges(edges), starting, cell_areas, options._checked)


def refine(
    edges: npt.ArrayLike,
    tones: npt.ArrayLike,
    labels: npt.ArrayLike,
    *,
    areas: npt.ArrayLike | None = None,
    grounds: npt.ArrayLike | None = None,
    sweeps: int = _OURS.refine,
    crispness: float = _OURS.crispness,
    cohesion: float = _OURS.cohesion,
    mean: float | None = None,
    tone_tolerance: float | None = _OURS.tone_tolerance,
) -> Refined:
    """Return labels that follow the tones of nodes and their neighbours (docs/method.md).

    Parameters
    ----------
    edges : array_like, (m, 2)
        Every edge once.
    tones : array_like, (n,)
        Tone of every node, as diffused.
    labels : array_like, (n,)
        0 black, 1 white: what the diffusion gave.
    areas : array_like, (n,), optional
        Cell area of every node in px^2, for the mean; without, all are alike.
    grounds : array_like, (n,), optional
        Those of smooth parts, by `grounds`: labels there stay, and count nothing in the mean. Their tones are to be 0 or 1, as the
        ground is.
    sweeps, crispness, cohesion, tone_tolerance
        As `Options.refine`, `crispness`, `cohesion` and `tone_tolerance`. Nodes are asked in blocks of consecutive numbers.
    mean : float, optional
        What the mean label should be, by area, 0 to 1; by default as it comes.

    Returns
    -------
    Refined
        The labels and the shift that gave them their mean.
    """
    options = Options(refine=sweeps, crispness=crispness, cohesion=cohesion, tone_tolerance=tone_tolerance)
    values = _array("tones", tones, np.float32, 1)
    cell_areas = np.ones(len(values)) if areas is None else _array("areas", areas, np.float64, 1)
    smooth = None if grounds is None else _array("grounds", grounds, np.uint8, 1)
    given = _array("labels", labels, np.uint8, 1)
    return Refined(*_core.refine(_edges(edges), values, given, (cell_areas, smooth), mean, options._checked))


def split(edges: npt.ArrayLike, tones: npt.ArrayLike, labels: npt.ArrayLike, most: int = _OURS.split) -> npt.NDArray[np.uint8]:
    """Return the labels with dots taken apart that fused by chance (docs/method.md).

    Parameters
    ----------
    edges : array_like, (m, 2)
        Every edge once.
    tones : array_like, (n,)
        Tone of every node, as diffused.
    labels : array_like, (n,)
        0 black, 1 white: what the diffusion gave.
    most : int
        As `Options.split`: components of 2 to so many nodes are taken apart.

    Returns
    -------
    ndarray of uint8, (n,)
        As many of either label as before.
    """
    values = _array("tones", tones, np.float32, 1)
    return _core.split(_edges(edges), values, _array("labels", labels, np.uint8, 1), Options(split=most).split)


def grounds(
    sites: npt.ArrayLike, edges: npt.ArrayLike, tones: npt.ArrayLike, stippling: float = _OURS.stippling
) -> npt.NDArray[np.uint8]:
    """Return the ground of every node in a smooth part (docs/method.md).

    Parameters
    ----------
    sites : array_like, (n, 2)
        Position of every node in pixels.
    edges : array_like, (m, 2)
        Every edge once.
    tones : array_like, (n,)
        Tone of every node without emphasis, in [0, 1].
    stippling : float
        As `Options.stippling`: 0 nothing is smooth, 1 everything.

    Returns
    -------
    ndarray of uint8, (n,)
        0 black and 1 white in smooth parts, 2 in those with structure.
    """
    values = _array("tones", tones, np.float32, 1)
    return _core.grounds(_sites(sites), _edges(edges), values, Options(stippling=stippling)._checked)


def clean(edges: npt.ArrayLike, tones: npt.ArrayLike, labels: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """Return the labels without marks that lie wholly on pure white or pure black (docs/method.md).

    Parameters
    ----------
    edges : array_like, (m, 2)
        Every edge once.
    tones : array_like, (n,)
        Tone of every node without emphasis, in [0, 1]; within half a level of 8 bits of 0 or 1 it is pure.
    labels : array_like, (n,)
        0 black, 1 white.

    Returns
    -------
    ndarray of uint8, (n,)
        0 black, 1 white.
    """
    return _core.clean(_edges(edges), _array("tones", tones, np.float32, 1), _array("labels", labels, np.uint8, 1))


def stipple(
    sites: npt.ArrayLike,
    grounds: npt.ArrayLike,
    tones: npt.ArrayLike,
    width: int,
    height: int,
    *,
    labels: npt.ArrayLike,
    areas: npt.ArrayLike | None = None,
) -> Stippled:
    """Return the labels with dots in smooth parts, which carry what the ground lacks there (docs/method.md).

    Parameters
    ----------
    sites : array_like, (n, 2)
        Different positions inside the canvas, not all in one line.
    grounds : array_like, (n,)
        By `grounds`.
    tones : array_like, (n,)
        Tone of every node without emphasis, in [0, 1].
    width, height : int
        Canvas in pixels.
    labels : array_like, (n,)
        0 black, 1 white; what they are in smooth parts does not matter.
    areas : array_like, (n,), optional
        Cell area of every node in px^2; by default by `cells`.

    Returns
    -------
    Stippled
    """
    positions, canvas = _sites(sites), (_count("width", width), _count("height", height))
    cell_areas = cells(positions, width, height).areas if areas is None else _array("areas", areas, np.float64, 1)
    smooth, given = _array("grounds", grounds, np.uint8, 1), _array("labels", labels, np.uint8, 1)
    values = _array("tones", tones, np.float32, 1)
    return Stippled(*_core.stipple(positions, smooth, values, cell_areas, given, canvas))


def components(edges: npt.ArrayLike, labels: npt.ArrayLike) -> npt.NDArray[np.uint32]:
    """Return the connected component of equally labelled nodes that every node belongs to (docs/method.md).

    Parameters
    ----------
    edges : array_like, (m, 2)
        Every edge once.
    labels : array_like, (n,)
        Label of every node.

    Returns
    -------
    ndarray of uint32, (n,)
        Components are numbered in the order of their lowest nodes.
    """
    return _core.components(_edges(edges), _array("labels", labels, np.uint8, 1))


def outline(
    sites: npt.ArrayLike,
    labels: npt.ArrayLike,
    width: int,
    height: int,
    *,
    areas: npt.ArrayLike | None = None,
    tones: npt.ArrayLike | None = None,
    places: npt.ArrayLike | None = None,
    stipple_scale: float = _OURS.stipple_scale,
    stipple_min: float = _OURS.stipple_min,
    stipple_max: float | None = _OURS.stipple_max,
    irregularity: float = _OURS.irregularity,
    wobble: float = _OURS.wobble,
    edge: Literal["smooth", "inked", "torn"] = _OURS.edge,
    seed: int = _OURS.seed,
    tolerance: float = _OURS.tolerance,
) -> Outline:
    """Return the stipples and regions of labelled sites (docs/method.md).

    Parameters
    ----------
    sites : array_like, (n, 2)
        Different positions inside the canvas, not all in one line.
    labels : array_like, (n,)
        0 black, 1 white.
    width, height : int
        Canvas in pixels.
    areas : array_like, (n,), optional
        Cell area of every node in px^2; by default by `cells`.
    tones : array_like, (n,), optional
        Tone of every node, for boundaries that follow it; without, they cross edges at their midpoints.
    places : array_like, (n, 2), optional
        Where every node is drawn, by `stipple`; by default at its site. No triangle may be turned over.
    stipple_scale, stipple_min, stipple_max, irregularity, wobble, edge, seed, tolerance
        As in `Options`.

    Returns
    -------
    Outline
    """
    positions = _sites(sites)
    options = Options(
        stipple_scale=stipple_scale,
        stipple_min=stipple_min,
        stipple_max=stipple_max,
        irregularity=irregularity,
        wobble=wobble,
        edge=edge,
        seed=seed,
        tolerance=tolerance,
    )
    cell_areas = cells(positions, width, height).areas if areas is None else _array("areas", areas, np.float64, 1)
    values = _array("labels", labels, np.uint8, 1)
    canvas = _count("width", width), _count("height", height)
    followed = None if tones is None else _array("tones", tones, np.float32, 1)
    drawn_at = None if places is None else _array("places", places, np.float64, 2)
    stipples, regions = _core.outline((positions, drawn_at), values, cell_areas, followed, canvas, options._checked)
    return Outline(stipple_array(*stipples), [Region(*region) for region in regions])


def offset(
    polygons: Sequence[Sequence[npt.ArrayLike]], distance: float, *, tolerance: float = 0.01
) -> list[list[npt.NDArray[np.float64]]]:
    """Move areas out, or in, with round corners.

    Parameters
    ----------
    polygons : sequence of sequences of array-like of float, (n, 2)
        Areas that do not overlap: of each the exterior, whose signed area is positive where x runs right and y runs down, then its
        holes, whose areas are negative; first points are not repeated.
    distance : float
        How far, in the unit of the points; below 0 is in.
    tolerance : float
        How far rings may lie from where they would, in the same unit, above 0: points are left out for it.

    Returns
    -------
    list of lists of ndarray of float64, (n, 2)
        Areas likewise.
    """
    if not (np.isfinite(distance) and np.isfinite(tolerance) and tolerance > 0):
        raise InvalidInputError(
            f"distance is {distance!r} and tolerance {tolerance!r}, but they must be finite, and the tolerance above 0"
        )
    rings = [[_array("ring", ring, np.float64, 2) for ring in polygon] for polygon in polygons]
    return _core.offset(rings, float(distance), float(tolerance))


def _array(name: str, values: npt.ArrayLike, dtype: type[np.number[Any]], dimensions: int) -> npt.NDArray[Any]:
    """Return the values as a C-contiguous array; what does not fit the type is an error, not a wrapped number."""
    array = unmasked(values, name)
    if array.dtype.kind not in "biuf" and array.size:
        raise InvalidInputError(f"{name} has values of type {array.dtype}, but they must be numbers")
    if array.ndim != dimensions:
        raise InvalidInputError(f"{name} has the shape {array.shape}, but it must have {dimensions} dimension(s)")
    if issubclass(dtype, np.integer) and array.size:
        limit = np.iinfo(dtype).max
        if array.dtype.kind == "f" or array.min() < 0 or array.max() > limit:
            raise InvalidInputError(f"{name} must hold whole numbers from 0 to {limit}")
    return np.ascontiguousarray(array, dtype)


def _field(name: str, values: npt.ArrayLike) -> npt.NDArray[np.float32]:
    return _array(name, values, np.float32, 2)


def _sites(values: npt.ArrayLike) -> npt.NDArray[np.float64]:
    return _array("sites", values, np.float64, 2)


def _edges(values: npt.ArrayLike) -> npt.NDArray[np.uint32]:
    return _array("edges", values, np.uint32, 2)


def _count(name: str, value: int) -> int:
    """Return a whole number that Rust can take as an unsigned one; its range is checked there."""
    try:
        count = operator.index(value)
    except TypeError:
        count = -1
    if not 0 <= count < 2**31:
        raise InvalidInputError(f"{name} is {value!r}, but it must be a whole number of at least 0")
    return count
