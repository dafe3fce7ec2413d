"""How far a dry stroke's body goes: along its hairs' ways, between streaks, and no farther."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from paint3d.calligraphy.photo.ink_mask import bodies_in, find_ink

WIDTH = 20.0
NONE = np.zeros((120, 300), bool)


def lanes(*bare: tuple[int, int, int]) -> np.ndarray:
    """A level stroke of six hairs, each two pixels, two apart; some bare for a way."""
    ink = NONE.copy()
    for hair in range(6):
        ink[40 + 4 * hair : 42 + 4 * hair, 40:260] = True
    for hair, first, last in bare:
        ink[40 + 4 * hair : 42 + 4 * hair, first:last] = False
    return ink


def test_a_hair_that_took_hold_again_went_over_what_is_bare() -> None:
    """At the rim, where no ink lies beyond; up to two widths."""
    ink = lanes((0, 120, 155), (1, 120, 155))
    body = bodies_in(ink, ink, WIDTH)
    assert body[48:62, 60:240].all()
    assert body[40:48, 121:154].mean() > 0.9
    assert not bodies_in(*[lanes((0, 80, 135), (1, 80, 135))] * 2, WIDTH)[40:44, 95:120].any()


def test_a_hair_that_never_comes_back_adds_nothing() -> None:
    ink = lanes((0, 120, 300), (1, 120, 300))
    body = bodies_in(ink, ink, WIDTH)
    assert not body[:44, 140:].any()
    assert body[48:62, 140:240].all()


def test_a_wet_stroke_ends_where_its_ink_does() -> None:
    """Two that meet: what lies in their corner, and between close ones, is paper."""
    ink = NONE.copy()
    ink[40:60, 40:260] = True
    ink[60:110, 100:120] = True
    ink[66:110, 126:146] = True  # beside the other, a quarter of a width away
    body = bodies_in(ink, ink, WIDTH)
    assert (body & ~ink).sum() < 0.005 * ink.sum()


@pytest.mark.parametrize(("streaks", "fills"), [(True, True), (False, False)])
def test_a_long_hole_is_a_streak_only_among_streaks(streaks: bool, fills: bool) -> None:
    ink = NONE.copy()
    ink[34:66, 40:260] = True
    ink[43:57, 110:190] = False  # narrower than a stroke, longer than a streak
    if streaks:
        for first in (70, 190):  # at both ends of it alone
            ink[36:64:4, first : first + 40] = False
    assert bodies_in(ink, ink, WIDTH)[50, 150] == fills


def test_wide_gaps_are_closed_where_streaks_are_many() -> None:
    ink = NONE.copy()
    for first in (40, 56, 72):
        ink[first : first + 4, 40:260] = True
    assert bodies_in(ink, ink, WIDTH)[44:72, 60:240].all()
    ink[44:100] = False
    ink[56:76, 40:260] = True  # a solid one, as far away
    assert not bodies_in(ink, ink, WIDTH)[50, 60:240].any()


@pytest.mark.parametrize(("side", "fills"), [(10, True), (14, False)])
def test_small_holes_belong_to_a_wet_stroke(side: int, fills: bool) -> None:
    ink = NONE.copy()
    ink[30:70, 40:260] = True
    ink[45 : 45 + side, 140 : 140 + side] = False
    assert bodies_in(ink, ink, WIDTH)[50, 145] == fills


def test_faint_ink_counts_among_streaks_alone() -> None:
    ink = lanes((0, 120, 300), (1, 120, 300))
    faint = ink.copy()
    faint[40:42, 120:260] = True
    assert not bodies_in(ink, ink, WIDTH)[40, 150:240].any()
    assert bodies_in(ink, faint, WIDTH)[40, 150:240].all()
    solid = NONE.copy()
    solid[44:64, 40:260] = True
    faint = solid.copy()
    faint[36:44, 40:260] = True
    assert not bodies_in(solid, faint, WIDTH)[38].any()


def test_what_a_lens_spreads_is_seen_as_narrow_as_it_is() -> None:
    """A gap of a pixel between two strokes stays open, and a hair beside one is ink."""
    fine = np.zeros((1, 2000))  # ten to a pixel
    for first, last in ((600, 720), (730, 850), (890, 905)):
        fine[0, first:last] = 0.95
    taken = gaussian_filter(fine, (0.0, 10.0)).reshape(200, 10).mean(axis=1)
    lit = np.zeros((200, 200), np.float32)
    lit[40:160] = -np.log10(1.0 - taken)
    inked = find_ink(lit).mask[60:140].mean(axis=0)
    assert inked[72] == 0.0
    assert inked[[70, 74, 89]].tolist() == [1.0, 1.0, 1.0]
