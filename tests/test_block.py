from __future__ import annotations

import numpy as np
import pytest
from leaf import ports, tick
from numba import njit
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput

from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.robot import add_scara

PERIOD = 0.01  # [s]


@njit
def lag_step(u: np.ndarray, decay: float, y: np.ndarray) -> None:
    """The first-order lag y <- u + (y - u) decay."""
    for i in range(y.size):
        y[i] = u[i] + (y[i] - u[i]) * decay


def lag_start(u: np.ndarray, y: np.ndarray) -> None:
    y[:] = u


def lag_rest(y: np.ndarray) -> None:
    y[:] = -1.0


def doubled(y: np.ndarray, twice: np.ndarray) -> None:
    twice[:] = 2.0 * y


def ramp(t: float, slope: float, line: np.ndarray) -> None:
    line[:] = slope * t


def lag(**changes: object) -> Block:
    declared: dict = {
        "inputs": {"u": Input(2, finite=True)},
        "memory": {"y": Memory([3.0, 4.0], port=True), "hidden": Memory(1)},
        "outputs": {"twice": Output(2, doubled), "line": Output(1, ramp)},
        "parameters": {"decay": 0.5, "slope": 2.0},
        "period": PERIOD,
        "update": lag_step,
    }
    block = Block(Declaration(**{**declared, **changes}))
    block.set_name("lag")
    return block


def test_ports_and_first_values_are_those_declared():
    block = lag()
    assert ports(block) == ({"u": 2}, {"y": 2, "twice": 2, "line": 1})
    context = block.CreateDefaultContext()
    np.testing.assert_array_equal(block.GetOutputPort("y").Eval(context), [3.0, 4.0])
    np.testing.assert_array_equal(block.GetOutputPort("twice").Eval(context), [6.0, 8.0])
    context.SetTime(1.5)
    assert block.GetOutputPort("line").Eval(context) == 3.0


def test_it_follows_the_closed_form_at_its_period():
    block = lag()
    simulator = Simulator(block)
    block.get_input_port().FixValue(simulator.get_mutable_context(), [1.0, 1.0])
    for count in (1, 7):
        simulator.AdvanceTo((count - 0.5) * PERIOD)
        y = block.GetOutputPort("y").Eval(simulator.get_context())
        np.testing.assert_allclose(y, 1.0 + np.array([2.0, 3.0]) * 0.5**count, rtol=1e-15)


def test_memory_alone_is_no_feedthrough_and_an_input_that_is_read_is():
    assert not lag().HasAnyDirectFeedthrough()

    def passed(u: np.ndarray, twice: np.ndarray) -> None:
        twice[:] = u

    assert lag(outputs={"twice": Output(2, passed)}).HasDirectFeedthrough(0, 1)


def test_an_argument_that_nobody_declared_is_named():
    def odd(u: np.ndarray, gain: float, y: np.ndarray) -> None:
        y[:] = gain * u

    with pytest.raises(ValueError, match="argument 'gain' of odd, allowed t, u, y, hidden, decay"):
        lag(update=odd)


def test_an_unconnected_input_is_its_default_and_a_connected_one_is_itself():
    block = lag(inputs={"u": Input(2, default=(5.0, 7.0))}, initialize=lag_start)
    context = block.CreateDefaultContext()
    tick(block, context)
    np.testing.assert_array_equal(block.GetOutputPort("y").Eval(context), [4.0, 5.5])
    block.get_input_port().FixValue(context, [0.0, 0.0])
    tick(block, context)
    np.testing.assert_array_equal(block.GetOutputPort("y").Eval(context), [2.0, 2.75])


def test_a_start_by_its_inputs():
    block = lag(initialize=lag_start)
    simulator = Simulator(block)
    block.get_input_port().FixValue(simulator.get_mutable_context(), [8.0, 9.0])
    simulator.Initialize()
    y = block.GetOutputPort("y").Eval(simulator.get_context())
    np.testing.assert_array_equal(y, [8.0, 9.0])


@pytest.mark.parametrize(("enable", "expected"), [(1.0, 2.0), (0.5, 2.0), (0.4, -1.0)])
def test_while_not_enabled_it_rests(enable, expected):
    gate = {"u": Input(2), "on": Input(1)}
    block = lag(inputs=gate, enable="on", rest=lag_rest)
    context = block.CreateDefaultContext()
    block.get_input_port(0).FixValue(context, [1.0, 1.0])
    block.get_input_port(1).FixValue(context, [enable])
    tick(block, context)
    assert block.GetOutputPort("y").Eval(context)[0] == expected


