"""When hairs need not be bent and drawn anew: as long as they would lie as they do.

All hairs follow from what `bend.fill_bend` is given. While those have
hardly changed, and the tuft has gone less than half the way from vertex to vertex, the imprint is
the last one, carried along.
"""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine import stamp as st
from paint3d.brush_engine.bristles.outline import hold_outline
from paint3d.core.kernel import kernel

__all__ = ["KEPT", "carry_outline", "keep_bend", "keep_outline", "may_keep", "note_cache_key"]

_CAUSES = 14  # numbers that hairs are bent by
_MOST_WAY = 0.5  # of the vertex spacing
_MOST_BEND = 1.0 / 16.0  # of the vertex spacing

KEPT = np.dtype(
    [
        ("touching", "f8"),  # hairs that touch, as they were bent last; 0: nothing is kept
        ("drawn", "f8"),  # 1.0 where they are also drawn so
        ("way", "f8"),  # of the tuft to where they were bent, mm
        ("cause", "f8", _CAUSES),  # what they were bent by, in mm at the tuft's border
        ("now", "f8", _CAUSES),  # and that of the stamp in hand
        ("heel", "f8"),  # of the outline drawn last, as of a stamp
        ("tip", "f8"),
        ("widest", "f8"),
        ("widest_at", "f8"),
        ("area", "f8"),
        ("half_widths", "f8", st.PROFILE_CELLS + 2),
    ],
    align=True,
)
"""How the hairs were bent and drawn last."""


@kernel(error_model="numpy")
def note_cache_key(cause, radius, tuft, kept):
    """Note what the hairs would be bent by, in mm at the border of a tuft in such a sphere (mm)."""
    patch, now = cause.patch, kept.now
    now[0] = cause.descent
    now[1] = cause.tilt * tuft.length
    now[2] = cause.pressure * radius
    now[3] = tuft.spread * radius
    now[4] = patch[0]
    now[5], now[6] = patch[1] * radius, patch[2] * radius
    for k in range(3, 6):
        now[4 + k] = patch[k] * radius * radius
    now[10], now[11] = cause.dryness * radius, cause.parted * radius
    now[12], now[13] = cause.set_x, cause.set_y


@kernel(error_model="numpy")
def may_keep(before, values, way_done, resolution, kept):
    """Whether the hairs may stay as they were bent last.

    Parameters
    ----------
    before : Stamp
    values : record of GEOMETRY
        Of the stamp in hand.
    way_done : float
        Of the tuft up to `before`, mm.
    resolution : float
        Vertex spacing, mm.
    kept : record of KEPT
        With the stamp's cause.
    """
    if kept.touching <= 0.0:
        return False
    way = way_done - kept.way + _step(before, values)
    if way < 0.0 or way > _MOST_WAY * resolution:
        return False
    change = 0.0
    for k in range(_CAUSES):
        change += abs(kept.now[k] - kept.cause[k])
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
    kept.touching = touching
    kept.drawn = 0.0
    kept.way = way_done + _step(before, values)
    kept.cause[:] = kept.now


@kernel(error_model="numpy")
def keep_outline(stamp, kept, lines):
    """Note the outline that was drawn."""
    values = stamp.values[0]
    kept.heel, kept.tip, kept.widest = values.heel, values.tip, values.widest
    kept.widest_at, kept.area = values.widest_at, values.area
    kept.half_widths[:] = stamp.half_widths
    lines[:] = stamp.lines
    kept.drawn = 1.0


@kernel(error_model="numpy")
def carry_outline(stamp, kept, lines):
    """Give a stamp the outline that was drawn last."""
    values = stamp.values[0]
    values.heel, values.tip, values.widest = kept.heel, kept.tip, kept.widest
    values.widest_at, values.area = kept.widest_at, kept.area
    stamp.half_widths[:] = kept.half_widths
    stamp.lines[:] = lines
    hold_outline(values)
