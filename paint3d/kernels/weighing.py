"""How much of a vertex's own small box a sweeping footprint covers, and for how long.

Guo 2017 asks whether a vertex lies inside the outline. Here it is asked for how long: the vertex's
distance to the moving outline is followed between the two stamps, and its share of the ink is the
mean share of its box that was covered meanwhile. That closes the gaps between samples (Guo 2015,
section 3.2), does not darken with the sampling rate, and draws edges finer than the vertices.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from paint3d.kernels import stamp as st
from paint3d.kernels import sweep as sw
from paint3d.kernels.sweep import edges_between

__all__ = ["weigh_block"]

_LAST_PLACE = st.PROFILE_CELLS - 1e-4  # on the profile, in cells: within the last
_SLOW = 4.0  # box widths: an edge that passes faster passes as good as straight


@njit(cache=True, nogil=True, error_model="numpy")
def covered(edge):
    """Share of the unit box on the inner side of an edge at a signed distance (box widths)."""
    return min(1.0, max(0.0, 0.5 + edge))


@njit(cache=True, nogil=True, error_model="numpy")
def _covered_sum(edge):
    """Antiderivative of `covered`."""
    t = 0.5 + edge
    if t <= 0.0:
        return 0.0
    if t >= 1.0:
        return t - 0.5
    return 0.5 * t * t


@njit(cache=True, nogil=True, error_model="numpy")
def mean_covered(a, b):
    """Mean of `covered` while the edge distance goes evenly from a to b."""
    d = b - a
    if abs(d) < 1e-4:
        return covered(0.5 * (a + b))
    return (_covered_sum(b) - _covered_sum(a)) / d


@njit(cache=True, nogil=True, error_model="numpy")
def _pass_edge(x, y, a, b, lines_before, lines, between, parts, scale):
    """Mean share covered, and the greatest, while the outline goes from one stamp to the other.

    `a` and `b` are the distances (box widths) at the two stamps.
    """
    share = 0.0
    cover = 0.0
    last = a
    for k in range(1, parts):
        near, far = edges_between(x, y, lines_before, lines, 1.0 - k / parts, between[k])
        inner = near * scale
        share += mean_covered(last, inner)
        cover = max(cover, covered(inner) + covered(far * scale) - 1.0)
        last = inner
    return (share + mean_covered(last, b)) / parts, cover


@njit(cache=True, nogil=True, error_model="numpy")
def _inner_edges(n, xs, ys, lines, heel, tip, turn, scale, places, sides, inner):
    """Signed distances (box widths) of a block's vertices to one outline; inside is positive.

    `turn` (4,) carries plane coordinates to the stamp's own: (x - ox, y - oy) turned by (c, s).
    Two loops without branches, the first of them in vector instructions: the profile is read at
    its nearer end beyond its ends, less the way beyond.
    """
    ox, oy = np.float32(turn[0]), np.float32(turn[1])
    c, s = np.float32(turn[2]), np.float32(turn[3])
    first, last = np.float32(heel), np.float32(tip)
    per_step = np.float32(st.PROFILE_CELLS / (tip - heel))
    top = np.float32(_LAST_PLACE)
    nothing = np.float32(0.0)
    factor = np.float32(scale)
    for k in range(n):
        u = xs[k] - ox
        v = ys[k] - oy
        x = c * u + s * v
        places[k] = min(max((x - first) * per_step, nothing), top)
        sides[k] = abs(c * v - s * u) + max(nothing, max(first - x, x - last))
    for k in range(n):
        at = places[k]
        i = np.int32(at)
        inner[k] = (lines[i, 0] + at * lines[i, 1] - sides[k]) * lines[i, 2] * factor


@njit(cache=True, nogil=True, error_model="numpy")
def _far_edge(x, y, lines, heel, tip, turn):
    """The distance (mm) to the outline's other side, at plane (x, y); see `_covered_share`."""
    u = x - turn[0]
    v = y - turn[1]
    along = turn[2] * u + turn[3] * v
    side = abs(turn[2] * v - turn[3] * u)
    at = min(max((along - heel) * st.PROFILE_CELLS / (tip - heel), 0.0), _LAST_PLACE)
    i = int(at)
    beyond = max(0.0, max(heel - along, along - tip))
    return (lines[i, 0] + at * lines[i, 1] - beyond + side) * lines[i, 2]


