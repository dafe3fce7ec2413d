import numpy as np
import pytest

from paint3d.brush.bending import build_tuft
from paint3d.brush.presets import brush_names, choose_brush, load_brush
from paint3d.calligraphy.footprint_table import tabulate_footprints
from paint3d.errors import InputError

SIZES = np.geomspace(8.0, 200.0, 40)


def test_every_size_has_a_brush_and_larger_ones_no_smaller_brush():
    chosen = [choose_brush(em) for em in SIZES]
    assert set(chosen) <= set(brush_names())
    lengths = [load_brush(name).length_mm for name in chosen]
    assert (np.diff(lengths) >= 0.0).all()
    assert len(set(chosen)) > 1


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
