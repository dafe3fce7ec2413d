"""How much of a vertex's own small box a sweeping footprint covers, and for how long.

Guo 2017 asks whether a vertex lies inside the outline. Here it is asked for how long: the vertex's
distance to the moving outline is followed between the two stamps, and its share of the ink is the
mean share of its box that was covered meanwhile. That closes the gaps between samples (Guo 2015,
section 3.2), does not darken with the sampling rate, and draws edges finer than the vertices.

Distances are in widths of the box, positive inside. Everything runs over blocks of vertices in
single precision, loop by loop, so that the compiler can use vector instructions; only the look-up
in the outline's profile and the packing of what is left over are done vertex by vertex.
"""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine import stamp as st
from paint3d.core.kernel import uncounted

__all__ = ["WORK_ROWS", "weigh_block", "weigh_standing"]

WORK_ROWS = 8  # float32 rows of a block's length that `weigh_block` works in
_LAST_PLACE = st.PROFILE_CELLS - 1e-4  # on the profile, in cells: within the last
_SLOW = np.float32(4.0)  # box widths: an edge that passes faster passes as good as straight
_STILL = np.float32(1e-3)  # box widths: a shorter way is judged by its middle
_NOT, _WHOLE, _STRAIGHT, _SLOWLY = np.uint8(0), np.uint8(1), np.uint8(2), np.uint8(3)
_NONE_OF_EIGHT, _ALL_OF_EIGHT = np.uint64(0), np.uint64(0x0101010101010101)  # as one number
_HALF = np.float32(0.5)
_ONE = np.float32(1.0)
_ZERO = np.float32(0.0)


@uncounted(error_model="numpy")
def _covered(edge):
    """Share of the unit box on the inner side of an edge at a signed distance (box widths)."""
    return min(_ONE, max(_ZERO, _HALF + edge))


@uncounted(error_model="numpy")
def _mean_covered(a, b):
    """Mean of `_covered` while the edge's distance goes evenly from a to b: both antiderivatives.

    Without a branch, for vector instructions.
    """
    s, t = _HALF + a, _HALF + b
    u, v = min(_ONE, max(_ZERO, s)), min(_ONE, max(_ZERO, t))
    way = t - s
    rise = _HALF * (v * v - u * u) + (max(t, _ONE) - max(s, _ONE))
    still = abs(way) < _STILL
    mean = rise / (_ONE if still else way)
    return _covered(_HALF * (a + b)) if still else mean


@uncounted(error_model="numpy")
def _place_block(n, xs, ys, turn, heel, tip, places, sides, beyond):
    """Where vertices of the plane lie on a stamp's profile: place (cells), side and beyond (mm).

    `turn` (4,) carries plane coordinates to the stamp's own: (x - ox, y - oy) turned by (c, s).
    The profile is read at its nearer end beyond its ends, `beyond` is the way beyond.
    """
    ox, oy = np.float32(turn[0]), np.float32(turn[1])
    c, s = np.float32(turn[2]), np.float32(turn[3])
    first, last = np.float32(heel), np.float32(tip)
    per_step = np.float32(st.PROFILE_CELLS / (tip - heel))
    top = np.float32(_LAST_PLACE)
    for k in range(n):
        u = xs[k] - ox
        v = ys[k] - oy
        x = c * u + s * v
        places[k] = min(max((x - first) * per_step, _ZERO), top)
        beyond[k] = max(_ZERO, max(first - x, x - last))
        sides[k] = abs(c * v - s * u)


@uncounted(error_model="numpy")
def _stamp_edges(n, places, sides, beyond, lines, scale, inner, far):
    """Signed distances (box widths) to the near and to the far side of one stamp's outline."""
    factor = np.float32(scale)
    for k in range(n):
        at = places[k]
        i = np.int32(at)
        width, steepness = lines[i, 0] + at * lines[i, 1], lines[i, 2]
        inner[k] = ((width - sides[k]) * steepness - beyond[k]) * factor
        far[k] = ((width + sides[k]) * steepness - beyond[k]) * factor


@uncounted(error_model="numpy")
def _way_edges(n, places, sides, beyond, lines_before, lines, back, scale, inner, far):
    """`_stamp_edges` for the outline a share `back` of the way before the stamp `lines`."""
    then = np.float32(back)
    now = np.float32(1.0 - back)
    factor = np.float32(scale)
    for k in range(n):
        at = places[k]
        i = np.int32(at)
        width = now * (lines[i, 0] + at * lines[i, 1])
        width += then * (lines_before[i, 0] + at * lines_before[i, 1])
        steepness = now * lines[i, 2] + then * lines_before[i, 2]
        inner[k] = ((width - sides[k]) * steepness - beyond[k]) * factor
        far[k] = ((width + sides[k]) * steepness - beyond[k]) * factor


