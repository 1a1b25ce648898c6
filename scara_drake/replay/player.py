"""Play a recording where Drake has no wheel, as on Windows: meshcat-python draws, numpy moves.

    python -m scara_drake.replay runs/teleoperation.nc [--speed 2] [--html page.html]

Needs the extra ``replay``. The robot is that of models/scara6.urdf, the surfaces are those of the
scenario kept in the recording. The poses of all frames are worked out at once, then shown one after
the other or written into a page.
"""

from __future__ import annotations

import argparse
import io
import math
import sys
import time
import webbrowser
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import Any

import meshcat
import numpy as np

from scara_drake.common.files import write_whole
from scara_drake.replay.page import animation_of
from scara_drake.replay.recording import load
from scara_drake.replay.scene import Poses, draw


@contextmanager
def _scene(path: str | Path, speed: float, fps: float) -> Iterator[tuple[Any, Poses]]:
    """Draw a recording in a Meshcat whose server process ends with the context."""
    for name, value in (("speed", speed), ("fps", fps)):
        if not 0.0 < value < math.inf:
            raise ValueError(f"{name}: {value}, allowed more than 0")
    data, blocks = load(path)
    # In a thread that is waited for: an interrupt cannot lose the process while it starts.
    with ThreadPoolExecutor(1) as pool, redirect_stdout(io.StringIO()):
        viewer = pool.submit(meshcat.Visualizer).result()
    try:
        yield viewer, draw(viewer, data, blocks, speed / fps)
    finally:
        viewer.window.zmq_socket.close(linger=0)
        viewer.window.server_proc.kill()
        viewer.window.server_proc.communicate()


def replay(
    path: str | Path, speed: float = 1.0, fps: float = 30, open_browser: bool = False
) -> None:
    """Play a recording once, `speed` times as fast as it was; print the address of the scene.

    At most `fps` pictures each second. With `open_browser` it starts when the browser is there.

    Raises:
        ValueError: no such recording, or a number that is not above 0.
    """
    with _scene(path, speed, fps) as (viewer, poses):
        sys.stdout.write(f"Scene: {viewer.url()}\n")
        sys.stdout.flush()
        if open_browser and webbrowser.open(viewer.url()):
            viewer.wait()
        shown, last, start = 0, len(poses["force"]) - 1, time.monotonic()
        while shown < last:
            time.sleep(max(0.0, start + (shown + 1) / fps - time.monotonic()))
            frame = min(max(shown + 1, int((time.monotonic() - start) * fps)), last)
            for name, X in poses.items():
                if not np.array_equal(X[frame], X[shown]):
                    viewer[name].set_transform(X[frame])
            shown = frame


def animation_page(path: str | Path, html: str | Path, speed: float = 1.0, fps: float = 30) -> None:
    """Write a page that plays a recording in any browser, without network and without Python.

    The file appears whole or not at all.

    Raises:
        ValueError: as `replay`, or `html` does not end in .html.
        OSError: the page cannot be written.
    """
    if Path(html).suffix != ".html":
        raise ValueError(f"html: '{html}', allowed a file that ends in .html")
    with _scene(path, speed, fps) as (viewer, poses):
        viewer.set_animation(animation_of(viewer, poses, fps))
        write_whole(html, viewer.static_html())


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status: 0, or 2 for bad input."""
    parser = argparse.ArgumentParser(
        prog="python -m scara_drake.replay", description=(__doc__ or "").partition("\n")[0]
    )
    parser.add_argument("recording", type=Path, metavar="FILE.nc")
    parser.add_argument("--speed", type=float, default=1.0, help="2 plays twice as fast")
    parser.add_argument("--html", type=Path, metavar="FILE.html", help="write a page instead")
    parser.add_argument("--open", action="store_true", help="open a browser and wait for it")
    options = parser.parse_args(arguments)
    try:
        if options.html:
            animation_page(options.recording, options.html, options.speed)
        else:
            replay(options.recording, options.speed, open_browser=options.open)
    except (ValueError, OSError) as error:
        sys.stderr.write(f"replay: {error}\n")
        return 2
    except KeyboardInterrupt:
        return 130
    return 0
