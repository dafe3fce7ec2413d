"""The single hairs of a tuft as lines, where the tuft's form in the picture has them.

Hairs stand in the ferrule as `paint3d.brush.bristles` places them; along the tuft each keeps its
place in the section, so that it follows the form's rings (`view.brush_shape`), bent, spread, parted
and laid on the surface as these are. A hair that is shorter than the longest ends above the tip.
"""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine.bristles.bend import Bristles
from paint3d.brush_engine.tuft import Tuft
from paint3d.core.types import AnyArray

__all__ = ["MOST_LINES", "SingleHairs"]

MOST_LINES = 400
"""Hairs that are drawn of more, evenly over the section."""

_STATIONS = 11  # points of a line
_CROWDED = 1.6  # towards the tip, where hairs bend most


class SingleHairs:
    """Lines for the hairs of one tuft.

    Parameters
    ----------
    tuft : Tuft
    bristles : Bristles
    around : int
        Points of a ring of the tuft's form.

    Attributes
    ----------
    count : int
        Lines that are drawn.
    line_mm : float
        How wide a line is, mm: as a hair, or as those that it stands for side by side.
    """

    def __init__(self, tuft: Tuft, bristles: Bristles, around: int) -> None:
        n = min(bristles.count, MOST_LINES)
        chosen = np.linspace(0.0, bristles.count - 1.0, n).round().astype(np.int64)
        a, b = (bristles.places[k].reshape(-1)[chosen] for k in range(2))
        lengths = bristles.lengths.reshape(-1)[chosen].astype(np.float64)
        self.count = n
        self.line_mm = 2.0 * float(bristles.hair_mm) * bristles.count / n
        out = np.hypot(a, b).astype(np.float64)[:, None]
        turn = np.mod(np.arctan2(b, a) / (2.0 * np.pi), 1.0) * around
        column = np.minimum(turn.astype(np.int64), around - 1)[:, None]
        beside, aside = (column + 1) % around, turn[:, None] - column
        arcs = tuft.arcs / tuft.length
        shares = np.linspace(0.0, 1.0, _STATIONS) ** _CROWDED
        self.arc = 1.0 - lengths[:, None] * (1.0 - shares)  # (n, S), from the tip
        place = np.interp(self.arc, arcs, np.arange(len(arcs), dtype=np.float64))
        row = np.minimum(place.astype(np.int64), len(arcs) - 2)
        up = place - row
        rim = [(row + k, c) for k in (0, 1) for c in (column, beside)]
        corners = np.stack([r * around + c for r, c in rim], axis=-1)
        weights = np.stack([w * v for w in (1.0 - up, up) for v in (1.0 - aside, aside)], axis=-1)
        self._corners, self._weights = corners, (out[..., None] * weights).astype(np.float32)
        self._rows = np.stack([row, row + 1], axis=-1)
        self._shares = np.stack([1.0 - up, up], axis=-1).astype(np.float32)
        self._inner = (1.0 - out).astype(np.float32)[..., None]

    def points(self, rings: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Points of the lines and the way out of the tuft there.

        Parameters
        ----------
        rings : (R, around, 3)
            The tuft's form, the tip's ring first, mm.

        Returns
        -------
        points : (n, S, 3) float32
            From tip to root, mm.
        outward : (n, S, 3) float32
            From the middle of the tuft, of length 1 at most.
        """
        flat = rings.reshape(-1, 3).astype(np.float32)
        middles = rings.mean(axis=1).astype(np.float32)
        middle = np.einsum("nsk,nskc->nsc", self._shares, middles[self._rows])
        rim = np.einsum("nsk,nskc->nsc", self._weights, flat[self._corners])
        points = rim + self._inner * middle
        apart = points - middle
        length = np.sqrt(np.einsum("nsc,nsc->ns", apart, apart))[..., None]
        return points, (1.0 - self._inner) * apart / np.maximum(length, 1e-6)
