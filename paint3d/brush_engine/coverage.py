"""Coverage of a vertex's own small box by a sweeping footprint: how much, and for how long.

Guo 2017 asks whether a vertex lies inside the outline. Here it is asked for how long: its fraction
of the ink is the mean fraction of its box that was covered on the way between the two stamps. That
closes the gaps between samples (Guo 2015, section 3.2), does not darken with the sampling rate, and
draws edges finer than the vertices.

Both outlines are cut into lines along the way, half a box apart. What an outline covers of a box on
a line lies between two ramps: each has the middle and the spread of where the box's rows meet the
outline, so that curved edges, corners and tips are drawn as they are. One table of lines is made
for each stamp, and every vertex looks its line up once in both, in vector instructions. From the
stamp before to the stamp after its distances to the ramps go evenly, and so do those to the flanks,
the outline's farthest points across the way: how long a box was behind each, how long within all,
and how much of it at the most are closed forms.

Distances are in widths of the box, positive inside; x runs along the way and y across.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.footprint import PROFILE_CELLS
from paint3d.core.kernel import uncounted
from paint3d.mesh.kernels.mesh_arrays import as_index

__all__ = [
    "BANDS",
    "LEVELS",
    "Chords",
    "cut_outline",
    "fetch",
    "fill_chords",
    "find_begun",
    "hold_within",
    "make_chords",
    "weigh",
    "weighed_area",
]

_MIDDLE = 1.5 * 2.0**52  # whole numbers near to it are apart by one
_MOST_LINES = 1024  # a power of two
_PITCH = 0.5  # box widths from one line to the next
_FINE_LINES, _FINE_PITCH = 16, 0.125  # lines across a small outline, and their pitch
_NARROWEST = 1.0 / 64.0  # box widths: an outline counts as at least so broad
_ROWS = 2  # cuts from a line to the next
_ROUND = 0.57  # with which a chord that grows like a root is as long on average
_NOWHERE = 1e30  # mm
_NOTHING = np.float32(1e-5)  # fraction of a box: less may come of rounding
_STILL = np.float32(1e-3)  # box widths: a shorter way is judged by its middle
BANDS, LEVELS = 64, 7  # bands of neighbouring lines, and of these spans of 1, 2, 4 to 64
_HALF = np.float32(0.5)
_ONE = np.float32(1.0)
_ZERO = np.float32(0.0)
# Columns of a table, bits: where the middle of each ramp lies on a line, mm; and pairs of halves
# (the upper halves of two float32), for both ramps: how much farther it lies on the next, how many
# box widths to the mm along the way they are steep, and how much steeper they are on the next.
_ENTERS, _LEAVES, _RISES, _STEEPS, _STEEP_RISES = range(5)
_ROW = 8
_UPPER, _ROUNDS, _HALF_BITS = np.uint32(0xFFFF0000), np.uint32(0x8000), np.uint32(16)
_SLACK = 0.01  # of a half's number, more than it is rounded by


class Chords(NamedTuple):
    """Scratch of a sweep's two tables of lines; places along and across the way, mm."""

    points: NDArray  # (2, 2, PROFILE_CELLS + 1, 2) float64, both sides of both stamps' outlines
    flanks: NDArray  # (2, 4) float64, y and x of their lowest points, and of their highest
    grids: NDArray  # (2, 3) float64, y of the first line, lines to the mm, steps to the last line
    cuts: NDArray  # (7, _ROWS MOST_LINES + 1) float64, y of cuts through one, where they enter and
    # leave it, and what is worked in
    sums: NDArray  # (4, 2 MOST_LINES) float64, of what the cuts find, up to each line
    nodes: NDArray  # (2, 4, MOST_LINES) float64, where ramps of lines lie and how steep they are
    lines: NDArray  # (2, MOST_LINES * _ROW) uint32, the tables
    bands: NDArray  # (4, LEVELS * BANDS) float32: from where on a box may be covered on the way,
    # and to where, and from where to where it is all covered all the time


