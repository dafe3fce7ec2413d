"""Layers of paint over a backing, spectrum by spectrum: mixing, glazing, gloss.

Wet paints mix: K and S add by their fractions of volume. Paint over dry paint glazes: the
reflectance of the dry layer is the backing of the next one. A glossy film's measured reflectance
also includes what its surface reflects on the way in and on the way out (Saunderson 1942); that
of a film of matt and glossy paints as much of it as it holds of glossy ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from paint3d.colour.kernels.kubelka_munk import layer_bands
from paint3d.colour.pigments import WATER, Pigment, load_pigment
from paint3d.colour.spectra import N_BANDS
from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.errors import InputError

__all__ = [
    "SAUNDERSON",
    "layer_reflectance",
    "mix_pigments",
    "mixture_reflectance",
    "stack_reflectance",
    "to_internal",
    "to_measured",
]

SAUNDERSON = (0.03, 0.5)
"""k1, k2: reflectance of the film's surface from outside and from inside."""


def layer_reflectance(
    absorption: ArrayLike, scattering: ArrayLike, coats: ArrayLike, backing: ArrayLike
) -> AnyArray:
    """Reflectance of a layer over a backing, element by element (docs/model.md, equation (14)).

    Parameters
    ----------
    absorption, scattering : array_like
        K and S per coat, >= 0.
    coats : array_like
        Thickness X, >= 0.
    backing : array_like
        Reflectance Rg of what lies below, in [0, 1].

    Returns
    -------
    ndarray
        R in [0, 1], f64, of the arguments' common shape.

    Raises
    ------
    InputError
        If a value is not finite or outside its range.
    """
    names = ("absorption", "scattering", "coats", "backing")
    given = [np.asarray(a) for a in (absorption, scattering, coats, backing)]
    checked = [
        as_array(a, n, (None,) * max(a.ndim, 1))
        for a, n in zip(map(np.atleast_1d, given), names, strict=True)
    ]
    for array, name in zip(checked, names, strict=True):
        high = 1.0 if name == "backing" else np.inf
        if array.size and not (array.min() >= 0 and array.max() <= high):
            worst = array.min() if array.min() < 0 else array.max()
            raise InputError(
                "{name} holds {worst:g}; expected 0 to {high:g}",
                name=name,
                worst=worst,
                high=high,
            )
    full = np.broadcast_arrays(*checked)
    reflected, alone, through = (np.empty(full[0].size) for _ in range(3))
    flat = [np.ascontiguousarray(array).reshape(-1) for array in full]
    layer_bands(*flat, reflected, alone, through)
    return reflected.reshape(np.broadcast_shapes(*(array.shape for array in given)))


def to_measured(internal: ArrayLike, outer: float, inner: float) -> AnyArray:
    """Measured reflectance, gloss included, of a film's internal reflectance.

    k1 + (1 - k1)(1 - k2) R / (1 - k2 R) with k1 = `outer`, k2 = `inner` (Saunderson 1942).
    """
    r = np.asarray(internal, dtype=np.float64)
    return outer + (1.0 - outer) * (1.0 - inner) * r / (1.0 - inner * r)


def to_internal(measured: ArrayLike, outer: float, inner: float) -> AnyArray:
    """Undo `to_measured`; below k1, darker than the gloss alone, the result is negative."""
    r = np.asarray(measured, dtype=np.float64) - outer
    return r / ((1.0 - outer) * (1.0 - inner) + inner * r)


