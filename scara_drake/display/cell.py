"""The scene of a run in the output of a notebook's cell: live while it goes on, to play after it.

What is left is the recording as a page of its own, which plays without a network, in the notebook
and in the HTML that is exported from it. Most of a megabyte of it is Meshcat's viewer, compressed;
the browser unpacks it.
"""

from __future__ import annotations

import base64
import gzip
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from html import escape
from pathlib import Path
from typing import Any, Final

from pydrake.geometry import Meshcat
from rich.console import Console

from scara_drake.common.checks import shown
from scara_drake.common.files import write_whole
from scara_drake.display.page import publish_recording, start_recording
from scara_drake.display.server import start_meshcat

HEIGHT: Final = 480  # of a scene in a cell [pixels]
# Runs the page that is packed in it. `gzip` is what browsers unpack by themselves.
_UNPACK: Final = """<!doctype html><script>
const packed = Uint8Array.from(atob("%s"), c => c.charCodeAt(0));
const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
new Response(stream).text().then(page => {
  document.open(); document.write(page); document.close();
});
</script>"""


class Scene:
    """What a Meshcat shows, with its published recording: an object that a notebook displays.

    Args:
        meshcat: with the scene.
        height: in a cell [pixels].
    """

    def __init__(self, meshcat: Meshcat, height: int = HEIGHT):
        self._page, self._height = meshcat.StaticHtml(), height

    def __repr__(self) -> str:
        return f"Scene ({len(self._page) / 1e6:.1f} MB)"

    def _repr_html_(self) -> str:
        packed = base64.b64encode(gzip.compress(self._page.encode(), mtime=0)).decode()
        return _frame("srcdoc", _UNPACK % packed, self._height)

    def save_html(self, path: str | Path) -> None:
        """Save it as one page that needs no network, whole or not at all.

        Raises:
            OSError: the folder cannot be written.
        """
        write_whole(path, self._page)


@contextmanager
def scene_of_run(meshcat: Meshcat | bool | None) -> Iterator[Meshcat | None]:
    """Give what draws a run: what is given, or, for True, the process's own Meshcat.

    The own one is in the cell while the context lasts, in a notebook, and leaves the recording
    there to be played; elsewhere its address is printed.

    Raises:
        ValueError: it is none of these.
    """
    if not isinstance(meshcat, Meshcat | bool | None):
        allowed = "True, False, None or a pydrake.geometry.Meshcat"
        raise ValueError(f"meshcat: {shown(meshcat)}, allowed {allowed}")
    if meshcat is not True:
        yield meshcat or None
        return
    own = own_meshcat()
    own.Delete()  # what the run before it left
    address = own.web_url()
    cell = _Cell() if in_notebook() else None
    if cell:
        cell.show(f"{_frame('src', address, HEIGHT)}<div>live: {escape(address)}</div>")
    else:
        Console().print(f"Scene: {address}", highlight=False, soft_wrap=True)
    start_recording(own)
    try:
        yield own
    finally:
        publish_recording(own)
        if cell:
            cell.show(Scene(own)._repr_html_())


def in_notebook() -> bool:
    """Whether what is displayed goes to a cell of a notebook."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    return hasattr(shell, "kernel")


@cache
def own_meshcat() -> Meshcat:
    """Return the process's own Meshcat, which serves all runs that are given none."""
    return start_meshcat()


def _frame(attribute: str, content: str, height: int) -> str:
    style = f"width:100%;height:{height}px;border:0"
    return f'<iframe {attribute}="{escape(content)}" style="{style}" loading="lazy"></iframe>'


class _Cell:
    """An output of the running cell that can be replaced."""

    def __init__(self) -> None:
        self._handle: Any = None

    def show(self, markup: str) -> None:
        """Show markup, in place of what was shown before."""
        from IPython.display import display

        bundle = {"text/html": markup, "text/plain": "Scene"}
        if self._handle is None:
            self._handle = display(bundle, raw=True, display_id=True)
        else:
            self._handle.update(bundle, raw=True)
