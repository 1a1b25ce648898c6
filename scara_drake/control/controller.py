"""The socket of a joint controller: its ports, its gate, and the checks of what arrives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Block, Declaration, Input, Kernel, Memory, Output

Array = NDArray[np.float64]

# Bits of the port `saturation`.
OUTSIDE_LAYER, EFFORT_LIMIT = 1, 2


@njit(cache=True)
def limit_effort(
    tau: Array, effort: Array, outside: Array, tau_limited: Array, saturation: Array
) -> None:
    """Write tau within its limits (n,), and the bits of `saturation` (n,).

    Args:
        tau: before the limits (n,) [N, N m].
        effort: limits (n,) [N, N m].
        outside: |s| / phi (n,); 1 or more is outside the boundary layer.
        tau_limited: written.
        saturation: written; 0, OUTSIDE_LAYER, EFFORT_LIMIT or their sum.
    """
    for i in range(tau.size):
        tau_limited[i] = min(max(tau[i], -effort[i]), effort[i])
        saturation[i] = 0.0
        if outside[i] >= 1.0:
            saturation[i] += OUTSIDE_LAYER
        if tau_limited[i] != tau[i]:
            saturation[i] += EFFORT_LIMIT


@njit(cache=True)
def release(actuation_commanded: Array, actuation: Array, saturation: Array) -> None:
    """Take the effort from the drives: all zero (n,)."""
    actuation_commanded[:] = 0.0
    actuation[:] = 0.0
    saturation[:] = 0.0


@dataclass(frozen=True)
class Law:
    """The kernels of a controller, see `Block`, compiled or plain Python.

    They name what they need of the inputs ``state`` and ``state_desired``, of the memory
    ``actuation``, ``actuation_commanded`` and ``saturation``, and of what the controller adds.

    Attributes:
        update: advances the law by one period. A sampled plant has stepped before its controller is
            updated, so `state` is one period younger than `state_desired`: a law carries the
            references one period along their velocity.
        initialize: begins the law, with both states of one instant; None leaves it at zero.
        rest: is called in place of `update` while the drives are off. It leaves them without an
            effort, and the law where it takes over without a jump.
        rest_initialize: of a start with the drives off, if `rest` does not do for it.
        limited: `actuation` is within the limits of the drives, so no `EffortLimit` follows.
    """

    update: Kernel
    initialize: Kernel | None = None
    rest: Kernel = release
    rest_initialize: Kernel | None = None
    limited: bool = False


class JointController(Block):
    """A sampled controller of the six joints; a law fills it.

    Ports:
        input state (12): q, v measured [m, rad, m/s, rad/s].
        input state_desired (12): q, v references.
        input engaged (1): optional, engaged if not connected; below 0.5 the drives are off: no
            effort, and the law starts afresh at every period, so that it takes over without a jump.
        output actuation (6): effort within the limits of the drives [N, N m].
        output actuation_commanded (6): effort before the limits.
        output saturation (6): 0, or the sum of 1 (outside the boundary layer) and 2 (effort limit).

    and those of the memory and the outputs that the law adds. Update, at t = k period: the law.
    Initial: what the law begins with.

    Args:
        period: [s].
        law: its kernels.
        parameters: of the kernels, by name.
        memory: of the law, by name.
        outputs: of the law, by name.
        inputs: of the law, by name, beside those of all controllers.

    Raises:
        ValueError: a kernel has an argument that none of these name.
    """

    def __init__(
        self,
        period: float,
        law: Law,
        parameters: Mapping[str, Any],
        memory: Mapping[str, Memory],
        outputs: Mapping[str, Output] | None = None,
        inputs: Mapping[str, Input] | None = None,
    ) -> None:
        efforts = ("actuation", "actuation_commanded", "saturation")
        super().__init__(
            Declaration(
                inputs={
                    "state": Input(12, finite=True),
                    "state_desired": Input(12, finite=True),
                    "engaged": Input(1),
                    **(inputs or {}),
                },
                memory={name: Memory(6, port=True) for name in efforts} | dict(memory),
                outputs=outputs or {},
                parameters=parameters,
                period=period,
                update=law.update,
                initialize=law.initialize,
                enable="engaged",
                rest=law.rest,
                rest_initialize=law.rest_initialize,
            )
        )
        self.limited = law.limited
