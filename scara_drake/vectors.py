"""The layout of every vector that crosses a port, by name, with makers and readers.

W is the world, z up; E is the tool frame. A field of one number that kernels write is a cell.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scara_drake import kinematics
from scara_drake.common.layout import Cell, Layout

Array = NDArray[np.float64]
# Which entries of a packet are felt together, and what they are, a name of `codec.QUANTITIES`.
Felt = tuple[slice, str]


class JoystickAxes(NamedTuple):
    """`joystick_axes` (5): the stick, each axis -1 to 1."""

    x: float
    y: float
    z: float
    mast_axis: float
    mast_hat: float


class OrientationAxes(NamedTuple):
    """`orientation_axes` (3): jogs the tool's orientation about W's axes, each -1 to 1."""

    roll: float
    pitch: float
    yaw: float


class OperatorButtons(NamedTuple):
    """`operator_buttons` (6): 1 while down, else 0.

    Attributes:
        engage: the dead-man button.
        clutch: the stick moves without the tool.
        hold: stops, until engaged again.
        reset: acknowledges a fault or an emergency stop.
        estop: stops, until reset.
        mast: the stick's z drives the mast.
    """

    engage: float
    clutch: float
    hold: float
    reset: float
    estop: float
    mast: float


class DeviceStatus(NamedTuple):
    """`device_status` (4): what the wall clock says, sampled with the device.

    Attributes:
        connected: 1 while the device is there, else 0.
        age: since the device last spoke [s].
        lateness: of the simulation behind the clock [s].
        bad_samples: how many in a row were dropped, as they held what is no number or out of range.
    """

    connected: float
    age: float
    lateness: float
    bad_samples: float


class LiveSettings(NamedTuple):
    """`live_settings` (5): what an operator may change during a run.

    Attributes:
        delay_up: added to the channel's, of the command [s].
        delay_down: added to the channel's, of the force [s].
        force_scale: of the force that is felt.
        motion_scale: of the tool's travel.
        gain_scale: of the controller's gains.
    """

    delay_up: float
    delay_down: float
    force_scale: float
    motion_scale: float
    gain_scale: float


class SupervisorStatus(NamedTuple):
    """`operator_status`, `robot_status` (4): see `safety`.

    Attributes:
        state: a `safety.State`.
        reason: a `safety.Reason`.
        engagements: how often it went ACTIVE from a stop; an engagement begins where the arm is.
        faults: how often it went to HOLD by itself, FAULT or ESTOP.
    """

    state: Cell
    reason: Cell
    engagements: Cell
    faults: Cell


class CommandFrame(NamedTuple):
    """`command_frame` (10): what a supervised operator sends.

    Attributes:
        tool_command: (8,), see `ToolCommand`.
        state: of the operator's supervisor.
        engagements: its count.
    """

    tool_command: Array
    state: Cell
    engagements: Cell


class RobotReport(NamedTuple):
    """`robot_report` (15): what a supervised robot sends back.

    Attributes:
        f_env_on_tool_W: (3,) [N].
        status: (4,) of the robot's supervisor, see `SupervisorStatus`.
        tool_command: (8,) the command that would leave the arm where its references are.
    """

    f_env_on_tool_W: Array
    status: Array
    tool_command: Array


class PolicyState(NamedTuple):
    """`policy_state` (3): what is told of an operator who reacts.

    Attributes:
        phase: 0 moves, 1 waits, 2 has done his work, 3 the picture stands still.
        leg: stages of the work that are done.
        done_at: when the last one was done [s]; negative before.
    """

    phase: Cell
    leg: Cell
    done_at: Cell


class Pose(NamedTuple):
    """`X_WE_desired` (7), and the beginning of every vector that holds a pose.

    Attributes:
        p: p_WE (3,) [m].
        quaternion: of R_WE (4,), w x y z.
    """

    p: Array
    quaternion: Array


class ToolCommand(NamedTuple):
    """`tool_command` (8): where the tool is wanted.

    Attributes:
        p: p_WE (3,) [m].
        quaternion: of R_WE (4,), w x y z.
        mast: height d1 [m].
    """

    p: Array
    quaternion: Array
    mast: Cell


class State(NamedTuple):
    """`state` and `state_desired` (12): the joints.

    Attributes:
        q: positions (6,) [m, rad].
        v: rates (6,) [m/s, rad/s].
    """

    q: Array
    v: Array


class Motion(NamedTuple):
    """`motion_limited`, `motion_master` (6): a point that moves.

    Attributes:
        p: position (3,) [m].
        v: velocity (3,) [m/s].
    """

    p: Array
    v: Array


class ServoState(NamedTuple):
    """`servo_state` (17): the limiter of the command, then what came of it.

    Attributes:
        p: p_WE (3,) [m].
        quaternion: of R_WE (4,), w x y z.
        v: velocity of the tool point (3,) [m/s].
        w: angular velocity of the tool (3,) [rad/s].
        mast: height d1 [m].
        mast_rate: [m/s].
        status: see `ik.servo`.
        count: of the samples that were solved from scratch.
    """

    p: Array
    quaternion: Array
    v: Array
    w: Array
    mast: Cell
    mast_rate: Cell
    status: Cell
    count: Cell


JOYSTICK_AXES = Layout(JoystickAxes)
STICK_NAMES: Final = JoystickAxes._fields
ORIENTATION_AXES = Layout(OrientationAxes)
ORIENTATION_NAMES: Final = OrientationAxes._fields
OPERATOR_BUTTONS = Layout(OperatorButtons)
BUTTON_NAMES: Final = OperatorButtons._fields
DEVICE_STATUS = Layout(DeviceStatus)
LIVE_SETTINGS = Layout(LiveSettings)
SETTING_NAMES: Final = LiveSettings._fields
# Nothing is added, nothing is scaled.
NEUTRAL_SETTINGS: Final = LiveSettings(0.0, 0.0, 1.0, 1.0, 1.0)
SUPERVISOR_STATUS = Layout(SupervisorStatus, state=(), reason=(), engagements=(), faults=())
COMMAND_FRAME = Layout(CommandFrame, tool_command=8, state=(), engagements=())
ROBOT_REPORT = Layout(RobotReport, f_env_on_tool_W=3, status=4, tool_command=8)
POLICY_STATE = Layout(PolicyState, phase=(), leg=(), done_at=())
POSE = Layout(Pose, p=3, quaternion=4)
TOOL_COMMAND = Layout(ToolCommand, p=3, quaternion=4, mast=())
STATE = Layout(State, q=6, v=6)
MOTION = Layout(Motion, p=3, v=3)
SERVO_STATE = Layout(
    ServoState, p=3, quaternion=4, v=3, w=3, mast=(), mast_rate=(), status=(), count=()
)
joystick_axes_of = JOYSTICK_AXES.reader()
orientation_axes_of = ORIENTATION_AXES.reader()
operator_buttons_of = OPERATOR_BUTTONS.reader()
device_status_of = DEVICE_STATUS.reader()
live_settings_of = LIVE_SETTINGS.reader()
supervisor_status_of = SUPERVISOR_STATUS.reader()
command_frame_of = COMMAND_FRAME.reader()
robot_report_of = ROBOT_REPORT.reader()
policy_state_of = POLICY_STATE.reader()
pose_of = POSE.reader()
tool_command_of = TOOL_COMMAND.reader()
state_of = STATE.reader()
motion_of = MOTION.reader()
servo_state_of = SERVO_STATE.reader()


def pose_vector(q: ArrayLike) -> Array:
    """Return the tool pose of a configuration (6,) as a vector (7,)."""
    from pydrake.math import RotationMatrix  # here: who reads names from this module needs no Drake

    X_WE = kinematics.forward_kinematics(q)
    quaternion = RotationMatrix(X_WE[:3, :3]).ToQuaternion().wxyz()
    return POSE.pack(p=X_WE[:3, 3], quaternion=quaternion)


def pose_matrix(vector: ArrayLike) -> Array:
    """Return the pose (4, 4) of a vector whose first entries are p_WE and the quaternion."""
    pose = POSE.unpack(np.array(vector, dtype=np.float64)[: POSE.size])
    X_WE, R_WE = np.eye(4), np.empty((3, 3))
    kinematics.rotation_from_quaternion_kernel(pose.quaternion, R_WE)
    X_WE[:3, :3], X_WE[:3, 3] = R_WE, pose.p
    return X_WE


def held_command(centre: ArrayLike, rpy: ArrayLike, mast_height: float) -> Array:
    """Return the tool command (8,) of a point relative to the arm's base, which rides on the mast.

    Args:
        centre: (3,) [m], in W's axes.
        rpy: orientation of the tool, Rx(roll) Ry(pitch) Rz(yaw) (3,) [rad].
        mast_height: [m].
    """
    from pydrake.math import RotationMatrix

    x, y, z = np.asarray(centre, dtype=np.float64)
    rotation = RotationMatrix(kinematics.rotation_from_intrinsic_xyz(rpy))
    return TOOL_COMMAND.pack(
        p=[x, y, z + mast_height],
        quaternion=rotation.ToQuaternion().wxyz(),
        mast=mast_height,
    )
