r"""A reference governor: the references wait for drives that are at their limits.

The references that the controller follows are those of the source plus an offset (q_o, v_o), zero
as long as every drive delivers what it is asked for. Of what a drive cannot deliver, the reference
loses the acceleration, so that it moves as the drive is able to move the joint

.. math::

    \ddot q_o = (\tau_{\text{limited}} - \tau) / \hat m + a_{\text{return}}

(conditioning after Hanus, model recovery after Teel). The controller then sees no growing error,
hence winds nothing up. a_return brings the offset back to zero, with bounded speed and acceleration
and able to stop there, so that the joint joins its source again without a jump and without an
overshoot.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake import robot
from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.common.fields import ABOVE_ZERO, vector
from scara_drake.common.layout import Rows
from scara_drake.common.motion import limit_motion

Array = NDArray[np.float64]


class Bounds(NamedTuple):
    """Bounds of the return, each row (n,).

    Attributes:
        speed: [m/s, rad/s].
        acceleration: [m/s², rad/s²].
    """

    speed: Array
    acceleration: Array


BOUNDS = Rows(Bounds)
bounds_of = BOUNDS.reader()
BANDWIDTH = 50.0  # [1/s], of the last part of the return


@njit(cache=True)
def govern(lost: Array, bounds: Array, period: float, offset: Array) -> None:
    """Advance the offset (2n,) = (q_o, v_o) of the references by one period, in place.

    Args:
        lost: acceleration that the drives could not deliver (n,) [m/s², rad/s²], with its sign:
            (tau_limited - tau) / m_hat.
        bounds: (2, n), see `Bounds`.
        period: [s].
        offset: [m, rad, m/s, rad/s], in place; stays exactly zero while nothing is lost.
    """
    b = bounds_of(bounds)
    n = lost.size
    for i in range(n):
        q, v = offset[i : i + 1], offset[n + i : n + i + 1]
        if lost[i] == 0.0 and q[0] == 0.0 and v[0] == 0.0:
            continue
        limit_motion(-q, v, b.speed[i], b.acceleration[i], BANDWIDTH, period)
        v[0] += period * lost[i]
        q[0] += period * v[0]
        # It has returned when one period would take it to zero within its bounds.
        step = b.acceleration[i] * period
        if lost[i] == 0.0 and abs(v[0]) <= step and abs(q[0]) <= step * period:
            q[0] = v[0] = 0.0


@njit(cache=True)
def lost_acceleration(
    actuation_commanded: Array, actuation: Array, m_hat: Array, lost: Array
) -> None:
    """Write the acceleration (n,) that the drives do not deliver [m/s², rad/s²]."""
    for i in range(lost.size):
        lost[i] = (actuation[i] - actuation_commanded[i]) / m_hat[i]


@njit(cache=True)
def offset_update(lost: Array, bounds: Array, period: float, reference_offset: Array) -> None:
    """Advance the offset (2n,), see `govern`."""
    govern(lost, bounds, period, reference_offset)


@njit(cache=True)
def governed(state_desired: Array, reference_offset: Array, state_desired_governed: Array) -> None:
    """Write the references (2n,) for the controller."""
    for i in range(state_desired.size):
        state_desired_governed[i] = state_desired[i] + reference_offset[i]


@dataclass
class ReferenceGovernor:
    """Bounds of the return to the source's references, per joint.

    The defaults leave the drives most of their effort: the accelerations are a fifth of those that
    they can give the nominal inertias, and for the mast of what its weight leaves.

    Attributes:
        speed: at which a joint that is behind catches up, beside that of the source.
        acceleration: likewise.
    """

    speed: list[float] = vector([0.25, 0.75, 0.75, 1.0, 1.5, 1.5], "m/s | rad/s", ABOVE_ZERO)
    acceleration: list[float] = vector(
        [2.0, 8.0, 9.0, 8.0, 15.0, 20.0], "m/s² | rad/s²", ABOVE_ZERO
    )

    def array(self) -> Array:
        """Return the bounds as `govern` takes them (2, 6)."""
        return BOUNDS.pack(speed=self.speed, acceleration=self.acceleration)

    def make_system(self, period: float) -> "ReferenceGovernorSystem":
        """Return a governor with these bounds."""
        return ReferenceGovernorSystem(self, period)


class ReferenceGovernorSystem(Block):
    """Holds the references of joints back whose drives are at their limits.

    Ports:
        input state_desired (12) [m, rad, m/s, rad/s]: q, v references of the source.
        input actuation_commanded (6) [N, N m]: effort that the controller asks for.
        input actuation (6) [N, N m]: the part of it within the limits of the drives.
        output reference_offset (12) [m, rad, m/s, rad/s].
        output state_desired_governed (12): references for the controller, state_desired +
            reference_offset: without delay, and equal to state_desired to the bit while no drive is
            at its limit.

    Update, at t = k period: first, together with the plant's step, the lost acceleration, so that
    it sees the efforts as that step does, also those of a controller that is a function of the
    state; then `govern`. Initial: zero.

    Args:
        bounds: checked.
        period: [s].
    """

    def __init__(self, bounds: ReferenceGovernor, period: float = 1e-3) -> None:
        super().__init__(
            Declaration(
                inputs={
                    "state_desired": Input(12),
                    "actuation_commanded": Input(6),
                    "actuation": Input(6),
                },
                memory={"reference_offset": Memory(12, port=True), "lost": Memory(6)},
                outputs={"state_desired_governed": Output(12, governed)},
                parameters={
                    "bounds": bounds.array(),
                    "m_hat": robot.nominal_inertias(),
                    "period": period,
                },
                period=period,
                sample=lost_acceleration,
                update=offset_update,
            )
        )
