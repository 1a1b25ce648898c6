"""The effort that holds the arm against gravity, in closed form.

Backwards along the chain of Table 1 the weights of the links add up, with their moment about each
joint's frame; the component about the joint's axis is the effort. Frame L_i of link i comes after
the motion of joint i, as in the URDF.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant

from scara_drake import robot
from scara_drake.common.layout import Rows
from scara_drake.kinematics import A4

Array = NDArray[np.float64]


class Links(NamedTuple):
    """Links 1 to 6 in a kernel, each row (6,).

    Attributes:
        weight: [N].
        x: of the centre of mass in L_i, times the weight [N m].
        y: likewise.
        z: likewise.
    """

    weight: Array
    x: Array
    y: Array
    z: Array


LINKS = Rows(Links)
links_of = LINKS.reader()


@njit(cache=True)
def gravity_effort(q: Array, links: Array, effort: Array) -> None:
    """Write the effort (6,) that holds the arm at rest in q (6,) [N, N m].

    Args:
        q: configuration [m, rad].
        links: (4, 6), see `gravity_parameters`.
        effort: written; minus the generalized force of gravity.
    """
    link = links_of(links)
    s3, c3 = np.sin(q[2]), np.cos(q[2])
    s4, c4 = np.sin(q[3]), np.cos(q[3])
    s5, c5 = np.sin(q[4]), np.cos(q[4])
    s6, c6 = np.sin(q[5]), np.cos(q[5])
    s45, c45 = np.sin(q[3] + q[4]), np.cos(q[3] + q[4])
    # The vertical in L_6, L_5, L_4 and L_3; the axis of a joint is z of its frame, and about it a
    # weight with the moment (x, y, z) has the effort x up_y - y up_x.
    up6_x, up6_y = -c6 * s3 * c45 + s6 * c3, s6 * s3 * c45 + c6 * c3
    up5_x, up5_y = -s3 * c45, s3 * s45
    up4_x, up4_y = -s3 * c4, s3 * s4
    up3_x, up3_y = -s3, -c3

    weight = link.weight[5]
    x, y, z = link.x[5], link.y[5], link.z[5]
    effort[5] = x * up6_y - y * up6_x

    # From L_6 to L_5: Rx(90°) Rz(θ6).
    weight += link.weight[4]
    x, y, z = (
        link.x[4] + c6 * x - s6 * y,
        link.y[4] - z,
        link.z[4] + s6 * x + c6 * y,
    )
    effort[4] = x * up5_y - y * up5_x

    # From L_5 to L_4: Tx(a4) Rz(θ5).
    x, y, z = (
        link.x[3] + c5 * x - s5 * y + A4 * weight,
        link.y[3] + s5 * x + c5 * y,
        link.z[3] + z,
    )
    effort[3] = x * up4_y - y * up4_x

    # From L_4 to L_3: Tz(d3) Rx(90°) Rz(θ4); d3 lies along the axis of joint 3.
    x, y = link.x[2] + c4 * x - s4 * y, link.y[2] - z
    effort[2] = x * up3_y - y * up3_x

    # The axis of joint 2 and the mast are vertical.
    effort[1] = 0.0
    effort[0] = link.weight.sum()


@lru_cache(maxsize=1)
def gravity_parameters() -> Array:
    """Return the nominal robot's links as `gravity_effort` takes them (4, 6)."""
    plant = MultibodyPlant(time_step=0.0)
    robot.add_scara(plant)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    g = float(np.linalg.norm(plant.gravity_field().gravity_vector()))
    bodies = [plant.GetBodyByName(f"link_{index}") for index in range(1, 7)]
    weight = np.array([g * body.get_mass(context) for body in bodies])
    centres = np.array([body.CalcCenterOfMassInBodyFrame(context) for body in bodies])
    x, y, z = (weight[:, np.newaxis] * centres).T
    links = LINKS.pack(weight=weight, x=x, y=y, z=z)
    links.setflags(write=False)
    return links
