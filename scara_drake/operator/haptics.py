"""From the contact force to the two motors of a joystick.

The force's magnitude has one sensation, so it is made graded and two-fold: the low frequency motor
holds a level for a sustained force, logarithmic because the skin resolves ratios (Weber); the high
frequency motor gives a short burst where the force changes fast, which is what tells hard from soft
at an impact (event-based haptics).
"""

import math
from dataclasses import asdict, dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import Context

from scara_drake.common import checks
from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.common.fields import check, number
from scara_drake.common.layout import Cell, Layout
from scara_drake.operator.devices import Device

Array = NDArray[np.float64]

PULSE = 150  # [ms] of one rumble: longer than a period, and it stops by itself if a run dies
# The publish event of the device sees the state before an update of its own time: come just after.
PUBLISH_OFFSET = 1e-3  # [s]


@dataclass
class HapticMapping:
    """How the force shakes the joystick; motor levels are 0..1.

    Attributes:
        force_threshold: where the low motor starts.
        release_ratio: of the threshold, where it stops.
        force_full: where it is at its highest.
        curvature: of the logarithm; small is nearly linear.
        level_minimum: at the threshold: less does not turn such a motor.
        impact_threshold: rate of the force where the high motor starts.
        impact_full: where it is at its highest.
        burst_time: time constant of a burst's decay.
        slew_up: fastest rise of a level.
        slew_down: fastest fall.
        period: about 30 Hz, on the ticks of the 1 kHz loop.
    """

    force_threshold: float = number(5.0, "N", 0.0, 1e5)
    release_ratio: float = number(0.8, "1", 0.0, 1.0)
    force_full: float = number(250.0, "N", 1e-3, 1e6)
    curvature: float = number(20.0, "1", 1e-3, 1e4)
    level_minimum: float = number(0.12, "1", 0.0, 1.0)
    impact_threshold: float = number(300.0, "N/s", 0.0, 1e8)
    impact_full: float = number(6000.0, "N/s", 1e-3, 1e9)
    burst_time: float = number(0.08, "s", 1e-3, 1.0)
    slew_up: float = number(8.0, "1/s", 0.1, 1e3)
    slew_down: float = number(20.0, "1/s", 0.1, 1e3)
    period: float = number(0.033, "s", 0.01, 0.1)

    def check_together(self, name: str) -> None:
        """Check that a motor is at its highest above where it starts.

        Raises:
            ValueError: it is not.
        """
        lowest = 1.001 * self.force_threshold
        checks.number(f"{name}.force_full", self.force_full, lowest, 1e6)
        lowest = 1.001 * self.impact_threshold
        checks.number(f"{name}.impact_full", self.impact_full, lowest, 1e9)

    def parameters(self) -> Array:
        """Return the fields as `mapping_of` reads them."""
        return MAPPING.pack(**asdict(self))


class Mapping(NamedTuple):
    """`HapticMapping` in a kernel."""

    force_threshold: float
    release_ratio: float
    force_full: float
    curvature: float
    level_minimum: float
    impact_threshold: float
    impact_full: float
    burst_time: float
    slew_up: float
    slew_down: float
    period: float


class Sensation(NamedTuple):
    """Memory of the mapping.

    Attributes:
        force: last |force| [N].
        engaged: 1 while the low motor is engaged, or 0.
        burst: level 0..1.
    """

    force: Cell
    engaged: Cell
    burst: Cell


MAPPING = Layout(Mapping)
SENSATION = Layout(Sensation, force=(), engaged=(), burst=())
mapping_of = MAPPING.reader()
sensation_of = SENSATION.reader()


@njit(cache=True)
def sustained_level(force: float, mapping: Array) -> float:
    """Level 0..1 of the low motor for a force [N] that has passed the threshold.

    ``I_min + (1 - I_min) ln(1 + mu x) / ln(1 + mu)``, with x the force from its threshold (0) to
    full (1), clipped.
    """
    p = mapping_of(mapping)
    x = min(max((force - p.force_threshold) / (p.force_full - p.force_threshold), 0.0), 1.0)
    span = 1.0 - p.level_minimum
    return p.level_minimum + span * math.log1p(p.curvature * x) / math.log1p(p.curvature)


@njit(cache=True)
def impact_level(rate: float, mapping: Array) -> float:
    """Level 0..1 of the high motor for a rate of force [N/s]: linear from its threshold."""
    p = mapping_of(mapping)
    travel = (abs(rate) - p.impact_threshold) / (p.impact_full - p.impact_threshold)
    return min(max(travel, 0.0), 1.0)


@njit(cache=True)
def haptics_step(f_haptic: Array, mapping: Array, sensation: Array, rumble: Array) -> None:
    """One tick of the mapping, in place; a force that is not finite counts as none.

    Args:
        f_haptic: (3,) [N].
        mapping: of `HapticMapping.parameters`.
        sensation: memory, see `Sensation`.
        rumble: (2,): low and high level 0..1.
    """
    p, m = mapping_of(mapping), sensation_of(sensation)
    fx, fy, fz = f_haptic
    magnitude = math.sqrt(fx**2 + fy**2 + fz**2)
    known = math.isfinite(magnitude)
    if not known:
        magnitude = 0.0
    impact = impact_level((magnitude - m.force[()]) / p.period, mapping) if known else 0.0
    keep = p.force_threshold * (p.release_ratio if m.engaged[()] > 0.0 else 1.0)
    m.force[()] = magnitude
    m.engaged[()] = 1.0 if magnitude >= keep and magnitude > 0.0 else 0.0
    m.burst[()] = max(impact, m.burst[()] * math.exp(-p.period / p.burst_time))
    if m.burst[()] < 1e-3:
        m.burst[()] = 0.0
    low = sustained_level(magnitude, mapping) if m.engaged[()] > 0.0 else 0.0
    up, down = p.slew_up * p.period, p.slew_down * p.period
    for motor, level in enumerate((low, m.burst[()])):
        rumble[motor] += min(max(level - rumble[motor], -down), up)


class HapticOutput(Block):
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
        check(mapping, "mapping")
        super().__init__(
            Declaration(
                inputs={"f_haptic": Input(3)},
                memory={"rumble": Memory(2, port=True), "sensation": Memory(SENSATION.size)},
                parameters={"mapping": mapping.parameters()},
                period=mapping.period,
                update=haptics_step,
            )
        )
        self._device = device
        if device is not None:
            self.DeclarePeriodicPublishEvent(mapping.period, PUBLISH_OFFSET, self._shake)

    def _shake(self, context: Context) -> None:
        if self._device is not None:
            low, high = self.GetOutputPort("rumble").Eval(context)
            self._device.rumble(low, high, PULSE)
