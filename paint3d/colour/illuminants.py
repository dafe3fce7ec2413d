"""Illuminants and observers: the CIE's, as colour-science tabulates them, and spectra from files.

colour-science is imported on first use, and only here: the default light and observer, D65 and
CIE 1931, come from the small table that `spectra` reads.
"""

from __future__ import annotations

import difflib
import os
import re
from collections.abc import Callable, Mapping
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError, UnknownNameError

__all__ = [
    "OBSERVERS",
    "Spectrum",
    "colour_science",
    "find_illuminant",
    "illuminant_names",
    "is_spectral",
    "observer_weights",
    "read_plain_spectrum",
    "read_spectra",
    "white_of",
]

# ---- Files of spectra ----------------------------------------------------------------------------
# Plain columns are read here; IES TM-27-14 (.spdx), X-Rite, Sekonic and UPRtek by colour-science,
# XML only after `parse_xml` found no entities in it.

Spectrum = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Wavelengths (N,) in nm, rising, and values (N,)."""

_MOST_BYTES = 1 << 22
_SPLIT = re.compile(r"[,;\s]+")
_FIRST_NM, _LAST_NM = 400.0, 700.0
_XML = (".spdx", ".xml")
_DEEPEST = 16  # elements of TM-27 in one another


def is_spectral(path: str | Path) -> bool:
    """Return whether a file's name is that of a measured spectrum, not of a table of pigments."""
    return str(path).lower().endswith((*_XML, ".txt"))


def read_plain_spectrum(path: Path) -> Spectrum | None:
    """Read two columns, wavelength in nm and value; None if the file is of another kind.

    Commas, semicolons, tabs or blanks separate them, lines before the first number are a header,
    ``#`` begins a comment.

    Raises
    ------
    InputError
        If it cannot be read, or a line after the first numbers is no pair of them.
    """
    rows: list[tuple[float, float]] = []
    for k, line in enumerate(_read_text(path).splitlines(), 1):
        words = [word for word in _SPLIT.split(line.split("#")[0].strip()) if word]
        if not words:
            continue
        try:
            nm, value = (float(word) for word in words)
        except ValueError:
            if not rows:
                continue  # a header
            if len(rows) < 3:
                return None
            raise InputError(
                "{file}:{k}: {line!r}; expected a wavelength in nm and a value",
                file=path,
                k=k,
                line=line.strip()[:60],
            ) from None
        rows.append((nm, value))
    if not rows:
        return None
    nm_column, values = np.array(rows).T
    return _checked(path, nm_column, values)


def read_spectra(path: str | Path) -> Mapping[str, Spectrum]:
    """Read the spectra of a .spdx file, or of X-Rite's, Sekonic's or UPRtek's text, by name.

    Raises
    ------
    InputError
        If the file cannot be read, is none of these, or colour-science is missing.
    """
    path = Path(path)
    text = _read_text(path)
    if path.suffix.lower() in _XML:
        from paint3d.core.foreign_xml import XmlFault, parse_xml  # pigments are read without

        try:
            parse_xml(text.encode("utf-8"), _DEEPEST, doctypes=False)
        except XmlFault as fault:
            raise InputError("{file}: {fault}", file=path, fault=fault) from None
    try:
        colour = import_module("colour")
    except ImportError as cause:
        raise InputError(
            "{file}: spectra of this kind are read by colour-science, which fails: {cause}",
            file=path,
            cause=cause,
            hint="pip install 'paint3d[spectral]'",
        ) from None
    for read in _readers(path, text, colour):
        try:
            found = {
                name: (
                    np.asarray(spectrum.wavelengths, np.float64),
                    np.asarray(spectrum.values, np.float64),
                )
                for name, spectrum in read().items()
            }
        except Exception:  # whatever a reader stumbles over in a file of another kind
            continue
        if found and all(len(nm) > 1 for nm, _ in found.values()):
            return {name: _checked(path, nm, values) for name, (nm, values) in found.items()}
    raise InputError(
        "{file}: holds no spectrum that is known; expected two columns (nm, value), IES TM-27 "
        "(.spdx), or text of X-Rite, Sekonic or UPRtek",
        file=path,
    )


