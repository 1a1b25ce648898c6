"""The standard cases of Niemeyer and Slotine, and of Hannaford and Ryu."""

from __future__ import annotations

import numpy as np
import pytest
from small_experiments import small

from scara_drake.experiments import REPRODUCED, Experiment
from scara_drake.experiments.literature import standard_cases
from scara_drake.experiments.literature.standard_cases import IMPEDANCE, echoes


def experiment() -> Experiment:
    return small("standard_cases")


def test_verdicts() -> None:
    assert [claim.verdict for claim in experiment().claims] == [REPRODUCED] * 4


def test_it_judges_what_it_is_given() -> None:
    data = experiment().data
    for name, changed, which in (
        ("stable", ~data.stable.astype(bool), 0),
        ("energy", -data.energy, 0),
        ("returned", data.returned * 1.05, 1),
        ("returned", data.returned + 0.01, 2),
        ("stiff_stable", ~data.stiff_stable.astype(bool), 3),
        ("stiff_energy", -data.stiff_energy, 3),
    ):
        judged = standard_cases.claims(data.assign({name: changed}))
        assert judged[which].verdict != REPRODUCED, name
        others = [claim.verdict for at, claim in enumerate(judged) if at != which]
        assert name == "returned" or others == [REPRODUCED] * 3
    assert [claim.verdict for claim in standard_cases.claims(data)] == [REPRODUCED] * 4


@pytest.mark.parametrize(("device", "tool"), [(10.0, 80.0), (40.0, 60.0), (100.0, 80.0)])
def test_a_wave_comes_back_as_its_ends_say(device: float, tool: float) -> None:
    once = (IMPEDANCE - device) / (IMPEDANCE + device) * (IMPEDANCE - tool) / (IMPEDANCE + tool)
    assert echoes(device, tool)[:2] == pytest.approx(abs(once), rel=0.03)


def test_from_a_tool_that_is_matched_nothing_comes_back() -> None:
    assert np.all(echoes(5.0, IMPEDANCE) < 0.01)
