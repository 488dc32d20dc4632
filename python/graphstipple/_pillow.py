"""Pillow: its images as samples, and the files that it reads and the core does not.

The core asks (`rust/py/src/fallback.rs`) for files that it calls not supported, never for those that it calls damaged. The
command that pip installs does so too; the native binary has nobody to ask.
"""

from __future__ import annotations

import io
import re
import struct
import warnings
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt
import PIL
from PIL import Image, ImageOps, UnidentifiedImageError

from graphstipple import _core
from graphstipple._errors import ImageFileError, InvalidInputError

if TYPE_CHECKING:
    from collections.abc import Sequence

FORMATS = ("AVIF", "BMP", "DDS", "DIB", "GIF", "HEIF", "JPEG", "JPEG2000", "PCX", "PNG", "PPM", "QOI", "SGI", "SUN", "TIFF", "WEBP")
"""What Pillow is asked for, as it names them."""

NAMES = {"JPEG2000": "JPEG 2000", "PPM": "PNM", "DIB": "BMP", "HEIF": "HEIC", "WEBP": "WebP", "MPO": "JPEG"}
"""Names of formats in messages, where Pillow has others."""

OF_THE_CORE = ("JPEG", "PNG", "TIFF", "WebP")
"""Formats that the core reads: what it does not support of them, Pillow may not support either."""

OF_DAMAGE = re.compile("truncated|broken data|premature|unexpected end|end of file", re.IGNORECASE)
"""What Pillow says of files that end too soon."""

EXIF, INTEROPERABILITY, COLOUR_SPACE = 0x8769, 0xA005, 0xA001
"""Tags of EXIF data."""

SUBFILE, REDUCED_OR_MASK = 254, 0b101
"""The tag that says what an image of a TIFF is, and the bits of those that are not the picture."""

Samples: TypeAlias = "npt.NDArray[np.uint8] | npt.NDArray[np.uint16] | npt.NDArray[np.float32]"

Said: TypeAlias = "tuple[bool, bytes | None, float | None, Sequence[Sequence[float]] | None, bool]"
"""What a file says of its samples: inks, profile, gamma, chromaticities, Adobe RGB."""

NOTHING: Said = (False, None, None, None, False)


def read(file: str | bytes, reading: _core.Reading, colour: bool = False) -> tuple[_core.Photo, str] | None:
    """Return the image of a file, given by its path or all its bytes, and what has read it; None if Pillow does not know it.

    The photo keeps its colour if that is asked for.

    Raises
    ------
    ImageFileError
        If it is damaged, cut short or too large.
    """
    with suppress(ImportError):
        import pillow_heif  # noqa: PLC0415  # whoever has it wants it used

        pillow_heif.register_heif_opener()
    Image.init()
    name = ""
    formats = [name for name in FORMATS if name in Image.OPEN]
    try:
        with warnings.catch_warnings():
            # Of sizes, the core has a rule of its own; of the rest, it tells in one sentence.
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(file) if isinstance(file, bytes) else file, formats=formats) as image:
                name = NAMES.get(image.format or "", image.format or "")
                _seek_the_picture(image)
                reading.check(*image.size)
                image.load()
                return _core.photo(*samples_of(image), reading, colour=colour), f"Pillow {PIL.__version__}"
    except UnidentifiedImageError:
        return None
    except Image.DecompressionBombError as error:
        raise ImageFileError("the image is too large for Pillow, which would have to read it") from error
    except (ImageFileError, InvalidInputError):
        raise
    except MemoryError as error:
        raise ImageFileError("there is not enough memory to read the image") from error
    except (OSError, SyntaxError, ValueError, EOFError, IndexError, KeyError, TypeError, struct.error) as error:
        if name and (OF_DAMAGE.search(str(error)) or name not in OF_THE_CORE):
            raise ImageFileError(f"the {name} file is damaged or cut short: Pillow cannot read its picture") from error
        return None


def _seek_the_picture(image: Image.Image) -> None:
    """Go to the largest image of a TIFF that is no thumbnail and no mask."""
    if image.format != "TIFF" or getattr(image, "n_frames", 1) == 1:
        return
    sizes = []
    for frame in range(image.n_frames):  # type: ignore[attr-defined]  # images of several frames have it
        image.seek(frame)
        tags: Any = getattr(image, "tag_v2", {})
        sizes.append((not tags.get(SUBFILE, 0) & REDUCED_OR_MASK, image.width * image.height))
    image.seek(sizes.index(max(sizes)))


def samples_of(image: Image.Image) -> tuple[Samples, Said]:
    """Return an image, upright, as samples (height, width, channels), and what its file said of them."""
    said = _said(image)
    image = ImageOps.exif_transpose(image)
    mode = image.mode
    if mode.startswith("I;16"):
        return np.ascontiguousarray(np.asarray(image), np.uint16)[:, :, np.newaxis], said
    if mode == "I":
        # Pillow's 32-bit mode stands for 16-bit files too.
        wide = np.asarray(image)
        if wide.size and (wide.min() < 0 or wide.max() > 65535):
            raise InvalidInputError(f"the image of mode I has values from {wide.min()} to {wide.max()}, but they must fit 16 bits")
        return wide.astype(np.uint16)[:, :, np.newaxis], said
    if mode == "F":
        return np.ascontiguousarray(np.asarray(image), np.float32)[:, :, np.newaxis], said
    transparent = "transparency" in image.info
    if mode in {"1", "L"}:
        target = "LA" if transparent else "L"
    elif mode in {"LA", "La"}:
        target = "LA"
    elif mode in {"RGBA", "RGBa", "PA"} or transparent:
        target = "RGBA"
    elif mode == "CMYK":
        target = "CMYK"
    else:
        target = "RGB"
    if mode == "LAB":
        # Pillow converts it by way of a profile of its own; what the file has is for other pixels.
        said = NOTHING
    samples = np.asarray(_converted(image, target))
    return np.ascontiguousarray(samples.reshape(image.height, image.width, len(target))), (target == "CMYK", *said[1:])


def _converted(image: Image.Image, target: str) -> Image.Image:
    if image.mode == target:
        return image
    if image.mode == "LAB":
        from PIL import ImageCms  # noqa: PLC0415  # not in every build of Pillow

        flat = ImageCms.profileToProfile(image, ImageCms.createProfile("LAB"), ImageCms.createProfile("sRGB"), outputMode="RGB")
        assert flat is not None  # only images that are converted in place are not returned
        return flat
    return image.convert(target)


def _said(image: Image.Image) -> Said:
    """Return what an image's file said of its colours, by the rules for files: a profile, else PNG's chunks, else EXIF."""
    info = image.info
    profile = info.get("icc_profile")
    if isinstance(profile, bytes) and profile:
        return (False, profile, None, None, False)
    if "srgb" in info:
        return NOTHING
    gamma, flat = info.get("gamma"), info.get("chromaticity")
    gamma = float(gamma) if isinstance(gamma, (int, float)) and gamma > 0 else None
    points = None
    if isinstance(flat, (tuple, list)) and len(flat) == 8:
        points = [[float(flat[i]), float(flat[i + 1])] for i in range(0, 8, 2)]
    if gamma is not None or points is not None:
        return (False, None, gamma, points, False)
    return (False, None, None, None, _is_adobe_rgb(image))


def _is_adobe_rgb(image: Image.Image) -> bool:
    exif = image.getexif()
    space = exif.get_ifd(EXIF).get(COLOUR_SPACE)
    return space == 2 or (space == 0xFFFF and str(exif.get_ifd(INTEROPERABILITY).get(1, "")).startswith("R03"))
