"""A tuft of single hairs: every hair bent, laid on the surface, and kept at its length.

The frame is that of `brush_engine.tuft`: the origin is the root's foot in the stamp's plane, x runs
along the bend, y to its side, z up. A hair starts from its own place (a, b) in the ferrule's disc
and is known by `SAMPLES` points, tip first. Its deformation is looked up by its own height over the
surface, in its own length, and by the tilt: three heights that span those of all hairs are read
from the table, and each hair is interpolated between them by a parabola. Around that curve it keeps
its place in the tuft's section (Guo 2017, Eqs. 2, 3): a hair in the section (a, b), a pointing
down, is `a C_2 / 2` below the spine and `b C_1 / 2` beside it, so that the hairs that meet the
plane are those within the outline of Eq. 8; near the tip hairs keep three quarters of their
thickness and film within it. Then one pass from the root to the tip lays it on the surface: no
point under it, every piece as long as it was.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.tuft import round_diameter
from paint3d.core.arrays import zeros_on_lines
from paint3d.core.kernel import kernel

__all__ = [
    "ARCS",
    "BEND",
    "BLOCK",
    "FLAT",
    "SAMPLES",
    "Bristles",
    "Cause",
    "bend_hairs",
    "clump_pulls",
    "fill_bend",
    "find_clumps",
    "make_block",
    "make_points",
    "make_turned",
    "turn_hairs",
]  # fmt: skip

SAMPLES = 8  # points of a hair
BLOCK = 336  # hairs bent together: what they take stays in the fastest memory, and few places of
# the last block stay empty for 1,000 hairs (8 of 1,008) and 10,000 (80)
ARCS = (np.arange(SAMPLES) / (SAMPLES - 1.0)) ** 1.5  # of the length, from the tip
ARCS[1] = 0.045  # a light touch bends the last millimetre: it takes a short piece
ARCS.setflags(write=False)
_NODES = 3  # heights read from the table for one imprint
_NEAR_TIP = 1  # last piece from the tip on which hairs that are too long go ahead, not aside, and
# on which lower hairs keep the width of the tuft where they lie
_INSET = 0.75  # of a hair's radius with its film: kept within the tuft
_INSET_TO = (0.17, 0.3)  # of the length, from the tip: whole, and no more
_REACHES = (0.35, 2.2)  # of the fall under its tip, what a pressed tuft makes up for at the least,
# and how much less for the pressure
_POINTED = 0.5  # of the way to the middles of its points: how far hairs of a split tuft come
_LEAST_RIDE = 0.5  # mm, what a hair of the upper side rides above the surface at the tip

_ZERO, _ONE, _FOUR, _TINY = np.float32([0.0, 1.0, 4.0, 1e-12])
# A root and a division cost as much as all the rest of a piece: `arcp` and `afn` let the compiler
# take the processor's estimate of 1 / sqrt(x) and one step of Newton's, right to 2e-7.
# And loops are kept short, with a row of scratch between them: a long chain of steps that wait for
# one another fills the processor's window, and a hair's whole piece in one loop takes half as long
# again.
_elementwise = kernel(error_model="numpy", fastmath={"contract", "arcp", "afn"})

# Rows of a block, one after another in one array: places that the compiler knows to be apart, so
# that it can use vector instructions without asking.
_X, _Y, _Z = 0, BLOCK, 2 * BLOCK  # of points
_KNOWN = 9  # of hairs:
DOWN, BESIDE, _PULL, _PULL2, _OWN, _PER_OWN, _FLAT, _UP, _PULL3 = (
    at * BLOCK for at in range(_KNOWN)
)
_NODE, _PART, _RUN, _LIFTED = (at * BLOCK for at in range(4))  # scratch
BLOCK_SIZE = 4 * BLOCK
_TRIFLE = np.float32(-0.02)  # mm, height from which a point may be lifted to the plane off-hand
_UNDER, _FAR_UNDER = np.array([-0.0, _TRIFLE], np.float32).view(np.uint32)  # see `_lowest`

BEND = np.dtype(
    [
        ("height", "f8"),  # of the root of the tuft's spine over the plane, mm
        ("per_height", "f8"),  # one over the straight spine's height, 1/mm
        ("first", "f8"),  # column of the lowest of the three heights
        ("per_span", "f8"),  # one over how far it is from there to the highest
        ("ground", "f8", 3),  # surface under the hairs' bellies: constant, by b, by b^2
        ("patch", "f8", 6),  # surface: constant, by x, by y, by x^2, by x y, by y^2
        ("curved", "f8"),  # 1.0 where it is not the plane
        ("reach", "f8"),  # how many points, from the tip, may come down to the plane
        ("curve", "f8", (2 * SAMPLES, _NODES)),  # x, then z of the points: parabolas by the height
        ("offset_x", "f8", SAMPLES),  # of a hair from the spine: by a
        ("offset_z", "f8", SAMPLES),
        ("ride", "f8", SAMPLES),  # how high hairs of the upper side stay
        ("side", "f8", SAMPLES),  # half the tuft's width: by b
        ("free", "f8", SAMPLES),  # how freely a point moves aside, 0 in the ferrule to 1
        ("shift_x", "f8", SAMPLES),  # remembered bend
        ("shift_y", "f8", SAMPLES),
        ("part", "f8", 3),  # how far large and small clumps have parted, and points
        ("flat", "f8"),  # how flat the tuft is pressed, 0 to 1
        ("per_step", "f8", SAMPLES - 1),  # 4 over the length of the piece above a point, 1/mm
        ("wider", "f8", SAMPLES),  # how much wider the tuft is where its lowest hairs' points lie
        ("thin", "f8", SAMPLES),  # half the tuft's thickness
        ("sine", "f8", SAMPLES),  # of its angle to the plane
        ("cosine", "f8", SAMPLES),
        ("film", "f8", SAMPLES),  # how thick films are, 1 but in the tuft's point
        ("own", "f8"),  # 1.0 where hairs lie otherwise than Guo 2017, Eq. 8, has the tuft
    ],
    align=True,
)
"""Bend that all hairs of one imprint have in common; lengths in mm, rows from the tip."""

FLAT = np.zeros(6)  # the patch of a plane
FLAT.setflags(write=False)


def _fit_cap(degree: int = 4) -> tuple[np.float32, ...]:
    """Fit the part of a half disc of radius 1 beyond x, over (1 - x)^1.5, by powers of x.

    Least squares at Chebyshev's nodes; within 1e-6 of the fraction (tested).
    """
    x = 0.5 + 0.5 * np.cos(np.pi * (np.arange(200) + 0.5) / 200.0)
    fraction = 1.0 - 2.0 / np.pi * (np.arcsin(x) + x * np.sqrt(1.0 - x * x))
    weight = (1.0 - x) ** 1.5
    powers = np.polynomial.polynomial.polyfit(x, fraction / weight, degree, w=weight + 1e-3)
    return tuple(powers.astype(np.float32))


_CAP = _fit_cap()


class Bristles(NamedTuple):
    """Hairs made ready for kernels (B hairs); built by `paint3d.brush.bristles.build_bristles`."""

    count: int  # hairs; the last block is filled up with copies of the last one
    places: NDArray  # (2, B / BLOCK, BLOCK) float32, where each is in the ferrule's unit disc
    lengths: NDArray  # (B / BLOCK, BLOCK) float32, over the tuft's, at most 1
    rests: NDArray  # (B / BLOCK, SAMPLES - 1, BLOCK) float32, of the pieces from the tip up, mm
    shapes: NDArray  # (tilts, heights, 3 SAMPLES) float32: x, z over the length, angle (rad)
    fans: NDArray  # (tilts, heights, 2) float32: measured spread (rad), from which length on
    clumps: NDArray  # (3, cells) float32: where in [-1, 1] the middle of a place's clump is
    appetite: NDArray  # (cells,) float32: how readily the hairs at a place give, mean 1
    retention: NDArray  # (cells,) float32: how wet they must be to give at all, 0 to 1, evenly
    shortest: float  # of `lengths`
    lowest_tilt: float  # rad
    greatest_fraction: float  # descent over the straight hair's height in the last column
    hair_mm: float  # radius of a dry hair
    film_mm: float  # what ink adds to it at the most
    threshold_mm: float  # over the surface, within which a hair leaves ink
    parting: float  # how far clumps part when dry, 0 to 1
    splay: float  # how far a dry tuft's hairs lie side by side to their tips, 0 to 1
    levelling_mm: float  # way over which neighbours exchange their ink
    root_mm: float  # diameter of the tuft
    bundle_mm: float  # breadth of the bundles that a dry stroke shows, at the belly
    set_mm: float  # descent over which a remembered bend is pressed out


class Cause(NamedTuple):
    """Cause of a bend: all that the shape of an imprint's hairs follows from."""

    descent: float  # D_s, mm
    tilt: float  # theta, rad
    pressure: float  # pe, 0 to 1
    patch: NDArray  # (6,) height of the surface over the plane, mm: by 1, x, y, x^2, x y, y^2
    dryness: float  # of the tuft, 0 to 1
    parted: float  # how far its clumps have parted, 0 to 1
    split: float  # and how far it has split into points, 0 to 1
    set_x: float  # bend that it remembers: where that carries the tip, mm
    set_y: float


