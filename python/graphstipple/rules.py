"""Rules: what a machine, a knife or a screen can make, where a drawing breaks that, and what was done so that it does not."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

from graphstipple import _core
from graphstipple._errors import InvalidInputError
from graphstipple._inputs import path_to_write, plain
from graphstipple.plots import HEAVY_SVG_BYTES

if TYPE_CHECKING:
    import os
    from collections.abc import Callable

Islands: TypeAlias = Literal["allow", "report", "bridge"]
"""What is done about white that black surrounds."""

ViolationKind: TypeAlias = Literal["neck", "gap", "dot", "area", "island"]
"""What is wrong at a place."""


@dataclass(frozen=True, kw_only=True)
class Rules:
    """What can be made. All sizes are on paper; those of dots are diameters. `None` is no limit.

    Lengths are as for `Drawing.save`: "0.4mm", or a number of px; areas are the same with a square, "2mm2". What is stored has its
    unit.

    Parameters
    ----------
    min_feature : float or str, optional
        Narrowest black, from 0.01 to 1000 mm.
    min_gap : float or str, optional
        Narrowest white between black.
    min_dot : float or str, optional
        Least diameter of a dot of either ink. No dot may be narrower than what is the narrowest of its ink.
    min_area : float or str, optional
        Smallest area of a region of either ink, from 0.0001 to 1000000 mm^2, and of an island that gets a bridge.
    islands : {"allow", "report", "bridge"}
        What is done about islands: white that black surrounds, which falls out of a stencil. They may be, they are reported and
        stay, or they are joined to the frame.

    Raises
    ------
    InvalidInputError
        If a value is out of its range, or nothing is limited.
    """

    min_feature: float | str | None = None
    min_gap: float | str | None = None
    min_dot: float | str | None = None
    min_area: float | str | None = None
    islands: Islands = "allow"

    def __post_init__(self) -> None:
        _store(self, _core.Rules({field.name: plain(getattr(self, field.name)) for field in dataclasses.fields(self)}))

    @classmethod
    def process(cls, name: str, **changes: Any) -> Rules:
        """Return the rules of a process (see `graphstipple.processes`), with single ones changed by keyword.

        Parameters
        ----------
        name : str
            Name of the process, such as "stencil".
        **changes
            Rules that differ from the process's.

        Returns
        -------
        Rules

        Raises
        ------
        InvalidInputError
            If there is no process of this name, or as `Rules`.
        """
        if not isinstance(name, str):
            raise InvalidInputError(f"process is {name!r}, but it must be the name of a process")
        rules = object.__new__(cls)
        _store(rules, _core.Rules.of_process(name))
        return rules.replace(**changes) if changes else rules

    def replace(self, **changes: Any) -> Rules:
        """Return the same rules with single ones changed by keyword."""
        unknown = sorted(changes.keys() - {field.name for field in dataclasses.fields(self)})
        if unknown:
            raise InvalidInputError(f"there is no rule {unknown[0]}")
        return dataclasses.replace(self, **changes)

    def __reduce__(self) -> tuple[Callable[[dict[str, Any]], Rules], tuple[dict[str, Any]]]:
        return _of_values, ({field.name: getattr(self, field.name) for field in dataclasses.fields(self)},)


def _of_values(values: dict[str, Any]) -> Rules:
    """Return the rules of these values."""
    return Rules(**values)


def _store(rules: Rules, core: _core.Rules) -> None:
    """Keep the values as Rust has them, and what it has checked."""
    for name, value in core.values():
        object.__setattr__(rules, name, value)
    object.__setattr__(rules, "_checked", core)


def checked_rules(rules: object) -> _core.Rules:
    """Return what Rust has checked."""
    if not isinstance(rules, Rules):
        raise InvalidInputError(f"rules is {rules!r}, but it must be graphstipple.Rules")
    core: _core.Rules = rules._checked  # type: ignore[attr-defined]
    return core


class Process(NamedTuple):
    """A process that there are rules for: ``Rules.process(name)``."""

    name: str
    description: str
    """What it asks for, in a few words."""


def processes() -> list[Process]:
    """Return the processes that there are rules for."""
    return [Process(*process) for process in _core.processes()]


class Violation(NamedTuple):
    """A place where a drawing breaks a rule."""

    kind: ViolationKind
    """Black that is too narrow is a "neck" and white a "gap"; a "dot" or an "area" is too small; an "island" falls out."""
    x: float
    """Where, in mm from the drawing's left."""
    y: float
    """Where, in mm from the drawing's top."""
    measured: float
    """How wide it is in mm where it is narrowest (a line where it is widest), a dot's diameter, or an area in mm^2."""
    limit: float
    """What it must be at least; 0 for an island, which has no limit."""
    length: float
    """How long it is in mm, roughly."""


