"""The brushes that come with paint3d, read from presets.json."""

from __future__ import annotations

import functools
import importlib.resources
import json

from paint3d.brush.bristle_spec import BristleSpec
from paint3d.brush.spec import BrushSpec
from paint3d.errors import UnknownNameError

__all__ = ["brush_names", "load_brush"]


@functools.lru_cache(maxsize=1)
def _read_presets() -> dict[str, BrushSpec]:
    text = importlib.resources.files("paint3d.brush").joinpath("presets.json").read_text("utf-8")
    specs = {}
    for name, parameters in json.loads(text).items():
        parameters.pop("note")
        if "bristles" in parameters:
            parameters["bristles"] = BristleSpec(**parameters["bristles"])
        specs[name] = BrushSpec(name=name, **parameters)
    return specs


def brush_names() -> tuple[str, ...]:
    """Names that `load_brush` knows, in the order of the file."""
    return tuple(_read_presets())


def load_brush(name: str) -> BrushSpec:
    """A brush by name.

    Raises
    ------
    UnknownNameError
        If no brush has this name; the message lists those that there are.
    """
    presets = _read_presets()
    if name not in presets:
        raise UnknownNameError("brush", str(name), presets)
    return presets[name]
