"""Inverse dynamics (computed torque) by Drake's own controller: the law that knows the robot.

With the nominal robot's mass matrix M, its bias C and its gravity G::

    a   = kp e + ki int e + kd e'
    tau = M(q) a + C(q, v) v + G(q)       limited to the drives' effort

Exact knowledge leaves e''' + kd e'' + kp e' + ki e = 0 driven by the reference alone, at every
posture. It is the opposite of sliding mode control, which knows one inertia a joint.
"""

from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.controllers import InverseDynamicsController
from pydrake.systems.framework import (
    BasicVector,
    Context,
    Diagram,
    DiagramBuilder,
    InputPort,
    LeafSystem,
    State,
)
from pydrake.systems.primitives import Saturation

from scara_drake import joints, robot
from scara_drake.common import checks
from scara_drake.common.finite import all_finite, check_finite
from scara_drake.common.state import declare_state
from scara_drake.control.chatter import LIMIT

Array = NDArray[np.float64]


def _six(value: float) -> list[float]:
    return [value] * 6


@dataclass
class InverseDynamics:
    """Gains per joint; the defaults put two poles at -100 1/s, critically damped, and one at -20.

    The slower pole is the integral's: it takes away what an unknown load leaves. As fast as the
    others it would work against the drives' limits after a large error.

    Attributes:
        kp: of the error [1/s²].
        ki: of its integral [1/s³].
        kd: of its rate [1/s].
    """

    kp: list[float] = field(default_factory=lambda: _six(14e3))
    ki: list[float] = field(default_factory=lambda: _six(200e3))
    kd: list[float] = field(default_factory=lambda: _six(220.0))

    def validate(self, name: str) -> None:
        """Check the gains; `name` is the field's path in the scenario.

        Raises:
            ValueError: a gain is negative or not finite.
        """
        for gain in ("kp", "ki", "kd"):
            checks.vector(f"{name}.{gain}", getattr(self, gain), 6, 0.0)

    def check_sampling(self, name: str, period: float) -> None:
        """Check that the gains do not chatter at this period [s].

        The mass matrix cancels, so each joint is a sampled double integrator, stable where
        T_s (kd + kp T_s / 2) < 2.

        Raises:
            ValueError: a joint breaks that rule.
        """
        numbers = period * (np.array(self.kd) + 0.5 * period * np.array(self.kp))
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
    tau: Array,
    effort: Array,
    ki: Array,
    period: float,
    integral: Array,
) -> None:
    """Advance ki int e (6,) [m/s², rad/s²] by one period, in place.

    It holds while the effort is at its limit and the error would drive it further.

    Args:
        state_desired: references (12,).
        state: measured (12,), of the same instant.
        tau: effort before the limits (6,) [N, N m], likewise.
        effort: the limits (6,).
        ki: gain (6,) [1/s³].
        period: [s].
        integral: in place.
    """
    for i in range(integral.size):
        error = state_desired[i] - state[i]
        if abs(tau[i]) <= effort[i] or tau[i] * error < 0.0:
            integral[i] += period * ki[i] * error


class IntegralAction(LeafSystem):
    """The integral part of the commanded acceleration.

    Input ports:
        state (12): q, v measured [m, rad, m/s, rad/s]
        state_desired (12): q, v references
        actuation_commanded (6): effort before the limits [N, N m]
    Output ports, discrete state:
        acceleration (6): ki int e [m/s², rad/s²]
    Update (every period, unrestricted): see `integrate_error`. Such an update sees all its inputs
        at one instant; before a discrete one a sampled plant has already stepped.
    Initial: zero.

    Args:
        ki: gain (6,) [1/s³].
        period: [s].
    """

    def __init__(self, ki: Array, period: float):
        super().__init__()
        self._ki, self._period = ki, period
        self._state = self.DeclareVectorInputPort("state", 12)
        self._desired = self.DeclareVectorInputPort("state_desired", 12)
        self._tau = self.DeclareVectorInputPort("actuation_commanded", 6)
        self._integral = declare_state(self, 6, "acceleration")
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, state: State) -> None:
        integrate_error(
            self._desired.Eval(context),
            self._state.Eval(context),
            self._tau.Eval(context),
            joints.EFFORT,
            self._ki,
            self._period,
            state.get_mutable_discrete_state(self._integral).get_mutable_value(),
        )


class FiniteStates(LeafSystem):
    """Lets states pass, and stops the run where one is not a number.

    It stands before the law, as the Simulator would try for ever to integrate a NaN.

    Input ports:
        state (12): q, v measured [m, rad, m/s, rad/s]
        state_desired (12): q, v references
    Output ports, each a function of its input:
        state_checked (12), state_desired_checked (12): the same; evaluating one raises a
            RuntimeError that names the input port
    """

    def __init__(self) -> None:
        super().__init__()
        for name in ("state", "state_desired"):
            port = self.DeclareVectorInputPort(name, 12)
            self.DeclareVectorOutputPort(
                f"{name}_checked",
                12,
                partial(self._check, port),
                prerequisites_of_calc={port.ticket()},
            )

    def _check(self, port: InputPort, context: Context, output: BasicVector) -> None:
        values = port.Eval(context)
        if not all_finite(values, values):
            check_finite(self, context, (port,))
        output.SetFromVector(values)


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
