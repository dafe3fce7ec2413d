"""The pores of a surface from place to place: its grain, its fibres, and the glue that dried there.

Glue of ink that has dried closes pores: a later stroke's water goes on more slowly there, and needs
to stand higher to get in at all, so it is pushed back at an earlier stroke's border. How much
stands for how many coats is set by eye.

A sheet's fibres lie in flocs, denser and thinner places of all sizes up to many times a fibre's
length (Provatas, Alava, Ala-Nissila, *Phys. Rev. E* 54, R36, 1996, for light paper). Where it is
dense water has to stand higher to go on, and goes more slowly: so the front stops along these, and
its outline is rough on all scales. Strengths are such that it is as rough as measured wet fronts in
paper, of exponent .63 (Buldyrev et al., *Phys. Rev. A* 45, R8313, 1992).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.materials import Material
from paint3d.core.arrays import AnyArray
from paint3d.surface.kernels.grain import fill_grain

__all__ = [
    "Pores",
    "capacity_of",
    "close_pores",
    "fibre_relief",
    "film_of",
    "find_pores",
    "mobility_of",
]

# ---- Fibres --------------------------------------------------------------------------------------
# The fibres of a sheet: streaks of noise in space, along which its pores lead further.
#
# A sheet of paper is felted of fibres a few millimetres long that lie in all directions. Water runs
# along them first, so ink feathers in fine points instead of round bumps. Here several noises, each
# drawn out along a direction of its own, lie over one another, and the strongest counts: a place in
# space has the same fibres on any mesh. The directions are spread evenly, and space is bent a
# little before, so that no direction comes back.


_DIRECTIONS = 12
_LONG = 8.0  # times as long as broad
_BENDS_MM, _BENT = 4.0, 0.6  # how far apart space is bent, and by how much of it
_USUAL, _SPAN = 0.74, 0.12  # of the strongest of so many noises: middle, and twice its deviation
_ASKEW = np.array([0.3, 0.5, 0.8])


def _frames() -> NDArray[np.float64]:
    """(K, 3, 3) rows: along each direction, even over a half sphere, and across it."""
    i = np.arange(_DIRECTIONS) + 0.5
    turn, z = np.pi * (1.0 + 5.0**0.5) * i, 1.0 - i / _DIRECTIONS
    flat = np.sqrt(1.0 - z * z)
    along = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])
    across = np.cross(along, _ASKEW)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return np.stack([along, across, np.cross(along, across)], axis=1)


_FRAMES = _frames()


def fibre_relief(points: NDArray[np.float64], width_mm: float) -> NDArray[np.float64]:
    """How far points (N, 3), mm, lie on fibres so broad: 1 on one, -1 between them, mean near 0."""
    bent = points.copy()
    height = np.empty(len(points))
    for axis in range(3):
        fill_grain(points + 31.7 * axis, _BENDS_MM, height)
        bent[:, axis] += _BENT * _BENDS_MM * (height - 0.5)
    strongest = np.zeros(len(points))
    scale = np.array([_LONG * width_mm, width_mm, width_mm])
    for k, frame in enumerate(_FRAMES):
        fill_grain(np.ascontiguousarray(bent @ frame.T / scale + 7.7 * k), 1.0, height)
        np.maximum(strongest, height, out=strongest)
    relief: NDArray[np.float64] = np.clip((strongest - _USUAL) / _SPAN, -1.0, 1.0)
    return relief


# --------------------------------------------------------------------------------------------------


_GRAIN_MM = 1.2  # bumps of the paper that ink runs around
_GRAIN_OF_PORES = 1.5  # of the residual, per unit of the material's grain
_GRAIN_OF_WAYS = 2.0  # of the conductance
_FIBRES_OF_WAYS = 1.4  # logarithm of the conductance there
_FLOCS = (1.2, 0.3), (2.4, 0.8), (4.8, 1.0)  # mm apart; of the residual, per unit of the grain
_FLOCS_MEAN = 0.07  # of them all, so that water goes as far as in an even sheet
_FLOCS_OF_WAYS = 1.0  # logarithm of the conductance that is lost, per that of the residual
_ELSEWHERE = 13.1  # mm: no two sizes of flocs begin at one place
_UNDER_FIBRES = 0.35  # of the bumps that are left where there are fibres
_FIBRE_MM = 0.3  # width of the bundles of fibres that are seen
_SHEET_MM = 0.12  # pores that are no deeper are those of a sheet, which is felted of fibres
_SHEET_UM, _BODY_UM = 12.0, 6.0  # width of the pores of a sheet, and of clay or plaster
_SHOWN = (0.7, 1.2)  # spacing of the vertices, mm, from which on fibres fade, and at which none are
_SIEVE = 2.8  # saturation at which pores let all soot pass, per unit of 1 less `passing`
_FIBRES_OF_SIEVE = 0.5  # logarithm of the potential that it takes: fibres' pores are wide
_GLUE = 0.25  # coats of dried ink that close half of what can be closed
_GLUE_OF_WAYS = 0.9  # of the conductance, at most
_GLUE_OF_ENTRY = 0.85  # of the way from the advance saturation to full pores, at most
_FULL = 0.98
_LEAST_MM = 0.012  # of a film on what has no pores: what glue that thickens holds where it is
_FILM_MM2_S = 0.3  # least diffusivity of a film of water: a few hundredths of a mm level in seconds
_POOL_MM = 0.25  # depth of a pool at which its border goes on over what sheds water
_SHEDS = (0.6, 0.9)  # advance saturations from which on, and at which, that is so


def capacity_of(drink: Material) -> float:
    """Depth of water that the pores hold, mm, above 0."""
    return max(drink.pores_mm, _LEAST_MM)


def film_of(drink: Material) -> float:
    """Diffusivity of a film of water on full pores, mm2/s."""
    return max(drink.spread_mm2_s, _FILM_MM2_S)


def mobility_of(drink: Material, grain_um: AnyArray) -> NDArray[np.float64]:
    """What pores let pass of grains of diameters (P,), um, over what they do of soot, 0 to 1.

    A sphere keeps its radius away from the walls of a pore, and goes with what flows beyond that:
    of those that fill a share k of its width 1 - (k (2 - k))^2 get through (Ferry, *J. Gen.
    Physiol.* 20, 1936), and none that is wider. The widths are set by eye.
    """
    width = _SHEET_UM if drink.pores_mm <= _SHEET_MM else _BODY_UM
    away = np.minimum(grain_um / width, 1.0)
    result: NDArray[np.float64] = 1.0 - (away * (2.0 - away)) ** 2
    return result


class Pores(NamedTuple):
    """What `find_pores` finds of each place (N,) float64; see `WetPatch`."""

    residual: NDArray[np.float64]
    strength: NDArray[np.float64]
    sieve: NDArray[np.float64]
    held: NDArray[np.float64]
    ways: NDArray[np.float64]


def find_pores(points: AnyArray, drink: Material, spacing: float) -> Pores:
    """Pores without glue at points (N, 3), mm, of vertices that lie so far apart, mm."""
    height = np.empty(len(points))
    fill_grain(points, _GRAIN_MM, height)
    bump, fibres = drink.grain * (2.0 * height - 1.0), _find_fibres(points, drink, spacing)
    relief = _GRAIN_OF_PORES * bump
    if fibres is not None:
        bump *= _UNDER_FIBRES
        relief = drink.grain * _find_flocs(points)
    residual = np.clip(drink.residual * (1.0 + relief), 0.0, 0.95)
    strength = capacity_of(drink) * drink.spread_mm2_s * (1.0 - residual) / 3.0
    held = capacity_of(drink) * np.maximum(residual, drink.advance * (1.0 + relief))
    sieve = strength * np.clip(_SIEVE * (1.0 - drink.passing), 0.0, 1.0) ** 3
    ways = np.maximum(0.05, 1.0 + _GRAIN_OF_WAYS * bump)
    if fibres is not None:
        sieve *= np.exp(-_FIBRES_OF_SIEVE * drink.grain * fibres)
        ways *= np.exp(_FIBRES_OF_WAYS * drink.grain * fibres - _FLOCS_OF_WAYS * relief)
    return Pores(residual, strength, sieve, held, ways)


def close_pores(
    pores: Pores, drink: Material, glue: AnyArray
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """What so many coats of dried ink (N,) leave of them.

    Returns
    -------
    held, entry, ways : (N,) float64
        Depth to which a dry place fills before water goes on, mm; the potential that this takes;
        the share of the conductance.
    """
    closed = glue / (glue + _GLUE)
    depth = capacity_of(drink)
    full = _FULL * depth
    held = pores.held + _GLUE_OF_ENTRY * closed * np.maximum(0.0, full - pores.held)
    s = np.clip((held / depth - pores.residual), 0.0, 1.0)
    s = np.minimum(1.0, s / (1.0 - pores.residual))
    low, high = _SHEDS
    sheds = np.clip((drink.advance - low) / (high - low), 0.0, 1.0) if drink.pores_mm else 1.0
    pinned = film_of(drink) * _POOL_MM * sheds
    return held, pores.strength * s**3 + pinned, pores.ways * (1.0 - _GLUE_OF_WAYS * closed)


def _find_flocs(points: AnyArray) -> AnyArray:
    """How much denser than the mean a sheet is at points (N, 3)."""
    denser, height = np.full(len(points), _FLOCS_MEAN), np.empty(len(points))
    for k, (apart_mm, strength) in enumerate(_FLOCS):
        fill_grain(points + _ELSEWHERE * k, apart_mm, height)
        denser += strength * (2.0 * height - 1.0)
    return denser


def _find_fibres(points: AnyArray, drink: Material, spacing: float) -> AnyArray | None:
    """How far points (N, 3) lie on fibres of the sheet, 0 where none show; None of no sheet."""
    fade, gone = _SHOWN
    if not 0.0 < drink.pores_mm <= _SHEET_MM:
        return None
    if spacing >= gone:
        return np.zeros(len(points))
    relief = fibre_relief(points, max(_FIBRE_MM, spacing))
    return relief * min(1.0, (gone - spacing) / (gone - fade))
