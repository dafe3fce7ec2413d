"""Pigments by name: those of the palette, the drawdown paints and users' tables.

Scripts build two tables in `data/` from published measurements: `palette.csv`, the inks and
colours to paint with (`scripts/build_palette.py`), and `drawdown_paints.csv`, the oil paints of
the drawdowns that the colour model was checked on (`scripts/fit_drawdowns.py`).
Users' own tables have the same columns (`load_pigments_csv`); a pigment of one is named
``FILE.csv:NAME``.
"""

from __future__ import annotations

import csv
import difflib
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from operator import attrgetter
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from paint3d.colour.illuminants import is_spectral, read_plain_spectrum, read_spectra
from paint3d.colour.ink_text import table_of
from paint3d.colour.kernels.kubelka_munk import layer_bands
from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.errors import InputError, Message, PigmentError, UnknownNameError

__all__ = [
    "BANDS_NM",
    "COARSEST_UM",
    "HIDING",
    "USUAL_FINE",
    "WATER",
    "Pigment",
    "film_strengths",
    "load_drawdown_paints",
    "load_palette",
    "load_pigment",
    "load_pigments_csv",
    "masstone_strengths",
    "pigment_names",
]

# ---- One pigment ---------------------------------------------------------------------------------
# Absorption and scattering by wavelength, with their source.

BANDS_NM = np.arange(400.0, 701.0, 10.0)
"""(31,) wavelengths of K and S, nm."""
BANDS_NM.flags.writeable = False
USUAL_FINE = 0.12
"""Default of `Pigment.fine`: the fraction that goes with the water until pores catch it."""
COARSEST_UM = 1000.0
"""Largest diameter of a pigment's grains, um."""
_DENSITIES = 0.01, 30.0  # g/cm3: osmium has 22.6
_STRONGEST = 1e6  # K and S of a coat; measured inks stay below 100


@dataclass(frozen=True, eq=False)
class Pigment:
    """One pigment, ink or paint.

    Parameters
    ----------
    name, chinese : str
    K, S : (31,) array_like
        Absorption and scattering per full coat at 400, 410, ... 700 nm, 0 to a million.
    source, basis, licence : str
        Whose measurement; how K and S were derived, and what they stand in for; its terms.
    saunderson : bool
        Whether K and S describe the film below its gloss, so that the measured reflectance
        follows by Saunderson's correction. Otherwise they give it directly.
    gloss : float
        Gloss of a dry full coat, 0 (that of the surface below) to 1.
    fine : float
        Fraction that no pore holds back, 0 (all grains) to 1 (dissolved).
    grain_um : float
        Diameter of the grains of the rest, um, 0 (no larger than soot) to 1000.
    density : float, optional
        Mass over volume of the paint, g/cm3, 0.01 to 30, where recipes of it are mass;
        None where they are parts of volume already, as of the palette.

    Raises
    ------
    PigmentError
        If the name is empty, K or S has the wrong length or is not between 0 and a million,
        gloss or fine are not between 0 and 1, grain_um is not between 0 and 1000, or the density
        is not from 0.01 to 30.
    """

    name: str
    chinese: str
    K: AnyArray
    S: AnyArray
    source: str = ""
    basis: str = ""
    licence: str = ""
    saunderson: bool = False
    gloss: float = 0.0
    fine: float = USUAL_FINE
    grain_um: float = 0.0
    density: float | None = None

    def __post_init__(self) -> None:
        if not self.name:
            raise PigmentError("a pigment has no name")
        for fraction in ("gloss", "fine"):
            value = getattr(self, fraction)
            as_number(value, f"{fraction} of {self.name}", 0.0, 1.0, error=PigmentError)
        grain = f"grain_um of {self.name}"
        as_number(self.grain_um, grain, 0.0, COARSEST_UM, error=PigmentError)
        if self.density is not None:
            density = f"density of {self.name}"
            as_number(self.density, density, *_DENSITIES, error=PigmentError)
        for letter in "KS":
            values = as_array(
                getattr(self, letter), f"{letter} of {self.name}", (31,), error=PigmentError
            ).copy()
            if not 0.0 <= values.min() <= values.max() <= _STRONGEST:
                worst = int(values.argmin() if values.min() < 0.0 else values.argmax())
                raise PigmentError(
                    "{letter} of {name} is {values:g} at {nm:.0f} nm; expected 0 to {strongest:g}",
                    letter=letter,
                    name=self.name,
                    values=values[worst],
                    nm=BANDS_NM[worst],
                    strongest=_STRONGEST,
                )
            values.flags.writeable = False
            object.__setattr__(self, letter, values)

    def is_like(self, other: Pigment) -> bool:
        """Return whether it absorbs, scatters, shines and flows as another, whatever its name."""
        if self is other:
            return True
        same = np.array_equal(self.K, other.K) and np.array_equal(self.S, other.S)
        rest = attrgetter("saunderson", "gloss", "fine", "grain_um", "density")
        return same and rest(self) == rest(other)


