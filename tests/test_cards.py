"""What objects show of themselves in a notebook: escaped, well-formed, readable, and complete."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgb

import scara_drake as sd
from scara_drake import ik, kinematics
from scara_drake.common import html
from scara_drake.display import cell, look
from scara_drake.display.cards import of_scenario, of_study
from scara_drake.experiments.claim import Claim, Criterion, Experiment
from scara_drake.experiments.quantity import quantity
from scara_drake.metrics.judgement import Verdict
from scara_drake.scenario import Scenario, scenario_names
from scara_drake.studies.study import study_names

NASTY = "<script>alert('1')</script> & \"<b>\""
Q = np.array([3.0, -0.5, 0.0, -0.5, 1.0, 0.0])


class Checker(HTMLParser):
    """Follows the tags: every one that is opened is closed, in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.names: set[str] = set()
        self.text = ""
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.open.append(tag)
        self.names.add(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def claim(statement: str = "It holds") -> Claim:
    criterion = Criterion("above zero", True)
    return Claim(statement, quantity(1.0, "mm"), quantity(2.0, "mm"), criterion, f"So {statement}")


def experiment(statement: str) -> Experiment:
    return Experiment(statement, xr.Dataset({"x": ("time", [1.0])}), [claim(statement)])


def study(name: str) -> sd.Study:
    study = sd.load_study(study_names()[0])
    study.description = name
    return study


SHOWN: dict[str, Callable[[str], Any]] = {
    "scenario": lambda text: Scenario(description=text),
    "study": study,
    "claim": claim,
    "experiment": experiment,
    "verdict": lambda text: Verdict((text,), (text,)),
    "IkResult": lambda text: dataclasses.replace(ik.solve(pose(Q)), reason=text),
}


def pose(q: np.ndarray) -> np.ndarray:
    return kinematics.forward_kinematics(q)


@pytest.mark.parametrize("kind", SHOWN)
def test_what_a_user_writes_is_escaped(kind):
    shown = Checker(SHOWN[kind](NASTY)._repr_html_())
    assert NASTY in shown.text
    assert "script" not in shown.names


@pytest.mark.parametrize("kind", SHOWN)
def test_no_colour_is_set_of_text_or_ground_alone(kind):
    for style in re.findall(r'style="([^"]*)"', SHOWN[kind]("it")._repr_html_()):
        sets = dict(part.split(":", 1) for part in style.split(";") if ":" in part)
        ground = sets.get("background", "transparent") != "transparent"
        assert ground == (sets.get("color", "inherit") != "inherit"), style


@pytest.mark.parametrize("background", look.VERDICTS)
def test_black_on_the_colours_of_verdicts_is_read(background):
    linear = [
        c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(background)
    ]
    luminance = float(np.dot([0.2126, 0.7152, 0.0722], linear))
    assert (luminance + 0.05) / 0.05 >= 7.0  # WCAG 2.2, level AAA


def test_markup_is_put_as_it_is_and_text_is_not():
    assert html.line(html.chip("a<b", "#fff"), "c<d").count("&lt;") == 2
    assert "<span" in html.line(html.chip("a", "#fff"))


@pytest.mark.parametrize("name", scenario_names())
def test_a_scenario_shows_what_differs_and_all_of_it_folded(name):
    scenario = sd.load_scenario(name)
    shown = Checker(of_scenario(scenario))
    assert f"Scenario {name}" in shown.text
    before, _, after = shown.text.partition("all fields as YAML")
    assert f"duration: {scenario.duration}" in after
    kind = type(scenario.operator).__name__
    assert (kind in before) == (kind != "Joystick")


def test_a_scenario_tells_a_change_and_its_unit():
    plain = of_scenario(Scenario(name="one"))
    changed = sd.load_scenario(
        "teleoperation", {"channel.up.delay": 0.234, "controller": "!Pid {}"}
    )
    head = Checker(of_scenario(changed)).text.partition("all fields as YAML")[0]
    assert "delay: 0.234 s" in head
    assert "controller: Pid" in head
    assert "Pid" not in plain
    assert "delay" not in Checker(plain).text.partition("all fields as YAML")[0]


@pytest.mark.parametrize("name", study_names())
def test_a_study_shows_what_is_varied_and_how_many_runs(name):
    study = sd.load_study(name)
    shown = Checker(of_study(study)).text
    for parameter in study.parameters:
        assert parameter.label in shown
        assert all(path in shown for path in parameter.paths)
    runs = np.prod([len(p.points()) for p in study.parameters]) * study.repeats
    assert f"{runs if study.is_grid else study.samples}, " in shown


def test_an_answer_shows_its_joints_and_its_errors():
    found = ik.solve(pose(Q), method="dpsoij", seed=0)
    shown = Checker(found._repr_html_()).text
    assert found.reason in shown
    assert all(f"{value:.4f}" in shown for value in found.q)
    assert "5 mm" in shown
    assert "0.0175 rad" in shown


def test_a_path_tells_how_many_are_solved():
    way = [pose(Q + np.array([0.0, step, 0.0, 0.0, 0.0, 0.0])) for step in np.linspace(0.0, 0.3, 7)]
    shown = Checker(ik.solve_path(way, method="dpsoij", seed=0)._repr_html_()).text
    assert "7 points" in shown
    assert "7 of 7 solved" in shown
    assert "6 by inverse_jacobian" in shown


def test_a_recording_in_short_is_text_and_card():
    recording = sd.simulate(sd.load_scenario("joint_sine"), duration=1.5)
    recording.attrs["scenario_name"] = NASTY
    found = sd.summary(recording)
    shown = Checker(found._repr_html_())
    assert "script" not in shown.names
    for text in (shown.text, str(found)):
        assert f"Recording of {NASTY}, 1.50 s" in text
        assert "arm followed" in text
        assert "theta2 error, RMS" in text
    assert type(recording)._repr_html_ is xr.Dataset._repr_html_
    with pytest.raises(ValueError, match="recording: no samples"):
        sd.summary(recording.isel(time=slice(0)))


def test_a_scene_of_its_own_prints_its_address_and_changes_nothing(capsys):
    scenario = sd.load_scenario("joint_sine")
    drawn = [sd.simulate(scenario, duration=0.1, meshcat=True) for _ in range(2)]
    first, second = re.findall(r"^Scene: (http://\S+)$", capsys.readouterr().out, re.MULTILINE)
    assert first == second  # one server for the process
    plain = sd.simulate(scenario, duration=0.1, engine="drake")
    for recording in drawn:
        assert recording.attrs["engine"] == "drake"
        xr.testing.assert_identical(recording.q_measured, plain.q_measured)
    meshcat = cell.own_meshcat()
    assert len(cell.Scene(meshcat)._repr_html_()) < 2e6


def test_no_scene_is_opened_unasked(capsys):
    for nothing in (None, False):
        with cell.scene_of_run(nothing) as scene:
            assert scene is None
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("wrong", ["x", 1, 0, []])
def test_what_is_no_meshcat_is_refused_in_one_line(wrong):
    with pytest.raises(ValueError, match=r"^meshcat: .*, allowed True, False, None or .*Meshcat$"):
        sd.simulate(sd.load_scenario("joint_sine"), duration=0.01, meshcat=wrong)
