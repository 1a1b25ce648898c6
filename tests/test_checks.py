import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scara_drake.common import checks


@given(st.floats(allow_nan=True, allow_infinity=True), st.floats(-10, 0), st.floats(0, 10))
def test_number_accepts_exactly_the_finite_values_in_the_range(value, low, high):
    if math.isfinite(value) and low <= value <= high:
        checks.number("x", value, low, high)
    else:
        with pytest.raises(ValueError, match=r"^x: .*, allowed .* to "):
            checks.number("x", value, low, high)


def test_messages_name_field_value_and_what_is_allowed():
    with pytest.raises(ValueError, match=r"^gain\[1\]: -2.0, allowed 0 or more, finite$"):
        checks.vector("gain", [1.0, -2.0], 2, 0.0)
    with pytest.raises(ValueError, match=r"^gain: 3 entries, allowed 2$"):
        checks.vector("gain", [1.0, 2.0, 3.0], 2)
    with pytest.raises(ValueError, match=r"^phi: 0, allowed above 0, finite$"):
        checks.number("phi", 0, checks.ABOVE_ZERO)
    with pytest.raises(ValueError, match=r"^speed: 0, allowed above 0, up to 5$"):
        checks.number("speed", 0, checks.ABOVE_ZERO, 5)
    with pytest.raises(ValueError, match=r"^kind: 'c', allowed a, b$"):
        checks.choice("kind", "c", ["a", "b"])
