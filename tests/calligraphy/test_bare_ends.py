"""Stubs of bold strokes that their lines do not reach."""

import numpy as np
import shapely
from shapely import box

from paint3d.calligraphy.glyphs import GlyphStroke
from paint3d.calligraphy.shapes.regions import with_stubs

STEM = np.array([[50.0, 190.0], [50.0, 10.0]])


def stroke(shape, line):
    return GlyphStroke(np.array(shape.exterior.coords)[:-1], line)


def test_an_arm_beside_a_bold_stem_is_a_stroke_of_its_own() -> None:
    shape = box(30, 0, 70, 200).union(box(0, 110, 31, 140))
    given = stroke(shape, STEM)
    found = with_stubs([given], 30.0)
    assert len(found) == 2
    assert found[0] is given
    arm = shapely.Polygon(found[1].outline)
    assert arm.contains(box(1, 111, 29, 139))
    assert shape.buffer(1e-6).contains(arm)
    line = shapely.LineString(found[1].median)
    assert arm.contains(line)
    assert line.coords[0][0] < line.coords[-1][0]  # from its far end into the stem


def test_thin_strokes_and_plain_ends_have_none() -> None:
    arm = box(30, 0, 70, 200).union(box(0, 110, 31, 140))
    assert len(with_stubs([stroke(arm, STEM)], 50.0)) == 1
    plain = stroke(box(30, 0, 70, 200), STEM)
    assert with_stubs([plain], 30.0) == [plain]


def test_what_is_bare_beside_a_line_but_narrow_is_none() -> None:
    """A line that runs off the middle leaves a band along the edge, a fifth of the stroke wide."""
    assert len(with_stubs([stroke(box(30, 0, 78, 200), STEM)], 30.0)) == 1
