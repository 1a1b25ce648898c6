r"""Integral sliding mode control with a sliding perturbation observer (SMCSPO).

With the estimates of `perturbation_observer` in place of the state, e^ = q_d - x1^ and
e^' = v_d - x2^, and limited to the drive's effort,

.. math::

    \hat\sigma &= \dot{\hat e} + c\,\hat e \\
    \hat s     &= \hat\sigma - z, \quad \dot z = -k\,\hat\sigma \\
    u          &= c\,\dot{\hat e} + k\,\hat\sigma + \rho \operatorname{sat}(\hat s / \phi)
                  - \hat\Psi \\
    \tau       &= \hat m\,u

With exact estimates :math:`\dot\sigma = \ddot q_d - k \sigma - \rho \operatorname{sat}(s / \phi)`,
whatever the load: :math:`\rho` has to cover the error of the estimate, and the reference's
acceleration unless that is fed forward, but not the perturbation. Positions are measured,
velocities are not. The paper names this observer as future work; it is that of Moura, Elmali and
Olgac (1997).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from scara_drake import joints, robot
from scara_drake.common import checks
from scara_drake.common.block import Memory, Output
from scara_drake.common.fields import ABOVE_ZERO, vector
from scara_drake.control import ismc_law as ismc
from scara_drake.control import observer_law as kernels
from scara_drake.control.chatter import Slopes, check_chatter
from scara_drake.control.controller import JointController, Law
from scara_drake.control.perturbation_observer import observer_gains

Array = NDArray[np.float64]

# Largest pole times T_s. The chatter rule is that of an exact velocity; faster observers leave it
# less than its 2, down to 1.3 where the product is 1.
FASTEST = 0.5


@dataclass
class ObserverSlidingMode:
    """Gains of the law and of its observer per joint.

    The slopes c and k are those of Table 12; rho is a tenth of it, for the observer does the rest.

    Attributes:
        c: slope of the sliding surface.
        k: gain of the nominal part.
        rho: gain of the discontinuous part.
        phi: boundary layer of s^.
        pole: triple pole of the observer.
        eps: layer of the observer. A step of Psi leaves it above 2.7 eps pole² where
            pole T_s is 0.2, and above 3.7 eps pole² where that is small.
        anti_windup: |s^| is clamped to 2 phi.
        acceleration_feedforward: the reference's acceleration is added to u.
        allow_chatter: gains that break the rule of `chatter` are accepted.
    """

    # Its controller has the outputs that the contact force is estimated from.
    observes_perturbation: ClassVar[bool] = True

    c: list[float] = vector(
        [50.0, 50.0, 50.0, 40.0, 10.0, 10.0], "1/s", 0.0, symbol="c", equation="(28)"
    )
    k: list[float] = vector(
        [150.0, 100.0, 100.0, 75.0, 40.0, 20.0], "1/s", 0.0, symbol="k", equation="(33)"
    )
    rho: list[float] = vector(
        [50.0, 15.0, 15.0, 12.0, 10.0, 10.0], "m/s² | rad/s²", 0.0, symbol="rho", equation="(37)"
    )
    phi: list[float] = vector([1.0] * 6, "m/s | rad/s", ABOVE_ZERO, symbol="phi", equation="(37)")
    pole: list[float] = vector([200.0] * 6, "1/s", ABOVE_ZERO, symbol="p")
    eps: list[float] = vector([0.005] * 6, "m | rad", ABOVE_ZERO, symbol="eps")
    anti_windup: bool = True
    acceleration_feedforward: bool = False
    allow_chatter: bool = False

    def check_sampling(
        self, name: str, period: float, model: robot.RobotModel | None = None
    ) -> None:
        """Check that the observer is slow enough for this period [s] and the law does not chatter.

        Beside its slope over sigma^ the law has c over e^', for which the chatter rule allows too.

        Raises:
            ValueError: a pole above 0.5 / period; or the gains chatter, and `allow_chatter` is not
                set.
        """
        checks.vector(f"{name}.pole", self.pole, 6, ABOVE_ZERO, FASTEST / period)
        if not self.allow_chatter:
            g = ismc.GAINS.unpack(kernels.GAINS.unpack(self.array(period)).law)
            slopes = Slopes(g.m_hat, g.c, g.k, g.rho, g.phi, beside=g.c)
            check_chatter(name, slopes, period, model)

    def array(self, period: float) -> Array:
        """Return the gains as `observer_law` takes them; the period in [s]."""
        phi = np.array(self.phi)
        law = ismc.GAINS.pack(
            c=self.c,
            k=self.k,
            rho=self.rho,
            phi=phi,
            m_hat=robot.nominal_inertias(),
            effort=joints.EFFORT,
            clamp=2.0 * phi if self.anti_windup else np.inf,
            period=period,
        )
        return kernels.GAINS.pack(
            law=law,
            observer=observer_gains(self.pole, self.eps, period),
            acceleration_feedforward=float(self.acceleration_feedforward),
        )

    def make_system(self, period: float) -> "ObserverSlidingModeController":
        """Return a controller with these gains, the robot's nominal inertias and efforts."""
        return ObserverSlidingModeController(self, period)


class ObserverSlidingModeController(JointController):
    """Integral sliding mode control of the six joints on estimated states.

    Ports: those of `JointController`, of whose `state` the velocities are not used but have to be
    finite, and
        output sliding_variable (6) [m/s, rad/s]: s^.
        output velocity_estimate (6) [m/s, rad/s].
        output perturbation_estimate (6) [m/s², rad/s²]: Psi^.
        output actuation_lagged (6) [N, N m]: effort as late as Psi^ sees a perturbation.

    The last three are functions of the state alone. Update, at t = k period: see `observer_law`.
    The sampled plant has stepped before, so the position is that at the end of the period in which
    the effort on `actuation` acted. Initial: at rest in the measured position with Psi^ = 0, and
    z = sigma^, hence s^ = 0. While not engaged the observer runs on, with no effort, and
    z = sigma^: so the drives take over an arm that moves without a jump.

    Args:
        gains: checked.
        period: [s].
    """

    def __init__(self, gains: ObserverSlidingMode, period: float = 1e-3) -> None:
        super().__init__(
            period,
            Law(
                update=kernels.observer_law,
                initialize=kernels.observer_initialize,
                rest=kernels.observer_rest,
                rest_initialize=kernels.observer_rest_initialize,
                limited=True,
            ),
            parameters={"gains": gains.array(period)},
            memory={
                "sliding_variable": Memory(6, port=True),
                "memory": Memory(6 * kernels.ESTIMATES.size),
            },
            outputs={
                "velocity_estimate": Output(6, kernels.show_velocity),
                "perturbation_estimate": Output(6, kernels.show_perturbation),
                "actuation_lagged": Output(6, kernels.show_lagged),
            },
        )
