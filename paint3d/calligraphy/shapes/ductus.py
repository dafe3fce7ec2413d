"""Order and direction of the strokes of letters that no package of characters knows.

KanjiVG has Latin letters, digits and kana; a Greek or Cyrillic letter of the same shape is written
as the Latin one, and the others are listed here as lines from 0 to 1: stems first, then bows, then
bars.
"""

from __future__ import annotations

import numpy as np

from paint3d.calligraphy.glyph_sources import GlyphSource
from paint3d.calligraphy.glyphs import Glyph, GlyphStroke

__all__ = ["JoinedForm", "known_strokes"]

_ALIKE = dict(
    zip(
        "ΑΒΕΖΗΙΚΜΝΟΡΤΥΧοκνυχρАВЕЗКМНОРСТУХІЈЅаеорсухкіјѕ",
        "ABEZHIKMNOPTYXokvuxpABE3KMHOPCTyXIJSaeopcyxkijs",
        strict=True,
    )
)

_LINES = {
    "ΓГг": "0,1 0,0; 0,1 1,1",
    "Δ": ".5,1 0,0; .5,1 1,0; 0,0 1,0",
    "Θθ": ".5,1 .15,.85 0,.5 .15,.15 .5,0 .85,.15 1,.5 .85,.85 .5,1; .2,.5 .8,.5",
    "ΛЛл": ".5,1 0,0; .5,1 1,0",
    "Ξ": "0,1 1,1; .15,.5 .85,.5; 0,0 1,0",
    "ΠПпπ": "0,1 0,0; 0,1 1,1; 1,1 1,0",
    "Σ": "1,1 0,1 .6,.5 0,0 1,0",
    "ΦФф": ".5,1 .5,0; .5,.8 .15,.7 0,.5 .15,.3 .5,.2; .5,.8 .85,.7 1,.5 .85,.3 .5,.2",
    "Ψψ": "0,1 .05,.55 .25,.38 .5,.33 .75,.38 .95,.55 1,1; .5,1 .5,0",
    "Ω": "0,0 .35,0 .35,.1 .1,.35 .05,.65 .2,.9 .5,1 .8,.9 .95,.65 .9,.35 .65,.1 .65,0 1,0",
    "γ": "0,1 .55,.3 .5,0 .4,.1 .5,.35 1,1",
    "λ": "0,1 .2,1 1,0; .5,.6 0,0",
    "τ": "0,1 1,1; .5,1 .5,.1 .75,0",
    "Б": "0,1 0,0; 0,1 .9,1; 0,.55 .7,.55 1,.3 .7,0 0,0",
    "Дд": ".35,1 .3,.5 .15,.2; .35,1 .85,1 .85,.2; 0,0 0,.2 1,.2 1,0",
    "Жж": "0,1 .5,.5; .5,.5 0,0; .5,1 .5,0; 1,1 .5,.5; .5,.5 1,0",
    "Ии": "0,1 0,0; 0,0 1,1; 1,1 1,0",
    "Йй": "0,.8 0,0; 0,0 1,.8; 1,.8 1,0; .3,1 .5,.92 .7,1",
    "б": "1,1 .4,.9 .1,.6 0,.3 .2,0 .7,0 1,.25 .8,.5 .3,.55 .05,.4",
    "в": "0,1 0,0; 0,1 .7,1 .9,.75 .7,.53 0,.53; .7,.53 1,.3 .7,0 0,0",
    "Цц": "0,1 0,.2; .8,1 .8,.2; 0,.2 1,.2 1,0",
    "Чч": "0,1 0,.6 .3,.4 1,.45; 1,1 1,0",
    "Шш": "0,1 0,0; .5,1 .5,0; 1,1 1,0; 0,0 1,0",
    "Щщ": "0,1 0,.2; .45,1 .45,.2; .9,1 .9,.2; 0,.2 1,.2 1,0",
    "Ъъ": "0,1 .3,1 .3,0; .3,.55 .75,.55 1,.3 .75,0 .3,0",
    "Ыы": "0,1 0,0; 0,.55 .4,.55 .6,.3 .4,0 0,0; 1,1 1,0",
    "Ьь": "0,1 0,0; 0,.55 .7,.55 1,.3 .7,0 0,0",
    "Ээ": "0,.85 .4,1 .85,.8 1,.5 .85,.2 .4,0 0,.15; .35,.5 1,.5",
    "Юю": "0,1 0,0; 0,.5 .35,.5; .68,1 .43,.8 .35,.5 .43,.2 .68,0 .92,.2 1,.5 .92,.8 .68,1",
    "Яя": "1,1 1,0; 1,1 .3,1 .05,.75 .3,.5 1,.5; .5,.5 0,0",
    "з": "0,.9 .5,1 .9,.75 .4,.53; .4,.53 1,.27 .5,0 0,.12",
    "н": "0,1 0,0; 1,1 1,0; 0,.5 1,.5",
    "м": "0,1 0,0; 0,1 .5,.2; 1,1 .5,.2; 1,1 1,0",
    "т": "0,1 1,1; .5,1 .5,0",
}  # fmt: skip
_OWN = {text: lines for letters, lines in _LINES.items() for text in letters}

