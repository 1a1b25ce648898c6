"""What went wrong is said, whatever it was, and what went well is said to have gone well."""

from io import StringIO

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console
from strategies import examples

import scara_drake as sd
from scara_drake import metrics
from scara_drake.cli.main import main
from scara_drake.cli.summary import print_summary
from scara_drake.metrics.links import silence, traffic
from scara_drake.metrics.stretches import stretches
from scara_drake.scenario import scenario_names
from scara_drake.simulation.run import Run

WALL = "[{{name: wall, point: [0.8, {y}, 3.0], normal: [0.0, 1.0, 0.0]{more}}}]"
INTO_ROBOT = ", motion: !ConstantVelocity {velocity: [0.0, 2.0, 0.0]}"
ZERO = {"controller.k": 0, "controller.rho": 0, "controller.c": 0}
OUTAGE = {"channel.up": "!Packets {outages: [0.0, 100.0]}"}
LOSS = {"channel.up": "!Packets {loss: {in_good: 1.0}}"}
# Each is accepted as a scenario; what it comes to has to be said.
FAULTS = [
    ("teleoperation", OUTAGE, 1.0, "command lost at t = 0.00 s"),
    ("teleoperation", LOSS, 1.0, "command lost at t = 0.00 s"),
    ("bilateral", OUTAGE, 1.0, "command lost at t = 0.00 s"),
    ("bilateral", {"channel.down": "!Packets {loss: {in_good: 1.0}}"}, 1.0, "force lost at t = 0"),
    (
        "teleoperation",
        {"environment.surfaces": WALL.format(y=-1.05, more=INTO_ROBOT)},
        1.5,
        "arm lost at t = ",
    ),
    ("teleoperation", {"environment.surfaces": WALL.format(y=5.0, more="")}, 0.2, "arm lost at t"),
    ("joint_sine", ZERO, 0.5, "arm lost at t = "),
    ("teleoperation", ZERO, 0.5, "arm lost at t = "),
    (
        "joint_sine",
        {"process_delay": "{measurement: !ConstantDelay {delay: 0.02}}"},
        0.5,
        "arm lost at t = ",
    ),
    ("joint_sine", {"robot.payload_mass": 500}, 1.0, "arm lost at t = "),
    ("joint_sine", {"robot.mass_scale": 10}, 0.5, "arm lost at t = "),
    ("joint_sine", {"q0": [3.2, 0.3, 0.0, 0.5, 0.2, 0.0]}, 4.0, "speed limit broken at t = "),
]


@pytest.mark.parametrize(("name", "fault", "duration", "said"), FAULTS)
def test_every_fault_is_said(name, fault, duration, said):
    recording = sd.simulate(sd.load_scenario(name, fault), duration=duration)
    verdict = sd.verdict(recording)
    assert not verdict.good
    assert str(verdict).startswith(said)
    assert "\n" not in str(verdict)


@pytest.mark.parametrize(
    ("name", "duration"),
    [("mast_step", 8.0), ("joint_sine", 2.0), ("bilateral", 1.5), ("teleoperation", 1.5)],
)
def test_what_goes_well_is_said_to(name, duration):
    verdict = sd.verdict(sd.simulate(sd.load_scenario(name), duration=duration))
    assert verdict.good, verdict
    assert str(verdict) == "arm followed"
    assert verdict.remarks == ()


@pytest.mark.slow
@pytest.mark.parametrize("name", scenario_names())
def test_every_shipped_scenario_goes_well_to_its_end(name):
    scenario = sd.load_scenario(name)
    verdict = sd.verdict(sd.simulate(scenario))
    assert verdict.good, verdict
    # Supervisors tell what they did.
    assert (verdict.remarks == ()) == (scenario.supervision is None)


@pytest.fixture(scope="module")
def short():
    return sd.simulate(sd.load_scenario("joint_sine"), duration=2.0)


