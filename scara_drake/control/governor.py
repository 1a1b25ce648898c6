"""A reference governor: the references wait for drives that are at their limits.

The references that the controller follows are those of the source plus an offset (q_o, v_o), zero
as long as every drive delivers what it is asked for. Of what a drive cannot deliver, the reference
loses the acceleration, so that it moves as the drive is able to move the joint::

    q_o'' = (tau_limited - tau) / m_hat + a_return

(conditioning after Hanus, model recovery after Teel). The controller then sees no growing error,
hence winds nothing up. a_return brings the offset back to zero, with bounded speed and acceleration
and able to stop there, so that the joint joins its source again without a jump and without an
overshoot.
"""

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem, State

from scara_drake import robot
from scara_drake.common import checks
from scara_drake.common.motion import limit_motion
from scara_drake.common.state import declare_state

Array = NDArray[np.float64]

# Rows of the array (2, n) of bounds, one column a joint.
SPEED, ACCELERATION = range(2)
BANDWIDTH = 50.0  # [1/s], of the last part of the return


@njit(cache=True)
def govern(lost: Array, bounds: Array, period: float, offset: Array) -> None:
    """Advance the offset (2n,) = (q_o, v_o) of the references by one period, in place.

    Args:
        lost: acceleration that the drives could not deliver (n,) [m/s², rad/s²], with its sign:
            (tau_limited - tau) / m_hat.
        bounds: (2, n), rows speed and acceleration of the return.
        period: [s].
        offset: [m, rad, m/s, rad/s], in place; stays exactly zero while nothing is lost.
    """
    n = lost.size
    for i in range(n):
        q, v = offset[i : i + 1], offset[n + i : n + i + 1]
        if lost[i] == 0.0 and q[0] == 0.0 and v[0] == 0.0:
            continue
        speed, acceleration = bounds[SPEED, i], bounds[ACCELERATION, i]
        limit_motion(-q, v, speed, acceleration, BANDWIDTH, period)
        v[0] += period * lost[i]
        q[0] += period * v[0]
        # It has returned when one period would take it to zero within its bounds.
        step = acceleration * period
        if lost[i] == 0.0 and abs(v[0]) <= step and abs(q[0]) <= step * period:
            q[0] = v[0] = 0.0


@dataclass
class ReferenceGovernor:
    """Bounds of the return to the source's references, per joint.

    The defaults leave the drives most of their effort: the accelerations are a fifth of those that
    they can give the nominal inertias, and for the mast of what its weight leaves.

    Attributes:
        speed: at which a joint that is behind catches up, beside that of the source [m/s, rad/s].
        acceleration: likewise [m/s², rad/s²].
    """

    speed: list[float] = field(default_factory=lambda: [0.25, 0.75, 0.75, 1.0, 1.5, 1.5])
    acceleration: list[float] = field(default_factory=lambda: [2.0, 8.0, 9.0, 8.0, 15.0, 20.0])

    def validate(self, name: str) -> None:
        """Check the bounds; `name` is the field's path in the scenario.

        Raises:
            ValueError: a bound is not positive and finite.
        """
        checks.vector(f"{name}.speed", self.speed, 6, checks.ABOVE_ZERO)
        checks.vector(f"{name}.acceleration", self.acceleration, 6, checks.ABOVE_ZERO)

    def array(self) -> Array:
        """Return the bounds as `govern` takes them (2, 6)."""
        return np.array([self.speed, self.acceleration], dtype=np.float64)

    def make_system(self, period: float) -> "ReferenceGovernorSystem":
        """Return a governor with these bounds."""
        return ReferenceGovernorSystem(self, period)


class ReferenceGovernorSystem(LeafSystem):
    """Holds the references of joints back whose drives are at their limits.

    Input ports:
        state_desired (12): q, v references of the source [m, rad, m/s, rad/s]
        actuation_commanded (6): effort that the controller asks for [N, N m]
        actuation (6): the part of it within the limits of the drives
    Output ports:
        state_desired_governed (12): references for the controller, a function of state_desired and
            the state: without delay, and equal to it to the bit while no drive is at its limit
        reference_offset (12): what they differ by, discrete state
    Update (every period): see `govern`. The efforts are read by an unrestricted update, which sees
        them as the plant's step does, also those of a controller that is a function of the state.
    Initial: zero.

    Args:
        bounds: checked.
        period: [s].
    """

    def __init__(self, bounds: ReferenceGovernor, period: float = 1e-3):
        super().__init__()
        self._bounds, self._m_hat = bounds.array(), robot.nominal_inertias()
        self._period = period
        self._desired = self.DeclareVectorInputPort("state_desired", 12)
        self._commanded = self.DeclareVectorInputPort("actuation_commanded", 6)
        self._limited = self.DeclareVectorInputPort("actuation", 6)
        # Not of the efforts: they depend on this very output.
        inputs = {self._desired.ticket(), self.xd_ticket()}
        self.DeclareVectorOutputPort(
            "state_desired_governed", 12, self._governed, prerequisites_of_calc=inputs
        )
        self._offset = declare_state(self, 12, "reference_offset")
        self._lost = declare_state(self, 6)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._read)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _governed(self, context: Context, output: BasicVector) -> None:
        offset = context.get_discrete_state(self._offset).value()
        output.SetFromVector(self._desired.Eval(context) + offset)

    def _read(self, context: Context, state: State) -> None:
        lost = state.get_mutable_discrete_state(self._lost).get_mutable_value()
        lost[:] = (self._limited.Eval(context) - self._commanded.Eval(context)) / self._m_hat

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        lost = context.get_discrete_state(self._lost).value()
        govern(lost, self._bounds, self._period, discrete.get_mutable_value(self._offset))
