"""Longest-edge bisection where paint comes (Rivara 1984; terminal edges: Rivara 1997).

A triangle is only ever halved at its longest edge, together with all that share that edge, after
those of them that have a longer one. Ties are broken by a key that depends on positions alone, so
the triangles and vertices that a set of cells ends up with do not depend on the order in which
the cells were asked for, and a vertex in a finished cell never changes again: colour is never
interpolated. Areas are integers, halved exactly, for the same reason.

A vertex stands for what of each triangle lies nearest to it, where that triangle's circumcentre is
not outside (Meyer, Desbrun, Schroeder, Barr 2003, the mixed area). Halves of right triangles are
right ones, and on a lattice of them all areas are the same, which thirds of triangles are not: of
its vertices every second one is a corner of four, and every other of eight.
"""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel, uncounted
from paint3d.mesh.kernels.mesh_arrays import find_cell, find_pair, mix
from paint3d.mesh.kernels.paper import lay_paper_at

__all__ = [
    "BAD_LOG",
    "MOST_AROUND_EDGE",
    "NO_ROOM",
    "activate_cell",
    "edge_key",
    "longest_edges",
    "repeat_splits",
    "spread_areas",
]

NO_ROOM, BAD_LOG = -1, -2
MOST_AROUND_EDGE = 256  # triangles on one edge
_INFLATION = 1e-3  # of a cell's size
_OPPOSED = np.float32(1e-3)  # length of the sum of two unit normals


@uncounted
def edge_key(a, b):
    """Key of the edge between two vertices with keys a and b, whichever way round."""
    if a > b:
        a, b = b, a
    return mix(a * np.uint64(0x9E3779B97F4A7C15) + mix(b))


@uncounted
def _distance2(px, py, pz, a, b):
    x = np.float64(px[a]) - np.float64(px[b])
    y = np.float64(py[a]) - np.float64(py[b])
    z = np.float64(pz[a]) - np.float64(pz[b])
    return x * x + y * y + z * z


@uncounted
def _length2(field, a, b):
    return _distance2(field.px, field.py, field.pz, a, b)


@uncounted
def _longest_edge(field, a, b, c):
    """Which edge (0: ab, 1: bc, 2: ca) is longest; the greater key wins a tie."""
    best = 0
    length = _length2(field, a, b)
    key = edge_key(field.key[a], field.key[b])
    for edge in (1, 2):
        u = b if edge == 1 else c
        v = c if edge == 1 else a
        other = _length2(field, u, v)
        if other < length:
            continue
        other_key = edge_key(field.key[u], field.key[v])
        if other > length or other_key > key:
            best = edge
            length = other
            key = other_key
    return best


@uncounted(error_model="numpy")
def _corner_areas(px, py, pz, corners, t, area):
    """Divide the area of triangle t, a whole number, among its corners."""
    a, b, c = corners[t, 0], corners[t, 1], corners[t, 2]
    one = _distance2(px, py, pz, b, c)
    two = _distance2(px, py, pz, c, a)
    three = _distance2(px, py, pz, a, b)
    at_a, at_b, at_c = two + three - one, three + one - two, one + two - three
    square = one * at_a + two * at_b + three * at_c  # 16 times that of the area
    whole = np.float64(area)
    if at_a <= 0.0 or square <= 0.0:
        at_two = at_three = area >> 2
    elif at_b <= 0.0:
        at_two, at_three = area >> 1, area >> 2
    elif at_c <= 0.0:
        at_two, at_three = area >> 2, area >> 1
    else:
        at_two = np.int64(whole * ((three * at_c + one * at_a) / (2.0 * square)))
        at_three = np.int64(whole * ((one * at_a + two * at_b) / (2.0 * square)))
    return area - at_two - at_three, at_two, at_three


@uncounted
def spread_areas(px, py, pz, triangles, areas, out):
    """Add the areas (T,) int64 of triangles (T, 3) to what their corners stand for, (N,) int64."""
    for t in range(triangles.shape[0]):
        first, second, third = _corner_areas(px, py, pz, triangles, t, areas[t])
        out[triangles[t, 0]] += first
        out[triangles[t, 1]] += second
        out[triangles[t, 2]] += third


@uncounted
def longest_edges(field, out):
    """The longest edge of every root."""
    for t in range(out.shape[0]):
        a = field.node_vertices[t, 0]
        out[t] = _longest_edge(field, a, field.node_vertices[t, 1], field.node_vertices[t, 2])


@uncounted
def _relink(radial, old, new):
    """Put half-edge `new` in the place of `old` in its ring."""
    after = radial[old]
    if after == old:
        radial[new] = new
        return
    before = after
    while radial[before] != old:
        before = radial[before]
    radial[before] = new
    radial[new] = after


