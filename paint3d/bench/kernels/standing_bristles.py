"""Imprints of hairs without a stroke: bent or left again and again, to be measured."""

from __future__ import annotations

from paint3d.brush_engine.bristles.bend import bend_hairs, fill_bend
from paint3d.brush_engine.bristles.ink_transfer import sweep_hairs
from paint3d.brush_engine.ink_transfer import sweep_deposit
from paint3d.core.kernel import kernel

__all__ = ["bend_often", "deposit_hairs_often", "deposit_often"]


@kernel
def bend_often(times, bristles, tuft, cause, turned, bend, block, points):
    """Bend all hairs `times` times from tables; arguments as in `brush_engine.bristles.bend`."""
    for _ in range(times):
        fill_bend(bristles, tuft, cause, bend[0])
        bend_hairs(bristles.rests, turned, bend[0], block, points)


@kernel
def deposit_often(times, before, after, tuft, field, ink, scratch):
    """Leave a solid tuft's footprint `times` times; as by `sweep_deposit`."""
    for _ in range(times):
        sweep_deposit(before, after, tuft, field, ink, scratch)


@kernel
def deposit_hairs_often(times, before, after, hairs, field, ink, scratch):
    """Leave an imprint of hairs `times` times; as by `sweep_hairs`."""
    for _ in range(times):
        sweep_hairs(before, after, 0.0, 0.0, hairs, field, ink, scratch)