def test_an_enable_that_nobody_drives_is_on():
    block = lag(inputs={"u": Input(2), "on": Input(1)}, enable="on", rest=lag_rest)
    context = block.CreateDefaultContext()
    block.get_input_port(0).FixValue(context, [1.0, 1.0])
    tick(block, context)
    assert block.GetOutputPort("y").Eval(context)[0] == 2.0


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("index", [0, 1])
def test_what_has_to_be_finite_stops_the_run_with_its_place(wrong, index):
    block = lag()
    simulator = Simulator(block)
    value = np.ones(2)
    value[index] = wrong
    block.get_input_port().FixValue(simulator.get_mutable_context(), value)
    with pytest.raises(RuntimeError, match=rf"lag: port 'u' at t = 0 s: u\[{index}\] is {wrong}"):
        simulator.AdvanceTo(PERIOD / 2)


def test_it_is_updated_with_the_step_of_the_plant_before_that_shows():
    """It sees the state before the step of its tick, another block the one after it."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlant(MultibodyPlantConfig(time_step=PERIOD), builder)
    add_scara(plant)
    plant.Finalize()
    v0 = np.zeros(6)
    v0[1] = 0.5

    def keep(state: np.ndarray, seen: np.ndarray) -> None:
        seen[:] = state

    seen = []
    for together in (True, False):
        declared = Declaration(
            inputs={"state": Input(12)}, memory={"seen": Memory(12, port=True)},
            period=PERIOD, update=keep, with_plant=together,
        )  # fmt: skip
        block = builder.AddSystem(Block(declared))
        builder.Connect(plant.get_state_output_port(), block.get_input_port())
        seen.append(block)
    rest = builder.AddSystem(ConstantVectorSource(np.zeros(6)))
    builder.Connect(rest.get_output_port(), plant.get_actuation_input_port())
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    plant.SetVelocities(plant.GetMyMutableContextFromRoot(context), v0)
    simulator.AdvanceTo(PERIOD / 2)
    early, late = (s.GetOutputPort("seen").Eval(s.GetMyContextFromRoot(context)) for s in seen)
    state = plant.get_state_output_port().Eval(plant.GetMyContextFromRoot(context))
    assert early[7] == 0.5
    assert late[7] != 0.5
    np.testing.assert_array_equal(late, state)


def test_a_cloned_context_continues_to_the_bit():
    block = lag()
    builder = DiagramBuilder()
    source = builder.AddSystem(ConstantVectorSource(np.array([0.3, -0.7])))
    builder.AddSystem(block)
    builder.Connect(source.get_output_port(), block.get_input_port())
    log = LogVectorOutput(block.GetOutputPort("y"), builder, PERIOD)
    diagram = builder.Build()
    first = Simulator(diagram)
    first.AdvanceTo(5.5 * PERIOD)
    second = Simulator(diagram, first.get_context().Clone())
    for simulator in (first, second):
        simulator.AdvanceTo(9.5 * PERIOD)
    continued, cloned = (log.FindLog(run.get_context()).data() for run in (first, second))
    np.testing.assert_array_equal(continued, cloned)


def push(t: float, trail: np.ndarray) -> None:
    trail[:] = t


def keep(trail: np.ndarray, kept: np.ndarray, seen: np.ndarray) -> None:
    kept[:] = np.append(kept[1:], trail)
    seen[:] = kept


def archiving() -> Block:
    return Block(
        Declaration(
            memory={"trail": Memory([-1.0], port=True), "seen": Memory(3, port=True)},
            period=PERIOD,
            update=push,
            archive={"kept": Memory(3)},
            store=keep,
            store_ticks=4,
        )
    )


def test_a_store_moves_memory_to_an_archive_before_the_update_of_its_instant():
    block = archiving()
    simulator = Simulator(block)
    simulator.AdvanceTo(8.5 * PERIOD)
    context = simulator.get_context()
    seen = block.GetOutputPort("seen").Eval(context)
    np.testing.assert_allclose(seen, [-1.0, 3 * PERIOD, 7 * PERIOD])
    clone = Simulator(block, context.Clone())
    simulator.AdvanceTo(12.5 * PERIOD)
    clone.AdvanceTo(12.5 * PERIOD)
    for one in (simulator, clone):
        seen = block.GetOutputPort("seen").Eval(one.get_context())
        np.testing.assert_allclose(seen, [3 * PERIOD, 7 * PERIOD, 11 * PERIOD])


def test_an_archive_is_for_the_store_alone():
    with pytest.raises(ValueError, match="argument 'kept' of keep, allowed t, trail, seen"):
        Block(Declaration(**{**vars(archiving().declaration), "update": keep}))
