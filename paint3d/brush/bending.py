"""The table of bent shapes of a tuft, and the `Tuft` that the kernels take.

`paint3d.brush_engine.spine` describes the bending energy, which the papers leave open. The spine is
discretised into fine arcs that crowd towards the tip, where a tuft is weak. The stiffness of joint
j is k_j = s_j^q / r_j, with s_j its arc length from the tip over the tuft's, and r_j the length
that bends there: the mean of the two arcs that it joins, at the holder half of the last one. The
table depends on the tuft by q alone, so tufts of one q share it.

The papers' segments determine where a tuft is soft: the shorter they are near the tip, the easier
it bends there. A brush whose number of segments or tip segment differs from its rated one bends as
if its hairs were le(s) / le_rated(s) times as thick at s, with le the length of the segment there:
docs/model.md, section 1.
"""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.spec import DEEPEST_PRESS, LARGEST_DRAG_FRACTION, BrushSpec
from paint3d.brush_engine.enclosing_sphere import tabulate_spheres
from paint3d.brush_engine.spine import tabulate_bending
from paint3d.brush_engine.tuft import RING_STATIONS, SPHERE_SPREADS, SPHERE_STEPS, STATIONS, Tuft
from paint3d.colour.materials import Material
from paint3d.core.arrays import AnyArray
from paint3d.errors import BrushError

__all__ = [
    "LEAST_COSINE",
    "LOWEST_TILT",
    "BendingTable",
    "bending_table",
    "build_tuft",
    "tuft_on",
]

LOWEST_TILT = math.radians(30.0)
_N_TILTS = 25
_N_DESCENTS = 129
_N_ARCS = 2 * (STATIONS - 1)
_CROWDING = 2.6  # exponent of the arcs' spacing: even the lightest touch bends several at the tip
Segmentation = tuple[float, float, float, float]
LEAST_COSINE = 1e-3
"""Of a section's angle; a steeper section is clear of the plane."""


class BendingTable:
    """Least-energy shapes of a tuft of length 1 over tilt and descent.

    Columns are even in the square root of the descent, as an upright tuft yields.

    Parameters
    ----------
    exponent : float
        q: a joint bends (s / LE)^q times as hard as the root.
    n_arcs : int
        Resolution of the spine; the default except in convergence studies.
    segmentation : tuple, optional
        As `BrushSpec.segmentation`.

    Attributes
    ----------
    tilts : (T,) float64, read-only
        30 to 90 degrees, rad.
    fractions : (D,) float64, read-only
        Descent of the root over LE sin(tilt), 0 to `DEEPEST_PRESS`.
    arcs : (M + 1,) float64, read-only
        Arc lengths of the joints from the tip, 0 to 1.
    angles : (T, D, M) float64, read-only
        Of the arcs to the plane, rad, tip first.

    Raises
    ------
    BrushError
        If the bending cannot be solved.
    """

    def __init__(
        self, exponent: float, n_arcs: int = _N_ARCS, segmentation: Segmentation | None = None
    ) -> None:
        self.tilts = np.linspace(LOWEST_TILT, 0.5 * math.pi, _N_TILTS)
        self.fractions = DEEPEST_PRESS * np.linspace(0.0, 1.0, _N_DESCENTS) ** 2
        self.arcs = np.linspace(0.0, 1.0, n_arcs + 1) ** _CROWDING
        self.angles = np.empty((_N_TILTS, _N_DESCENTS, n_arcs))
        failures = tabulate_bending(
            self.arcs,
            joint_stiffness(self.arcs, exponent, segmentation),
            float(exponent),
            self.tilts,
            self.fractions,
            self.angles,
        )
        if failures:
            raise BrushError(
                "stiffness_exponent {exponent:g}: {failures} of {n_tilts} bent shapes found no "
                "resting position; expected none (try one nearer to 3.5)",
                exponent=exponent,
                failures=failures,
                n_tilts=_N_TILTS * _N_DESCENTS,
            )
        for array in (self.tilts, self.fractions, self.arcs, self.angles):
            array.setflags(write=False)

    @functools.cached_property
    def spine(self) -> tuple[AnyArray, AnyArray, AnyArray]:
        """Positions of the joints and angles of their sections, (T, D, M + 1) each, tip first.

        Along the plane from the root's foot and up from the plane, both over the tuft's length, and
        the section's angle (rad): the mean of the two arcs at the joint, at the root the holder's.
        """
        lengths = np.diff(self.arcs)
        run, rise = lengths * np.cos(self.angles), lengths * np.sin(self.angles)
        start = np.zeros((*self.angles.shape[:2], 1))
        along = np.concatenate([start, np.cumsum(run, axis=-1)], axis=-1)
        up = np.concatenate([start, np.cumsum(rise, axis=-1)], axis=-1)
        clamp = np.broadcast_to(self.tilts[:, None, None], start.shape)
        below = np.concatenate([self.angles[..., :1], self.angles], axis=-1)
        above = np.concatenate([self.angles, clamp], axis=-1)
        angle = 0.5 * (below + above)
        angle[..., -1:] = clamp  # in the ferrule
        return along[..., -1:] - along, up, angle


