"""Whether the default's numbers hold on photos that they were not chosen on: `python -m graphstipple_eval.cross_validation FOLDER`.

Every photo is drawn with the default, with the paper's settings at the same number of nodes, and with a few other values of the
default's main numbers, one changed at a time. Printed are, as Markdown:

- settings: the means of all figures relative to the paper's, and a score; how little they differ is how flat the optimum is;
- left out: for each photo the setting with the best score on all others, and its figures on that photo; the nearer their mean is to
  the default's, the less the choice of numbers hangs on single photos;
- flat grey: how far the default and the paper's settings fall into labyrinths where a photo gives nothing to follow.

Drawing, measuring and processes are those of `graphstipple-eval`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

import graphstipple as gs
from graphstipple_eval import cli, ours, photos, tables
from graphstipple_eval.method import Photo
from graphstipple_eval.selection import Selection
from graphstipple_eval.tables import Figure

GRID: dict[str, tuple[float, ...]] = {
    "stippling": (0.6, 0.8, 1.2, 1.4),
    "shading": (0.5, 0.7, 1.4, 2),
    "sharpen": (0.5, 0.7, 1.4, 2),
    "local_contrast": (0.5, 0.7, 1.4, 2),
    "floor": (0.5, 0.7, 1.4, 2),
    "midtones": (0.5, 0.7, 1.4, 2),
    "crispness": (0.5, 0.7, 1.4, 2),
    "cohesion": (0.5, 0.7, 1.4, 2),
    "tolerance": (0.5, 0.7, 1.4, 2),
}
"""Options, and what their defaults are multiplied by, one option at a time."""

GREYS, GREY_SIDE = (0.4, 0.5, 0.6), 256
"""Tones of the flat pictures, and their side in pixels."""

MOST = 1.5
"""What one target can add to a score, as a multiple of the target: a large gain in one figure does not make up for all others."""


FIGURES = (
    Figure("near LPIPS", lambda it: (it.metrics["near_lpips_alex"] + it.metrics["near_lpips_vgg"]) / 2, target=-0.12),
    Figure("far LPIPS", lambda it: it.metrics["far_lpips_alex"], target=-0.25),
    Figure("near SSIM", lambda it: it.metrics["near_ssim"], target=0.35),
    Figure("far PSNR", lambda it: it.metrics["far_psnr"], is_relative=False, digits=2, target=2.5),
    Figure("tone error, absolute", lambda it: abs(it.metrics["tone_error"]), is_relative=False, digits=4),
    Figure("vertices", lambda it: float(it.counts["vertices"] or 0), digits=0),
)

Array = npt.NDArray[np.float64]


def score(figures: Array, paper: Array) -> float:
    """Return the mean over the targets of gain / target, each at most `MOST`: 0 is as good as the paper's, 1 meets the targets.

    Parameters
    ----------
    figures, paper : (photos, figures) array
        `FIGURES` of one setting and of the paper's.
    """
    met = zip(FIGURES, tables.gains(FIGURES, figures, paper), strict=True)
    return float(np.mean([min(gain / figure.target, MOST) for figure, gain in met if figure.target is not None]))


def chosen(figures: Array, paper: Array) -> list[int]:
    """Return for each photo which setting has the best score on all other photos, of equal ones the first.

    Parameters
    ----------
    figures : (settings, photos, figures) array
        `FIGURES` of every setting.
    paper : (photos, figures) array
        Those of the paper's.
    """
    others = ~np.eye(len(paper), dtype=bool)
    return [int(np.argmax([score(setting[kept], paper[kept]) for setting in figures])) for kept in others]


def sweeps() -> tuple[ours.Sweep, ...]:
    """Return `GRID` as sweeps over values that the options may have and that are not the default."""
    found = []
    for option, factors in GRID.items():
        default = getattr(gs.Options(), option)
        values = {float(f"{factor * default:.3g}"): None for factor in factors}
        allowed = tuple(value for value in values if value != default and _is_allowed(option, value))
        if allowed:
            found.append(ours.Sweep(option, allowed))
    return tuple(found)


def _is_allowed(option: str, value: float) -> bool:
    try:
        gs.Options().replace(**{option: value})
    except gs.InvalidInputError:
        return False
    return True


def measured(places: Sequence[Path], size: int, root: Path, jobs: int) -> tuple[list[str], dict[str, Array]]:
    """Draw and measure everything that is not in the folder yet.

    Returns
    -------
    list of str
        Names of the photos.
    dict of (photos, figures) array
        `FIGURES` of every setting by its name, the paper's among them.
    """
    selection = Selection((ours.PAPER,), sweeps(), "coordinates")
    found = photos.find(places)
    if len(found) < 2:
        raise gs.InvalidInputError("there is one photo, but one is left out and others must be there to choose on: give more")
    prepared, outcome = cli.all_made(found, size, selection, root, jobs)
    return [photo.name for photo in prepared], tables.by_method(outcome.results, FIGURES)


def summary(names: Sequence[str], by_setting: dict[str, Array]) -> str:
    """Return the tables of settings and of photos that are left out, from what `measured` returns."""
    paper = by_setting[ours.PAPER]
    settings = [name for name in by_setting if name != ours.PAPER]
    figures = np.array([by_setting[name] for name in settings])
    choices = chosen(figures, paper)
    held_out = figures[choices, np.arange(len(names))]

    def row(titles: Iterable[str], own: Array, reference: Array) -> list[str]:
        shown = [figure.gain_text(gain) for figure, gain in zip(FIGURES, tables.gains(FIGURES, own, reference), strict=True)]
        return [*titles, *shown, f"{score(own, reference):.3f}"]

    head = [figure.title for figure in FIGURES]
    means = [
        "the paper's, as it is",
        *(figure.text(mean) for figure, mean in zip(FIGURES, paper.mean(axis=0), strict=True)),
        "0",
    ]
    parts = [
        f"## Settings: means over {len(names)} photos, relative to the paper's",
        tables.markdown(["setting", *head, "score"], [means, *(row([name], by_setting[name], paper) for name in settings)]),
        "## Left out: each photo with the setting that is best on the others",
        tables.markdown(
            ["photo", "setting", *head, "score"],
            [
                *(
                    row([name, settings[at]], held_out[[i]], paper[[i]])
                    for i, (name, at) in enumerate(zip(names, choices, strict=True))
                ),
                row(["all, left out", ""], held_out, paper),
                row(["all", ours.DEFAULT], by_setting[ours.DEFAULT], paper),
            ],
        ),
    ]
    return "\n\n".join(parts)


def flat_grey() -> str:
    """Return the table of `graphstipple_eval.labyrinth.measures` on flat grey pictures, by the default and the paper's settings."""
    rows = []
    methods = [method for method in ours.methods(None) if method.name in {ours.DEFAULT, ours.PAPER}]
    for grey in GREYS:
        pixels = np.full((GREY_SIDE, GREY_SIDE), round(255 * grey), np.uint8)
        photo = Photo(f"grey-{grey}", "", pixels, gs.stages.tone(pixels))
        for method in methods:
            found = method.draw(photo, 0).labyrinth
            rows.append([str(grey), method.name, f"{found['small_regions']:.1f}", f"{found['boundary']:.2f}"])
    head = ["grey", "setting", "small regions per 1000 nodes", "boundary, px per node"]
    return f"## Flat grey: {GREY_SIDE} x {GREY_SIDE} pixels\n\n{tables.markdown(head, rows)}"


def _tables(places: Sequence[Path], size: int, root: Path, jobs: int) -> str:
    """Return all tables."""
    names, by_setting = measured(places, size, root, jobs)
    return f"{summary(names, by_setting)}\n\n{flat_grey()}\n"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables (`cli.print_tables`).

    Parameters
    ----------
    arguments : sequence of str, optional
        By default the program's.
    """
    description = "Leave-one-photo-out validation of the default's numbers."
    cli.print_tables("cross_validation", description, _tables, "cross_validation.md", arguments)


if __name__ == "__main__":  # the worker processes import this module too
    main()
