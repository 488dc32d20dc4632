"""The subject of a photo, found by OpenCV alone: in, a photo; out, a mask of what the rest may step back from.

Nothing was learned from photos of things: what is told apart is what photographers do. A subject differs in colour from its
surroundings, it is not of what touches the borders, and it is near the middle. That gives two guesses; from each GrabCut (Rother,
Kolmogorov and Blake 2004) finds what belongs together, by colour, by colour without texture, and by texture; what most of them find
is the subject.
"""

from __future__ import annotations

import io
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from graphstipple import _core
from graphstipple._errors import MissingPackageError
from graphstipple._inputs import ImageLike, is_pil, path_to_read, read_photo
from graphstipple._interruptible import run
from graphstipple.options import Options

if TYPE_CHECKING:
    from PIL import Image

Map: TypeAlias = "npt.NDArray[np.float32]"
Rgb: TypeAlias = "npt.NDArray[np.uint8]"

NONE_FOUND = "no subject was found, so the photo is drawn as it is"
"""What is said where there is none."""

SIDE = 320
"""Longest side at which it is looked for: smaller loses legs, larger takes longer and finds no more."""

SEGMENTS = 300
"""Superpixels, about."""

SAME = 10.0
"""Difference of colours (CIE Lab) at which two superpixels count as of one surface, as in saliency optimization."""

LEAST, MOST = 0.02, 0.9
"""Shares of a photo that a subject takes: less is a speck, more leaves nothing to step back."""

AGREEMENT = 0.55
"""How far those that look for it must agree: the mean overlap (intersection over union) of each with what most find."""

EDGE = 4.0
"""How far colours on the two sides of its edge must be apart (CIE Lab), at the median: a gradient has no edge anywhere."""

CLEARLY = 0.8
"""From where on, between the threshold of a guess and 1, GrabCut takes the guess for sure."""

HARDLY = 0.25
"""Below which share of that threshold it takes the rest for sure."""

_lock = threading.Lock()
"""OpenCV's random numbers and its number of threads are the process's."""


def find_subject(image: ImageLike, *, background: str = "white") -> Map | None:
    """Return a mask of a photo's subject, by OpenCV alone: no model is needed. It is what ``draw(subject="auto")`` finds.

    It finds what differs in colour and texture from its surroundings and is near the middle. How well it does so is in
    docs/howto/subject.md, with how to name a program that has learned what things look like.

    Parameters
    ----------
    image : path, bytes, PIL image or array
        As for `draw`.
    background : str
        What lies under transparent pixels: "white", "black", "#rrggbb" or "#rgb".

    Returns
    -------
    ndarray of float32, (height, width), or None
        In [0, 1], 1 where the subject is; None if none was found.

    Raises
    ------
    InvalidInputError, ImageFileError
        As `draw`.
    MissingPackageError
        If OpenCV, or its contributed modules, are not installed.
    """
    reading = _core.Reading(Options(background=background)._checked.background, None, _core.MAX_PIXELS, False)
    photo, _, _ = read_photo(image, reading)
    mask = found(rgb_of(image, photo, reading))
    if mask is None:
        return None
    return photo.with_subject(as_photo(mask)).subject


def of_file(file: str | bytes, photo: _core.Photo, reading: _core.Reading) -> tuple[_core.Photo | None, str | None]:
    """Return a mask for the command line, of a file given by its path or all its bytes, and what is to be said of it."""
    mask = found(rgb_of(file, photo, reading))
    return (None, NONE_FOUND) if mask is None else (as_photo(mask), None)


def as_photo(mask: Map) -> _core.Photo:
    """Return a mask for the core."""
    return _core.Photo(np.ascontiguousarray(mask, np.float32), (mask.shape[1], mask.shape[0]), 1)


def rgb_of(image: ImageLike, photo: _core.Photo, reading: _core.Reading) -> Rgb:
    """Return a photo's colours (height, width, 3) on the raster of its luma, upright, laid on the background.

    Of one that Pillow does not read, its greys.
    """
    luma = photo.luma
    size = (luma.shape[1], luma.shape[0])
    samples = None
    with suppress(Exception):
        # Whatever is wrong with it, the core has read it: its greys are there.
        samples = _samples(image)
    if samples is None or abs(np.log(samples.shape[0] * size[0] / (samples.shape[1] * size[1]))) > 0.1:
        return np.repeat(_core.luma_to_u8(luma)[:, :, np.newaxis], 3, axis=2)
    if samples.shape[:2] == luma.shape:
        return _on_background(samples, reading.background)
    import cv2  # noqa: PLC0415  # a drawing does not need it

    return _on_background(_channels(cv2.resize(samples, size, interpolation=cv2.INTER_AREA)), reading.background)


