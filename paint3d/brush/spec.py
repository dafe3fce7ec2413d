"""Checked brush parameters: the tuft, its single hairs, input curves, and the amount of a dip.

The papers call one quantity by several letters; here each has one name, with the letters beside it.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from paint3d.brush_engine.tuft import MOST_POINTS, Curves, Tuft, no_curves
from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.errors import BrushError, InputError, Message

__all__ = [
    "DEEPEST_PRESS",
    "HAIRS",
    "INPUTS",
    "LARGEST_DRAG_FRACTION",
    "MOST_HAIRS",
    "REFERENCE_LENGTH",
    "SETTINGS",
    "SHAPE_COLUMNS",
    "TABLES",
    "BristleSpec",
    "BrushSpec",
    "DipAmount",
    "InputCurves",
    "ShapeRows",
    "build_curves",
    "check_curves",
    "hair_ranges",
    "parameter_ranges",
    "shape_rows",
]

# ---- Single hairs --------------------------------------------------------------------------------

MOST_HAIRS = 10_000
TABLES = ("energy", "measured")

SHAPE_COLUMNS = ("angle", "height", "offset", "imprint", "upper", "lower", "spread")
"""Columns of a row of measured shapes: the handle's angle from the upright (degrees); the root's
height over that of the straight hair; in hair lengths, how far the tip lies ahead of where the
handle's axis meets the paper, the imprint, and the control lengths of the cubic Bezier curve along
the handle and along the paper; the hairs' spread (degrees)."""

ShapeRows = tuple[tuple[float, ...], ...]

_SHAPE_RANGES = (
    (0.0, 60.0),
    (0.0, 1.0),
    (-1.0, 1.5),
    (0.0, 1.5),
    (0.0, 2.0),
    (0.0, 2.0),
    (0.0, 90.0),
)
_MOST_SHAPES = 1000

_HAIR_RANGES = {
    "hair_mm": (0.01, 2.0),
    "film": (0.0, 0.2),
    "threshold_mm": (0.0, 1.0),
    "unevenness": (0.0, 0.2),
    "parting": (0.0, 1.0),
    "splay": (0.0, 1.0),
    "appetite": (0.0, 0.95),
    "levelling_mm": (0.1, 1e4),
    "set_share": (0.001, 0.5),
}


def hair_ranges() -> dict[str, tuple[float, float]]:
    """Allowed range of every numeric parameter of the hairs."""
    return {"n_hairs": (1.0, float(MOST_HAIRS)), **_HAIR_RANGES}


@dataclasses.dataclass(frozen=True, slots=True)
class BristleSpec:
    """Checked parameters of a tuft of single hairs.

    Parameters
    ----------
    n_hairs : int
        1 to 10,000.
    table : {"energy", "measured"} or rows of numbers
        Source of the bent shapes: the least bending energy of the brush, the shapes measured on a
        real brush (FastBrush), or the user's: rows of `SHAPE_COLUMNS`.
    hair_mm : float
        Thickness of a dry hair, mm.
    film : float
        Thickness of ink around a full hair, as a fraction of the tuft's diameter at the root; hairs
        closer than that flow together.
    threshold_mm : float
        How near the surface a hair must be to leave ink, mm.
    unevenness : float
        How much shorter than the longest hair the shortest is, as a fraction.
    parting : float
        How far the clumps of a dry tuft part, 0 to 1.
    splay : float
        How far the hairs of a dry tuft lie side by side instead of coming to a point, 0 to 1.
    appetite : float
        How much hairs differ in giving ink, 0 (all alike) to 1.
    levelling_mm : float
        Path length over which neighbouring wet hairs level their ink, mm.
    set_share : float
        Descent over which a remembered bend is pressed out, as a fraction of the tuft's length.

    Raises
    ------
    BrushError
        Naming the parameter, what was got and what was expected.
    """

    n_hairs: int = 1000
    table: str | ShapeRows = "energy"
    hair_mm: float = 0.12
    film: float = 0.011
    threshold_mm: float = 0.15
    unevenness: float = 0.02
    parting: float = 0.9
    splay: float = 0.85
    appetite: float = 0.6
    levelling_mm: float = 30.0
    set_share: float = 0.06

    def __post_init__(self) -> None:
        count = as_number(self.n_hairs, "n_hairs", 1, MOST_HAIRS, BrushError)
        if count != int(count):
            raise BrushError("n_hairs is {n_hairs}; expected a whole number", n_hairs=self.n_hairs)
        object.__setattr__(self, "n_hairs", int(count))
        if isinstance(self.table, list | tuple):
            object.__setattr__(self, "table", shape_rows(self.table))
        elif self.table not in TABLES:
            raise BrushError(
                "table is {table!r:.60}; expected {tables} or rows of numbers",
                table=self.table,
                tables=", ".join(TABLES),
            )
        for name, (low, high) in _HAIR_RANGES.items():
            as_number(getattr(self, name), name, low, high, BrushError)


