"""Inks from text: pigments of the palette, mixtures, ink in one of its five tones, kept inks.

Painters distinguish five tones of one ink by the water in it (mo fen wu se): burnt, thick, heavy,
light and clear. ``light`` is light pine soot, ``light oil soot`` that of another ink.

Mixtures can be kept by name among the user's settings: ``inks.toml`` has a line for each,
``"deep teal" = {"indigo" = 0.8, "water" = 0.2}``.
"""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from paint3d.colour.ink_text import names_table, split_ink, table_of
from paint3d.colour.pigments import WATER, Pigment, load_palette, load_pigment
from paint3d.core.atomic import write_atomically
from paint3d.core.own_folders import config_folder, make_private_folder, usual_config_folder
from paint3d.errors import PigmentError, UnknownNameError

__all__ = [
    "TONES",
    "Tone",
    "describe_ink",
    "forget_ink",
    "keep_ink",
    "kept_inks",
    "load_ink",
    "tone_names",
]

_INK = "pine soot"


class Tone(NamedTuple):
    """A tone of ink: its Chinese name and the fraction that is ink; the rest is water."""

    chinese: str
    share: float


TONES: Mapping[str, Tone] = MappingProxyType({
    "burnt": Tone("焦", 1.0), "thick": Tone("浓", 0.25), "heavy": Tone("重", 0.15),
    "light": Tone("淡", 0.09), "clear": Tone("清", 0.04),
})  # fmt: skip
"""The five tones. Their fractions space a coat of each on xuan, and the bare paper, evenly in
lightness (L*); painters give no numbers."""

_OTHER_CHINESE = {"濃": "浓"}


def load_ink(text: str, *, own_tables: bool = True) -> dict[Pigment, float]:
    """Return the pigments of an ink written as text, and the parts of each.

    Parameters
    ----------
    text : str
        A pigment as `load_pigment` knows it, one of the `TONES`, alone (of pine soot) or before a
        pigment's name, one of `kept_inks`, or several of these with their parts:
        ``pine soot:0.2,water:0.8``, ``light oil soot``, ``mine.csv:iron gall:1,water:3``.
    own_tables : bool
        Whether a name may refer to a file or a kept ink; not where the text comes from somebody
        else's file.

    Returns
    -------
    dict
        Parts as given, above 0, in the order of the text; one pigment alone has 1.

    Raises
    ------
    UnknownNameError
        If a pigment is unknown; the message lists the palette, or the table's names.
    PigmentError
        If a part is not a number above 0, or a table cannot be used, or may not be read.
    """
    if not own_tables and names_table(text):
        raise PigmentError(
            "the ink {text!r} is of a table on this machine, which a file may not name; expected "
            "an ink of the palette",
            text=text[-100:],
        )
    mixture: dict[Pigment, float] = {}
    for name, parts in _resolve(text, own_tables).items():
        pigment = load_pigment(name)
        mixture[pigment] = mixture.get(pigment, 0.0) + parts
    return mixture


def _resolve(text: str, own_tables: bool) -> dict[str, float]:
    """Return the parts of an ink by the names that `load_pigment` has for its pigments."""
    mixture: dict[str, float] = {}
    for name, parts in split_ink(text):
        for pigment, fraction in _resolve_toned(name, own_tables).items():
            mixture[pigment] = mixture.get(pigment, 0.0) + parts * fraction
    return mixture


def _resolve_toned(name: str, own_tables: bool, within: tuple[str, ...] = ()) -> dict[str, float]:
    """Return the fractions of an ink, and of water where the name begins with a tone."""
    tone, ink = _split_tone(name)
    kept: Mapping[str, Mapping[str, float]] = {}
    for is_kept in (False, True)[: 1 + own_tables]:  # read only for what the program does not know
        kept = kept_inks() if is_kept else kept
        for one, share in ((name, 1.0), (ink, 1.0 if tone is None else tone.share)):
            stirred = _resolve_named(one, kept, within)
            if stirred is not None:
                is_water = set(stirred) == {WATER.name}
                return stirred if is_water or share == 1.0 else _thin(stirred, share)
    error = UnknownNameError("ink", ink, [*load_palette(), *TONES, WATER.name, *kept])
    error.hint = (
        f"paint3d inks --nearest {name!r} finds the mixture nearest to a colour"
        if name.startswith("#")
        else "an ink of a table is FILE.csv:NAME, or kept by its name: paint3d inks --ink "
        "FILE.csv:NAME --keep NAME"
    )
    raise error


def _resolve_named(
    name: str, kept: Mapping[str, Mapping[str, float]], within: tuple[str, ...]
) -> dict[str, float] | None:
    """Return the fractions of a pigment, or of a kept ink that is not mixed of itself."""
    if table_of(name):
        return {name: 1.0}
    try:
        return {load_pigment(name).name: 1.0}
    except UnknownNameError:
        if name not in kept or name in within:
            return None
    parts = kept[name]
    whole = sum(parts.values())
    mixture: dict[str, float] = {}
    for part, weight in parts.items():
        for pigment, fraction in _resolve_toned(part, True, (*within, name)).items():
            mixture[pigment] = mixture.get(pigment, 0.0) + weight / whole * fraction
    return mixture