def _readers(path: Path, text: str, colour: Any) -> tuple[Callable[[], Mapping[str, Any]], ...]:
    """Return the readers of colour-science that may fit a file, the likeliest first."""

    def measured(kind: str) -> Callable[[], Mapping[str, Any]]:
        def read() -> Mapping[str, Any]:
            spectrum = getattr(colour, f"SpectralDistribution_{kind}")(str(path))
            return {path.stem: spectrum.read() or spectrum}

        return read

    if path.suffix.lower() in _XML:
        return (measured("IESTM2714"),)
    kinds: tuple[Callable[[], Mapping[str, Any]], ...] = (
        lambda: colour.read_sds_from_xrite_file(str(path)),
        measured("Sekonic"),
        measured("UPRTek"),
    )
    return kinds[1:] + kinds[:1] if "sekonic" in text.lower() else kinds


def _read_text(path: Path) -> str:
    try:
        with path.open("rb") as stream:
            data = stream.read(_MOST_BYTES + 1)
    except OSError as cause:
        raise InputError("{file}: cannot be read: {cause}", file=path, cause=cause) from None
    if len(data) > _MOST_BYTES:
        raise InputError(
            "{file}: is larger than {most:,} bytes; expected a spectrum",
            file=path,
            most=_MOST_BYTES,
        )
    for encoding in ("utf-8-sig", "utf-16"):
        try:
            return data.decode(encoding)
        except UnicodeDecodeError:
            continue
    return data.decode("latin-1")


def _checked(path: Path, nm: AnyArray, values: AnyArray) -> Spectrum:
    if not (np.isfinite(nm).all() and np.isfinite(values).all()):
        raise InputError("{file}: a number of its spectrum is not finite", file=path)
    if not (np.diff(nm) > 0.0).all():
        raise InputError("{file}: its wavelengths are not in rising order", file=path)
    if nm[0] > _FIRST_NM or nm[-1] < _LAST_NM:
        raise InputError(
            "{file}: its wavelengths are {first:g} to {last:g} nm; expected to cover 400 to 700",
            file=path,
            first=nm[0],
            last=nm[-1],
        )
    return nm, values


# ---- Illuminants and observers -------------------------------------------------------------------


OBSERVERS = {2: "CIE 1931 2 Degree Standard Observer", 10: "CIE 1964 10 Degree Standard Observer"}
FINE_NM = np.arange(360.0, 831.0)
"""(471,) nm, the wavelengths of the sum over light, observer and reflectance."""
FINE_NM.flags.writeable = False

_KELVINS = re.compile(r"(\d{3,5}(?:\.\d+)?)\s*K", re.IGNORECASE)
_LAMP = re.compile(r"F(L?)(\d+(?:\.\d+)?)", re.IGNORECASE)
_COLDEST, _HOTTEST = 800.0, 25_000.0
_C2 = 1.438776877e7  # nm K, of Planck's law
_FAINTEST = 1e-9  # fraction of a file's peak power that must be visible
_SUFFIXES = (".spd", ".csv", ".txt", ".tsv", ".spdx", ".xml")


