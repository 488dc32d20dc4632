"""The exceptions of graphstipple. The extension module raises them too (``rust/py/src/errors.rs``)."""


class GraphStippleError(Exception):
    """Base class of every error that graphstipple raises on purpose."""


class GraphStippleWarning(UserWarning):
    """A drawing is hardly what was wanted: it is blank, though the photo is not flat, or made of what there is of a file."""


class InvalidInputError(GraphStippleError, ValueError):
    """An image, a map, an array or an option breaks a rule; the message says which and what is allowed."""


class ImageFileError(GraphStippleError, OSError):
    """A file cannot be read as an image or as a drawing, or a drawing cannot be written."""


class ImageFileNotFoundError(ImageFileError, FileNotFoundError):
    """The file, or the folder to write to, does not exist."""


class MissingPackageError(GraphStippleError, ImportError):
    """What was asked for needs a package that is not installed; the message says which."""


class MissingWeightsError(GraphStippleError, OSError):
    """LPIPS needs weights that are not, or not whole, in the cache folder; the message names the command that fetches them."""
