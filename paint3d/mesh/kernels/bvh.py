"""Where a root node meets the surface: a box tree, closest points, and the smooth foot point.

The tree is built once, since the surface never changes shape: triangles in Morton order, eight
to a leaf, boxes in heap order (node 1 is the root, the children of n are 2n and 2n + 1).

The foot point P'_m of Guo 2017 (Fig. 7) is the point whose normal passes through the root node
P_m. On a mesh of flat faces the plain closest point sticks to edges while the hand moves evenly;
`find_foot` therefore solves for the point whose *interpolated* normal passes through P_m (the
Phong projection of Panozzo et al. 2013), starting from the closest one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.kernel import kernel, uncounted

__all__ = [
    "ENDLESS",
    "FACES_PER_LEAF",
    "LEAF_SIZE",
    "ContactTree",
    "box_distance2",
    "build_boxes",
    "closest_on",
    "closest_point",
    "closest_weights",
    "find_closest",
    "find_foot",
    "find_foot_within",
    "find_hits",
    "find_meant",
    "interpolate",
    "is_near",
    "mean_normal",
    "nearest_within",
    "note_foot",
    "order_by_halving",
    "residual_of",
    "search_nearest",
    "settle_foot",
]

LEAF_SIZE = 8
ENDLESS = 1 << 62  # nodes that a search may look at, where nothing waits for it
_STACK = 64
_THIN = 1e-12  # sine squared of the angle at a triangle's corner below which it has edges only
_TOLERANCE = 1e-4  # mm, tangential residual at which the foot point counts as found
_ITERATIONS = 8
_WARM = 0.15  # of the reach: a root that has moved farther is looked for afresh
_NEAR = 0.03  # of the reach: a place between two that the hand means lies hardly off the surface
_ON = 0.001  # of the reach: one that it means lies on it


class ContactTree(NamedTuple):
    """A box tree over the base triangles, as plain arrays for kernels."""

    order: NDArray  # (T,) int32, triangles in Morton order
    boxes: NDArray  # (2 L, 6) float32, low and high corners, heap order
    triangles: NDArray  # (T, 3) int32 vertex ids, in that order, the tree's: a leaf's lie together
    points: NDArray  # (V, 3) float32
    normals: NDArray  # (V, 3) float32


@uncounted
def build_boxes(triangles, points, boxes, leaf_size):
    """Fill the boxes of a heap-ordered tree whose leaves hold so many triangles each."""
    n_leaves = boxes.shape[0] // 2
    boxes[:, :3] = np.inf
    boxes[:, 3:] = -np.inf
    for k in range(triangles.shape[0]):
        node = n_leaves + k // leaf_size
        for corner in range(3):
            v = triangles[k, corner]
            for axis in range(3):
                boxes[node, axis] = min(boxes[node, axis], points[v, axis])
                boxes[node, 3 + axis] = max(boxes[node, 3 + axis], points[v, axis])
    for node in range(n_leaves - 1, 0, -1):
        for axis in range(3):
            boxes[node, axis] = min(boxes[2 * node, axis], boxes[2 * node + 1, axis])
            boxes[node, 3 + axis] = max(boxes[2 * node, 3 + axis], boxes[2 * node + 1, 3 + axis])


@uncounted
def box_distance2(boxes, node, x, y, z):
    """Square of how far a point lies from a node's box, mm2."""
    dx = max(0.0, max(boxes[node, 0] - x, x - boxes[node, 3]))
    dy = max(0.0, max(boxes[node, 1] - y, y - boxes[node, 4]))
    dz = max(0.0, max(boxes[node, 2] - z, z - boxes[node, 5]))
    return dx * dx + dy * dy + dz * dz


@uncounted
def _centre_distance2(boxes, node, x, y, z):
    dx = 0.5 * (boxes[node, 0] + boxes[node, 3]) - x
    dy = 0.5 * (boxes[node, 1] + boxes[node, 4]) - y
    dz = 0.5 * (boxes[node, 2] + boxes[node, 5]) - z
    return dx * dx + dy * dy + dz * dz


