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

from paint3d.brush_engine.footprint import LAST_PLACE, PROFILE_CELLS, profile_cell
from paint3d.core.kernel import uncounted
from paint3d.mesh.kernels.mesh_arrays import as_index

__all__ = ["ROWS", "WORK_ROWS", "fetch", "weigh_block", "weigh_passing", "weighed_area"]

_MIDDLE = 1.5 * 2.0**52  # whole numbers near to it are apart by one
ROWS = 7  # float32 rows of a block's length: plane x, y and stretch of each vertex, and its
# distances at the stamp before and at the stamp after, to the near side and to the far side
WORK_ROWS = 14  # of the same, that `weigh_block` works in: rows 6 and 7 are share and cover
_SLOW = np.float32(4.0)  # box widths: an edge that passes faster passes as good as straight
_NEAR = 1.5  # times as far as the outline moved: distances beyond its ends are no true ones
_STILL = np.float32(1e-3)  # box widths: a shorter way is judged by its middle
_NOT, _WHOLE, _STRAIGHT, _SLOWLY = np.uint8(0), np.uint8(1), np.uint8(2), np.uint8(4)
_NONE = np.uint64(0)  # of eight; and where each of eight is of a kind, as one number:
_WHOLES = np.uint64(0x0101010101010101)
_STRAIGHTS, _SLOW_ONES = np.uint64(2) * _WHOLES, np.uint64(4) * _WHOLES
_HALF = np.float32(0.5)
_ONE = np.float32(1.0)
_ZERO = np.float32(0.0)


@uncounted(error_model="numpy", forceinline=True)
def _covered(edge):
    """Share of the unit box on the inner side of an edge at a signed distance (box widths)."""
    return min(_ONE, max(_ZERO, _HALF + edge))


@uncounted(error_model="numpy", forceinline=True)
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


@uncounted(error_model="numpy", apart=True)
def _place_block(n, rows, stand, spots):
    """Where vertices of the plane lie on a stamp's profile: rows of place (cells), side and beyond.

    The profile is read at its nearer end beyond its ends, `beyond` is the way beyond; sides, with
    their sign, and ways in mm. `stand` (6,) is how the outline stands: the turn that carries plane
    coordinates to the stamp's own, (x - ox, y - oy) turned by (c, s), and where heel and tip are.
    """
    xs, ys = rows[0], rows[1]
    places, sides, beyond = spots[0], spots[1], spots[2]
    turn_x, turn_y, cosine, sine, heel, tip = stand
    ox, oy = np.float32(turn_x), np.float32(turn_y)
    c, s = np.float32(cosine), np.float32(sine)
    first, last = np.float32(heel), np.float32(tip)
    per_step = np.float32(PROFILE_CELLS / (tip - heel))
    top = np.float32(LAST_PLACE)
    for k in range(n):
        u = xs[k] - ox
        v = ys[k] - oy
        x = c * u + s * v
        places[k] = min(max((x - first) * per_step, _ZERO), top)
        beyond[k] = max(_ZERO, max(first - x, x - last))
        sides[k] = c * v - s * u


@uncounted(error_model="numpy")
def _after(sweep):
    """How the outline stands at the end of the way."""
    turn = sweep.to_after
    return turn[0], turn[1], turn[2], turn[3], sweep.after_heel, sweep.after_tip


@uncounted(error_model="numpy")
def _before(sweep):
    """How the outline stands at its beginning."""
    turn = sweep.to_before
    return turn[0], turn[1], turn[2], turn[3], sweep.before_heel, sweep.before_tip


@uncounted(error_model="numpy")
def _part_way(sweep, part):
    """How it stands after so many parts of the way; after 0: half the way."""
    row = sweep.between[part]
    return row[0], row[1], row[2], row[3], row[4], row[5]


@uncounted(error_model="numpy", apart=True)
def _stamp_edges(n, spots, lines, scale, inner, far):
    """Signed distances (box widths) to the near and to the far side of one stamp's outline."""
    places, sides, beyond = spots[0], spots[1], spots[2]
    starts, rises, steep = lines[0], lines[1], lines[2]
    factor = np.float32(scale)
    for k in range(n):
        at = places[k]
        i = profile_cell(at)
        width, steepness = starts[i] + at * rises[i], steep[i]
        side = abs(sides[k])
        inner[k] = ((width - side) * steepness - beyond[k]) * factor
        far[k] = ((width + side) * steepness - beyond[k]) * factor


