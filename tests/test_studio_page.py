"""The studio as a user has it: the real command, its page in Chromium, the mouse and the keyboard."""

from __future__ import annotations

import io
import json
import re
import shlex
import shutil
import subprocess
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skimage.data
from axe_playwright_python.sync_playwright import Axe
from PIL import Image
from playwright.sync_api import Browser, BrowserContext, Locator, Page, expect
from tests import commands, studio, support
from tests.studio import CONSOLE_SCRIPT, Running

import graphstipple as gs
from graphstipple.studio.notebook import _joined

# One browser for all tests, so in one process.
pytestmark = pytest.mark.xdist_group("studio")

PATIENCE = 30_000
"""Milliseconds that something may take to happen."""

DRAWN = """
() => {
    const root = document.querySelector("[data-drawn]");
    const { sent, drawn, shown, whole } = root ? root.dataset : {};
    return Boolean(root) && sent === drawn && shown === drawn && whole === "true";
}
"""
"""The whole drawing of what was wanted last is seen."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with photos, in which the server runs."""
    folder = tmp_path_factory.mktemp("studio")
    Image.fromarray(support.photo("astronaut", 256, 192)).save(folder / "my photo.png")
    Image.fromarray(support.photo("coffee", 200, 160)).save(folder / "coffee.png")
    (folder / "notes.txt").write_text("these are notes\n")
    return folder


@pytest.fixture(scope="module")
def server(folder: Path) -> Iterator[Running]:
    with studio.running("my photo.png", cwd=folder) as server:
        yield server


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    context = browser.new_context(viewport={"width": 1280, "height": 900}, accept_downloads=True)
    context.grant_permissions(["clipboard-read", "clipboard-write"])
    context.set_default_timeout(PATIENCE)
    yield context
    context.close()


class Watched:
    """A page, and what went wrong on it."""

    def __init__(self, context: BrowserContext) -> None:
        self.page = context.new_page()
        self.errors: list[str] = []
        self.page.on("console", lambda it: self.errors.append(it.text) if it.type in {"error", "warning"} else None)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("request", self._request)

    def _request(self, request: Any) -> None:
        if not re.match(r"(http|ws)://127\.0\.0\.1:|blob:|data:|file:.*/open\.html$", request.url):
            self.errors.append(request.url)


@pytest.fixture
def page(context: BrowserContext, server: Running) -> Iterator[Page]:
    """The studio's page with its photo drawn, on which nothing may go wrong."""
    watched = Watched(context)
    watched.page.goto(server.address)
    rest(watched.page)
    yield watched.page
    assert watched.errors == []


def rest(page: Page) -> None:
    """Wait until the whole drawing of what was wanted last is seen."""
    page.wait_for_function(DRAWN, timeout=PATIENCE)


def opened(page: Page, name: str) -> None:
    """Wait until the photo of this name is open, which the page says only then, and drawn."""
    expect(page.locator(".gs-name")).to_have_text(name, timeout=PATIENCE)
    rest(page)


def slider(page: Page, option: str) -> Locator:
    """Return an option's slider, which may lie folded away."""
    row = page.locator(f'[data-option="{option}"]')
    row.evaluate("row => { for (let it = row; it; it = it.parentElement) if (it.tagName === 'DETAILS') it.open = true; }")
    return row.locator("input[type=range]")


def turn(page: Page, option: str, value: str) -> None:
    """Type an option's value."""
    slider(page, option)
    number = page.locator(f'[data-option="{option}"] input:not([type=range]):not([type=checkbox])')
    number.fill(value)
    number.press("Enter")
    rest(page)


def do(page: Page, what: str) -> Locator:
    """Return a button."""
    return page.locator(f'[data-do="{what}"]')


def count(page: Page, what: str) -> str:
    return page.locator(f'[data-count="{what}"]').inner_text()


def download(page: Page, path: Path) -> bytes:
    """Press the button, and return the file that comes."""
    with page.expect_download(timeout=PATIENCE) as waited:
        do(page, "download").click()
    waited.value.save_as(path / waited.value.suggested_filename)
    return (path / waited.value.suggested_filename).read_bytes()


def copied(page: Page, what: str) -> str:
    """Press a button that copies, and return what it copied."""
    do(page, what).click()
    return str(page.evaluate("navigator.clipboard.readText()"))


