"""A brush as words and numbers, as JSON holds it, and back again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from paint3d.brush.spec import BristleSpec, BrushSpec
from paint3d.core.array_state import listed
from paint3d.core.arrays import as_array
from paint3d.errors import BrushError, SessionError
from paint3d.painter.bristle_state import complete_memory
from paint3d.painter.painter import Painter

__all__ = ["brush_from_words", "brush_words", "hair_words", "restore_hairs"]


def brush_words(brush: BrushSpec) -> dict[str, object]:
    """Everything that `brush_from_words` needs."""
    return asdict(brush)


def brush_from_words(words: Mapping[str, Any]) -> BrushSpec:
    """The brush that `brush_words` described.

    Raises
    ------
    BrushError
        If it describes none.
    """
    values = dict(words)
    try:
        if isinstance(values.get("bristles"), Mapping):
            values["bristles"] = BristleSpec(**values["bristles"])
        return BrushSpec(**values)
    except TypeError as cause:
        raise BrushError("this describes no brush: {cause}", cause=cause) from None


def hair_words(painter: Painter) -> dict[str, object] | None:
    """State of the single hairs of a painter's tuft; None for a solid tuft."""
    if painter.hairs is None:
        return None
    return listed(painter.hairs.keep())


def restore_hairs(painter: Painter, words: Any) -> None:
    """Restore hairs from `hair_words`; without any, do nothing.

    Raises
    ------
    SessionError
        If it describes no hairs, or those of another tuft.
    """
    if words is None or painter.hairs is None:
        return
    if isinstance(words, Mapping) and "n_hairs" in words:  # commands once said only which they are
        return
    now = painter.hairs.keep()
    try:
        wide = (len(now["load"]), len(painter.surface.pigments))
        load = as_array(words["load"], "load of the hairs", (wide[0], None), np.float64)
        memory = as_array(words["memory"], "memory of the hairs", (None,), np.float64)
        memory = as_array(
            complete_memory(memory), "memory of the hairs", now["memory"].shape, np.float64
        )
    except (KeyError, TypeError, ValueError) as cause:
        raise SessionError("the hairs of the brush cannot be used: {cause}", cause=cause) from None
    if load.min(initial=0.0) < 0.0 or load.shape[1] > wide[1]:
        raise SessionError(
            "the hairs hold {load_shape} inks, of one {least:g}; expected inks of the painting, "
            "none below 0",
            least=load.min(),
            load_shape=load.shape[1],
        )
    load = np.pad(load, ((0, 0), (0, wide[1] - load.shape[1])))
    painter.hairs.restore({"load": load, "memory": memory})
