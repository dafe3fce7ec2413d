"""The force on the hand: the papers' law, what makes it safe, and that it gives no energy away."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.brush.presets import load_brush
from paint3d.core.quaternion import multiply_quaternions, quaternions_from_matrices, rotate
from paint3d.errors import DeviceError
from paint3d.haptics.kernels import state as hs
from paint3d.haptics.settings import PHANTOM_DESKTOP, TOUCH, DeviceLimits, HapticSettings
from paint3d.mesh.kernels.bvh import (
    closest_point,
    find_foot,
    find_foot_within,
    mean_normal,
    nearest_within,
)
from paint3d.surface.painted_surface import PaintedSurface
from scripts.solids import make_bowl, make_plane, make_sphere
from tests.support.cases import long_but
from tests.support.force_model import ForceModel, flag_names

QUICK = settings(deadline=None, max_examples=25)
FULL = load_brush("full")
SETTINGS = HapticSettings.for_brush(FULL)
UPRIGHT = (1.0, 0.0, 0.0, 0.0)
UP = (0.0, 0.0, 1.0)
LENGTH, SPRING = FULL.length_mm, FULL.spring
MS = 0.001


@pytest.fixture(scope="module")
def trees():
    meshes = {"plane": make_plane(), "sphere": make_sphere(), "bowl": make_bowl()}
    return {k: PaintedSurface(m, resolution=None).contact_tree for k, m in meshes.items()}


def settled(model: ForceModel, position, orientation=UPRIGHT, steps=60, **more):
    """Hold still until ramps and slews are over."""
    for _ in range(steps):
        step = model.step(position, orientation, **more)
    return step


def leaning(angle: float, azimuth: float = 0.0) -> np.ndarray:
    half = 0.5 * angle
    axis = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
    return np.concatenate([[math.cos(half)], math.sin(half) * axis])


# -- the law ----------------------------------------------------------------------------------


@QUICK
@given(st.floats(0.1, 16.0), st.floats(-40, 40), st.floats(-40, 40), st.floats(0, 0.9))
def test_force_is_that_of_the_spring(trees, descent, x, y, lean) -> None:
    model = ForceModel(trees["plane"], SETTINGS, awake=True)
    step = settled(model, [x, y, LENGTH * math.cos(lean) - descent], leaning(lean))
    assert step.descent == pytest.approx(descent, abs=1e-4)
    assert np.allclose(step.force, [0, 0, min(SPRING * descent, 7.9)], atol=1e-4)


def test_no_force_off_the_surface(trees) -> None:
    model = ForceModel(trees["plane"], SETTINGS, awake=True)
    assert not settled(model, [0, 0, LENGTH + 0.01]).force.any()
    assert not settled(model, [500, 0, 20]).force.any()


def test_a_weaker_device_gets_a_softer_brush() -> None:
    weak = HapticSettings.for_brush(FULL, TOUCH)
    assert weak.spring * FULL.full_press_mm == pytest.approx(TOUCH.max_force)
    assert HapticSettings.for_brush(FULL).spring * FULL.full_press_mm == pytest.approx(7.9)


@QUICK
@given(st.floats(0.5, 12.0), st.floats(-math.pi, math.pi))
def test_friction_is_mu_f_against_the_slip(trees, descent, heading) -> None:
    model = ForceModel(trees["plane"], SETTINGS, awake=True)
    way = np.array([math.cos(heading), math.sin(heading), 0.0])
    for i in range(300):
        step = model.step(way * 0.1 * i + [0, 0, LENGTH - descent])
    slip = step.force - [0, 0, step.force[2]]
    assert np.allclose(slip, -FULL.friction * SPRING * descent * way, atol=1e-3)


def test_friction_holds_before_it_slips(trees) -> None:
    model = ForceModel(trees["plane"], SETTINGS, awake=True)
    settled(model, [0, 0, LENGTH - 10.0])
    held = settled(model, [0.5, 0, LENGTH - 10.0])
    assert held.force[0] == pytest.approx(-0.5 * SETTINGS.stick, abs=1e-6)
    assert np.allclose(held.proxy, 0.0, atol=1e-4)
    back = settled(model, [0, 0, LENGTH - 10.0])
    assert abs(back.force[0]) < 1e-4  # it stuck: nothing was lost


def test_the_force_follows_the_averaged_normal_of_a_sphere(trees) -> None:
    points = trees["sphere"].points
    radius = float(np.linalg.norm(points, axis=1).mean())
    for lean in (0.0, 0.4, 0.8):
        model = ForceModel(trees["sphere"], SETTINGS, awake=True)
        out = np.array([math.sin(lean), 0.0, math.cos(lean)])
        step = settled(model, out * (radius + LENGTH - 6.0), leaning(lean), steps=200)
        along = step.force @ out / np.linalg.norm(step.force)
        assert along > 0.9995
        assert np.linalg.norm(step.force) == pytest.approx(6.0 * SPRING, rel=0.01)


@QUICK
@given(st.integers(0, 1000))
def test_moving_everything_together_changes_nothing(trees, seed) -> None:
    rng = np.random.default_rng(seed)
    turn = rng.normal(size=4)
    turn /= np.linalg.norm(turn)
    shift = rng.uniform(-100, 100, 3)
    here, there = (ForceModel(trees["bowl"], SETTINGS, awake=True) for _ in range(2))
    for i in range(40):
        place = np.array([10.0 + 0.2 * i, 0.1 * i, 30.0])
        one = here.step(place)
        two = there.step(
            rotate(turn, place) + shift,
            multiply_quaternions(turn, np.array(UPRIGHT)),
            object_pose=np.concatenate([shift, turn]),
        )
    assert np.linalg.norm(one.force) > 0.5
    assert np.allclose(rotate(turn, one.force), two.force, atol=1e-3)


# -- safety, in order -------------------------------------------------------------------------


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("where", range(7))
def test_what_is_not_finite_gives_no_force(trees, bad, where) -> None:
    model = ForceModel(trees["plane"], SETTINGS, awake=True)
    settled(model, [0, 0, 25.0])
    pose = np.array([0, 0, 25.0, 1, 0, 0, 0])
    pose[where] = bad
    step = model.step(pose[:3], pose[3:])
    assert not step.force.any()
    assert "not finite" in flag_names(step.flags)
    assert settled(model, [0, 0, 25.0]).force[2] > 4.0  # and it recovers


def test_a_contact_fades_in(trees) -> None:
    quick = HapticSettings.for_brush(FULL, ramp_s=0.015, slew=5000.0)
    model = ForceModel(trees["plane"], quick, awake=True)
    model.step([0, 0, 60.0])
    rising = [model.step([0, 0, 25.0]).force[2] for _ in range(20)]
    assert np.allclose(np.diff(rising[:15]), 10.0 * SPRING / 15, rtol=1e-6)
    assert rising[15] == rising[19] == pytest.approx(10.0 * SPRING)
    for wrong in (0.009, 0.021):
        with pytest.raises(DeviceError, match="ramp_s"):
            HapticSettings.for_brush(FULL, ramp_s=wrong)


@QUICK
@given(st.floats(-40, 34), st.floats(0.0, 12.0), st.floats(0.5, 12.0))
def test_never_over_the_limit(trees, z, user, device) -> None:
    limits = DeviceLimits(device, 5.0)
    model = ForceModel(
        trees["plane"], HapticSettings(LENGTH, 3.0, 0.3, limits, user, slew=5000.0), awake=True
    )
    for i in range(60):
        step = model.step([0.3 * i, 0, z])
        assert np.linalg.norm(step.force) <= min(user, device) * (1 + 1e-12)
    if step.wanted > min(user, device):
        assert "clamped" in flag_names(step.flags)


def test_the_force_changes_no_faster_than_the_slew_limit(trees) -> None:
    slow = HapticSettings.for_brush(FULL, slew=100.0)
    model = ForceModel(trees["plane"], slow, awake=True)
    places = [60.0] * 3 + [20.0] * 80 + [60.0] * 40
    steps = [model.step([0, 0, z]) for z in places]
    forces = [step.force[2] for step in steps]
    assert max(np.diff(forces)) == pytest.approx(slow.slew * MS)
    assert "slew limited" in flag_names(steps[10].flags)
    assert max(forces) > 5.0
    drops = np.flatnonzero(np.diff(forces) < -slow.slew * MS * (1 + 1e-9)) + 1
    assert all("energy limited" in flag_names(steps[i].flags) for i in drops)  # never harder


@pytest.mark.parametrize(
    ("age", "flag"),
    [({"pose_age": 0.0051}, "pose too old"), ({"snapshot_age": 0.201}, "surface too old")],
)
def test_what_is_too_old_gives_no_force(trees, age, flag) -> None:
    model = ForceModel(trees["plane"], SETTINGS, awake=True)
    fresh = {key: value - 0.0011 for key, value in age.items()}
    assert settled(model, [0, 0, 25.0], **fresh).force[2] > 4.0
    step = model.step([0, 0, 25.0], **age)
    assert not step.force.any()
    assert flag in flag_names(step.flags)


def test_stopping_gives_no_force(trees) -> None:
    model = ForceModel(trees["plane"], SETTINGS, awake=True)
    settled(model, [0, 0, 25.0])
    step = model.step([0, 0, 25.0], stopping=True)
    assert not step.force.any()
    assert "stopping" in flag_names(step.flags)


def test_the_start_waits_for_a_lifted_brush_and_rises_over_two_seconds(trees) -> None:
    model = ForceModel(trees["plane"], SETTINGS)
    pressed = [0, 0, 25.0]
    waiting = settled(model, pressed, steps=3000)
    assert not waiting.force.any()
    assert flag_names(waiting.flags) == ["waiting to be lifted"]
    model.step([0, 0, LENGTH - 0.3])  # 0.14 N: below 0.2
    forces = [model.step(pressed).force[2] for _ in range(2100)]
    assert forces[30] < 0.15
    assert forces[999] == pytest.approx(5.0 * SPRING, rel=0.01)
    assert forces[2050] == pytest.approx(10.0 * SPRING)


def test_after_a_hang_it_starts_anew(trees) -> None:
    model = ForceModel(trees["plane"], SETTINGS, awake=True)
    settled(model, [0, 0, 25.0])
    model.step([0, 0, 25.0], snapshot_age=0.3)
    again = settled(model, [0, 0, 25.0])
    assert "waiting to be lifted" in flag_names(again.flags)
    assert not again.force.any()


@pytest.mark.parametrize(
    "wrong",
    [
        {"user_limit": -1.0},
        {"slew": math.nan},
        {"max_pose_age_s": 0.006},
        {"max_snapshot_age_s": 0.3},
        {"start_force": 0.3},
        {"rise_s": 0.0},
        {"friction": 2.0},
    ],
)
def test_settings_out_of_range_are_refused(wrong) -> None:
    good = {"length": 35.0, "spring": 0.45, "friction": 0.2}
    with pytest.raises(DeviceError, match=next(iter(wrong))):
        HapticSettings(**{**good, **wrong})


# -- energy -----------------------------------------------------------------------------------


def hand_taps(model: ForceModel, speed: float, mass=0.08, length=LENGTH, seconds=0.6):
    """A hand of `mass` kg lets the pen fall onto the plane at `speed` mm/s and feels the force.

    The recorded roots and forces; simulated at 20 kHz, the force held for a millisecond each.
    """
    z, v = length + 3.0, -speed
    roots, forces = [], []
    for _ in range(int(seconds * 1000)):
        step = model.step([0, 0, z])
        force = step.force[2]
        roots.append(z)
        forces.append(force)
        for _ in range(20):
            v += force / mass * 1000.0 * 5e-5  # N / kg = m/s2 = 1000 mm/s2
            z += v * 5e-5
    return np.array(roots), np.array(forces), v


def work_of_device(roots, forces) -> np.ndarray:
    """Energy given to the hand up to every step, N mm."""
    return np.cumsum(forces[:-1] * np.diff(roots))


@pytest.mark.parametrize("speed", [20.0, 80.0, 200.0, 400.0])
@pytest.mark.parametrize("brush", ["full", "gongbi", "dakai"])
def test_a_tap_gains_no_energy(trees, speed, brush) -> None:
    spec = load_brush(brush)
    model = ForceModel(trees["plane"], HapticSettings.for_brush(spec), awake=True)
    roots, forces, v = hand_taps(model, speed, length=spec.length_mm, seconds=0.9)
    given = work_of_device(roots, forces)
    put_in = -given.min()
    assert put_in > 0.0
    assert given[-1] <= 1e-3 * put_in  # over press and release
    assert 0.0 < v <= speed  # the hand comes back no faster than it came


def test_the_recorded_tap_is_passive_when_it_is_played_again(trees) -> None:
    roots, _, _ = hand_taps(ForceModel(trees["plane"], SETTINGS, awake=True), 150.0, mass=1.0)
    model = ForceModel(trees["plane"], SETTINGS, awake=True)
    forces = np.array([model.step([0, 0, z]).force[2] for z in roots])
    given = work_of_device(roots, forces)
    assert given.max() <= 1e-3 * -given.min()
    assert given[-1] < 0.0
    assert forces.max() > 3.0


def test_a_held_press_does_not_chatter(trees) -> None:
    rng = np.random.default_rng(5)
    model = ForceModel(trees["plane"], SETTINGS, awake=True)
    settled(model, [0, 0, 40.0])
    for z in np.linspace(35.0, 27.0, 100):
        model.step([0, 0, z])
    tremor = np.cumsum(rng.normal(scale=0.01, size=500))
    forces = [
        model.step([0, 0, 27.0 + 0.05 * math.sin(i * 0.06) + t]).force[2]
        for i, t in enumerate(tremor - tremor.mean())
    ]
    assert np.abs(np.diff(forces)).max() < 0.05 * 7.9


# -- continuity -------------------------------------------------------------------------------


def inner_wall(tree):
    """Radius and inward normal of the bowl's inner wall over the height, from its vertices."""
    points, normals = tree.points.astype(float), tree.normals.astype(float)
    radius = np.hypot(points[:, 0], points[:, 1])
    inward = (normals[:, :2] * points[:, :2]).sum(axis=1) / np.maximum(radius, 1e-9)
    wall = np.flatnonzero((inward < -0.3) & (points[:, 2] > 12.0))
    wall = wall[np.argsort(points[wall, 2], kind="stable")]
    return points[wall, 2], radius[wall], inward[wall], normals[wall, 2]


