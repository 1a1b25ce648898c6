"""The variables of a recording: which entries of which signal make which."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from scara_drake.cut_state import PIPE_STATE
from scara_drake.vectors import (
    DEVICE_STATUS,
    LIVE_SETTINGS,
    POLICY_STATE,
    SERVO_STATE,
    SUPERVISOR_STATUS,
)


@dataclass(frozen=True)
class Signal:
    """One variable of a recording.

    Attributes:
        source: the logged signal it is in; empty where it is worked out from others.
        column: of its first entry there.
        dims: beside the time.
        units: of SI; or, where the joints have different ones, which of `JOINT_QUANTITIES` it is.
        long_name: what it is.
        always: whether it is there, as NaN, where the Diagram does not have its signal.
    """

    source: str
    column: int
    dims: tuple[str, ...]
    units: str
    long_name: str
    always: bool = True


_POSITIONS, _RATES = "joint_units", "joint_rate_units"
_EFFORTS, _ACCELERATIONS = "joint_effort_units", "joint_acceleration_units"
# Coordinates that hold the unit of each joint, by the unit of its position.
JOINT_QUANTITIES: Final[dict[str, dict[str, str]]] = {
    _POSITIONS: {"m": "m", "rad": "rad"},
    _RATES: {"m": "m/s", "rad": "rad/s"},
    _ACCELERATIONS: {"m": "m/s^2", "rad": "rad/s^2"},
    _EFFORTS: {"m": "N", "rad": "N m"},
}
_JOINT, _AXIS = ("joint",), ("axis",)
_STATES = "0 idle, 1 active, 2 clutch, 3 hold, 4 fault, 5 e-stop"


def _supervisor(who: str) -> dict[str, Signal]:
    """What a recording holds of the supervisor on a side, see `safety`."""
    source, columns = f"{who}_status", SUPERVISOR_STATUS.slices
    return {
        f"{who}_{name}": Signal(source, columns[name].start, (), "1", long_name, False)
        for name, long_name in (
            ("state", f"of the {who}'s supervisor: {_STATES}"),
            ("reason", f"why the {who}'s supervisor is in it, a code of `safety.Reason`"),
            ("engagements", f"how often the {who}'s side was engaged"),
            ("faults", f"how often the {who}'s side stopped by itself or by an e-stop"),
        )
    }


def _settings() -> dict[str, Signal]:
    """What a recording holds of what the operator changes during a run."""
    columns = LIVE_SETTINGS.slices
    return {
        f"live_{name}": Signal("live_settings", columns[name].start, (), unit, long_name, False)
        for name, unit, long_name in (
            ("delay_up", "s", "delay of the command that the operator added"),
            ("delay_down", "s", "delay of the force that the operator added"),
            ("force_scale", "1", "of the force that is felt, by the operator"),
            ("motion_scale", "1", "of the tool's travel, by the operator"),
            ("gain_scale", "1", "of the controller's gains, by the operator"),
        )
    }


def _policy() -> dict[str, Signal]:
    """What a recording holds of an operator who reacts, see `operator.policy`."""
    columns = POLICY_STATE.slices
    return {
        f"policy_{name}": Signal("policy_state", columns[name].start, (), unit, long_name, False)
        for name, unit, long_name in (
            ("phase", "1", "0 moves, 1 waits, 2 has done his work, 3 the picture stands still"),
            ("leg", "1", "stages of his work that the operator has done"),
            ("done_at", "s", "when the operator's work was done; negative before"),
        )
    }


def _cut() -> dict[str, Signal]:
    """What a recording holds of a pipe that is cut, see `cut_state.PipeState`."""
    columns = PIPE_STATE.slices
    return {
        name: Signal("pipe_cut", columns[entry].start, (), unit, long_name, False)
        for name, entry, unit, long_name in (
            ("blade_power", "power", "W", "power that the blade's motor gives"),
            ("blade_speed", "speed", "m/s", "speed of the blade's rim"),
            ("blade_stalled", "stalled", "1", "1 while the blade stands"),
            ("blade_bend", "bend", "m", "of the blade in its kerf, beyond the clearance"),
            ("energy_blade", "energy", "J", "that the blade's motor has given"),
            ("energy_cut", "energy_cut", "J", "of the material that is cut away"),
            ("energy_friction", "energy_friction", "J", "heat of the blade in its kerf"),
            ("volume_removed", "volume", "m^3", "that the blade has cut away"),
            ("cut_left", "left", "1", "share of the pipe's section that is left"),
            ("kerf_place", "place", "m", "of the kerf along the pipe, from its middle"),
        )
    }


def _playout(link: str) -> dict[str, Signal]:
    """What a recording holds of the buffer of a link, see `channel.layouts.PlayoutState`."""
    return {
        f"{name}_{link}": Signal(f"playout_{link}", column, (), unit, long_name, False)
        for column, (name, unit, long_name) in enumerate(
            (
                ("packets_late", "1", f"packets {link} so far that come after their time"),
                ("packets_late_used", "1", "how many of these were used, and not dropped"),
                ("packets_skipped", "1", "passed over by a buffer that became less deep"),
                ("playout_depth", "s", f"depth of the buffer of the {link}link"),
            )
        )
    }


SIGNALS: Final[dict[str, Signal]] = {
    "q_measured": Signal("state", 0, _JOINT, _POSITIONS, "joint positions of the plant"),
    "v_measured": Signal("state", 6, _JOINT, _RATES, "joint rates of the plant"),
    "q_desired": Signal("state_desired", 0, _JOINT, _POSITIONS, "joint position references"),
    "v_desired": Signal("state_desired", 6, _JOINT, _RATES, "joint rate references"),
    "tau_commanded": Signal("actuation_commanded", 0, _JOINT, _EFFORTS, "effort before limits"),
    "tau_applied": Signal("actuation", 0, _JOINT, _EFFORTS, "effort within the limits"),
    "sliding_variable": Signal("sliding_variable", 0, _JOINT, _RATES, "s of equation (27)"),
    "p_WE_measured": Signal("", 0, _AXIS, "m", "tool position of the plant"),
    "p_WE_desired": Signal("servo_state", 0, _AXIS, "m", "tool position of the references"),
    "p_WE_commanded": Signal("tool_command", 0, _AXIS, "m", "tool command before the channel"),
    "f_env_on_tool_W": Signal(
        "f_env_on_tool_W", 0, _AXIS, "N", "force of surfaces and pipe on the tool"
    ),
    "f_haptic": Signal("f_haptic", 0, _AXIS, "N", "that force after the channel"),
    "penetration": Signal("penetration", 0, ("surface",), "m", "depth of the tool in each surface"),
    "rumble": Signal("rumble", 0, ("motor",), "1", "strength of the motors, 0 to 1"),
    "joystick_axes": Signal("joystick_axes", 0, ("stick",), "1", "axes, -1 to 1"),
    "device_connected": Signal(
        "device_connected", 0, (), "1", "1 while the operator's device is there", False
    ),
    "delay_up": Signal("delay_up", 0, (), "s", "delay of the command"),
    "delay_down": Signal("delay_down", 0, (), "s", "delay of the force"),
    "status": Signal(
        "servo_state",
        SERVO_STATE.slices["status"].start,
        (),
        "1",
        "0 tracking, 1 holding, 2 target drawn into reach",
    ),
    "f_kinesthetic": Signal(
        "f_kinesthetic", 0, _AXIS, "N", "force on the hand by a kinesthetic device", False
    ),
    "x_master": Signal("motion_master", 0, _AXIS, "m", "motion of the master's device", False),
    "v_master": Signal("motion_master", 3, _AXIS, "m/s", "rate of the master's device", False),
    "x_master_measured": Signal(
        "motion_measured", 0, _AXIS, "m", "motion of the device, by its encoders", False
    ),
    "v_master_measured": Signal(
        "motion_measured", 3, _AXIS, "m/s", "rate of the device, by its driver", False
    ),
    "f_master": Signal(
        "f_master", 0, _AXIS, "N", "force of the device, before its actuators' limit", False
    ),
    "f_hand": Signal("f_hand", 0, _AXIS, "N", "force of the hand on the device", False),
    "hand_target": Signal("hand_target", 0, _AXIS, "m", "where the hand wants to be", False),
    "energy_master_in": Signal("energy_master", 0, _AXIS, "J", "taken from the hand", False),
    "energy_master_out": Signal("energy_master", 3, _AXIS, "J", "given to the hand", False),
    "energy_slave_in": Signal("energy_slave", 0, _AXIS, "J", "given back by the slave", False),
    "energy_slave_out": Signal("energy_slave", 3, _AXIS, "J", "given to the slave", False),
    "p_WE_received": Signal(
        "tool_command_received", 0, _AXIS, "m", "tool command after the channel", False
    ),
    "age_up": Signal("age_up", 0, (), "s", "age of the command in use", False),
    "age_down": Signal("age_down", 0, (), "s", "age of the force in use", False),
    "command_watch": Signal(
        "command_watch", 0, (), "1", "0 command passes, 1 lost, 2 waits or catches up", False
    ),
    "packets_sent_up": Signal("packet_counts_up", 0, (), "1", "packets sent up so far", False),
    "packets_lost_up": Signal(
        "packet_counts_up", 1, (), "1", "packets sent up, never to arrive", False
    ),
    "packets_sent_down": Signal(
        "packet_counts_down", 0, (), "1", "packets sent down so far", False
    ),
    "packets_lost_down": Signal(
        "packet_counts_down", 1, (), "1", "packets sent down that never arrive", False
    ),
    **_playout("up"),
    **_playout("down"),
    "saturation": Signal(
        "saturation", 0, _JOINT, "1", "1 outside the boundary layer, 2 effort limit, 3 both", False
    ),
    "q_governed": Signal(
        "state_desired_governed", 0, _JOINT, _POSITIONS, "references after the governor", False
    ),
    "tau_delivered": Signal(
        "actuation_delivered", 0, _JOINT, _EFFORTS, "effort after the lag of the drives", False
    ),
    "perturbation_estimate": Signal(
        "perturbation_estimate",
        0,
        _JOINT,
        _ACCELERATIONS,
        "perturbation seen by the observer",
        False,
    ),
    "v_estimated": Signal(
        "velocity_estimate", 0, _JOINT, _RATES, "joint rates seen by the observer", False
    ),
    "f_estimated_W": Signal(
        "f_estimated_W", 0, _AXIS, "N", "force on the tool without a sensor", False
    ),
    "p_WE_seen": Signal("tool_seen", 0, _AXIS, "m", "tool position as the operator sees it", False),
    "age_view": Signal("age_view", 0, (), "s", "age of the picture that the operator sees", False),
    **_policy(),
    "orientation_axes": Signal(
        "orientation_axes", 0, ("rotation",), "1", "axes that turn the tool, -1 to 1", False
    ),
    "operator_buttons": Signal(
        "operator_buttons", 0, ("button",), "1", "1 while a button is down", False
    ),
    "device_age": Signal(
        "device_status",
        DEVICE_STATUS.slices["age"].start,
        (),
        "s",
        "since the operator's device last spoke",
        False,
    ),
    "lateness": Signal(
        "device_status",
        DEVICE_STATUS.slices["lateness"].start,
        (),
        "s",
        "of the simulation behind the clock",
        False,
    ),
    **_cut(),
    "blade_force_W": Signal(
        "blade_force_W", 0, _AXIS, "N", "force of the pipe on the blade", False
    ),
    "bad_samples": Signal(
        "device_status",
        DEVICE_STATUS.slices["bad_samples"].start,
        (),
        "1",
        "how many samples of the device in a row were dropped",
        False,
    ),
    **_settings(),
    **_supervisor("operator"),
    **_supervisor("robot"),
}
# Which Diagrams have a signal that others do not: by the signal, where it is not there always.
PRESENT: Final[dict[str, str]] = {
    "device_connected": "the operator's device is a live one",
    "f_kinesthetic": "the scenario has `kinesthetic`",
    "motion_master": "the operator is a `!Master`",
    "motion_measured": "the device of a `!Master` has encoders with a resolution",
    "f_master": "the operator is a `!Master`",
    "f_hand": "the operator is a `!Master`",
    "hand_target": "the operator is a `!Master`",
    "energy_master": "the operator is a `!Master`",
    "energy_slave": "the operator is a `!Master`",
    "tool_command_received": "a command crosses the channel",
    "age_up": "the uplink has packets",
    "age_down": "the downlink has packets",
    "command_watch": "the scenario has `channel.watch`",
    "packet_counts_up": "the uplink has packets",
    "packet_counts_down": "the downlink has packets",
    "playout_up": "the uplink has a `playout`",
    "playout_down": "the downlink has a `playout`",
    "saturation": "the controller is neither `!InverseDynamics` nor your own",
    "state_desired_governed": "the scenario has a `governor`",
    "actuation_delivered": "the scenario has `drives.lag`",
    "perturbation_estimate": "the controller is an `!ObserverSlidingMode`",
    "velocity_estimate": "the controller is an `!ObserverSlidingMode`",
    "f_estimated_W": "the controller is an `!ObserverSlidingMode` and there is a surface",
    "tool_seen": "the operator is a `!Trainee`, or a `!Master` with a `policy`",
    "age_view": "the operator has a `policy` and the downlink has packets",
    "policy_state": "the operator has a `policy`",
    "pipe_cut": "the scenario has `environment.cut`",
    "blade_force_W": "the scenario has `environment.cut`",
    "orientation_axes": "the operator is supervised",
    "operator_buttons": "the operator is supervised",
    "device_status": "the operator is supervised",
    "live_settings": "the operator is supervised",
    "operator_status": "the operator is supervised",
    "robot_status": "the operator is supervised",
}
# What a recording says of itself.
ATTRIBUTES: Final[dict[str, str]] = {
    "scenario_name": "name of the scenario",
    "scenario": "the whole scenario as YAML text: a file of it runs again",
    "seed": "of all random draws",
    "versions": "of Python and of the packages that made it, JSON",
    "engine": "what ran the Diagram: `drake` or `compiled`",
    "engine_reason": "why it was not the other, where there is a reason",
    "device": "the operator's device, or the trace in its place",
    "packet_numbers_up": "how many numbers are in a packet up, with all that the receiver gets",
    "packet_numbers_down": "the same of a packet down",
    "score": "of its task, 0 to 100, see [training](training.md)",
    "score_table": "its criteria with values, bounds and points, JSON",
    "ended_by": "what ended the run: `duration`, an interrupt, an error, `cut off`, damage",
    "ended_at": "when it ended [s]",
    "ticks": "of a run in real time: how many there were",
    "late_ticks": "of these, how many were done more than 1 ms behind the clock",
    "lateness_p99": "99 % of the ticks were less behind the clock [s]; below zero, it waited",
    "lateness_p999": "the same of 99.9 % [s]",
    "lateness_worst": "the largest [s]",
    "overruns": "how often the real-time factor was below 0.9 for a second",
    "clock_restarts": "how often the pacing began afresh, 0.2 s behind",
    "time_given_up": "how much time was given up in these [s]",
    "pictures_dropped": "how many pictures of the scene gave way, as the run was behind",
    "first_posture_method": "who found the posture that the arm started from, if one was searched",
    "first_posture_evaluations": "in how many evaluations",
    "first_posture_seconds": "in which time [s]; it differs from run to run",
    "Conventions": "of the metadata: CF",
    "format_version": "of the files; those of before are read too",
    "comment": "on units and frames",
}