def shape_rows(rows: Any) -> ShapeRows:
    """Check measured shapes and sort them by angle, the straight hair first.

    Parameters
    ----------
    rows : sequence of sequences of 7 numbers
        `SHAPE_COLUMNS`. An angle without a row of height 1 is given one: the straight hair.

    Raises
    ------
    BrushError
        Naming the row and the column, what was got and what was expected.
    """
    if not isinstance(rows, list | tuple):
        raise BrushError("table is {rows!r:.60}; expected rows of numbers", rows=rows)
    if not 1 <= len(rows) <= _MOST_SHAPES:
        raise BrushError("table has {n} rows; expected 1 to {most}", n=len(rows), most=_MOST_SHAPES)
    checked = set()
    for k, row in enumerate(rows, 1):
        if not isinstance(row, list | tuple) or len(row) != len(SHAPE_COLUMNS):
            raise BrushError(
                "table: row {k} is {row!r:.60}; expected 7 numbers: {shape_columns}",
                k=k,
                row=row,
                shape_columns=", ".join(SHAPE_COLUMNS),
            )
        named = zip(SHAPE_COLUMNS, row, _SHAPE_RANGES, strict=True)
        checked.add(
            tuple(as_number(x, f"table: row {k}: {what}", *r, BrushError) for what, x, r in named)
        )
    checked |= {(angle, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0) for angle, height, *_ in checked} - {
        (angle, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0) for angle, height, *_ in checked if height == 1.0
    }
    ordered = tuple(sorted(checked, key=lambda row: (row[0], -row[1])))
    for one, other in itertools.pairwise(ordered):
        if one[:2] == other[:2]:
            raise BrushError(
                "table has two rows of angle {first:g} and height {second:g}; expected one",
                first=one[0],
                second=one[1],
            )
    for angle in {row[0] for row in ordered}:
        if sum(row[0] == angle for row in ordered) < 2:
            raise BrushError(
                "table has no bent hair of angle {angle:g}; expected heights below 1",
                angle=angle,
            )
    return ordered


# ---- Input curves --------------------------------------------------------------------------------
# They modulate a brush's settings by the hand's motion; see `paint3d.brush_engine.stroke_loop`.

SETTINGS = ("stiffness", "spread", "load", "wetness")
INPUTS = ("pressure", "tilt", "speed", "ink_left", "curvature")
_FACTORS = (0.05, 20.0)

Points = tuple[tuple[float, float], ...]
InputCurves = tuple[tuple[str, tuple[tuple[str, Points], ...]], ...]
"""Points (input, factor) of a curve, by setting and input; hashable."""


def check_curves(
    curves: Mapping[str, Mapping[str, object]] | InputCurves, brush: str
) -> InputCurves:
    """Check curves in a preset's form, {setting: {input: [[x, factor], ...]}}.

    Raises
    ------
    BrushError
        Naming the brush, the curve, what was got and what was expected.
    """
    what = Message("brush {brush!r}: inputs", brush=brush)
    checked = []
    for setting, by_input in _items(curves, what):
        if setting not in SETTINGS:
            raise BrushError(
                "{what} drive {setting!r:.40}; expected {settings}",
                what=what,
                setting=setting,
                settings=", ".join(SETTINGS),
            )
        lines = []
        for name, points in _items(
            by_input, Message("{what} of {setting}", what=what, setting=setting)
        ):
            if name not in INPUTS:
                raise BrushError(
                    "{what}: {name!r:.40}; expected one of {inputs}",
                    what=what,
                    name=name,
                    inputs=", ".join(INPUTS),
                )
            lines.append(
                (
                    name,
                    _points(
                        points,
                        Message(
                            "{what}: {setting} by {input}", what=what, setting=setting, input=name
                        ),
                    ),
                )
            )
        checked.append((setting, tuple(lines)))
    return tuple(checked)


def _items(value: Any, what: str) -> list[tuple[str, Any]]:
    try:
        pairs: list[tuple[str, Any]] = list(value.items() if isinstance(value, Mapping) else value)
        names = [name for name, _ in pairs]
    except (TypeError, ValueError):
        raise BrushError(
            "{what} is {value!r:.60}; expected names with curves",
            what=what,
            value=value,
        ) from None
    if len(set(map(str, names))) < len(names):
        raise BrushError("{what} names something twice", what=what)
    return pairs


