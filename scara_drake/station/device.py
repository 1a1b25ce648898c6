"""The page that holds control, as a device that an operator holds."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from scara_drake.operator.devices.sample import Sample
from scara_drake.station.records import RUMBLE, Mailboxes, no_input

LOG = logging.getLogger("scara_drake")


class StationDevice:
    """Reads what the server left of the page that holds control, and tells it how to shake.

    It is lost while no page holds control, and once that page or the server has ended; stale while
    the page is silent. When control has changed hands it counts as lost for one sample, so that
    nobody drives on by another's dead-man button.

    Args:
        mailboxes: shared with the server.
        alive: whether the server is there.
    """

    name = "the station's page"

    def __init__(self, mailboxes: Mailboxes, alive: Callable[[], bool] = lambda: True) -> None:
        self._mailboxes, self._alive = mailboxes, alive
        self._last: Any = no_input()
        self._said = _sample(self._last)  # the last while it was there
        self._hand, self._told = 0, False

    def sample(self) -> Sample:
        """Return what the page said last."""
        found = self._mailboxes.input.read()
        if found is not None:
            self._last = found
        now, same = _sample(self._last), int(self._last["hand"]) == self._hand
        self._hand = int(self._last["hand"])
        if now.connected and same and self._server_is_there():
            self._said = now
            return now
        return self._said._replace(connected=False, settings=now.settings)

    def _server_is_there(self) -> bool:
        there = self._alive()
        if not there and not self._told:
            self._told = True
            LOG.warning("Station: its server has ended, so no page can command; Ctrl-C ends it.")
        return there

    def rumble(self, low: float, high: float, milliseconds: int) -> bool:
        """Shake the motors (0..1) of the page's device for a while; whether it has any is unknown.

        Returns:
            Whether a page holds control.
        """
        record = np.zeros((), RUMBLE)
        record["low"], record["high"] = low, high
        record["until"] = time.monotonic() + milliseconds / 1e3
        self._mailboxes.rumble.write(record)
        return bool(self._last["connected"])

    def close(self) -> None:
        """Stop the motors; a second call does nothing."""
        self._mailboxes.rumble.write(np.zeros((), RUMBLE))


def _sample(record: Any) -> Sample:
    """Return an input as a sample, in arrays of its own."""
    return Sample(
        connected=bool(record["connected"]),
        stamp=float(record["stamp"]),
        axes=np.array(record["axes"]),
        orientation=np.array(record["orientation"]),
        buttons=np.array(record["buttons"]),
        settings=np.array(record["settings"]),
    )
