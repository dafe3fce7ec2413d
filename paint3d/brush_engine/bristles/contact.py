"""Where each hair of a tuft touches the surface, block by block in vector instructions.

What one imprint finds of every hair is kept in rows of a block's length, one after another in one
array (places below), as in `brush_engine.bristles.bend`.

Eight points tell how a hair lies, but not where between two of them it leaves the surface: pieces
are up to 9 mm long. The table gives its angle at every point too. A cubic through points and angles
(Hermite's), with the tuft's own taper about it, comes down where the outline of Guo 2017, Eq. 8,
has it, within 0.2 mm; and so do the hairs.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from paint3d.brush_engine.bristles.bend import ARCS, BESIDE, BLOCK, DOWN, SAMPLES
from paint3d.brush_engine.tuft import round_diameter
from paint3d.core.kernel import kernel, uncounted

__all__ = [
    "BEGIN",
    "CONTACT_SIZE",
    "DOT",
    "END",
    "FINDINGS",
    "GIVES",
    "HELD",
    "LAID",
    "LANDING_SIZE",
    "LIES",
    "READY",
    "THICK",
    "add_up",
    "find_contacts",
    "find_landings",
]

# Rows of a block: what an imprint finds of its hairs.
BEGIN, END = 0, BLOCK  # first and last place that touches, in points from the tip; END < 0: none
HELD = 2 * BLOCK  # ink in the hair, coats x mm2
GIVES = 3 * BLOCK  # how readily it gives; then the fraction of its ink that it gives
DOT = 4 * BLOCK  # radius with its film, mm
LAID = 5 * BLOCK  # what it would leave on a station of the map, as against the others
THICK = 6 * BLOCK  # its width there, 0 where it does not give, mm
READY = 7 * BLOCK  # 4 rows: how readily hairs at its place give, and how wet they must be to
LIES = 11 * BLOCK  # how far it lies on the surface, from 0 where it is about to leave it, to 1
FINDINGS = 12

CONTACT_SIZE = 2 * SAMPLES * BLOCK  # scratch of `find_contacts`

_Y, _Z = BLOCK, 2 * BLOCK
_ZERO, _ONE, _TWO, _FOUR = np.float32([0.0, 1.0, 2.0, 4.0])
_STEEP = np.float32(1e-4)  # mm
_elementwise = kernel(error_model="numpy", fastmath={"contract"})
_SIDES = 5  # places for which it is found, from the middle of the tuft (a = 0) to its underside (1)
_TIP = 2 * _SIDES  # where the spine's own tip lies
_BEFORE = _TIP + 1  # scratch: clearances and places one step before
LANDING_SIZE = _BEFORE + 2 * _SIDES
_RIM = 0.3  # of its thickness: so much lower lie the sides of a tuft that is pressed flat
_ON = 0.02  # mm over the surface: on it
_STEPS = 3  # to a piece
_MOST = np.float32(1.5)  # pieces beyond the last point that touches
_LYING = np.float32(4.0)  # to the piece: of so much of one, a hair lies on the surface
_SHORT = np.float32(1e-4)  # mm


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
def _rise_over_plane(here, clear):
    """Clearance of points over the plane."""
    for j in range(BLOCK):
        clear[j] = here[_Z + j]


@_elementwise
def _follow(at, z, before, piece, near, state):
    """Update the state of a hair's first run on the surface by one more point from the tip."""
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
        fraction = (near - row[3 * BLOCK + j]) / (row[2 * BLOCK + j] - row[3 * BLOCK + j])
        begins[j] = first - (fraction if first > _ZERO else _ZERO)
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
def _cubic(fraction, low, rise_low, high, rise_high):
    """Hermite's cubic between two points, from what they are and how they rise."""
    rest = 1.0 - fraction
    ends = (
        rest * rest * (1.0 + 2.0 * fraction) * low
        + fraction * fraction * (3.0 - 2.0 * fraction) * high
    )
    return ends + fraction * rest * (rest * rise_low - fraction * rise_high)


@kernel(error_model="numpy")
def _at(bend, k, t):
    """Number of the hairs' common curve (x of a point, or SAMPLES on its z) at one of 3 heights."""
    curve = bend.curve
    return curve[k, 0] + t * (curve[k, 1] + t * curve[k, 2])


@kernel(error_model="numpy")
def _ground(bend, x):
    """Height of the surface under the bend: hairs follow it where it falls away from their belly,
    and meet it where it rises."""
    rise = bend.patch[0] + x * (bend.patch[1] + x * bend.patch[3])
    return max(bend.ground[0], rise)


class _Section(NamedTuple):
    """The tuft at a place of its spine."""

    x: float  # of the spine, along the bend and over the plane, mm
    z: float
    thin: float  # half its thickness, mm
    sine: float  # of the spine's angle to the plane
    cosine: float


