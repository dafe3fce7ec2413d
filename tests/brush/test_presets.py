import itertools

import numpy as np
import pytest

from paint3d.brush.bending import build_tuft
from paint3d.brush.presets import brush_names, choose_brush, load_brush
from paint3d.calligraphy.footprint_table import tabulate_footprints
from paint3d.errors import InputError
from tests.support.outlines import sizes_of

SIZES = np.geomspace(8.0, 200.0, 40)


def test_every_size_has_a_brush_and_larger_ones_no_smaller_brush():
    chosen = [choose_brush(em) for em in SIZES]
    assert set(chosen) <= set(brush_names())
    lengths = [load_brush(name).length_mm for name in chosen]
    assert (np.diff(lengths) >= 0.0).all()
    assert len(set(chosen)) > 1


def test_new_brushes_come_after_the_others():
    """The studio's keys go by the order."""
    assert brush_names() == (
        "full", "slender", "calibrated", "xiaokai", "zhongkai", "dakai", "gongbi", "baiyun",
        "xiaobaiyun", "zhongbaiyun", "dabaiyun", "feibai", "langhao", "yanghao", "jianhao",
    )  # fmt: skip


def test_weasel_is_thin_and_springs_back_goat_is_broad_and_stays_bent():
    brushes = [load_brush(name) for name in ("langhao", "jianhao", "yanghao")]
    assert [brush.hair for brush in brushes] == ["weasel", "mixed", "goat"]
    for low, high in itertools.pairwise(brushes):
        assert low.plasticity < high.plasticity
        assert low.load < high.load
        assert low.spring > high.spring
    shares = np.linspace(0.01, 1.0, 100)
    widths = [sizes_of(build_tuft(b), shares * b.full_press_mm)[:, 1] for b in brushes]
    assert (np.diff(widths, axis=1) > 0.0).all()
    assert (np.diff(widths, axis=0) > 0.0).all()


@pytest.mark.parametrize("em", [8.0, 21.9, 22.1, 60.0, 60.1, 200.0])
def test_brush_makes_the_strokes_of_its_size(em):
    """Kaishu's strokes are 1 to 14 % of the em wide; the footprint must be about as long."""
    footprints = tabulate_footprints(build_tuft(load_brush(choose_brush(em))), 0.2 * em)
    length, width = np.ptp(footprints.points, axis=1).T
    assert width[0] < 0.02 * em
    assert width[-1] > 0.14 * em
    body = (width > 0.04 * em) & (width < 0.1 * em)
    assert (length / width)[body].min() > 0.6
    assert (length / width)[body].max() < 1.4
    assert load_brush(choose_brush(em)).length_mm < 2.6 * em


@pytest.mark.parametrize("em", [7.9, 200.1, float("nan"), -3.0, "large"])
def test_other_sizes_are_refused(em):
    with pytest.raises(InputError, match="size of the characters"):
        choose_brush(em)
