"""The materials that surfaces are made of, by name, and those of one's own files.

The table `data/materials.csv` is built by `scripts/build_materials.py`; each row says where its
reflectance was measured and for what it stands in, and `note` where the other numbers are from.
"""

from __future__ import annotations

import csv
import dataclasses
import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from paint3d.colour.pigments import BANDS_NM
from paint3d.colour.spectra import WAVELENGTHS, decode_srgb
from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.core.parameter_file import check_known, is_parameter_file, named_or_read, read_thing
from paint3d.errors import PigmentError

__all__ = [
    "WAVE_RANGE_MM",
    "WET_COAT_MM",
    "Material",
    "glazed_roughness",
    "load_material",
    "load_materials",
    "material_names",
    "material_ranges",
    "material_text",
    "read_material",
]

# ---- One material --------------------------------------------------------------------------------
# What a surface is made of: what shines through thin paint, how it looks, drinks and rubs.


_FRICTION = (0.2, 2.0)
_MOST_SPREAD = 2.5  # times the friction that a brush was rated on: what shapes are tabulated for
_RANGES = {
    "roughness": (0.0, 1.0),
    "coat": (0.0, 1.0),
    "absorbency": (0.0, 1.0),
    "grain": (0.0, 1.0),
    "friction": _FRICTION,
    "pores_mm": (0.0, 10.0),
    "residual": (0.0, 0.95),
    "advance": (0.0, 1.0),
    "spread_mm2_s": (0.0, 1000.0),
    "passing": (0.0, 1.0),
    "drying_mm_s": (0.0, 1.0),
    "tooth_mm": (0.0, 10.0),
}
_BUMPS = 2.0  # lengths of a bump from one to the next
_GLAZE_ROUGHNESS = 0.07  # of the one lobe that is used: VTK's own coat is weighed by Fresnel twice
_RATED = {"rated_absorbency": "absorbency", "rated_friction": "friction"}

WAVE_RANGE_MM = (0.1, 20.0)
"""Least and greatest distance of bumps that is felt and seen, mm."""
WET_COAT_MM = 0.03
"""Depth of the liquid in one wet coat, mm: a full stroke brushed on. Chosen by eye."""


def glazed_roughness(roughness: float, coat: float) -> float:
    """Roughness that a body of this one has under a glaze so strong, all 0 to 1."""
    return roughness + coat * (_GLAZE_ROUGHNESS - roughness)


def material_ranges() -> dict[str, tuple[float, float]]:
    """Least and greatest value of every number of a material."""
    return _RANGES | {name: _RANGES[of] for name, of in _RATED.items()}


