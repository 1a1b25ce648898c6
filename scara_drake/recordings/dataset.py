"""The labelled dataset of logged samples."""

from __future__ import annotations

import json
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.joints import JOINT_NAMES, JOINT_UNITS
from scara_drake.kinematics import forward_kinematics
from scara_drake.recordings.signals import JOINT_QUANTITIES, SIGNALS
from scara_drake.vectors import BUTTON_NAMES, ORIENTATION_NAMES, STICK_NAMES

Array = NDArray[np.float64]
TIME: Final = {"units": "s", "long_name": "time since the start of the run"}
BY_DURATION: Final = "duration"
Notes = dict[str, str | int | float]  # attributes of a recording
Variable = tuple[tuple[str, ...], Array, dict[str, Any]]  # dims, values, attributes


FORMAT_VERSION: Final = 2
# Times are written as the decimals they are meant to be: 9 ticks of 1 ms are 0.009 s.
DECIMALS: Final = 9
# Dimensions that only a supervised operator has.
SUPERVISED: Final = ("rotation", "button")


def with_notes(description: dict[str, Any], notes: Notes | None) -> dict[str, Any]:
    """Return what the recorder says of itself with further attributes of the recording."""
    if not notes:
        return description
    return {**description, "notes": {**description.get("notes", {}), **notes}}


def to_dataset(
    description: dict[str, Any],
    times: Array,
    values: Array,
    ended_by: str = "",
    ended_at: float | None = None,
) -> xr.Dataset:
    """Label samples at times (n,) with values (n, width); see `SIGNALS` for the variables.

    A variable whose signal the Diagram does not have is NaN throughout, or left out; so is what is
    of each surface where there is none.

    Args:
        description: what the recorder says of itself.
        times: [s].
        values: of the signals, stacked.
        ended_by: what ended the run; if "", the duration or, before that, whoever stepped it.
        ended_at: when [s]; the time of the last sample if None.
    """
    if ended_at is None:
        ended_at = float(times[-1]) if times.size else 0.0
    if not ended_by:
        ended_by = BY_DURATION if ended_at >= description["duration"] - 1e-9 else "its simulator"
    coordinates: dict[str, Any] = {
        "joint": list(JOINT_NAMES),
        "axis": ["x", "y", "z"],
        "stick": list(STICK_NAMES),
        "motor": ["low", "high"],
        "rotation": list(ORIENTATION_NAMES),
        "button": list(BUTTON_NAMES),
    }
    if description["surfaces"]:
        coordinates["surface"] = list(description["surfaces"])
    sizes = {dim: len(labels) for dim, labels in coordinates.items()}
    for name, quantity in JOINT_QUANTITIES.items():
        coordinates[name] = ("joint", [quantity[unit] for unit in JOINT_UNITS])
    data = _variables(description, sizes, values)
    for dim in SUPERVISED:
        if not any(dim in dims for dims, _, _ in data.values()):
            del coordinates[dim]
    _add_tool_positions(description, data)
    return xr.Dataset(
        {
            name: (dims, array.copy(), attributes)
            for name, (dims, array, attributes) in data.items()
        },
        coords={"time": ("time", np.round(times, DECIMALS), TIME), **coordinates},
        attrs={
            "scenario_name": description["scenario_name"],
            "scenario": description["scenario"],
            "seed": description["seed"],
            "versions": json.dumps(description["versions"]),
            "ended_by": ended_by,
            "ended_at": round(ended_at, DECIMALS),
            "Conventions": "CF-1.11",
            "format_version": FORMAT_VERSION,
            "comment": "SI units; W: world, z up; E: tool frame",
            **description.get("notes", {}),
        },
    )


def _variables(
    description: dict[str, Any], sizes: dict[str, int], values: Array
) -> dict[str, Variable]:
    data: dict[str, Variable] = {}
    for name, signal in SIGNALS.items():
        if not sizes.keys() >= set(signal.dims):
            continue
        shape = (len(values), *(sizes[dim] for dim in signal.dims))
        attributes: dict[str, Any] = {"long_name": signal.long_name}
        # The joints have different units: they are in a coordinate, and no library is misled.
        differ = signal.units in JOINT_QUANTITIES
        attributes["units_in" if differ else "units"] = signal.units
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
    return data


def _add_tool_positions(description: dict[str, Any], data: dict[str, Variable]) -> None:
    """Work out where the tool is from the joints, where no signal says so."""
    for tool, joints in (("p_WE_measured", "q_measured"), ("p_WE_desired", "q_desired")):
        if SIGNALS[tool].source not in description["columns"]:
            dims, _, attributes = data[tool]
            _, q, of_joints = data[joints]
            position = forward_kinematics(q)[:, :3, 3]
            data[tool] = (dims, position, {**attributes, "period": of_joints["period"]})
