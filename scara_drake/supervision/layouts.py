"""What the robot's supervisor knows, sees and remembers, as arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scara_drake.common.layout import Cell, Layout
from scara_drake.ik.kernels.limiter import LIMITS, SETTINGS
from scara_drake.vectors import SUPERVISOR_STATUS, TOOL_COMMAND

Array = NDArray[np.float64]


class Bounds(NamedTuple):
    """`RobotSupervision` in a kernel, and the robot's inverse kinematics that it stands before.

    Attributes:
        motion: of the inverse kinematics, see `limiter.Settings`.
        limits: of the joints, see `limiter.Limits`.
        after_outage: ENGAGE or RESUME.
        reach: [m] from the circle of the end of the beam.
        box_lower: (3,) [m].
        box_upper: (3,) [m].
        joint_margin: (6,) [m, rad].
        horizon: [s].
        singularity_slow: of the controlled rows.
        singularity_stop: of the controlled rows.
        retract: [m], at a time.
        release: [N], force down to which the tool backs off.
        linger: ticks for which a warning stays.
    """

    motion: Array
    limits: Array
    after_outage: float
    reach: float
    box_lower: Array
    box_upper: Array
    joint_margin: Array
    horizon: float
    singularity_slow: float
    singularity_stop: float
    retract: float
    release: float
    linger: float


class Supervisor(NamedTuple):
    """Memory of the supervisor.

    Attributes:
        command: (8,) that is let through.
        status: (4,), see `vectors.SupervisorStatus`.
        offset: (8,) between the command that is let through and the one that arrives: a shift, a
            turn and a height, as a `vectors.ToolCommand`.
        seen: engagement of the operator's that was taken up, or let pass.
        was_lost: 1 from an outage on until something arrives.
        acknowledged: 1 once the operator's side knows of the fault, or stopped by itself.
        restart: 1 for the tick in which the references are put where the arm is.
        warned: ticks for which the warning stays.
        backed_off: how far the tool has, since the force was too large [m].
        blind: 1 from a bad measurement on until a reset.
    """

    command: Array
    status: Array
    offset: Array
    seen: Cell
    was_lost: Cell
    acknowledged: Cell
    restart: Cell
    warned: Cell
    backed_off: Cell
    blind: Cell


class ArmCondition(NamedTuple):
    """`arm_condition` (16): what the watch over the arm finds.

    Attributes:
        fault: a `safety.Reason` to stop for, or 0.
        warning: one to tell of, or 0.
        f: contact force (3,) [N].
        tool: where the tool is measured, a `vectors.ToolCommand` (8,).
        away: 1 where the arm is away from its references.
        force: |f| [N].
        efforts: how fast they vary, in their limits [1/s].
    """

    fault: Cell
    warning: Cell
    f: Array
    tool: Array
    away: Cell
    force: Cell
    efforts: Cell


class LinkCondition(NamedTuple):
    """`link_condition` (2): what the watch over the channel finds.

    Attributes:
        lost: 1 while the command is.
        fault: a `safety.Reason` to stop for, or 0.
    """

    lost: Cell
    fault: Cell


class ChannelEnergy(NamedTuple):
    """`channel_energy` (2): since the start, both ends together [J].

    Attributes:
        taken: by the channel.
        given: by the channel.
    """

    taken: Cell
    given: Cell


BOUNDS = Layout(
    Bounds, motion=SETTINGS.size, limits=LIMITS.size, box_lower=3, box_upper=3, joint_margin=6
)
SUPERVISOR = Layout(
    Supervisor,
    command=TOOL_COMMAND.size,
    status=SUPERVISOR_STATUS.size,
    offset=TOOL_COMMAND.size,
    **dict.fromkeys(("seen", "was_lost", "acknowledged", "restart", "warned"), ()),
    **dict.fromkeys(("backed_off", "blind"), ()),
)
ARM_CONDITION = Layout(
    ArmCondition,
    f=3,
    tool=TOOL_COMMAND.size,
    **dict.fromkeys(("fault", "warning", "away", "force", "efforts"), ()),
)
LINK_CONDITION = Layout(LinkCondition, lost=(), fault=())
CHANNEL_ENERGY = Layout(ChannelEnergy, taken=(), given=())
bounds_of = BOUNDS.reader()
supervisor_of = SUPERVISOR.reader()
arm_condition_of = ARM_CONDITION.reader()
link_condition_of = LINK_CONDITION.reader()
channel_energy_of = CHANNEL_ENERGY.reader()
