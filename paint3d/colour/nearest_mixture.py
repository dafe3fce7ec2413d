"""The mixture of a palette whose coat is nearest to a colour, by Kubelka-Munk theory.

A mixture has up to three pigments and water; nearness is the CIEDE2000 difference of a coat on a
given ground, and where a colour is given for it, also that of a wash. Every triple of the palette
is tried on a coarse grid, once for a palette and a ground; then the best few are refined on
shrinking grids around their best points.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from paint3d.colour.difference import delta_e, lab_from_reflectance, lab_from_srgb
from paint3d.colour.layers import SAUNDERSON, layer_reflectance, to_internal, to_measured
from paint3d.colour.pigments import WATER, Pigment, load_palette
from paint3d.colour.spectra import N_BANDS, srgb_from_reflectance
from paint3d.core.arrays import AnyArray, as_array
from paint3d.errors import InputError

__all__ = ["WASH_COATS", "Nearest", "nearest_mixture"]

WASH_COATS = 0.1
"""Coats of ink in a wash."""

_SPLITS = ((3, 3, 1), (3, 1, 3), (1, 3, 3), (8, 1, 1), (1, 8, 1), (1, 1, 8))
_INKED = (1.0, 0.5, 0.2, 0.08, 0.02)  # fraction that is not water
_BEST = 60  # triples that are refined
_ROUNDS, _FIRST, _KEPT = 30, 0.16, 0.75  # first step in the roots of the fractions
_LEAST = 0.0005  # of a coat: smaller amounts are left out


class Nearest(NamedTuple):
    """A mixture and its distance from the colour asked for.

    Attributes
    ----------
    parts : dict of Pigment to float
        Summing to 1, the largest first, with the water.
    difference : float
        CIEDE2000 between the colour asked for and a coat of it.
    srgb : (int, int, int)
        Of that coat, 0 to 255.
    wash_difference : float or None
        CIEDE2000 between the colour asked for and a wash of it; None where none was.
    wash_srgb : (int, int, int)
        Of that wash.
    """

    parts: dict[Pigment, float]
    difference: float
    srgb: tuple[int, int, int]
    wash_difference: float | None
    wash_srgb: tuple[int, int, int]


class _Wanted(NamedTuple):
    """L*a*b* (3,) of a coat, and of a wash or None, on a ground (31,)."""

    coat: AnyArray
    wash: AnyArray | None
    ground: AnyArray


def nearest_mixture(
    srgb: ArrayLike,
    ground: ArrayLike,
    pigments: Sequence[Pigment] | None = None,
    wash: ArrayLike | None = None,
) -> Nearest:
    """Find the mixture of up to three pigments and water whose coat is nearest to a colour.

    Parameters
    ----------
    srgb : (3,) uint8 or int
        0 to 255.
    ground : (31,) array_like
        Reflectance of the surface below.
    pigments : sequence of Pigment, optional
        Those available; by default the palette.
    wash : (3,) uint8 or int, optional
        Colour that `WASH_COATS` of it come near to besides; both count alike.

    Raises
    ------
    InputError
        If a colour or the ground is out of range, or there is no pigment.

    Notes
    -----
    About .1 s; the first time for a palette and a ground .4 s more.
    """
    below = as_array(ground, "ground", (N_BANDS,))
    if below.min() < 0.0 or below.max() > 1.0:
        raise InputError(
            "ground is {least:g} to {most:g}; expected 0 to 1",
            least=below.min(),
            most=below.max(),
        )
    inks = tuple(p for p in pigments or load_palette().values() if p is not WATER)
    if not inks:
        raise InputError("there is no pigment to mix; expected one or more")
    wanted = _Wanted(_lab_of(srgb), None if wash is None else _lab_of(wash), below)
    chosen, fractions, labs = _coarse_grid(inks, tuple(below.tolist()), 1.0)
    off = delta_e(labs, wanted.coat)
    if wanted.wash is not None:
        labs = _coarse_grid(inks, tuple(below.tolist()), WASH_COATS)[2]
        off = off + delta_e(labs, wanted.wash)
    off = off.reshape(-1, len(_SPLITS) * len(_INKED))
    at = off.argmin(axis=1) + off.shape[1] * np.arange(len(off))  # the best of every triple
    order = at[np.argsort(off.min(axis=1), kind="stable")[:_BEST]]
    which, roots = chosen[order], np.sqrt(fractions[order])
    which, roots = _refine(which, roots, inks, wanted)
    return _make_nearest(which, roots**2, inks, wanted)


def _lab_of(srgb: ArrayLike) -> AnyArray:
    codes = as_array(srgb, "sRGB", (3,))
    if codes.min() < 0.0 or codes.max() > 255.0:
        raise InputError(
            "sRGB is {codes}; expected three numbers from 0 to 255",
            codes=codes.tolist(),
        )
    return lab_from_srgb(codes / 255.0)


@lru_cache(maxsize=8)
def _coarse_grid(
    inks: tuple[Pigment, ...], ground: tuple[float, ...], coats: float
) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Return indices (N, 3), fractions of a coat (N, 3) and L*a*b* (N, 3) of the coarse grid."""
    n = len(inks)
    triples = list(itertools.combinations(range(n), 3)) or [(0, min(1, n - 1), min(1, n - 1))]
    splits = np.array(_SPLITS, np.float64)
    splits /= splits.sum(axis=1, keepdims=True)
    points = (np.array(_INKED)[:, None, None] * splits).reshape(-1, 3)
    chosen = np.repeat(np.array(triples), len(points), axis=0)
    fractions = np.tile(points, (len(triples), 1))
    lab = lab_from_reflectance(_film(chosen, fractions, inks, np.array(ground), coats))
    return chosen, fractions, lab