@kernel(error_model="numpy")
def _land(bend, section, found, first, out):
    """Take one step up the curve: those sides that leave the surface in it have landed there."""
    rim = _RIM * bend.flat
    for n in range(found, _SIDES):
        down = max(n / (_SIDES - 1.0), rim) * section.thin
        place = section.x - down * section.sine
        clear = section.z - down * section.cosine - _ground(bend, place) - _ON
        before = out[_BEFORE + n]
        if clear > 0.0:
            x_before = out[_BEFORE + _SIDES + n]
            fraction = before / (before - clear) if before < 0.0 else 0.0
            out[first + n] = x_before + fraction * (place - x_before)
            found = n + 1
        else:
            out[first + n] = place
        out[_BEFORE + n] = clear
        out[_BEFORE + _SIDES + n] = place
    return found


@kernel(error_model="numpy")
def find_landings(tuft, bend, out):
    """Find where along the bend hairs of the tuft's length come down, for the first and last of the
    three heights; over a plane they stand at the last one.

    Parameters
    ----------
    tuft : Tuft
    bend : record of BEND
    out : (LANDING_SIZE,) float64
        For either height the place (mm along the bend) by a from 0 to 1, and where the spine's tip
        lies.
    """
    length = tuft.length
    for height in range(0 if bend.curved > 0.0 else 1, 2):
        t = np.float64(height)
        node = bend.first + t / bend.per_span
        own = (bend.height - bend.ground[0]) * bend.per_height / (1.0 - node * node)
        own = min(1.0, max(0.5, own))
        first = height * _SIDES
        root_z = bend.height - own * _at(bend, 2 * SAMPLES - 1, t)
        x_low = own * _at(bend, 0, t) + bend.shift_x[0]
        z_low = root_z + own * _at(bend, SAMPLES, t)
        if height == 1:
            out[_TIP] = x_low
        out[_BEFORE + _SIDES :] = x_low
        out[_BEFORE : _BEFORE + _SIDES] = z_low - _ground(bend, x_low) - _ON
        sine_low, cosine_low = bend.sine[0], bend.cosine[0]
        found, wide_low = 0, 0.0
        for k in range(SAMPLES - 1):
            if found == _SIDES:
                break
            x_high = own * _at(bend, k + 1, t) + bend.shift_x[k + 1]
            z_high = root_z + own * _at(bend, SAMPLES + k + 1, t)
            sine_high, cosine_high = bend.sine[k + 1], bend.cosine[k + 1]
            step = ARCS[k + 1] - ARCS[k]
            long, wide_high = own * step * length, round_diameter(tuft, ARCS[k + 1] * length)
            for i in range(1, _STEPS + 1):
                u = i / _STEPS
                wide = round_diameter(tuft, (ARCS[k] + u * step) * length) - wide_low
                wide /= wide_high - wide_low
                section = _Section(
                    _cubic(u, x_low, -long * cosine_low, x_high, -long * cosine_high),
                    _cubic(u, z_low, long * sine_low, z_high, long * sine_high),
                    bend.thin[k] + wide * (bend.thin[k + 1] - bend.thin[k]),
                    sine_low + u * (sine_high - sine_low),
                    cosine_low + u * (cosine_high - cosine_low),
                )
                found = _land(bend, section, found, first, out)
            x_low, z_low, sine_low, cosine_low = x_high, z_high, sine_high, cosine_high
            wide_low = wide_high
    if bend.curved <= 0.0:
        out[:_SIDES] = out[_SIDES:_TIP]


@_elementwise
def _find_lands(bend, landing, known, lands):
    """Fill where along the bend each hair comes down, by the ground and its place in the section.

    A tuft comes down as one: that some of its hairs are shorter changes nothing here.
    """
    height, per_height = np.float32(bend.height), np.float32(bend.per_height)
    start, per_span = np.float32(bend.first), np.float32(bend.per_span)
    g0 = np.float32(bend.ground[0])
    g1, g2 = np.float32(bend.ground[1]), np.float32(bend.ground[2])
    c0, c1, c2, c3, c4 = _bends(landing[:_SIDES])
    d0, d1, d2, d3, d4 = _bends(landing[_SIDES:_TIP])
    for j in range(BLOCK):
        a, b = known[DOWN + j], known[BESIDE + j]
        fraction = _ONE - (height - (g0 + b * (g1 + b * g2))) * per_height
        t = (np.sqrt(fraction if fraction > _ZERO else _ZERO) - start) * per_span
        t = t if t > _ZERO else _ZERO
        t = t if t < _ONE else _ONE
        u = _FOUR * (a if a > _ZERO else _ZERO)
        v, w, q = u - _ONE, u - _TWO, u - _ONE - _TWO
        v = v if v > _ZERO else _ZERO
        w = w if w > _ZERO else _ZERO
        q = q if q > _ZERO else _ZERO
        first = c0 + c1 * u + (c2 * v + c3 * w) + c4 * q
        final = d0 + d1 * u + (d2 * v + d3 * w) + d4 * q
        lands[j] = first + t * (final - first)


