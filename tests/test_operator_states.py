"""Anything may happen, in any order: the operator's side is never what it must not be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    rule,
    run_state_machine_as_test,
)
from operator_rig import PERIOD, OperatorRig

from scara_drake.kinematics import draw_into_reach
from scara_drake.operator.mapping import JoystickMapping
from scara_drake.operator.smooth_stick import MOTION
from scara_drake.operator.supervision import OperatorSupervision
from scara_drake.safety import Reason, State, words

NAN = float("nan")
UNIT = st.floats(-1.0, 1.0)
TIME = st.sampled_from([PERIOD, 0.01, 0.03, 0.2])
BAD = st.sampled_from([NAN, np.inf, -np.inf, 1e300, -1.06])
FOLLOWS = (State.ACTIVE, State.CLUTCH)


class AnythingGoes(RuleBasedStateMachine):
    @initialize(
        mode=st.sampled_from(["position", "rate"]),
        dead_man=st.booleans(),
        after=st.sampled_from(["engage", "resume"]),
    )
    def begin(self, mode: str, dead_man: bool, after: str) -> None:
        config = OperatorSupervision(dead_man=dead_man, after_outage=after)
        self.rig = OperatorRig(config, mapping=JoystickMapping(mode=mode, rate=0.5))
        self.rig.run(0.15).engage()
        assert self.rig.state == State.ACTIVE

    @rule(x=UNIT, y=UNIT, z=UNIT, mast=UNIT, yaw=UNIT, time=TIME)
    def move(self, x: float, y: float, z: float, mast: float, yaw: float, time: float) -> None:
        self.rig.run(time, x=x, y=y, z=z, mast_axis=mast, yaw=yaw)

    @rule(
        button=st.sampled_from(["engage", "clutch", "hold", "reset", "estop", "mast"]),
        down=st.booleans(),
        time=TIME,
    )
    def press(self, button: str, down: bool, time: float) -> None:
        self.rig.run(time, **{button: float(down)})

    @rule(time=TIME)
    def all_is_well(self, time: float) -> None:
        """Otherwise nearly no sequence would ever move."""
        self.rig.run(
            0.05,
            connected=1.0,
            age=0.0,
            silence=0.0,
            lateness=0.0,
            hold=0.0,
            estop=0.0,
            robot_state=0.0,
            robot_reason=0.0,
            bad_samples=0.0,
            reset=0.0,
            x=0.0,
        )
        self.rig.press("reset")
        if self.rig.state not in FOLLOWS:  # without a dead man a press would stop it
            self.rig.engage()
        self.rig.run(time)
        assert self.rig.state in FOLLOWS

    @rule(
        connected=st.sampled_from([1.0, 0.0, NAN]),
        age=st.sampled_from([0.0, 0.2, -3.0, NAN]),
        lateness=st.sampled_from([0.0, 0.3, 100.0, NAN]),
        time=TIME,
    )
    def device(self, connected: float, age: float, lateness: float, time: float) -> None:
        self.rig.run(time, connected=connected, age=age, lateness=lateness)

    @rule(
        name=st.sampled_from(["x", "mast_hat", "roll", "engage", "estop", "motion_scale"]),
        value=BAD,
        time=TIME,
    )
    def nonsense(self, name: str, value: float, time: float) -> None:
        before = self.rig.now[name]
        self.rig.run(time, **{name: value})
        self.rig.run(PERIOD, **{name: before})

    @rule(
        state=st.sampled_from([*State, NAN]),
        reason=st.sampled_from([*Reason]),
        faults=st.integers(0, 3),
        silence=st.sampled_from([0.0, 0.0, 1.0, NAN]),
        time=TIME,
    )
    def robot(self, state: float, reason: float, faults: int, silence: float, time: float) -> None:
        self.rig.run(
            time,
            robot_state=float(state),
            robot_reason=float(reason),
            robot_faults=float(faults),
            silence=silence,
        )

    @rule(scale=st.floats(0.0, 3.0), time=TIME)
    def scale(self, scale: float, time: float) -> None:
        self.rig.run(time, motion_scale=scale)

    @rule()
    def silence(self) -> None:
        self.rig.run(1.5, age=1.0)
        assert self.rig.state not in FOLLOWS
        motion = MOTION.unpack(self.rig.motion)
        for rate in (motion.v, motion.w, motion.climb):
            np.testing.assert_allclose(rate, 0.0, atol=1e-9)

    @invariant()
    def nothing_is_what_it_must_not_be(self) -> None:
        rig = self.rig
        words(rig.state, rig.reason)
        if rig.state in FOLLOWS:
            assert rig.now["connected"] > 0.0
            assert rig.now["age"] <= rig.config.stale_after
            assert rig.operator_input[12] == 0.0, "emergency stop"
            assert rig.now["silence"] <= rig.config.report_after
            assert rig.operator_input[8] == 1.0 or not rig.config.dead_man
        self.check_motion()
        rig.report[-8:] = rig.tool_command

    def check_motion(self) -> None:
        rig, form = self.rig, self.rig.form
        moves, path = np.array(rig.motions), np.array(rig.path)
        del rig.motions[:-1], rig.path[:-1]  # what was looked at
        assert np.isfinite(path).all()
        build_up = form.max_acceleration / form.max_jerk
        for speed, change, fastest, quickest in (
            ("v", "a", form.max_speed, form.max_acceleration),
            ("w", "w_dot", form.turn_rate, form.turn_acceleration),
            ("climb", "climb_dot", form.mast_rate, form.mast_acceleration),
        ):
            v, a = moves[:, MOTION.slices[speed]], moves[:, MOTION.slices[change]]
            jerk = np.diff(a, axis=0) / PERIOD
            for values, bound in ((v, fastest), (a, quickest), (jerk, quickest / build_up)):
                assert np.linalg.norm(values, axis=1).max(initial=0.0) <= bound * (1 + 1e-6) + 1e-9
            np.testing.assert_allclose(np.diff(v, axis=0), PERIOD * a[1:], atol=1e-12)
        assert (path[:, 7] >= 2.5 - 1e-9).all()
        assert (path[:, 7] <= 10.0 + 1e-9).all()
        np.testing.assert_allclose(np.linalg.norm(path[:, 3:7], axis=1), 1.0, atol=1e-9)
        for point in (path[:, :3] - path[:, 7:] * [0.0, 0.0, 1.0])[:: max(len(path) // 5, 1)]:
            drawn = point.copy()
            draw_into_reach(drawn)
            assert np.linalg.norm(point - drawn) < 0.01


def play(sequences: int, steps: int) -> None:
    run_state_machine_as_test(
        AnythingGoes,
        settings=settings(
            max_examples=sequences,
            stateful_step_count=steps,
            deadline=None,
            phases=[Phase.generate],  # to shrink so many steps takes minutes
            suppress_health_check=list(HealthCheck),
        ),
    )


def test_whatever_happens_the_operators_side_is_never_what_it_must_not_be() -> None:
    play(2, 150)


@pytest.mark.slow
def test_whatever_happens_a_thousand_times_neither() -> None:
    play(10, 1000)
