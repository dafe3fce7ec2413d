"""Tables of pigments: CSV of K and S by wavelength, or of the reflectance of a masstone."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from paint3d.colour.masstone import masstone_strengths
from paint3d.colour.pigment import BANDS_NM, COARSEST_UM, USUAL_FINE, Pigment
from paint3d.colour.spectral_files import is_spectral, read_plain_spectrum, read_spectra
from paint3d.core.types import AnyArray
from paint3d.errors import InputError, PigmentError

__all__ = ["load_pigments_csv"]

_NUMBER = re.compile(r"\d+(\.\d*)?|\.\d+")
_DARKEST = 1e-6  # of a reflectance; nothing is as black
_BAND = re.compile(r"\s*([KSR])_(\d+(?:\.\d+)?)\s*")


def load_pigments_csv(path: str | Path) -> Mapping[str, Pigment]:
    """Read a table of pigments, one a row, as a read-only mapping by name.

    Parameters
    ----------
    path : str or Path
        CSV in UTF-8 with a header: ``name``, and either ``K_<nm>`` and ``S_<nm>``, per full coat,
        or ``R_<nm>``, the reflectance of a masstone (see `masstone_strengths`), for rising
        wavelengths that cover 400 to 700 nm (others than every 10 nm are interpolated linearly);
        where wanted ``chinese``, ``source``, ``basis``, ``licence``, ``saunderson`` (yes|no),
        ``gloss`` (0 to 1), ``fine`` (0 to 1; .12), what no pore holds back, and ``grain_um`` (0
        to 1000; 0), the diameter of the other grains, um.
        Or measured masstones as `spectral_files` reads them: IES TM-27 (.spdx), and .txt of two
        columns or of X-Rite.

    Raises
    ------
    PigmentError
        Naming file and line, if it cannot be read, holds no pigment, a name is empty or occurs
        twice, the wavelengths do not rise or cover 400-700 nm, K or S is negative, not finite
        or not a number, R is not from 1e-6 to less than 1, gloss or fine are not between 0 and 1,
        or grain_um is not between 0 and 1000.
    """
    path = Path(path)
    if is_spectral(path):
        return _of_spectra(path)
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            reader = csv.DictReader(stream)
            header = list(reader.fieldnames or [])
            rows = [(reader.line_num, row) for row in reader]
    except (OSError, UnicodeDecodeError, csv.Error) as cause:
        why = getattr(cause, "strerror", None) or cause  # which names the file once more
        raise PigmentError(f"{path}: cannot be read as a table of pigments: {why}") from None
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


def _of_spectra(path: Path) -> Mapping[str, Pigment]:
    """Pigments of measured masstones, by the names that their file gives them, or its own."""
    try:
        plain = read_plain_spectrum(path) if path.suffix.lower() == ".txt" else None
        spectra = read_spectra(path) if plain is None else {path.stem: plain}
    except InputError as cause:
        raise PigmentError(str(cause)) from None
    pigments = {}
    for name, (nm, values) in spectra.items():
        reflectance = np.interp(BANDS_NM, nm, values)
        if not _DARKEST <= reflectance.min() <= reflectance.max() < 1.0:
            raise PigmentError(
                f"{path}: {name!r} is {reflectance.min():g} to {reflectance.max():g}; "
                f"expected the reflectance of a masstone, {_DARKEST:g} to less than 1"
            )
        k, s = masstone_strengths(reflectance)
        pigments[name] = Pigment(name, "", K=k, S=s, source=path.name, basis="masstone")
    return MappingProxyType(pigments)


def _read_bands(header: list[str], path: Path) -> tuple[AnyArray, dict[str, list[str]]]:
    """Wavelengths and columns of each letter: K and S for the same wavelengths, or R alone."""
    columns: dict[str, list[str]] = {"K": [], "S": [], "R": []}
    bands: dict[str, list[float]] = {"K": [], "S": [], "R": []}
    for column in header:
        match = _BAND.fullmatch(column)
        if match:
            columns[match[1]].append(column)
            bands[match[1]].append(float(match[2]))
    masstone = bool(bands["R"]) and not (bands["K"] or bands["S"])
    if not masstone and (bands["R"] or not bands["K"] or bands["K"] != bands["S"]):
        raise PigmentError(
            f"{path}:1: has {len(bands['K'])} columns K_<nm>, {len(bands['S'])} columns S_<nm> "
            f"and {len(bands['R'])} columns R_<nm>; expected K and S for the same wavelengths, "
            "or R alone"
        )
    nm = bands["R" if masstone else "K"]
    if sorted(set(nm)) != nm:
        raise PigmentError(f"{path}:1: wavelengths are not in rising order")
    if nm[0] > BANDS_NM[0] or nm[-1] < BANDS_NM[-1]:
        raise PigmentError(
            f"{path}:1: wavelengths are {nm[0]:g} to {nm[-1]:g} nm; expected to cover 400 to 700"
        )
    return np.array(nm), {a: names for a, names in columns.items() if names}


def _read_row(
    row: dict[str, Any], where: str, nm: AnyArray, columns: dict[str, list[str]]
) -> Pigment:
    spectra = {a: _read_spectrum(row, where, nm, names) for a, names in columns.items()}
    words = {key: (row.get(key) or "").strip() for key in ("name", "chinese", "source", "basis")}
    words["licence"] = (row.get("licence") or "").strip()
    if not words["name"]:
        raise PigmentError(f"{where}: name is empty")
    corrected = (row.get("saunderson") or "no").strip().lower()
    if corrected not in ("yes", "no"):
        raise PigmentError(f"{where}: saunderson is {corrected!r}; expected yes or no")
    gloss = _read_number(row, where, "gloss", 0.0)
    fine = _read_number(row, where, "fine", USUAL_FINE)
    grain = _read_number(row, where, "grain_um", 0.0, COARSEST_UM)
    if "R" in spectra:
        worst = int(np.abs(spectra["R"] - 0.5).argmax())
        if not _DARKEST <= spectra["R"][worst] < 1.0:
            raise PigmentError(
                f"{where}: R is {spectra['R'][worst]:g} at {BANDS_NM[worst]:.0f} nm; "
                f"expected a reflectance from {_DARKEST:g} to less than 1"
            )
        if corrected == "yes":
            raise PigmentError(f"{where}: saunderson is yes; expected no for a masstone")
        strengths = masstone_strengths(spectra["R"])
        words["basis"] = words["basis"] or "masstone"
    else:
        strengths = spectra["K"], spectra["S"]
    return Pigment(
        **words,
        K=strengths[0],
        S=strengths[1],
        saunderson=corrected == "yes",
        gloss=gloss,
        fine=fine,
        grain_um=grain,
    )


def _read_number(
    row: dict[str, Any], where: str, name: str, usual: float, most: float = 1.0
) -> float:
    """A number from 0 to `most`, or the usual one where nothing is said."""
    text = (row.get(name) or "").strip()
    if not text:
        return usual
    if not _NUMBER.fullmatch(text) or not 0.0 <= float(text) <= most:
        raise PigmentError(
            f"{where}: {name} is {text[-40:]!r}; expected a number from 0 to {most:g}"
        )
    return float(text)


def _read_spectrum(row: dict[str, Any], where: str, nm: AnyArray, columns: list[str]) -> AnyArray:
    """Values (31,) of one letter's columns, checked one by one."""
    values = []
    for column in columns:
        try:
            value = float(row[column])
        except (TypeError, ValueError):
            raise PigmentError(f"{where}: {column} is {row[column]!r}; expected a number") from None
        if not 0.0 <= value < math.inf:
            raise PigmentError(
                f"{where}: {column} is {value:g}; expected a finite number of at least 0"
            )
        values.append(value)
    result: AnyArray = np.interp(BANDS_NM, nm, values)
    return result