class _Place(NamedTuple):
    """Height of a tuft, and the position in the tables at which its shape is read."""

    tall: float  # straight, mm
    height: float  # pressed as it is: of its root over the plane, mm
    row: int
    fraction: float  # of the row after it
    column: float  # of the whole tuft, in columns
    per_column: float  # of the root of a height's fraction


def make_block() -> NDArray:
    """Scratch of `bend_hairs`."""
    return zeros_on_lines(BLOCK_SIZE, np.float32)


def make_turned(blocks: int) -> NDArray:
    """Room for what `turn_hairs` gives for so many blocks of hairs."""
    return zeros_on_lines((blocks, _KNOWN * BLOCK), np.float32)


def make_points(blocks: int) -> NDArray:
    """Room for the points of so many blocks of hairs."""
    return zeros_on_lines((blocks, SAMPLES, 3 * BLOCK), np.float32)


@_elementwise
def _find_even(row):
    """Fractions of the disc on this side of b, as places: pressed flat, hairs lie evenly."""
    q0, q1, q2, q3, q4 = _CAP
    for j in range(BLOCK):
        b = row[BESIDE + j]
        x = abs(b)
        x = x if x < _ONE else _ONE
        cap = _ONE - x
        cap *= np.sqrt(cap) * (q0 + x * (q1 + x * (q2 + x * (q3 + x * q4))))
        row[_FLAT + j] = _ONE - cap if b > _ZERO else cap - _ONE