_ALSO = (
    ("a", ".95,.75 .6,1 .25,.95 0,.6 .05,.2 .35,0 .7,.2 .9,.5; 1,1 .93,.4 1,0"),
    ("E", ".95,.85 .6,1 .25,.92 .15,.7 .45,.53 .65,.52 .35,.5 .05,.32 .1,.08 .45,0 1,.18"),
    ("g", ".9,.8 .6,1 .25,.95 0,.75 .1,.5 .45,.42 .8,.55 .95,.75; 1,1 .9,.5 .75,.15 .4,0 0,.1"),
    ("k", "0,1 0,0 .15,.35 .5,.62 .85,.65 .85,.5 .5,.38 .2,.35; .4,.36 .7,.05 1,0"),
)
"""The a and g with one storey, the round E, and the k of running hands, whose arm is a loop."""

_JOINED = (
    ("a", ".72,.75 .5,1 .2,.95 0,.5 .05,.15 .25,0 .5,.15 .7,.5; .78,.95 .72,.3 .75,.05 .82,0 "
     "1,.35"),
    ("b", ".2,.48 .5,.72 .75,.95 .65,1 .5,.85 .2,.4 .1,.1 .3,0 .55,.1 .65,.28 .48,.42 .4,.25 "
     ".6,.15 .8,.18 1,.32"),
    ("f", ".4,.62 .75,.82 1,1 .85,.98 .6,.8 .3,.4 .03,0 .2,.03 .45,.3 .4,.5 .5,.38 .7,.32 1,.45"),
    ("k", ".22,.5 .5,.75 .65,.95 .55,.98 .2,.45 .03,.05 .12,.2 .4,.42 .65,.42 .7,.3 .42,.2 .5,.05 "
     ".7,.03 1,.25"),
    ("r", "0,.3 .2,.7 .3,1 .27,.82 .45,.68 .5,.45 .37,.15 .52,0 .8,.12 1,.42"),
    ("v", ".1,.8 .08,.3 .15,.03 .35,.15 .6,.55 .7,1; .62,.6 .78,.28 1,.5"),
    ("w", ".15,.9 .03,.4 .08,.08 .25,.25 .45,.95; .45,.95 .38,.4 .42,.05 .6,.2 .75,.6 .8,1; "
     ".75,.62 .87,.35 1,.55"),
)  # fmt: skip
"""Letters of joined hands as they are taught: stems are loops, and all are led out to the right."""


class JoinedForm(Glyph):
    """A letter as joined hands write it: a way so long and loose that it can be bent to much.

    It counts where it lies nearer, by a quarter, than the letters that are set apart.
    """


def known_strokes(source: GlyphSource, text: str) -> tuple[Glyph, ...]:
    """The strokes of a character in each of its forms: a source's, or of a letter alike, or listed.

    Parameters
    ----------
    source : GlyphSource
    text : str
        A single character.

    Returns
    -------
    tuple of Glyph
        None where it is not known. Their lines count, in any frame; listed ones have no outlines.
    """
    forms: list[Glyph] = []
    for known in (text, _ALIKE.get(text, "")):
        if known and source.has(known):
            forms.append(source.load(known))
            break
    if not forms and text in _OWN:
        forms.append(Glyph(text, _listed(_OWN[text])))
    alike = _ALIKE.get(text, text)
    forms += [Glyph(text, _listed(lines)) for letter, lines in _ALSO if letter == alike]
    forms += [JoinedForm(text, _listed(lines)) for letter, lines in _JOINED if letter == alike]
    return tuple(forms)


def _listed(lines: str) -> tuple[GlyphStroke, ...]:
    """The strokes of lines that are written as points "x,y x,y; x,y x,y"."""
    strokes = [
        np.array([[float(x) for x in point.split(",")] for point in line.split()])
        for line in lines.split(";")
    ]
    return tuple(GlyphStroke(np.empty((0, 2)), line) for line in strokes)
