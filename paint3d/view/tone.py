"""Between sRGB bytes and linear light (IEC 61966-2-1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.spectra import decode_srgb
from paint3d.core.types import AnyArray

__all__ = ["linear_to_srgb", "srgb_to_linear"]

_LINEAR = decode_srgb(np.arange(256, dtype=np.uint8)).astype(np.float32)


def srgb_to_linear(srgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return linear light in [0, 1] for sRGB bytes of any shape."""
    return _LINEAR[srgb]


def linear_to_srgb(linear: AnyArray) -> AnyArray:
    """Return sRGB in [0, 1] for linear light in [0, 1] of any shape."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