@kernel(error_model="numpy")
def turn_hairs(bristles, cosine, sine, out):
    """Places (a, b) of the hairs for a bend turned in the handle, and their pulls to clumps.

    Parameters
    ----------
    bristles : Bristles
    cosine, sine : float
        Of the angle from the ferrule's first axis to the bend.
    out : (B / BLOCK, 9 BLOCK) float32
        For a block of hairs: a (down), b (to the side), how far the middles of their clumps are,
        large and small, their lengths, one over these, how far they move where the tuft is pressed
        flat, how far they are on its upper side, and how far the middles of their points are.
    """
    c, s = np.float32(cosine), np.float32(sine)
    wide, narrow, points = bristles.clumps[0], bristles.clumps[1], bristles.clumps[2]
    cells = wide.shape[0]
    half, one = np.float32(0.5 * cells), np.float32(1.0)
    top = np.int32(cells - 1)
    for g in range(out.shape[0]):
        u, v, own = bristles.places[0, g], bristles.places[1, g], bristles.lengths[g]
        row = out[g]
        for j in range(BLOCK):
            row[DOWN + j] = -(c * u[j] + s * v[j])
        for j in range(BLOCK):
            row[BESIDE + j] = c * v[j] - s * u[j]
        for j in range(BLOCK):
            row[_UP + j] = max(np.float32(0.0), -row[DOWN + j])
        for j in range(BLOCK):
            row[_OWN + j] = own[j]
        for j in range(BLOCK):
            row[_PER_OWN + j] = one / own[j]
        _find_even(row)
        for j in range(BLOCK):
            even = row[_FLAT + j]
            cell = min(top, np.int32((even + one) * half))
            row[_PULL + j] = wide[cell] - even
            row[_PULL2 + j] = narrow[cell] - even
            row[_PULL3 + j] = points[cell] - even
        for j in range(BLOCK):
            row[_FLAT + j] -= row[BESIDE + j]


@kernel(error_model="numpy")
def find_clumps(known, j):
    """Which clumps and point hair j of a block belongs to: the sum of their middles.

    `known` (9 BLOCK,) is of `turn_hairs`.
    """
    even = np.float64(known[_FLAT + j]) + known[BESIDE + j]
    return 3.0 * even + known[_PULL + j] + known[_PULL2 + j] + known[_PULL3 + j]


@kernel(error_model="numpy")
def _find_place(bristles, tuft, cause):
    n_tilts, n_columns, _ = bristles.shapes.shape
    row = (cause.tilt - bristles.lowest_tilt) * (n_tilts - 1)
    row /= 0.5 * np.pi - bristles.lowest_tilt
    row = min(max(row, 0.0), n_tilts - 1.0)
    i = min(int(row), n_tilts - 2)
    tall = tuft.length * np.sin(cause.tilt)
    per_column = (n_columns - 1.0) / np.sqrt(bristles.greatest_fraction)
    column = min(np.sqrt(max(cause.descent, 0.0) / tall) * per_column, n_columns - 1.0)
    return _Place(tall, tall - cause.descent, i, row - i, column, per_column)


@kernel(error_model="numpy")
def _row(table, at, column, k):
    """Return one number of the table at a position's tilt and a column."""
    i, v = at.row, at.fraction
    j = min(int(column), table.shape[1] - 2)
    u = column - j
    low = (1.0 - v) * ((1.0 - u) * table[i, j, k] + u * table[i, j + 1, k])
    return low + v * ((1.0 - u) * table[i + 1, j, k] + u * table[i + 1, j + 1, k])


