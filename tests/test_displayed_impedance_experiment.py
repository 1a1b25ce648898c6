"""What a hand is shown over the channels against its closed forms, and how that is judged."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from small_experiments import small

from scara_drake.experiments.claim import REPRODUCED, Experiment
from scara_drake.experiments.literature import displayed_impedance as module


def experiment() -> Experiment:
    return small("displayed_impedance")


def met(data: xr.Dataset) -> list[bool]:
    return [claim.verdict == REPRODUCED for claim in module.claims(data)]


def test_it_judges_what_it_is_given() -> None:
    data = experiment().data
    assert met(data) == [True] * 4
    for coupling, left in (
        ("wave variables", [False, True, True, True]),
        ("P+d", [True, False, True, True]),
    ):
        off = data.copy(deep=True)
        off["found"].loc[{"coupling": coupling, "link": "none"}] *= 1.06
        assert met(off) == left
    turned = data.copy(deep=True)
    turned["apart"].loc[{"coupling": "wave variables", "link": "none"}][20] = 0.06
    assert met(turned) == [True, True, False, True]
    orderly = data.copy(deep=True)
    orderly["found"].loc[{"link": "5g"}] = orderly.form.sel(link="5g")
    assert met(orderly) == [True, True, True, False]


def test_the_press_over_no_delay_shows_what_the_closed_form_has() -> None:
    none = experiment().data.sel(link="none")
    assert bool(none.constant.all())
    # P+d without the spring of a wall in its way: 100 N/m and 30 N s/m, that is all of it.
    low = none.apart.sel(coupling="P+d")
    assert float(low.max()) < 0.005
    waves = none.apart.sel(coupling="wave variables", frequency=slice(0.3, 3.0))
    assert float(waves.max()) < 0.02


def test_jitter_without_a_buffer_is_seen_at_almost_every_frequency() -> None:
    waves = experiment().data.sel(coupling="wave variables")
    assert float(waves.apart.sel(link="5g").median()) > 0.3
    assert float(waves.apart.sel(link="5g, buffered").median()) < 0.15
    assert float(waves.apart.sel(link="5g, constant").median()) < 0.02
    assert float(waves.delay.sel(link="5g, constant")) == pytest.approx(0.028)
    assert np.isfinite(waves.apart).all()
