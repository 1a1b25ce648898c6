"""Recordings: what a Diagram logs, and the labelled dataset made of it.

A Diagram stacks its signals into one vector and logs that vector once a period. `SIGNALS` says
which entries of which signal make which variable of the dataset.
"""

from __future__ import annotations

import json
import os
import platform
from dataclasses import dataclass
from importlib.metadata import version
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import LogVectorOutput, Multiplexer, VectorLogSink

from scara_drake.joints import JOINT_NAMES
from scara_drake.kinematics import forward_kinematics
from scara_drake.operator.trace import STICK_NAMES
from scara_drake.recordings.journal import read_journal
from scara_drake.scenario import Scenario, dump_scenario
from scara_drake.vectors import SERVO_STATE

Array = NDArray[np.float64]

BUNDLE, LOG = "recorded_signals", "recorder"


@dataclass(frozen=True)
class Signal:
    """One variable: the logged signal it is in, its first column there, dims, unit, meaning.

    A variable that is not `always` there is left out where the Diagram does not have its signal.
    """

    source: str
    column: int
    dims: tuple[str, ...]
    units: str
    long_name: str
    always: bool = True


_POSITIONS, _RATES = "m for d1, rad for the others", "m/s for d1, rad/s for the others"
_EFFORTS = "N for d1, N m for the others"
_JOINT, _AXIS = ("joint",), ("axis",)
SIGNALS: dict[str, Signal] = {
    "q_measured": Signal("state", 0, _JOINT, _POSITIONS, "joint positions of the plant"),
    "v_measured": Signal("state", 6, _JOINT, _RATES, "joint rates of the plant"),
    "q_desired": Signal("state_desired", 0, _JOINT, _POSITIONS, "joint position references"),
    "v_desired": Signal("state_desired", 6, _JOINT, _RATES, "joint rate references"),
    "tau_commanded": Signal("actuation_commanded", 0, _JOINT, _EFFORTS, "effort before limits"),
    "tau_applied": Signal("actuation", 0, _JOINT, _EFFORTS, "effort within the limits"),
    "sliding_variable": Signal("sliding_variable", 0, _JOINT, _RATES, "s of equation (27)"),
    "p_WE_measured": Signal("", 0, _AXIS, "m", "tool position of the plant"),
    "p_WE_desired": Signal("servo_state", 0, _AXIS, "m", "tool position of the references"),
    "p_WE_commanded": Signal("tool_command", 0, _AXIS, "m", "tool command before the channel"),
    "f_env_on_tool_W": Signal(
        "f_env_on_tool_W", 0, _AXIS, "N", "force of the surfaces on the tool"
    ),
    "f_haptic": Signal("f_haptic", 0, _AXIS, "N", "that force after the channel"),
    "penetration": Signal("penetration", 0, ("surface",), "m", "depth of the tool in each surface"),
    "rumble": Signal("rumble", 0, ("motor",), "1", "strength of the motors, 0 to 1"),
    "joystick_axes": Signal("joystick_axes", 0, ("stick",), "1", "axes, -1 to 1"),
    "delay_up": Signal("delay_up", 0, (), "s", "delay of the command"),
    "delay_down": Signal("delay_down", 0, (), "s", "delay of the force"),
    "status": Signal(
        "servo_state",
        SERVO_STATE.slices["status"].start,
        (),
        "1",
        "0 tracking, 1 holding, 2 target drawn into reach",
    ),
    "f_kinesthetic": Signal(
        "f_kinesthetic", 0, _AXIS, "N", "force on the hand by a kinesthetic device", False
    ),
    "x_master": Signal("motion_master", 0, _AXIS, "m", "motion of the master's device", False),
    "v_master": Signal("motion_master", 3, _AXIS, "m/s", "rate of the master's device", False),
    "f_master": Signal(
        "f_master", 0, _AXIS, "N", "force of the device, before its actuators' limit", False
    ),
    "f_hand": Signal("f_hand", 0, _AXIS, "N", "force of the hand on the device", False),
    "hand_target": Signal("hand_target", 0, _AXIS, "m", "where the hand wants to be", False),
    "energy_master_in": Signal("energy_master", 0, _AXIS, "J", "taken from the hand", False),
    "energy_master_out": Signal("energy_master", 3, _AXIS, "J", "given to the hand", False),
    "energy_slave_in": Signal("energy_slave", 0, _AXIS, "J", "given back by the slave", False),
    "energy_slave_out": Signal("energy_slave", 3, _AXIS, "J", "given to the slave", False),
    "p_WE_received": Signal(
        "tool_command_received", 0, _AXIS, "m", "tool command after the channel", False
    ),
    "age_up": Signal("age_up", 0, (), "s", "age of the command in use", False),
    "age_down": Signal("age_down", 0, (), "s", "age of the force in use", False),
    "saturation": Signal(
        "saturation", 0, _JOINT, "1", "1 outside the boundary layer, 2 effort limit, 3 both", False
    ),
    "q_governed": Signal(
        "state_desired_governed", 0, _JOINT, _POSITIONS, "references after the governor", False
    ),
    "tau_delivered": Signal(
        "actuation_delivered", 0, _JOINT, _EFFORTS, "effort after the lag of the drives", False
    ),
    "perturbation_estimate": Signal(
        "perturbation_estimate",
        0,
        _JOINT,
        "m/s^2 for d1, rad/s^2 for the others",
        "perturbation seen by the observer",
        False,
    ),
    "v_estimated": Signal(
        "velocity_estimate", 0, _JOINT, _RATES, "joint rates seen by the observer", False
    ),
    "f_estimated_W": Signal(
        "f_estimated_W", 0, _AXIS, "N", "force on the tool without a sensor", False
    ),
}


