"""What a blade does to a pipe: energies, forces, stall and binding, by closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from cut_rig import CutRig
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples

from scara_drake import load_scenario, simulate
from scara_drake.environment import Blade, PipeCut

FEED = 2e-3  # [m/s]


def width_of(rig: CutRig) -> float:
    """Largest width [m] of the wall across the feed that a rim meets at once, by geometry.

    The lens where the disc, moved by each depth, covers the annulus.
    """
    pipe, R = rig.pipe, rig.pipe.blade.radius
    inner = pipe.radius - pipe.wall
    x = np.linspace(-pipe.radius, pipe.radius, 4001)
    widest = 0.0
    for depth in np.linspace(0.0, 2 * pipe.radius, 801):
        y = depth - pipe.radius - (R - np.sqrt(R * R - x * x))  # the rim's front
        r = np.hypot(x, y)
        widest = max(widest, float(np.sum((r > inner) & (r < pipe.radius)) * (x[1] - x[0])))
    return widest


@examples(8)
@given(
    u=st.floats(5e8, 6e9),
    speed=st.floats(2e-3, 2e-2),
    wall=st.floats(1e-3, 8e-3),
    ratio=st.floats(0.2, 2.0),
    period=st.sampled_from([5e-4, 1e-3, 2e-3]),
)
def test_the_energy_is_the_volume_times_the_specific_energy(u, speed, wall, ratio, period):
    """The cut's to rounding; with the work of the feed, all that comes in to 1 %, or it stalls."""
    rig = CutRig(
        period=period,
        blade={"feed_ratio": ratio},
        specific_energy=u,
        wall=wall,
        radius=0.02,
        cells_around=60,
    )
    rig.feed(speed, 0.005)
    s = rig.state
    assert s.energy_cut == pytest.approx(u * rig.removed(), rel=1e-9)
    assert s.volume == pytest.approx(rig.removed(), rel=1e-9)
    assert s.energy == pytest.approx(s.energy_cut + s.energy_friction, rel=0.01, abs=1.0)
    assert rig.removed() > 0.0


def test_a_straight_cut_removes_the_section_times_the_kerf():
    rig = CutRig(radius=0.015)
    rig.feed(FEED, 2 * rig.pipe.radius + 2e-3)
    pipe = rig.pipe
    inner = pipe.radius - pipe.wall
    whole = pipe.blade.kerf * np.pi * (pipe.radius**2 - inner**2)
    assert rig.removed() == pytest.approx(whole, rel=1e-3)
    assert rig.removed() <= whole * (1 + 1e-12)
    assert rig.state.left == pytest.approx(0.0, abs=1e-3)


@examples(5)
@given(depth=st.floats(2e-3, 0.02), speed=st.floats(1e-3, 2.5e-3))
def test_no_more_is_removed_than_the_blade_has_swept(depth, speed):
    """Cells beyond the rim, by more than half a cell, are whole; those passed long ago are gone."""
    rig = CutRig(gap=0.0)
    rig.feed(speed, depth)
    pipe, R = rig.pipe, rig.pipe.blade.radius
    ring = np.repeat(np.arange(pipe.cells_through), pipe.cells_around)
    r = pipe.radius - pipe.wall + (ring + 0.5) * pipe.wall / pipe.cells_through
    angle = np.tile((np.arange(pipe.cells_around) + 0.5) * 2 * np.pi, pipe.cells_through)
    angle /= pipe.cells_around
    ahead = pipe.pose().rotation().inverse() @ rig.ahead
    toward = np.cos(angle) * ahead[0] + np.sin(angle) * ahead[1]
    along, across = r * toward, r * np.sqrt(1 - toward**2)
    tip = depth - pipe.radius
    inside = R - np.hypot(along - (tip - R), across)  # of the rim [m]
    half = r * np.pi / pipe.cells_around + pipe.wall / pipe.cells_through / 2
    assert (rig.cells[inside < -half] == 1.0).all()
    assert (rig.cells[inside > half + 1e-3] < 0.05).all()
    assert rig.removed() > 0.0


