"""Scenarios that between them have every part that the engine compiles; see `both` in engines.py.

Each is a shipped scenario with changes, so that what it is about happens in its first 0.4 s.
"""

from __future__ import annotations

from typing import Any

from scara_drake import load_scenario
from scara_drake.scenario import Scenario, scenario_names

Changes = dict[str, Any]

# A hand that is at the wall, 1 cm away, after 0.1 s.
PRESS: Changes = {
    "operator.times": [0.02, 0.12, 6.0, 7.0],
    "operator.hand_stiffness": 600.0,
    "channel.up": "!ConstantDelay {delay: 0.02}",
    "channel.down": "!ConstantDelay {delay: 0.015}",
    "inverse_kinematics.max_acceleration": 50.0,
}
JITTER = (
    "!Packets {delay: !ConstantDelay {delay: 0.01}, send_period: 0.002, longest: 0.2,"
    " jitter: {distribution: gamma, mean: 0.004, std: 0.002},"
    " loss: {in_good: 0.05, to_bad: 0.02, to_good: 0.2}}"
)
LOSSY: Changes = {**PRESS, "channel.up": JITTER, "channel.down": JITTER}
# A wall that comes to the tool of an operator whose trace begins with free motion.
COMES: Changes = {
    "environment.surfaces.0.point": [0.8, -0.765, 3.0],
    "environment.surfaces.0.motion": "!ConstantVelocity {velocity: [0.0, 0.1, 0.0]}",
}

COUPLINGS = (
    "Direct", "ScaledForce", "PositionDamping", "FourChannel", "WaveVariables", "Tdpa",
    "ModelMediated",
)  # fmt: skip
CONTROLLERS = (
    "!IntegralSlidingMode {}",
    "!IntegralSlidingMode {mode: paper, phi: 10.0, allow_chatter: true, anti_windup: false}",
    "!IntegralSlidingMode {acceleration_feedforward: true, gravity_compensation: true}",
    "!SlidingMode {}",
    "!Pid {}",
)
FOLLOWING = ("robust", "inverse_jacobian", "dpsoij")
SURFACES = {
    "wall": "!Wall {point: [0.8, -1.05, 3.0]",
    "box": "!Box {centre: [0.8, -1.15, 3.0]",
    "cylinder": "!Cylinder {point: [0.8, -1.15, 3.0]",
}
LAWS = ("impedance", "hunt_crossley")
MOTIONS = {
    "still": "",
    "drifting": ", motion: !ConstantVelocity {velocity: [0.0, 0.02, 0.0]}",
    "waving": ", motion: !SineMotion {amplitude: 0.005, frequency: 3.0}",
}
SINE = "!SineDelay {amplitude: 0.01, offset: 0.01, frequency: 9.0}"


def _couplings() -> dict[str, tuple[str, Changes]]:
    return {
        f"{kind}, {channel}": ("bilateral", {**changes, "coupling": f"!{kind} {{}}"})
        for kind in COUPLINGS
        for channel, changes in (("constant delay", PRESS), ("jitter with loss", LOSSY))
    }


def _codecs() -> dict[str, tuple[str, Changes]]:
    return {
        f"{kind}, dead band": (
            "bilateral",
            {**LOSSY, "coupling": f"!{kind} {{}}", "channel.codec": "{keep_alive: 0.02}"},
        )
        for kind in COUPLINGS
    }


def _surfaces() -> dict[str, tuple[str, Changes]]:
    return {
        f"{motion} {surface}, {law}": (
            "bilateral",
            {**PRESS, "environment.surfaces": f"[{text}, law: {law}{MOTIONS[motion]}}}]"},
        )
        for surface, text in SURFACES.items()
        for law in LAWS
        for motion in MOTIONS
    }


