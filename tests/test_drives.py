"""scara_drake.plant: lag and friction, by closed forms, energy, and the arm in a loop."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from leaf import ports, tick
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput
from scipy import integrate

from scara_drake import joints, robot
from scara_drake.common.fields import check, check_sampling
from scara_drake.plant.drives import ActuatorLag, ActuatorLagSystem, Drives
from scara_drake.plant.encoder import Encoder
from scara_drake.plant.friction import (
    FRICTION,
    JointFriction,
    JointFrictionSystem,
    joint_friction,
)

H = 1e-3


# Lag


def response(time_constant, efforts):
    """Efforts delivered (n, 6) for efforts held over a period each (n,)."""
    system = ActuatorLag([time_constant] * 6).make_system(H)
    context = system.CreateDefaultContext()
    rows = []
    for u in efforts:
        system.get_input_port().FixValue(context, np.full(6, u))
        rows.append(system.get_output_port().Eval(context).copy())
        tick(system, context)
    return np.array(rows)


@pytest.mark.parametrize("time_constant", [2e-4, 1e-3, 5e-3])
def test_lag_delivers_the_mean_of_the_first_order_response(time_constant):
    efforts = np.r_[np.ones(10), np.full(10, -2.0), np.zeros(5)]

    def rate(t, tau):
        return (efforts[min(int(t / H), 24)] - tau) / time_constant

    solution = [np.zeros(1)]
    wanted = []
    for k in range(25):  # one period at a time: the effort steps between them
        span = (k * H, (k + 1 - 1e-9) * H)
        piece = integrate.solve_ivp(
            rate, span, solution[-1], "Radau", rtol=1e-10, atol=1e-12, dense_output=True
        )
        solution.append(piece.y[:, -1])
        wanted.append(integrate.quad(lambda t: piece.sol(t)[0], *span)[0] / H)  # noqa: B023
    np.testing.assert_allclose(response(time_constant, efforts)[:, 0], wanted, atol=1e-6)


def test_a_lag_without_time_constant_is_none_at_all():
    efforts = np.array([1.0, -3.0, 2.0])
    np.testing.assert_allclose(response(0.0, efforts)[:, 2], efforts, rtol=1e-5)


@given(u=st.lists(st.floats(-1e4, 1e4), min_size=1, max_size=20), T=st.floats(0, 0.1))
@settings(deadline=None, max_examples=50)
def test_lag_never_leaves_the_range_of_the_efforts_asked_for(u, T):
    delivered = response(T, u)
    margin = 1e-9 * max(map(abs, u))
    assert delivered.max() <= max(*u, 0.0) + margin
    assert delivered.min() >= min(*u, 0.0) - margin


def test_lag_is_fed_through_in_the_same_tick():
    system = ActuatorLagSystem(ActuatorLag())
    assert ports(system) == ({"actuation": 6}, {"actuation_delivered": 6})
    assert system.HasDirectFeedthrough(0, 0)
    assert response(3e-4, [1.0])[0, 0] == pytest.approx(1 - 0.3 * (1 - math.exp(-1 / 0.3)))


# Friction, of one joint: a mass with the least inertia of joint 2 unless said otherwise.

JOINT = 1
PARAMETERS = JointFriction().parameters()
F_C = FRICTION.unpack(PARAMETERS).coulomb[JOINT]
SIGMA = FRICTION.unpack(PARAMETERS).sigma_0[JOINT]
Z_MAX = F_C / SIGMA
LEAST_INERTIA = FRICTION.unpack(PARAMETERS).sigma_1[JOINT] ** 2 / (4 * SIGMA)


class Sled:
    """A mass on the friction of joint 2, stepped like Drake's discrete plant."""

    def __init__(self, inertia=LEAST_INERTIA, parameters=PARAMETERS):
        self.inertia, self.parameters = inertia, parameters
        self.state = np.zeros(12)
        self.memory = np.r_[np.zeros(6), np.full(6, np.nan)]
        self.force = np.zeros(6)
        self.touch()

    def touch(self):
        joint_friction(self.state, self.parameters, self.memory, self.force)

    def step(self, load):
        self.state[6 + JOINT] += H / self.inertia * (load + self.force[JOINT])
        self.state[JOINT] += H * self.state[6 + JOINT]
        self.touch()

    @property
    def q(self):
        return self.state[JOINT]

    @property
    def v(self):
        return self.state[6 + JOINT]

    @property
    def energy(self):
        return self.inertia * self.v**2 / 2 + SIGMA * self.memory[JOINT] ** 2 / 2


