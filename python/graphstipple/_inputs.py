"""Images and maps as users have them, to luma and colour.

Files are decoded by Rust, so that Python and the command line see the same values; those that Rust does not support, by Pillow. PIL
images and arrays are brought to samples (height, width, channels) here, where the copies are visible; Rust makes luma and colour of
them.
"""

from __future__ import annotations

import os
import sys
import warnings
from typing import TYPE_CHECKING, Any, TypeAlias, TypeGuard

import numpy as np
import numpy.typing as npt

from graphstipple import _core
from graphstipple._errors import GraphStippleWarning, ImageFileError, ImageFileNotFoundError, InvalidInputError

if TYPE_CHECKING:
    from PIL import Image

ImageLike: TypeAlias = "str | os.PathLike[str] | bytes | Image.Image | npt.NDArray[Any]"
"""A path, all bytes of a file, a PIL image or an array."""

Samples: TypeAlias = "npt.NDArray[np.uint8] | npt.NDArray[np.uint16] | npt.NDArray[np.float32]"

MAX_PIXELS: int = _core.MAX_PIXELS
"""The most pixels that an image may have."""

NOTHING = (False, None, None, None, False)
"""What an array says of its samples besides what they are."""

DTYPES = "bool, uint8, uint16, or floats in [0, 1]"


def plain(value: object) -> object:
    """Return NumPy's scalars as Python's."""
    return value.item() if isinstance(value, np.generic) else value


def is_pil(image: object) -> TypeGuard[Image.Image]:
    """Whether it is a PIL image; there is none before somebody has imported Pillow."""
    module = sys.modules.get("PIL.Image")
    return module is not None and isinstance(image, module.Image)


def read_luma(image: ImageLike, background: tuple[int, int, int], name: str = "image") -> npt.NDArray[np.float32]:
    """Return the luma of an image, (height, width) in [0, 1], transparent parts laid on a background (R, G, B).

    Raises
    ------
    InvalidInputError
        If it is no image, is empty, or has a wrong shape, type or value; `name` says what it is in the message.
    ImageFileError
        If a file cannot be read as an image.
    """
    photo, warning, _ = read_photo(image, _core.Reading(background, None, MAX_PIXELS, False), name)
    if warning:
        warnings.warn(warning, GraphStippleWarning, stacklevel=3)
    return photo.luma


def reading_of(options: _core.Options, max_pixels: object, allow_damaged: bool) -> _core.Reading:
    """Return how photos and maps are read that are drawn with options.

    Raises
    ------
    InvalidInputError
        If `max_pixels` is no whole number of pixels that may be read.
    """
    if isinstance(max_pixels, bool) or not isinstance(max_pixels, int | np.integer) or not 1 <= max_pixels <= MAX_PIXELS:
        raise InvalidInputError(f"max_pixels is {max_pixels}, but it must be between 1 and {MAX_PIXELS} pixels")
    return _core.Reading(options.background, options, int(max_pixels), bool(allow_damaged))


def read_colour(image: ImageLike, background: tuple[int, int, int], name: str = "image") -> npt.NDArray[np.float32]:
    """Return the colour of an image, (height, width, 3) of sRGB in [0, 1], by the rules and with the errors of `read_luma`."""
    photo, warning, _ = read_photo(image, _core.Reading(background, None, MAX_PIXELS, False), name, colour=True)
    if warning:
        warnings.warn(warning, GraphStippleWarning, stacklevel=3)
    kept = photo.colour
    assert kept is not None  # it was asked for
    return kept


def read_photo(
    image: ImageLike, reading: _core.Reading, name: str = "image", *, colour: bool = False
) -> tuple[_core.Photo, str | None, str | None]:
    """Return an image as `read_luma` does, for the core, what is to be said of it, and what has decoded its file.

    The photo keeps its colour if that is asked for.
    """
    if isinstance(image, (str, os.PathLike)):
        return _core.read_photo(path_to_read(image), reading, colour=colour)
    if isinstance(image, bytes):
        return _core.read_photo(name, reading, image, colour=colour)
    if is_pil(image):
        from graphstipple._pillow import samples_of  # noqa: PLC0415  # whoever has a PIL image has imported Pillow

        try:
            # Before it is loaded, if it is not yet.
            reading.check(*image.size)
        except ImageFileError as error:
            raise InvalidInputError(str(error)) from None
        return _core.photo(*samples_of(image), reading, colour=colour), None, None
    if hasattr(image, "__array__"):
        return _core.photo(_from_array(unmasked(image, name), name), NOTHING, reading, colour=colour), None, None
    raise InvalidInputError(
        f"the {name} is of type {type(image).__name__}, but it must be a path, a file's bytes, a PIL image or a NumPy array"
    )