@kernel(error_model="numpy")
def _patch_at(patch, x, y):
    return (
        patch[0] + patch[1] * x + patch[2] * y + patch[3] * x * x + patch[4] * x * y
        + patch[5] * y * y
    )  # fmt: skip


@kernel(error_model="numpy")
def fill_bend(bristles, tuft, cause, bend):
    """Fill everything that the hairs of one imprint have in common.

    Parameters
    ----------
    bristles : Bristles
    tuft : Tuft
    cause : Cause
    bend : record of BEND
        Filled.
    """
    at = _find_place(bristles, tuft, cause)
    _shape_section(bristles, tuft, cause, at, bend)
    _remember_bend(bristles, cause, bend)
    _lay_ground(bristles, tuft, cause, at, bend)
    _fit_curves(bristles, tuft, at, bend)
    _find_lags(bend)
    _widen(tuft, bend)


@kernel(error_model="numpy")
def _find_departure(bristles, length, pressed, at, side):
    """The arc up to which the tuft's underside lies on the plane; `side` are its radii."""
    before = 0.0
    for k in range(1, SAMPLES):
        angle = _row(bristles.shapes, at, at.column, 2 * SAMPLES + k)
        over = length * _row(bristles.shapes, at, at.column, SAMPLES + k)
        over -= side[k] / pressed * np.cos(angle)
        if over > 0.0:
            fraction = before / (before - over) if before < 0.0 else 0.0
            return length * (ARCS[k - 1] + fraction * (ARCS[k] - ARCS[k - 1]))
        before = over
    return 0.0


@kernel(error_model="numpy")
def _shape_section(bristles, tuft, cause, at, bend):
    """Fill the tuft's thickness, breadth and lean at its points; `wider` gets its radii.

    Also how many of its points may come down to the plane, of those that are not yet pressed.
    """
    length, dryness = tuft.length, cause.dryness
    radius = 0.5 * tuft.diameters[-1]
    for k in range(SAMPLES):
        bend.side[k] = 0.5 * round_diameter(tuft, ARCS[k] * length)
    fan = _row(bristles.fans, at, at.column, 0)
    fan_length = _row(bristles.fans, at, at.column, 1) * length
    pressed = 1.0 + (tuft.spread * cause.pressure if fan_length <= 0.0 else 0.0)
    bend.own = 0.0 if fan_length <= 0.0 else 1.0
    departure = _find_departure(bristles, length, pressed, at, bend.side)
    broad = 0.5 * round_diameter(tuft, departure) * pressed
    tilted = _row(bristles.shapes, at, at.column, 3 * SAMPLES - 1)
    bend.reach = _find_reach(length, at.height - radius * abs(np.cos(tilted)), bend.side)
    inset = _INSET * (bristles.hair_mm + (1.0 - dryness) * bristles.film_mm)
    for k in range(SAMPLES):
        arc = ARCS[k] * length
        angle = _row(bristles.shapes, at, at.column, 2 * SAMPLES + k)
        sine, cosine = np.sin(angle), np.cos(angle)
        round_ = bend.side[k]
        # what spreads is the part that is pressed; above it the hairs gather into the ferrule
        spread = 1.0 + (pressed - 1.0) * min(1.0, (length - arc) / (length - departure))
        thin = round_ / spread
        bend.wider[k] = round_
        bend.thin[k], bend.sine[k], bend.cosine[k] = thin, sine, cosine
        bend.offset_x[k], bend.offset_z[k] = -thin * sine, -thin * cosine
        bend.ride[k] = max(thin, _LEAST_RIDE) * (1.0 - ARCS[k])
        side = round_ * spread
        if arc < departure:  # dry hairs do not come together in a point: they lie side by side
            side += bristles.splay * dryness * (broad - side)
        side += np.tan(fan) * max(0.0, fan_length - arc)
        tip = min(1.0, max(0.0, (_INSET_TO[1] - ARCS[k]) / (_INSET_TO[1] - _INSET_TO[0])))
        bend.film[k] = min(1.0, arc / tuft.point) if tuft.point > 0.0 else 1.0
        bend.side[k] = max(side - inset * tip, 0.25 * side)
        if k < SAMPLES - 1:
            bend.per_step[k] = 4.0 / ((ARCS[k + 1] - ARCS[k]) * length)


@kernel
def clump_pulls(parted, split, out):
    """Fill `out` (3,): how far hairs come to the middles of large and small clumps, and of points.

    From how far the tuft has parted and split, 0 to 1.
    """
    out[0] = 0.5 * parted
    out[1] = (1.0 - 0.5 * parted) * 0.85 * parted
    out[2] = _POINTED * split


