"""A scripted person at the stick, who knows the drawing of his task and what comes back to him."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.common.fields import choice, number
from scara_drake.common.scratch import scratch
from scara_drake.kinematics import tool_pose_kernel
from scara_drake.operator.mapping import JoystickMapping, initial_command
from scara_drake.operator.moves import DONE, MIND, OWN_LAG, WAITING, start_work, work
from scara_drake.operator.skills import LEG, SKILLS, Skill

Array = NDArray[np.float64]

OWN: Final = "own"


@dataclass
class Trainee:
    """A scripted operator, who does the scenario's task by what he sees and feels.

    Both come back over the downlink. He holds the stick of `mapping`, whose axes are a position.

    Attributes:
        preset: "good" or "bad", or "own" for `skill`.
        skill: how well he works, with "own".
        sample_period: of the stick.
        mapping: from the stick to the tool.
    """

    preset: str = choice("good", (*SKILLS, OWN))
    skill: Skill = field(default_factory=Skill)
    sample_period: float = number(0.01, "s", 1e-3, 0.1)
    mapping: JoystickMapping = field(default_factory=JoystickMapping)

    def first_command(self) -> Array:
        """Return the tool command (8,) of the centred stick, see `initial_command`."""
        return initial_command(self.mapping)

    def skilled(self) -> Skill:
        """Return the skill that stands."""
        return self.skill if self.preset == OWN else SKILLS[self.preset]


class TraineeSource(Block):
    """A scripted operator, see `Trainee`: he acts on what came back a reaction ago.

    Ports:
        input tool_seen (3): p_WE as it came over the downlink [m].
        input f_haptic (3): force of the environment on the tool, likewise [N]; zero where not
            connected.
        output joystick_axes (5): x, y, z, mast_axis, mast_hat, each in [-1, 1].

    Update, at t = k period: `work`. A move from where the stick asks the tool to be is one of
    minimum jerk, of `next_move` and the spread of his aim; behind it he waits for `patience` times
    the lag that he has met. Initial: he has seen the tool where it is, with the stick centred.

    Args:
        trainee: who it is.
        plan: (n, `LEG.size`), see `plan_of`; n may be 0, for somebody who does nothing.
        seed: of his aim.

    Attributes:
        device_name: what the axes come from.

    Raises:
        ValueError: the plan has another shape.
    """

    def __init__(self, trainee: Trainee, plan: ArrayLike, seed: int = 0) -> None:
        rows = np.array(plan, dtype=np.float64)
        if rows.ndim != 2 or rows.shape[1] != LEG.size:
            raise ValueError(f"plan: shape {rows.shape}, allowed (n, {LEG.size})")
        skill, mapping = trainee.skilled(), trainee.mapping
        period, centre = trainee.sample_period, trainee.first_command()[:3]
        samples = max(math.ceil(skill.reaction / period), 1)
        first = MIND.zeros(
            phase=WAITING if len(rows) else DONE,
            lag=skill.reaction + OWN_LAG,
            timed=-1.0,
            arrived=-1.0,
            aim=centre,
            history=np.zeros(6 * samples),
        )
        super().__init__(
            Declaration(
                inputs={"tool_seen": Input(3), "f_haptic": Input(3, default=(0.0,) * 3)},
                memory={
                    "joystick_axes": Memory(5, port=True),
                    "mind": Memory(first),
                },
                parameters={
                    "plan": rows,
                    "person": skill.parameters(centre, mapping.scale, mapping.dead_zone),
                    "seed": seed,
                },
                period=period,
                update=work,
                initialize=start_work,
            )
        )
        self.device_name = f"scripted operator, {trainee.preset}"


@njit(cache=True)
def write_tool_position(state: Array, p_WE: Array) -> None:
    """Write the tool position (3,) [m] of a robot state (12,)."""
    R_WE = scratch(3, 3)
    tool_pose_kernel(state[:6], p_WE, R_WE)


class ToolPosition(Block):
    """Says where the tool is.

    Ports:
        input state (12): q, v [m, rad, m/s, rad/s].
        output p_WE (3) [m].
    """

    def __init__(self) -> None:
        super().__init__(
            Declaration(
                inputs={"state": Input(12)}, outputs={"p_WE": Output(3, write_tool_position)}
            )
        )
