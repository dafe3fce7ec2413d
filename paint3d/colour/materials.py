"""Materials of surfaces: the shipped ones by name, and users' own files.

The table `data/materials.csv` is built by `scripts/build_materials.py`; each row says where its
reflectance was measured and what it stands in for, and `note` where the other numbers are from.
"""

from __future__ import annotations

import csv
import dataclasses
import json
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
from paint3d.core.parameter_file import check_known, find_or_read, is_parameter_file, read_object
from paint3d.errors import Message, PigmentError

__all__ = [
    "SHEET_MM",
    "WAVE_RANGE_MM",
    "WET_COAT_MM",
    "WET_INK_MM",
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
# Reflectance below the paint, gloss, uptake of ink and water, and friction.

_RANGES = {
    "roughness": (0.0, 1.0),
    "coat": (0.0, 1.0),
    "absorbency": (0.0, 1.0),
    "grain": (0.0, 1.0),
    "friction": (0.2, 2.0),
    "pores_mm": (0.0, 10.0),
    "residual": (0.0, 0.95),
    "advance": (0.0, 1.0),
    "spread_mm2_s": (0.0, 1000.0),
    "passing": (0.0, 1.0),
    "drying_mm_s": (0.0, 1.0),
    "tooth_mm": (0.0, 10.0),
}
_BUMPS = 2.0  # spacing of bumps, in lengths of one
_GLAZE_ROUGHNESS = 0.07  # for our single lobe: VTK's own coat is weighted by Fresnel twice

WAVE_RANGE_MM = (0.1, 20.0)
"""Least and greatest spacing of bumps that is felt and seen, mm."""
SHEET_MM = 0.12
"""Greatest depth of pores in a sheet, which is felted of fibres, mm."""
WET_COAT_MM = 0.03
"""Depth of the liquid in one wet coat, mm: a full stroke brushed on. Chosen by eye."""
WET_INK_MM = 0.015
"""Depth of what runs of it where it is undiluted: glue holds the rest. Chosen by eye."""


def glazed_roughness(roughness: float, coat: float) -> float:
    """Return the roughness of a body under a glaze of strength `coat`, all 0 to 1."""
    return roughness + coat * (_GLAZE_ROUGHNESS - roughness)


def material_ranges() -> dict[str, tuple[float, float]]:
    """Return the least and greatest value of every numeric parameter of a material."""
    return dict(_RANGES)


@dataclass(frozen=True, eq=False)
class Material:
    """Material of an object: its look, uptake of ink and water, and friction.

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
        Water that the pores below 1 mm2 hold, as a depth in mm (thickness x porosity); with 0
        nothing soaks in, and ink stays where it is laid.
    residual : float
        Fraction of it that the fibres hold in place.
    advance : float
        Entry saturation: fraction of it above which water enters dry pores. The more it exceeds
        the residual, the earlier the border is pinned and the darker its rim dries.
    spread_mm2_s : float
        Diffusivity of water in full pores, mm2/s.
    passing : float
        Speed of soot over that of the water that carries it, 0 to 1; coarser grains are slower.
    drying_mm_s : float
        Depth of water that evaporates in a second.
    tooth_mm : float
        Length of the bumps that break a dry stroke, 0 for none.
    friction : float
        Friction of hairs on it over that on raw xuan, .2 to 2: times the brush's own mu it is mu
        of Guo 2015, Eqs. 2 and 5.
    chinese, source, basis, licence, note : str
        Its Chinese name; whose measurement the reflectance is, what it stands in for, and its
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
    chinese: str = ""
    source: str = ""
    basis: str = ""
    licence: str = ""
    friction: float = 1.0
    note: str = ""

    def __post_init__(self) -> None:
        if not self.name:
            raise PigmentError("a material has no name")
        values = as_array(
            self.reflectance, f"reflectance of {self.name}", (31,), error=PigmentError
        ).copy()
        if values.min() < 0 or values.max() > 1:
            raise PigmentError(
                "reflectance of {name} is {least:g} to {most:g}; expected 0 to 1",
                name=self.name,
                least=values.min(),
                most=values.max(),
            )
        values.flags.writeable = False
        object.__setattr__(self, "reflectance", values)
        for key, (low, high) in material_ranges().items():
            number = as_number(
                getattr(self, key), f"{key} of {self.name}", low, high, error=PigmentError
            )
            object.__setattr__(self, key, number)

    @property
    def is_felted(self) -> bool:
        """Whether it is a sheet of fibres, thin and with pores: paper, silk."""
        return 0.0 < self.pores_mm <= SHEET_MM

    @property
    def seen_roughness(self) -> float:
        """Roughness of the reflecting surface: the body, or the glaze over it, 0 to 1."""
        return glazed_roughness(self.roughness, self.coat)

    @property
    def wave_mm(self) -> float:
        """Spacing of the bumps of its grain, mm, as they are felt and seen."""
        shortest, longest = WAVE_RANGE_MM
        return min(max(_BUMPS * self.tooth_mm, shortest), longest)

    @property
    def uptake(self) -> float:
        """Ratio of a brush's rate of giving ink to that on raw xuan, on which brushes are rated.

        Guo 2017, section 4.2.2, adapts eta to brush and surface; the factor is set by eye.
        """
        return (2.0 + self.absorbency) / 3.0


# ---- Shipped materials ---------------------------------------------------------------------------


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
    """List the names of the shipped materials."""
    return list(load_materials())


def load_material(name: str, *, own_files: bool = True) -> Material:
    """Return a shipped material by name, or one of a user's file (``mine.toml``, ``mine.json``).

    Parameters
    ----------
    name : str
    own_files : bool
        Whether the name may be that of a file; not where it comes from somebody else's file.

    Raises
    ------
    UnknownNameError
        If there is none; the message lists them.
    PigmentError
        If the file cannot be used, or may not be read.

    Examples
    --------
    >>> import paint3d
    >>> paint3d.load_material("xuan").pores_mm
    0.06
    """
    materials = load_materials()
    read = partial(read_material, known=materials) if own_files else None
    return find_or_read(name, materials, Message("material"), PigmentError, read)


# ---- Files ---------------------------------------------------------------------------------------
# A user's material is a TOML or JSON file with the parameters of `Material` by name; see
# docs/materials.md. Parameters that it leaves out are those of its ``base``, if it names one;
# otherwise a colour or a reflectance, roughness, coat, absorbency and grain are required.

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
}


def read_material(path: str | Path, known: Mapping[str, Material]) -> Material:
    """Read a material from a file.

    Parameters
    ----------
    path : path-like
        ``.toml`` or ``.json``, in UTF-8, at most 1 MiB. Without a ``name``, the material is named
        after the file.
    known : mapping
        The materials that ``base`` may name; their names are taken.

    Raises
    ------
    PigmentError
        Naming the file and the parameter, the value and what was expected.
    """
    return read_object(
        path,
        Message("a material"),
        PigmentError,
        lambda values, stem: _make_material(values, stem, known),
    )


def _make_material(values: dict[str, Any], stem: str, known: Mapping[str, Material]) -> Material:
    fields = {field.name: field for field in dataclasses.fields(Material)}
    check_known(values, ["base", "colour", *fields], PigmentError)
    name, base = values.pop("name", stem), values.pop("base", None)
    given: dict[str, Any] = {}
    if base is not None:
        if not isinstance(base, str) or base not in known:
            raise PigmentError(
                "base is {base!r:.60}; expected one of {known}",
                base=base,
                known=", ".join(known),
            )
        given = {field: getattr(known[base], field) for field in fields}
        given |= dict.fromkeys(_FILE_WORDS, "") | {"basis": f"as {base}"}
    else:
        needed = [f.name for f in fields.values() if f.default is dataclasses.MISSING]
        missing = [f for f in needed if f != "name" and f not in values]
        if "colour" in values and "reflectance" in missing:
            missing.remove("reflectance")
        if missing:
            names = ", ".join("colour" if f == "reflectance" else f for f in missing)
            raise PigmentError(
                'says no {names}; expected these, or base = "xuan" or another material to take '
                "them from",
                names=names,
            )
    if "colour" in values and "reflectance" in values:
        raise PigmentError("says a colour and a reflectance; expected one of them")
    if "colour" in values:
        given["reflectance"], given["basis"] = _spectrum_of_colour(values.pop("colour"))
    elif "reflectance" in values:
        given["reflectance"] = _parse_reflectance(values.pop("reflectance"))
        given["basis"] = "as its file says"
    _check_words(name, values)
    material = Material(**(given | values | {"name": name}))
    if material.name in known:
        raise PigmentError(
            "name is {material!r}, a material that comes with the program; expected another: name "
            '= "mine"',
            material=material.name,
        )
    return material


def _check_words(name: object, values: Mapping[str, Any]) -> None:
    is_name = isinstance(name, str) and 0 < len(name) <= _LONGEST_NAME and name.isprintable()
    if not is_name or is_parameter_file(str(name)):
        raise PigmentError(
            "name is {name!r:.80}; expected 1 to {most} characters, and no file's name",
            name=name,
            most=_LONGEST_NAME,
        )
    for word in _FILE_WORDS:
        text = values.get(word, "")
        if not isinstance(text, str) or len(text) > _LONGEST_WORDS or _ODD.search(text):
            raise PigmentError(
                "{word} is {text!r:.60}; expected at most {most} letters, no control characters "
                "and no halves of one",
                word=word,
                text=text,
                most=_LONGEST_WORDS,
            )


def _spectrum_of_colour(colour: object) -> tuple[AnyArray, str]:
    """Return the reflectance (31,) of an sRGB colour, and the text of its basis."""
    from paint3d.colour.glazing import srgb_primaries  # brings kernels

    if not isinstance(colour, str) or _COLOUR.fullmatch(colour) is None:
        raise PigmentError(
            'colour is {colour!r:.60}; expected sRGB such as "#f4efe2"',
            colour=colour,
        )
    codes = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)], np.uint8)
    spectrum: AnyArray = np.clip(srgb_primaries() @ decode_srgb(codes), 0.0, 1.0)
    return spectrum, f"of the colour {colour.lower()}"


def _parse_reflectance(values: object) -> AnyArray:
    """Return the reflectance (31,) given by 31 numbers, or by pairs [wavelength in nm, value]."""
    expected = Message(
        "{n} numbers at 400, 410, ... 700 nm, or pairs [nm, reflectance]", n=len(WAVELENGTHS)
    )
    rows = values if isinstance(values, list) else [values]
    numbers = [one for row in rows for one in (row if isinstance(row, list) else [row])]
    # checked here, since NumPy would also take strings and booleans for numbers
    if not all(isinstance(one, int | float) and not isinstance(one, bool) for one in numbers):
        raise PigmentError(
            "reflectance is {values!r:.60}; expected {expected}",
            values=values,
            expected=expected,
        )
    try:
        array = np.array(values, np.float64)
    except (ValueError, OverflowError):
        raise PigmentError(
            "reflectance is {values!r:.60}; expected {expected}",
            values=values,
            expected=expected,
        ) from None
    if array.shape == (len(WAVELENGTHS),):
        return array
    if array.ndim != 2 or array.shape[1] != 2 or not 2 <= len(array) <= 10_000:
        raise PigmentError(
            "reflectance is of the shape {array_shape}; expected {expected}",
            array_shape=array.shape,
            expected=expected,
        )
    nm = array[:, 0]
    if not (np.diff(nm) > 0.0).all() or not nm[0] <= 400.0 or not nm[-1] >= 700.0:
        raise PigmentError(
            "reflectance goes from {first:g} to {last:g} nm; expected rising wavelengths from at "
            "most 400 to at least 700",
            first=nm[0],
            last=nm[-1],
        )
    bands: AnyArray = np.interp(WAVELENGTHS, nm, array[:, 1])
    return bands


def material_text(material: Material) -> str:
    """Write a material as a TOML file, with ranges and meanings as comments.

    `read_material` reads the same material back, except for the name, which is the file's.
    """
    lines = [
        "# A material of paint3d: --material FILE paints on it. It is called like the file,",
        '# or as name = "..." says. Behind each value: its range; what it is.',
    ]
    for word in _FILE_WORDS:
        if text := getattr(material, word):
            lines.append(f"{word} = {json.dumps(text, ensure_ascii=False)}")
    for parameter, (low, high) in material_ranges().items():
        setting = f"{parameter} = {getattr(material, parameter)!r}"
        lines.append(f"{setting:<28}# {low:g} to {high:g}; {_MEANINGS[parameter]}")
    lines += ['# at 400, 410, ... 700 nm; colour = "#rrggbb" or pairs [nm, reflectance] do, too']
    numbers = [repr(float(value)) for value in material.reflectance]
    rows = [", ".join(numbers[i : i + 8]) for i in range(0, len(numbers), 8)]
    lines += ["reflectance = [", *(f"    {row}," for row in rows), "]"]
    return "\n".join(lines) + "\n"
