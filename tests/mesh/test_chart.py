"""Closest points, charts by geodesics, placing, and laying pads on surfaces."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.interpolate import RectBivariateSpline

from paint3d.core.quaternion import matrices_from_quaternions
from paint3d.errors import InputError, MeshError, RecordingError
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import (
    SplineMap,
    frame_at,
    lay_square,
    lay_squares,
    make_chart,
    overlapping,
    unroll,
)
from paint3d.mesh.placement import place
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.flat_input import LaidPad, lay, pad_extent
from paint3d.recording.flat_recording import orientations_from_angles
from paint3d.recording.recording import Recording
from scripts.solids import make_plane, make_sphere


def sheet(surface, us, vs):
    """A mesh over a grid of parameters; `surface(u, v)` gives points, u cross v outward."""
    u, v = np.meshgrid(us, vs, indexing="ij")
    points = np.stack(surface(u, v), axis=-1).reshape(-1, 3)
    ids = np.arange(u.size).reshape(u.shape)
    a, b, c, d = (x.ravel() for x in (ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return TriangleMesh(points.astype(np.float32), faces.astype(np.int32))


@pytest.fixture(scope="module")
def plane():
    grid = np.linspace(-50, 50, 11)
    return ClosestPoints(sheet(lambda u, v: (u, v, 0 * u), grid, grid))


@pytest.fixture(scope="module")
def cylinder():
    """R = 40 mm about z, in front (-y); u is the arc, v the height."""
    return ClosestPoints(
        sheet(
            lambda u, v: (40 * np.sin(u / 40), -40 * np.cos(u / 40), v),
            np.linspace(-60, 60, 161),
            np.linspace(-50, 50, 41),
        )
    )


@pytest.fixture(scope="module")
def cap():
    """The upper part of a sphere of 75 mm."""
    grid = np.linspace(-45, 45, 121)

    def point(u, v):
        r = np.sqrt(u * u + v * v + 75.0**2) / 75.0
        return u / r, v / r, 75.0 / r

    return ClosestPoints(sheet(point, grid, grid))


def spread(reach, n=500):
    return np.random.default_rng(0).uniform(-reach, reach, (n, 2))


def brute_force(mesh, point):
    """Nearest distance by trying every face: its plane, its edges."""
    best = np.inf
    for corners in mesh.vertices[mesh.faces].astype(float):
        edges = np.roll(corners, -1, axis=0) - corners
        normal = np.cross(edges[0], -edges[2])
        share = [
            np.dot(np.cross(e, point - c), normal) for e, c in zip(edges, corners, strict=True)
        ]
        if min(share) >= 0:
            best = min(best, abs(np.dot(point - corners[0], normal)) / np.linalg.norm(normal))
        for edge, corner in zip(edges, corners, strict=True):
            t = np.clip(np.dot(point - corner, edge) / np.dot(edge, edge), 0, 1)
            best = min(best, np.linalg.norm(point - corner - t * edge))
    return best


def test_closest_points_equal_a_search_through_all_faces():
    grid = np.linspace(-10, 10, 7)
    surface = ClosestPoints(sheet(lambda u, v: (u, v, np.sin(u) + 0.1 * v * v), grid, grid))
    points = np.random.default_rng(4).uniform(-14, 14, (40, 3))
    found = surface.find(points)
    distance = np.linalg.norm(found.points - points, axis=1)
    wanted = [brute_force(surface.mesh, p) for p in points]
    assert distance == pytest.approx(wanted, abs=1e-4)
    corners = surface.mesh.vertices[surface.mesh.faces[found.faces]]
    again = np.einsum("nk,nkd->nd", found.barycentric, corners)
    assert again == pytest.approx(found.points, abs=1e-5)
    assert np.linalg.norm(found.normals, axis=1) == pytest.approx(1.0)


def test_rays_hit_or_say_so(plane):
    hits = plane.cast(np.array([[1.0, 2, 9], [500, 0, 9]]), np.array([[0.0, 0, -3], [0, 0, -1]]))
    assert hits.hit.tolist() == [True, False]
    assert hits.distance[0] == pytest.approx(3.0)
    assert hits.points[0] == pytest.approx([1, 2, 0], abs=1e-5)
    assert hits.faces[1] == -1
    assert np.isnan(hits.points[1]).all()


@pytest.mark.parametrize(("fold", "smooth"), [(0.4, True), (1.5, False)])
def test_normals_ignore_seams_but_not_edges(fold, smooth):
    """Two triangles with vertices of their own meet along x; one is folded up."""
    up = [0, -np.cos(fold), np.sin(fold)]
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0], up, [1, 0, 0]]
    faces = np.array([[0, 1, 2], [3, 4, 5]], np.int32)
    surface = ClosestPoints(TriangleMesh(np.array(corners, np.float32), faces))
    normal = surface.find(np.array([[0.5, 1e-6, 0.0]])).normals[0]
    lean = 0.5 * fold if smooth else 0.0
    assert normal == pytest.approx([0, np.sin(lean), np.cos(lean)], abs=0.02)


def test_a_plane_is_its_own_chart(plane):
    chart = make_chart(plane, frame_at(plane, [5, -3, 4], [0, 1, 0]), 40, 30)
    xy = spread(30)
    wanted = np.column_stack([xy + np.array([5, -3]), np.zeros(len(xy))])
    assert chart.points(xy) == pytest.approx(wanted, abs=2e-4)
    assert chart.tangents(xy) == pytest.approx(np.tile(np.eye(3), (len(xy), 1, 1)), abs=1e-4)


def test_a_sphere_gives_its_exponential_map(cap):
    frame = frame_at(cap, [0, 0, 80], [0, 1, 0])
    chart = make_chart(cap, frame, 22, 22)
    xy = spread(22)
    r = np.hypot(*xy.T)[:, None]
    ray = (xy[:, :1] * frame.x_axis + xy[:, 1:] * frame.y_axis) / r
    wanted = 75 * (np.cos(r / 75) * frame.normal + np.sin(r / 75) * ray)
    assert np.linalg.norm(chart.points(xy) - wanted, axis=1).max() < 0.01
    assert chart.normals(xy) == pytest.approx(wanted / 75, abs=2e-3)


def test_a_cylinder_is_unrolled(cylinder):
    chart = make_chart(cylinder, frame_at(cylinder, [0, -50, 0], [0, 0, 1]), 30, 20)
    xy = spread(20) * [1.5, 1.0]
    turn = xy[:, 0] / 40
    wanted = np.column_stack([40 * np.sin(turn), -40 * np.cos(turn), xy[:, 1]])
    assert np.linalg.norm(chart.points(xy) - wanted, axis=1).max() < 0.01
    frames = chart.tangents(xy)
    assert frames[..., 1] == pytest.approx(np.tile([0, 0, 1.0], (len(xy), 1)), abs=2e-3)
    assert np.einsum("nij,nik->njk", frames, frames) == pytest.approx(
        np.tile(np.eye(3), (len(xy), 1, 1)), abs=1e-12
    )


def test_a_chart_over_the_edge_is_refused(plane):
    frame = frame_at(plane, [30, 0, 0], [0, 1, 0])
    with pytest.raises(MeshError, match="the surface ends 20"):
        make_chart(plane, frame, 25, 1)


def test_boxes_laid_side_by_side_are_those_laid_alone(cap):
    """To the bit; boxes of several sizes need steps of their own."""
    frames = [frame_at(cap, (x, x / 2, 75.0), (0, 1, 0)) for x in (-20.0, -9.0, 0.0, 14.0, 22.0)]
    sizes = [(8.0, 8.0), (3.0, 9.0), (8.0, 8.0), (14.0, 2.0), (8.0, 8.0)]
    together = lay_squares(cap, frames, 8.0, sizes)
    for frame, size, square in zip(frames, sizes, together, strict=True):
        alone = lay_square(cap, frame, 8.0, size=size)
        assert np.array_equal(alone.points, square.points)
        assert np.array_equal(alone.normals, square.normals)
        at = [[0.4 * size[0], -0.3 * size[1]]]
        assert np.array_equal(alone.chart.tangents(at), square.chart.tangents(at))


@pytest.mark.parametrize("name", ["cap", "plane"])
def test_of_many_boxes_the_first_pair_that_overlaps_is_named(name, request):
    """Wherever on the surface it lies: the number of the box counts, not its place.

    A plane along the axes gives boxes without any thickness.
    """
    surface = request.getfixturevalue(name)
    rng = np.random.default_rng(5)
    for spread in [(22.0, 22.0), (22.0, 2.0), (2.0, 22.0)]:
        places = rng.uniform(-1.0, 1.0, (40, 2)) * spread
        frames = [frame_at(surface, (x, y, 75.0), (0, 1, 0)) for x, y in places]
        squares = lay_squares(surface, frames, 3.0, [(3.0, 3.0)] * 40)
        for most in (0.2, 1.0, 2.0):
            pairs = (
                (k, other)
                for k, other in itertools.combinations(range(40), 2)
                if squares[k].overlap(squares[other]) > most
                or squares[other].overlap(squares[k]) > most
            )
            assert overlapping(squares, lambda *_, most=most: most) == next(pairs, None)


@pytest.mark.parametrize("x", [30.0, 49.0])
def test_of_boxes_the_first_that_has_no_place_is_named(plane, x):
    first, second = frame_at(plane, (x, 0, 0), (0, 1, 0)), frame_at(plane, (48, 9, 0), (0, 1, 0))
    where = {30.0: r"\(48\.0, 9\.0", 49.0: r"\(49\.0, 0\.0"}[x]
    with pytest.raises(MeshError, match=rf"{where}, 0\.0\): the surface ends within it"):
        lay_squares(plane, [first, second], 8.0, [(8.0, 8.0)] * 2)


def test_coordinates_outside_the_chart_are_refused(plane):
    chart = make_chart(plane, frame_at(plane, [0, 0, 0], [0, 1, 0]), 10, 5)
    with pytest.raises(InputError, match="lies outside the chart"):
        chart.points([[0, 5.1]])


def test_up_along_the_normal_is_refused(plane):
    with pytest.raises(InputError, match="along the surface's normal"):
        frame_at(plane, [0, 0, 0], [0, 0, 1])


def test_placing_by_fractions_and_by_direction(plane, cylinder):
    above = place(plane, (0.75, 0.5))
    assert above.origin == pytest.approx([25, 0, 0], abs=1e-4)
    assert above.y_axis == pytest.approx([0, 1, 0], abs=1e-6)
    front = place(cylinder, (0.5, 0.75))
    assert front.origin == pytest.approx([0, -40, 25], abs=0.01)
    assert front.y_axis == pytest.approx([0, 0, 1], abs=1e-3)
    assert place(plane, (0, 0, 1)).origin == pytest.approx([0, 0, 0], abs=1e-4)
    with pytest.raises(InputError, match=r"u is 1\.5"):
        place(plane, (1.5, 0.5))
    with pytest.raises(MeshError, match="there is no surface"):
        place(cylinder, (0, 0, 1))


def test_faces_are_parts_of_the_outside_and_of_what_is_flat_its_top_and_back(plane):
    round_body = ClosestPoints(load_mesh("vase"))
    axes = {"front": (0, -1), "right": (1, 0), "back": (0, 1), "left": (-1, 0)}
    for face, axis in axes.items():
        for u, way in ((0.5, 0.0), (0.6, 0.2 * np.pi)):  # U grows to the right of who looks at it
            seen = place(round_body, (u, 0.5), face).origin[:2]
            c, s = np.cos(way), np.sin(way)
            turned = np.array([c * axis[0] - s * axis[1], s * axis[0] + c * axis[1]])
            assert seen / np.linalg.norm(seen) == pytest.approx(turned, abs=0.01)
    for face in axes:
        with pytest.raises(InputError, match=f"side is '{face}'; expected u, v on that face"):
            place(round_body, (1, 0, 0), face)
    assert place(plane, (0.75, 0.5), "front").origin == pytest.approx([25, 0, 0], abs=1e-4)
    with pytest.raises(InputError, match="lies flat; expected its front"):
        place(plane, (0.5, 0.5), "left")
    with pytest.raises(MeshError, match="seen from the back the surface faces away"):
        place(plane, (0.5, 0.5), "back")


def pad(positions, azimuth=0.3, altitude=1.2):
    n = len(positions)
    return Recording(
        np.arange(n) * 1000,
        np.array(positions, dtype=float),
        orientations_from_angles(np.full(n, azimuth), np.full(n, altitude)),
        np.full(n, 0.5),
        header={"space": "pad", "ink": "pine soot"},
    )


def test_a_pad_laid_on_a_cylinder_keeps_height_and_lean(cylinder):
    chart = make_chart(cylinder, frame_at(cylinder, [0, -40, 0], [0, 0, 1]), 30, 20)
    recording = pad([[0, 0, 0], [20, 10, 7]])
    laid = lay(recording, chart)
    assert laid.header["space"] == "world"
    assert laid.header["ink"] == "pine soot"
    turn = 20 / 40
    wanted = [47 * np.sin(turn), -47 * np.cos(turn), 10]
    assert laid.position[1] == pytest.approx(wanted, abs=0.02)
    outward = np.array([np.sin(turn), -np.cos(turn), 0])
    handle = matrices_from_quaternions(laid.orientation)[1, :, 2]
    assert handle @ outward == pytest.approx(np.sin(1.2), abs=2e-3)
    assert handle[2] == pytest.approx(np.cos(1.2) * np.sin(0.3), abs=2e-3)


def test_laying_refuses_what_does_not_fit(plane):
    chart = make_chart(plane, frame_at(plane, [0, 0, 0], [0, 1, 0]), 10, 10)
    with pytest.raises(RecordingError, match="does not fit"):
        lay(pad([[11, 0, 0]]), chart)
    with pytest.raises(RecordingError, match="expected 'pad'"):
        lay(lay(pad([[1, 0, 0]]), chart), chart)


def test_a_pad_is_centred_scaled_and_laid_part_by_part(plane):
    drawn = pad([[10, 10, 3], [30, 20, 0], [11, 12, 0], [29, 13, 1], [15, 11, 0]])
    middle, half, scale = pad_extent(drawn, width_mm=10)
    assert (middle.tolist(), half.tolist(), scale) == ([20, 15], [5, 2.5], 0.5)
    chart = make_chart(plane, frame_at(plane, [0, 0, 0], [0, 1, 0]), 10, 10)
    laid = LaidPad(drawn, chart, middle, scale)
    whole = laid.whole()
    assert whole.position[:2] == pytest.approx(np.array([[-5, -2.5, 3], [5, 2.5, 0]]))
    assert laid.header == whole.header
    for first, last in ((0, 2), (1, 4), (4, 5)):
        part = laid.part(first, last)
        for name in ("time_ns", "position", "orientation", "pressure", "contact", "buttons"):
            np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[first:last])
    with pytest.raises(RecordingError, match="has no width"):
        pad_extent(pad([[1, 2, 0], [1, 3, 0]]), 10)


@pytest.mark.parametrize("half", [300.0, 5e5])
def test_a_sheet_much_too_large_is_refused_soon(plane, monkeypatch, half):
    asked, find = [], ClosestPoints.find

    def counted(self, points):
        asked.append(len(points))
        return find(self, points)

    monkeypatch.setattr(ClosestPoints, "find", counted)
    frame = frame_at(plane, (0, 0, 0), (0, 1, 0))
    asked.clear()
    with pytest.raises((InputError, MeshError), match=r"surface ends|is 141 mm in size; expected"):
        make_chart(plane, frame, half, half)
    assert sum(asked) < 10_000  # a full grid of them is 160,000 at every step


# -- unrolling ---------------------------------------------------------------------------------


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


# -- splines over a grid -----------------------------------------------------------------------


@pytest.mark.parametrize("nodes", [(4, 4), (5, 41), (33, 8)])
@pytest.mark.parametrize("order", [(0, 0), (1, 0), (0, 1)])
def test_functions_are_those_of_scipy_to_the_bit(
    nodes: tuple[int, int], order: tuple[int, int]
) -> None:
    chance = np.random.default_rng(3)
    xs = np.sort(chance.uniform(-60.0, 60.0, nodes[0]))
    ys = np.linspace(-7.3, 5.1, nodes[1])
    values = chance.normal(size=(*nodes, 3)).cumsum(axis=0)
    xy = chance.uniform([xs[0], ys[0]], [xs[-1], ys[-1]], (5000, 2))
    xy[: nodes[0], 0], xy[-nodes[1] :, 1] = xs, ys  # on the nodes, too
    xy[100:102] = [[xs[0], ys[0]], [xs[-1], ys[-1]]]
    found = SplineMap(xs, ys, values)(xy, *order)
    for f in range(3):
        expected = RectBivariateSpline(xs, ys, values[..., f]).ev(*xy.T, *order)
        np.testing.assert_array_equal(found[:, f], expected)


def test_beyond_the_grid_the_rim_holds() -> None:
    xs, ys = np.linspace(0.0, 6.0, 7), np.linspace(0.0, 4.0, 5)
    values = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1)
    found = SplineMap(xs, ys, values)(np.array([[-1.0, 2.0], [7.0, 9.0]]))
    np.testing.assert_allclose(found, [[0.0, 2.0], [6.0, 4.0]], atol=1e-12)
