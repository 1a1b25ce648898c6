"""Controllers of the user's own: what they need, and what happens where they err."""

import subprocess
import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.systems.framework import LeafSystem
from strategies import examples

from scara_drake import joints, load_scenario, make_diagram, robot, simulate
from scara_drake.common.block import Block, Declaration, Output
from scara_drake.common.finite import naming_nan
from scara_drake.control.controller import JointController, Law
from scara_drake.control.effort_limit import ABSURD, EffortLimit
from scara_drake.diagram import start_posture
from scara_drake.plant.perturbation import JointPerturbation

TS = 1e-3


class Springs(LeafSystem):
    """Springs and dampers, and from `since` on one effort that is `bad`."""

    def __init__(self, bad=None, since=0.0, entry=0, inputs=("state", "state_desired"), size=6):
        super().__init__()
        self.bad = bad, since, entry
        self.ports = [self.DeclareVectorInputPort(name, 12) for name in inputs]
        needs = {self.all_input_ports_ticket(), self.time_ticket()}
        self.DeclareVectorOutputPort("actuation", size, self.calc, prerequisites_of_calc=needs)

    def calc(self, context, output):
        state, desired = (port.Eval(context) for port in self.ports)
        error = desired - state
        u = robot.nominal_inertias() * (2500.0 * error[:6] + 100.0 * error[6:])
        bad, since, entry = self.bad
        if bad is not None and context.get_time() > since - TS / 2:
            u[entry] = bad
        output.SetFromVector(u)


def part(make):
    """A controller that makes whatever it is told to."""

    @dataclass
    class Part:
        def make_system(self, period):
            return make()

    return Part()


def first_reference():
    return start_posture(load_scenario("joint_sine"))


def with_controller(controller, **overrides):
    scenario = load_scenario("joint_sine", {"duration": 0.1, **overrides})
    scenario.controller = controller
    return scenario


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300, -1e300])
def test_an_effort_that_is_none_stops_the_run_and_is_named(bad):
    with pytest.raises(RuntimeError) as told:
        simulate(with_controller(part(partial(Springs, bad, 0.05, 3))))
    text = str(told.value)
    assert text.startswith(f"controller: port 'actuation' at t = 0.05 s: actuation[3] is {bad:g}")
    assert "\n" not in text


def spoil(state, state_desired, actuation_commanded, actuation):
    actuation_commanded[:] = np.inf
    actuation[:] = joints.EFFORT


def test_an_infinite_effort_before_the_limits_is_named_too():
    law = partial(JointController, TS, Law(update=spoil), {}, {})
    with pytest.raises(RuntimeError, match=r"^controller: port 'actuation_commanded' at t = 0"):
        simulate(with_controller(part(law)))


@examples(100)
@given(st.lists(st.floats(allow_nan=True, allow_infinity=True, width=64), min_size=6, max_size=6))
def test_the_limit_lets_through_what_a_drive_can_give_and_refuses_what_is_no_effort(asked):
    limit = EffortLimit("mine")
    context = limit.CreateDefaultContext()
    limit.GetInputPort("actuation_asked").FixValue(context, asked)
    fault = [not abs(u) <= ABSURD * most for u, most in zip(asked, joints.EFFORT, strict=True)]
    if any(fault):
        where = rf"^mine: port 'actuation' at t = 0 s: actuation\[{fault.index(True)}\] is "
        with pytest.raises(RuntimeError, match=where):
            limit.get_output_port().Eval(context)
    else:
        acts = limit.get_output_port().Eval(context)
        np.testing.assert_array_equal(acts, np.clip(asked, -joints.EFFORT, joints.EFFORT))


