"""Wet ink lies under a brush as an even film (docs/model.md, equation (12)).

Guo 2017, Eq. 13 gives every vertex under the footprint the same, moment by moment. What is under
the middle of the tuft for long then gets much, and what only its flank passes gets little: a ridge
with pale rims. A wet tuft and the ink under it are one body of liquid, though, that levels across
the way as it goes. So each line of the footprint along the way gets as much to the mm2, however
long or short it is; on a glaze the flanks rather more, where the film is drawn to as it dries, and
rather less on paper that drinks it meanwhile.
"""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine.footprint import PROFILE_CELLS, outline_motion
from paint3d.core.kernel import uncounted

__all__ = ["LINES", "level_shares"]

LINES = 64  # along the way, side by side, that a footprint is cut into
_RUNS_DRY = (0.15, 0.3)  # contact level below which a tuft has no film, and from which it has one
_MOST = 6.0  # times a share that a line gets
_ON_GLAZE, _ON_GRAIN = 1.15, 0.65  # power of a line's length that what it gets falls with
_LEAST_WAY = 1e-9  # mm


@uncounted(error_model="numpy")
def _middle(values, axis):
    """Coordinate of the middle of an outline's length."""
    return values.origin[axis] + 0.5 * (values.heel + values.tip) * values.bend[axis]


@uncounted(error_model="numpy")
def _find_way(before, after):
    """How much of a footprint's motion its way is, and where that leads, by bend and cross.

    0 for one that turns, grows or comes down in its place, 1 for one that is only carried on.
    """
    a, b = before.values[0], after.values[0]
    along = across = 0.0
    for axis in range(3):
        d = _middle(b, axis) - _middle(a, axis)
        along += d * b.bend[axis]
        across += d * b.cross[axis]
    carried = np.sqrt(along * along + across * across)
    if carried < _LEAST_WAY:
        return 0.0, 0.0, 0.0
    moved = outline_motion(before, after)
    return min(1.0, carried / moved), along / carried, across / carried


@uncounted(error_model="numpy")
def _reach_lines(x, y, last_x, last_y, first, step, ends):
    """Let an edge of the outline reach the lines (their `ends` (2, LINES)) that it crosses."""
    at, last = (y - first) / step - 0.5, (last_y - first) / step - 0.5
    low, high = min(at, last), max(at, last)
    for line in range(max(0, int(np.ceil(low))), min(LINES - 1, int(np.floor(high))) + 1):
        part = (line - last) / (at - last) if at != last else 0.0
        reach = last_x + part * (x - last_x)
        ends[0, line] = min(ends[0, line], reach)
        ends[1, line] = max(ends[1, line], reach)


@uncounted(error_model="numpy")
def _fill_lines(stamp, way, ends):
    """Cut a footprint into lines along the way, side by side; fill `ends` (2, LINES) with theirs.

    Returns where across the way, from the stamp's origin, the first begins, and how far they lie
    apart (mm).
    """
    values, widths = stamp.values[0], stamp.half_widths
    step = (values.tip - values.heel) / PROFILE_CELLS
    left, right = 1e30, -1e30
    for i in range(PROFILE_CELLS + 1):
        middle = -way[1] * (values.heel + i * step)
        aside = abs(way[0]) * widths[i]
        left, right = min(left, middle - aside), max(right, middle + aside)
    apart = (right - left) / LINES
    ends[0, :] = 1e30
    ends[1, :] = -1e30
    for side in (-1.0, 1.0):
        last_x = last_y = 0.0
        for i in range(PROFILE_CELLS + 1):
            along, across = values.heel + i * step, side * widths[i]
            x, y = way[0] * along + way[1] * across, way[0] * across - way[1] * along
            if i > 0:
                _reach_lines(x, y, last_x, last_y, left, apart, ends)
            last_x, last_y = x, y
    return left, apart


@uncounted(error_model="numpy")
def _fill_gains(lines, strength, power):
    """Fill the third row of `lines`: how many times its share what lies on each gets."""
    ends, gains = lines[:2], lines[2]
    mean, count = 0.0, 0
    for line in range(LINES):
        length = max(0.0, ends[1, line] - ends[0, line])
        gains[line] = length
        mean += length
        count += length > 0.0
    mean /= max(1, count)
    for line in range(LINES):
        gain = _MOST
        if gains[line] > 0.0:
            gain = min(_MOST, (mean / gains[line]) ** power)
        gains[line] = 1.0 + strength * (gain - 1.0)


@uncounted(error_model="numpy")
def _give_by_line(values, way, first, apart, gains, field, found, n):
    """Multiply the shares of vertices by what the lines on which they lie get."""
    ids, share = found.ids, found.share
    ax = (way[0] * values.cross[0] - way[1] * values.bend[0]) / apart
    ay = (way[0] * values.cross[1] - way[1] * values.bend[1]) / apart
    az = (way[0] * values.cross[2] - way[1] * values.bend[2]) / apart
    start = ax * values.origin[0] + ay * values.origin[1] + az * values.origin[2]
    start += first / apart + 0.5
    for k in range(n):
        v = ids[k]
        at = ax * field.px[v] + ay * field.py[v] + az * field.pz[v] - start
        at = min(max(at, 0.0), LINES - 1.001)
        line = np.int64(at)
        gain = gains[line] + (at - line) * (gains[line + 1] - gains[line])
        share[k] *= np.float32(gain)


@uncounted(error_model="numpy")
def level_shares(before, after, level, grain, field, n, scratch):
    """Let what a sweep leaves lie as an even film across the way, as far as the tuft is wet.

    Parameters
    ----------
    before, after : Stamp
    level : float
        See `ink_transfer.contact_level`.
    grain : float
        Of the surface's material, 0 to 1.
    field : SurfaceField
    n : int
        Vertices in `scratch.found`; their shares are changed.
    scratch : Scratch

    Returns
    -------
    bool
        Whether they were.
    """
    values = after.values[0]
    if before.values[0].touches <= 0.0 or values.touches <= 0.0 or values.tip <= values.heel:
        return False
    wet = min(1.0, (level - _RUNS_DRY[0]) / (_RUNS_DRY[1] - _RUNS_DRY[0]))
    carried, along, across = _find_way(before, after)
    if wet <= 0.0 or carried <= 0.0:
        return False
    way, lines = (along, across), scratch.lines
    first, apart = _fill_lines(after, way, lines)
    power = _ON_GLAZE + grain * (_ON_GRAIN - _ON_GLAZE)
    _fill_gains(lines, wet * carried, power)
    _give_by_line(values, way, first, apart, lines[2], field, scratch.found, n)
    return True
