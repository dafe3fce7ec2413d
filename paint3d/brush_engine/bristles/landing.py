"""Where the hairs of a tuft come down to the surface, read from their smooth curves.

Eight points tell how a hair lies, but not where between two of them it leaves the surface: pieces
are up to 9 mm long. The table gives its angle at every point too. A cubic through points and angles
(Hermite's), with the tuft's own taper about it, comes down where the outline of Guo 2017, Eq. 8,
has it, within 0.2 mm; and so do the hairs.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from paint3d.brush_engine.bristles.bend import ARCS, BESIDE, BLOCK, DOWN, SAMPLES
from paint3d.core.kernel import kernel

__all__ = ["LANDING_SIZE", "end_where_they_land", "find_landings"]

_SIDES = 5  # places for which it is found, from the middle of the tuft (a = 0) to its underside (1)
_TIP = 2 * _SIDES  # where the spine's own tip lies
_BEFORE = _TIP + 1  # scratch: clearances and places one step before
LANDING_SIZE = _BEFORE + 2 * _SIDES
_RIM = 0.3  # of its thickness: so much lower lie the sides of a tuft that is pressed flat
_ON = 0.02  # mm over the surface: on it
_STEPS = 3  # to a piece
_MOST = np.float32(1.5)  # pieces beyond the last point that touches

_Y = BLOCK
_ZERO, _ONE, _TWO, _FOUR = np.float32([0.0, 1.0, 2.0, 4.0])
_SHORT = np.float32(1e-4)  # mm
_elementwise = kernel(error_model="numpy", fastmath={"contract"})


@kernel(error_model="numpy")
def _cubic(share, low, rise_low, high, rise_high):
    """Hermite's cubic between two points, from what they are and how they rise."""
    rest = 1.0 - share
    ends = rest * rest * (1.0 + 2.0 * share) * low + share * share * (3.0 - 2.0 * share) * high
    return ends + share * rest * (rest * rise_low - share * rise_high)


@kernel(error_model="numpy")
def _at(bend, k, t):
    """A number of the shared curve (x of a point, or SAMPLES on its z) at a height of the three."""
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
    """One step up the curve: those sides that leave the surface in it have landed there."""
    rim = _RIM * bend.flat
    for n in range(found, _SIDES):
        down = max(n / (_SIDES - 1.0), rim) * section.thin
        place = section.x - down * section.sine
        clear = section.z - down * section.cosine - _ground(bend, place) - _ON
        before = out[_BEFORE + n]
        if clear > 0.0:
            x_before = out[_BEFORE + _SIDES + n]
            share = before / (before - clear) if before < 0.0 else 0.0
            out[first + n] = x_before + share * (place - x_before)
            found = n + 1
        else:
            out[first + n] = place
        out[_BEFORE + n] = clear
        out[_BEFORE + _SIDES + n] = place
    return found


@kernel(error_model="numpy")
def find_landings(tuft, bend, out):
    """Where along the bend hairs of the tuft's length come down, for the first and last of the
    three heights; over a plane they stand at the last one.

    Parameters
    ----------
    tuft : Tuft
    bend : record of BEND
    out : (LANDING_SIZE,) float64
        For either height the place (mm along the bend) by a from 0 to 1, and where the spine's tip
        lies.
    """
    taper = tuft.taper
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
        found, power_low = 0, 0.0
        for k in range(SAMPLES - 1):
            if found == _SIDES:
                break
            x_high = own * _at(bend, k + 1, t) + bend.shift_x[k + 1]
            z_high = root_z + own * _at(bend, SAMPLES + k + 1, t)
            sine_high, cosine_high = bend.sine[k + 1], bend.cosine[k + 1]
            step = ARCS[k + 1] - ARCS[k]
            long, power_high = own * step * tuft.length, ARCS[k + 1] ** taper
            for i in range(1, _STEPS + 1):
                u = i / _STEPS
                wide = ((ARCS[k] + u * step) ** taper - power_low) / (power_high - power_low)
                section = _Section(
                    _cubic(u, x_low, -long * cosine_low, x_high, -long * cosine_high),
                    _cubic(u, z_low, long * sine_low, z_high, long * sine_high),
                    bend.thin[k] + wide * (bend.thin[k + 1] - bend.thin[k]),
                    sine_low + u * (sine_high - sine_low),
                    cosine_low + u * (cosine_high - cosine_low),
                )
                found = _land(bend, section, found, first, out)
            x_low, z_low, sine_low, cosine_low = x_high, z_high, sine_high, cosine_high
            power_low = power_high
    if bend.curved <= 0.0:
        out[:_SIDES] = out[_SIDES:_TIP]


@_elementwise
def _find_lands(bend, landing, known, lands):
    """Where along the bend each hair comes down, by the ground and its place in the section.

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
def _share_ahead(here, next_, x):
    """Share of a piece that lies ahead of a place along the bend."""
    run = here - next_
    share = (here - x) / (run if run > _SHORT else _SHORT)
    share = share if share > _ZERO else _ZERO
    return share if share < _ONE else _ONE


@_elementwise
def _add_pieces(lands, near_tip, far, places):
    """Add the share of a piece that lies ahead of where its hair comes down."""
    for j in range(BLOCK):
        places[j] += _share_ahead(near_tip[j], far[j], lands[j])


@_elementwise
def _hold(landing, known, tip, next_, third, places, begins, ends):
    """Let hairs of the lower side touch up to where they land, those above them at most so far;
    and none ahead of the spine's own tip: what is near the surface only there hangs over it."""
    x_tip, top = np.float32(landing[_TIP]), np.float32(SAMPLES - 1)
    for j in range(BLOCK):
        ahead = _share_ahead(tip[j], next_[j], x_tip) + _share_ahead(next_[j], third[j], x_tip)
        begin = begins[j] if begins[j] > ahead else ahead
        end, place = ends[j], places[j]
        most = end + _MOST if end + _MOST < top else top
        most = end if known[DOWN + j] < _ZERO else most
        place = place if place < most else most
        place = place if place > begin else begin
        begins[j] = begin
        ends[j] = place if end >= ahead else -_ONE


@kernel(error_model="numpy")
def end_where_they_land(bend, landing, known, points, highest, scratch, begins, ends):
    """Let the hairs of a block cease to touch where their smooth curves leave the surface.

    Parameters
    ----------
    bend : record of BEND
    landing : (LANDING_SIZE,) float64
        From `find_landings`.
    known : (8 BLOCK,) float32
        From `bend.turn_hairs`.
    points : (SAMPLES, 3 BLOCK) float32
    highest : int
        The last point at which any hair touches.
    scratch : (2 BLOCK,) float32
    begins, ends : (BLOCK,) float32
        Places between points where they touch, as their points have it; changed.
    """
    lands, places = scratch[:BLOCK], scratch[BLOCK : 2 * BLOCK]
    _find_lands(bend, landing, known, lands)
    places[:] = _ZERO
    for k in range(min(highest + 3, SAMPLES - 1)):
        _add_pieces(lands, points[k], points[k + 1], places)
    _hold(landing, known, points[0], points[1], points[2], places, begins, ends)
