"""The lattice of cells that the surface meets, and the sheets of surface in them.

Cells are hashed: memory goes with the surface, not with the box around it. A sheet is a connected
piece of surface within a cell; the graph of sheets is what tells the two sides of a thin wall, or
two shells a millimetre apart, from one another (the patch of Guo 2017, Fig. 7, made safe).
"""

from __future__ import annotations

import numpy as np
from numba import njit

__all__ = [
    "build_table",
    "fill_pairs",
    "find_cell",
    "flood_patch",
    "link_sheets",
    "locate_vertices",
    "lookup",
    "measure_sheets",
    "sheet_of",
    "split_sheets",
]

_INFLATION = 1e-3  # of the cell's size: cells are met a little early, so rounding cannot lose one


@njit(cache=True, nogil=True)
def _hash(i, j, k):
    h = np.uint64(i) * np.uint64(0x9E3779B97F4A7C15)
    h ^= np.uint64(j) * np.uint64(0xC2B2AE3D27D4EB4F)
    h ^= np.uint64(k) * np.uint64(0x165667B19E3779F9)
    h ^= h >> np.uint64(32)
    return h


@njit(cache=True, nogil=True)
def build_table(places, table):
    """Fill the hash table (a power of two long, -1 everywhere) with the cells' places (C, 3)."""
    mask = np.uint64(table.shape[0] - 1)
    for c in range(places.shape[0]):
        slot = _hash(places[c, 0], places[c, 1], places[c, 2]) & mask
        while table[slot] >= 0:
            slot = (slot + np.uint64(1)) & mask
        table[slot] = c


@njit(cache=True, nogil=True)
def lookup(table, places, i, j, k):
    """The cell at a lattice place, or -1."""
    mask = np.uint64(table.shape[0] - 1)
    slot = _hash(i, j, k) & mask
    while table[slot] >= 0:
        c = table[slot]
        if places[c, 0] == i and places[c, 1] == j and places[c, 2] == k:
            return c
        slot = (slot + np.uint64(1)) & mask
    return -1


@njit(cache=True, nogil=True)
def find_cell(field, x, y, z):
    """The cell that holds a point (mm), or -1 where no surface is near."""
    size = field.numbers[1]
    i = int(np.floor((x - field.origin[0]) / size))
    j = int(np.floor((y - field.origin[1]) / size))
    k = int(np.floor((z - field.origin[2]) / size))
    return lookup(field.table, field.cell_place, i, j, k)


@njit(cache=True, nogil=True)
def sheet_of(field, cell, root):
    """The sheet that base triangle `root` belongs to in `cell`, or -1 if it does not meet it."""
    pair = find_pair(field.cell_pairs, field.pair_root, cell, root)
    return field.pair_sheet[pair] if pair >= 0 else -1


@njit(cache=True, nogil=True)
def find_pair(cell_pairs, pair_root, cell, root):
    """Index of the pair (cell, root), by bisection, or -1."""
    low = cell_pairs[cell]
    high = cell_pairs[cell + 1]
    while low < high:
        mid = (low + high) // 2
        if pair_root[mid] < root:
            low = mid + 1
        else:
            high = mid
    if low < cell_pairs[cell + 1] and pair_root[low] == root:
        return low
    return -1


@njit(cache=True, nogil=True)
def _axis_parts(ax, ay, az, bx, by, bz, cx, cy, cz, ux, uy, uz, half):
    """Whether the axis u separates the triangle (relative to the box's centre) from the box."""
    a = ax * ux + ay * uy + az * uz
    b = bx * ux + by * uy + bz * uz
    c = cx * ux + cy * uy + cz * uz
    r = half * (abs(ux) + abs(uy) + abs(uz))
    return min(a, min(b, c)) > r or max(a, max(b, c)) < -r