CASES: dict[str, tuple[str, Changes]] = {
    **{name: (name, {}) for name in scenario_names()},
    **_couplings(),
    **_codecs(),
    **_surfaces(),
    **{f"controller {c[1:]}": ("joint_sine", {"controller": c}) for c in CONTROLLERS},
    **{
        f"inverse kinematics {m}": ("teleoperation", {"inverse_kinematics.method": m, **COMES})
        for m in FOLLOWING
    },
    # A blade that is in the pipe by a quarter of a millimetre from the start.
    "cut pipe": ("cut_pipe", {"environment.cut.point": [0.8, -0.8978, 3.0]}),
    "cut pipe, wall": (
        "cut_pipe",
        {
            "environment.cut.point": [0.8, -0.8978, 3.0],
            "environment.surfaces": "[!Wall {point: [0.8, -0.8605, 3.0]}]",
            "task": None,
        },
    ),
    # Encoders, and friction that sticks.
    "device touch": ("bilateral", {**PRESS, "operator.device": "touch"}),
    "device of one's own": (
        "bilateral",
        {
            **PRESS,
            "operator.friction": 0.5,
            "operator.resolution": 1e-5,
            "operator.workspace": 0.05,
        },
    ),
    "no surface": ("bilateral", {"environment.surfaces": "[]"}),
    "two surfaces": (
        "bilateral",
        {
            **PRESS,
            "environment.surfaces": (
                f"[{SURFACES['wall']}}}, {SURFACES['cylinder']}, name: other, direction: [0, 0, 1],"
                " motion: !SineMotion {frequency: 2.0}}]"
            ),
        },
    ),
    "governed stick": ("teleoperation", {**COMES, "governor": "{}"}),
    "full joints, pose": (
        "teleoperation",
        {**COMES, "inverse_kinematics.joints": "full", "inverse_kinematics.task": "pose"},
    ),
    **{
        f"policy {kind}": (
            "bilateral",
            {
                "operator.policy": f"!{kind} {{work: !Reach {{places: [[0.0, -0.03, 0.0]]}}}}",
                "channel.up": "!ConstantDelay {delay: 0.01}",
                "channel.down": JITTER,
            },
        )
        for kind in ("MoveAndWait", "Continuous")
    },
    "kinesthetic": ("teleoperation", {**COMES, "kinesthetic": "{}"}),
    "haptics at 7 ms": ("teleoperation", {**COMES, "haptics.period": 0.014}),
    "stick at 7 ms": ("teleoperation", {**COMES, "operator.sample_period": 0.007}),
    "preset 5g": ("teleoperation", {**COMES, "channel.preset": "5g"}),
    "preset paper_2s": ("teleoperation", {**COMES, "channel.preset": "paper_2s"}),
    "command watch": (
        "teleoperation",
        {**COMES, "channel.up": JITTER, "channel.watch": "{age_limit: 0.02, afterwards: follow}"},
    ),
    "catching up": (
        "teleoperation",
        {
            **COMES,
            "channel.up": JITTER.replace("send_period", "outages: [0.1, 0.2], send_period"),
            "channel.watch": "{age_limit: 0.02, afterwards: catch_up}",
        },
    ),
    "buffers": (
        "bilateral",
        {
            **LOSSY,
            "coupling": "!WaveVariables {}",
            "channel.up.playout": "{depth: 0.014}",
            "channel.down.playout": "{kind: adaptive, percentile: 90.0, window: 50.0}",
        },
    ),
    "supervised, any delay": ("teleoperation", {**COMES, "supervision": "{}"}),
    # A trace without buttons is engaged from the start; the link is lost at 0.12 s.
    "supervised, link lost": (
        "supervised",
        {
            **COMES,
            "operator.trace": "operator_trace.csv",
            "operator.mapping.dead_zone": 0.0,
            "channel.up.outages": [0.12, 0.2],
            "supervision.robot.age_limit": 0.03,
            "supervision.robot.after_outage": "resume",
        },
    ),
    "lag": ("joint_sine", {"drives.lag": "{}"}),
    "friction": ("joint_sine", {"drives.friction": "{}"}),
    "exact encoder": ("joint_sine", {"drives.encoder": "{resolution: 0.0}"}),
    "perturbation": ("joint_sine", {"perturbation": "{offset: 2.0, amplitude: 5.0, start: 0.1}"}),
    "governor": (
        "joint_sine",
        {
            "governor": "{}",
            "robot.payload_mass": 60.0,
            "controller": "!Pid {}",
            "operator.move_duration": 2.0,
            "operator.start": 0.0,
        },
    ),
    "delayed process": (
        "joint_sine",
        {
            "process_delay": "{actuation: !ConstantDelay {delay: 0.001}, reference: " + SINE + ","
            " measurement: !ConstantDelay {delay: 0.001}}",
        },
    ),
    "all that drives add": (
        "bilateral",
        {
            **PRESS,
            "drives": "{lag: {}, friction: {}, encoder: {resolution: 0.0}}",
            "perturbation": "{amplitude: 1.0}",
        },
    ),
    "scaled robot": ("joint_sine", {"robot.mass_scale": [0.7, 1.2, 1.1, 0.9, 1.5, 1.0]}),
    "logged each 7 ms": ("teleoperation", {**COMES, "logging.period": 0.007}),
    "logged each 1/3 s": ("bilateral", {**PRESS, "logging.period": 0.1 / 3.0}),
    "steps of 0.5 ms": ("bilateral", {**PRESS, "time_step": 0.5e-3}),
    "steps of 2 ms": ("joint_sine", {"time_step": 2e-3, "controller.phi": 5.0}),
    "steps of 2 ms, stick": ("teleoperation", {**COMES, "time_step": 2e-3, "controller.phi": 5.0}),
    "steps of 2 ms, stick at 1 ms": (
        "teleoperation",
        {**COMES, "time_step": 2e-3, "controller.phi": 5.0, "operator.sample_period": 1e-3},
    ),
    "steps of 0.7 ms": ("teleoperation", {**COMES, "time_step": 0.7e-3}),
}  # fmt: skip

# Of few structures, for each is compiled once.
QUICK = [
    *scenario_names(),
    *_surfaces(),
    "cut pipe",
    "Tdpa, jitter with loss",
    "Tdpa, dead band",
    "device touch",
    "WaveVariables, constant delay",
    "controller Pid {}",
    "all that drives add",
    "governed stick",
    "policy MoveAndWait",
    "delayed process",
    "command watch",
    "buffers",
    "supervised, link lost",
    "logged each 1/3 s",
    "steps of 0.5 ms",
    "steps of 2 ms, stick at 1 ms",
    "steps of 0.7 ms",
]


def scenario_of(name: str, duration: float) -> Scenario:
    """A case, for a duration [s]."""
    base, changes = CASES[name]
    return load_scenario(base, {**changes, "duration": duration})
