"""What each step of the default brings: `python -m graphstipple_eval.ablation FOLDER`.

Every photo is drawn with the default, with the default without each of its steps (`ours.WITHOUT`: the paper's values of the options
that make it), and with the paper's settings, all at one number of nodes. Printed is a table in Markdown: the means of the default,
and how far those of the others are from them. Means hide whether a step helps most photos or a few much, so a last column counts
photos that are worse and better without it.

Drawing, measuring and processes are those of `graphstipple-eval`. The folder is one of its reports without the pages: it makes them
of the same pictures when it is given the same photos and methods.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from graphstipple_eval import cli, files, ours, photos, report, tables
from graphstipple_eval.flip import PIXELS_PER_DEGREE
from graphstipple_eval.results import Result
from graphstipple_eval.selection import Selection
from graphstipple_eval.tables import Figure


def _flip(pixels: int) -> Figure:
    return Figure(f"FLIP {pixels}", lambda it: it.metrics[f"flip_{pixels}"])


FIGURES = (
    *(_flip(pixels) for pixels in PIXELS_PER_DEGREE),
    Figure("LPIPS near", lambda it: (it.metrics["near_lpips_alex"] + it.metrics["near_lpips_vgg"]) / 2),
    Figure("LPIPS far", lambda it: it.metrics["far_lpips_alex"]),
    Figure("SSIM near", lambda it: it.metrics["near_ssim"]),
    Figure("PSNR far, dB", lambda it: it.metrics["far_psnr"], is_relative=False, digits=2),
    Figure("PSNR at 3 px, dB", lambda it: it.metrics["farther_psnr"], is_relative=False, digits=2),
    Figure("local tone", lambda it: it.metrics["local_tone"]),
    Figure("evenness", lambda it: it.evenness.get("evenness", np.nan), is_relative=False),
    Figure("coordinates", lambda it: float(it.counts["coordinates"] or 0), digits=0),
)
"""The columns. A picture with too few dots has no evenness, and the photo does not count for it."""

COUNTED = 1
"""Index of the figure by which photos are counted: FLIP at 80 pixels a degree, about arm's length from a screen."""


def selection() -> Selection:
    """Return the methods of the table."""
    return Selection((*ours.WITHOUT, ours.PAPER), (), "coordinates")


def summary(results: Sequence[Result]) -> str:
    """Return the table of the results of `selection` on some photos."""
    figures = tables.by_method(results, FIGURES)
    default = figures[ours.DEFAULT]
    means = [figure.text(mean) for figure, mean in zip(FIGURES, np.nanmean(default, axis=0), strict=True)]
    rows = [[f"`{ours.DEFAULT}`, as it is", *means, ""]]
    for name in (*ours.WITHOUT, ours.PAPER):
        own = figures[name]
        gains = zip(FIGURES, tables.gains(FIGURES, own, default), strict=True)
        by = own[:, COUNTED] - default[:, COUNTED]
        counted = f"{np.count_nonzero(by > 0)} / {np.count_nonzero(by < 0)}"
        rows.append([f"`{name}`", *("" if np.isnan(gain) else figure.gain_text(gain) for figure, gain in gains), counted])
    head = ["", *(figure.title for figure in FIGURES), f"{FIGURES[COUNTED].title} worse / better"]
    photos_of = "1 photo" if len(default) == 1 else f"{len(default)} photos"
    return f"## Without each step: means over {photos_of}, against the default\n\n{tables.markdown(head, rows)}\n"


def _tables(places: Sequence[Path], size: int, root: Path, jobs: int) -> str:
    """Return the table, and write the numbers that it is made of."""
    cli.check_out(root)
    chosen, found = selection(), photos.find(places)
    cli.mark(root)
    prepared, outcome = cli.all_made(found, size, chosen, root, jobs)
    for name, content in report.numbers(prepared, chosen, outcome).items():
        files.write(root / name, content.encode())
    return summary(outcome.results)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table (`cli.print_tables`).

    Parameters
    ----------
    arguments : sequence of str, optional
        By default the program's.
    """
    description = "The default without each of its steps: what each brings."
    cli.print_tables("ablation", description, _tables, "ablation.md and results.json", arguments)


if __name__ == "__main__":  # the worker processes import this module too
    main()
