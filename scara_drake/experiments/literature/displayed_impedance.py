"""The impedance that a hand is shown over each named channel, against its closed forms.

Hirche and Buss (Human perceived transparency with time delay, 2007) have that of wave variables,
that of P+d follows from its two forces, see `stability.displayed_impedance`. A hand presses the
wall of Table 4 and sweeps. What it is shown is compared as in the table of the couplings, by the
mean error to the wall's own impedance, and as a complex number at each frequency: a mean can hide
much.

A link with jitter is seen three times: as it is, through the playout buffer that is recommended for
it, and as the constant delay that it would be behind that one, were no packet late.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.channel.delays import ConstantDelay
from scara_drake.channel.links import Channel, Link
from scara_drake.common.parallel import side_by_side
from scara_drake.experiments.claim import OURS, Claim, Criterion, Experiment, within
from scara_drake.experiments.quantity import Quantity, quantity
from scara_drake.experiments.teleoperation import hand_sweep
from scara_drake.experiments.teleoperation.couplings_runs import (
    COUPLINGS,
    LINKS,
    SCENARIO,
    buffered,
    has_jitter,
)
from scara_drake.experiments.teleoperation.hand_sweep import HandSweep
from scara_drake.metrics import bilateral
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import load_scenario

Array = NDArray[np.float64]

WAVES, SPRINGS = "wave variables", "P+d"
BUFFERED, CONSTANT = ", buffered", ", constant"  # behind the name of a link
WAYS: Final = {"without a buffer": "", "through a buffer": BUFFERED}
FAST = "paper_2s"  # its delay grows and shrinks as fast as time
APART = 0.05
UP_TO = 8.0  # [Hz], below which the two are so near at each frequency
TIMES = (1.0, 2.0)  # [s], of the hand: it starts, and is there
AMPLITUDE = 2e-3  # [m]: the tool stays in firm contact over every channel
# Waves go to and fro until the hand has taken them up, so a long link needs a longer rest.
REST, ROUNDS = 4.0, 15.0  # [s], and ways there and back of packets
FREQUENCIES: Final = np.geomspace(*bilateral.BAND, 41)  # [Hz]


@dataclass(frozen=True)
class Job:
    """A coupling over a link."""

    coupling: str
    link: str
    seed: int
    duration: float  # of the sweep [s]

    @property
    def name(self) -> str:
        """Of the link in `LINKS`."""
        return self.link.removesuffix(BUFFERED).removesuffix(CONSTANT)

    def rest(self) -> float:
        """Return the time for which the hand is still before the sweep and after it [s]."""
        if self.coupling != WAVES or not has_jitter(self.name):
            return REST
        return REST + ROUNDS * 2.0 * buffered(self.name).buffer().depth

    def channel(self) -> Link:
        """Return the link of either direction."""
        if self.link == self.name:
            return LINKS[self.name]
        link = buffered(self.name)
        return link if self.link.endswith(BUFFERED) else ConstantDelay(link.buffer().depth)


def names(links: Sequence[str]) -> list[str]:
    """Return the links, and behind each that has jitter the same with a buffer, and constant."""
    return [
        link + way
        for link in links
        for way in (("", BUFFERED, CONSTANT) if has_jitter(link) else ("",))
    ]


def run(
    seed: int = 0,
    links: Sequence[str] = tuple(LINKS),
    duration: float = 30.0,
    jobs: int | None = None,
) -> Experiment:
    """Sweep the hand with both couplings over each link.

    Args:
        seed: of jitter and loss.
        links: of `LINKS`.
        duration: of a sweep [s].
        jobs: runs side by side; all cores if None.
    """
    couplings, channels = (WAVES, SPRINGS), names(links)
    todo = [Job(coupling, link, seed, duration) for coupling in couplings for link in channels]
    results = list(side_by_side(compare, todo, jobs))
    shape = (len(couplings), len(channels))
    dims = ("coupling", "link")

    def column(name: str) -> Array:
        return np.reshape([result[name] for result in results], (*shape, *results[0][name].shape))

    data = xr.Dataset(
        {
            "found": labelled(
                dims, column("found"), "decades", "mean |log10| of what is shown over the wall's"
            ),
            "form": labelled(dims, column("form"), "decades", "the same of the closed form"),
            "delay": labelled(dims, column("delay"), "s", "there and back, mean"),
            "constant": labelled(dims, column("constant"), "1", "whether that never changed"),
            "apart": labelled(
                (*dims, "frequency"), column("apart"), "1", "|what is shown / closed form - 1|"
            ),
        },
        coords={
            "coupling": list(couplings),
            "link": channels,
            "frequency": ("frequency", FREQUENCIES, {"units": "Hz"}),
        },
        attrs={"seed": seed, "scenario": SCENARIO},
    )  # fmt: skip
    return Experiment("Displayed impedance", data, claims(data))


def compare(job: Job) -> dict[str, Array]:
    """Simulate a sweep, and return what it shows beside the closed form."""
    made = load_scenario(SCENARIO, {"coupling": COUPLINGS[job.coupling], "seed": job.seed})
    made.channel = Channel(up=job.channel(), down=job.channel())
    sweep = HandSweep(TIMES, job.duration, AMPLITUDE, job.rest())
    recording = sweep.run(made)
    shown, delays = sweep.displayed(recording), sweep.delays(recording).values
    mean, frequency = float(delays.mean()), shown.frequency
    form = bilateral.as_swept(
        lambda hertz: hand_sweep.predicted(made, hertz, mean),
        recording, hand_sweep.AXIS, sweep.start,
    )  # fmt: skip
    apart = np.interp(FREQUENCIES, frequency, abs(shown / form - 1.0))
    found = bilateral.decades(shown, hand_sweep.true_impedance(made, frequency))
    expected = hand_sweep.predicted_error(made, frequency, delays)
    return {
        "found": np.array(found),
        "form": np.array(expected),
        "delay": np.array(mean),
        "constant": np.array(np.ptp(delays) < 1e-9),
        "apart": apart,
    }


def claims(data: xr.Dataset) -> list[Claim]:
    """Say how near the two are, over which links and up to which frequency."""
    raw = [name for name in data.link.values if name + BUFFERED in data.link.values]
    orderly = data.sel(link=[name for name in data.link.values if name not in raw])
    made = [_means(orderly, WAVES), _means(orderly, SPRINGS), _each(orderly)]
    return made + ([_jitter(data.sel(coupling=WAVES), raw)] if raw else [])


def _named(values: xr.DataArray, label: str = "") -> Quantity:
    pairs = zip(values.link.values, values.values, strict=True)
    return quantity({str(name): float(value) for name, value in pairs}, "decades", label)


def _means(data: xr.Dataset, coupling: str) -> Claim:
    slow = data.sel(coupling=coupling, link=[name for name in data.link.values if name != FAST])
    measured = _named(slow.found)
    beside: tuple[Quantity, ...] = ()
    if FAST in data.link.values:
        fast = data.sel(coupling=coupling, link=FAST)
        off = 1e2 * abs(float(fast.found / fast.form) - 1.0)
        beside = (quantity(off, "%", f"apart over {FAST}, which decides nothing"),)
    return Claim(
        f"{coupling}: over a link that keeps the order, what is shown of a wall has a closed form",
        _named(slow.form),
        (measured, *beside),
        Criterion(
            f"the mean error to the wall's impedance within {1e2 * APART:g} % of the closed form's "
            "over each link, with jitter through a buffer, whose delay varies by no more than 0.2 "
            "s in a second",
            within(measured, APART),
        ),
        "By Hirche and Buss, 2007. Where the delay varies it is the mean over the delays, as if "
        f"each were constant; over {FAST} it varies as fast as time."
        if coupling == WAVES
        else "A spring to where the other end was: the tool hardly moves, so no delay shows.",
        OURS,
    )


def _each(data: xr.Dataset) -> Claim:
    constant = data.apart.where(data.constant)
    low = constant.sel(frequency=slice(None, UP_TO))
    far = constant.max("link") > APART
    leaves = {
        str(name): float(data.frequency.where(far.sel(coupling=name)).min())
        for name in data.coupling.values
    }
    return Claim(
        "Over a constant delay that form holds at each frequency, in size and phase",
        None,
        (
            quantity(1e2 * constant.median("frequency"), "%", "apart, median of the frequencies"),
            quantity(1e2 * low.max(), "%", f"apart below {UP_TO:g} Hz", "up to"),
            quantity(1e2 * constant.max(), "%", f"apart up to {bilateral.BAND[1]:g} Hz", "up to"),
            quantity(leaves, "Hz", f"from which some link is beyond {1e2 * APART:g} %"),
        ),
        Criterion(
            f"apart by no more than {1e2 * APART:g} % of the complex impedance at every frequency "
            f"up to {UP_TO:g} Hz, over every link whose delay is constant",
            bool((low.isnull() | (low <= APART)).all()) and bool(low.notnull().any()),
        ),
        "Beyond that the tool nears its resonance on the wall, and the lag of the arm shows.",
        OURS,
    )


def _jitter(waves: xr.Dataset, raw: list[str]) -> Claim:
    ways = {way: waves.sel(link=[name + end for name in raw]) for way, end in WAYS.items()}
    off = {way: abs(one.found / one.form - 1.0) for way, one in ways.items()}
    plain, buffer = WAYS
    return Claim(
        "Jitter without a buffer takes the waves away from their closed form",
        _named(ways[plain].form),
        (
            *(_named(ways[way].found, way) for way in (plain, buffer)),
            *(
                quantity(1e2 * one.apart.median("frequency"), "%",
                         f"apart at a frequency, median, {way}")
                for way, one in ways.items()
            ),
        ),
        Criterion(
            f"over some link apart by more than {1e2 * APART:g} % in the mean without a buffer, "
            "and over none of them through one",
            bool((off[plain] > APART).any()) and bool((off[buffer] <= APART).all()),
        ),
        "Of packets that arrive together or out of order only the newest is played, and what the "
        "others leave the waves' term against drift spends at once, so a tick without a packet is "
        "one without motion. The one in a hundred that comes too late for the buffer is what is "
        "still apart at single frequencies.",
        OURS,
    )  # fmt: skip
