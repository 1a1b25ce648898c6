"""A live device: which of its axes count, what a lost one still commands, and how it returns."""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Declaration, Memory
from scara_drake.common.layout import Cell, Layout
from scara_drake.operator.devices import Device, Sample, WallClock
from scara_drake.operator.devices.inputs import DOWN, REST_ZONE
from scara_drake.operator.devices.sample import SHAPES, is_good
from scara_drake.vectors import (
    DEVICE_STATUS,
    JOYSTICK_AXES,
    LIVE_SETTINGS,
    NEUTRAL_SETTINGS,
    OPERATOR_BUTTONS,
    ORIENTATION_AXES,
)

Array = NDArray[np.float64]

RATES = 3  # axes from here on are the mast's: speeds, not positions
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
        turn_state: (3,) the same of the axes that turn the tool.
        turn_side: (3,)
        button: 1 while a button is down, or the device lost.
    """

    state: Array
    side: Array
    turn_state: Array
    turn_side: Array
    button: Cell


_TURNS = ORIENTATION_AXES.size
GRIP = Layout(
    Grip,
    state=JOYSTICK_AXES.size,
    side=JOYSTICK_AXES.size,
    turn_state=_TURNS,
    turn_side=_TURNS,
    button=(),
)
grip_of = GRIP.reader()


@njit(cache=True)
def _loosen(state: Array, side: Array) -> None:
    for i in range(state.size):
        if state[i] == COUNTS:
            state[i] = HELD
    side[:] = 0.0


@njit(cache=True)
def let_go(
    joystick_axes: Array, orientation_axes: Array, operator_buttons: Array, grip: Array
) -> None:
    """The device is lost: positions are held, rates are zero, no button is down; in place."""
    g = grip_of(grip)
    joystick_axes[RATES:] = 0.0
    orientation_axes[:] = 0.0
    operator_buttons[:] = 0.0
    _loosen(g.state, g.side)
    _loosen(g.turn_state, g.turn_side)
    g.button[()] = 1.0


@njit(cache=True)
def _pick_up(sample: Array, press: bool, axes: Array, state: Array, side: Array) -> None:
    for i in range(axes.size):
        value, held = min(max(sample[i], -1.0), 1.0), axes[i]
        if state[i] != COUNTS:
            away = value - held
            near = abs(away) <= (REST_ZONE if held == 0.0 else PICK_UP)
            if near or away * side[i] < 0.0 or (press and state[i] == HELD):
                state[i] = COUNTS
            side[i] = np.sign(away)
        if state[i] == COUNTS:
            axes[i] = value


@njit(cache=True)
def take_over(
    axes: Array,
    orientation: Array,
    buttons: Array,
    joystick_axes: Array,
    orientation_axes: Array,
    operator_buttons: Array,
    grip: Array,
) -> None:
    """Take a good sample of a device that is there, in place.

    An axis that does not count yet keeps its value on the port until the stick comes near it or
    passes it: at the start that value is 0, so a trigger that rests at -1 commands nothing; after a
    loss it is where the arm is held. Those that counted before a loss also count again from a press
    of a button on: then the arm goes where the stick is, at the speed of the mapping.

    Args:
        axes: (5,) of the device.
        orientation: (3,) of the device.
        buttons: (6,) of the device.
        joystick_axes: (5,) on the port, each in [-1, 1].
        orientation_axes: (3,) on the port, each in [-1, 1].
        operator_buttons: (6,) on the port, each 0 or 1.
        grip: memory, see `Grip`.
    """
    g = grip_of(grip)
    for i in range(operator_buttons.size):
        operator_buttons[i] = 1.0 if buttons[i] >= DOWN else 0.0
    pressed = operator_buttons.max()
    press = pressed > 0.0 and g.button[()] == 0.0
    g.button[()] = pressed
    _pick_up(axes, press, joystick_axes, g.state, g.side)
    _pick_up(orientation, press, orientation_axes, g.turn_state, g.turn_side)


@dataclass(frozen=True)
class LiveStick:
    """A device as a kernel, which cannot be compiled.

    Attributes:
        device: that is read.
        clock: beside it.
    """

    device: Device
    clock: WallClock = field(default_factory=WallClock)

    def declaration(self, period: float) -> Declaration:
        """Return the block that samples the device every `period` [s]."""
        return Declaration(
            memory={
                "joystick_axes": Memory(JOYSTICK_AXES.size, port=True),
                "orientation_axes": Memory(ORIENTATION_AXES.size, port=True),
                "operator_buttons": Memory(OPERATOR_BUTTONS.size, port=True),
                "device_connected": Memory(np.ones(1), port=True),
                "device_status": Memory(
                    DEVICE_STATUS.pack(connected=1.0, age=0.0, lateness=0.0, bad_samples=0.0),
                    port=True,
                ),
                "live_settings": Memory(
                    LIVE_SETTINGS.pack(**NEUTRAL_SETTINGS._asdict()), port=True
                ),
                "grip": Memory(GRIP.size),
            },
            period=period,
            update=self.sample,
        )

    def sample(
        self,
        joystick_axes: Array,
        orientation_axes: Array,
        operator_buttons: Array,
        device_connected: Array,
        device_status: Array,
        live_settings: Array,
        grip: Array,
    ) -> None:
        """Take what the device says now; tell once when it is lost, and when it is back.

        Raises:
            ValueError: its sample has other shapes than `Sample` tells.
        """
        sample = self.device.sample()
        self._check(sample)
        before = DEVICE_STATUS.unpack(device_status)
        self._tell(sample.connected, bool(before.connected))
        bad = 0.0
        if not sample.connected:
            let_go(joystick_axes, orientation_axes, operator_buttons, grip)
        elif is_good(sample):
            take_over(
                sample.axes,
                sample.orientation,
                sample.buttons,
                joystick_axes,
                orientation_axes,
                operator_buttons,
                grip,
            )
            live_settings[:] = sample.settings
        else:
            bad = before.bad_samples + 1.0
        age = self.clock.now() - sample.stamp
        device_connected[0] = float(sample.connected)
        device_status[:] = DEVICE_STATUS.pack(
            connected=float(sample.connected),
            age=max(age, 0.0) if math.isfinite(age) else before.age,
            lateness=self.clock.lateness,
            bad_samples=bad,
        )

    def _check(self, sample: Sample) -> None:
        for name, size in SHAPES.items():
            shape = np.shape(getattr(sample, name))
            if shape != (size,):
                raise ValueError(f"{self.device.name}: {name} {shape}, allowed ({size},)")

    def _tell(self, connected: bool, before: bool) -> None:
        if connected != before:
            LOG.warning("%s: %s", self.device.name, BACK if connected else LOST)
