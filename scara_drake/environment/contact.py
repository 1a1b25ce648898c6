"""The LeafSystem that says how the environment pushes the tool."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import Value
from pydrake.multibody.plant import ContactResults

from scara_drake.common.block import Block, Declaration, Input, Kernel, Memory
from scara_drake.environment.force import tool_contact, tool_contact_next
from scara_drake.environment.own import OwnSurfaces
from scara_drake.environment.scene import ContactShapes
from scara_drake.environment.surfaces import Environment

Array = NDArray[np.float64]


class ImpedanceContact(Block):
    """Contact of the tool with the surfaces of an environment, see `law` and `own`.

    Ports:
        input state (12): q, v measured [m, rad, m/s, rad/s].
        input contact_results (abstract): of the plant; only where a surface has the law "drake".
        output f_env_on_tool_W (3) [N]: force of the environment on the tool.
        output generalized_force (6) [N, N m]: J_vᵀ f of the surfaces whose law is not Drake's,
            which acts in the plant already.
        output penetration (n) [m]: depth below each surface, zero outside; n may be 0.

    Update, at t = k period: the contact of the state with the surfaces of t + period,
    `tool_contact`, plus what the plant's contact results have of the tool. Initial: that of the
    state and the surfaces at the start.

    A plant with sampled output ports steps before discrete states are updated: the force written at
    tick k is that of the state from which step k + 1 starts, so the contact adds no delay. Drake's
    own contact is the one that acted during step k.

    Args:
        environment: the surfaces.
        period: of the updates, that of the plant [s].
        shapes: what `add_surfaces` returned; needed where a surface has the law "drake".

    Raises:
        ValueError: a surface has the law "drake", but `shapes` is None.
    """

    def __init__(
        self, environment: Environment, period: float = 1e-3, shapes: ContactShapes | None = None
    ) -> None:
        inputs = {"state": Input(12)}
        start: Kernel = tool_contact
        update: Kernel = tool_contact_next
        own = OwnSurfaces.of(environment)
        if own.surfaces:
            start, update = OwnContact(own, 0.0).write, OwnContact(own, period).write
        if any(surface.law == "drake" for surface in environment.surfaces):
            if shapes is None:
                raise ValueError("shapes: None, allowed what add_surfaces returned (law 'drake')")
            inputs["contact_results"] = Input(value=Value[ContactResults]())
            start = PlantContact(shapes, OwnContact(own, 0.0)).add
            update = PlantContact(shapes, OwnContact(own, period)).add
        super().__init__(
            Declaration(
                inputs=inputs,
                memory={
                    "f_env_on_tool_W": Memory(3, port=True),
                    "generalized_force": Memory(6, port=True),
                    "penetration": Memory(len(environment.surfaces), port=True),
                },
                parameters={"surfaces": environment.parameters(), "period": period},
                period=period,
                initialize=start,
                update=update,
            )
        )


@dataclass(frozen=True)
class OwnContact:
    """`tool_contact` where some surfaces are of kinds that it does not know.

    Attributes:
        own: these surfaces.
        ahead: how much later than now the surfaces are looked at [s].
    """

    own: OwnSurfaces
    ahead: float

    def write(
        self,
        t: float,
        state: Array,
        surfaces: Array,
        penetration: Array,
        f_env_on_tool_W: Array,
        generalized_force: Array,
    ) -> None:
        """Write the contact of the tool but for Drake's."""
        t += self.ahead
        rows = self.own.rows(t, state, surfaces) if self.own.surfaces else surfaces
        tool_contact(t, state, rows, penetration, f_env_on_tool_W, generalized_force)


@dataclass(frozen=True)
class PlantContact:
    """`OwnContact` together with the plant's own contact of the tool.

    Attributes:
        shapes: between which that acts.
        others: the contact that is not the plant's.
    """

    shapes: ContactShapes
    others: OwnContact

    def add(
        self,
        t: float,
        state: Array,
        surfaces: Array,
        penetration: Array,
        f_env_on_tool_W: Array,
        generalized_force: Array,
        contact_results: ContactResults,
    ) -> None:
        """Write the contact of the tool, Drake's included where a surface has that law."""
        f = f_env_on_tool_W
        self.others.write(t, state, surfaces, penetration, f, generalized_force)
        add_plant_contact(contact_results, self.shapes, penetration, f)


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