@pytest.mark.parametrize(
    ("speed", "towards_wall"),
    long_but([(50.0, 1.0), (200.0, 0.6)], product((50.0, 200.0), (1.0, 0.6))),
)
def test_sliding_over_the_bowl_has_no_steps(trees, speed, towards_wall) -> None:
    tree = trees["bowl"]
    heights, radii, inward, upward = inner_wall(tree)
    model = ForceModel(tree, SETTINGS, awake=True)
    forces, wanted, crossed = [], [], set()
    for i in range(2000):
        z = 40.0 + 12.0 * math.sin(speed / 40.0 * i * MS)
        turn = speed / 80.0 * i * MS
        radial = np.array([math.cos(turn), math.sin(turn), 0.0])
        a, b = np.interp(z, heights, inward), np.interp(z, heights, upward)
        normal = (a * radial + [0, 0, b]) / math.hypot(a, b)
        up = towards_wall * normal + (1.0 - towards_wall) * np.array([0, 0, 1.0])
        up /= np.linalg.norm(up)
        bend = np.cross(np.cross(up, [0.3, 0.2, 1.0]), up)
        bend /= np.linalg.norm(bend)
        frame = np.stack([bend, np.cross(up, bend), up], axis=1)
        depth = 7.0 * min(1.0, i / 200.0)
        root = np.interp(z, heights, radii) * radial + [0, 0, z] + up * LENGTH - normal * depth
        step = model.step(root, quaternions_from_matrices(frame[None])[0])
        forces.append(step.force)
        wanted.append(step.wanted)
        crossed.add(int(model.state[0]["warm"][1]))
    steps = np.linalg.norm(np.diff(forces[250:], axis=0), axis=1)
    assert len(crossed) > 50
    assert np.linalg.norm(forces[250:], axis=1).min() > 1.0
    assert steps.max() < 0.05 * PHANTOM_DESKTOP.max_force
    assert np.abs(np.diff(wanted[250:])).max() < 0.05 * PHANTOM_DESKTOP.max_force


