r"""The standard cases of Niemeyer and Slotine, and of Hannaford and Ryu. Not in the paper.

Niemeyer and Slotine (IEEE Journal of Oceanic Engineering 16, 1991, 152): positions and forces that
are exchanged over a delay are unstable, waves are not; a wave comes back from an end of impedance Z
as its part :math:`(b - Z) / (b + Z)`, and not at all where the end is matched, Z = b. Hannaford and
Ryu (IEEE Transactions on Robotics and Automation 18, 2002, 1): a stiff virtual wall that makes
energy and swings without a passivity controller is quiet with one. How stiff it is here is ours.

The contacts are runs of the scenario `bilateral`, arm and all. The waves run through the couplings'
own two ends on one axis: a device without a hand, and a tool that is held still, so that its end is
the spring and the damper of the coupling.
"""

from __future__ import annotations

from typing import Final

import numpy as np
import xarray as xr
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Layout
from scara_drake.coupling.layouts import PACKET
from scara_drake.coupling.wave_variables import DOWN, UP, WaveVariables, wave_master, wave_slave
from scara_drake.experiments.claim import OURS, Claim, Criterion, Experiment, within
from scara_drake.experiments.quantity import quantity
from scara_drake.metrics import bilateral as bilateral_metrics
from scara_drake.metrics import hand_press
from scara_drake.operator.device_motion import move_device
from scara_drake.operator.master import Master
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import simulate

Array = NDArray[np.float64]

SCENARIO = "bilateral"
DELAYS: Final = (0.02, 0.1, 0.5)  # [s], of each direction
EXCHANGES: Final = {"position and force": "!Direct {}", "waves": "!WaveVariables {}"}
CONTROLLERS: Final = {"without": "!Direct {}", "with": "!Tdpa {}"}
STIFF = 30e3  # [N/m]
DURATION = 7.0  # [s]

IMPEDANCE, DEVICE = 20.0, 0.1  # b [N s/m] and mass of the device [kg]
ENDS: Final = {  # damping of the device, and of the coupling at the tool [N s/m]
    "5 and 60": (5.0, 60.0),
    "2 and 100": (2.0, 100.0),
    "60 and 100": (60.0, 100.0),
    "device matched": (20.0, 60.0),
    "tool matched": (5.0, 20.0),
}
MATCHED: Final = ("device matched", "tool matched")
PERIOD, LATE, PULSE = 1e-3, 800, 500  # [s], [ticks] of each direction, [ticks]
TRIPS = 3
NEAR, NOTHING = 0.03, 0.01  # share of a prediction; part of a wave that counts as none
RESERVE, OPEN = 100.0, 10.0  # [J], with which no wave is cut


def run(seed: int = 0, delays: tuple[float, ...] = DELAYS) -> Experiment:
    """Run the contacts and the waves.

    Args:
        seed: of the scenario.
        delays: of each direction [s].
    """
    exchanged = [
        [_contact(coupling, seed, delay) for delay in delays] for coupling in EXCHANGES.values()
    ]
    stiff = [_contact(coupling, seed, 0.0, STIFF) for coupling in CONTROLLERS.values()]
    names = {
        "stable": ("1", "the force rests in the steady part, and nothing but the hand drives it"),
        "energy": ("J", "least energy left in coupling and channel, with the reserve"),
        "ripple": ("N", "standard deviation of the force in the steady part"),
    }
    data = xr.Dataset(
        {
            **{
                name: labelled(("exchange", "delay"), _column(exchanged, name), *what)
                for name, what in names.items()
            },
            **{
                f"stiff_{name}": labelled(("controller",), _column(stiff, name), *what)
                for name, what in names.items()
            },
            "returned": labelled(
                ("ends", "trip"),
                np.array([echoes(*ends) for ends in ENDS.values()]),
                "1",
                "size of a wave at the tool over that of the way there and back before",
            ),
            "predicted": labelled(
                ("ends",),
                np.array([abs(part(device) * part(tool)) for device, tool in ENDS.values()]),
                "1",
                "product of (b - Z) / (b + Z) of both ends",
            ),
        },
        coords={
            "exchange": list(EXCHANGES),
            "delay": ("delay", list(delays), {"units": "s"}),
            "controller": list(CONTROLLERS),
            "ends": list(ENDS),
            "trip": np.arange(1, TRIPS + 1),
        },
        attrs={"seed": seed, "scenario": SCENARIO, "impedance": IMPEDANCE},
    )
    return Experiment("Standard cases", data, claims(data))


