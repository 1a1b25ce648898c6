import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

import scara_drake as sd
from scara_drake import plotting

WALL_Y = -0.75  # [m]; the tool starts 10 mm behind it


@pytest.fixture(scope="module")
def recording():
    wall = {"name": "front", "point": [0.8, WALL_Y, 3.0], "normal": [0.0, 1.0, 0.0]}
    scenario = sd.load_scenario("teleoperation", {"environment.surfaces": [wall]})
    return sd.simulate(scenario, duration=2.0)


@pytest.fixture
def ax():
    return Figure().subplots()


def lines(axes):
    return {line.get_label(): line for line in axes.get_lines()}


def assert_line(line, x, y, rtol=0.0):
    np.testing.assert_allclose(line.get_xdata(), x, rtol=0.0)
    np.testing.assert_allclose(line.get_ydata(), y, rtol=rtol, equal_nan=True)


def test_tracking_draws_the_desired_and_the_measured_positions(recording, ax):
    plotting.tracking(recording, ax, ["theta2", "theta4"])
    drawn = lines(ax)
    assert set(drawn) == {"θ2", "θ2 desired", "θ4", "θ4 desired"}
    for joint, name in (("theta2", "θ2"), ("theta4", "θ4")):
        assert_line(drawn[name], recording.time, recording.q_measured.sel(joint=joint))
        desired = drawn[f"{name} desired"]
        assert_line(desired, recording.time, recording.q_desired.sel(joint=joint))
        assert desired.get_linestyle() == "--"
        assert desired.get_color() == drawn[name].get_color()
    assert ax.get_xlabel() == "time [s]"
    assert ax.get_ylabel() == "position [rad]"


def test_tracking_of_the_mast_is_in_metres(recording, ax):
    plotting.tracking(recording, ax, ["d1"])
    assert ax.get_ylabel() == "position [m]"


@pytest.mark.parametrize(("joint", "unit"), [("d1", "mm"), ("theta5", "mrad")])
def test_tracking_error_is_a_thousand_times_desired_less_measured(recording, ax, joint, unit):
    plotting.tracking_error(recording, ax, [joint])
    error = recording.q_desired.sel(joint=joint) - recording.q_measured.sel(joint=joint)
    (line,) = ax.get_lines()
    assert_line(line, recording.time, 1000 * error, rtol=1e-12)
    assert ax.get_ylabel() == f"error [{unit}]"


@pytest.mark.parametrize("plot", [plotting.tracking, plotting.tracking_error])
@pytest.mark.parametrize(
    ("joints", "said"), [(["d1", "theta2"], "d1 alone"), (["theta7"], "theta7"), ([], "allowed")]
)
def test_joints_must_exist_and_share_a_unit(recording, ax, plot, joints, said):
    with pytest.raises(ValueError, match=said):
        plot(recording, ax, joints)


def test_tool_path_draws_the_ways_and_the_wall_from_above(recording, ax):
    plotting.tool_path(recording, ax)
    drawn = lines(ax)
    for kind in ("commanded", "desired", "measured"):
        path = recording[f"p_WE_{kind}"]
        assert_line(drawn[kind], path.sel(axis="x"), path.sel(axis="y"))
    np.testing.assert_allclose(np.sort(drawn["front"].get_xdata()), [0.8 - 1.0, 0.8 + 1.0])
    np.testing.assert_allclose(drawn["front"].get_ydata(), WALL_Y)
    low, high = ax.get_ylim()
    assert low < WALL_Y < high
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x [m]", "y [m]")


def test_tool_path_without_a_command_or_a_wall_draws_what_there_is(ax):
    plotting.tool_path(sd.simulate(sd.load_scenario("joint_sine"), duration=0.01), ax)
    assert set(lines(ax)) == {"desired", "measured"}


