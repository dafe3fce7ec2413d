"""Brushes by name: presets, the user's brush files, and the choice of one for a character size."""

from __future__ import annotations

import dataclasses
import functools
import importlib.resources
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from paint3d.brush.spec import (
    HAIRS,
    SHAPE_COLUMNS,
    TABLES,
    BristleSpec,
    BrushSpec,
    hair_ranges,
    parameter_ranges,
)
from paint3d.core.arrays import as_number
from paint3d.core.atomic import write_atomically
from paint3d.core.parameter_file import check_known, find_or_read, is_parameter_file, read_object
from paint3d.errors import BrushError, Message

__all__ = [
    "LARGEST_PRESET_EM",
    "SMALLEST_PRESET_EM",
    "brush_for",
    "brush_names",
    "brush_note",
    "brush_text",
    "check_brush_name",
    "check_not_preset",
    "choose_brush",
    "load_brush",
    "load_presets",
    "meaning_of",
    "read_brush",
    "suits_size",
    "write_brush",
]

# ---- Brush files ---------------------------------------------------------------------------------
# TOML or JSON, with the parameters of `BrushSpec` by name; docs/brushes.md describes the format.
# Parameters that a file omits come from the preset that it names as ``base``; without a base, all
# that have no default are required.

_LONGEST_NAME = 60
_EXTRA_KEYS = ("note", "base")
_MEANINGS = {
    "hair": Message("what the hairs are of; a word for people"),
    "hardness": Message("S of Guo 2017: larger is stiffer"),
    "n_segments": Message("m of Guo 2017: straight segments of the spine"),
    "tip_segment_mm": Message(
        "le_1 of Guo 2017: the segment at the tip; smaller, and the tip bends more"
    ),
    "friction": Message("mu on paper; spreads the hairs and is felt"),
    "spread_by_pressure": Message("d of Guo 2017, Eq. 2"),
    "spread_by_friction": Message("h of Guo 2017, Eq. 2"),
    "length_mm": Message("LE of Guo 2017: tuft from tip to ferrule; ranges in mm grow with it"),
    "root_diameter_mm": Message("thickness at the ferrule"),
    "taper": Message("the diameter falls towards the tip like (s / LE)^taper"),
    "stiffness_exponent": Message("q: a joint bends (s / LE)^q times as hard as the root"),
    "full_press_mm": Message("descent at the greatest force"),
    "load": Message("ink in a full tuft, full coats times mm2"),
    "transfer_per_mm": Message("share of the ink given per mm of way at full pressure"),
    "drag_fraction": Message("how far paper drags the contact back"),
    "plasticity": Message("share of the bend that stays when the brush is lifted"),
    "max_force": Message("N, at full_press_mm"),
    "point_mm": Message("the cone at the tip"),
    "rated_hardness": Message("the hardness at which full_press_mm holds"),
    "rated_segments": Message("the m at which stiffness_exponent holds"),
    "rated_tip_share": Message("the le_1 / LE at which stiffness_exponent holds"),
    "n_hairs": Message("single hairs"),
    "table": Message("where bent shapes come from"),
    "hair_mm": Message("thickness of a dry hair"),
    "film": Message("ink around a full hair, of the root's diameter"),
    "threshold_mm": Message("how near the surface a hair leaves ink"),
    "unevenness": Message("how much shorter the shortest hair is, as a share"),
    "parting": Message("how far the clumps of a dry tuft part"),
    "splay": Message("how far the hairs of a dry tuft lie side by side"),
    "appetite": Message("how differently hairs give"),
    "levelling_mm": Message("way over which wet neighbours share their ink"),
    "set_share": Message("descent over which a remembered bend is pressed out, of the length"),
}


def meaning_of(parameter: str) -> Message:
    """Describe a parameter of a brush, or of its hairs, in a few words."""
    return _MEANINGS[parameter]


def read_brush(path: str | Path, presets: Mapping[str, BrushSpec]) -> BrushSpec:
    """Read a brush from a file.

    Parameters
    ----------
    path : path-like
        ``.toml`` or ``.json``, in UTF-8, at most 1 MiB. Without a ``name`` in it, the brush is
        named after the file.
    presets : mapping
        The brushes that ``base`` may name; their own names are taken.

    Raises
    ------
    BrushError
        Naming the file and the parameter, what was got and what was expected.
    """
    return read_object(
        path, Message("a brush"), BrushError, lambda values, stem: _brush_of(values, stem, presets)
    )


