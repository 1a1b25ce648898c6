"""Perturbations that act on the joints beside the drives."""

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from scara_drake import robot
from scara_drake.common import checks

Array = NDArray[np.float64]

# Rows of the parameters (5, 6).
OFFSET, AMPLITUDE, FREQUENCY, PHASE, M_HAT = range(5)


@njit(cache=True)
def perturbation_force(t: float, start: float, stop: float, parameters: Array, tau: Array) -> None:
    """Write m_hat (offset + amplitude sin(frequency t + phase)) (6,); zero outside [start, stop).

    Args:
        t: [s].
        start: [s].
        stop: [s].
        parameters: (5, 6), rows offset, amplitude, frequency, phase, m_hat.
        tau: generalized force [N, N m], written.
    """
    active = start <= t < stop
    for i in range(6):
        angle = parameters[FREQUENCY, i] * t + parameters[PHASE, i]
        u = parameters[OFFSET, i] + parameters[AMPLITUDE, i] * np.sin(angle)
        tau[i] = parameters[M_HAT, i] * u if active else 0.0


@dataclass
class JointPerturbation:
    """Matched perturbation offset + amplitude sin(frequency t + phase) of each joint.

    It is in units of the control law's u, so it compares with rho: the force on a joint is the
    nominal inertia m_hat times it. The sine runs on the simulation's time, not from `start`.

    Attributes:
        offset: [m/s², rad/s²].
        amplitude: [m/s², rad/s²].
        frequency: [rad/s].
        phase: [rad].
        start: first instant at which it acts [s].
        stop: from here on it is zero [s].
    """

    offset: list[float] = field(default_factory=lambda: [0.0] * 6)
    amplitude: list[float] = field(default_factory=lambda: [0.0] * 6)
    frequency: list[float] = field(default_factory=lambda: [1.0] * 6)
    phase: list[float] = field(default_factory=lambda: [0.0] * 6)
    start: float = 0.0  # [s]
    stop: float = 86400.0  # [s], the longest run

    def validate(self, name: str) -> None:
        """Check the fields; `name` is the path in the scenario.

        Raises:
            ValueError: a number out of its range, or a stop before the start.
        """
        checks.vector(f"{name}.offset", self.offset, 6, -1e4, 1e4)
        checks.vector(f"{name}.amplitude", self.amplitude, 6, -1e4, 1e4)
        checks.vector(f"{name}.frequency", self.frequency, 6, 0.0, 1e4)
        checks.vector(f"{name}.phase", self.phase, 6, -2.0 * np.pi, 2.0 * np.pi)
        checks.number(f"{name}.start", self.start, 0.0, 86400.0)
        checks.number(f"{name}.stop", self.stop, self.start, 86400.0)

    def array(self) -> Array:
        """Return the parameters (5, 6) of `perturbation_force`."""
        rows = [self.offset, self.amplitude, self.frequency, self.phase, robot.nominal_inertias()]
        return np.array(rows, dtype=np.float64)

    def make_system(self) -> "JointPerturbationSource":
        """Return a source of its force on the joints."""
        return JointPerturbationSource(self)


class JointPerturbationSource(LeafSystem):
    """Plays a `JointPerturbation`.

    Output port, a function of time:
        perturbation_force (6): generalized force on the joints [N, N m], see `perturbation_force`

    Args:
        perturbation: checked.
    """

    def __init__(self, perturbation: JointPerturbation):
        super().__init__()
        self._parameters = perturbation.array()
        self._start, self._stop = perturbation.start, perturbation.stop
        self.DeclareVectorOutputPort(
            "perturbation_force", 6, self._calc, prerequisites_of_calc={self.time_ticket()}
        )

    def _calc(self, context: Context, output: BasicVector) -> None:
        perturbation_force(
            context.get_time(),
            self._start,
            self._stop,
            self._parameters,
            output.get_mutable_value(),
        )
