import gc
import hashlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
import tracemalloc
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from journalled import journalled
from pydrake.geometry import Meshcat

from scara_drake import joints, load_recording, load_scenario, metrics, simulate
from scara_drake.recordings.journal import Journal

JITTER = (
    "!Packets {delay: !ConstantDelay {delay: 0.02}, longest: 0.3,"
    " jitter: {distribution: gamma, mean: 0.005, std: 0.003}, loss: {in_good: 0.1}}"
)
# Shipped scenarios and changes to them, in JSON, for a process of its own.
SEEDED = {
    "teleoperation": {},
    "bilateral": {"channel.up": JITTER, "channel.down": JITTER},
}
FINGERPRINT = """
import hashlib, json, sys, scara_drake as sd
_, engine, name, changes = sys.argv
d = sd.simulate(sd.load_scenario(name, json.loads(changes)), engine=engine)
print(hashlib.sha256(b"".join(d[v].values.tobytes() for v in sorted(d.data_vars))).hexdigest())
"""


def fingerprint(dataset):
    parts = (dataset[name].values.tobytes() for name in sorted(dataset.data_vars))
    return hashlib.sha256(b"".join(parts)).hexdigest()


@pytest.mark.parametrize("engine", ["compiled", "drake"])
@pytest.mark.parametrize("name", SEEDED)
def test_a_seed_gives_the_same_bits_everywhere(engine, name):
    changes = {"duration": 0.3, "seed": 5, **SEEDED[name]}
    scenario = load_scenario(name, changes)
    first = fingerprint(simulate(scenario, engine=engine))
    assert fingerprint(simulate(scenario, engine=engine)) == first
    if engine == "drake":
        assert fingerprint(simulate(scenario, meshcat=Meshcat())) == first
        assert fingerprint(simulate(scenario, realtime_rate=1.0)) == first
    else:
        with ThreadPoolExecutor(4) as threads:
            assert set(threads.map(fingerprint, threads.map(simulate, [scenario] * 8))) == {first}
    other = subprocess.run(
        [sys.executable, "-c", FINGERPRINT, engine, name, json.dumps(changes)],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert other.stdout.strip() == first
    another = load_scenario(name, {**changes, "seed": 6})
    if name == "bilateral":
        assert fingerprint(simulate(another, engine=engine)) != first


BASES = {
    "as shipped": None,
    "theta4 = pi/2": [3.0, 0.0, 0.0, np.pi / 2, 0.0, 0.0],
    "theta4 = -pi/2": [3.0, 0.0, 0.3, -np.pi / 2, 0.2, 0.0],
    "theta5 = -pi/2": [3.0, 0.0, 0.5, 0.0, -np.pi / 2, 0.0],
    "theta4 = pi/2, theta5 = -pi/2": [3.0, 0.0, 0.5, np.pi / 2, -np.pi / 2, 0.0],
}


@pytest.mark.parametrize("base", BASES.values(), ids=BASES.keys())
def test_sine_tracking_is_tight_and_quiet(base):
    overrides = {} if base is None else {"operator.base": base}
    dataset = simulate(load_scenario("joint_sine", overrides)).sel(time=slice(1.0, None))
    peak = metrics.peak(metrics.tracking_error(dataset))
    assert (peak[1:] < 0.5e-3).all(), peak.values  # [rad]
    assert peak[0] < 0.1e-3  # [m]
    assert (metrics.chatter(dataset.tau_applied)[1:] < 1.0).all()  # [N m] a tick


def test_mast_step_ends_where_it_should():
    dataset = simulate(load_scenario("mast_step"))
    end = dataset.isel(time=-1)
    assert abs(float(end.q_measured[0]) - 3.5) < 1e-5
    # In the end the drive carries the weight: 735.5 kg.
    np.testing.assert_allclose(float(end.tau_applied[0]), 735.5 * 9.81, atol=0.5)


@pytest.fixture(scope="module")
def pressing():
    return simulate(load_scenario("teleoperation"))


def test_contact_force_is_the_impedance_of_the_recorded_penetration(pressing):
    depth = pressing.penetration.sel(surface="wall").values
    rate = np.gradient(depth, 1e-3)
    force = metrics.contact_force(pressing).values
    deep = depth > 2e-3
    deep[0] = deep[-1] = False
    assert deep.sum() > 1000
    expected = 1e4 * depth[deep] + 100.0 * rate[deep]
    np.testing.assert_allclose(force[deep], expected, atol=0.5)
    assert (force[depth == 0.0] == 0.0).all()
    assert (pressing.f_env_on_tool_W.sel(axis="y") >= 0.0).all()  # it never pulls


def test_the_shipped_trace_presses_within_its_promise(pressing):
    depth = pressing.penetration.max().item()
    assert 5e-3 < depth <= 25e-3  # [m]
    assert (pressing.penetration.sel(time=slice(0.0, 10.0)) == 0.0).all()  # free motion first
    assert (pressing.status == 0.0).all()


def test_the_force_comes_back_after_the_delay(pressing):
    np.testing.assert_allclose(pressing.delay_down[1:], 0.05)
    # 50 ms of channel, and the channel's own tick.
    sent = pressing.f_env_on_tool_W.values[:-51]
    np.testing.assert_allclose(pressing.f_haptic.values[51:], sent, atol=1e-9)
    assert pressing.rumble.max() > 0.5
    assert (pressing.rumble.sel(time=slice(0.0, 10.0)) == 0.0).all()


def test_the_tool_follows_its_reference(pressing):
    settled = pressing.sel(time=slice(1.0, None))
    assert metrics.peak(metrics.tool_error(settled)) < 2e-3
    assert (pressing.q_desired >= joints.LOWER).all()
    assert (pressing.q_desired <= joints.UPPER).all()
    assert (np.abs(pressing.tau_applied) <= joints.EFFORT).all()


def test_the_run_starts_at_the_answer_for_the_first_pose(pressing):
    start = pressing.isel(time=0)
    np.testing.assert_allclose(start.q_measured, start.q_desired, atol=1e-12)
    np.testing.assert_allclose(start.p_WE_measured, start.p_WE_commanded, atol=1e-6)
    assert np.abs(start.q_measured - joints.HOME).max() < 0.1


def test_start_posture_and_duration_can_be_given():
    scenario = load_scenario("teleoperation")
    q0 = joints.HOME + np.array([0.2, 0.1, 0.0, 0.0, 0.1, 0.0])
    dataset = simulate(scenario, duration=0.05, q0=q0)
    np.testing.assert_allclose(dataset.q_measured[0], q0)
    assert dataset.sizes["time"] == 51
    assert scenario.duration == 30.0
    assert scenario.q0 is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"duration": -1.0}, "^duration: -1.0"),
        ({"q0": [0.0] * 6}, "^q0: d1 = 0 m, allowed"),
        ({"q0": [0.0] * 5}, "^q0: shape"),
        ({"realtime_rate": float("nan")}, "^realtime_rate: nan"),
    ],
)
def test_bad_arguments_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        simulate(load_scenario("joint_sine"), **arguments)