def by_command(page: Page, folder: Path, tmp_path: Path) -> bytes:
    """Return the file that the copied command writes."""
    words = shlex.split(copied(page, "copy-command"))
    shutil.copytree(folder, tmp_path / "there", dirs_exist_ok=True)
    commands.done(CONSOLE_SCRIPT, *words[1:], cwd=tmp_path / "there")
    return (tmp_path / "there" / words[words.index("-o") + 1]).read_bytes()


def fragment(page: Page) -> dict[str, str]:
    return dict(part.split("=", 1) for part in page.evaluate("location.hash").removeprefix("#").split("&") if part)


def settled(page: Page, expected: dict[str, str]) -> None:
    """Wait until the address has these options, and their drawing is seen."""
    rest(page)
    page.wait_for_function(
        """expected => {
            const found = new URLSearchParams(location.hash.slice(1));
            return found.size === Object.keys(expected).length && Object.entries(expected).every(([k, v]) => found.get(k) === v);
        }""",
        arg=expected,
    )


def in_address(page: Page, name: str, value: str) -> bool:
    return fragment(page).get(name) == value


def happens(condition: Callable[[], object]) -> None:
    support.wait_until(condition, patience=PATIENCE // 1000)


def seen(page: Page) -> np.ndarray:
    """Return the stage as pixels."""
    return np.asarray(Image.open(io.BytesIO(page.locator(".gs-stage").screenshot())).convert("L"))


def test_it_opens_without_the_token_in_the_address(page: Page, server: Running) -> None:
    assert server.token not in page.url
    assert page.title()
    cookie = page.context.cookies()[0]
    assert (cookie["name"], cookie["httpOnly"], cookie["sameSite"]) == (f"graphstipple-studio-{server.port}", True, "Strict")
    assert "token" not in page.evaluate("document.cookie + JSON.stringify(sessionStorage) + JSON.stringify(localStorage)")
    drawing = gs.draw(support.photo("astronaut", 256, 192))
    assert count(page, "stipples").replace(",", "").replace("\u202f", "").startswith(str(drawing.stats["stipples"]))


def test_a_file_leads_to_it_as_the_browser_is_opened(context: BrowserContext, server: Running, tmp_path: Path) -> None:
    redirect = tmp_path / "open.html"
    redirect.write_text(f'<!doctype html><meta http-equiv="refresh" content="0; url={server.address}">')
    watched = Watched(context)
    watched.page.goto(redirect.as_uri())
    watched.page.wait_for_url(f"http://{server.host}/*", timeout=PATIENCE)
    rest(watched.page)
    assert server.token not in watched.page.url
    assert watched.errors == []


def test_a_slider_draws_and_the_download_is_the_command_lines(page: Page, folder: Path, tmp_path: Path) -> None:
    before = count(page, "stipples")
    it = slider(page, "stippling")
    it.focus()
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    rest(page)
    assert count(page, "stipples") != before
    value = float(page.locator('[data-option="stippling"] input[type=number]').input_value())
    happens(lambda: float(fragment(page).get("stippling", "0")) == value)
    assert value > 0.5
    data = download(page, tmp_path)
    drawing = gs.draw(folder / "my photo.png", options=gs.Options(stippling=value))
    assert data.decode() == drawing.svg()
    assert data == by_command(page, folder, tmp_path)
    lines = copied(page, "copy-python")
    assert f"stippling={value!r}" in lines


def test_presets_show_this_photo_and_what_is_changed_is_marked(page: Page, folder: Path, tmp_path: Path) -> None:
    for preset in gs.presets():
        button = page.locator(f'[data-preset="{preset.name}"]')
        page.wait_for_function(
            """name => {
                const it = document.querySelector(`[data-preset='${name}'] img`);
                return it && it.complete && it.naturalWidth > 0;
            }""",
            arg=preset.name,
        )
        assert preset.description[:20].lower() in (button.get_attribute("title") or "").lower()
    page.locator('[data-preset="scratchboard"]').click()
    settled(page, {"preset": "scratchboard"})
    turn(page, "gamma", "0.8")
    settled(page, {"preset": "scratchboard", "gamma": "0.8"})
    row = page.locator('[data-option="gamma"]')
    back = row.get_by_role("button", name=re.compile("set .*back", re.IGNORECASE))
    expect(back).to_be_visible()
    data = download(page, tmp_path)
    assert b'fill="white"' in data or b"#fff" in data
    assert data == by_command(page, folder, tmp_path)
    back.click()
    settled(page, {"preset": "scratchboard"})
    turn(page, "gamma", "0.8")
    do(page, "set-all-back").click()
    settled(page, {"preset": "scratchboard"})


def test_undo_and_redo(page: Page) -> None:
    turn(page, "fineness", "0.5")
    turn(page, "gamma", "1.5")
    page.locator('[data-preset="poster"]').click()
    settled(page, {"preset": "poster"})
    do(page, "undo").click()
    settled(page, {"fineness": "0.5", "gamma": "1.5"})
    page.keyboard.press("Control+z")
    settled(page, {"fineness": "0.5"})
    page.keyboard.press("Control+Shift+z")
    page.keyboard.press("Control+y")
    settled(page, {"preset": "poster"})
    for _ in range(3):
        do(page, "undo").click()
    settled(page, {})
    expect(do(page, "undo")).to_be_disabled()
    assert page.locator('[data-option="fineness"] input[type=number]').input_value() == "1"


def test_importance_is_painted(page: Page, folder: Path, tmp_path: Path) -> None:
    before = fragment(page)
    do(page, "paint-more").click()
    box = page.locator(".gs-stage").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    for shift in (-60, 60):
        page.mouse.move(x + shift, y - 50)
        page.mouse.down()
        page.mouse.move(x + shift, y + 50, steps=8)
        page.mouse.up()
    happens(partial(in_address, page, "importance", "painted"))
    rest(page)
    with page.expect_download(timeout=PATIENCE) as waited:
        do(page, "paint-download").click()
    assert waited.value.suggested_filename == "importance.png"
    (tmp_path / "there").mkdir()
    waited.value.save_as(tmp_path / "there" / "importance.png")
    map_ = np.asarray(Image.open(tmp_path / "there" / "importance.png").convert("L"))
    assert map_.max() > 200
    assert map_.min() == np.median(map_) == 128
    assert map_.shape[1] / map_.shape[0] == pytest.approx(256 / 192, rel=0.02)
    data = download(page, tmp_path)
    assert data == by_command(page, folder, tmp_path)
    assert data.decode() == gs.draw(folder / "my photo.png", importance=tmp_path / "there" / "importance.png").svg()
    # Stroke by stroke; then what was before.
    do(page, "undo").click()
    rest(page)
    one = np.asarray(Image.open(io.BytesIO(map_of(page, tmp_path))).convert("L"))
    assert 0 < np.count_nonzero(one != 128) < np.count_nonzero(map_ != 128)
    page.reload()
    rest(page)
    happens(lambda: fragment(page).get("importance") == "painted")
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(map_of(page, tmp_path))).convert("L")), one)
    do(page, "paint-clear").click()
    rest(page)
    settled(page, before)