@_elementwise
def _bends(places):
    """A broken line through places, as its start, its first slope, and how that changes."""
    p0, p1, p2 = np.float32(places[0]), np.float32(places[1]), np.float32(places[2])
    p3, p4 = np.float32(places[3]), np.float32(places[4])
    return p0, p1 - p0, (p2 - p1) - (p1 - p0), (p3 - p2) - (p2 - p1), (p4 - p3) - (p3 - p2)


@_elementwise
def _fraction_ahead(here, next_, x):
    """Fraction of a piece that lies ahead of a place along the bend."""
    run = here - next_
    fraction = (here - x) / (run if run > _SHORT else _SHORT)
    fraction = fraction if fraction > _ZERO else _ZERO
    return fraction if fraction < _ONE else _ONE


@_elementwise
def _add_pieces(lands, near_tip, far, places):
    """Add the fraction of a piece that lies ahead of where its hair comes down."""
    for j in range(BLOCK):
        places[j] += _fraction_ahead(near_tip[j], far[j], lands[j])


@_elementwise
def _hold(landing, known, tip, next_, third, places, row):
    """End the contact of hairs of the lower side where they land, of those above at most there;
    and none ahead of the spine's own tip: what is near the surface only there hangs over it.
    Tell how far each lies on it, so that none begins or ceases to at once."""
    begins, ends = row[BEGIN : BEGIN + BLOCK], row[END : END + BLOCK]
    lies = row[LIES : LIES + BLOCK]
    x_tip, top = np.float32(landing[_TIP]), np.float32(SAMPLES - 1)
    for j in range(BLOCK):
        ahead = _fraction_ahead(tip[j], next_[j], x_tip)
        ahead += _fraction_ahead(next_[j], third[j], x_tip)
        begin = begins[j] if begins[j] > ahead else ahead
        end, place = ends[j], places[j]
        most = end + _MOST if end + _MOST < top else top
        most = end if known[DOWN + j] < _ZERO else most
        place = place if place < most else most
        place = place if place > begin else begin
        most = end if end > place else place
        lying = _LYING * (most - begin)
        lies[j] = lying * lying if lying < _ONE else _ONE
        begins[j] = begin
        ends[j] = place if end >= ahead else -_ONE


@kernel(error_model="numpy")
def _end_where_they_land(bend, landing, known, points, highest, scratch, row):
    """End the contact of a block's hairs where their smooth curves leave the surface.

    Parameters
    ----------
    bend : record of BEND
    landing : (LANDING_SIZE,) float64
        From `find_landings`.
    known : (9 BLOCK,) float32
        From `bend.turn_hairs`.
    points : (SAMPLES, 3 BLOCK) float32
    highest : int
        The last point at which any hair touches.
    scratch : (2 BLOCK,) float32
    row : (FINDINGS BLOCK,) float32
        With the places between points where they touch, as their points have it. BEGIN and END are
        changed, LIES is filled.
    """
    lands, places = scratch[:BLOCK], scratch[BLOCK : 2 * BLOCK]
    _find_lands(bend, landing, known, lands)
    places[:] = _ZERO
    for k in range(min(highest + 3, SAMPLES - 1)):
        _add_pieces(lands, points[k], points[k + 1], places)
    _hold(landing, known, points[0], points[1], points[2], places, row)


@kernel(error_model="numpy")
def _any_near(near, clear):
    """Whether any point of a block is near the surface."""
    count = np.int32(0)
    for j in range(BLOCK):
        count += np.int32(clear[j] <= near)
    return count > 0


@kernel(error_model="numpy")
def _count(row):
    """Count a block's hairs that touch, and how far up any does, in thirds of a piece."""
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
        Bent, with their slopes and landings. Rows BEGIN, END and LIES of `hair_contacts` are
        filled, and `depths`: for each block the end of the hair that lies on furthest up, in
        points, below 0 for none. On a curved surface points are laid on the plane: x and y become
        those of their feet along the normal.

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
                _rise_over_plane(here, clear)
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
        _end_where_they_land(bend, landing, turned[g], points[g], highest, runs, row)
        for j in range(bristles.count - g * BLOCK, BLOCK):  # copies that fill up the last block
            row[END + j] = -_ONE
        n, deepest = _count(row)
        touching += n
        hairs.depths[g] = np.float32(deepest + 1) / np.float32(16.0) if n > 0 else -_ONE
    return touching
