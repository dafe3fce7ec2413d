import json

import pytest

from paint3d.calligraphy.planning import PlanSettings
from tests.support.copybook import Desk, copy_character

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