class Changes(NamedTuple):
    """What was done to a drawing so that it keeps rules."""

    dots_kept: int
    """Dots that stay as they were."""
    dots_enlarged: int
    """Dots that are larger now, many of them in the place of several."""
    dots_reduced: int
    """Dots that are smaller now, so that there is room around them."""
    dots_dropped: int
    """Dots that were left out."""
    areas_filled: int
    """Regions that were too small and are filled."""
    features: int
    """Black parts that were too thin."""
    gaps: int
    """White parts that were too thin."""
    islands_filled: int
    """Islands that were too small for a bridge and are filled."""
    islands_bridged: int
    """Islands that were joined to the frame."""
    bridges: int
    """Bridges that join them."""
    rounds: int
    """Rounds of opening and closing."""
    tone_before: float
    """Mean tone before, 0 black to 1 white."""
    tone: float
    """Mean tone now."""


class Report:
    """Where a drawing breaks rules, as `Drawing.check` returns it. It is true where the drawing keeps all of them."""

    def __init__(self, core: _core.Report, rules: Rules) -> None:
        self._core, self._rules = core, rules

    @property
    def rules(self) -> Rules:
        """The rules that the drawing was checked for."""
        return self._rules

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the drawing in mm."""
        return self._core.size

    @cached_property
    def violations(self) -> list[Violation]:
        """All places where a rule is broken, by kind, then from the top down."""
        return [Violation(*violation) for violation in self._core.violations()]

    @cached_property
    def counts(self) -> dict[ViolationKind, int]:
        """How many violations of every kind there are, those of which there are none too."""
        counts: dict[ViolationKind, int] = self._core.counts()
        return counts

    def __bool__(self) -> bool:
        return not any(self.counts.values())

    def svg(self) -> str:
        """Return a picture of the report, the same that `save` writes: the drawing in grey, and a layer of marks for every kind."""
        return self._core.encode("svg").decode()

    def json(self) -> str:
        """Return the report as a JSON document, the same that `save` writes: rules, counts, and all violations."""
        return self._core.encode("json").decode()

    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Write the report to a file, whole or not at all: .json for machines, or .svg to look at.

        Parameters
        ----------
        path : str or path
            Where to; an existing file is replaced, unless it is read-only.
        force : bool
            Whether a file that is read-only is replaced, too.

        Raises
        ------
        InvalidInputError
            If the suffix is not known.
        ImageFileError
            If the file cannot be written; `ImageFileNotFoundError` if its folder does not exist.
        """
        self._core.save(path_to_write(path), bool(force))

    def __repr__(self) -> str:
        width, height = self.size
        found = ", ".join(f"{count} of kind {kind}" for kind, count in self.counts.items() if count) or "nothing breaks the rules"
        return f"<graphstipple.Report {width:.1f} x {height:.1f} mm: {found}>"

    def _repr_svg_(self) -> str | None:
        svg = self.svg()
        return svg if len(svg) <= HEAVY_SVG_BYTES else None
