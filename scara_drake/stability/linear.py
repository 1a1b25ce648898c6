r"""The closed loop linearised inside the boundary layer, and its poles.

Inside the layer the law is linear, with :math:`r = \rho / \phi`:

.. math::

    \tau = \hat m\,((k + r)\,\sigma - r z), \quad \dot z = -k\,\sigma, \quad
    \sigma = \dot e + c\,e

so with M(q), the gradient G of the gravity's efforts and the damping B of the joints

.. math::

    M \ddot e = -\tau + G e - B \dot e

For one joint without G and B, with the plant gain :math:`b = \hat m / M` and :math:`a = k + r`, the
poles solve

.. math::

    \lambda^3 + b\,(\lambda + c)\,(a\,\lambda + k\,r) = 0

They are stable while :math:`b\,a\,(a c + k r) > c\,k\,r`: a joint can be too heavy for its gains.
Where :math:`c\,\dot e` is counted as a part of the perturbation, as equation (30) does, what is
left are the poles of :math:`\sigma` and s, :math:`\lambda^2 + a b\,\lambda + k r b = 0`, and -c;
that is the limit of c much below a b.

`linearise` lets Drake differentiate the diagram itself; the closed forms are what it is compared
with.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import BasicVector_, Context, DiagramBuilder, LeafSystem_
from pydrake.systems.primitives import ConstantVectorSource, Linearize
from pydrake.systems.scalar_conversion import TemplateSystem

from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.ismc_law import GAINS, Gains
from scara_drake.joints import check_configuration
from scara_drake.robot import RobotModel, add_scara

Array = NDArray[np.float64]
Poles = NDArray[np.complex128]

AT_REST = 1e-6  # largest rate of a state at the equilibrium [m/s², rad/s²]


class Linearised(NamedTuple):
    """The loop around an equilibrium, in the states (q, v, z).

    Attributes:
        matrix: (18, 18), x' = matrix x.
        s: that holds the robot against gravity (6,) [m/s, rad/s].
        share: |s| / phi (6,); the equilibrium lies in the layer where it is below 1.
    """

    matrix: Array
    s: Array
    share: Array


@TemplateSystem.define("ContinuousLayer_")
def ContinuousLayer_(T):  # type: ignore[no-untyped-def]  # noqa: D103 (Drake's form of a template)
    class Impl(LeafSystem_[T]):
        """The law of `ismc_law` in continuous time, without limits, as in the boundary layer.

        Input ports:
            state (12): q, v [m, rad, m/s, rad/s]
            state_desired (12): q, v references
        Output port:
            actuation (6): tau [N, N m]
        Continuous state: z (6) [m/s, rad/s], z' = -k sigma.
        """

        def _construct(self, gains: Gains, converter: Any = None) -> None:
            LeafSystem_[T].__init__(self, converter)
            self._gains = gains
            self._state = self.DeclareVectorInputPort("state", 12)
            self._desired = self.DeclareVectorInputPort("state_desired", 12)
            self.DeclareContinuousState(6)
            self.DeclareVectorOutputPort(
                "actuation",
                BasicVector_[T](6),
                self._calc,
                prerequisites_of_calc={self.all_input_ports_ticket(), self.xc_ticket()},
            )

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(self, other._gains, converter=converter)

        def _sigma(self, context: Context) -> Any:
            error = self._desired.Eval(context) - self._state.Eval(context)
            return error[6:] + self._gains.c * error[:6]

        def _calc(self, context: Context, output: Any) -> None:
            sigma, z = self._sigma(context), context.get_continuous_state_vector().CopyToVector()
            g = self._gains
            u = g.k * sigma + g.rho / g.phi * (sigma - z)
            output.SetFromVector(g.m_hat * u)

        def DoCalcTimeDerivatives(self, context: Context, derivatives: Any) -> None:
            derivatives.get_mutable_vector().SetFromVector(-self._gains.k * self._sigma(context))

    return Impl


ContinuousLayer = ContinuousLayer_[None]


def linearise(
    q: ArrayLike,
    controller: IntegralSlidingMode,
    model: RobotModel | None = None,
    plant: MultibodyPlant | None = None,
) -> Linearised:
    """Linearise the law on the continuous robot at rest in a posture, by Drake's differentiation.

    z is where it holds the robot against gravity. The layer is taken to reach as far as that needs;
    `Linearised.share` says whether it does. Feedforwards of the controller are left out.

    Args:
        q: posture (6,) [m, rad].
        controller: the gains.
        model: of the robot; None is the nominal one.
        plant: a finalized continuous plant with six joints, in place of the model; it becomes part
            of a Diagram, so it serves once.

    Raises:
        ValueError: q is not a posture within the ranges.
    """
    q = check_configuration("q", q)
    gains = GAINS.unpack(controller.array())
    plant = plant if plant is not None else continuous_plant(model)
    builder = DiagramBuilder()
    builder.AddSystem(plant)
    law = builder.AddSystem(ContinuousLayer(gains))
    reference = builder.AddSystem(ConstantVectorSource(np.concatenate([q, np.zeros(6)])))
    builder.Connect(plant.get_state_output_port(), law.GetInputPort("state"))
    builder.Connect(reference.get_output_port(), law.GetInputPort("state_desired"))
    builder.Connect(law.get_output_port(), plant.get_actuation_input_port())
    diagram = builder.Build()

    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    plant.SetPositions(plant_context, q)
    held = -plant.CalcGravityGeneralizedForces(plant_context)
    s = held * gains.phi / (gains.m_hat * gains.rho)
    law.GetMyMutableContextFromRoot(context).SetContinuousState(-s)
    loop = Linearize(diagram, context, equilibrium_check_tolerance=AT_REST)
    return Linearised(loop.A(), s, np.abs(s) / gains.phi)


def closed_loop_poles(
    q: ArrayLike, controller: IntegralSlidingMode, model: RobotModel | None = None
) -> Poles:
    """Poles of the loop (18,) [1/s] in a posture, see `linearise`; the slowest comes first.

    Raises:
        ValueError: q is not a posture within the ranges.
    """
    poles = np.linalg.eigvals(linearise(q, controller, model).matrix).astype(np.complex128)
    return poles[np.argsort(-poles.real)]


def layer_poles(
    c: ArrayLike, k: ArrayLike, rho: ArrayLike, phi: ArrayLike, mass_ratio: ArrayLike = 1.0
) -> Poles:
    """Poles (..., 3) [1/s] of one joint in the layer, l³ + b (l + c) (a l + k r) = 0.

    Args:
        c: [1/s], as all others a number or an array of one shape.
        k: [1/s].
        rho: [m/s², rad/s²].
        phi: [m/s, rad/s].
        mass_ratio: plant gain b = m_hat / M.
    """
    c, k, rho, phi, b = np.broadcast_arrays(c, k, rho, phi, mass_ratio)
    r = rho / phi
    a = k + r
    cubic = np.stack([np.ones(c.shape), b * a, b * (a * c + k * r), b * c * k * r], axis=-1)
    poles = np.empty((*c.shape, 3), dtype=np.complex128)
    for index in np.ndindex(c.shape):
        poles[index] = np.roots(cubic[index])
    return poles


def sliding_poles(
    c: ArrayLike, k: ArrayLike, rho: ArrayLike, phi: ArrayLike, mass_ratio: ArrayLike = 1.0
) -> Poles:
    """Poles (..., 3) [1/s] with c e' as a perturbation: -c, and those of sigma and s.

    What a design begins with: damping of 0.7 takes rho / phi of about 2 k / b, see `layer_poles`
    for the arguments and for the loop as it is.
    """
    c, k, rho, phi, b = np.broadcast_arrays(c, k, rho, phi, mass_ratio)
    r = rho / phi
    half = 0.5 * b * (k + r)
    far = -half - np.sqrt((half * half - b * k * r).astype(np.complex128))
    # The small root by the product of both: their difference would cancel.
    return np.stack([-c + 0j, b * k * r / far, far], axis=-1)


def least_mass_ratio(c: ArrayLike, k: ArrayLike, rho: ArrayLike, phi: ArrayLike) -> Array:
    """Least plant gain m_hat / M at which a joint is stable, by Routh: c k r / (a (a c + k r)).

    Arguments as `layer_poles`.
    """
    c, k, rho, phi = (np.asarray(x, dtype=np.float64) for x in (c, k, rho, phi))
    r = rho / phi
    a = k + r
    return c * k * r / (a * (a * c + k * r))


def layer_matrix(
    mass: Array, controller: IntegralSlidingMode, stiffness: Array | None = None, damping: Any = 0.0
) -> Array:
    """Matrix (18, 18) of the loop in the states (q, v, z), in closed form.

    Args:
        mass: M(q) (6, 6) [kg, kg m²].
        controller: the gains.
        stiffness: G (6, 6), gradient of the gravity's efforts on the joints; None is zero.
        damping: of the joints (6,) [N s/m, N m s/rad].
    """
    g = GAINS.unpack(controller.array())
    r = g.rho / g.phi
    on_v = -np.diag(g.m_hat * (g.k + r))
    on_q = on_v * g.c
    if stiffness is not None:
        on_q = on_q + stiffness
    on_v = on_v - np.diag(np.broadcast_to(damping, 6))
    eye, none = np.eye(6), np.zeros((6, 6))
    acceleration = np.linalg.solve(mass, np.hstack([on_q, on_v, -np.diag(g.m_hat * r)]))
    memory = np.hstack([np.diag(g.k * g.c), np.diag(g.k), none])
    return np.vstack([np.hstack([none, eye, none]), acceleration, memory])


def continuous_plant(model: RobotModel | None = None) -> MultibodyPlant:
    """Return the robot in a finalized plant of continuous time."""
    plant = MultibodyPlant(time_step=0.0)
    plant.set_name("plant")
    add_scara(plant, model)
    plant.Finalize()
    return plant