@uncounted
def _add_midpoint(field, a, b, root):
    """Append the vertex that halves the edge ab of a triangle of `root`; return its id."""
    v = field.counts[0]
    field.counts[0] += 1
    half = np.float32(0.5)
    field.px[v] = half * (field.px[a] + field.px[b])
    field.py[v] = half * (field.py[a] + field.py[b])
    field.pz[v] = half * (field.pz[a] + field.pz[b])
    x = field.nx[a] + field.nx[b]
    y = field.ny[a] + field.ny[b]
    z = field.nz[a] + field.nz[b]
    length = np.sqrt(x * x + y * y + z * z)
    first = a if field.key[a] < field.key[b] else b
    if length < _OPPOSED:  # no mean: the ends face away from each other
        x, y, z, length = field.nx[first], field.ny[first], field.nz[first], np.float32(1.0)
    scale = np.float32(1.0) / length
    field.nx[v] = x * scale
    field.ny[v] = y * scale
    field.nz[v] = z * scale
    field.key[v] = edge_key(field.key[a], field.key[b])
    field.parents[v, 0] = min(a, b)
    field.parents[v, 1] = max(a, b)
    field.area_units[v] = 0
    lay_paper_at(field, v)
    cell = find_cell(field, field.px[v], field.py[v], field.pz[v])
    if cell < 0:  # rounded out of the lattice, far from the origin
        cell = field.sheet_cell[field.vertex_sheet[first]]
    field.next_in_cell[v] = field.head[cell]
    field.head[cell] = v
    pair = find_pair(field.cell_pairs, field.pair_root, cell, root)
    field.vertex_sheet[v] = (
        field.pair_sheet[pair] if pair >= 0 else field.pair_sheet[field.cell_pairs[cell]]
    )
    return v


