"""How much of a vertex's own small box a sweeping footprint covers, and for how long.

Guo 2017 asks whether a vertex lies inside the outline. Here it is asked for how long: its share of
the ink is the mean share of its box that was covered on the way between the two stamps. That closes
the gaps between samples (Guo 2015, section 3.2), does not darken with the sampling rate, and draws
edges finer than the vertices.

The footprints are cut into lines along the way, half a box apart. On each line an outline has a
chord. From the stamp before to the stamp after its ends go evenly, so how long a box was behind
each end, how long within both, and how much of it at the most are closed forms. One table of lines
is made for a sweep, and every vertex looks its line up once, in vector instructions.

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
    "MOST_LINES",
    "Chords",
    "cut_outline",
    "fetch",
    "fill_chords",
    "hold_within",
    "make_chords",
    "weigh",
    "weighed_area",
]

_MIDDLE = 1.5 * 2.0**52  # whole numbers near to it are apart by one
MOST_LINES = 1024  # a power of two
_LEAST_LINES = 16
_PITCH = 0.5  # box widths from line to line
_NOWHERE = 1e30  # mm
_NOTHING = np.float32(1e-5)  # share of a box
_STILL = np.float32(1e-3)  # box widths: a shorter way is judged by its middle
BANDS, LEVELS = 64, 7  # bands of neighbouring lines, and of these spans of 1, 2, 4 to 64
_HALF = np.float32(0.5)
_ONE = np.float32(1.0)
_ZERO = np.float32(0.0)
# Columns of the table: a number between a line and the next is first + rise x part. Where the
# chord is entered and left at one stamp, mm; how steep the outline is there, box widths to the mm
# along the way, and how many box widths farther ahead it is at the other stamp; for which share of
# the way the box lies between the flanks, and how much of it there at that stamp and the other.
_ENTERS, _ENTERS_RISE, _LEAVES, _LEAVES_RISE, _STEEP, _STEEP_OUT, _COMES, _GOES = range(8)
_WITHIN, _WITHIN_RISE, _NOW, _NOW_RISE, _THEN, _THEN_RISE = range(8, 14)
_ROW = 16


class Chords(NamedTuple):
    """Scratch of a sweep's table of lines; places along and across the way, mm."""

    points: NDArray  # (2, 2, PROFILE_CELLS + 1, 2) float64, both sides of both stamps' outlines
    flanks: NDArray  # (2, 4) float64, y and x of their lowest points, and of their highest
    at: NDArray  # (2, MOST_LINES) float64, y of the middle of what of a box on each line lies
    # between the flanks of both stamps
    ends: NDArray  # (4, MOST_LINES) float64, where the chords of both stamps are entered and left
    lines: NDArray  # (MOST_LINES * _ROW,) float32, the table
    bands: NDArray  # (4, LEVELS * BANDS) float32: from where on a box may be covered on the way,
    # and to where, and from where to where it is all covered all the time


def make_chords() -> Chords:
    """Scratch for the lines of a sweep."""
    return Chords(
        np.zeros((2, 2, PROFILE_CELLS + 1, 2)),
        np.zeros((2, 4)),
        np.zeros((2, MOST_LINES)),
        np.zeros((4, MOST_LINES)),
        np.zeros(MOST_LINES * _ROW, np.float32),
        np.zeros((4, LEVELS * BANDS), np.float32),
    )


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