@njit(cache=True, nogil=True, error_model="numpy")
def weigh_block(
    n, ids, xs, ys, stretch, frame, lines, lines_before, between, work, near,
    out_ids, out_share, out_cover, found,
):  # fmt: skip
    """Time-mean share for the ink, and greatest share covered, of the vertices of a block.

    Vertices with a share are appended to the outputs; returns their new number.
    """
    places, sides, inner_a, inner_b = work[0], work[1], work[2], work[3]
    scale = frame[sw.SCALE]
    now, heel, tip = frame[sw.AFTER], frame[sw.AFTER + 1], frame[sw.AFTER + 2]
    then, heel_a, tip_a = frame[sw.BEFORE], frame[sw.BEFORE + 1], frame[sw.BEFORE + 2]
    turn_b = frame[sw.TURN_AFTER : sw.TURN_AFTER + 4]
    turn_a = frame[sw.BOX_BEFORE : sw.BOX_BEFORE + 4]
    if now > 0.0:
        _inner_edges(n, xs, ys, lines, heel, tip, turn_b, scale, places, sides, inner_b)
    if then > 0.0:  # after the other: `places` are then those on the stamp the brush comes from
        _inner_edges(n, xs, ys, lines_before, heel_a, tip_a, turn_a, scale, places, sides, inner_a)
    if now <= 0.0:
        inner_b = inner_a
    elif then <= 0.0:
        inner_a = inner_b
    parts = int(frame[sw.PARTS])
    least = np.float32(-0.5 - frame[sw.RISE])
    least_at_end = np.float32(-0.5 - frame[sw.END_RISE])
    end = np.float32(st.PROFILE_CELLS - frame[sw.END])
    half_rise = 0.5 * frame[sw.END_RISE]
    candidates = 0
    for k in range(n):  # no branch: half of them lie outside, in no order that can be foretold
        near[candidates] = k
        inner = max(inner_a[k], inner_b[k])
        at_end = (places[k] > end) & (inner > least_at_end)
        candidates += np.int64((inner > least) | at_end)
    for i in range(candidates):
        k = near[i]
        a = np.float64(inner_a[k])
        b = np.float64(inner_b[k])
        share = 1.0
        cover = 1.0
        if min(a, b) < 0.5:
            most = 0.0
            if parts > 1 and (max(a, b) < 0.5 or abs(b - a) < _SLOW):
                x, y = np.float64(xs[k]), np.float64(ys[k])
                middle, _ = edges_between(x, y, lines_before, lines, 0.5, between[0])
                if max(max(a, b), middle * scale + half_rise) <= -0.5:
                    continue  # too far from the outline at half the way to be passed at all
                share, most = _pass_edge(x, y, a, b, lines_before, lines, between, parts, scale)
            else:
                share = mean_covered(a, b)
            if max(a, b) < 0.5:  # on the edge itself: never wholly covered
                cover = most
                if now > 0.0 and b > -0.5:
                    far = _far_edge(xs[k], ys[k], lines, heel, tip, turn_b) * scale
                    cover = max(cover, covered(b) + covered(far) - 1.0)
                if then > 0.0 and a > -0.5:
                    far = _far_edge(xs[k], ys[k], lines_before, heel_a, tip_a, turn_a) * scale
                    cover = max(cover, covered(a) + covered(far) - 1.0)
                if cover <= 0.0:
                    continue
        out_ids[found] = ids[k]
        out_share[found] = share * stretch[k]
        out_cover[found] = cover
        found += 1
    return found