def part(impedance: float) -> float:
    """Return what comes back of a wave from an end [1]: (b - Z) / (b + Z)."""
    return (IMPEDANCE - impedance) / (IMPEDANCE + impedance)


def _column(results: list, name: str) -> Array:
    if isinstance(results[0], dict):
        return np.array([one[name] for one in results])
    return np.array([_column(one, name) for one in results])


def _contact(coupling: str, seed: int, delay: float, stiffness: float = 1e4) -> dict[str, float]:
    """Return the figures of a press."""
    late = f"!ConstantDelay {{delay: {delay}}}"
    fields = {"coupling": coupling, "seed": seed, "channel.up": late, "channel.down": late}
    scenario = load_scenario(SCENARIO, fields)
    scenario.environment.surfaces[0].stiffness = stiffness
    master: Master = scenario.operator  # type: ignore[assignment]  # that of `bilateral`
    recording = simulate(scenario, duration=DURATION)
    begin, end = master.times[1:3]
    held = bilateral_metrics.steady_press(recording, begin, end)
    return {
        "stable": hand_press.is_stable(recording, master),
        "energy": bilateral_metrics.energy_margin(recording, scenario.coupling.reserves()),
        "ripple": bilateral_metrics.force_ripple(held),
    }


def echoes(device_damping: float, tool_damping: float) -> Array:
    """Return the size of a wave at the tool over that of the way there and back before (TRIPS,).

    A pulse is on its way to the tool at first; its size is its peak.

    Args:
        device_damping: Z of the device, which nobody holds [N s/m].
        tool_damping: Z of the coupling's end at a tool that is held still [N s/m].
    """
    coupling = WaveVariables(
        impedance=IMPEDANCE, stiffness=1.0, damping=tool_damping, drift_gain=0.0, reserve=RESERVE,
        turn=1.0,
    )  # fmt: skip
    device = Master(mass=DEVICE, damping=device_damping, hand_stiffness=0.0, hand_damping=0.0)
    arrived = _waves_at_the_tool(coupling, device.parameters(PERIOD))
    trip = 2 * LATE
    sizes = np.array([abs(arrived[k : k + trip]).max() for k in trip * np.arange(TRIPS + 1)])
    # Of one that has come back as nothing there is nothing to come back.
    return np.divide(sizes[1:], sizes[:-1], out=np.zeros(TRIPS), where=sizes[:-1] > NOTHING)


def _waves_at_the_tool(coupling: WaveVariables, device: Array) -> Array:
    """Return the wave that arrives at the tool at each tick [sqrt(W)]."""
    near = coupling.make_master(PERIOD).declaration
    far = coupling.make_slave(PERIOD, np.zeros(8)).declaration
    near_memory, far_memory = (np.array(end.memory["memory"].initial) for end in (near, far))
    near_constants, far_constants = (end.parameters["constants"] for end in (near, far))
    pulse = np.concatenate([np.hanning(PULSE), np.zeros(LATE - PULSE)])
    ups = np.zeros((2 * LATE * (TRIPS + 1), PACKET.size + UP.size))
    downs = np.zeros((ups.shape[0], PACKET.size + DOWN.size))
    for k in range(LATE):  # on their way at first
        # What was sent is counted from OPEN on, so that there is energy for all of it.
        ups[k] = _packet(UP, k + 1, pulse[k], OPEN)
        downs[k] = _packet(DOWN, k + 1, 0.0, 0.0)
    _travel(ups, downs, near_constants, far_constants, near_memory, far_memory, device)
    return np.array([UP.unpack(PACKET.unpack(up).payload).wave[0] for up in ups])


@njit(cache=True)
def _travel(
    ups: Array,
    downs: Array,
    near_constants: Array,
    far_constants: Array,
    near_memory: Array,
    far_memory: Array,
    device: Array,
) -> None:
    """Fill the packets behind those that are on their way, each as it arrives."""
    up, down = ups[LATE - 1].copy(), downs[LATE - 1].copy()
    motion, rest, command, energy = np.zeros(6), np.zeros(6), np.zeros(8), np.zeros((2, 6))
    target, still, f_hand, f_master = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    for k in range(ups.shape[0] - LATE):
        acting = f_master.copy()
        wave_master(motion, downs[k], near_constants, near_memory, up, f_master, energy[0])
        wave_slave(ups[k], still, rest, far_constants, far_memory, down, command, energy[1])
        move_device(device, acting, still, motion, target, f_hand)
        ups[k + LATE] = up
        downs[k + LATE] = down


