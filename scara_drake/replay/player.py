"""Play a recording where Drake has no wheel, as on Windows: meshcat-python draws, numpy moves.

    scara-drake replay runs/teleoperation.nc [--speed 2] [--html page.html]
    python -m scara_drake.replay runs/teleoperation.nc

Needs the extra ``replay``. The robot is that of models/scara6.urdf, the surfaces are those of the
scenario kept in the recording. The poses of all frames are worked out at once, then shown one after
the other or written into a page.
"""

from __future__ import annotations

import argparse
import io
import math
import signal
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
from scara_drake.replay import server
from scara_drake.replay.arguments import LOOPBACK, add_arguments
from scara_drake.replay.page import animation_of
from scara_drake.replay.recording import load
from scara_drake.replay.scene import Poses, draw


@contextmanager
def _scene(
    path: str | Path, speed: float, fps: float, host: str = LOOPBACK, port: int | None = None
) -> Iterator[tuple[Any, Poses]]:
    """Draw a recording in a Meshcat whose server process ends with the context."""
    for name, value in (("speed", speed), ("fps", fps)):
        if not 0.0 < value < math.inf:
            raise ValueError(f"{name}: {value}, allowed more than 0")
    data, blocks = load(path)
    # In a thread that is waited for: an interrupt cannot lose the process while it starts.
    with ThreadPoolExecutor(1) as pool:
        process, url = pool.submit(server.start, host, port).result()
    try:
        with redirect_stdout(io.StringIO()):
            viewer = meshcat.Visualizer(url)
        try:
            yield viewer, draw(viewer, data, blocks, speed / fps)
        finally:
            viewer.window.zmq_socket.close(linger=0)
    finally:
        process.kill()
        process.communicate()


def replay(
    path: str | Path,
    speed: float = 1.0,
    fps: float = 30,
    open_browser: bool = False,
    host: str = LOOPBACK,
    port: int | None = None,
) -> None:
    """Play a recording once, `speed` times as fast as it was; print the address of the scene.

    At most `fps` pictures each second. With `open_browser` it starts when the browser is there. The
    scene is on the first free port from 7000 on, or on `port`; whoever reaches `host` can change
    what it shows, which is nobody but this machine's users unless another address is given.

    Raises:
        ValueError: no such recording, or a number that is not above 0.
        OSError: the scene cannot be where it is wanted.
    """
    with _scene(path, speed, fps, host, port) as (viewer, poses):
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
    """Run the command line; return the exit status, see `play`."""
    parser = argparse.ArgumentParser(
        prog="python -m scara_drake.replay", description=(__doc__ or "").partition("\n")[0]
    )
    add_arguments(parser)
    return play(parser.parse_args(arguments))


def play(options: argparse.Namespace) -> int:
    """Play as the options say; return the exit status: 0, 2 for bad input, 128 + n for a signal."""
    for name in ("SIGTERM", "SIGHUP"):  # so that the server is ended as well
        if number := getattr(signal, name, None):
            signal.signal(number, lambda number, frame: sys.exit(128 + number))
    try:
        if options.port is not None and not 0 < options.port < 2**16:
            raise ValueError(f"port: {options.port}, allowed 1 to 65535")
        if options.html:
            animation_page(options.recording, options.html, options.speed)
        else:
            replay(
                options.recording,
                options.speed,
                open_browser=options.open,
                host=options.host,
                port=options.port,
            )
    except (ValueError, OSError) as error:
        sys.stderr.write(f"replay: {error}\n")
        return 2
    except KeyboardInterrupt:
        return 130
    return 0
