r"""The Lyapunov function V = s²/2 of equations (48) to (51), followed on recorded data.

The paper's proof of :math:`\dot V < 0` holds for :math:`u_1 = K \operatorname{sign}(s)`, in the
place of the sat(s) that it writes, and a plant gain :math:`b = \hat m / M` of 1. With
:math:`\operatorname{sat}(s / \phi)`, and any b, the perturbation
:math:`D = \Psi + (1 - b)\,k\,\sigma` takes the place of :math:`\Psi`:

.. math::

    \dot s &= D - b\,u_1, \quad u_1 = \rho \operatorname{sat}(s / \phi)  \quad (50) \\
    \dot V &= s\,\dot s \le -|s|\,(b \rho - |D|)                         \quad (51)

the second outside the layer. So V decreases there while :math:`|D| < b \rho`. Inside it
:math:`\dot V` may have any sign; what holds there, from a start on the surface, is
:math:`|s| \le \phi \max|D| / (b \rho)`.

s is what the controller recorded; D comes from the efforts and the robot's equations of motion, so
that each is a check of the other. An effort that a drive cannot deliver is a perturbation, too.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from scara_drake.common import checks
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.ismc_law import GAINS
from scara_drake.joints import JOINT_NAMES
from scara_drake.plant.perturbation import perturb
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import Scenario
from scara_drake.stability.linear import continuous_plant

Array = NDArray[np.float64]

TOLERANCE = 0.01  # of the bound: s is sampled, its derivative is not
NEEDED = (
    "q_measured",
    "v_measured",
    "q_desired",
    "v_desired",
    "tau_applied",
    "tau_commanded",
)

_RATES = "m/s for d1, rad/s for the others"
_ACCELERATIONS = "m/s^2 for d1, rad/s^2 for the others"
_SQUARES = "(m/s)^2 for d1, (rad/s)^2 for the others"
_POWERS = "m^2/s^3 for d1, rad^2/s^3 for the others"


def lyapunov(recording: xr.Dataset, scenario: Scenario, mass_ratio: ArrayLike = 1.0) -> xr.Dataset:
    """Follow V through a recording.

    Args:
        recording: of `simulate`.
        scenario: that ran: integral sliding mode control in free motion, with ideal drives.
        mass_ratio: b = m_hat / M, a number or one a joint (6,); 1 is the paper's reading, in which
            all that differs from it is a perturbation.

    Returns:
        Over (time, joint): V, V_rate, perturbation D, and outside. Over (joint):

        - samples_outside, and samples_checked of them, where |D| < b rho;
        - share_decreasing of those checked, and worst_rate, the largest V' there (NaN if none);
        - worst_margin, the least -V' / (|s| (b rho - |D|)) there: by (51) it is 1 or more, but for
          the change of s within a period;
        - share_rising_inside, of the samples in the layer;
        - largest_s, the bound phi max|D| / (b rho), infinite where it is not below phi, and
          within_bound.

    Raises:
        ValueError: the scenario has another controller, or forces that are not in the equations of
            motion; or the mass ratio is not positive.
    """
    controller = sliding_mode(scenario)
    b = np.broadcast_to(np.asarray(mass_ratio, dtype=np.float64), 6)
    checks.vector("mass_ratio", b.tolist(), 6, checks.ABOVE_ZERO)
    gains = GAINS.unpack(controller.array())
    time = recording.time.values
    period = float(time[1] - time[0])
    D = perturbation(recording, scenario, b)[:-1]
    s = recording.sliding_variable.values
    V = 0.5 * s * s
    V_rate, V, s = np.diff(V, axis=0) / period, V[:-1], s[:-1]

    outside = np.abs(s) >= gains.phi
    both = ("time", "joint")
    over_time = {
        "V": labelled(both, V, _SQUARES, "V = s^2 / 2, equation (48)"),
        "V_rate": labelled(both, V_rate, _POWERS, "V' from sample to sample, equation (49)"),
        "perturbation": labelled(both, D, _ACCELERATIONS, "D of the equations of motion"),
        "outside": labelled(both, outside, "1", "whether |s| >= phi"),
    }
    coordinates = {"time": ("time", time[:-1], {"units": "s"}), "joint": list(JOINT_NAMES)}
    per_joint = _per_joint(s, V_rate, D, b * gains.rho, gains.phi)
    return xr.Dataset(over_time | per_joint, coords=coordinates)


def _per_joint(
    s: Array, V_rate: Array, D: Array, reach: Array, phi: Array
) -> dict[str, xr.Variable]:
    """What became of V, over (joint); `reach` (6,) is b rho, the largest D that can be met."""
    outside, authority = np.abs(s) >= phi, reach - np.abs(D)
    checked = outside & (authority > 0.0)
    margin = -V_rate / np.where(checked, np.abs(s) * authority, 1.0)
    largest, worst = np.abs(s).max(axis=0), np.abs(D).max(axis=0) / reach
    bound = np.where(worst < 1.0, phi * worst, np.inf)
    values = {
        "samples_outside": (outside.sum(axis=0), "1", "samples outside"),
        "samples_checked": (checked.sum(axis=0), "1", "samples outside where |D| < b rho"),
        "share_decreasing": (
            _mean(V_rate < 0.0, checked),
            "1",
            "share of those checked with V' < 0",
        ),
        "worst_rate": (-_least(-V_rate, checked), _POWERS, "largest V' of those checked"),
        "worst_margin": (_least(margin, checked), "1", "least -V' / (|s| (b rho - |D|)) of those"),
        "share_rising_inside": (
            _mean(V_rate > 0.0, ~outside),
            "1",
            "share of the samples inside with V' > 0",
        ),
        "largest_s": (largest, _RATES, "largest |s|"),
        "bound": (bound, _RATES, "phi max|D| / (b rho)"),
        "within_bound": (largest <= (1.0 + TOLERANCE) * bound, "1", "whether |s| keeps the bound"),
    }
    return {name: labelled(("joint",), *value) for name, value in values.items()}


def perturbation(recording: xr.Dataset, scenario: Scenario, mass_ratio: ArrayLike = 1.0) -> Array:
    """D (time, joint) [m/s², rad/s²] of each sample, from the equations of motion.

    With q'' = M(q)^-1 (tau + what acts on the joints besides), sigma' = q_d'' + c e' - q''. The law
    asked for u1 + k sigma = tau_commanded / m_hat, hence D = sigma' + k sigma + b u1, without s.
    Arguments as `lyapunov`.
    """
    controller = sliding_mode(scenario)
    gains = GAINS.unpack(controller.array())
    plant = continuous_plant(scenario.robot)
    context = plant.CreateDefaultContext()
    q, v, q_d, v_d, tau, commanded = (recording[name].values for name in NEEDED)
    time = recording.time.values
    act = np.zeros(6)
    acceleration = np.empty_like(q)
    for i in range(time.size):
        plant.SetPositionsAndVelocities(context, np.concatenate([q[i], v[i]]))
        if scenario.perturbation is not None:
            perturb(time[i], scenario.perturbation.parameters(), act)
        plant.get_actuation_input_port().FixValue(context, tau[i])
        plant.get_applied_generalized_force_input_port().FixValue(context, act)
        acceleration[i] = plant.get_generalized_acceleration_output_port().Eval(context)
    e, e_rate = q_d - q, v_d - v
    sigma_rate = np.gradient(v_d, time, axis=0) + gains.c * e_rate - acceleration
    u2 = gains.k * (e_rate + gains.c * e)
    return sigma_rate + u2 + np.asarray(mass_ratio) * (commanded / gains.m_hat - u2)


def sliding_mode(scenario: Scenario) -> IntegralSlidingMode:
    """Return the controller of a scenario whose equations of motion are known.

    Raises:
        ValueError: it has another controller, or forces or delays that are not in them.
    """
    controller, drives = scenario.controller, scenario.drives
    if not isinstance(controller, IntegralSlidingMode):
        raise ValueError(f"controller: {type(controller).__name__}, allowed IntegralSlidingMode")
    for name, part in (
        ("environment.surfaces", scenario.environment.surfaces),
        ("process_delay", scenario.process_delay),
        ("drives.encoder", drives.encoder),
        ("drives.lag", drives.lag),
        ("drives.friction", drives.friction),
        ("controller.acceleration_feedforward", controller.acceleration_feedforward),
        ("controller.gravity_compensation", controller.gravity_compensation),
    ):
        if part:
            raise ValueError(f"{name}: set, allowed none: it is not in the equations of motion")
    return controller


def _mean(condition: NDArray[np.bool_], where: NDArray[np.bool_]) -> Array:
    """Share (joint) of the samples `where` that meet a condition; NaN if there are none."""
    count = where.sum(axis=0)
    return np.where(count > 0, (condition & where).sum(axis=0) / np.maximum(count, 1), np.nan)


def _least(values: Array, where: NDArray[np.bool_]) -> Array:
    """Least value (joint) of the samples `where`; NaN if there are none."""
    least = np.where(where, values, np.inf).min(axis=0)
    return np.where(np.isinf(least), np.nan, least)
