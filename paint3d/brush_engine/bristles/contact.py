"""Where each hair of a tuft touches the surface, block by block in vector instructions.

What one imprint finds of every hair is kept in rows of a block's length, one after another in one
array (places below), as in `brush_engine.bristles.bend`.
"""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine.bristles.bend import BLOCK, SAMPLES
from paint3d.brush_engine.bristles.landing import end_where_they_land
from paint3d.core.kernel import kernel, uncounted

__all__ = ["BEGIN", "CONTACT_SIZE", "DOT", "END", "FINDINGS", "GIVES", "HELD", "LAID", "READY",
           "THICK", "add_up", "find_contacts"]  # fmt: skip

# Rows of a block: what an imprint finds of its hairs.
BEGIN, END = 0, BLOCK  # first and last place that touches, in points from the tip; END < 0: none
HELD = 2 * BLOCK  # ink in the hair, coats x mm2
GIVES = 3 * BLOCK  # how readily it gives; then the share of its ink that it gives
DOT = 4 * BLOCK  # radius with its film, mm
LAID = 5 * BLOCK  # what it would leave on a station of the map, as against the others
THICK = 6 * BLOCK  # its width there, 0 where it does not give, mm
READY = 7 * BLOCK  # 4 rows: how readily hairs at its place give, and how wet they must be to
FINDINGS = 11

CONTACT_SIZE = 2 * SAMPLES * BLOCK  # scratch of `find_contacts`

_Y, _Z = BLOCK, 2 * BLOCK
_ZERO, _ONE, _TWO = np.float32([0.0, 1.0, 2.0])
_STEEP = np.float32(1e-4)  # mm
_elementwise = kernel(error_model="numpy", fastmath={"contract"})


@kernel(error_model="numpy")
def add_up(row, size):
    """Sum of the first `size` numbers, which are used up.

    The upper half is added to the lower: vector instructions, and the same bits on every processor.
    """
    while size > 1:
        half = (size + 1) // 2
        for j in range(size - half):
            row[j] += row[half + j]
        size = half
    return row[0]


@_elementwise
def _lay_flat(bend, here, clear):
    """Clearance of points over the patch; x and y become those of their feet along its normal."""
    patch = bend.patch
    p0, p1, p2 = np.float32(patch[0]), np.float32(patch[1]), np.float32(patch[2])
    p3, p4, p5 = np.float32(patch[3]), np.float32(patch[4]), np.float32(patch[5])
    for j in range(BLOCK):
        x, y = here[j], here[_Y + j]
        along, across = p1 + p3 * x + p4 * y, p2 + p5 * y
        ground = p0 + x * along + y * across
        clear[j] = here[_Z + j] - ground
        here[j] = x + ground * (along + p3 * x)
        here[_Y + j] = y + ground * (across + p5 * y + p4 * x)


@_elementwise
def _lift_off(here, clear):
    """Clearance of points over the plane."""
    for j in range(BLOCK):
        clear[j] = here[_Z + j]


@_elementwise
def _follow(at, z, before, piece, near, state):
    """One more point of a hair from the tip: what is known of its first run on the surface."""
    first, count, z_before, z_first, z_last, z_after, rise, seen, runs = state
    inside = z <= near
    starts = inside & (not seen)
    z_before = before if starts else z_before
    z_first = z if starts else z_first
    first = at if starts else first
    ends = runs & (not inside)
    z_after = z if ends else z_after
    rise = piece if ends else rise
    runs = starts | (runs & inside)
    z_last = z if runs else z_last
    count = count + (_ONE if runs else _ZERO)
    return first, count, z_before, z_first, z_last, z_after, rise, seen | inside, runs


@_elementwise
def _note(state, row, j):
    """Keep what is known of a run in the rows of a block."""
    row[j] = state[0]
    row[BLOCK + j] = state[1]
    row[2 * BLOCK + j] = state[2]
    row[3 * BLOCK + j] = state[3]
    row[4 * BLOCK + j] = state[4]
    row[5 * BLOCK + j] = state[5]
    row[6 * BLOCK + j] = state[6]


@_elementwise
def _first_runs(near, slopes, rests, clear, row):
    """First point that touches, how many from there do, the clearances around both ends, and how
    much higher the hair would be at the point after the last if it rose as steeply as there."""
    s1, s2, s3, s4 = slopes[1], slopes[2], slopes[3], slopes[4]
    s5, s6, s7 = slopes[5], slopes[6], slopes[7]
    for j in range(BLOCK):
        z0, z1, z2, z3 = clear[j], clear[BLOCK + j], clear[2 * BLOCK + j], clear[3 * BLOCK + j]
        z4, z5 = clear[4 * BLOCK + j], clear[5 * BLOCK + j]
        z6, z7 = clear[6 * BLOCK + j], clear[7 * BLOCK + j]
        state = (_ZERO, _ZERO, _ZERO, _ZERO, _ZERO, _ONE, _ONE, False, False)
        state = _follow(np.float32(0.0), z0, z0, _ONE, near, state)
        state = _follow(np.float32(1.0), z1, z0, s1 * rests[j], near, state)
        state = _follow(np.float32(2.0), z2, z1, s2 * rests[BLOCK + j], near, state)
        state = _follow(np.float32(3.0), z3, z2, s3 * rests[2 * BLOCK + j], near, state)
        state = _follow(np.float32(4.0), z4, z3, s4 * rests[3 * BLOCK + j], near, state)
        state = _follow(np.float32(5.0), z5, z4, s5 * rests[4 * BLOCK + j], near, state)
        state = _follow(np.float32(6.0), z6, z5, s6 * rests[5 * BLOCK + j], near, state)
        state = _follow(np.float32(7.0), z7, z6, s7 * rests[6 * BLOCK + j], near, state)
        _note(state, row, j)


