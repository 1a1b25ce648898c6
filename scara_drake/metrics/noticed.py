r"""What a hand would notice: differences in just noticeable differences (JND).

One JND is what is told from the reference in a stated share of the trials; an error of less is
there but not felt.

Force: 7 % of a reference of 2.5 to 10 N (Pang, Tan and Durlach, Perception & Psychophysics 49,
1991: an active squeeze of 5 to 30 mm at 25 to 160 mm/s, five people). Outside that range there is
no number in that work, and ours is: below, the JND of 2.5 N, which is 0.175 N, so that a force of
zero has one as well; above, the same 7 %. `Noticed.tested` says for how much of the time the
reference was within the range.

Compliance: 15 %, the best that was found where work and terminal force told nothing; 8 % where they
do (both Tan, Durlach, Shao and Wei, ASME DSC 49, 1993), and 22 % where they mislead (Tan, Durlach,
Beauregard and Srinivasan, Perception & Psychophysics 57, 1995). For velocity there is none here.

The force at the master is what is asked of the device, before the limit of its actuators: at that
limit a hand feels less, and more of an error than is told here.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import xarray as xr

from scara_drake.metrics.bilateral import force_error, force_sent, vector_size

FORCE: Final = 0.07  # JND over the reference
TESTED: Final = (2.5, 10.0)  # [N], references that this holds for
COMPLIANCE: Final = 0.15  # JND over the reference


class Noticed(NamedTuple):
    """How much of the error of a force would be noticed.

    Attributes:
        share: of the time in which the error is more than one JND.
        mean: error [JND].
        percentile95: error that is not exceeded for 95 % of the time [JND].
        tested: share of the time in which the reference is in the range that the JND was found in.
    """

    share: float
    mean: float
    percentile95: float
    tested: float


def force_jnd(reference: xr.DataArray) -> xr.DataArray:
    """Return the JND [N] of forces of a size [N]."""
    return FORCE * abs(reference).clip(min=TESTED[0])


def force_jnds(recording: xr.Dataset, force_scale: float = 1.0) -> xr.DataArray:
    """Error (time) [JND] of the force at the master from that at the tool, delay removed."""
    error = force_error(recording, force_scale)
    return error / force_jnd(vector_size(force_sent(recording, force_scale)))


def noticed(recording: xr.Dataset, force_scale: float = 1.0) -> Noticed:
    """Return how much of the error of the force at the master would be noticed.

    All of the recording counts, so the caller selects: with the free motion, a force that is shown
    where nothing is touched counts too.
    """
    jnds = force_jnds(recording, force_scale)
    reference = vector_size(force_sent(recording, force_scale))
    within = (reference >= TESTED[0]) & (reference <= TESTED[1])
    return Noticed(
        share=float((jnds > 1.0).mean()),
        mean=float(jnds.mean()),
        percentile95=float(np.quantile(jnds, 0.95)),
        tested=float(within.mean()),
    )


def compliance_jnds(displayed: float, stiffness: float, fraction: float = COMPLIANCE) -> float:
    """Difference [JND] between the compliance that is felt and the true one.

    Args:
        displayed: stiffness that is felt [N/m], above zero.
        stiffness: true one [N/m].
        fraction: JND over the true compliance.
    """
    return abs(stiffness / displayed - 1.0) / fraction
