"""The laws written out once more in a few lines, on a plant integrated by hand.

The loop is that of "One tick" in docs/architecture.md: u(0) is computed of the state and the
reference at t = 0, and each later sample compares the new state with the reference of the sample
before, carried one period along its velocity.
"""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

from scara_drake import joints, load_scenario, robot, simulate
from scara_drake.control.pid import Pid

TS = 1e-3
STEPS = 300
BASE = np.array([3.0, 0.0, 0.3, 0.2, 0.5, 0.0])
SWING = np.array([0.0, 0.7854, 0.0, 0.7854, 0.0, 0.0])
W = 1.25
START = BASE + 1e-3  # an error at t = 0, beside that of the velocity


def reference(t):
    return BASE + SWING * np.sin(W * t), SWING * W * np.cos(W * t)


def by_hand(effort):
    """Positions (STEPS + 1, 6) of the arm under u = effort(e, e', first) [N, N m]."""
    plant = MultibodyPlant(0.0)
    robot.add_scara(plant)
    plant.Finalize()
    context, forces = plant.CreateDefaultContext(), MultibodyForces(plant)
    damping = [plant.get_joint(i).default_damping_vector()[0] for i in plant.GetJointIndices()
               if plant.get_joint(i).num_velocities() == 1]  # fmt: skip
    q, v = START, np.zeros(6)
    q_d, rate = reference(0.0)
    tau = np.clip(effort(q_d - q, rate - v), -joints.EFFORT, joints.EFFORT)
    track = [q]
    for tick in range(STEPS):
        plant.SetPositions(context, q)
        plant.SetVelocities(context, v)
        plant.CalcForceElementsContribution(context, forces)
        # The damping of the joints acts at the end of the step.
        mass = plant.CalcMassMatrix(context) + TS * np.diag(damping)
        bias = plant.CalcInverseDynamics(context, np.zeros(6), forces)
        v = v + TS * np.linalg.solve(mass, tau - bias)
        q = q + TS * v
        track.append(q)
        q_d, rate = reference(TS * tick)
        tau = np.clip(effort(q_d + TS * rate - q, rate - v), -joints.EFFORT, joints.EFFORT)
    return np.array(track)


def in_the_project(controller=None):
    overrides = {
        "duration": STEPS * TS,
        "logging.period": TS,
        "operator.displacement": [0.0] * 6,
        "q0": START.tolist(),
    }
    scenario = load_scenario("joint_sine", overrides)
    if controller is not None:
        scenario.controller = controller
    return scenario, simulate(scenario)["q_measured"].values


def test_integral_sliding_mode_control_agrees_from_the_first_tick_on():
    scenario, q = in_the_project()
    g, m_hat = scenario.controller, robot.nominal_inertias()
    c, k, rho, phi = (np.array(row) for row in (g.c, g.k, g.rho, g.phi))
    z = None

    def effort(e, e_dot):
        nonlocal z
        sigma = e_dot + c * e
        z = sigma.copy() if z is None else z  # (46)
        s = sigma - z
        u2 = k * sigma
        z = np.clip(z - TS * u2, sigma - 2 * phi, sigma + 2 * phi)  # (33), and the clamp
        return m_hat * (rho * np.clip(s / phi, -1, 1) + u2)

    assert np.abs(by_hand(effort) - q).max() < 1e-9


def test_pid_control_agrees_from_the_first_tick_on():
    scenario, q = in_the_project(Pid())
    g, m_hat = scenario.controller, robot.nominal_inertias()
    kp, ki, kd = (np.array(row) for row in (g.kp, g.ki, g.kd))
    integral = None

    def effort(e, e_dot):
        nonlocal integral
        if integral is None:
            integral = -kp * e - kd * e_dot  # begins without an effort
        tau = m_hat * (kp * e + integral + kd * e_dot)
        free = (np.abs(tau) <= joints.EFFORT) | (tau * e < 0.0)
        integral = integral + TS * ki * e * free
        return tau

    assert np.abs(by_hand(effort) - q).max() < 1e-9
