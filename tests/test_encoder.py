"""scara_drake.plant.encoder: what the sensors show, and that they add no tick to the loop."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from leaf import ports
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import LogVectorOutput
from scipy import signal, stats

from scara_drake import joints, robot
from scara_drake.common.fields import check
from scara_drake.plant.encoder import Encoder, EncoderSystem, encoder_sample

H = 1e-3
NONE = [0.0] * 6


def sample(q, v, encoder, memory, seed=0, period=H):
    """What the sensors show (12,); the memory moves on by a sample."""
    measured = np.empty(12)
    state = np.concatenate([np.broadcast_to(q, 6), np.broadcast_to(v, 6)]).astype(float)
    encoder_sample(state, encoder.parameters(period), seed, memory, measured)
    memory[0] += 1.0
    memory[1:] = measured
    return measured


def samples(motion, encoder, seed=0, first_velocity=0.0):
    """What joint 1 shows (n, 2) along a motion (n,)."""
    memory = np.zeros(13)
    rows = [sample(q, first_velocity, encoder, memory, seed) for q in motion]
    return np.array(rows)[:, [0, 6]]


@given(q=st.floats(-10, 10), resolution=st.floats(1e-7, 1e-2))
@settings(deadline=None)
def test_positions_are_whole_counts_within_half_a_count(q, resolution):
    measured = sample(q, 0.0, Encoder(resolution=[resolution] * 6), np.zeros(13))[:6]
    np.testing.assert_allclose(measured / resolution, np.rint(measured / resolution), atol=1e-6)
    assert np.abs(measured - q).max() <= resolution / 2 * (1 + 1e-9)


def test_an_ideal_sensor_shows_the_position_itself():
    assert sample(1.234567891234, 0.5, Encoder(NONE), np.zeros(13))[0] == 1.234567891234


def test_a_rounded_noisy_position_is_still_a_whole_count():
    encoder = Encoder(resolution=[1e-3] * 6, noise=[2e-3] * 6)
    counts = samples(np.full(200, 0.1), encoder)[:, 0] / 1e-3
    np.testing.assert_allclose(counts, np.rint(counts), atol=1e-9)
    assert np.unique(np.rint(counts)).size > 3


def test_the_velocity_is_the_exact_response_of_the_filtered_derivative():
    # w s / (s + w) of a position on straight lines: scipy's exact simulation of the same.
    times = H * np.arange(400)
    motion = np.interp(times, [0.0, 0.05, 0.2, 0.3, 0.4], [0.0, 0.0, 0.3, 0.1, 0.1])
    shown = samples(motion, Encoder(NONE, NONE, 120.0))[:, 1]
    _, wanted, _ = signal.lsim(([120.0, 0.0], [1.0, 120.0]), motion, times, interp=True)
    np.testing.assert_allclose(shown, wanted, atol=1e-9)


def test_a_constant_velocity_is_shown_from_the_first_sample():
    shown = samples(0.3 * H * np.arange(100), Encoder(NONE), first_velocity=0.3)
    np.testing.assert_allclose(shown[:, 1], 0.3, rtol=1e-9)


def test_a_count_makes_the_velocity_jump_by_the_filter_s_gain():
    step = samples(np.r_[np.zeros(3), np.full(5, 1e-4)], Encoder([1e-4] * 6, NONE, 500.0))[:, 1]
    assert step[3] == pytest.approx(1e-4 / H * (1 - math.exp(-0.5)))
    np.testing.assert_allclose(step[4:] / step[3:-1], math.exp(-0.5))


def test_noise_is_normal_and_white():
    noise = samples(np.zeros(20000), Encoder(NONE, [1e-3] * 6))[:, 0] / 1e-3
    assert stats.kstest(noise, "norm").pvalue > 0.01
    lagged = [np.corrcoef(noise[lag:], noise[:-lag])[0, 1] for lag in (1, 2, 6)]
    assert np.abs(lagged).max() < 4 / math.sqrt(noise.size)


def test_noise_has_the_stated_deviation_and_differs_by_joint_and_seed():
    encoder = Encoder(NONE, [1e-5, 2e-5, 3e-5, 4e-5, 5e-5, 0.0])

    def run(seed):
        memory = np.zeros(13)
        return np.array([sample(0.0, 0.0, encoder, memory, seed)[:6] for _ in range(5000)])

    noise = run(1)
    np.testing.assert_allclose(noise.std(axis=0), encoder.noise, rtol=0.04)
    correlation = np.corrcoef(np.column_stack([noise[:, :5], run(2)[:, :5]]).T)
    assert np.abs(correlation - np.eye(10)).max() < 4 / math.sqrt(5000)
    np.testing.assert_array_equal(run(1), noise)


class Probe(LeafSystem):
    """Remembers what a controller reads in its discrete update."""

    def __init__(self):
        super().__init__()
        self.port = self.DeclareVectorInputPort("state_measured", 12)
        self.seen = self.DeclareDiscreteState(12)
        self.DeclareStateOutputPort("seen", self.seen)
        self.DeclarePeriodicDiscreteUpdateEvent(H, 0.0, self.update)

    def update(self, context, discrete):
        discrete.get_mutable_value(int(self.seen))[:] = self.port.Eval(context)


def falling(encoder, seed=3):
    """The arm falling for 50 ms: logs at every tick of state, state_measured and what was read."""
    builder = DiagramBuilder()
    plant = MultibodyPlant(time_step=H)
    robot.add_scara(plant)
    plant.Finalize()
    plant.SetDefaultPositions(joints.HOME)
    builder.AddNamedSystem("plant", plant)
    sensors = builder.AddNamedSystem("encoder", encoder.make_system(H, seed))
    probe = builder.AddNamedSystem("probe", Probe())
    builder.Connect(plant.get_state_output_port(), sensors.get_input_port())
    builder.Connect(sensors.get_output_port(), probe.get_input_port())
    ports_ = (plant.get_state_output_port(), sensors.get_output_port(), probe.get_output_port())
    sinks = [LogVectorOutput(port, builder, H) for port in ports_]
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    plant.get_actuation_input_port().FixValue(plant.GetMyContextFromRoot(context), np.zeros(6))
    simulator = Simulator(diagram, context)

    def run(duration):
        simulator.AdvanceTo(duration)
        return [sink.FindLog(simulator.get_context()).data().T.copy() for sink in sinks]

    return run, simulator


def test_a_reader_in_an_update_sees_the_state_after_the_step_and_a_log_sees_the_same():
    encoder = Encoder([1e-9] * 6, [1e-5] * 6)
    state, measured, seen = falling(encoder)[0](0.05)
    # What was read at tick k is logged at k + 1, and belongs to the state logged at k + 1.
    np.testing.assert_array_equal(seen[1:], measured[1:])
    np.testing.assert_allclose(measured[:, :6], state[:, :6], atol=6e-5)
    assert np.abs(measured[:, :6] - state[:, :6]).max() > 1e-6


def test_an_ideal_sensor_with_a_fast_filter_shows_the_state_itself():
    # The plant's step is q + h v of the state after, so the difference of positions is that v.
    state, measured, seen = falling(Encoder(NONE, NONE, 1e5))[0](0.05)
    np.testing.assert_allclose(measured, state, atol=1e-10)
    np.testing.assert_allclose(seen[1:], state[1:], atol=1e-10)


def test_a_fork_continues_bit_for_bit_and_a_second_run_is_the_same():
    encoder = Encoder(noise=[1e-5] * 6)
    run, simulator = falling(encoder)
    run(0.0205)
    clone = simulator.get_context().Clone()
    straight = run(0.0505)
    fork = Simulator(simulator.get_system(), clone)
    fork.AdvanceTo(0.0505)
    system = simulator.get_system().GetSubsystemByName("encoder")
    values = [
        system.get_output_port().Eval(system.GetMyContextFromRoot(s.get_context()))
        for s in (simulator, fork)
    ]
    np.testing.assert_array_equal(*values)
    np.testing.assert_array_equal(falling(encoder)[0](0.0505)[1], straight[1])


def test_ports_and_constant_attributes():
    system = EncoderSystem(Encoder())
    assert ports(system) == ({"state": 12}, {"state_measured": 12})
    assert system.HasDirectFeedthrough(0, 0)


@pytest.mark.parametrize(
    ("encoder", "named"),
    [
        (Encoder(resolution=[-1.0] + [0.0] * 5), r"e\.resolution\[0\]: -1\.0, allowed 0 to 0\.1"),
        (Encoder(noise=[0.0] * 5), r"e\.noise: 5 entries, allowed 6"),
        (Encoder(noise=[math.nan] * 6), r"e\.noise\[0\]: nan"),
        (Encoder(velocity_bandwidth=0.0), r"e\.velocity_bandwidth: 0\.0, allowed 1 to"),
    ],
)
def test_bad_fields_are_named(encoder, named):
    with pytest.raises(ValueError, match=named):
        check(encoder, "e")