def make_chords() -> Chords:
    """Scratch for the lines of a sweep."""
    cuts = _ROWS * _MOST_LINES + 1
    return Chords(
        np.zeros((2, 2, PROFILE_CELLS + 1, 2)),
        np.zeros((2, 4)),
        np.zeros((2, 3)),
        np.zeros((7, cuts)),
        np.zeros((4, 2 * _MOST_LINES)),
        np.zeros((2, 4, _MOST_LINES)),
        np.zeros((2, _MOST_LINES * _ROW), np.uint32),
        np.zeros((4, LEVELS * BANDS), np.float32),
    )


@uncounted(error_model="numpy", forceinline=True)
def _covered(edge):
    """Fraction of the unit box on the inner side of an edge at a signed distance (box widths)."""
    return min(_ONE, max(_ZERO, _HALF + edge))


@uncounted(error_model="numpy", forceinline=True)
def _per_way(a, b):
    """Inverse of the way of an edge whose distance goes from a to b; 0 where it stands still."""
    way = b - a
    still = abs(way) < _STILL
    per_way = _ONE / (_ONE if still else way)
    return _ZERO if still else per_way


@uncounted(error_model="numpy", forceinline=True)
def _mean_covered(a, b, per_way):
    """Mean of `_covered` while the edge's distance goes evenly from a to b: both antiderivatives.

    Without a branch, for vector instructions. Of what it covers all the time nothing is rounded.
    """
    s, t = _HALF + a, _HALF + b
    u, v = min(_ONE, max(_ZERO, s)), min(_ONE, max(_ZERO, t))
    rise = _HALF * (v * v - u * u) + (max(t, _ONE) - max(s, _ONE))
    by_middle = (per_way == _ZERO) | (min(s, t) >= _ONE)
    return _covered(_HALF * (a + b)) if by_middle else rise * per_way


@uncounted(error_model="numpy", forceinline=True)
def _between(a, b):
    """Fraction of the box on the inner side of two edges that face each other."""
    return max(_ZERO, _covered(a) + _covered(b) - _ONE)


@uncounted(error_model="numpy", forceinline=True)
def _covered_at(t, a, b, c, d, low, low_then, high, high_then):
    """Fraction of the box between two edges and two flanks after a part t of the way."""
    within = _between(low + t * (low_then - low), high + t * (high_then - high))
    return within * _between(a + t * (b - a), c + t * (d - c))


@uncounted(error_model="numpy")
def _lay_outline(stamp, turn, points, flanks):
    """Lay a stamp's outline along its way; `turn` is from there to the stamp's own coordinates."""
    values, widths = stamp.values[0], stamp.half_widths
    ox, oy, c, s = turn[0], turn[1], turn[2], turn[3]
    step = (values.tip - values.heel) / PROFILE_CELLS
    flanks[0], flanks[2] = _NOWHERE, -_NOWHERE
    for i in range(PROFILE_CELLS + 1):
        along = values.heel + i * step
        for side in range(2):
            across = widths[i] if side == 0 else -widths[i]
            x, y = ox + c * along - s * across, oy + s * along + c * across
            points[side, i, 0], points[side, i, 1] = x, y
            if y < flanks[0]:
                flanks[0], flanks[1] = y, x
            if y > flanks[2]:
                flanks[2], flanks[3] = y, x


@uncounted(error_model="numpy")
def cut_outline(points, at, n, per_mm, enters, leaves):
    """Cut an outline by lines along the way: where each enters and leaves it, mm, or never.

    Parameters
    ----------
    points : (2, PROFILE_CELLS + 1, 2) float64
    at : (n or more,) float64
        y of the lines, rising.
    n : int
    per_mm : float
        About how many there are to the mm.
    enters, leaves : (n or more,) float64
        Filled.
    """
    for k in range(n):
        enters[k], leaves[k] = _NOWHERE, -_NOWHERE
    for side in range(2):
        for i in range(PROFILE_CELLS):
            xa, ya = points[side, i, 0], points[side, i, 1]
            xb, yb = points[side, i + 1, 0], points[side, i + 1, 1]
            if ya > yb:
                xa, ya, xb, yb = xb, yb, xa, ya
            k = min(n, max(0, int((ya - at[0]) * per_mm)))
            while k > 0 and at[k - 1] >= ya:
                k -= 1
            while k < n and at[k] < ya:
                k += 1
            slope = (xb - xa) / (yb - ya) if yb > ya else 0.0
            while k < n and at[k] <= yb:
                x = xa + (at[k] - ya) * slope
                enters[k], leaves[k] = min(enters[k], x), max(leaves[k], x)
                k += 1


