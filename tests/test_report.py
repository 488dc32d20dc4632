"""The report in a real browser: pages load whole, tables hold the numbers of the results, one zoom moves all pictures."""

from __future__ import annotations

import io
import json
import math
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlparse

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Page
from tests import support

from graphstipple_eval import quoted

# One report for all tests, so in one process.
pytestmark = pytest.mark.xdist_group("report")

METHODS = ("graphstipple", "paper", "paper-alpha-1", "no-area", "threshold", "floyd-steinberg", "lbg")
VALUES = (0, 12)
PHOTOS = ("astronaut", "camera #2")
"""One of the names needs quoting in links."""

METRICS = ("near_lpips_alex", "near_lpips_vgg", "near_psnr", "near_ssim", "near_msssim")
METRICS += ("far_lpips_alex", "far_psnr", "far_ssim", "far_msssim")
METRICS += ("farther_psnr", "farther_ssim", "flip_40", "flip_80", "flip_160", "local_tone", "tone_error")

LABYRINTH = ("small_regions", "boundary")
"""Numbers that our own drawings alone have."""

EVENNESS = ("evenness", "evenness_deviation")
"""Numbers that drawings with dots alone have."""


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory, weights: None) -> Path:
    """The report of a small evaluation, by the real command."""
    folder = tmp_path_factory.mktemp("evaluation")
    (folder / "photos").mkdir()
    for name, crop in zip(PHOTOS, ("astronaut", "camera"), strict=True):
        Image.fromarray(support.photo(crop, 200, 190)).save(folder / "photos" / f"{name}.png")
    sweep = f"published.detail_gain={','.join(map(str, VALUES))}"
    arguments = ["photos", "--methods", ",".join(METHODS), "--sweep", sweep, "--size", "180"]
    command = [sys.executable, "-m", "graphstipple_eval", *arguments, "--out", "report"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=300)
    return folder / "report"


@pytest.fixture(scope="module")
def pictures(report: Path) -> list[dict[str, Any]]:
    """What results.json says of each picture."""
    entries: list[dict[str, Any]] = json.loads((report / "results.json").read_text())["pictures"]
    assert len(entries) == len(PHOTOS) * (len(METHODS) + len(VALUES))
    return entries


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    """A page that must not meet an error."""
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    page.add_init_script(CLOCK)
    errors: list[str] = []
    page.on("console", lambda message: errors.append(message.text) if message.type in {"error", "warning"} else None)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("requestfailed", lambda request: errors.append(f"{request.url} failed"))
    page.on("request", lambda request: None if request.url.startswith(("file:", "data:")) else errors.append(request.url))
    yield page
    page.close()
    assert errors == []


def pages_of(report: Path) -> list[Path]:
    return sorted(report.rglob("*.html"))


def numbers(picture: dict[str, Any]) -> dict[str, float | None]:
    """Return all numbers of a picture."""
    own = {"seconds": picture["seconds"], "svg_bytes": picture["svg_bytes"]}
    own |= picture["metrics"] | picture["counts"] | picture["labyrinth"] | picture["evenness"]
    found = dict.fromkeys(LABYRINTH + EVENNESS) | own
    return {name: None if value is None else float(value) for name, value in found.items()}


def mean(pictures: list[dict[str, Any]], method: str, key: str) -> float | None:
    """Return the mean of a number of a method over the photos that have it."""
    found = [value for picture in pictures if picture["method"] == method and (value := numbers(picture)[key]) is not None]
    return math.fsum(found) / len(found) if found else None


def printed(text: str) -> float | None:
    """Return the number that a cell shows."""
    if text == "\N{EN DASH}":
        return None
    return float(text.replace("\N{NARROW NO-BREAK SPACE}", "").replace("\N{MINUS SIGN}", "-").replace("∞", "inf"))


def cells(page: Page, table: str) -> dict[tuple[str, str], str]:
    """Return the text of a table's measured cells by method and number."""
    script = """table => Object.fromEntries([...table.querySelectorAll("tbody.measured tr")].map(row => [row.dataset.method,
        [...row.cells].slice(1).map(cell => cell.textContent.trim())]))"""
    keys = page.locator(f"{table} thead th[data-key]").evaluate_all("cells => cells.map(cell => cell.dataset.key)")
    rows: dict[str, list[str]] = page.locator(table).evaluate(script)
    return {(method, key): text for method, row in rows.items() for key, text in zip(keys, row, strict=False)}


