"""What will go wrong in a run, as far as it can be told before: weight, gains and delays.

Nothing here is refused: a loop beyond its limits is worth watching. What is looked at is the robot
that will be simulated, where it starts: whether the drives and rho hold its weight there, whether
the gains hold a position at all, and whether the sampled loop in the layer is stable with the
delays of the scenario, see `delay_margin`. Of a device that exists it is told what hand and
coupling ask of it that it does not have.
"""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scara_drake import joints
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.ismc_law import GAINS
from scara_drake.control.observer_sliding_mode import ObserverSlidingMode
from scara_drake.control.pid import Pid
from scara_drake.control.sliding_mode import SlidingMode
from scara_drake.operator.kinesthetic_devices import OWN
from scara_drake.operator.master import Master
from scara_drake.scenario import Scenario
from scara_drake.stability.delay_margin import onset, spectral_radius
from scara_drake.stability.linear import continuous_plant
from scara_drake.wiring.operators import start_posture

Array = NDArray[np.float64]

GROWS = 1.0 + 1e-4  # a period; slower than a tenfold growth in 23 s is not told


def foresee(scenario: Scenario) -> list[str]:
    """Return a sentence for each thing that will go wrong; none for a sound scenario.

    First of the arm and its controller, see `_arm`, then of a device that the operator pushes.

    Raises:
        ValueError: the first tool command cannot be reached.
    """
    return _arm(scenario) + _device(scenario)


def _arm(scenario: Scenario) -> list[str]:
    """Return what will go wrong with the arm.

    Of controllers of the user's own only the weight is judged, of `InverseDynamics` likewise; the
    delays are those of integral and conventional sliding mode control.

    Args:
        scenario: checked.

    Raises:
        ValueError: its first tool command cannot be reached.
    """
    plant = continuous_plant(scenario.robot)
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, start_posture(scenario))
    weight = -plant.CalcGravityGeneralizedForces(context)
    inverse_mass: Array = np.linalg.inv(plant.CalcMassMatrix(context)).astype(np.float64)
    told = _weight(weight) + _gains(scenario.controller)
    gains = _as_ismc(scenario.controller, scenario.time_step)
    if told or gains is None:
        return told
    return _cover(weight, gains, scenario.controller) + _loop(inverse_mass, gains, scenario)


def _device(scenario: Scenario) -> list[str]:
    """Return what a device of a name cannot do that the hand or the coupling asks of it."""
    master, told = scenario.operator, []
    if not isinstance(master, Master) or master.device == OWN:
        return []
    hardware = master.hardware()
    pressed = master.hand_stiffness * max((math.hypot(*way) for way in master.targets), default=0.0)
    if pressed > hardware.force:
        told.append(
            f"the hand can press with {pressed:.3g} N, the device {master.device} pushes back with "
            f"{hardware.force:.3g} N at most: what is above is not felt"
        )
    coupling = scenario.coupling.within(hardware.stiffness, hardware.damping)
    for entry in fields(coupling):
        before, after = (getattr(one, entry.name) for one in (scenario.coupling, coupling))
        if after != before:
            told.append(
                f"coupling.{entry.name} is cut from {before:.4g} to {after:.4g}, as much as the "
                f"device {master.device} renders"
            )
    asked = coupling.asked_damping()
    if asked > hardware.damping:
        told.append(
            f"the coupling asks the device {master.device} for {asked:.4g} N s/m, it renders "
            f"{hardware.damping:.4g} N s/m: expect it to buzz"
        )
    for surface in scenario.environment.surfaces:
        asked = coupling.asked_stiffness(surface.stiffness)
        if asked > hardware.stiffness:
            told.append(
                f"pressed on {surface.name} the coupling asks the device {master.device} for "
                f"{asked:.4g} N/m, it renders {hardware.stiffness:.4g} N/m: expect it to buzz"
            )
    return told


def loop_delay(scenario: Scenario) -> float:
    """Longest delay in the control loop [s]: of effort and measurement, each with its tick."""
    delays = scenario.process_delay
    if delays is None:
        return 0.0
    within = (delays.actuation, delays.measurement)
    return sum(delay.maximum() + scenario.time_step for delay in within if delay is not None)


def _weight(weight: Array) -> list[str]:
    return [
        f"{name} needs {abs(effort):.0f} {unit} to hold the arm where it starts, its drive has "
        f"{limit:.0f}: it will fall"
        for name, unit, effort, limit in zip(
            joints.JOINT_NAMES, ("N", *["N m"] * 5), weight, joints.EFFORT, strict=True
        )
        if abs(effort) > limit
    ]


def _gains(controller: Any) -> list[str]:
    if isinstance(controller, Pid):
        stiffness, what = np.array(controller.kp), "kp = 0"
    elif isinstance(controller, IntegralSlidingMode | ObserverSlidingMode):
        slope = np.add(controller.k, controller.rho)
        stiffness, what = np.multiply(controller.c, slope), "c = 0, or k and rho = 0"
    elif isinstance(controller, SlidingMode):
        stiffness, what = np.multiply(controller.c, controller.rho), "c = 0 or rho = 0"
    else:
        return []
    loose = [name for name, k in zip(joints.JOINT_NAMES, stiffness, strict=True) if k == 0.0]
    return [f"nothing holds {', '.join(loose)} in position: {what}"] if loose else []


def _as_ismc(controller: Any, period: float) -> Array | None:
    """Return the gains as `ismc_law` takes them; None of a law that is no such one."""
    if isinstance(controller, IntegralSlidingMode):
        return controller.array(period)
    if isinstance(controller, SlidingMode):
        same = IntegralSlidingMode(
            c=controller.c, k=[0.0] * 6, rho=controller.rho, phi=controller.phi
        )
        return same.array(period)
    return None


def _cover(weight: Array, gains: Array, controller: Any) -> list[str]:
    if getattr(controller, "gravity_compensation", False):
        return []
    g = GAINS.unpack(gains)
    reach = g.m_hat * g.rho
    # In the raw law of the paper the nominal part k sigma holds what rho does not.
    held = np.isinf(g.clamp) if isinstance(controller, IntegralSlidingMode) else g.clamp < 0.0
    short = (np.abs(weight) > reach) & ~held
    return [
        f"rho of {name} gives {reach[i]:.0f}, the weight asks for {abs(weight[i]):.0f}: s leaves "
        "its layer, and an error stays"
        for i, name in enumerate(joints.JOINT_NAMES)
        if short[i]
    ]


def _loop(inverse_mass: Array, gains: Array, scenario: Scenario) -> list[str]:
    delay = loop_delay(scenario)
    if spectral_radius(inverse_mass, gains, delay) <= GROWS:
        return []
    if spectral_radius(inverse_mass, gains, 0.0) > GROWS:
        return ["the sampled loop is unstable on this robot: gains and inertia do not go together"]
    borne = onset(inverse_mass, gains)
    return [
        f"the control loop has a delay of {1e3 * delay:.3g} ms, where it starts it bears "
        f"{1e3 * borne:.3g} ms: it will swing up to the limits of the drives"
    ]