def _channels(samples: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return samples if samples.ndim == 3 else samples[:, :, np.newaxis]


def _samples(image: ImageLike) -> npt.NDArray[np.uint8]:
    """Return an image's samples (height, width, 1 to 4 channels) in 8 bits, upright."""
    from graphstipple._pillow import samples_of  # noqa: PLC0415  # a drawing does not need Pillow

    if is_pil(image):
        return _in_bytes(*_of_pillow(image, samples_of))
    if hasattr(image, "__array__"):
        array = _channels(np.asarray(image))
        return array.astype(np.uint8) * np.uint8(255) if array.dtype == np.bool_ else _in_bytes(array, False)
    from PIL import Image  # noqa: PLC0415

    source = io.BytesIO(image) if isinstance(image, bytes) else path_to_read(image)  # type: ignore[arg-type]  # no PIL image
    with Image.open(source) as opened:
        return _in_bytes(*_of_pillow(opened, samples_of))


def _of_pillow(image: Image.Image, samples_of: Callable[..., Any]) -> tuple[npt.NDArray[Any], bool]:
    if image.mode == "CMYK":
        image = image.convert("RGB")
    samples, said = samples_of(image)
    return samples, said[0]


def _in_bytes(samples: npt.NDArray[Any], is_inks: bool) -> npt.NDArray[np.uint8]:
    assert not is_inks
    if samples.dtype == np.uint8:
        return np.ascontiguousarray(samples)
    if samples.dtype == np.uint16:
        return (samples >> 8).astype(np.uint8)
    return np.rint(np.asarray(samples, np.float64) * 255).astype(np.uint8)


def _on_background(samples: npt.NDArray[np.uint8], background: tuple[int, int, int]) -> Rgb:
    colours = samples[:, :, :3] if samples.shape[2] >= 3 else np.repeat(samples[:, :, :1], 3, axis=2)
    if samples.shape[2] % 2:
        return np.ascontiguousarray(colours)
    opacity = samples[:, :, -1:].astype(np.float32) / 255
    mixed = colours * opacity + np.asarray(background, np.float32) * (1 - opacity)
    return np.rint(mixed).astype(np.uint8)


def found(rgb: Rgb) -> Map | None:
    """Return a mask of the subject at the size at which it was looked for, in [0, 1]; None if there is none.

    It depends on the colours alone: not on threads, nor on what OpenCV was asked for before.
    """
    cv2 = _opencv()
    return run(lambda: _found(cv2, rgb))


def _opencv() -> Any:
    """Return OpenCV, with its contributed modules."""
    try:
        import cv2  # noqa: PLC0415  # a drawing does not need it
    except ImportError as error:
        raise MissingPackageError(f"subject auto needs OpenCV ({error}): pip install opencv-contrib-python-headless") from error
    if not hasattr(cv2, "ximgproc"):
        raise MissingPackageError(
            "subject auto needs the contributed modules of OpenCV, which the installed one lacks: pip uninstall the other wheels "
            "of OpenCV, then pip install --force-reinstall opencv-contrib-python-headless"
        )
    return cv2


@contextmanager
def _alone(cv2: Any) -> Iterator[None]:
    """Have OpenCV's random numbers begin anew, on one thread."""
    with _lock:
        before = cv2.getNumThreads()
        cv2.setNumThreads(1)
        try:
            yield
        finally:
            cv2.setNumThreads(before)


def _found(cv2: Any, rgb: Rgb) -> Map | None:
    height, width = rgb.shape[:2]
    scale = SIDE / max(height, width)
    if min(height, width) * min(scale, 1.0) < 16:
        return None
    with _alone(cv2):
        if scale < 1:
            size = (max(1, round(width * scale)), max(1, round(height * scale)))
            rgb = cv2.resize(rgb, size, interpolation=cv2.INTER_AREA)
        guesses = _guesses(cv2, rgb)
        if guesses is None:
            return None
        looks = _looks(cv2, rgb)
        cuts = [cut for guess in guesses for look in looks if (cut := _cut(cv2, look, guess)) is not None]
        if not cuts:
            return None
        votes = np.mean(cuts, axis=0, dtype=np.float32)
        mask = _whole(cv2, np.asarray(votes >= 0.5, np.bool_))
        share = float(mask.mean())
        agreement = np.mean([_overlap(cut >= 0.5, mask) for cut in cuts])
        if not LEAST <= share <= MOST or agreement < AGREEMENT or _edge(cv2, rgb, mask) < EDGE:
            return None
        # The edge follows the colours; the core refines it by the whole photo.
        guide = rgb.astype(np.float32) / 255
        refined: Map = np.clip(cv2.ximgproc.guidedFilter(guide, mask.astype(np.float32), 3, 1e-3), 0.0, 1.0)
        return refined


def _overlap(one: npt.NDArray[np.bool_], other: npt.NDArray[np.bool_]) -> float:
    either = int(np.count_nonzero(one | other))
    return int(np.count_nonzero(one & other)) / max(1, either)


def _edge(cv2: Any, rgb: Rgb, mask: npt.NDArray[np.bool_]) -> float:
    """Return how far the colours around its edge are apart on the two sides, as the median along it."""
    lab = cv2.cvtColor(rgb.astype(np.float32) / 255, cv2.COLOR_RGB2LAB)
    inside = mask.astype(np.float32)
    means, weights = [], []
    for side in (inside, 1 - inside):
        weight = cv2.GaussianBlur(side, (0, 0), 4)
        means.append(cv2.GaussianBlur(lab * side[:, :, np.newaxis], (0, 0), 4) / np.maximum(weight, 1e-3)[:, :, np.newaxis])
        weights.append(weight)
    near = np.minimum(*weights) > 0.35
    return float(np.median(np.linalg.norm(means[0] - means[1], axis=2)[near])) if near.any() else 0.0


def _stretched(map_: npt.NDArray[Any]) -> Map:
    map_ = map_ - map_.min()
    return (map_ / max(float(map_.max()), 1e-9)).astype(np.float32)


def _guesses(cv2: Any, rgb: Rgb) -> list[Map] | None:
    """Return where the subject may be, by each way to tell; None for a photo of one colour."""
    height, width = rgb.shape[:2]
    lab = cv2.cvtColor(rgb.astype(np.float32) / 255, cv2.COLOR_RGB2LAB)
    if float(np.ptp(lab.reshape(-1, 3), axis=0).max()) < 3.0:
        return None
    stands_out, of_border = _against_the_border(cv2, lab)
    y, x = np.mgrid[0:height, 0:width]
    middle = np.exp(-(((x + 0.5) / width - 0.5) ** 2) / (2 * 0.3**2) - ((y + 0.5) / height - 0.53) ** 2 / (2 * 0.35**2))
    return [_stretched(guess) for guess in (stands_out + middle, (1.2 - of_border) * middle)]


def _against_the_border(cv2: Any, lab: Map) -> tuple[Map, Map]:
    """Return what stands out of its surroundings, and how surely parts belong to the border, both in [0, 1].

    After Zhu, Liang, Wei and Sun, "Saliency Optimization from Robust Background Detection" (2014): a superpixel belongs to the rest
    if what is of its surface touches the borders more than an object would.
    """
    height, width = lab.shape[:2]
    smooth = cv2.GaussianBlur(lab, (0, 0), 1.5)
    ids, count = _superpixels(cv2, smooth)
    pixels = np.bincount(ids.ravel(), minlength=count).astype(np.float64)

    def mean(values: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
        return np.bincount(ids.ravel(), values.ravel(), count) / pixels

    y, x = np.mgrid[0:height, 0:width]
    colour = np.stack([mean(smooth[:, :, channel]) for channel in range(3)], axis=1)
    place = np.stack([mean(x / width), mean(y / height)], axis=1)
    differs = np.linalg.norm(colour[:, None] - colour[None], axis=2)
    apart = np.linalg.norm(place[:, None] - place[None], axis=2)
    touching = np.zeros((count, count), bool)
    for one, other in ((ids[:, :-1], ids[:, 1:]), (ids[:-1], ids[1:])):
        touching[one, other] = True
    touching |= touching.T
    np.fill_diagonal(touching, val=False)
    on_border = np.zeros(count, bool)
    on_border[np.concatenate([ids[0], ids[-1], ids[:, 0], ids[:, -1]])] = True

    # What lies between two superpixels, along the way that changes least; the borders are one surface.
    way = np.where(touching | (on_border[:, None] & on_border[None]), differs, np.inf)
    np.fill_diagonal(way, 0.0)
    for by in range(count):
        np.minimum(way, way[:, by : by + 1] + way[by], out=way)
    surface = np.exp(-(way**2) / (2 * SAME**2))
    length = surface[:, on_border].sum(axis=1)
    of_border = 1 - np.exp(-(length**2) / (2 * surface.sum(axis=1)))
    apart_from_rest = (differs * np.exp(-(apart**2) / (2 * 0.4**2)) * of_border[None]).sum(axis=1)
    apart_from_rest /= max(float(apart_from_rest.max()), 1e-9)

    # Those that touch and look alike get alike values.
    like = np.where(touching, np.exp(-(differs**2) / (2 * SAME**2)) + 0.1, 0.0)
    system = np.diag(like.sum(axis=1) + 5 * of_border + apart_from_rest + 1e-9) - like
    return _stretched(np.linalg.solve(system, apart_from_rest)[ids]), of_border[ids].astype(np.float32)


def _superpixels(cv2: Any, lab: Map) -> tuple[npt.NDArray[np.int32], int]:
    in_bytes = np.clip(lab * (2.55, 1.0, 1.0) + (0.0, 128.0, 128.0), 0, 255).astype(np.uint8)
    side = max(8, round((lab.shape[0] * lab.shape[1] / SEGMENTS) ** 0.5))
    slic = cv2.ximgproc.createSuperpixelSLIC(in_bytes, cv2.ximgproc.SLIC, side, 12.0)
    slic.iterate(10)
    slic.enforceLabelConnectivity(25)
    _, numbered = np.unique(slic.getLabels(), return_inverse=True)
    ids = np.asarray(numbered, np.int32).reshape(lab.shape[:2])
    return ids, int(ids.max()) + 1


def _looks(cv2: Any, rgb: Rgb) -> list[Rgb]:
    """Return what GrabCut is shown: the colours, the colours without texture, and lightness, colour and texture."""
    bgr = cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR)
    lab = cv2.cvtColor(rgb, cv2.COLOR_RGB2LAB).astype(np.float32)
    light = lab[:, :, 0]
    texture = cv2.GaussianBlur(np.abs(light - cv2.GaussianBlur(light, (0, 0), 2)), (0, 0), 4)
    mixed = np.stack([light, (lab[:, :, 1] + lab[:, :, 2]) / 2, 6 * texture], axis=2)
    return [bgr, cv2.pyrMeanShiftFiltering(bgr, 6, 18), np.clip(mixed, 0, 255).astype(np.uint8)]


def _cut(cv2: Any, look: Rgb, guess: Map) -> Map | None:
    """Return what GrabCut makes of a guess; None where it has nothing to begin with."""
    threshold = cv2.threshold(np.rint(guess * 255).astype(np.uint8), 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)[0] / 255
    mask = np.where(guess >= threshold, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
    mask[guess < HARDLY * threshold] = cv2.GC_BGD
    mask[guess >= threshold + CLEARLY * (1 - threshold)] = cv2.GC_FGD
    cv2.setRNGSeed(0)
    try:
        cv2.grabCut(look, mask, None, np.zeros((1, 65)), np.zeros((1, 65)), 5, cv2.GC_INIT_WITH_MASK)
    except cv2.error:
        return None
    found: Map = np.isin(mask, (cv2.GC_FGD, cv2.GC_PR_FGD)).astype(np.float32)
    return found


def _whole(cv2: Any, mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return a mask without specks and small holes."""
    count, ids, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    areas = stats[:, cv2.CC_STAT_AREA].copy()
    areas[0] = 0
    whole = (areas >= 0.05 * areas.max())[ids] & mask if count > 1 else mask
    count, ids, stats, _ = cv2.connectedComponentsWithStats((~whole).astype(np.uint8))
    areas = stats[:, cv2.CC_STAT_AREA]
    filled: npt.NDArray[np.bool_] = whole | ((areas < 0.002 * mask.size)[ids] & ~whole)
    return filled
