"""The surface under the hand: friction of brush and surface, and grain that is felt."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.brush.presets import load_brush
from paint3d.colour.materials import load_material, load_materials
from paint3d.errors import DeviceError
from paint3d.haptics.kernels import state as hs
from paint3d.haptics.settings import PHANTOM_DESKTOP, TOUCH, DeviceLimits, Feel, HapticSettings
from paint3d.surface.painted_surface import PaintedSurface
from scripts.solids import make_plane
from tests.support.force_model import ForceModel

FULL = load_brush("full")
LENGTH = FULL.length_mm
MS = 0.001
BEGUN = 200  # steps until ramp, slew and slip are over


@pytest.fixture(scope="module")
def tree():
    return PaintedSurface(make_plane(), resolution=None).contact_tree


def felt(tree, settings, *, speed=40.0, descent=8.0, heading=0.3, steps=1200):
    """Forces (N, 3) of a hand that goes straight on, N, and what is along and against its way."""
    model = ForceModel(tree, settings, awake=True)
    way = np.array([math.cos(heading), math.sin(heading), 0.0])
    forces = np.array(
        [
            model.step(way * speed * MS * i + [-20.0, -5.0, LENGTH - descent]).force
            for i in range(steps + BEGUN)
        ]
    )[BEGUN:]
    return forces, -forces @ way


def on(material, **more) -> HapticSettings:
    made_of = load_material(material) if isinstance(material, str) else material
    return HapticSettings.for_brush(FULL, material=made_of, **more)


def test_friction_is_that_of_brush_and_surface(tree) -> None:
    pressing = FULL.spring * 8.0
    felt_by = {}
    for name, material in load_materials().items():
        _, against = felt(tree, on(name, texture=0.0), steps=20)
        felt_by[name] = against.mean()
        assert against.mean() == pytest.approx(
            FULL.friction * material.friction * pressing, rel=1e-3
        )
    assert len({round(force, 6) for force in felt_by.values()}) == len(felt_by)
    assert felt_by["porcelain"] < felt_by["silk"] < felt_by["xuan"] < felt_by["terracotta"]


@pytest.mark.parametrize("limits", [PHANTOM_DESKTOP, TOUCH])
def test_the_more_grain_the_more_is_felt_and_none_of_it_is_none(tree, limits) -> None:
    stone = load_material("terracotta")
    swings = []
    for grain in (0.0, 0.15, 0.3, 0.6):
        coarse = dataclasses.replace(stone, grain=grain)
        settings = HapticSettings.for_brush(FULL, limits, coarse)
        swings.append(felt(tree, settings, descent=2.0)[1].std())
    assert swings[0] < 1e-4
    assert swings[1] > 0.002
    assert np.allclose(swings[2:], [2.0 * swings[1], 4.0 * swings[1]], rtol=0.02)
    assert felt(tree, on("terracotta", texture=0.0))[1].std() < 1e-4
    half, whole = (felt(tree, on("terracotta", texture=t), descent=2.0)[1].std() for t in (0.5, 1))
    assert half == pytest.approx(0.5 * whole, rel=0.02)
    assert felt(tree, on("porcelain"))[1].std() < 1e-4


@pytest.mark.parametrize("heading", [0.0, 0.7, 1.5708, 2.6])
@pytest.mark.parametrize("speed", [15.0, 80.0])
def test_the_mean_force_is_that_of_smooth_ground(tree, heading, speed) -> None:
    way = {"heading": heading, "speed": speed, "steps": 1500 if speed < 50 else 500}
    rough, smooth = (felt(tree, on("terracotta", texture=t), **way) for t in (1.0, 0.0))
    sizes = [np.linalg.norm(forces, axis=1).mean() for forces, _ in (rough, smooth)]
    assert sizes[0] == pytest.approx(sizes[1], rel=0.005)
    assert rough[1].mean() == pytest.approx(smooth[1].mean(), rel=0.05)
    assert np.allclose(rough[0][:, 2], smooth[0][:, 2], atol=1e-9)  # the press is as it was


def test_it_is_never_more_than_the_limit(tree) -> None:
    for limits, user in ((TOUCH, 7.9), (PHANTOM_DESKTOP, 2.0)):
        settings = HapticSettings.for_brush(
            FULL, limits, load_material("terracotta"), user_limit=user
        )
        forces, _ = felt(tree, settings, descent=17.0, steps=400)
        assert np.linalg.norm(forces, axis=1).max() <= settings.limit * (1.0 + 1e-12)


def test_no_wave_has_less_than_four_steps(tree) -> None:
    """Its band ends at a quarter of the servo's rate: what goes faster feels nothing."""
    settings = on("terracotta")
    fastest = settings.wave_mm / 4.0 / MS
    for speed in (0.15, 0.4, 0.7):
        _, against = felt(tree, settings, speed=speed * fastest, steps=2048, descent=2.0)
        window = np.hanning(len(against))
        power = np.abs(np.fft.rfft((against - against.mean()) * window)) ** 2
        above = np.fft.rfftfreq(len(against), MS) > 0.25 / MS
        assert power[above].sum() < 1e-4 * power.sum()
        if speed < 0.5:
            assert against.std() > 0.002
    assert felt(tree, settings, speed=1.05 * fastest, steps=200)[1].std() < 1e-4


def test_the_force_is_no_stiffer_than_the_device(tree) -> None:
    for limits in (TOUCH, PHANTOM_DESKTOP):
        settings = HapticSettings.for_brush(FULL, limits, load_material("terracotta"))
        _, against = felt(tree, settings, speed=10.0, descent=12.0)
        slope = np.abs(np.diff(against)) / (10.0 * MS)
        assert 0.05 * limits.max_stiffness < slope.max() < 1.5 * limits.max_stiffness
        assert np.sqrt((slope**2).mean()) < limits.max_stiffness