@uncounted(error_model="numpy")
def _pack(n, near, ids, rows, chosen_ids, chosen):
    """Copy the columns `near` of the first rows, and their ids, to the front of others."""
    for i in range(n):
        chosen_ids[i] = ids[near[i]]
    for row in range(chosen.shape[0]):
        source = rows[row]
        target = chosen[row]
        for i in range(n):
            target[i] = source[near[i]]


@uncounted(error_model="numpy")
def _follow(n, sweep, lines, lines_before, between, rows, work, share, cover):
    """Mean share covered, and the greatest, of vertices that the edge passes on a curve."""
    xs, ys, a, b = rows[0], rows[1], rows[3], rows[4]
    last, inner, far = work[0], work[1], work[2]
    places, sides, beyond = work[3], work[4], work[5]
    parts = int(sweep.parts)
    each = np.float32(1.0 / parts)
    for k in range(n):
        last[k] = a[k]
        share[k] = _ZERO
    for part in range(1, parts):
        where = between[part]
        _place_block(n, xs, ys, where, where[4], where[5], places, sides, beyond)
        _way_edges(
            n, places, sides, beyond, lines_before, lines, 1.0 - part / parts, sweep.scale,
            inner, far,
        )  # fmt: skip
        for k in range(n):
            share[k] += _mean_covered(last[k], inner[k])
            cover[k] = max(cover[k], _covered(inner[k]) + _covered(far[k]) - _ONE)
            last[k] = inner[k]
    for k in range(n):
        share[k] = (share[k] + _mean_covered(last[k], b[k])) * each


@uncounted(error_model="numpy")
def _drop_far(n, sweep, lines, lines_before, between, rows, work, near):
    """List which of these the outline can reach on its way, by where it is half the way."""
    inner, far, places, sides, beyond = work[0], work[1], work[2], work[3], work[4]
    where = between[0]
    _place_block(n, rows[0], rows[1], where, where[4], where[5], places, sides, beyond)
    _way_edges(
        n, places, sides, beyond, lines_before, lines, 0.5, sweep.scale, inner, far
    )  # fmt: skip
    rise = np.float32(0.5 * sweep.end_rise)
    kept = 0
    for k in range(n):
        near[kept] = k
        kept += np.int64(max(max(rows[3][k], rows[4][k]), inner[k] + rise) > -_HALF)
    return kept


@uncounted(error_model="numpy")
def _append(n, ids, rows, share, cover, out_ids, out_share, out_cover, found):
    """Append the vertices with a share to the outputs."""
    stretch = rows[2]
    for k in range(n):
        out_ids[found] = ids[k]
        out_share[found] = share[k] * stretch[k]
        out_cover[found] = cover[k]
        found += np.int64(cover[k] > _ZERO)
    return found


@uncounted(error_model="numpy")
def _stamp_cover(n, rows, cover):
    """Greatest share covered at the two stamps: whole where the middle of the box ever was."""
    a, b, far_a, far_b = rows[3], rows[4], rows[5], rows[6]
    for k in range(n):
        now = _covered(b[k]) + _covered(far_b[k]) - _ONE
        then = _covered(a[k]) + _covered(far_a[k]) - _ONE
        cover[k] = _ONE if max(a[k], b[k]) >= _HALF else max(now, then)


