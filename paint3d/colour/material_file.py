"""Materials of one's own as files: TOML or JSON, with the parameters of `Material` by name.

docs/materials.md describes the file. One that names a ``base`` takes from that material what it
does not say; without, it must say a colour or a reflectance, roughness, coat, absorbency and grain.
"""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from paint3d.colour.material import Material, material_ranges
from paint3d.colour.spectra import WAVELENGTHS, decode_srgb
from paint3d.core.parameter_file import check_known, is_parameter_file, read_thing
from paint3d.core.types import AnyArray
from paint3d.errors import PigmentError

__all__ = ["material_text", "read_material"]

_LONGEST_NAME = 60
_LONGEST_WORDS = 500
_WORDS = ("chinese", "source", "basis", "licence", "note")
_COLOUR = re.compile("#[0-9a-fA-F]{6}")
_ODD = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff]")  # no file or terminal takes them
_MEANINGS = {
    "roughness": "of the reflection: 0 a mirror, 1 matt",
    "coat": "strength of a clear glaze over it",
    "absorbency": "draws ink out of the brush: 0 a glaze, 1 raw paper",
    "grain": "how coarse: breaks dry strokes, ink runs around it; felt and seen",
    "friction": "of hairs on it, over that on raw xuan",
    "pores_mm": "depth of water that its pores hold, mm; 0: it drinks nothing",
    "residual": "share of it that stays where it is",
    "advance": "share of it that must be there before water goes on into the dry",
    "spread_mm2_s": "diffusivity of water in full pores, mm2/s",
    "passing": "speed of soot over that of the water; coarser grains go slower",
    "drying_mm_s": "depth of water that evaporates in a second, mm",
    "tooth_mm": "length of the bumps that break a dry stroke, mm",
    "rated_absorbency": "the absorbency at which brushes give as they say",
    "rated_friction": "the friction at which brushes spread and drag as they say",
}


def read_material(path: str | Path, known: Mapping[str, Material]) -> Material:
    """A material from a file.

    Parameters
    ----------
    path : path-like
        ``.toml`` or ``.json``, in UTF-8, at most 1 MiB. Where it says no ``name``, the material is
        called like the file.
    known : mapping
        What ``base`` may name, and what no other material may be called.

    Raises
    ------
    PigmentError
        Naming the file and the parameter, what was got and what was expected.
    """
    return read_thing(
        path, "a material", PigmentError, lambda values, called: _material_of(values, called, known)
    )


def _material_of(values: dict[str, Any], called: str, known: Mapping[str, Material]) -> Material:
    fields = {field.name: field for field in dataclasses.fields(Material)}
    check_known(values, ["base", "colour", *fields], PigmentError)
    name, base = values.pop("name", called), values.pop("base", None)
    given: dict[str, Any] = {}
    if base is not None:
        if not isinstance(base, str) or base not in known:
            raise PigmentError(f"base is {base!r:.60}; expected one of {', '.join(known)}")
        given = {field: getattr(known[base], field) for field in fields}
        given |= dict.fromkeys(_WORDS, "") | {"basis": f"as {base}"}
    else:
        needed = [f.name for f in fields.values() if f.default is dataclasses.MISSING]
        missing = [f for f in needed if f != "name" and f not in values]
        if "colour" in values and "reflectance" in missing:
            missing.remove("reflectance")
        if missing:
            told = ", ".join("colour" if f == "reflectance" else f for f in missing)
            raise PigmentError(
                f'says no {told}; expected these, or base = "xuan" or another material to take '
                "them from"
            )
    if "colour" in values and "reflectance" in values:
        raise PigmentError("says a colour and a reflectance; expected one of them")
    if "colour" in values:
        given["reflectance"], given["basis"] = _spectrum_of(values.pop("colour"))
    elif "reflectance" in values:
        given["reflectance"] = _bands_of(values.pop("reflectance"))
        given["basis"] = "as its file says"
    _check_words(name, values)
    material = Material(**(given | values | {"name": name}))
    if material.name in known:
        raise PigmentError(
            f"name is {material.name!r}, a material that comes with the program; expected another: "
            'name = "mine"'
        )
    return material


