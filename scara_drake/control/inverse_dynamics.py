"""Inverse dynamics (computed torque) by Drake's own controller: the law that knows the robot.

With the nominal robot's mass matrix M, its bias C and its gravity G::

    a   = kp e + ki int e + kd e'
    tau = M(q) a + C(q, v) v + G(q)       limited to the drives' effort

Exact knowledge leaves e''' + kd e'' + kp e' + ki e = 0 driven by the reference alone, at every
posture. It is the opposite of sliding mode control, which knows one inertia a joint.
"""

from dataclasses import dataclass, field

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.controllers import InverseDynamicsController
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import Saturation

from scara_drake import checks, robot
from scara_drake.control.chatter import LIMIT
from scara_drake.control.controller import all_finite, check_finite


def _six(value: float) -> list[float]:
    return [value] * 6


@dataclass
class InverseDynamics:
    """Gains per joint; the defaults put three poles at -100 1/s, critically damped.

    Attributes:
        kp: of the error [1/s²].
        ki: of its integral [1/s³]; takes away the error that an unknown load would leave.
        kd: of its rate [1/s].
    """

    kp: list[float] = field(default_factory=lambda: _six(3e4))
    ki: list[float] = field(default_factory=lambda: _six(1e6))
    kd: list[float] = field(default_factory=lambda: _six(300.0))

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
                f"{robot.JOINT_NAMES[worst]} and T_s = {period:g} s, allowed below 2"
            )

    def make_system(self, period: float) -> Diagram:
        """Return a controller with these gains, see `make_inverse_dynamics`."""
        return make_inverse_dynamics(self, period)


class StateWatch(LeafSystem):
    """Stops the run where a state is not a number.

    Input ports:
        state (12): q, v measured [m, rad, m/s, rad/s]
        state_desired (12): q, v references
    Publish (every period): raises a RuntimeError that names the port. Publish events come before
        the plant's step, so nothing has been computed of a bad value.

    Args:
        period: [s].
    """

    def __init__(self, period: float) -> None:
        super().__init__()
        self._state = self.DeclareVectorInputPort("state", 12)
        self._desired = self.DeclareVectorInputPort("state_desired", 12)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._check)

    def _check(self, context: Context) -> None:
        if not all_finite(self._state.Eval(context), self._desired.Eval(context)):
            check_finite(self, context, (self._state, self._desired))


def make_inverse_dynamics(gains: InverseDynamics, period: float) -> Diagram:
    """Return Drake's `InverseDynamicsController` of the nominal robot, in the controller's socket.

    The effort is a function of the inputs at one instant. The integral is continuous state, so
    the Simulator integrates between the ticks.

    Ports:
        inputs ``state`` (12) and ``state_desired`` (12); outputs ``actuation`` (6) within the
        limits of the drives and ``actuation_commanded`` (6) before them [N, N m].

    Args:
        gains: checked.
        period: of the watch over the inputs [s].
    """
    plant = MultibodyPlant(time_step=0.0)  # kept alive by the controller that refers to it
    robot.add_scara(plant)
    plant.Finalize()
    builder = DiagramBuilder()
    law = builder.AddNamedSystem(
        "inverse_dynamics",
        InverseDynamicsController(
            plant, np.array(gains.kp), np.array(gains.ki), np.array(gains.kd), False
        ),
    )
    limit = builder.AddNamedSystem("effort_limit", Saturation(-robot.EFFORT, robot.EFFORT))
    watch = builder.AddNamedSystem("controller", StateWatch(period))  # its errors begin so
    commanded = law.GetOutputPort("actuation")
    builder.Connect(commanded, limit.get_input_port())
    for name, port in (("state", "estimated_state"), ("state_desired", "desired_state")):
        builder.ExportInput(law.GetInputPort(port), name)
        builder.ConnectInput(name, watch.GetInputPort(name))
    builder.ExportOutput(limit.get_output_port(), "actuation")
    builder.ExportOutput(commanded, "actuation_commanded")
    return builder.Build()
