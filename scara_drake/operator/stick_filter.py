"""What a device sends, freed of what is no number, out of range, or a spike."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common import checks
from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.common.layout import Cell, Layout
from scara_drake.vectors import (
    BUTTON_NAMES,
    JOYSTICK_AXES,
    OPERATOR_BUTTONS,
    ORIENTATION_AXES,
)

Array = NDArray[np.float64]

AXIS_LIMIT = 1.05  # a little beyond 1 for a stick calibrated badly
DOWN = 0.5  # a button from here on is down
ESTOP = BUTTON_NAMES.index("estop")
ALL_AXES = JOYSTICK_AXES.size + ORIENTATION_AXES.size


class OperatorInput(NamedTuple):
    """`operator_input` (16): what the operator does, as far as it can be believed.

    Attributes:
        axes: (5,) in the order of `vectors.JoystickAxes`, each in [-1, 1].
        orientation: (3,) of `vectors.OrientationAxes`.
        buttons: (6,) of `vectors.OperatorButtons`.
        bad: samples in a row that were left out, as they are no numbers or out of range.
        spikes: axes so far that were left out for a sample.
    """

    axes: Array
    orientation: Array
    buttons: Array
    bad: Cell
    spikes: Cell


class Filtering(NamedTuple):
    """Parameters of the filter.

    Attributes:
        ticks: from sample to sample.
        spike: of the travel: what a sample has to stand out by.
    """

    ticks: float
    spike: float


class Samples(NamedTuple):
    """Memory of the filter.

    Attributes:
        last: (2, 8) the axes of the last two samples, the older first.
        tick: of the sample.
        bad_ticks: in a row.
    """

    last: Array
    tick: Cell
    bad_ticks: Cell


OPERATOR_INPUT = Layout(
    OperatorInput,
    axes=JOYSTICK_AXES.size,
    orientation=ORIENTATION_AXES.size,
    buttons=OPERATOR_BUTTONS.size,
    bad=(),
    spikes=(),
)
FILTERING = Layout(Filtering)
SAMPLES = Layout(Samples, last=(2, ALL_AXES), tick=(), bad_ticks=())
operator_input_of = OPERATOR_INPUT.reader()
filtering_of = FILTERING.reader()
samples_of = SAMPLES.reader()


@njit(cache=True)
def believable(joystick_axes: Array, orientation_axes: Array, operator_buttons: Array) -> bool:
    """Whether a sample is made of numbers, and its axes are within their range."""
    for axes in (joystick_axes, orientation_axes):
        for i in range(axes.size):
            if not abs(axes[i]) <= AXIS_LIMIT:  # NaN is not
                return False
    return bool(np.isfinite(operator_buttons).all())


@njit(cache=True)
def median(a: float, b: float, c: float) -> float:
    """The middle one of three numbers."""
    return max(min(a, b), min(max(a, b), c))


@njit(cache=True)
def filter_step(
    joystick_axes: Array,
    orientation_axes: Array,
    operator_buttons: Array,
    filtering: Array,
    samples: Array,
    operator_input: Array,
) -> None:
    """One tick of `StickFilter`, in place."""
    p, m, out = filtering_of(filtering), samples_of(samples), operator_input_of(operator_input)
    if not believable(joystick_axes, orientation_axes, operator_buttons):
        m.bad_ticks[()] += 1.0
        out.bad[()] = np.ceil(m.bad_ticks[()] / p.ticks)
        if operator_buttons[ESTOP] > DOWN:  # whatever else the sample says
            out.buttons[ESTOP] = 1.0
        return
    m.bad_ticks[()] = out.bad[()] = 0.0
    for i in range(operator_buttons.size):
        out.buttons[i] = 1.0 if operator_buttons[i] > DOWN else 0.0
    m.tick[()] += 1.0
    if m.tick[()] < p.ticks:
        return
    m.tick[()] = 0.0
    for i in range(joystick_axes.size + orientation_axes.size):
        stick = i < joystick_axes.size
        sample = joystick_axes[i] if stick else orientation_axes[i - joystick_axes.size]
        value = median(m.last[0, i], m.last[1, i], sample)
        # Before the newest sample came the one that may be a spike: an extreme between two others.
        if abs(m.last[1, i] - value) > p.spike:
            out.spikes[()] += 1.0
        value = min(max(value, -1.0), 1.0)
        if stick:
            out.axes[i] = value
        else:
            out.orientation[i - joystick_axes.size] = value
        m.last[0, i], m.last[1, i] = m.last[1, i], sample


class StickFilter(Block):
    """Leaves out what a device cannot mean, for the operator's supervisor and the mapping.

    Ports:
        input joystick_axes (5), orientation_axes (3), operator_buttons (6): of the device.
        output operator_input (16): see `OperatorInput`.

    Update, at t = k period: a sample that is not finite, or with an axis beyond ±1.05, changes
    nothing and is counted. Of any other the buttons are passed on, and of each axis the median of
    the last three samples, which is a sample late and leaves out every spike of one sample.
    Initial: everything zero.

    Args:
        sample_period: of the device [s].
        spike: of the travel: from which size on a sample left out counts as a spike.
        period: [s].

    Raises:
        ValueError: a period or the size is out of its bounds.
    """

    def __init__(
        self, sample_period: float = 0.01, spike: float = 0.25, period: float = 1e-3
    ) -> None:
        checks.number("period", period, 1e-4, 0.1)
        checks.number("sample_period", sample_period, 1e-4, 1.0)
        checks.number("spike", spike, 0.0, 2.0)
        ticks = max(round(sample_period / period), 1)
        super().__init__(
            Declaration(
                inputs={
                    "joystick_axes": Input(JOYSTICK_AXES.size),
                    "orientation_axes": Input(
                        ORIENTATION_AXES.size, default=(0.0,) * ORIENTATION_AXES.size
                    ),
                    "operator_buttons": Input(OPERATOR_BUTTONS.size),
                },
                memory={
                    "operator_input": Memory(OPERATOR_INPUT.size, port=True),
                    "samples": Memory(SAMPLES.size),
                },
                parameters={"filtering": FILTERING.pack(ticks=ticks, spike=spike)},
                period=period,
                update=filter_step,
            )
        )
