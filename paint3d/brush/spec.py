"""What a brush is: the papers' parameters under names that cannot be confused."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import ArrayLike

from paint3d.brush.bristle_spec import BristleSpec
from paint3d.brush.dynamics import InputCurves, check_curves
from paint3d.core.arrays import as_array, as_number
from paint3d.core.types import AnyArray
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.errors import BrushError

__all__ = ["HAIRS", "REFERENCE_LENGTH", "BrushSpec", "parameter_ranges"]

HAIRS = ("goat", "weasel", "mixed")
REFERENCE_LENGTH = 35.0  # mm, the tuft of Guo 2017, Table 2, to which its ranges belong

# The ranges of Guo 2017, section 5; le_1 scales with the tuft's length.
_RANGES = {
    "hardness": (0.3, 0.7),
    "friction": (0.2, 0.3),
    "spread_by_pressure": (1.3, 1.8),
    "spread_by_friction": (0.6, 0.8),
    "length_mm": (5.0, 200.0),
    "taper": (0.4, 1.5),
    "stiffness_exponent": (2.5, 5.0),
    "load": (1.0, 1e7),
    "transfer_per_mm": (1e-6, 1.0),
    "drag_fraction": (0.0, 0.5),
    "plasticity": (0.0, 1.0),
}
_SEGMENTS = (8.0, 13.0)
_FORCES = (0.1, 100.0)  # N
_TIP_SEGMENT = (0.8, 1.4)  # mm of a tuft of the reference's length
_SHALLOWEST_PRESS = 0.2  # of the length
_DEEPEST_PRESS = 0.62  # of the length; the table of bent shapes ends there
_POINT = 2.0  # tip segments
_LONGEST_POINT = 0.15  # of the length
_THINNEST_ROOT = 0.02  # of the length
_THICKEST_ROOT = 0.42  # of the length: thicker, and the ferrule touches within the table


def parameter_ranges(length_mm: float) -> dict[str, tuple[float, float]]:
    """Least and greatest value of every number of a brush whose tuft is so long (mm)."""
    scale = length_mm / REFERENCE_LENGTH
    return _RANGES | {
        "n_segments": _SEGMENTS,
        "tip_segment_mm": (_TIP_SEGMENT[0] * scale, _TIP_SEGMENT[1] * scale),
        "root_diameter_mm": (_THINNEST_ROOT * length_mm, _THICKEST_ROOT * length_mm),
        "point_mm": (0.0, _LONGEST_POINT * length_mm),
        "full_press_mm": (_SHALLOWEST_PRESS * length_mm, _DEEPEST_PRESS * length_mm),
        "max_force": _FORCES,
        "rated_hardness": _RANGES["hardness"],
        "rated_segments": _SEGMENTS,
        "rated_tip_share": (
            _TIP_SEGMENT[0] / REFERENCE_LENGTH,
            _TIP_SEGMENT[1] / REFERENCE_LENGTH,
        ),
    }


@dataclasses.dataclass(frozen=True, slots=True)
class BrushSpec:
    """One brush, checked against the ranges in which the papers' model holds.

    Parameters
    ----------
    name : str
    hair : {"goat", "weasel", "mixed"}
    hardness : float
        The papers' S ("softness", though larger is stiffer), 0.3 to 0.7.
    n_segments : int
        m, 8 to 13 straight segments of the spine.
    tip_segment_mm : float
        le_1, 0.8 to 1.4 mm on a tuft of 35 mm, in proportion on others.
    friction : float
        mu between hairs and surface, 0.2 to 0.3.
    spread_by_pressure, spread_by_friction : float
        d and h of Guo 2017, Eq. 2.
    length_mm : float
        LE from tip to ferrule.
    root_diameter_mm, taper : float
        The round section at arc length s from the tip has the diameter root (s / LE)^taper.
    point_mm : float, optional
        s0, 0 to .15 LE: nearer to the tip the tuft is a cone, (1 - exp(-s / s0))^(1 - taper) times
        as wide as that. NaN: two tip segments.
    stiffness_exponent : float
        q: a joint bends (s / LE)^q times as hard as the root.
    full_press_mm : float
        Descent of the root at which pe = 1, with the hardness `rated_hardness`; gives lambda_c.
    load : float
        Ink in a full tuft, full coats times mm2.
    transfer_per_mm : float
        eta', share of the ink given per mm of travel at pe = 1.
    drag_fraction : float
        c, how far paper drags the contact back in the dragged mode, 0 to 1/2.
    plasticity : float
        rho, share of the bend that stays when the pen lifts, 0 (springs back) to 1.
    max_force : float
        Force at pe = 1, N.
    rated_hardness, rated_segments, rated_tip_share : float, optional
        The hardness at which `full_press_mm`, and the number of segments and tip_segment_mm /
        length_mm at which `stiffness_exponent` holds: what the brush was fitted with. A brush with
        less hardness is pressed deeper by the same force, one with a shorter tip segment bends more
        at its tip. NaN: the brush's own.
    bristles : BristleSpec, optional
        What its tuft's hairs are, for a brush that paints with single hairs; None: a solid tuft.
    inputs : mapping, optional
        Curves by which the hand drives the brush: ``{setting: {input: [[x, factor], ...]}}``; see
        `brush.dynamics`.

    Raises
    ------
    BrushError
        Naming the brush, the parameter, what was got and what was expected.
    """

    name: str
    hair: str
    hardness: float
    n_segments: int
    tip_segment_mm: float
    friction: float
    spread_by_pressure: float
    spread_by_friction: float
    length_mm: float
    root_diameter_mm: float
    taper: float
    stiffness_exponent: float
    full_press_mm: float
    load: float
    transfer_per_mm: float
    drag_fraction: float
    plasticity: float
    max_force: float = MAX_FORCE_N
    point_mm: float = math.nan
    bristles: BristleSpec | None = None
    inputs: InputCurves = ()
    rated_hardness: float = math.nan
    rated_segments: float = math.nan
    rated_tip_share: float = math.nan

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise BrushError(f"name is {self.name!r}; expected a non-empty string")
        if self.hair not in HAIRS:
            raise BrushError(
                f"brush {self.name!r}: hair is {self.hair!r}; expected one of {', '.join(HAIRS)}"
            )
        self._check("length_mm", *_RANGES["length_mm"])
        self._check("tip_segment_mm", 0.0, self.length_mm)
        for parameter, value in (
            ("point_mm", _POINT * self.tip_segment_mm),
            ("rated_hardness", self.hardness),
            ("rated_segments", self.n_segments),
            ("rated_tip_share", self.tip_segment_mm / self.length_mm),
        ):
            stated = getattr(self, parameter)
            if isinstance(stated, float) and math.isnan(stated):
                object.__setattr__(self, parameter, value)
        for parameter, (low, high) in parameter_ranges(self.length_mm).items():
            self._check(parameter, low, high)
        if self.n_segments != int(self.n_segments):
            raise BrushError(
                f"brush {self.name!r}: n_segments is {self.n_segments}; expected a whole number"
            )
        object.__setattr__(self, "n_segments", int(self.n_segments))
        object.__setattr__(self, "inputs", check_curves(self.inputs, self.name))
        if not isinstance(self.bristles, BristleSpec | None):
            raise BrushError(
                f"brush {self.name!r}: bristles is {type(self.bristles).__name__}; "
                "expected a BristleSpec or nothing"
            )

    def _check(self, parameter: str, low: float, high: float) -> None:
        what = f"brush {self.name!r}: {parameter}"
        low, high = low * (1.0 - 1e-9), high * (1.0 + 1e-9)  # a scaled range holds its own ends
        as_number(getattr(self, parameter), what, low, high, BrushError)

    @property
    def segment_lengths(self) -> AnyArray:
        """le_j (M,), mm, tip first: an arithmetic progression (Guo 2017, Eq. 1)."""
        m = self.n_segments
        difference = 2.0 * (self.length_mm - m * self.tip_segment_mm) / (m * (m - 1))
        return self.tip_segment_mm + difference * np.arange(m)

    @property
    def spread(self) -> float:
        """d + h mu: growth of a section's major diameter at pe = 1 (Guo 2017, Eqs. 2, 5)."""
        return self.spread_by_pressure + self.spread_by_friction * self.friction

    @property
    def force_coefficient(self) -> float:
        """lambda_c, N/mm: chosen so that pe = 1 at `full_press_mm` when it was rated (Eq. 4)."""
        return self.max_force / (self.rated_hardness * self.full_press_mm)

    @property
    def spring(self) -> float:
        """lambda_c S, N/mm: force per descent of the root."""
        return self.force_coefficient * self.hardness

    @property
    def press_mm(self) -> float:
        """Descent at pe = 1, mm: where a softer brush would go on, it ends at its deepest press."""
        press = self.full_press_mm * (self.rated_hardness / self.hardness)
        return min(press, _DEEPEST_PRESS * self.length_mm)

    @property
    def greatest_force(self) -> float:
        """Force at pe = 1, N: `max_force`, and less where the press ends before."""
        is_whole = self.full_press_mm * (self.rated_hardness / self.hardness) <= (
            _DEEPEST_PRESS * self.length_mm
        )
        return self.max_force if is_whole else self.spring * self.press_mm

    @property
    def chain(self) -> tuple[float, float, float, float] | None:
        """Segments and tip_segment_mm / length_mm, as they are and as rated; None where alike."""
        share = self.tip_segment_mm / self.length_mm
        if self.n_segments == self.rated_segments and math.isclose(share, self.rated_tip_share):
            return None
        return float(self.n_segments), share, float(self.rated_segments), self.rated_tip_share

    @property
    def volume(self) -> float:
        """Volume of the unbent tuft, mm3."""
        area = 0.25 * math.pi * self.root_diameter_mm**2
        return area * self.length_mm / (2.0 * self.taper + 1.0)

    def diameters(self, arc_lengths: ArrayLike) -> AnyArray:
        """Round diameter (N,), mm, of the unbent tuft at arc lengths (N,) from the tip, mm.

        docs/model.md, equation (1).

        Raises
        ------
        BrushError
            If an arc length lies off the tuft.
        """
        s = as_array(arc_lengths, "arc_lengths", (None,), error=BrushError)
        if s.size and (s.min() < 0.0 or s.max() > self.length_mm * (1.0 + 1e-9)):
            raise BrushError(
                f"arc_lengths span {s.min():g} to {s.max():g}; expected 0 to {self.length_mm:g}"
            )
        diameters: AnyArray = self.root_diameter_mm * (s / self.length_mm) ** self.taper
        if self.point_mm > 0.0:
            narrowed = -np.expm1(-s / self.point_mm)
            narrowed[s <= 0.0] = 1.0
            diameters *= narrowed ** (1.0 - self.taper)
        return diameters