def assert_same(text: str, value: float | None, digits: int) -> None:
    """Check that a cell shows a value, rounded to so many digits."""
    shown = printed(text)
    if value is None or shown is None:
        assert shown is value
    else:
        assert shown == pytest.approx(value, abs=0.5 * 10**-digits + 1e-9)
        assert len(text.partition(".")[2]) == digits


def digits(key: str) -> int:
    if key in {"near_psnr", "far_psnr", "farther_psnr", "boundary", "seconds"}:
        return 2
    return {"tone_error": 4, "small_regions": 1}.get(key, 3 if key in METRICS + EVENNESS else 0)


def test_there_is_a_page_for_every_photo(report: Path) -> None:
    names = [path.relative_to(report).as_posix() for path in pages_of(report)]
    assert names == ["index.html", *(f"photos/{name}-180.html" for name in PHOTOS), "protocol.html"]


def test_every_page_and_what_it_names_loads(report: Path, page: Page) -> None:
    for path in pages_of(report):
        page.goto(path.as_uri())
        sizes = page.locator("img").evaluate_all(
            """images => Promise.all(images.map(async image => {
                image.loading = "eager";
                await image.decode();
                return image.naturalWidth;
            }))"""
        )
        assert all(width > 0 for width in sizes)
        links = page.locator("a").evaluate_all("links => links.map(link => link.href)")
        for link in links:
            place = urlparse(link)
            assert place.scheme == "file"
            assert Path(unquote(place.path)).is_file(), link
            if place.fragment:
                assert page.locator(f'[id="{place.fragment}"]').count() == 1
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), f"{path.name} is wider than the window"


@pytest.mark.parametrize(
    ("table", "methods"),
    [
        ("#table-quality-180", ["graphstipple", "paper", "threshold", "floyd-steinberg", "lbg"]),
        ("#table-counts-180", ["graphstipple", "paper", "threshold", "floyd-steinberg", "lbg"]),
        ("#table-seen-180", list(METHODS)),
        ("#table-ablations-180", ["paper-alpha-1", "paper"]),
        ("#table-ideas-180", ["graphstipple", "no-area", "paper"]),
        ('[id="table-sweep-published.detail_gain-180"]', [f"published.detail_gain={value}" for value in VALUES]),
    ],
)
def test_tables_show_the_means_of_the_results(
    report: Path, page: Page, pictures: list[dict[str, Any]], table: str, methods: list[str]
) -> None:
    page.goto((report / "index.html").as_uri())
    shown = cells(page, table)
    assert {method for method, _ in shown} == set(methods)
    for (method, key), text in shown.items():
        assert_same(text, mean(pictures, method, key), digits(key))
    assert len({key for _, key in shown}) >= 8


def test_the_best_of_a_column_is_bold(report: Path, page: Page, pictures: list[dict[str, Any]]) -> None:
    page.goto((report / "index.html").as_uri())
    column = "td:nth-child(8)"  # far PSNR
    bold = page.locator(f"#table-quality-180 tr[data-method] {column}.best")
    values = [mean(pictures, method, "far_psnr") for method in METHODS if method not in {"paper-alpha-1", "no-area"}]
    assert bold.count() == 1
    assert_same(bold.inner_text(), max(value for value in values if value is not None), 2)
    assert int(bold.evaluate("cell => getComputedStyle(cell).fontWeight")) > 600


def test_quoted_figures_are_marked_and_apart(report: Path, page: Page) -> None:
    page.goto((report / "index.html").as_uri())
    assert page.locator("#table-quality-180 .quoted").count() == 0
    headings = page.locator("#table-quoted-180 thead th")
    assert headings.all_inner_texts() == ["method", "LPIPS ↓", "PSNR ↑", "MSSIM ↑"]
    assert page.locator("#table-quoted-180 caption").inner_text().startswith("Quoted from the paper")
    rows = page.locator("#table-quoted-180 tbody tr")
    assert rows.count() == len(quoted.QUALITY)
    for row, entry in zip(rows.all(), quoted.QUALITY, strict=True):
        assert row.locator(".badge").inner_text() == "quoted"
        assert [float(text) for text in row.locator("td").all_inner_texts()] == [entry.lpips, entry.psnr, entry.msssim]
    ablation = page.locator('#table-ablations-180 tr[data-method="paper-alpha-1"] td.quoted')
    assert ablation.all_inner_texts() == ["0.564", "17.59", "0.389"]


