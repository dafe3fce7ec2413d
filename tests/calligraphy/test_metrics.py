from __future__ import annotations

import functools
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.calligraphy.metrics import MARGIN, PIXELS, compare, copybook_mask, painted_mask
from paint3d.calligraphy.path_fit import PlanSettings
from paint3d.errors import InputError
from tests.support.copybook import Desk, copy_character
from tests.support.examples import examples

EM = 64.0
PIXEL = EM / PIXELS


def box(x0, y0, x1, y1):
    """A rectangle's corners, pixels of the em square to mm."""
    return PIXEL * np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], float)


@functools.cache
def mask(*corners):
    return copybook_mask([box(*corners)], EM)


def test_the_same_shape_is_wholly_alike():
    like = compare(mask(100, 200, 300, 240), mask(100, 200, 300, 240))
    assert (like.iou, like.precision, like.recall) == (1.0, 1.0, 1.0)
    assert like.hausdorff95 == like.width_error == 0.0


@given(aside=st.integers(1, 40))
@settings(deadline=None, max_examples=examples(25))
def test_a_shifted_square_has_the_overlap_and_distance_of_its_shift(aside):
    like = compare(mask(100 + aside, 100, 200 + aside, 200), mask(100, 100, 200, 200))
    assert like.iou == pytest.approx((100 - aside) / (100 + aside))
    assert like.precision == like.recall == pytest.approx(1 - aside / 100)
    assert like.hausdorff95 * PIXELS == pytest.approx(aside)


def test_precision_and_recall_tell_too_much_from_too_little():
    small, large = mask(100, 100, 200, 200), mask(100, 100, 200, 300)
    assert (compare(large, small).precision, compare(large, small).recall) == (0.5, 1.0)
    assert (compare(small, large).precision, compare(small, large).recall) == (1.0, 0.5)


def test_holes_are_left_out_of_their_own_outline_only():
    frame, hole, within = box(100, 100, 200, 200), box(120, 120, 180, 180), box(140, 140, 160, 160)
    assert copybook_mask([frame], EM, [[hole]]).sum() == 100**2 - 60**2
    assert copybook_mask([frame, within], EM, [[hole]]).sum() == 100**2 - 60**2 + 20**2


def test_width_error_counts_both_sides_of_a_bar():
    wanted = mask(50, 200, 450, 240)
    assert compare(mask(50, 197, 450, 243), wanted).width_error * PIXELS == pytest.approx(
        6, abs=0.2
    )
    assert compare(mask(50, 202, 450, 238), wanted).width_error * PIXELS == pytest.approx(
        4, abs=0.2
    )


def test_pixel_belongs_to_the_shape_from_half_its_area_on():
    assert mask(10, 10, 20.51, 20).sum() == 110
    assert mask(10, 10, 20.49, 20).sum() == 110  # two of four columns of samples
    assert mask(10, 10, 20.37, 20).sum() == 100


def test_raster_has_the_em_square_in_its_middle_and_rows_upwards():
    rows, columns = np.nonzero(mask(0, 0, 3, 5))
    assert (columns.min(), columns.max()) == (MARGIN, MARGIN + 2)
    assert (rows.min(), rows.max()) == (MARGIN, MARGIN + 4)


def test_outlines_are_joined_and_filled_by_the_non_zero_rule():
    twice = np.concatenate([box(10, 10, 60, 60), box(30, 30, 80, 80)])
    apart = copybook_mask([box(10, 10, 60, 60), box(30, 30, 80, 80)], EM)
    assert apart.sum() == 2 * 50**2 - 30**2
    inner = mask(32, 32, 58, 58)
    assert (copybook_mask([twice], EM) & inner).sum() == inner.sum()


def test_painting_ends_where_its_coverage_falls_to_half():
    corners = PIXEL * np.array([[100.0, 100.0], [200.0, 100.0], [200.0, 200.0], [100.0, 200.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    painted = painted_mask(corners, [1.0, 0.0, 0.0, 1.0], faces, EM)
    assert np.array_equal(painted, mask(100, 100, 150, 200))
    assert painted_mask(corners, [1.0] * 4, faces, EM).sum() == 100**2
    corners[2] = np.nan
    assert painted_mask(corners, [1.0] * 4, faces, EM).sum() == 0


def test_bad_shapes_are_refused():
    one = mask(10, 10, 20, 20)
    with pytest.raises(InputError, match="painted shape is empty"):
        compare(np.zeros_like(one), one)
    with pytest.raises(InputError, match="expected the same"):
        compare(one[:10], one)
    with pytest.raises(InputError, match="outline 1"):
        copybook_mask([np.zeros((3, 3))], EM)
    with pytest.raises(InputError, match="em"):
        copybook_mask([box(0, 0, 1, 1)], 0.0)
    with pytest.raises(InputError, match=r"expected \(V, 2\) and \(V,\)"):
        painted_mask(np.zeros((4, 2)), np.zeros(3), np.zeros((1, 3), int), EM)


# -- the copybook ------------------------------------------------------------------------------


BAR = "M 200 420 Q 230 470 300 440 L 760 452 Q 850 470 840 400 L 300 380 Q 230 370 200 420 Z"
GLYPH = {"strokes": [BAR], "medians": [[[215, 420], [500, 415], [830, 420]]]}


@pytest.fixture(scope="module")
def glyphs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("glyphs")
    for text in "一二三":
        (folder / f"{text}.json").write_text(json.dumps(GLYPH), encoding="utf-8")
    (folder / "package.json").write_text("{}", encoding="utf-8")
    return folder


@pytest.mark.parametrize("azimuth", ["commanded", "dragged"])
def test_painted_character_is_like_its_copybook(glyphs, azimuth):
    desk = Desk(glyphs, 20.0, "plane", 0.1, settings=PlanSettings(azimuth=azimuth))
    copy = copy_character(desk, "一")
    assert copy.likeness.iou > 0.95
    assert copy.likeness.precision > 0.985
    assert copy.n_strokes == 1
    speed, acceleration, jerk, turning = copy.fastest
    assert speed <= 120.0
    assert acceleration <= 1000.0
    assert jerk <= 10000.0
    assert turning <= 6.0


def test_painted_character_is_like_its_copybook_on_the_bowl(glyphs):
    copy = copy_character(Desk(glyphs, 20.0, "bowl", 0.2), "一")
    assert copy.likeness.iou > 0.94
