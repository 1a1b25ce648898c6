"""Kernels are compiled before the scene is shown, and counted."""

import io

import numpy as np
from numba import njit
from rich.console import Console

from scara_drake.cli.compile_line import counted_kernels
from scara_drake.cli.main import main
from scara_drake.scenario import load_scenario
from scara_drake.simulation.kernels import compile_kernels


def test_what_is_compiled_is_counted_in_one_line_of_a_terminal():
    @njit
    def one(x):
        return x + 1

    text = io.StringIO()
    with counted_kernels(Console(file=text, force_terminal=True)) as line:
        one(1)
        one(1.0)
        one(2.0)
    one(np.ones(2))
    assert line.count == 2
    assert "Compiling kernels, only the first time: 2 (test_cli_kernels." in text.getvalue()
    assert "\n" not in text.getvalue()
    assert text.getvalue().endswith("\x1b[2K\r")


def test_no_terminal_no_line():
    @njit
    def one(x):
        return x + 1

    text = io.StringIO()
    with counted_kernels(Console(file=text)) as line:
        one(1)
    assert line.count == 1
    assert text.getvalue() == ""


def test_the_kernels_of_a_scenario_are_compiled_once_and_its_device_is_left_alone(caplog):
    scenario = load_scenario("teleoperation", {"operator.device": "joystick"})
    compile_kernels(scenario)  # with no joystick plugged in
    with counted_kernels(Console(stderr=True)) as line:
        compile_kernels(scenario)
    assert line.count == 0
    assert getattr(scenario.operator, "device", "") == "joystick"
    assert not [each for each in caplog.records if each.name.startswith("scara_drake")]


def test_the_command_says_how_many(capsys):
    assert main(["compile", "mast_step"]) == 0
    assert capsys.readouterr().out.startswith("Compiled: ")
    assert main(["compile", "nope"]) == 2
