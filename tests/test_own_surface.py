"""Surfaces of kinds that no compiled kernel knows; a ball is a box rounded until it is one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from kinds import of_kind
from pydrake import geometry
from pydrake.math import RigidTransform

from scara_drake import joints, kinematics, plotting
from scara_drake.common.fields import check, number, vector
from scara_drake.environment import (
    Box,
    Compliance,
    ConstantVelocity,
    Environment,
    SineMotion,
    Wall,
    contact_force,
    tool_contact,
)
from scara_drake.environment.own import OwnSurfaces
from scara_drake.operator.joint_motion import JointMotion
from scara_drake.recordings.surfaces import read_blocks
from scara_drake.scenario import dump_scenario, load_scenario
from scara_drake.simulation.run import simulate

TOOL = kinematics.forward_kinematics(joints.HOME)[:3, 3]
RADIUS = 0.1
TURNED = [0.3, -0.4, 1.1]


@dataclass
class Ball(Compliance):
    """A ball that is turned, which nobody can see."""

    name: str = "ball"
    centre: list[float] = vector([0.0, 0.0, 0.0], "m", -100.0, 100.0)
    radius: float = number(RADIUS, "m", 1e-3, 100.0)

    def pose(self) -> RigidTransform:
        return RigidTransform(Box(rpy=TURNED).pose().rotation(), np.array(self.centre))

    def distance(self, p_S, normal_S) -> float:
        away = float(np.linalg.norm(p_S))
        normal_S[:] = p_S / away
        return away - self.radius

    def shape(self):
        return geometry.Sphere(self.radius), RigidTransform()

    def corners(self):
        return np.array(self.centre) + RADIUS * np.vstack([np.eye(3), -np.eye(3)])


def box(ball: Ball) -> Box:
    """The same ball, of a kind that the kernels know."""
    side = 2 * ball.radius
    return Box(
        name=ball.name,
        centre=ball.centre,
        size=[side] * 3,
        edge_radius=ball.radius,
        law=ball.law,
        stiffness=ball.stiffness,
        damping=ball.damping,
        motion=ball.motion,
    )


def around(*surfaces: Any) -> Environment:
    """An environment of surfaces of any kind."""
    return Environment(list(surfaces))


def contact(surfaces, t, state):
    """Penetration, force and joint force of the tool."""
    environment = around(*surfaces)
    rows = OwnSurfaces.of(environment).rows(t, state, environment.parameters())
    found = np.empty(len(surfaces)), np.empty(3), np.empty(6)
    tool_contact(t, state, rows, *found)
    return found


@pytest.mark.parametrize("law", ["impedance", "hunt_crossley"])
@pytest.mark.parametrize(
    "motion",
    [None, ConstantVelocity([0.01, 0.03, -0.02]), SineMotion([0.0, 0.6, 0.8], 0.01, 2.0, 0.4)],
)
def test_a_ball_of_ones_own_is_the_box_that_is_rounded_to_a_ball(law, motion):
    rng = np.random.default_rng(3)
    for _ in range(40):
        out = rng.normal(size=3)
        centre = TOOL - rng.uniform(0.5, 1.1) * RADIUS * out / np.linalg.norm(out)
        ball = Ball(centre=centre.tolist(), law=law, motion=motion)
        state = np.concatenate([joints.HOME, rng.uniform(-0.3, 0.3, 6)])
        t = rng.uniform(0.0, 1.0)
        wall = Wall(point=(TOOL + np.array([0, 0.002, 0])).tolist())
        for mine, known in zip(
            contact([wall, ball], t, state), contact([wall, box(ball)], t, state), strict=True
        ):
            np.testing.assert_allclose(mine, known, rtol=1e-9, atol=1e-9)


def test_a_press_on_it_is_that_on_the_box():
    recordings = []
    for kind in (lambda ball: ball, box):
        scenario = load_scenario("joint_sine", {"controller.phi": 1.0})
        ball = Ball(centre=(TOOL - [0.02, RADIUS - 0.005, 0.0]).tolist())
        scenario.q0 = joints.HOME.tolist()
        of_kind(JointMotion, scenario.operator).base = joints.HOME.tolist()
        scenario.environment.surfaces = [kind(ball)]
        recordings.append(simulate(scenario, duration=0.5))
    mine, known = recordings
    assert float(abs(known.f_env_on_tool_W).max()) > 10.0
    for name in ("f_env_on_tool_W", "penetration", "q_measured"):
        np.testing.assert_allclose(mine[name], known[name], rtol=1e-7, atol=1e-9)


def test_the_parameters_of_an_update_are_left_as_they_are():
    environment = around(Ball(centre=TOOL.tolist()), Wall())
    rows = environment.parameters()
    before = rows.copy()
    state = np.concatenate([joints.HOME + 0.01, np.zeros(6)])
    OwnSurfaces.of(environment).rows(0.0, state, rows)
    np.testing.assert_array_equal(rows, before)


def test_a_kernel_that_is_not_told_where_it_is_says_so_by_nan():
    penetration, f = np.empty(1), np.empty(3)
    rows = around(Ball()).parameters()
    contact_force(0.0, np.zeros(3), np.zeros(3), rows, penetration, f)
    assert np.isnan(f).all()


def test_its_fields_have_bounds():
    with pytest.raises(ValueError, match=r"environment.surfaces\[0\].radius: 0.0, allowed"):
        check(around(Ball(radius=0.0)), "environment")


def test_a_surface_without_a_distance_is_refused_at_the_first_contact():
    @dataclass
    class Bare(Ball):
        distance = Compliance.distance

    with pytest.raises(NotImplementedError):
        contact([Bare()], 0.0, np.zeros(12))


def test_plots_and_replay_of_its_recording_leave_it_out():
    scenario = load_scenario("teleoperation")
    scenario.environment = around(*scenario.environment.surfaces, Ball(centre=[0.0, 0.0, 9.0]))
    recording = simulate(scenario, duration=0.01)
    assert [wall.name for wall in plotting.walls(recording)] == ["wall"]
    assert len(read_blocks(dump_scenario(scenario))) == 1
