"""What is proven of a loop, beside what is seen of it: couplings, gains, delays. Not in the paper.

A hand presses the wall of the scenario `bilateral`, or sweeps free space, over a channel with a
constant delay. Proven is what `stability.certify` returns; seen is the delay at which a root of
the linear loop crosses the axis, and the first whole millisecond at which the Diagram with the arm
in it no longer comes to rest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import numpy as np
import xarray as xr

from scara_drake.coupling.position_damping import PositionDamping
from scara_drake.experiments.claim import OURS, Claim, Criterion, Experiment, at_least, within
from scara_drake.experiments.quantity import quantity
from scara_drake.metrics import bilateral as bilateral_metrics
from scara_drake.operator.master import Master
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import Scenario, load_scenario
from scara_drake.simulation.run import simulate
from scara_drake.stability.certificates import Certificates, absolute_delay, certify
from scara_drake.stability.certificates.linear_couplings import FREE, LIGHTLY
from scara_drake.stability.certificates.result import VARYING

SCENARIO = "bilateral"
CASES: Final = {
    "direct": "!Direct {}",
    "direct, force x 0.1": "!ScaledForce {}",
    "direct, force x 0.03": "!ScaledForce {force_scale: 0.03}",
    "direct, force x 0.01": "!ScaledForce {force_scale: 0.01}",
    "P+d": "!PositionDamping {}",
    "P+d, 1000 N/m, 5 N s/m": "!PositionDamping {stiffness: 1000.0, damping: 5.0}",
    "waves": "!WaveVariables {}",
}
CONTACTS: Final = (FREE, "wall", f"wall{LIGHTLY}")
DURATION = 6.0  # [s], of a press, which is held from 2 s on
# Below this share of its ripple two seconds before the force dies; below [N] it rests, and above
# [N] it is thrown about, whatever it was before.
DYING, CALM, LARGE = 0.9, 1e-3, 1.5
LONGEST = 64  # [ms], of the delays at which the Diagram is run
TIGHT = 0.95  # share of what is seen that is proven
P_D: Final = ((100.0, 30.0), (1000.0, 5.0), (300.0, 3.0))  # [N/m], [N s/m]


def run(seed: int = 0, cases: Mapping[str, str] = CASES, longest: int = LONGEST) -> Experiment:
    """Certify each case, and look where it is seen to turn over.

    Args:
        seed: of the scenario.
        cases: couplings by name.
        longest: delay at which the Diagram is run [ms]; 0 for no runs.
    """
    found = {name: certify(_scenario(coupling, seed)) for name, coupling in cases.items()}
    both = ("case", "contact")
    data = xr.Dataset(
        {
            "proven": labelled(
                both, _table(found, "proven"), "s", "constant delay there and back that is proven"
            ),
            "proven_varying": labelled(
                both, _table(found, "varying"), "s", "the same, where it varies"
            ),
            "seen": labelled(
                both, _table(found, "seen"), "s", "least delay with a root on the axis"
            ),
            "seen_with_arm": labelled(
                ("case",),
                np.array([_with_arm(one, seed, found[n], longest) for n, one in cases.items()]),
                "s",
                "least delay, in steps of 1 ms, at which the Diagram's force does not come to rest",
            ),
            "rule": labelled(
                ("gains",), np.array([2.0 * b / k for k, b in P_D]), "s", "2 B / K of P+d"
            ),
            "absolute": labelled(
                ("gains",),
                np.array([_absolute(k, b) for k, b in P_D]),
                "s",
                "delay up to which Llewellyn's condition holds, of a device without friction",
            ),
        },
        coords={
            "case": list(cases),
            "contact": list(CONTACTS),
            "gains": [f"{k:g} N/m, {b:g} N s/m" for k, b in P_D],
        },
        attrs={"seed": seed, "scenario": SCENARIO},
    )
    return Experiment("Certificates", data, claims(data))


def _scenario(coupling: str, seed: int, delay: float = 0.0, contact: str = "wall") -> Scenario:
    late = f"!ConstantDelay {{delay: {delay}}}"
    made = load_scenario(
        SCENARIO,
        {
            "coupling": coupling,
            "seed": seed,
            "channel.up": late,
            "channel.down": "!ConstantDelay {}",
        },
    )
    if contact == FREE:
        made.environment.surfaces = []
    return made


def _table(found: Mapping[str, Certificates], what: str) -> np.ndarray:
    """Return delays (case, contact) [s]; NaN where the coupling has no loop in a contact."""

    def one(certified: Certificates, contact: str) -> float:
        if contact not in certified.contacts and certified.contacts != ("any",):
            return math.nan
        if what == "seen":
            return certified.seen_delay(contact)
        return certified.proven_delay(contact, VARYING if what == "varying" else "constant")

    return np.array([[one(each, contact) for contact in CONTACTS] for each in found.values()])


def _with_arm(coupling: str, seed: int, found: Certificates, longest: int) -> float:
    """Return the least delay [s] at which the Diagram swings, where the linear loop does at some.

    The wall is pressed, or where the loop is the weaker in free space nothing is touched. Infinite
    where it rests at the longest.
    """
    if longest == 0:
        return math.nan
    contact = min((FREE, "wall"), key=found.seen_delay)

    def rests(delay: int) -> bool:
        recording = simulate(_scenario(coupling, seed, 1e-3 * delay, contact), duration=DURATION)
        before, after = (
            bilateral_metrics.force_ripple(recording.sel(time=slice(begin, begin + 1.0)))
            for begin in (DURATION - 3.0, DURATION - 1.0)
        )
        return after < min(max(DYING * before, CALM), LARGE)

    low, high = -1, longest + 1
    if rests(longest):
        return math.inf
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if rests(middle) else (low, middle)
    return 1e-3 * high


def _absolute(stiffness: float, damping: float) -> float:
    coupling = PositionDamping(stiffness=stiffness, damping=damping)
    found = absolute_delay(coupling, Master(damping=0.0), 400.0)
    return math.nan if found is None else found


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge the proofs by what is seen; see `run` for the data."""
    return [_below(data), _tight(data), _condition(data)]


