"""Spatial variation of a surface's pores: grain, fibres, and the glue that has dried in them.

Glue of dried ink clogs pores: a later stroke's water runs more slowly there, and needs to stand
higher to enter at all, so it is pushed back at an earlier stroke's border. How many coats clog how
much is set by eye. The table of words is that of `surface.kernels.wet_step`.

A sheet's fibres lie in flocs, denser and thinner regions of all sizes up to many times a fibre's
length (Provatas, Alava, Ala-Nissila, *Phys. Rev. E* 54, R36, 1996, for light paper). Where the
sheet is dense, water has to stand higher to enter, and runs more slowly: the front stops
along dense regions, and its outline is rough on all scales. Strengths are chosen to make it as
rough as measured wet fronts in paper, of exponent .63 (Buldyrev et al., *Phys. Rev. A* 45, R8313,
1992).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.materials import SHEET_MM, Material
from paint3d.core.arrays import AnyArray
from paint3d.surface.kernels.grain import fill_grain

__all__ = [
    "Pores",
    "capacity_of",
    "clog_pores",
    "entry_ratio_of",
    "even_exp",
    "fibre_frames",
    "fibre_relief",
    "film_of",
    "find_pores",
    "mobility_of",
    "sieve_of",
]

# ---- The same on all machines --------------------------------------------------------------------

_LN2_HIGH, _LN2_LOW = float.fromhex("0x1.62e42feep-1"), float.fromhex("0x1.a39ef35793c76p-33")
_TERMS = 14


def even_exp(x: AnyArray) -> NDArray[np.float64]:
    """Return e to the power of x (N,), -700 to 700, to a unit of the last digit.

    NumPy's differs in last bits between processors, and from a browser's: this one is made of sums
    and products alone, which nobody rounds otherwise. `web/src/surface/pores.ts` has the same.
    """
    k = np.floor(x * (1.0 / (_LN2_HIGH + _LN2_LOW)) + 0.5)
    r = (x - k * _LN2_HIGH) - k * _LN2_LOW
    series = np.ones_like(r)
    for n in range(_TERMS, 0, -1):
        series = 1.0 + series * r / n
    result: NDArray[np.float64] = np.ldexp(series, k.astype(np.int32))
    return result


# ---- Fibres --------------------------------------------------------------------------------------
# The fibres of a sheet: streaks of solid noise along which water runs farther.
#
# A sheet of paper is felted of fibres a few millimetres long that lie in all directions. Water runs
# along them first, so ink feathers in fine points instead of round bumps. The streaks are the
# maximum of several noises, each stretched along a direction of its own; being functions of the
# position in space, they are the same on any mesh. The directions are evenly spread, and space is
# warped slightly first, so that no direction is recognisable.


_DIRECTIONS = 12
_LONG = 8.0  # length of a streak over its width
_BENDS_MM, _BENT = 4.0, 0.6  # size of the bumps of the warp, and its strength as a fraction of it
_USUAL, _SPAN = 0.74, 0.12  # of the maximum of so many noises: mean, and twice its deviation
_ASKEW = np.array([0.3, 0.5, 0.8])  # along none of the directions


def fibre_frames() -> NDArray[np.float64]:
    """Return (K, 3, 3) frames whose first rows are evenly spread over a half sphere."""
    i = np.arange(_DIRECTIONS) + 0.5
    turn, z = np.pi * (1.0 + 5.0**0.5) * i, 1.0 - i / _DIRECTIONS  # Fibonacci lattice
    flat = np.sqrt(1.0 - z * z)
    along = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])
    across = np.cross(along, _ASKEW)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return np.stack([along, across, np.cross(along, across)], axis=1)


_FRAMES = fibre_frames()


def fibre_relief(points: NDArray[np.float64], width_mm: float) -> NDArray[np.float64]:
    """Return the fibre relief (N,) at points (N, 3), mm: 1 on a fibre, -1 between, mean near 0."""
    bent = points.copy()
    height = np.empty(len(points))
    for axis in range(3):
        fill_grain(points + 31.7 * axis, _BENDS_MM, height)
        bent[:, axis] += _BENT * _BENDS_MM * (height - 0.5)
    strongest = np.zeros(len(points))
    x, y, z = bent.T
    turned = np.empty_like(points)
    for k, frame in enumerate(_FRAMES):
        for axis, (a, b, c) in enumerate(frame):
            size = width_mm if axis else _LONG * width_mm
            # not a product of matrices, which sums in an order of its own
            turned[:, axis] = (x * a + y * b + z * c) / size + 7.7 * k
        fill_grain(turned, 1.0, height)
        np.maximum(strongest, height, out=strongest)
    relief: NDArray[np.float64] = np.clip((strongest - _USUAL) / _SPAN, -1.0, 1.0)
    return relief


# ---- Pores ---------------------------------------------------------------------------------------


_GRAIN_MM = 1.2  # size of the paper's bumps, which ink runs around
_GRAIN_OF_PORES = 1.5  # relative change of the residual, per unit of the material's grain
_GRAIN_OF_WAYS = 2.0  # the same of the conductance
_FIBRES_OF_WAYS = 1.4  # log of the conductance along fibres
_FLOCS = (1.2, 0.3), (2.4, 0.8), (4.8, 1.0)  # size, mm; change of the residual, per unit of grain
_FLOCS_MEAN = 0.07  # mean of them all, so that water goes as far as in an even sheet
_FLOCS_OF_WAYS = 1.0  # log of the conductance lost, per relative change of the residual
_ELSEWHERE = 13.1  # mm: offset between the noises of different floc sizes
_UNDER_FIBRES = 0.35  # fraction of the bumps that is left where there are fibres
_FIBRE_MM = 0.3  # width of the visible bundles of fibres
_SHEET_UM, _BODY_UM = 12.0, 6.0  # width of the pores of a sheet, and of clay or plaster
_SHOWN = (0.7, 1.2)  # spacing of the vertices, mm, at which fibres start to fade, and are gone
_SIEVE = 2.8  # saturation at which pores let all soot pass, per unit of 1 - `passing`
_FIBRES_OF_SIEVE = 0.5  # log of the drop of that potential along fibres, whose pores are wide
_RAW_MM = 0.06  # depth of the pores of raw paper
_CATCH_MM = 0.4  # in such: way through pores after which 1 / e of the fine pigment is still afloat
_FIBRES_OF_CATCH, _FLOCS_OF_CATCH = 0.6, 1.0  # log of that way along fibres, and lost in flocs
_GLUE = 0.25  # coats of dried ink that clog half of what can be clogged
_GLUE_OF_WAYS = 0.9  # greatest fraction of the conductance that glue takes
_GLUE_OF_ENTRY = 0.85  # of the range from the entry saturation to full pores, at most
_FULL = 0.98  # saturation that counts as full
_LEAST_MM = 0.012  # film held where there are no pores, by glue as it thickens
_FILM_MM2_S = 0.3  # least diffusivity of a film of water: a few hundredths of a mm level in seconds
_ENTRY_RATIO = 0.3  # entry potential of a cell's widest pores over that of its narrowest
_POOL_MM = 0.25  # depth at which a pool's water enters what is dry on a repellent surface
_SHEDS = (0.6, 0.9)  # entry saturations at which repellence starts, and is complete


def capacity_of(material: Material) -> float:
    """Return the depth of water that the pores hold, mm, above 0."""
    return max(material.pores_mm, _LEAST_MM)


def film_of(material: Material) -> float:
    """Return the diffusivity of a film of water on full pores, mm2/s."""
    return max(material.spread_mm2_s, _FILM_MM2_S)


def repellence_of(material: Material) -> float:
    """Return how far a surface repels water, 0 to 1."""
    low, high = _SHEDS
    if not material.pores_mm:
        return 1.0
    return min(max((material.advance - low) / (high - low), 0.0), 1.0)


def entry_ratio_of(material: Material) -> float:
    """Return the entry potential of a cell's widest pores over that of its narrowest, 0 to 1.

    Narrow pores fill at a higher potential. A pool that stands on a surface has none to fill: 1.
    """
    return _ENTRY_RATIO + (1.0 - _ENTRY_RATIO) * repellence_of(material)


def mobility_of(material: Material, grain_um: AnyArray) -> NDArray[np.float64]:
    """Return the mobility (P,) of grains of diameters (P,), um, relative to soot, 0 to 1.

    A sphere cannot come nearer to a pore's wall than its radius, and is carried by the flow further
    inside: of spheres that take up the fraction k of its width 1 - (k (2 - k))^2 get through
    (Ferry, *J. Gen. Physiol.* 20, 1936), and none that is wider. The widths are set by eye.
    """
    width = _SHEET_UM if material.pores_mm <= SHEET_MM else _BODY_UM
    k = np.minimum(grain_um / width, 1.0)
    result: NDArray[np.float64] = 1.0 - (k * (2.0 - k)) ** 2
    return result


def sieve_of(material: Material) -> float:
    """Return the potential above which pores let all pigment pass, as a part of their strength."""
    return float(np.clip(_SIEVE * (1.0 - material.passing), 0.0, 1.0)) ** 3


class Pores(NamedTuple):
    """Pore properties at points, (N,) float64 each; see the same names in `WetPatch`."""

    residual: NDArray[np.float64]
    strength: NDArray[np.float64]
    sieve: NDArray[np.float64]
    catch: NDArray[np.float64]
    entry_depth: NDArray[np.float64]
    conductance: NDArray[np.float64]


def find_pores(points: AnyArray, material: Material, spacing: float) -> Pores:
    """Return the pores without glue at points (N, 3), mm, of vertices `spacing` mm apart."""
    height = np.empty(len(points))
    fill_grain(points, _GRAIN_MM, height)
    bump, fibres = material.grain * (2.0 * height - 1.0), _fibres_shown(points, material, spacing)
    relief = _GRAIN_OF_PORES * bump
    if fibres is not None:
        bump *= _UNDER_FIBRES
        relief = material.grain * _floc_relief(points)
    residual = np.clip(material.residual * (1.0 + relief), 0.0, 0.95)
    strength = capacity_of(material) * material.spread_mm2_s * (1.0 - residual) / 3.0
    entry_depth = capacity_of(material) * np.maximum(residual, material.advance * (1.0 + relief))
    sieve = strength * sieve_of(material)
    conductance = np.maximum(0.05, 1.0 + _GRAIN_OF_WAYS * bump)
    if fibres is not None:
        sieve *= even_exp(-_FIBRES_OF_SIEVE * material.grain * fibres)
        conductance *= even_exp(_FIBRES_OF_WAYS * material.grain * fibres - _FLOCS_OF_WAYS * relief)
    # pores of sized paper are narrower
    tight = min(1.0, material.pores_mm / _RAW_MM) if material.pores_mm else 1.0
    catch = np.full(len(points), _CATCH_MM * tight)
    if fibres is not None:
        catch *= even_exp(_FIBRES_OF_CATCH * material.grain * fibres - _FLOCS_OF_CATCH * relief)
    return Pores(residual, strength, sieve, catch, entry_depth, conductance)


def clog_pores(
    pores: Pores, material: Material, glue: AnyArray
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the pores as `glue` (N,), coats of dried ink, leaves them.

    Returns
    -------
    entry_depth, entry, conductance : (N,) float64
        Depth at which a dry node is soaked, mm; the potential above which water enters it, mm3/s;
        the factor on the conductance.
    """
    clogged = glue / (glue + _GLUE)
    depth = capacity_of(material)
    full = _FULL * depth
    entry_depth = pores.entry_depth + _GLUE_OF_ENTRY * clogged * np.maximum(
        0.0, full - pores.entry_depth
    )
    s = np.clip((entry_depth / depth - pores.residual), 0.0, 1.0)
    s = np.minimum(1.0, s / (1.0 - pores.residual))
    pool_entry = film_of(material) * _POOL_MM * repellence_of(material)
    return (
        entry_depth,
        pores.strength * (s * s * s) + pool_entry,
        pores.conductance * (1.0 - _GLUE_OF_WAYS * clogged),
    )


def _floc_relief(points: AnyArray) -> AnyArray:
    """Return how much denser than its mean a sheet is at points (N, 3)."""
    denser, height = np.full(len(points), _FLOCS_MEAN), np.empty(len(points))
    for k, (apart_mm, strength) in enumerate(_FLOCS):
        fill_grain(points + _ELSEWHERE * k, apart_mm, height)
        denser += strength * (2.0 * height - 1.0)
    return denser


def _fibres_shown(points: AnyArray, material: Material, spacing: float) -> AnyArray | None:
    """Return the fibre relief (N,), faded out for coarse spacings; None if this is no sheet."""
    fade, gone = _SHOWN
    if not material.is_felted:
        return None
    if spacing >= gone:
        return np.zeros(len(points))
    relief = fibre_relief(points, max(_FIBRE_MM, spacing))
    return relief * min(1.0, (gone - spacing) / (gone - fade))
