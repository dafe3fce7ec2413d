"""Sheets: the connected pieces of surface in each cell, their measures and their links."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.mesh.kernels.mesh_arrays import find_cell, find_pair, lookup, sheet_of
from paint3d.mesh.kernels.topology import find_root

__all__ = [
    "INFLATION",
    "fill_pairs",
    "gather_links",
    "link_sheets",
    "locate_vertices",
    "measure_sheets",
    "split_sheets",
]

# ---- Triangles and cells -------------------------------------------------------------------------
# Which triangles meet which cells of the lattice.


INFLATION = 1e-3  # of the cell's size: cells are met a little early, so rounding cannot lose one


@kernel
def _minus(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@kernel
def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def _parts(axis, a, b, c, half):
    """Whether an axis (3,) separates a triangle, relative to the cube's centre, from the cube."""
    x, y, z = axis
    at_a = a[0] * x + a[1] * y + a[2] * z
    at_b = b[0] * x + b[1] * y + b[2] * z
    at_c = c[0] * x + c[1] * y + c[2] * z
    r = half * (abs(x) + abs(y) + abs(z))
    return min(at_a, min(at_b, at_c)) > r or max(at_a, max(at_b, at_c)) < -r


@kernel
def _triangle_meets_box(tri, x, y, z, half):
    """Separating axes of a triangle (3, 3) and a cube (Akenine-Moller 2001)."""
    a = (tri[0, 0] - x, tri[0, 1] - y, tri[0, 2] - z)
    b = (tri[1, 0] - x, tri[1, 1] - y, tri[1, 2] - z)
    c = (tri[2, 0] - x, tri[2, 1] - y, tri[2, 2] - z)
    for axis in range(3):
        least = min(a[axis], min(b[axis], c[axis]))
        most = max(a[axis], max(b[axis], c[axis]))
        if least > half or most < -half:
            return False
    ab, bc, ca = _minus(b, a), _minus(c, b), _minus(a, c)
    if _parts(_cross(ab, bc), a, b, c, half):
        return False
    for x, y, z in (ab, bc, ca):
        if (
            _parts((0.0, -z, y), a, b, c, half)
            or _parts((z, 0.0, -x), a, b, c, half)
            or _parts((-y, x, 0.0), a, b, c, half)
        ):
            return False
    return True


@kernel
def fill_pairs(points, triangles, origin, size, places, roots):
    """List the (lattice place, triangle) pairs that meet, as many as there is room for.

    Returns how many there are.
    """
    n = 0
    capacity = roots.shape[0]
    tri = np.empty((3, 3))
    low = np.empty(3, np.int64)
    high = np.empty(3, np.int64)
    half = size * (0.5 + INFLATION)
    for t in range(triangles.shape[0]):
        for axis in range(3):
            least = np.inf
            most = -np.inf
            for corner in range(3):
                p = np.float64(points[triangles[t, corner], axis])
                tri[corner, axis] = p
                least = min(least, p)
                most = max(most, p)
            low[axis] = int(np.floor((least - origin[axis]) / size - INFLATION))
            high[axis] = int(np.floor((most - origin[axis]) / size + INFLATION))
        single = low[0] == high[0] and low[1] == high[1] and low[2] == high[2]
        for i in range(low[0], high[0] + 1):
            x = origin[0] + (i + 0.5) * size
            for j in range(low[1], high[1] + 1):
                y = origin[1] + (j + 0.5) * size
                for k in range(low[2], high[2] + 1):
                    z = origin[2] + (k + 0.5) * size
                    if not single and not _triangle_meets_box(tri, x, y, z, half):
                        continue
                    if n < capacity:
                        places[n, 0] = i
                        places[n, 1] = j
                        places[n, 2] = k
                        roots[n] = t
                    n += 1
    return n


# --------------------------------------------------------------------------------------------------


@kernel
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


