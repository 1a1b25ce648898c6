"""The recorder of a Diagram: it stacks the signals into one vector and logs that once a period."""

from __future__ import annotations

import json
import platform
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib.metadata import version
from itertools import pairwise
from typing import Any, cast

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import LogVectorOutput, Multiplexer, VectorLogSink

from scara_drake.recordings.dataset import to_dataset
from scara_drake.recordings.signals import SIGNALS

Array = NDArray[np.float64]

_BUNDLE, _LOG = "recorded_signals", "recorder"


@dataclass(frozen=True)
class Origin:
    """What a recording says about where it comes from.

    Attributes:
        scenario_name: of the scenario.
        scenario: its YAML text.
        seed: of its random draws.
        surfaces: names of the surfaces that the tool may touch.
        duration: [s], of a whole run.
        notes: further attributes of the recording.
    """

    scenario_name: str
    scenario: str
    seed: int
    surfaces: tuple[str, ...] = ()
    duration: float = 0.0
    notes: dict[str, str | int | float] = field(default_factory=dict)


class SignalBundle(Multiplexer):
    """Stacks the recorded signals into one vector, and knows what they are.

    Input ports: one for each recorded signal, in order.
    Output port: all of them, stacked.
    """

    __slots__ = ()  # so that it can be freed, see `Collectable`

    def __init__(self, sizes: list[int], metadata: dict[str, Any]):
        super().__init__(sizes)
        self.metadata = json.dumps(metadata)  # text, so that nobody can change it in place


def add_recorder(
    builder: DiagramBuilder,
    signals: dict[str, OutputPort],
    origin: Origin,
    periods: dict[str, float],
    time_step: float,
    logging_period: float,
) -> None:
    """Log those of some signals that `SIGNALS` names.

    Args:
        builder: of the Diagram.
        signals: by name.
        origin: goes into the recording.
        periods: [s], of the signals that change less often than once a time step.
        time_step: [s].
        logging_period: [s], from sample to sample.
    """
    wanted = {signal.source for signal in SIGNALS.values()}
    signals = {name: port for name, port in signals.items() if name in wanted}
    sizes = [port.size() for port in signals.values()]
    starts = np.cumsum([0, *sizes]).tolist()
    metadata = {
        "columns": dict(zip(signals, pairwise(starts), strict=True)),
        "periods": {name: periods.get(name, time_step) for name in signals},
        **asdict(origin),
        "versions": versions(),
    }
    bundle = builder.AddNamedSystem(_BUNDLE, SignalBundle(sizes, metadata))
    for index, port in enumerate(signals.values()):
        builder.Connect(port, bundle.get_input_port(index))
    log = LogVectorOutput(bundle.get_output_port(), builder, logging_period)
    log.set_name(_LOG)


def versions() -> dict[str, str]:
    """Return the versions of what a result depends on."""
    packages = ("scara-drake", "drake", "numpy", "numba")
    return {"python": platform.python_version(), **{name: _version(name) for name in packages}}


@cache
def _version(package: str) -> str:
    """Return a version, which is searched for on the disk once."""
    return version(package)


def drain(diagram: Diagram, context: Context) -> tuple[Array, Array]:
    """Return and clear what the log holds: times (n,) and values (n, width)."""
    log = _sink(diagram).FindMutableLog(context)
    times, values = log.sample_times().copy(), log.data().T.copy()
    log.Clear()
    return times, values


def metadata(diagram: Diagram) -> dict[str, Any]:
    """Return the description of what a Diagram of `make_diagram` logs.

    Raises:
        ValueError: the Diagram has no recorder.
    """
    if not diagram.HasSubsystemNamed(_BUNDLE):
        raise ValueError("diagram: no recorder, allowed a Diagram of scara_drake.make_diagram")
    bundle = cast(SignalBundle, diagram.GetSubsystemByName(_BUNDLE))
    description: dict[str, Any] = json.loads(bundle.metadata)
    return description


def recording(diagram: Diagram, context: Context) -> xr.Dataset:
    """Return what your own Simulator's run of a Diagram has logged so far.

    Args:
        diagram: made by `make_diagram`.
        context: its root context, such as ``simulator.get_context()``.

    Raises:
        ValueError: the Diagram was not made by `make_diagram`.
    """
    description = metadata(diagram)
    log = _sink(diagram).FindLog(context)
    return to_dataset(description, log.sample_times(), log.data().T)


def _sink(diagram: Diagram) -> VectorLogSink:
    return cast(VectorLogSink, diagram.GetSubsystemByName(_LOG))