def _points(points: Any, what: str) -> Points:
    try:
        pairs = [(x, y) for x, y in points]
    except (TypeError, ValueError):
        raise BrushError(
            "{what} is {points!r:.60}; expected points [input, factor]",
            what=what,
            points=points,
        ) from None
    if not 1 <= len(pairs) <= MOST_POINTS:
        raise BrushError(
            "{what} has {n} points; expected 1 to {most}",
            what=what,
            n=len(pairs),
            most=MOST_POINTS,
        )
    xs = [as_number(x, f"{what}: an input", error=BrushError) for x, _ in pairs]
    ys = [as_number(y, f"{what}: a factor", *_FACTORS, BrushError) for _, y in pairs]
    if any(b <= a for a, b in itertools.pairwise(xs)):
        raise BrushError("{what} has inputs {xs}; expected them to rise", what=what, xs=xs)
    return tuple(zip(xs, ys, strict=True))


def build_curves(curves: InputCurves) -> Curves:
    """Pack checked curves into arrays for the kernels."""
    built = no_curves()
    for setting, by_input in curves:
        row = SETTINGS.index(setting)
        for name, points in by_input:
            column = INPUTS.index(name)
            built.counts[row, column] = len(points)
            built.points[row, column, : len(points)] = np.array(points)
    built.any[0] = np.count_nonzero(built.counts)
    return built


# ---- The brush -----------------------------------------------------------------------------------

HAIRS = ("goat", "weasel", "mixed")
REFERENCE_LENGTH = 35.0  # mm, the tuft of Guo 2017, Table 2, to which its ranges belong

LARGEST_DRAG_FRACTION = 0.5
"""Upper end of `BrushSpec.drag_fraction`."""

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
    "drag_fraction": (0.0, LARGEST_DRAG_FRACTION),
    "plasticity": (0.0, 1.0),
}
_SEGMENTS = (8.0, 13.0)
_FORCES = (0.1, 100.0)  # N
_TIP_SEGMENT = (0.8, 1.4)  # mm of a tuft of the reference's length
_SHALLOWEST_PRESS = 0.2  # of the length
DEEPEST_PRESS = 0.62
"""Descent over the length at which the table of bent shapes ends: deeper, the ferrule touches."""
_POINT = 2.0  # tip segments
_LONGEST_POINT = 0.15  # of the length
_THINNEST_ROOT = 0.02  # of the length
_THICKEST_ROOT = 0.42  # of the length: thicker, and the ferrule touches within the table


