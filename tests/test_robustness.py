"""The robustness map: what it runs, what it measures, and what it calls stable."""

import numpy as np
import pytest
import xarray as xr

from scara_drake import load_scenario, metrics, simulate
from scara_drake.stability import robustness
from scara_drake.stability.robustness import CONTROLLERS, SETTLE, VARIATIONS, robustness_map

ISMC = {"ISMC": CONTROLLERS["ISMC"]}
DURATION = 1.5


def some(*names):
    return {name: VARIATIONS[name] for name in names}


def test_the_nominal_cell_is_the_run_of_the_scenario():
    data = robustness_map(some("nominal"), ISMC, duration=DURATION)
    scenario = load_scenario("joint_sine", dict(ISMC["ISMC"]))
    late = simulate(scenario, duration=DURATION).sel(time=slice(SETTLE, None))
    cell = data.sel(variation="nominal", controller="ISMC")
    error = metrics.tracking_error(late)
    np.testing.assert_array_equal(cell.rmse, metrics.rmse(error))
    np.testing.assert_array_equal(cell.peak, metrics.peak(error))
    np.testing.assert_array_equal(cell.chatter, metrics.chatter(late.tau_applied))
    assert cell.stable
    assert (cell.limited == 0.0).all()


def test_imperfections_show_where_they_act():
    names = ("nominal", "payload 25 kg", "encoders, 15 bit", "friction x 3", "lag 10 ms")
    data = robustness_map(some(*names), ISMC, duration=DURATION).sel(controller="ISMC")
    nominal = data.sel(variation="nominal")
    # The payload lies on the axis of joint 6, and joint 5 lifts it.
    heavy = data.sel(variation="payload 25 kg").peak / nominal.peak
    assert heavy.sel(joint="theta5") > 2.0
    coarse = data.sel(variation="encoders, 15 bit")
    assert coarse.chatter.sel(joint="theta2") > 100.0 * nominal.chatter.sel(joint="theta2")
    assert (coarse.peak.sel(joint=["theta2", "theta4"]) < 4 * np.pi / 2**15).all()
    dry = data.sel(variation="friction x 3").peak / nominal.peak
    assert (dry.sel(joint=["theta2", "theta4"]) > 2.0).all()
    assert data.stable.values.tolist() == [True, True, True, True, False]
    assert data.limited.sel(variation="lag 10 ms").max() > 0.5


def test_a_limit_cycle_is_not_stable_though_it_stays_near_the_reference():
    delayed = {"process_delay.actuation": "!ConstantDelay {delay: 0.001}"}
    data = robustness_map({"two ticks": delayed}, ISMC, duration=DURATION)
    assert data.peak.max() < robustness.LOST
    assert data.limited.sel(joint="d1") > 2 * robustness.LIMITED
    assert not data.stable.any()


def test_smc_errs_by_the_perturbation_and_pid_like_ismc():
    data = robustness_map(some("links x 1.5"), CONTROLLERS, duration=DURATION)
    ismc, smc, pid = data.peak.sel(variation="links x 1.5").max("joint").values
    assert smc > 10.0 * ismc
    assert pid == pytest.approx(ismc, rel=0.1)


def test_every_variation_is_a_scenario():
    for overrides in VARIATIONS.values():
        load_scenario("joint_sine", dict(overrides))


def test_threads_give_the_same_bits():
    cells = some("nominal", "encoders, noise 2 µm, µrad")
    one = robustness_map(cells, ISMC, duration=1.2, jobs=1)
    two = robustness_map(cells, ISMC, duration=1.2, jobs=2)
    xr.testing.assert_identical(one, two)


def test_a_run_that_breaks_down_is_not_stable(monkeypatch):
    def fail(*_, **__):
        raise RuntimeError("controller: port 'state' at t = 0.1 s: state[0] is nan")

    monkeypatch.setattr(robustness, "simulate", fail)
    data = robustness_map(some("nominal"), ISMC, duration=DURATION)
    assert data.peak.isnull().all()
    assert not data.stable.any()


def test_wrong_overrides_are_refused_before_anything_runs(monkeypatch):
    monkeypatch.setattr(robustness, "simulate", lambda *_, **__: pytest.fail("ran"))
    with pytest.raises(ValueError, match=r"^robot\.payload_mass: -1"):
        robustness_map({"nominal": {}, "light": {"robot.payload_mass": -1.0}}, ISMC)
    with pytest.raises(ValueError, match=r"^duration: 1\.0, allowed"):
        robustness_map(some("nominal"), ISMC, duration=1.0)


@pytest.mark.slow
def test_the_whole_map():
    data = robustness_map()
    follows = data.stable.sel(controller="ISMC")
    assert follows.drop_sel(variation="lag 10 ms").all()
    assert not follows.sel(variation="lag 10 ms")
