"""The recording of what a Meshcat shows, and the page that plays it."""

from __future__ import annotations

from pathlib import Path

from pydrake.geometry import Meshcat

from scara_drake.common.files import write_whole
from scara_drake.display.annotations import PERIOD


def start_recording(meshcat: Meshcat) -> None:
    """Begin a new recording of what is drawn, one frame a picture."""
    meshcat.DeleteRecording()
    meshcat.StartRecording(frames_per_second=1.0 / PERIOD, set_visualizations_while_recording=True)


def publish_recording(meshcat: Meshcat) -> None:
    """End the recording and give it to the browsers and to the page of `save_html`."""
    meshcat.StopRecording()
    meshcat.PublishRecording()


def save_html(meshcat: Meshcat, path: str | Path) -> Path:
    """Save the scene, with its published recording, as one page that needs no network.

    The file appears whole or not at all.

    Raises:
        OSError: the folder cannot be written.
    """
    write_whole(path, meshcat.StaticHtml())
    return Path(path)