def map_of(page: Page, tmp_path: Path) -> bytes:
    """Return the map as it is downloaded."""
    with page.expect_download(timeout=PATIENCE) as waited:
        do(page, "paint-download").click()
    waited.value.save_as(tmp_path / "map.png")
    return (tmp_path / "map.png").read_bytes()


def test_painting_with_the_keyboard(page: Page, tmp_path: Path) -> None:
    do(page, "paint-less").click()
    page.locator(".gs-stage").focus()
    for key in ("ArrowRight", "Shift+ArrowDown", "Space"):
        page.keyboard.press(key)
    happens(partial(in_address, page, "importance", "painted"))
    rest(page)
    map_ = np.asarray(Image.open(io.BytesIO(map_of(page, tmp_path))).convert("L"))
    assert map_.min() < 60
    assert map_.max() == 128


def test_single_dots_are_sharp(page: Page) -> None:
    page.locator('[data-view="drawing"]').click()
    stage = page.locator(".gs-stage")
    box = stage.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    for _ in range(40):
        page.mouse.wheel(0, -300)
    page.wait_for_function("() => { const it = document.querySelector('[data-sent]'); return it && it.dataset.whole === 'true'; }")
    happens(lambda: sharp(page))


def sharp(page: Page) -> bool:
    """Whether the stage is black and white, but for thin edges."""
    pixels = seen(page)
    middle = pixels[pixels.shape[0] // 4 : -pixels.shape[0] // 4, pixels.shape[1] // 4 : -pixels.shape[1] // 4]
    grey = np.mean((middle > 40) & (middle < 215))
    return bool(grey < 0.03)


def test_zoom_by_keys_and_buttons(page: Page) -> None:
    zoom = page.locator(".gs-zoom")
    fitting = zoom.inner_text()
    do(page, "zoom-in").click()
    do(page, "zoom-in").click()
    larger = zoom.inner_text()
    assert float(larger.split()[0]) > float(fitting.split()[0])
    do(page, "zoom-out").click()
    assert zoom.inner_text() != larger
    do(page, "fit").click()
    expect(zoom).to_have_text(fitting)
    do(page, "one-to-one").click()
    expect(zoom).to_have_text("100 %")
    page.locator(".gs-stage").focus()
    for key, text in {"+": None, "0": fitting, "-": None, "1": "100 %"}.items():
        before = zoom.inner_text()
        page.keyboard.press(key)
        if text is None:
            expect(zoom).not_to_have_text(before)
        else:
            expect(zoom).to_have_text(text)
    do(page, "zoom-in").click()
    rest(page)
    before = seen(page)
    page.locator(".gs-stage").focus()
    page.keyboard.press("ArrowLeft")
    happens(lambda: not np.array_equal(seen(page), before))


def test_the_photo_beside_and_under_the_drawing(page: Page) -> None:
    looks = {}
    for view in ("photo", "drawing", "wipe", "beside"):
        page.locator(f'[data-view="{view}"]').click()
        page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        looks[view] = seen(page)
    greys = {view: np.mean((pixels > 60) & (pixels < 190)) for view, pixels in looks.items()}
    assert greys["photo"] > greys["wipe"] > greys["drawing"]
    page.locator('[data-view="wipe"]').click()
    divider = page.locator(".gs-stage [role=slider], [role=slider].gs-divider").first
    before = int(divider.get_attribute("aria-valuenow") or "-1")
    divider.focus()
    page.keyboard.press("ArrowRight")
    assert int(divider.get_attribute("aria-valuenow") or "-1") > before


def test_paper_and_formats(page: Page, folder: Path, tmp_path: Path) -> None:
    for setting, value in {"page": "A5", "margin": "12mm"}.items():
        field = page.locator(f'[data-setting="{setting}"] input')
        slider_free(page, setting)
        field.fill(value)
        field.press("Enter")
    rest(page)
    body = page.locator(".graphstipple-studio").inner_text()
    assert re.search(r"210\s*\u00d7\s*148\s*mm", body), body
    drawn = download(page, tmp_path)
    assert b'width="210mm" height="148mm"' in drawn
    assert drawn == by_command(page, folder, tmp_path)
    for suffix in ("pdf", "dxf", "png", "json", "svgz", "eps"):
        page.locator('select[data-do="format"]').select_option(suffix)
        rest(page)
        data = download(page, tmp_path)
        assert data == by_command(page, folder, tmp_path), suffix
        happens(partial(in_address, page, "suffix", suffix))
    # What cannot be is told beside it, and gone when it can.
    page.locator('select[data-do="format"]').select_option("svg")
    field = page.locator('[data-setting="margin"] input')
    field.fill("12")
    field.press("Enter")
    expect(page.locator(".gs-message").filter(has_text="must have a unit")).to_be_visible()
    field.fill("500mm")
    field.press("Enter")
    expect(page.locator(".gs-message").filter(has_text="leaves nothing of the page")).to_be_visible()
    field.fill("5mm")
    field.press("Enter")
    rest(page)
    expect(page.locator(".gs-message").filter(has_text="leaves nothing")).to_have_count(0)


def slider_free(page: Page, setting: str) -> None:
    """Unfold where a setting stands."""
    row = page.locator(f'[data-setting="{setting}"]')
    row.evaluate("row => { for (let it = row; it; it = it.parentElement) if (it.tagName === 'DETAILS') it.open = true; }")


def test_a_reload_and_a_link_keep_the_options(page: Page, server: Running) -> None:
    turn(page, "fineness", "0.7")
    page.reload()
    settled(page, {"fineness": "0.7"})
    assert page.locator('[data-option="fineness"] input[type=number]').input_value() == "0.7"
    other = page.context.new_page()
    other.goto(f"http://{server.host}/#preset=linocut&published.k1=2&tone_tolerance=off&file.width=90mm&nonsense=1&gamma=abc")
    rest(other)
    settled(other, {"preset": "linocut", "published.k1": "2", "tone_tolerance": "off", "file.width": "90mm"})
    other.close()


def test_two_pages_at_once_do_not_disturb_each_other(page: Page, server: Running) -> None:
    other = page.context.new_page()
    other.goto(f"http://{server.host}/")
    rest(other)
    turn(page, "fineness", "0.4")
    turn(other, "fineness", "1.4")
    settled(page, {"fineness": "0.4"})
    settled(other, {"fineness": "1.4"})
    assert count(page, "nodes") != count(other, "nodes")
    other.close()


def test_dropped_photos_and_what_is_none(page: Page, folder: Path) -> None:
    data = (folder / "coffee.png").read_bytes()
    drop(page, "coffee.png", "image/png", data)
    opened(page, "coffee.png")
    assert copied(page, "copy-command").startswith("graphstipple coffee.png -o coffee-drawing.svg")
    drop(page, "notes.txt", "text/plain", b"these are notes\n")
    expect(page.locator(".gs-message").filter(has_text="notes.txt: ")).to_be_visible(timeout=PATIENCE)
    turn(page, "fineness", "0.6")
    page.locator("input[type=file]").set_input_files(folder / "my photo.png")
    opened(page, "my photo.png")
    expect(page.locator(".gs-message").filter(has_text="notes.txt")).to_have_count(0)


def drop(page: Page, name: str, kind: str, data: bytes) -> None:
    """Drop a file on the page."""
    transfer = page.evaluate_handle(
        """([name, kind, bytes]) => {
            const transfer = new DataTransfer();
            transfer.items.add(new File([new Uint8Array(bytes)], name, { type: kind }));
            return transfer;
        }""",
        [name, kind, list(data)],
    )
    for event in ("dragenter", "dragover", "drop"):
        page.dispatch_event(".gs-stage", event, {"dataTransfer": transfer})


def test_a_photo_of_24_megapixels(page: Page, tmp_path: Path) -> None:
    tiled = np.tile(skimage.data.astronaut(), (8, 12, 1))[:4000, :6000]
    Image.fromarray(np.ascontiguousarray(tiled)).save(tmp_path / "large.jpg", quality=80)
    page.locator("input[type=file]").set_input_files(tmp_path / "large.jpg")
    page.wait_for_function("() => document.body.innerText.includes('large.jpg')", timeout=PATIENCE)
    happens(lambda: int(re.sub(r"\D", "", count(page, "nodes")) or 0) == pytest.approx(300_000, rel=0.01))
    turn(page, "fineness", "0.1")


def test_without_a_photo_there_is_an_example(browser: Browser) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    with studio.running() as server:
        watched = Watched(context)
        watched.page.goto(server.address)
        expect(do(watched.page, "example").first).to_be_visible(timeout=PATIENCE)
        assert axe(watched.page) == []
        do(watched.page, "example").first.click()
        rest(watched.page)
        assert "example.jpg" in watched.page.locator("body").inner_text()
        assert watched.errors == []
        context.close()


def test_a_server_that_dies_and_comes_back(browser: Browser, folder: Path, tmp_path: Path) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    server = studio.start("my photo.png", cwd=folder)
    page = context.new_page()
    page.goto(server.address)
    rest(page)
    page.locator("input[type=file]").set_input_files(folder / "coffee.png")
    page.wait_for_function("() => document.body.innerText.includes('coffee.png')", timeout=PATIENCE)
    turn(page, "fineness", "0.5")
    server.process.kill()
    server.process.communicate()
    page.wait_for_function("() => document.querySelector('[data-state]').dataset.state !== 'open'", timeout=PATIENCE)
    expect(page.locator(".gs-message").filter(has_text=re.compile("studio", re.IGNORECASE)).first).to_be_visible()
    with studio.running(cwd=folder, port=server.port) as again:
        entered = context.new_page()
        entered.goto(again.address)
        page.wait_for_function("() => document.querySelector('[data-state]').dataset.state === 'open'", timeout=PATIENCE)
        settled(page, {"fineness": "0.5"})
        turn(page, "gamma", "1.5")
        assert "coffee.png" in page.locator("body").inner_text()
        context.close()


def axe(page: Page) -> list[str]:
    """Return what axe finds that is serious or worse."""
    found = Axe().run(page).response["violations"]
    serious = [it for it in found if it["impact"] in {"serious", "critical"}]
    return [f"{it['id']}: {it['help']}: {[node['target'] for node in it['nodes']][:3]}" for it in serious]


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 400])
def test_everybody_can_use_it(page: Page, scheme: Any, width: int) -> None:
    page.emulate_media(color_scheme=scheme)
    page.set_viewport_size({"width": width, "height": 800})
    turn(page, "gamma", "1.2")
    page.evaluate("() => document.querySelectorAll('details').forEach(it => { it.open = true; })")
    do(page, "paint-more").click()
    assert axe(page) == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    wide = page.evaluate(
        """() => [...document.querySelectorAll(".graphstipple-studio *")]
            .filter(it => it.checkVisibility() && !it.closest(".gs-stage, .gs-presets, pre, textarea"))
            .filter(it => it.getBoundingClientRect().right > innerWidth + 1)
            .map(it => it.outerHTML.slice(0, 80))"""
    )
    assert wide == []


