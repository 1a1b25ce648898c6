from __future__ import annotations

import os
import time
from collections.abc import Iterator

import numpy as np
import pytest

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
if not os.environ.get("DISPLAY"):
    os.environ.setdefault("SDL_VIDEODRIVER", "dummy")

import pygame
from pydrake.systems.analysis import Simulator
from virtual_pad import VirtualPad, load_sdl

from scara_drake.common.fields import check
from scara_drake.operator.devices import AxisMap, PygameDevice, Sample, find_device
from scara_drake.operator.joystick import JoystickSource
from scara_drake.safety import Reason, State
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import simulate

pytestmark = [
    pytest.mark.device,
    pytest.mark.skipif(
        load_sdl() is None, reason="pygame's SDL library with virtual joysticks was not found"
    ),
]
RESOLUTION = 1 / 32767


@pytest.fixture
def pad() -> Iterator[VirtualPad]:
    made = VirtualPad()
    yield made
    made.unplug()
    pygame.event.get()


def test_reads_axes_and_hat_of_a_flight_stick(pad: VirtualPad) -> None:
    device = PygameDevice()
    assert device.name == "Virtual Pad (flight_stick)"
    assert device.sample().connected
    for index, value in enumerate((0.5, -1.0, 0.25, 0.75)):
        pad.axis(index, value)
    pad.hat(0, 1)
    # By default no axis drives the mast, so the fourth stays unread.
    np.testing.assert_allclose(device.sample().axes, [0.5, -1.0, 0.25, 0.0, 1.0], atol=RESOLUTION)
    pad.hat(0, -1)
    assert device.sample().axes[4] == -1.0


def test_lowest_raw_value_stays_within_the_unit_range(pad: VirtualPad) -> None:
    pad.axis(0, -32768 / 32767)
    device = PygameDevice()
    device.sample()
    assert device.sample().axes[0] == -1.0


def test_axis_map_chooses_axes_and_missing_ones_read_zero(pad: VirtualPad) -> None:
    device = PygameDevice(axes=AxisMap(x=3, y=-1, z=17, mast_axis=0, mast_hat=5))
    pad.axis(0, -0.5)
    pad.axis(1, 0.9)
    pad.axis(3, 0.125)
    np.testing.assert_allclose(device.sample().axes, [0.125, 0.0, 0.0, -0.5, 0.0], atol=RESOLUTION)


@pytest.mark.parametrize("index", [-2, 64, 1.5])
def test_axis_map_refuses_bad_indices(index: float) -> None:
    with pytest.raises(ValueError, match=r"axes\.z: .*allowed"):
        check(AxisMap(z=index), "axes")  # type: ignore[arg-type]


def test_read_returns_its_own_array(pad: VirtualPad) -> None:
    device = PygameDevice()
    first = device.sample().axes
    first[:] = 9.0
    assert np.abs(device.sample().axes).max() <= 1.0


def test_unplugged_it_holds_the_last_axes_and_replugged_it_goes_on(pad: VirtualPad) -> None:
    device = PygameDevice()
    pad.axis(0, 0.5)
    pad.hat(0, 1)
    held = device.sample().axes
    pad.unplug()
    for _ in range(3):
        np.testing.assert_array_equal(device.sample().axes, held)
    assert not device.sample().connected
    assert not device.rumble(0.5, 0.5, 100)
    pad.plug()
    pad.axis(0, -0.25)
    assert device.sample().connected
    np.testing.assert_allclose(device.sample().axes, [-0.25, 0, 0, 0, 0], atol=RESOLUTION)
    assert device.rumble(0.5, 0.5, 100)


def test_unplugged_and_back_between_two_reads(pad: VirtualPad) -> None:
    device = PygameDevice()
    device.sample()
    pad.unplug()
    pad.plug()
    pad.axis(1, 0.5)
    device.sample()
    np.testing.assert_allclose(device.sample().axes, [0, 0.5, 0, 0, 0], atol=RESOLUTION)


