"""Arrays as a caller gives them, and as the kernels take them: real numbers, double precision."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def real_array(name: str, value: Any) -> Array:
    """Return a contiguous copy of an array of real numbers.

    Raises:
        ValueError: complex, masked, boolean or no numbers at all; names the argument.
    """
    if type(value) is np.ndarray and value.dtype.char == "d":
        return np.array(value, order="C")
    parts = value if isinstance(value, list | tuple) else (value,)
    if any(np.ma.isMaskedArray(part) for part in parts):
        raise ValueError(f"{name}: a masked array, allowed one without masks, such as filled()")
    try:
        given = np.asarray(value)
    except (ValueError, TypeError, OverflowError):
        raise ValueError(f"{name}: no rectangular array, allowed real numbers") from None
    if given.dtype.kind not in "iuf":
        raise ValueError(f"{name}: values of type {given.dtype}, allowed real numbers")
    return np.array(given, dtype=np.float64, order="C")
