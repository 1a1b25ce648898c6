"""Which input of a device does what: profiles, read from YAML by model or by layout."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Final

import numpy as np

from scara_drake.common import checks
from scara_drake.common.fields import check, choice
from scara_drake.common.resources import resource
from scara_drake.common.schema import build
from scara_drake.common.yaml_text import read_yaml
from scara_drake.operator.devices.inputs import DOWN, LAYOUTS, MAX_INDEX, REST_ZONE, Use
from scara_drake.operator.devices.sample import AXIS_LIMIT, Sample
from scara_drake.vectors import (
    BUTTON_NAMES,
    JOYSTICK_AXES,
    OPERATOR_BUTTONS,
    ORIENTATION_AXES,
    ORIENTATION_NAMES,
    STICK_NAMES,
)


@dataclass
class ProfileAxes:
    """What moves each axis; several inputs add up, as the two triggers or two keys do."""

    x: list[Use] = field(default_factory=list)
    y: list[Use] = field(default_factory=list)
    z: list[Use] = field(default_factory=list)
    mast_axis: list[Use] = field(default_factory=list)
    mast_hat: list[Use] = field(default_factory=list)
    roll: list[Use] = field(default_factory=list)
    pitch: list[Use] = field(default_factory=list)
    yaw: list[Use] = field(default_factory=list)


@dataclass
class ProfileButtons:
    """Which inputs press each button; any of them does."""

    engage: list[str] = field(default_factory=list)
    clutch: list[str] = field(default_factory=list)
    hold: list[str] = field(default_factory=list)
    reset: list[str] = field(default_factory=list)
    estop: list[str] = field(default_factory=list)
    mast: list[str] = field(default_factory=list)


@dataclass
class AxisMap:
    """Which axis of a joystick is which, in place of what the profile says of it.

    Attributes:
        x: index of the axis, as it comes; -1 for none; empty for what the profile says.
        y: the same.
        z: the same.
        mast_axis: that moves the mast.
        mast_hat: index of a hat, of which the vertical direction moves the mast.
    """

    x: int | None = None
    y: int | None = None
    z: int | None = None
    mast_axis: int | None = None
    mast_hat: int | None = None

    def check_together(self, name: str) -> None:
        """Check the indices.

        Raises:
            ValueError: an index is not a whole number between -1 and 63.
        """
        for entry, index in vars(self).items():
            if index is not None:
                if not isinstance(index, int):
                    raise ValueError(f"{name}.{entry}: {index}, allowed a whole number or none")
                checks.number(f"{name}.{entry}", index, -1, MAX_INDEX)


@dataclass
class Profile:
    """A device's layout, the models it is for, and what its inputs do.

    Attributes:
        name: as `operator.profile` names it; that of the file if empty.
        layout: how the inputs are called.
        models: parts of the names of the devices that it is for, in any case.
        guids: of the devices that it is for.
        axes: what moves them.
        buttons: what presses them.
    """

    name: str = ""
    layout: str = choice("joystick", tuple(LAYOUTS))
    models: list[str] = field(default_factory=list)
    guids: list[str] = field(default_factory=list)
    axes: ProfileAxes = field(default_factory=ProfileAxes)
    buttons: ProfileButtons = field(default_factory=ProfileButtons)

    def check_together(self, name: str) -> None:
        """Check the names of the inputs.

        Raises:
            ValueError: one that the layout does not have.
        """
        words, pattern = LAYOUTS[self.layout]
        for where, text in self._named():
            if not re.fullmatch(pattern, text) or int(re.sub(r"\D", "", text) or 0) > MAX_INDEX:
                place = f"{name}.{where}" if name else where
                raise ValueError(f"{place}: {checks.shown(text)}, allowed {words}")

    def _named(self) -> Iterator[tuple[str, str]]:
        for axis in fields(self.axes):
            for index, use in enumerate(getattr(self.axes, axis.name)):
                yield f"axes.{axis.name}[{index}].input", use.input
        for button in fields(self.buttons):
            for index, text in enumerate(getattr(self.buttons, button.name)):
                yield f"buttons.{button.name}[{index}]", text

    def inputs(self) -> set[str]:
        """Return the names of all inputs that do something."""
        return {text for _, text in self._named()}

    def axis_inputs(self) -> set[str]:
        """Return the names of the inputs that move an axis."""
        return {use.input for axis in fields(self.axes) for use in getattr(self.axes, axis.name)}

    def away(self, inputs: Mapping[str, float]) -> set[str]:
        """Return the inputs that stand away from rest, of the axes that several inputs move.

        Two triggers under two fingers cancel, so the axis alone would not tell.
        """
        uses = (getattr(self.axes, axis.name) for axis in fields(self.axes))
        return {
            use.input
            for several in uses
            if len(several) > 1
            for use in several
            if abs(use.value(inputs.get(use.input, use.rest))) > REST_ZONE
        }

    def sample(self, stamp: float, inputs: Mapping[str, float]) -> Sample:
        """Return what the inputs say at a time; one that is not there is at rest."""
        axes = {axis.name: self._axis(axis.name, inputs) for axis in fields(self.axes)}
        buttons = {
            name: float(any(inputs.get(one, 0.0) >= DOWN for one in getattr(self.buttons, name)))
            for name in BUTTON_NAMES
        }
        return Sample(
            True,
            stamp,
            JOYSTICK_AXES.pack(**{name: axes[name] for name in STICK_NAMES}),
            ORIENTATION_AXES.pack(**{name: axes[name] for name in ORIENTATION_NAMES}),
            OPERATOR_BUTTONS.pack(**buttons),
        )

    def _axis(self, name: str, inputs: Mapping[str, float]) -> float:
        uses: list[Use] = getattr(self.axes, name)
        values = [use.value(inputs[use.input]) for use in uses if use.input in inputs]
        wrong = [value for value in values if not abs(value) <= AXIS_LIMIT]
        return wrong[0] if wrong else float(np.clip(sum(values), -1.0, 1.0))

    def changed(self, axes: AxisMap) -> Profile:
        """Return the profile with the axes that a scenario chooses itself."""
        chosen: dict[str, list[Use]] = {}
        for name, index in vars(axes).items():
            if index is not None:
                text = f"hat{index}_y" if name == "mast_hat" else f"axis{index}"
                chosen[name] = [Use(text)] if index >= 0 else []
        return replace(self, axes=replace(self.axes, **chosen))


def profile_names() -> list[str]:
    """Return the names of the shipped profiles."""
    return sorted(path.stem for path in resource("profiles").glob("*.yaml"))


def load_profile(name: str) -> Profile:
    """Load a profile, checked: a shipped one by its name, or a YAML file by its path.

    Raises:
        ValueError: no such profile, no YAML, or a field that is not allowed; names it.
    """
    shipped = profile_names()
    path = resource("profiles") / f"{name}.yaml" if name in shipped else Path(name)
    if not path.is_file():
        raise ValueError(
            f"operator.profile: {checks.shown(name)}, allowed {', '.join(shipped)} or a YAML file"
            f"{checks.nearest(name, shipped)}"
        )
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise ValueError(f"{path.name}: allowed YAML text in UTF-8") from None
    data = read_yaml(text, path.name)
    if not isinstance(data, dict):
        raise ValueError(f"{path.name}: allowed a map with the fields of a profile")
    try:
        profile = build(Profile, data)
        check(profile, "")
    except ValueError as error:
        raise ValueError(f"{path.name}: {error}") from None
    return replace(profile, name=profile.name or path.stem)


def choose_profile(name: str, guid: str, layouts: tuple[str, ...]) -> Profile:
    """Return the shipped profile for a device: by its GUID, by its model, or by its layout.

    Args:
        name: what the device calls itself.
        guid: of its model.
        layouts: that its inputs can be read in, the best first; each has a profile for all.
    """
    known = [profile for profile in map(load_profile, profile_names()) if profile.layout in layouts]
    for fits in (
        lambda profile: guid in profile.guids,
        lambda profile: any(model.lower() in name.lower() for model in profile.models),
    ):
        for profile in known:
            if fits(profile):
                return profile
    return load_profile(DEFAULT_PROFILES[layouts[0]])


# What is taken for a device of which no profile knows the model.
DEFAULT_PROFILES: Final = {
    "joystick": "flight_stick",
    "game_controller": "game_controller",
    "keyboard": "keyboard",
    "spacemouse": "spacemouse",
}