@uncounted
def _on_edge(u, p):
    """Project p on the edge: u (0 to 1) of the nearest point, and the squared distance to it."""
    along = u[0] * p[0] + u[1] * p[1] + u[2] * p[2]
    length2 = u[0] * u[0] + u[1] * u[1] + u[2] * u[2]
    t = 0.0 if along <= 0.0 else (1.0 if along >= length2 else along / length2)
    dx, dy, dz = p[0] - t * u[0], p[1] - t * u[1], p[2] - t * u[2]
    return t, dx * dx + dy * dy + dz * dz


@uncounted
def _on_nearest_edge(ab, ac, p):
    """`closest_weights` on the border; all are counted from the corner a."""
    bc = (ac[0] - ab[0], ac[1] - ab[1], ac[2] - ab[2])
    t, best = _on_edge(ab, p)
    weights = (1.0 - t, t, 0.0)
    t, d2 = _on_edge(ac, p)
    if d2 < best:
        best, weights = d2, (1.0 - t, 0.0, t)
    t, d2 = _on_edge(bc, (p[0] - ab[0], p[1] - ab[1], p[2] - ab[2]))
    return (0.0, 1.0 - t, t) if d2 < best else weights


@uncounted
def closest_weights(points, a, b, c, place):
    """Barycentric weights of the point of triangle abc nearest to a place (Ericson 2005).

    Where a triangle is too thin to have an inside, the nearest of its edges has the point.
    """
    x, y, z = place
    ax = np.float64(points[a, 0])
    ay = np.float64(points[a, 1])
    az = np.float64(points[a, 2])
    abx = points[b, 0] - ax
    aby = points[b, 1] - ay
    abz = points[b, 2] - az
    acx = points[c, 0] - ax
    acy = points[c, 1] - ay
    acz = points[c, 2] - az
    px = x - ax
    py = y - ay
    pz = z - az
    d1 = abx * px + aby * py + abz * pz
    d2 = acx * px + acy * py + acz * pz
    if d1 <= 0.0 and d2 <= 0.0:
        return 1.0, 0.0, 0.0
    ab_ab = abx * abx + aby * aby + abz * abz
    ab_ac = abx * acx + aby * acy + abz * acz
    ac_ac = acx * acx + acy * acy + acz * acz
    d3 = d1 - ab_ab
    d4 = d2 - ab_ac
    if d3 >= 0.0 and d4 <= d3:
        return 0.0, 1.0, 0.0
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        t = d1 / (d1 - d3)
        return 1.0 - t, t, 0.0
    d5 = d1 - ab_ac
    d6 = d2 - ac_ac
    if d6 >= 0.0 and d5 <= d6:
        return 0.0, 0.0, 1.0
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        t = d2 / (d2 - d6)
        return 1.0 - t, 0.0, t
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return 0.0, 1.0 - t, t
    total = va + vb + vc
    if total <= _THIN * ab_ab * ac_ac:
        return _on_nearest_edge((abx, aby, abz), (acx, acy, acz), (px, py, pz))
    return va / total, vb / total, vc / total


@uncounted
def _faces(points, a, b, c, up):
    """Whether the triangle's front looks towards `up` (3,)."""
    abx = points[b, 0] - points[a, 0]
    aby = points[b, 1] - points[a, 1]
    abz = points[b, 2] - points[a, 2]
    acx = points[c, 0] - points[a, 0]
    acy = points[c, 1] - points[a, 1]
    acz = points[c, 2] - points[a, 2]
    nx = aby * acz - abz * acy
    ny = abz * acx - abx * acz
    nz = abx * acy - aby * acx
    return nx * up[0] + ny * up[1] + nz * up[2] > 0.0


@uncounted(forceinline=True)
def _push_children(boxes, node, place, best, stack, away, depth):
    """Put the children of a node that are near enough on the stack, the nearer last.

    `away` is filled with the squares of how far off they are. Returns where the stack ends then.
    """
    x, y, z = place
    left = box_distance2(boxes, 2 * node, x, y, z)
    right = box_distance2(boxes, 2 * node + 1, x, y, z)
    near = 2 * node
    if right < left or (
        right == left
        and _centre_distance2(boxes, 2 * node + 1, x, y, z)
        < _centre_distance2(boxes, 2 * node, x, y, z)
    ):
        near += 1  # boxes overlap: the one around the point is the better guess
    if max(left, right) <= best:
        depth += 1
        stack[depth], away[depth] = 4 * node + 1 - near, max(left, right)
    if min(left, right) <= best:
        depth += 1
        stack[depth], away[depth] = near, min(left, right)
    return depth


