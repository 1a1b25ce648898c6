"""A scenario describes one runnable Diagram; it is read from YAML and checked before anything runs.

Each part is a dataclass that lives with its subject and checks itself. A part with several kinds
(operator, delay, controller) is a union chosen by a YAML tag: a new kind is one file, and one entry
in its union here.
"""

import re
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scara_drake import joints
from scara_drake.channel.links import Channel
from scara_drake.common import checks
from scara_drake.common.checks import shown
from scara_drake.common.fields import check, check_sampling, number, resolve_files
from scara_drake.common.overrides import override
from scara_drake.common.schema import build, changed_yaml, yaml_of
from scara_drake.common.shipped import find_scenario
from scara_drake.common.shipped import scenario_names as scenario_names
from scara_drake.common.yaml_text import read_yaml
from scara_drake.control.contract import ControllerPart, check_controller
from scara_drake.control.governor import ReferenceGovernor
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.inverse_dynamics import InverseDynamics
from scara_drake.control.observer_sliding_mode import ObserverSlidingMode
from scara_drake.control.pid import Pid
from scara_drake.control.process_delay import ProcessDelay
from scara_drake.control.sliding_mode import SlidingMode
from scara_drake.coupling.direct import Direct, ScaledForce
from scara_drake.coupling.four_channel import FourChannel
from scara_drake.coupling.model_mediated import ModelMediated
from scara_drake.coupling.position_damping import PositionDamping
from scara_drake.coupling.tdpa import Tdpa
from scara_drake.coupling.wave_variables import WaveVariables
from scara_drake.environment import Environment
from scara_drake.ik.system import InverseKinematics
from scara_drake.operator.external import External
from scara_drake.operator.haptics import HapticMapping
from scara_drake.operator.joint_motion import JointMotion
from scara_drake.operator.joystick import Joystick
from scara_drake.operator.kinesthetic import KinestheticMapping
from scara_drake.operator.master import Master
from scara_drake.operator.trainee import Trainee
from scara_drake.plant.drives import Drives
from scara_drake.plant.perturbation import JointPerturbation
from scara_drake.recordings.logging_part import Logging
from scara_drake.robot import RobotModel
from scara_drake.supervision.config import Supervision
from scara_drake.tasks import Task
from scara_drake.wiring.operators import unused_settings, wiring_of

Operator = Joystick | External | Trainee | Master | JointMotion
Coupling = (
    Direct | ScaledForce | PositionDamping | FourChannel | WaveVariables | Tdpa | ModelMediated
)
if TYPE_CHECKING:  # from Python any controller will do; a YAML tag chooses one of these
    Controller = ControllerPart
else:
    Controller = IntegralSlidingMode | ObserverSlidingMode | SlidingMode | Pid | InverseDynamics

# Systems with random numbers of their own; the order decides their seeds.
STREAMS = ("uplink", "downlink", "encoder", "view")


class UnusedSetting(UserWarning):
    """A field was set that does nothing in this scenario."""


@dataclass(repr=False)
class Scenario:
    """One runnable Diagram, in SI units.

    With a `Joystick` or `External` operator the command crosses `channel` to `inverse_kinematics`,
    and the contact force returns over it to `haptics`. With a `JointMotion` the references go
    straight to the controller and those three parts stay unused.

    Attributes:
        name: of the Diagram and the recording; that of the file if empty.
        description: one line.
        duration: of a run.
        seed: of all random numbers.
        time_step: of the plant and of every block of the fast loop.
        q0: posture (6,) at t = 0, d1 [m] and angles [rad]; where the first reference is if empty.
        operator: who commands.
        coupling: of a `Master` and the robot.
        channel: between the operator and the robot.
        inverse_kinematics: from the tool command to joint references.
        controller: of the joints.
        governor: holds the reference back at an effort limit.
        process_delay: delays in the control loop.
        robot: how the robot differs from the nominal one.
        drives: what real drives and sensors add.
        perturbation: forces on the joints.
        environment: surfaces to touch.
        task: what the operator is asked to do.
        haptics: from the force to the motors of a joystick.
        kinesthetic: from the force to a device that pushes back.
        supervision: of the operator and of the robot, which then stop by themselves.
        logging: what is recorded.
    """

    name: str = ""
    description: str = ""
    duration: float = number(10.0, "s", 1e-3, 86400.0)
    seed: int = number(0, "", 0, 2**63 - 1)
    time_step: float = number(1e-3, "s", 1e-4, 2e-3)
    q0: list[float] | None = None
    operator: Operator = field(default_factory=Joystick)
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
    task: Task | None = None
    haptics: HapticMapping = field(default_factory=HapticMapping)
    kinesthetic: KinestheticMapping | None = None
    supervision: Supervision | None = None
    logging: Logging = field(default_factory=Logging)

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in self.__dataclass_fields__:
            fields = ", ".join(self.__dataclass_fields__)
            near = checks.nearest(name, self.__dataclass_fields__)
            raise AttributeError(f"scenario.{name}: unknown field, allowed {fields}{near}")
        object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        """The fields that differ from their defaults, as YAML."""
        return f"Scenario {self.name}\n{changed_yaml(self)}".rstrip()

    def _repr_html_(self) -> str:
        from scara_drake.display.cards import of_scenario

        return of_scenario(self)

    def check_together(self, name: str) -> None:
        """Check what concerns more than one part.

        Raises:
            ValueError: one line that names the field, its value and what is allowed.
        """
        checks.number("duration", self.duration, self.time_step, 86400.0)
        if self.q0 is not None:
            joints.check_configuration("q0", self.q0)
        if self.name:
            checks.word("name", self.name)
        if len(self.description) > 500 or not all(c.isprintable() for c in self.description):
            raise ValueError(
                f"description: {checks.shown(self.description)}, allowed one line of up to 500 "
                "characters"
            )
        if self.task is not None:
            self.task.check_scene(
                "task", self.environment.names(), self.environment.cut is not None
            )
        wiring_of(self).check(self)

    @property
    def sample_period(self) -> float:
        """From sample to sample [s]: of a supervised run a tick, for what comes before a fault."""
        return self.logging.period if self.supervision is None else self.time_step

    def seed_of(self, name: str) -> int:
        """Return the seed of a system that draws random numbers, by its name in the Diagram.

        Raises:
            ValueError: no such system draws any.
        """
        if name == "inverse_kinematics":
            return self.seed
        checks.choice("seed_of", name, STREAMS)
        return 4 * (self.seed % 2**60) + STREAMS.index(name)


