"""The LeafSystem that says how the environment pushes the tool."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import Value
from pydrake.multibody.plant import ContactResults
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from scara_drake.common.state import declare_state
from scara_drake.environment.law import tool_contact
from scara_drake.environment.scene import ContactShapes
from scara_drake.environment.surfaces import Environment

Array = NDArray[np.float64]


class ImpedanceContact(LeafSystem):
    """Contact of the tool with the surfaces of an environment, see `law`.

    Input ports:
        state (12): q, v measured [m, rad, m/s, rad/s]
        contact_results (abstract): of the plant; only where a surface has the law "drake"
    Output ports, all discrete state:
        f_env_on_tool_W (3): force of the environment on the tool [N]
        generalized_force (6): J_vᵀ f of the surfaces whose law is not Drake's, which acts in the
            plant already [N, N m]
        penetration (n): depth below each surface, zero outside [m]; n may be 0
    Update (every period): the contact of the state at the end of the period, `tool_contact`, plus
        what the plant's contact results have of the tool. Initial: that of the state at the start.

    A plant with sampled output ports steps before discrete states are updated: the force written at
    tick k is that of the state from which step k + 1 starts, so the contact adds no delay. Drake's
    own contact is the one that acted during step k.
    """

    def __init__(
        self, environment: Environment, period: float = 1e-3, shapes: ContactShapes | None = None
    ):
        """Declare the ports.

        Args:
            environment: the surfaces.
            period: of the updates, that of the plant [s].
            shapes: what `add_surfaces` returned; needed where a surface has the law "drake".

        Raises:
            ValueError: a surface has the law "drake", but `shapes` is None.
        """
        super().__init__()
        self._surfaces = environment.parameters()
        self._period = period
        self._state = self.DeclareVectorInputPort("state", 12)
        self._f = declare_state(self, 3, "f_env_on_tool_W")
        self._generalized = declare_state(self, 6, "generalized_force")
        self._penetration = declare_state(self, len(environment.surfaces), "penetration")
        self._shapes = shapes
        self._results = None
        if any(surface.law == "drake" for surface in environment.surfaces):
            if shapes is None:
                raise ValueError("shapes: None, allowed what add_surfaces returned (law 'drake')")
            self._results = self.DeclareAbstractInputPort(
                "contact_results", Value[ContactResults]()
            )
        self.DeclareInitializationDiscreteUpdateEvent(self._start)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _start(self, context: Context, discrete: DiscreteValues) -> None:
        self._write(context.get_time(), context, discrete)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        self._write(context.get_time() + self._period, context, discrete)

    def _write(self, time: float, context: Context, discrete: DiscreteValues) -> None:
        f_W = discrete.get_mutable_value(self._f)
        penetration = discrete.get_mutable_value(self._penetration)
        tool_contact(
            time,
            self._state.Eval(context),
            self._surfaces,
            penetration,
            f_W,
            discrete.get_mutable_value(self._generalized),
        )
        if self._results is not None and self._shapes is not None:
            add_plant_contact(self._results.Eval(context), self._shapes, penetration, f_W)


def add_plant_contact(
    results: ContactResults, shapes: ContactShapes, penetration: Array, f_W: Array
) -> None:
    """Add a plant's contact of the tool to the penetrations (n,) [m] and to the force (3,) [N].

    The contact with surfaces that are not in `shapes.compliant` is not looked at, nor is that of
    the other links.
    """
    for index in range(results.num_point_pair_contacts()):
        info = results.point_pair_contact_info(index)
        pair = info.point_pair()
        # The contact force is that on body B.
        for tool, other, sign in ((pair.id_B, pair.id_A, 1.0), (pair.id_A, pair.id_B, -1.0)):
            surface = shapes.compliant.get(other)
            if tool in shapes.tool and surface is not None:
                f_W += sign * info.contact_force()
                penetration[surface] = max(penetration[surface], pair.depth)
