"""From slider to picture: `python benches/studio.py`. The studio's own server and page, in a real browser, beside `Session.draw`.

A slider of the page is moved and let go, and the time is taken from its event to the paint of the whole drawing; then the same
value is drawn by a session of the same photo in this process, so that what else the machine does meets both. The difference is what
the studio costs: messages, painting what the page shows, compressing, decoding. While a slider is dragged, 60 values a second, the
time is taken from the first event of a value to the first picture of it or of a later one.

The photo is the made-up one of the Rust benchmarks, options are the default's but the one that is turned.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from playwright.sync_api import Page, sync_playwright
from ratios import write_photo

import graphstipple as gs

BROWSERS = ("chromium", "chromium-browser", "google-chrome")

TURNED = ("fineness", "sharpen", "gamma", "stippling", "shading", "crispness", "tolerance", "stipple_scale")
"""Options that are turned: of every stage."""

SIZES = ((577, 433), (1152, 864))
"""A quarter of a megapixel, and one."""

LIMITS = {577: 0.3, 1152: 1.0}
"""Seconds that 95 of 100 pictures may take, by the photo's width."""

OVERHEAD = 0.1
"""Seconds beyond `Session.draw`, in the median."""

VALUES, TINY_VALUES = 6, 1
"""Of every option."""

PLACES = (0.25, 0.45)
"""Where the slider is let go, as shares of its length: around the default, which is a third along or in the middle."""

DRAGGED = 60
"""Values of a drag."""

TURN = """
([option, place]) => new Promise((resolve) => {
    const root = document.querySelector("[data-sent]");
    const slider = root.querySelector(`[data-option="${option}"] input[type=range]`);
    const least = Number(slider.min), most = Number(slider.max);
    const began = performance.now();
    const shown = (event) => {
        if (event.detail.whole && String(event.detail.id) === root.dataset.sent && event.detail.id !== before) {
            root.removeEventListener("graphstipple-shown", shown);
            resolve((performance.now() - began) / 1000);
        }
    };
    const before = Number(root.dataset.shown);
    root.addEventListener("graphstipple-shown", shown);
    slider.value = least + place * (most - least);
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    slider.dispatchEvent(new Event("change", { bubbles: true }));
})
"""

DRAG = """
([option, count]) => new Promise((resolve) => {
    const root = document.querySelector("[data-sent]");
    const slider = root.querySelector(`[data-option="${option}"] input[type=range]`);
    const least = Number(slider.min), most = Number(slider.max);
    const sent = [], taken = [];
    const shown = (event) => {
        const now = performance.now();
        while (sent.length > 0 && sent[0][0] <= event.detail.id) {
            taken.push((now - sent.shift()[1]) / 1000);
        }
        if (moves === count && sent.length === 0) {
            root.removeEventListener("graphstipple-shown", shown);
            resolve(taken);
        }
    };
    root.addEventListener("graphstipple-shown", shown);
    let moves = 0, last = root.dataset.sent;
    const move = () => {
        if (root.dataset.sent !== last) {
            last = root.dataset.sent;
            sent.push([Number(last), times.shift()]);
            times.length = 0;
        }
        if (moves === count) return;
        moves += 1;
        times.push(performance.now());
        slider.value = least + (0.25 + 0.2 * moves / count) * (most - least);
        slider.dispatchEvent(new Event("input", { bubbles: true }));
        if (moves === count) slider.dispatchEvent(new Event("change", { bubbles: true }));
        setTimeout(move, 16);
    };
    const times = [];
    move();
})
"""


BACK = """
(option) => {
    const slider = document.querySelector(`[data-option="${option}"] input[type=range]`);
    slider.dispatchEvent(new Event("dblclick", { bubbles: true }));
}
"""

AT_REST = """
() => {
    const root = document.querySelector("[data-drawn]");
    return root && root.dataset.sent === root.dataset.drawn && root.dataset.shown === root.dataset.sent;
}
"""

ALL_PRESETS = "(count) => document.querySelectorAll('[data-preset] img[src], [data-preset] canvas').length >= count"


