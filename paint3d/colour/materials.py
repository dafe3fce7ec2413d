"""The materials that surfaces are made of, by name, and those of one's own files.

The table `data/materials.csv` is built by `scripts/build_materials.py`; each row says where its
reflectance was measured and for what it stands in, and `note` where the other numbers are from.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from functools import lru_cache, partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

from paint3d.colour.material import WET_COAT_MM, Material, material_ranges
from paint3d.colour.material_file import read_material
from paint3d.colour.pigments import BANDS_NM
from paint3d.core.parameter_file import named_or_read
from paint3d.errors import PigmentError

__all__ = ["WET_COAT_MM", "Material", "load_material", "load_materials", "material_names"]

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
