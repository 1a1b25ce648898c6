"""A delay that is set during a run: what is received is what was sent then, and never runs back."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from engines import FREE, both, differences
from hypothesis import given
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import LogVectorOutput
from strategies import examples

import scara_drake as sd
from scara_drake.channel.live_delay import LONGEST_LIVE, LiveDelay
from scara_drake.common.resources import resource
from scara_drake.vectors import LIVE_SETTINGS, NEUTRAL_SETTINGS

H = 1e-3
INITIAL = (-7.0, 3.0)


def settings(delay: float, link: str = "up") -> np.ndarray:
    return LIVE_SETTINGS.pack(**NEUTRAL_SETTINGS._replace(**{f"delay_{link}": delay})._asdict())


def sent(tick: int) -> np.ndarray:
    """Two signals that never repeat."""
    return np.array([float(tick), math.sin(11.0 * tick)])


def stepped(wanted: list[float], store_first: bool, link: str = "up") -> tuple[np.ndarray, ...]:
    """What is received at each tick (n, 2), and the delay in use [s], by the kernels alone."""
    is_ = LiveDelay(INITIAL, H, link).declaration
    p = is_.parameters
    live, archived = (
        np.array(memory.initial) for memory in (is_.memory["live"], is_.archive["archived"])
    )
    assert is_.store is not None
    assert is_.update is not None
    received, delays, delay_live = np.empty((len(wanted), 2)), np.empty(len(wanted)), np.zeros(1)
    for tick, delay in enumerate(wanted):
        is_.outputs["signal_delayed"].kernel(sent(tick), p["recent"], live, received[tick])
        delays[tick] = delay_live[0]
        stores = tick % is_.store_ticks == 0
        if stores and store_first:
            is_.store(p["recent"], p["size"], live, archived)
        is_.update(sent(tick), settings(delay, link), p["link"], H, p["recent"], live, delay_live)
        if stores and not store_first:
            is_.store(p["recent"], p["size"], live, archived)
    return received, delays


def expected(delays: np.ndarray) -> np.ndarray:
    numbers = np.arange(delays.size) - np.round(delays / H).astype(int)
    return np.array([sent(number) if number >= 0 else INITIAL for number in numbers])


@given(
    st.lists(
        st.tuples(st.sampled_from([0.0, 1e-3, 0.02, 0.3, 1.0, LONGEST_LIVE]), st.integers(1, 1500)),
        min_size=1,
        max_size=6,
    ),
    st.booleans(),
)
@examples(15)
def test_what_is_received_is_what_was_sent_then_and_never_runs_backwards(
    plan: list[tuple[float, int]], store_first: bool
) -> None:
    wanted = [delay for delay, ticks in plan for _ in range(ticks)]
    received, delays = stepped(wanted, store_first)
    np.testing.assert_array_equal(received, expected(delays))
    forward = np.diff(np.arange(delays.size) - np.round(delays / H))
    assert ((forward >= 0.0) & (forward <= 2.0)).all()
    over_time = delays[100:] - delays[:-100]
    assert (abs(over_time) <= 0.5 * 100 * H + H).all()


@pytest.mark.parametrize("store_first", [True, False])
def test_a_delay_is_reached_and_left_and_then_it_is_the_signal_itself(store_first: bool) -> None:
    wanted = [0.0] * 100 + [1.5] * 3200 + [0.0] * 3200
    received, delays = stepped(wanted, store_first)
    assert delays.max() == pytest.approx(1.5)
    np.testing.assert_array_equal(delays[:101], 0.0)
    assert delays[100 + 3000 + 1] == pytest.approx(1.5)
    np.testing.assert_array_equal(delays[-100:], 0.0)
    now = np.array([sent(tick) for tick in range(len(wanted))])
    np.testing.assert_array_equal(received[:101], now[:101])
    np.testing.assert_array_equal(received[-100:], now[-100:])


def test_the_other_direction_s_setting_and_bad_ones_change_nothing() -> None:
    _, delays = stepped([math.nan, math.inf, -math.inf, -1.0] * 100, True)
    np.testing.assert_array_equal(delays, 0.0)
    _, delays = stepped([100.0] * 4500, True)
    assert delays.max() == pytest.approx(LONGEST_LIVE)
    is_ = LiveDelay(INITIAL, H, "down").declaration
    assert is_.update is not None
    live, delay = np.array(is_.memory["live"].initial), np.zeros(1)
    for tick in range(50):
        is_.update(
            sent(tick), settings(0.1, "up"), is_.parameters["link"], H,
            is_.parameters["recent"], live, delay,
        )  # fmt: skip
    assert delay[0] == 0.0


class Wanted(LeafSystem):
    """A signal of the time, and settings that change."""

    def __init__(self) -> None:
        super().__init__()
        time = {self.time_ticket()}
        self.DeclareVectorOutputPort("signal", 2, self._signal, prerequisites_of_calc=time)
        self.DeclareVectorOutputPort("settings", 5, self._settings, prerequisites_of_calc=time)

    def _signal(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(sent(round(context.get_time() / H)))

    def _settings(self, context: Context, output: BasicVector) -> None:
        t = context.get_time()
        output.SetFromVector(settings(0.2 if 0.1 <= t < 0.7 else 0.0))


@pytest.mark.parametrize("connected", [True, False])
def test_in_a_diagram_it_delays_as_told_and_not_where_nothing_is_told(connected: bool) -> None:
    builder = DiagramBuilder()
    source = builder.AddSystem(Wanted())
    block = builder.AddSystem(LiveDelay(INITIAL, H))
    builder.Connect(source.GetOutputPort("signal"), block.GetInputPort("signal_sent"))
    if connected:
        builder.Connect(source.GetOutputPort("settings"), block.GetInputPort("live_settings"))
    logs = [
        LogVectorOutput(block.GetOutputPort(name), builder, H)
        for name in ("signal_delayed", "delay_live")
    ]
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(1.3)
    received, delays = (log.FindLog(simulator.get_context()).data() for log in logs)
    np.testing.assert_array_equal(received.T, expected(delays[0]))
    assert delays.max() == pytest.approx(0.2 if connected else 0.0)
    assert delays[0, -1] == 0.0


def test_a_supervised_run_has_the_operator_s_delays_and_gains_in_both_engines(tmp_path) -> None:
    plain = pd.read_csv(resource("diagrams") / "operator_trace.csv")
    trace, time = tmp_path / "settings.csv", plain.time
    plain = plain.assign(
        delay_up=np.where((time > 0.05) & (time < 0.3), 0.1, 0.0),
        delay_down=np.where((time > 0.1) & (time < 0.3), 0.05, 0.0),
        gain_scale=np.where(time > 0.2, 0.4, 1.0),
    )
    plain[time < 1.0].to_csv(trace, index=False)
    changes = {"duration": 0.7, "operator.trace": str(trace), "supervision": "{}"}
    compiled, drake = both(sd.load_scenario("teleoperation", changes))
    assert max(differences(compiled, drake).values()) < FREE
    for name, link, live in (("delay_up", 0.05, 0.1), ("delay_down", 0.05, 0.05)):
        np.testing.assert_allclose(drake[name][[0, -1]], link)
        np.testing.assert_allclose(drake[name].max(), link + live)
