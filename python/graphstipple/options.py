"""The options of a drawing: the same names, defaults and ranges as in Rust, on the command line and in a drawing's metadata."""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from graphstipple import _core
from graphstipple._errors import InvalidInputError


@dataclass(frozen=True, kw_only=True)
class Options:
    """Everything that shapes a drawing besides the photo and the importance.

    Checked when made, by the Rust core; unchangeable afterwards (see `replace`).

    Parameters
    ----------
    lattice : {"hexagonal", "square"}
        The regular first graph.
    density : float, optional
        Lattice nodes per pixel, above 0, at most 16. By default as fine as the node budget needs, and no finer.
    nodes : int, optional
        Node budget: how many nodes to keep (within 2 %), at least 3. At most one of `nodes` and `nodes_per_pixel`; without
        either and without a density, 0.3 a pixel and at most 300,000.
    nodes_per_pixel : float, optional
        Node budget per pixel, above 0, at most 16.
    relax : int
        Lloyd steps between the two graphs, 0 to 100.
    k1, k2 : float
        Weights of the difference of values between two nodes and of their distance (per pixel), 0 to 1000.
    base : float
        Dynamic alpha where there is no detail, 0 to 1.
    detail_gain : float
        The paper's lambda: how much dynamic alpha grows with detail, 0 to 1000.
    rings : int
        Radius of the local mean in rings of the graph, 1 to 16.
    importance_alpha, alpha : "dynamic" or float
        Share of a node's error that is passed on, when the importance and when the tone is diffused: dynamic, or the same
        everywhere, 0 (thresholding) to 1 (halftoning).
    stipple_scale : float
        A stipple's area relative to its node's cell, above 0, at most 4.
    tolerance : float
        How far a region's outline may lie from the one through all midpoints when it is drawn with fewer points, in pixels,
        0 to 2; 0 keeps every midpoint.
    gamma : float
        The tone is raised to the power 1 / gamma (above 1 brightens), 0.1 to 10.
    contrast : float
        Factor on the tone's distance from middle grey, 0 to 10.
    invert : bool
        Swap black and white in the tone.
    threads : int, optional
        Worker threads, 1 to 1024; by default one a core. The drawing does not depend on it.
    background : str
        What lies under transparent pixels of the image: "white", "black", "#rrggbb" or "#rgb".

    Raises
    ------
    InvalidInputError
        If a value has the wrong type or lies outside its range.
    """

    lattice: Literal["hexagonal", "square"] = "hexagonal"
    density: float | None = None
    nodes: int | None = None
    nodes_per_pixel: float | None = None
    relax: int = 1
    k1: float = 1.0
    k2: float = 0.1
    base: float = 0.5
    detail_gain: float = 6.0
    rings: int = 1
    importance_alpha: Literal["dynamic"] | float = "dynamic"
    alpha: Literal["dynamic"] | float = "dynamic"
    stipple_scale: float = 1.0
    tolerance: float = 0.25
    gamma: float = 1.0
    contrast: float = 1.0
    invert: bool = False
    threads: int | None = None
    background: str = "white"

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.generic):
                object.__setattr__(self, field.name, value.item())
            if isinstance(value, (float, np.floating)) and not math.isfinite(value):
                raise InvalidInputError(f"{field.name} is {value}, but it must be a finite number")
        # What Rust makes of the values is stored, so that density=1 and density=1.0 are equal options.
        for name, value in json.loads(_core.validated_options(self._json())).items():
            object.__setattr__(self, name, value)

    @classmethod
    def paper(cls, **changes: Any) -> Options:
        """Return the paper's settings: density 1, no node budget, tolerance 0, with single ones changed by keyword.

        Parameters
        ----------
        **changes
            Options that differ from the paper's.

        Returns
        -------
        Options
        """
        return cls(**{**json.loads(_core.paper_options()), **changes})

    def replace(self, **changes: Any) -> Options:
        """Return the same options with single ones changed by keyword.

        Parameters
        ----------
        **changes
            Options to change.

        Returns
        -------
        Options
        """
        return dataclasses.replace(self, **changes)

    def _json(self) -> str:
        """Return the options as JSON, the form in which the core takes them."""
        try:
            return json.dumps(dataclasses.asdict(self), allow_nan=False)
        except TypeError as error:
            raise InvalidInputError(f"an option has a type that no option has: {error}") from None
