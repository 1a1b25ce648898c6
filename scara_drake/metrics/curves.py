"""What is shown of a run over time, under which name and in which unit: in tables and in plots."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final, NamedTuple

import xarray as xr

from scara_drake.joints import JOINT_NAMES
from scara_drake.metrics.bilateral import age_of_information, vector_size
from scara_drake.metrics.command import command_error
from scara_drake.metrics.noticed import force_jnds
from scara_drake.metrics.offsets import force_offsets, tool_offsets
from scara_drake.metrics.scales import scales_of
from scara_drake.metrics.tracking import contact_force, tool_error

SETTLING: Final = 1.0  # [s], left out of the figures: the drives take up the weight


class Curve(NamedTuple):
    """A quantity over time that a recording may have.

    Attributes:
        name: of the quantity.
        unit: in which it is shown.
        scale: what is shown over its value in SI units.
        needs: variables that it is worked out from.
        of: gives it (time), in SI units.
    """

    name: str
    unit: str
    scale: float
    needs: tuple[str, ...]
    of: Callable[[xr.Dataset], xr.DataArray]

    def shown(self, recording: xr.Dataset) -> xr.DataArray | None:
        """Return it (time) in its unit; None where the recording does not have it."""
        if not all(name in recording for name in self.needs):
            return None
        try:
            curve = self.of(recording)
        except (LookupError, ValueError):  # no such joint, or too short, or not of a run
            return None
        return self.scale * curve if bool(curve.notnull().any()) else None


def settled(recording: xr.Dataset) -> xr.Dataset:
    """Return a recording from `SETTLING` on, or the whole of one that is too short for that."""
    rest = recording.sel(time=slice(SETTLING, None))
    return rest if rest.sizes["time"] >= 2 else recording


def _joint_error(recording: xr.Dataset, joint: str) -> xr.DataArray:
    both = recording[["q_desired", "q_measured"]].sel(joint=joint)
    return both.q_desired - both.q_measured


def _of_joint(recording: xr.Dataset, joint: str, name: str) -> xr.DataArray:
    return recording[name].sel(joint=joint)


def _size(recording: xr.Dataset, name: str) -> xr.DataArray:
    return (recording[name] ** 2).sum("axis", skipna=False) ** 0.5


def _deepest(recording: xr.Dataset) -> xr.DataArray:
    return recording.penetration.max("surface").clip(min=0.0)


def _tool_offset(recording: xr.Dataset, name: str) -> xr.DataArray:
    found = tool_offsets(recording, scales_of(recording).position)[name]
    return vector_size(found) if "axis" in found.dims else found


def _force_offset(recording: xr.Dataset, name: str) -> xr.DataArray:
    found = force_offsets(recording, scales_of(recording).force)[name]
    return vector_size(found) if "axis" in found.dims else found


def _force_jnds(recording: xr.Dataset) -> xr.DataArray:
    return force_jnds(recording, scales_of(recording).force)


def _of_joints(
    what: str,
    units: tuple[str, str],
    scale: float,
    needs: tuple[str, ...],
    values: Callable[..., xr.DataArray],
) -> tuple[Curve, ...]:
    """Return a curve a joint: units of the mast's and of the others', values by `joint`."""
    return tuple(
        Curve(f"{joint} {what}", units[joint != "d1"], scale, needs, partial(values, joint=joint))
        for joint in JOINT_NAMES
    )


_TOOL = ("p_WE_measured",)
JOINT_ERRORS: Final = _of_joints(
    "error", ("mm", "mrad"), 1e3, ("q_desired", "q_measured"), _joint_error
)
SLIDING_VARIABLES: Final = _of_joints(
    "sliding variable",
    ("m/s", "rad/s"),
    1.0,
    ("sliding_variable",),
    partial(_of_joint, name="sliding_variable"),
)
EFFORTS: Final = _of_joints(
    "effort", ("N", "N m"), 1.0, ("tau_applied",), partial(_of_joint, name="tau_applied")
)
TOOL_ERROR: Final = Curve(
    "tool from its reference", "mm", 1e3, ("p_WE_desired", *_TOOL), tool_error
)
COMMAND_ERRORS: Final = (
    Curve(
        "tool from the delayed command",
        "mm",
        1e3,
        ("p_WE_commanded", "delay_up", *_TOOL),
        command_error,
    ),
    Curve(
        "tool from the command as sent",
        "mm",
        1e3,
        ("p_WE_commanded", *_TOOL),
        partial(command_error, delayed=False),
    ),
)
CONTACT_FORCE: Final = Curve("contact force", "N", 1.0, ("f_env_on_tool_W",), contact_force)
PENETRATION: Final = Curve("penetration", "mm", 1e3, ("penetration",), _deepest)
FELT_FORCES: Final = (
    Curve("force after the channel", "N", 1.0, ("f_haptic",), partial(_size, name="f_haptic")),
    Curve("force of the device", "N", 1.0, ("f_master",), partial(_size, name="f_master")),
)
AGES: Final = tuple(
    Curve(
        f"age of what came {link}",
        "ms",
        1e3,
        (f"delay_{link}",),
        partial(age_of_information, link=link),
    )
    for link in ("up", "down")
)
_MOVED: Final = ("x_master", "delay_up", "f_env_on_tool_W", *_TOOL)
_SHOWN: Final = ("f_master", "delay_down", "f_env_on_tool_W")
TOOL_OFFSETS: Final = tuple(
    Curve(name, unit, 1e3, _MOVED, partial(_tool_offset, name=variable))
    for name, unit, variable in (
        ("time offset of the tool", "ms", "time_offset"),
        ("value offset of the tool", "mm", "value_offset"),
    )
)
FORCE_OFFSETS: Final = tuple(
    Curve(name, unit, scale, _SHOWN, partial(_force_offset, name=variable))
    for name, unit, scale, variable in (
        ("time offset of the force", "ms", 1e3, "time_offset"),
        ("value offset of the force", "N", 1.0, "value_offset"),
    )
)
FORCE_JNDS: Final = Curve("force error, delay removed", "JND", 1.0, _SHOWN, _force_jnds)
