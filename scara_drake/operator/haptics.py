"""From the contact force to the two motors of a joystick.

The force's magnitude has one sensation, so it is made graded and two-fold: the low frequency motor
holds a level for a sustained force, logarithmic because the skin resolves ratios (Weber); the high
frequency motor gives a short burst where the force changes fast, which is what tells hard from soft
at an impact (event-based haptics).
"""

import math
from dataclasses import astuple, dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from scara_drake.common import checks
from scara_drake.common.state import declare_state
from scara_drake.operator.devices import Device

Array = NDArray[np.float64]

PULSE = 150  # [ms] of one rumble: longer than a period, and it stops by itself if a run dies
# The publish event of the device sees the state before an update of its own time: come just after.
PUBLISH_OFFSET = 1e-3  # [s]


@dataclass
class HapticMapping:
    """How the force shakes the joystick; motor levels are 0..1."""

    force_threshold: float = 5.0  # [N], where the low motor starts
    release_ratio: float = 0.8  # of the threshold, where it stops
    force_full: float = 250.0  # [N], where it is at its highest
    curvature: float = 20.0  # of the logarithm; small is nearly linear
    level_minimum: float = 0.12  # at the threshold: less does not turn such a motor
    impact_threshold: float = 300.0  # [N/s], where the high motor starts
    impact_full: float = 6000.0  # [N/s], where it is at its highest
    burst_time: float = 0.08  # [s], time constant of a burst's decay
    slew_up: float = 8.0  # [1/s], fastest rise of a level
    slew_down: float = 20.0  # [1/s], fastest fall
    period: float = 0.033  # [s], about 30 Hz, on the ticks of the 1 kHz loop

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: one line that names the field, its value and what is allowed.
        """
        checks.number(f"{name}.force_threshold", self.force_threshold, 0.0, 1e5)
        checks.number(f"{name}.release_ratio", self.release_ratio, 0.0, 1.0)
        lowest = max(1.001 * self.force_threshold, 1e-3)
        checks.number(f"{name}.force_full", self.force_full, lowest, 1e6)
        checks.number(f"{name}.curvature", self.curvature, 1e-3, 1e4)
        checks.number(f"{name}.level_minimum", self.level_minimum, 0.0, 1.0)
        checks.number(f"{name}.impact_threshold", self.impact_threshold, 0.0, 1e8)
        lowest = max(1.001 * self.impact_threshold, 1e-3)
        checks.number(f"{name}.impact_full", self.impact_full, lowest, 1e9)
        checks.number(f"{name}.burst_time", self.burst_time, 1e-3, 1.0)
        checks.number(f"{name}.slew_up", self.slew_up, 0.1, 1e3)
        checks.number(f"{name}.slew_down", self.slew_down, 0.1, 1e3)
        checks.number(f"{name}.period", self.period, 0.01, 0.1)

    def parameters(self) -> Array:
        """The fields in their order (11,), for the kernels."""
        return np.array(astuple(self), dtype=np.float64)


@njit(cache=True)
def sustained_level(force: float, parameters: Array) -> float:
    """Level 0..1 of the low motor for a force [N] that has passed the threshold.

    ``I_min + (1 - I_min) ln(1 + mu x) / ln(1 + mu)``, with x the force from its threshold (0) to
    full (1), clipped.
    """
    threshold, full, mu, lowest = parameters[0], parameters[2], parameters[3], parameters[4]
    x = min(max((force - threshold) / (full - threshold), 0.0), 1.0)
    return lowest + (1.0 - lowest) * math.log1p(mu * x) / math.log1p(mu)


@njit(cache=True)
def impact_level(rate: float, parameters: Array) -> float:
    """Level 0..1 of the high motor for a rate of force [N/s]: linear from its threshold."""
    threshold, full = parameters[5], parameters[6]
    return min(max((abs(rate) - threshold) / (full - threshold), 0.0), 1.0)


@njit(cache=True)
def step_haptics(force: Array, parameters: Array, memory: Array, rumble: Array) -> None:
    """One tick of the mapping, in place; a force that is not finite counts as none.

    Args:
        force: (3,) [N].
        parameters: (11,), of `HapticMapping.parameters`.
        memory: (3,): last |force| [N], 1 while the low motor is engaged or 0, burst level 0..1.
        rumble: (2,): low and high level 0..1.
    """
    period = parameters[10]
    magnitude = math.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    known = math.isfinite(magnitude)
    if not known:
        magnitude = 0.0
    impact = impact_level((magnitude - memory[0]) / period, parameters) if known else 0.0
    keep = parameters[0] * (parameters[1] if memory[1] > 0.0 else 1.0)
    memory[0] = magnitude
    memory[1] = 1.0 if magnitude >= keep and magnitude > 0.0 else 0.0
    memory[2] = max(impact, memory[2] * math.exp(-period / parameters[7]))
    if memory[2] < 1e-3:
        memory[2] = 0.0
    low = sustained_level(magnitude, parameters) if memory[1] > 0.0 else 0.0
    up, down = parameters[8] * period, parameters[9] * period
    rumble[0] += min(max(low - rumble[0], -down), up)
    rumble[1] += min(max(memory[2] - rumble[1], -down), up)


class HapticOutput(LeafSystem):
    """Turns the contact force into the levels of a joystick's motors, and shakes a device.

    Ports:
        input f_haptic (3) [N]: force of the environment, as it came over the channel.
        output rumble (2): levels of the low and the high frequency motor, each 0..1.

    Update, at t = k period, with F = |f_haptic|::

        engaged <- F >= force_threshold (release_ratio times that while engaged)
        burst   <- max(impact_level(dF/dt), burst exp(-period / burst_time))
        low  <- slewed(sustained_level(F) if engaged else 0);   high <- slewed(burst)

    where dF/dt is the difference over one period, and a slewed level rises at most by slew_up
    period and falls at most by slew_down period. Initial: everything zero.

    Publish, 1 ms after each update, if there is a device: device.rumble(low, high, 150 ms).

    Raises:
        ValueError: a field of the mapping is out of its bounds.
    """

    def __init__(self, mapping: HapticMapping, device: Device | None = None) -> None:
        super().__init__()
        mapping.validate("mapping")
        self._parameters = mapping.parameters()
        self._device = device
        self._force = self.DeclareVectorInputPort("f_haptic", 3)
        self._memory = declare_state(self, 3)
        self._levels = declare_state(self, 2, "rumble")
        self._rumble = self.GetOutputPort("rumble")
        self.DeclarePeriodicDiscreteUpdateEvent(mapping.period, 0.0, self._step)
        if device is not None:
            self.DeclarePeriodicPublishEvent(mapping.period, PUBLISH_OFFSET, self._shake)

    def _step(self, context: Context, discrete: DiscreteValues) -> None:
        step_haptics(
            self._force.Eval(context),
            self._parameters,
            discrete.get_mutable_value(self._memory),
            discrete.get_mutable_value(self._levels),
        )

    def _shake(self, context: Context) -> None:
        if self._device is not None:
            low, high = self._rumble.Eval(context)
            self._device.rumble(low, high, PULSE)
