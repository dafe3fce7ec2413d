"""When hairs need not be bent and drawn anew: as long as they would lie as they do.

All hairs follow from the numbers that `kernels.bristle_tuft.fill_bend` is given. While those have
hardly changed, and the tuft has gone less than half the way from vertex to vertex, the imprint is
the last one, carried along.
"""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine import stamp as st
from paint3d.brush_engine.bristles.outline import hold_outline
from paint3d.core.kernel import kernel

__all__ = ["DRAWN", "KEPT_SIZE", "TOUCHING", "carry_outline", "keep_bend", "keep_outline",
           "may_keep", "note_cause"]  # fmt: skip

# Places in Hairs.kept.
TOUCHING = 0  # hairs that touch, as they were bent last; 0: nothing is kept
DRAWN = 1  # 1.0 where they are also drawn so
_WAY = 2  # of the tuft to where they were bent, mm
_CAUSE = 3  # 14 numbers that they were bent by
_NOW = 17  # and those of the stamp in hand
_OUTLINE = 31  # 5 values, and half widths, of the outline drawn last
KEPT_SIZE = _OUTLINE + 5 + st.PROFILE_CELLS + 2

_MOST_WAY = 0.5  # of the vertex spacing
_MOST_BEND = 1.0 / 16.0  # of the vertex spacing


@kernel(error_model="numpy")
def note_cause(values, tuft, patch, dryness, parted, set_x, set_y, kept):
    """Note what the hairs of a stamp would be bent by, in mm at the tuft's border."""
    radius = values.radius
    now = kept[_NOW:_OUTLINE]
    now[0] = values.descent
    now[1] = values.tilt * tuft.length
    now[2] = values.pressure * radius
    now[3] = tuft.spread * radius
    now[4] = patch[0]
    now[5], now[6] = patch[1] * radius, patch[2] * radius
    for k in range(3, 6):
        now[4 + k] = patch[k] * radius * radius
    now[10], now[11] = dryness * radius, parted * radius
    now[12], now[13] = set_x, set_y


@kernel(error_model="numpy")
def may_keep(before, values, way_done, resolution, kept):
    """Whether the hairs may stay as they were bent last.

    Parameters
    ----------
    before : Stamp
    values : (N_VALUES,) float64
        Of the stamp in hand.
    way_done : float
        Of the tuft up to `before`, mm.
    resolution : float
        Vertex spacing, mm.
    kept : (KEPT_SIZE,) float64
        With the stamp's cause.
    """
    if kept[TOUCHING] <= 0.0:
        return False
    way = way_done - kept[_WAY] + _step(before, values)
    if way < 0.0 or way > _MOST_WAY * resolution:
        return False
    change = 0.0
    for k in range(_OUTLINE - _NOW):
        change += abs(kept[_NOW + k] - kept[_CAUSE + k])
    return change <= _MOST_BEND * resolution


@kernel(error_model="numpy")
def _step(before, values):
    """Way of the foot point from the stamp before, mm."""
    d2 = 0.0
    for axis in range(3):
        d2 += (values.foot[axis] - before.values[0].foot[axis]) ** 2
    return np.sqrt(d2)


@kernel(error_model="numpy")
def keep_bend(before, values, way_done, touching, kept):
    """Note that the hairs were bent by the stamp's cause, and how many touch."""
    kept[TOUCHING] = touching
    kept[DRAWN] = 0.0
    kept[_WAY] = way_done + _step(before, values)
    kept[_CAUSE:_NOW] = kept[_NOW:_OUTLINE]


@kernel(error_model="numpy")
def keep_outline(stamp, kept, lines):
    """Note the outline that was drawn."""
    values, out = stamp.values[0], kept[_OUTLINE:]
    out[0], out[1], out[2] = values.heel, values.tip, values.widest
    out[3], out[4] = values.widest_at, values.area
    out[5:] = stamp.half_widths
    lines[:] = stamp.lines
    kept[DRAWN] = 1.0


@kernel(error_model="numpy")
def carry_outline(stamp, kept, lines):
    """Give a stamp the outline that was drawn last."""
    values, out = stamp.values[0], kept[_OUTLINE:]
    values.heel, values.tip, values.widest = out[0], out[1], out[2]
    values.widest_at, values.area = out[3], out[4]
    stamp.half_widths[:] = out[5:]
    stamp.lines[:] = lines
    hold_outline(values)
