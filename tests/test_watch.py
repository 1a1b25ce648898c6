"""What happens to a command that no packet renews, and when it comes again."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples

import scara_drake as sd
from scara_drake import metrics
from scara_drake.channel.watch import (
    AFTERWARDS,
    IN_USE,
    LOST,
    RETURNING,
    WATCH,
    command_distance,
    watch_step,
)
from scara_drake.vectors import held_command

STEP = 1e-3
START = held_command([0.8, -0.76, 0.0], [0.0, 0.0, 0.0], 3.0)
OUTAGE = "!Packets {outages: [0.3, 1.0]}"


def command(x, turn, mast):
    return held_command([0.8 + x, -0.76, 0.0], [0.0, 0.0, turn], 3.0 + mast)


def run(afterwards, silent, commands, near=0.02, speed=0.1):
    """Return the commands that pass and the watch, tick by tick."""
    watch = WATCH.pack(
        age_limit=0.1, afterwards=AFTERWARDS.index(afterwards), near=near, step=speed * STEP
    )
    passed, state, rows, states = START.copy(), np.zeros(1), [], []
    for gap, wanted in zip(silent, commands, strict=True):
        watch_step(wanted, np.array([gap + 0.2]), np.array([0.2]), watch, passed, state)
        rows.append(passed.copy())
        states.append(state[0])
    return np.array(rows), np.array(states)


targets = st.builds(command, st.floats(-1.0, 1.0), st.floats(-3.0, 3.0), st.floats(-0.5, 0.5))


@examples(50)
@given(st.sampled_from(AFTERWARDS), targets, targets)
def test_a_lost_command_stands_and_one_in_time_passes(afterwards, before, after):
    rows, states = run(afterwards, [0.0, 0.09, 0.11, 5.0], [before, before, after, after])
    np.testing.assert_array_equal(rows, [before] * 4)
    np.testing.assert_array_equal(states, [IN_USE, IN_USE, LOST, LOST])


@examples(50)
@given(targets, targets, st.floats(0.01, 2.0))
def test_catching_up_is_never_faster_than_it_may_be_and_arrives(before, after, speed):
    ticks = 3 + int(np.ceil(command_distance(before, after) / (speed * STEP) * 1.3))
    rows, states = run(
        "catch_up", [0.0, 1.0] + [0.0] * ticks, [before, before] + [after] * ticks, speed=speed
    )
    for one, other in pairwise(rows[1:]):
        # The chord of a turn is shorter than its arc: the last steps of a half turn are longer.
        assert np.linalg.norm(one[:3] - other[:3]) <= speed * STEP * 1.001
        assert abs(one[7] - other[7]) <= speed * STEP * 1.001
    np.testing.assert_array_equal(rows[-1], after)
    assert states[-1] == IN_USE
    assert set(states[2:-1]) <= {RETURNING, IN_USE}


@examples(50)
@given(targets, targets, st.floats(0.001, 1.0))
def test_holding_ends_where_the_command_is_near_and_only_there(before, after, near):
    rows, states = run("hold", [0.0, 1.0, 0.0], [before, before, after], near=near)
    back = command_distance(before, after) <= near
    np.testing.assert_array_equal(rows[-1], after if back else before)
    assert states[-1] == (IN_USE if back else RETURNING)
    rows, states = run("hold", [0.0, 1.0, 0.0, 0.0], [before, before, after, before], near=near)
    np.testing.assert_array_equal(rows[-1], before)
    assert states[-1] == IN_USE


def after_the_outage(tmp_path, watch):
    """The recording of a stick that moves on during an outage, for 0.7 s at most 0.35 m."""
    trace = tmp_path / "reach.csv"
    trace.write_text("time,x,y,z,mast_axis,mast_hat\n0,0,0,0,0,0\n0.4,-1,0,0,0,0\n4,-1,0,0,0,0\n")
    settings = {"channel.up": OUTAGE, "operator.trace": str(trace), "operator.mapping.scale": 0.3}
    if watch:
        settings["channel.watch"] = watch
    return sd.simulate(sd.load_scenario("free_motion", settings), duration=2.0)


def test_what_follows_an_outage_is_chosen(tmp_path):
    follow = after_the_outage(tmp_path, "")
    hold = after_the_outage(tmp_path, "{age_limit: 0.2, afterwards: hold}")
    slow = after_the_outage(tmp_path, "{age_limit: 0.2, afterwards: catch_up, speed: 0.05}")
    speeds = {}
    for name, recording in (("follow", follow), ("hold", hold), ("slow", slow)):
        way = recording.p_WE_measured.differentiate("time").sel(time=slice(0.9, None))
        speeds[name] = float(((way**2).sum("axis") ** 0.5).max())
    assert speeds["follow"] > 0.3
    assert speeds["hold"] < 0.01
    assert 0.04 < speeds["slow"] < 0.06
    assert set(np.unique(hold.command_watch)) == {IN_USE, LOST, RETURNING}
    lost = hold.time.values[hold.command_watch.values == LOST]
    assert lost[0] == pytest.approx(0.5, abs=5e-3)
    assert lost[-1] == pytest.approx(1.0, abs=5e-3)
    said = metrics.verdict(hold)
    assert "nothing came over the uplink from 0.30 s to 1.00 s" in said.remarks
    assert any(remark.startswith("the command was lost") for remark in said.remarks)


@pytest.mark.parametrize(
    ("name", "settings", "message"),
    [
        ("teleoperation", {"channel.watch": "{}"}, r"^channel\.watch: set, allowed where"),
        (
            "bilateral",
            {"channel.watch": "{}", "channel.up": "!Packets {}"},
            r"^channel\.watch: set, allowed with a Joystick only",
        ),
        (
            "teleoperation",
            {"channel.watch.afterwards": "jump", "channel.up": "!Packets {}"},
            r"^channel\.watch\.afterwards: 'jump', allowed follow, hold, catch_up",
        ),
    ],
)
def test_a_watch_that_cannot_watch_is_refused(name, settings, message):
    with pytest.raises(ValueError, match=message):
        sd.load_scenario(name, settings)