def test_a_hand_that_goes_to_and_fro_gets_no_energy(tree) -> None:
    model = ForceModel(tree, on("terracotta"), awake=True)
    places = np.array([[6.0 * math.sin(0.02 * i), 0.0, LENGTH - 8.0] for i in range(2000)])
    forces = np.array([model.step(place).force for place in places])
    given = np.cumsum((forces[:-1] * np.diff(places, axis=0)).sum(axis=1))
    assert given.max() <= 1e-3 * -given.min()
    assert given[-1] < 0.9 * given[len(given) // 2] < 0.0  # friction goes on taking


@pytest.mark.parametrize("wrong", [{"texture": 1.5}, {"grain": -0.1}, {"wave_mm": 0.0}])
def test_grain_out_of_range_is_refused(wrong) -> None:
    with pytest.raises(DeviceError, match=next(iter(wrong))):
        on("xuan", **wrong)


# -- anticipation and clicks -------------------------------------------------------------------


QUICK = settings(deadline=None, max_examples=25)


def held(tree, chosen, z, steps=60):
    model = ForceModel(tree, chosen, awake=True)
    for _ in range(steps):
        step = model.step([0.0, 0.0, z])
    return step.force


def test_before_the_surface_it_grows_gently_and_the_law_stays(tree) -> None:
    feel = Feel(anticipation_mm=5.0)
    chosen, plain = (f.settings(FULL, PHANTOM_DESKTOP) for f in (feel, Feel()))
    gaps = np.array([6.0, 5.0, 4.0, 3.0, 2.0, 1.0, 0.0])
    felt = [held(tree, chosen, LENGTH + gap)[2] for gap in gaps]
    wanted = chosen.ahead_n * np.clip(1.0 - gaps / 5.0, 0.0, 1.0) ** 2
    assert np.allclose(felt, wanted, atol=1e-4)
    assert not any(held(tree, plain, LENGTH + gap).any() for gap in gaps[:-1])
    for descent in (0.2, 1.0, 4.0):
        both = [held(tree, one, LENGTH - descent)[2] for one in (chosen, plain)]
        assert both[0] == pytest.approx(max(both[1], chosen.ahead_n), abs=1e-4)


@pytest.mark.parametrize("speed", [20.0, 100.0, 400.0])
def test_it_gives_no_more_energy_than_the_hand_puts_in(tree, speed) -> None:
    chosen = Feel(anticipation_mm=8.0).settings(FULL, PHANTOM_DESKTOP)
    model = ForceModel(tree, replace(chosen, slew=5000.0), awake=True)
    down = np.arange(LENGTH + 10.0, LENGTH - 4.0, -1e-3 * speed)
    given_back, before, force = 0.0, None, 0.0
    for z in [*down, *down[::-1]]:
        if before is not None:
            given_back += force * (z - before)
        before, force = z, model.step([0.0, 0.0, z]).force[2]
    assert given_back <= 0.02 + 1e-9


def test_a_click_is_one_wave_along_the_handle(tree) -> None:
    chosen = Feel(click_n=0.4).settings(FULL, PHANTOM_DESKTOP)
    model = ForceModel(tree, chosen, awake=True)
    lifted = [0.0, 0.0, LENGTH + 30.0]
    assert not model.step(lifted).force.any()
    model.clicks = 1
    felt = np.array([model.step(lifted).force for _ in range(40)])
    assert np.abs(felt[:, :2]).max() == 0.0
    assert 0.3 < felt[:, 2].max() <= 0.4
    assert abs(felt[:, 2].sum()) < 0.05 * 0.4
    assert not felt[22:].any()


@QUICK
@given(
    st.floats(0.0, 20.0), st.floats(0.0, 1.0), st.floats(0.0, 7.9), st.floats(0.05, 12.0),
    st.lists(st.floats(-3.0, 3.0), min_size=30, max_size=60), st.integers(0, 40),
)  # fmt: skip
def test_cues_stay_within_every_limit(tree, ahead, click, user, device, ways, when) -> None:
    feel = Feel(limit_n=user, anticipation_mm=ahead, click_n=click)
    chosen = feel.settings(FULL, DeviceLimits(device, 1.0))
    model, z, before = ForceModel(tree, chosen, awake=True), LENGTH + 3.0, np.zeros(3)
    for k, way in enumerate(ways):
        model.clicks = int(k >= when)
        z = min(LENGTH + 12.0, max(LENGTH - 8.0, z + way))
        step = model.step([0.0, 0.0, z])
        assert np.isfinite(step.force).all()
        assert np.linalg.norm(step.force) <= min(user, device) * (1 + 1e-12)
        if not step.flags & hs.TAMED and k:
            assert np.linalg.norm(step.force - before) <= chosen.slew * 0.001 * (1 + 1e-9) or (
                np.linalg.norm(step.force) < np.linalg.norm(before)
            )
        before = step.force


def test_a_weak_device_is_not_asked_for_more_stiffness_than_it_holds(tree) -> None:
    chosen = Feel(anticipation_mm=0.5).settings(FULL, TOUCH)
    felt = [held(tree, chosen, LENGTH + gap)[2] for gap in np.linspace(0.5, 0.0, 11)]
    assert np.diff(felt).max() / 0.05 <= TOUCH.max_stiffness * (1 + 1e-6)