# ---- By name -------------------------------------------------------------------------------------


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
"""The thinner of inks: it takes up volume in the brush and on the surface, and evaporates."""


@lru_cache(maxsize=1)
def load_palette() -> Mapping[str, Pigment]:
    """Load the inks and colours to paint with, by name."""
    return load_pigments_csv(_DATA / "palette.csv")


@lru_cache(maxsize=1)
def load_drawdown_paints() -> Mapping[str, Pigment]:
    """Load the oil paints fitted on the drawdowns, by the names used there."""
    return load_pigments_csv(_DATA / "drawdown_paints.csv")


def pigment_names() -> list[str]:
    """List the names of the palette, inks first, as in the table."""
    return list(load_palette())


def load_pigment(name: str, *, own_tables: bool = True) -> Pigment:
    """Return a pigment by its name in the palette, English or Chinese, or a drawdown paint.

    Chinese may be in either script; ``azurite 2`` and ``二青`` are the grade that ``azurite`` is.
    ``water`` is one too; ``FILE.csv:NAME`` is the pigment NAME of a user's own table.

    Parameters
    ----------
    name : str
    own_tables : bool
        Whether the name may refer to a file; not where it comes from somebody else's file.

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
                "the ink {name!r} is of a table on this machine, which a file may not name; "
                "expected an ink of the palette",
                name=name[-100:],
            )
        own, table = name[len(file) + 1 :], load_pigments_csv(file)
        if own not in table:
            raise UnknownNameError(Message("ink of {file}", file=file), own, table)
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


# ---- From the reflectance of an opaque layer -----------------------------------------------------
# For an opaque layer Kubelka-Munk gives K/S = (1 - R)^2 / 2R and nothing about S. We assume one S
# for all wavelengths, scaled so that a full coat hides 98 %: good for pigments that scatter
# strongly (vermilion is missed by 1.5 dE00), bad for dyes and strong blues (Prussian blue by 17).

HIDING = 0.98
"""Luminance of a full coat over black, divided by that over a white chart."""
_CHART = 0.8


def masstone_strengths(reflectance: AnyArray) -> tuple[AnyArray, AnyArray]:
    """K and S (31,) per full coat from the reflectance (31,) of an opaque layer, in (0, 1)."""
    from scipy.optimize import brentq  # a third of a second, and the shipped tables have K and S

    k = (1.0 - reflectance) ** 2 / (2.0 * reflectance)
    s = np.ones_like(k)
    weights = _luminous_efficiency()

    def excess(log_scale: float) -> float:
        scale = np.exp(log_scale)
        black, white = (weights @ _film(k * scale, s * scale, ground) for ground in (0.0, _CHART))
        result: float = black / white - HIDING
        return result

    scale = np.exp(brentq(excess, -12.0, 12.0, xtol=1e-12))
    return k * scale, s * scale


def film_strengths(
    over_white: AnyArray, over_black: AnyArray, white: float, black: float
) -> tuple[AnyArray, AnyArray]:
    """K and S of a film from its reflectance over two grounds, per thickness of the film.

    Parameters
    ----------
    over_white, over_black : (N,) ndarray
        Reflectance of the film over a light and over a dark ground, 0 to 1.
    white, black : float
        Reflectance of those grounds, 0 to 1; white is the lighter.

    Raises
    ------
    PigmentError
        If no film shows so over such grounds, or it hides them, so that S is not to be known.

    Notes
    -----
    With R0 the film's own reflectance and T what it lets through, R = R0 + T^2 g / (1 - R0 g) over
    a ground g: docs/model.md, equations (14) and (15), which two grounds solve for R0 and T.
    """
    with np.errstate(all="ignore"):  # of measurements that belong to no film
        lower = white * (1.0 + over_black * black) - black * (1.0 + over_white * white)
        own = (over_black * white - over_white * black) / lower
        through2 = (over_white - own) * (1.0 - own * white) / white
    possible = (own >= -_NOISE) & (through2 <= (1.0 - own) ** 2 + _NOISE)
    if (over_white < over_black).all():
        raise PigmentError(
            "the film is darker over white than over black; expected W_<nm> over white "
            "and B_<nm> over black"
        )
    hides = over_white - over_black < _SHOWS * (white - black)
    if hides.any():
        worst = int(hides.argmax())
        raise PigmentError(
            "the film hides its ground at {nm:.0f} nm ({light:g} over white, {dark:g} over black); "
            "expected a thinner one, or R_<nm> of a masstone",
            nm=BANDS_NM[worst],
            light=over_white[worst],
            dark=over_black[worst],
        )
    if not possible.all():
        worst = int(possible.argmin())
        raise PigmentError(
            "at {nm:.0f} nm no film is {light:g} over a ground of {white:g} and {dark:g} over one "
            "of {black:g}; expected its reflectance, and those of the grounds",
            nm=BANDS_NM[worst],
            light=over_white[worst],
            dark=over_black[worst],
            white=white,
            black=black,
        )
    own = np.maximum(own, 0.0)
    through2, clear = np.minimum(through2, (1.0 - own) ** 2), own < _DARKEST
    a = np.maximum(1.0, (1.0 + own**2 - through2) / (2.0 * np.maximum(own, _DARKEST)))
    b = np.sqrt(np.maximum(a * a - 1.0, 1e-12))
    s = np.where(clear, 0.0, np.arcsinh(b * own / np.sqrt(through2)) / b)
    k = np.where(clear, -0.5 * np.log(through2), s * (a - 1.0))
    return k, s


def _film(k: AnyArray, s: AnyArray, ground: float) -> AnyArray:
    reflected, alone, through = (np.empty(k.size) for _ in range(3))
    layer_bands(k, s, np.ones_like(k), np.full_like(k, ground), reflected, alone, through)
    return reflected


def _luminous_efficiency() -> AnyArray:
    """CIE 1931 y-bar (31,) by the two-lobe fit of Wyman, Sloan, Shirley (JCGT 2(2), 2013)."""

    def lobe(peak: float, left: float, right: float) -> AnyArray:
        t = (BANDS_NM - peak) * np.where(peak > BANDS_NM, left, right)
        return np.exp(-0.5 * t * t)

    return 0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322)


# ---- Tables --------------------------------------------------------------------------------------
# CSV of K and S by wavelength, or of the reflectance of a masstone.

_NUMBER = re.compile(r"\d+(\.\d*)?|\.\d+")
_DARKEST = 1e-6  # of a reflectance; nothing is as black
_NOISE = 0.002  # of what a film reflects
_SHOWS = 0.005  # of what two grounds differ by, what a film over them differs by at least
_COLUMNS = (
    "name", "chinese", "source", "basis", "licence", "saunderson", "gloss", "fine", "grain_um",
    "density", "white", "black",
)  # fmt: skip
_BAND = re.compile(r"\s*([KSRWB])_(\d+(?:\.\d+)?)\s*")
_KINDS = ("KS", "R", "WB")  # letters of columns that a table has


def load_pigments_csv(path: str | Path) -> Mapping[str, Pigment]:
    """Read a table of pigments, one a row, as a read-only mapping by name.

    Parameters
    ----------
    path : str or Path
        CSV in UTF-8 with a header: ``name``, and either ``K_<nm>`` and ``S_<nm>``, per full coat,
        or ``R_<nm>``, the reflectance of a masstone (see `masstone_strengths`), or ``W_<nm>`` and
        ``B_<nm>``, that of a film, as thick as a full coat, over two grounds, whose reflectance
        ``white`` and ``black`` tell (see `film_strengths`), for rising wavelengths that cover 400
        to 700 nm (others than every 10 nm are interpolated linearly);
        optionally ``chinese``, ``source``, ``basis``, ``licence``, ``saunderson`` (yes|no),
        ``gloss`` (0 to 1), ``fine`` (0 to 1; .12), what goes with the water until pores catch
        it, ``grain_um`` (0 to 1000; 0), the diameter of the other grains, um, and ``density``
        (0.01 to 30, g/cm3), where recipes are mass.
        Or measured masstones as `illuminants` reads them: IES TM-27 (.spdx), and .txt of two
        columns or of X-Rite.

    Raises
    ------
    PigmentError
        Naming file and line, if it cannot be read, holds no pigment, a column is spelt like one of
        these or named by a wavelength and is none, a name is empty or occurs
        twice, the wavelengths do not rise or cover 400-700 nm, K or S is negative, not finite
        or not a number, R is not from 1e-6 to less than 1, gloss or fine are not between 0 and 1,
        grain_um is not between 0 and 1000, or density is not from 0.01 to 30.
    """
    path = Path(path)
    if is_spectral(path):
        return _read_masstones(path)
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            reader = csv.DictReader(stream)
            header = list(reader.fieldnames or [])
            rows = [(reader.line_num, row) for row in reader]
    except (OSError, UnicodeDecodeError, csv.Error) as cause:
        raise PigmentError(
            "{file}: cannot be read as a table of pigments: {cause}", file=path, cause=cause
        ) from None
    if "name" not in header:
        if any(";" in column or "\t" in column for column in header):
            raise PigmentError(
                "{file}:1: has no column 'name'; expected commas between columns", file=path
            )
        raise PigmentError(
            "{file}:1: has no column 'name'; expected a row for each ink: name, and R_400, R_500 "
            "and so on of an opaque layer, or white, black, W_400 .. and B_400 .. of a film over "
            "two grounds, reflectances of 0 to 1",
            file=path,
        )
    nm, columns = _read_bands(header, path)
    pigments: dict[str, Pigment] = {}
    for line, row in rows:
        pigment = _read_row(row, f"{path}:{line}", nm, columns)
        if pigment.name in pigments:
            raise PigmentError(
                "{file}:{line}: {pigment!r} occurs twice",
                file=path,
                line=line,
                pigment=pigment.name,
            )
        pigments[pigment.name] = pigment
    if not pigments:
        raise PigmentError("{file}: holds no pigment; expected at least one row", file=path)
    return MappingProxyType(pigments)


def _read_masstones(path: Path) -> Mapping[str, Pigment]:
    """Make pigments of measured masstones, by their names in the file, or the file's own."""
    try:
        plain = read_plain_spectrum(path) if path.suffix.lower() == ".txt" else None
        spectra = read_spectra(path) if plain is None else {path.stem: plain}
    except InputError as cause:
        raise PigmentError(cause) from None
    pigments = {}
    for name, (nm, values) in spectra.items():
        reflectance = np.interp(BANDS_NM, nm, values)
        if not _DARKEST <= reflectance.min() <= reflectance.max() < 1.0:
            raise PigmentError(
                "{file}: {name!r} is {least:g} to {most:g}; expected the reflectance of a "
                "masstone, {darkest:g} to less than 1",
                file=path,
                name=name,
                least=reflectance.min(),
                most=reflectance.max(),
                darkest=_DARKEST,
            )
        k, s = masstone_strengths(reflectance)
        pigments[name] = Pigment(name, "", K=k, S=s, source=path.name, basis="masstone")
    return MappingProxyType(pigments)