@kernel(error_model="numpy")
def _remember_bend(bristles, cause, bend):
    """The bend that stays in the tuft, as far as it is not pressed out, and its clumps."""
    stays = np.exp(-max(cause.descent, 0.0) / bristles.set_mm)
    for k in range(SAMPLES):
        free = 1.0 - ARCS[k]
        bend.free[k] = min(1.0, 1.6 * free)
        keep = free * free * stays
        bend.shift_x[k] = cause.set_x * keep
        bend.shift_y[k] = cause.set_y * keep
    clump_pulls(cause.parted, cause.split, bend.part)
    bend.flat = min(1.0, 3.0 * cause.pressure)


@kernel(error_model="numpy")
def _lay_ground(bristles, tuft, cause, at, bend):
    """The surface under the tuft, and under the bellies of its hairs."""
    length, patch = tuft.length, cause.patch
    curved = 0.0
    reach = length * _row(bristles.shapes, at, at.column, 0)
    for k in range(6):
        bend.patch[k] = patch[k]
        curved = max(curved, abs(patch[k]) * (1.0 if k == 0 else reach if k < 3 else reach * reach))
    bend.curved = 1.0 if curved > 1e-3 else 0.0
    bend.own = max(bend.own, bend.curved)
    belly = length * _row(bristles.shapes, at, at.column, 2)
    side = bend.side[2]
    # what hairs bend over: the belly of the tuft; and where the surface falls away from there,
    # their tips reach for it, the more the less of the tuft is pressed
    ground = _patch_at(patch, belly, 0.0)
    falls = max(0.0, ground - _patch_at(patch, reach, 0.0))
    bend.ground[0] = ground - max(_REACHES[0], 1.0 - _REACHES[1] * cause.pressure) * falls
    bend.ground[1] = (patch[2] + patch[4] * belly) * side
    bend.ground[2] = patch[5] * side * side


@kernel(error_model="numpy")
def _fit_curves(bristles, tuft, at, bend):
    """The spine at three heights that span those of all hairs, as parabolas between these."""
    length, tall, height = tuft.length, at.tall, at.height
    per_column, last = at.per_column, bristles.shapes.shape[1] - 1.0
    low = high = 0.0
    for b in (-1.0, -0.5, 0.5, 1.0):
        rise = b * (bend.ground[1] + b * bend.ground[2])
        low, high = min(low, rise), max(high, rise)
    span_low = 1.0 - (height - bend.ground[0] - low) / (bristles.shortest * tall)
    span_high = 1.0 - (height - bend.ground[0] - high) / tall
    first = min(np.sqrt(max(span_low, 0.0)) * per_column, last)
    final = min(np.sqrt(max(span_high, 0.0)) * per_column, last)
    final = max(final, first + 1e-3)
    bend.height = height
    bend.per_height = 1.0 / tall
    bend.first = first / per_column
    bend.per_span = per_column / (final - first)
    for k in range(2 * SAMPLES):
        y0 = length * _row(bristles.shapes, at, min(first, last), k)
        y1 = length * _row(bristles.shapes, at, min(0.5 * (first + final), last), k)
        y2 = length * _row(bristles.shapes, at, min(final, last), k)
        bend.curve[k, 0] = y0
        bend.curve[k, 1] = -3.0 * y0 + 4.0 * y1 - y2
        bend.curve[k, 2] = 2.0 * y0 - 4.0 * y1 + 2.0 * y2


@kernel(error_model="numpy")
def _find_lags(bend):
    """Fill the lag of the lowest hairs behind the spine at its points: their path is longer.

    The tuft's radii stand in `wider`; the lags are put there.
    """
    lag = x_above = z_above = round_above = low_x_above = low_z_above = 0.0
    for k in range(SAMPLES - 1, -1, -1):
        rise = SAMPLES + k
        x = bend.curve[k, 0] + bend.curve[k, 1] + bend.curve[k, 2]
        z = bend.curve[rise, 0] + bend.curve[rise, 1] + bend.curve[rise, 2]
        low_x, low_z = x + bend.offset_x[k], max(0.0, z + bend.offset_z[k])
        round_ = bend.wider[k]
        if k < SAMPLES - 1:
            dx, dz, dr = x - x_above, z - z_above, round_ - round_above
            low_dx, low_dz = low_x - low_x_above, low_z - low_z_above
            lag += np.sqrt(low_dx * low_dx + low_dz * low_dz)
            lag -= np.sqrt(dx * dx + dz * dz + dr * dr)
        x_above, z_above, round_above, low_x_above, low_z_above = x, z, round_, low_x, low_z
        bend.wider[k] = lag


