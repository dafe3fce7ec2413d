"""Files of spectra: plain columns, IES TM-27-14 (.spdx), X-Rite, Sekonic and UPRtek.

Plain columns are read here, the rest by colour-science, after a look at what a stranger's XML
declares.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.types import AnyArray
from paint3d.errors import InputError

__all__ = ["Spectrum", "is_spectral", "read_plain_spectrum", "read_spectra"]

Spectrum = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Wavelengths (N,) in nm, rising, and values (N,)."""

_MOST_BYTES = 1 << 22
_SPLIT = re.compile(r"[,;\s]+")
_FIRST_NM, _LAST_NM = 400.0, 700.0
_XML = (".spdx", ".xml")
_DEEPEST = 16  # elements of TM-27 in one another


def is_spectral(path: str | Path) -> bool:
    """Whether a file's name is that of a measured spectrum and not of a table of pigments."""
    return str(path).lower().endswith((*_XML, ".txt"))


def read_plain_spectrum(path: Path) -> Spectrum | None:
    """Read two columns, wavelength in nm and value; None if the file is of another kind.

    Commas, semicolons, tabs or blanks are between them, lines before the first number are a head,
    ``#`` begins a comment.

    Raises
    ------
    InputError
        If it cannot be read, or a line after the first numbers is no pair of them.
    """
    rows: list[tuple[float, float]] = []
    for k, line in enumerate(_text(path).splitlines(), 1):
        words = [word for word in _SPLIT.split(line.split("#")[0].strip()) if word]
        if not words:
            continue
        try:
            nm, value = (float(word) for word in words)
        except ValueError:
            if not rows:
                continue  # a head
            if len(rows) < 3:
                return None
            raise InputError(
                f"{path}:{k}: {line.strip()[:60]!r}; expected a wavelength in nm and a value"
            ) from None
        rows.append((nm, value))
    if not rows:
        return None
    nm_column, values = np.array(rows).T
    return _checked(path, nm_column, values)


def read_spectra(path: str | Path) -> Mapping[str, Spectrum]:
    """Read what colour-science does, by name: .spdx, and text of X-Rite, Sekonic and UPRtek.

    Raises
    ------
    InputError
        If it cannot be read, is none of these, or colour-science is missing.
    """
    path = Path(path)
    text = _text(path)
    if path.suffix.lower() in _XML:
        _check_xml(path, text)
    try:
        colour = import_module("colour")
    except ImportError as cause:
        raise InputError(
            f"{path}: spectra of this kind are read by colour-science, which fails: {cause}; "
            'expected it installed: pip install "paint3d[spectral]"'
        ) from None
    for read in _readers(path, text, colour):
        try:
            found = {name: _points(spectrum) for name, spectrum in read().items()}
        except Exception:  # whatever a reader stumbles over in a file of another kind
            continue
        if found and all(len(nm) > 1 for nm, _ in found.values()):
            return {name: _checked(path, nm, values) for name, (nm, values) in found.items()}
    raise InputError(
        f"{path}: holds no spectrum that is known; expected two columns (nm, value), IES TM-27 "
        "(.spdx), or text of X-Rite, Sekonic or UPRtek"
    )


def _check_xml(path: Path, text: str) -> None:
    from paint3d.core.foreign_xml import XmlFault, parse_xml  # pigments are read without

    try:
        parse_xml(text.encode("utf-8"), _DEEPEST, doctypes=False)
    except XmlFault as fault:
        raise InputError(f"{path}: {fault}") from None


def _readers(path: Path, text: str, colour: Any) -> tuple[Callable[[], Mapping[str, Any]], ...]:
    """How colour-science might read a file, the likeliest first."""

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


def _points(spectrum: Any) -> Spectrum:
    return np.asarray(spectrum.wavelengths, np.float64), np.asarray(spectrum.values, np.float64)


def _text(path: Path) -> str:
    try:
        with path.open("rb") as stream:
            data = stream.read(_MOST_BYTES + 1)
    except OSError as cause:
        raise InputError(f"{path}: cannot be read: {cause.strerror or cause}") from None
    if len(data) > _MOST_BYTES:
        raise InputError(f"{path}: is larger than {_MOST_BYTES:,} bytes; expected a spectrum")
    for encoding in ("utf-8-sig", "utf-16"):
        try:
            return data.decode(encoding)
        except UnicodeDecodeError:
            continue
    return data.decode("latin-1")


def _checked(path: Path, nm: AnyArray, values: AnyArray) -> Spectrum:
    if not (np.isfinite(nm).all() and np.isfinite(values).all()):
        raise InputError(f"{path}: a number of its spectrum is not finite")
    if not (np.diff(nm) > 0.0).all():
        raise InputError(f"{path}: its wavelengths are not in rising order")
    if nm[0] > _FIRST_NM or nm[-1] < _LAST_NM:
        raise InputError(
            f"{path}: its wavelengths are {nm[0]:g} to {nm[-1]:g} nm; expected to cover 400 to 700"
        )
    return nm, values