def _read_bands(header: list[str], path: Path) -> tuple[AnyArray, dict[str, list[str]]]:
    """Return wavelengths, and columns by letter, all for the same wavelengths."""
    columns: dict[str, list[str]] = {letter: [] for kind in _KINDS for letter in kind}
    bands: dict[str, list[float]] = {letter: [] for letter in columns}
    for column in header:
        match = _BAND.fullmatch(column)
        if match:
            columns[match[1]].append(column)
            bands[match[1]].append(float(match[2]))
        elif column not in _COLUMNS and (
            re.fullmatch(r"\s*\w+_\d+(\.\d+)?\s*", column)
            or difflib.get_close_matches(column, _COLUMNS, 1, 0.75)
        ):
            raise PigmentError(
                "{file}:1: {column!r} is no column of a table of pigments; expected K_<nm> and "
                "S_<nm>, R_<nm>, or W_<nm> and B_<nm>, {known}",
                file=path,
                column=column,
                known=", ".join(_COLUMNS),
            )
    there = "".join(letter for letter, found in bands.items() if found)
    if there not in _KINDS or any(bands[letter] != bands[there[0]] for letter in there):
        raise PigmentError(
            "{file}:1: has columns {found}; expected K_<nm> and S_<nm> for the same wavelengths, "
            "R_<nm> alone, or W_<nm> and B_<nm> for the same",
            file=path,
            found=", ".join(f"{a}_<nm> ({len(bands[a])})" for a in there) or "for no wavelength",
        )
    nm = bands[there[0]]
    if sorted(set(nm)) != nm:
        raise PigmentError("{file}:1: wavelengths are not in rising order", file=path)
    if nm[0] > BANDS_NM[0] or nm[-1] < BANDS_NM[-1]:
        raise PigmentError(
            "{file}:1: wavelengths are {first:g} to {last:g} nm; expected to cover 400 to 700",
            file=path,
            first=nm[0],
            last=nm[-1],
        )
    return np.array(nm), {a: names for a, names in columns.items() if names}


