"""Small pictures of the layers: the paint of each over the bare object, from the front or above."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["layer_pictures"]

_FLAT = 0.05  # thickness over length of what is seen from above
_MARGIN = 0.04  # of the picture, around the object


def layer_pictures(surface: PaintedSurface, size: int) -> list[NDArray[np.uint8]]:
    """Draw what is on each layer.

    Parameters
    ----------
    surface : PaintedSurface
    size : int
        Pixels along a side.

    Returns
    -------
    list of (size, size, 4) uint8
        sRGB and how dense, the first row at the top; of the lowest layer first.
    """
    stack, glaze = surface.use_layers(), surface.glaze
    pictures = [np.zeros((size, size, 4), np.uint8) for _ in range(len(stack))]
    if glaze is None:
        return pictures
    vertices = surface.paint_mesh.vertices
    base = vertices[: surface.paint_mesh.n_base_vertices]
    low, high = base.min(axis=0), base.max(axis=0)
    extent = (high - low).astype(np.float64)
    down = 1 if extent[2] < _FLAT * extent.max() else 2  # which axis goes up in the picture
    scale = (1.0 - 2.0 * _MARGIN) * size / max(extent[0], extent[down], 1e-9)
    for k, picture in enumerate(pictures):
        ids, codes = stack.colours_alone(glaze, k)
        if len(ids):
            off = vertices[ids].astype(np.float64) - 0.5 * (low + high)
            column = np.clip(0.5 * size + scale * off[:, 0], 0, size - 1).astype(np.int64)
            row = np.clip(0.5 * size - scale * off[:, down], 0, size - 1).astype(np.int64)
            _fill_pixels(picture, row * size + column, codes)
    return pictures


def _fill_pixels(picture: NDArray[np.uint8], at: AnyArray, codes: AnyArray) -> None:
    """Give pixels (N,) the mean of the colours (N, 3) that fall on each."""
    size = picture.shape[0] * picture.shape[1]
    count = np.bincount(at, minlength=size)
    painted = count > 0
    flat = picture.reshape(size, 4)
    for channel in range(3):
        total = np.bincount(at, codes[:, channel].astype(np.float64), minlength=size)
        flat[painted, channel] = np.rint(total[painted] / count[painted])
    flat[painted, 3] = 255