def colour_science() -> Any:
    """Import the package colour-science.

    Raises
    ------
    InputError
        If it is not installed; the message says how to.
    """
    try:
        return import_module("colour")
    except ImportError as cause:
        raise InputError(
            "this needs colour-science, which fails: {cause}",
            cause=cause,
            hint="pip install 'paint3d[spectral]'",
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
        `read_spectra` reads. Between its wavelengths a light is interpolated linearly, beyond
        them it is constant.

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
        return _read_illuminant(Path(name))
    known = colour_science().SDS_ILLUMINANTS
    lamp = _LAMP.fullmatch(name.strip())
    wanted = (f"FL{lamp[2]}" if lamp else name.strip()).lower()
    found = next((key for key in known if key.lower() == wanted), None)
    if found is None:
        close = difflib.get_close_matches(name.upper(), list(known), 3, 0.5)
        expected = [*dict.fromkeys([*close, "A", "D50", "D65", "F2", "F11", "LED-B3", "E"])]
        raise UnknownNameError("illuminant", name, [*expected, "a temperature 2700K", "FILE.spd"])
    spectrum = known[found]
    return _resample(np.asarray(spectrum.wavelengths), np.asarray(spectrum.values))


def _black_body(kelvins: float, name: str) -> NDArray[np.float64]:
    if not _COLDEST <= kelvins <= _HOTTEST:
        raise InputError(
            "the illuminant is {name}; expected {coldest:g}K to {hottest:g}K for a black body",
            name=name,
            coldest=_COLDEST,
            hottest=_HOTTEST,
        )
    power = FINE_NM**-5.0 / np.expm1(_C2 / (FINE_NM * kelvins))
    result: NDArray[np.float64] = power / power[200]
    return result


def _read_illuminant(path: Path) -> NDArray[np.float64]:
    found = read_plain_spectrum(path)
    if found is None:
        spectra = read_spectra(path)
        if len(spectra) != 1:
            raise InputError(
                "{file}: holds {n} spectra; expected one, of a light",
                file=path,
                n=len(spectra),
            )
        found = next(iter(spectra.values()))
    nm, power = found
    if power.min() < 0.0 or not power.max() > 0.0:
        raise InputError(
            "{file}: its power is {least:g} to {most:g}; expected light",
            file=path,
            least=power.min(),
            most=power.max(),
        )
    fine = _resample(nm, power / power.max())
    if not fine.max() > _FAINTEST:
        raise InputError(
            "{file}: none of its power is from 360 to 830 nm; expected light",
            file=path,
        )
    return fine


def _resample(nm: AnyArray, values: AnyArray) -> NDArray[np.float64]:
    """Interpolate values at wavelengths `nm` to `FINE_NM`."""
    result: NDArray[np.float64] = np.interp(FINE_NM, nm, values)
    return result


@lru_cache(maxsize=2)
def _matching_functions(degrees: int) -> NDArray[np.float64]:
    """Colour matching functions (471, 3) of an observer at `FINE_NM`."""
    table = colour_science().MSDS_CMFS[OBSERVERS[degrees]]
    nm = np.asarray(table.wavelengths)
    return np.stack([_resample(nm, column) for column in np.asarray(table.values).T], axis=1)


def white_of(illuminant: str, observer: int) -> NDArray[np.float64]:
    """XYZ (3,) of a perfect reflector in a light, Y = 1."""
    result: NDArray[np.float64] = observer_weights(illuminant, observer).sum(axis=0)
    return result


@lru_cache(maxsize=64)
def observer_weights(illuminant: str, observer: int) -> NDArray[np.float64]:
    """Weights (31, 3): XYZ of a reflectance spectrum in a light is ``spectrum @ weights``, Y = 1.

    Light and observer are summed every 1 nm, as CIE 15 requires, so that the lines of lamps are
    not missed; the reflectance is interpolated linearly between its 31 bands and constant beyond.

    Raises
    ------
    UnknownNameError
        If the light or the observer is unknown.
    InputError
        If a file holds no light, or colour-science is missing.
    """
    if observer not in OBSERVERS:
        raise UnknownNameError("observer", str(observer), [str(degrees) for degrees in OBSERVERS])
    seen = find_illuminant(illuminant)[:, None] * _matching_functions(observer)
    seen /= seen[:, 1].sum()
    at = np.clip((FINE_NM - 400.0) / 10.0, 0.0, 30.0)
    # hat functions: the linear interpolation as weights of the bands
    hats = np.maximum(0.0, 1.0 - np.abs(at[None, :] - np.arange(31.0)[:, None]))
    weights: NDArray[np.float64] = hats @ seen
    weights.flags.writeable = False
    return weights