@uncounted(error_model="numpy", apart=True)
def _way_edges(n, spots, sweep, back, inner, far):
    """`_stamp_edges` for the outline a share `back` of the way before its end."""
    places, sides, beyond = spots[0], spots[1], spots[2]
    lines, before = sweep.after.lines, sweep.before.lines
    starts, rises, steep = lines[0], lines[1], lines[2]
    starts_before, rises_before, steep_before = before[0], before[1], before[2]
    then = np.float32(back)
    now = np.float32(1.0 - back)
    factor = np.float32(sweep.values[0].scale)
    for k in range(n):
        at = places[k]
        i = profile_cell(at)
        width = now * (starts[i] + at * rises[i])
        width += then * (starts_before[i] + at * rises_before[i])
        steepness = now * steep[i] + then * steep_before[i]
        side = abs(sides[k])
        inner[k] = ((width - side) * steepness - beyond[k]) * factor
        far[k] = ((width + side) * steepness - beyond[k]) * factor


@uncounted(error_model="numpy", apart=True)
def _pack(n, near, ids, rows, packed_ids, packed):
    """Copy the columns `near` of rows, and their ids, to the front of the packed ones."""
    for i in range(n):
        packed_ids[i] = ids[as_index(near[i])]
    for row in range(ROWS):
        source = rows[row]
        target = packed[row]
        for i in range(n):
            target[i] = source[as_index(near[i])]


@uncounted(error_model="numpy", apart=True)
def _find_crossings(n, spots, later, sweep, back, crossings):
    """When in a part of the way the outline's middle line passes over vertices, and how deep.

    A pointed end that goes to the side is over a vertex for a moment, which need be none of those
    that are looked at. `spots` and `later` are where vertices lie at the beginning and at the end
    of the part, which stand `back` (2,) of the way before its end. Rows of `crossings`: the share
    of the part, 0 where it does not pass over, the distance (box widths) to the edge then, which is
    as far to both sides, and the place on the profile, cells.
    """
    a, b, lines, before = spots, later, sweep.after.lines, sweep.before.lines
    starts, rises, steep = lines[0], lines[1], lines[2]
    starts_before, rises_before, steep_before = before[0], before[1], before[2]
    values, when, peak, where = sweep.values[0], crossings[0], crossings[1], crossings[2]
    length = 0.5 * (values.after_tip - values.after_heel + values.before_tip - values.before_heel)
    per_step, step = np.float32(PROFILE_CELLS / length), np.float32(length / PROFILE_CELLS)
    middle, top = np.float32(0.5 * PROFILE_CELLS), np.float32(LAST_PLACE)
    first, each, factor = (
        np.float32(back[0]),
        np.float32(back[1] - back[0]),
        np.float32(values.scale),
    )
    for k in range(n):
        way = a[1, k] - b[1, k]
        passes = a[1, k] * b[1, k] < _ZERO
        t = a[1, k] / (way if passes else _ONE)
        begin = a[0, k] + (a[2, k] if a[0, k] > middle else -a[2, k]) * per_step
        end = b[0, k] + (b[2, k] if b[0, k] > middle else -b[2, k]) * per_step
        at = begin + t * (end - begin)
        place = min(max(at, _ZERO), top)
        i = profile_cell(place)
        then = first + t * each
        now = _ONE - then
        width = now * (starts[i] + place * rises[i])
        width += then * (starts_before[i] + place * rises_before[i])
        steepness = now * steep[i] + then * steep_before[i]
        when[k] = t if passes else _ZERO
        peak[k] = (width * steepness - abs(at - place) * step) * factor
        where[k] = place


@uncounted(error_model="numpy", apart=True)
def _share_straight(n, a, b, share):
    """Mean share covered of vertices that the edge passes evenly, between two distances."""
    for k in range(n):
        share[k] = _mean_covered(a[k], b[k])


@uncounted(error_model="numpy", apart=True)
def _add_part(n, when, peak, inner, far, last, share, cover):
    """Add what a part of the way covers to the sum of shares, and to the greatest.

    Of each vertex: its distance (box widths) at the part's beginning, `last`, which goes on to its
    end, there to both sides, and when and how deep it was passed over meanwhile.
    """
    for k in range(n):
        t, deep, a, b = when[k], peak[k], last[k], inner[k]  # read, used or not: no branch
        top = deep if t > _ZERO else a
        share[k] += t * _mean_covered(a, top) + (_ONE - t) * _mean_covered(top, b)
        seen = _covered(b) + _covered(far[k]) - _ONE
        passed = _covered(top) + _covered(top) - _ONE
        cover[k] = max(cover[k], max(seen, passed if t > _ZERO else _ZERO))
        last[k] = b


