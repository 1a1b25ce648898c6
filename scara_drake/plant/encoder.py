"""Position sensors: what they show is rounded, noisy, and has no velocity but an estimated one."""

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import BasicVector, Context, LeafSystem, State

from scara_drake.common import checks
from scara_drake.common.draws import normal
from scara_drake.common.state import declare_state

Array = NDArray[np.float64]

# Rows of the parameters (2, 6).
RESOLUTION, NOISE = range(2)


@njit(cache=True)
def encoder_sample(
    state: Array,
    parameters: Array,
    seed: int,
    period: float,
    decay: float,
    memory: Array,
    measured: Array,
) -> None:
    """Write what the encoders show (12,) of a state (12,).

    Args:
        state: q, v of the plant.
        parameters: (2, 6), rows resolution and noise [m, rad].
        seed: of the noise.
        period: [s].
        decay: exp(-bandwidth period).
        memory: (13,): how many samples were taken before, and the last of them.
        measured: (12,), written.
    """
    for i in range(6):
        q, resolution = state[i], parameters[RESOLUTION, i]
        if parameters[NOISE, i] > 0.0:
            q += parameters[NOISE, i] * normal(seed, int(memory[0]) * 6 + i)
        if resolution > 0.0:
            q = resolution * np.rint(q / resolution)
        measured[i] = q
        if memory[0] == 0.0:
            measured[6 + i] = state[6 + i]
        else:
            slope = (q - memory[1 + i]) / period
            measured[6 + i] = slope + decay * (memory[7 + i] - slope)


@dataclass
class Encoder:
    """Position sensors at the joints; velocities are estimated from what they show.

    The defaults are those of magnetic absolute encoders: a linear scale of 1 µm, rings of 19 bit.

    Attributes:
        resolution: size of a count [m, rad]; 0 is infinitely fine.
        noise: standard deviation of a sample, before it is rounded to a count [m, rad].
        velocity_bandwidth: w of the first-order dirty derivative w s / (s + w) [rad/s].
    """

    resolution: list[float] = field(default_factory=lambda: [1e-6] + [2.0 * math.pi / 2**19] * 5)
    noise: list[float] = field(default_factory=lambda: [0.0] * 6)
    velocity_bandwidth: float = 1000.0  # [rad/s]

    def validate(self, name: str) -> None:
        """Check the fields; `name` is the path in the scenario.

        Raises:
            ValueError: a number out of its range.
        """
        checks.vector(f"{name}.resolution", self.resolution, 6, 0.0, 0.1)
        checks.vector(f"{name}.noise", self.noise, 6, 0.0, 0.1)
        checks.number(f"{name}.velocity_bandwidth", self.velocity_bandwidth, 1.0, 1e5)

    def make_system(self, period: float, seed: int) -> "EncoderSystem":
        """Return the sensors, sampled every `period` [s]."""
        return EncoderSystem(self, period, seed)


class EncoderSystem(LeafSystem):
    """The position sensors of the six joints, and the velocity estimated from them.

    Input port:
        state (12): q, v of the plant [m, rad, m/s, rad/s]
    Output port, a function of the input and of the memory:
        state_measured (12): with h the period and a = exp(-w h),
            q: the position with noise, rounded to a count
            v <- a v + (1 - a) (q - q of the sample before) / h
    Update (every period): the memory takes over the output. The derivative is exact for a position
        that moves on straight lines between samples.
    Initial: v is the true one: the estimator has settled before t = 0, and does not kick.

    The update is unrestricted, like the step of a plant with sampled ports: it happens while the
    plant still shows the state of the sample before. So in the discrete updates that follow, and in
    the publish events of the next tick, the memory ends before the state that the plant shows, and
    both see the same sample. The noise depends on the seed and the count of samples only.

    Args:
        encoder: checked.
        period: [s].
        seed: of the noise.
    """

    def __init__(self, encoder: Encoder, period: float = 1e-3, seed: int = 0):
        super().__init__()
        self._parameters = np.array([encoder.resolution, encoder.noise], dtype=np.float64)
        decay = math.exp(-encoder.velocity_bandwidth * period)
        self._constants = (seed, period, decay)
        self._state = self.DeclareVectorInputPort("state", 12)
        self._memory = declare_state(self, 13)
        self._measured = self.DeclareVectorOutputPort(
            "state_measured",
            12,
            self._measure,
            prerequisites_of_calc={self.all_input_ports_ticket(), self.xd_ticket()},
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._advance)

    def _measure(self, context: Context, output: BasicVector) -> None:
        encoder_sample(
            self._state.Eval(context),
            self._parameters,
            *self._constants,
            context.get_discrete_state(self._memory).value(),
            output.get_mutable_value(),
        )

    def _advance(self, context: Context, state: State) -> None:
        memory = state.get_mutable_discrete_state().get_mutable_value(self._memory)
        memory[0] += 1.0
        memory[1:] = self._measured.Eval(context)