def test_a_click_on_a_heading_sorts(report: Path, page: Page, pictures: list[dict[str, Any]]) -> None:
    page.goto((report / "index.html").as_uri())
    heading = page.locator('#table-counts-180 th[data-key="coordinates"] button')
    order = """rows => rows.map(row => row.dataset.method)"""
    rows = page.locator("#table-counts-180 tbody.measured tr")
    for turned in (False, True):
        heading.click()
        methods = rows.evaluate_all(order)
        values = [mean(pictures, method, "coordinates") for method in methods]
        known = [value for value in values if value is not None]
        assert known == sorted(known, reverse=turned)
        assert values[: len(known)] == known  # those without a value come last


def test_a_photo_s_page_shows_each_picture_with_its_own_figures(report: Path, page: Page, pictures: list[dict[str, Any]]) -> None:
    for name in PHOTOS:
        page.goto((report / "photos" / f"{name}-180.html").as_uri())
        own = {picture["method"]: picture for picture in pictures if picture["photo"] == name}
        panes = page.locator(".pane")
        assert panes.evaluate_all("panes => panes.map(pane => pane.dataset.method)") == ["photo", *own]
        for method, picture in own.items():
            pane = page.locator(f'.pane[data-method="{method}"]')
            for shown in pane.locator("[data-key]").all():
                text = shown.inner_text()
                key = shown.get_attribute("data-key")
                assert key is not None
                if text:
                    assert_same(text, numbers(picture)[key], digits(key))
                else:
                    assert key in {"far_lpips_vgg", "farther_lpips_alex", "farther_lpips_vgg", "farther_msssim"}
            png = next(file for file in picture["files"] if file.endswith(".png"))
            assert unquote(str(pane.locator("img").get_attribute("src"))) == f"../{png}"
        shown_in_tables = cells(page, "#table-quality") | cells(page, "#table-seen") | cells(page, "#table-counts")
        assert {key for _, key in shown_in_tables} == set(numbers(pictures[0]))
        for (method, key), text in shown_in_tables.items():
            assert_same(text, numbers(own[method])[key], digits(key))
        for table in ("#table-quality", "#table-seen", "#table-counts"):
            assert page.locator(table).evaluate("table => table.parentElement.scrollWidth <= table.parentElement.clientWidth")


@pytest.mark.parametrize("width", [1024, 1280])
def test_captions_stay_within_their_panes(report: Path, page: Page, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 900})
    page.goto((report / "photos" / f"{PHOTOS[0]}-180.html").as_uri())
    page.locator(".controls select").select_option("6")
    page.locator("details").evaluate_all("all => all.forEach(details => { details.open = true; })")
    outside = """panes => panes.flatMap(pane => [...pane.querySelectorAll("figcaption *")].filter(part =>
        part.getBoundingClientRect().right > pane.getBoundingClientRect().right + 0.5).map(part => part.outerHTML))"""
    assert page.locator(".pane").evaluate_all(outside) == []
    widths = page.locator(".pane").evaluate_all("panes => panes.map(pane => pane.getBoundingClientRect().width)")
    assert min(widths) >= 260
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_as_many_columns_as_are_asked_for_where_they_fit(report: Path, page: Page) -> None:
    page.set_viewport_size({"width": 1920, "height": 900})
    page.goto((report / "photos" / f"{PHOTOS[0]}-180.html").as_uri())
    for wanted in range(1, 7):
        page.locator(".controls select").select_option(str(wanted))
        tops = page.locator(".pane").evaluate_all("panes => panes.map(pane => pane.getBoundingClientRect().top)")
        assert tops.count(tops[0]) == wanted


# The zoom

CLOCK = "window.clock = 0; performance.now = () => clock"
"""The clock of the page, which stands still: whether it is at rest is for the tests to say."""


