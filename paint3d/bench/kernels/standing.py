"""Stamps that stand alone, without a stroke: placed all at once, inked one by one."""

from __future__ import annotations

from paint3d.brush_engine.ink_transfer import sweep_deposit
from paint3d.brush_engine.placement import lean_plane, place_stamp
from paint3d.core.kernel import kernel

__all__ = ["deposit_standing", "place_standing"]


@kernel
def place_standing(poses, tuft, tree, field, scratch, stamp, kept):
    """Place a stamp for every pose (D, 9), and keep them in one with arrays of D rows."""
    nothing = stamp.values.copy()
    for i in range(poses.shape[0]):
        stamp.values[0] = nothing[0]
        place_stamp(poses[i], False, stamp, stamp, tuft, tree, field, scratch)
        kept.values[i, 0] = stamp.values[0]
        kept.half_widths[i] = stamp.half_widths
        kept.lines[i] = stamp.lines


@kernel
def deposit_standing(kept, tuft, field, ink, scratch, before, after):
    """Leave every stamp once: plane, vertices, projection and ink. `before` touches nothing."""
    for i in range(kept.values.shape[0]):
        after.values[0] = kept.values[i, 0]
        after.half_widths[:] = kept.half_widths[i]
        after.lines[:] = kept.lines[i]
        lean_plane(after.values[0], field, scratch)
        sweep_deposit(before, after, tuft, field, ink, scratch)