@uncounted(error_model="numpy")
def _follow(n, sweep, rows, work):
    """Mean share covered, and the greatest, of vertices that the edge passes on a curve."""
    a, b, values = rows[3], rows[4], sweep.values[0]
    last, inner, far, spots, later = work[0], work[1], work[2], work[3:6], work[8:11]
    share, cover, when, peak = work[6], work[7], work[11], work[12]
    parts = int(values.parts)
    each = np.float32(1.0 / parts)
    _place_block(n, rows, _before(values), spots)
    for k in range(n):
        last[k] = a[k]
        share[k] = _ZERO
    for part in range(1, parts + 1):
        if part < parts:
            _place_block(n, rows, _part_way(sweep, part), later)
            _way_edges(n, later, sweep, 1.0 - part / parts, inner, far)
        else:
            _place_block(n, rows, _after(values), later)
            for k in range(n):
                inner[k], far[k] = b[k], -_HALF  # the greatest share knows the end already
        back = 1.0 - (part - 1) / parts, 1.0 - part / parts
        _find_crossings(n, spots, later, sweep, back, work[11:14])
        _add_part(n, when, peak, inner, far, last, share, cover)
        spots, later = later, spots
    for k in range(n):
        share[k] *= each


@uncounted(error_model="numpy")
def _drop_far(n, sweep, rows, work, near, kept_ones):
    """List which of those `near` the outline can reach on its way, by where it is half the way.

    The rows are theirs, packed.
    """
    inner, far, spots = work[0], work[1], work[2:5]
    a, b = rows[3], rows[4]
    _place_block(n, rows, _part_way(sweep, 0), spots)
    _way_edges(n, spots, sweep, 0.5, inner, far)
    rise = np.float32(0.5 * sweep.values[0].end_rise)
    kept = 0
    for k in range(n):
        kept_ones[kept] = near[k]
        kept += np.int64(max(max(a[k], b[k]), inner[k] + rise) > -_HALF)
    return kept


@uncounted(error_model="numpy")
def _append(n, block, found, at):
    """Append the packed vertices with a share to those found; return how many these are then."""
    ids, stretch = block.packed_ids, block.packed[2]
    share, cover = block.work[6], block.work[7]
    out_ids, out_share, out_cover = found.ids, found.share, found.cover
    for k in range(n):
        out_ids[at] = ids[k]
        out_share[at] = share[k] * stretch[k]
        out_cover[at] = cover[k]
        at += np.int64(cover[k] > _ZERO)
    return at


@uncounted(error_model="numpy", apart=True)
def _stamp_cover(n, rows, cover):
    """Greatest share covered at the two stamps: whole where the middle of the box ever was."""
    a, b, far_a, far_b = rows[3], rows[4], rows[5], rows[6]
    for k in range(n):
        now = _covered(b[k]) + _covered(far_b[k]) - _ONE
        then = _covered(a[k]) + _covered(far_a[k]) - _ONE
        cover[k] = _ONE if max(a[k], b[k]) >= _HALF else max(now, then)


@uncounted(error_model="numpy", forceinline=True)
def _measure(n, sweep, block):
    """Fill the vertices' distances at both stamps; those at one that does not touch are no others.

    The first row of work keeps their places on the stamp that the brush comes from, if it touches.
    """
    rows, spots, values = block.rows, block.work[0:3], sweep.values[0]
    a, b, far_a, far_b = rows[3], rows[4], rows[5], rows[6]
    now, then, scale = values.after_touches, values.before_touches, values.scale
    if now > 0.0:
        _place_block(n, rows, _after(values), spots)
        _stamp_edges(n, spots, sweep.after.lines, scale, b, far_b)
    if then > 0.0:
        _place_block(n, rows, _before(values), spots)
        _stamp_edges(n, spots, sweep.before.lines, scale, a, far_a)
    if now <= 0.0:
        for k in range(n):
            b[k] = a[k]
            far_b[k] = far_a[k]
    elif then <= 0.0:
        for k in range(n):
            a[k] = b[k]
            far_a[k] = far_b[k]


