"""Inks as one asks for them in words: one of the palette, a mixture, ink in one of its five tones.

Painters know five tones of one ink, by how much water is in it (mo fen wu se): burnt, thick, heavy,
light and clear. ``light`` is that of pine soot, ``light oil soot`` that of another.
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
    """A tone of ink: what it is called, and how much of it is ink; the rest is water."""

    chinese: str
    share: float


TONES: Mapping[str, Tone] = MappingProxyType({
    "burnt": Tone("焦", 1.0), "thick": Tone("浓", 0.25), "heavy": Tone("重", 0.15),
    "light": Tone("淡", 0.09), "clear": Tone("清", 0.04),
})  # fmt: skip
"""The five tones. Their shares are such that a coat of each on xuan, and the bare paper, lie evenly
apart in lightness (L*); painters' own rules are of words."""

_OTHER_CHINESE = {"濃": "浓"}


def load_ink(text: str, *, own_tables: bool = True) -> dict[Pigment, float]:
    """Return the pigments that an ink in words is made of, and the parts of each.

    Parameters
    ----------
    text : str
        A pigment as `load_pigment` knows it, one of the `TONES`, alone (of pine soot) or before a
        pigment's name, or several of these with their parts:
        ``pine soot:0.2,water:0.8``, ``light oil soot``, ``mine.csv:iron gall:1,water:3``.
    own_tables : bool
        Whether a name may lead to a file. What comes from somebody else's file may not.

    Returns
    -------
    dict
        Parts as they were given, above 0, in the order of the text; one pigment alone has 1.

    Raises
    ------
    UnknownNameError
        If a pigment is not known; the message lists the palette, or the table's names.
    PigmentError
        If a part is no number above 0, or a table cannot be used, or may not be read.
    """
    if not own_tables and names_table(text):
        raise PigmentError(
            f"the ink {text[-100:]!r} is of a table on this machine, which a file "
            "may not name; expected an ink of the palette"
        )
    stirred: dict[Pigment, float] = {}
    for name, parts in split_ink(text):
        for pigment, share in _thinned(name).items():
            stirred[pigment] = stirred.get(pigment, 0.0) + parts * share
    return stirred


def _thinned(name: str) -> dict[Pigment, float]:
    """One pigment by its name, or in one of its tones."""
    try:
        return {load_pigment(name): 1.0}
    except UnknownNameError:
        tone, of = _tone_in(name)
        if tone is None and table_of(name):
            raise
        if tone is None:
            known = [*load_palette(), *TONES, WATER.name]
            raise UnknownNameError("ink", name, known) from None
    pigment = load_pigment(of)
    if tone.share == 1.0 or pigment is WATER:
        return {pigment: 1.0}
    return {pigment: tone.share, WATER: 1.0 - tone.share}


def _tone_in(name: str) -> tuple[Tone | None, str]:
    """The tone that a name begins with, and the pigment's name after it."""
    word, _, of = name.partition(" ")
    if word.lower() in TONES:
        return TONES[word.lower()], of.strip() or _INK
    first = _OTHER_CHINESE.get(name[:1], name[:1])
    for tone in TONES.values():
        if first == tone.chinese:
            of = name[1:].strip()
            return tone, _INK if of in ("", "墨") else of
    return None, name


def tone_names() -> list[str]:
    """Names of the tones, the darkest first."""
    return list(TONES)


def describe_ink(stirred: Mapping[Pigment, float]) -> str:
    """A text that `load_ink` reads back, naming the palette's pigments and no file."""
    if len(stirred) == 1:
        return next(iter(stirred)).name
    return ",".join(f"{pigment.name}:{parts:.6g}" for pigment, parts in stirred.items())