@pytest.mark.parametrize("inertia", [1.0, 10.0])
@pytest.mark.parametrize("share", [0.1, 0.6, 0.9])
def test_a_load_below_coulomb_is_held_without_creep(share, inertia):
    sled = Sled(inertia * LEAST_INERTIA)
    for k in range(1000):  # grows slowly, so nothing overshoots
        sled.step(share * F_C * min(k / 500, 1.0))
    settled = sled.q
    assert settled == pytest.approx(share * Z_MAX, rel=1e-3)
    for _ in range(20000):
        sled.step(share * F_C)
    assert sled.q == pytest.approx(settled, abs=1e-4 * Z_MAX)
    for _ in range(3000):
        sled.step(0.0)
    assert abs(sled.q) < 1e-3 * Z_MAX  # presliding is elastic


def test_a_vibrating_load_below_coulomb_does_not_creep():
    sled = Sled()
    trace = []
    for k in range(20000):
        sled.step(F_C * min(k / 500, 1.0) * (0.5 + 0.3 * math.sin(0.2 * k)))
        trace.append(sled.q)
    first, last = np.mean(trace[2000:4000]), np.mean(trace[-2000:])
    assert abs(last - first) < 1e-3 * Z_MAX


def test_a_joint_breaks_away_at_coulomb_and_slides_at_constant_friction():
    sled = Sled()
    load = 0.0
    while sled.q < 2 * Z_MAX:
        load += F_C / 20000
        sled.step(load)
    assert load == pytest.approx(F_C, rel=0.02)
    for _ in range(200):
        sled.step(1.5 * F_C)
    before = sled.v
    for _ in range(100):
        sled.step(1.5 * F_C)
        assert sled.force[JOINT] == -F_C
    assert sled.v - before == pytest.approx(100 * H * 0.5 * F_C / sled.inertia)


def test_a_sliding_joint_stops_where_coulomb_friction_stops_it():
    sled = Sled()
    sled.state[6 + JOINT] = v = 0.5
    for _ in range(2000):
        sled.step(0.0)
    assert abs(sled.v) < 1e-9
    assert sled.q == pytest.approx(sled.inertia * v**2 / (2 * F_C), rel=0.02)


@given(seed=st.integers(0, 10**6), scale=st.floats(0.1, 3.0), inertia=st.floats(1.0, 20.0))
@settings(deadline=None, max_examples=40)
def test_it_takes_more_energy_than_it_gives_over_any_motion(seed, scale, inertia):
    # A mass pushed at random: the work of the friction and its stored energy never exceed zero by
    # more than the energy of one step of its spring.
    rng = np.random.default_rng(seed)
    sled = Sled(inertia * LEAST_INERTIA)
    loads = np.convolve(rng.normal(0.0, 1.0, 1500), np.ones(20) / 5, "valid") * scale * F_C
    work = 0.0
    for load in loads:
        held, before = sled.force[JOINT], sled.q
        sled.step(load)
        work += held * (sled.q - before)
        assert work <= 0.02 * F_C * Z_MAX
    # Left alone, the energy only falls.
    energies = []
    for _ in range(300):
        sled.step(0.0)
        energies.append(sled.energy)
    assert np.diff(energies).max() <= 1e-3 * energies[0] + 1e-12


@given(
    state=st.lists(st.floats(-10, 10), min_size=12, max_size=12),
    viscous=st.floats(0, 100),
    steps=st.integers(1, 5),
)
@settings(deadline=None)
def test_the_force_is_bounded_by_coulomb_and_viscous(state, viscous, steps):
    friction = JointFriction(viscous=[viscous] * 6)
    memory, force = np.r_[np.zeros(6), np.full(6, np.nan)], np.empty(6)
    for k in range(steps):
        now = np.array(state) * math.cos(k)
        joint_friction(now, friction.parameters(), memory, force)
        bound = np.array(friction.coulomb) + viscous * np.abs(now[6:])
        assert np.all(np.abs(force) <= bound * (1 + 1e-12))


def test_no_coulomb_is_viscous_friction_alone():
    friction = JointFriction([0.0] * 6, [3.0] * 6)
    memory, force = np.r_[np.zeros(6), np.full(6, np.nan)], np.empty(6)
    joint_friction(np.r_[np.ones(6), np.full(6, 0.5)], friction.parameters(), memory, force)
    np.testing.assert_allclose(force, -1.5)


def arm(friction, load, duration, q=joints.HOME):
    """State (n, 12) and friction (n, 6) of the arm under a constant load added to gravity's."""
    builder = DiagramBuilder()
    plant = builder.AddNamedSystem("plant", MultibodyPlant(time_step=H))
    robot.add_scara(plant)
    plant.Finalize()
    plant.SetDefaultPositions(q)
    scratch = plant.CreateDefaultContext()
    holding = load - plant.CalcGravityGeneralizedForces(scratch)
    drives = builder.AddSystem(ConstantVectorSource(holding))
    dry = builder.AddNamedSystem("friction", friction.make_system(H))
    builder.Connect(plant.get_state_output_port(), dry.get_input_port())
    builder.Connect(dry.get_output_port(), plant.get_applied_generalized_force_input_port())
    builder.Connect(drives.get_output_port(), plant.get_actuation_input_port())
    outputs = (plant.get_state_output_port(), dry.get_output_port())
    sinks = [LogVectorOutput(port, builder, H) for port in outputs]
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(duration)
    return [sink.FindLog(simulator.get_context()).data().T.copy() for sink in sinks]