@uncounted(error_model="numpy")
def weigh_block(
    n, ids, rows, sweep, lines, lines_before, between, packed_ids, packed, work, near,
    kinds, eights, out_ids, out_share, out_cover, found,
):  # fmt: skip
    """Time-mean share for the ink, and greatest share covered, of the vertices of a block.

    Parameters
    ----------
    n : int
        Vertices in the block (N: its room).
    ids : (N,) int32
    rows : (7, N) float32
        Plane x, y and stretch of each; the rest is filled: the distances at the stamp before and
        at the stamp after, to the near side and to the far side.
    sweep, between, lines, lines_before : arrays of the sweep and of its two stamps
    packed_ids, packed, work, near : (N,) int32, (7, N), (WORK_ROWS, N) float32, (2, N) int32
        Scratch.
    kinds, eights : (N,) uint8, (N / 8,) uint64
        Scratch: the same memory seen in two ways. Neighbours mostly share their fate, so eight of
        them are looked at together first.
    out_ids, out_share, out_cover : (cap + 1,) int32, float32, float32
        Vertices with a share are appended.
    found : int
        How many there are already.

    Returns
    -------
    int
        How many there are then.
    """
    xs, ys, stretch = rows[0], rows[1], rows[2]
    a, b, far_a, far_b = rows[3], rows[4], rows[5], rows[6]
    places, sides, beyond = work[0], work[1], work[2]
    now, then, scale = sweep.after_touches, sweep.before_touches, sweep.scale
    if now > 0.0:
        turn = sweep.to_after
        heel, tip = sweep.after_heel, sweep.after_tip
        _place_block(n, xs, ys, turn, heel, tip, places, sides, beyond)
        _stamp_edges(n, places, sides, beyond, lines, scale, b, far_b)
    if then > 0.0:  # after the other: `places` are then those on the stamp the brush comes from
        turn = sweep.to_before
        heel, tip = sweep.before_heel, sweep.before_tip
        _place_block(n, xs, ys, turn, heel, tip, places, sides, beyond)
        _stamp_edges(n, places, sides, beyond, lines_before, scale, a, far_a)
    if now <= 0.0:
        for k in range(n):
            b[k] = a[k]
            far_b[k] = far_a[k]
    elif then <= 0.0:
        for k in range(n):
            a[k] = b[k]
            far_a[k] = far_b[k]
    curved = sweep.parts > 1.0
    least = np.float32(-0.5 - sweep.rise)
    least_at_end = np.float32(-0.5 - sweep.end_rise)
    end = np.float32(st.PROFILE_CELLS - sweep.end)
    for k in range(n):
        low, high = min(a[k], b[k]), max(a[k], b[k])
        reached = (high > least) | ((places[k] > end) & (high > least_at_end))
        bent = curved & ((high < _HALF) | (high - low < _SLOW))
        kind = _SLOWLY if bent else _STRAIGHT
        kind = _WHOLE if low >= _HALF else kind
        kinds[k] = kind if reached else _NOT
    last = (n + 7) // 8
    kinds[n : 8 * last] = _NOT
    straight_ones, slow_ones = near[0], near[1]
    straight, slow = 0, 0
    for g in range(last):
        if eights[g] == _NONE_OF_EIGHT:
            continue
        first = 8 * g
        if eights[g] == _ALL_OF_EIGHT:
            for k in range(8):
                out_ids[found + k] = ids[first + k]
                out_share[found + k] = stretch[first + k]
                out_cover[found + k] = _ONE
            found += 8
            continue
        for k in range(first, min(n, first + 8)):  # no branch: what comes cannot be foretold
            out_ids[found] = ids[k]
            out_share[found] = stretch[k]
            out_cover[found] = _ONE
            found += np.int64(kinds[k] == _WHOLE)
            straight_ones[straight] = k
            straight += np.int64(kinds[k] == _STRAIGHT)
            slow_ones[slow] = k
            slow += np.int64(kinds[k] == _SLOWLY)
    share, cover = work[6], work[7]
    _pack(straight, straight_ones, ids, rows, packed_ids, packed)
    _stamp_cover(straight, packed, cover)
    for k in range(straight):
        share[k] = _mean_covered(packed[3, k], packed[4, k])
    found = _append(
        straight, packed_ids, packed, share, cover, out_ids, out_share, out_cover, found
    )
    if slow == 0:
        return found
    _pack(slow, slow_ones, ids, rows, packed_ids, packed)
    left = _drop_far(slow, sweep, lines, lines_before, between, packed, work, slow_ones)
    _pack(left, slow_ones, packed_ids, packed, packed_ids, packed)
    _stamp_cover(left, packed, cover)
    _follow(left, sweep, lines, lines_before, between, packed, work, share, cover)
    return _append(left, packed_ids, packed, share, cover, out_ids, out_share, out_cover, found)


@uncounted(error_model="numpy")
def weigh_standing(n, ids, rows, sweep, lines, packed_ids, packed, work, near):
    """Share covered where the way ends, of the vertices of a block; those with one are packed.

    Parameters
    ----------
    n, ids, rows, sweep, lines : as for `weigh_block`
        Of a sweep whose two stamps are one.
    packed_ids : (N,) int32
        Filled with the vertices that have a share,
    packed : (7, N) float32
        and their plane x and y, share for the ink, and share covered.
    work, near : (WORK_ROWS, N) float32, (N,) int32
        Scratch.

    Returns
    -------
    int
        How many there are.
    """
    places, sides, beyond, inner, far, cover = work[0], work[1], work[2], work[3], work[4], work[5]
    turn = sweep.to_after
    heel, tip = sweep.after_heel, sweep.after_tip
    _place_block(n, rows[0], rows[1], turn, heel, tip, places, sides, beyond)
    _stamp_edges(n, places, sides, beyond, lines, sweep.scale, inner, far)
    for k in range(n):
        part = _covered(inner[k]) + _covered(far[k]) - _ONE
        cover[k] = _ONE if inner[k] >= _HALF else part
    kept = 0
    for k in range(n):
        near[kept] = k
        kept += np.int64(cover[k] > _ZERO)
    xs, ys, stretch = rows[0], rows[1], rows[2]
    out_x, out_y, out_share, out_cover = packed[0], packed[1], packed[2], packed[3]
    for i in range(kept):
        k = np.uint32(near[i])
        packed_ids[i] = ids[k]
        out_x[i], out_y[i] = xs[k], ys[k]
        out_share[i], out_cover[i] = _covered(inner[k]) * stretch[k], cover[k]
    return kept
