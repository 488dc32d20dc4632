from collections.abc import Callable, Sequence
from typing import Any, Literal, final

import numpy as np
import numpy.typing as npt

__all__ = [
    "MAX_PIXELS",
    "Drawing",
    "Options",
    "Photo",
    "Reading",
    "Session",
    "Trials",
    "__version__",
    "adjust",
    "cells",
    "clean",
    "cli",
    "components",
    "diffuse",
    "draw",
    "emphasize",
    "formats",
    "grounds",
    "lattice",
    "lattice_labels",
    "load",
    "luma_to_u8",
    "mixed_importance",
    "options_schema",
    "outline",
    "owners",
    "photo",
    "preset",
    "presets",
    "read_photo",
    "refine",
    "relax",
    "saliency",
    "samples_per_pixel",
    "settings",
    "sources",
    "split",
    "stipple",
    "triangulate",
]

__version__: str
MAX_PIXELS: int

@final
class Drawing:
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def region_count(self) -> int: ...
    @property
    def stipple_count(self) -> int: ...
    def encode(self, suffix: str, settings: dict[str, Any]) -> bytes: ...
    def rasterize(self, width: int | None = None) -> npt.NDArray[np.uint8]: ...
    def save(self, path: str, settings: dict[str, Any]) -> str | None: ...
    def with_min_dot(self, length: object, settings: dict[str, Any]) -> Drawing: ...
    def stats(self) -> dict[str, Any]: ...
    def provenance(self) -> dict[str, Any]: ...
    def options(self) -> Options: ...
    def stipples(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint8]]: ...
    def region(self, index: int) -> tuple[npt.NDArray[np.float64], list[npt.NDArray[np.float64]], float, int]: ...
    def polygons(self, ink: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32], npt.NDArray[np.uint32]]: ...
    def graph(
        self,
    ) -> (
        tuple[
            npt.NDArray[np.float64],
            npt.NDArray[np.uint32],
            npt.NDArray[np.float32],
            npt.NDArray[np.uint8],
            npt.NDArray[np.uint32],
        ]
        | None
    ): ...
    def importance(self) -> npt.NDArray[np.float32] | None: ...

@final
class Options:
    def __new__(cls, values: dict[str, Any], published: Options | None = None) -> Options: ...
    @property
    def background(self) -> tuple[int, int, int]: ...
    def values(self) -> dict[str, Any]: ...

@final
class Photo:
    @property
    def luma(self) -> npt.NDArray[np.float32]: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def factor(self) -> int: ...

@final
class Reading:
    def __new__(
        cls, background: tuple[int, int, int], options: Options | None, max_pixels: int, allow_damaged: bool
    ) -> Reading: ...
    def check(self, width: int, height: int) -> None: ...

@final
class Session:
    def __new__(cls, photo: Photo, importance: str | Photo, reading: Reading) -> Session: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def importance(self) -> str: ...
    @property
    def seconds(self) -> dict[str, float]: ...
    @property
    def warning(self) -> str | None: ...
    def fits(self, options: Options) -> bool: ...
    def draw(self, options: Options, progress: Callable[[str, float], object] | None = None) -> Drawing: ...

@final
class Trials:
    def __new__(
        cls,
        options: Options,
        size: tuple[int, int],
        max_bytes: object,
        max_points: object,
        suffix: str,
        settings: dict[str, Any],
    ) -> Trials: ...
    def next_options(self) -> Options | None: ...
    def tell(self, drawing: Drawing) -> bool: ...
    def found(self, finest: Drawing | None) -> Drawing | None: ...