def test_the_arm_rests_on_its_friction():
    # Small loads on every joint at once: the bristles take them all, and nothing creeps.
    friction = JointFriction()
    load = 0.3 * np.array(friction.coulomb) * [1, -1, 1, -1, 1, -1]
    state, force = arm(friction, load, 2.0)
    np.testing.assert_allclose(force[-1], -load, rtol=1e-2)
    np.testing.assert_allclose(
        state[-1, :6] - joints.HOME,
        0.3 * np.array(friction.presliding) * [1, -1, 1, -1, 1, -1],
        rtol=0.05,
    )
    assert np.abs(state[-1, :6] - state[1000, :6]).max() < 1e-8
    assert np.abs(state[-1, 6:]).max() < 1e-7


def test_a_ten_times_stiffer_friction_still_settles_within_the_sampling_rule():
    friction = JointFriction()
    stiff = JointFriction(presliding=[0.1 * x for x in friction.presliding])
    check_sampling(stiff, "f", H)
    state, force = arm(stiff, 0.5 * np.array(stiff.coulomb), 1.0)
    assert np.abs(state[-1, 6:]).max() < 1e-6
    np.testing.assert_allclose(force[-1], -0.5 * np.array(stiff.coulomb), rtol=1e-2)


def test_too_stiff_a_friction_is_refused_and_would_not_settle():
    stiff = JointFriction(presliding=[0.01 * x for x in JointFriction().presliding])
    with pytest.raises(ValueError, match=r"d\.friction: h max lambda.* allowed below 4"):
        check_sampling(Drives(friction=stiff), "d", H)
    state, _ = arm(stiff, 0.5 * np.array(stiff.coulomb), 0.3)
    assert np.abs(state[-50:, 6:]).max() > 1e-4


def test_the_defaults_hold_at_every_time_step_of_a_scenario():
    for period in (1e-4, 1e-3, 2e-3):
        check_sampling(Drives(friction=JointFriction()), "d", period)
    check_sampling(Drives(), "d", H)


def test_starting_again_changes_nothing():
    # Initialization of a cloned context must not move the bristles.
    system = JointFrictionSystem(JointFriction())
    assert ports(system) == ({"state": 12}, {"friction_force": 6})
    assert not system.HasAnyDirectFeedthrough()
    context = system.CreateDefaultContext()
    for q in (0.0, 1e-5, 3e-5):
        system.get_input_port().FixValue(context, np.full(12, q))
        tick(system, context)
    force = system.get_output_port().Eval(context).copy()
    assert np.all(force < 0.0)
    Simulator(system, context).Initialize()
    np.testing.assert_array_equal(system.get_output_port().Eval(context), force)


def test_drives_read_from_yaml_and_write_back():
    text = "{encoder: {velocity_bandwidth: 300}, friction: {coulomb: [1, 1, 1, 1, 1, 1]}}"
    drives = yaml_load_typed(schema=Drives, data=text, defaults=Drives())
    assert drives == Drives(
        encoder=Encoder(velocity_bandwidth=300.0), friction=JointFriction([1.0] * 6)
    )
    assert yaml_load_typed(schema=Drives, data=yaml_dump_typed(drives)) == drives
    check(drives, "drives")
    check(Drives(), "drives")


@pytest.mark.parametrize(
    ("drives", "named"),
    [
        (Drives(encoder=Encoder(noise=[-1.0] * 6)), r"d\.encoder\.noise\[0\]: -1\.0"),
        (Drives(lag=ActuatorLag([0.0] * 5)), r"d\.lag\.time_constant: 5 entries"),
        (Drives(lag=ActuatorLag([math.inf] * 6)), r"d\.lag\.time_constant\[0\]: inf"),
        (Drives(friction=JointFriction([-1.0] * 6)), r"d\.friction\.coulomb\[0\]: -1\.0"),
        (Drives(friction=JointFriction(viscous=[math.nan] * 6)), r"d\.friction\.viscous\[0\]: nan"),
        (Drives(friction=JointFriction(presliding=[0.0] * 6)), r"presliding\[0\]: 0\.0, .*above 0"),
    ],
)
def test_bad_fields_are_named(drives, named):
    with pytest.raises(ValueError, match=named):
        check(drives, "d")
