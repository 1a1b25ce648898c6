"""The simulator of a joint alone: its plant, its delay, its encoder, and the laws in it."""

import numpy as np
import pytest

from scara_drake.control import ismc_law, observer_law, sliding_mode
from scara_drake.control.perturbation_observer import observer_gains
from scara_drake.stability.joint_alone import make_rig, simulate

TS = 1e-3
INF = np.inf


def ismc(c, k, rho, phi=1.0, m_hat=1.0, effort=INF, clamp=INF):
    return ismc_law.GAINS.pack(
        c=c, k=k, rho=rho, phi=phi, m_hat=m_hat, effort=effort, clamp=clamp, period=TS
    )


def smc(c, rho, phi=1.0, m_hat=1.0, effort=INF):
    return sliding_mode.GAINS.pack(c=c, rho=rho, phi=phi, m_hat=m_hat, effort=effort, period=TS)


def at_rest(samples, n=1):
    return np.zeros((samples, 2, n))


@pytest.mark.parametrize("delay", [0.0, 0.4e-3, 1e-3, 3.7e-3])
def test_an_effort_acts_after_its_delay_exactly(delay):
    # Far outside the layer the effort is rho, whatever the joint does: x = 1 - rho t² / 2 M.
    track = simulate(
        "SMC", smc(1.0, 2.0, 1e-6), make_rig(inertia=4.0, delay=delay), at_rest(200), start=1.0
    )
    t = TS * np.arange(200)
    late = np.maximum(t - delay, 0.0)
    np.testing.assert_allclose(track.x[:, 0], 1.0 - 0.25 * late**2, rtol=0, atol=1e-14)
    np.testing.assert_allclose(track.v[:, 0], -0.5 * late, rtol=0, atol=1e-14)


def test_a_disturbance_is_held_for_its_share_of_the_period():
    rng = np.random.default_rng(0)
    d = rng.normal(size=(100, 5, 2))
    free = ismc(0.0, 0.0, 0.0)
    track = simulate("ISMC", free, make_rig(), at_rest(100, 2), d, start_rate=[1.0, -1.0])
    h = TS / 5
    before = np.cumsum(d.reshape(500, 2), axis=0) - d.reshape(500, 2)
    v = np.array([1.0, -1.0]) + h * before
    x = np.cumsum(h * v + 0.5 * h * h * d.reshape(500, 2), axis=0)
    np.testing.assert_allclose(track.v, v[::5], rtol=0, atol=1e-12)
    np.testing.assert_allclose(track.x[1:], x[4:-1:5], rtol=0, atol=1e-12)


def test_through_an_encoder_the_law_sees_whole_counts_and_their_rate():
    # No effort, a constant speed: with a wide band the rate is the difference of the counts.
    resolution, c = 1e-3, 10.0
    rig = make_rig(resolution=resolution, bandwidth=1e9)
    track = simulate("SMC", smc(c, 0.0), rig, at_rest(50), start_rate=0.23)
    shown = resolution * np.rint(0.23 * TS * np.arange(50) / resolution)
    rate = np.concatenate([[0.23], np.diff(shown) / TS])
    np.testing.assert_allclose(track.sigma[:, 0], -rate - c * shown, rtol=0, atol=1e-9)


def test_a_lead_makes_up_for_a_reference_that_is_a_period_late():
    t = TS * np.arange(400)
    reference = np.stack([0.3 * t, np.full_like(t, 0.3)], axis=1)[:, :, np.newaxis]
    late = reference.copy()
    late[:, 0] -= 0.3 * TS
    gains = ismc(20.0, 30.0, 50.0)
    now = simulate("ISMC", gains, make_rig(), reference)
    carried = simulate("ISMC", gains, make_rig(lead=TS), late)
    np.testing.assert_allclose(carried.x, now.x, rtol=0, atol=1e-12)


def test_a_governed_joint_waits_for_its_drive_and_arrives():
    # A step of the reference asks for more than the drive has.
    reference = at_rest(6000)
    reference[:, 0] = 1.0
    rig = make_rig(inertia=2.0, bounds=[[0.8], [4.0]])
    gains = ismc(50.0, 100.0, 150.0, m_hat=2.0, effort=10.0, clamp=2.0)
    free = simulate("ISMC", gains, make_rig(inertia=2.0), reference)
    governed = simulate("ISMC", gains, rig, reference)
    assert free.x.max() > 1.05
    assert governed.x.max() < 1.01
    assert governed.x[-1, 0] == pytest.approx(1.0, abs=1e-4)


def test_the_observer_holds_a_load_without_rho():
    law = ismc(50.0, 100.0, 0.0, clamp=2.0)
    gains = observer_law.GAINS.pack(
        law=law,
        observer=observer_gains([200.0], [0.005], TS),
        acceleration_feedforward=0.0,
    )
    d = np.full((2000, 1, 1), -9.81)
    track = simulate("ISMC + SPO", gains, make_rig(), at_rest(2000), d, start=0.2)
    assert track.x[0, 0] == 0.2
    assert abs(track.x[-1, 0]) < 1e-9
    assert track.u[-1, 0] == pytest.approx(9.81, abs=1e-6)