def draw(
    photo: Photo,
    importance: str | Photo,
    reading: Reading,
    options: Options,
    progress: Callable[[str, float], object] | None = None,
) -> Drawing: ...
def load(path: str) -> Drawing: ...
def options_schema() -> dict[str, Any]: ...
def settings() -> list[tuple[str, str, str, list[str]]]: ...
def formats() -> list[tuple[str, str, str, bool]]: ...
def sources() -> list[tuple[str, str]]: ...
def preset(name: str) -> Options: ...
def presets() -> list[tuple[str, str, Literal["black", "white", "both"]]]: ...
def read_photo(path: str, reading: Reading) -> tuple[Photo, str | None, str]: ...
def photo(
    samples: npt.NDArray[Any],
    said: tuple[bool, bytes | None, float | None, Sequence[Sequence[float]] | None, bool],
    reading: Reading,
) -> Photo: ...
def adjust(luma: npt.NDArray[np.float32], options: Options) -> npt.NDArray[np.float32]: ...
def luma_to_u8(luma: npt.NDArray[np.float32]) -> npt.NDArray[np.uint8]: ...
def saliency(luma: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]: ...
def cli(args: list[str]) -> int: ...
def lattice(width: int, height: int, options: Options) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]]: ...
def emphasize(tone: npt.NDArray[np.float32], options: Options) -> npt.NDArray[np.float32]: ...
def mixed_importance(
    tone: npt.NDArray[np.float32], given: npt.NDArray[np.float32], is_factor: bool, options: Options
) -> npt.NDArray[np.float32]: ...
def lattice_labels(
    importance: npt.NDArray[np.float32], options: Options
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint8], float]: ...
def samples_per_pixel(density: float) -> int: ...
def cells(
    sites: npt.NDArray[np.float64], width: int, height: int, field: npt.NDArray[np.float32] | None, samples_per_pixel: int
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float32], npt.NDArray[np.uint32]]: ...
def owners(sites: npt.NDArray[np.float64], width: int, height: int, samples_per_pixel: int) -> npt.NDArray[np.uint32]: ...
def relax(
    sites: npt.NDArray[np.float64], width: int, height: int, steps: int, samples_per_pixel: int
) -> npt.NDArray[np.float64]: ...
def triangulate(sites: npt.NDArray[np.float64], width: int, height: int) -> npt.NDArray[np.uint32]: ...
def diffuse(
    sites: npt.NDArray[np.float64],
    edges: npt.NDArray[np.uint32],
    values: npt.NDArray[np.float32],
    areas: npt.NDArray[np.float64] | None,
    options: Options,
) -> npt.NDArray[np.uint8]: ...
def refine(
    edges: npt.NDArray[np.uint32],
    tones: npt.NDArray[np.float32],
    labels: npt.NDArray[np.uint8],
    cells: tuple[npt.NDArray[np.float64], npt.NDArray[np.uint8] | None],
    mean: float | None,
    options: Options,
) -> tuple[npt.NDArray[np.uint8], float]: ...
def split(
    edges: npt.NDArray[np.uint32], tones: npt.NDArray[np.float32], labels: npt.NDArray[np.uint8], most: int
) -> npt.NDArray[np.uint8]: ...
def grounds(
    sites: npt.NDArray[np.float64], edges: npt.NDArray[np.uint32], tones: npt.NDArray[np.float32], options: Options
) -> npt.NDArray[np.uint8]: ...
def clean(
    edges: npt.NDArray[np.uint32], tones: npt.NDArray[np.float32], labels: npt.NDArray[np.uint8]
) -> npt.NDArray[np.uint8]: ...
def stipple(
    sites: npt.NDArray[np.float64],
    grounds: npt.NDArray[np.uint8],
    tones: npt.NDArray[np.float32],
    areas: npt.NDArray[np.float64],
    labels: npt.NDArray[np.uint8],
    size: tuple[int, int],
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float64], npt.NDArray[np.float64]]: ...
def components(edges: npt.NDArray[np.uint32], labels: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint32]: ...
def outline(
    positions: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64] | None],
    labels: npt.NDArray[np.uint8],
    areas: npt.NDArray[np.float64],
    tones: npt.NDArray[np.float32] | None,
    size: tuple[int, int],
    options: Options,
) -> tuple[
    tuple[npt.NDArray[np.float64], npt.NDArray[np.uint8]],
    list[tuple[npt.NDArray[np.float64], list[npt.NDArray[np.float64]], float, int]],
]: ...
