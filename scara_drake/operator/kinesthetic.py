"""From the contact force to the force of a device that can push the hand."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from scara_drake.common import checks
from scara_drake.common.state import declare_state

Array = NDArray[np.float64]


@dataclass
class KinestheticMapping:
    """What a kinesthetic device is asked for. The limit is that of a small desktop device.

    Attributes:
        scale: force at the hand over force at the tool.
        limit: largest magnitude [N].
        slew: fastest change [N/s].
    """

    scale: float = 0.02
    limit: float = 3.3  # [N]
    slew: float = 500.0  # [N/s]

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: a number out of its range.
        """
        checks.number(f"{name}.scale", self.scale, 0.0, 1e3)
        checks.number(f"{name}.limit", self.limit, checks.ABOVE_ZERO, 1e4)
        checks.number(f"{name}.slew", self.slew, checks.ABOVE_ZERO, 1e7)


@njit(cache=True)
def step_kinesthetic(force: Array, scale: float, limit: float, step: float, felt: Array) -> None:
    """Move the force felt (3,) [N] towards scale force, by at most `step` [N] along a line.

    The target is cut to `limit` [N] in its own direction; one that is not finite counts as none.
    """
    target = scale * force
    size = np.sqrt((target * target).sum())
    if not np.isfinite(size):
        target = np.zeros(3)
    elif size > limit:
        target *= limit / size
    change = target - felt
    size = np.sqrt((change * change).sum())
    if size > step:
        change *= step / size
    felt += change


class KinestheticOutput(LeafSystem):
    """The force that a kinesthetic device should put on the hand.

    Ports:
        input f_haptic (3) [N]: force of the environment on the tool, as it came over the channel.
        output f_kinesthetic (3) [N]: force on the hand, in the axes of the world.

    Update, every period: see `step_kinesthetic`. Initial: zero. The device's own driver reads the
    port in a publish event of its own.

    Args:
        mapping: how the force is scaled and limited.
        period: [s].

    Raises:
        ValueError: a field of the mapping is out of its bounds.
    """

    def __init__(self, mapping: KinestheticMapping, period: float = 1e-3):
        super().__init__()
        mapping.validate("mapping")
        self._constants = (mapping.scale, mapping.limit, mapping.slew * period)
        self._force = self.DeclareVectorInputPort("f_haptic", 3)
        self._felt = declare_state(self, 3, "f_kinesthetic")
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._step)

    def _step(self, context: Context, discrete: DiscreteValues) -> None:
        felt = discrete.get_mutable_value(self._felt)
        step_kinesthetic(self._force.Eval(context), *self._constants, felt)
