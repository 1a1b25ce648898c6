"""The couplings on devices that exist: the data, and how they are judged."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from small_experiments import small

from scara_drake.experiments.claim import OURS, REPRODUCED, Experiment
from scara_drake.experiments.teleoperation import devices
from scara_drake.experiments.teleoperation.devices_claims import claims
from scara_drake.operator.kinesthetic_devices import DEVICES
from scara_drake.operator.master import Master


def experiment() -> Experiment:
    return small("devices")


def met(data: xr.Dataset) -> list[bool]:
    made = claims(data)
    assert all(claim.source == OURS for claim in made)
    return [claim.verdict == REPRODUCED for claim in made]


def test_verdicts() -> None:
    assert met(experiment().data) == [True] * 4


def test_the_own_device_has_one_scale() -> None:
    own = experiment().data.sel(device="own")
    for name, values in own.data_vars.items():
        full, natural = (values.sel(scale=scale).values for scale in devices.SCALES)
        np.testing.assert_array_equal(full, natural, str(name))
        assert values.attrs["units"], name
    assert not own.meter_bound.any()


def test_a_device_feels_no_more_than_it_has() -> None:
    touch = experiment().data.sel(device="touch")
    assert (touch.felt <= DEVICES["touch"].force + 1e-12).all()
    assert (touch.asked.sel(scale="full") > touch.felt.sel(scale="full")).all()


def test_the_scales_put_the_tool_where_it_would_be() -> None:
    job = devices.Job("delta.3", "natural", "TDPA", "none", 0, devices.PRESS, devices.DURATION)
    made = devices.scenario(job)
    assert made.coupling.position_scale == pytest.approx(0.5)
    assert made.coupling.force_scale == pytest.approx(0.5)
    assert isinstance(made.operator, Master)
    assert made.operator.targets[1] == pytest.approx([0.0, -0.08, 0.0])


def test_it_judges_what_it_is_given() -> None:
    data = experiment().data
    for figure, where, bad, broken in (
        ("stable", ("touch", "TDPA", "natural"), False, 0),
        ("energy_margin", ("touch", "TDPA", "full"), -0.1, 0),
        ("meter_error", ("touch", "direct", "full"), 0.1, 1),
        ("stable", ("own", "direct", "full"), True, 2),
        ("stable", ("touch", "direct", "full"), False, 2),
        ("asked", ("touch", "direct", "full"), 20.0, 2),
        ("cut", ("touch", "TDPA", "full"), 0.4, 3),
        ("cut", ("touch", "TDPA", "natural"), 0.01, 3),
        ("cut", ("own", "TDPA", "full"), 0.01, 3),
        ("felt", ("touch", "TDPA", "natural"), 1.0, 3),
    ):
        other = data.copy(deep=True)
        other[figure].loc[dict(zip(("device", "coupling", "scale"), where, strict=True))] = bad
        assert met(other) == [index != broken for index in range(4)], (figure, where)
    assert not met(data.sel(device=["own"]))[1]


def test_what_was_not_run_is_not_judged() -> None:
    data = experiment().data
    assert len(claims(data.sel(coupling=["direct"], device=["touch"]))) == 1
    assert len(claims(data.sel(coupling=["TDPA"]))) == 3
