"""Lights and observers: those of the CIE as colour-science tabulates them, and files of one's own.

colour-science is imported when one is asked for, and only here and in `spectral_files`: the light
that paintings have by themselves, D65 and the observer of 1931, is in a small table of our own.
"""

from __future__ import annotations

import difflib
import os
import re
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.spectral_files import read_plain_spectrum, read_spectra
from paint3d.core.types import AnyArray
from paint3d.errors import InputError, UnknownNameError

__all__ = [
    "OBSERVERS",
    "colour_science",
    "find_illuminant",
    "illuminant_names",
    "observer_weights",
    "white_of",
]

OBSERVERS = {2: "CIE 1931 2 Degree Standard Observer", 10: "CIE 1964 10 Degree Standard Observer"}
FINE_NM = np.arange(360.0, 831.0)
"""(471,) nm, at which light, observer and reflectance are summed."""
FINE_NM.flags.writeable = False

_KELVINS = re.compile(r"(\d{3,5}(?:\.\d+)?)\s*K", re.IGNORECASE)
_LAMP = re.compile(r"F(L?)(\d+(?:\.\d+)?)", re.IGNORECASE)
_COLDEST, _HOTTEST = 800.0, 25_000.0
_C2 = 1.438776877e7  # nm K, of Planck's law
_FAINTEST = 1e-9  # share of a file's power that can be seen
_SUFFIXES = (".spd", ".csv", ".txt", ".tsv", ".spdx", ".xml")


def colour_science() -> Any:
    """The package colour-science.

    Raises
    ------
    InputError
        If it is not installed; it says how it is.
    """
    try:
        return import_module("colour")
    except ImportError as cause:
        raise InputError(
            f"this needs colour-science, which fails: {cause}; "
            'expected it installed: pip install "paint3d[spectral]"'
        ) from None


def illuminant_names() -> list[str]:
    """The names of the lights that colour-science tabulates."""
    return list(colour_science().SDS_ILLUMINANTS)


@lru_cache(maxsize=64)
def find_illuminant(name: str) -> NDArray[np.float64]:
    """Relative power (471,) of a light at `FINE_NM`.

    Parameters
    ----------
    name : str
        One of `illuminant_names` (``F2`` is ``FL2``), a temperature such as ``2700K`` (a black
        body, Planck 1901), or a file: two columns, wavelength in nm and power, or what
        `spectral_files` reads. Between its wavelengths a light is interpolated linearly, beyond
        them it is as at the last.

    Raises
    ------
    UnknownNameError
        If there is no such light.
    InputError
        If the file holds none, or colour-science is missing.
    """
    heat = _KELVINS.fullmatch(name.strip())
    if heat:
        return _black_body(float(heat[1]), name)
    if os.path.splitext(name)[1].lower() in _SUFFIXES:
        return _of_file(Path(name))
    known = colour_science().SDS_ILLUMINANTS
    lamp = _LAMP.fullmatch(name.strip())
    wanted = (f"FL{lamp[2]}" if lamp else name.strip()).lower()
    found = next((key for key in known if key.lower() == wanted), None)
    if found is None:
        close = difflib.get_close_matches(name.upper(), list(known), 3, 0.5)
        expected = [*dict.fromkeys([*close, "A", "D50", "D65", "F2", "F11", "LED-B3", "E"])]
        raise UnknownNameError("illuminant", name, [*expected, "a temperature 2700K", "FILE.spd"])
    spectrum = known[found]
    return _fine(np.asarray(spectrum.wavelengths), np.asarray(spectrum.values))


def _black_body(kelvins: float, name: str) -> NDArray[np.float64]:
    if not _COLDEST <= kelvins <= _HOTTEST:
        raise InputError(
            f"the illuminant is {name}; expected {_COLDEST:g}K to {_HOTTEST:g}K for a black body"
        )
    power = FINE_NM**-5.0 / np.expm1(_C2 / (FINE_NM * kelvins))
    result: NDArray[np.float64] = power / power[200]
    return result


def _of_file(path: Path) -> NDArray[np.float64]:
    found = read_plain_spectrum(path)
    if found is None:
        spectra = read_spectra(path)
        if len(spectra) != 1:
            raise InputError(f"{path}: holds {len(spectra)} spectra; expected one, of a light")
        found = next(iter(spectra.values()))
    nm, power = found
    if power.min() < 0.0 or not power.max() > 0.0:
        raise InputError(f"{path}: its power is {power.min():g} to {power.max():g}; expected light")
    fine = _fine(nm, power / power.max())
    if not fine.max() > _FAINTEST:
        raise InputError(f"{path}: none of its power is from 360 to 830 nm; expected light")
    return fine


def _fine(nm: AnyArray, values: AnyArray) -> NDArray[np.float64]:
    result: NDArray[np.float64] = np.interp(FINE_NM, nm, values)
    return result


@lru_cache(maxsize=2)
def _observer(degrees: int) -> NDArray[np.float64]:
    table = colour_science().MSDS_CMFS[OBSERVERS[degrees]]
    nm = np.asarray(table.wavelengths)
    return np.stack([_fine(nm, column) for column in np.asarray(table.values).T], axis=1)


def white_of(illuminant: str, observer: int) -> NDArray[np.float64]:
    """XYZ (3,) of a perfect reflector in a light, Y = 1."""
    result: NDArray[np.float64] = observer_weights(illuminant, observer).sum(axis=0)
    return result


@lru_cache(maxsize=64)
def observer_weights(illuminant: str, observer: int) -> NDArray[np.float64]:
    """Weights (31, 3): XYZ of a reflectance spectrum in a light is ``spectrum @ weights``, Y = 1.

    Light and observer are summed by 1 nm, as CIE 15 asks; the reflectance is interpolated linearly
    between its 31 bands and beyond them as at the last. So lamps with lines are not missed.

    Raises
    ------
    UnknownNameError
        If the light or the observer is not known.
    InputError
        If a file holds no light, or colour-science is missing.
    """
    if observer not in OBSERVERS:
        raise UnknownNameError("observer", str(observer), [str(degrees) for degrees in OBSERVERS])
    seen = find_illuminant(illuminant)[:, None] * _observer(observer)
    seen /= seen[:, 1].sum()
    at = np.clip((FINE_NM - 400.0) / 10.0, 0.0, 30.0)
    hats = np.maximum(0.0, 1.0 - np.abs(at[None, :] - np.arange(31.0)[:, None]))
    weights: NDArray[np.float64] = hats @ seen
    weights.flags.writeable = False
    return weights
