"""A Diagram that nobody holds is freed, so that thousands of runs may share a process."""

from __future__ import annotations

import gc
import subprocess
import sys
import weakref

import numpy as np
import pytest
from pydrake.geometry import Meshcat
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder

import scara_drake as sd
from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.scenario import scenario_names


class Own(Block):
    """A block of a user, with a computed output."""

    def __init__(self) -> None:
        super().__init__(
            Declaration(
                inputs={"u": Input(1, finite=True, default=(1.0,))},
                memory={"y": Memory(1, port=True)},
                outputs={"both": Output(1, lambda u, y, both: np.copyto(both, u + y))},
                period=0.1,
                update=lambda u, y: np.copyto(y, u),
                initialize=lambda u, y: np.copyto(y, u),
            )
        )


def run_shortly(diagram: Diagram) -> None:
    Simulator(diagram).AdvanceTo(0.02)


def witnesses(diagram: Diagram) -> dict[str, weakref.ref]:
    systems = {system.get_name(): weakref.ref(system) for system in diagram.GetSystems()}
    return {"the Diagram": weakref.ref(diagram), **systems}


def alive(seen: dict[str, weakref.ref]) -> list[str]:
    gc.collect()
    return [name for name, system in seen.items() if system() is not None]


@pytest.mark.parametrize("name", scenario_names())
def test_a_diagram_is_freed_after_its_run(name: str) -> None:
    overrides = {"operator.device": "trace"} if "teleoperation" in name else {}
    diagram = sd.make_diagram(sd.load_scenario(name, overrides))
    run_shortly(diagram)
    seen = witnesses(diagram)
    del diagram
    assert alive(seen) == []


def test_one_that_draws_itself_is_freed() -> None:
    diagram = sd.make_diagram(sd.load_scenario("joint_sine"), Meshcat())
    run_shortly(diagram)
    seen = witnesses(diagram)
    del diagram
    assert alive(seen) == []


def test_a_block_of_a_user_is_freed_and_lives_as_long_as_its_diagram() -> None:
    builder = DiagramBuilder()
    builder.AddNamedSystem("own", Own())
    diagram = builder.Build()
    del builder
    seen = witnesses(diagram)
    gc.collect()
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.15)
    own = diagram.GetSubsystemByName("own")
    both = own.GetOutputPort("both").Eval(own.GetMyContextFromRoot(simulator.get_context()))
    assert both == pytest.approx([2.0])
    del simulator, own, diagram
    assert alive(seen) == []


IN_ANOTHER_THREAD = """
import gc, threading
from pydrake.geometry import Meshcat
import scara_drake as sd
diagram = sd.make_diagram(sd.load_scenario("joint_sine"), Meshcat())
del diagram
thread = threading.Thread(target=gc.collect)
thread.start()
thread.join()
print("alive")
"""


def test_a_drawn_diagram_may_be_freed_in_any_thread() -> None:
    """Drake ends the program where a Meshcat is freed by another thread than its own."""
    command = [sys.executable, "-c", IN_ANOTHER_THREAD]
    result = subprocess.run(command, capture_output=True, text=True)
    assert (result.returncode, result.stdout) == (0, "alive\n"), result.stderr
