"""Poles inside the boundary layer: Drake's differentiation against the closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kinds import of_kind
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia, UnitInertia

from scara_drake import joints, load_scenario, robot
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.ismc_law import GAINS
from scara_drake.robot import RobotModel
from scara_drake.stability.linear import (
    closed_loop_poles,
    continuous_plant,
    layer_matrix,
    layer_poles,
    least_mass_ratio,
    linearise,
    sliding_poles,
)

TABLE_12 = IntegralSlidingMode()
DAMPING = np.array([100.0, 10.0, 5.0, 5.0, 0.5, 0.1])  # of models/README.md [N s/m, N m s/rad]


gain = st.floats(1.0, 100.0)


def together(poles):
    """Poles in an order that does not depend on their rounding."""
    return sorted(poles.ravel(), key=lambda p: (round(p.real, 3), round(p.imag, 3)))


def masses_on_rails(masses):
    """A plant of six masses that slide along x, without gravity and friction."""
    plant = MultibodyPlant(time_step=0.0)
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    for index, mass in enumerate(masses):
        inertia = SpatialInertia(mass, np.zeros(3), UnitInertia(1.0, 1.0, 1.0))
        body = plant.AddRigidBody(f"mass_{index}", inertia)
        rail = PrismaticJoint(
            f"rail_{index}", plant.world_frame(), body.body_frame(), np.array([1.0, 0.0, 0.0])
        )
        plant.AddJointActuator(f"drive_{index}", plant.AddJoint(rail))
    plant.Finalize()
    return plant


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_masses_on_rails_have_the_poles_of_the_formula(seed):
    rng = np.random.default_rng(seed)
    ratio = rng.uniform(0.3, 3.0, 6)
    gains = IntegralSlidingMode(
        c=rng.uniform(1, 50, 6).tolist(),
        k=rng.uniform(1, 150, 6).tolist(),
        rho=rng.uniform(10, 500, 6).tolist(),
        phi=rng.uniform(0.5, 2.0, 6).tolist(),
    )
    plant = masses_on_rails(robot.nominal_inertias() / ratio)
    loop = linearise(joints.HOME, gains, plant=plant)
    expected = layer_poles(gains.c, gains.k, gains.rho, gains.phi, ratio)
    for pole in expected.ravel():
        # 1e-6 of the polynomial's scale: a double root moves by the root of an error.
        distance = np.abs(np.linalg.eigvals(loop.matrix) - pole).min()
        assert distance < 1e-6 * np.abs(expected).max()
    np.testing.assert_array_equal(loop.share, 0.0)


def test_the_formula_solves_its_polynomial():
    c, k, rho, phi, b = 40.0, 75.0, 120.0, 0.8, 1.3
    poles = layer_poles(c, k, rho, phi, b)
    loop = poles**3 + b * (poles + c) * ((k + rho / phi) * poles + k * rho / phi)
    np.testing.assert_allclose(np.abs(loop), 0.0, atol=1e-6)
    sliding = sliding_poles(c, k, rho, phi, b)
    residual = sliding[1:] ** 2 + (k + rho / phi) * b * sliding[1:] + k * rho / phi * b
    assert sliding[0] == -c
    np.testing.assert_allclose(np.abs(residual), 0.0, atol=1e-9 * k * rho)


def test_with_a_small_c_the_loop_has_the_poles_of_sigma_and_s():
    for c, distance in ((1.0, 0.05), (0.1, 0.005)):
        found, limit = layer_poles(c, 100.0, 500.0, 1.0), sliding_poles(c, 100.0, 500.0, 1.0)
        np.testing.assert_allclose(together(found), together(limit), rtol=distance)
    # Well damped from rho / phi = 2 k / b on: (1 + 2)² > 8 ζ² at ζ = 0.7.
    slow = sliding_poles(1.0, 10.0, 20.0, 1.0)[1]
    assert -slow.real / abs(slow) >= 0.7
    # A vast gain leaves -k, not zero, beside the fast pole.
    assert sliding_poles(1.0, 75.0, 1e12, 1.0)[1].real == pytest.approx(-75.0, rel=1e-9)


@settings(deadline=None, max_examples=50)
@given(gain, gain, st.floats(10.0, 500.0), st.floats(0.2, 2.0))
def test_a_joint_that_is_too_heavy_is_unstable(c, k, rho, phi):
    least = float(least_mass_ratio(c, k, rho, phi))
    assert layer_poles(c, k, rho, phi, 1.01 * least).real.max() < 0.0
    assert layer_poles(c, k, rho, phi, 0.99 * least).real.max() > 0.0
    at_the_limit = layer_poles(c, k, rho, phi, least)
    assert np.abs(at_the_limit.real).min() < 1e-6 * np.abs(at_the_limit).max()


def test_without_gravity_and_damping_the_poles_are_those_of_the_coupled_block():
    # In e, sigma and s: e' = sigma - c e, sigma' = c e' - M^-1 m_hat (k sigma + r s).
    plant = continuous_plant()
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, joints.HOME)
    mass = plant.CalcMassMatrix(context)
    gains = GAINS.unpack(TABLE_12.array())
    A = np.linalg.solve(mass, np.diag(gains.m_hat))
    c, k, r = np.diag(gains.c), np.diag(gains.k), np.diag(gains.rho / gains.phi)
    sigma_rate = np.hstack([-c @ c, c - A @ k, -A @ r])
    s_rate = sigma_rate + np.hstack([0 * c, k, 0 * c])
    block = np.vstack([np.hstack([-c, np.eye(6), 0 * c]), sigma_rate, s_rate])
    found = np.linalg.eigvals(layer_matrix(mass, TABLE_12))
    np.testing.assert_allclose(together(found), together(np.linalg.eigvals(block)), rtol=1e-6)


@pytest.mark.parametrize("model", [None, RobotModel([1.5] * 6, 25.0, [0.2, 0.0, 0.0])])
def test_drake_finds_the_block_matrix_of_the_robot(model):
    q = np.array([4.0, 0.3, -0.8, 1.1, -0.6, 0.4])
    plant = continuous_plant(model)
    context = plant.CreateDefaultContext()

    def gravity(at):
        plant.SetPositions(context, at)
        return plant.CalcGravityGeneralizedForces(context)

    h = 1e-5
    stiffness = np.column_stack(
        [(gravity(q + h * d) - gravity(q - h * d)) / (2 * h) for d in np.eye(6)]
    )
    plant.SetPositions(context, q)
    expected = layer_matrix(plant.CalcMassMatrix(context), TABLE_12, stiffness, DAMPING)
    found = linearise(q, TABLE_12, model).matrix
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6)


def test_all_poles_are_stable_over_the_workspace():
    table_11 = of_kind(IntegralSlidingMode, load_scenario("joint_sine").controller)
    for gains in (table_11, TABLE_12):
        for q in np.random.default_rng(2).uniform(joints.LOWER, joints.UPPER, (20, 6)):
            poles = closed_loop_poles(q, gains)
            assert poles.shape == (18,)
            assert (np.diff(poles.real) <= 0.0).all()
            assert poles[0].real < -5.0


def test_what_holds_the_mast():
    weight = 735.5 * 9.81
    loop = linearise(joints.HOME, TABLE_12)
    assert loop.s[0] == pytest.approx(weight / (735.5 * 500.0))
    # The raw law has 500 N in its layer, and the weight is beyond it.
    raw = IntegralSlidingMode(mode=["paper"] + ["normalised"] * 5)
    assert linearise(joints.HOME, raw).share[0] == pytest.approx(weight / 500.0)


def test_without_an_integral_the_loop_is_not_asymptotically_stable():
    gains = IntegralSlidingMode(k=[0.0] * 6)
    assert closed_loop_poles(joints.HOME, gains)[0].real == pytest.approx(0.0, abs=1e-9)


def test_a_posture_out_of_range_is_refused():
    with pytest.raises(ValueError, match=r"^q: d1 = 1 m, allowed"):
        linearise([1.0, 0, 0, 0, 0, 0], TABLE_12)
