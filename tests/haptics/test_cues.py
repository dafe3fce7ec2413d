"""Anticipation of the surface and the click at a dip: gentle, and within every limit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.brush.presets import load_brush
from paint3d.haptics.kernels import state as hs
from paint3d.haptics.settings import PHANTOM_DESKTOP, TOUCH, DeviceLimits, Feel
from paint3d.surface.painted_surface import PaintedSurface
from scripts.solids import make_plane
from tests.support.force_model import ForceModel

FULL = load_brush("full")
LENGTH = FULL.length_mm
QUICK = settings(deadline=None, max_examples=25)


@pytest.fixture(scope="module")
def tree():
    return PaintedSurface(make_plane(), resolution=None).contact_tree


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