@uncounted(error_model="numpy")
def fill_chords(before, after, sweep, chords):
    """Make both tables of a sweep's lines, and bands of them for judging many vertices at once.

    Parameters
    ----------
    before, after : Stamp
        Where the way begins and ends; the same twice for a footprint that comes or goes.
    sweep : record of SWEEP
        Its turns and scale are filled; its bands are.
    chords : Chords
        Filled.
    """
    points, flanks = chords.points, chords.flanks
    _lay_outline(before, sweep.to_before, points[0], flanks[0])
    _lay_outline(after, sweep.to_after, points[1], flanks[1])
    for stamp in range(2):
        _fill_lines(
            points[stamp], flanks[stamp], 1.0 / sweep.scale, chords.grids[stamp], chords.cuts,
            chords.sums, chords.nodes[stamp], chords.lines[stamp],
        )  # fmt: skip
    _fill_bands(sweep, chords)


@uncounted(error_model="numpy")
def _fill_lines(points, flanks, box, grid, cuts, sums, nodes, lines):
    """Fill a stamp's table; `box` is the width of a vertex's, mm.

    Lines lie evenly from flank to flank, and half a box beyond. The rows of a box are cuts between
    lines; what of it lies beyond a flank has none.
    """
    breadth = max(flanks[2] - flanks[0], _NARROWEST * box)
    fine = min(_FINE_LINES, int(np.ceil(breadth / (_FINE_PITCH * box))))
    inner = max(2, max(fine, int(np.ceil(breadth / (_PITCH * box)))))
    inner = min(inner, _MOST_LINES - 4)
    apart = breadth / inner
    reach = max(1, int(np.round(0.5 * box / apart)))  # lines to half a box
    steps = inner + 2 * reach
    grid[0], grid[1], grid[2] = flanks[0] - reach * apart, 1.0 / apart, steps
    _sum_cuts(points, flanks, inner, apart / _ROWS, 2 * reach, cuts, sums)
    for column in range(2):
        means, squares = sums[2 * column], sums[2 * column + 1]
        _find_ramps(steps, 2 * reach, inner, box, means, squares, nodes[column], nodes[2 + column])
        ramp = nodes[column]
        ramp[0] = _at_flank(flanks[1], ramp[1], ramp[2])
        ramp[steps] = _at_flank(flanks[3], ramp[steps - 1], ramp[steps - 2])
        nodes[2 + column, 0] = nodes[2 + column, steps] = 1.0 / box
    _write_lines(steps, nodes[0], nodes[1], nodes[2], nodes[3], lines)


@uncounted(error_model="numpy", apart=True)
def _write_lines(steps, enters, leaves, steep, steep_out, lines):
    """Write a table of lines from its nodes."""
    for k in range(steps):
        row = k * _ROW
        lines[row + _ENTERS] = np.float32(enters[k]).view(np.uint32)
        lines[row + _LEAVES] = np.float32(leaves[k]).view(np.uint32)
        lines[row + _RISES] = _pair(enters[k + 1] - enters[k], leaves[k + 1] - leaves[k])
        lines[row + _STEEPS] = _pair(steep[k], steep_out[k])
        lines[row + _STEEP_RISES] = _pair(steep[k + 1] - steep[k], steep_out[k + 1] - steep_out[k])


@uncounted(error_model="numpy", forceinline=True)
def _pair(one, other):
    """Two numbers as halves, in one."""
    upper = np.uint32(np.float32(one).view(np.uint32) + _ROUNDS) & _UPPER
    return upper | (np.uint32(np.float32(other).view(np.uint32) + _ROUNDS) >> _HALF_BITS)


