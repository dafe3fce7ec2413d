"""The table of bent shapes of a brush, and the `Tuft` that kernels take.

The energy that fills the gap in the papers is described in `paint3d.brush_engine.spine`. A joint's
stiffness is k_j = (s_j / LE)^q / r_j, with s_j its arc length from the tip and r_j the rest length
that bends there: the mean of the two segments it joins, and all of the last one at the holder.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from paint3d.brush.spec import BrushSpec
from paint3d.brush_engine.spine import tabulate_bending
from paint3d.brush_engine.tuft import SHARES, Tuft
from paint3d.core.types import AnyArray
from paint3d.errors import BrushError

__all__ = ["GREATEST_FRACTION", "LOWEST_TILT", "BendingTable", "build_tuft"]

LOWEST_TILT = math.radians(30.0)
GREATEST_FRACTION = 0.62  # descent over the straight tuft's height; below, the ferrule would touch
_N_TILTS = 25
_N_DESCENTS = 129


class BendingTable:
    """Least-energy shapes of one brush over tilt and descent.

    Columns are even in the square root of the descent, because an upright tuft gives way like one.
    Building takes some 10 ms for 25 tilts and 129 descents.

    Parameters
    ----------
    spec : BrushSpec

    Attributes
    ----------
    tilts : (T,) float64, read-only
        30 to 90 degrees, rad.
    fractions : (D,) float64, read-only
        Descent of the root over LE sin(tilt), 0 to `GREATEST_FRACTION`.
    angles : (T, D, M) float64, read-only
        beta_j, rad, tip first.

    Raises
    ------
    BrushError
        If the bending of this brush cannot be solved.
    """

    def __init__(self, spec: BrushSpec) -> None:
        self.tilts = np.linspace(LOWEST_TILT, 0.5 * math.pi, _N_TILTS)
        self.fractions = GREATEST_FRACTION * np.linspace(0.0, 1.0, _N_DESCENTS) ** 2
        self.angles = np.empty((_N_TILTS, _N_DESCENTS, spec.n_segments))
        failures = tabulate_bending(
            spec.segment_lengths, joint_stiffness(spec), self.tilts, self.fractions, self.angles
        )
        if failures:
            raise BrushError(
                f"brush {spec.name!r}: {failures} of {_N_TILTS * _N_DESCENTS} bent shapes found no "
                "resting position; expected none (try a stiffness_exponent nearer to 3.5)"
            )
        for array in (self.tilts, self.fractions, self.angles):
            array.setflags(write=False)


def joint_stiffness(spec: BrushSpec) -> AnyArray:
    """k_j (M,) of the joints P_1 to P_m in docs/model.md, equation (1), up to a common factor."""
    lengths = spec.segment_lengths
    arcs = np.cumsum(lengths)
    rest = np.append(0.5 * (lengths[:-1] + lengths[1:]), lengths[-1])
    result: AnyArray = (arcs / spec.length_mm) ** spec.stiffness_exponent / rest
    return result


def _refined_diameters(spec: BrushSpec) -> AnyArray:
    joints = np.concatenate([[0.0], np.cumsum(spec.segment_lengths)])
    inner = joints[:-1, None] + SHARES[1:] * spec.segment_lengths[:, None]
    arcs = np.concatenate([[0.0], inner.ravel()])
    return spec.diameters(np.minimum(arcs, spec.length_mm))


@functools.lru_cache(maxsize=64)
def build_tuft(spec: BrushSpec) -> Tuft:
    """The brush ready for kernels; kept in memory, so that asking again costs nothing.

    Raises
    ------
    BrushError
        If the bending of this brush cannot be solved.
    """
    table = BendingTable(spec)
    lengths = spec.segment_lengths
    diameters = _refined_diameters(spec)
    for array in (lengths, diameters):
        array.setflags(write=False)
    return Tuft(
        segment_lengths=lengths,
        diameters=diameters,
        taper=float(spec.taper),
        angles=table.angles,
        lowest_tilt=LOWEST_TILT,
        greatest_fraction=GREATEST_FRACTION,
        length=float(spec.length_mm),
        full_press=float(spec.full_press_mm),
        spring=float(spec.spring),
        max_force=float(spec.max_force),
        spread=float(spec.spread),
        load=float(spec.load),
        transfer_per_mm=float(spec.transfer_per_mm),
        drag_fraction=float(spec.drag_fraction),
        plasticity=float(spec.plasticity),
    )
