"""The brushes that come with paint3d, read from presets.json, and which suits a size of writing."""

from __future__ import annotations

import functools
import importlib.resources
import json

from paint3d.brush.bristle_spec import BristleSpec
from paint3d.brush.spec import BrushSpec
from paint3d.core.arrays import as_number
from paint3d.errors import UnknownNameError

__all__ = ["GREATEST_EM", "LEAST_EM", "brush_names", "choose_brush", "load_brush"]

LEAST_EM, GREATEST_EM = 8.0, 200.0
"""mm: the sizes of characters that the presets are made for."""

_BRUSHES = ((22.0, "xiaobaiyun"), (60.0, "zhongbaiyun"), (GREATEST_EM, "dabaiyun"))
"""Size (mm) up to which each brush is taken. The three are alike in shape: a full belly and a
blunt taper, whose footprints are about as long as wide and so reach into corners at any bend."""


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


def choose_brush(em_mm: float) -> str:
    """The preset for writing kaishu of a size.

    Parameters
    ----------
    em_mm : float
        Side of the em square, mm, 8 to 200.

    Returns
    -------
    str
        A name for `paint3d.brush.presets.load_brush`.

    Raises
    ------
    InputError
        If the size is none of those.
    """
    size = as_number(em_mm, "size of the characters (mm)", LEAST_EM, GREATEST_EM)
    return next(name for largest, name in _BRUSHES if size <= largest)