@uncounted(error_model="numpy", forceinline=True)
def _first(pair):
    """The first of a pair of halves."""
    return np.uint32(pair & _UPPER).view(np.float32)


@uncounted(error_model="numpy", forceinline=True)
def _second(pair):
    """The second of a pair of halves."""
    return np.uint32(pair << _HALF_BITS).view(np.float32)


@uncounted(error_model="numpy", apart=True)
def _find_ramps(steps, many, inner, box, means, squares, middles, steeps):
    """Find the middles and steepnesses of ramps on the lines between the first and the last.

    Parameters
    ----------
    steps : int
    many, inner : int
        Lines to a box, and within the outline; the box of the first line ends where these begin.
    box : float
        Width of a box, mm.
    means, squares : (steps + many or more,) float64
        Two rows of `_sum_cuts`.
    middles, steeps : (steps or more,) float64
        Filled, but for the first and the last.
    """
    box2, box_lines, within = box * box, np.float64(many), np.float64(inner)
    means_then, squares_then = means[many:], squares[many:]
    for k in range(1, steps):
        line = np.float64(np.int32(k))
        part = 1.0 / (_ROWS * (min(within, line) - max(0.0, line - box_lines)))
        middle = (means_then[k] - means[k]) * part
        spread = (squares_then[k] - squares[k]) * part - middle * middle
        middles[k] = middle
        # what lies evenly over a width spreads by a twelfth of its square
        steeps[k] = 1.0 / np.sqrt(box2 + 12.0 * max(0.0, spread))


@uncounted(error_model="numpy", forceinline=True)
def _at_flank(flank, near, far):
    """From where at a flank an end of a chord goes straight to where it is near by, on average.

    A corner's chord grows evenly from the flank, as the next two tell, and a round one like a root.
    """
    grown = _ROUND * (2.0 * (near - flank) - (far - flank))
    return flank + grown if grown * (near - flank) > 0.0 else flank


@uncounted(error_model="numpy")
def _sum_cuts(points, flanks, inner, apart, many, cuts, sums):
    """Sum where cuts from flank to flank enter and leave an outline, and their squares, by lines.

    From one cut to the next both go straight; `inner` lines have _ROWS of them each. Sums are 0 up
    to the line `many`, and go on as they are as many lines beyond the last.
    """
    n = inner * _ROWS
    at, enters, leaves = cuts[0], cuts[1], cuts[2]
    for k in range(n):
        at[k] = flanks[0] + k * apart
    at[n] = max(at[n - 1], flanks[2])  # the outline may be narrower than it counts
    cut_outline(points, at, n + 1, 1.0 / apart, enters, leaves)
    for k in range(n + 1):
        if enters[k] > leaves[k]:
            enters[k] = leaves[k] = flanks[1] if 2 * k < n else flanks[3]
    for ends in (enters, leaves):
        ends[0] = _at_flank(flanks[1], ends[1], ends[2])
        ends[n] = _at_flank(flanks[3], ends[n - 1], ends[n - 2])
    _find_terms(n, enters, cuts[3], cuts[4])
    _find_terms(n, leaves, cuts[5], cuts[6])
    sums[:, : many + 1] = 0.0
    enter, enter2, leave, leave2 = 0.0, 0.0, 0.0, 0.0
    for line in range(inner):
        for k in range(line * _ROWS, (line + 1) * _ROWS):
            enter += cuts[3, k]
            enter2 += cuts[4, k]
            leave += cuts[5, k]
            leave2 += cuts[6, k]
        to = many + 1 + line
        sums[0, to], sums[1, to], sums[2, to], sums[3, to] = enter, enter2, leave, leave2
    for k in range(many + 1 + inner, 2 * many + inner):
        sums[0, k], sums[1, k], sums[2, k], sums[3, k] = enter, enter2, leave, leave2


@uncounted(error_model="numpy", apart=True)
def _find_terms(n, ends, means, squares):
    """Fill the means of `n` straight pieces between neighbouring ends, and those of squares."""
    for k in range(n):
        a, b = ends[k], ends[k + 1]
        means[k] = 0.5 * (a + b)
        squares[k] = (a * a + a * b + b * b) * (1.0 / 3.0)


