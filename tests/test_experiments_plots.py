"""The paper's figures as we draw them: what is drawn is what was measured, and can be read."""

from __future__ import annotations

import re

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from small_experiments import small

from scara_drake import metrics
from scara_drake.experiments import EXPERIMENTS
from scara_drake.experiments.inverse_kinematics import paths
from scara_drake.experiments.plots import EQUATIONS, FIGURES, TABLES
from scara_drake.experiments.teleoperation import figure_28

PICTURES = {
    **{f"figure {number}": picture for number, picture in FIGURES.items()},
    # That of the search, table 7, has a form of its own: test_table_7.py.
    **{f"table {number}": picture for number, picture in TABLES.items() if number != 7},
    **{f"equation {number}": picture for number, picture in EQUATIONS.items()},
}
TOLERANCES = (5.0, 0.0175)  # section III-C of the paper [mm, rad]
UNIT = r"\[(m|mm|rad|mrad|s|N|1|m/s|m/s²)\]$"
# The dimension whose every value a picture names; of the others each shows a part.
NAMED = {
    **dict.fromkeys(("figure 8", "figure 9"), "posture"),
    **dict.fromkeys(("figure 10", "figure 11", "figure 22", "table 8"), "solver"),
    **dict.fromkeys(("figure 16", "figure 17", "figure 18", "figure 19", "equation 51"), "run"),
    "figure 21": "part",
    **dict.fromkeys(("figure 29", "figure 30"), "reading"),
    **dict.fromkeys(("table 5", "table 6"), "posture"),
    **dict.fromkeys(("table 10", "equation 31", "equation 42"), "disturbance"),
    "equation 39": "phi",
}
STARTED = slice(1.0, None)  # [s]

each = pytest.mark.parametrize("name", PICTURES)
drawn_figures: dict[str, Figure] = {}


def data_of(name: str):
    return small(PICTURES[name].experiment).data


def drawn(name: str) -> Figure:
    if name not in drawn_figures:
        drawn_figures[name] = PICTURES[name].draw(data_of(name))
    return drawn_figures[name]


def y_of(line: Line2D) -> np.ndarray:
    return np.asarray(line.get_ydata(), dtype=np.float64)


