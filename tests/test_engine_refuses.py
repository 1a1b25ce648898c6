"""What the compiled engine cannot do it says, and `auto` has Drake do it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from journalled import journalled
from kinds import of_kind
from numba import njit
from pydrake.geometry import Meshcat
from test_own_controller import Springs, part
from test_own_surface import Ball

from scara_drake import joints, load_recording, load_scenario, simulate
from scara_drake.cli.main import main
from scara_drake.common.block import Block, Declaration, Output
from scara_drake.engine.errors import LeftTheModelError, NotCompilableError
from scara_drake.environment import Box, Environment
from scara_drake.operator.joint_motion import JointMotion
from scara_drake.plant.perturbation import JointPerturbation


def own_controller():
    scenario = load_scenario("joint_sine")
    scenario.controller = part(Springs)
    return scenario


def own_surface():
    scenario = load_scenario("joint_sine")
    ball: Any = Ball(centre=[5.0, 5.0, 5.0])
    scenario.environment = Environment([ball])
    return scenario


def changed(name, **settings):
    return lambda: load_scenario(name, {key.replace("__", "."): v for key, v in settings.items()})


REFUSED = {
    "a controller of the user's own": (own_controller, "controller: Springs"),
    "a surface of the user's own": (own_surface, "contact: OwnContact"),
    "Drake's contact": (
        changed("teleoperation", environment__surfaces__0__law="drake"),
        "contact: PlantContact",
    ),
    "inverse dynamics": (changed("joint_sine", controller="!InverseDynamics {}"), "controller: "),
    "a swarm each tick": (
        changed("teleoperation", inverse_kinematics__method="pso"),
        "inverse_kinematics: ",
    ),
}


@pytest.mark.parametrize(("make", "told"), REFUSED.values(), ids=REFUSED)
def test_what_only_drake_runs_is_named_in_a_line_and_auto_takes_drake(make, told):
    scenario = make()
    with pytest.raises(NotCompilableError, match=f"^{told}") as error:
        simulate(scenario, duration=0.01, engine="compiled")
    assert isinstance(error.value, ValueError)
    assert "\n" not in str(error.value)
    recording = simulate(scenario, duration=0.01)
    assert recording.attrs["engine"] == "drake"
    assert recording.attrs["engine_reason"] == str(error.value)
    asked_for = simulate(scenario, duration=0.01, engine="drake")
    assert "engine_reason" not in asked_for.attrs
    np.testing.assert_array_equal(asked_for.q_measured, recording.q_measured)


def test_a_run_that_is_drawn_or_paced_is_drakes():
    scenario = load_scenario("joint_sine", {"duration": 0.02})
    for seen in ({"meshcat": Meshcat()}, {"realtime_rate": 10.0}):
        with pytest.raises(ValueError, match=r"^engine: 'compiled', allowed auto, drake"):
            simulate(scenario, engine="compiled", **seen)
        assert simulate(scenario, **seen).attrs["engine"] == "drake"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--set", "controller=!InverseDynamics {}", "--engine", "compiled"], "controller: "),
        (["--engine", "fast"], "engine: 'fast', allowed auto, drake, compiled"),
    ],
)
def test_the_command_line_says_it_in_a_line_with_status_2(arguments, told, capsys, tmp_path):
    out = tmp_path / "run.nc"
    base = ["run", "joint_sine", "--no-meshcat", "--no-realtime", "--duration", "0.02"]
    assert main([*base, "--record", str(out), *arguments]) == 2
    *shown, line = capsys.readouterr().err.splitlines()
    assert line.startswith(f"scara-drake: {told}")
    assert len(shown) <= 1  # of the progress
    assert not list(tmp_path.iterdir())


def into_the_limit(joint, side):
    """A start five millimetres or milliradians from a limit, and a push that no drive holds."""
    scenario = load_scenario("joint_sine", {"duration": 0.3})
    scenario.q0 = joints.HOME.tolist()
    scenario.q0[joint] = (joints.LOWER, joints.UPPER)[side][joint] + (5e-3, -5e-3)[side]
    scenario.operator = JointMotion(base=list(scenario.q0))
    scenario.perturbation = JointPerturbation()
    scenario.perturbation.offset[joint] = (-300.0, 300.0)[side]
    return scenario


def same(one, other):
    for name in one.variables:
        np.testing.assert_array_equal(one[name], other[name], err_msg=str(name))


@pytest.mark.parametrize(("joint", "side"), [(0, 0), (1, 1), (3, 0), (4, 1), (5, 1)])
def test_a_joint_at_its_limit_is_told_with_the_time_and_auto_is_drakes_run(joint, side):
    scenario = into_the_limit(joint, side)
    with pytest.raises(LeftTheModelError, match=f"{joints.JOINT_NAMES[joint]} is at its") as error:
        simulate(scenario, engine="compiled")
    assert error.match(rf"^t = {error.value.time:.6g} s: ")
    drake = simulate(scenario, engine="drake")
    near = drake.q_measured.values[:, joint]
    limit = (joints.LOWER, joints.UPPER)[side][joint]
    first = drake.time.values[np.abs(near - limit) < 1e-3][0]
    assert 0.0 < error.value.time <= first + 1e-3
    recording = simulate(scenario)
    assert recording.attrs["engine"] == "drake"
    assert recording.attrs["engine_reason"] == str(error.value)
    same(recording, drake)


def turning():
    """The forearm turns to where `pressed` has a box."""
    scenario = load_scenario("joint_sine", {"duration": 0.8})
    base = joints.HOME.tolist()
    move = [0.0, 0.6, 0.0, 0.0, 0.0, 0.0]
    scenario.operator = JointMotion(base=base, displacement=move, start=0.0, move_duration=0.8)
    return scenario


def pressed(motion=None):
    scenario = turning()
    text = "[!Box {centre: [0.72, 0.62, 3.0], size: [0.16, 0.16, 0.16]}]"
    if motion:
        text = text.replace("}]", f", motion: {motion}}}]")
    scenario.environment = load_scenario("joint_sine", {"environment.surfaces": text}).environment
    return scenario


def test_a_link_that_touches_is_told_with_the_time_and_auto_is_drakes_run():
    scenario = pressed()
    with pytest.raises(LeftTheModelError, match=r"link_\d touches world") as error:
        simulate(scenario, engine="compiled")
    assert 0.05 < error.value.time < 0.8
    drake, recording = simulate(scenario, engine="drake"), simulate(scenario)
    assert recording.attrs["engine_reason"] == str(error.value)
    same(recording, drake)
    free = simulate(turning(), engine="compiled")
    # The arm was Drake's until then, and was held up after.
    until = int(error.value.time / 1e-3)
    gap = np.abs(free.q_measured.values - drake.q_measured.values).max(axis=1)
    assert gap[:until].max() < 1e-9
    assert gap.max() > 1e-6


def test_a_link_that_touches_from_the_start_is_told():
    scenario = pressed()
    of_kind(Box, scenario.environment.surfaces[0]).size = [1.0, 1.0, 0.3]
    with pytest.raises(LeftTheModelError, match=r"^t = 0 s: link_\d touches world"):
        simulate(scenario, engine="compiled")


def test_a_moving_surface_stops_no_link_in_either_engine():
    scenario = pressed("!ConstantVelocity {velocity: [0.0, 1e-9, 0.0]}")
    compiled, drake = simulate(scenario, engine="compiled"), simulate(scenario, engine="drake")
    np.testing.assert_allclose(compiled.q_measured, drake.q_measured, atol=1e-9)


@njit(cache=False)
def nan_force(t, perturbation_force):
    perturbation_force[:] = 0.0
    if t > 0.0195:
        perturbation_force[2] = np.nan


class NanForce(JointPerturbation):
    def make_system(self):
        return Block(Declaration(outputs={"perturbation_force": Output(6, nan_force)}))


@pytest.mark.parametrize("engine", ["compiled", "drake"])
def test_a_nan_stops_the_run_names_its_maker_and_keeps_what_was_recorded(engine, tmp_path):
    scenario = load_scenario("joint_sine", {"duration": 0.05})
    scenario.perturbation = NanForce()
    journal = tmp_path / "run.journal"
    with pytest.raises(RuntimeError) as error:
        journalled(scenario, journal, engine=engine)
    told = "perturbation: port 'perturbation_force' at t = 0.02 s: perturbation_force[2] is nan"
    assert str(error.value) == told
    assert str(journal) in "".join(error.value.__notes__)
    kept = load_recording(journal)
    assert told in kept.attrs["ended_by"]
    assert kept.time.values[-1] == 0.02
