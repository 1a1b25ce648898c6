"""A recorded trace as a block's declaration: what it has said, held until the next row."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.common.block import Declaration, Memory
from scara_drake.operator.trace import CLOCK_TOLERANCE, Trace
from scara_drake.operator.trace_columns import SAID, said_of
from scara_drake.vectors import device_status_of

Array = NDArray[np.float64]


@njit(cache=True)
def hold_sample(sample: Array, axes: Array) -> None:
    """Write a sample, clipped, into the axes (5,); leave them as they are if it is not finite."""
    if np.isfinite(sample).all():
        for i in range(axes.size):
            axes[i] = min(max(sample[i], -1.0), 1.0)


@njit(cache=True)
def row_at(t: float, times: Array) -> int:
    """Return the last row of a trace that is not later than `t` [s], or its first row."""
    row = int(np.searchsorted(times, t + CLOCK_TOLERANCE, side="right")) - 1
    return max(row, 0)


@njit(cache=True)
def play_trace(t: float, times: Array, rows: Array, joystick_axes: Array) -> None:
    """Hold the last row (5,) of a trace that is not later than `t` [s], or its first row."""
    hold_sample(rows[row_at(t, times)], joystick_axes)


@njit(cache=True)
def play_operator(
    t: float,
    table: Array,
    joystick_axes: Array,
    orientation_axes: Array,
    operator_buttons: Array,
    device_connected: Array,
    device_status: Array,
    live_settings: Array,
) -> None:
    """Hold that row of a table (n, 24), and with it what the device said beside its stick."""
    times, axes = table[:, 0], joystick_axes.size
    row = table[row_at(t, times)]
    hold_sample(row[1 : 1 + axes], joystick_axes)
    r = said_of(row[1 + axes :])
    orientation_axes[:] = r.orientation
    operator_buttons[:] = r.buttons
    device_connected[0] = device_status_of(r.status).connected
    device_status[:] = r.status
    live_settings[:] = r.settings


def played(trace: Trace, period: float) -> Declaration:
    """Return the block that plays a checked trace, with a sample every `period` [s]."""
    times, rows, said = trace
    initial = np.zeros(rows.shape[1])
    hold_sample(rows[0], initial)
    axes = Memory(initial, port=True)
    if said is None:
        return Declaration(
            memory={"joystick_axes": axes},
            parameters={"times": times, "rows": rows},
            period=period,
            update=play_trace,
        )
    first = SAID.unpack(said[0])
    return Declaration(
        memory={
            "joystick_axes": axes,
            "orientation_axes": Memory(first.orientation, port=True),
            "operator_buttons": Memory(first.buttons, port=True),
            "device_connected": Memory(first.status[:1], port=True),
            "device_status": Memory(first.status, port=True),
            "live_settings": Memory(first.settings, port=True),
        },
        parameters={"table": np.column_stack([times, rows, said])},
        period=period,
        update=play_operator,
    )


def check_trace(times: ArrayLike, axes: ArrayLike, said: ArrayLike | None = None) -> Trace:
    """Return a trace of arrays of its own.

    Raises:
        ValueError: other shapes than those of `Trace`, or times that are not finite and increasing.
    """
    t, a = np.array(times, dtype=np.float64), np.array(axes, dtype=np.float64)
    if t.ndim != 1 or t.size == 0 or a.shape != (t.size, 5):
        raise ValueError(f"trace: shapes {t.shape} and {a.shape}, allowed (n,) and (n, 5), n > 0")
    if not (np.isfinite(t).all() and (np.diff(t) > 0.0).all()):
        raise ValueError("trace: times that are not finite and increasing, allowed such times only")
    if said is None:
        return Trace(t, a)
    more = np.array(said, dtype=np.float64)
    if more.shape != (t.size, SAID.size) or not np.isfinite(more).all():
        raise ValueError(f"trace: further columns {more.shape}, allowed ({t.size}, {SAID.size})")
    return Trace(t, a, more)
