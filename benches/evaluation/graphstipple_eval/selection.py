"""Which methods are compared, and at which counts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import graphstipple as gs
from graphstipple_eval import baselines, ours
from graphstipple_eval.method import Method
from graphstipple_eval.ours import Sweep

Budget: TypeAlias = Literal["coordinates", "marks"] | int
"""How many dots a stippling method draws: as many as the default drawing of the photo has coordinates or marks, or a number."""


@dataclass(frozen=True)
class Selection:
    """The methods of a run. Methods cannot be sent to other processes, so each process makes them from this.

    Parameters
    ----------
    names : tuple of str, optional
        Names of methods; by default all that can run here. `graphstipple` is always one of them: its drawing is the budget.
    sweeps : tuple of Sweep
        Sweeps over options.
    budget : "coordinates", "marks" or int
        How many dots stippling methods draw. A number is also how many coordinates our own drawings write.

    Raises
    ------
    InvalidInputError
        If there is no method of a name, one that is named cannot run here, or two sweeps have a value in common.
    """

    names: tuple[str, ...] | None
    sweeps: tuple[Sweep, ...]
    budget: Budget

    def __post_init__(self) -> None:
        known = {method.name: method for method in self._known}
        for name in self.names or ():
            if name not in known:
                raise gs.InvalidInputError(f"there is no method {name!r}: it must be all, or some of {', '.join(known)}")
            reason = known[name].missing()
            if reason is not None:
                raise gs.InvalidInputError(f"the method {name} cannot run here: {reason}")
        if len({sweep.option for sweep in self.sweeps}) < len(self.sweeps):
            raise gs.InvalidInputError("two sweeps are over one option: give all its values in one")

    @property
    def coordinates(self) -> int | None:
        """How many coordinates our own drawings write; None if they are as their options make them."""
        return self.budget if isinstance(self.budget, int) else None

    @property
    def _known(self) -> tuple[Method, ...]:
        return ours.methods(self.coordinates) + baselines.METHODS

    @property
    def compared(self) -> tuple[Method, ...]:
        """The methods that are compared, without sweeps."""
        if self.names is None:
            return tuple(method for method in self._known if method.missing() is None)
        return tuple(method for method in self._known if method.name in {ours.DEFAULT, *self.names})

    def all(self) -> dict[str, Method]:
        """Return the methods by name, one for every value of a sweep among them."""
        swept = [method for sweep in self.sweeps for method in sweep.methods(self.coordinates)]
        return {method.name: method for method in [*self.compared, *swept]}

    @property
    def missing(self) -> dict[str, str]:
        """What cannot run here, when all methods are wanted: its name, and what it needs."""
        wanted = self._known if self.names is None else ()
        return {method.name: reason for method in wanted if (reason := method.missing()) is not None}

    def dots(self, default: dict[str, int | None] | None) -> int | None:
        """Return how many dots stippling methods draw of a photo; None if that cannot be known.

        Parameters
        ----------
        default : dict, optional
            The counts of the photo's default drawing; None if there is no such drawing.
        """
        if isinstance(self.budget, int):
            return self.budget
        if default is None:
            return None
        names = {"coordinates": ("coordinates",), "marks": ("stipples", "regions")}[self.budget]
        return sum(default[name] or 0 for name in names)


def parse_names(text: str) -> tuple[str, ...] | None:
    """Read `all` or names with commas between them.

    Raises
    ------
    InvalidInputError
        If `all` is one of several names.
    """
    names = tuple(dict.fromkeys(text.split(",")))
    if names == ("all",):
        return None
    if "all" in names:
        raise gs.InvalidInputError(f"the methods are {text!r}, but all stands alone: give all, or names without it")
    return names


def parse_budget(text: str) -> Budget:
    """Read `coordinates`, `marks` or a number.

    Raises
    ------
    InvalidInputError
        If it is something else.
    """
    if text == "coordinates":
        return "coordinates"
    if text == "marks":
        return "marks"
    if not text.isdecimal() or int(text) < 1:
        raise gs.InvalidInputError(f"the budget is {text!r}, but it must be coordinates, marks, or a number of at least 1")
    return int(text)


def parse_sweeps(texts: Sequence[str]) -> tuple[Sweep, ...]:
    """Read sweeps (`Sweep.parse`)."""
    return tuple(Sweep.parse(text) for text in texts)