@kernel(error_model="numpy")
def _widen(tuft, bend):
    """Widening of the tuft at the last points of its lowest hairs, from their lag.

    Near the tip the tuft widens fast: a hair that ends a millimetre behind it does not come to its
    point. Farther up it hardly matters.
    """
    bend.wider[_NEAR_TIP + 1 :] = 0.0
    for k in range(_NEAR_TIP + 1):
        at = min(max(ARCS[k] + bend.wider[k] / tuft.length, 0.0), 1.0)
        i = k
        while i < SAMPLES - 2 and ARCS[i + 1] < at:
            i += 1
        fraction = max(0.0, (at - ARCS[i]) / (ARCS[i + 1] - ARCS[i]))
        if i == 0:
            fraction = round_diameter(tuft, at * tuft.length)
            fraction /= round_diameter(tuft, ARCS[1] * tuft.length)
        side = bend.side[i] + fraction * (bend.side[i + 1] - bend.side[i])
        bend.wider[k] = side - bend.side[k] if fraction > 0.0 else 0.0


@kernel(error_model="numpy")
def _find_reach(length, lowest, side):
    """Count the points of the tuft's outermost hairs that may come down to the plane.

    `lowest` is how high the lowest root is, `side` are the tuft's radii.
    """
    for k in range(SAMPLES - 2, -1, -1):
        along = (ARCS[k + 1] - ARCS[k]) * length
        lowest -= np.hypot(along, side[k + 1] - side[k])
        if lowest < 1e-3:
            return k + 1
    return 0


@_elementwise
def _start_block(bend, known, w, here):
    """Fill the positions of a block's hairs between the three heights, and their roots."""
    height, per_height = np.float32(bend.height), np.float32(bend.per_height)
    first, per_span = np.float32(bend.first), np.float32(bend.per_span)
    g0 = np.float32(bend.ground[0])
    g1, g2 = np.float32(bend.ground[1]), np.float32(bend.ground[2])
    dx, dz = np.float32(bend.offset_x[SAMPLES - 1]), np.float32(bend.offset_z[SAMPLES - 1])
    side = np.float32(bend.side[SAMPLES - 1])
    part, part2, part3 = (
        np.float32(bend.part[0]),
        np.float32(bend.part[1]),
        np.float32(bend.part[2]),
    )
    flat = np.float32(bend.flat)
    for j in range(BLOCK):
        b = known[BESIDE + j]
        fraction = _ONE - (height - (g0 + b * (g1 + b * g2))) * per_height * known[_PER_OWN + j]
        fraction = fraction if fraction > _ZERO else _ZERO
        w[_NODE + j] = np.sqrt(fraction)
    for j in range(BLOCK):
        a, b = known[DOWN + j], known[BESIDE + j]
        t = (w[_NODE + j] - first) * per_span
        t = t if t > _ZERO else _ZERO
        t = t if t < _ONE else _ONE
        w[_NODE + j] = t
        w[_PART + j] = known[_PULL + j] * part + known[_PULL2 + j] * part2 + known[_FLAT + j] * flat
        w[_PART + j] += known[_PULL3 + j] * part3
        here[_X + j] = a * dx
        here[_Y + j] = b * side
        here[_Z + j] = height + a * dz


@_elementwise
def _piece(bend, k):
    """Numbers that all hairs have in common on the way to their point k.

    Returns how far their curves lead ahead, and from the root up: constant, by t, by t^2, by a; how
    far the remembered bend leads ahead; their widths; and how high the root is.
    """
    curve, rise, root = bend.curve, SAMPLES + k, 2 * SAMPLES - 1
    ahead = (
        np.float32(curve[k, 0] - curve[k + 1, 0]),
        np.float32(curve[k, 1] - curve[k + 1, 1]),
        np.float32(curve[k, 2] - curve[k + 1, 2]),
        np.float32(bend.offset_x[k] - bend.offset_x[k + 1]),
    )
    shift = np.float32(bend.shift_x[k] - bend.shift_x[k + 1])
    aside = (
        np.float32(bend.side[k]),
        np.float32(bend.wider[k]),
        np.float32(bend.side[k] * bend.free[k]),
        np.float32(bend.shift_y[k]),
    )
    up = (
        np.float32(curve[rise, 0] - curve[root, 0]),
        np.float32(curve[rise, 1] - curve[root, 1]),
        np.float32(curve[rise, 2] - curve[root, 2]),
        np.float32(bend.offset_z[k]),
    )
    return ahead, shift, aside, up, np.float32(bend.height)


@_elementwise
def _place(curve, t, own, a, base):
    """Coordinate to which a hair's own curve leads in one direction."""
    c0, c1, c2, offset = curve
    return own * (c0 + t * (c1 + t * c2)) + (a * offset + base)


