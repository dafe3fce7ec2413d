"""Cracks: open edges that lie so near to other surface that a brush does not know of them.

Two halves of a body that were mirrored and never joined, a face whose long edge has a corner of
its neighbours in the middle: nothing says that such faces belong together, but paint goes over.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from paint3d.kernels.cells import find_pair, lookup

__all__ = ["link_cracks"]

_STEP = 0.25  # of a cell: places along an open edge


@njit(cache=True, nogil=True)
def link_cracks(
    points, triangles, radial, origin, size, table, places, cell_pairs, pair_root, pair_sheet,
    widest, links,
):  # fmt: skip
    """List links (n, 2) between sheets of a cell, one of which ends beside the other.

    Parameters
    ----------
    points, triangles, radial : arrays of `BaseSurface`
    origin, size, table, places, cell_pairs, pair_root, pair_sheet : arrays of the lattice
    widest : float
        Of a crack, mm.
    links : (N, 2) int32
        Filled as far as there is room; a link may come more than once.

    Returns
    -------
    int
        How many there are.
    """
    n = 0
    room = links.shape[0]
    place = np.empty(3)
    for h in range(radial.shape[0]):
        if radial[h] != h:
            continue
        t = h // 3
        a = triangles[t, h % 3]
        b = triangles[t, (h % 3 + 1) % 3]
        length = 0.0
        for axis in range(3):
            length += (np.float64(points[b, axis]) - np.float64(points[a, axis])) ** 2
        steps = max(1, int(np.ceil(np.sqrt(length) / (_STEP * size))))
        for k in range(steps):
            share = (k + 0.5) / steps
            for axis in range(3):
                place[axis] = (1.0 - share) * points[a, axis] + share * points[b, axis]
            cell = lookup(
                table,
                places,
                int(np.floor((place[0] - origin[0]) / size)),
                int(np.floor((place[1] - origin[1]) / size)),
                int(np.floor((place[2] - origin[2]) / size)),
            )
            own = find_pair(cell_pairs, pair_root, cell, t) if cell >= 0 else -1
            if own < 0:
                continue
            sheet = pair_sheet[own]
            for other in range(cell_pairs[cell], cell_pairs[cell + 1]):
                if pair_sheet[other] == sheet:
                    continue
                if _away2(points, triangles, pair_root[other], place) > widest * widest:
                    continue
                if n < room:
                    links[n, 0] = sheet
                    links[n, 1] = pair_sheet[other]
                n += 1
    return n


@njit(cache=True, nogil=True)
def _away2(points, triangles, t, place):
    """Square of a place's distance from a triangle: from its plane inside it, else from an edge."""
    nx, ny, nz = 0.0, 0.0, 0.0
    inside = True
    nearest = np.inf
    first = triangles[t, 0]
    ux = np.float64(points[triangles[t, 1], 0]) - points[first, 0]
    uy = np.float64(points[triangles[t, 1], 1]) - points[first, 1]
    uz = np.float64(points[triangles[t, 1], 2]) - points[first, 2]
    vx = np.float64(points[triangles[t, 2], 0]) - points[first, 0]
    vy = np.float64(points[triangles[t, 2], 1]) - points[first, 1]
    vz = np.float64(points[triangles[t, 2], 2]) - points[first, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    norm = np.sqrt(nx * nx + ny * ny + nz * nz)
    height = 0.0
    for corner in range(3):
        a = triangles[t, corner]
        b = triangles[t, (corner + 1) % 3]
        ex = np.float64(points[b, 0]) - points[a, 0]
        ey = np.float64(points[b, 1]) - points[a, 1]
        ez = np.float64(points[b, 2]) - points[a, 2]
        px, py, pz = place[0] - points[a, 0], place[1] - points[a, 1], place[2] - points[a, 2]
        long2 = ex * ex + ey * ey + ez * ez
        share = min(1.0, max(0.0, (px * ex + py * ey + pz * ez) / long2)) if long2 > 0.0 else 0.0
        dx, dy, dz = px - share * ex, py - share * ey, pz - share * ez
        nearest = min(nearest, dx * dx + dy * dy + dz * dz)
        sx, sy, sz = ey * pz - ez * py, ez * px - ex * pz, ex * py - ey * px
        inside = inside and sx * nx + sy * ny + sz * nz >= 0.0
        height = px * nx + py * ny + pz * nz
    if inside and norm > 0.0:
        return (height / norm) ** 2
    return nearest
