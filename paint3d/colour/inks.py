"""Inks from text: a pigment of the palette, a mixture, or ink in one of its five tones.

Painters distinguish five tones of one ink by the water in it (mo fen wu se): burnt, thick, heavy,
light and clear. ``light`` is light pine soot, ``light oil soot`` that of another ink.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from paint3d.colour.ink_text import names_table, split_ink, table_of
from paint3d.colour.pigments import WATER, Pigment, load_palette, load_pigment
from paint3d.errors import PigmentError, UnknownNameError

__all__ = ["TONES", "Tone", "describe_ink", "load_ink", "tone_names"]

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
        pigment's name, or several of these with their parts:
        ``pine soot:0.2,water:0.8``, ``light oil soot``, ``mine.csv:iron gall:1,water:3``.
    own_tables : bool
        Whether a name may refer to a file; not where the text comes from somebody else's file.

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
    for name, parts in split_ink(text):
        for pigment, fraction in _load_toned(name).items():
            mixture[pigment] = mixture.get(pigment, 0.0) + parts * fraction
    return mixture


def _load_toned(name: str) -> dict[Pigment, float]:
    """Return the fractions of a pigment, and of water where the name begins with a tone."""
    try:
        return {load_pigment(name): 1.0}
    except UnknownNameError:
        tone, ink = _split_tone(name)
        if tone is None and table_of(name):
            raise
        if tone is None:
            known = [*load_palette(), *TONES, WATER.name]
            error = UnknownNameError("ink", name, known)
            if name.startswith("#"):
                error.hint = (
                    f"paint3d inks --nearest {name!r} finds the mixture nearest to a colour"
                )
            raise error from None
    pigment = load_pigment(ink)
    if tone.share == 1.0 or pigment is WATER:
        return {pigment: 1.0}
    return {pigment: tone.share, WATER: 1.0 - tone.share}


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