@_elementwise
def _aim(bend, k, known, w, above, here):
    """Fill the steps of the hairs' own curves over a plane, from their last points."""
    ahead, sx, (side, wider, parting, sy), up, height = _piece(bend, k)
    ride = np.float32(bend.ride[k])
    for j in range(BLOCK):
        t, own, a = w[_NODE + j], known[_OWN + j], known[DOWN + j]
        here[_X + j] = _place(ahead, t, own, a, sx)
    if k <= _NEAR_TIP:
        for j in range(BLOCK):
            broad = side + wider * (known[DOWN + j] + known[_UP + j])  # of the lower side
            aside = w[_PART + j] * parting + (sy - above[_Y + j])
            here[_Y + j] = known[BESIDE + j] * broad + aside
    else:
        for j in range(BLOCK):
            aside = w[_PART + j] * parting + (sy - above[_Y + j])
            here[_Y + j] = known[BESIDE + j] * side + aside
    for j in range(BLOCK):
        t, own, a = w[_NODE + j], known[_OWN + j], known[DOWN + j]
        low = _place(up, t, own, a, height)
        least = known[_UP + j] * ride  # hairs of the upper side lie on those below
        here[_Z + j] = (low if low > least else least) - above[_Z + j]


@_elementwise
def _aim_patch(bend, k, known, w, above, here):
    """`_aim` over a curved patch, asked for where the hairs' curves lead to."""
    ahead, sx, (side, wider, parting, sy), up, height = _piece(bend, k)
    ride = np.float32(bend.ride[k])
    s0, s1, s2, s3, s4, s5 = _patch(bend)
    for j in range(BLOCK):
        t, own, a = w[_NODE + j], known[_OWN + j], known[DOWN + j]
        broad = side + wider * (a + known[_UP + j])
        here[_X + j] = _place(ahead, t, own, a, sx)
        here[_Y + j] = known[BESIDE + j] * broad + (w[_PART + j] * parting + (sy - above[_Y + j]))
        here[_Z + j] = _place(up, t, own, a, height)
    for j in range(BLOCK):
        x, y = above[_X + j] + here[_X + j], above[_Y + j] + here[_Y + j]
        ground = s0 + x * (s1 + s3 * x + s4 * y) + y * (s2 + s5 * y)
        least, low = ground + known[_UP + j] * ride, here[_Z + j]
        here[_Z + j] = (low if low > least else least) - above[_Z + j]


@_elementwise
def _step_free(rest, above, here):
    """Take steps at the pieces' lengths: what is longer or shorter is so in every direction."""
    for j in range(BLOCK):
        ex, ey, ez = here[_X + j], here[_Y + j], here[_Z + j]
        run = rest[j] * _per_root(ex * ex + (ey * ey + (ez * ez + _TINY)))
        here[_X + j] = above[_X + j] + ex * run
        here[_Y + j] = above[_Y + j] + ey * run
        here[_Z + j] = above[_Z + j] + ez * run


@_elementwise
def _step(bend, k, known, rest, w, above, here):
    """Take steps at the pieces' lengths.

    What a hair is longer than its curve takes it ahead, what it is shorter leaves it behind.
    """
    per_step = np.float32(bend.per_step[k])
    for j in range(BLOCK):
        ex, ey, ez = here[_X + j], here[_Y + j], here[_Z + j]
        w[_RUN + j] = rest[j] * _per_root(ex * ex + (ey * ey + (ez * ez + _TINY)))
    for j in range(BLOCK):
        run = w[_RUN + j]
        over = run - _ONE if run > _ONE else _ZERO
        led = here[_X + j] * per_step  # the more it points ahead, the less of the rest goes aside
        led = led if led > _ZERO else _ZERO
        rides = _FOUR * known[_UP + j]  # and hairs of the upper side stay on those below
        here[_Y + j] *= run - over * (led if led < _ONE else _ONE)
        here[_Z + j] *= run - over * (rides if rides < _ONE else _ONE)
    for j in range(BLOCK):
        ex, aside, drop = here[_X + j], here[_Y + j], here[_Z + j]
        scratch = rest[j] * rest[j] - aside * aside - drop * drop
        scratch = scratch if scratch > _TINY else _TINY
        ahead = scratch * _per_root(scratch)
        here[_X + j] = above[_X + j] + (ahead if ex > _ZERO else -ahead)
        here[_Y + j] = above[_Y + j] + aside
        here[_Z + j] = above[_Z + j] + drop


@_elementwise
def _per_root(x):
    """1 / sqrt(x)."""
    return _ONE / np.sqrt(x)


