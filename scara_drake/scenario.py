"""A scenario describes one runnable Diagram; it is read from YAML and checked before anything runs.

Each part is a dataclass that lives with its subject and checks itself. A part with several kinds
(operator, delay, controller) is a union chosen by a YAML tag: a new kind is one file, and one entry
in its union here.
"""

import copy
import dataclasses
import typing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from pydrake.common.yaml import yaml_dump, yaml_dump_typed, yaml_load, yaml_load_typed

from scara_drake import joints
from scara_drake.channel.links import Channel
from scara_drake.common import checks, fields
from scara_drake.common.fields import check
from scara_drake.common.resources import resource
from scara_drake.common.schema import alternatives, check_schema
from scara_drake.control.governor import ReferenceGovernor
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.inverse_dynamics import InverseDynamics
from scara_drake.control.observer_sliding_mode import ObserverSlidingMode
from scara_drake.control.pid import Pid
from scara_drake.control.process_delay import ProcessDelay
from scara_drake.control.sliding_mode import SlidingMode
from scara_drake.coupling.direct import Direct, ScaledForce
from scara_drake.coupling.model_mediated import ModelMediated
from scara_drake.coupling.position_damping import PositionDamping
from scara_drake.coupling.tdpa import Tdpa
from scara_drake.coupling.wave_variables import WaveVariables
from scara_drake.environment import Environment
from scara_drake.ik.system import FOLLOWERS, InverseKinematics
from scara_drake.operator.haptics import HapticMapping
from scara_drake.operator.joint_motion import JointMotion
from scara_drake.operator.joystick import Joystick
from scara_drake.operator.kinesthetic import KinestheticMapping
from scara_drake.operator.master import Master
from scara_drake.plant.drives import Drives
from scara_drake.plant.perturbation import JointPerturbation
from scara_drake.robot import RobotModel

Coupling = Direct | ScaledForce | PositionDamping | WaveVariables | Tdpa | ModelMediated
Controller = IntegralSlidingMode | ObserverSlidingMode | SlidingMode | Pid | InverseDynamics


@dataclass
class Logging:
    """What a run records."""

    period: float = 1e-3  # [s]

    def validate(self, name: str) -> None:
        """Check the period.

        Raises:
            ValueError: the period is not between 1 ms and 1 s.
        """
        checks.number(f"{name}.period", self.period, 1e-3, 1.0)


@dataclass
class Scenario:
    """One runnable Diagram, in SI units.

    With a `Joystick` operator the command crosses `channel` to `inverse_kinematics`, and the
    contact force returns over it to `haptics`. With a `JointMotion` the references go straight to
    the controller and those three parts stay unused.
    """

    name: str = ""
    description: str = ""
    duration: float = 10.0  # [s]
    seed: int = 0
    time_step: float = 1e-3  # [s], of the plant and of every block of the 1 kHz loop
    q0: list[float] | None = None  # [m], [rad]; None: where the first reference is
    operator: Joystick | Master | JointMotion = field(default_factory=Joystick)
    coupling: Coupling = field(default_factory=Tdpa)
    channel: Channel = field(default_factory=Channel)
    inverse_kinematics: InverseKinematics = field(default_factory=InverseKinematics)
    controller: Controller = field(default_factory=IntegralSlidingMode)
    governor: ReferenceGovernor | None = None
    process_delay: ProcessDelay | None = None
    robot: RobotModel = field(default_factory=RobotModel)
    drives: Drives = field(default_factory=Drives)
    perturbation: JointPerturbation | None = None
    environment: Environment = field(default_factory=Environment)
    haptics: HapticMapping = field(default_factory=HapticMapping)
    kinesthetic: KinestheticMapping | None = None
    logging: Logging = field(default_factory=Logging)

    def validate(self) -> None:
        """Check every number against its bounds.

        Raises:
            ValueError: one line that names the field, its value and what is allowed.
        """
        checks.number("duration", self.duration, self.time_step, 86400.0)
        checks.number("seed", self.seed, 0, 2**63 - 1)
        checks.number("time_step", self.time_step, 1e-4, 2e-3)
        if self.q0 is not None:
            joints.check_configuration("q0", self.q0)
        for part in dataclasses.fields(self):
            value = getattr(self, part.name)
            if dataclasses.is_dataclass(value):
                check(value, part.name)
        self._check_together()
        # A controller of the user's own need not have a rule about its sampling.
        check_sampling = getattr(self.controller, "check_sampling", None)
        if check_sampling is not None:
            check_sampling("controller", self.time_step)
        fields.check_sampling(self.drives, "drives", self.time_step)
        self.channel.check_sampling("channel", self.time_step)

    def _check_together(self) -> None:
        if "/" in self.name or self.name.startswith("."):
            raise ValueError(f"name: '{self.name}', allowed a word without '/'")
        if self.kinesthetic is not None and not isinstance(self.operator, Joystick):
            raise ValueError("kinesthetic: set, allowed with a Joystick only")
        if not isinstance(self.operator, Master):
            return
        if self.governor is not None:
            raise ValueError(
                "governor: set, allowed without a Master only: its coupling has to see every limit "
                "of the motion, and the governor comes after it"
            )
        checks.choice("inverse_kinematics.method", self.inverse_kinematics.method, FOLLOWERS)

    def stream(self, index: int) -> int:
        """Return the seed of one of up to four systems that draw random numbers."""
        return 4 * (self.seed % 2**60) + index


