"""The light on a sheet taken out: what is left is how much of it the ink lets back.

The paper's own brightness is known wherever there is no ink. It is spread over the rest from near
by where paper is near, and from farther off where it is not, so that the edge of a shadow is
followed and the inside of a thick stroke is bridged.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray

__all__ = ["blur_matrix", "flattened"]

_SMALL = 360  # pixels of the longer side: light has no finer detail
_SEEN_AS_PAPER = 80.0  # per cent of a window's pixels that are darker, at first
_WINDOW = 0.12  # of the longer side
_NEAR = (0.008, 0.02, 0.06, 0.25)  # of the longer side: from where paper is taken, nearest first
_ENOUGH = 0.25  # of paper within that distance
_BLACK = 0.3  # of the light of bright paper around: darker than a shadow
_RED = 1.35  # times the paper's own red over green and blue: a seal
_NARROW = 0.05  # of the longer side: narrower dark places are ink, broader ones shadow
_DARKER = 0.9  # of the paper's light
_DARKEST = 1e-3


def flattened(sheet: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """What share of the paper's light every place of a sheet sends back.

    Parameters
    ----------
    sheet : (H, W, 3) float32
        Linear light.

    Returns
    -------
    (H, W, 3) float32
        1 on bare paper, 0 on the blackest ink.
    (h, w, 3) float32
        The paper's light, at a smaller size.
    """
    step = max(1, round(max(sheet.shape[:2]) / _SMALL))
    small = _means(sheet, step)
    paper = _spread(small, _is_paper(small), max(small.shape[:2]))
    whole = np.stack([_stretched(paper[..., k], sheet.shape[:2]) for k in range(3)], axis=-1)
    return np.clip(sheet / np.maximum(whole, _DARKEST), 1e-3, 1.25), paper


def _means(sheet: AnyArray, step: int) -> NDArray[np.float32]:
    """Means over blocks of so many pixels a side; the last ones may be cut."""
    height, width = (max(1, n // step) * step for n in sheet.shape[:2])
    blocks = sheet[:height, :width].reshape(height // step, step, width // step, step, 3)
    result: NDArray[np.float32] = blocks.mean(axis=(1, 3), dtype=np.float32)
    return result


def _stretched(plane: AnyArray, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """A plane at another size, linear between its pixels' middles."""
    from scipy.ndimage import map_coordinates

    rows = (np.arange(shape[0]) + 0.5) * plane.shape[0] / shape[0] - 0.5
    columns = (np.arange(shape[1]) + 0.5) * plane.shape[1] / shape[1] - 0.5
    at = np.stack(np.meshgrid(rows, columns, indexing="ij"))
    result: NDArray[np.float32] = map_coordinates(
        plane.astype(np.float32), at, order=1, mode="nearest", output=np.float32
    )
    return result


def _is_paper(small: AnyArray) -> NDArray[np.bool_]:
    """Places that no ink darkens: ink is very dark, or coloured, or narrow; a shadow is neither."""
    from scipy.ndimage import binary_dilation, grey_closing, median_filter, percentile_filter

    longest = max(small.shape[:2])
    grey = small.mean(axis=2)
    window = max(3, round(_WINDOW * longest / 3))
    top = percentile_filter(median_filter(grey[::3, ::3], 3), _SEEN_AS_PAPER, size=window)
    bright = np.maximum(_stretched(top, grey.shape), _DARKEST)
    warmth = small[..., 0] / np.maximum(np.minimum(small[..., 1], small[..., 2]), _DARKEST)
    lit = grey > 0.7 * bright
    usual = float(np.median(warmth[lit])) if lit.any() else 1.0
    inked = binary_dilation((grey < _BLACK * bright) | (warmth > _RED * usual), np.ones((3, 3)))
    bridged = _spread(grey[..., None], ~inked, longest)[..., 0]
    filled = np.where(inked, bridged, grey)
    size = max(3, round(_NARROW * longest))
    closed = grey_closing(filled, size=(size, size), mode="nearest")
    result: NDArray[np.bool_] = ~binary_dilation(grey < _DARKER * closed) & ~inked
    return result


def _spread(small: AnyArray, is_paper: AnyArray, longest: int) -> NDArray[np.float32]:
    """The light of places that are paper, spread over all: normalized blurs, nearest first."""
    weight = is_paper.astype(np.float32)
    if not weight.any():
        weight[:] = 1.0
    total = np.zeros(small.shape, np.float32)
    left = np.ones(small.shape[:2], np.float32)
    for k, share in enumerate(_NEAR):
        sigma = max(0.7, share * longest)
        down, across = (blur_matrix(n, sigma) for n in small.shape[:2])
        there = (down @ weight @ across.T).astype(np.float32)
        trust = left if k == len(_NEAR) - 1 else left * np.clip(there / _ENOUGH, 0.0, 1.0)
        for channel in range(small.shape[2]):
            seen = (down @ (small[..., channel] * weight) @ across.T).astype(np.float32)
            total[..., channel] += trust * seen / np.maximum(there, 1e-6)
        left = left - trust
    return total


def blur_matrix(n: int, sigma: float) -> NDArray[np.float64]:
    """What each of n pixels in a row has of each when they are blurred by a Gaussian.

    The row is mirrored at its ends. The widest blur here reaches over all pixels there are: picture
    by picture, tap by tap, it would cost 2.7 times as much.

    Parameters
    ----------
    n : int
    sigma : float
        Pixels.

    Returns
    -------
    (n, n) float64
        Each row sums to 1.
    """
    from scipy.ndimage import gaussian_filter1d

    result: NDArray[np.float64] = gaussian_filter1d(np.eye(n), sigma, axis=0)
    return result