def transforms(page: Page) -> list[list[float]]:
    """Return of every picture: its scale, and its left and top edge in its window as shares of the window."""
    script = """images => images.map(image => {
        const [inner, outer] = [image.getBoundingClientRect(), image.parentElement.getBoundingClientRect()];
        return [inner.width / outer.width, (inner.left - outer.left) / outer.width, (inner.top - outer.top) / outer.height];
    })"""
    result: list[list[float]] = page.locator(".window img").evaluate_all(script)
    return result


def moved_together(page: Page) -> list[float]:
    """Return how all pictures are scaled and moved, having checked that it is the same for all."""
    first, *others = transforms(page)
    assert len(others) == len(METHODS) + len(VALUES)
    for other in others:
        assert other == pytest.approx(first, abs=1e-3)
    return first


@pytest.fixture
def viewer(report: Path, page: Page) -> Page:
    page.goto((report / "photos" / f"{PHOTOS[0]}-180.html").as_uri())
    assert moved_together(page) == pytest.approx([1, 0, 0], abs=1e-6)
    return page


def point_at(page: Page, pane: int, x: float, y: float) -> None:
    """Move the mouse over a pane, to a place in shares of it, on a page that is at rest."""
    window = page.locator(".window").nth(pane)
    window.scroll_into_view_if_needed()
    # The page has seen that it was scrolled, and then some time passes.
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    page.evaluate("clock += 1000")
    box = window.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + x * box["width"], box["y"] + y * box["height"])


def test_the_wheel_zooms_all_pictures_about_the_mouse(viewer: Page) -> None:
    point_at(viewer, 2, 0.75, 0.25)
    viewer.mouse.wheel(0, -100)
    viewer.mouse.wheel(0, -100)
    viewer.wait_for_function("getComputedStyle(document.querySelector('.viewer')).getPropertyValue('--scale') > 2")
    scale, left, top = moved_together(viewer)
    assert scale == pytest.approx(1.5**2)
    assert left == pytest.approx(0.75 * (1 - scale), abs=0.01)
    assert top == pytest.approx(0.25 * (1 - scale), abs=0.01)
    for _ in range(3):
        viewer.mouse.wheel(0, 100)
    viewer.wait_for_function("!document.querySelector('.viewer').classList.contains('zoomed')")
    assert moved_together(viewer) == pytest.approx([1, 0, 0], abs=1e-3)


def test_dragging_moves_all_pictures_and_stops_at_their_edges(viewer: Page) -> None:
    viewer.locator('[data-zoom="in"]').click()
    before = moved_together(viewer)
    point_at(viewer, 1, 0.5, 0.5)
    viewer.mouse.down()
    point_at(viewer, 1, 0.6, 0.45)
    viewer.mouse.up()
    scale, left, top = moved_together(viewer)
    assert scale == before[0] == pytest.approx(1.5)
    assert left - before[1] == pytest.approx(0.1, abs=0.01)
    assert top - before[2] == pytest.approx(-0.05, abs=0.01)
    point_at(viewer, 1, 0.2, 0.2)  # the button is up: nothing moves
    assert moved_together(viewer) == [scale, left, top]
    viewer.mouse.down()
    point_at(viewer, 1, 0.9, 0.9)
    viewer.mouse.up()
    assert moved_together(viewer) == pytest.approx([1.5, 0, 0], abs=1e-3)


def test_buttons_and_keys_zoom_and_move(viewer: Page) -> None:
    viewer.locator('[data-zoom="in"]').click()
    assert moved_together(viewer) == pytest.approx([1.5, -0.25, -0.25], abs=1e-3)
    viewer.keyboard.press("ArrowRight")
    assert moved_together(viewer) == pytest.approx([1.5, -0.35, -0.25], abs=1e-3)
    viewer.keyboard.press("+")
    assert moved_together(viewer)[0] == pytest.approx(1.5**2)
    viewer.keyboard.press("-")
    viewer.locator('[data-zoom="out"]').click()
    assert moved_together(viewer) == pytest.approx([1, 0, 0], abs=1e-3)
    viewer.locator("select").select_option("2")
    viewer.keyboard.press("1")
    viewer.locator('[data-zoom="pixels"]').click()
    moved_together(viewer)
    viewer.keyboard.press("0")
    assert moved_together(viewer) == pytest.approx([1, 0, 0], abs=1e-3)


