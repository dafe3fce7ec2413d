import json

import numpy as np
import pytest

from paint3d.bench.copybook import Desk, copy_character, draw_sample, picture
from paint3d.calligraphy.planning import PlanSettings
from paint3d.errors import InputError

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
    image = picture([copy])
    assert image.shape == (576, 576, 3)
    shared = (image == (200, 200, 200)).all(axis=2)
    assert shared.sum() == (copy.painted & copy.wanted).sum()
    assert np.array_equal(shared, (copy.painted & copy.wanted)[::-1])


def test_sample_is_the_same_for_the_same_seed(glyphs):
    assert draw_sample(glyphs, 2, 5) == draw_sample(glyphs, 2, 5)
    assert sorted(draw_sample(glyphs, 3, 1)) == sorted("一二三")
    drawn = draw_sample(glyphs, 1, 4, also="一二三二")
    assert sorted(drawn) == sorted("一二三")


def test_more_characters_than_there_are_and_no_copies_are_refused(glyphs):
    with pytest.raises(InputError, match="has 3 characters; expected at least 4"):
        draw_sample(glyphs, 4, 1)
    with pytest.raises(InputError, match="no copies"):
        picture([])
