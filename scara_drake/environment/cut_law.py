"""How a saw blade cuts the wall of a pipe, as kernels.

The section of the pipe is a field of cells, by angle and by depth of the wall. Of a cell of the
area a, the share m is left, and the disc covers the share c: 0 outside the rim, 1 inside, linear
between. What is left and covered is its overlap A = a max(0, c + m - 1). There the material::

    pushes the rim back along its normal    N = k A (1 + d v_in)       v_in: speed of approach
    and holds the teeth back along it       F = N / r                  r: feed ratio

The load of all cells and of the friction in the kerf slows the motor down, v = v_0 (1 - F / F_s),
and the teeth, sliding at v_s = v + (the tool's own speed along the rim), remove ::

    u dV/dt = F v_s

so the energy of the cut is the volume times the specific energy u, to the last digit. A front of
the width h (across the feed) and the kerf w, fed at v_f, takes the power u w h v_f; the motor gives
P = v_0 F_s / 4 at most. Fed faster than P / (u w h) the overlap grows, the blade falls below
`stalled_below` of its speed and stands: it cuts nothing and rests on what is left, as on a surface
of the stiffness k h.

The kerf lies where the teeth bit first: `kerf_place` along the axis. Each cell also has where, at
its removal, the blade was across the kerf. A blade that is by more than the clearance e elsewhere,
because the tool was moved aside or turned, is bent back, by its covered share g of the section::

    S = K_s g e + B_s g de/dt,       and rubs on the side with mu S, against its turning

so it may bind: stall by friction alone. S has the potential K_s g e² / 2, which the rim feels too
as a wedge where g grows. Beside its kerf a blade rests on the pipe and cuts nothing: a pipe has one
cut.

Work and heat: motor = cut + friction + work on the tool, each a sum over the ticks; what the
springs give to the tool they had from it before. Friction is that on the sides, and the teeth's
where they slide and do not bite. All of it acts where it acts, so the tool feels a force and a
moment.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.scratch import scratch
from scara_drake.cut_state import BESIDE, FREE, IN_KERF, PipeState, pipe_state_of
from scara_drake.dynamics.spatial import Vector, cross, plus, times
from scara_drake.environment.cut_layout import Cut, cut_of
from scara_drake.environment.cut_touch import (
    NOTHING,
    Disc,
    Touch,
    disc_at,
    in_world,
    meets,
    ring,
    section,
    touch,
)

Array = NDArray[np.float64]


@njit(cache=True)
def load_of(c: Cut, disc: Disc, s: PipeState, cells: Array, kerf: Array) -> tuple[float, bool]:
    """Return the load [N] at the rim, and whether the blade is on the section at all.

    Writes the largest bend.
    """
    load, met = 0.0, False
    s.bend[()] = 0.0
    for number in range(int(c.through)):
        r, first = ring(c, number), number * int(c.around)
        for angle in range(int(c.around)):
            cell = first + angle
            left = 1.0 if s.mode[()] == BESIDE else cells[cell]
            near = meets(c, disc, r, angle, left, kerf[cell])
            met = met or near > 0
            if near < 2:
                continue
            t = touch(c, disc, r, angle, left, kerf[cell])
            load += t.normal / c.feed_ratio + c.friction * abs(t.side) * t.arm
            s.bend[()] = max(s.bend[()], t.bend)
    return load, met


@njit(cache=True)
def run_motor(c: Cut, load: float, s: PipeState) -> float:
    """Write the speed under a load [N] at the rim; return the share of it that the motor bears."""
    speed = c.speed * (1.0 - load / c.stall_force)
    s.stalled[()] = 1.0 if speed < c.stalled_below * c.speed else 0.0
    s.speed[()] = 0.0 if s.stalled[()] == 1.0 else speed
    return min(1.0, c.stall_force / load) if load > 0.0 else 1.0


@njit(cache=True)
def remove(c: Cut, t: Touch, cell: int, energy: float, cells: Array, kerf: Array) -> float:
    """Remove of a cell what an energy [J] cuts; return the energy [J] that there was to use."""
    gone = min(energy / (c.energy * c.kerf), t.overlap) / t.area
    before = 1.0 - cells[cell]
    cells[cell] -= gone
    if gone > 0.0:
        kerf[cell] += (t.across - kerf[cell]) * gone / (before + gone)
    return gone * t.area * c.kerf * c.energy


@njit(cache=True)
def bite(
    c: Cut, disc: Disc, s: PipeState, borne: float, period: float, cells: Array, kerf: Array
) -> tuple[Vector, Vector]:
    """Cut for a period [s]; return force [N] and moment [N m] on the tool, about its point, in S.

    Args:
        c: pipe and blade.
        disc: the blade.
        s: the cut so far; its energies and the volume grow.
        borne: share of the load that the motor bears.
        period: [s].
        cells: of each cell (n,), what is left.
        kerf: of each cell (n,), where it was across the blade at its removal [m].
    """
    force, moment, motor, heat, used = NOTHING, NOTHING, 0.0, 0.0, 0.0
    bites = s.mode[()] == IN_KERF and s.stalled[()] == 0.0
    for number in range(int(c.through)):
        r, first = ring(c, number), number * int(c.around)
        for angle in range(int(c.around)):
            cell = first + angle
            left = 1.0 if s.mode[()] == BESIDE else cells[cell]
            if meets(c, disc, r, angle, left, kerf[cell]) < 2:
                continue
            t = touch(c, disc, r, angle, left, kerf[cell])
            teeth, rub = borne * t.normal / c.feed_ratio, borne * c.friction * abs(t.side)
            slip, glide = max(s.speed[()] + t.slide, 0.0), max(s.speed[()] * t.arm + t.slide, 0.0)
            work = teeth * slip * period
            if bites and work > 0.0:
                removed = remove(c, t, cell, work, cells, kerf)
                teeth *= removed / work
                used += removed
            else:
                heat += work
            heat += rub * glide * period
            motor += teeth * (slip - t.slide) + rub * (glide - t.slide)
            push = times(-(t.normal + t.wedge), t.outward)
            push = plus(push, plus(times(-(teeth + rub), t.along), times(t.side, disc.axis)))
            force = plus(force, push)
            moment = plus(moment, cross(t.lever, push))
    s.power[()] = motor
    s.energy[()] += motor * period
    s.energy_cut[()] += used
    s.energy_friction[()] += heat
    s.volume[()] += used / c.energy
    s.left[()] = 1.0 - s.volume[()] / (section(c) * c.kerf)
    return force, moment


@njit(cache=True)
def approach(c: Cut, disc: Disc, s: PipeState) -> bool:
    """Write whether the blade is in its kerf or beside; return whether it may touch the pipe."""
    if s.volume[()] == 0.0:
        s.place[()] = disc.tip[2]
    off = abs(disc.tip[2] - s.place[()])
    if s.mode[()] == FREE:
        s.mode[()] = IN_KERF if off <= c.kerf / 2.0 else BESIDE
    near = math.hypot(disc.centre[0], disc.centre[1]) < c.radius + 2.0 * c.outer
    return near and abs(disc.tip[2]) <= c.half_length


@njit(cache=True)
def cut_pipe(
    period: float,
    state: Array,
    cut: Array,
    cells: Array,
    kerf: Array,
    pipe_cut: Array,
    blade_force_W: Array,
    blade_effort: Array,
) -> None:
    """Cut for a period [s] as the robot's state (12,) says; write force (3,) and Jᵀ of it (6,).

    Args:
        period: [s].
        state: q, v.
        cut: of `PipeCut.parameters`.
        cells: share of each cell that is left (n,).
        kerf: where each cell was across the blade at its removal (n,) [m].
        pipe_cut: the cut so far, see `cut_state.PipeState`.
        blade_force_W: receives the force on the tool [N].
        blade_effort: receives what that does at the joints [N, N m].
    """
    c, s, J = cut_of(cut), pipe_state_of(pipe_cut), scratch(6, 6)
    at = disc_at(state, c, J)
    if not approach(c, at, s):
        s.mode[()], s.power[()], s.bend[()] = FREE, 0.0, 0.0
        run_motor(c, 0.0, s)
        blade_force_W[:] = 0.0
        blade_effort[:] = 0.0
        return
    place = at.tip[2] if s.mode[()] == BESIDE else s.place[()]
    disc = Disc(at.tip, at.centre, at.axis, at.velocity, at.rate, place)
    load, met = load_of(c, disc, s, cells, kerf)
    if not met:
        s.mode[()] = FREE
    borne = run_motor(c, load, s)
    force, moment = bite(c, disc, s, borne, period, cells, kerf)
    f, m = in_world(c, force), in_world(c, moment)
    for i in range(3):
        blade_force_W[i] = f[i]
    for j in range(6):
        turning = J[0, j] * m[0] + J[1, j] * m[1] + J[2, j] * m[2]
        blade_effort[j] = turning + J[3, j] * f[0] + J[4, j] * f[1] + J[5, j] * f[2]
