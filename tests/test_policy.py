"""Operators who react: what they know, that they stop when the picture is cut, that they work."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples

from scara_drake import load_scenario, simulate
from scara_drake.diagram import make_diagram
from scara_drake.metrics import completion_time
from scara_drake.operator.policy import Continuous, MoveAndWait, OperatorPolicy, Press, Reach
from scara_drake.scenario import Scenario

PERIOD = 1e-3
FIRST = np.array([0.8, -1.0, 3.0])
STIFFNESS = 150.0  # of the hand [N/m]
WALL = -0.05  # along y [m]
STRATEGIES = (MoveAndWait, Continuous)
REACH = Reach(places=[[0.0, 0.0, 0.1], [0.05, 0.02, 0.0]])
PRESS = Press(places=[[0.0, -0.04, 0.0]])


def hand_of(policy, delay, duration, cut=np.inf, seed=0):
    """Where the hand is wanted (n, 3): the tool is where the hand is, at a wall; cut at a time."""
    block = OperatorPolicy(policy, FIRST, 1.0, STIFFNESS, PERIOD, seed).declaration
    assert block.update is not None
    assert block.initialize is not None
    memory = {name: np.array(group.initial, dtype=float) for name, group in block.memory.items()}
    mind, sense, worker = memory["mind"], memory["sense"], block.parameters["worker"]
    steps, late = round(duration / PERIOD), round(delay / PERIOD)
    x, motion, f_hand, wanted = np.zeros((steps, 3)), np.zeros(6), np.zeros(3), np.zeros(3)
    tool = FIRST.copy()
    block.initialize(tool, f_hand, worker, mind)
    hand = np.zeros((steps, 3))
    age = np.array([delay])
    for k in range(steps):
        t = k * PERIOD
        if t - delay < cut:
            tool = FIRST + x[max(k - 1 - late, 0)]
        else:
            age[0] += PERIOD
        block.update(t, tool, age, motion, f_hand, worker, mind, sense)
        block.outputs["hand_wanted"].kernel(mind, wanted)
        hand[k] = wanted
        motion[:3] = [wanted[0], max(wanted[1], WALL), wanted[2]]
        f_hand[:] = STIFFNESS * (wanted - motion[:3])
        x[k] = motion[:3]
    state = np.zeros(3)
    block.outputs["policy_state"].kernel(mind, sense, state)
    return hand, state


@pytest.mark.parametrize("strategy", STRATEGIES)
@examples(60)
@given(
    reaction=st.floats(0.05, 0.6),
    trust=st.floats(0.0, 1.0),
    delay=st.integers(0, 800),
    cut=st.floats(0.2, 5.0),
    press=st.booleans(),
    seed=st.integers(0, 2**62),
)
def test_he_stops_within_his_reaction_when_the_picture_is_cut(
    strategy, reaction, trust, delay, cut, press, seed
):
    policy = strategy(work=PRESS if press else REACH, reaction=reaction, trust=trust)
    late = delay * PERIOD
    end = cut + late + reaction
    hand, state = hand_of(policy, late, end + 1.5, cut, seed)
    # The device's hand has it two ticks later.
    after = hand[round(end / PERIOD) - 2 :]
    assert (after == after[0]).all()
    assert state[0] in (2.0, 3.0)


@pytest.mark.parametrize("work", [REACH, PRESS])
@pytest.mark.parametrize(("strategy", "delay"), [*((MoveAndWait, d) for d in (0.0, 0.3, 1.0)),
                                                 (Continuous, 0.0)])  # fmt: skip
def test_with_a_picture_he_does_his_work(strategy, delay, work):
    """So the hand that stops above is one that would have moved."""
    hand, state = hand_of(strategy(work=work), delay, 10.0 + 25.0 * delay)
    assert state[0] == 2.0
    assert state[2] > delay
    assert state[1] == len(list(work.stages()))
    last = work.places[-1]
    np.testing.assert_allclose(hand[-1], last, atol=2.0 * work.tolerance)


def test_the_force_is_pressed_within_its_share():
    """After the second of the three stages the hand has held the force, as a passive wall shows."""
    seen = []
    for seed in range(20):
        hand, _ = hand_of(MoveAndWait(work=PRESS, weber_force=0.0), 0.2, 12.0, seed=seed)
        depth = WALL - hand[:, 1]
        held = np.bincount(np.round(depth / 1e-4).astype(int).clip(0)).argsort()[::-1]
        pressed = STIFFNESS * 1e-4 * held[held > 50][0]
        seen.append(pressed)
    np.testing.assert_allclose(seen, PRESS.force, rtol=PRESS.share + 0.01)


def test_waiting_takes_the_delay_and_trusting_less_takes_less():
    def time_of(trust, delay):
        return hand_of(MoveAndWait(work=REACH, trust=trust), delay, 60.0)[1][2]

    assert time_of(1.0, 1.0) > time_of(1.0, 0.0) + 2.0
    assert time_of(0.0, 1.0) < time_of(1.0, 1.0)


LATE = "!Packets {delay: !ConstantDelay {delay: 0.1}, outages: [%g, 60.0]}"


def late_scenario(strategy, work="!Reach {}", cut=50.0, **changes):
    return load_scenario(
        "bilateral",
        {
            "operator.policy": f"!{strategy.__name__} {{work: {work}}}",
            "channel.up": "!ConstantDelay {delay: 0.1}",
            "channel.down": LATE % cut,
            "logging.period": 0.001,
            "duration": 2.0,
            **changes,
        },
    )


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_in_the_diagram_the_hand_rests_a_reaction_after_the_last_picture(strategy):
    cut = 0.7
    recording = simulate(late_scenario(strategy, cut=cut))
    target, end = recording.hand_target, cut + 0.1 + 0.2
    assert float(abs(target.sel(time=slice(cut, end - 0.1)).diff("time")).max()) > 0.0
    rest = target.sel(time=slice(end, None))
    assert float(abs(rest - rest.isel(time=0)).max()) == 0.0
    assert (recording.policy_phase.sel(time=slice(end, None)) == 3.0).all()
    assert float(recording.age_view[-1]) > 1.0
    assert np.isnan(completion_time(recording))


def test_nothing_of_the_robot_is_known_before_its_delay():
    """Two robots, one of which hardly moves: the hand is the same until a picture has come back."""
    runs = [
        simulate(late_scenario(Continuous, duration=1.0, **more))
        for more in ({}, {"inverse_kinematics.max_speed": 0.01})
    ]
    apart = abs(runs[0].hand_target - runs[1].hand_target).max("axis")
    moved = abs(runs[0].p_WE_measured - runs[1].p_WE_measured).max("axis") > 1e-9
    first = float(moved.time[int(moved.values.argmax())])
    assert float(apart.sel(time=slice(None, first + 0.1)).max()) == 0.0
    assert float(apart.max()) > 0.0


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_his_inputs_come_from_the_picture_s_link_and_from_the_master_alone(strategy):
    diagram = make_diagram(late_scenario(strategy))
    operator = diagram.GetSubsystemByName("operator")
    sources = {
        into[0].get_input_port(into[1]).get_name(): out[0].get_name()
        for into, out in diagram.connection_map().items()
        if into[0] is operator
    }
    assert sources == {
        "tool_seen": "view",
        "age_seen": "view",
        "motion_master": "master",
        "f_hand": "master",
    }
    assert len(sources) == operator.num_input_ports()


def test_without_a_policy_nothing_is_added():
    names = {system.get_name() for system in make_diagram(load_scenario("bilateral")).GetSystems()}
    assert not names & {"operator", "view"}


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"operator.policy": "!MoveAndWait {reaction: 0.01}"}, "operator.policy.reaction: 0.01"),
        ({"operator.policy": "!Continuous {trust: 1.5}"}, "operator.policy.trust: 1.5"),
        (
            {"operator.policy": "!MoveAndWait {work: !Press {normal: [0, 0, 0]}}"},
            "operator.policy.work.normal: ",
        ),
        (
            {"operator.policy": "!MoveAndWait {}", "operator.sweep.amplitude": 0.1},
            "operator.sweep.amplitude",
        ),
        (
            {"operator.policy": "!Continuous {work: !Reach {places: []}}"},
            "operator.policy.work.places: []",
        ),
        (
            {"operator.policy": "!Continuous {work: !Press {places: []}}"},
            "operator.policy.work.places: []",
        ),
        (
            {"operator.policy": "!Continuous {}", "operator.device": "touch"},
            "operator.policy.work.places[0]: 0.1 m from the centre, allowed up to 0.075 m",
        ),
        ({"operator.policy": "!Guess {}"}, "Guess"),
    ],
)
def test_bad_input_is_told_in_one_line(changes, told):
    with pytest.raises(ValueError, match=r"operator|Guess") as error:
        load_scenario("bilateral", changes)
    assert told in str(error.value)
    assert "\n" not in str(error.value)


def test_a_scenario_with_a_policy_is_written_and_read_again():
    from scara_drake.common.schema import build
    from scara_drake.common.yaml_text import read_yaml
    from scara_drake.scenario import dump_scenario

    made = late_scenario(MoveAndWait, "!Press {force: 2.0}")
    assert build(Scenario, read_yaml(dump_scenario(made), "text")) == made
