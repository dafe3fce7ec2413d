"""Where a layer or a group of layers goes by one step up or down, into groups and out of them."""

from __future__ import annotations

from collections.abc import Sequence

from paint3d.surface.layer_stack import Layer, group_span

__all__ = ["group_step", "layer_step"]


def layer_step(layers: Sequence[Layer], index: int, by: int) -> tuple[int, int] | None:
    """Arguments of `Document.move_layer` for a layer's step by 1 or -1: to, and within.

    Before a group it goes into it, and at the end of its own it goes out of it, each by a step
    of its own. None where there is no way to go.
    """
    own, beside = layers[index].group, index + by
    if not 0 <= beside < len(layers):
        return None if own is None else (index, -1)
    other = layers[beside].group
    if own is not None:
        return (beside, index) if other == own else (index, -1)
    return (beside, -1) if other is None else (index, beside)


def group_step(layers: Sequence[Layer], index: int, by: int) -> int | None:
    """Index of a group's lowest layer after a step by 1 or -1: past a layer or a group."""
    first, last = group_span(layers, index)
    beside = last + 1 if by > 0 else first - 1
    if not 0 <= beside < len(layers):
        return None
    low, high = group_span(layers, beside)
    return first + by * (high - low + 1)
