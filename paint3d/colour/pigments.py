"""The pigments there are to paint with, by name.

Two tables lie in `data/`, both built by scripts from published measurements: `palette.csv`, the
inks and colours to paint with (`scripts/build_palette.py`), and `drawdown_paints.csv`, the oil
paints of the drawdowns that the colour model was checked on (`scripts/fit_drawdowns.py`).
Users' own tables have the same columns (`load_pigments_csv`); a pigment of one is named
``FILE.csv:NAME``.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

import numpy as np

from paint3d.colour.ink_text import table_of
from paint3d.colour.pigment import BANDS_NM, Pigment
from paint3d.colour.pigment_tables import load_pigments_csv
from paint3d.errors import PigmentError, UnknownNameError

__all__ = [
    "BANDS_NM",
    "WATER",
    "Pigment",
    "load_drawdown_paints",
    "load_palette",
    "load_pigment",
    "load_pigments_csv",
    "pigment_names",
]

_DATA = Path(__file__).parent / "data"

_ALSO = {"azurite 2": "azurite", "二青": "azurite", "malachite 2": "malachite", "二绿": "malachite"}
_SIMPLIFIED = str.maketrans("頭綠煙硃鉛黃銅鐵礦鈦臙", "头绿烟朱铅黄铜铁矿钛胭")

WATER = Pigment(
    "water",
    "水",
    np.zeros(BANDS_NM.size),
    np.zeros(BANDS_NM.size),
    source="none needed: clear water neither absorbs nor scatters visible light in so thin a film",
    basis="by definition",
    licence="none needed",
)
"""What inks are thinned with: it takes room in the brush and on the surface and dries away."""


@lru_cache(maxsize=1)
def load_palette() -> Mapping[str, Pigment]:
    """Inks and colours to paint with, by name."""
    return load_pigments_csv(_DATA / "palette.csv")


@lru_cache(maxsize=1)
def load_drawdown_paints() -> Mapping[str, Pigment]:
    """Oil paints fitted on the drawdowns, by the names used there."""
    return load_pigments_csv(_DATA / "drawdown_paints.csv")


def pigment_names() -> list[str]:
    """Names of the palette, inks first, as in the table."""
    return list(load_palette())


def load_pigment(name: str, *, own_tables: bool = True) -> Pigment:
    """Return a pigment by its name in the palette, English or Chinese, or a drawdown paint.

    Chinese may be in either script; ``azurite 2`` and ``二青`` are the grade that ``azurite`` is.
    ``water`` is one too; ``FILE.csv:NAME`` is the pigment NAME of a user's own table.

    Parameters
    ----------
    name : str
    own_tables : bool
        Whether the name may lead to a file. Names that come from somebody else's file may not.

    Raises
    ------
    UnknownNameError
        If there is none; the message lists the palette, or the table's names.
    PigmentError
        If the table cannot be used, or may not be read.
    """
    file = table_of(name)
    if file is not None:
        if not own_tables:
            raise PigmentError(
                f"the ink {name[-100:]!r} is of a table on this machine, which a file "
                "may not name; expected an ink of the palette"
            )
        own, table = name[len(file) + 1 :], load_pigments_csv(file)
        if own not in table:
            raise UnknownNameError(f"ink of {file}", own, table)
        return table[own]
    palette = load_palette()
    found = palette.get(name) or load_drawdown_paints().get(name)
    if found is None and name:
        plain = name.translate(_SIMPLIFIED)
        plain = _ALSO.get(plain, plain)
        found = next((p for p in (*palette.values(), WATER) if plain in (p.chinese, p.name)), None)
    if found is None:
        raise UnknownNameError("ink", name, [*palette, *load_drawdown_paints(), WATER.name])
    return found
