"""The kernels of the contact: signed distances, laws, moving surfaces."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scara_drake.environment import (
    Box,
    ConstantVelocity,
    Cylinder,
    Environment,
    SineMotion,
    Surface,
    Wall,
    contact_force,
    normal_force,
    surface_distance,
    surface_row,
)

settings.register_profile("kernels", deadline=None)  # the first call of a kernel compiles it
settings.load_profile("kernels")

POINTS = st.tuples(*[st.floats(-0.3, 0.3)] * 3).map(np.array)
VELOCITIES = st.tuples(*[st.floats(-1.0, 1.0)] * 3).map(np.array)
SIZES = st.tuples(*[st.floats(0.05, 0.4)] * 3)
ANALYTIC = st.sampled_from(["impedance", "hunt_crossley"])


@st.composite
def boxes(draw, **fields) -> Box:
    size = draw(SIZES)
    rounding = draw(st.floats(0.1, 1.0)) * min(size) / 2
    rpy = list(draw(st.tuples(*[st.floats(-3, 3)] * 3)))
    centre = draw(st.tuples(*[st.floats(-0.1, 0.1)] * 3))
    return Box(centre=list(centre), rpy=rpy, size=list(size), edge_radius=rounding, **fields)


@st.composite
def cylinders(draw, **fields) -> Cylinder:
    radius, length, _ = draw(SIZES)
    rounding = draw(st.floats(0.1, 1.0)) * min(radius, length / 2)
    unit = draw(POINTS.filter(lambda p: np.linalg.norm(p) > 0.05))
    return Cylinder(
        point=list(draw(st.tuples(*[st.floats(-0.1, 0.1)] * 3))),
        direction=(unit / np.linalg.norm(unit)).tolist(),
        radius=radius,
        length=length,
        edge_radius=rounding,
        **fields,
    )


@st.composite
def walls(draw, **fields) -> Wall:
    unit = draw(POINTS.filter(lambda p: np.linalg.norm(p) > 0.05))
    return Wall(point=[0.02, 0, 0], normal=(unit / np.linalg.norm(unit)).tolist(), **fields)


def surfaces(**fields) -> st.SearchStrategy[Surface]:
    return walls(**fields) | boxes(**fields) | cylinders(**fields)


def distance(surface: Surface, p_S: np.ndarray) -> tuple[float, np.ndarray]:
    normal = np.empty(3)
    return surface_distance(surface_row(surface), np.array(p_S, dtype=float), normal), normal


def contact(
    surface: Surface, p: np.ndarray, v: np.ndarray, time: float = 0.0
) -> tuple[np.ndarray, float]:
    penetration, f = np.empty(1), np.empty(3)
    contact_force(time, p, v, Environment([surface]).parameters(), penetration, f)
    return f, penetration[0]


def entry(law: str) -> list[tuple[Surface, np.ndarray, np.ndarray]]:
    """A surface of each kind, the point of it that is met first, and the normal there."""
    return [
        (Wall(point=[0, 0, 0], law=law), np.zeros(3), np.array([0.0, 1, 0])),
        (Box(centre=[0, 0, 0], law=law), np.array([0.1, 0.1, 0.2]), np.array([0.0, 1, 0])),
        (Cylinder(point=[0, 0, 0], law=law), np.array([0.2, 0.1, 0]), np.array([0.0, 1, 0])),
    ]


# Distances and normals.


def surface_samples(core: np.ndarray, sharp: np.ndarray, edge: float) -> np.ndarray:
    """Points of a rounded shape: those of its core, moved outward by the radius of its edges."""
    outward = sharp - core
    return core + edge * outward / np.linalg.norm(outward, axis=1, keepdims=True)


def assert_nearest(surface: Surface, samples: np.ndarray, inside, rng: np.random.Generator):
    for p in rng.uniform(-0.3, 0.3, (150, 3)):
        signed, _ = distance(surface, p)
        nearest = np.sqrt(((samples - p) ** 2).sum(axis=1).min())
        assert abs(signed) <= nearest + 1e-12
        assert abs(signed) >= nearest - 5e-3  # of samples some 3 mm apart
        assert (signed < 0.0) == inside(p)


@pytest.mark.parametrize("edge", [0.001, 0.02, 0.05])
def test_the_distance_of_a_box_is_that_of_its_nearest_point(edge: float) -> None:
    rng = np.random.default_rng(1)
    box = Box(size=[0.2, 0.3, 0.1], edge_radius=edge)
    half = np.array(box.size) / 2
    sharp = rng.uniform(-half, half, (90_000, 3))
    face = rng.integers(0, 3, len(sharp))
    sharp[np.arange(len(sharp)), face] = half[face] * rng.choice([-1, 1], len(sharp))
    core = np.clip(sharp, -(half - edge), half - edge)

    def inside(p: np.ndarray) -> bool:
        return bool(np.linalg.norm(p - np.clip(p, -(half - edge), half - edge)) < edge)

    assert_nearest(box, surface_samples(core, sharp, edge), inside, rng)


@pytest.mark.parametrize("edge", [0.001, 0.02, 0.08])
def test_the_distance_of_a_cylinder_is_that_of_its_nearest_point(edge: float) -> None:
    rng = np.random.default_rng(2)
    radius, half = 0.08, 0.15
    cylinder = Cylinder(radius=radius, length=2 * half, edge_radius=edge)

    def core_of(p: np.ndarray) -> np.ndarray:
        across = np.linalg.norm(p[:, :2], axis=1, keepdims=True)
        scale = np.minimum(1.0, (radius - edge) / np.maximum(across, 1e-12))
        return np.hstack([p[:, :2] * scale, np.clip(p[:, 2:], edge - half, half - edge)])

    angle, count = rng.uniform(0, 2 * np.pi, 90_000), 90_000
    side = np.arange(count) < count * 0.65
    r = np.where(side, radius, radius * np.sqrt(rng.uniform(size=count)))
    z = np.where(side, rng.uniform(-half, half, count), half * rng.choice([-1, 1], count))
    sharp = np.column_stack([r * np.cos(angle), r * np.sin(angle), z])
    samples = surface_samples(core_of(sharp), sharp, edge)
    assert_nearest(cylinder, samples, lambda p: np.linalg.norm(p - core_of(p[None])[0]) < edge, rng)


@settings(max_examples=300)
@given(surface=surfaces(), p=POINTS)
def test_the_normal_is_the_gradient_of_the_distance(surface, p) -> None:
    h = 1e-6
    signed, normal = distance(surface, p)
    assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-12)
    if not isinstance(surface, Wall) and signed < 2 * h - surface.edge_radius:
        return  # deeper, two faces may be equally near
    slope = [distance(surface, p + d)[0] - distance(surface, p - d)[0] for d in h * np.eye(3)]
    curvature = 0.0 if isinstance(surface, Wall) else 1.0 / (surface.edge_radius + signed)
    np.testing.assert_allclose(normal, np.array(slope) / (2 * h), atol=2 * h * curvature + 1e-8)


def test_the_normal_turns_steadily_around_the_edge_of_a_table() -> None:
    table = Box(size=[1.0, 0.6, 0.05], edge_radius=0.01)
    path = [[0.1, 0.3 - 0.03, 0.025 - 1e-3], [0.1, 0.3 - 1e-3, 0.025 - 0.03]]
    corner = np.array([0.1, 0.3, 0.025]) - [0, 4e-3, 4e-3]
    points = np.vstack([np.linspace(path[0], corner, 500), np.linspace(corner, path[1], 500)])
    assert all(-0.01 < distance(table, p)[0] < 0.0 for p in points)
    normals = np.array([distance(table, p)[1] for p in points])
    assert normals[0] @ [0, 0, 1] == pytest.approx(1.0)
    assert normals[-1] @ [0, 1, 0] == pytest.approx(1.0)
    assert np.linalg.norm(np.diff(normals, axis=0), axis=1).max() < 0.03


@settings(max_examples=300)
@given(surface=surfaces(damping=0.0), p=POINTS)
def test_the_spring_has_a_potential(surface, p) -> None:
    """f = -grad(K d²/2), in the world, wherever the surface stands."""
    f, depth = contact(surface, p, np.zeros(3))
    assert np.linalg.norm(f) == pytest.approx(1e4 * depth)
    if not isinstance(surface, Wall) and depth > surface.edge_radius - 2e-6:
        return
    h = 1e-6
    slope = [
        0.5e4 * (contact(surface, p + d, f)[1] ** 2 - contact(surface, p - d, f)[1] ** 2) / (2 * h)
        for d in h * np.eye(3)
    ]
    np.testing.assert_allclose(f, -np.array(slope), atol=0.05)


# The laws.


@pytest.mark.parametrize("case", range(3))
def test_position_and_velocity_are_in_si_units(case: int) -> None:
    surface, p, n = entry("impedance")[case]
    f, depth = contact(surface, p - 1e-3 * n, np.zeros(3))
    np.testing.assert_allclose(f, 10.0 * n, atol=1e-9)  # 1 mm
    assert depth == pytest.approx(1e-3)
    np.testing.assert_allclose(contact(surface, p - 1e-3 * n, -n)[0] - f, 100.0 * n)  # 1 m/s


@pytest.mark.parametrize("law", ["impedance", "hunt_crossley"])
@pytest.mark.parametrize("case", range(3))
def test_entering_at_200_mm_per_s_steps_by_less_than_8_newton_a_millisecond(case, law) -> None:
    # The raw equation (52) steps by B v = 20 N at touch.
    surface, p, n = entry(law)[case]
    for phase in np.linspace(0, 1, 11):
        depths = 0.2e-3 * (np.arange(-3, 40) + phase)
        entering = [contact(surface, p - d * n, -0.2 * n)[0] @ n for d in depths]
        assert np.abs(np.diff(entering)).max() < 8.0
    assert entering[-1] > 1e4 * depths[-1]


@settings(max_examples=50)
@given(
    data=st.data(), law=ANALYTIC, spin=VELOCITIES, swing=VELOCITIES, frequency=st.floats(0.1, 20)
)
def test_no_motion_is_ever_pulled(data, law, spin, swing, frequency) -> None:
    surface = data.draw(surfaces(law=law, alpha=5.0))
    X_SW, p_S = surface.pose().inverse(), np.empty(3)
    for t in np.linspace(0, 1, 60):
        angle = 2 * np.pi * frequency * t
        p = 0.15 * (np.cos(angle) * spin + np.sin(angle) * swing)
        v = 0.15 * 2 * np.pi * frequency * (np.cos(angle) * swing - np.sin(angle) * spin)
        f, depth = contact(surface, p, v)
        p_S = X_SW @ p
        signed, normal_S = distance(surface, p_S)
        assert depth == pytest.approx(max(-signed, 0.0), abs=1e-12)
        push = surface.pose().rotation().inverse() @ f
        assert push @ normal_S >= 0.0
        np.testing.assert_allclose(push, (push @ normal_S) * normal_S, atol=1e-9)  # no friction


@given(
    law=ANALYTIC,
    depth=st.floats(0, 0.05),
    rate=st.floats(-5, 5),
    n=st.floats(1, 1.5),
    alpha=st.floats(0, 5),
)
def test_what_a_law_adds_to_its_spring_dissipates(law, depth, rate, n, alpha) -> None:
    row = surface_row(Wall(law=law, exponent=n, alpha=alpha))
    spring = 1e4 * depth ** (n if law == "hunt_crossley" else 1.0)
    f = normal_force(row, depth, rate)
    assert f >= 0.0
    assert (f - spring) * rate >= -1e-9


def held_work(wall: Wall, depth: np.ndarray, rate: np.ndarray, period: float) -> float:
    """Energy [J] that a wall gives to a tool whose depths (n,) are a period apart, force held."""
    row = surface_row(wall)
    force = [normal_force(row, d, v) for d, v in zip(depth[:-1], rate[:-1], strict=True)]
    return float(np.dot(force, -np.diff(depth)))


def half_sine(deepest: float, duration: float, early: float) -> tuple[np.ndarray, np.ndarray]:
    """Depth [m] and rate [m/s] of a press, each millisecond; it begins `early` periods before 0."""
    t = 1e-3 * (np.arange(-1.0, duration / 1e-3 + 3.0) - early)
    omega = np.pi / duration
    return deepest * np.sin(omega * t), deepest * omega * np.cos(omega * t)


PRESS = {
    "deepest": st.floats(1e-3, 0.05),
    "duration": st.floats(0.02, 1.0),
    "early": st.floats(0.0, 1.0),
}


@given(**PRESS)
def test_a_held_spring_gives_half_its_stiffness_times_the_squared_steps(
    deepest: float, duration: float, early: float
) -> None:
    depth, rate = half_sine(deepest, duration, early)
    given_out = held_work(Wall(damping=0.0), depth, rate, 1e-3)
    touching = np.maximum(depth[:-1], depth[1:]) > 0.0
    assert given_out <= 0.5e4 * np.sum(np.diff(depth)[touching] ** 2) + 1e-12
    # A share 2 v T / d of the stored energy, and the ticks at which it touches and leaves.
    fastest = deepest * np.pi / duration
    stored = 0.5e4 * deepest**2
    assert given_out <= (2.0 * fastest * 1e-3 / deepest) * stored + 0.5e4 * (fastest * 1e-3) ** 2


def test_the_share_is_what_it_says() -> None:
    # 29 mm at up to 1.9 m/s: a tenth of K d^2 / 2; the mean of the squared speed is half its peak.
    depth, rate = half_sine(0.029, 0.048, 0.5)
    stored = 0.5e4 * 0.029**2
    expected = 0.5 * (np.pi / 0.048) ** 2 * 0.048 * 1e-3
    assert held_work(Wall(damping=0.0), depth, rate, 1e-3) / stored == pytest.approx(
        expected, rel=0.05
    )


@given(**PRESS)
def test_the_default_wall_takes_energy_of_every_press(
    deepest: float, duration: float, early: float
) -> None:
    depth, rate = half_sine(deepest, duration, early)
    assert held_work(Wall(), depth, rate, 1e-3) < 0.0


@settings(max_examples=50)
@given(
    data=st.data(), law=ANALYTIC, cosines=st.tuples(*[POINTS] * 2), sines=st.tuples(*[POINTS] * 2)
)
def test_a_closed_path_loses_energy(data, law, cosines, sines) -> None:
    """The work on the tool around any loop, over edges and through the middle, is not positive."""
    surface = data.draw(surfaces(law=law))
    t = np.arange(4000) * (2 * np.pi / 4000)
    harmonics = (
        np.outer(np.cos(k * t), a) + np.outer(np.sin(k * t), b)
        for k, (a, b) in enumerate(zip(cosines, sines, strict=True), start=1)
    )
    p = sum(harmonics, np.zeros((len(t), 3)))
    v = (np.roll(p, -1, axis=0) - np.roll(p, 1, axis=0)) / (2 * t[1])
    rows, penetration, f = Environment([surface]).parameters(), np.empty(1), np.empty_like(p)
    for point, velocity, force in zip(p, v, f, strict=True):
        contact_force(0.0, point, velocity, rows, penetration, force)
    power = (f * v).sum(axis=1)
    assert power.mean() <= 2e-3 * (np.abs(power).max() + 1e-9)


@pytest.mark.parametrize("n", [1.0, 1.5])
@pytest.mark.parametrize("speed", [0.02, 0.1, 0.3])
def test_hunt_and_crossley_keep_1_minus_alpha_v_of_the_speed(n: float, speed: float) -> None:
    alpha, mass = 0.4, 2.0
    row = surface_row(Wall(law="hunt_crossley", exponent=n, alpha=alpha))
    state, h = np.array([0.0, speed]), 2e-5  # depth, its rate

    def slope(x: np.ndarray) -> np.ndarray:
        return np.array([x[1], -normal_force(row, x[0], x[1]) / mass])

    while state[0] > 0.0 or state[1] > 0.0:  # Runge and Kutta, until it has left
        k1 = slope(state)
        k2 = slope(state + h / 2 * k1)
        k3 = slope(state + h / 2 * k2)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(state + h * k3))
    restitution = -state[1] / speed
    assert restitution == pytest.approx(1.0 - alpha * speed, abs=(alpha * speed) ** 2 + 1e-6)


# Motion.


MOTIONS = st.builds(ConstantVelocity, st.tuples(*[st.floats(-0.5, 0.5)] * 3).map(list)) | st.builds(
    SineMotion,
    st.sampled_from([[1.0, 0, 0], [0.6, 0, -0.8]]),
    st.floats(0, 0.05),
    st.floats(0, 5),
    st.floats(-3, 3),
)


def place(motion: ConstantVelocity | SineMotion, time: float) -> np.ndarray:
    if isinstance(motion, ConstantVelocity):
        return time * np.array(motion.velocity)
    angle = 2 * np.pi * motion.frequency * time + motion.phase
    return motion.amplitude * np.sin(angle) * np.array(motion.direction)


@settings(max_examples=200)
@given(data=st.data(), law=ANALYTIC, motion=MOTIONS, time=st.floats(0, 3), p=POINTS, v=VELOCITIES)
def test_a_moving_surface_is_one_at_rest_in_the_frame_that_moves(
    data, law, motion, time, p, v
) -> None:
    surface = data.draw(surfaces(law=law))
    at_rest, depth_at_rest = contact(surface, p, v)
    surface.motion = motion
    h = 1e-5
    velocity = (place(motion, time + h) - place(motion, time - h)) / (2 * h)
    f, depth = contact(surface, p + place(motion, time), v + velocity, time)
    assert depth == pytest.approx(depth_at_rest, abs=1e-12)
    if isinstance(surface, Wall) or depth < surface.edge_radius - 1e-9:  # else not one normal
        np.testing.assert_allclose(f, at_rest, atol=1e-4 + 1e-7 * float(np.linalg.norm(at_rest)))
    moved = surface.pose_at(time).translation() - surface.pose().translation()
    np.testing.assert_allclose(moved, place(motion, time), atol=1e-12)


@pytest.mark.parametrize("motion", [ConstantVelocity([0, 0.05, 0]), SineMotion(amplitude=0.005)])
def test_a_wall_that_comes_pushes_with_its_damping(motion) -> None:
    wall = Wall(point=[0, 0.01, 0], motion=motion, stiffness=0.0)
    f, _ = contact(wall, np.zeros(3), np.zeros(3))
    speed = 0.05 if isinstance(motion, ConstantVelocity) else 0.005 * np.pi
    np.testing.assert_allclose(f, [0, 100 * speed, 0], atol=1e-9)