def _film(
    chosen: AnyArray, fractions: AnyArray, inks: Sequence[Pigment], ground: AnyArray, coats: float
) -> AnyArray:
    """Reflectance (N, 31) of films of mixtures: indices of inks (N, 3), fractions (N, 3)."""
    k, s = (np.array([getattr(ink, letter) for ink in inks]) for letter in "KS")
    weights = np.zeros((len(chosen), len(inks)))
    np.add.at(weights, (np.arange(len(chosen))[:, None], chosen), fractions)
    glossy = np.array([ink.saunderson for ink in inks])
    film = np.maximum(weights.sum(axis=1), 1e-12)  # some hold no paint
    glossy_fraction = weights[:, glossy].sum(axis=1) / film
    outer, inner = (loss * glossy_fraction[:, None] for loss in SAUNDERSON)
    below = np.maximum(to_internal(ground, outer, inner), 0.0)
    return to_measured(layer_reflectance(weights @ k, weights @ s, coats, below), outer, inner)


def _difference(
    chosen: AnyArray, fractions: AnyArray, inks: Sequence[Pigment], wanted: _Wanted
) -> AnyArray:
    """CIEDE2000 (N,) of mixtures from what is wanted, of coat and wash together."""

    def off(lab: AnyArray, coats: float) -> AnyArray:
        film = _film(chosen, fractions, inks, wanted.ground, coats)
        return delta_e(lab_from_reflectance(film), lab)

    coat = off(wanted.coat, 1.0)
    return coat if wanted.wash is None else coat + off(wanted.wash, WASH_COATS)


def _refine(
    chosen: AnyArray, roots: AnyArray, inks: Sequence[Pigment], wanted: _Wanted
) -> tuple[AnyArray, AnyArray]:
    """Descend from mixtures (N, 3) in the roots of their fractions; return the best one."""
    steps = np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=3)))
    reach = np.full(len(chosen), _FIRST)
    for _ in range(_ROUNDS):
        tried = np.maximum(roots[:, None] + reach[:, None, None] * steps, 0.0)
        whole = np.sqrt(np.maximum((tried**2).sum(axis=-1, keepdims=True), 1.0))
        tried /= whole  # no more than a coat
        flat = tried.reshape(-1, 3)
        off = _difference(np.repeat(chosen, len(steps), axis=0), flat**2, inks, wanted)
        off = off.reshape(tried.shape[:2])
        best = off.argmin(axis=1)
        moved = best != len(steps) // 2
        roots = tried[np.arange(len(tried)), best]
        reach = np.where(moved, reach * 0.9, reach * 0.7)
        order = np.argsort(off.min(axis=1), kind="stable")
        if len(order) > 6:  # drop those that fall behind
            order = order[: max(6, int(_KEPT * len(order)))]
        chosen, roots, reach = chosen[order], roots[order], reach[order]
    return chosen[0], roots[0]


def _make_nearest(
    chosen: AnyArray, fractions: AnyArray, inks: Sequence[Pigment], wanted: _Wanted
) -> Nearest:
    """Round a mixture, drop its traces, and measure the coat that is left."""
    summed: dict[Pigment, float] = {}
    for which, fraction in zip(chosen, fractions, strict=True):
        if fraction >= _LEAST:
            summed[inks[which]] = summed.get(inks[which], 0.0) + float(fraction)
    if not summed:
        summed[inks[chosen[int(np.argmax(fractions))]]] = _LEAST
    parts = dict(sorted(summed.items(), key=lambda part: -part[1]))
    water = 1.0 - sum(parts.values())
    parts = {ink: round(fraction, 4) for ink, fraction in parts.items()}
    if water > 1e-4:
        parts[WATER] = round(1.0 - sum(parts.values()), 4)
    indices = {ink: k for k, ink in enumerate(inks)}
    inked = [(indices[ink], fraction) for ink, fraction in parts.items() if ink is not WATER]
    rows, fractions = np.array([[k for k, _ in inked]]), np.array([[part for _, part in inked]])
    coat, wash = (_film(rows, fractions, inks, wanted.ground, coats) for coats in (1.0, WASH_COATS))
    off = float(delta_e(lab_from_reflectance(coat), wanted.coat)[0])
    wash_off = None
    if wanted.wash is not None:
        wash_off = float(delta_e(lab_from_reflectance(wash), wanted.wash)[0])
    return Nearest(parts, off, _codes(coat), wash_off, _codes(wash))


def _codes(film: AnyArray) -> tuple[int, int, int]:
    red, green, blue = (int(code) for code in srgb_from_reflectance(film)[0])
    return red, green, blue