def _read_row(
    row: dict[str, Any], where: str, nm: AnyArray, columns: dict[str, list[str]]
) -> Pigment:
    spectra = {a: _read_spectrum(row, where, nm, names) for a, names in columns.items()}
    words = {key: (row.get(key) or "").strip() for key in ("name", "chinese", "source", "basis")}
    words["licence"] = (row.get("licence") or "").strip()
    if not words["name"]:
        raise PigmentError("{where}: name is empty", where=where)
    corrected = (row.get("saunderson") or "no").strip().lower()
    if corrected not in ("yes", "no"):
        raise PigmentError(
            "{where}: saunderson is {corrected!r}; expected yes or no",
            where=where,
            corrected=corrected,
        )
    gloss = _read_number(row, where, "gloss", 0.0)
    fine = _read_number(row, where, "fine", USUAL_FINE)
    grain = _read_number(row, where, "grain_um", 0.0, COARSEST_UM)
    weighed = bool((row.get("density") or "").strip())
    density = _read_number(row, where, "density", 0.0, _DENSITIES[1], _DENSITIES[0])
    if "R" in spectra:
        worst = int(np.abs(spectra["R"] - 0.5).argmax())
        if not _DARKEST <= spectra["R"][worst] < 1.0:
            raise PigmentError(
                "{where}: R is {r:g} at {nm:.0f} nm; expected a reflectance from {darkest:g} to "
                "less than 1",
                where=where,
                r=spectra["R"][worst],
                nm=BANDS_NM[worst],
                darkest=_DARKEST,
            )
        if corrected == "yes":
            raise PigmentError(
                "{where}: saunderson is yes; expected no for a masstone",
                where=where,
            )
        strengths = masstone_strengths(spectra["R"])
        words["basis"] = words["basis"] or "masstone"
    elif "W" in spectra:
        if corrected == "yes":
            raise PigmentError("{where}: saunderson is yes; expected no for films", where=where)
        white, black = (_read_number(row, where, ground, -1.0) for ground in ("white", "black"))
        if not 0.0 <= black < white:
            raise PigmentError(
                "{where}: white is {white!r} and black {black!r}; expected the reflectance of the "
                "grounds that the film lies on, 0 to 1, white the lighter",
                where=where,
                white=row.get("white") or "",
                black=row.get("black") or "",
            )
        try:
            strengths = film_strengths(spectra["W"], spectra["B"], white, black)
        except PigmentError as cause:
            raise PigmentError("{where}: {cause}", where=where, cause=cause) from None
        words["basis"] = words["basis"] or "film over white and black"
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
        density=density if weighed else None,
    )