@njit(cache=True, nogil=True)
def _triangle_meets_box(tri, x, y, z, half):
    """Separating axes of a triangle (3, 3) and a cube (Akenine-Moller 2001)."""
    ax, ay, az = tri[0, 0] - x, tri[0, 1] - y, tri[0, 2] - z
    bx, by, bz = tri[1, 0] - x, tri[1, 1] - y, tri[1, 2] - z
    cx, cy, cz = tri[2, 0] - x, tri[2, 1] - y, tri[2, 2] - z
    if min(ax, min(bx, cx)) > half or max(ax, max(bx, cx)) < -half:
        return False
    if min(ay, min(by, cy)) > half or max(ay, max(by, cy)) < -half:
        return False
    if min(az, min(bz, cz)) > half or max(az, max(bz, cz)) < -half:
        return False
    ex, ey, ez = bx - ax, by - ay, bz - az
    fx, fy, fz = cx - bx, cy - by, cz - bz
    nx, ny, nz = ey * fz - ez * fy, ez * fx - ex * fz, ex * fy - ey * fx
    if _axis_parts(ax, ay, az, bx, by, bz, cx, cy, cz, nx, ny, nz, half):
        return False
    for edge in range(3):
        if edge == 0:
            dx, dy, dz = ex, ey, ez
        elif edge == 1:
            dx, dy, dz = fx, fy, fz
        else:
            dx, dy, dz = ax - cx, ay - cy, az - cz
        if _axis_parts(ax, ay, az, bx, by, bz, cx, cy, cz, 0.0, -dz, dy, half):
            return False
        if _axis_parts(ax, ay, az, bx, by, bz, cx, cy, cz, dz, 0.0, -dx, half):
            return False
        if _axis_parts(ax, ay, az, bx, by, bz, cx, cy, cz, -dy, dx, 0.0, half):
            return False
    return True


@njit(cache=True, nogil=True)
def fill_pairs(points, triangles, origin, size, places, roots):
    """List the (lattice place, triangle) pairs that meet; with empty lists only count them."""
    n = 0
    counting = roots.shape[0] == 0
    tri = np.empty((3, 3))
    low = np.empty(3, np.int64)
    high = np.empty(3, np.int64)
    half = size * (0.5 + _INFLATION)
    for t in range(triangles.shape[0]):
        for axis in range(3):
            least = np.inf
            most = -np.inf
            for corner in range(3):
                p = np.float64(points[triangles[t, corner], axis])
                tri[corner, axis] = p
                least = min(least, p)
                most = max(most, p)
            low[axis] = int(np.floor((least - origin[axis]) / size - _INFLATION))
            high[axis] = int(np.floor((most - origin[axis]) / size + _INFLATION))
        single = low[0] == high[0] and low[1] == high[1] and low[2] == high[2]
        for i in range(low[0], high[0] + 1):
            x = origin[0] + (i + 0.5) * size
            for j in range(low[1], high[1] + 1):
                y = origin[1] + (j + 0.5) * size
                for k in range(low[2], high[2] + 1):
                    z = origin[2] + (k + 0.5) * size
                    if not single and not _triangle_meets_box(tri, x, y, z, half):
                        continue
                    if not counting:
                        places[n, 0] = i
                        places[n, 1] = j
                        places[n, 2] = k
                        roots[n] = t
                    n += 1
    return n


@njit(cache=True, nogil=True)
def _segment_meets_box(points, a, b, x, y, z, half):
    """Whether the edge from vertex a to b meets the cube around (x, y, z)."""
    enter = 0.0
    leave = 1.0
    for axis, middle in ((0, x), (1, y), (2, z)):
        p = points[a, axis] - middle
        d = np.float64(points[b, axis]) - np.float64(points[a, axis])
        if d == 0.0:
            if abs(p) > half:
                return False
            continue
        s = (-half - p) / d
        t = (half - p) / d
        enter = max(enter, min(s, t))
        leave = min(leave, max(s, t))
    return enter <= leave


