r"""How a bilateral system feels by hand: effort transparency, displayed stiffness, backdrivability.

The UK's laboratory for remote handling compares two nuclear-rated systems by these three (Tugal and
others, "Nuclear bilateral telerobotic systems", Robotica, 2024) and says that no standard exists.
From that work are two definitions: effort transparency is how accurately forces are handed on
between the two manipulators, and a system can be driven back if what moves the remote manipulator
moves the local one. How each is worked out from a recording is ours:

- effort transparency: the force at the master over that at the tool when it was sent, by least
  squares through zero over the contact, and what of it that leaves unexplained;
- displayed stiffness: k in :math:`f = k x + b v + c` at the master, by least squares while the
  touch is felt, along the mean force. With a rigid wall it is that of the system itself;
- backdrivability: the way of the master over that of the tool, by least squares while something
  pushes the tool and the hand only holds; and what the operator has to bear in free space, b and m
  in :math:`f = b v + m \dot v` at the master.

The force at the master is what is asked of the device, before the limit of its actuators.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.metrics.bilateral import age_of_information, as_received, force_sent, tool_way

Array = NDArray[np.float64]

LEAST: Final = 20  # samples of a regression
CONDITION: Final = 1e6  # of its columns, scaled: beyond it they cannot be told apart


class Transparency(NamedTuple):
    """How the effort at the tool is handed on.

    Attributes:
        ratio: of the force at the master to that at the tool; 1 is all of it.
        unexplained: share of the squared force at the master that the ratio leaves over.
    """

    ratio: float
    unexplained: float


class Felt(NamedTuple):
    """What the master shows of a contact.

    Attributes:
        stiffness: [N/m].
        damping: [N s/m].
        unexplained: share of the variance of the force that both leave over.
    """

    stiffness: float
    damping: float
    unexplained: float


class Backdrive(NamedTuple):
    """What becomes of a push at the tool.

    Attributes:
        ratio: way of the master over that of the tool; 1 is all of it, 0 none.
        effort: mean force on the tool while it is pushed, in the master's units [N].
    """

    ratio: float
    effort: float


class Resistance(NamedTuple):
    """What moving the master takes where nothing is touched.

    Attributes:
        damping: force over velocity [N s/m].
        mass: force over acceleration [kg].
    """

    damping: float
    mass: float


def effort_transparency(recording: xr.Dataset, force_scale: float = 1.0) -> Transparency:
    """Return the force at the master over that at the tool, delay removed, in the master's units.

    Raises:
        ValueError: nothing was touched.
    """
    sent = force_sent(recording, force_scale).values
    touched = _touched(sent)
    x, y = sent[touched], recording.f_master.transpose("time", "axis").values[touched]
    ratio = float((x * y).sum() / (x * x).sum())
    shown = float((y * y).sum())
    left = float(((y - ratio * x) ** 2).sum())
    return Transparency(ratio, left / shown if shown > 0.0 else 0.0)


def displayed_stiffness(recording: xr.Dataset) -> Felt:
    """Return what the coupling shows at the master of a contact, without the device.

    Raises:
        ValueError: nothing was touched, or the master hardly moved while it was.
    """
    sent = force_sent(recording).values
    felt = recording.isel(time=np.flatnonzero(_touched(sent)))
    along = _direction(felt.f_master)
    x, v, f = (_along(felt[name], along) for name in ("x_master", "v_master", "f_master"))
    stiffness, damping, constant = _least_squares([x, v, np.ones(x.size)], f)
    spread = float(np.var(f))
    left = float(np.var(f - stiffness * x - damping * v - constant))
    return Felt(stiffness, damping, left / spread if spread > 0.0 else 0.0)


def backdrivability(
    recording: xr.Dataset, position_scale: float = 1.0, force_scale: float = 1.0
) -> Backdrive:
    """Return what becomes of a push at the tool, of a run in which the hand only holds.

    Raises:
        ValueError: nothing was touched, or the tool did not move while it was.
    """
    sent = force_sent(recording, force_scale).values
    touched = _touched(sent)
    age = age_of_information(recording, "down")
    pushed = as_received(tool_way(recording, position_scale), age).values[touched]
    followed = recording.x_master.transpose("time", "axis").values[touched]
    along = _direction(xr.DataArray(sent[touched], dims=("time", "axis")))
    ratio, _ = _least_squares([pushed @ along, np.ones(len(pushed))], followed @ along)
    return Backdrive(ratio, float(np.linalg.norm(sent[touched], axis=1).mean()))


def free_resistance(recording: xr.Dataset) -> Resistance:
    """Return the force of the coupling in free motion over velocity and acceleration.

    Only what comes before the first contact, as felt at the master, counts.

    Raises:
        ValueError: something is touched from the start, or the master does not move before.
    """
    touched = np.linalg.norm(force_sent(recording).values, axis=1) > 0.0
    end = int(np.argmax(touched)) if touched.any() else touched.size
    if end < LEAST:
        raise ValueError(f"recording: {end} samples before the contact, allowed {LEAST} or more")
    v = recording.v_master.transpose("time", "axis").values[:end]
    f = recording.f_master.transpose("time", "axis").values[:end]
    a = np.gradient(v, recording.time.values[:end], axis=0)
    damping, mass = _least_squares([v.ravel(), a.ravel()], f.ravel())
    return Resistance(damping, mass)


def _touched(sent: Array) -> NDArray[np.bool_]:
    touched = np.asarray(np.linalg.norm(sent, axis=1) > 0.0)
    if touched.sum() < LEAST:
        raise ValueError(f"recording: {touched.sum()} samples in contact, allowed {LEAST} or more")
    return touched


def _direction(force: xr.DataArray) -> Array:
    """Unit vector (3,) of a mean force."""
    mean = force.mean("time").values
    size = float(np.linalg.norm(mean))
    if size == 0.0:
        raise ValueError("recording: no force on average, allowed one that the hand feels")
    return np.asarray(mean / size)


def _along(signal: xr.DataArray, direction: Array) -> Array:
    return np.asarray(signal.transpose("time", "axis").values @ direction)


def _least_squares(columns: list[Array], wanted: Array) -> list[float]:
    """Coefficients of the columns.

    Raises:
        ValueError: they cannot be told apart.
    """
    matrix = np.stack(columns, axis=-1)
    sizes = np.linalg.norm(matrix, axis=0)
    if not (sizes > 0.0).all() or np.linalg.cond(matrix / sizes) > CONDITION:
        raise ValueError("recording: the master hardly moves, allowed one that is moved")
    found = np.linalg.lstsq(matrix / sizes, wanted, rcond=None)[0] / sizes
    return [float(each) for each in found]