@uncounted(error_model="numpy")
def _fill_bands(sweep, chords):
    """Fill the bands from the tables, and spans of two, four to all of them.

    Boxes beyond all lines of a stamp are asked of its last.
    """
    flanks, bands = chords.flanks, chords.bands
    half = 0.5 / sweep.scale
    first = min(flanks[0, 0], flanks[1, 0]) - half
    per_mm = BANDS / (max(flanks[0, 2], flanks[1, 2]) + half - first)
    sweep.first, sweep.per_mm = first, per_mm
    bands[0], bands[1], bands[2], bands[3] = _NOWHERE, -_NOWHERE, -_NOWHERE, _NOWHERE
    least, most, whole_from, whole_to = (
        chords.cuts[0],
        chords.cuts[1],
        chords.cuts[2],
        chords.cuts[3],
    )
    for stamp in range(2):
        nodes, grid = chords.nodes[stamp], chords.grids[stamp]
        steps, shift = int(grid[2]), (grid[0] - first) * per_mm
        to_bands = per_mm / grid[1]
        _find_reach(
            steps, nodes[0], nodes[1], nodes[2], nodes[3], least, most, whole_from, whole_to
        )
        for j in range(steps):
            begin = max(0, int(shift + j * to_bands)) if j > 0 else 0
            end = min(BANDS, int(shift + (j + 1) * to_bands) + 1) if j + 1 < steps else BANDS
            for band in range(begin, end):
                bands[0, band] = min(bands[0, band], least[j])
                bands[1, band] = max(bands[1, band], most[j])
                bands[2, band] = max(bands[2, band], whole_from[j])
                bands[3, band] = min(bands[3, band], whole_to[j])
    low, high = max(flanks[0, 0], flanks[1, 0]) + half, min(flanks[0, 2], flanks[1, 2]) - half
    for band in range(BANDS):
        if first + band / per_mm < low or first + (band + 1) / per_mm > high:
            bands[2, band], bands[3, band] = _NOWHERE, -_NOWHERE
    for level in range(1, LEVELS):
        below, here, end = (level - 1) * BANDS, level * BANDS, (level + 1) * BANDS
        for row in range(4):
            _fill_level(
                1 << (level - 1), row == 0 or row == 3, bands[row, below:here], bands[row, here:end]
            )


@uncounted(error_model="numpy", apart=True)
def _find_reach(steps, enters, leaves, steep, steep_out, least, most, whole_from, whole_to):
    """Fill from where on boxes between neighbouring lines may be covered, as for the bands."""
    for j in range(steps):
        enter, enter_next, leave, leave_next = enters[j], enters[j + 1], leaves[j], leaves[j + 1]
        wide = (0.5 + _SLACK) / min(steep[j], steep[j + 1])
        wide += _SLACK * abs(enter_next - enter)
        wide_out = (0.5 + _SLACK) / min(steep_out[j], steep_out[j + 1])
        wide_out += _SLACK * abs(leave_next - leave)
        least[j], most[j] = min(enter, enter_next) - wide, max(leave, leave_next) + wide_out
        whole_from[j] = max(enter, enter_next) + wide
        whole_to[j] = min(leave, leave_next) - wide_out


@uncounted(error_model="numpy", apart=True)
def _fill_level(apart, is_least, below, here):
    """Fill what spans of twice as many bands have: the least or most of two that are `apart`."""
    for band in range(BANDS - apart):
        one, other = below[band], below[band + apart]
        here[band] = min(one, other) if is_least else max(one, other)
    last = below[BANDS - 1]
    for band in range(BANDS - apart, BANDS):
        one = below[band]
        here[band] = min(one, last) if is_least else max(one, last)


@uncounted(error_model="numpy", forceinline=True)
def _look_up(y, first, per_mm, last):
    """Find the row of the line before a position in a stamp's table, and the distance from it."""
    at = min(max((y - first) * per_mm, _ZERO), last)
    line = np.int32(at)
    return (np.uint32(line) & np.uint32(_MOST_LINES - 1)) * np.uint32(_ROW), at - np.float32(line)


