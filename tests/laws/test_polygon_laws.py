"""Laws of cutting polygons: every triangle upright, their areas the outline's, from any corner.

The signed areas of triangles that cut a polygon always add up to the outline's. Where none is
turned over as well, they cover every point inside once and none outside.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.mesh.polygons import triangulate
from tests.support.examples import examples

AS_IT_LIES = np.eye(3)
SEEDS = st.integers(0, 100_000)


def shoelace(ring):
    """Signed area of an (n, 2) outline."""
    after = np.roll(ring, -1, axis=0)
    return 0.5 * float((ring[:, 0] * after[:, 1] - ring[:, 1] * after[:, 0]).sum())


def signed_areas(ring, faces):
    a, b, c = (ring[faces[:, k]] for k in range(3))
    u, v = b - a, c - a
    return 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def check_every_start(ring, turned=AS_IT_LIES, starts=None):
    """Cut an (n, 2) counter-clockwise outline from each corner in turn."""
    n, area = len(ring), shoelace(ring)
    points = np.c_[ring, np.zeros(n)] @ turned
    for start in range(n) if starts is None else starts:
        faces = triangulate(points, np.roll(np.arange(n), -start), np.array([n]))
        parts = signed_areas(ring, faces)
        assert faces.shape == (n - 2, 3)
        assert parts.min() >= -1e-9 * area, start
        assert parts.sum() == pytest.approx(area), start


def outline_of_cells(cells):
    """The outline (n, 2) of squares that hang together and enclose no other; corners only."""
    following = {}
    for x, y in cells:
        sides = (
            ((x, y), (x + 1, y), (x, y - 1)),
            ((x + 1, y), (x + 1, y + 1), (x + 1, y)),
            ((x + 1, y + 1), (x, y + 1), (x, y + 1)),
            ((x, y + 1), (x, y), (x - 1, y)),
        )
        following |= {start: end for start, end, across in sides if across not in cells}
    at = first = min(following)
    ring = []
    while not ring or at != first:
        ring.append(at)
        at = following[at]
    assert len(ring) == len(following)
    return np.array(ring, float)


def grown(seed, n_cells):
    """A random heap of squares that touches itself in no corner and encloses nothing."""
    rng = np.random.default_rng(seed)
    cells = {(0, 0)}
    for _ in range(20 * n_cells):
        if len(cells) == n_cells:
            break
        x, y = sorted(cells)[rng.integers(len(cells))]
        dx, dy = ((1, 0), (-1, 0), (0, 1), (0, -1))[rng.integers(4)]
        x, y = x + dx, y + dy
        ring = [(x + i, y + j) in cells for i, j in
                ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))]  # fmt: skip
        changes = sum(ring[k] != ring[k - 1] for k in range(8))
        if (x, y) not in cells and changes == 2:  # its neighbours are one run: no hole, no touch
            cells.add((x, y))
    return cells


def without_straight_corners(ring):
    u, v = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    return ring[u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] != 0.0]


def turned_about(seed):
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]


@settings(deadline=None, max_examples=examples(60))
@given(SEEDS, st.integers(2, 40), st.booleans())
def test_rectilinear_polygons(seed, n_cells, straight):
    ring = outline_of_cells(grown(seed, n_cells))
    ring = ring if straight else without_straight_corners(ring)
    check_every_start(ring + 100.0, turned_about(seed), starts=(seed % len(ring),))
    steps = np.random.default_rng(seed).uniform(0.1, 3.0, (2, 200)).cumsum(axis=1)
    ring = ring.astype(int) + 100
    ring = np.stack([steps[0][ring[:, 0]], steps[1][ring[:, 1]]], axis=1)  # columns of any width
    check_every_start(ring)


def test_an_h_from_every_corner():
    h = [(0, 0), (10, 0), (10, 10), (20, 10), (20, 0), (30, 0),
         (30, 30), (20, 30), (20, 20), (10, 20), (10, 30), (0, 30)]  # fmt: skip
    assert shoelace(np.array(h, float)) == 700.0
    check_every_start(np.array(h, float))


def simple(seed, n, whole):
    """A random outline without crossings: wherever two sides cross, what is between is turned."""
    rng = np.random.default_rng(seed)
    ring = rng.permutation(np.unique(rng.integers(0, 8, (n, 2)), axis=0)).astype(float)
    ring += 0.0 if whole else rng.uniform(-0.4, 0.4, ring.shape)
    for _ in range(2000):
        pair = crossing(ring)
        if pair is None:
            return ring if shoelace(ring) > 0.0 else ring[::-1]
        i, j = pair
        ring[i + 1 : j + 1] = ring[i + 1 : j + 1][::-1].copy()
    return None


def crossing(ring):
    """The first two sides that meet elsewhere than in a corner they share, or None."""
    n = len(ring)
    after = np.roll(ring, -1, axis=0)

    def side(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    def between(a, b, c):
        return side(a, b, c) == 0.0 and min(a[0], b[0]) <= c[0] <= max(a[0], b[0]) and (
            min(a[1], b[1]) <= c[1] <= max(a[1], b[1])
        )  # fmt: skip

    for i in range(n):
        for j in range(i + 1, n):
            a, b, c, d = ring[i], after[i], ring[j], after[j]
            if j == i + 1 or (i == 0 and j == n - 1):
                shared, other, far = (b, a, d) if j == i + 1 else (a, b, c)
                if between(shared, other, far) or between(shared, far, other):
                    return i, j
                continue
            if side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0:
                return i, j
            if between(a, b, c) or between(a, b, d) or between(c, d, a) or between(c, d, b):
                return i, j
    return None


@settings(deadline=None, max_examples=examples(60))
@given(SEEDS, st.integers(4, 16), st.booleans(), SEEDS)
def test_simple_polygons(seed, n, whole, turn):
    ring = simple(seed, n, whole)
    if ring is None or len(ring) < 4:
        return
    check_every_start(ring)
    check_every_start(ring, turned_about(turn), starts=(0, len(ring) // 2))


@settings(deadline=None, max_examples=examples(30))
@given(st.lists(st.tuples(*[st.floats(0.5, 4.0)] * 3), min_size=1, max_size=4), SEEDS)
def test_holes_that_a_seam_joins_to_the_outline(holes, turn):
    ring = [(0.0, 0.0)]
    for k, (low, width, height) in enumerate(holes):
        x, left, right = 4.0 * k + 3.0, 4.0 * k + 2.5, 4.0 * k + 2.5 + 0.8 * width
        ring += [(x, 0.0), (x, low), (left, low), (left, low + height), (right, low + height),
                 (right, low), (x, low), (x, 0.0)]  # fmt: skip
    ring = np.array([*ring, (20.0, 0.0), (20.0, 10.0), (0.0, 10.0)])
    check_every_start(ring)
    check_every_start(ring, turned_about(turn), starts=(0, 5))


def area_of(points, faces):
    a, b, c = (points[faces[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def seen_along_its_normal(points):
    """An outline (n, 3) as (n, 2), counter-clockwise, by another way than that of what is tried."""
    normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    turned, _ = np.linalg.qr(np.c_[normal, np.eye(3)])
    flat = points @ turned[:, 1:3]
    return flat if shoelace(flat) > 0.0 else flat[:, ::-1]


@settings(deadline=None, max_examples=examples(60))
@given(SEEDS, st.integers(4, 10), st.floats(0.0, 3.0), SEEDS)
def test_outlines_that_are_not_flat(seed, n, height, turn):
    """Along the axis nearest to the normal they looked otherwise: corners that point in, out."""
    ring = simple(seed, n, whole=False)
    if ring is None or len(ring) < 4:
        return
    lift = np.random.default_rng(seed).uniform(-height, height, len(ring))
    points = np.c_[ring, lift] @ turned_about(turn)
    seen = seen_along_its_normal(points)
    if crossing(seen) is not None:
        return
    faces = triangulate(points, np.arange(len(ring)), np.array([len(ring)]))
    fan = np.array([[0, k, k + 1] for k in range(1, len(ring) - 1)])
    assert (faces == fan).all() or signed_areas(seen, faces).min() >= -1e-9 * shoelace(seen)
    assert area_of(points, faces) <= area_of(points, fan) * (1.0 + 1e-5)
    assert signed_areas(seen, faces).sum() == pytest.approx(shoelace(seen))


def test_a_twisted_spoke_of_a_bicycle():
    """A stranger's four corners: cut along its length it had six times its area."""
    spoke = np.array([[-1.588, 0.313, -0.112], [3.578, 8.808, 10.373],
                      [-1.122, -0.345, 0.123], [-0.868, -8.776, -10.384]])  # fmt: skip
    for start in range(4):
        ids = np.roll(np.arange(4), -start)
        faces = triangulate(spoke, ids, np.array([4]))
        assert all({0, 2} < set(face) for face in faces.tolist())
        assert area_of(spoke, faces) == pytest.approx(11.49, abs=0.01)


def test_the_fan_is_taken_where_ears_fold_back():
    """As in outlines that cross themselves, of which a heater's ribs have some."""
    crossed = np.array([[3, 4, 0], [0, 0, 0], [2, 3, 0], [3, 0, 0]], float)
    faces = triangulate(crossed, np.arange(4), np.array([4]))
    assert faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert area_of(crossed, faces) == 2.5