def _brush_of(values: dict[str, Any], stem: str, presets: Mapping[str, BrushSpec]) -> BrushSpec:
    fields = {field.name: field for field in dataclasses.fields(BrushSpec)}
    check_known(values, [*_EXTRA_KEYS, *fields], BrushError)
    name, base = values.pop("name", stem), values.pop("base", None)
    values.pop("note", None)
    given: dict[str, Any] = {}
    if base is not None:
        if not isinstance(base, str) or base not in presets:
            raise BrushError(
                "base is {base!r:.60}; expected one of {presets}",
                base=base,
                presets=", ".join(presets),
            )
        given = {field: getattr(presets[base], field) for field in fields}
    else:
        needed = [f.name for f in fields.values() if f.default is dataclasses.MISSING]
        missing = [f for f in needed if f != "name" and f not in values]
        if missing:
            raise BrushError(
                '{missing} missing; give them, or base = "full" or another brush to take them from',
                missing=", ".join(missing),
            )
    if "bristles" in values:
        values["bristles"] = _hairs_of(values["bristles"], given.get("bristles"))
    check_brush_name(name)
    brush = BrushSpec(**(given | values | {"name": name}))
    if brush != presets.get(brush.name):
        check_not_preset(brush.name, presets)
    return brush


def check_brush_name(name: object) -> None:
    """Raise unless `name` is a valid name for a user's brush.

    Raises
    ------
    BrushError
        Saying what was got and what was expected.
    """
    is_name = isinstance(name, str) and 0 < len(name) <= _LONGEST_NAME and name.isprintable()
    if not is_name or " @" in str(name) or is_parameter_file(str(name)):
        raise BrushError(
            "name is {name!r:.80}; expected 1 to {most} characters, without ' @', and not ending "
            "in .toml or .json",
            name=name,
            most=_LONGEST_NAME,
        )


def check_not_preset(name: str, presets: Iterable[str]) -> None:
    """Raise if `name` is that of a preset.

    Raises
    ------
    BrushError
        Saying what was got and what was expected.
    """
    if name in presets:
        raise BrushError(
            'name is {name!r}, a brush that comes with the program; expected another: "mine"',
            name=name,
        )


def _hairs_of(values: object, base: BristleSpec | None) -> BristleSpec | None:
    """Parse a file's table of hairs; False or 0 is a solid tuft (None)."""
    if values is False or values == 0:
        return None
    if not isinstance(values, dict):
        raise BrushError(
            "bristles is {values!r:.40}; expected parameters by name, or false",
            values=values,
        )
    names = [field.name for field in dataclasses.fields(BristleSpec)]
    check_known(values, names, BrushError, "bristles: ")
    try:
        return dataclasses.replace(base or BristleSpec(), **values)
    except BrushError as cause:
        raise BrushError("bristles: {cause}", cause=cause) from None


def brush_text(brush: BrushSpec, note: str = "", *, named: bool = False) -> str:
    """Format a brush as TOML, with ranges and meanings as comments.

    `read_brush` reads the same brush from it; without a name, it is named after the file.

    Parameters
    ----------
    brush : BrushSpec
    note : str
        Written at the top, in one line.
    named : bool
        Whether to write the brush's name, too.
    """
    ranges = parameter_ranges(brush.length_mm)
    lines = [
        "# A brush of paint3d: --brush FILE paints with it. It is called like the file,",
        '# or as name = "..." says. Behind each value: its range; what it is.',
    ]
    lines += [f"name = {json.dumps(brush.name, ensure_ascii=False)}"] if named else []
    printable = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in note)
    lines += [f"note = {json.dumps(printable, ensure_ascii=False)}"] if printable else []
    for field in dataclasses.fields(brush):
        if field.name not in ("name", "bristles", "inputs"):
            lines.append(_line(field.name, getattr(brush, field.name), ranges, HAIRS))
    if brush.bristles is not None:
        lines += ["", "[bristles]"]
        for field in dataclasses.fields(brush.bristles):
            value = getattr(brush.bristles, field.name)
            if field.name == "table" and not isinstance(value, str):
                lines.append(f"table = [  # bent shapes of one's own: {', '.join(SHAPE_COLUMNS)}")
                lines += [f"  [{', '.join(f'{x!r}' for x in row)}]," for row in value]
                lines.append("]")
            else:
                lines.append(_line(field.name, value, hair_ranges(), TABLES))
    for setting, by_input in brush.inputs:
        lines += ["", f"[inputs.{setting}]  # factors, from 0.05 to 20"]
        for name, points in by_input:
            pairs = ", ".join(f"[{x!r}, {y!r}]" for x, y in points)
            lines.append(f"{name} = [{pairs}]")
    return "\n".join(lines) + "\n"


