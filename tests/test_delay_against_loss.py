"""Delay against loss: what is run, and how it is judged."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from small_experiments import small

from scara_drake.coupling.position_damping import PositionDamping
from scara_drake.experiments.claim import (
    IN_KIND,
    NOT_REPRODUCED,
    OURS,
    REPRODUCED,
    Experiment,
)
from scara_drake.experiments.literature import delay_against_loss as module


def experiment() -> Experiment:
    return small("delay_against_loss")


def verdicts(data: xr.Dataset) -> dict[str, str]:
    return {claim.statement: claim.verdict for claim in module.claims(data)}


def test_what_is_run_has_the_delay_and_the_loss() -> None:
    made = module.scenario("P+d", 0.272, 0.25, 3)
    for link in (made.channel.up, made.channel.down):
        packets: Any = link
        assert packets.delay.delay == 0.136
        assert packets.loss.in_good == 0.25
    assert made.seed == 3
    coupling = made.coupling
    assert isinstance(coupling, PositionDamping)
    # Stable over the longest, with a delay in the loop that the blocks add.
    assert coupling.margin(0.5 * module.DELAYS[-1] + 5e-3, 0.5 * module.DELAYS[-1] + 5e-3) > 1.0


def test_the_data_are_labelled_and_the_verdicts_those_of_the_runs() -> None:
    found = experiment()
    assert dict(found.data.sizes) == {"coupling": 3, "delay": 2, "loss": 2, "seed": 1}
    for name, values in found.data.data_vars.items():
        assert values.attrs["units"], name
        assert (values > 0.0).all()
    assert all(claim.source == OURS for claim in found.claims)
    told = verdicts(found.data)
    assert told["Loss is less critical than delay: TDPA"] == REPRODUCED
    # The energy that a lost wave leaves over holds the wave over gaps, where nothing spends it.
    assert told["What makes loss costly to waves is the term that takes their drift away"] == (
        REPRODUCED
    )


def made_up(loss: float, delay: float) -> xr.Dataset:
    """Errors (delay, loss) that grow by so much with each, for every coupling and seed."""
    names = list(module.COUPLINGS)
    grid = 1.0 + delay * np.array([0.0, 0.5, 1.0])[:, None] + loss * np.array([0.0, 0.5, 1.0])
    values = np.broadcast_to(grid[None, :, :, None], (len(names), 3, 3, 3))
    return xr.Dataset(
        {name: (("coupling", "delay", "loss", "seed"), values.copy()) for name in module.FIGURES},
        coords={"coupling": names},
    )


def test_it_judges_what_it_is_given() -> None:
    names = list(module.COUPLINGS)
    orders = [f"Loss is less critical than delay: {name}" for name in names]
    remedies = [statement for statement, _ in module.REMEDIES.values()]
    data = made_up(loss=1.0, delay=2.0)
    assert verdicts(data) == dict.fromkeys(orders, REPRODUCED) | dict.fromkeys(
        remedies, NOT_REPRODUCED
    )
    assert [verdicts(made_up(2.0, 1.0))[order] for order in orders] == [NOT_REPRODUCED] * len(names)
    # Of one of the errors only.
    data["force"] = made_up(2.0, 1.0).force
    assert [verdicts(data)[order] for order in orders] == [IN_KIND] * len(names)
    # Of a remedy a quarter may be left.
    for left, verdict in ((0.24, REPRODUCED), (0.26, NOT_REPRODUCED)):
        data = made_up(1.0, 2.0)
        for name in module.REMEDIES:
            data.position.loc[{"coupling": name}] = (
                made_up(left, 2.0).position.sel(coupling=name).values
            )
        assert [verdicts(data)[remedy] for remedy in remedies] == [verdict, verdict]


def test_the_seeds_have_to_agree() -> None:
    data = made_up(loss=1.9, delay=2.0)
    order = "Loss is less critical than delay: TDPA"
    assert verdicts(data)[order] == REPRODUCED
    apart = xr.DataArray([0.9, 1.0, 1.1], dims="seed")
    assert verdicts(data * apart)[order] == NOT_REPRODUCED


def test_the_effect_is_the_largest_change_with_its_interval() -> None:
    data = made_up(loss=3.0, delay=2.0).sel(coupling="TDPA") * xr.DataArray(
        [1.0, 2.0, 3.0], dims="seed"
    )
    found = module.effects(data, "force")
    # Mean 2, standard deviation 1, Student's t for two degrees of freedom.
    half = 4.302652729911275 / np.sqrt(3.0)
    for what, effect in (("loss", 3.0), ("delay", 2.0)):
        wanted = effect * np.array([2.0, 2.0 - half, 2.0 + half])
        np.testing.assert_allclose(found[what], wanted, rtol=1e-9)


def test_a_run_that_breaks_off_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> dict[str, float]:
        raise ValueError("no force")

    monkeypatch.setattr(module, "figures", broken)
    with pytest.raises(RuntimeError, match=r"^\('P\+d', 0\.008, 0\.0, 0\): no force"):
        module.run(couplings=("P+d",), delays=(0.008,), losses=(0.0,), seeds=1, jobs=1)
