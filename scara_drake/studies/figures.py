"""The figures that a study keeps of a run, by name: single numbers with units."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

import numpy as np
import xarray as xr

from scara_drake import metrics
from scara_drake.joints import JOINT_NAMES, JOINT_UNITS
from scara_drake.metrics import bilateral, hand_press
from scara_drake.metrics.manual import (
    backdrivability,
    displayed_stiffness,
    effort_transparency,
    free_resistance,
)
from scara_drake.metrics.noticed import noticed
from scara_drake.metrics.offsets import tool_offsets
from scara_drake.metrics.squared_force import squared_force
from scara_drake.scenario import Scenario


@dataclass(frozen=True)
class Metric:
    """A figure of a run.

    Attributes:
        units: of it.
        long_name: what it is.
        of: the figure of a scenario and its recording; a ValueError says why there is none.
        whole: whether it counts from the start, also where the study counts from later on.
        flag: whether it is 1 for yes and 0 for no.
    """

    units: str
    long_name: str
    of: Callable[[Scenario, xr.Dataset], Any]
    whole: bool = False
    flag: bool = False

    def attributes(self) -> dict[str, Any]:
        """Return what its variable says of itself."""
        flags = {"flag_values": [0.0, 1.0], "flag_meanings": "no yes"} if self.flag else {}
        return {"units": self.units, "long_name": self.long_name, **flags}


def figures_of(
    scenario: Scenario, recording: xr.Dataset, names: Sequence[str], after: float
) -> tuple[list[float], dict[str, str]]:
    """Return the figures of a run, and why those that are NaN are none.

    Args:
        scenario: that was run.
        recording: of it.
        names: of `METRICS`.
        after: figures count from here on [s].
    """
    late = recording.sel(time=slice(after, None))
    values, missing = [], {}
    for name in names:
        metric = METRICS[name]
        value = np.nan
        try:
            value = float(metric.of(scenario, recording if metric.whole else late))
        except (ValueError, LookupError, AttributeError) as error:
            missing[name] = " ".join(str(error).split())[:200]
        if not np.isfinite(value):
            missing.setdefault(name, f"it is {value}")
            value = np.nan
        values.append(value)
    return values, missing


def _joint_error(name: str, scenario: Scenario, recording: xr.Dataset) -> Any:
    return metrics.rmse(metrics.tracking_error(recording).sel(joint=name))


def _largest_angle(scenario: Scenario, recording: xr.Dataset) -> Any:
    return metrics.rmse(metrics.tracking_error(recording)).isel(joint=slice(1, None)).max()


def _scored(recording: xr.Dataset) -> metrics.Score:
    found = metrics.score(recording)
    if found is None:
        raise ValueError("the scenario has no task")
    return found


def _touched(recording: xr.Dataset) -> xr.Dataset:
    if recording.sizes.get("surface", 0) == 0:
        raise ValueError("the scenario has no surface")
    return recording


def _coupled(recording: xr.Dataset) -> xr.Dataset:
    if "x_master" not in recording:
        raise ValueError("the operator is no !Master")
    return recording


def _master(scenario: Scenario) -> Any:
    return scenario.operator


def _coupling(scenario: Scenario) -> Any:
    return scenario.coupling


def _tool_offsets(scenario: Scenario, recording: xr.Dataset) -> xr.Dataset:
    return tool_offsets(_coupled(recording), _coupling(scenario).position_scale)


METRICS: Final[dict[str, Metric]] = {
    "score": Metric(
        "1", "score of its task, 0 to 100", lambda scenario, recording: _scored(recording).total,
        whole=True,
    ),
    "task_time": Metric(
        "s", "until the task was done", lambda scenario, recording: _scored(recording).seconds,
        whole=True,
    ),
    "followed": Metric(
        "1", "whether the arm did what it was told, see `verdict`",
        lambda scenario, recording: metrics.verdict(recording).good, whole=True, flag=True,
    ),
    "tool_error_rms": Metric(
        "m", "tool from its reference, rms",
        lambda scenario, recording: metrics.rmse(metrics.tool_error(recording)),
    ),
    "tool_error_peak": Metric(
        "m", "tool from its reference, largest",
        lambda scenario, recording: metrics.peak(metrics.tool_error(recording)),
    ),
    "tool_error_p95": Metric(
        "m", "tool from its reference, 95 % of the time within",
        lambda scenario, recording: metrics.percentile95(metrics.tool_error(recording)),
    ),
    "joint_error_rms": Metric(
        "rad", "error of the revolute joint that errs most, rms", _largest_angle
    ),
    **{
        f"{name}_error_rms": Metric(unit, f"error of {name}, rms", partial(_joint_error, name))
        for name, unit in zip(JOINT_NAMES, JOINT_UNITS, strict=True)
    },
    "command_error_rms": Metric(
        "m", "tool from the delayed command, rms",
        lambda scenario, recording: metrics.rmse(metrics.command_error(recording)),
    ),
    "saturated_share": Metric(
        "1", "share of the time at the effort limit, of the joint that is there most",
        lambda scenario, recording: metrics.saturated_share(recording.tau_applied).max(),
    ),
    "speed_peak": Metric(
        "1", "speed over the fastest of a joint, largest",
        lambda scenario, recording: metrics.speed_ratio(recording.v_measured).max(),
    ),
    "energy": Metric(
        "J", "energy that passes the drives either way",
        lambda scenario, recording: metrics.energy(
            recording.tau_applied, recording.v_measured
        ).sum(skipna=False),
    ),
    "contact_force_peak": Metric(
        "N", "contact force, largest",
        lambda scenario, recording: metrics.contact_force(_touched(recording)).max(),
    ),
    "contact_force_mean": Metric(
        "N", "contact force, mean",
        lambda scenario, recording: metrics.contact_force(_touched(recording)).mean(),
    ),
    "contact_share": Metric(
        "1", "share of the time in which the tool is touched",
        lambda scenario, recording: bilateral.contact_share(_touched(recording)),
    ),
    "penetration_peak": Metric(
        "m", "depth of the tool in a surface, largest",
        lambda scenario, recording: _touched(recording).penetration.max(),
    ),
    "stable": Metric(
        "1", "the force rests while the hand presses, and nothing but the hand moves the device",
        lambda scenario, recording: hand_press.is_stable(_coupled(recording), _master(scenario)),
        whole=True, flag=True,
    ),
    "force_ripple": Metric(
        "N", "force at the master while the hand presses steadily, standard deviation",
        lambda scenario, recording: bilateral.force_ripple(
            hand_press.steady(_coupled(recording), _master(scenario))
        ), whole=True,
    ),
    "master_force_peak": Metric(
        "N", "force at the master before the limit of its actuators, largest",
        lambda scenario, recording: bilateral.peak_force(_coupled(recording)),
    ),
    "position_error_rms": Metric(
        "m", "tool from master, delay removed, rms",
        lambda scenario, recording: metrics.rmse(
            bilateral.position_error(_coupled(recording), _coupling(scenario).position_scale)
        ),
    ),
    "force_error_rms": Metric(
        "N", "force at the master from that at the tool, delay removed, rms",
        lambda scenario, recording: metrics.rmse(
            bilateral.force_error(_coupled(recording), _coupling(scenario).force_scale)
        ),
    ),
    "force_noticed_share": Metric(
        "1", "share of the time in which the force at the master is wrong by more than one JND",
        lambda scenario, recording: noticed(
            _coupled(recording), _coupling(scenario).force_scale
        ).share,
    ),
    "force_jnd_p95": Metric(
        "1", "force at the master wrong by so many JND, 95 % of the time within",
        lambda scenario, recording: noticed(
            _coupled(recording), _coupling(scenario).force_scale
        ).percentile95,
    ),
    "squared_force": Metric(
        "N2 s", "squared force on the tool, over the time",
        lambda scenario, recording: squared_force(_touched(recording)),
    ),
    "effort_transparency": Metric(
        "1", "force at the master over that at the tool, delay removed",
        lambda scenario, recording: effort_transparency(
            _coupled(recording), _coupling(scenario).force_scale
        ).ratio,
    ),
    "displayed_stiffness": Metric(
        "N/m", "stiffness of the contact that the master shows",
        lambda scenario, recording: displayed_stiffness(_coupled(recording)).stiffness,
    ),
    "free_resistance": Metric(
        "N s/m", "force over velocity at the master before anything is touched",
        lambda scenario, recording: free_resistance(_coupled(recording)).damping, whole=True,
    ),
    "backdrive_ratio": Metric(
        "1", "way of the master over that of the tool while the tool is pushed",
        lambda scenario, recording: backdrivability(
            _coupled(recording), _coupling(scenario).position_scale
        ).ratio,
    ),
    "time_offset_mean": Metric(
        "s", "effective time offset of the tool from the master, mean",
        lambda scenario, recording: _tool_offsets(scenario, recording).time_offset.mean(),
    ),
    "value_offset_rms": Metric(
        "m", "effective value offset of the tool from the master, rms",
        lambda scenario, recording: metrics.rmse(
            bilateral.vector_size(_tool_offsets(scenario, recording).value_offset)
        ),
    ),
    "energy_margin": Metric(
        "J", "least energy left in coupling and channel, with the reserve",
        lambda scenario, recording: bilateral.energy_margin(
            _coupled(recording), _coupling(scenario).reserves()
        ), whole=True,
    ),
}  # fmt: skip