def check_scenario(scenario: Scenario) -> None:
    """Check every field against its bounds, the rules between them, and the time step.

    Raises:
        ValueError: one line that names the field, its value and what is allowed.
    """
    check_controller(scenario.controller)
    check(scenario, "")
    check_sampling(scenario, "", scenario.time_step, model=scenario.robot)


def load_scenario(name_or_path: str | Path, overrides: dict[str, Any] | None = None) -> Scenario:
    """Load a scenario by the name of a shipped one or by the path of a YAML file, and check it.

    Args:
        name_or_path: such as ``"teleoperation"`` or ``"my/press.yaml"``.
        overrides: dotted keys to values, such as ``{"controller.phi": 0.5}``. A number or a
            word given for a list sets every entry; a string is read as YAML, so tags such as
            ``"!SineDelay {}"`` choose another kind of part.

    Warns:
        UnusedSetting: a field was set that the scenario's operator has no use for.

    Raises:
        ValueError: no such scenario, unknown key, wrong type, or a number out of its bounds.
    """
    scenario, unused = read_scenario(name_or_path, overrides)
    for sentence in unused:
        warnings.warn(sentence, UnusedSetting, stacklevel=2)
    return scenario


def read_scenario(
    name_or_path: str | Path, overrides: dict[str, Any] | None = None
) -> tuple[Scenario, list[str]]:
    """Return a scenario, and a sentence for each setting that it has no use for; `load_scenario`.

    Raises:
        ValueError: as there.
    """
    path = find_scenario(name_or_path)
    file = shown(path.name, quotes=False)
    try:
        data = read_yaml(path.read_text(encoding="utf-8"), file)
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"{file}: {shown(error, 160)}, allowed a text in UTF-8") from None
    if not isinstance(data, dict):
        raise ValueError(f"{file}: {type(data).__name__}, allowed a map of scenario fields")
    in_file = list(data)
    for key, value in (overrides or {}).items():
        override(data, key, value)
    scenario = build(Scenario, data)
    scenario.name = scenario.name or re.sub(r"[^\w.,+=()-]|^\W", "_", path.stem)[:100]
    resolve_files(scenario, path.parent)
    check_scenario(scenario)
    own = [name for name in in_file if getattr(scenario, name) != getattr(Scenario(), name)]
    return scenario, list(unused_settings(scenario, dict.fromkeys([*own, *(overrides or {})])))


def dump_scenario(scenario: Scenario) -> str:
    """Return the YAML text of a scenario; loading it gives an equal scenario.

    A part of a kind that is not in the unions above, such as a controller of your own, is written
    under its own tag: the text says what ran, but does not load.
    """
    return yaml_of(scenario)


def parse_overrides(settings: list[str]) -> dict[str, Any]:
    """Return the overrides of texts such as "controller.phi=0.5", for `load_scenario`.

    Raises:
        ValueError: a text is not KEY=VALUE.
    """
    pairs = {}
    for setting in settings:
        key, equals, value = setting.partition("=")
        if not (key and equals):
            raise ValueError(f"--set: {shown(setting)}, allowed KEY=VALUE")
        pairs[key] = value
    return pairs
