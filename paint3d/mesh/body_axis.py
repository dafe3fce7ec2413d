"""The vertical axis of an object's body, whatever sticks out of that at one side.

The box around a mug with a handle has its middle between the two. Cut level, the mug is its wall at
every height and the handle a smaller piece beside it, but for the heights at which they meet.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray

__all__ = ["find_axis"]

_SECTIONS = 32
_ALIKE = 1e-5  # of the object's size: ends of a section's segments that are nearer are one
_MIDDLE = 0.02  # of the width: an axis so near to the middle of the box is there


def find_axis(vertices: AnyArray, faces: AnyArray, bounds: AnyArray) -> tuple[float, float]:
    """Find where the vertical axis of a body is: x and y, mm.

    The median over the middles of the largest pieces of level sections, large ones counting for
    more. Of what is alike on all sides it is the middle of the box, to the last bit.

    Parameters
    ----------
    vertices : (V, 3) float32
        mm.
    faces : (F, 3) int
    bounds : (2, 3) float64
        Lowest and highest corner, mm.
    """
    low, high = bounds
    x, y, _ = (0.5 * (low + high)).tolist()
    a, b, c = (vertices[faces[:, k], 2] for k in range(3))
    foot, top = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    middles, sizes = [], []
    for fraction in (np.arange(_SECTIONS) + 0.5) / _SECTIONS:
        height = np.float32(low[2] + fraction * (high[2] - low[2]))
        cut = np.flatnonzero((foot < height) & (top >= height))
        if len(cut):
            piece = _largest_piece(vertices, faces[cut], bounds, height)
            middles.append(0.5 * piece.sum(axis=0))
            sizes.append(np.linalg.norm(piece[1] - piece[0]))
    if not middles:
        return x, y
    axis = [_median(along, np.array(sizes)) for along in np.array(middles).T]
    away = np.hypot(axis[0] - x, axis[1] - y)
    return (x, y) if away <= _MIDDLE * max(high[:2] - low[:2]) else (axis[0], axis[1])


def _largest_piece(
    vertices: AnyArray, cut: AnyArray, bounds: AnyArray, height: np.float32
) -> NDArray[np.float64]:
    """Lowest and highest corner (2, 2) of the largest piece of the section of faces (F, 3)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    edges = np.stack([cut, np.roll(cut, -1, axis=1)], axis=2)  # (F, 3, 2)
    below = vertices[edges, 2] < height
    crossing = below[..., 0] != below[..., 1]  # two of each face, in its order
    edges = np.where(below[..., :1], edges, edges[..., ::-1])[crossing]
    start, end = (vertices[edges[:, k]].astype(np.float64) for k in range(2))
    fraction = (float(height) - start[:, 2]) / (end[:, 2] - start[:, 2])
    ends = start[:, :2] + fraction[:, None] * (end - start)[:, :2]
    size = float(np.ptp(bounds, axis=0).max())
    at = np.rint((ends - bounds[0, :2]) / (_ALIKE * size)).astype(np.int64)
    found, node = np.unique(at @ np.array([round(2.0 / _ALIKE), 1]), return_inverse=True)
    node, n = node.reshape(-1, 2), len(found)
    links = coo_array((np.ones(len(node)), (node[:, 0], node[:, 1])), (n, n))
    n_pieces, piece = connected_components(links, directed=False)
    lowest, highest = np.full((n_pieces, 2), np.inf), np.full((n_pieces, 2), -np.inf)
    of_end = piece[node.ravel()]
    np.minimum.at(lowest, of_end, ends)
    np.maximum.at(highest, of_end, ends)
    k = int(np.linalg.norm(highest - lowest, axis=1).argmax())
    return np.stack([lowest[k], highest[k]])


def _median(values: AnyArray, weights: AnyArray) -> float:
    order = np.argsort(values, kind="stable")
    passed = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(passed, 0.5 * passed[-1])]])
