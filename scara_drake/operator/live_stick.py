"""A live joystick: which of its axes count, what a lost one still commands, and how it returns."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Declaration, Memory
from scara_drake.common.layout import Cell, Layout
from scara_drake.operator.devices import Device

Array = NDArray[np.float64]

AXES = 5
RATES = 3  # axes from here on are the mast's: speeds, not positions
REST_ZONE = 0.1  # of the travel: where an axis counts as let go; worn sticks rest at up to 0.08
PICK_UP = 0.02  # of the travel: the step that the arm may see when an axis counts again

UNTOUCHED, COUNTS, HELD = 0.0, 1.0, 2.0

LOST = "unplugged; positions are held, rates are zero"
BACK = (
    "plugged in again; an axis counts once the stick has passed where it was, or from a press of a "
    "button on"
)

LOG = logging.getLogger("scara_drake")


class Grip(NamedTuple):
    """What is known of a device's axes.

    Attributes:
        state: (5,) `UNTOUCHED`, `COUNTS`, or `HELD` since the device was lost.
        side: (5,) sign of the axis less its held value at the last sample; 0 before the first.
        button: 1 while a button is down, or the device lost.
    """

    state: Array
    side: Array
    button: Cell


GRIP = Layout(Grip, state=AXES, side=AXES, button=())
grip_of = GRIP.reader()


@njit(cache=True)
def let_go(joystick_axes: Array, grip: Array) -> None:
    """The device is lost: positions are held and rates are zero, in place."""
    g = grip_of(grip)
    joystick_axes[RATES:] = 0.0
    for i in range(joystick_axes.size):
        if g.state[i] == COUNTS:
            g.state[i] = HELD
    g.side[:] = 0.0
    g.button[()] = 1.0


@njit(cache=True)
def take_over(sample: Array, pressed: bool, joystick_axes: Array, grip: Array) -> None:
    """Take a sample of a device that is there, in place; one that is not finite changes nothing.

    An axis that does not count yet keeps its value on the port until the stick comes near it or
    passes it: at the start that value is 0, so a trigger that rests at -1 commands nothing; after a
    loss it is where the arm is held. Those that counted before a loss also count again from a press
    of a button on: then the arm goes where the stick is, at the speed of the mapping.

    Args:
        sample: (5,) axes of the device.
        pressed: whether any of its buttons is down.
        joystick_axes: (5,) on the port, each in [-1, 1].
        grip: memory, see `Grip`.
    """
    if not np.isfinite(sample).all():
        return
    g = grip_of(grip)
    press = pressed and g.button[()] == 0.0
    g.button[()] = 1.0 if pressed else 0.0
    for i in range(joystick_axes.size):
        value, held = min(max(sample[i], -1.0), 1.0), joystick_axes[i]
        if g.state[i] != COUNTS:
            away = value - held
            near = abs(away) <= (REST_ZONE if held == 0.0 else PICK_UP)
            if near or away * g.side[i] < 0.0 or (press and g.state[i] == HELD):
                g.state[i] = COUNTS
            g.side[i] = np.sign(away)
        if g.state[i] == COUNTS:
            joystick_axes[i] = value


@dataclass(frozen=True)
class LiveStick:
    """A device as a kernel, which cannot be compiled."""

    device: Device

    def declaration(self, period: float) -> Declaration:
        """Return the block that samples the device every `period` [s]."""
        return Declaration(
            memory={
                "joystick_axes": Memory(AXES, port=True),
                "device_connected": Memory(np.ones(1), port=True),
                "grip": Memory(GRIP.size),
            },
            period=period,
            update=self.sample,
        )

    def sample(self, joystick_axes: Array, device_connected: Array, grip: Array) -> None:
        """Take what the device reads now; say it once when it is lost, and when it is back.

        Raises:
            ValueError: it does not give five axes.
        """
        sample = np.asarray(self.device.read(), dtype=np.float64)
        if sample.shape != (AXES,):
            raise ValueError(f"{self.device.name}: axes {sample.shape}, allowed (5,)")
        connected = self.device.connected
        if connected != bool(device_connected[0]):
            LOG.warning("%s: %s", self.device.name, BACK if connected else LOST)
        device_connected[0] = float(connected)
        if connected:
            take_over(sample, self.device.pressed, joystick_axes, grip)
        else:
            let_go(joystick_axes, grip)