def _below(data: xr.Dataset) -> Claim:
    known = data.proven.notnull()
    weakest = data.proven.min("contact")
    arm = data.seen_with_arm
    beyond = int((known & (data.proven > data.seen)).sum() + (weakest > arm).sum())
    proven = data.proven.where((data.proven > 0.0) & np.isfinite(data.proven), drop=True)
    run = [quantity(_named(arm), "ms", "seen with the arm", missing="rests")]
    return Claim(
        "No delay is proven at which the loop is seen to turn over",
        None,
        (
            quantity(1e3 * proven, "ms", "proven, where it is neither none nor any"),
            *(run if arm.notnull().any() else ()),
            quantity(beyond, f"of {int(known.sum())}", "proven beyond what is seen"),
        ),
        Criterion(
            "in each contact no more is proven than the roots of the linear loop say, and in the "
            "weakest contact no more than the Diagram with the arm bears",
            beyond == 0 and bool(known.any()),
        ),
        "The linear loop leaves out impacts and the limits of speed and acceleration, so that a "
        "contact that is proven may still be kicked out of rest by a weaker one on the way.",
        OURS,
    )


def _named(delays: xr.DataArray) -> dict[str, float]:
    return {
        str(name): 1e3 * float(value) if np.isfinite(value) else math.nan
        for name, value in zip(delays.case.values, delays, strict=True)
    }


def _tight(data: xr.Dataset) -> Claim:
    finite = np.isfinite(data.seen) & (data.proven > 0.0)
    share = (data.proven / data.seen).where(finite)
    varying = (data.proven_varying / data.seen).where(finite)
    return Claim(
        "What is proven for constant delays is nearly what is seen, for varying ones far less",
        None,
        (
            quantity(1e2 * share.min(), "%", "of what is seen, constant", "at least"),
            quantity(1e2 * varying.max(), "%", "varying", "up to"),
        ),
        Criterion(
            f"at least {1e2 * TIGHT:g} % of the least delay with a root on the axis, wherever that "
            "is finite and any delay is proven, and less than that where it varies",
            bool(share.min() >= TIGHT) and bool(varying.max() < TIGHT),
        ),
        "The ticks of the loop count in full where the delay of the channel is small, so a "
        "varying delay soon has nothing left.",
        OURS,
    )


def _condition(data: xr.Dataset) -> Claim:
    found = quantity(1e3 * data.absolute, "ms", "by Llewellyn")
    promised = quantity(1e3 * data.rule, "ms", "T_l + T_r = 2 B / K")
    return Claim(
        "P+d (Nuno, Basanez and Ortega 2011): Llewellyn's condition is 4 B_l B_r = (T_l + T_r)² "
        "K_l K_r",
        promised,
        found,
        Criterion(
            "the delay there and back up to which the two-port is absolutely stable within 0.1 % "
            "of that of the condition (in kind: no less)",
            within(found, 1e-3),
            at_least(found),
        ),
        "For constant delays the condition gives nothing away; with the sum of squares in place "
        "of the square of the sum it would promise 41 % more.",
        OURS,
    )
