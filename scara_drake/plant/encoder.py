"""Position sensors: what they show is rounded, noisy, and has no velocity but an estimated one."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.common.draws import normal
from scara_drake.common.fields import number, vector
from scara_drake.common.layout import Cell, Layout
from scara_drake.common.scratch import scratch

Array = NDArray[np.float64]


@dataclass
class Encoder:
    """Position sensors at the joints; velocities are estimated from what they show.

    The defaults are those of magnetic absolute encoders: a linear scale of 1 µm, rings of 19 bit.

    Attributes:
        resolution: size of a count; 0 is infinitely fine.
        noise: standard deviation of a sample, before it is rounded to a count.
        velocity_bandwidth: w of the first-order dirty derivative w s / (s + w).
    """

    resolution: list[float] = vector([1e-6] + [2.0 * math.pi / 2**19] * 5, "m | rad", 0.0, 0.1)
    noise: list[float] = vector([0.0] * 6, "m | rad", 0.0, 0.1)
    velocity_bandwidth: float = number(1000.0, "rad/s", 1.0, 1e5)

    def parameters(self, period: float) -> Array:
        """Return the sensors over a period [s] as `sensors_of` reads them."""
        return SENSORS.pack(
            resolution=self.resolution,
            noise=self.noise,
            period=period,
            decay=math.exp(-self.velocity_bandwidth * period),
        )

    def make_system(self, period: float, seed: int) -> "EncoderSystem":
        """Return the sensors, sampled every `period` [s]."""
        return EncoderSystem(self, period, seed)


class Sensors(NamedTuple):
    """`Encoder` in a kernel.

    Attributes:
        resolution: (6,) [m, rad].
        noise: (6,) [m, rad].
        period: h [s].
        decay: exp(-w h).
    """

    resolution: Array
    noise: Array
    period: float
    decay: float


class Samples(NamedTuple):
    """Memory of the sensors.

    Attributes:
        count: of the samples that were taken before.
        last: of them, q and v (12,).
    """

    count: Cell
    last: Array


SENSORS = Layout(Sensors, resolution=6, noise=6)
SAMPLES = Layout(Samples, count=(), last=12)
sensors_of = SENSORS.reader()
samples_of = SAMPLES.reader()


@njit(cache=True)
def encoder_sample(
    state: Array, sensors: Array, seed: int, samples: Array, state_measured: Array
) -> None:
    """Write what the encoders show (12,) of a state (12,).

    Args:
        state: q, v of the plant.
        sensors: of `Encoder.parameters`.
        seed: of the noise.
        samples: memory, see `Samples`; not written.
        state_measured: written.
    """
    e, m = sensors_of(sensors), samples_of(samples)
    count = m.count[()]
    q_last, v_last = m.last[:6], m.last[6:]
    for i in range(6):
        q, resolution = state[i], e.resolution[i]
        if e.noise[i] > 0.0:
            q += e.noise[i] * normal(seed, int(count) * 6 + i)
        if resolution > 0.0:
            q = resolution * np.rint(q / resolution)
        state_measured[i] = q
        if count == 0.0:
            state_measured[6 + i] = state[6 + i]
        else:
            slope = (q - q_last[i]) / e.period
            state_measured[6 + i] = slope + e.decay * (v_last[i] - slope)


@njit(cache=True)
def encoder_step(state: Array, sensors: Array, seed: int, samples: Array) -> None:
    """Take over into the memory what the encoders show of a state (12,)."""
    measured = scratch(12)
    encoder_sample(state, sensors, seed, samples, measured)
    m = samples_of(samples)
    m.count[()] += 1.0
    m.last[:] = measured


class EncoderSystem(Block):
    """The position sensors of the six joints, and the velocity estimated from them.

    Ports:
        input state (12) [m, rad, m/s, rad/s]: q, v of the plant.
        output state_measured (12) [m, rad, m/s, rad/s], of the input and of the memory: with h the
            period and a = exp(-w h),
            q: the position with noise, rounded to a count
            v <- a v + (1 - a) (q - q of the sample before) / h

    Update, at t = k h: the memory takes over the output. The derivative is exact for a position
    that moves on straight lines between samples. Initial: v is the true one: the estimator has
    settled before t = 0, and does not kick.

    The update is unrestricted, like the step of a plant with sampled ports: it happens while the
    plant still shows the state of the sample before. So in the discrete updates that follow, and in
    the publish events of the next tick, the memory ends before the state that the plant shows, and
    both see the same sample. The noise depends on the seed and the count of samples only.

    Args:
        encoder: checked.
        period: [s].
        seed: of the noise.
    """

    def __init__(self, encoder: Encoder, period: float = 1e-3, seed: int = 0) -> None:
        super().__init__(
            Declaration(
                inputs={"state": Input(12)},
                memory={"samples": Memory(SAMPLES.size)},
                outputs={"state_measured": Output(12, encoder_sample)},
                parameters={"sensors": encoder.parameters(period), "seed": seed},
                period=period,
                update=encoder_step,
                with_plant=True,
            )
        )