def load_scenario(name_or_path: str | Path, overrides: dict[str, Any] | None = None) -> Scenario:
    """Load a scenario by the name of a shipped one or by the path of a YAML file, and check it.

    Args:
        name_or_path: such as ``"teleoperation"`` or ``"my/press.yaml"``.
        overrides: dotted keys to values, such as ``{"controller.phi": 0.5}``. A number or a
            word given for a list sets every entry; a string is read as YAML, so tags such as
            ``"!SineDelay {}"`` choose another kind of part.

    Raises:
        ValueError: no such scenario, unknown key, wrong type, or a number out of its bounds.
    """
    path = _find(name_or_path)
    try:
        data = yaml_load(filename=str(path), private=True)
    except yaml.YAMLError as error:
        raise ValueError(f"{path.name}: not YAML, {_one_line(error)}") from None
    if not isinstance(data, dict):
        raise ValueError(f"{path.name}: {type(data).__name__}, allowed a map of scenario fields")
    for key, value in (overrides or {}).items():
        _override(data, key, value)
    check_schema(Scenario, data, "")
    try:
        scenario = yaml_load_typed(schema=Scenario, data=yaml_dump(data))
    except (RuntimeError, ValueError, TypeError) as error:
        raise ValueError(f"{path.name}: {_one_line(error)}") from None
    scenario.name = scenario.name or path.stem
    if isinstance(scenario.operator, Joystick):
        scenario.operator.resolve(path.parent)
    scenario.validate()
    return scenario


def dump_scenario(scenario: Scenario) -> str:
    """Return the YAML text of a scenario; loading it gives an equal scenario.

    A part of a kind that is not in the unions above, such as a controller of your own, is written
    under its own tag: the text says what ran, but does not load.
    """
    hints: list[tuple[str, Any]] = []
    for name, hint in typing.get_type_hints(Scenario).items():
        kind = type(getattr(scenario, name))
        own = dataclasses.is_dataclass(kind) and kind not in alternatives(hint)
        hints.append((name, hint | kind if own else hint))
    return yaml_dump_typed(scenario, schema=dataclasses.make_dataclass("Written", hints))


def parse_overrides(settings: list[str]) -> dict[str, Any]:
    """Return the overrides of texts such as "controller.phi=0.5", for `load_scenario`.

    Raises:
        ValueError: a text is not KEY=VALUE.
    """
    pairs = {}
    for setting in settings:
        key, equals, value = setting.partition("=")
        if not (key and equals):
            raise ValueError(f"--set: '{setting}', allowed KEY=VALUE")
        pairs[key] = value
    return pairs


def scenario_names() -> list[str]:
    """Return the names of the shipped scenarios."""
    return sorted(path.stem for path in resource("diagrams").glob("*.yaml"))


def _find(name_or_path: str | Path) -> Path:
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml"):
        if not path.is_file():
            raise ValueError(f"scenario: '{path}', allowed a YAML file that exists")
        return path
    checks.choice("scenario", str(name_or_path), scenario_names())
    return resource("diagrams", f"{name_or_path}.yaml")


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())


def _override(data: dict[str, Any], dotted: str, value: Any) -> None:
    """Set one dotted key in the data of a YAML file, in place."""
    if isinstance(value, str):
        try:
            # Of an empty text pydrake would want to know the file.
            value = yaml_load(data=value, private=True) if value.strip() else None
        except yaml.YAMLError as error:
            raise ValueError(f"{dotted}: {value}, not YAML: {_one_line(error)}") from None
    *parents, last = dotted.split(".")
    for parent in parents:
        data = data.setdefault(parent, {})
        if not isinstance(data, dict):
            raise ValueError(f"{dotted}: '{parent}' has no fields, allowed the path of a field")
    data[last] = copy.deepcopy(value)
