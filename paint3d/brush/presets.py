"""Brushes by name: those of presets.json, files of one's own, and which suits a size of writing."""

from __future__ import annotations

import functools
import importlib.resources
import json
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from paint3d.brush.bristle_spec import BristleSpec
from paint3d.brush.brush_file import read_brush
from paint3d.brush.spec import BrushSpec
from paint3d.core.arrays import as_number
from paint3d.core.parameter_file import named_or_read
from paint3d.errors import BrushError

__all__ = [
    "GREATEST_EM",
    "LEAST_EM",
    "brush_names",
    "brush_note",
    "choose_brush",
    "load_brush",
    "load_presets",
]

LEAST_EM, GREATEST_EM = 8.0, 200.0
"""mm: the sizes of characters that the presets are made for."""

_BRUSHES = ((22.0, "xiaobaiyun"), (60.0, "zhongbaiyun"), (GREATEST_EM, "dabaiyun"))
"""Size (mm) up to which each brush is taken. The three are alike in shape: a full belly and a
blunt taper, whose footprints are about as long as wide and so reach into corners at any bend."""


@functools.lru_cache(maxsize=1)
def _read_file() -> dict[str, dict[str, Any]]:
    text = importlib.resources.files("paint3d.brush").joinpath("presets.json").read_text("utf-8")
    parameters: dict[str, dict[str, Any]] = json.loads(text)
    return parameters


@functools.lru_cache(maxsize=1)
def load_presets() -> Mapping[str, BrushSpec]:
    """The brushes that come with the program, by name; read-only."""
    specs = {}
    for name, stated in _read_file().items():
        parameters = {key: value for key, value in stated.items() if key != "note"}
        if "bristles" in parameters:
            parameters["bristles"] = BristleSpec(**parameters["bristles"])
        specs[name] = BrushSpec(name=name, **parameters)
    return MappingProxyType(specs)


def brush_names() -> tuple[str, ...]:
    """Names of the brushes that come with the program, in the order of the file."""
    return tuple(load_presets())


def brush_note(name: str) -> str:
    """What a preset is for and where its numbers are from; nothing of any other brush."""
    return str(_read_file().get(name, {}).get("note", ""))


def load_brush(name: str, *, own_files: bool = True) -> BrushSpec:
    """A brush by name, or of a file of one's own (``mine.toml``, ``mine.json``).

    Parameters
    ----------
    name : str
    own_files : bool
        Whether the name may be that of a file. Names that come from somebody else's file may not.

    Raises
    ------
    UnknownNameError
        If no brush has this name; the message lists those that there are.
    BrushError
        If the file cannot be used, or may not be read.
    """
    presets = load_presets()
    read = functools.partial(read_brush, presets=presets) if own_files else None
    return named_or_read(name, presets, "brush", BrushError, read)


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