@_elementwise
def _first_short_runs(near, slopes, rests, clear, row):
    """`_first_runs` where only the first three points touch."""
    s1, s2, s3 = slopes[1], slopes[2], slopes[3]
    for j in range(BLOCK):
        z0, z1, z2, z3 = clear[j], clear[BLOCK + j], clear[2 * BLOCK + j], clear[3 * BLOCK + j]
        state = (_ZERO, _ZERO, _ZERO, _ZERO, _ZERO, _ONE, _ONE, False, False)
        state = _follow(np.float32(0.0), z0, z0, _ONE, near, state)
        state = _follow(np.float32(1.0), z1, z0, s1 * rests[j], near, state)
        state = _follow(np.float32(2.0), z2, z1, s2 * rests[BLOCK + j], near, state)
        state = _follow(np.float32(3.0), z3, z2, s3 * rests[2 * BLOCK + j], near, state)
        _note(state, row, j)


@_elementwise
def _find_ends(near, row, begins, ends):
    """Places between points where the first run begins and ends."""
    per_near = _ONE / near if near > _ZERO else _ZERO
    top = np.float32(SAMPLES - 1)
    for j in range(BLOCK):
        first, count = row[j], row[BLOCK + j]
        share = (near - row[3 * BLOCK + j]) / (row[2 * BLOCK + j] - row[3 * BLOCK + j])
        begins[j] = first - (share if first > _ZERO else _ZERO)
        # a hair leaves the surface as a parabola that has the slope of its next point
        z_last, z_after, rise = row[4 * BLOCK + j], row[5 * BLOCK + j], row[6 * BLOCK + j]
        here = z_last if z_last > _ZERO else _ZERO
        bow = _TWO * z_after / (rise if rise > _STEEP else _STEEP)
        bow = bow if bow < _ONE else _ONE
        flat = (_ONE - bow) * (_ONE - here * per_near)
        scratch = (near - here) / (z_after - here)
        beyond = flat + (_ONE - flat) * np.sqrt(scratch if scratch > _ZERO else _ZERO)
        last = first + count - _ONE
        end = last + (beyond if last < top else _ZERO)
        ends[j] = end if count > _ZERO else -_ONE


@kernel(error_model="numpy")
def _any_near(near, clear):
    """Whether any point of a block is near the surface."""
    count = np.int32(0)
    for j in range(BLOCK):
        count += np.int32(clear[j] <= near)
    return count > 0


@kernel(error_model="numpy")
def _count(row):
    """How many hairs of a block touch, and how far up any of them does, in thirds of a piece."""
    touching, deepest = np.int32(0), np.int32(-1)
    for j in range(BLOCK):
        touching += np.int32(row[END + j] >= _ZERO)
    for j in range(BLOCK):
        deepest = max(deepest, np.int32(row[END + j] * np.float32(16.0)))
    return touching, deepest


@uncounted(error_model="numpy")
def find_contacts(hairs):
    """Which piece of each hair is near enough to the surface to leave ink.

    Parameters
    ----------
    hairs : Hairs
        Bent, with their slopes and landings. Rows BEGIN and END of `hair_contacts` are filled, and
        `depths`: for each block the end of the hair that lies on furthest up, in points, below 0
        for none. On a curved surface points are laid on the plane: x and y become those of their
        feet along the normal.

    Returns
    -------
    int
        How many hairs touch.
    """
    bristles, bend, landing, turned = hairs.bristles, hairs.bend[0], hairs.landing, hairs.turned
    points, hair_contacts, scratch, slopes = (
        hairs.points,
        hairs.hair_contacts,
        hairs.clear,
        hairs.slopes,
    )
    near = np.float32(bristles.threshold_mm)
    curved = bend.curved > 0.0
    touching = 0
    for g in range(points.shape[0]):
        row = hair_contacts[g]
        highest = -1
        for k in range(SAMPLES):
            here, clear = points[g, k], scratch[k * BLOCK : (k + 1) * BLOCK]
            if curved:
                _lay_flat(bend, here, clear)
            else:
                _lift_off(here, clear)
            if _any_near(near, clear):
                highest = k
        rests = bristles.rests[g].reshape((SAMPLES - 1) * BLOCK)
        clear, runs = scratch[: SAMPLES * BLOCK], scratch[SAMPLES * BLOCK :]
        if highest < 3:
            _first_short_runs(near, slopes, rests, clear, runs)
        else:
            _first_runs(near, slopes, rests, clear, runs)
        begins, ends = row[BEGIN : BEGIN + BLOCK], row[END : END + BLOCK]
        _find_ends(near, runs, begins, ends)
        end_where_they_land(bend, landing, turned[g], points[g], highest, runs, begins, ends)
        for j in range(bristles.count - g * BLOCK, BLOCK):  # copies that fill up the last block
            row[END + j] = -_ONE
        n, deepest = _count(row)
        touching += n
        hairs.depths[g] = np.float32(deepest + 1) / np.float32(16.0) if n > 0 else -_ONE
    return touching