def test_one_to_one_shows_a_pixel_of_the_picture_as_a_pixel_of_the_screen(viewer: Page) -> None:
    viewer.locator(".controls select").select_option("2")
    box = viewer.locator(".window").first.bounding_box()
    assert box is not None
    assert box["width"] > 500  # the picture has 180
    assert viewer.locator("output").inner_text() == f"{round(100 * box['width'] / 180)} %"
    viewer.locator('[data-zoom="pixels"]').click()
    scale, left, top = moved_together(viewer)
    assert scale * box["width"] == pytest.approx(180, abs=0.01)
    assert (left, top) == pytest.approx((0, 0), abs=1e-3)
    assert viewer.locator("output").inner_text() == "100 %"
    viewer.locator('[data-zoom="out"]').click()
    assert moved_together(viewer)[0] == pytest.approx(scale)
    viewer.locator('[data-zoom="reset"]').click()
    assert moved_together(viewer) == pytest.approx([1, 0, 0], abs=1e-3)


def test_the_wheel_scrolls_a_page_that_is_not_at_rest(viewer: Page) -> None:
    viewer.set_viewport_size({"width": 1280, "height": 500})
    point_at(viewer, 0, 0.5, 0.5)
    viewer.mouse.wheel(0, 100)
    viewer.wait_for_function("scrollY == 100")
    viewer.mouse.wheel(0, -40)
    viewer.wait_for_function("scrollY == 60")
    assert moved_together(viewer)[0] == 1
    point_at(viewer, 0, 0.4, 0.5)
    before = viewer.evaluate("scrollY")
    viewer.mouse.wheel(0, -100)
    viewer.wait_for_function("document.querySelector('.viewer').classList.contains('zoomed')")
    assert moved_together(viewer)[0] == pytest.approx(1.5)
    assert viewer.evaluate("scrollY") == before


def test_the_wheel_with_ctrl_zooms_at_any_time(viewer: Page) -> None:
    viewer.set_viewport_size({"width": 1280, "height": 500})
    point_at(viewer, 0, 0.5, 0.5)
    viewer.mouse.wheel(0, 100)
    viewer.wait_for_function("scrollY == 100")
    viewer.keyboard.down("Control")
    viewer.mouse.wheel(0, -100)
    viewer.keyboard.up("Control")
    viewer.wait_for_function("document.querySelector('.viewer').classList.contains('zoomed')")
    assert viewer.evaluate("scrollY") == 100


def test_a_finger_scrolls_the_page_over_whole_pictures(viewer: Page) -> None:
    touch = "window => getComputedStyle(window).touchAction"
    assert viewer.locator(".window").first.evaluate(touch) == "pan-y"
    viewer.locator('[data-zoom="in"]').click()
    assert viewer.locator(".window").first.evaluate(touch) == "none"


def test_far_in_every_pane_shows_the_same_pixels_of_its_own_picture(viewer: Page, report: Path) -> None:
    for _ in range(9):
        point_at(viewer, 3, 0.3, 0.6)
        viewer.mouse.wheel(0, -100)
    viewer.wait_for_function("getComputedStyle(document.querySelector('.viewer')).getPropertyValue('--scale') > 38")
    scale, left, top = moved_together(viewer)
    for window in viewer.locator(".window").all():
        image = window.locator("img")
        assert image.evaluate("image => getComputedStyle(image).imageRendering") == "pixelated"
        with Image.open(report / "photos" / unquote(str(image.get_attribute("src")))) as file:
            pixels = np.asarray(file)
        with Image.open(io.BytesIO(window.screenshot())) as file:
            shown = np.asarray(file.convert("L"))
        # The pixel of the picture that lies under the centre of each pixel of the screen.
        height, width = shown.shape
        columns = ((np.arange(width) + 0.5) / width - left) / scale * pixels.shape[1]
        rows = ((np.arange(height) + 0.5) / height - top) / scale * pixels.shape[0]
        expected = pixels[rows.astype(int)[:, np.newaxis], columns.astype(int)]
        # Edges of pixels and the outline of the pane may fall one screen pixel to either side.
        assert np.mean(np.abs(shown.astype(int) - expected) <= 2) > 0.8
