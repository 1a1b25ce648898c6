"""What the engine watches for: joints at their limits, and links that touch a surface."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import DiagramBuilder
from strategies import examples
from strategies.surfaces import surfaces
from test_engine_dynamics import PLANTS, drake_step

from scara_drake import joints
from scara_drake.dynamics.arm import arm_parameters
from scara_drake.dynamics.equations import (
    WORK,
    arm_of,
    place_links,
    plant_step,
    set_efforts,
    work_of,
)
from scara_drake.engine.watch import FASTEST, LEVERS, is_fast, speed_bound, ticks_clear, watched
from scara_drake.environment import add_surfaces
from scara_drake.environment.surfaces import Environment
from scara_drake.environment.wall import Wall
from scara_drake.robot import add_scara

PERIOD = 1e-3  # [s]

units = st.floats(0.0, 1.0)
signs = st.floats(-1.0, 1.0)


def place(q, arm, work):
    place_links.py_func(q, arm_of(arm), work_of(work))


@examples(120)
@given(
    surface=surfaces(),
    posture=st.lists(units, min_size=6, max_size=6),
    heading=st.lists(signs, min_size=6, max_size=6),
)
def test_a_link_that_touches_was_seen_to_come(surface, posture, heading):
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlant(MultibodyPlantConfig(time_step=PERIOD), builder)
    add_scara(plant)
    environment = Environment([surface])
    add_surfaces(plant, scene_graph, environment)
    plant.Finalize()
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    own = plant.GetMyMutableContextFromRoot(context)
    links, rows = watched(plant, scene_graph, environment)
    arm, work = arm_parameters(plant), WORK.zeros()
    q = joints.LOWER + np.array(posture) * (joints.UPPER - joints.LOWER)
    q[0] = 2.5 + 2.0 * posture[0]
    # As fast as it may be without being looked at.
    v = np.array(heading) + 1e-3
    state = np.concatenate([q, v])
    v *= 0.999 * FASTEST / speed_bound(state)
    state[6:] = v
    assert not is_fast(rows, state)
    place(q, arm, work)
    clear = ticks_clear(links, rows, arm, work, state)
    for ticks in {0, clear // 2, clear}:
        plant.SetPositions(own, q + ticks * PERIOD * v)
        query = plant.get_geometry_query_input_port().Eval(own)
        if query.ComputePointPairPenetration():
            assert clear == 0
    # Not by being blind: from far away, in Drake's distance, nothing is near.
    fixed = set(plant.GetCollisionGeometriesForBody(plant.world_body()))
    plant.SetPositions(own, q)
    pairs = (
        plant.get_geometry_query_input_port().Eval(own).ComputeSignedDistancePairwiseClosestPoints()
    )
    gaps = [pair.distance for pair in pairs if {pair.id_A, pair.id_B} & fixed]
    # Of rounded edges the watch sees the sharp shape around them, so far off it may be.
    if not isinstance(surface, Wall) and min(gaps) > 0.2 + 2.0 * surface.edge_radius:
        assert clear > 0


@examples(60)
@given(
    posture=st.lists(units, min_size=6, max_size=6), speed=st.lists(signs, min_size=6, max_size=6)
)
def test_no_point_of_a_link_is_faster_than_its_bound(posture, speed):
    _, plant = PLANTS["nominal"]
    context = plant.CreateDefaultContext()
    q = joints.LOWER + np.array(posture) * (joints.UPPER - joints.LOWER)
    state = np.concatenate([q, speed])
    plant.SetPositionsAndVelocities(context, state)
    for link, ends in {
        "link_1": [[0.1, 0.1, 0.26], [0.1, 0.1, 2.66]],
        "link_3": [[0.0, 0.0, 0.87], [0.12, 0.0, 0.75]],
        "link_4": [[0.92, 0.0, 0.0], [0.82, 0.1, 0.0]],
        "link_5": [[0.1, 0.0, 0.0], [0.0, 0.0, 0.1]],
    }.items():
        V_WL = plant.GetBodyByName(link).EvalSpatialVelocityInWorld(context)
        R_WL = plant.GetBodyByName(link).EvalPoseInWorld(context).rotation()
        for p in ends:
            fast = np.linalg.norm(V_WL.Shift(R_WL @ np.array(p)).translational())
            assert fast <= speed_bound(state) + 1e-12


def test_an_arm_that_is_fast_is_always_looked_at():
    surface = np.zeros((1, 1))
    state = np.zeros(12)
    state[7] = 1.01 * FASTEST / LEVERS[1]
    assert is_fast(surface, state)
    assert not is_fast(surface[:0], state)
    state[7] = np.nan
    assert is_fast(surface, state)


@examples(200)
@given(
    joint=st.integers(0, 5),
    upper=st.booleans(),
    gap=st.floats(-6.0, -2.0).map(lambda power: 10.0**power),
    speed=st.sampled_from([0.0, 0.01, 0.1, 1.0, -0.1]),
    push=st.floats(-1e3, 1e3),
    tau=st.lists(signs, min_size=6, max_size=6),
)
def test_near_a_limit_the_step_is_drakes_or_is_not_taken(joint, upper, gap, speed, push, tau):
    simulator, plant = PLANTS["nominal"]
    q, v, force = joints.HOME.copy(), np.zeros(6), np.zeros(6)
    q[joint] = joints.UPPER[joint] - gap if upper else joints.LOWER[joint] + gap
    v[joint], force[joint] = speed, push
    tau = np.array(tau) * joints.EFFORT
    expected = drake_step(simulator, plant, q, v, tau, force)
    arm, work, state = arm_parameters(plant), WORK.zeros(), np.concatenate([q, v])
    set_efforts(tau, force, arm, work)
    if plant_step(arm, work, state):
        np.testing.assert_allclose(state, expected, rtol=1e-11, atol=1e-11)
    else:
        # Within reach in two periods at the faster of the two speeds, and named.
        reached = 2.0 * PERIOD * max(abs(speed), abs(WORK.unpack(work).right[joint]))
        assert reached >= gap * (1.0 - 1e-6)
        assert WORK.unpack(work).beyond[()] == joint + 1
        np.testing.assert_array_equal(state, np.concatenate([q, v]))