@uncounted(forceinline=True)
def _look_into(tree, leaf, place, up, nearest):
    """The nearest triangle so far after those of a leaf: squared distance, number, and weights."""
    best, found, weights = nearest
    x, y, z = place
    first = leaf * LEAF_SIZE
    for k in range(first, min(first + LEAF_SIZE, tree.triangles.shape[0])):
        a = tree.triangles[k, 0]
        b = tree.triangles[k, 1]
        c = tree.triangles[k, 2]
        if not _faces(tree.points, a, b, c, up):
            continue
        va, vb, vc = closest_weights(tree.points, a, b, c, place)
        d2 = 0.0
        for axis, q in ((0, x), (1, y), (2, z)):
            p = va * tree.points[a, axis] + vb * tree.points[b, axis]
            p += vc * tree.points[c, axis]
            d2 += (p - q) * (p - q)
        if d2 < best or (d2 == best and (found < 0 or tree.order[k] < tree.order[found])):
            best = d2
            found = k
            weights = (va, vb, vc)
    return best, found, weights


@kernel
def search_nearest(tree, place, up, reach, guess, nodes):
    """The triangle nearest to a place among those that face `up`, within reach and budget.

    Parameters
    ----------
    tree : ContactTree
    place : (3,) float64
        mm.
    up : (3,) float64
        Only triangles that face this way count.
    reach : float
        mm.
    guess : int
        A triangle, in the tree's order, to start from; -1 for none.
    nodes : int
        Of the tree, that may be looked at.

    Returns
    -------
    found : int
        In the tree's order, or -1. A tie is won by the triangle that comes first in the mesh.
    weights : (3,) float64
        Of its corners, at the point nearest to the place.
    left : int
        Nodes that were not looked at.
    """
    boxes = tree.boxes
    n_leaves = boxes.shape[0] // 2
    stack, away = np.empty(_STACK, np.int64), np.empty(_STACK)
    nearest = (reach * reach, -1, (0.0, 0.0, 0.0))
    # From the guess's leaf upwards, the other side of every ancestor being looked at in turn: where
    # the guess is good, hardly more than one box a level.
    climbed = n_leaves + guess // LEAF_SIZE if guess >= 0 else 1
    depth = 0
    stack[0], away[0] = climbed, box_distance2(boxes, climbed, place[0], place[1], place[2])
    while nodes > 0:
        if depth < 0:
            if climbed <= 1:
                break
            depth = 0
            stack[0] = climbed ^ 1
            away[0] = box_distance2(boxes, stack[0], place[0], place[1], place[2])
            climbed >>= 1
        node, d2 = stack[depth], away[depth]
        depth -= 1
        nodes -= 1
        if d2 > nearest[0]:
            continue
        if node < n_leaves:
            depth = _push_children(boxes, node, place, nearest[0], stack, away, depth)
        else:
            nearest = _look_into(tree, node - n_leaves, place, up, nearest)
    return nearest[1], nearest[2], nodes


@uncounted
def closest_point(tree, place, up, reach, out):
    """The point nearest to a place (3,) on triangles facing `up` (3,), within `reach` (mm).

    Returns the triangle, or -1; `out` (6,) gets the point and the interpolated unit normal.
    A tie is won by the triangle that comes first in the mesh.
    """
    found, weights, _ = search_nearest(tree, place, up, reach, -1, ENDLESS)
    if found < 0:
        return -1
    interpolate(tree, found, weights, out)
    return tree.order[found]


@uncounted
def interpolate(tree, k, weights, out):
    """Fill `out` (6,) with a point of triangle k (in the tree's order) and its unit normal."""
    wa, wb, wc = weights
    a = tree.triangles[k, 0]
    b = tree.triangles[k, 1]
    c = tree.triangles[k, 2]
    norm = 0.0
    for axis in range(3):
        out[axis] = (
            wa * tree.points[a, axis] + wb * tree.points[b, axis] + wc * tree.points[c, axis]
        )
        n = wa * tree.normals[a, axis] + wb * tree.normals[b, axis] + wc * tree.normals[c, axis]
        out[3 + axis] = n
        norm += n * n
    norm = np.sqrt(norm)
    for axis in range(3):
        out[3 + axis] /= norm if norm > 0.0 else 1.0


