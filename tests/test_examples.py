"""Every example runs in any folder, and what it prints is true."""

from __future__ import annotations

import re
import runpy
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

import scara_drake as sd
from scara_drake import metrics, robot
from scara_drake.environment import Box
from scara_drake.scenario import dump_scenario, load_scenario

FOLDER = Path(__file__).parents[1] / "examples"
FILES = sorted(FOLDER.glob("*.py"))
NUMBER = r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?"


@dataclass
class Ran:
    """What an example printed, and the names that it left."""

    text: str
    names: dict[str, Any]

    def numbers(self, label: str) -> list[float]:
        """Numbers of the line that begins with a label, after it."""
        (line,) = [line for line in self.text.splitlines() if line.startswith(label)]
        return [float(each) for each in re.findall(NUMBER, line.removeprefix(label))]


def needed_efforts(recording: Any) -> np.ndarray:
    """Efforts (time, 6) with which the robot would follow its references exactly, by Drake."""
    plant = MultibodyPlant(time_step=0.0)
    robot.add_scara(plant)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    forces = MultibodyForces(plant)
    rates = recording.v_desired.values
    accelerations = np.gradient(rates, recording.time.values, axis=0)
    efforts = np.empty_like(rates)
    for k in range(len(efforts)):
        plant.SetPositions(context, recording.q_desired.values[k])
        plant.SetVelocities(context, rates[k])
        plant.CalcForceElementsContribution(context, forces)
        efforts[k] = plant.CalcInverseDynamics(context, accelerations[k], forces)
    return efforts


def check_controller(ran: Ran) -> None:
    mast, theta2 = ran.numbers("Spring")
    assert mast == pytest.approx(1e3 * 9.81 / 2500.0, rel=2e-3)  # m g = m kp e
    # The references are slow for it, so the spring gives what the motion needs, to first order.
    window = ran.names["recording"].sel(time=slice(2.0, None))
    error = needed_efforts(window)[:, 1] / robot.nominal_inertias()[1] / 2500.0
    assert theta2 == pytest.approx(1e3 * np.sqrt(np.mean(error**2)), rel=0.05)
    mast, theta2 = ran.numbers("IntegralSlidingMode")
    assert abs(mast) <= 1e-3
    assert theta2 < 0.1


def check_coupling(ran: Ran) -> None:
    (pressed,) = ran.numbers("largest force on the tool")
    shown, largest = ran.numbers("largest shown, but for B v")
    (off,) = ran.numbers("largest distance from the law")
    assert largest == 4.0
    assert pressed > 10 * largest
    assert shown == largest  # tanh of so much is one
    assert off < 1e-12


def check_surface(ran: Ran) -> None:
    (depth,) = ran.numbers("largest depth d")
    (force,) = ran.numbers("force there")
    assert force == pytest.approx(10000.0 * 1e-3 * depth, rel=2e-3)
    assert ran.numbers("force off the normal")[0] < 1e-9
    # A box whose edges are as round as they can be is a ball, and one that the kernels know.
    scenario, ball = sd.load_scenario("teleoperation"), ran.names["ball"]
    side = 2 * ball.radius
    scenario.environment.surfaces = [
        Box(name="ball", centre=ball.centre, size=[side] * 3, edge_radius=ball.radius)
    ]
    known = sd.simulate(scenario, duration=9.0)
    (largest,) = ran.numbers("largest force")
    assert largest == pytest.approx(float(metrics.contact_force(known).max()), abs=1e-3)


def check_delay_law(ran: Ran) -> None:
    longest, most = ran.numbers("longest delay")
    off, bound = ran.numbers("largest distance from the law")
    assert longest == most == 0.35
    # h²/8 max |tau''|, where tau'' = swell / rise² (x - 2) exp(1 - x) is largest at x = 0.
    assert bound == pytest.approx(1e3 * 0.05**2 / 8 * 2 * np.e * 0.3 / 0.7**2, abs=1e-3)
    assert 0.5 * bound < off <= bound
    for axis in "xyz":
        moved, differs = ran.numbers(axis + " goes")
        assert moved > 10.0  # [mm]
        assert differs < 1e-6  # [um]
    text = dump_scenario(ran.names["scenario"])
    assert "up: !Congestion\n    base: 0.05\n    swell: 0.3\n" in text
    assert "up: !Congestion\n" in ran.names["recording"].attrs["scenario"]
    assert "up: !Congestion\n" in ran.text


def check_recording(ran: Ran) -> None:
    assert ran.numbers("samples") == [3001.0, 3.0]
    assert ran.numbers("largest |slope - rate|")[0] < 1e-9
    recording = sd.simulate(load_scenario("joint_sine"), duration=3.0)
    error = metrics.tracking_error(recording).sel(joint="theta2", time=slice(1.0, None))
    assert ran.numbers("theta2, rms error")[0] == pytest.approx(float(metrics.rmse(error)))


