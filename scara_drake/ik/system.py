"""Inverse kinematics in the loop: a thin LeafSystem over the solvers and the servo."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteStateIndex,
    DiscreteValues,
    LeafSystem,
)

from scara_drake.common import checks
from scara_drake.common.state import declare_state
from scara_drake.ik import servo
from scara_drake.ik.solve import METHODS, solve
from scara_drake.joints import HOME, LOWER, MAX_SPEED, UPPER, check_configuration
from scara_drake.kinematics import tool_kinematics_kernel
from scara_drake.vectors import pose_matrix, pose_vector

Array = NDArray[np.float64]

# Methods that start from one answer and follow the command with the Jacobian; the value is the
# method of that first answer. Every other method solves each sample from scratch, as the paper
# has it: by its swarms alone, without polish.
FOLLOWERS = {"dpsoij": "dpso", "inverse_jacobian": "inverse_jacobian"}
SWARMS = ("dpso", "pso")

# Layout of the memory: the limiter, then these.
STATUS, COUNT = servo.LIMITER_SIZE, servo.LIMITER_SIZE + 1


@dataclass
class InverseKinematics:
    """How the tool command becomes joint references.

    joints: "arm" gives the mast its own command; "full" lets it take part.
    task: "position" holds the tool point exactly and its orientation as near as possible; "pose"
        holds both.
    """

    method: str = "dpsoij"
    joints: str = "arm"
    task: str = "position"
    max_speed: float = 0.5  # [m/s], of the tool point
    max_acceleration: float = 4.0  # [m/s²]
    max_turn_rate: float = 1.0  # [rad/s], of the tool
    max_turn_acceleration: float = 8.0  # [rad/s²]
    mast_acceleration: float = 1.0  # [m/s²]
    bandwidth: float = 30.0  # [1/s], of the command limiter
    position_gain: float = 200.0  # [1/s], of the resolved rates
    rotation_gain: float = 20.0  # [1/s]

    def validate(self, name: str) -> None:
        """Check the choices and bounds.

        Raises:
            ValueError: one line that names the field, its value and what is allowed.
        """
        checks.choice(f"{name}.method", self.method, METHODS)
        checks.choice(f"{name}.joints", self.joints, ("arm", "full"))
        checks.choice(f"{name}.task", self.task, ("position", "pose"))
        if self.method == "closed_form":
            checks.choice(f"{name}.task with method closed_form", self.task, ("pose",))
        smallest = checks.ABOVE_ZERO
        for bound in (
            "max_speed",
            "max_acceleration",
            "max_turn_rate",
            "max_turn_acceleration",
            "mast_acceleration",
        ):
            checks.number(f"{name}.{bound}", getattr(self, bound), smallest, 100.0)
        for gain in ("bandwidth", "position_gain", "rotation_gain"):
            checks.number(f"{name}.{gain}", getattr(self, gain), smallest, 400.0)

    def settings(self, period: float) -> Array:
        """Return the settings (10,) that `servo.servo_step` takes."""
        return np.array(
            [
                self.max_speed,
                self.max_acceleration,
                self.max_turn_rate,
                self.max_turn_acceleration,
                MAX_SPEED[0],
                self.mast_acceleration,
                self.bandwidth,
                self.position_gain,
                self.rotation_gain,
                period,
            ]
        )


def first_posture(config: InverseKinematics, command: ArrayLike, seed: int) -> Array:
    """Return q (6,) for the first command (8,), on the branch nearest the home posture.

    Raises:
        ValueError: the first command cannot be reached.
    """
    near = HOME.copy()
    near[0] = np.clip(np.asarray(command)[7], LOWER[0], UPPER[0])
    method = FOLLOWERS.get(config.method, config.method)
    options = {"nearest_to": near} if method in SWARMS else {}
    result = solve(
        pose_matrix(command),
        method=method,
        joints=config.joints,
        task=config.task,
        q_seed=near,
        seed=seed,
        **options,
    )
    if not result.success:
        position = ", ".join(f"{x:.3f}" for x in np.asarray(command)[:3])
        raise ValueError(f"first tool command: [{position}] m, not reachable: {result.reason}")
    return result.q


class InverseKinematicsSystem(LeafSystem):
    """Turns tool commands into joint references.

    Input port:
        tool_command (8): p_WE [m], quaternion w x y z of R_WE, mast height [m]
    Output ports:
        state_desired (12): discrete state, q, v references [m, rad, m/s, rad/s]
        servo_state (17): discrete state: the limiter (see `servo`), status, count of samples
        X_WE_desired (7): of servo_state, the pose that is followed: p_WE [m], quaternion w x y z
        status (1): of servo_state: 0 tracking, 1 holding the last good answer because the target
            cannot be reached, 2 tracking a target that was drawn back into the arm's reach
        motion_limited (6): of state_desired, the motion of the tool point that the joints are
            asked for, after every limit: p_WE [m], its velocity [m/s]
    Update (every period), with "dpsoij" and "inverse_jacobian": the limiter follows the command and
        the joints follow the limiter by resolved rates, see `servo`. With another method each
        sample is solved from scratch. Where the answer leaves the tolerance, q stays, v is zero and
        the limiter returns to the last good pose.
    Initial: q = `q_start`, or the answer for `first_command`; the limiter rests at its tool pose.
    """

    def __init__(
        self,
        config: InverseKinematics,
        first_command: ArrayLike,
        q_start: ArrayLike | None = None,
        seed: int = 0,
        period: float = 1e-3,
    ):
        super().__init__()
        self._config, self._seed = config, seed
        self._mast_follows = config.joints == "arm"
        self._position_first = config.task == "position"
        self._settings = config.settings(period)
        self._limits = np.array([LOWER, UPPER, MAX_SPEED])

        if q_start is None:
            q = first_posture(config, first_command, seed)
        else:
            q = check_configuration("q_start", q_start)
        limiter = limiter_at(q)
        self._command = self.DeclareVectorInputPort("tool_command", 8)
        self._desired = declare_state(self, np.concatenate([q, np.zeros(6)]), "state_desired")
        # The count of samples numbers the draws of the swarm methods.
        self._memory = declare_state(
            self, np.concatenate([limiter, [servo.TRACKING, 0.0]]), "servo_state"
        )
        memory = {self.discrete_state_ticket(DiscreteStateIndex(self._memory))}
        self.DeclareVectorOutputPort("X_WE_desired", 7, self._show_pose, memory)
        self.DeclareVectorOutputPort("status", 1, self._show_status, memory)
        desired = {self.discrete_state_ticket(DiscreteStateIndex(self._desired))}
        self.DeclareVectorOutputPort("motion_limited", 6, self._show_motion, desired)
        update = self._follow if config.method in FOLLOWERS else self._solve
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, update)

    def _follow(self, context: Context, discrete: DiscreteValues) -> None:
        desired = discrete.get_mutable_value(self._desired)
        memory = discrete.get_mutable_value(self._memory)
        memory[STATUS] = servo.servo_step(
            self._command.Eval(context),
            memory[: servo.LIMITER_SIZE],
            desired,
            self._mast_follows,
            self._position_first,
            self._limits,
            self._settings,
        )

    def _show_pose(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state(self._memory).value()
        output.SetFromVector(memory[: servo.POSE_SIZE])

    def _show_status(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(context.get_discrete_state(self._memory).value()[[STATUS]])

    def _show_motion(self, context: Context, output: BasicVector) -> None:
        desired = context.get_discrete_state(self._desired).value()
        tool_motion(desired, output.get_mutable_value())

    def _solve(self, context: Context, discrete: DiscreteValues) -> None:
        desired = discrete.get_mutable_value(self._desired)
        memory = discrete.get_mutable_value(self._memory)
        limiter, good = memory[: servo.LIMITER_SIZE], memory[: servo.LIMITER_SIZE].copy()
        cut = servo.follow_command(
            self._command.Eval(context),
            limiter,
            self._mast_follows,
            self._limits,
            self._settings,
        )
        memory[COUNT] += 1.0
        q_seed = desired[:6].copy()
        if self._mast_follows:
            q_seed[0] = limiter[servo.MAST]
        options = {"polish": False} if self._config.method in SWARMS else {}
        result = solve(
            pose_matrix(limiter),
            method=self._config.method,
            joints=self._config.joints,
            task=self._config.task,
            q_seed=q_seed,
            seed=self._seed + int(memory[COUNT]),
            **options,
        )
        if result.success:
            desired[:6] = result.q
            servo.reference_rates(
                limiter,
                result.q,
                self._mast_follows,
                self._position_first,
                self._limits,
                desired[6:],
            )
        else:
            limiter[:] = good
            servo.rest(limiter, desired)
        status = servo.REACH_LIMITED if cut else servo.TRACKING
        memory[STATUS] = status if result.success else servo.HOLDING


@njit(cache=True)
def tool_motion(state: Array, motion: Array) -> None:
    """Write position and velocity in W (6,) [m, m/s] of the tool point of a state (12,)."""
    p, R, J = np.empty(3), np.empty((3, 3)), np.empty((6, 6))
    tool_kinematics_kernel(state[:6], p, R, J)
    for i in range(3):
        motion[i] = p[i]
        motion[3 + i] = 0.0
        for j in range(6):
            motion[3 + i] += J[3 + i, j] * state[6 + j]


def limiter_at(q: Array) -> Array:
    """Return the limiter (15,) at rest at the tool pose of q."""
    limiter = np.zeros(servo.LIMITER_SIZE)
    limiter[: servo.POSE_SIZE] = pose_vector(q)
    limiter[servo.MAST] = q[0]
    return limiter
