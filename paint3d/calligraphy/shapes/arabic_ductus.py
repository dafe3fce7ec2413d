"""How the letters of the Arabic script are written: the way of the pen through each of their forms.

Letters run from right to left; heads of waw, feh and qaf, meem's and sad's loops go clockwise; a
stem that is joined at its foot (the final alef) goes up, others go down; what is added to a body
(tah's stem, kaf's bar) comes after it, dots come last. These are the ways of M. Sakkal, *Arabic
alphabet chart in naskh style* (sakkal.com). Forms that hands write differently (the joined hah,
meem, heh) are not listed: the shape alone tells their way.

Lines go from 0 to 1 in the box of the letter's body, without its dots: the way from its entry on
the right to its exit on the left, then what is added.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.core.arrays import AnyArray

__all__ = ["PlacedLetter", "body_strokes", "form_of"]

_ALONE, _FIRST, _MIDDLE, _LAST = "alone", "first", "middle", "last"

_TOOTH = {_FIRST: "1,1 .9,.2 .5,0 0,0", _MIDDLE: "1,0 .6,.05 .5,1 .4,.05 0,0"}
_FORMS: dict[str, dict[str, str]] = {
    "اأإآٱ": {_ALONE: ".5,1 .5,0", _LAST: "1,0 .4,.05 .2,.2 .15,1"},
    "بتثپٹ": {
        **_TOOTH,
        _ALONE: "1,1 .97,.35 .8,.05 .4,0 .1,.2 0,.9",
        _LAST: "1,.1 .5,0 .1,.2 0,1",
    },
    "ن": {
        **_TOOTH,
        _ALONE: "1,1 .95,.4 .6,0 .2,.1 0,.6",
        _LAST: "1,.95 .85,.6 .6,0 .2,.1 0,.6",
    },
    "يىئی": {
        **_TOOTH,
        _ALONE: "1,.85 .85,1 .65,.8 .8,.55 1,.4 .8,.1 .4,0 .1,.15 0,.6",
        _LAST: "1,1 .75,.85 .8,.6 1,.4 .7,.02 .3,0 0,.5",
    },
    "جحخچ": {
        _ALONE: "0,.85 .3,1 1,.85 .3,.65 .05,.4 .1,.1 .5,0 1,.15",
        _FIRST: ".1,.85 .45,.95 1,.35 .5,.1 0,0",
    },
    "دذڈ": {
        _ALONE: ".3,1 .8,.7 1,.25 .6,0 0,.05",
        _LAST: "1,.2 .7,.35 .35,1 .75,.3 .5,0 0,.05",
    },
    "رزژ": {_ALONE: ".9,1 1,.5 .6,.1 0,0", _LAST: "1,.95 .85,.6 .5,.1 0,0"},
    "وؤ": {
        _ALONE: ".75,.55 .3,.55 .15,.8 .5,1 .9,.85 1,.5 .6,.1 0,0",
        _LAST: "1,.5 .3,.5 .15,.8 .5,1 .85,.85 .9,.5 .6,.1 0,0",
    },
    "ف": {
        _ALONE: ".95,.5 .75,.5 .7,.8 .85,1 1,.8 1,.3 .8,.05 .3,0 0,.35",
        _FIRST: ".9,.35 .3,.4 .2,.8 .6,1 .95,.8 .9,.2 .5,0 0,0",
        _MIDDLE: "1,0 .3,.1 .1,.6 .5,1 .9,.6 .7,.05 0,0",
        _LAST: "1,.2 .8,.25 .7,.6 .85,1 .97,.7 .9,.15 .3,0 0,.35",
    },
    "ق": {
        _ALONE: ".95,.6 .65,.6 .6,.9 .8,1 1,.85 .95,.3 .6,0 .2,.05 0,.5",
        _FIRST: ".9,.35 .3,.4 .2,.8 .6,1 .95,.8 .9,.2 .5,0 0,0",
        _MIDDLE: "1,0 .3,.1 .1,.6 .5,1 .9,.6 .7,.05 0,0",
        _LAST: "1,.6 .65,.6 .55,.85 .75,1 .92,.85 .85,.3 .5,0 .15,.05 0,.5",
    },
    "صض": {
        _ALONE: ".52,.5 .7,.9 .9,1 1,.8 .85,.5 .5,.45 .5,.6 .48,.3 .35,.02 .1,.05 0,.5",
        _FIRST: ".3,.1 .5,.8 .8,1 1,.6 .8,.05 .25,0 .2,.5 .2,.1 0,0",
        _MIDDLE: "1,0 .3,.05 .5,.8 .8,1 .95,.6 .75,.05 .25,0 .2,.5 .2,.1 0,0",
        _LAST: "1,.45 .52,.48 .65,.9 .85,1 .95,.8 .8,.5 .48,.45 .48,.6 .46,.3 .35,.02 .1,.05 0,.5",
    },
    "طظ": {
        _ALONE: ".2,.05 .45,.45 .8,.5 1,.3 .8,.05 .4,0 0,.02; .25,1 .25,.05",
        _FIRST: ".25,.05 .5,.45 .8,.5 1,.3 .8,.05 .4,0 0,0; .3,1 .3,.05",
        _MIDDLE: "1,0 .3,.05 .5,.45 .8,.5 .95,.3 .8,.05 .4,0 0,0; .3,1 .3,.05",
        _LAST: "1,0 .25,.05 .45,.45 .8,.5 .95,.3 .8,.05 .4,0 0,.02; .25,1 .25,.05",
    },
    "عغ": {
        _ALONE: ".85,.9 .55,1 .3,.85 .45,.68 .9,.65 .3,.5 0,.25 .3,0 1,.1",
        _FIRST: ".95,.85 .6,1 .25,.65 .5,.3 .95,.25 .5,.05 0,0",
        _MIDDLE: "1,0 .55,.3 .1,.9 .9,.9 .45,.3 0,0",
        _LAST: "1,.6 .6,.65 .2,.95 .8,1 .5,.65 .1,.35 .1,.1 .5,0 1,.05",
    },
    "كکگ": {
        _ALONE: ".95,1 1,.2 .8,.02 .3,0 0,.25",
        _FIRST: ".3,.65 .85,.2 .7,0 0,0; 1,1 .3,.65",
        _LAST: "1,.05 .9,.1 .85,1 .88,.1 .6,0 .2,.02 0,.25",
    },
    "ل": {
        _ALONE: ".95,1 .95,.4 .6,0 .2,.05 0,.35",
        _FIRST: ".8,1 .8,.15 .5,0 0,0",
        _MIDDLE: "1,0 .55,.02 .5,1 .45,.02 0,0",
        _LAST: "1,.3 .92,.35 .9,1 .88,.4 .6,0 .2,.05 0,.35",
    },
    "م": {
        _ALONE: ".35,.75 .5,.95 .8,1 1,.8 .8,.6 .35,.65 .1,.5 0,0",
        _FIRST: ".1,.3 .3,.9 .7,1 1,.6 .8,.15 .5,0 0,.1",
    },
    "سش": {
        _ALONE: "1,.9 .98,.6 .85,.55 .82,.8 .8,.6 .65,.55 .62,.8 .6,.5 .45,.05 .15,0 0,.5",
        _FIRST: "1,.9 .95,.1 .75,.05 .65,.8 .55,.05 .4,.1 .3,.9 .2,.05 0,0",
        _MIDDLE: "1,0 .9,.9 .8,.05 .65,.8 .55,.05 .4,.1 .3,.9 .2,.05 0,0",
        _LAST: "1,.5 .95,.85 .9,.5 .8,.5 .77,.8 .74,.5 .63,.5 .6,.8 .57,.4 .45,.05 .15,0 0,.5",
    },
}  # fmt: skip
_BY_LETTER = {letter: forms for letters, forms in _FORMS.items() for letter in letters}
_ENDS = frozenset("اأإآٱدذڈرزژوؤةىء")  # letters that never join the one that follows
_APART = "ء"  # nor does this the one before it


class PlacedLetter(NamedTuple):
    """A letter of a body.

    Attributes
    ----------
    character : str
        Several, where one glyph stands for them.
    form : str
        See `form_of`.
    box : (4,) float64
        Left, lower, right and upper side of its ink without dots.
    """

    character: str
    form: str
    box: NDArray[np.float64]


def form_of(before: str, character: str, after: str) -> str:
    """Whether a letter stands "alone", or "first", in the "middle" or "last" of joined ones.

    Parameters
    ----------
    before, character, after : str
        A letter and its neighbours without marks; "" where there is none.
    """
    joined = bool(before) and before not in _ENDS and character != _APART
    goes_on = bool(after) and character[-1:] not in _ENDS and after != _APART
    if joined:
        return _MIDDLE if goes_on else _LAST
    return _FIRST if goes_on else _ALONE


def body_strokes(letters: Sequence[PlacedLetter]) -> Glyph | None:
    """The way of the pen through a body of joined letters, as they are read.

    Returns
    -------
    Glyph or None
        A stroke through all letters, then what is added to them, in the frame of their boxes;
        a letter that is not listed is gone through straight. None where none is listed.
    """
    way: list[NDArray[np.float64]] = []
    added: list[NDArray[np.float64]] = []
    found = False
    for one in letters:
        listed = _BY_LETTER.get(one.character, {}).get(one.form)
        found = found or listed is not None
        lines = [_placed(line, one.box) for line in (listed or "1,.2 0,.2").split(";")]
        way.append(lines[0])
        added += lines[1:]
    if not found:
        return None
    text = "".join(one.character for one in letters)
    lines = [np.concatenate(way), *added]
    return Glyph(text, tuple(GlyphStroke(np.empty((0, 2)), line) for line in lines))


def _placed(line: str, box: AnyArray) -> NDArray[np.float64]:
    points = np.array([[float(x) for x in point.split(",")] for point in line.split()])
    placed: NDArray[np.float64] = box[:2] + points * (box[2:] - box[:2])
    return placed
