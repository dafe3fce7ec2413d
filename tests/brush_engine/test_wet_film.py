"""A wet stroke is an even film from flank to flank, whatever the way it goes and who holds it."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.surface_cases import UPRIGHT, flat, poses, sheet

UP = (0.0, 0.0, 1.0)
WIDE = 0.9  # of the half width: what lies nearer to the flank is looked at by itself


def profile(material="porcelain", angle=0.0, tremble=0.0, share=0.5, **options):
    """Places across a stroke's middle, from -1 to 1 at its flanks, and the coats there."""
    surface = PaintedSurface(sheet(flat, (60.0, 60.0), 5.0), 0.2, material)
    along = np.array([np.cos(angle), np.sin(angle), 0.0])
    aside = np.array([-along[1], along[0], 0.0])
    x = np.linspace(-22.0, 22.0, 400)
    shaken = np.random.default_rng(1).normal(0.0, tremble, len(x))
    points = x[:, None] * along + shaken[:, None] * aside
    pressures = np.full(len(x), 0.3)
    pressures[[0, -1]] = 0.0
    bend = np.cos(share) * along + np.sin(share) * aside  # how askew the tuft lies on its way
    painter = Painter(surface, "full", "pine soot", **options)
    painter.replay(poses(points, UP, bend, pressures, tilt=UPRIGHT))
    at = surface.paint_mesh.vertices.astype(np.float64)
    whole = (surface.coverage > 0.999) & (np.abs(at @ along) < 6.0)
    across = at[whole] @ aside
    middle, half = 0.5 * (across.min() + across.max()), 0.5 * np.ptp(across)
    return (across - middle) / half, surface.ink.amounts[: len(at)][whole].sum(axis=1)


def steps(place, coats, n=12):
    """Mean coats in n steps across."""
    step = np.minimum(n - 1, ((place + 1.0) * 0.5 * n).astype(int))
    return np.bincount(step, coats, n) / np.bincount(step, minlength=n)


@pytest.mark.parametrize("hairs", [0, 300])
@pytest.mark.parametrize("angle", [0.0, 0.6])
@pytest.mark.parametrize("share", [0.0, 0.7, 1.5])
def test_what_a_wet_brush_leaves_is_level_across_its_way(hairs, angle, share):
    place, coats = profile(angle=angle, share=share, hairs=hairs)
    within = np.abs(place) < WIDE
    level = steps(place[within] / WIDE, coats[within])
    assert np.ptp(level) < 0.3 * level.mean()  # the flanks of a glaze hold rather more


def test_the_flanks_hold_rather_more_on_a_glaze_and_rather_less_on_paper_that_drinks():
    flank = {}
    for material in ("porcelain", "xuan"):
        place, coats = profile(material)
        near = (np.abs(place) > 0.8) & (np.abs(place) < 0.97)
        flank[material] = coats[near].mean() / coats[np.abs(place) < 0.5].mean()
    assert 1.0 < flank["porcelain"] < 1.3
    assert 0.7 < flank["xuan"] < 1.1  # bundles bring more and less


def test_a_hand_that_trembles_draws_no_dark_rims():
    place, coats = profile(tremble=0.05)
    middle = coats[np.abs(place) < 0.5].mean()
    assert coats[np.abs(place) > WIDE].max() < 1.6 * middle


def test_a_brush_turned_on_the_spot_draws_no_dark_rim():
    """It is not carried anywhere, so there are no lines along its way to be levelled."""
    surface = PaintedSurface(sheet(flat, (60.0, 60.0), 5.0), 0.2, "porcelain")
    turn = np.linspace(0.0, 3.0, 200)
    pressures = np.full(len(turn), 0.4)
    pressures[[0, -1]] = 0.0
    bend = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    painter = Painter(surface, "full", "pine soot")
    painter.replay(poses(np.zeros((len(turn), 3)), UP, bend, pressures, tilt=UPRIGHT))
    coats = surface.ink.amounts.sum(axis=1)[: len(surface.coverage)]
    whole = surface.coverage > 0.999
    at, coats = surface.paint_mesh.vertices[whole, :2].astype(np.float64), coats[whole]
    away = np.linalg.norm(at - np.median(at, axis=0), axis=1)
    assert coats[away > np.quantile(away, 0.8)].max() < 1.6 * np.median(coats)