def test_contact_force_is_drawn_with_the_law_of_the_wall(recording, ax):
    plotting.contact_force(recording, ax)
    drawn = lines(ax)
    f_y = recording.f_env_on_tool_W.sel(axis="y").values
    assert_line(drawn["force"], recording.time, f_y)
    law = drawn["K d + B d'"].get_ydata()
    # K and B of Table 4, with the rate differenced from the depth.
    depth = WALL_Y - recording.p_WE_measured.sel(axis="y").values
    rate = np.gradient(depth, recording.time.values)
    inside = depth > 1e-3
    assert inside.sum() > 500
    expected = 1e4 * depth + 100.0 * rate
    np.testing.assert_allclose(law[inside][1:-1], expected[inside][1:-1], atol=0.3)
    np.testing.assert_allclose(f_y[inside], law[inside], rtol=1e-9)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [s]", "force [N]")


def test_the_law_is_zero_away_from_the_wall(recording, ax):
    away = recording.assign(penetration=0.0 * recording.penetration)
    plotting.contact_force(away, ax)
    assert not lines(ax)["K d + B d'"].get_ydata().any()


def test_contact_force_names_the_walls_there_are(recording, ax):
    with pytest.raises(ValueError, match="'back', allowed front"):
        plotting.contact_force(recording, ax, surface="back")


def test_haptic_draws_both_forces_and_the_motors(recording, ax):
    right = plotting.haptic(recording, ax)
    drawn = lines(ax)
    for name, signal in (("at the robot", "f_env_on_tool_W"), ("after the channel", "f_haptic")):
        magnitude = np.linalg.norm(recording[signal].values, axis=1)
        assert_line(drawn[name], recording.time, magnitude, rtol=1e-12)
    for motor in ("low", "high"):
        rumble = recording.rumble.sel(motor=motor)
        assert_line(lines(right)[f"{motor} motor"], recording.time, rumble)
    assert ax.get_ylabel() == "force [N]"
    assert right.get_ylabel() == "rumble [1]"


@pytest.fixture(scope="module")
def bilateral():
    return sd.simulate(sd.load_scenario("bilateral"), duration=1.6)


def test_coupled_motion_draws_hand_device_and_tool_in_mm(bilateral, ax):
    plotting.coupled_motion(bilateral, ax)
    drawn = lines(ax)
    along = bilateral.sel(axis="y")
    assert_line(drawn["hand"], along.time, 1000 * along.hand_target, rtol=1e-12)
    assert_line(drawn["device"], along.time, 1000 * along.x_master, rtol=1e-12)
    tool = drawn["tool"].get_ydata()
    assert tool[0] == 0.0
    np.testing.assert_allclose(np.diff(tool), 1000 * np.diff(along.p_WE_measured), atol=1e-9)
    assert tool[-1] < -1.0  # it has moved along -y
    assert ax.get_ylabel() == "y [mm]"


def test_coupling_energy_is_what_came_in_less_what_went_out(bilateral, ax):
    plotting.coupling_energy(bilateral, ax, label="mine")
    energy = lines(ax)["mine"].get_ydata()
    meters = bilateral.sel(axis="y")
    expected = (
        meters.energy_master_in
        - meters.energy_master_out
        + meters.energy_slave_in
        - meters.energy_slave_out
    )
    np.testing.assert_allclose(energy, expected, atol=1e-12)
    assert abs(energy).max() > 1e-3
    assert ax.get_ylabel() == "energy [J]"


@pytest.mark.parametrize("plot", [plotting.coupled_motion, plotting.coupling_energy])
def test_bilateral_plots_say_what_they_need(recording, bilateral, ax, plot):
    with pytest.raises(ValueError, match="no master"):
        plot(recording, ax)
    with pytest.raises(ValueError, match="'w', allowed x, y, z"):
        plot(bilateral, ax, axis="w")


def test_walls_are_those_of_the_scenario(recording):
    (wall,) = plotting.walls(recording)
    assert (wall.name, wall.stiffness, wall.damping) == ("front", 1e4, 100.0)


def test_plots_change_no_global_setting(recording, ax):
    before = dict(matplotlib.rcParams)
    plotting.tracking(recording, ax)
    plotting.haptic(recording, ax)
    assert dict(matplotlib.rcParams) == before
