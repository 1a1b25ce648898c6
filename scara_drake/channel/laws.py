"""How long a channel delays, inside kernels: a law is a row that begins with its kind."""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import REST, Layout

Array = NDArray[np.float64]

# Kinds of law.
SINE, STEPS, LINES = 0.0, 1.0, 2.0


class Law(Protocol):
    """What a delay has to tell, see `delays`."""

    def maximum(self) -> float:
        """Longest delay [s]."""

    def parameters(self) -> Array:
        """Return the law as `delay_at` takes it."""


class Kind(NamedTuple):
    """What every law begins with."""

    kind: float


class Sine(NamedTuple):
    """Law of the kind SINE.

    Attributes:
        kind: SINE.
        offset: [s].
        amplitude: [s].
        frequency: [rad/s].
        phase: [rad].
    """

    kind: float
    offset: float
    amplitude: float
    frequency: float
    phase: float


class Table(NamedTuple):
    """Law of the kinds STEPS and LINES.

    Attributes:
        kind: STEPS, where a delay holds from its time to the next, or LINES, straight from point
            to point.
        points: times (n,) [s], rising, then delays (n,) [s].
    """

    kind: float
    points: Array


KIND, SINE_LAW, TABLE_LAW = Layout(Kind), Layout(Sine), Layout(Table, points=REST)
kind_of, sine_of, table_of = KIND.reader(), SINE_LAW.reader(), TABLE_LAW.reader()


@njit(cache=True)
def delay_at(law: Array, t: float) -> float:
    """Delay [s] at time t [s], never negative.

    Args:
        law: of one of the kinds above.
        t: [s].
    """
    kind = kind_of(law).kind
    if kind == SINE:
        p = sine_of(law)
        return max(p.offset + p.amplitude * math.sin(p.frequency * t + p.phase), 0.0)
    times, delays = table_of(law).points.reshape((2, -1))
    if kind == STEPS:
        return delays[max(int(np.searchsorted(times, t, side="right")) - 1, 0)]
    return np.interp(t, times, delays)