@uncounted
def is_near(warm, place, reach):
    """Whether a root has moved so little since `warm` that its foot is looked for from the last."""
    if warm[0] <= 0.0:
        return False
    moved = (place[0] - warm[2]) ** 2 + (place[1] - warm[3]) ** 2 + (place[2] - warm[4]) ** 2
    return moved <= (_WARM * reach) ** 2


@uncounted
def note_foot(warm, found, place):
    """Fill `warm` (5,): 1 where there is a foot, its triangle in the tree's order, and its root."""
    warm[0] = 1.0 if found >= 0 else 0.0
    warm[1] = found
    warm[2] = place[0]
    warm[3] = place[1]
    warm[4] = place[2]


@uncounted
def find_foot(tree, root, up, reach, out, warm):
    """The foot point P'_m of the root node: its interpolated normal passes through it.

    The solution of docs/model.md, equation (5).

    Parameters
    ----------
    tree : ContactTree
    root : (3,) float64
        mm.
    up : (3,) float64
        Up the handle: only triangles that face this way count.
    reach : float
        Farthest surface, mm.
    out : (6,) float64
        Filled with the point and the normal there. Holds the last foot where `warm` says so.
    warm : (5,) float64
        See `note_foot`; kept here. While the root moves little the search goes on from the last
        foot: a tree asked for the nearest of many points all but equally far has to look at most
        of them.

    Returns
    -------
    int
        The triangle the foot lies on, or -1 where no facing surface is within `reach`. Where the
        surface ends or has a crease there may be no such point: then the nearest one found.
    """
    found = -1
    if is_near(warm, root, reach):
        found, _ = settle_foot(tree, root, up, int(warm[1]), 1.0, False, ENDLESS, out)
        rest = residual_of(root, out)[3]
        away = (root[0] - out[0]) ** 2 + (root[1] - out[1]) ** 2 + (root[2] - out[2]) ** 2
        facing = out[3] * up[0] + out[4] * up[1] + out[5] * up[2]
        if rest > _TOLERANCE * _TOLERANCE or away > reach * reach or facing <= 0.0:
            found = -1
    if found < 0:
        found, weights, _ = search_nearest(tree, root, up, reach, -1, ENDLESS)
        if found >= 0:
            interpolate(tree, found, weights, out)
            found, _ = settle_foot(tree, root, up, found, 0.7, False, ENDLESS, out)
    note_foot(warm, found, root)
    return tree.order[found] if found >= 0 else -1


@uncounted
def find_meant(tree, place, up, reach, out):
    """The point of the surface that the hand means by a place (3,) on it or hardly off it.

    The nearest one on triangles that face up the handle, `up` (3,), near by first. In a fold the
    place may lie on one that does not; but a place a little under the surface of a thin wall, as
    between two events of a hasty hand, must not come out on the other side.
    Returns the triangle, or -1; `out` (6,) gets the point and the interpolated unit normal.
    """
    triangle = closest_point(tree, place, up, _NEAR * reach, out)
    if triangle < 0:
        down = (-up[0], -up[1], -up[2])
        triangle = closest_point(tree, place, down, _ON * reach, out)
    if triangle < 0:
        triangle = closest_point(tree, place, up, reach, out)
    return triangle


