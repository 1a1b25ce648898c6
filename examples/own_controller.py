"""A controller of your own beside the paper's: a spring and a damper at each joint.

A controller is a small dataclass that holds the gains and makes a LeafSystem for a time step.
`JointController` has its ports, checks them for NaN, and records the effort; what is left to write
is the law: a function on arrays, whose arguments are named after what it reads and writes.

The mast hangs on its spring. Its weight needs an effort of m g, the spring gives m kp e, so at rest
e = g / kp, up to some um by which the swinging arm shakes it. Integral sliding mode control has an
integral, and leaves no error.

    python examples/own_controller.py
"""

from dataclasses import dataclass

import numpy as np

import scara_drake as sd
from scara_drake import joints, metrics, robot
from scara_drake.common.fields import number
from scara_drake.control.controller import JointController, Law

GRAVITY = 9.81  # [m/s^2]


@dataclass
class Spring:
    """A spring and a damper, per kg or kg m² of each joint.

    Attributes:
        kp: stiffness.
        kd: damping.
    """

    kp: float = number(2500.0, "1/s^2", 0.0)
    kd: float = number(100.0, "1/s", 0.0)

    def make_system(self, period: float) -> JointController:
        """Return the controller, which runs every `period` [s]."""
        parameters = {"gains": self, "m_hat": robot.nominal_inertias(), "period": period}
        return JointController(period, Law(update=pull), parameters, memory={})


# Plain Python; with `@numba.njit(cache=True)`, and arrays for the gains, it would be compiled.
def pull(
    state: np.ndarray,  # q, v measured
    state_desired: np.ndarray,  # q, v of the references
    gains: Spring,
    m_hat: np.ndarray,
    period: float,
    actuation_commanded: np.ndarray,
    actuation: np.ndarray,
) -> None:
    """Write the effort of one tick [N, N m], before and within the limits of the drives."""
    # The plant has stepped already: the reference is a period older than the state.
    q_desired = state_desired[:6] + period * state_desired[6:]
    error, error_rate = q_desired - state[:6], state_desired[6:] - state[6:]
    actuation_commanded[:] = m_hat * (gains.kp * error + gains.kd * error_rate)
    actuation[:] = np.clip(actuation_commanded, -joints.EFFORT, joints.EFFORT)


scenario = sd.load_scenario("joint_sine", {"operator.displacement": 0.0})  # the mast stays
spring = Spring()

print(f"g / kp = {1e3 * GRAVITY / spring.kp:.3f} mm")
print("controller              mast at rest [mm]   theta2, rms [mrad]")
for controller in (scenario.controller, spring):
    scenario.controller = controller
    recording = sd.simulate(scenario, duration=4.0)
    error = metrics.tracking_error(recording).sel(time=slice(2.0, None))
    hang = float(error.sel(joint="d1").mean())
    rms = float(metrics.rmse(error).sel(joint="theta2"))
    print(f"{type(controller).__name__:22} {1e3 * hang:18.3f} {1e3 * rms:20.3f}")
