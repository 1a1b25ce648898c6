"""The robot as an environment of reinforcement learning: reset, and step with a stick.

The operator is `External`, so the Diagram has an input port `joystick_axes`; what the policy sees
comes from its output ports, the distance to the wall from `query_object`, as a camera's picture
would. The names are Gymnasium's, which is not needed. The policy here presses the wall with 40 N.

    python examples/step_loop.py
"""

from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator

import scara_drake as sd

STEP = 0.05  # [s] from action to action
HALF_TICK = 0.0005  # [s]: a step ends between two ticks, so that rounding skips none
WANTED, STIFFNESS = 40.0, 1e4  # [N], [N/m] of the wall
GAIN = 0.5  # of the stick per metre that is missing
KEYS = ("p_x", "p_y", "p_z", "distance", "force")


class PressEnv:
    """Observation (5): tool point [m], its distance to the wall [m], force on it [N].

    Action (5): x, y, z of the stick, axis and hat of the mast, each -1 to 1.
    Reward of a step: -|force - wanted| / wanted.
    """

    def __init__(self, duration: float = 6.0):
        operator = {"_tag": "!External", "mapping": {"smoothing": 0.0}}
        self.scenario = sd.load_scenario("teleoperation", {"operator": operator})
        self.scenario.channel.up.delay = self.scenario.channel.down.delay = 0.0  # type: ignore[union-attr]
        self.diagram = sd.make_diagram(self.scenario)
        self.duration = duration

    def reset(self, seed: int | None = None) -> tuple[np.ndarray, dict[str, Any]]:
        """Start again; nothing in the scenario is drawn, so the seed changes nothing."""
        self.simulator = Simulator(self.diagram)
        self.context = self.simulator.get_mutable_context()
        self.stick = self.diagram.GetInputPort("joystick_axes")
        self.stick.FixValue(self.context, np.zeros(5))
        self.simulator.Initialize()
        return self.observe(), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Hold the stick for a step; return observation, reward, terminated, truncated, info."""
        self.stick.FixValue(self.context, action)
        steps = round(self.context.get_time() / STEP) + 1
        self.simulator.AdvanceTo(steps * STEP + HALF_TICK)
        observation = self.observe()
        reward = -abs(observation[KEYS.index("force")] - WANTED) / WANTED
        return observation, reward, False, steps * STEP >= self.duration, {}

    def observe(self) -> np.ndarray:
        """Read the output ports."""
        joints = self.read("state")[:6]
        tool = sd.kinematics.forward_kinematics(joints)[:3, 3]
        near = self.read("query_object").ComputeSignedDistanceToPoint(tool)
        name_of = self.read("query_object").inspector().GetName
        (wall,) = (each for each in near if "wall" in name_of(each.id_G))
        force = float(np.linalg.norm(self.read("f_env_on_tool_W")))
        return np.array([*tool, wall.distance, force])

    def read(self, name: str) -> Any:
        """Return what an output port of the Diagram shows now."""
        return self.diagram.GetOutputPort(name).Eval(self.context)


def policy(observation: np.ndarray, stick: float) -> float:
    """Move the stick forward until the wall pushes back as wanted: integral control."""
    distance, force = observation[3:]
    to_go = max(distance, 0.0) + (WANTED - force) / STIFFNESS
    return float(np.clip(stick - GAIN * min(to_go, 0.03), -1.0, 1.0))


env = PressEnv()
observation, info = env.reset()
print(f"at the start the wall is {1e3 * observation[3]:.1f} mm away, the force {observation[4]} N")
stick, rewards, done = 0.0, [], False
while not done:
    stick = policy(observation, stick)
    observation, reward, _, done, info = env.step(np.array([0.0, stick, 0.0, 0.0, 0.0]))
    rewards.append(reward)
print(f"at the end {observation[3] * 1e3:.3f} mm, force {observation[4]:.3f} N of {WANTED} N")
print(f"steps {len(rewards)}, reward of the last one {rewards[-1]:.4f}")