@kernel(error_model="numpy")
def settle_foot(tree, root, up, found, gain, follows, nodes, out):
    """Secant steps along the tangential residual, from the foot in `out` (6,), which is moved.

    Parameters
    ----------
    tree, root, up, out : as for `find_foot`
    found : int
        The triangle of that foot, in the tree's order.
    gain : float
        Of the first step: its length over that of the residual.
    follows : bool
        Whether searches start from the triangle found last.
    nodes : int
        As for `search_nearest`, of all searches together.

    Returns
    -------
    found, left : int
        The foot's triangle, and the nodes that were not looked at.
    """
    trial = np.empty(6)
    rx, ry, rz, residual = residual_of(root, out)
    for _ in range(_ITERATIONS):
        if residual <= _TOLERANCE * _TOLERANCE or nodes <= 0:
            break
        place = (out[0] + gain * rx, out[1] + gain * ry, out[2] + gain * rz)
        bound = gain * np.sqrt(residual) + 1e-3
        guess = found if follows else -1
        hit, weights, nodes = search_nearest(tree, place, up, bound, guess, nodes)
        if hit < 0:
            break
        interpolate(tree, hit, weights, trial)
        sx, sy, sz, rest = residual_of(root, trial)
        slope = (residual - (sx * rx + sy * ry + sz * rz)) / (gain * residual)
        if rest >= residual:
            gain *= 0.5
            if gain < 0.05:
                break
            continue
        gain = min(1.0, max(0.1, 1.0 / slope)) if slope > 0.0 else 0.7
        found = hit
        out[:] = trial
        rx, ry, rz, residual = sx, sy, sz, rest
    return found, nodes


@uncounted
def residual_of(root, foot):
    """Part of root - foot across the normal, and its square."""
    dx = root[0] - foot[0]
    dy = root[1] - foot[1]
    dz = root[2] - foot[2]
    along = dx * foot[3] + dy * foot[4] + dz * foot[5]
    rx = dx - along * foot[3]
    ry = dy - along * foot[4]
    rz = dz - along * foot[5]
    return rx, ry, rz, rx * rx + ry * ry + rz * rz


# ---- Order of leaves -----------------------------------------------------------------------------
# An order of points in which every half, quarter and so on of them lies together in a box.
#
# A heap-ordered tree over it has boxes that hardly overlap, unlike one over Morton order: halves of
# that end anywhere along the curve.


@kernel
def _select(centres, order, low, high, middle, axis):
    """Move the points [low, high) so that the least along the axis fill [low, middle).

    Of equal ones those with the lower numbers come first.
    """
    left, right = low, high - 1
    while left < right:
        at = (left + right) // 2
        pivot, number = centres[at, axis], order[at]
        i, j = left, right
        while i <= j:
            while centres[i, axis] < pivot or (centres[i, axis] == pivot and order[i] < number):
                i += 1
            while centres[j, axis] > pivot or (centres[j, axis] == pivot and order[j] > number):
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                for k in range(3):
                    centres[i, k], centres[j, k] = centres[j, k], centres[i, k]
                i += 1
                j -= 1
        if middle <= j:
            right = j
        elif middle >= i:
            left = i
        else:
            return


@kernel
def order_by_halving(centres, n_leaves, leaf_size, order):
    """Sort points into the leaves of a heap-ordered tree, halving boxes across their longest side.

    Parameters
    ----------
    centres : (T, 3) float32
        Sorted in place as well.
    n_leaves : int
        A power of two.
    leaf_size : int
        Points to each leaf; the leaves on the left are full.
    order : (T,) int32
        The points' numbers; sorted in place.
    """
    total = order.shape[0]
    size = n_leaves * leaf_size
    low_corner, high_corner = np.empty(3, np.float32), np.empty(3, np.float32)
    while size > leaf_size:
        half = size // 2
        for low in range(0, total, size):
            high = min(low + size, total)
            if high - low <= half:
                continue
            low_corner[:] = np.inf
            high_corner[:] = -np.inf
            for k in range(low, high):
                for axis in range(3):
                    value = centres[k, axis]
                    low_corner[axis] = min(low_corner[axis], value)
                    high_corner[axis] = max(high_corner[axis], value)
            axis = np.argmax(high_corner - low_corner)
            _select(centres, order, low, high, low + half, axis)
        size = half


# ---- Closest points and rays ---------------------------------------------------------------------
# Closest points and first hits of rays on the triangles of a mesh, front and back alike.
#
# The tree is the one above in the order of `order_by_halving`, with fewer
# triangles to a leaf. A tie is won by the triangle that comes first in the mesh: an answer depends
# on the mesh and the question alone.


FACES_PER_LEAF = 2

_AWRY = 1e-12  # of a normal's length: corner normals that cancel out
_CLOSE = 1.0 + 1e-12  # what rounding may add to a box's squared distance
_SLACK = 1e-12  # of a distance along a ray: what rounding may take from a box


