"""Perturbations that act on the joints beside the drives."""

from dataclasses import asdict, dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake import robot
from scara_drake.common import checks
from scara_drake.common.block import Block, Declaration, Output
from scara_drake.common.fields import number, vector
from scara_drake.common.layout import Layout

Array = NDArray[np.float64]

LONGEST = 86400.0  # [s], a run


@dataclass
class JointPerturbation:
    """Matched perturbation offset + amplitude sin(frequency t + phase) of each joint.

    It is in units of the control law's u, so it compares with rho: the force on a joint is the
    nominal inertia m_hat times it. The sine runs on the simulation's time, not from `start`.

    Attributes:
        offset: constant part.
        amplitude: of the sine.
        frequency: of the sine.
        phase: of the sine.
        start: first instant at which it acts.
        stop: from here on it is zero.
    """

    offset: list[float] = vector([0.0] * 6, "m/s² | rad/s²", -1e4, 1e4)
    amplitude: list[float] = vector([0.0] * 6, "m/s² | rad/s²", -1e4, 1e4)
    frequency: list[float] = vector([1.0] * 6, "rad/s", 0.0, 1e4)
    phase: list[float] = vector([0.0] * 6, "rad", -2.0 * np.pi, 2.0 * np.pi)
    start: float = number(0.0, "s", 0.0, LONGEST)
    stop: float = number(LONGEST, "s", 0.0, LONGEST)

    def check_together(self, name: str) -> None:
        """Check that it does not stop before it starts.

        Raises:
            ValueError: it does.
        """
        checks.number(f"{name}.stop", self.stop, self.start, LONGEST)

    def parameters(self) -> Array:
        """Return the perturbation as `perturbation_of` reads it."""
        return PERTURBATION.pack(**asdict(self), m_hat=robot.nominal_inertias())

    def make_system(self) -> "JointPerturbationSource":
        """Return a source of its force on the joints."""
        return JointPerturbationSource(self)


class Perturbation(NamedTuple):
    """`JointPerturbation` in a kernel; m_hat is the nominal inertia (6,) [kg, kg m²]."""

    offset: Array
    amplitude: Array
    frequency: Array
    phase: Array
    start: float
    stop: float
    m_hat: Array


PERTURBATION = Layout(Perturbation, offset=6, amplitude=6, frequency=6, phase=6, m_hat=6)
perturbation_of = PERTURBATION.reader()


@njit(cache=True)
def perturb(t: float, perturbation: Array, perturbation_force: Array) -> None:
    """Write m_hat (offset + amplitude sin(frequency t + phase)) (6,); zero outside [start, stop).

    Args:
        t: [s].
        perturbation: of `JointPerturbation.parameters`.
        perturbation_force: generalized force on the joints [N, N m], written.
    """
    p = perturbation_of(perturbation)
    active = p.start <= t < p.stop
    for i in range(6):
        angle = p.frequency[i] * t + p.phase[i]
        u = p.offset[i] + p.amplitude[i] * np.sin(angle)
        perturbation_force[i] = p.m_hat[i] * u if active else 0.0


class JointPerturbationSource(Block):
    """Plays a `JointPerturbation`.

    Ports:
        output perturbation_force (6) [N, N m], a function of time: generalized force on the joints,
            see `perturb`.

    No update, and no memory.

    Args:
        perturbation: checked.
    """

    def __init__(self, perturbation: JointPerturbation) -> None:
        super().__init__(
            Declaration(
                outputs={"perturbation_force": Output(6, perturb)},
                parameters={"perturbation": perturbation.parameters()},
            )
        )
