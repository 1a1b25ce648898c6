"""The operator: a joystick, live or recorded, and how its axes become tool poses."""

from dataclasses import dataclass, field
from pathlib import Path

from scara_drake.common import checks
from scara_drake.common.resources import resource
from scara_drake.teleop.devices import Device, PygameDevice, find_device
from scara_drake.teleop.joystick import JoystickSource
from scara_drake.teleop.mapping import JoystickMapping
from scara_drake.teleop.trace import load_trace

DEVICES = ("trace", "auto", "joystick")


@dataclass
class Joystick:
    """A joystick operator.

    device: "trace" plays a recorded CSV file, "joystick" reads a live device, and "auto" reads a
    live device if one is plugged in, and plays the trace otherwise.
    """

    device: str = "trace"
    index: int = 0
    trace: str = "operator_trace.csv"
    sample_period: float = 0.01  # [s]
    mapping: JoystickMapping = field(default_factory=JoystickMapping)

    def validate(self, name: str) -> None:
        """Check the fields, and the trace file where it is to be played.

        Raises:
            ValueError: one line that names the field, its value and what is allowed.
        """
        checks.choice(f"{name}.device", self.device, DEVICES)
        checks.number(f"{name}.index", self.index, 0, 31)
        checks.number(f"{name}.sample_period", self.sample_period, 1e-3, 0.1)
        self.mapping.validate(f"{name}.mapping")
        if self.device != "joystick":
            if not self.trace_path().is_file():
                raise ValueError(f"{name}.trace: '{self.trace}', allowed a CSV file that exists")
            load_trace(self.trace_path())

    def resolve(self, folder: Path) -> None:
        """Take a trace beside the scenario's file, if there is one, in place of a shipped one."""
        beside = folder / self.trace
        if beside.is_file() and beside.resolve() != self._shipped():
            self.trace = str(beside)

    def trace_path(self) -> Path:
        """Return the trace file: as named, or the shipped one of that name."""
        path = Path(self.trace)
        return path if path.is_file() else self._shipped() or path

    def _shipped(self) -> Path | None:
        path = resource("diagrams") / self.trace
        return path.resolve() if path.is_file() else None

    def open_device(self) -> Device | None:
        """Open the live device, or return None where the trace is to be played.

        Raises:
            ValueError: device is "joystick" and there is none of this index.
        """
        if self.device == "joystick":
            return PygameDevice(self.index)
        return find_device() if self.device == "auto" else None

    def make_source(self, device: Device | None) -> JoystickSource:
        """Return the source that samples the device, or plays the trace where it is None."""
        source = load_trace(self.trace_path()) if device is None else device
        return JoystickSource(source, self.sample_period)
