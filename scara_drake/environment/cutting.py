"""The LeafSystem in which the tool's blade cuts a pipe."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.cut_state import PIPE_STATE
from scara_drake.environment.cut_law import cut_pipe
from scara_drake.environment.pipe import PipeCut

Array = NDArray[np.float64]


@njit(cache=True)
def add_force(f_surfaces_W: Array, blade_force_W: Array, f_env_on_tool_W: Array) -> None:
    """Write the force of surfaces and pipe (3,) [N]."""
    for i in range(3):
        f_env_on_tool_W[i] = f_surfaces_W[i] + blade_force_W[i]


@njit(cache=True)
def add_effort(effort_surfaces: Array, blade_effort: Array, generalized_force: Array) -> None:
    """Write what surfaces and pipe do at the joints (6,) [N, N m]."""
    for i in range(6):
        generalized_force[i] = effort_surfaces[i] + blade_effort[i]


class PipeCutting(Block):
    """A pipe, and the blade that cuts it: see `cut_law`.

    Ports:
        input state (12): q, v measured [m, rad, m/s, rad/s].
        input f_surfaces_W (3) [N], effort_surfaces (6) [N, N m]: of the contact with surfaces; zero
            where not connected.
        output pipe_cut (11): the cut so far, see `cut_state.PipeState`.
        output cells (n): share of each cell that is left, ring after ring from the inside.
        output blade_force_W (3) [N]: force of the pipe on the tool.
        output f_env_on_tool_W (3) [N], generalized_force (6) [N, N m]: of surfaces and pipe.

    Update, at t = k period: the blade cuts for a period as it is now, which is where the plant's
    step begins that this force acts in. Initial: the pipe is whole, there is no force.
    """

    def __init__(self, pipe: PipeCut, period: float = 1e-3) -> None:
        cells = pipe.cells_around * pipe.cells_through
        first = PIPE_STATE.zeros(speed=abs(pipe.blade.speed), left=1.0)
        super().__init__(
            Declaration(
                inputs={
                    "state": Input(12),
                    "f_surfaces_W": Input(3, default=(0.0,) * 3),
                    "effort_surfaces": Input(6, default=(0.0,) * 6),
                },
                memory={
                    "pipe_cut": Memory(first, port=True),
                    "cells": Memory(np.ones(cells), port=True),
                    "blade_force_W": Memory(3, port=True),
                    "kerf": Memory(cells),
                    "blade_effort": Memory(6),
                },
                outputs={
                    "f_env_on_tool_W": Output(3, add_force),
                    "generalized_force": Output(6, add_effort),
                },
                parameters={"cut": pipe.parameters(), "period": period},
                period=period,
                update=cut_pipe,
            )
        )
