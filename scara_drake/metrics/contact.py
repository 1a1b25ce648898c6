"""What a press asks of the joints."""

from __future__ import annotations

import xarray as xr


def yielding_joints(recording: xr.Dataset) -> xr.DataArray:
    """Share of the time in contact (joint) in which a joint yields to it.

    A joint yields while it is outside its boundary layer, |s| >= phi: the robust part rho m_hat of
    its effort is spent and no longer holds it to its reference. NaN if nothing was touched.

    Raises:
        ValueError: the recording has no saturation.
    """
    if "saturation" not in recording:
        raise ValueError("recording: no saturation, allowed that of a sliding mode controller")
    touching = (recording.penetration > 0.0).any("surface")
    outside = recording.saturation % 2  # 1 outside the layer, 2 at the effort limit, 3 both
    return outside.where(touching).mean("time")