@uncounted(error_model="numpy", forceinline=True)
def _most_covered(a, b, c, d, first, last):
    """Greatest share of the box between two edges whose distances go from a to b, and c to d.

    Of all of it there are shares that go from `first` to `last`.
    """
    before, after = a - c, b - d
    passes = before * after < _ZERO
    part = before / (before - after if passes else _ONE)
    deep = _covered(a + part * (b - a))
    middle = (first + part * (last - first)) * (deep + deep - _ONE) if passes else _ZERO
    begin = first * (_covered(a) + _covered(c) - _ONE)
    end = last * (_covered(b) + _covered(d) - _ONE)
    return max(max(_ZERO, middle), max(begin, end))


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
    """Where lines along the way enter and leave an outline, mm; one that passes it by, never.

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
    """Make the table of a sweep's lines, and bands of them for judging many vertices at once.

    Parameters
    ----------
    before, after : Stamp
        Where the way begins and ends; the same twice for a footprint that comes or goes.
    sweep : record of SWEEP
        Its turns and scale are filled; its lines are.
    chords : Chords
        Filled.
    """
    points, flanks, at, ends = chords.points, chords.flanks, chords.at, chords.ends
    _lay_outline(before, sweep.to_before, points[0], flanks[0])
    _lay_outline(after, sweep.to_after, points[1], flanks[1])
    low, high = min(flanks[0, 0], flanks[1, 0]), max(flanks[0, 2], flanks[1, 2])
    half = 0.5 / sweep.scale
    extent = high - low + 2.0 * half
    n = int(np.ceil(extent * sweep.scale / _PITCH))
    n = max(_LEAST_LINES, min(MOST_LINES - 2, n))
    apart = extent / n
    n += 1  # steps: in the last, nothing is covered
    sweep.first, sweep.per_mm, sweep.lines = low - half, 1.0 / apart, n
    for stamp in range(2):
        for k in range(n + 1):
            y = sweep.first + k * apart
            at[stamp, k] = 0.5 * (max(y - half, flanks[stamp, 0]) + min(y + half, flanks[stamp, 2]))
        enters, leaves = ends[2 * stamp], ends[2 * stamp + 1]
        cut_outline(points[stamp], at[stamp], n + 1, 1.0 / apart, enters, leaves)
    _begin_at_flanks(n + 1, apart, sweep.first, flanks, ends)
    _grow_evenly(n + 1, ends)
    _fill_lines(n, apart, sweep, chords)
    _fill_bands(n, chords)


@uncounted(error_model="numpy")
def _begin_at_flanks(n, apart, first, flanks, ends):
    """Let chords that only one stamp has grow from where the other's flank comes over their lines.

    How long that takes is no matter of theirs: the table says for how long they are there.
    """
    middle = 0.25 * (flanks[0, 0] + flanks[0, 2] + flanks[1, 0] + flanks[1, 2])
    for k in range(n):
        at = first + k * apart
        side = 0 if at < middle else 2
        y, y_end = flanks[0, side], flanks[1, side]
        x, x_end = flanks[0, side + 1], flanks[1, side + 1]
        t = (at - y) / (y_end - y) if y != y_end else 0.0
        here = x + min(1.0, max(0.0, t)) * (x_end - x)
        for stamp in range(0, 4, 2):
            if ends[stamp, k] > ends[stamp + 1, k]:
                ends[stamp, k] = ends[stamp + 1, k] = here


@uncounted(error_model="numpy")
def _grow_evenly(n, ends):
    """Lengthen the shorter of a line's two chords, so that growing evenly it is as long on average.

    Where a flank comes over a line its chord grows like a root: of its length's square evenly.
    """
    for k in range(n):
        a, b, c, d = ends[0, k], ends[1, k], ends[2, k], ends[3, k]
        shorter, longer = (0, 2) if b - a < d - c else (2, 0)
        begin, end = ends[longer, k], ends[longer + 1, k]
        inner_begin, inner_end = ends[shorter, k], ends[shorter + 1, k]
        most, least = end - begin, inner_end - inner_begin
        if most <= least:
            continue
        mean = 2.0 / 3.0 * (most * most + most * least + least * least) / (most + least)
        grown = 0.5 * (2.0 * mean - most - least)
        ends[shorter, k] = max(inner_begin - grown, min(inner_begin, begin))
        ends[shorter + 1, k] = min(inner_end + grown, max(inner_end, end))


@uncounted(error_model="numpy")
def _fill_lines(n, apart, sweep, chords):
    """Fill the table from where n + 1 lines are entered and left.

    As time may run either way, it is told from the stamp after, or from the one before where the
    chord is longer there.
    """
    at, ends, lines, flanks = chords.at, chords.ends, chords.lines, chords.flanks
    scale = sweep.scale
    last_within, last_first, last_last = _ZERO, _ZERO, _ZERO
    for k in range(n + 1):
        y = sweep.first + k * apart
        a, b = np.float32((y - flanks[0, 0]) * scale), np.float32((y - flanks[1, 0]) * scale)
        c, d = np.float32((flanks[0, 2] - y) * scale), np.float32((flanks[1, 2] - y) * scale)
        within = max(_ZERO, _mean_covered(a, b) + _mean_covered(c, d) - _ONE)
        within = within if within > _NOTHING else _ZERO
        first = max(_ZERO, _covered(a) + _covered(c) - _ONE)
        last = max(_ZERO, _covered(b) + _covered(d) - _ONE)
        if min(first, last) <= _ZERO:  # it comes to the line, and is all there at once
            first = last = max(first, last)
        if within <= _ZERO:
            first = last = _ZERO
        if k > 0:
            j, row = k - 1, (k - 1) * _ROW
            longer = ends[1, j] + ends[1, k] - ends[0, j] - ends[0, k]
            longer -= ends[3, j] + ends[3, k] - ends[2, j] - ends[2, k]
            base = 0 if longer * scale > 0.5 else 2
            dy = at[base // 2, k] - at[base // 2, j]
            for end in range(2):
                then, now, column = ends[2 - base + end], ends[base + end], 2 * end
                rise = now[k] - now[j]
                slope = rise / dy if dy > 0.0 else 0.0
                # across what of the box lies between the flanks
                slope *= 0.5 * (max(last_first, last_last) + max(first, last))
                steep = scale / np.sqrt(1.0 + slope * slope)
                lines[row + column] = now[j]
                lines[row + column + 1] = rise
                lines[row + _STEEP + end] = steep
                lines[row + _COMES + end] = 0.5 * (then[j] + then[k] - now[j] - now[k]) * steep
            lines[row + _WITHIN] = last_within
            lines[row + _WITHIN_RISE] = within - last_within
            here, other = (_NOW, _THEN) if base == 2 else (_THEN, _NOW)
            lines[row + here] = last_last
            lines[row + here + 1] = last - last_last
            lines[row + other] = last_first
            lines[row + other + 1] = first - last_first
        last_within, last_first, last_last = within, first, last


@uncounted(error_model="numpy")
def _fill_bands(n, chords):
    """Fill the bands from the table, and spans of two, four to all of them."""
    lines, bands = chords.lines, chords.bands
    bands[0], bands[1], bands[2], bands[3] = _NOWHERE, -_NOWHERE, -_NOWHERE, _NOWHERE
    for j in range(n):
        row = j * _ROW
        steep, steep_out = lines[row + _STEEP], lines[row + _STEEP_OUT]
        comes, goes = lines[row + _COMES] / steep, lines[row + _GOES] / steep_out
        least, most, whole_from, whole_to = _NOWHERE, -_NOWHERE, -_NOWHERE, _NOWHERE
        for part in range(2):
            enters = lines[row + _ENTERS] + part * lines[row + _ENTERS_RISE]
            leaves = lines[row + _LEAVES] + part * lines[row + _LEAVES_RISE]
            least = min(least, enters + min(0.0, comes) - 0.5 / steep)
            most = max(most, leaves + max(0.0, goes) + 0.5 / steep_out)
            whole_from = max(whole_from, enters + max(0.0, comes) + 0.5 / steep)
            whole_to = min(whole_to, leaves + min(0.0, goes) - 0.5 / steep_out)
        within = lines[row + _WITHIN]
        if min(within, within + lines[row + _WITHIN_RISE]) < 0.99999:
            whole_from, whole_to = _NOWHERE, -_NOWHERE
        for band in range(j * BANDS // n, ((j + 1) * BANDS - 1) // n + 1):
            bands[0, band] = min(bands[0, band], least)
            bands[1, band] = max(bands[1, band], most)
            bands[2, band] = max(bands[2, band], whole_from)
            bands[3, band] = min(bands[3, band], whole_to)
    for level in range(1, LEVELS):
        apart, here, below = 1 << (level - 1), level * BANDS, (level - 1) * BANDS
        for band in range(BANDS):
            other = min(band + apart, BANDS - 1)
            bands[0, here + band] = min(bands[0, below + band], bands[0, below + other])
            bands[1, here + band] = max(bands[1, below + band], bands[1, below + other])
            bands[2, here + band] = max(bands[2, below + band], bands[2, below + other])
            bands[3, here + band] = min(bands[3, below + band], bands[3, below + other])


@uncounted(error_model="numpy", apart=True)
def weigh(n, sweep, lines, xs, ys, stretch, share, cover):
    """Time-mean share for the ink, and greatest share covered, of vertices.

    The share is w of docs/model.md, equation (9).

    Parameters
    ----------
    n : int
    sweep : record of SWEEP
    lines : (MOST_LINES * _ROW,) float32
        Of `fill_chords`.
    xs, ys, stretch : (n or more,) float32
        Where vertices lie along the way and across, mm, and how many times their area the plane's
        is.
    share, cover : (n or more,) float32
        Filled.
    """
    first, per_mm = np.float32(sweep.first), np.float32(sweep.per_mm)
    last = np.float32(sweep.lines - 1e-3)
    row, mask = np.uint32(_ROW), np.uint32(MOST_LINES - 1)
    for k in range(n):
        x = xs[k]
        at = min(max((ys[k] - first) * per_mm, _ZERO), last)
        line = np.int32(at)
        i, part = (np.uint32(line) & mask) * row, at - np.float32(line)
        steep, steep_out = lines[i + np.uint32(_STEEP)], lines[i + np.uint32(_STEEP_OUT)]
        enters = lines[i + np.uint32(_ENTERS)] + part * lines[i + np.uint32(_ENTERS_RISE)]
        leaves = lines[i + np.uint32(_LEAVES)] + part * lines[i + np.uint32(_LEAVES_RISE)]
        b, d = (x - enters) * steep, (leaves - x) * steep_out
        a, c = b - lines[i + np.uint32(_COMES)], d + lines[i + np.uint32(_GOES)]
        mean = max(_ZERO, _mean_covered(a, b) + _mean_covered(c, d) - _ONE)
        within = lines[i + np.uint32(_WITHIN)] + part * lines[i + np.uint32(_WITHIN_RISE)]
        share[k] = within * mean * stretch[k]
        then = lines[i + np.uint32(_THEN)] + part * lines[i + np.uint32(_THEN_RISE)]
        now = lines[i + np.uint32(_NOW)] + part * lines[i + np.uint32(_NOW_RISE)]
        cover[k] = _most_covered(a, b, c, d, then, now)


@uncounted(error_model="numpy")
def hold_within(n, sweep, flanks, lines, xs, ys):
    """Move vertices that the footprint has passed to where they lay on its edge last."""
    first, per_mm = np.float32(sweep.first), np.float32(sweep.per_mm)
    last, half = np.float32(sweep.lines - 1e-3), np.float32(0.5 / sweep.scale)
    low, high = np.float32(flanks[0]) - half, np.float32(flanks[2]) + half
    row, mask = np.uint32(_ROW), np.uint32(MOST_LINES - 1)
    for k in range(n):
        at = min(max((ys[k] - first) * per_mm, _ZERO), last)
        line = np.int32(at)
        i, part = (np.uint32(line) & mask) * row, at - np.float32(line)
        enters = lines[i + np.uint32(_ENTERS)] + part * lines[i + np.uint32(_ENTERS_RISE)]
        leaves = lines[i + np.uint32(_LEAVES)] + part * lines[i + np.uint32(_LEAVES_RISE)]
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