def test_without_contact_nothing_is_removed_and_nothing_felt():
    rig = CutRig(gap=0.01)
    rig.feed(FEED, 8e-3)
    assert (rig.cells == 1.0).all()
    assert not rig.force.any()
    assert rig.state.energy == rig.state.power == 0.0
    assert rig.state.speed == rig.pipe.blade.speed


def test_the_force_opposes_the_feed_and_is_the_ratio_of_what_cuts():
    rig = CutRig()
    rig.feed(FEED, 5e-3)
    against, along = -rig.force @ rig.ahead, abs(rig.force @ rig.aside)
    assert against > 1.0
    # The front is an arc of 11 degrees to each side at most: a cosine of 0.98.
    assert against / along == pytest.approx(rig.pipe.blade.feed_ratio, rel=0.03)
    assert along * rig.state.speed == pytest.approx(rig.state.power, rel=0.03)
    assert rig.force @ rig.axis == pytest.approx(0.0, abs=1e-9)


def test_the_blade_s_turn_decides_to_which_side_it_pulls():
    sides = []
    for speed in (5.0, -5.0):
        rig = CutRig(blade={"speed": speed})
        rig.feed(FEED, 3e-3)
        sides.append(rig.force @ rig.aside)
    assert sides[0] == pytest.approx(-sides[1], rel=1e-6)
    assert abs(sides[0]) > 1.0


def test_the_power_of_a_steady_feed_is_that_of_the_volume():
    """P = u w h v_f: halfway through, h is the two walls."""
    rig = CutRig()
    rig.feed(FEED, rig.pipe.radius)
    pipe = rig.pipe
    powers = rig.move(FEED * rig.ahead, ticks=2000).power
    expected = pipe.specific_energy * pipe.blade.kerf * 2 * pipe.wall * FEED
    assert np.mean(powers) == pytest.approx(expected, rel=0.08)


@pytest.mark.parametrize(("share", "stalls"), [(0.8, False), (1.3, True)])
def test_it_stalls_above_the_feed_that_the_motor_can_bear(share, stalls):
    """v_f = P / (u w h) is the most, h the largest width of the front."""
    rig = CutRig(radius=0.012, wall=0.012, cells_through=6, cells_around=48)
    pipe = rig.pipe
    most = pipe.blade.power / (pipe.specific_energy * pipe.blade.kerf * width_of(rig))
    s = rig.feed(share * most, 0.024)
    assert bool(s.stalled.any()) is stalls
    assert s.power.max() <= pipe.blade.power * 1.001


def stalled_rig() -> CutRig:
    """A blade that was fed so fast that it stands."""
    rig = CutRig()
    rig.feed(0.05, 5e-3)
    assert rig.state.stalled == 1.0
    return rig


def test_a_blade_that_stands_does_not_pass():
    rig = stalled_rig()
    rig.feed(1e-2, 1e-3)
    cells, first = rig.cells.copy(), -rig.force @ rig.ahead
    rig.feed(1e-2, 2e-3)
    assert (rig.cells == cells).all()
    assert rig.state.speed == 0.0
    # It rests on what is left as on a spring: on the two walls at least.
    pipe = rig.pipe
    assert -rig.force @ rig.ahead > first + pipe.blade.stiffness * 2 * pipe.wall * 2e-3


def test_a_blade_that_stands_runs_again_when_it_is_drawn_back():
    rig = stalled_rig()
    rig.feed(0.05, 1e-3)
    rig.move(-0.05 * rig.ahead, ticks=120)
    assert rig.state.stalled == 0.0
    assert rig.state.speed == rig.pipe.blade.speed


def in_kerf() -> CutRig:
    """A blade 2 cm deep in a pipe, at rest."""
    rig = CutRig()
    rig.feed(FEED, 0.02)
    rig.move(ticks=500)
    assert rig.state.bend == 0.0
    return rig


def test_within_the_clearance_the_kerf_is_not_felt():
    rig = in_kerf()
    rig.move(1e-2 * rig.axis, ticks=30)
    assert rig.force @ rig.axis == 0.0
    assert rig.state.energy_friction == 0.0


