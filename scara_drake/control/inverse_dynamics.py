r"""Inverse dynamics (computed torque) by Drake's own controller: the law that knows the robot.

With the nominal robot's mass matrix M, its bias C and its gravity G, and limited to the drives'
effort,

.. math::

    a    &= k_p\,e + k_i \int e\,dt + k_d\,\dot e \\
    \tau &= M(q)\,a + C(q, v)\,v + G(q)

Exact knowledge leaves :math:`\dddot e + k_d \ddot e + k_p \dot e + k_i e = 0` driven by the
reference alone, at every posture. It is the opposite of sliding mode control, which knows one
inertia a joint.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.controllers import InverseDynamicsController
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Saturation

from scara_drake import joints, robot
from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.common.fields import vector
from scara_drake.control.chatter import LIMIT

Array = NDArray[np.float64]


@dataclass
class InverseDynamics:
    """Gains per joint; the defaults put two poles at -100 1/s, critically damped, and one at -20.

    The slower pole is the integral's: it takes away what an unknown load leaves. As fast as the
    others it would work against the drives' limits after a large error.

    Attributes:
        kp: of the error.
        ki: of its integral.
        kd: of its rate.
    """

    kp: list[float] = vector([14e3] * 6, "1/s²", 0.0, symbol="kp")
    ki: list[float] = vector([200e3] * 6, "1/s³", 0.0, symbol="ki")
    kd: list[float] = vector([220.0] * 6, "1/s", 0.0, symbol="kd")

    def check_sampling(
        self, name: str, period: float, model: robot.RobotModel | None = None
    ) -> None:
        """Check that the gains do not chatter at this period [s] on a robot, or the nominal one.

        The nominal mass matrix cancels, so each joint is a sampled double integrator, stable where
        T_s (kd + kp T_s / 2) < 2. On a robot that is lighter by a factor it counts for more.

        Raises:
            ValueError: a joint breaks that rule.
        """
        numbers = period * (np.array(self.kd) + 0.5 * period * np.array(self.kp))
        numbers = numbers * robot.lightness(model)
        worst = int(np.argmax(numbers))
        if numbers[worst] >= LIMIT:
            raise ValueError(
                f"{name}: chatters, T_s (kd + kp T_s / 2) = {numbers[worst]:.3g} at joint "
                f"{joints.JOINT_NAMES[worst]} and T_s = {period:g} s, allowed below 2"
            )

    def make_system(self, period: float) -> Diagram:
        """Return a controller with these gains, see `make_inverse_dynamics`."""
        return make_inverse_dynamics(self, period)


@njit(cache=True)
def integrate_error(
    state_desired: Array,
    state: Array,
    actuation_commanded: Array,
    effort: Array,
    ki: Array,
    period: float,
    acceleration: Array,
) -> None:
    """Advance ki int e (6,) [m/s², rad/s²] by one period, in place.

    It holds while the effort is at its limit and the error would drive it further.

    Args:
        state_desired: references (12,).
        state: measured (12,), of the same instant.
        actuation_commanded: effort before the limits (6,) [N, N m], likewise.
        effort: the limits (6,).
        ki: gain (6,) [1/s³].
        period: [s].
        acceleration: the integral, in place.
    """
    tau = actuation_commanded
    for i in range(acceleration.size):
        error = state_desired[i] - state[i]
        if abs(tau[i]) <= effort[i] or tau[i] * error < 0.0:
            acceleration[i] += period * ki[i] * error


class IntegralAction(Block):
    """The integral part of the commanded acceleration.

    Ports:
        input state (12) [m, rad, m/s, rad/s]: q, v measured.
        input state_desired (12): q, v references.
        input actuation_commanded (6) [N, N m]: effort before the limits.
        output acceleration (6) [m/s², rad/s²]: ki int e.

    Update, at t = k period together with the plant's step: see `integrate_error`. Such an update
    sees all its inputs at one instant; before another one a sampled plant has already stepped.
    Initial: zero.

    Args:
        ki: gain (6,) [1/s³].
        period: [s].
    """

    def __init__(self, ki: Array, period: float) -> None:
        super().__init__(
            Declaration(
                inputs={
                    "state": Input(12),
                    "state_desired": Input(12),
                    "actuation_commanded": Input(6),
                },
                memory={"acceleration": Memory(6, port=True)},
                parameters={"effort": joints.EFFORT, "ki": ki, "period": period},
                period=period,
                update=integrate_error,
                with_plant=True,
            )
        )


@njit(cache=True)
def pass_state(state: Array, state_checked: Array) -> None:
    """Copy a state (12,)."""
    state_checked[:] = state


@njit(cache=True)
def pass_state_desired(state_desired: Array, state_desired_checked: Array) -> None:
    """Copy a reference (12,)."""
    state_desired_checked[:] = state_desired


class FiniteStates(Block):
    """Lets states pass, and stops the run where one is not a number.

    It stands before the law, as the Simulator would try for ever to integrate a NaN.

    Ports:
        input state (12) [m, rad, m/s, rad/s]: q, v measured.
        input state_desired (12): q, v references.
        output state_checked (12): state.
        output state_desired_checked (12): state_desired.

    Each output is a function of its input alone; evaluating one raises a RuntimeError that names
    the input port.
    """

    def __init__(self) -> None:
        super().__init__(
            Declaration(
                inputs={
                    "state": Input(12, finite=True),
                    "state_desired": Input(12, finite=True),
                },
                outputs={
                    "state_checked": Output(12, pass_state),
                    "state_desired_checked": Output(12, pass_state_desired),
                },
            )
        )


def make_inverse_dynamics(gains: InverseDynamics, period: float) -> Diagram:
    """Return Drake's `InverseDynamicsController` of the nominal robot, in the controller's socket.

    The effort is a function of its inputs at one instant, but for the integral, which is sampled:
    Drake's own would be integrated between the ticks, where the reference moves and the sampled
    state stands still, and would not know of the drives' limits. It is there all the same, with
    the gain zero, so the Simulator has continuous state to integrate: a run takes nearly twice as
    long as with a sampled controller.

    Ports:
        inputs ``state`` (12) and ``state_desired`` (12); outputs ``actuation`` (6) within the
        limits of the drives and ``actuation_commanded`` (6) before them [N, N m].

    Args:
        gains: checked.
        period: of the integral [s].
    """
    plant = MultibodyPlant(time_step=0.0)  # kept alive by the controller that refers to it
    robot.add_scara(plant)
    plant.Finalize()
    kp, ki, kd = (np.array(gain, dtype=np.float64) for gain in (gains.kp, gains.ki, gains.kd))
    builder = DiagramBuilder()
    check = builder.AddNamedSystem("controller", FiniteStates())  # its errors begin with the name
    integral = builder.AddNamedSystem("integral", IntegralAction(ki, period))
    law = builder.AddNamedSystem(
        "inverse_dynamics", InverseDynamicsController(plant, kp, np.zeros(6), kd, True)
    )
    limit = builder.AddNamedSystem("effort_limit", Saturation(-joints.EFFORT, joints.EFFORT))
    for name, estimate in (("state", "estimated_state"), ("state_desired", "desired_state")):
        builder.ExportInput(check.GetInputPort(name), name)
        checked = check.GetOutputPort(f"{name}_checked")
        builder.Connect(checked, integral.GetInputPort(name))
        builder.Connect(checked, law.GetInputPort(estimate))
    commanded = law.GetOutputPort("actuation")
    builder.Connect(integral.get_output_port(), law.GetInputPort("desired_acceleration"))
    builder.Connect(commanded, integral.GetInputPort("actuation_commanded"))
    builder.Connect(commanded, limit.get_input_port())
    builder.ExportOutput(limit.get_output_port(), "actuation")
    builder.ExportOutput(commanded, "actuation_commanded")
    return builder.Build()
