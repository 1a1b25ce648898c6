"""Pictures of Meshcat pages, taken by Debian's chromium without a display, and their colours."""

from __future__ import annotations

import base64
import io
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

CHROMIUM = shutil.which("chromium")
ARGUMENTS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
]

Picture = NDArray[np.uint8]  # (height, width, 3)


@dataclass
class Page:
    """An open Meshcat page, live or saved."""

    page: Any  # playwright's
    failed: list[str] = field(default_factory=list)  # requests that failed
    requested: list[str] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)  # errors of its scripts

    def wait(self, seconds: float) -> None:
        self.page.wait_for_timeout(1000 * seconds)

    def press(self, key: str) -> None:
        self.page.keyboard.press(key)

    def seek(self, time: float) -> None:
        """Show a saved recording at a time [s]."""
        self.page.evaluate("t => { viewer.animator.pause(); viewer.animator.seek(t); }", time)

    def position(self, path: str) -> list[float]:
        """Place of a scene path in its parent, such as "drake/annotations/ghost"."""
        script = "path => viewer.scene_tree.find(path.split('/')).object.position.toArray()"
        return self.page.evaluate(script, path)

    def picture(self, width: int = 640, height: int = 400) -> Picture:
        url = self.page.evaluate(f"viewer.capture_image({width}, {height})")
        data = base64.b64decode(url.split(",", 1)[1])
        image = Image.open(io.BytesIO(data)).convert("RGBA")
        white = Image.new("RGBA", image.size, "white")
        return np.asarray(Image.alpha_composite(white, image).convert("RGB"))


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser, to be shared by several `open_page`: starting it takes seconds."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield browser
        browser.close()


@contextmanager
def open_page(browser: Any, url: str, offline: bool = False) -> Iterator[Page]:
    """Open a page; `url` is Meshcat's web_url() or a file:// address of a saved page."""
    context = browser.new_context(viewport={"width": 640, "height": 400}, offline=offline)
    page = context.new_page()
    opened = Page(page)
    page.on("request", lambda request: opened.requested.append(request.url[:80]))
    page.on("requestfailed", lambda request: opened.failed.append(request.url[:80]))
    page.on("pageerror", lambda error: opened.messages.append(str(error)))
    page.goto(url)
    page.wait_for_function("typeof viewer !== 'undefined'")
    opened.wait(1.0)  # the scene comes in over a socket
    yield opened
    context.close()


def count_near(picture: Picture, rgb: tuple[float, float, float], tolerance: float = 0.1) -> int:
    """Pixels whose red, green and blue (0..1) are each within `tolerance` of a colour."""
    difference = picture.astype(float) / 255.0 - np.array(rgb)
    return int((np.abs(difference).max(axis=-1) < tolerance).sum())


def count_hue(picture: Picture, low: float, high: float, saturation: float = 0.4) -> int:
    """Pixels of hue low..high [degrees, may wrap], whatever light falls on them."""
    h, s, v = np.moveaxis(np.asarray(Image.fromarray(picture).convert("HSV"), float), -1, 0)
    degrees = h * 360.0 / 255.0
    inside = (degrees - low) % 360.0 <= (high - low) % 360.0
    return int((inside & (s / 255.0 > saturation) & (v / 255.0 > 0.15)).sum())


def save(picture: Picture, path: str) -> None:
    Image.fromarray(picture).save(path)


needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")