def parameter_ranges(length_mm: float) -> dict[str, tuple[float, float]]:
    """Allowed range of every numeric parameter of a brush with a tuft of this length, mm."""
    scale = length_mm / REFERENCE_LENGTH
    return _RANGES | {
        "n_segments": _SEGMENTS,
        "tip_segment_mm": (_TIP_SEGMENT[0] * scale, _TIP_SEGMENT[1] * scale),
        "root_diameter_mm": (_THINNEST_ROOT * length_mm, _THICKEST_ROOT * length_mm),
        "point_mm": (0.0, _LONGEST_POINT * length_mm),
        "full_press_mm": (_SHALLOWEST_PRESS * length_mm, DEEPEST_PRESS * length_mm),
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
        Descent of the root at which pe = 1 with `rated_hardness`; determines lambda_c.
    load : float
        Ink in a full tuft, full coats times mm2.
    transfer_per_mm : float
        eta', fraction of the ink given per mm of travel at pe = 1.
    drag_fraction : float
        c, how far paper drags the contact back in the dragged mode, 0 to 1/2.
    plasticity : float
        rho, fraction of the bend that remains when the pen lifts, 0 (springs back) to 1.
    max_force : float
        Force at pe = 1, N.
    rated_hardness, rated_segments, rated_tip_share : float, optional
        The hardness at which `full_press_mm`, and the number of segments and tip_segment_mm /
        length_mm at which `stiffness_exponent` holds: what the brush was fitted with. A brush with
        less hardness is pressed deeper by the same force, one with a shorter tip segment bends more
        at its tip. NaN: the brush's own.
    bristles : BristleSpec, optional
        Single hairs that it paints with; None: a solid tuft.
    inputs : mapping, optional
        Curves by which the hand drives the brush: ``{setting: {input: [[x, factor], ...]}}``; see
        `check_curves`.

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
            raise BrushError("name is {name!r}; expected a non-empty string", name=self.name)
        if self.hair not in HAIRS:
            raise BrushError(
                "brush {name!r}: hair is {hair!r}; expected one of {hairs}",
                name=self.name,
                hair=self.hair,
                hairs=", ".join(HAIRS),
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
                "brush {name!r}: n_segments is {n_segments}; expected a whole number",
                name=self.name,
                n_segments=self.n_segments,
            )
        object.__setattr__(self, "n_segments", int(self.n_segments))
        object.__setattr__(self, "inputs", check_curves(self.inputs, self.name))
        if not isinstance(self.bristles, BristleSpec | None):
            raise BrushError(
                "brush {name!r}: bristles is {kind}; expected a BristleSpec or nothing",
                name=self.name,
                kind=type(self.bristles).__name__,
            )

    def _check(self, parameter: str, low: float, high: float) -> None:
        what = f"brush {self.name!r}: {parameter}"
        low, high = low * (1.0 - 1e-9), high * (1.0 + 1e-9)  # ends of scaled ranges are rounded
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
        """Descent at pe = 1, mm; a softer brush, which would go deeper, stops at its deepest."""
        press = self.full_press_mm * (self.rated_hardness / self.hardness)
        return min(press, DEEPEST_PRESS * self.length_mm)

    @property
    def greatest_force(self) -> float:
        """Force at pe = 1, N: `max_force`, or less where `press_mm` is limited."""
        is_whole = self.full_press_mm * (self.rated_hardness / self.hardness) <= (
            DEEPEST_PRESS * self.length_mm
        )
        return self.max_force if is_whole else self.spring * self.press_mm

    @property
    def segmentation(self) -> tuple[float, float, float, float] | None:
        """Segments and tip_segment_mm / length_mm, now and as rated; None if they are the same."""
        tip = self.tip_segment_mm / self.length_mm
        if self.n_segments == self.rated_segments and math.isclose(tip, self.rated_tip_share):
            return None
        return float(self.n_segments), tip, float(self.rated_segments), self.rated_tip_share

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
                "arc_lengths span {least:g} to {most:g}; expected 0 to {length_mm:g}",
                least=s.min(),
                most=s.max(),
                length_mm=self.length_mm,
            )
        diameters: AnyArray = self.root_diameter_mm * (s / self.length_mm) ** self.taper
        if self.point_mm > 0.0:
            narrowed = -np.expm1(-s / self.point_mm)
            narrowed[s <= 0.0] = 1.0  # the diameter is 0 there already
            diameters *= narrowed ** (1.0 - self.taper)
        return diameters


# ---- Amount of a dip -----------------------------------------------------------------------------

_LEAST_WETTED = 1e-3  # fraction of a tuft
_FULLEST, _EMPTIEST = 3.0, 0.05


@dataclass(frozen=True)
class DipAmount:
    """The load of a brush after a dip, relative to its preset.

    A fraction f of the tuft is wet and filled g times as full as in the preset. It holds f g of the
    preset's load, and gives R (1 - exp(-eta' pe ds / f)) of its load (docs/model.md, equation
    (10)): at first g times what a whole dip gives, for any f, but a smaller f runs dry sooner. So a
    large brush writes a few small characters and is dipped again.

    Attributes
    ----------
    wetted : float
        f, .001 to 1.
    fullness : float
        g, .05 to 3.

    Raises
    ------
    InputError
        If one of them is out of range.
    """

    wetted: float = 1.0
    fullness: float = 1.0

    def __post_init__(self) -> None:
        as_number(self.wetted, "wetted share of the tuft", _LEAST_WETTED, 1.0)
        as_number(self.fullness, "fullness of a dip", _EMPTIEST, _FULLEST)

    @classmethod
    def of(cls, words: object) -> DipAmount:
        """Parse the amount in a recording's header: ``{"wetted": .., "fullness": ..}``.

        Raises
        ------
        InputError
            For anything else.
        """
        if not isinstance(words, Mapping) or set(words) - {"wetted", "fullness"}:
            raise InputError("a dip is {words!r:.60}; expected wetted and fullness", words=words)
        return cls(**words)

    def words(self) -> dict[str, Any]:
        """Return the form that `of` parses."""
        return {"wetted": self.wetted, "fullness": self.fullness}

    def of_tuft(self, tuft: Tuft) -> Tuft:
        """Return `tuft` with this load when full, and the matching rate of transfer."""
        return tuft._replace(
            load=tuft.load * self.wetted * self.fullness,
            transfer_per_mm=tuft.transfer_per_mm / self.wetted,
        )
