import numpy as np
import pytest

from paint3d.errors import InputError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import frame_at, make_chart, unroll
from scripts.solids import make_plane, make_sphere


def chart(mesh, point, half=12.0):
    surface = ClosestPoints(mesh)
    return make_chart(surface, frame_at(surface, point, (0.0, 1.0, 0.3)), half, half)


@pytest.mark.parametrize(
    ("mesh", "point"), [(make_plane(), (5.0, 8.0, 0.0)), (make_sphere(), (0.0, -75.0, 20.0))]
)
def test_points_come_back_to_where_they_were_laid(mesh, point):
    flat = np.random.default_rng(3).uniform(-11.9, 11.9, (300, 2))
    sheet = chart(mesh, point)
    assert np.allclose(unroll(sheet, sheet.points(flat)), flat, atol=1e-4)
    lifted = sheet.points(flat) + 0.2 * sheet.normals(flat)
    assert np.allclose(unroll(sheet, lifted), flat, atol=0.01)


def test_points_beyond_the_sheet_have_no_place_on_it():
    sheet = chart(make_plane(), (0.0, 0.0, 0.0))
    out = unroll(sheet, [[12.3, 0.0, 0.0], [0.0, -40.0, 0.0], [11.0, 11.0, 0.0]])
    assert np.isnan(out[:2]).all()
    assert np.isfinite(out[2]).all()
    assert unroll(sheet, np.empty((0, 3))).shape == (0, 2)


def test_what_is_no_point_is_refused():
    with pytest.raises(InputError, match="points"):
        unroll(chart(make_plane(), (0.0, 0.0, 0.0)), [[1.0, 2.0]])