@examples(30)
@given(
    start=st.integers(0, 1999),
    length=st.integers(1, 2001),
    name=st.sampled_from(["Virtual Pad", "[bold]Pad[/bold] [0]", ""]),
)
def test_a_lost_device_is_said_with_when_and_how_long(short, start, length, name):
    there = np.ones(short.sizes["time"])
    there[start : start + length] = 0.0
    recording = short.assign(device_connected=("time", there)).assign_attrs(device=name)
    verdict = sd.verdict(recording)
    to_the_end = start + length >= 2001
    first, last = short.time.values[[start, min(start + length - 1, 2000)]]
    (said,) = verdict.failures or verdict.remarks
    ends = "the end" if to_the_end else f"{last:.2f} s"
    assert "device" in said
    assert f"lost for {last - first:.2f} s, from {first:.2f} s to {ends}" in said
    assert verdict.good is not (to_the_end and start < 1500)
    written = StringIO()
    console = Console(file=written, width=200)
    run = Run(2.0, 1.0, "duration", recording=recording)
    print_summary(console, sd.load_scenario("joint_sine"), run, verdict)
    lines = written.getvalue().splitlines()
    assert any(said in line for line in lines)
    assert (f"Operator: {name}." in lines) is bool(name)


def test_a_device_that_was_there_is_no_remark(short):
    there = np.ones(short.sizes["time"])
    recording = short.assign(device_connected=("time", there)).assign_attrs(device="Virtual Pad")
    assert sd.verdict(recording) == sd.verdict(short)


def test_the_command_line_says_it_and_answers_with_three(capsys, tmp_path):
    record = tmp_path / "run.nc"
    arguments = ["run", "joint_sine", "--no-realtime", "--no-meshcat", "--record", str(record)]
    status = main([*arguments, *(f"--set={key}={value}" for key, value in ZERO.items()),
                   "--set=duration=0.5"])  # fmt: skip
    out = capsys.readouterr().out
    assert status == 3
    said = out[out.index("Verdict: ") :].splitlines()[0]
    assert said.startswith("Verdict: arm lost at t = ")
    assert str(sd.verdict(sd.load_recording(record))) in said
    assert main([*arguments, "--set=duration=0.5"]) == 0
    assert "Verdict: arm followed." in capsys.readouterr().out


def test_the_share_of_each_status_and_what_did_not_come_are_in_the_summary(capsys, tmp_path):
    status = main(
        ["run", "teleoperation", "--no-realtime", "--no-meshcat", "--set=duration=1.0",
         "--set=channel.up=!Packets {outages: [0.2, 0.6]}", "--record", str(tmp_path / "run.nc")]
    )  # fmt: skip
    out = capsys.readouterr().out
    assert status == 0
    assert "received command followed" in out
    assert "400 of 1000" in out
    assert "Note: nothing came over the uplink from 0.20 s to 0.60 s." in out


# --- by recordings that are made up -----------------------------------------------------------


def made_up(times, tool=0.0, status=0.0, **more):
    """A recording of an arm at rest whose tool is `tool` (n,) [m] from its reference along x."""
    n, zeros = times.size, np.zeros((times.size, 6))
    offset = np.zeros((n, 3))
    offset[:, 0] = tool
    at = np.tile([3.0, 0.0, 0.0, 0.0, 0.0, 0.0], (n, 1))
    joint, axis = ("time", "joint"), ("time", "axis")
    return xr.Dataset(
        {
            **dict.fromkeys(("q_measured", "q_desired"), (joint, at)),
            **dict.fromkeys(("v_measured", "v_desired", "tau_applied"), (joint, zeros)),
            "p_WE_measured": (axis, offset),
            **{name: (axis, np.zeros((n, 3))) for name in ("p_WE_desired", "p_WE_commanded")},
            "f_env_on_tool_W": (axis, np.full((n, 3), np.nan)),
            "delay_up": ("time", np.zeros(n)),
            "delay_down": ("time", np.zeros(n)),
            "status": ("time", np.full(n, status)),
            **more,
        },
        coords={"time": times},
    )


TIMES = np.arange(0.0, 4.0, 0.01)


