"""What the driver of a kinesthetic device gives of its motion: counts, and their filtered rate."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.common.layout import Layout
from scara_drake.common.scratch import scratch
from scara_drake.operator.master import Master

Array = NDArray[np.float64]


class EncoderRow(NamedTuple):
    """The encoders of a device in a kernel.

    Attributes:
        resolution: size of a count [m].
        period: T [s].
        decay: exp(-w T) of the velocity's filter.
    """

    resolution: float
    period: float
    decay: float


ENCODER = Layout(EncoderRow)
encoder_of = ENCODER.reader()


@njit(cache=True)
def show_motion(motion_master: Array, encoder: Array, last: Array, motion_measured: Array) -> None:
    """Write what the driver gives (6,) of a device's motion (6,).

    Args:
        motion_master: x, v.
        encoder: see `EncoderRow`.
        last: what it gave a period before (6,); not written.
        motion_measured: x rounded to a count, and v <- a v + (1 - a) (x - x before) / T; written.
    """
    e = encoder_of(encoder)
    for i in range(3):
        x = e.resolution * np.rint(motion_master[i] / e.resolution)
        slope = (x - last[i]) / e.period
        motion_measured[i] = x
        motion_measured[3 + i] = slope + e.decay * (last[3 + i] - slope)


@njit(cache=True)
def keep_motion(motion_master: Array, encoder: Array, last: Array) -> None:
    """Take over into the memory what the driver gives."""
    shown = scratch(6)
    show_motion(motion_master, encoder, last, shown)
    last[:] = shown


class DeviceEncoder(Block):
    """The encoders of a kinesthetic device, and its driver.

    Ports:
        input motion_master (6) [m, m/s]: x, v of the device.
        output motion_measured (6) [m, m/s]: the nearest count of x, and the velocity that the
            driver works out from the counts, see `show_motion`.

    Update, at t = k period: the memory takes over the output. Initial: at rest at zero.

    Args:
        master: whose device has a resolution.
        period: [s].
    """

    def __init__(self, master: Master, period: float = 1e-3) -> None:
        encoder = ENCODER.pack(
            resolution=master.hardware().resolution,
            period=period,
            decay=math.exp(-master.velocity_bandwidth * period),
        )
        super().__init__(
            Declaration(
                inputs={"motion_master": Input(6)},
                memory={"last": Memory(6)},
                outputs={"motion_measured": Output(6, show_motion)},
                parameters={"encoder": encoder},
                period=period,
                update=keep_motion,
            )
        )