@uncounted(error_model="numpy", forceinline=True)
def _judge(n, sweep, block):
    """Tell which vertices the sweep covers whole, which not, and which its edge passes, and how."""
    a, b, places, kinds = block.rows[3], block.rows[4], block.work[0], block.kinds
    curved = sweep.parts > 1.0
    least = np.float32(-0.5 - sweep.rise)
    least_at_end = np.float32(-0.5 - sweep.end_rise)
    begin, end = np.float32(sweep.ends[0]), np.float32(PROFILE_CELLS - sweep.ends[1])
    for k in range(n):
        low, high = min(a[k], b[k]), max(a[k], b[k])
        at_end = (places[k] > end) | (places[k] < begin)
        reached = (high > least) | (at_end & (high > least_at_end))
        bent = curved & ((high < _HALF) | (high - low < _SLOW))
        kind = _SLOWLY if bent else _STRAIGHT
        kind = _WHOLE if low >= _HALF else kind
        kinds[k] = kind if reached else _NOT
    kinds[n : 8 * ((n + 7) // 8)] = _NOT


@uncounted(error_model="numpy", forceinline=True)
def _sort(n, block, found, at):
    """Append the vertices that are covered whole, and list the others by kind.

    Returns how many have been found then, and how many the edge passes straight, and slowly.
    """
    ids, stretch, kinds, eights = block.ids, block.rows[2], block.kinds, block.eights
    straight_ones, slow_ones = block.near[0], block.near[1]
    out_ids, out_share, out_cover = found.ids, found.share, found.cover
    straight, slow = 0, 0
    for g in range((n + 7) // 8):
        eight = eights[g]
        if eight == _NONE:
            continue
        first = 8 * g
        if eight == _WHOLES:
            for k in range(8):
                out_ids[at + k] = ids[first + k]
                out_share[at + k] = stretch[first + k]
                out_cover[at + k] = _ONE
            at += 8
            continue
        last = min(n, first + 8)  # no branch for one: what comes cannot be foretold
        if eight & _WHOLES != _NONE:
            for k in range(first, last):
                out_ids[at] = ids[k]
                out_share[at] = stretch[k]
                out_cover[at] = _ONE
                at += np.int64(kinds[k] == _WHOLE)
        if eight & _STRAIGHTS != _NONE:
            for k in range(first, last):
                straight_ones[straight] = k
                straight += np.int64(kinds[k] == _STRAIGHT)
        if eight & _SLOW_ONES != _NONE:
            for k in range(first, last):
                slow_ones[slow] = k
                slow += np.int64(kinds[k] == _SLOWLY)
    return at, straight, slow


@uncounted(error_model="numpy", forceinline=True)
def weigh_block(n, sweep, block, found, at):
    """Time-mean share for the ink, and greatest share covered, of the vertices of a block.

    The share is w of docs/model.md, equation (9).

    Parameters
    ----------
    n : int
        Vertices in the block.
    sweep : Sweep
    block : Block
        With their ids, and the first three of `rows`; the rest is filled, and worked in.
    found : Found
        Vertices with a share are appended.
    at : int
        How many there are already.

    Returns
    -------
    int
        How many there are then.
    """
    ids, rows, packed, work = block.ids, block.rows, block.packed, block.work
    straight_ones, slow_ones = block.near[0], block.near[1]
    share, cover = work[6], work[7]
    _measure(n, sweep, block)
    _judge(n, sweep.values[0], block)
    at, straight, slow = _sort(n, block, found, at)
    _pack(straight, straight_ones, ids, rows, block.packed_ids, packed)
    _stamp_cover(straight, packed, cover)
    _share_straight(straight, packed[3], packed[4], share)
    at = _append(straight, block, found, at)
    if slow == 0:
        return at
    _pack(slow, slow_ones, ids, rows, block.packed_ids, packed)
    left = _drop_far(slow, sweep, packed, work, slow_ones, straight_ones)
    _pack(left, straight_ones, ids, rows, block.packed_ids, packed)
    _stamp_cover(left, packed, cover)
    _follow(left, sweep, packed, work)
    return _append(left, block, found, at)


@uncounted(error_model="numpy")
def _find_deepest(n, sweep, rows, work):
    """Where on the outline vertices lie that its end no longer covers: when they lay deepest.

    The first two of `rows` become their places in the plane on the outline at the end of the way
    that was over them then; the others stay where they are.
    """
    a, b, values = rows[3], rows[4], sweep.values[0]
    spots, when, peak, where = work[3:6], work[11], work[12], work[13]
    heel, length = np.float32(values.after_heel), values.after_tip - values.after_heel
    step = np.float32(length / PROFILE_CELLS)
    for k in range(n):
        crosses = (when[k] > _ZERO) & (peak[k] > a[k])
        place = where[k] if crosses else spots[0, k]
        side = _ZERO if crosses else spots[1, k]
        here = b[k] > -_HALF
        rows[0, k] = rows[0, k] if here else heel + place * step
        rows[1, k] = rows[1, k] if here else side


@uncounted(error_model="numpy")
def _weigh_near(n, sweep, rows, work):
    """Mean share covered, and the greatest, of packed vertices that the edge may pass.

    Their distances at the end of the way are known.
    """
    a, b, far_a, far_b = rows[3], rows[4], rows[5], rows[6]
    spots, later, when, peak = work[3:6], work[8:11], work[11], work[12]
    share, cover, values = work[6], work[7], sweep.values[0]
    if values.before_touches > 0.0:
        _place_block(n, rows, _after(values), later)
        _place_block(n, rows, _before(values), spots)
        _stamp_edges(n, spots, sweep.before.lines, values.scale, a, far_a)
        _find_crossings(n, spots, later, sweep, (1.0, 0.0), work[11:14])
    else:
        for k in range(n):
            a[k], far_a[k], when[k] = b[k], far_b[k], _ZERO
    _stamp_cover(n, rows, cover)
    for k in range(n):
        t = when[k]
        top = peak[k] if t > _ZERO else a[k]
        share[k] = t * _mean_covered(a[k], top) + (_ONE - t) * _mean_covered(top, b[k])
        passed = _covered(top) + _covered(top) - _ONE if t > _ZERO else _ZERO
        cover[k] = max(cover[k], passed)
    _find_deepest(n, sweep, rows, work)


@uncounted(error_model="numpy")
def weigh_passing(n, sweep, moved, block):
    """Mean share covered on a way that is no longer than the vertices lie apart.

    Of the vertices of a block; those with one are packed.

    Parameters
    ----------
    n : int
    sweep : Sweep
        Its end touches; where its beginning does not, it is all end.
    moved : float
        How far the fastest of the outline's points moved, mm.
    block : Block
        With the vertices' ids, and the first three of `rows`. Filled are `packed_ids` with those
        that have a share, and of `packed` their place on the outline at its end (plane x and y),
        share for the ink, and greatest share covered.

    Returns
    -------
    int
        How many there are.
    """
    rows, work, values = block.rows, block.work, sweep.values[0]
    near, whole, share, cover = block.near[0], block.near[1], work[6], work[7]
    b, far_b = rows[4], rows[6]
    _place_block(n, rows, _after(values), work[8:11])
    _stamp_edges(n, work[8:11], sweep.after.lines, values.scale, b, far_b)
    reach = np.float32(0.5 + _NEAR * moved * values.scale)
    n_near, n_whole = 0, 0
    for k in range(n):
        near[n_near], whole[n_whole] = k, k
        n_near += np.int64((b[k] > -reach) & (b[k] < reach))
        n_whole += np.int64(b[k] >= reach)
    packed_ids, packed = block.packed_ids, block.packed
    _pack(n_near, near, block.ids, rows, packed_ids, packed)
    _weigh_near(n_near, sweep, packed, work)
    xs, ys, stretch, shares, covers = packed[0], packed[1], packed[2], packed[2], packed[3]
    kept = 0
    for k in range(n_near):
        packed_ids[kept], xs[kept], ys[kept] = packed_ids[k], xs[k], ys[k]
        shares[kept], covers[kept] = share[k] * stretch[k], cover[k]
        kept += np.int64(cover[k] > _ZERO)
    for i in range(n_whole):
        k = np.uint32(whole[i])
        packed_ids[kept + i], xs[kept + i], ys[kept + i] = block.ids[k], rows[0, k], rows[1, k]
        shares[kept + i], covers[kept + i] = rows[2, k], _ONE
    return kept + n_whole


@uncounted(error_model="numpy", apart=True)
def fetch(n, ids, values, out):
    """Fill the values that vertices have; `values` holds those of all."""
    for k in range(n):
        out[k] = values[as_index(ids[k])]


@uncounted(error_model="numpy", apart=True)
def weighed_area(n, area, share, step):
    """Area that vertices stand for, weighed, mm2.

    Summed in whole numbers of steps (mm2, a power of two, see `SurfaceField`), so that the order in
    which vertices are found, which depends on what was refined before, cannot change a bit of it.
    The sum of a number and `_MIDDLE` steps has its whole number of steps in its last bits.
    """
    middle = np.float64(_MIDDLE * step)
    total = np.int64(0)
    for k in range(n):
        near = np.float64(share[k] * area[k] + middle)
        total += near.view(np.int64)
    return (total - n * middle.view(np.int64)) * step
