"""The ink on vertices and in the brush as kernels see it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["TRANSFER", "InkField"]

TRANSFER = np.dtype(
    [
        ("pickup", "f8"),  # share of the wet ink under the brush that it takes up per mm, at pe = 1
        ("grain", "f8"),  # of the surface's material, 0 to 1
        ("capacity", "f8"),  # ink in a full brush, coats x mm2
        ("tooth_mm", "f8"),  # length of that surface's bumps, 0 for none
        ("reservoir_mm", "f8"),  # length of the tuft that one reservoir of its load stands for
    ],
    align=True,
)
"""What decides how ink passes between the brush and the surface."""


class InkField(NamedTuple):
    """What kernels need to leave ink on vertices (cap: room for vertices, P: pigments)."""

    amounts: NDArray  # (cap, P) float32, full coats x share of the vertex's area that is covered
    coverage: NDArray  # (cap,) float32, share of the vertex's area under paint, 0 to 1
    dirty: NDArray  # (cap,) uint8, 1 where the colour is out of date
    dirty_ids: NDArray  # (cap,) int32, those vertices
    n_dirty: NDArray  # (1,) int64, how many
    load: NDArray  # (P,) float64, ink in the brush, coats x mm2
    off_surface: NDArray  # (P,) float64, ink that ran off the surface, coats x mm2
    reservoirs: NDArray  # (N, P) float64, the load along the tuft, tip first; N = 1: alike all over
    transfer: NDArray  # (1,) of TRANSFER
    noise: NDArray  # (64^3,) int8, of the tooth: see `dry_contact.fill_noise`
    bundles: NDArray  # (2, 64^2) int32, and of bundles: see `dry_contact.bundle_noise`