def write_brush(
    path: str | Path, brush: BrushSpec, presets: Mapping[str, BrushSpec], note: str = ""
) -> None:
    """Write a user's brush with its name, in TOML, atomically.

    Parameters
    ----------
    path : path-like
    brush : BrushSpec
    presets : mapping
        Their names are taken.
    note : str

    Raises
    ------
    BrushError
        For a name that is invalid or taken.
    ExportError
        If the file cannot be written.
    """
    check_brush_name(brush.name)
    check_not_preset(brush.name, presets)
    with write_atomically(path) as file:
        file.write_text(brush_text(brush, note, named=True), encoding="utf-8")


def _line(
    name: str, value: object, ranges: Mapping[str, tuple[float, float]], words: Iterable[str]
) -> str:
    """Format one parameter with its range, or the words it may be, and its meaning."""
    text = json.dumps(value) if isinstance(value, str) else repr(value)
    allowed = ", ".join(words)
    if name in ranges:
        low, high = ranges[name]
        allowed = f"{low:.5g} to {high:.5g}"
    return f"{f'{name} = {text}':<35} # {allowed}; {_MEANINGS[name]}"


# ---- Presets -------------------------------------------------------------------------------------

SMALLEST_PRESET_EM, LARGEST_PRESET_EM = 8.0, 350.0
"""mm: range of character sizes that the presets are made for."""

_BRUSHES = (
    (22.0, "xiaobaiyun"),
    (60.0, "zhongbaiyun"),
    (200.0, "dabaiyun"),
    (LARGEST_PRESET_EM, "tidou"),
)
"""Each brush with the largest size (mm) that it writes. They are alike in shape: a full belly
and a blunt taper, whose footprints are about as long as wide and so reach into corners at any bend.
"""
_ABOUT_AS_THICK = 1.7  # times as thick, or as thin


@functools.lru_cache(maxsize=1)
def _read_file() -> dict[str, dict[str, Any]]:
    text = importlib.resources.files("paint3d.brush").joinpath("presets.json").read_text("utf-8")
    parameters: dict[str, dict[str, Any]] = json.loads(text)
    return parameters


@functools.lru_cache(maxsize=1)
def load_presets() -> Mapping[str, BrushSpec]:
    """Return the presets by name; read-only."""
    specs = {}
    for name, stated in _read_file().items():
        parameters = {key: value for key, value in stated.items() if key != "note"}
        if "bristles" in parameters:
            parameters["bristles"] = BristleSpec(**parameters["bristles"])
        specs[name] = BrushSpec(name=name, **parameters)
    return MappingProxyType(specs)


def brush_names() -> tuple[str, ...]:
    """Names of the presets, in the order of presets.json."""
    return tuple(load_presets())


def brush_note(name: str) -> str:
    """Return a preset's purpose and the source of its numbers; "" for any other brush."""
    return str(_read_file().get(name, {}).get("note", ""))


def load_brush(name: str, *, own_files: bool = True) -> BrushSpec:
    """Return a preset by name, or read a user's brush file (``mine.toml``, ``mine.json``).

    Parameters
    ----------
    name : str
    own_files : bool
        Whether the name may be that of a file; False for names from a stranger's file.

    Raises
    ------
    UnknownNameError
        If no brush has this name; the message lists the presets.
    BrushError
        If the file is invalid, or may not be read.

    Examples
    --------
    >>> import paint3d
    >>> paint3d.load_brush("full").length_mm
    35.0
    """
    presets = load_presets()
    read = functools.partial(read_brush, presets=presets) if own_files else None
    return find_or_read(name, presets, Message("brush"), BrushError, read)


def choose_brush(em_mm: float) -> str:
    """Choose the preset for writing kaishu of a size.

    Parameters
    ----------
    em_mm : float
        Side of the em square, mm, 8 to 350.

    Returns
    -------
    str
        A name for `paint3d.brush.presets.load_brush`.

    Raises
    ------
    InputError
        If the size is out of this range.
    """
    size = as_number(em_mm, "size of the characters (mm)", SMALLEST_PRESET_EM, LARGEST_PRESET_EM)
    return next(name for largest, name in _BRUSHES if size <= largest)


def brush_for(em_mm: float) -> BrushSpec:
    """Return the preset of `choose_brush` for a size, mm; the nearest for one out of its range."""
    return load_brush(choose_brush(min(max(em_mm, SMALLEST_PRESET_EM), LARGEST_PRESET_EM)))


def suits_size(brush: BrushSpec, em_mm: float) -> bool:
    """Return whether a brush is about as thick as `brush_for` has it for a size, mm."""
    thicker = brush.root_diameter_mm / brush_for(em_mm).root_diameter_mm
    return 1.0 / _ABOUT_AS_THICK < thicker < _ABOUT_AS_THICK