def mix_pigments(
    parts: Mapping[str | Pigment, float], by_volume: bool = False
) -> tuple[AnyArray, AnyArray, float]:
    """K and S (31,) per coat of a wet mixture, and how glossy its film is.

    docs/model.md, equations (16) and (16a), for one coat.

    Parameters
    ----------
    parts : mapping
        How much of each pigment, by name or as `Pigment`, >= 0: g of paints that have a density,
        cm3 of others (all of the palette), or any multiple of both. The gloss is the fraction by
        volume, 0 to 1, of paints but water that were fitted with Saunderson's correction.
    by_volume : bool
        Whether parts of weighed paints are cm3 too, as in a brush.

    Raises
    ------
    UnknownNameError
        If a name is not in the palette or among the fitted paints.
    InputError
        If there is no paint, or a part is negative or not finite.
    """
    paints = [p if isinstance(p, Pigment) else load_pigment(p) for p in parts]
    volumes = np.array(
        [
            as_number(part, f"fraction of {p.name}", 0.0)
            / (1.0 if by_volume or p.density is None else p.density)
            for p, part in zip(paints, parts.values(), strict=True)
        ]
    )
    total = volumes.sum() if volumes.size else 0.0
    if not total > 0:
        raise InputError("the mixture holds no paint; expected a fraction above 0")
    volumes = volumes / total
    k = sum(v * p.K for v, p in zip(volumes, paints, strict=True))
    s = sum(v * p.S for v, p in zip(volumes, paints, strict=True))
    film = sum(v for v, p in zip(volumes, paints, strict=True) if p is not WATER)
    glossy = sum(v for v, p in zip(volumes, paints, strict=True) if p.saunderson)
    return k, s, float(glossy / film) if glossy else 0.0


def mixture_reflectance(
    parts: Mapping[str | Pigment, float],
    coats: float,
    backing: ArrayLike,
    saunderson: bool | None = None,
    by_volume: bool = False,
) -> AnyArray:
    """Reflectance (31,), 400-700 nm, as measured, of a mixed paint over a backing.

    Parameters
    ----------
    parts : mapping of name to part
        Names of the palette, whose parts are volume, or of the fitted drawdown paints, whose
        parts are mass; see `mix_pigments`.
    coats : float
        Thickness in full coats, >= 0; a drawdown is one.
    backing : (31,) array_like
        Reflectance of the surface below as measured, in [0, 1].
    saunderson : bool, optional
        Whether the film is glossy; by default as far as its paints were fitted so.
    by_volume : bool
        Whether parts of weighed paints are volume too, as in a brush.

    Raises
    ------
    UnknownNameError
        If a paint's name is unknown.
    InputError
        If a fraction, the thickness or the backing is not finite or outside its range.

    Notes
    -----
    Under gloss a backing darker than k1 = 0.03 counts as black. Mean error on the drawdowns that
    the paints were fitted to 1.2 dE00, on mixtures left out of the fit whose paints occur in
    other mixtures 1.0; blending RGB is wrong by 26. A paint known by a hiding film alone has an
    unknown strength: its tint is then missed by 10 (`scripts/fit_drawdowns.py`, docs/ink.md).
    """
    k, s, glossy = mix_pigments(parts, by_volume)
    return stack_reflectance(
        [(k, s, as_number(coats, "coats", 0.0))],
        backing,
        glossy if saunderson is None else float(saunderson),
    )


def stack_reflectance(
    layers: Sequence[tuple[ArrayLike, ArrayLike, float]], backing: ArrayLike, glossy: float = 0.0
) -> AnyArray:
    """Reflectance (31,) as measured of dry layers over a backing, the lowest first.

    Parameters
    ----------
    layers : sequence of (K (31,), S (31,), coats)
    backing : (31,) array_like
        As measured, in [0, 1].
    glossy : float
        How much of a gloss the top has and the backing was measured through, 0 to 1.

    Raises
    ------
    InputError
        If an argument has the wrong shape, is not finite or outside its range.
    """
    below = as_array(backing, "backing", (N_BANDS,))
    if below.min() < 0 or below.max() > 1:
        raise InputError(
            "backing is {least:g} to {most:g}; expected 0 to 1",
            least=below.min(),
            most=below.max(),
        )
    gloss = [glossy * loss for loss in SAUNDERSON]
    below = np.maximum(to_internal(below, *gloss), 0.0)
    for k, s, coats in layers:
        below = layer_reflectance(k, s, coats, below)
    return to_measured(below, *gloss)