@examples(100)
@given(st.floats(0.1, 3.0), st.floats(0.02, 3.9), st.floats(0.06, 10.0))
def test_an_arm_is_lost_where_it_stays_away_and_not_where_it_is_only_for_a_moment(
    start, length, distance
):
    away = (start <= TIMES) & (start + length >= TIMES)
    verdict = metrics.verdict(made_up(TIMES, tool=np.where(away, distance, 0.0)))
    stays = TIMES[away][-1] - TIMES[away][0] >= (0.1 if away[-1] else 0.5)
    assert verdict.good is not bool(stays)
    if stays:
        assert str(verdict).startswith(f"arm lost at t = {TIMES[away][0]:.2f} s")
        assert ("back at" in str(verdict)) is not bool(away[-1])


def test_an_arm_that_is_not_a_number_is_lost():
    assert not metrics.verdict(made_up(TIMES, tool=np.nan)).good


def test_an_arm_that_starts_away_from_its_reference_and_gets_there_is_not_lost():
    assert metrics.verdict(made_up(TIMES, tool=np.where(TIMES < 1.0, 0.3, 0.0))).good
    assert not metrics.verdict(made_up(TIMES, tool=0.3)).good


def test_a_command_out_of_reach_is_no_failure_and_one_that_is_held_is():
    far = xr.DataArray(np.tile([0.5, 0.0, 0.0], (TIMES.size, 1)), dims=("time", "axis"))
    limited = metrics.verdict(made_up(TIMES, status=2.0, p_WE_commanded=far))
    held = metrics.verdict(made_up(TIMES, status=1.0, p_WE_commanded=far))
    assert limited.good
    assert any("out of reach" in remark for remark in limited.remarks)
    assert any("100.0 % limited" in remark for remark in limited.remarks)
    assert str(held).startswith("command not followed from 0.00 s to the end")


def test_a_large_force_is_told_with_how_long_it_was():
    force = xr.DataArray(np.zeros((TIMES.size, 3)), dims=("time", "axis"))
    force[(TIMES >= 1.0) & (TIMES < 3.0), 1] = 2100.0
    verdict = metrics.verdict(made_up(TIMES, f_env_on_tool_W=force))
    assert verdict.good
    assert verdict.remarks == ("contact force up to 2100 N, above 500 N for 2.00 s",)


@examples(200)
@given(st.lists(st.booleans(), min_size=1, max_size=30), st.integers(0, 5))
def test_stretches_are_what_holds_but_for_short_interruptions(holds, hold):
    times = np.arange(len(holds), dtype=float)
    found = stretches(times, np.array(holds), hold)
    inside = np.zeros(len(holds), dtype=bool)
    for stretch in found:
        covered = (times >= stretch.start) & (times <= stretch.end)
        assert not (inside & covered).any()
        inside |= covered
        assert holds[int(stretch.start)]
        assert holds[int(stretch.end)]
        assert stretch.open is (stretch.end == times[-1])
    if hold == 0:
        np.testing.assert_array_equal(inside, holds)


@pytest.mark.parametrize("delay", [0.0, 0.05, 0.3])
def test_the_silence_of_a_link_is_that_of_its_outages(delay):
    link = f"!Packets {{delay: !ConstantDelay {{delay: {delay}}}, outages: [0.4, 0.7]}}"
    scenario = sd.load_scenario("free_motion", {"channel.up": link})
    recording = sd.simulate(scenario, duration=1.2)
    silent = silence(recording, "up")
    t = recording.time.values - delay
    expected = np.where((t > 0.4) & (t < 0.7), t - 0.4, 0.0)
    inside = abs(t - 0.7) > 5e-3  # a tick or two later or earlier
    np.testing.assert_allclose(silent[inside], expected[inside], atol=5e-3)
    found = traffic(recording, "up")
    assert found is not None
    assert (found.sent, found.lost, found.received) == (1200, 300, 900)
    (outage,) = found.outages
    assert outage.start == pytest.approx(0.4 + delay, abs=5e-3)
    assert outage.end == pytest.approx(0.7 + delay, abs=5e-3)


def test_an_old_recording_without_counts_of_packets_is_judged_too():
    assert traffic(made_up(TIMES), "up") is None
    assert metrics.verdict(made_up(TIMES)).good