def check_step_loop(ran: Ran) -> None:
    # The wall is 0.29 m from the centred stick, and K d = 40 N.
    away, force = ran.numbers("at the start the wall is")
    assert away == pytest.approx(290.0, abs=0.5)
    assert force == 0.0
    depth, force, wanted = ran.numbers("at the end")
    assert force == pytest.approx(wanted, rel=1e-3)
    assert depth == pytest.approx(-1e3 * wanted / 1e4, rel=1e-3)
    steps, reward = ran.numbers("steps")
    assert steps == 120.0
    assert abs(reward) < 1e-3


def check_gymnasium(ran: Ran) -> None:
    for seed in (1, 3):
        touched, steps, force = ran.numbers(f"seed {seed}: touched in step")
        assert 0 < touched < steps == 100
        assert force == pytest.approx(40.0, abs=0.5)
    env, episode = ran.names["make_env"](), ran.names["episode"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)
    first, again, other = (episode(env, seed) for seed in (1, 1, 3))
    for (seen, reward), (seen_again, reward_again) in zip(first, again, strict=True):
        np.testing.assert_array_equal(seen, seen_again)
        assert reward == reward_again
    assert not np.array_equal(first[-1][0], other[-1][0])  # another seed, another wall
    assert first[-1][1] > -0.02 > first[0][1] == -1.0


def check_camera(ran: Ran) -> None:
    names = ran.names
    (moved,) = ran.numbers("pixels that the arm")
    assert moved > 500
    focal = names["HEIGHT"] / 2 / np.tan(names["VIEW"] / 2)
    seen = (names[key] for key in ("pictures", "labels", "postures"))
    for picture, labels, q in zip(*seen, strict=True):
        assert np.isin(names["links"][1:], labels).all()
        reddest = picture[labels == names["links"][3]].astype(float).mean(axis=0)
        assert reddest[0] > 2 * reddest[2]  # the forearm is orange
        # The tool point is seen where a pinhole sees it, at the rim of the last link.
        tool = sd.kinematics.forward_kinematics(q)[:3, 3]
        x, y, depth = names["looking"](names["EYE"], names["TARGET"]).inverse() @ tool
        column = names["WIDTH"] / 2 + focal * x / depth
        row = names["HEIGHT"] / 2 + focal * y / depth
        rows, columns = np.nonzero(labels == names["links"][5])
        assert np.hypot(rows - row, columns - column).min() < 5.0
    shown = [line for line in ran.text.splitlines() if line.startswith("t = ")]
    away = float(re.findall(NUMBER, shown[-1])[-1])
    assert away == pytest.approx(depth, abs=0.4)


def check_builder(ran: Ran) -> None:
    least, most = ran.numbers("radius of the tool's way")
    assert 99.0 < least <= most < 101.0
    delay, off = ran.numbers("largest distance from the command of")
    assert delay == 0.05
    # A turn of 0.1 m in 6 s, which the reference and the arm follow within a tenth of a second.
    assert 0.0 < off < 1e3 * 0.1 * 2 * np.pi / 6.0 * 0.1


CHECKS: dict[str, Callable[[Ran], None]] = {
    "camera": check_camera,
    "gymnasium_env": check_gymnasium,
    "own_builder": check_builder,
    "own_controller": check_controller,
    "own_coupling": check_coupling,
    "own_delay_law": check_delay_law,
    "own_surface": check_surface,
    "read_recording": check_recording,
    "step_loop": check_step_loop,
}


def run(path: Path, *arguments: str) -> dict[str, Any]:
    """Run an example as a script."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", [str(path), *arguments])
        names = runpy.run_path(str(path), run_name="__main__")
    plt.close("all")
    return names


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_example_prints_what_is_true(path, tmp_path, monkeypatch, capsys):
    before = set(FOLDER.rglob("*"))
    monkeypatch.chdir(tmp_path)
    names = run(path)
    CHECKS[path.stem](Ran(capsys.readouterr().out, names))
    assert list(tmp_path.iterdir()) == []
    assert set(FOLDER.rglob("*")) == before


def test_every_example_has_a_check_and_a_line_in_the_table():
    assert {path.stem for path in FILES} == set(CHECKS)
    table = re.findall(r"^\| \[(\w+)\.py\]", (FOLDER / "README.md").read_text(), re.MULTILINE)
    assert sorted(table) == sorted(CHECKS)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_example_is_short_and_says_how_it_is_run(path):
    text = path.read_text()
    assert 40 <= text.count("\n") <= 110
    assert f"python examples/{path.name}" in text


def test_a_recording_and_its_picture_go_where_they_are_told(tmp_path):
    run(FOLDER / "read_recording.py", str(tmp_path))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["sine.nc", "sine.png"]
    assert sd.load_recording(tmp_path / "sine.nc").sizes["time"] == 3001