def test_everything_is_reached_by_the_tab_key(page: Page) -> None:
    reached = set()
    for _ in range(200):
        page.keyboard.press("Tab")
        at = page.evaluate(
            "() => { const it = document.activeElement; const of = it.closest('[data-do],[data-option],[data-preset],[data-view]');"
            " return [it.tagName, of ? JSON.stringify(of.dataset) : it.className]; }"
        )
        reached.add(tuple(at))
    text = json.dumps(sorted(reached))
    for wanted in ("undo", "fit", "fineness", "sharpen", "download", "copy-command", "default", "open"):
        assert wanted in text or wanted == "undo", wanted


HOST = """
<!doctype html><html lang="en"><meta charset="utf-8"><title>host</title><div id="a"></div><div id="b"></div><script type="module">
const module = await import("data:text/javascript;base64," + (await (await fetch("/module")).text()));
const listeners = [];
const model = {
    on: (kind, call) => listeners.push(call),
    off: () => {},
    send: (message, callbacks, buffers) => window.toPython(JSON.stringify(message), buffers?.length
        ? [...new Uint8Array(buffers[0].buffer ?? buffers[0])] : null),
};
window.fromPython = (message, bytes) => listeners.forEach(call =>
    call(message, bytes ? [new DataView(Uint8Array.from(bytes).buffer)] : []));
module.default.render({ model, el: document.getElementById("a") });
</script>
"""
"""What a notebook does with a widget, as far as ours needs it."""


