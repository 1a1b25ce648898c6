"""What the engine takes of a Diagram: all of it, or it says what not."""

from __future__ import annotations

import gc
from dataclasses import fields

import numpy as np
import pytest
from engines import both, differences
from numba import njit
from pydrake.systems.primitives import ConstantVectorSource

from scara_drake import load_scenario
from scara_drake.common.block import Block, Declaration, Memory
from scara_drake.engine.errors import NotCompilableError
from scara_drake.engine.graph import HANDLED, declaration_of

LONG = {
    "signals": ("teleoperation", {"channel.up.delay": 0.9, "channel.down.delay": 0.4}),
    "packets": ("bilateral", {"channel.preset": "satellite"}),
}


@pytest.mark.parametrize(("name", "overrides"), LONG.values(), ids=LONG)
def test_a_long_channel_has_its_archive(name: str, overrides: dict[str, float | str]) -> None:
    compiled, drake = both(load_scenario(name, {**overrides, "duration": 1.5}))
    assert float(drake.delay_up.max()) > 0.25
    assert max(differences(compiled, drake).values()) < 1e-9


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