def joint_stiffness(
    arcs: AnyArray, exponent: float, segmentation: Segmentation | None = None
) -> AnyArray:
    """k_j (M,) of the joints above the arcs in docs/model.md, equation (2), for LE = 1."""
    lengths = np.diff(arcs)
    bending = np.append(0.5 * (lengths[:-1] + lengths[1:]), 0.5 * lengths[-1])
    result: AnyArray = arcs[1:] ** exponent / bending
    if segmentation is not None:
        segments, tip, rated_segments, rated_tip = segmentation
        actual = _segment_at(arcs[1:], segments, tip)
        result *= (actual / _segment_at(arcs[1:], rated_segments, rated_tip)) ** exponent
    return result


def _segment_at(arcs: AnyArray, segments: float, tip: float) -> AnyArray:
    """Length of the papers' segment (Guo 2017, Eq. 1) at arc lengths, all for LE = 1.

    j segments span j (tip - d / 2) + j^2 d / 2; the derivative with respect to j is the length.
    """
    d = 2.0 * (1.0 - segments * tip) / (segments * (segments - 1.0))
    result: AnyArray = np.sqrt((tip - 0.5 * d) ** 2 + 2.0 * d * arcs)
    return result


@functools.lru_cache(maxsize=16)
def bending_table(exponent: float, segmentation: Segmentation | None = None) -> BendingTable:
    """Return the table for a stiffness exponent and a segmentation; cached. About .1 s.

    Raises
    ------
    BrushError
        If the bending cannot be solved.
    """
    return BendingTable(exponent, segmentation=segmentation)


@functools.lru_cache(maxsize=16)
def _shared(exponent: float, segmentation: Segmentation | None) -> tuple[NDArray[np.float32], ...]:
    """Arrays common to tufts of one table, at the stations: `Tuft.spine`, `Tuft.reach`, chords."""
    along, up, angle = (part[..., ::2] for part in bending_table(exponent, segmentation).spine)
    spine = np.stack([along, up, angle], axis=2)
    cosine = np.maximum(np.cos(angle), LEAST_COSINE)
    reach = along - up * np.sin(angle) / cosine
    return (
        _constant(spine),
        _constant(reach),
        _constant(2.0 * up / cosine),
    )


def _constant(values: AnyArray) -> NDArray[np.float32]:
    result = np.ascontiguousarray(values, np.float32)
    result.setflags(write=False)
    return result


def tuft_on(spec: BrushSpec, material: Material) -> Tuft:
    """Build the tuft of a brush on a material, which may draw more or less ink out of it.

    Brushes are rated on raw xuan. Friction belongs to brush and surface (Guo 2015, section 4):
    hairs spread by d + h mu with mu = `BrushSpec.friction` times `Material.friction` (Eq. 2), and
    the drag of the contact scales with it.

    Raises
    ------
    BrushError
        If the bending of this brush cannot be solved.
    """
    tuft = build_tuft(spec)
    rubbing = spec.spread_by_friction * spec.friction
    return tuft._replace(
        transfer_per_mm=tuft.transfer_per_mm * material.uptake,
        spread=tuft.spread + (material.friction - 1.0) * rubbing,
        drag_fraction=min(LARGEST_DRAG_FRACTION, tuft.drag_fraction * material.friction),
    )


@functools.lru_cache(maxsize=64)
def build_tuft(spec: BrushSpec) -> Tuft:
    """Build the tuft of a brush for the kernels; results are cached.

    Raises
    ------
    BrushError
        If the bending of this brush cannot be solved.
    """
    exponent = float(spec.stiffness_exponent)
    spine, reach, chords = _shared(exponent, spec.segmentation)
    arcs = bending_table(exponent, spec.segmentation).arcs[::2] * spec.length_mm
    diameters = spec.diameters(arcs)
    rings = np.array(RING_STATIONS)
    spheres = np.empty((*spine[::2, ::SPHERE_STEPS].shape[:2], len(SPHERE_SPREADS), 3))
    tabulate_spheres(
        np.ascontiguousarray(spine[::2, ::SPHERE_STEPS][..., rings], np.float64),
        0.5 * diameters[rings] / spec.length_mm,
        np.array(SPHERE_SPREADS),
        spheres,
    )
    for array in (arcs, diameters, spheres):
        array.setflags(write=False)
    # Tuft.openness, g / (1 + g) with g = 2 z / (cos beta C); at the tip, 0 over 0, that beside it:
    gap = chords[..., 1:] / (diameters / spec.length_mm)[1:]
    gap = np.concatenate([gap[..., :1], gap], axis=-1)
    return Tuft(
        arcs=arcs,
        diameters=diameters,
        spine=spine,
        reach=reach,
        openness=_constant(gap / (1.0 + gap)),
        spheres=spheres,
        taper=float(spec.taper),
        point=float(spec.point_mm),
        lowest_tilt=LOWEST_TILT,
        greatest_fraction=DEEPEST_PRESS,
        length=float(spec.length_mm),
        full_press=float(spec.press_mm),
        spring=float(spec.spring),
        max_force=float(spec.greatest_force),
        spread=float(spec.spread),
        load=float(spec.load),
        transfer_per_mm=float(spec.transfer_per_mm),
        drag_fraction=float(spec.drag_fraction),
        plasticity=float(spec.plasticity),
    )