@uncounted(error_model="numpy", forceinline=True)
def _ends(i, part, lines):
    """Positions of the middles of both ramps."""
    rises = lines[i + np.uint32(_RISES)]
    enters = np.uint32(lines[i + np.uint32(_ENTERS)]).view(np.float32) + part * _first(rises)
    leaves = np.uint32(lines[i + np.uint32(_LEAVES)]).view(np.float32) + part * _second(rises)
    return enters, leaves


@uncounted(error_model="numpy", forceinline=True)
def _distances(x, y, first, per_mm, last, lines):
    """Distances (box widths) of a place to both ramps of a stamp."""
    i, part = _look_up(y, first, per_mm, last)
    enters, leaves = _ends(i, part, lines)
    steeps, rises = lines[i + np.uint32(_STEEPS)], lines[i + np.uint32(_STEEP_RISES)]
    steep = _first(steeps) + part * _first(rises)
    steep_out = _second(steeps) + part * _second(rises)
    return (x - enters) * steep, (leaves - x) * steep_out


@uncounted(error_model="numpy", apart=True)
def weigh(n, scale, flanks, grids, before, after, xs, ys, stretch, fraction, cover):
    """Time-mean fraction for the ink, and greatest fraction covered, of vertices.

    The fraction is w of docs/model.md, equations (9) and (9a).

    Parameters
    ----------
    n : int
    scale : float
        Box widths to the mm.
    flanks, grids : (2, 4) and (2, 3) float64
        Of `fill_chords`.
    before, after : (MOST_LINES * _ROW,) uint32
        The tables of both stamps.
    xs, ys, stretch : (n or more,) float32
        Where vertices lie along the way and across, mm, and how many times their area the plane's
        is.
    fraction, cover : (n or more,) float32
        Filled.
    """
    per_box = np.float32(scale)
    from_a, per_mm_a, last_a = _grid(grids[0])
    from_b, per_mm_b, last_b = _grid(grids[1])
    low_a, high_a = np.float32(flanks[0, 0]), np.float32(flanks[0, 2])
    low_b, high_b = np.float32(flanks[1, 0]), np.float32(flanks[1, 2])
    half = np.float32(0.5 / scale)
    track_low = _track(flanks[0, 0], flanks[0, 1], flanks[1, 0], flanks[1, 1], half)
    track_high = _track(flanks[0, 2], flanks[0, 3], flanks[1, 2], flanks[1, 3], half)
    per_low = _per_way(-low_a * per_box, -low_b * per_box)
    per_high = _per_way(high_a * per_box, high_b * per_box)
    for k in range(n):
        x, y = xs[k], ys[k]
        # beyond a flank, where that passes on its way
        x_a = x - min(_ZERO, y - low_a + half) * track_low
        x_a -= max(_ZERO, y - high_a - half) * track_high
        x_b = x - min(_ZERO, y - low_b + half) * track_low
        x_b -= max(_ZERO, y - high_b - half) * track_high
        a, c = _distances(x_a, y, from_a, per_mm_a, last_a, before)
        b, d = _distances(x_b, y, from_b, per_mm_b, last_b, after)
        per_way, per_way_out = _per_way(a, b), _per_way(c, d)
        mean = max(_ZERO, _mean_covered(a, b, per_way) + _mean_covered(c, d, per_way_out) - _ONE)
        low, high = (y - low_a) * per_box, (high_a - y) * per_box
        low_then, high_then = (y - low_b) * per_box, (high_b - y) * per_box
        within = _mean_covered(low, low_then, per_low) + _mean_covered(high, high_then, per_high)
        # it is greatest at the beginning, at the end, or where an edge has just passed all of it
        t = min(_ONE, max(_ZERO, (_HALF - a) * per_way))
        t_out = min(_ONE, max(_ZERO, (_HALF - c) * per_way_out))
        passed = _covered_at(t, a, b, c, d, low, low_then, high, high_then)
        left = _covered_at(t_out, a, b, c, d, low, low_then, high, high_then)
        begin = _between(low, high) * _between(a, c)
        end = _between(low_then, high_then) * _between(b, d)
        most = max(max(passed, left), max(begin, end))
        cover[k] = most if most > _NOTHING else _ZERO
        weight = (within - _ONE) * mean
        fraction[k] = weight * stretch[k] if min(weight, most) > _NOTHING else _ZERO