def curve(name: str, label: str, axes: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """The points of the line of a label in some axes of a picture."""
    lines = [line for line in drawn(name).axes[axes].get_lines() if line.get_label() == label]
    assert len(lines) == 1, f"{label}: {len(lines)} lines"
    return np.asarray(lines[0].get_xdata(), dtype=np.float64), y_of(lines[0])


def words(figure: Figure) -> list[str]:
    """What is written in a picture, but for numbers and units."""
    (legend,) = figure.legends
    found = [text.get_text() for text in legend.get_texts()]
    for ax in figure.axes:
        found += [ax.get_title("left"), *(label.get_text() for label in ax.get_xticklabels())]
    return found


def test_every_curve_of_the_paper_is_drawn():
    assert [*FIGURES] == [*range(8, 31)]


@each
def test_a_picture_says_what_is_seen_in_one_sentence(name):
    picture = PICTURES[name]
    assert picture.experiment in EXPERIMENTS
    assert re.fullmatch(r"[A-Z][^\n]*\.", picture.caption)
    assert ". " not in picture.caption


@each
def test_a_picture_shows_every_run_with_units(name):
    figure, data = drawn(name), data_of(name)
    for ax in figure.axes:
        assert ax.get_lines()
        for line in ax.get_lines():
            assert np.isfinite(np.asarray(line.get_xydata(), dtype=np.float64)).all()
        assert not ax.get_ylabel() or re.search(UNIT, ax.get_ylabel())
        assert re.fullmatch(r"|iteration|point|time \[s\]|x \[m\]", ax.get_xlabel())
    assert figure.axes[0].get_ylabel()
    assert figure.axes[-1].get_xlabel() or name.startswith("table")
    texts = " ".join(words(figure))
    dim = NAMED.get(name)
    for value in data[dim].values if dim else ():
        assert (f"{value:g}" if isinstance(value, float) else str(value)) in texts


@pytest.mark.parametrize("name", ["figure 11", "figure 30", "table 8", "equation 51"])
def test_the_legend_is_beside_the_curves_and_in_the_picture(name):
    figure = drawn(name)
    figure.draw_without_rendering()
    (legend,) = figure.legends
    box = legend.get_window_extent()
    assert box.x0 >= 0
    assert box.x1 <= figure.bbox.x1
    assert box.y1 <= figure.bbox.y1
    assert not any(box.overlaps(ax.get_window_extent()) for ax in figure.axes)


@pytest.mark.parametrize(("name", "solver"), [("figure 8", "PSO"), ("figure 9", "DPSO")])
def test_swarms_end_within_the_tolerances(name, solver):
    data = data_of(name).sel(solver=solver)
    for axes, (bound, errors) in enumerate(
        zip(TOLERANCES, (1e3 * data.position_error, data.rotation_error), strict=True)
    ):
        for posture in data.posture.values:
            wanted = errors.sel(posture=posture).dropna("iteration")
            x, y = curve(name, f"posture {posture}", axes)
            np.testing.assert_array_equal(x, np.arange(wanted.size))
            np.testing.assert_array_equal(y, wanted)
            assert not wanted.size or y[-1] <= bound < y[0]  # no draw of so few may succeed
        assert errors.notnull().any()


@pytest.mark.parametrize(
    ("name", "errors", "scale"),
    [("figure 10", "position_error", 1e3), ("figure 11", "rotation_error", 1.0)],
)
def test_the_errors_along_the_paths(name, errors, scale):
    data = data_of(name)
    for solver in data.solver.values:
        error = scale * data[errors].sel(solver=solver)
        np.testing.assert_array_equal(curve(name, str(solver))[1], error.sel(path=0))
        assert curve(name, str(solver), 1)[1].max() == error.max()


@pytest.mark.parametrize("number", [12, 13, 14, 15])
def test_the_joints_along_the_paths(number):
    name, joint = f"figure {number}", f"theta{3 + number % 2}"
    data = data_of(name)
    solvers = ["DPSO"] if number < 14 else ["literal DPSOIJ", "default DPSOIJ"]
    for ax, solver in zip(drawn(name).axes, solvers, strict=True):
        lines = [line for line in ax.get_lines() if "made from" not in str(line.get_label())]
        rows = data.q.sel(solver=solver, joint=joint).values
        assert {tuple(y_of(line)) for line in lines} == {tuple(row) for row in rows}
        largest = max(np.abs(np.diff(y_of(line))).max() for line in lines)
        assert largest == paths.steps(data.q.sel(solver=solver), [joint]).max()
        (shown,) = [line for line in lines if str(line.get_label()).startswith(solver)]
        (made,) = [line for line in ax.get_lines() if "made from" in str(line.get_label())]
        assert abs(y_of(shown)[0] - y_of(made)[0]) <= np.pi


def test_the_mast_hangs_by_its_weight():
    # (m g - rho) / (k c) with Tables 3, 11 and 12 [mm].
    for name, label, rho in (
        ("figure 17", "mm and N", 300.0),
        ("figure 27", "mast in mm and N", 500.0),
    ):
        assert curve(name, label)[1][-1] == pytest.approx((735.5 * 9.81 - rho) / 7500.0, rel=0.02)
        assert abs(curve(name, "normalised")[1][-1]) < 0.01


@pytest.mark.parametrize(("name", "joints"), [("figure 18", (2, 4)), ("figure 19", (2, 4))])
def test_the_sines(name, joints):
    data = data_of(name)
    error = 1e3 * metrics.tracking_error(data.sel(time=STARTED))
    for axes, number in enumerate(joints):
        for run in data.run.values:
            x, y = curve(name, str(run), axes)
            if name == "figure 19":
                peak = metrics.peak(error.sel(run=run, joint=f"theta{number}"))
                assert np.abs(y[x >= 1.0]).max() == pytest.approx(float(peak))
            else:
                measured = data.q_measured.sel(run=run, joint=f"theta{number}")
                np.testing.assert_array_equal(y, measured)
                # 0.7854 rad at 1.25 rad/s, around wherever the joint begins
                wave = 0.7854 * np.sin(1.25 * x)
                assert np.abs(y - y[0] - wave)[x >= 1.0].max() < 1e-3


def test_the_tool_and_its_errors():
    data = data_of("figure 20").sel(run="normalised")
    for label in ("commanded", "reference", "measured"):
        x, y = curve("figure 20", label)
        path = data[f"p_WE_{label}"]
        np.testing.assert_array_equal([x, y], path.sel(axis=["x", "y"]).T)
    parts = {"channel": 0, "command limiter": 0, "controller": 1, "inverse kinematics": 1}
    lengths = sum(curve("figure 21", part, axes)[1] for part, axes in parts.items())
    whole = curve("figure 21", "in all")[1]
    apart = data.p_WE_commanded - data.p_WE_measured
    np.testing.assert_allclose(whole, 1e3 * np.linalg.norm(apart, axis=-1), atol=1e-9)
    assert (whole <= lengths + 1e-9).all()


@pytest.mark.parametrize(("name", "joint"), [("figure 23", 2), ("figure 25", 4)])
def test_the_joints_of_the_operators_motion(name, joint):
    data = data_of(name).sel(run="normalised", joint=f"theta{joint}")
    np.testing.assert_array_equal(curve(name, "measured")[1], data.q_measured)
    np.testing.assert_array_equal(curve(name, "desired")[1], data.q_desired)


def test_their_errors():
    error = 1e3 * metrics.tracking_error(data_of("figure 24"))
    expected = curve("figure 24", "expected, of the control alone", 1)[1]
    np.testing.assert_allclose(expected, error.sel(run="normalised", joint="theta2"))
    actual = curve("figure 24", "actual, of the received command")[1]
    assert np.abs(actual).max() > 10 * np.abs(expected).max()
    for label, run in (("stick smoothed", "normalised"), ("stick as it is", "raw stick")):
        shown = curve("figure 26", label)[1]
        np.testing.assert_allclose(shown, error.sel(run=run, joint="theta4"))


def test_what_is_asked_ahead_is_met_one_lag_later():
    # While a joint moves steadily its actual error is its speed times the lag of the limiter.
    data = data_of("figure 24")
    x, actual = curve("figure 24", "actual, of the received command")
    one = data.sel(run="normalised", joint="theta2").sel(time=x)
    speed = 1e3 * one.q_desired.differentiate("time")
    fast = np.abs(speed) > 0.9 * np.abs(speed).max()
    np.testing.assert_allclose(
        actual[fast.values], speed[fast] * data.attrs["limiter_lag"], rtol=0.15
    )


def test_the_answers_of_both_methods():
    data = data_of("figure 22").sel(joint="theta2")
    for solver in data.solver.values:
        answers, arm = (curve("figure 22", str(solver), axes)[1] for axes in (0, 1))
        np.testing.assert_array_equal(answers, data.answer.sel(solver=solver))
        np.testing.assert_array_equal(arm, data.q_measured.sel(solver=solver))


def test_the_force_is_felt_later():
    data = data_of("figure 28")
    channels = [name for name in data.channel.values if name != "none"]
    assert len(drawn("figure 28").axes) == len(channels) + 1
    for axes, channel in enumerate(channels):
        x, late = curve("figure 28", "with delay", axes)
        _, early = curve("figure 28", "without delay", axes)
        np.testing.assert_array_equal(late, data.force_felt.sel(channel=channel))
        delay = drawn("figure 28").axes[-1].get_lines()[axes]
        np.testing.assert_array_equal(y_of(delay), data.delay.sel(channel=channel))
        begins = [x[y > figure_28.TOUCH][:1] for y in (early, late)]
        if begins[1].size:
            lag = figure_28.late(data, str(channel))[0]
            assert begins[1] - begins[0] == pytest.approx(float(lag), abs=1e-9)


@pytest.mark.parametrize(
    ("name", "controllers"), [("figure 29", ["ISMC"]), ("figure 30", ["SMC", "SMC, high gain"])]
)
def test_joint_2_under_each_reading(name, controllers):
    data = data_of(name)
    for row, reading in enumerate(data.reading.values):
        for controller in controllers:
            q = data.q_measured.sel(reading=reading, controller=controller)
            np.testing.assert_array_equal(curve(name, controller, 2 * row)[1], q)
            error = curve(name, controller, 2 * row + 1)[1]
            np.testing.assert_allclose(error, 1e3 * (data.q_desired - q), atol=1e-9)
            assert drawn(name).axes[2 * row].get_title("left").startswith(f"{reading}: ")


def test_what_is_left_of_a_step():
    data = data_of("table 10")
    for axes, disturbance in enumerate(data.disturbance.values):
        for law in data.law.values:
            left = abs(1.0 - data.x.sel(law=law, disturbance=disturbance))
            np.testing.assert_array_equal(curve("table 10", str(law), axes)[1], left)
    x, left = curve("table 10", "ISMC")
    # The sliding motion e' = -c e with c = 1, and the paper's numbers within 3 %.
    for share, paper in ((0.1, 2.31), (0.01, 4.65)):
        crossed = x[left <= share][0]
        assert crossed == pytest.approx(-np.log(share), rel=0.03)
        assert crossed == pytest.approx(paper, rel=0.03)


def test_errors_of_the_postures_are_all_drawn():
    for name in ("table 5", "table 6", "table 8"):
        data = data_of(name)
        for ax, error in zip(
            drawn(name).axes, (1e3 * data.position_error, data.rotation_error), strict=True
        ):
            if name == "table 6":
                error = error.sel(joints="full")
            dots = [y_of(line) for line in ax.get_lines() if line.get_marker() == "."]
            np.testing.assert_array_equal(np.sort(np.concatenate(dots)), np.sort(error, axis=None))
            top = ax.get_ylim()[1]
            assert top > error.max()


def test_the_equations():
    data = data_of("equation 42")
    for axes, phi in enumerate(data.phi.values):
        x, sigma = curve("equation 42", "constant", axes)
        off = np.abs(sigma - np.exp(-data.attrs["k"] * x)).max()
        assert off < 0.05 or phi == data.phi.max()
        x, u1 = curve("equation 39", "u1", axes)
        psi = curve("equation 39", "the perturbation Psi", axes)[1]
        late = x > 0.5
        # A first-order lag of phi / rho, at 20 rad/s.
        lagged = 20.0 * phi / data.attrs["rho"]
        apart = np.abs(u1 - psi)[late].max() / np.abs(psi)[late].max()
        assert apart == pytest.approx(lagged / np.hypot(1.0, lagged), rel=0.1, abs=0.01)
        within = curve("equation 31", "slow sine", axes)[1]
        assert np.abs(within[x > 1.0]).max() < 1.0 < within[0] + 1e-9


def test_v_falls_outside_of_the_layer_once_a_joint_is_let_go():
    pushed = [*data_of("equation 51").run.values].index("pushed")
    for joint in data_of("equation 51").joint.values:
        x, V = curve("equation 51", str(joint), pushed)
        assert V[(x > 0.5) & (x < 0.6)].max() > 1.0
        assert V[-1] < 1.0
