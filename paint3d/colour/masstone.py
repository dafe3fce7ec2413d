"""K and S of a pigment of which only the reflectance of an opaque layer is known.

Kubelka-Munk gives K/S = (1 - R)^2 / 2R there and nothing about S. We guess one S for all
wavelengths, scaled so that a full coat hides 98 %: good for pigments that scatter strongly
(vermilion is missed by 1.5 dE00), bad for dyes and strong blues (Prussian blue by 17).
"""

from __future__ import annotations

import numpy as np

from paint3d.colour.kernels.kubelka_munk import layer_bands
from paint3d.colour.pigment import BANDS_NM
from paint3d.core.types import AnyArray

__all__ = ["HIDING", "masstone_strengths"]

HIDING = 0.98
"""Luminance of a full coat over black by that over a white chart."""
_CHART = 0.8


def masstone_strengths(reflectance: AnyArray) -> tuple[AnyArray, AnyArray]:
    """K and S (31,) per full coat from the reflectance (31,) of an opaque layer, in (0, 1)."""
    from scipy.optimize import brentq  # a third of a second, and the shipped tables have K and S

    k = (1.0 - reflectance) ** 2 / (2.0 * reflectance)
    s = np.ones_like(k)
    weights = _luminous_efficiency()

    def excess(log_scale: float) -> float:
        scale = np.exp(log_scale)
        black, white = (weights @ _film(k * scale, s * scale, ground) for ground in (0.0, _CHART))
        result: float = black / white - HIDING
        return result

    scale = np.exp(brentq(excess, -12.0, 12.0, xtol=1e-12))
    return k * scale, s * scale


def _film(k: AnyArray, s: AnyArray, ground: float) -> AnyArray:
    reflected, alone, through = (np.empty(k.size) for _ in range(3))
    layer_bands(k, s, np.ones_like(k), np.full_like(k, ground), reflected, alone, through)
    return reflected


def _luminous_efficiency() -> AnyArray:
    """CIE 1931 y-bar (31,) by the two-lobe fit of Wyman, Sloan, Shirley (JCGT 2(2), 2013)."""

    def lobe(peak: float, left: float, right: float) -> AnyArray:
        t = (BANDS_NM - peak) * np.where(peak > BANDS_NM, left, right)
        return np.exp(-0.5 * t * t)

    return 0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322)