@dataclass(frozen=True)
class Line:
    """Seconds at one size."""

    size: tuple[int, int]
    nodes: int
    page: list[float]
    session: list[float]
    dragged: list[float]
    turned: dict[str, tuple[float, float]]

    def __str__(self) -> str:
        width, height = self.size
        over = [page - session for page, session in zip(self.page, self.session, strict=True)]
        numbers = (
            *(at(self.page, share) for share in (0.5, 0.95)),
            *(at(self.session, share) for share in (0.5, 0.95)),
            at(over, 0.5),
            *(at(self.dragged, share) for share in (0.5, 0.95)),
        )
        return f"{width:>5} x {height:<5}{self.nodes:>8}" + "".join(f"{number:>11.3f}" for number in numbers)

    def verdicts(self) -> list[str]:
        """Return what is to be reached beside what was."""
        width, height = self.size
        over = at([page - session for page, session in zip(self.page, self.session, strict=True)], 0.5)
        limit = LIMITS.get(width)
        lines = []
        if limit is not None:
            lines.append(verdict(f"{width} x {height}: slider to whole drawing, 95 of 100, s", at(self.page, 0.95), limit))
        return [*lines, verdict(f"{width} x {height}: beyond Session.draw, median, s", over, OVERHEAD)]


def verdict(title: str, value: float, limit: float) -> str:
    """Return a line with a limit."""
    return f"{title:<62}{value:>8.3f}   <= {limit:<5g}{'met' if value <= limit else 'missed'}"


def at(values: Sequence[float], share: float) -> float:
    """Return the value below which a share of them lies."""
    return float(np.quantile(values, share))


@contextlib.contextmanager
def studio(photo: Path) -> Iterator[str]:
    """Run the server on a photo, and give its address."""
    command = [str(Path(sys.executable).with_name("graphstipple")), "studio", str(photo), "--port", "0", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            found = re.search(r"http://\S+", process.stdout.readline() if process.stdout else "")
            if found is None:
                sys.exit("the studio did not begin")
            yield found[0]
        finally:
            process.terminate()


def measured(page: Page, photo: Path, size: tuple[int, int], values: int) -> Line:
    """Turn options on the page, and draw the same in a session."""
    session = gs.Session(photo)
    drawn = session.draw()
    numbers = np.random.default_rng(7)
    on_page, in_session, dragged = [], [], []
    turned = dict.fromkeys(TURNED, (np.inf, -np.inf))
    for option in TURNED:
        for place in numbers.uniform(*PLACES, values):
            on_page.append(page.evaluate(TURN, [option, place]))
            page.wait_for_function(AT_REST)
            value = float(page.locator(f'[data-option="{option}"] input[type=number]').input_value())
            turned[option] = (min(value, turned[option][0]), max(value, turned[option][1]))
            began = time.perf_counter()
            session.draw(gs.Options(**{option: value}))
            in_session.append(time.perf_counter() - began)
        dragged += page.evaluate(DRAG, [option, DRAGGED if values > 1 else 3])
        page.evaluate(BACK, option)
        page.wait_for_function(AT_REST)
    return Line(size, int(drawn.stats["nodes"]), on_page, in_session, dragged, turned)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Seconds from slider to picture in the studio, beside Session.draw.")
    parser.add_argument("--smoke", action="store_true", help="a tiny photo and single values: whether this still runs")
    arguments = parser.parse_args()
    program = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if program is None:
        sys.exit("Chromium is not installed: it measures nothing")
    sizes, values = (((60, 45),), TINY_VALUES) if arguments.smoke else (SIZES, VALUES)
    sandbox = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
    print(f"{len(TURNED)} options, {values} values of each, {os.cpu_count()} processors, Chromium, a window of 1280 x 900\n")
    groups = f"{'slider to whole, s':>22}{'Session.draw, s':>22}{'beyond, s':>11}{'while dragged, s':>22}"
    pair = f"{'median':>11}{'95 of 100':>11}"
    print(f"{'':<21}{groups}\n{'':<13}{'nodes':>8}{pair}{pair}{'median':>11}{pair}")
    lines = []
    with TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=sandbox)
        for size in sizes:
            photo = Path(folder, "photo.png")
            write_photo(photo, size, arguments.smoke)
            with studio(photo) as address:
                page = browser.new_page(viewport={"width": 1280, "height": 900})
                page.goto(address)
                page.wait_for_function(AT_REST)
                page.wait_for_function(ALL_PRESETS, arg=len(gs.presets()))
                lines.append(measured(page, photo, size, values))
                page.close()
            print(lines[-1], flush=True)
        browser.close()
    ranges = [f"{name} {least:.3g} to {most:.3g}" for name, (least, most) in lines[-1].turned.items()]
    print(f"\nvalues: {', '.join(ranges[:4])},\n        {', '.join(ranges[4:])}\n\nto reach")
    print("\n".join(line for it in lines for line in it.verdicts()))


if __name__ == "__main__":
    main()
