"""What an end of `WaveVariables` may play of a wave, as kernels: no more than has arrived."""

from __future__ import annotations

import math
from typing import NamedTuple

from numba import njit

from scara_drake.common.layout import Layout


class Gains(NamedTuple):
    """`WaveVariables` in a kernel, in the master's units."""

    impedance: float
    stiffness: float
    damping: float
    drift_gain: float
    max_speed: float
    reserve: float
    turn: float
    integral_rate: float


GAINS = Layout(Gains)
gains_of = GAINS.reader()


@njit(cache=True)
def affordable(wave: float, arrived: float, played: float, period: float) -> float:
    """Return the wave, smaller where its energy over the period has not arrived [J]."""
    left = max(arrived - played, 0.0)
    if 0.5 * wave * wave * period > left:
        return math.copysign(math.sqrt(2.0 * left / period), wave)
    return wave


@njit(cache=True)
def make_up(missing: float, p: Gains) -> float:
    """Return the wave that makes up for what is missing in the integral [sqrt(W) s], bounded."""
    most = math.sqrt(0.5 * p.impedance) * p.max_speed
    return min(max(p.integral_rate * missing, -most), most)


@njit(cache=True)
def corrected(wave: float, correction: float, left: float, share: float, period: float) -> float:
    """Return the wave with a correction, as far as a share of the energy pays that it leaves [J].

    The rest stays for ticks in which nothing comes: too large now and zero then wastes energy.
    """
    left = share * max(left - 0.5 * wave * wave * period, 0.0)
    wanted = wave + correction
    if 0.5 * (wanted * wanted - wave * wave) * period > left:
        return math.copysign(math.sqrt(wave * wave + 2.0 * left / period), wanted)
    return wanted