def _thin(stirred: Mapping[str, float], share: float) -> dict[str, float]:
    """Return an ink of which this share is left, the rest being water."""
    thinned = {pigment: share * fraction for pigment, fraction in stirred.items()}
    thinned[WATER.name] = thinned.get(WATER.name, 0.0) + 1.0 - share
    return thinned


def _split_tone(name: str) -> tuple[Tone | None, str]:
    """Return the tone that a name begins with, and the pigment's name after it."""
    word, _, ink = name.partition(" ")
    if word.lower() in TONES:
        return TONES[word.lower()], ink.strip() or _INK
    first = _OTHER_CHINESE.get(name[:1], name[:1])
    for tone in TONES.values():
        if first == tone.chinese:
            ink = name[1:].strip()
            return tone, _INK if ink in ("", "墨") else ink
    return None, name


def tone_names() -> list[str]:
    """Names of the tones, the darkest first."""
    return list(TONES)


def describe_ink(stirred: Mapping[Pigment, float]) -> str:
    """Return a text that `load_ink` reads back; it names pigments without their files."""
    if len(stirred) == 1:
        return next(iter(stirred)).name
    return ",".join(f"{pigment.name}:{parts:.6g}" for pigment, parts in stirred.items())


# ---- Kept inks -----------------------------------------------------------------------------------

_FILE = "inks.toml"
_LONGEST = 60  # letters of a name


def kept_inks() -> Mapping[str, Mapping[str, float]]:
    """Return the mixtures that are kept: parts of each by the names of inks, by its own name.

    Raises
    ------
    PigmentError
        If their file is there and cannot be used.
    """
    path = config_folder() / _FILE
    usual = usual_config_folder()  # of a home that can be read, but not written
    if usual is not None and not path.is_file():
        path = usual / _FILE
    try:
        inks = tomllib.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError):
        return {}
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as cause:
        raise PigmentError(
            "{file}: cannot be read as a list of inks: {cause}", file=path, cause=cause
        ) from None
    for name, parts in inks.items():
        if not (isinstance(parts, dict) and parts and all(map(_is_part, parts.values()))):
            raise PigmentError(
                "{file}: {name!r} is {parts!r:.60}; expected the parts of an ink such as "
                "{{indigo = 0.8, water = 0.2}}",
                file=path,
                name=name,
                parts=parts,
            )
    return inks


def keep_ink(name: str, text: str) -> Path:
    """Keep an ink under a name, in the place of one of that name; return the file.

    Parameters
    ----------
    name : str
        1 to 60 letters without ``,``, ``:`` and ``#``, and not the name of an ink there is.
    text : str
        As `load_ink` reads it; tables are kept by their whole paths.

    Raises
    ------
    PigmentError
        If the name is none for an ink, or the ink cannot be loaded.
    UnknownNameError
        If the text names an ink that is not known.
    ExportError
        If the file cannot be written.
    """
    is_name = 0 < len(name) <= _LONGEST and name.isprintable() and name == name.strip()
    if not is_name or set(name) & set(",:#") or names_table(name + ":") or _is_taken(name):
        raise PigmentError(
            "{name!r:.80} cannot be the name of an ink; expected 1 to {most} letters without ',', "
            "':' and '#', and not the name of an ink that comes with the program",
            name=name,
            most=_LONGEST,
        )
    load_ink(text)
    parts = {}
    for pigment, weight in _resolve(text, own_tables=True).items():
        file = table_of(pigment)
        whole = "" if file is None else str(Path(file).absolute())
        parts[whole + pigment[len(file or "") :]] = weight
    return _write_kept({**kept_inks(), name: parts})


def forget_ink(name: str) -> Path:
    """Forget an ink that is kept; return the file.

    Raises
    ------
    UnknownNameError
        If there is none of that name.
    ExportError
        If the file cannot be written.
    """
    inks = dict(kept_inks())
    if inks.pop(name, None) is None:
        raise UnknownNameError("kept ink", name, inks)
    return _write_kept(inks)


def _is_part(value: object) -> bool:
    if not isinstance(value, int | float) or isinstance(value, bool):
        return False
    return math.isfinite(value) and value > 0.0


def _is_taken(name: str) -> bool:
    known = {one.casefold() for one in (*load_palette(), *TONES, WATER.name)}
    if name.casefold() in known:
        return True
    try:
        load_ink(name, own_tables=False)
    except (PigmentError, UnknownNameError):
        return False
    return True


def _write_kept(inks: Mapping[str, Mapping[str, float]]) -> Path:
    folder = config_folder()
    with suppress(OSError):  # what cannot be written says so
        make_private_folder(folder)
    with write_atomically(folder / _FILE) as path:
        lines = []
        for name, parts in inks.items():
            said = ", ".join(f"{_quoted(ink)} = {part:.6g}" for ink, part in parts.items())
            lines.append(f"{_quoted(name)} = {{{said}}}\n")
        path.write_text("".join(lines), encoding="utf-8")
    return folder / _FILE


def _quoted(text: str) -> str:
    """Return a string as TOML writes it, which is as JSON does."""
    return json.dumps(text, ensure_ascii=False)