def _check_words(name: object, values: Mapping[str, Any]) -> None:
    is_name = isinstance(name, str) and 0 < len(name) <= _LONGEST_NAME and name.isprintable()
    if not is_name or is_parameter_file(str(name)):
        raise PigmentError(
            f"name is {name!r:.80}; expected 1 to {_LONGEST_NAME} characters, and no file's name"
        )
    for word in _WORDS:
        said = values.get(word, "")
        if not isinstance(said, str) or len(said) > _LONGEST_WORDS or _ODD.search(said):
            raise PigmentError(
                f"{word} is {said!r:.60}; expected at most {_LONGEST_WORDS} letters, no control "
                "characters and no halves of one"
            )


def _spectrum_of(colour: object) -> tuple[AnyArray, str]:
    """Reflectance (31,) of an sRGB colour, and what it is from."""
    from paint3d.colour.glazing import srgb_primaries  # brings kernels

    if not isinstance(colour, str) or _COLOUR.fullmatch(colour) is None:
        raise PigmentError(f'colour is {colour!r:.60}; expected sRGB such as "#f4efe2"')
    codes = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)], np.uint8)
    spectrum: AnyArray = np.clip(srgb_primaries() @ decode_srgb(codes), 0.0, 1.0)
    return spectrum, f"of the colour {colour.lower()}"


def _bands_of(values: object) -> AnyArray:
    """Reflectance (31,) of as many numbers, or of pairs of a wavelength (nm) and a reflectance."""
    expected = f"{len(WAVELENGTHS)} numbers at 400, 410, ... 700 nm, or pairs [nm, reflectance]"
    if not _are_numbers(values):
        raise PigmentError(f"reflectance is {values!r:.60}; expected {expected}")
    try:
        array = np.array(values, np.float64)
    except (ValueError, OverflowError):
        raise PigmentError(f"reflectance is {values!r:.60}; expected {expected}") from None
    if array.shape == (len(WAVELENGTHS),):
        return array
    if array.ndim != 2 or array.shape[1] != 2 or not 2 <= len(array) <= 10_000:
        raise PigmentError(f"reflectance is of the shape {array.shape}; expected {expected}")
    nm = array[:, 0]
    if not (np.diff(nm) > 0.0).all() or not nm[0] <= 400.0 or not nm[-1] >= 700.0:
        raise PigmentError(
            f"reflectance goes from {nm[0]:g} to {nm[-1]:g} nm; expected rising wavelengths from "
            "at most 400 to at least 700"
        )
    bands: AnyArray = np.interp(WAVELENGTHS, nm, array[:, 1])
    return bands


def _are_numbers(values: object) -> bool:
    """Whether it is a number, or they are, or pairs: NumPy would take words and truths for some."""
    rows = values if isinstance(values, list) else [values]
    numbers = [one for row in rows for one in (row if isinstance(row, list) else [row])]
    return all(isinstance(one, int | float) and not isinstance(one, bool) for one in numbers)


def material_text(material: Material) -> str:
    """The file of a material in TOML, with ranges and meanings as comments.

    `read_material` makes the same material of it, but for the name, which is then that of the file.
    """
    lines = [
        "# A material of paint3d: --material FILE paints on it. It is called like the file,",
        '# or as name = "..." says. Behind each value: its range; what it is.',
    ]
    for word in _WORDS:
        if said := getattr(material, word):
            lines.append(f"{word} = {json.dumps(said, ensure_ascii=False)}")
    for parameter, (low, high) in material_ranges().items():
        told = f"{parameter} = {getattr(material, parameter)!r}"
        lines.append(f"{told:<28}# {low:g} to {high:g}; {_MEANINGS[parameter]}")
    lines += ['# at 400, 410, ... 700 nm; colour = "#rrggbb" or pairs [nm, reflectance] do, too']
    numbers = [repr(float(value)) for value in material.reflectance]
    rows = [", ".join(numbers[i : i + 8]) for i in range(0, len(numbers), 8)]
    lines += ["reflectance = [", *(f"    {row}," for row in rows), "]"]
    return "\n".join(lines) + "\n"
