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

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import graphstipple as gs
from graphstipple.metrics import Comparison
from graphstipple_eval import cli, files, ours, photos, report
from graphstipple_eval.method import Photo
from graphstipple_eval.results import Result
from graphstipple_eval.selection import Selection

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


class Figure(NamedTuple):
    """What is measured of a picture."""

    title: str
    read: Callable[[Result], float]
    is_relative: bool = True
    """Whether a gain is a share of the paper's mean, else the difference from it."""
    digits: int = 3
    target: float | None = None
    """The gain that is wanted; None for figures that the score does not know."""


FIGURES = (
    Figure("near LPIPS", lambda it: (it.metrics["near_lpips_alex"] + it.metrics["near_lpips_vgg"]) / 2, target=-0.12),
    Figure("far LPIPS", lambda it: it.metrics["far_lpips_alex"], target=-0.25),
    Figure("near SSIM", lambda it: it.metrics["near_ssim"], target=0.35),
    Figure("far PSNR", lambda it: it.metrics["far_psnr"], is_relative=False, digits=2, target=2.5),
    Figure("tone error, absolute", lambda it: abs(it.metrics["tone_error"]), is_relative=False, digits=4),
    Figure("vertices", lambda it: float(it.counts["vertices"] or 0), digits=0),
)

Array = npt.NDArray[np.float64]


def gains(figures: Array, paper: Array) -> Array:
    """Return the gains over the paper's settings in the means over photos: shares or differences, as `FIGURES` says.

    Parameters
    ----------
    figures, paper : (photos, figures) array
        `FIGURES` of one setting and of the paper's.
    """
    mean, reference = figures.mean(axis=0), paper.mean(axis=0)
    is_relative = np.array([figure.is_relative for figure in FIGURES])
    gained: Array = (mean - reference) / np.where(is_relative, reference, 1)
    return gained


def score(figures: Array, paper: Array) -> float:
    """Return the mean over the targets of gain / target, each at most `MOST`: 0 is as good as the paper's, 1 meets the targets.

    Parameters
    ----------
    figures, paper : (photos, figures) array
        As for `gains`.
    """
    met = zip(FIGURES, gains(figures, paper), strict=True)
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
    decoded = photos.decode(photos.find(places), [size], Comparison.LEAST_SIDE, root / report.PICTURES)
    if len(decoded) < 2:
        raise gs.InvalidInputError("there is one photo, but one is left out and others must be there to choose on: give more")
    prepared = photos.write(decoded)
    outcome = cli.run_and_show(prepared, selection, root, jobs)
    if outcome.failures:
        failure = outcome.failures[0]
        raise gs.GraphStippleError(f"{failure.method} failed on {failure.photo}: {failure.reason}")
    made: dict[str, list[list[float]]] = {name: [] for name in selection.all()}
    for result in outcome.results:  # in the order of the photos
        made[result.method].append([figure.read(result) for figure in FIGURES])
    return [photo.name for photo in prepared], {name: np.array(rows) for name, rows in made.items()}


def summary(names: Sequence[str], by_setting: dict[str, Array]) -> str:
    """Return the tables of settings and of photos that are left out, from what `measured` returns."""
    paper = by_setting[ours.PAPER]
    settings = [name for name in by_setting if name != ours.PAPER]
    figures = np.array([by_setting[name] for name in settings])
    choices = chosen(figures, paper)
    held_out = figures[choices, np.arange(len(names))]

    def row(titles: Iterable[str], own: Array, reference: Array) -> list[str]:
        shown = [_gain(figure, gain) for figure, gain in zip(FIGURES, gains(own, reference), strict=True)]
        return [*titles, *shown, f"{score(own, reference):.3f}"]

    head = [figure.title for figure in FIGURES]
    means = [
        "the paper's, as it is",
        *(f"{mean:.{figure.digits}f}" for figure, mean in zip(FIGURES, paper.mean(axis=0), strict=True)),
        "0",
    ]
    parts = [
        f"## Settings: means over {len(names)} photos, relative to the paper's",
        table(["setting", *head, "score"], [means, *(row([name], by_setting[name], paper) for name in settings)]),
        "## Left out: each photo with the setting that is best on the others",
        table(
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


def _gain(figure: Figure, gain: float) -> str:
    return f"{100 * gain:+.1f} %" if figure.is_relative else f"{gain:+.{figure.digits}f}"


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
    return f"## Flat grey: {GREY_SIDE} x {GREY_SIDE} pixels\n\n{table(head, rows)}"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *rows))


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables.

    Parameters
    ----------
    arguments : sequence of str, optional
        By default the program's.

    Raises
    ------
    SystemExit
        If there is something wrong with the arguments or the photos, or a picture cannot be made; with one sentence.
    """
    parser = argparse.ArgumentParser(
        prog="python -m graphstipple_eval.cross_validation",
        description="Leave-one-photo-out validation of the default's numbers.",
    )
    parser.add_argument("photos", nargs="+", type=Path, metavar="FOLDER|FILE", help="folders of photos, or single photos")
    parser.add_argument("--size", type=int, default=512, help="longest side that photos are reduced to (default: %(default)s)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default: %(default)s)")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FOLDER",
        help="also write cross_validation.md there, and keep the pictures, so that another run makes only what has changed",
    )
    given = parser.parse_args(arguments)
    try:
        with TemporaryDirectory() as temporary:
            names, by_setting = measured(given.photos, given.size, given.out or Path(temporary), given.jobs)
        text = f"{summary(names, by_setting)}\n\n{flat_grey()}\n"
    except gs.GraphStippleError as error:
        sys.exit(f"cross_validation: {error}")
    print(text, end="")
    if given.out is not None:
        files.write(given.out / "cross_validation.md", text.encode())


if __name__ == "__main__":  # the worker processes import this module too
    main()