@_elementwise
def _patch(bend):
    patch = bend.patch
    return (
        np.float32(patch[0]), np.float32(patch[1]), np.float32(patch[2]),
        np.float32(patch[3]), np.float32(patch[4]), np.float32(patch[5]),
    )  # fmt: skip


@_elementwise
def _lowest(here):
    """Bits of the lowest height: above `_UNDER` where any point is under the plane.

    As whole numbers without a sign, numbers below 0 come after all others, the lower the later;
    and the greatest of whole numbers is found eight at a time.
    """
    bits = here[_Z : _Z + BLOCK].view(np.uint32)
    most = np.uint32(0)
    for j in range(BLOCK):
        most = bits[j] if bits[j] > most else most
    return most


@_elementwise
def _raise_to_plane(here):
    """Put points that are hardly under the plane on it."""
    for j in range(BLOCK):
        z = here[_Z + j]
        here[_Z + j] = z if z > _ZERO else _ZERO


@_elementwise
def _raise(rest, w, above, here):
    """Lift points under the plane to it and slide them on, so that the piece keeps its length."""
    for j in range(BLOCK):
        ex, ey, z1 = here[_X + j] - above[_X + j], here[_Y + j] - above[_Y + j], above[_Z + j]
        scratch = rest[j] * rest[j] - z1 * z1
        scratch = scratch if scratch > _TINY else _TINY
        run = scratch * _per_root(scratch * (ex * ex + (ey * ey + _TINY)))
        w[_RUN + j] = run if here[_Z + j] < _ZERO else _ONE
    for j in range(BLOCK):
        x1, y1, z, run = above[_X + j], above[_Y + j], here[_Z + j], w[_RUN + j]
        here[_X + j] = x1 + (here[_X + j] - x1) * run
        here[_Y + j] = y1 + (here[_Y + j] - y1) * run
        here[_Z + j] = z if z > _ZERO else _ZERO


@_elementwise
def _raise_patch(bend, rest, w, above, here):
    """`_raise` to a curved patch: the ground is asked for where the point came, and once more."""
    s0, s1, s2, s3, s4, s5 = _patch(bend)
    for j in range(BLOCK):
        x, y, z = here[_X + j], here[_Y + j], here[_Z + j]
        ground = s0 + x * (s1 + s3 * x + s4 * y) + y * (s2 + s5 * y)
        w[_LIFTED + j] = z if z > ground else ground
    for j in range(BLOCK):
        ex, ey = here[_X + j] - above[_X + j], here[_Y + j] - above[_Y + j]
        drop = w[_LIFTED + j] - above[_Z + j]
        scratch = rest[j] * rest[j] - drop * drop
        scratch = scratch if scratch > _TINY else _TINY
        w[_RUN + j] = scratch * _per_root(scratch * (ex * ex + (ey * ey + _TINY)))
    for j in range(BLOCK):
        x1, y1, z, run = above[_X + j], above[_Y + j], w[_LIFTED + j], w[_RUN + j]
        x, y = x1 + (here[_X + j] - x1) * run, y1 + (here[_Y + j] - y1) * run
        ground = s0 + x * (s1 + s3 * x + s4 * y) + y * (s2 + s5 * y)
        here[_X + j] = x
        here[_Y + j] = y
        here[_Z + j] = z if z > ground else ground


@kernel(error_model="numpy")
def bend_hairs(rests, turned, bend, block, out):
    """Bend all hairs and lay them on the surface.

    Parameters
    ----------
    rests : (B / BLOCK, SAMPLES - 1, BLOCK) float32
        Of `Bristles`.
    turned : (B / BLOCK, 9 BLOCK) float32
        From `turn_hairs`.
    bend : record of BEND
        From `fill_bend`.
    block : (BLOCK_SIZE,) float32
        Scratch.
    out : (B / BLOCK, SAMPLES, 3 BLOCK) float32
        By blocks, and from the tip up: x, y, z of the hairs' points, mm.
    """
    curved = bend.curved > 0.0
    reach = int(bend.reach)
    for g in range(turned.shape[0]):
        known, above = turned[g], out[g, SAMPLES - 1]
        _start_block(bend, known, block, above)
        for k in range(SAMPLES - 2, -1, -1):
            rest, here = rests[g, k], out[g, k]
            if curved:
                _aim_patch(bend, k, known, block, above, here)
                _step(bend, k, known, rest, block, above, here)
                _raise_patch(bend, rest, block, above, here)
            else:
                _aim(bend, k, known, block, above, here)
                if k > _NEAR_TIP:
                    _step_free(rest, above, here)
                else:
                    _step(bend, k, known, rest, block, above, here)
                lowest = _lowest(here) if k < reach else _UNDER
                if lowest > _FAR_UNDER:
                    _raise(rest, block, above, here)
                elif lowest > _UNDER:
                    _raise_to_plane(here)
            above = here
