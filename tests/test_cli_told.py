"""What a command says before it runs: what is not used, who commands, what cannot be written."""

import logging
import os
import sys
import warnings

import pytest

from scara_drake.cli.main import main
from scara_drake.cli.outputs import check_output
from scara_drake.scenario import (
    UnusedSetting,
    dump_scenario,
    load_scenario,
    parse_overrides,
    scenario_names,
)


@pytest.mark.parametrize(
    ("name", "setting", "said"),
    [
        ("joint_sine", "channel.up.delay=2", "channel.up.delay: not used with the operator Joint"),
        ("joint_sine", "haptics={}", "haptics: not used"),
        ("teleoperation", "coupling=!Direct {}", "coupling: not used with the operator Joystick"),
        ("teleoperation", "coupling.force_scale=1", "coupling"),
        ("bilateral", "haptics={}", "haptics: not used with the operator Master"),
        ("joint_sine", "inverse_kinematics.joints=full", "the joints are commanded"),
    ],
)
def test_a_setting_that_does_nothing_is_told_with_what_does_it(name, setting, said):
    with pytest.warns(UnusedSetting, match="not used") as told:
        load_scenario(name, parse_overrides([setting]))
    (message,) = {str(each.message) for each in told}
    assert said in message
    assert "\n" not in message


@pytest.mark.parametrize("name", scenario_names())
def test_the_shipped_scenarios_use_all_that_they_set(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load_scenario(name)


def test_a_scenario_that_was_written_down_whole_is_not_told_of(tmp_path):
    path = tmp_path / "again.yaml"
    path.write_text(dump_scenario(load_scenario("joint_sine")))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load_scenario(path)
    path.write_text("operator: !JointMotion {}\nchannel: {up: {delay: 1}}\n")
    with pytest.warns(UnusedSetting, match=r"^channel: not used with the operator JointMotion"):
        load_scenario(path)


def test_what_is_told_to_set_instead_is_a_setting():
    settings = parse_overrides(["process_delay={reference: !ConstantDelay {delay: 0.1}}"])
    assert load_scenario("joint_sine", settings).process_delay is not None


def run(capsys, tmp_path, *arguments):
    status = main(
        ["run", *arguments, "--no-realtime", "--no-meshcat", "--duration", "0.01",
         "--record", str(tmp_path / "run.nc")]
    )  # fmt: skip
    return status, capsys.readouterr()


def test_the_command_line_warns_in_one_line_and_runs(capsys, tmp_path):
    status, said = run(capsys, tmp_path, "joint_sine", "--set", "channel.up.delay=2")
    assert status == 0
    lines = [line for line in said.err.splitlines() if "warning" in line]
    assert len(lines) == 1
    assert "process_delay" in lines[0]
    assert "joint_sine: 0.0 s" in said.out


@pytest.mark.parametrize("device", ["trace", "auto"])
def test_who_commands_is_said(capsys, tmp_path, device):
    setting = f"operator.device={device}"
    _, said = run(capsys, tmp_path, "free_motion", "--set", setting)
    line = "Operator: trace operator_trace.csv"
    assert line + (", as no joystick is plugged in" if device == "auto" else "") + "\n" in said.err


def test_it_is_said_once_where_drake_has_a_handler_of_its_own(capsys, tmp_path):
    root, handler = logging.getLogger(), logging.StreamHandler(sys.stderr)
    root.addHandler(handler)
    try:
        _, said = run(capsys, tmp_path, "free_motion", "--set", "operator.device=trace")
    finally:
        root.removeHandler(handler)
    assert said.err.count("Operator:") == 1
    assert logging.getLogger("scara_drake").propagate


def test_an_output_that_cannot_be_written_is_found_before_the_run(capsys, tmp_path, monkeypatch):
    file = tmp_path / "file"
    file.touch()
    monkeypatch.chdir(tmp_path)
    for arguments in (
        ["run", "joint_sine", "--record", str(file / "a.nc")],
        ["run", "joint_sine", "--html", str(file / "deep" / "a.html")],
        ["tune", "joint_sine", "--output", str(file / "a.yaml")],
    ):
        assert main(arguments) == 2
        error = capsys.readouterr().err
        assert error.count("\n") == 1
        assert arguments[2] in error
    assert list(tmp_path.iterdir()) == [file]


def test_a_folder_that_is_missing_is_accepted_and_not_made(tmp_path):
    check_output("--html", tmp_path / "a" / "b" / "c.html", ".html")
    check_output("--html", None, ".html")
    assert list(tmp_path.iterdir()) == []
    for bad in (tmp_path / "a.nc", tmp_path):
        with pytest.raises(ValueError, match=r"^--html: .*, allowed a file that ends in \.html$"):
            check_output("--html", bad, ".html")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_may_not_be_written_is_refused(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(ValueError, match="allowed a file that may be written"):
        check_output("--record", tmp_path / "a.nc", ".nc")