# -- the bounded search -----------------------------------------------------------------------


@QUICK
@given(st.integers(0, 10_000))
def test_the_bounded_search_finds_what_the_whole_search_finds(trees, seed) -> None:
    rng = np.random.default_rng(seed)
    tree = trees["bowl"]
    place = rng.uniform([-60, -60, 10], [60, 60, 80])
    mine, theirs, work = np.zeros(6), np.zeros(6), np.array([10_000_000])
    guess = int(rng.integers(-1, len(tree.triangles)))
    here = nearest_within(tree, tuple(place), UP, 40.0, guess, work, mine)
    there = closest_point(tree, tuple(place), UP, 40.0, theirs)
    assert (here < 0) == (there < 0)
    if here >= 0:
        d = [np.linalg.norm(found[:3] - place) for found in (mine, theirs)]
        assert d[0] == pytest.approx(d[1], abs=1e-6)


def test_the_foot_is_that_of_painting(trees) -> None:
    tree, mine, theirs = trees["bowl"], np.zeros(6), np.zeros(6)
    near, far = np.zeros(5), np.zeros(5)
    for i in range(300):
        place = (20.0 * math.cos(0.02 * i), 20.0 * math.sin(0.03 * i), 33.0)
        work = np.array([1500])
        find_foot_within(tree, place, UP, 35.0, near, work, mine)
        find_foot(tree, place, UP, 35.0, theirs, far)
        assert np.abs(mine - theirs).max() < 2e-3