@uncounted(error_model="numpy", apart=True)
def find_begun(n, scale, flanks, grid, lines, xs, ys, begun):
    """Fraction of vertices' boxes that the outline covers where a sweep begins.

    Parameters
    ----------
    n : int
    scale : float
        Box widths to the mm.
    flanks, grid, lines : (4,) and (3,) float64, (MOST_LINES * _ROW,) uint32
        Of `fill_chords`, those of the first stamp.
    xs, ys : (n or more,) float32
        Where vertices lie along the way and across, mm.
    begun : (n or more,) float32
        Filled.
    """
    per_box = np.float32(scale)
    first, per_mm, last = _grid(grid)
    low, high = np.float32(flanks[0]), np.float32(flanks[2])
    for k in range(n):
        y = ys[k]
        enters, leaves = _distances(xs[k], y, first, per_mm, last, lines)
        begun[k] = _between((y - low) * per_box, (high - y) * per_box) * _between(enters, leaves)


@uncounted(error_model="numpy", forceinline=True)
def _track(y, x, y_then, x_then, half):
    """Slope of a flank's way, mm along it for each mm across; 0 where it hardly goes across."""
    across = y_then - y
    return np.float32((x_then - x) / across) if abs(across) > 0.1 * half else _ZERO


@uncounted(error_model="numpy", forceinline=True)
def _grid(grid):
    """y of a stamp's first line, lines to the mm, and the last place between two."""
    return np.float32(grid[0]), np.float32(grid[1]), np.float32(grid[2] - 1e-3)


@uncounted(error_model="numpy")
def hold_within(n, scale, flanks, grid, lines, xs, ys):
    """Move vertices that a footprint has passed to where their boxes touched its edge last.

    Parameters
    ----------
    n : int
    scale : float
        Box widths to the mm.
    flanks : (4,) float64
    grid : (3,) float64
    lines : (MOST_LINES ROW,) uint32
        Those of the stamp.
    xs, ys : (n or more,) float32
        Positions along and across the way, mm; changed.
    """
    first, per_mm, last = _grid(grid)
    half = np.float32(0.5 / scale)
    low, high = np.float32(flanks[0]) - half, np.float32(flanks[2]) + half
    for k in range(n):
        i, part = _look_up(ys[k], first, per_mm, last)
        enters, leaves = _ends(i, part, lines)
        xs[k] = min(max(xs[k], enters - half), leaves + half)
        ys[k] = min(max(ys[k], low), high)


@uncounted(error_model="numpy", apart=True)
def fetch(runs, n_runs, ids, n, values, out):
    """Fill the values that vertices found have; `values` holds those of all.

    `runs` (n_runs or more, 2) and `ids` (n or more,) are those of `Found`.
    """
    at = 0
    for r in range(n_runs):
        first, many = runs[r, 0], runs[r, 1]
        source, target = values[first : first + many], out[at : at + many]
        for k in range(many):
            target[k] = source[k]
        at += many
    for k in range(at, n):
        out[k] = values[as_index(ids[k])]


@uncounted(error_model="numpy", apart=True)
def weighed_area(n, area, fraction, step):
    """Area that vertices stand for, weighed, mm2.

    Summed in whole numbers of steps (mm2, a power of two, see `SurfaceField`), so that the order in
    which vertices are found, which depends on what was refined before, cannot change a bit of it.
    The sum of a number and `_MIDDLE` steps has its whole number of steps in its last bits.
    """
    middle = np.float64(_MIDDLE * step)
    total = np.int64(0)
    for k in range(n):
        near = np.float64(fraction[k] * area[k] + middle)
        total += near.view(np.int64)
    return (total - n * middle.view(np.int64)) * step