@uncounted
def _split_edge(field, h0, ring, mids):
    """Halve every triangle on the edge of half-edge h0, which is longest in each of them."""
    n = 0
    h = h0
    while True:
        ring[n] = h
        n += 1
        h = field.radial[h]
        if h == h0:
            break
    # one midpoint for every distinct pair of ends: both sides of a crease have their own
    n_mids = 0
    for i in range(n):
        t = ring[i] // 3
        a = field.node_vertices[t, ring[i] % 3]
        b = field.node_vertices[t, (ring[i] % 3 + 1) % 3]
        low, high = min(a, b), max(a, b)
        known = -1
        for j in range(n_mids):
            if field.parents[mids[j], 0] == low and field.parents[mids[j], 1] == high:
                known = mids[j]
        if known < 0:
            known = _add_midpoint(field, a, b, field.node_root[t])
            mids[n_mids] = known
            n_mids += 1
        mids[MOST_AROUND_EDGE + i] = known
    base = ring[0] // 3
    start_key = field.key[field.node_vertices[base, ring[0] % 3]]
    first_a, first_b, last_a, last_b = -1, -1, -1, -1
    for i in range(n):
        m = mids[MOST_AROUND_EDGE + i]
        left, right = _split_node(field, ring[i], m)
        a = field.node_vertices[ring[i] // 3, ring[i] % 3]
        same = field.key[a] == start_key
        half_a = 3 * left if same else 3 * right
        half_b = 3 * right if same else 3 * left
        if i == 0:
            first_a, first_b = half_a, half_b
        else:
            field.radial[last_a] = half_a
            field.radial[last_b] = half_b
        last_a, last_b = half_a, half_b
    field.radial[last_a] = first_a
    field.radial[last_b] = first_b


@uncounted
def _stand_for(field, t, sign):
    """Add a triangle's area to what its corners stand for, or subtract it (`sign` -1)."""
    corners = field.node_vertices
    parts = _corner_areas(field.px, field.py, field.pz, corners, t, field.node_area[t])
    for k in range(3):
        v = corners[t, k]
        field.area_units[v] += sign * parts[k]
        field.area[v] = field.area_units[v] * field.area_unit


@uncounted
def _split_node(field, h, m):
    """Halve a triangle at vertex m on its edge h % 3; return its children (a, m, c), (m, b, c)."""
    t = h // 3
    e = h % 3
    a = field.node_vertices[t, e]
    b = field.node_vertices[t, (e + 1) % 3]
    c = field.node_vertices[t, (e + 2) % 3]
    left = field.counts[1]
    right = left + 1
    field.counts[1] += 2
    field.child[t] = left
    half = field.node_area[t] >> 1
    for child in (left, right):
        field.child[child] = -1
        field.node_root[child] = field.node_root[t]
        field.node_area[child] = half
    field.node_vertices[left, 0] = a
    field.node_vertices[left, 1] = m
    field.node_vertices[left, 2] = c
    field.node_vertices[right, 0] = m
    field.node_vertices[right, 1] = b
    field.node_vertices[right, 2] = c
    _stand_for(field, t, -1)
    _stand_for(field, left, 1)
    _stand_for(field, right, 1)
    radial = field.radial
    radial[3 * left + 1] = 3 * right + 2
    radial[3 * right + 2] = 3 * left + 1
    _relink(radial, 3 * t + (e + 1) % 3, 3 * right + 1)
    _relink(radial, 3 * t + (e + 2) % 3, 3 * left + 2)
    field.longest[left] = _longest_edge(field, a, m, c)
    field.longest[right] = _longest_edge(field, m, b, c)
    return left, right


@uncounted
def _bisect(field, node, ring, mids):
    """Halve a leaf, and first whatever must be halved before it; False without room."""
    path = field.path
    depth = 0
    path[0] = node
    while depth >= 0:
        t = path[depth]
        if field.child[t] >= 0:
            depth -= 1
            continue
        h0 = 3 * t + field.longest[t]
        h = field.radial[h0]
        around = 1
        ready = True
        while h != h0:
            if field.longest[h // 3] != h % 3:
                depth += 1
                if depth == path.shape[0]:  # too long to remember: walk it again from here
                    depth = 1
                path[depth] = h // 3
                ready = False
                break
            around += 1
            h = field.radial[h]
        if not ready:
            continue
        if field.counts[0] + around > field.px.shape[0]:
            return False
        if field.counts[1] + 2 * around > field.child.shape[0]:
            return False
        _split_edge(field, h0, ring, mids)
        depth -= 1
    return True


@uncounted
def _misses(field, t, low, high):
    """Whether the box around a node lies outside the box low..high."""
    a = field.node_vertices[t, 0]
    b = field.node_vertices[t, 1]
    c = field.node_vertices[t, 2]
    x, y, z = field.px, field.py, field.pz
    return (
        max(x[a], max(x[b], x[c])) < low[0]
        or min(x[a], min(x[b], x[c])) > high[0]
        or max(y[a], max(y[b], y[c])) < low[1]
        or min(y[a], min(y[b], y[c])) > high[1]
        or max(z[a], max(z[b], z[c])) < low[2]
        or min(z[a], min(z[b], z[c])) > high[2]
    )


@kernel
def activate_cell(field, cell):
    """Refine until every leaf that meets the cell has edges no longer than wanted.

    Returns 0, or -1 where the arrays have no room; then the mesh is whole, and the same call goes
    on after `PaintMesh.reserve`.
    """
    if field.done[cell]:
        return 0
    h2 = field.resolution * field.resolution
    size = field.cell_size
    low = np.empty(3)
    high = np.empty(3)
    for axis in range(3):
        low[axis] = field.origin[axis] + (field.cell_place[cell, axis] - _INFLATION) * size
        high[axis] = low[axis] + (1.0 + 2.0 * _INFLATION) * size
    ring = np.empty(MOST_AROUND_EDGE, np.int64)
    mids = np.empty(2 * MOST_AROUND_EDGE, np.int64)
    stack = np.empty(256, np.int64)
    for pair in range(field.cell_pairs[cell], field.cell_pairs[cell + 1]):
        depth = 0
        stack[0] = field.pair_root[pair]
        while depth >= 0:
            t = stack[depth]
            depth -= 1
            if _misses(field, t, low, high):
                continue
            if field.child[t] < 0:
                e = field.longest[t]
                a = field.node_vertices[t, e]
                b = field.node_vertices[t, (e + 1) % 3]
                if _length2(field, a, b) <= h2:
                    continue
                if not _bisect(field, t, ring, mids):
                    return -1
            stack[depth + 1] = field.child[t]
            stack[depth + 2] = field.child[t] + 1
            depth += 2
    field.done[cell] = 1
    return 0


@kernel
def repeat_splits(field, log, at):
    """Bisect the nodes of `log` (n,) int32 from place `at[0]` on, where they are not yet halved.

    A log may come from a stranger, so each entry is checked before anything is changed: it must
    name a node there is, whose longest edge is longest in all triangles on that edge.

    Returns 0, NO_ROOM (reserve and call again), or BAD_LOG with the entry's place in `at`.
    """
    ring = np.empty(MOST_AROUND_EDGE, np.int64)
    mids = np.empty(2 * MOST_AROUND_EDGE, np.int64)
    while at[0] < log.shape[0]:
        t = log[at[0]]
        if t < 0 or t >= field.counts[1]:
            return BAD_LOG
        if field.child[t] >= 0:
            at[0] += 1
            continue
        h0 = 3 * t + field.longest[t]
        around = 1
        h = field.radial[h0]
        while h != h0:
            if field.longest[h // 3] != h % 3 or around == MOST_AROUND_EDGE:
                return BAD_LOG
            around += 1
            h = field.radial[h]
        if field.counts[0] + around > field.px.shape[0]:
            return NO_ROOM
        if field.counts[1] + 2 * around > field.child.shape[0]:
            return NO_ROOM
        _split_edge(field, h0, ring, mids)
        at[0] += 1
    return 0