def test_where_the_patch_was_found_last_makes_its_search_shorter_and_nothing_else(trees) -> None:
    tree, foot, warm = trees["bowl"], np.zeros(6), np.zeros(5)
    kept, spent = np.zeros(hs.PATCH_SAMPLES), np.zeros(2)
    for i in range(400):
        length = math.hypot(math.sin(0.01 * i), 2.0)
        lean = (math.sin(0.01 * i) / length, 0.0, 2.0 / length)
        place = (30.0 * math.cos(0.02 * i), 30.0 * math.sin(0.03 * i), 38.0)
        triangle = find_foot_within(tree, place, lean, 35.0, warm, np.array([10_000]), foot)
        assert triangle >= 0
        normals = []
        for k, near in enumerate((np.zeros(hs.PATCH_SAMPLES), kept)):
            work = np.array([10_000])
            normal = mean_normal(tree, foot, lean, (1.0, 0.0, 0.0), 5.0, triangle, near, work)
            spent[k] += 10_000 - work[0]
            normals.append(np.array(normal))
        assert np.abs(normals[0] - normals[1]).max() < 1e-12
    assert spent[1] < 0.9 * spent[0]


def test_the_search_ends_with_its_budget(trees) -> None:
    tree, out = trees["sphere"], np.zeros(6)
    work = np.array([200])  # inside a sphere, everything is equally far
    nearest_within(tree, (0.0, 0.0, 0.0), UP, 1e4, -1, work, out)
    assert work[0] == 0
    assert np.isfinite(out).all()
    model = ForceModel(tree, SETTINGS, awake=True)
    step = model.step([0, 0, 0])
    assert model.state[0]["spent"] <= 1500
    assert np.isfinite(step.force).all()