@kernel(error_model="numpy")
def closest_on(points, a, b, c, x, y, z):
    """Weights v, w of the corners b, c at the point of triangle abc nearest to (x, y, z).

    Returns v, w and the squared distance; see `bvh.closest_weights`.
    """
    _, v, w = closest_weights(points, a, b, c, (x, y, z))
    ax = np.float64(points[a, 0])
    ay = np.float64(points[a, 1])
    az = np.float64(points[a, 2])
    dx = x - ax - v * (points[b, 0] - ax) - w * (points[c, 0] - ax)
    dy = y - ay - v * (points[b, 1] - ay) - w * (points[c, 1] - ay)
    dz = z - az - v * (points[b, 2] - az) - w * (points[c, 2] - az)
    return v, w, dx * dx + dy * dy + dz * dz


@kernel(error_model="numpy")
def _search(tree, x, y, z, nodes, away):
    """The leaf place of the triangle nearest to (x, y, z), and the weights of its b and c.

    `nodes` and `away` (64,) are room for the nodes yet to be seen and how far off they are.
    """
    boxes = tree.boxes
    n_leaves = boxes.shape[0] // 2
    depth = 0
    nodes[0] = 1
    away[0] = 0.0
    best = np.inf
    found = -1
    v = 0.0
    w = 0.0
    while depth >= 0:
        node = nodes[depth]
        if away[depth] > best * _CLOSE:
            depth -= 1
            continue
        depth -= 1
        while node < n_leaves:  # down to the nearest leaf
            near = 2 * node
            far = near + 1
            d2 = box_distance2(boxes, near, x, y, z)
            other = box_distance2(boxes, far, x, y, z)
            if other < d2:
                near, far = far, near
                d2, other = other, d2
            if other <= best * _CLOSE:
                depth += 1
                nodes[depth] = far
                away[depth] = other
            if d2 > best * _CLOSE:
                break
            node = near
        if node < n_leaves:
            continue
        first = (node - n_leaves) * FACES_PER_LEAF
        for k in range(first, min(first + FACES_PER_LEAF, tree.triangles.shape[0])):
            a = tree.triangles[k, 0]
            b = tree.triangles[k, 1]
            c = tree.triangles[k, 2]
            tv, tw, d2 = closest_on(tree.points, a, b, c, x, y, z)
            if d2 < best or found < 0 or (d2 == best and tree.order[k] < tree.order[found]):
                best = d2
                found = k
                v = tv
                w = tw
    return found, v, w


@kernel(error_model="numpy")
def find_closest(tree, queries, points, faces, weights, normals):
    """Find the nearest point of the surface to each of N points.

    Parameters
    ----------
    tree : ContactTree
    queries : (N, 3) float64
        mm.
    points : (N, 3) float64
        Filled with the nearest points, mm.
    faces : (N,) int64
        Filled with the triangles they lie on.
    weights : (N, 3) float64
        Filled with the weights of the triangles' corners there.
    normals : (N, 3) float64
        Filled with the interpolated unit normals; zero where the corner normals cancel out.

    Returns
    -------
    int
        How many normals are zero.
    """
    nodes, away = np.empty(_STACK, np.int64), np.empty(_STACK)
    cancelled = 0
    for i in range(queries.shape[0]):
        k, v, w = _search(tree, queries[i, 0], queries[i, 1], queries[i, 2], nodes, away)
        u = 1.0 - v - w
        faces[i] = tree.order[k]
        weights[i, 0] = u
        weights[i, 1] = v
        weights[i, 2] = w
        a = tree.triangles[k, 0]
        b = tree.triangles[k, 1]
        c = tree.triangles[k, 2]
        n = 0.0
        for axis in range(3):
            x = np.float64(tree.points[a, axis])
            points[i, axis] = x + v * (tree.points[b, axis] - x) + w * (tree.points[c, axis] - x)
            normals[i, axis] = (
                u * tree.normals[a, axis] + v * tree.normals[b, axis] + w * tree.normals[c, axis]
            )
            n += normals[i, axis] * normals[i, axis]
        n = np.sqrt(n)
        for axis in range(3):
            normals[i, axis] = normals[i, axis] / n if n >= _AWRY else 0.0
        cancelled += n < _AWRY
    return cancelled


