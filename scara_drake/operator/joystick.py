"""A joystick operator, live or recorded, and the system that samples it."""

import logging
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scara_drake.common import checks
from scara_drake.common.block import Block
from scara_drake.common.fields import choice, number
from scara_drake.common.resources import resource
from scara_drake.operator.devices import (
    OPENERS,
    AxisMap,
    Device,
    NoDeviceError,
    WallClock,
    Wanted,
    find_device,
)
from scara_drake.operator.devices.profiles import load_profile, profile_names
from scara_drake.operator.live_stick import LiveStick
from scara_drake.operator.mapping import JoystickMapping, initial_command
from scara_drake.operator.played_trace import check_trace, played
from scara_drake.operator.trace import Trace, load_operator
from scara_drake.operator.trace_columns import by_default

Array = NDArray[np.float64]
TraceArrays: TypeAlias = tuple[ArrayLike, ArrayLike] | Trace

LENT = "station"  # of a device that the program lends
DEVICES = ("trace", "auto", *OPENERS, LENT)

LOG = logging.getLogger("scara_drake")


@dataclass
class Joystick:
    """A joystick operator.

    Attributes:
        device: "trace" plays a recorded CSV file, "auto" reads a joystick or SpaceMouse if one is
            plugged in and plays the trace otherwise, the others read a live device of that kind.
            "station" is the page of `scara-drake station`, which asks for it itself.
        index: of the live device, where there are several.
        profile: of the live device, which says what its axes and buttons do: the name of a shipped
            one, a YAML file, or empty for what its model is known for.
        axes: of a joystick: which of them is which, in place of the profile's.
        trace: the CSV file, or the name of a shipped one.
        trace_from_first_row: its times count from its first row on, as for Unix times.
        sample_period: of the stick.
        mapping: from the stick to the tool.
    """

    device: str = choice("trace", DEVICES)
    index: int = number(0, "1", 0, 31)
    profile: str = ""
    axes: AxisMap = field(default_factory=AxisMap)
    trace: str = "operator_trace.csv"
    trace_from_first_row: bool = False
    sample_period: float = number(0.01, "s", 1e-3, 0.1)
    mapping: JoystickMapping = field(default_factory=JoystickMapping)

    def check_together(self, name: str) -> None:
        """Check the trace file where it is to be played, and the profile if it is named.

        Raises:
            ValueError: there is none, or something in it is wrong; names the line and the column,
                or the field.
        """
        if self.profile:
            load_profile(self.profile)
        if self.device in ("trace", "auto"):
            path = self.trace_path()
            if not path.is_file():
                raise ValueError(f"{name}.trace: '{self.trace}', allowed a CSV file that exists")
            load_operator(path, self.trace_from_first_row)

    @property
    def is_live(self) -> bool:
        """Whether a run depends on somebody at a device, so that the next one differs."""
        return self.device != "trace"

    def found_from(self, folder: Path) -> "Joystick":
        """Return the part such that a scenario in `folder` finds the files that it uses now."""
        part = self
        if self._profile_is_file():
            part = replace(part, profile=str(Path(self.profile).resolve()))
        trace = self.trace_path().resolve()
        if self.is_live or (trace == self._shipped() and not (folder / self.trace).is_file()):
            return part  # a shipped one is found by its name, wherever the package is
        return replace(part, trace=str(trace))

    def first_command(self) -> NDArray[np.float64]:
        """Return the tool command (8,) of the centred stick, see `initial_command`."""
        return initial_command(self.mapping)

    def resolve_files(self, folder: Path) -> None:
        """Take a trace and a profile beside the scenario's file, if they are there."""
        beside = folder / self.trace
        if beside.is_file() and beside.resolve() != self._shipped():
            self.trace = str(beside)
        if self._profile_is_file() and (folder / self.profile).is_file():
            self.profile = str(folder / self.profile)

    def _profile_is_file(self) -> bool:
        return bool(self.profile) and self.profile not in profile_names()

    def trace_path(self) -> Path:
        """Return the trace file: as named, or the shipped one of that name."""
        path = Path(self.trace)
        return path if path.is_file() else self._shipped() or path

    def _shipped(self) -> Path | None:
        path = resource("diagrams") / self.trace
        return path.resolve() if path.is_file() else None

    def lend(self, device: Device) -> None:
        """Let runs read a device that the program has."""
        self.device, self._lent = LENT, device

    def open_device(self) -> Device | None:
        """Open the live device, or return None where the trace is to be played.

        It is also played, and a warning says so, where this machine can have no such device.

        Raises:
            ValueError: the device asked for is not there, or its profile does not fit, or it is
                "station" and there is none.
        """
        if not self.is_live:
            return None
        if self.device == LENT:
            lent: Device | None = getattr(self, "_lent", None)
            if lent is None:
                raise ValueError(f"operator.device: {LENT}, allowed with `scara-drake station`")
            return lent
        wanted = Wanted(self.index, self.profile, self.axes)
        try:
            return find_device(wanted) if self.device == "auto" else OPENERS[self.device](wanted)
        except NoDeviceError as error:
            LOG.warning(
                "operator.device: %s, but %s; the recorded operator plays", self.device, error
            )
            return None

    def make_source(self, device: Device | None, supervised: bool = False) -> "JoystickSource":
        """Return the source that samples the device, or plays the trace where it is None.

        Args:
            device: opened.
            supervised: the source has the ports of buttons and status even where the trace has no
                columns of them; see `JoystickSource`.
        """
        if device is not None:
            return JoystickSource(device, self.sample_period)
        path = self.trace_path()
        trace = load_operator(path, self.trace_from_first_row)
        silent = trace.said is None
        if supervised and silent:
            trace = trace._replace(said=by_default(len(trace.times)))
        source = JoystickSource(trace, self.sample_period, f"trace {path.name}")
        source.says_buttons = not silent
        return source


