"""Materials of the surface: what shines through thin paint, and how the surface looks and drinks.

The table `data/materials.csv` is built by `scripts/build_materials.py`; each row says where its
reflectance was measured and for what it stands in. The other properties are chosen by eye.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from paint3d.colour.pigments import BANDS_NM
from paint3d.core.arrays import as_array, as_number
from paint3d.core.types import AnyArray
from paint3d.errors import PigmentError, UnknownNameError

__all__ = ["WET_COAT_MM", "Material", "load_material", "load_materials", "material_names"]

_TABLE = Path(__file__).parent / "data" / "materials.csv"
_LOOKS = ("roughness", "coat", "absorbency", "grain")
_DRINKS = {  # greatest value of each
    "pores_mm": 10.0,
    "residual": 0.95,
    "advance": 1.0,
    "spread_mm2_s": 1000.0,
    "passing": 1.0,
    "drying_mm_s": 1.0,
    "tooth_mm": 10.0,
}

WET_COAT_MM = 0.03
"""Depth of the liquid in one wet coat, mm: a full stroke brushed on. Chosen by eye."""


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
        Speed of the pigment over that of the water that carries it, 0 to 1.
    drying_mm_s : float
        Depth of water that evaporates in a second.
    tooth_mm : float
        Length of the bumps that break a dry stroke, 0 for none.
    rated_absorbency : float, optional
        The absorbency at which brushes give their ink as `BrushSpec` says. NaN: its own.
    chinese, source, basis, licence : str
        Whose measurement the reflectance is, for what it stands in, and its terms.

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
        if isinstance(self.rated_absorbency, float) and math.isnan(self.rated_absorbency):
            object.__setattr__(self, "rated_absorbency", self.absorbency)
        for key in (*_LOOKS, "rated_absorbency"):
            number = as_number(
                getattr(self, key), f"{key} of {self.name}", 0.0, 1.0, error=PigmentError
            )
            object.__setattr__(self, key, number)
        for key, most in _DRINKS.items():
            number = as_number(
                getattr(self, key), f"{key} of {self.name}", 0.0, most, error=PigmentError
            )
            object.__setattr__(self, key, number)

    @property
    def uptake(self) -> float:
        """How many times as fast a brush gives its ink as on the surface that it was rated on.

        Guo 2017, section 4.2.2, adapts eta to brush and surface: here by (1 + absorbency) over the
        same of `rated_absorbency`. The factor is set by eye.
        """
        return (1.0 + self.absorbency) / (1.0 + self.rated_absorbency)


@lru_cache(maxsize=1)
def load_materials() -> Mapping[str, Material]:
    """Return all materials by name, in the table's order; read-only."""
    with _TABLE.open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    materials = {}
    for row in rows:
        words: dict[str, Any] = {
            key: row[key] for key in ("name", "chinese", "source", "basis", "licence")
        }
        looks: dict[str, Any] = {key: float(row[key]) for key in (*_LOOKS, *_DRINKS)}
        looks["reflectance"] = [float(row[f"R_{nm:.0f}"]) for nm in BANDS_NM]
        materials[row["name"]] = Material(**words, **looks)
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