def test_an_interrupt_keeps_what_was_recorded(tmp_path):
    scenario = load_scenario("joint_sine", {"duration": 3600.0})
    journal = tmp_path / "run.journal"

    def interrupt_once_it_runs():
        while not journal.exists() or journal.stat().st_size < 100_000:
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt_once_it_runs).start()
    result = journalled(scenario, journal)
    assert result.interrupted
    assert 0.1 < result.simulated < 3600.0
    # Every tick up to the interrupt is there.
    steps = np.diff(result.recording.time)
    np.testing.assert_allclose(steps, 1e-3, atol=1e-9)
    assert abs(float(result.recording.time[-1]) - result.simulated) <= 1e-3 + 1e-9
    assert load_recording(journal).identical(result.recording)


@pytest.mark.parametrize(
    ("engine", "duration"),
    [("drake", 3.0), pytest.param("compiled", 150.0, marks=pytest.mark.slow)],
)
def test_memory_stays_flat_while_it_runs(tmp_path, engine, duration):
    """What is held between blocks does not grow with them: the samples are in the journal."""
    held = []

    class WatchedJournal(Journal):
        def append(self, times, values):
            super().append(times, values)
            gc.collect()
            held.append(tracemalloc.get_traced_memory()[0])

    tracemalloc.start()
    try:
        scenario = load_scenario("mast_step", {"duration": duration})
        journalled(scenario, tmp_path / "run.journal", engine, WatchedJournal)
    finally:
        tracemalloc.stop()
    assert len(held) > 25
    assert held[-2] - held[5] < 20_000  # [B]; a block of 100 samples is 40 kB


def test_real_time_takes_its_time():
    scenario = load_scenario("mast_step", {"duration": 0.5})
    simulate(scenario, duration=0.05)
    start = time.perf_counter()
    simulate(scenario, realtime_rate=1.0)
    assert time.perf_counter() - start > 0.49
