"""Where a line of text may be broken: at spaces and hyphens, and between ideographs.

Words are kept together. Closing punctuation does not begin a line and opening does not end one.
Scripts that are written without spaces and need a dictionary, such as Thai, are not broken.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence

__all__ = ["break_line", "may_break_after"]

_NOT_FIRST = set(
    "、。，．・：；？！ー」』）］｝〉》〕】〗’”ゝゞ々〻ぁぃぅぇぉっゃゅょァィゥェォッャュョ…‥%‰℃,.:;?!)]}"
)
_NOT_LAST = set("「『（［｛〈《〔【〖‘“([{")
_HYPHENS = set("-‐–—")
_IDEOGRAPHIC_SPACE = "\u3000"


def may_break_after(text: str, k: int) -> bool:
    """Whether a line may end after character k of a text, which has more."""
    here, after = text[k], text[k + 1]
    if unicodedata.category(after).startswith("M") or after == "\u200d" or here == "\u2060":
        return False
    if here in (" ", "\t", _IDEOGRAPHIC_SPACE, "\u200b"):
        return after not in (" ", "\t", _IDEOGRAPHIC_SPACE)
    if here in _HYPHENS:
        return after.isalpha()
    if after in _NOT_FIRST or here in _NOT_LAST or after.isspace():
        return False
    return _is_wide(here) or _is_wide(after)


def _is_wide(character: str) -> bool:
    return unicodedata.east_asian_width(character) in ("W", "F")


def break_line(text: str, advances: Sequence[float], room: float) -> list[str]:
    """Break a text into lines no longer than there is room for, where it can be broken.

    Parameters
    ----------
    text : str
    advances : sequence of float
        Of every character; 0 for all but the first that are drawn as one.
    room : float
        In the unit of the advances.

    Returns
    -------
    list of str
        Without the spaces around the breaks.
    """
    lines, start, end, width, kept = [], 0, 0, 0.0, 0.0
    for k, advance in enumerate(advances):
        width += advance
        inked = width if not text[k].isspace() else kept
        if inked > room and end > start:
            lines.append(text[start:end].strip())
            start = end
            width = sum(advances[start : k + 1])
            inked = width
        kept = inked
        if k + 1 < len(text) and advances[k + 1] > 0.0 and may_break_after(text, k):
            end = k + 1
    lines.append(text[start:].strip())
    return [line for line in lines if line]
