"""Pigments: how strongly each absorbs and scatters light, by wavelength, and where that is from.

Two tables lie in `data/`, both built by scripts from published measurements: `palette.csv`, the
inks and colours to paint with (`scripts/build_palette.py`), and `drawdown_paints.csv`, the oil
paints of the drawdowns that the colour model was checked on (`scripts/fit_drawdowns.py`).
Users' own tables have the same columns.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from paint3d.arrays import as_array
from paint3d.errors import PigmentError, UnknownNameError

__all__ = [
    "BANDS_NM",
    "Pigment",
    "load_drawdown_paints",
    "load_palette",
    "load_pigment",
    "load_pigments_csv",
    "pigment_names",
]

BANDS_NM = np.arange(400.0, 701.0, 10.0)
"""(31,) wavelengths of K and S, nm."""
BANDS_NM.flags.writeable = False

_DATA = Path(__file__).parent / "data"
_BAND = re.compile(r"([KS])_(\d+(?:\.\d+)?)")


@dataclass(frozen=True, eq=False)
class Pigment:
    """One pigment, ink or paint.

    Parameters
    ----------
    name, chinese : str
    K, S : (31,) array_like
        Absorption and scattering per full coat at 400, 410, ... 700 nm, finite, >= 0.
    source, basis, licence : str
        Whose measurement; how K and S came from it, and for what it stands in; its terms.
    saunderson : bool
        Whether K and S describe the film below its gloss, so that Saunderson's correction leads
        to what is measured. Otherwise they give the measured reflectance themselves.

    Raises
    ------
    PigmentError
        If the name is empty, or K or S has the wrong length, is negative or not finite.
    """

    name: str
    chinese: str
    K: NDArray
    S: NDArray
    source: str = ""
    basis: str = ""
    licence: str = ""
    saunderson: bool = False

    def __post_init__(self) -> None:
        if not self.name:
            raise PigmentError("a pigment has no name")
        for letter in "KS":
            values = as_array(
                getattr(self, letter), f"{letter} of {self.name}", (31,), error=PigmentError
            ).copy()
            if values.min() < 0:
                worst = int(values.argmin())
                raise PigmentError(
                    f"{letter} of {self.name} is {values[worst]:g} at {BANDS_NM[worst]:.0f} nm; "
                    "expected at least 0"
                )
            values.flags.writeable = False
            object.__setattr__(self, letter, values)


def _read_bands(header: list[str], path: Path) -> tuple[NDArray, dict[str, list[str]]]:
    """Wavelengths of the K_ and S_ columns, which must be the same, rising, and cover 400-700."""
    columns = {"K": [], "S": []}
    for column in header:
        match = _BAND.fullmatch(column.strip())
        if match:
            columns[match[1]].append(column)
    k_nm, s_nm = ([float(c.strip()[2:]) for c in columns[letter]] for letter in "KS")
    if not k_nm or k_nm != s_nm:
        raise PigmentError(
            f"{path}:1: has {len(k_nm)} columns K_<nm> and {len(s_nm)} columns S_<nm>; "
            "expected both for the same wavelengths"
        )
    if sorted(set(k_nm)) != k_nm:
        raise PigmentError(f"{path}:1: wavelengths are not in rising order")
    if k_nm[0] > 400 or k_nm[-1] < 700:
        raise PigmentError(
            f"{path}:1: wavelengths are {k_nm[0]:g} to {k_nm[-1]:g} nm; "
            "expected to cover 400 to 700"
        )
    return np.array(k_nm), columns


def _read_row(row: dict, where: str, nm: NDArray, columns: dict[str, list[str]]) -> Pigment:
    spectra = {}
    for letter in "KS":
        values = np.empty(nm.size)
        for i, column in enumerate(columns[letter]):
            try:
                values[i] = float(row[column])
            except (TypeError, ValueError):
                raise PigmentError(
                    f"{where}: {column} is {row[column]!r}; expected a number"
                ) from None
            if not (np.isfinite(values[i]) and values[i] >= 0):
                raise PigmentError(
                    f"{where}: {column} is {values[i]:g}; expected a finite number of at least 0"
                )
        spectra[letter] = np.interp(BANDS_NM, nm, values)
    words = {key: (row.get(key) or "").strip() for key in ("name", "chinese", "source", "basis")}
    if not words["name"]:
        raise PigmentError(f"{where}: name is empty")
    gloss = (row.get("saunderson") or "no").strip().lower()
    if gloss not in ("yes", "no"):
        raise PigmentError(f"{where}: saunderson is {gloss!r}; expected yes or no")
    licence = (row.get("licence") or "").strip()
    return Pigment(**words, **spectra, licence=licence, saunderson=gloss == "yes")


def load_pigments_csv(path: str | Path) -> Mapping[str, Pigment]:
    """Read a table of pigments, one a row, as a read-only mapping by name.

    Parameters
    ----------
    path : str or Path
        CSV in UTF-8 with a header: ``name``, ``K_<nm>`` and ``S_<nm>`` for the same rising
        wavelengths that cover 400 to 700 nm (others than every 10 nm are interpolated linearly),
        and where wanted ``chinese``, ``source``, ``basis``, ``licence``, ``saunderson`` (yes|no).

    Raises
    ------
    PigmentError
        Naming file and line, if it cannot be read, holds no pigment, a name is empty or occurs
        twice, the wavelengths do not rise or cover 400-700 nm, or K or S is negative, not
        finite or not a number.
    """
    path = Path(path)
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            reader = csv.DictReader(stream)
            header = list(reader.fieldnames or [])
            rows = [(reader.line_num, row) for row in reader]
    except (OSError, UnicodeDecodeError, csv.Error) as cause:
        raise PigmentError(f"{path}: cannot be read as a table of pigments: {cause}") from None
    if "name" not in header:
        raise PigmentError(f"{path}:1: has no column 'name'")
    nm, columns = _read_bands(header, path)
    pigments: dict[str, Pigment] = {}
    for line, row in rows:
        pigment = _read_row(row, f"{path}:{line}", nm, columns)
        if pigment.name in pigments:
            raise PigmentError(f"{path}:{line}: {pigment.name!r} occurs twice")
        pigments[pigment.name] = pigment
    if not pigments:
        raise PigmentError(f"{path}: holds no pigment; expected at least one row")
    return MappingProxyType(pigments)


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


def load_pigment(name: str) -> Pigment:
    """Return a pigment by its name in the palette, English or Chinese, or a drawdown paint.

    Raises
    ------
    UnknownNameError
        If there is none; the message lists the palette.
    """
    palette, paints = load_palette(), load_drawdown_paints()
    found = palette.get(name) or paints.get(name)
    if found is None and name:
        found = next((p for p in palette.values() if p.chinese == name), None)
    if found is None:
        raise UnknownNameError("ink", name, [*palette, *paints])
    return found