def test_aside_the_kerf_pushes_back_and_brakes():
    rig = in_kerf()
    rig.move(1e-2 * rig.axis, ticks=100)
    blade = rig.pipe.blade
    bend = 1e-3 - (blade.kerf - blade.body) / 2
    rig.move()
    s = rig.state
    assert s.bend == pytest.approx(bend, rel=1e-6)
    # The springs of the share of the section that the blade covers, and that is cut.
    share = 1.0 - s.left
    back = -rig.force @ rig.axis
    assert back == pytest.approx(blade.side_stiffness * bend * share, rel=0.02)
    load = blade.friction * back
    assert s.speed == pytest.approx(blade.speed * (1 - load / blade.stall_force()), rel=0.02)
    assert s.power == pytest.approx(load * s.speed, rel=0.15)  # the rub is within the rim
    assert s.energy_friction > 0.0


def test_turned_in_its_kerf_a_stiff_blade_binds():
    rig = CutRig(blade={"side_stiffness": 1e6})
    rig.feed(FEED, 0.04)
    rig.move(angular=0.3 * rig.ahead, ticks=500)
    assert rig.state.bend > 1e-3
    assert rig.state.stalled == 1.0


def test_beside_its_kerf_it_cuts_nothing():
    rig = in_kerf()
    rig.move(-0.02 * rig.ahead, ticks=1500)
    rig.move(0.01 * rig.axis, ticks=1000)
    cells = rig.cells.copy()
    rig.feed(0.02, 0.011)
    assert (rig.cells == cells).all()
    assert -rig.force @ rig.ahead > 10.0


@examples(10)
@given(
    seed=st.integers(0, 2**32 - 1),
    side=st.floats(0.0, 1e6),
    running=st.booleans(),
)
def test_the_tool_gets_no_more_than_the_motor_gives_and_the_cut_leaves(seed, side, running):
    """Work on the tool <= motor - cut - friction, whatever way the blade is moved and turned."""
    power = 750.0 if running else 1.0
    rig = CutRig(
        period=2e-4,
        gap=0.0,
        blade={"side_stiffness": side, "power": power},
        radius=0.015,
        cells_around=48,
    )
    rng = np.random.default_rng(seed)
    most = 0.0
    for _ in range(20):
        linear = 0.006 * rng.uniform(-1, 1.4) * rig.ahead + 0.005 * rng.uniform(-1, 1) * rig.aside
        linear = linear + 0.004 * rng.uniform(-1, 1) * rig.axis
        s = rig.move(linear, 0.02 * rng.uniform(-1, 1, 3), ticks=150)
        given_to_tool = s.energy - s.energy_cut - s.energy_friction
        most = max(most, float(np.max(rig.works - given_to_tool)))
    assert most < 0.02


@pytest.mark.slow
def test_a_scripted_straight_feed_cuts_the_pipe_through():
    scenario = load_scenario("cut_pipe")
    recording = simulate(scenario, duration=50.0)
    pipe = scenario.environment.cut
    assert isinstance(pipe, PipeCut)
    assert recording.cut_left.values[-1] < 1e-3
    whole = pipe.blade.kerf * pipe.section()
    assert recording.volume_removed.values[-1] == pytest.approx(whole, rel=1e-3)
    energy = recording.energy_blade.values[-1]
    assert energy == pytest.approx(pipe.specific_energy * whole, rel=0.01)
    assert not recording.blade_stalled.any()
    under_way = recording.time.values[recording.blade_power.values > 10.0]
    assert 20.0 < under_way[-1] - under_way[0] < 60.0
    assert abs(float(recording.kerf_place.values[-1])) < 1e-3


@pytest.mark.parametrize(
    ("part", "words"),
    [
        (PipeCut(wall=0.05), "pipe.wall: 0.05, allowed 0 to 0.03805"),
        (PipeCut(radius=0.2), "pipe.radius: 0.2, allowed 0 to 0.14"),
        (PipeCut(direction=[0.0, 0.0, 2.0]), "pipe.direction: length 2"),
        (Blade(body=0.004), "pipe.body: 0.004, allowed above 0, up to 0.003"),
        (Blade(speed=0.0), "pipe.speed: 0, allowed 0.01 m/s or more either way"),
    ],
)
def test_what_cannot_be_is_refused(part, words):
    with pytest.raises(ValueError, match=words):
        part.check_together("pipe")