def _packet(layout: Layout, number: int, wave: float, energy: float) -> Array:
    payload = layout.zeros(wave=[wave, 0.0, 0.0], energy=np.full(3, energy))
    return PACKET.pack(number=number, payload=payload)


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge the standard cases; see `run` for the data."""
    return [_exchange(data), _reflections(data), _matched(data), _stiff(data)]


def _exchange(data: xr.Dataset) -> Claim:
    plain, waves = (data.sel(exchange=name) for name in EXCHANGES)
    return Claim(
        "Niemeyer and Slotine: positions and forces exchanged over a delay are unstable, waves are "
        "stable and make no energy",
        None,
        (
            quantity(int(plain.stable.sum()), f"of {plain.stable.size}", "stable, positions"),
            quantity(int(waves.stable.sum()), f"of {waves.stable.size}", "stable, waves"),
            quantity(plain.energy, "J", "left, positions"),
            quantity(waves.energy, "J", "left, waves"),
        ),
        Criterion(
            "at each delay the press swings with positions and rests with waves, and only the "
            "waves keep their energy above zero",
            not bool(plain.stable.any())
            and bool(waves.stable.all())
            and bool((plain.energy < 0.0).all())
            and bool((waves.energy >= 0.0).all()),
        ),
        f"The delay is {quantity(1e3 * data.delay, 'ms')} each way.",
        OURS,
    )


def _reflections(data: xr.Dataset) -> Claim:
    open_ends = data.sel(ends=[name for name in data.ends.values if name not in MATCHED])
    last = quantity(open_ends.returned.isel(trip=-1), "", "of a wave, on the third way")
    off = abs(open_ends.returned / open_ends.predicted - 1.0)
    return Claim(
        "Niemeyer and Slotine: a wave comes back as (b - Z) / (b + Z) of itself from each end",
        quantity(open_ends.predicted, "", "of a wave, of both ends"),
        (last, quantity(1e2 * off.max(), "%", "off, on any way", "up to")),
        Criterion(
            f"within {1e2 * NEAR:g} % on each way there and back",
            (within(last, NEAR), bool((off <= NEAR).all())),
        ),
        f"The ends are dampers but for the device's mass of {DEVICE:g} kg and the softest spring "
        "of the coupling, 1 N/m.",
        OURS,
    )


def _matched(data: xr.Dataset) -> Claim:
    matched = data.returned.sel(ends=list(MATCHED)).isel(trip=0)
    return Claim(
        "Niemeyer and Slotine: where an end is matched, Z = b, no wave comes back",
        None,
        quantity(1e2 * matched, "%", "of a wave"),
        Criterion(
            f"less than {1e2 * NOTHING:g} % there and back, with either end matched",
            bool((matched < NOTHING).all()) and matched.size > 0,
        ),
        "What is left is of the device's mass and the spring, which are no dampers.",
        OURS,
    )


def _stiff(data: xr.Dataset) -> Claim:
    without, controlled = (data.sel(controller=name) for name in CONTROLLERS)
    return Claim(
        f"Hannaford and Ryu: a stiff wall, here {1e-3 * STIFF:g} kN/m, makes energy and swings "
        "without a passivity controller, and rests with one",
        None,
        (
            quantity(without.stiff_ripple, "N", "ripple without"),
            quantity(controlled.stiff_ripple, "N", "ripple with"),
            quantity(without.stiff_energy, "J", "observer, least, without"),
            quantity(controlled.stiff_energy, "J", "observer, least, with"),
        ),
        Criterion(
            "over a channel without delay: not stable and the observer below zero without, stable "
            "and never below zero, the reserve counted, with",
            not bool(without.stiff_stable)
            and float(without.stiff_energy) < 0.0
            and bool(controlled.stiff_stable)
            and float(controlled.stiff_energy) >= 0.0,
        ),
        "Here the wall is touched by an arm whose own lag is the delay. Theirs is a virtual one on "
        "a device, and their controller acts when energy is gone, ours before it is.",
        OURS,
    )
