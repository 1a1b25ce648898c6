"""Hands from slow to brisk: what they do to a device in the space of a few seconds.

Half of a motion to and fro takes 0.1 to 2 s, over 1 to 20 cm: the target is as fast as 3.75 m/s,
and the device of `Master`'s defaults changes its velocity by up to 200 m/s². A hand begins to move
after 0.2 s and then never rests for long; it goes along y, in which the walls of the rig are.
"""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from scara_drake.operator.master import Master

START = 0.2  # [s]

# Amplitude [m] and half period [s] of a hand that goes to and fro, from slow to brisk.
BRISK = ((0.04, 1.0), (0.06, 0.5), (0.08, 0.4), (0.10, 0.35), (0.20, 0.5), (0.20, 0.1))


def to_and_fro(amplitude: float, half_period: float, duration: float) -> Master:
    """A hand between the centre and `amplitude` [m] along -y, in halves of a period [s]."""
    times = np.arange(START + half_period, duration, half_period)
    places = [-amplitude if index % 2 == 0 else 0.0 for index in range(times.size)]
    return along_y(times, places)


def steps(amplitude: float, hold: float, duration: float, rise: float = 0.1) -> Master:
    """A hand that jumps `amplitude` [m] along -y within `rise` [s], holds [s], and jumps back."""
    times, places = [], []
    place, t = 0.0, START
    while t + rise < duration:
        times += [t, t + rise]
        places += [place, -amplitude - place]
        place, t = places[-1], t + rise + hold
    return along_y(times, places)


def along_y(times: list[float] | np.ndarray, places: list[float] | np.ndarray) -> Master:
    """A hand that is at `places` [m] on y at `times` [s]."""
    targets = [[0.0, float(place), 0.0] for place in places]
    return Master(times=[float(time) for time in times], targets=targets)


@st.composite
def wanderers(draw: st.DrawFn, duration: float) -> Master:
    """A hand that goes from place to place at random."""
    seed = draw(st.integers(0, 2**31), label="seed of the hand")
    largest = draw(st.floats(0.01, 0.2), label="largest way")
    random = np.random.default_rng(seed)
    # 20 cm to 20 cm on the other side within 0.1 s would be 7.5 m/s.
    times = START + np.cumsum(random.uniform(max(0.1, largest), 0.6, 10 * int(duration + 1.0)))
    places = random.uniform(-largest, 0.5 * largest, times.size)
    return along_y(times[times < duration], places[times < duration])


def hands(duration: float = 6.0) -> st.SearchStrategy[Master]:
    """Hands that go to and fro, jump, or wander, within `duration` [s]."""
    amplitude, half = st.floats(0.01, 0.2), st.floats(0.1, 2.0)
    return st.one_of(
        st.sampled_from(BRISK).map(lambda motion: to_and_fro(*motion, duration)),
        st.builds(to_and_fro, amplitude, half, st.just(duration)),
        st.builds(steps, amplitude, half, st.just(duration)),
        wanderers(duration),
    )
