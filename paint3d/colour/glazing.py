"""Wet paint over grounds that differ from vertex to vertex: dried layers, coloured meshes.

Always all 31 bands: dried paint is stored as the spectrum that it reflects, which is all that
Kubelka-Munk theory needs of a backing, so any number of layers composes exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.kernels.glazing import Glaze, Ground, dry_vertices, glazed_colours
from paint3d.colour.kernels.kubelka_munk import Shown, Wet
from paint3d.colour.layers import SAUNDERSON
from paint3d.colour.pigments import WATER, Pigment
from paint3d.colour.spectra import N_BANDS, rgb_weights, srgb_codes
from paint3d.core.arrays import AnyArray

__all__ = ["GlazeModel", "make_ground", "srgb_primaries"]

_TABLE = Path(__file__).parent / "data" / "srgb_spectra.csv"
_NO_RGB = np.empty((0, 3), np.float32)


@lru_cache(maxsize=1)
def srgb_primaries() -> AnyArray:
    """Return (31, 3) spectra of red, green and blue.

    Their sum weighted by a linear sRGB colour is a smooth reflectance in [0, 1] of that colour
    (Mallett, Yuksel: Spectral Primary Decomposition for Rendering with sRGB Reflectance, EGSR
    2019). It is linear: interpolated colours have the interpolated spectrum.
    """
    primaries = np.loadtxt(_TABLE, delimiter=",", skiprows=1)[:, 1:]
    primaries.flags.writeable = False
    return primaries


def make_ground(material: AnyArray) -> Ground:
    """The ground of a surface of one material on which nothing has dried."""
    return Ground(
        slots=np.empty(0, np.int32),
        spectra=np.empty((0, N_BANDS), np.uint16),
        linear_rgb=_NO_RGB,
        primaries=srgb_primaries().astype(np.float32),
        material=np.asarray(material, np.float32),
    )


class GlazeModel:
    """Colours and drying of vertices that carry some of P pigments over a `Ground`.

    Parameters
    ----------
    pigments : sequence of Pigment
        At least one; the columns of the amounts. A film has as much of Saunderson's correction
        as it holds of paint that was fitted with it, and takes the ground as seen through that.
    """

    def __init__(self, pigments: Sequence[Pigment]) -> None:
        strengths = [(p.K, p.S) for p in pigments]
        self._glaze = Glaze(
            np.ascontiguousarray(np.transpose(strengths, (2, 0, 1)), np.float32),
            np.ascontiguousarray(rgb_weights(), np.float32),
            np.array(SAUNDERSON, np.float32),
            np.array([(p is not WATER, p.saunderson) for p in pigments], np.float32),
        )

    def srgb(
        self,
        amounts: NDArray[np.float32],
        coverage: NDArray[np.float32],
        ground: Ground,
        out: NDArray[np.uint8],
        vertex_ids: NDArray[np.int32],
        linear_rgb: NDArray[np.float32] | None = None,
    ) -> None:
        """Fill `out` (V, 3), and `linear_rgb` (V, 3), for the vertices in `vertex_ids`."""
        rgb = _NO_RGB if linear_rgb is None else linear_rgb
        wet, shown = Wet(vertex_ids, amounts, coverage), Shown(srgb_codes(), rgb, out)
        glazed_colours(wet, self._glaze, ground, shown)

    def dry(
        self,
        amounts: NDArray[np.float32],
        coverage: NDArray[np.float32],
        ground: Ground,
        vertex_ids: NDArray[np.int32],
        rows: NDArray[np.int32],
    ) -> None:
        """Store in the rows of `ground.spectra` what the vertices reflect now."""
        dry_vertices(Wet(vertex_ids, amounts, coverage), self._glaze, ground, rows)