class JoystickSource(Block):
    """Samples a joystick every `period` [s]; between samples it holds.

    Ports:
        output joystick_axes (5): x, y, z, mast_axis, mast_hat, each in [-1, 1].
        output orientation_axes (3): roll, pitch, yaw, each in [-1, 1].
        output operator_buttons (6): 0 or 1, see `vectors.OperatorButtons`.
        output device_connected (1): 1 while the device is there, else 0.
        output device_status (4): that, its age, the lateness, and how many samples were bad.
        output live_settings (5): what the operator changes during a run.

    A trace has all but the first only if it has columns of them (`trace.load_operator`).

    Update of a trace, at t = k period, with r(t) its last row not later than t (before its first
    row, that row)::

        y <- clip(r(t), -1, 1)   where all of r(t) is finite; y is held otherwise

    Update of a device, at t = k period: a sample with anything that is not finite, or an axis
    beyond ±1.05, is dropped: every port holds what it had, and ``bad_samples`` counts how many were
    so in a row, for the supervisor to judge. Of a good one, an axis counts only once it has been
    where y is, and a lost device stops what moves, with no button down, see `live_stick`. The age
    is that of `Sample.stamp` on the clock at the update, the lateness what the pacing of the run
    has written into `clock`.

    Initial: the first row of the trace; of a device zeros, there, and neutral settings. The sample
    of time t is on the port right after t.

    Args:
        source: a device, or a trace: the arrays times (n,) [s], axes (n, 5) and, if it has more,
            those further columns (n, 18).
        period: [s].
        name: of a trace, for the recording; a device has its own.

    Attributes:
        device_name: what the axes come from.
        says_buttons: they are those of somebody, not what stands for them where a trace has none.
        clock: beside a device; None for a trace.

    Raises:
        ValueError: a trace of other shapes, or times that are not finite and increasing; a period
            not between 0.1 ms and 1 s; at run time, a device whose sample has other shapes.
    """

    def __init__(
        self, source: Device | TraceArrays, period: float = 0.01, name: str = "trace"
    ) -> None:
        checks.number("period", period, 1e-4, 1.0)
        self.clock: WallClock | None = None
        self._device: Device | None = None
        if isinstance(source, tuple):
            declaration = played(check_trace(*source), period)
        else:
            self.clock = WallClock()
            declaration = LiveStick(source, self.clock).declaration(period)
            self._device, name = source, source.name
        super().__init__(declaration)
        self.device_name, self.says_buttons = name, True

    def close(self) -> None:
        """Let go of the device, if there is one: its motors stop. Call it after the last run."""
        if self._device is not None:
            self._device.close()