@kernel
def split_sheets(points, triangles, radial, cells):
    """Number the sheets: triangles of a cell joined by an edge that passes through the cell.

    Of `Cells` the fields pair_sheet and cell_sheets are filled. Returns the number of sheets; they
    are numbered cell by cell, in the order of their first triangle.
    """
    origin, size, places = cells.origin, cells.cell_size, cells.cell_place
    cell_pairs, pair_root, pair_sheet = cells.cell_pairs, cells.pair_root, cells.pair_sheet
    half = size * (0.5 + INFLATION)
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
                            u = find_root(parent, p)
                            v = find_root(parent, pair_of[g // 3])
                            if u < v:
                                parent[v] = u
                            else:
                                parent[u] = v
                    g = radial[g]
        cells.cell_sheets[c] = n_sheets
        for p in range(cell_pairs[c], cell_pairs[c + 1]):
            r = find_root(parent, p)
            if r == p:
                pair_sheet[p] = n_sheets
                n_sheets += 1
            else:
                pair_sheet[p] = pair_sheet[r]
    cells.cell_sheets[places.shape[0]] = n_sheets
    return n_sheets


@kernel
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


@kernel
def measure_sheets(points, normals, triangles, cells, area, normal, centre):
    """Area, area times mean normal, and centre of every sheet, by clipping triangles to cells."""
    origin, size, places = cells.origin, cells.cell_size, cells.cell_place
    cell_pairs, pair_root, pair_sheet = cells.cell_pairs, cells.pair_root, cells.pair_sheet
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


@kernel
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


@kernel
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


@kernel
def link_sheets(cells, root_pairs, pair_order, pair_cell, links):
    """List links (n, 2) between sheets of neighbouring cells that share a triangle.

    `pair_order` lists the pairs triangle by triangle, `root_pairs` is each triangle's run in it,
    `pair_cell` says which of the `Cells` each pair is of. As many are listed as there is room for;
    returns how many there are.
    """
    table, places, pair_sheet = cells.table, cells.cell_place, cells.pair_sheet
    n = 0
    capacity = links.shape[0]
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
                        if n < capacity:
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
                q = find_pair(cells.cell_pairs, cells.pair_root, d, t)
                if q >= 0:
                    if n < capacity:
                        links[n, 0] = pair_sheet[p]
                        links[n, 1] = pair_sheet[q]
                    n += 1
    return n


@kernel
def gather_links(links, n_sheets):
    """Turn links (n, 2) into a graph: runs (S + 1,) and neighbours, which rise within each run.

    Each link is there once in either direction, however often it is listed.
    """
    ends = np.zeros(n_sheets + 1, np.int64)
    for k in range(len(links)):
        ends[links[k, 0] + 1] += 1
        ends[links[k, 1] + 1] += 1
    for sheet in range(n_sheets):
        ends[sheet + 1] += ends[sheet]
    places, listed = ends[:-1].copy(), np.empty(2 * len(links), np.int32)
    for k in range(len(links)):
        for one in range(2):
            sheet = links[k, one]
            listed[places[sheet]] = links[k, 1 - one]
            places[sheet] += 1
    runs = np.zeros(n_sheets + 1, np.int64)
    n = 0
    for sheet in range(n_sheets):
        first = n
        for k in range(ends[sheet], ends[sheet + 1]):  # few are different
            other, at = listed[k], n
            while at > first and listed[at - 1] > other:
                at -= 1
            if at > first and listed[at - 1] == other:
                continue
            for moved in range(n, at, -1):
                listed[moved] = listed[moved - 1]
            listed[at] = other
            n += 1
        runs[sheet + 1] = n
    return runs, listed[:n].copy()


@kernel
def locate_vertices(points, root_of, cells, found, sheets):
    """Find the cell and the sheet of every base vertex, given one triangle of each."""
    for v in range(points.shape[0]):
        found[v] = find_cell(cells, points[v, 0], points[v, 1], points[v, 2])
        sheets[v] = sheet_of(cells, found[v], root_of[v])
