"""The brush that will be in hand when all that was asked for is done.

The hand asks for another brush and paints on at once, while the painting may be seconds behind;
what it does then it does with the brush it asked for, not with the one that still paints.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from paint3d.app.model.brush_size import resized, scaled, stepped
from paint3d.app.model.persistence.brush_words import brush_from_words
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BrushSpec
from paint3d.errors import Paint3DError

__all__ = ["BRUSH_COMMANDS", "brush_after"]


def _set(_: BrushSpec, brush: str | BrushSpec | Mapping[str, Any]) -> BrushSpec:
    if isinstance(brush, Mapping):
        return brush_from_words(brush)
    return load_brush(brush, own_files=False) if isinstance(brush, str) else brush


BRUSH_COMMANDS: dict[str, Callable[..., BrushSpec]] = {
    "set_brush": _set,
    "scale_brush": scaled,
    "resize_brush": resized,
    "step_brush": stepped,
}
"""Commands of a document that take another brush, and which."""


def brush_after(brush: BrushSpec, command: str, arguments: Sequence[object]) -> BrushSpec:
    """The brush in hand after one of `BRUSH_COMMANDS`; where that will be refused, as before."""
    try:
        return BRUSH_COMMANDS[command](brush, *arguments)
    except (Paint3DError, TypeError):
        return brush