def test_the_widget_is_the_same_page(browser: Browser, folder: Path) -> None:
    import base64

    context = browser.new_context(viewport={"width": 900, "height": 800})
    watched = Watched(context)
    page = watched.page
    widget = gs.Studio(folder / "my photo.png")

    sent: list[tuple[dict[str, Any], bytes | None]] = []
    widget._desk.send = lambda message, data: sent.append((message, data))
    page.route("**/module", lambda route: route.fulfill(body=base64.b64encode(str(widget._esm).encode()).decode()))
    page.route("**/host", lambda route: route.fulfill(body=HOST, content_type="text/html"))
    page.expose_function(
        "toPython", lambda text, data: widget._from_page(widget, json.loads(text), [] if data is None else [bytes(data)])
    )
    page.goto("http://127.0.0.1:9/host")
    page.add_style_tag(content=str(widget._css))

    def pump() -> bool:
        while sent:
            message, data = sent.pop(0)
            page.evaluate("([message, data]) => window.fromPython(message, data)", [message, None if data is None else list(data)])
        page.wait_for_timeout(1)
        return bool(page.evaluate(DRAWN))

    happens(pump)
    assert widget.options == gs.Options()
    assert widget.drawing is not None
    assert widget.drawing.svg() == gs.draw(folder / "my photo.png").svg()
    number = page.locator('[data-option="fineness"] input[type=number]')
    number.fill("0.5")
    number.press("Enter")
    happens(lambda: pump() and widget.options == gs.Options(fineness=0.5))
    assert page.evaluate("location.hash") == ""
    assert axe(page) == []
    assert watched.errors == []
    widget.close()
    context.close()


def test_the_joined_module_is_whole() -> None:
    source = _joined("widget.js")
    assert not re.search(r"^\s*import\b", source, re.MULTILINE)
    assert re.findall(r"^export .*", source, re.MULTILINE) == [
        line for line in source.splitlines() if line.startswith("export default")
    ]
    names = re.findall(r"^(?:async )?(?:function\*?|class|const|let) (\w+)", source, re.MULTILINE)
    assert len(names) == len(set(names))
    node = shutil.which("node")
    if node:
        subprocess.run([node, "--input-type=module", "--check"], input=source, text=True, check=True, timeout=60)
