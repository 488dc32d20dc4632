"""Make the picture of the studio: ``python docs/screenshot.py``, into docs/images. Chromium has to be installed.

The photo is the studio's own example, as a new user sees it; the drawing is wiped over half of it, and one option is changed.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

IMAGES = Path(__file__).parent / "images"
SIZE = (1280, 860)
COLOURS = 128
"""Of the picture: line art and few colours, in a fraction of the bytes."""

DRAWN = """
() => {
    const { sent, drawn, shown, whole } = document.querySelector("[data-drawn]")?.dataset ?? {};
    return sent !== undefined && sent === drawn && shown === drawn && whole === "true";
}
"""
"""The whole drawing of what was wanted last is seen."""

PRESETS = "() => [...document.querySelectorAll('[data-preset] img')].every(it => it.complete && it.naturalWidth > 0)"


def main() -> None:
    """Run the studio, use it, and take its picture."""
    program = next(found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name)))
    command = [str(Path(sys.executable).with_name("graphstipple")), "studio", "--port", "0", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as studio, sync_playwright() as playwright:
        try:
            found = re.search(r"http://\S+", studio.stdout.readline() if studio.stdout else "")
            assert found, "the studio did not begin"
            sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
            page = playwright.chromium.launch(executable_path=program, args=sandbox).new_page(
                viewport={"width": SIZE[0], "height": SIZE[1]}, color_scheme="light", reduced_motion="reduce"
            )
            page.goto(found[0])
            page.locator('.gs-empty [data-do="example"]').click()
            page.wait_for_function(DRAWN)
            page.wait_for_function(PRESETS)
            page.locator('[data-view="wipe"]').click()
            number = page.locator('[data-option="fineness"] input[type=number]')
            number.fill("0.6")
            number.press("Enter")
            page.wait_for_function(DRAWN)
            page.wait_for_function("() => /B/.test(document.querySelector('[data-count=\"bytes\"]').textContent)")
            page.mouse.click(640, 20)
            picture = IMAGES / "studio.png"
            page.screenshot(path=picture)
        finally:
            studio.terminate()
    with Image.open(picture) as image:
        few = image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    few.save(picture, optimize=True)


if __name__ == "__main__":
    main()