def test_the_applied_effort_is_the_one_that_acts():
    # A decimetre and a tenth of a radian off: the springs ask for more than the drives have.
    start = (first_reference() + 0.1).tolist()
    run = simulate(with_controller(part(Springs), q0=start))
    asked, applied = run.tau_commanded.values, run.tau_applied.values
    assert (np.abs(asked) > joints.EFFORT).any()
    np.testing.assert_array_equal(applied, np.clip(asked, -joints.EFFORT, joints.EFFORT))
    # Played back, it moves the arm just as it did.
    again = simulate(with_controller(part(partial(Played, applied)), q0=start))
    np.testing.assert_array_equal(again.q_measured, run.q_measured)


class Played(LeafSystem):
    """Plays efforts (samples, 6), one a tick."""

    def __init__(self, efforts):
        super().__init__()
        self.efforts = efforts
        self.DeclareVectorInputPort("state", 12)
        self.DeclareVectorInputPort("state_desired", 12)
        needs = {self.time_ticket()}
        self.DeclareVectorOutputPort("actuation", 6, self.calc, prerequisites_of_calc=needs)

    def calc(self, context, output):
        output.SetFromVector(self.efforts[round(context.get_time() / TS)])


def test_a_governor_sees_the_limits_that_an_own_controller_does_not_tell():
    start = (first_reference() + 0.1).tolist()
    run = simulate(with_controller(part(Springs), governor={}, q0=start))
    assert (np.abs(run.q_governed - run.q_desired).max("time") > 0.0).any()


class Empty:
    """No controller at all."""


class Named:
    """Right but for being the class."""

    def make_system(self, period):
        return Springs()


class Hasty:
    """Takes no period."""

    def make_system(self):
        return Springs()


@pytest.mark.parametrize(
    ("wrong", "what"),
    [
        (None, "NoneType"),
        (Empty(), "Empty"),
        (Hasty(), "Hasty"),
        (Named, "the class Named itself"),
        (part(int), "Part.make_system returns int"),
        (part(partial(Springs, inputs=("q", "state_desired"))), "without the input state (12)"),
        (part(partial(Springs, size=5)), "without the output actuation (6)"),
    ],
)
def test_what_is_no_controller_is_told_what_one_needs_in_a_line(wrong, what):
    with pytest.raises(ValueError, match=r"^controller: ") as told:
        make_diagram(with_controller(wrong))
    text = str(told.value)
    assert what in text
    assert "\n" not in text
    for need in ("make_system(period)", "state (12)", "state_desired (12)", "actuation (6)"):
        assert need in text


def nan_force(t, perturbation_force):
    perturbation_force[:] = np.nan if t > 0.0195 else 0.0


class NanForce(JointPerturbation):
    def make_system(self):
        return Block(Declaration(outputs={"perturbation_force": Output(6, nan_force)}))


def test_a_nan_that_reaches_the_plant_names_the_system_that_made_it():
    scenario = load_scenario("joint_sine", {"duration": 0.05})
    scenario.perturbation = NanForce()
    with pytest.raises(RuntimeError, match=r"^perturbation: port 'pert.* at t = 0\.02"):
        simulate(scenario)


def test_an_error_without_a_nan_stays_what_it_is():
    diagram = make_diagram(load_scenario("joint_sine"))
    with (
        pytest.raises(RuntimeError, match=r"^mine NaN$"),
        naming_nan(diagram, diagram.CreateDefaultContext()),
    ):
        raise RuntimeError("mine NaN")


README_LIKE = """
from dataclasses import dataclass

from pydrake.systems.framework import LeafSystem

import scara_drake as sd


class Mine(LeafSystem):
    pass

@dataclass
class Gains:
    k: float = 1.0
    def make_system(self, period: float) -> LeafSystem:
        return Mine()

scenario = sd.load_scenario("joint_sine")
scenario.controller = Gains()
"""


@pytest.mark.slow
def test_a_type_checker_takes_it(tmp_path):
    script = tmp_path / "mine.py"
    script.write_text(README_LIKE)
    checked = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", str(script)],
        cwd=Path(__file__).parent.parent, capture_output=True, text=True,
    )  # fmt: skip
    assert "Success" in checked.stdout, checked.stdout
