"""The page of recordings is that of the code, and the code says what is in a recording."""

import make_recording_reference as reference
import pytest

import scara_drake as sd
from scara_drake.recordings.attributes import ATTRIBUTES
from scara_drake.recordings.signals import PRESENT, SIGNALS

# What the signals are there for, as the page words it: each in a run of its own.
OBSERVER = {"controller": "!ObserverSlidingMode {}"}
PACKETS = {"channel.up": "!Packets {}", "channel.down": "!Packets {}"}
RUNS = [
    ("teleoperation", {}),
    ("teleoperation", OBSERVER | PACKETS | {"channel.watch": "!CommandWatch {}"}),
    ("joint_sine", {"controller": "!Pid {}", "governor": "{}", "drives.lag": "{}"}),
    ("joint_sine", {"controller": "!InverseDynamics {}"}),
    ("bilateral", {}),
    ("bilateral", {"operator.device": "touch"}),
    ("teleoperation", {"operator": "!Trainee {}", "task": "!TouchPoints {}"}),
]


def test_the_page_is_that_of_the_code() -> None:
    assert reference.PAGE.read_text() == reference.page(), (
        "run python docs/make_recording_reference.py"
    )


def test_what_is_not_there_always_is_said_when_it_is() -> None:
    assert set(PRESENT) == {signal.source for signal in SIGNALS.values() if not signal.always}


@pytest.mark.parametrize(("name", "settings"), RUNS)
def test_a_run_has_the_variables_and_attributes_that_are_told(name: str, settings: dict) -> None:
    scenario = sd.load_scenario(name, settings)
    recording = sd.simulate(scenario, duration=0.01, engine="drake")
    assert set(recording.attrs) <= set(ATTRIBUTES)
    text = recording.attrs["scenario"]
    holds = {
        "the operator's device is a live one": False,
        "the operator is supervised": scenario.supervision is not None,
        "the scenario has `environment.cut`": scenario.environment.cut is not None,
        "the scenario has `kinesthetic`": scenario.kinesthetic is not None,
        "the operator is a `!Master`": "operator: !Master" in text,
        "the device of a `!Master` has encoders with a resolution": "device: touch" in text,
        "a command crosses the channel": "operator: !JointMotion" not in text,
        "the operator has a `policy`": "policy: !" in text,
        "the operator is a `!Trainee`, or a `!Master` with a `policy`": (
            "operator: !Trainee" in text or "policy: !" in text
        ),
        "the operator has a `policy` and the downlink has packets": (
            "policy: !" in text and "down: !Packets" in text
        ),
        "the uplink has a `playout`": "playout: !Playout" in text,
        "the downlink has a `playout`": "playout: !Playout" in text,
        "the uplink has packets": "up: !Packets" in text,
        "the downlink has packets": "down: !Packets" in text,
        "the scenario has `channel.watch`": scenario.channel.watch is not None,
        "the controller is neither `!InverseDynamics` nor your own": (
            "controller: !InverseDynamics" not in text
        ),
        "the scenario has a `governor`": scenario.governor is not None,
        "the scenario has `drives.lag`": scenario.drives.lag is not None,
        "the controller is an `!ObserverSlidingMode`": "!ObserverSlidingMode" in text,
        "the controller is an `!ObserverSlidingMode` and there is a surface": (
            "!ObserverSlidingMode" in text and "!Wall" in text
        ),
    }
    assert set(holds) == set(PRESENT.values())
    for variable, signal in SIGNALS.items():
        if not signal.always:
            assert (variable in recording) is holds[PRESENT[signal.source]], variable
        elif "surface" not in signal.dims:
            assert variable in recording
