"""Materials of the surface: what shines through thin paint, and how the surface looks and drinks.

The table `data/materials.csv` is built by `scripts/build_materials.py`; each row says where its
reflectance was measured and for what it stands in. The other properties are chosen by eye.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

from numpy.typing import NDArray

from paint3d.arrays import as_array, as_number
from paint3d.errors import PigmentError, UnknownNameError
from paint3d.ink.pigments import BANDS_NM

__all__ = ["Material", "load_material", "load_materials", "material_names"]

_TABLE = Path(__file__).parent / "data" / "materials.csv"
_LOOKS = ("roughness", "coat", "absorbency", "grain")


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
        How readily ink soaks in, 0 (glaze) to 1 (raw paper).
    grain : float
        How coarse the surface is to a brush, 0 to 1.
    chinese, source, basis, licence : str
        Whose measurement the reflectance is, for what it stands in, and its terms.

    Raises
    ------
    PigmentError
        If the name is empty or a value is not finite or outside its range.
    """

    name: str
    reflectance: NDArray
    roughness: float
    coat: float
    absorbency: float
    grain: float
    chinese: str = ""
    source: str = ""
    basis: str = ""
    licence: str = ""

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
        for key in _LOOKS:
            number = as_number(
                getattr(self, key), f"{key} of {self.name}", 0.0, 1.0, error=PigmentError
            )
            object.__setattr__(self, key, number)


@lru_cache(maxsize=1)
def load_materials() -> Mapping[str, Material]:
    """Return all materials by name, in the table's order; read-only."""
    with _TABLE.open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    materials = {}
    for row in rows:
        words = {key: row[key] for key in ("name", "chinese", "source", "basis", "licence")}
        looks = {key: float(row[key]) for key in _LOOKS}
        reflectance = [float(row[f"R_{nm:.0f}"]) for nm in BANDS_NM]
        materials[row["name"]] = Material(reflectance=reflectance, **words, **looks)
    return MappingProxyType(materials)


def material_names() -> list[str]:
    """Names of the materials."""
    return list(load_materials())


def load_material(name: str) -> Material:
    """Return a material by its name.

    Raises
    ------
    UnknownNameError
        If there is none; the message lists them.
    """
    materials = load_materials()
    if name not in materials:
        raise UnknownNameError("material", name, materials)
    return materials[name]