def test_another_joystick_does_not_take_the_place_of_the_lost_one(pad: VirtualPad) -> None:
    device = PygameDevice()
    pad.axis(0, 0.5)
    held = device.sample().axes
    pad.unplug()
    device.sample()
    other = VirtualPad("Other Stick")
    other.axis(0, -1.0)
    np.testing.assert_array_equal(device.sample().axes, held)
    np.testing.assert_array_equal(device.sample().axes, held)
    assert not device.sample().connected
    other.unplug()


def test_a_twin_in_use_does_not_take_the_place_of_the_lost_one(pad: VirtualPad) -> None:
    twin = VirtualPad()
    lost, kept = PygameDevice(0), PygameDevice(1)
    pad.axis(0, 0.5)
    twin.axis(0, -0.5)
    held = lost.sample().axes
    kept.sample()
    pad.unplug()
    newcomer = VirtualPad("Other Stick")  # makes the lost one look around
    np.testing.assert_array_equal(lost.sample().axes, held)
    np.testing.assert_array_equal(lost.sample().axes, held)
    twin.unplug()
    newcomer.unplug()


def test_an_equal_pad_that_was_there_does_not_take_the_place_of_the_lost_one(
    pad: VirtualPad,
) -> None:
    device = PygameDevice()
    equal = VirtualPad()  # comes while ours is there; nobody uses it
    equal.axis(0, -0.5)
    pad.axis(0, 0.5)
    held = device.sample().axes
    pad.unplug()
    newcomer = VirtualPad("Other Stick")  # makes the lost one look around
    for _ in range(3):
        np.testing.assert_array_equal(device.sample().axes, held)
    assert not device.sample().connected
    pad.plug()
    assert device.sample().connected
    equal.unplug()
    newcomer.unplug()


def test_a_short_loss_is_seen_by_one_read(pad: VirtualPad) -> None:
    device = PygameDevice()
    device.sample()
    pad.unplug()
    pad.plug()
    assert not device.sample().connected
    assert device.sample().connected


def test_any_button_counts_as_pressed(pad: VirtualPad) -> None:
    device = PygameDevice()
    for down in (False, True, False):
        pad.button(1, down)
        assert device.sample().buttons.any() == down


def test_two_devices_both_hear_of_a_removal(pad: VirtualPad) -> None:
    second_pad = VirtualPad("Second Pad")
    first, second = PygameDevice(0), PygameDevice(1)
    assert (first.name, second.name) == ("Virtual Pad (flight_stick)", "Second Pad (flight_stick)")
    pad.axis(0, 0.5)
    second_pad.axis(0, -0.5)
    first.sample()
    pad.unplug()
    # The second device takes the events off the queue; the first must still hold.
    np.testing.assert_allclose(second.sample().axes[0], -0.5, atol=RESOLUTION)
    np.testing.assert_allclose(first.sample().axes[0], 0.5, atol=RESOLUTION)
    second_pad.unplug()


def test_rumble_reaches_the_motors_and_stops_by_itself(pad: VirtualPad) -> None:
    device = PygameDevice()
    assert device.rumble(0.25, 0.75, 20)
    assert pad.rumbles == [(16383, 49151)]
    time.sleep(0.05)
    device.sample()
    assert pad.rumbles[-1] == (0, 0)


def test_rumble_clips_and_is_false_without_motors(pad: VirtualPad) -> None:
    device = PygameDevice()
    assert device.rumble(7.0, -1.0, 20)
    assert pad.rumbles[-1] == (65535, 0)
    mute = VirtualPad("Mute", motors=False)
    assert not PygameDevice(1).rumble(0.5, 0.5, 100)
    mute.unplug()


def test_close_stops_the_motors_and_may_be_repeated(pad: VirtualPad) -> None:
    device = PygameDevice()
    pad.axis(0, 0.5)
    held = device.sample().axes
    device.rumble(1.0, 1.0, 1000)
    device.close()
    device.close()
    assert pad.rumbles[-1] == (0, 0)
    assert not device.sample().connected
    assert not device.rumble(1.0, 1.0, 100)
    np.testing.assert_array_equal(device.sample().axes, held)