@dataclass(frozen=True, eq=False)
class Material:
    """What an object is made of.

    Parameters
    ----------
    name : str
    reflectance : (31,) array_like
        Reflectance at 400, 410, ... 700 nm, in [0, 1].
    roughness : float
        Of the reflection, 0 (mirror) to 1 (matt).
    coat : float
        Strength of a clear glaze over it, 0 to 1.
    absorbency : float
        How readily ink soaks in, 0 (glaze) to 1 (raw paper). It draws ink out of the brush:
        `uptake`.
    grain : float
        How coarse the surface is to a brush, 0 to 1.
    pores_mm : float
        Water that the pores below 1 mm2 hold, as a depth in mm (thickness x porosity); 0 for what
        drinks nothing, and then ink stays where it is laid.
    residual : float
        Share of it that stays where it is, held by the fibres.
    advance : float
        Share of it that must be there before water goes on into what is dry. The more it is above
        the residual, the earlier the border is pinned and the darker its rim dries.
    spread_mm2_s : float
        Diffusivity of water in full pores, mm2/s.
    passing : float
        Speed of soot over that of the water that carries it, 0 to 1; coarser grains go slower.
    drying_mm_s : float
        Depth of water that evaporates in a second.
    tooth_mm : float
        Length of the bumps that break a dry stroke, 0 for none.
    friction : float
        How many times as much hairs rub on it as on raw xuan, .2 to 2: with the brush's own mu it
        is mu of Guo 2015, Eqs. 2 and 5 (`slip`).
    rated_absorbency, rated_friction : float, optional
        Those at which brushes give their ink, spread and drag as `BrushSpec` says. NaN: its own.
    chinese, source, basis, licence, note : str
        Its Chinese name; whose measurement the reflectance is, for what it stands in, and its
        terms; where the other numbers are from.

    Raises
    ------
    PigmentError
        If the name is empty or a value is not finite or outside its range.
    """

    name: str
    reflectance: AnyArray
    roughness: float
    coat: float
    absorbency: float
    grain: float
    pores_mm: float = 0.0
    residual: float = 0.3
    advance: float = 0.3
    spread_mm2_s: float = 0.0
    passing: float = 1.0
    drying_mm_s: float = 4e-5
    tooth_mm: float = 0.5
    rated_absorbency: float = math.nan
    chinese: str = ""
    source: str = ""
    basis: str = ""
    licence: str = ""
    friction: float = 1.0
    rated_friction: float = math.nan
    note: str = ""

    def __post_init__(self) -> None:
        if not self.name:
            raise PigmentError("a material has no name")
        values = as_array(
            self.reflectance, f"reflectance of {self.name}", (31,), error=PigmentError
        ).copy()
        if values.min() < 0 or values.max() > 1:
            raise PigmentError(
                f"reflectance of {self.name} is {values.min():g} to {values.max():g}; "
                "expected 0 to 1"
            )
        values.flags.writeable = False
        object.__setattr__(self, "reflectance", values)
        for rated, own in _RATED.items():
            stated = getattr(self, rated)
            if isinstance(stated, float) and math.isnan(stated):
                object.__setattr__(self, rated, getattr(self, own))
        for key, (low, high) in material_ranges().items():
            number = as_number(
                getattr(self, key), f"{key} of {self.name}", low, high, error=PigmentError
            )
            object.__setattr__(self, key, number)
        if self.slip > _MOST_SPREAD:
            raise PigmentError(
                f"friction of {self.name} is {self.friction:g}, {self.slip:.3g} times its "
                f"rated_friction {self.rated_friction:g}; expected at most {_MOST_SPREAD:g} times"
            )

    @property
    def seen_roughness(self) -> float:
        """Roughness of what mirrors: the body, or the glaze over it, 0 to 1."""
        return glazed_roughness(self.roughness, self.coat)

    @property
    def wave_mm(self) -> float:
        """How far apart the bumps of its grain are, mm: as they are felt and seen."""
        shortest, longest = WAVE_RANGE_MM
        return min(max(_BUMPS * self.tooth_mm, shortest), longest)

    @property
    def uptake(self) -> float:
        """How many times as fast a brush gives its ink as on the surface that it was rated on.

        Guo 2017, section 4.2.2, adapts eta to brush and surface: here by (1 + absorbency) over the
        same of `rated_absorbency`. The factor is set by eye.
        """
        return (1.0 + self.absorbency) / (1.0 + self.rated_absorbency)

    @property
    def slip(self) -> float:
        """How many times as much hairs rub on it as where a brush was rated.

        Friction belongs to brush and surface (Guo 2015, section 4): what is painted has
        mu = `BrushSpec.friction` times this, what is felt `BrushSpec.friction` times `friction`.
        """
        return self.friction / self.rated_friction


# --------------------------------------------------------------------------------------------------


_TABLE = Path(__file__).parent / "data" / "materials.csv"
_WORDS = ("name", "chinese", "source", "basis", "licence", "note")


@lru_cache(maxsize=1)
def load_materials() -> Mapping[str, Material]:
    """Return all materials by name, in the table's order; read-only."""
    with _TABLE.open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    materials = {}
    for row in rows:
        words: dict[str, Any] = {key: row[key] for key in _WORDS}
        looks: dict[str, Any] = {key: float(row[key]) for key in material_ranges() if key in row}
        looks["reflectance"] = [float(row[f"R_{nm:.0f}"]) for nm in BANDS_NM]
        materials[row["name"]] = Material(**words, **looks)
    return MappingProxyType(materials)


def material_names() -> list[str]:
    """Names of the materials that come with the program."""
    return list(load_materials())


def load_material(name: str, *, own_files: bool = True) -> Material:
    """Return a material by its name, or of a file of one's own (``mine.toml``, ``mine.json``).

    Parameters
    ----------
    name : str
    own_files : bool
        Whether the name may be that of a file. Names that come from somebody else's file may not.

    Raises
    ------
    UnknownNameError
        If there is none; the message lists them.
    PigmentError
        If the file cannot be used, or may not be read.
    """
    materials = load_materials()
    read = partial(read_material, known=materials) if own_files else None
    return named_or_read(name, materials, "material", PigmentError, read)


# ---- Files ---------------------------------------------------------------------------------------
# Materials of one's own as files: TOML or JSON, with the parameters of `Material` by name.
#
# docs/materials.md describes the file. One that names a ``base`` takes from that material what it
# does not say; without, it must say a colour or a reflectance, roughness, coat, absorbency and
# grain.


_LONGEST_NAME = 60
_LONGEST_WORDS = 500
_FILE_WORDS = ("chinese", "source", "basis", "licence", "note")
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
        given |= dict.fromkeys(_FILE_WORDS, "") | {"basis": f"as {base}"}
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
    for word in _FILE_WORDS:
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
    for word in _FILE_WORDS:
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
