"""Generates the shipped joystick trace: 30 s of an operator who moves about and presses on a wall.

Reaches are minimum-jerk (Flash and Hogan, 1985) between rests. On top come physiological tremor of
8 to 10 Hz, and what a cheap gamepad adds: 8 bits, and spikes of one to three samples, as the paper
saw them. Run ``python -m scara_drake.operator.shipped_trace OUT.csv``.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scara_drake.common.fields import ABOVE_ZERO, check, number
from scara_drake.common.files import write_whole
from scara_drake.common.motion import minimum_jerk
from scara_drake.operator.mapping import JoystickMapping
from scara_drake.operator.trace import COLUMNS

Array = NDArray[np.float64]

# time [s] at which the tool is to rest, and its offset from the mapping's centre x, y, z [m]
Waypoint = tuple[float, float, float, float]
# time [s], axis (0, 1, 2), number of samples, stick value
Spike = tuple[float, int, int, float]

FREE_MOTION: list[Waypoint] = [
    (0.0, 0.0, 0.0, 0.0),
    (1.0, 0.0, 0.0, 0.0),
    (2.6, 0.20, 0.0, 0.0),
    (3.2, 0.20, 0.0, 0.0),
    (5.4, -0.10, 0.10, 0.05),
    (6.0, -0.10, 0.10, 0.05),
    (8.0, 0.05, -0.15, 0.15),
    (8.4, 0.05, -0.15, 0.15),
    (10.4, 0.10, 0.05, -0.15),
    (10.8, 0.10, 0.05, -0.15),
    (12.8, 0.0, 0.0, 0.0),
    (14.8, 0.0, 0.0, 0.0),
]


@dataclass
class OperatorProfile:
    """What the operator does; the lengths are turned into stick positions by `mapping`.

    Attributes:
        mapping: of the stick, which is inverted.
        wall_y: commanded y of the tool at first touch.
        tap_depth: of the first press, beyond the wall.
        hold_depth: of the second and sustained press, beyond the wall.
        clearance: from the wall before and between the presses.
        free_motion: before the presses.
        hat_up: from and until when the hat is up [s].
        tremor: of the stick's travel, bound on the sum of its waves.
        tremor_band: lowest and highest frequency [Hz].
        spikes: that a cheap gamepad adds.
        levels: of half the stick's travel: 8 bits with the sign.
        duration: of the trace.
        rate: of the samples.
        seed: of the tremor.
    """

    mapping: JoystickMapping = field(default_factory=JoystickMapping)
    wall_y: float = number(-1.05, "m")
    tap_depth: float = number(0.015, "m")
    hold_depth: float = number(0.018, "m")
    clearance: float = number(0.03, "m")
    free_motion: list[Waypoint] = field(default_factory=lambda: list(FREE_MOTION))
    hat_up: tuple[float, float] = (13.0, 14.5)
    tremor: float = number(0.008, "1", 0.0, 1.0)
    tremor_band: tuple[float, float] = (8.0, 10.0)
    spikes: list[Spike] = field(
        default_factory=lambda: [(3.8, 0, 1, -0.9), (7.1, 2, 2, 0.8), (11.5, 1, 3, 0.85)]
    )
    levels: int = 127
    duration: float = number(30.0, "s", ABOVE_ZERO)
    rate: float = number(100.0, "Hz", ABOVE_ZERO)
    seed: int = 20

    def waypoints(self) -> list[Waypoint]:
        """Free motion, approach, tap, press and hold, and back to the centre."""
        wall = self.wall_y - self.mapping.centre[1]
        near, tap, hold = wall + self.clearance, wall - self.tap_depth, wall - self.hold_depth
        return [
            *self.free_motion,
            (16.6, 0.0, near, 0.0),
            (17.0, 0.0, near, 0.0),
            (18.0, 0.0, tap, 0.0),
            (18.6, 0.0, tap, 0.0),
            (19.4, 0.0, near, 0.0),
            (20.2, 0.0, near, 0.0),
            (21.4, 0.0, hold, 0.0),
            (25.4, 0.0, hold, 0.0),
            (26.4, 0.0, near, 0.0),
            (28.6, 0.0, 0.0, 0.0),
            (self.duration, 0.0, 0.0, 0.0),
        ]


def stick_for(offset: float, mapping: JoystickMapping) -> float:
    """Stick position that commands an offset [m] from the centre: the mapping, inverted."""
    travel = offset / mapping.scale
    if travel == 0.0:
        return 0.0
    return float(np.copysign(mapping.dead_zone + abs(travel) * (1 - mapping.dead_zone), travel))


def operator_trace(profile: OperatorProfile | None = None) -> tuple[Array, Array]:
    """Return times (n,) [s] and axes (n, 5) of the operator; the same profile, the same bits.

    Raises:
        ValueError: a field of the profile is out of its bounds.
    """
    p = profile or OperatorProfile()
    check(p, "profile")
    generator = np.random.default_rng(p.seed)
    times = np.arange(round(p.duration * p.rate)) / p.rate
    axes = np.zeros((times.size, 5))
    hand = _reaches(times, p) + _tremor(times, p, generator)
    axes[:, :3] = np.round(hand * p.levels) / p.levels
    axes[:, 4] = (times >= p.hat_up[0]) & (times < p.hat_up[1])
    for start, axis, samples, value in p.spikes:
        row = round(start * p.rate)
        axes[row : row + samples, axis] = value
    axes = np.clip(axes, -1.0, 1.0).round(5) + 0.0  # + 0.0 makes no zero negative
    return times, axes


def _reaches(times: Array, p: OperatorProfile) -> Array:
    waypoints = p.waypoints()
    marks = np.array([waypoint[0] for waypoint in waypoints])
    sticks = np.array([[stick_for(x, p.mapping) for x in waypoint[1:]] for waypoint in waypoints])
    leg = np.clip(np.searchsorted(marks, times, side="right") - 1, 0, marks.size - 2)
    s = ((times - marks[leg]) / (marks[leg + 1] - marks[leg]))[:, np.newaxis]
    return sticks[leg] + (sticks[leg + 1] - sticks[leg]) * minimum_jerk(s)


def _tremor(times: Array, p: OperatorProfile, generator: np.random.Generator) -> Array:
    """Three waves an axis with random frequencies in the band: a beat, as a hand's tremor has."""
    frequency = generator.uniform(*p.tremor_band, size=(3, 3))
    phase = generator.uniform(0.0, 2 * np.pi, size=(3, 3))
    waves = np.sin(2 * np.pi * times[:, np.newaxis, np.newaxis] * frequency + phase)
    return p.tremor * waves.mean(axis=2)


def write_operator_trace(path: str | Path, profile: OperatorProfile | None = None) -> None:
    """Write the trace as CSV, five decimals, for `load_trace`."""
    times, axes = operator_trace(profile)
    lines = [",".join(COLUMNS)]
    for time, row in zip(times, axes, strict=True):
        lines.append(f"{time:.2f}," + ",".join(f"{value:.5f}" for value in row))
    write_whole(path, "\n".join(lines) + "\n")


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the trace to the file named on the command line."""
    parser = argparse.ArgumentParser(prog="operator_trace", description=main.__doc__)
    parser.add_argument("out", type=Path, help="CSV file to write")
    write_operator_trace(parser.parse_args(arguments).out)


if __name__ == "__main__":
    main()
