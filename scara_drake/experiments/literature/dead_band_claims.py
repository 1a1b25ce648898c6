"""What the table of the dead bands shows, beside what was published of people."""

from __future__ import annotations

import xarray as xr

from scara_drake.experiments.claim import OURS, Claim, Criterion, at_least, within, within_factor
from scara_drake.experiments.quantity import quantity

EVERY = -1.0  # stands for no codec: a packet each tick
STANDARD = 0.1  # k at which packets are counted
FEWER, ENOUGH = 90.0, 80.0  # [%], published at most, and asked of ours at least
FALLS, STEP, FACTOR = 27.0, 3.0, 1.5  # [%], published; of ours; and the bounds of the verdict
WORSE = 0.1  # of the position error, from which it has fallen
RARELY, OFTEN = 0.05, 0.5  # shares of the press
DRIFT = 1e-3  # [m]


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge the packets and the errors; see `dead_band.run` for the data."""
    return [_packets(data), _performance(data), _noticed(data), _drift(data)]


def _packets(data: xr.Dataset) -> Claim:
    sent = xr.concat([data.packets_up, data.packets_down], "link")
    share = 1e2 * (1.0 - sent.sel(band=STANDARD) / sent.sel(band=EVERY))
    found = quantity(share.transpose("delay", "link"), "%", "fewer packets, up and down")
    bitrate = data.bitrate.sel(band=[EVERY, STANDARD])
    return Claim(
        "Hirche, Hinterseer, Kammerl: up to 90 % fewer packets at k = 10 %",
        quantity(FEWER, "%", "fewer packets"),
        (found, quantity(bitrate, "kbit/s", "both links, each packet sent and at k = 10 %")),
        Criterion(
            f"at least {ENOUGH:g} % fewer up and down and at each delay, and {FEWER:g} % in one",
            (at_least(found, ENOUGH / FEWER), at_least(found, share=1.0 / share.size)),
            at_least(found, ENOUGH / FEWER),
        ),
        "A press is mostly a hold, in which hardly more is sent than the keep-alives.",
        OURS,
    )


def _performance(data: xr.Dataset) -> Claim:
    late = data.position_error.isel(delay=-1)
    coded = late.sel(band=late.band > EVERY)
    worse = coded / late.sel(band=EVERY) - 1.0
    fallen = worse.band.values[worse.values > WORSE]
    kept = [k for k in worse.band.values if not fallen.size or k < fallen.min()]
    found = quantity(1e2 * max(kept, default=0.0), "%", "largest k before it has fallen")
    return Claim(
        "Chaudhari: performance falls above a dead band of 27 %",
        quantity(FALLS, "%", "dead band"),
        (found, quantity(1e2 * worse, "%", "larger position error than without the codec")),
        Criterion(
            f"the last k of the table before the position error over {float(late.delay):g} s is "
            f"more than {1e2 * WORSE:g} % larger is within {STEP:g} % of it (in kind: a factor of "
            f"{FACTOR:g})",
            within(found, STEP / 1e2),
            within_factor(found, FACTOR),
        ),
        "People were asked there, at their own task; here the error of a press stands for it.",
        OURS,
    )


def _noticed(data: xr.Dataset) -> Claim:
    near = data.isel(delay=0)
    share = near.noticed
    most = float(share.band.max())
    return Claim(
        "Without delay, what the codec leaves out at k = 10 % is rarely felt, and at 40 % mostly",
        None,
        (
            quantity(1e2 * share, "%", "of the press with an error of the force above one JND"),
            quantity(near.force_error, "N", "error of the force, rms"),
        ),
        Criterion(
            f"more than one JND off in less than {1e2 * RARELY:g} % of the press up to k = 10 %, "
            f"and in more than {1e2 * OFTEN:g} % at {1e2 * most:g} %",
            bool((share.sel(band=share.band <= STANDARD) < RARELY).all())
            and bool(share.sel(band=most) > OFTEN),
        ),
        "The JND of a force is 7 %, so a change of 10 % can be felt; it rarely is, as a press is "
        "mostly a hold, in which next to nothing is left out.",
        OURS,
    )


def _drift(data: xr.Dataset) -> Claim:
    return Claim(
        "What is not sent keeps its energy: TDPA lets go without a drift at each dead band",
        None,
        quantity(1e3 * data.drift.max("band"), "mm", "drift after the release", "up to"),
        Criterion(f"below {1e3 * DRIFT:g} mm", bool((data.drift < DRIFT).all())),
        "Energies are sent as sums, so a packet has that of all samples before it.",
        OURS,
    )