def test_wrong_index_lists_what_is_there(pad: VirtualPad) -> None:
    with pytest.raises(ValueError, match=r"operator.index: 3, allowed 0 \(Virtual Pad\)"):
        PygameDevice(3)
    with pytest.raises(ValueError, match=r"operator\.index: -1"):
        PygameDevice(-1)


def test_without_a_joystick() -> None:
    if pygame.joystick.get_init() and pygame.joystick.get_count():
        pytest.skip("a real joystick is plugged in")
    assert find_device() is None
    with pytest.raises(ValueError, match="no joystick is there"):
        PygameDevice(0)


def test_find_device_opens_the_first(pad: VirtualPad) -> None:
    device = find_device()
    assert device is not None
    assert device.name == "Virtual Pad (flight_stick)"


def test_keyboard_events_stay_on_the_queue(pad: VirtualPad) -> None:
    device = PygameDevice()
    pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=pygame.K_a))
    device.sample()
    assert [event.key for event in pygame.event.get(pygame.KEYDOWN)] == [pygame.K_a]


def test_source_follows_the_stick_through_a_run_and_holds_when_unplugged(pad: VirtualPad) -> None:
    source = JoystickSource(PygameDevice(), period=0.01)
    simulator = Simulator(source)
    context = simulator.get_context()
    port = source.GetOutputPort("joystick_axes")
    simulator.AdvanceTo(0.005)
    np.testing.assert_array_equal(port.Eval(context), np.zeros(5))
    pad.axis(1, -0.5)
    simulator.AdvanceTo(0.025)
    np.testing.assert_allclose(port.Eval(context), [0, -0.5, 0, 0, 0], atol=RESOLUTION)
    pad.unplug()
    simulator.AdvanceTo(0.055)
    np.testing.assert_allclose(port.Eval(context), [0, -0.5, 0, 0, 0], atol=RESOLUTION)


def test_a_pad_lost_in_a_run_stops_the_mast_and_is_recorded(pad: VirtualPad) -> None:
    settings = {"operator.device": "joystick", "operator.axes.z": 3, "logging.period": 0.01}
    scenario = load_scenario("free_motion", settings | {"duration": 0.9})
    pad.axis(3, -1.0)  # a trigger at rest
    moves = {0.15: lambda: pad.button(0, True), 0.2: lambda: pad.hat(0, 1), 0.5: pad.unplug}
    sample = PygameDevice.sample

    def scripted(device: PygameDevice) -> Sample:
        scripted.reads += 1  # type: ignore[attr-defined]  # a counter on the function
        moves.get(round((scripted.reads - 2) * 0.01, 2), lambda: None)()  # type: ignore[attr-defined]
        return sample(device)

    scripted.reads = 0  # type: ignore[attr-defined]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(PygameDevice, "sample", scripted)
        recording = simulate(scenario)
    assert recording.attrs["device"] == "Virtual Pad (flight_stick)"
    connected = recording.device_connected.values
    lost = int(np.argmin(connected))
    assert 0 < lost < connected.size - 20
    np.testing.assert_array_equal(connected, np.arange(connected.size) < lost)
    assert recording.joystick_axes.sel(stick="mast_hat").values[lost - 1] == 1.0
    np.testing.assert_array_equal(recording.joystick_axes.values[lost:], 0.0)
    np.testing.assert_array_equal(recording.operator_state.values[lost + 1 :], State.HOLD)
    np.testing.assert_array_equal(recording.operator_reason.values[lost + 1 :], Reason.DEVICE_LOST)
    height = recording.p_WE_commanded.sel(axis="z").values
    assert height[lost] > height[0] + 0.03
    rate = np.diff(height) / 0.01
    assert rate.max() <= 0.2 + 1e-9
    assert np.abs(np.diff(rate)).max() / 0.01 <= 1.0 + 1e-6  # brakes as fast as it may
    np.testing.assert_allclose(height[lost + 30 :], height[-1], atol=1e-12)


def test_the_recording_says_that_a_trace_was_played() -> None:
    scenario = load_scenario("free_motion", {"operator.device": "auto", "duration": 0.01})
    assert simulate(scenario).attrs["device"] == "trace operator_trace.csv"
