"""A run whose command is lost leaves its last seconds beside its recording."""

import json

import numpy as np

import scara_drake as sd
from scara_drake.cli.main import main
from scara_drake.safety import Reason, State, words


def test_the_seconds_before_a_fault_are_beside_the_recording_and_load(tmp_path):
    record = tmp_path / "lost.nc"
    main([
        "run", "teleoperation", "--no-meshcat", "--no-realtime", "--duration", "0.4",
        "--set", "supervision={}", "--set", "channel.up=!Packets {outages: [0.1, 5.0]}",
        "--set", "logging.period=0.02", "--record", str(record),
    ])  # fmt: skip
    assert sorted(path.name for path in tmp_path.iterdir()) == ["lost.fault-1.nc", "lost.nc"]
    box, run = sd.load_recording(tmp_path / "lost.fault-1.nc"), sd.load_recording(record)
    np.testing.assert_allclose(np.diff(box.time), 1e-3)
    np.testing.assert_allclose(np.diff(run.time), 0.02)
    told = json.loads(run.attrs["faults"])
    assert told[0]["side"] == "robot"
    assert told[0]["says"] == words(State.HOLD, Reason.COMMAND_LOST)
    assert told[0]["time"] == float(box.time[-1])
    assert box.robot_state[-1] == State.HOLD
    assert (box.robot_state[:-1] != State.HOLD).all()
