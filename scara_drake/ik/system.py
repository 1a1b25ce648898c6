"""Inverse kinematics in the loop: a block over the solvers and the servo."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake import kinematics
from scara_drake.common import checks
from scara_drake.common.block import Block, Declaration, Input, Kernel, Memory, Output
from scara_drake.common.fields import ABOVE_ZERO, choice, number
from scara_drake.ik import servo
from scara_drake.ik.kernels.limiter import LIMITS, SETTINGS, follow_command
from scara_drake.ik.restart import put_at, restarting_step
from scara_drake.ik.result import IkResult
from scara_drake.ik.solve import METHODS, solve
from scara_drake.joints import HOME, LOWER, MAX_SPEED, UPPER, check_configuration
from scara_drake.kinematics import tool_kinematics_kernel
from scara_drake.vectors import (
    MOTION,
    POSE,
    SERVO_STATE,
    STATE,
    TOOL_COMMAND,
    motion_of,
    pose_matrix,
    pose_of,
    servo_state_of,
    state_of,
)

Array = NDArray[np.float64]

# Methods that start from one answer and follow the command with the Jacobian; the value is the
# method of that first answer: for "dpsoij" the swarms of (18) to (25). Every other method solves
# each sample from scratch, as the paper has it: by its swarms alone, without polish.
FOLLOWERS = {"dpsoij": "dpso", "robust": "robust", "inverse_jacobian": "inverse_jacobian"}
SWARMS = ("dpso", "pso")


@dataclass
class InverseKinematics:
    """How the tool command becomes joint references.

    Attributes:
        method: solver of each sample; "dpsoij", "robust" and "inverse_jacobian" follow the command
            by resolved rates, from a first posture by DPSO, by closed form and least squares, or
            from home.
        joints: "arm" gives the mast its own command; "full" lets it take part.
        task: "position" holds the tool point exactly and its orientation as near as possible;
            "pose" holds both.
        max_speed: of the tool point.
        max_acceleration: of the tool point.
        max_turn_rate: of the tool.
        max_turn_acceleration: of the tool.
        mast_acceleration: of the mast's command.
        bandwidth: of the command limiter.
        position_gain: of the resolved rates.
        rotation_gain: of the resolved rates.
    """

    method: str = choice("dpsoij", tuple(METHODS))
    joints: str = choice("arm", ("arm", "full"))
    task: str = choice("position", ("position", "pose"))
    max_speed: float = number(0.5, "m/s", ABOVE_ZERO, 100.0)
    max_acceleration: float = number(4.0, "m/s^2", ABOVE_ZERO, 100.0)
    max_turn_rate: float = number(1.0, "rad/s", ABOVE_ZERO, 100.0)
    max_turn_acceleration: float = number(8.0, "rad/s^2", ABOVE_ZERO, 100.0)
    mast_acceleration: float = number(1.0, "m/s^2", ABOVE_ZERO, 100.0)
    bandwidth: float = number(30.0, "1/s", ABOVE_ZERO, 400.0)
    position_gain: float = number(200.0, "1/s", ABOVE_ZERO, 400.0)
    rotation_gain: float = number(20.0, "1/s", ABOVE_ZERO, 400.0)

    def check_together(self, name: str) -> None:
        """Check that the method knows the task.

        Raises:
            ValueError: it does not.
        """
        if self.method == "closed_form":
            checks.choice(f"{name}.task with method closed_form", self.task, ("pose",))

    def settings(self, period: float) -> Array:
        """Return the fields as `limiter.settings_of` reads them, for a period [s]."""
        return SETTINGS.pack(
            mast_follows=self.joints == "arm",
            position_first=self.task == "position",
            max_speed=self.max_speed,
            max_acceleration=self.max_acceleration,
            max_turn_rate=self.max_turn_rate,
            max_turn_acceleration=self.max_turn_acceleration,
            mast_speed=MAX_SPEED[0],
            mast_acceleration=self.mast_acceleration,
            bandwidth=self.bandwidth,
            position_gain=self.position_gain,
            rotation_gain=self.rotation_gain,
            period=period,
        )


def first_answer(config: InverseKinematics, command: ArrayLike, seed: int) -> IkResult:
    """Return the answer to the first command (8,), on the branch nearest the home posture.

    It tells who found it: the swarm with "dpsoij", or "robust" where that did not converge.

    Raises:
        ValueError: the first command cannot be reached.
    """
    near = HOME.copy()
    asked = TOOL_COMMAND.unpack(np.array(command, dtype=np.float64))
    near[0] = np.clip(asked.mast[()], LOWER[0], UPPER[0])
    method = FOLLOWERS.get(config.method, config.method)
    how: dict[str, Any] = {"method": method, "joints": config.joints, "task": config.task}
    how |= {"q_seed": near, "seed": seed}
    if method in (*SWARMS, "robust"):
        how["nearest_to"] = near
        # Loads the kernels, so that the time that the answer tells is that of its search.
        solve(kinematics.forward_kinematics(near), starts=1, **how)
    result = solve(pose_matrix(command), **how)
    if not result.success:
        position = ", ".join(f"{x:.3f}" for x in asked.p)
        raise ValueError(f"first tool command: [{position}] m, not reachable: {result.reason}")
    return result


def first_posture(config: InverseKinematics, command: ArrayLike, seed: int) -> Array:
    """Return q (6,) of `first_answer`."""
    return first_answer(config, command, seed).q


@njit(cache=True)
def show_pose(servo_state: Array, X_WE_desired: Array) -> None:
    """Write the pose (7,) of the limiter."""
    shown, now = pose_of(X_WE_desired), servo_state_of(servo_state)
    shown.p[:] = now.p
    shown.quaternion[:] = now.quaternion


@njit(cache=True)
def show_status(servo_state: Array, status: Array) -> None:
    """Write the status (1,)."""
    status[0] = servo_state_of(servo_state).status[()]


@njit(cache=True)
def show_motion(state_desired: Array, motion_limited: Array) -> None:
    """Write position and velocity in W (6,) [m, m/s] of the tool point of a state (12,)."""
    desired, tool = state_of(state_desired), motion_of(motion_limited)
    p, R, J = np.empty(3), np.empty((3, 3)), np.empty((6, 6))
    tool_kinematics_kernel(desired.q, p, R, J)
    for i in range(3):
        tool.p[i] = p[i]
        tool.v[i] = 0.0
        for j in range(6):
            tool.v[i] += J[3 + i, j] * desired.v[j]


class InverseKinematicsSystem(Block):
    """Turns tool commands into joint references.

    Ports:
        input tool_command (8): p_WE [m], quaternion w x y z of R_WE, mast height [m]; not finite
            stops the run.
        input references_restart (1), state (12): with `restarts`; where the first is above zero the
            references are put at rest where the second, the measured one, is.
        output state_desired (12): discrete state, q, v references [m, rad, m/s, rad/s].
        output servo_state (17): discrete state: the limiter, status, count of samples, see
            `vectors.ServoState`.
        output X_WE_desired (7): of servo_state, the pose that is followed: p_WE [m], quaternion
            w x y z.
        output status (1): of servo_state: 0 tracking, 1 holding the last good answer because the
            target cannot be reached, 2 tracking a target that was drawn back into the arm's reach,
            3 on the way to an answer that is further than the joints can go in a period.
        output motion_limited (6): of state_desired, the motion of the tool point that the joints
            are asked for, after every limit: p_WE [m], its velocity [m/s].

    Update, at t = k period, with "dpsoij", "robust" and "inverse_jacobian": the limiter follows the
    command and the joints follow the limiter by resolved rates, see `servo`. With another method
    each sample is solved from scratch, and the joints go there no faster than they can. Where the
    answer leaves the tolerance, q stays, v is zero and the limiter returns to the last good pose.

    Initial: q = `q_start`, or the answer for `first_command`; the limiter rests at its tool pose.

    Args:
        config: checked.
        first_command: (8,).
        q_start: (6,), or None.
        seed: of the swarms.
        period: [s].
        restarts: whether the references can be put where the arm is.

    Raises:
        ValueError: `q_start` is outside the joint ranges, or `first_command` cannot be reached.
    """

    def __init__(
        self,
        config: InverseKinematics,
        first_command: ArrayLike,
        q_start: ArrayLike | None = None,
        seed: int = 0,
        period: float = 1e-3,
        restarts: bool = False,
    ):
        self._config, self._seed = config, seed
        self._settings = config.settings(period)
        self._limits = LIMITS.pack(lower=LOWER, upper=UPPER, rate=MAX_SPEED)
        if q_start is None:
            q = first_posture(config, first_command, seed)
        else:
            q = check_configuration("q_start", q_start)
        inputs = {"tool_command": Input(TOOL_COMMAND.size, finite=True)}
        update: Kernel = servo.servo_step if config.method in FOLLOWERS else self._solve
        if restarts:
            inputs |= {"references_restart": Input(1), "state": Input(STATE.size)}
            update = restarting_step if config.method in FOLLOWERS else self._solve_or_restart
        super().__init__(
            Declaration(
                inputs=inputs,
                memory={
                    "state_desired": Memory(STATE.zeros(q=q), port=True),
                    "servo_state": Memory(servo.servo_state_at(q), port=True),
                },
                outputs={
                    "X_WE_desired": Output(POSE.size, show_pose),
                    "status": Output(1, show_status),
                    "motion_limited": Output(MOTION.size, show_motion),
                },
                parameters={"settings": self._settings, "limits": self._limits},
                period=period,
                update=update,
            )
        )

    def _solve_or_restart(
        self,
        tool_command: Array,
        references_restart: Array,
        state: Array,
        state_desired: Array,
        servo_state: Array,
    ) -> None:
        """`_solve`, or in its place a restart."""
        if references_restart[0] > 0.0 and np.isfinite(state).all():
            put_at(state, state_desired, servo_state, self._limits)
        else:
            self._solve(tool_command, state_desired, servo_state)

    def _solve(self, tool_command: Array, state_desired: Array, servo_state: Array) -> None:
        """Solve one sample from scratch, in Python; the count numbers the draws of the swarms."""
        desired, now = STATE.unpack(state_desired), SERVO_STATE.unpack(servo_state)
        now.count[()] += 1.0
        good = servo_state.copy()
        settings, limits = self._settings, self._limits
        cut = follow_command(tool_command, servo_state, settings, limits)
        q_seed = desired.q.copy()
        if self._config.joints == "arm":
            q_seed[0] = now.mast[()]
        options = {"polish": False} if self._config.method in SWARMS else {}
        result = solve(
            pose_matrix(servo_state),
            method=self._config.method,
            joints=self._config.joints,
            task=self._config.task,
            q_seed=q_seed,
            seed=self._seed + int(now.count[()]),
            **options,
        )
        if not result.success:
            servo.hold(good, servo_state, state_desired)
            return
        servo.reference_rates(servo_state, result.q, settings, limits, desired.v)
        q, rates = desired.q.copy(), desired.v.copy()
        period = self.declaration.period
        late = servo.approach(q, result.q, limits, period, rates)
        desired.q[:], desired.v[:] = q, rates
        now.status[()] = servo.REACH_LIMITED if cut else servo.TRACKING
        if late:
            now.status[()] = servo.CATCHING_UP