@njit(cache=True, nogil=True)
def _find(parent, i):
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@njit(cache=True, nogil=True)
def split_sheets(
    points, triangles, radial, origin, size, places, cell_pairs, pair_root, pair_sheet, cell_sheets
):
    """Number the sheets: triangles of a cell joined by an edge that passes through the cell.

    Returns the number of sheets; they are numbered cell by cell, in the order of their first
    triangle, so that `cell_sheets` (C + 1) is their run.
    """
    half = size * (0.5 + _INFLATION)
    parent = np.empty(pair_root.shape[0], np.int64)
    last_cell = np.full(triangles.shape[0], -1, np.int32)
    pair_of = np.empty(triangles.shape[0], np.int64)
    n_sheets = 0
    for c in range(places.shape[0]):
        x = origin[0] + (places[c, 0] + 0.5) * size
        y = origin[1] + (places[c, 1] + 0.5) * size
        z = origin[2] + (places[c, 2] + 0.5) * size
        for p in range(cell_pairs[c], cell_pairs[c + 1]):
            parent[p] = p
            last_cell[pair_root[p]] = c
            pair_of[pair_root[p]] = p
        for p in range(cell_pairs[c], cell_pairs[c + 1]):
            t = pair_root[p]
            for edge in range(3):
                g = radial[3 * t + edge]
                if g == 3 * t + edge:
                    continue
                met = -1
                while g != 3 * t + edge:
                    if last_cell[g // 3] == c:
                        if met < 0:
                            a = triangles[t, edge]
                            b = triangles[t, (edge + 1) % 3]
                            met = 1 if _segment_meets_box(points, a, b, x, y, z, half) else 0
                        if met == 1:
                            u = _find(parent, p)
                            v = _find(parent, pair_of[g // 3])
                            if u < v:
                                parent[v] = u
                            else:
                                parent[u] = v
                    g = radial[g]
        cell_sheets[c] = n_sheets
        for p in range(cell_pairs[c], cell_pairs[c + 1]):
            r = _find(parent, p)
            if r == p:
                pair_sheet[p] = n_sheets
                n_sheets += 1
            else:
                pair_sheet[p] = pair_sheet[r]
    cell_sheets[places.shape[0]] = n_sheets
    return n_sheets


@njit(cache=True, nogil=True)
def _clip(polygon, n, axis, bound, sign, out):
    """Keep the part of a polygon (n points) with sign * (coordinate - bound) <= 0."""
    m = 0
    for i in range(n):
        j = (i + 1) % n
        a = sign * (polygon[i, axis] - bound)
        b = sign * (polygon[j, axis] - bound)
        if a <= 0.0:
            out[m] = polygon[i]
            m += 1
        if (a < 0.0 and b > 0.0) or (a > 0.0 and b < 0.0):
            s = a / (a - b)
            for k in range(3):
                out[m, k] = polygon[i, k] + s * (polygon[j, k] - polygon[i, k])
            m += 1
    return m


@njit(cache=True, nogil=True)
def measure_sheets(
    points, normals, triangles, origin, size, places, cell_pairs, pair_root, pair_sheet,
    area, normal, centre,
):  # fmt: skip
    """Area, area times mean normal, and centre of every sheet, by clipping triangles to cells."""
    one = np.empty((12, 3))
    two = np.empty((12, 3))
    mid = np.empty(3)
    weights = np.empty(3)
    for c in range(places.shape[0]):
        for p in range(cell_pairs[c], cell_pairs[c + 1]):
            t = pair_root[p]
            s = pair_sheet[p]
            inside = True
            for corner in range(3):
                for axis in range(3):
                    q = np.float64(points[triangles[t, corner], axis])
                    one[corner, axis] = q
                    at = (q - origin[axis]) / size - places[c, axis]
                    inside = inside and 0.0 <= at <= 1.0
            n = 3
            if not inside:
                for axis in range(3):
                    low = origin[axis] + places[c, axis] * size
                    n = _clip(one, n, axis, low, -1.0, two)
                    n = _clip(two, n, axis, low + size, 1.0, one)
                if n < 3:
                    continue
            whole = _polygon(one, n, mid)
            if whole <= 0.0:
                continue
            _weights_at(points, triangles, t, mid, weights)
            area[s] += whole
            for axis in range(3):
                centre[s, axis] += whole * mid[axis]
            x, y, z = 0.0, 0.0, 0.0
            for corner in range(3):
                v = triangles[t, corner]
                x += weights[corner] * normals[v, 0]
                y += weights[corner] * normals[v, 1]
                z += weights[corner] * normals[v, 2]
            length = np.sqrt(x * x + y * y + z * z)
            if length > 0.0:
                normal[s, 0] += whole * x / length
                normal[s, 1] += whole * y / length
                normal[s, 2] += whole * z / length
    for s in range(area.shape[0]):
        if area[s] > 0.0:
            for axis in range(3):
                centre[s, axis] /= area[s]


@njit(cache=True, nogil=True)
def _polygon(polygon, n, mid):
    """Area of a plane polygon, and its centre."""
    whole = 0.0
    mid[:] = 0.0
    for i in range(1, n - 1):
        ux = polygon[i, 0] - polygon[0, 0]
        uy = polygon[i, 1] - polygon[0, 1]
        uz = polygon[i, 2] - polygon[0, 2]
        vx = polygon[i + 1, 0] - polygon[0, 0]
        vy = polygon[i + 1, 1] - polygon[0, 1]
        vz = polygon[i + 1, 2] - polygon[0, 2]
        x = uy * vz - uz * vy
        y = uz * vx - ux * vz
        z = ux * vy - uy * vx
        part = 0.5 * np.sqrt(x * x + y * y + z * z)
        whole += part
        for k in range(3):
            mid[k] += part * (polygon[0, k] + polygon[i, k] + polygon[i + 1, k]) / 3.0
    if whole > 0.0:
        for k in range(3):
            mid[k] /= whole
    return whole


@njit(cache=True, nogil=True)
def _weights_at(points, triangles, t, mid, weights):
    """Barycentric weights of a point of triangle t."""
    d00, d01, d11, d20, d21 = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        a = np.float64(points[triangles[t, 0], k])
        u = points[triangles[t, 1], k] - a
        v = points[triangles[t, 2], k] - a
        w = mid[k] - a
        d00 += u * u
        d01 += u * v
        d11 += v * v
        d20 += w * u
        d21 += w * v
    det = d00 * d11 - d01 * d01
    if det <= 0.0:
        weights[:] = 1.0 / 3.0
        return
    weights[1] = (d11 * d20 - d01 * d21) / det
    weights[2] = (d00 * d21 - d01 * d20) / det
    weights[0] = 1.0 - weights[1] - weights[2]


@njit(cache=True, nogil=True)
def link_sheets(
    table, places, root_pairs, pair_order, pair_cell, cell_pairs, pair_root, pair_sheet, links
):
    """List links (n, 2) between sheets of neighbouring cells that share a triangle.

    `pair_order` lists the pairs triangle by triangle, `root_pairs` is each triangle's run in it.
    With an empty list the links are only counted.
    """
    n = 0
    counting = links.shape[0] == 0
    for t in range(root_pairs.shape[0] - 1):
        first = root_pairs[t]
        last = root_pairs[t + 1]
        for a in range(first, last):
            p = pair_order[a]
            c = pair_cell[p]
            if last - first <= 8:
                for b in range(a + 1, last):
                    q = pair_order[b]
                    d = pair_cell[q]
                    near = True
                    for axis in range(3):
                        near = near and abs(places[c, axis] - places[d, axis]) <= 1
                    if near:
                        if not counting:
                            links[n, 0] = pair_sheet[p]
                            links[n, 1] = pair_sheet[q]
                        n += 1
                continue
            for step in range(14, 27):
                i = places[c, 0] + step // 9 - 1
                j = places[c, 1] + step // 3 % 3 - 1
                k = places[c, 2] + step % 3 - 1
                d = lookup(table, places, i, j, k)
                if d < 0:
                    continue
                q = find_pair(cell_pairs, pair_root, d, t)
                if q >= 0:
                    if not counting:
                        links[n, 0] = pair_sheet[p]
                        links[n, 1] = pair_sheet[q]
                    n += 1
    return n


@njit(cache=True, nogil=True)
def flood_patch(field, start, x, y, z, radius, stamps, tick, sheets):
    """Sheets reached from `start` through sheets whose cells meet the ball.

    Parameters
    ----------
    field : SurfaceField
    start : int
        The sheet to start from; it is taken wherever the ball is.
    x, y, z, radius : float
        The ball, mm.
    stamps : (S,) int64
        Set to `tick` for every sheet of the patch.
    tick : int
        A number not used before.
    sheets : (S,) int32
        Filled with the patch, nearest links first.

    Returns
    -------
    int
        Number of sheets in the patch.
    """
    return _flood(
        field.sheet_links, field.linked_sheet, field.sheet_place, field.origin,
        field.numbers[1], start, x, y, z, radius, stamps, tick, sheets,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def _flood(links, linked, places, origin, size, start, x, y, z, radius, stamps, tick, sheets):
    r2 = (radius / size) ** 2
    px = (x - origin[0]) / size
    py = (y - origin[1]) / size
    pz = (z - origin[2]) / size
    sheets[0] = start
    stamps[start] = tick
    n = 1
    at = 0
    while at < n:
        s = sheets[at]
        at += 1
        for link in range(links[s], links[s + 1]):
            other = linked[link]
            if stamps[other] == tick:
                continue
            i = np.float64(places[other, 0])
            j = np.float64(places[other, 1])
            k = np.float64(places[other, 2])
            dx = max(0.0, max(i - px, px - i - 1.0))
            dy = max(0.0, max(j - py, py - j - 1.0))
            dz = max(0.0, max(k - pz, pz - k - 1.0))
            if dx * dx + dy * dy + dz * dz > r2:
                continue
            stamps[other] = tick
            sheets[n] = other
            n += 1
    return n


@njit(cache=True, nogil=True)
def locate_vertices(
    points, root_of, origin, size, places, table, cell_pairs, pair_root, pair_sheet, cells, sheets
):
    """Find the cell and the sheet of every base vertex, given one triangle of each."""
    for v in range(points.shape[0]):
        i = int(np.floor((points[v, 0] - origin[0]) / size))
        j = int(np.floor((points[v, 1] - origin[1]) / size))
        k = int(np.floor((points[v, 2] - origin[2]) / size))
        c = lookup(table, places, i, j, k)
        cells[v] = c
        sheets[v] = pair_sheet[find_pair(cell_pairs, pair_root, c, root_of[v])]