def _read_number(
    row: dict[str, Any],
    where: str,
    name: str,
    usual: float,
    most: float = 1.0,
    least: float = 0.0,
) -> float:
    """Parse a number from `least` to `most`; an empty cell gives `usual`."""
    text = (row.get(name) or "").strip()
    if not text:
        return usual
    if not _NUMBER.fullmatch(text) or not least <= float(text) <= most:
        raise PigmentError(
            "{where}: {name} is {text!r}; expected a number from {least:g} to {most:g}",
            where=where,
            name=name,
            text=text[-40:],
            least=least,
            most=most,
        )
    return float(text)


def _read_spectrum(row: dict[str, Any], where: str, nm: AnyArray, columns: list[str]) -> AnyArray:
    """Parse one letter's columns and interpolate them at `BANDS_NM` (31,)."""
    values = []
    for column in columns:
        try:
            value = float(row[column])
        except (TypeError, ValueError):
            raise PigmentError(
                "{where}: {column} is {row!r}; expected a number",
                where=where,
                column=column,
                row=row[column],
            ) from None
        if not 0.0 <= value < math.inf:
            raise PigmentError(
                "{where}: {column} is {value:g}; expected a finite number of at least 0",
                where=where,
                column=column,
                value=value,
            )
        values.append(value)
    result: AnyArray = np.interp(BANDS_NM, nm, values)
    return result
