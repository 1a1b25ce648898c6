"""What the engine takes of a Diagram: all of it, or it says what not."""

from __future__ import annotations

import gc
from dataclasses import fields

import numpy as np
import pytest
from engines import both, differences
from numba import njit
from pydrake.systems.framework import Diagram
from pydrake.systems.primitives import ConstantVectorSource

from scara_drake import load_scenario, simulate
from scara_drake.common.block import Block, Declaration, Memory, Output
from scara_drake.engine import stepper
from scara_drake.engine.errors import NotCompilableError
from scara_drake.engine.graph import HANDLED, Buffer, Graph, Node, declaration_of, graph_of

LONG = {
    "signals": ("teleoperation", {"channel.up.delay": 0.9, "channel.down.delay": 0.4}),
    "packets": ("bilateral", {"channel.preset": "satellite"}),
}


@pytest.mark.parametrize(("name", "overrides"), LONG.values(), ids=LONG)
def test_a_long_channel_has_its_archive(name: str, overrides: dict[str, float | str]) -> None:
    compiled, drake = both(load_scenario(name, {**overrides, "duration": 1.5}))
    assert float(drake.delay_up.max()) > 0.25
    assert max(differences(compiled, drake).values()) < 1e-9


OPENS = 0.0205  # [s]


@njit
def hold(y: np.ndarray) -> None:
    y[:] = 1.0


def block() -> Block:
    return Block(Declaration(memory={"y": Memory(2, port=True)}, period=0.1, update=hold))


def test_a_block_is_its_declaration() -> None:
    assert declaration_of(block()) is not None


@pytest.mark.parametrize(
    "add",
    [
        lambda block: block.DeclareVectorInputPort("more", 1),
        lambda block: block.DeclareDiscreteState(3),
        lambda block: block.DeclareContinuousState(1),
    ],
    ids=["port", "discrete state", "continuous state"],
)
def test_a_block_with_more_than_its_declaration_is_refused(add: object) -> None:
    more = block()
    more.set_name("more")
    add(more)  # type: ignore[operator]  # one of the functions above
    with pytest.raises(NotCompilableError, match="more: it has ports or state beside"):
        declaration_of(more)


def test_all_that_a_declaration_can_say_is_handled() -> None:
    assert {field.name for field in fields(Declaration)} == HANDLED


def test_a_constant_is_kept_beyond_the_context_that_showed_it() -> None:
    source = ConstantVectorSource(np.arange(1.0, 4.0))
    declared = declaration_of(source)
    assert declared is not None
    gc.collect()
    others = [source.CreateDefaultContext() for _ in range(50)]
    for context in others:
        source.get_mutable_source_value(context).SetFromVector(np.full(3, -1.0))
    kept = declared.memory["value"].initial
    np.testing.assert_array_equal(kept, np.arange(1.0, 4.0))
    assert isinstance(kept, np.ndarray)
    assert kept.flags.owndata  # no view of what is freed, which may look right for a while


@njit(cache=False)
def late(t: float, engaged: np.ndarray) -> None:
    engaged[0] = 1.0 if t > OPENS else 0.0


def test_an_enable_that_is_worked_out_is_worked_out_each_tick(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The drives give nothing until a computed output engages them."""

    def gated(diagram: Diagram) -> Graph:
        graph = graph_of(diagram)
        gate = Declaration(outputs={"engaged": Output(1, late)})
        graph.nodes["gate"] = Node("gate", gate, {})
        graph.nodes["controller"].reads["engaged"] = Buffer("gate", "engaged")
        return graph

    monkeypatch.setattr(stepper, "graph_of", gated)
    run = simulate(load_scenario("joint_sine", {"duration": 0.04}), engine="compiled")
    gives = (run.tau_commanded.values != 0.0).any(axis=1)
    # A sample shows what was there before the update of its time.
    np.testing.assert_array_equal(gives, run.time.values > OPENS + 1e-3)
