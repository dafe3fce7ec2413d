"""Cracks: open edges that lie so near to other surface that a brush does not know of them.

Two halves of a body that were mirrored and never joined, a face whose long edge has a corner of
its neighbours in the middle: nothing says that such faces belong together, but paint goes over.
"""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.mesh.kernels.closest_points import closest_on
from paint3d.mesh.kernels.grid import find_cell, sheet_of

__all__ = ["link_cracks"]

_STEP = 0.25  # of a cell: places along an open edge


@kernel
def _length(points, start, end):
    """How far apart two vertices lie, mm."""
    length = 0.0
    for axis in range(3):
        length += (np.float64(points[end, axis]) - np.float64(points[start, axis])) ** 2
    return np.sqrt(length)


@kernel
def link_cracks(points, triangles, radial, cells, widest, links):
    """List links (n, 2) between sheets of a cell, one of which ends beside the other.

    Parameters
    ----------
    points, triangles, radial : arrays of `BaseSurface`
    cells : Cells
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
    capacity = links.shape[0]
    place = np.empty(3)
    for h in range(radial.shape[0]):
        if radial[h] != h:
            continue
        t = h // 3
        start = triangles[t, h % 3]
        end = triangles[t, (h % 3 + 1) % 3]
        steps = max(1, int(np.ceil(_length(points, start, end) / (_STEP * cells.cell_size))))
        for k in range(steps):
            share = (k + 0.5) / steps
            for axis in range(3):
                place[axis] = (1.0 - share) * points[start, axis] + share * points[end, axis]
            cell = find_cell(cells, place[0], place[1], place[2])
            sheet = sheet_of(cells, cell, t) if cell >= 0 else -1
            if sheet < 0:
                continue
            for other in range(cells.cell_pairs[cell], cells.cell_pairs[cell + 1]):
                if cells.pair_sheet[other] == sheet:
                    continue
                a, b, c = triangles[cells.pair_root[other]]
                _v, _w, away2 = closest_on(points, a, b, c, place[0], place[1], place[2])
                if away2 > widest * widest:
                    continue
                if n < capacity:
                    links[n, 0] = sheet
                    links[n, 1] = cells.pair_sheet[other]
                n += 1
    return n