@kernel(error_model="numpy")
def _enters(boxes, node, ray, best):
    """Whether a ray meets a box before `best`, in lengths of its direction."""
    near = 0.0
    far = best
    for axis in range(3):
        low = boxes[node, axis] - ray[axis]
        high = boxes[node, 3 + axis] - ray[axis]
        if low > high:  # of an empty node
            return False
        way = ray[3 + axis]
        if way == 0.0:
            if low > 0.0 or high < 0.0:
                return False
            continue
        first = min(low / way, high / way)
        last = max(low / way, high / way)
        near = max(near, first - _SLACK * abs(first))
        far = min(far, last + _SLACK * abs(last))
    return near <= far


@kernel(error_model="numpy")
def _crosses(points, a, b, c, ray):
    """Distance at which a ray meets triangle abc, in lengths of its direction; inf: it misses.

    The sides' volumes are those of the Plücker coordinates of ray and edge: two triangles see the
    edge between them with opposite signs, so no ray slips through. (One of 20,000 that are aimed
    right at a corner does: the volumes of all edges there are rounding.)
    """
    ax = points[a, 0] - ray[0]
    ay = points[a, 1] - ray[1]
    az = points[a, 2] - ray[2]
    bx = points[b, 0] - ray[0]
    by = points[b, 1] - ray[1]
    bz = points[b, 2] - ray[2]
    cx = points[c, 0] - ray[0]
    cy = points[c, 1] - ray[1]
    cz = points[c, 2] - ray[2]
    dx = ray[3]
    dy = ray[4]
    dz = ray[5]
    u = dx * (by * cz - bz * cy) + dy * (bz * cx - bx * cz) + dz * (bx * cy - by * cx)
    v = dx * (cy * az - cz * ay) + dy * (cz * ax - cx * az) + dz * (cx * ay - cy * ax)
    w = dx * (ay * bz - az * by) + dy * (az * bx - ax * bz) + dz * (ax * by - ay * bx)
    if not ((u >= 0.0 and v >= 0.0 and w >= 0.0) or (u <= 0.0 and v <= 0.0 and w <= 0.0)):
        return np.inf
    total = u + v + w  # 0 where the ray runs within the plane: t is NaN then
    x = (u * ax + v * bx + w * cx) / total
    y = (u * ay + v * by + w * cy) / total
    z = (u * az + v * bz + w * cz) / total
    t = (x * dx + y * dy + z * dz) / (dx * dx + dy * dy + dz * dz)
    return t if t >= 0.0 else np.inf


@kernel(error_model="numpy")
def find_hits(tree, rays, distances, faces):
    """Find where each of N rays first meets the surface, from whichever side.

    Parameters
    ----------
    tree : ContactTree
    rays : (N, 6) float64
        Origins, mm, and directions of any length.
    distances : (N,) float64
        Filled with the distances in lengths of the direction; inf where nothing is hit.
    faces : (N,) int64
        Filled with the triangles; -1 where nothing is hit.
    """
    n_leaves = tree.boxes.shape[0] // 2
    stack = np.empty(_STACK, np.int64)
    for i in range(rays.shape[0]):
        ray = rays[i]
        best = np.inf
        found = -1
        depth = 0
        stack[0] = 1
        while depth >= 0:
            node = stack[depth]
            depth -= 1
            if not _enters(tree.boxes, node, ray, best):
                continue
            if node < n_leaves:
                stack[depth + 1] = 2 * node + 1
                stack[depth + 2] = 2 * node
                depth += 2
                continue
            first = (node - n_leaves) * FACES_PER_LEAF
            for k in range(first, min(first + FACES_PER_LEAF, tree.triangles.shape[0])):
                corners = tree.triangles[k]
                t = _crosses(tree.points, corners[0], corners[1], corners[2], ray)
                if t < best or (t == best and found >= 0 and tree.order[k] < tree.order[found]):
                    best = t
                    found = k
        distances[i] = best
        faces[i] = tree.order[found] if found >= 0 else -1


# ---- Within a bounded time -----------------------------------------------------------------------
# Contact for a servo: the nearest point, the foot and the mean normal within a bounded time.
#
# A tree asked for the nearest of a million points that are all but equally far (the middle of a
# bowl) looks at most of them; a servo with a millisecond cannot. Every search counts down one
# budget of tree nodes, starts from the last foot, and gives the best found when the budget is
# spent.


