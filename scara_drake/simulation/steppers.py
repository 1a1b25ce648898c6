"""What advances a Diagram: Drake's Simulator, or the same Diagram compiled."""

from __future__ import annotations

import weakref
from functools import cache
from pathlib import Path
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram

import scara_drake
from scara_drake.common.finite import naming_nan
from scara_drake.common.kernel_cache import cache_folder
from scara_drake.engine.errors import NotCompilableError
from scara_drake.engine.stepper import CompiledStepper
from scara_drake.recordings.recorder import drain
from scara_drake.scenario import Scenario
from scara_drake.simulation.pacing import Pacing

Array = NDArray[np.float64]

AUTO, DRAKE, COMPILED = "auto", "drake", "compiled"
ENGINES: Final = (AUTO, DRAKE, COMPILED)


class Stepper(Protocol):
    """What advances a Diagram from t = 0.

    Attributes:
        block: simulated time between two looks at its samples, what may end it, and the clock [s].
    """

    block: float

    @property
    def time(self) -> float:
        """How far it is [s]."""

    def begin(self) -> None:
        """Do what happens at t = 0."""

    def advance_to(self, time: float) -> None:
        """Advance to a time [s]."""

    def drain(self) -> tuple[Array, Array]:
        """Return the samples that nobody has taken yet: times (n,) and values (n, width)."""


class DrakeStepper:
    """Drake's Simulator; see `Stepper`.

    Args:
        diagram: of `make_diagram`.
        pacing: by the clock; None for as fast as it goes.
    """

    block = 0.1  # [s]

    def __init__(self, diagram: Diagram, pacing: Pacing | None = None) -> None:
        self._diagram, self._simulator = diagram, Simulator(diagram)
        self._context = self._simulator.get_mutable_context()
        self._pacing = pacing

    @property
    def time(self) -> float:
        """How far it is [s]."""
        return float(self._context.get_time())

    def begin(self) -> None:
        """Do what happens at t = 0, and begin the pacing."""
        with naming_nan(self._diagram, self._context):
            self._simulator.Initialize()
        if self._pacing is not None:
            self._pace(self._pacing)

    def _pace(self, pacing: Pacing) -> None:
        simulator = weakref.proxy(self._simulator)  # it holds the monitor: neither could be freed

        def monitor(context: Context) -> None:
            if pacing.tick(context.get_time()):
                simulator.ResetStatistics()

        self._simulator.set_target_realtime_rate(pacing.rate)
        self._simulator.set_monitor(monitor)
        self._simulator.ResetStatistics()
        pacing.begin(self.time)

    def advance_to(self, time: float) -> None:
        """Advance to a time [s].

        Raises:
            RuntimeError: NaN or infinity; names the system, the port, the time and the entry.
        """
        with naming_nan(self._diagram, self._context):
            self._simulator.AdvanceTo(time)

    def drain(self) -> tuple[Array, Array]:
        """Return the samples that nobody has taken yet: times (n,) and values (n, width)."""
        return drain(self._diagram, self._context)


def compiled_stepper(diagram: Diagram, scenario: Scenario) -> CompiledStepper:
    """Return what advances a Diagram compiled, from the cache where its like was compiled before.

    Raises:
        NotCompilableError: a part of it can only run in Drake; names it.
    """
    return CompiledStepper(diagram, scenario, _functions_folder())


@cache
def _functions_folder() -> Path:
    """Return where compiled functions are kept; to find it a file is written."""
    package = Path(scara_drake.__file__).parent
    return (cache_folder(package) or package / "__pycache__") / "engine"


def why_not_compiled(diagram: Diagram, scenario: Scenario) -> str:
    """Return the line that says which part of a Diagram only Drake can run; "" if none."""
    try:
        compiled_stepper(diagram, scenario)
    except NotCompilableError as error:
        return str(error)
    return ""
