"""Black ink and red seals told apart: inks over each other add in density, -log10 of the light.

The density of every place is made of black and of red, neither less than none (least squares). Red
is the sheet's own: the mean direction of its most coloured places.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray

__all__ = ["Inks", "rubbed", "unmixed"]

_BLACK = np.ones(3) / np.sqrt(3.0)
_CINNABAR = np.array([0.08, 0.85, 0.75])  # densities in red, green and blue light
_COLOURED = 0.18  # by how much the density in green and blue exceeds that in red on a seal
_MOST_RED = 0.55  # of the density in green: in red light a red seal is hardly seen
_FEW = 2e-4  # of the sheet: fewer coloured pixels are no seal
_LEAST, _MOST = 4e-3, 1.25  # shares of the light


@dataclass(frozen=True, eq=False)
class Inks:
    """What lies on a sheet.

    Attributes
    ----------
    black, red : (H, W) float32
        Optical densities of the ink and of seals.
    """

    black: NDArray[np.float32]
    red: NDArray[np.float32]


def unmixed(reflected: NDArray[np.float32]) -> Inks:
    """Tell black ink from red.

    Parameters
    ----------
    reflected : (H, W, 3) float32
        As a share of the paper's light.
    """
    density = -np.log10(np.clip(reflected, _LEAST, _MOST))
    red_way = _red_of(density)
    # what a point of the plane of both directions is made of; off its wedge, of the nearer side
    ways = np.stack([_BLACK, red_way])
    inverse = np.linalg.pinv(ways).astype(np.float32)
    black, red = density @ inverse[:, 0], density @ inverse[:, 1]
    alone_black = np.maximum(density @ _BLACK.astype(np.float32), 0.0)
    alone_red = np.maximum(density @ red_way.astype(np.float32), 0.0)
    black, red = (
        np.where(red < 0.0, alone_black, np.where(black < 0.0, 0.0, black)),
        np.where(black < 0.0, alone_red, np.where(red < 0.0, 0.0, red)),
    )
    scale = np.float32(1.0 / np.sqrt(3.0))
    return Inks((black * scale).astype(np.float32), (red * scale).astype(np.float32))


def _red_of(density: AnyArray) -> NDArray[np.float64]:
    """The direction (3,) of the sheet's red, of length 1."""
    every = density[::2, ::2].reshape(-1, 3)
    other = np.minimum(every[:, 1], every[:, 2])
    coloured = every[(other - every[:, 0] > _COLOURED) & (every[:, 0] < _MOST_RED * other)]
    if len(coloured) < max(20.0, _FEW * len(every)):
        coloured = _CINNABAR[None]
    purest = coloured[:, 0] / np.minimum(coloured[:, 1], coloured[:, 2])
    mean = np.maximum(coloured[purest <= np.median(purest)].mean(axis=0), 0.0)
    result: NDArray[np.float64] = mean / np.linalg.norm(mean)
    return result


def rubbed(sheet: NDArray[np.float32]) -> Inks:
    """The white strokes of a rubbing as if they were ink: how far a place is from its black ground.

    Parameters
    ----------
    sheet : (H, W, 3) float32
        Linear light.
    """
    from scipy.ndimage import percentile_filter, zoom

    grey = np.sqrt(np.clip(sheet.mean(axis=2), 0.0, 1.0))
    step = max(1, round(max(grey.shape) / 150))
    small = grey[::step, ::step]
    window = max(3, round(0.15 * max(small.shape)))
    levels = []
    for percent in (25.0, 98.0):
        level = percentile_filter(small, percent, size=window)
        factor = np.array(grey.shape) / level.shape
        levels.append(zoom(level, factor, order=1, grid_mode=True, mode="nearest"))
    ground, white = levels
    white = np.maximum(white, ground + 0.35 * float(np.ptp(np.percentile(small, (5.0, 99.5)))))
    share = np.clip((grey - ground) / np.maximum(white - ground, 1e-3), 0.0, 1.2)
    return Inks(share.astype(np.float32), np.zeros_like(share, np.float32))
