"""The labelled dataset of logged samples."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.joints import JOINT_NAMES
from scara_drake.kinematics import forward_kinematics
from scara_drake.recordings.signals import SIGNALS
from scara_drake.vectors import STICK_NAMES

Array = NDArray[np.float64]
Variable = tuple[tuple[str, ...], Array, dict[str, Any]]  # dims, values, attributes


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
    data = _variables(description, sizes, values)
    _add_tool_positions(description, data)
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
            "device": description.get("device", ""),
            "versions": json.dumps(description["versions"]),
            "conventions": "SI units; W: world, z up; E: tool frame",
        },
    )


def _variables(
    description: dict[str, Any], sizes: dict[str, int], values: Array
) -> dict[str, Variable]:
    data: dict[str, Variable] = {}
    for name, signal in SIGNALS.items():
        shape = (len(values), *(sizes[dim] for dim in signal.dims))
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
    return data


def _add_tool_positions(description: dict[str, Any], data: dict[str, Variable]) -> None:
    """Work out where the tool is from the joints, where no signal says so."""
    for tool, joints in (("p_WE_measured", "q_measured"), ("p_WE_desired", "q_desired")):
        if SIGNALS[tool].source not in description["columns"]:
            dims, _, attributes = data[tool]
            _, q, of_joints = data[joints]
            position = forward_kinematics(q)[:, :3, 3]
            data[tool] = (dims, position, {**attributes, "period": of_joints["period"]})
