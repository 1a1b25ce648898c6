"""A delay law of your own: a queue that fills and empties again, on the way up to the robot.

A law is a dataclass over `Delay` that says its longest delay and gives itself to the compiled
channel: here as a table of points, so it may be any function of time. Between the points the
channel takes straight lines, so it differs from a smooth function by at most h²/8 max |delay''|.

    python examples/own_delay_law.py
"""

from dataclasses import dataclass

import numpy as np

import scara_drake as sd
from scara_drake.channel.delays import LONGEST, Delay
from scara_drake.channel.laws import LINES, TABLE_LAW
from scara_drake.common.fields import ABOVE_ZERO, number
from scara_drake.scenario import dump_scenario

STEP = 0.05  # [s], h: between the points of the table


@dataclass
class Congestion(Delay):
    """base + swell x exp(1 - x), with x = (t - start) / rise from `start` on.

    Attributes:
        base: without a queue.
        swell: what the queue adds at its longest.
        start: of the congestion.
        rise: from the start to the longest queue.
    """

    base: float = number(0.05, "s", 0.0, 1.0)
    swell: float = number(0.3, "s", 0.0, 1.0)
    start: float = number(1.0, "s", 0.0)
    rise: float = number(0.7, "s", ABOVE_ZERO)

    def law(self, t: np.ndarray) -> np.ndarray:
        """Delay [s] at the times t [s]."""
        x = np.maximum(t - self.start, 0.0) / self.rise
        return self.base + self.swell * x * np.exp(1.0 - x)

    def maximum(self) -> float:
        """Longest delay [s]; the channel keeps so much of the past."""
        return self.base + self.swell

    def parameters(self) -> np.ndarray:
        """Return the law as the channel takes it."""
        times = self.start + np.arange(0.0, LONGEST, STEP)
        return TABLE_LAW.pack(kind=LINES, points=[*times, *self.law(times)])


congestion = Congestion()
scenario = sd.load_scenario("free_motion")
scenario.channel.up = congestion  # type: ignore[assignment]  # the union has shipped kinds

recording = sd.simulate(scenario, duration=6.0)
# A sample is what stood on the ports before the updates at its time, so the channel had worked out
# this delay, and what it received, at the tick before.
delay, tick = recording.delay_up.values, recording.time.values - scenario.time_step
print(f"longest delay {delay.max():.4f} s, base + swell {congestion.maximum():.4f} s")
bound = STEP**2 / 8 * 2 * np.e * congestion.swell / congestion.rise**2
off = np.abs(delay - congestion.law(tick)).max()
print(f"largest distance from the law {1e3 * off:.3f} ms, bound {1e3 * bound:.3f} ms")

# What arrives at t left at t - delay; before the first sample there was the first value.
for axis in ("x", "y", "z"):
    sent, received = (
        recording[f"p_WE_{name}"].sel(axis=axis) for name in ("commanded", "received")
    )
    left = np.interp(tick - delay, recording.time, sent)
    moved = 1e3 * float(sent.max() - sent.min())
    off = 1e6 * float(abs(received - left).max())
    print(f"{axis} goes {moved:5.1f} mm, received differs from sent earlier by {off:.1e} um")

print("\nAs a recording keeps it, in the scenario's text:")
print(dump_scenario(scenario).partition("channel:\n")[2].partition("  down:")[0])