def checked_width(width: object) -> int | None:
    """Return the width; what Rust cannot take as an unsigned integer is said in our words."""
    if width is None:
        return None
    if isinstance(width, bool) or not isinstance(width, (int, np.integer)) or not 1 <= width < 2**31:
        raise InvalidInputError(f"width is {width!r}, but it must be a whole number of pixels, at least 1")
    return int(width)


def path_to_read(path: str | os.PathLike[str]) -> str:
    """Return a path as text.

    Raises
    ------
    ImageFileNotFoundError
        If no file can have this name.
    """
    return _text_of(path, ImageFileNotFoundError, "the file does not exist")


def path_to_write(path: str | os.PathLike[str]) -> str:
    """Return a path as text.

    Raises
    ------
    ImageFileError
        If no file can have this name.
    """
    return _text_of(path, ImageFileError, "the file cannot be written")


def is_text(path: str) -> bool:
    """Whether a path is text, as names of sources are; others hold bytes that no text has, and only files are named so."""
    return not any("\ud800" <= character <= "\udfff" for character in path)


def _text_of(path: str | os.PathLike[str], refusal: type[ImageFileError], told: str) -> str:
    text = os.fsdecode(path)
    unfit = _unfit_character(text)
    if unfit is not None:
        raise refusal(f"{text!a}: {told}, as no file name can hold {unfit}")
    return text


def _unfit_character(name: str) -> str | None:
    """Return the first character that no file name can hold, in words, if there is one: NUL, a lone surrogate on most systems."""
    place = name.find("\0")
    if place < 0:
        try:
            os.fsencode(name)
        except UnicodeEncodeError as error:
            place = error.start
    return f"the character U+{ord(name[place]):04X}" if place >= 0 else None


def unmasked(values: object, name: str) -> npt.NDArray[Any]:
    """Return what is an array, or becomes one, as a plain array.

    Raises
    ------
    InvalidInputError
        If values of a masked array are masked; `name` says what it is.
    """
    if isinstance(values, np.ma.MaskedArray):
        count = np.count_nonzero(np.ma.getmaskarray(values))
        if count:
            masked = f"{count} values of the {name} are" if count > 1 else f"1 value of the {name} is"
            raise InvalidInputError(f"{masked} masked, but every value must be known: {name}.filled(value) fills what is masked")
    return np.asarray(values)


def check_range(array: npt.NDArray[Any], name: str) -> None:
    """Raise InvalidInputError if a value of an array (height, width, ...) lies outside [0, 1]; `name` says what it is."""
    wrong = np.argwhere(~((array >= 0) & (array <= 1)))
    if len(wrong):
        row, column = (int(i) for i in wrong[0][:2])
        raise InvalidInputError(
            f"the {name} is {array[tuple(wrong[0])]} at column {column}, row {row}, but floats must be between 0 and 1"
        )


def _from_array(array: npt.NDArray[Any], name: str) -> Samples:
    if array.ndim == 2:
        array = array[:, :, np.newaxis]
    if array.ndim != 3 or not 1 <= array.shape[2] <= 4:
        raise InvalidInputError(
            f"the {name} has the shape {array.shape}, but it must be (height, width) or (height, width, 1 to 4 channels)"
        )
    if array.size == 0:
        raise InvalidInputError(f"the {name} has no pixels: its shape is {array.shape}")
    if array.dtype == np.bool_:
        return np.ascontiguousarray(array, np.uint8) * np.uint8(255)
    if array.dtype == np.uint8:
        return np.ascontiguousarray(array)
    if array.dtype.kind == "u" and array.dtype.itemsize == 2:
        return np.ascontiguousarray(array, np.uint16)
    if array.dtype.kind != "f":
        raise InvalidInputError(f"the {name} has values of type {array.dtype}, but they must be {DTYPES}")
    check_range(array, name)
    return np.ascontiguousarray(array, np.float32)