class SignalBundle(Multiplexer):
    """Stacks the recorded signals into one vector, and knows what they are.

    Input ports: one for each recorded signal, in order.
    Output port: all of them, stacked.
    """

    def __init__(self, sizes: list[int], metadata: dict[str, Any]):
        super().__init__(sizes)
        self.metadata = json.dumps(metadata)  # text, so that nobody can change it in place


def add_recorder(
    builder: DiagramBuilder,
    scenario: Scenario,
    signals: dict[str, OutputPort],
    periods: dict[str, float],
) -> None:
    """Log those of `signals` that `SIGNALS` names; `periods` [s] has those slower than the loop."""
    wanted = {signal.source for signal in SIGNALS.values()}
    signals = {name: port for name, port in signals.items() if name in wanted}
    sizes = [port.size() for port in signals.values()]
    starts = np.cumsum([0, *sizes]).tolist()
    metadata = {
        "columns": dict(zip(signals, pairwise(starts), strict=True)),
        "periods": {name: periods.get(name, scenario.time_step) for name in signals},
        "surfaces": [surface.name for surface in scenario.environment.surfaces],
        "scenario_name": scenario.name,
        "scenario": dump_scenario(scenario),
        "seed": scenario.seed,
        "versions": versions(),
    }
    bundle = builder.AddNamedSystem(BUNDLE, SignalBundle(sizes, metadata))
    for index, port in enumerate(signals.values()):
        builder.Connect(port, bundle.get_input_port(index))
    log = LogVectorOutput(bundle.get_output_port(), builder, scenario.logging.period)
    log.set_name(LOG)


def versions() -> dict[str, str]:
    """Return the versions of what a result depends on."""
    packages = ("scara-drake", "drake", "numpy", "numba")
    return {"python": platform.python_version(), **{name: version(name) for name in packages}}


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
    if not diagram.HasSubsystemNamed(BUNDLE):
        raise ValueError("diagram: no recorder, allowed a Diagram of scara_drake.make_diagram")
    return json.loads(diagram.GetSubsystemByName(BUNDLE).metadata)


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
    return diagram.GetSubsystemByName(LOG)


def to_dataset(description: dict[str, Any], times: Array, values: Array) -> xr.Dataset:
    """Label samples at times (n,) with values (n, width); see `SIGNALS` for the variables.

    A variable whose signal the Diagram does not have is NaN throughout, or left out.
    """
    coordinates: dict[str, Any] = {
        "joint": list(JOINT_NAMES),
        "axis": ["x", "y", "z"],
        "stick": list(STICK_NAMES),
        "motor": ["low", "high"],
        "surface": np.array(description["surfaces"], dtype=str),
    }
    sizes = {dim: len(labels) for dim, labels in coordinates.items()}
    data: dict[str, tuple[tuple[str, ...], Array, dict[str, Any]]] = {}
    for name, signal in SIGNALS.items():
        shape = (times.size, *(sizes[dim] for dim in signal.dims))
        attributes: dict[str, Any] = {"units": signal.units, "long_name": signal.long_name}
        if signal.source in description["columns"]:
            start = description["columns"][signal.source][0] + signal.column
            width = int(np.prod(shape[1:]))
            array = values[:, start : start + width].reshape(shape)
            attributes["period"] = description["periods"][signal.source]
        elif not signal.always:
            continue
        else:
            array = np.full(shape, np.nan)
        data[name] = (("time", *signal.dims), array, attributes)
    for tool, joints in (("p_WE_measured", "q_measured"), ("p_WE_desired", "q_desired")):
        dims, array, attributes = data[tool]
        if SIGNALS[tool].source not in description["columns"]:
            array = forward_kinematics(data[joints][1])[:, :3, 3]
            attributes["period"] = data[joints][2]["period"]
        data[tool] = (dims, array, attributes)
    return xr.Dataset(
        {
            name: (dims, array.copy(), attributes)
            for name, (dims, array, attributes) in data.items()
        },
        coords={"time": ("time", times.copy(), {"units": "s"}), **coordinates},
        attrs={
            "scenario_name": description["scenario_name"],
            "scenario": description["scenario"],
            "seed": description["seed"],
            "versions": json.dumps(description["versions"]),
            "conventions": "SI units; W: world, z up; E: tool frame",
        },
    )


def save_recording(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a recording as NetCDF, whole or not at all.

    It is written under a temporary name beside `path`, then renamed.
    """
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    partial = target.with_name(f".{target.name}.partial")
    try:
        encoding = {name: {"zlib": True, "complevel": 1} for name in dataset.data_vars}
        dataset.to_netcdf(partial, engine="h5netcdf", encoding=encoding)
        os.replace(partial, target)
    finally:
        partial.unlink(missing_ok=True)


def load_recording(path: str | Path) -> xr.Dataset:
    """Read a recording: NetCDF, or the journal of a run that was cut off.

    Raises:
        ValueError: no such file, or not a recording.
    """
    source = Path(path)
    if not source.is_file():
        raise ValueError(f"recording: '{source}', allowed a file that exists")
    if source.suffix == ".journal":
        return to_dataset(*read_journal(source))
    try:
        with xr.open_dataset(source, engine="h5netcdf") as dataset:
            return dataset.load()
    except (OSError, ValueError):
        raise ValueError(f"recording: '{source}', allowed NetCDF written by a run") from None