_POOR = 0.1  # of the distance: a residual above it is no foot


@kernel(error_model="numpy")
def nearest_within(tree, place, up, reach, guess, work, out):
    """The point nearest to a place on triangles facing `up`, within reach and budget.

    Parameters
    ----------
    tree, place, up, reach, guess : as for `mesh.kernels.bvh.search_nearest`
    work : (1,) int64
        Tree nodes that may still be looked at; counted down.
    out : (6,) float64
        Gets the point and its interpolated unit normal.

    Returns
    -------
    int
        The triangle in the tree's order, or -1.
    """
    found, weights, left = search_nearest(tree, place, up, reach, guess, work[0])
    work[0] = left
    if found >= 0:
        interpolate(tree, found, weights, out)
    return found


@kernel(error_model="numpy")
def find_foot_within(tree, root, up, reach, warm, work, out):
    """The foot whose interpolated normal passes through the root; see `bvh.find_foot`.

    `warm` (5,) is that of `bvh.note_foot`; `out` (6,) holds the last foot. Returns the triangle in
    the tree's order, or -1.
    """
    found = -1
    if is_near(warm, root, reach):
        found, work[0] = settle_foot(tree, root, up, int(warm[1]), 1.0, True, work[0], out)
        residual = residual_of(root, out)[3]
        away = (root[0] - out[0]) ** 2 + (root[1] - out[1]) ** 2 + (root[2] - out[2]) ** 2
        facing = out[3] * up[0] + out[4] * up[1] + out[5] * up[2]
        if away > reach * reach or facing <= 0.0 or residual > _POOR * _POOR * away:
            found = -1
    if found < 0:
        guess = int(warm[1]) if warm[0] > 0.0 else -1
        found = nearest_within(tree, root, up, reach, guess, work, out)
        if found >= 0:
            found, work[0] = settle_foot(tree, root, up, found, 0.7, True, work[0], out)
    note_foot(warm, found, root)
    return found


@kernel(error_model="numpy")
def mean_normal(tree, foot, up, ahead, patch, guess, near, work):
    """The mean unit normal (3,) of the surface around the foot, a disc of radius `patch`.

    Places where the surface has ended or bent away count less and less, so that the mean does not
    jump at a rim. `ahead` (3,) is any direction that turns with the pen. `near` (S,) keeps the
    triangles found, plus 1, from step to step: from there on, the next search is short; the first
    time from `guess`, as for `nearest_within`.
    """
    nx, ny, nz = foot[3], foot[4], foot[5]
    along = ahead[0] * nx + ahead[1] * ny + ahead[2] * nz
    ex = ahead[0] - along * nx
    ey = ahead[1] - along * ny
    ez = ahead[2] - along * nz
    norm = np.sqrt(ex * ex + ey * ey + ez * ez)
    if norm < 1e-6:
        return nx, ny, nz
    ex /= norm
    ey /= norm
    ez /= norm
    fx = ny * ez - nz * ey
    fy = nz * ex - nx * ez
    fz = nx * ey - ny * ex
    there = np.empty(6)
    n_samples = near.shape[0]
    for i in range(n_samples):
        c = patch * np.cos(2.0 * np.pi * i / n_samples)
        s = patch * np.sin(2.0 * np.pi * i / n_samples)
        x = foot[0] + c * ex + s * fx
        y = foot[1] + c * ey + s * fy
        z = foot[2] + c * ez + s * fz
        begin = np.int64(near[i]) - 1 if near[i] > 0.0 else guess
        found = nearest_within(tree, (x, y, z), up, patch, begin, work, there)
        near[i] = found + 1
        if found < 0:
            continue
        d2 = (x - there[0]) ** 2 + (y - there[1]) ** 2 + (z - there[2]) ** 2
        weight = (1.0 - d2 / (patch * patch)) ** 2
        nx += weight * there[3]
        ny += weight * there[4]
        nz += weight * there[5]
    norm = np.sqrt(nx**2 + ny**2 + nz**2)
    return (nx / norm, ny / norm, nz / norm) if norm > 1e-9 else (nx, ny, nz)
