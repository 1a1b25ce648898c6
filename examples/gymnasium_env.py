"""The Diagram as an environment of Gymnasium, by Drake's own DrakeGymEnv over its ports.

Action (5) is the stick: x, y, z, axis and hat of the mast, each -1 to 1. Observation (15) is the
state, q and v, and the force on the tool [N]. The reward is largest where the tool presses the wall
with 40 N. A reset puts the wall somewhere else, where the seed says. The policy here is integral
control of the force. Needs the extra `gym`.

    python examples/gymnasium_env.py
"""

from typing import Any

import gymnasium
import numpy as np
from pydrake.common import RandomGenerator
from pydrake.gym import DrakeGymEnv
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, System
from pydrake.systems.primitives import Multiplexer

import scara_drake as sd

STEP, STEPS = 0.05, 100  # [s] from action to action, and how many there are in an episode
WANTED, STIFFNESS = 40.0, 1e4  # [N], [N/m] of the wall
NEAREST, SPREAD = -0.95, 0.1  # where the wall may be [m]
APPROACH, GAIN = 0.01, 0.5  # of the stick, per step until it touches, per metre that is missing
MOST = np.array([20.0] * 6 + [10.0] * 6 + [1e4] * 3)  # of the observation, m, rad, s and N
PARTS = {"state": 12, "f_env_on_tool_W": 3}


def make_simulator(generator: RandomGenerator) -> Simulator:
    """Build the Diagram with its stick as input and the observation as output."""
    operator = {"_tag": "!External", "mapping": {"smoothing": 0.0}}
    scenario = sd.load_scenario("teleoperation", {"operator": operator})
    away = SPREAD * np.random.default_rng(generator()).uniform()
    scenario.environment.surfaces[0].point[1] = NEAREST - float(away)  # type: ignore[union-attr]
    builder = DiagramBuilder()
    robot = builder.AddNamedSystem("robot", sd.make_diagram(scenario))
    seen = builder.AddNamedSystem("seen", Multiplexer(list(PARTS.values())))
    for index, name in enumerate(PARTS):
        builder.Connect(robot.GetOutputPort(name), seen.get_input_port(index))
    builder.ExportInput(robot.GetInputPort("joystick_axes"), "stick")
    builder.ExportOutput(seen.get_output_port(), "observation")
    return Simulator(builder.Build())


def start(simulator: Simulator, context: Context, seed: int | None) -> None:
    """Run what the systems do at the start: a reset of DrakeGymEnv undoes it."""
    simulator.Initialize()


def reward(system: System, context: Context) -> float:
    """How far the force is from the wanted one, none being -1."""
    force = np.linalg.norm(system.GetOutputPort("observation").Eval(context)[12:])
    return -abs(float(force) - WANTED) / WANTED


def make_env() -> gymnasium.Env[np.ndarray, np.ndarray]:
    """Return the environment, which ends after `STEPS` steps."""
    env = DrakeGymEnv(
        simulator=make_simulator,
        time_step=STEP,
        action_space=gymnasium.spaces.Box(-1.0, 1.0, (5,), np.float64),
        observation_space=gymnasium.spaces.Box(-MOST, MOST, dtype=np.float64),
        reward=reward,
        action_port_id="stick",
        observation_port_id="observation",
        reset_handler=start,  # type: ignore[arg-type]  # it is given the seed too
    )
    return gymnasium.wrappers.TimeLimit(env, STEPS)


def episode(env: gymnasium.Env[np.ndarray, np.ndarray], seed: int) -> list[Any]:
    """Press the wall; return what was seen and the reward, step by step."""
    observation, _ = env.reset(seed=seed)
    steps, stick, done = [], 0.0, False
    while not done:
        force = float(np.linalg.norm(observation[12:]))
        forward = APPROACH if force == 0.0 else GAIN * (WANTED - force) / STIFFNESS
        stick = max(stick - forward, -1.0)
        action = np.array([0.0, stick, 0.0, 0.0, 0.0])
        observation, gained, terminated, truncated, _ = env.step(action)
        steps.append((observation, float(gained)))
        done = terminated or truncated
    return steps


if __name__ == "__main__":
    env = make_env()
    for seed in (1, 3):
        steps = episode(env, seed)
        force = float(np.linalg.norm(steps[-1][0][12:]))
        touched = next(k for k, (seen, _) in enumerate(steps) if any(seen[12:]))
        print(f"seed {seed}: touched in step {touched} of {len(steps)}, at the end {force:.2f} N")
