"""From a line of text to positioned glyphs: runs of one script and direction, by HarfBuzz."""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import NamedTuple

from paint3d.calligraphy.fonts.font_file import FontFile
from paint3d.calligraphy.optional_packages import import_optional

__all__ = [
    "DIRECTIONS",
    "ShapedGlyph",
    "Shaper",
    "Style",
    "base_level",
    "levels_of",
    "visual_order",
]

# ---- Directions ----------------------------------------------------------------------------------
# Which way each character of a line runs: the levels of Unicode's bidirectional algorithm.
#
# Of UAX #9 all rules are here but those of explicit formatting characters (X1 to X8), which are
# passed over, and of paired brackets (N0).


_STRONG = {"L": 0, "R": 1, "AL": 1}
_PASSED_OVER = {"LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI", "BN"}
_NEUTRAL = {"B", "S", "WS", "ON"}


def base_level(text: str) -> int:
    """1 where the first letter runs from right to left, else 0 (rules P2 and P3)."""
    kinds = map(unicodedata.bidirectional, text)
    return next((_STRONG[kind] for kind in kinds if kind in _STRONG), 0)


def levels_of(text: str, base: int) -> list[int]:
    """The level of every character of a line: even from left to right, odd from right to left."""
    kinds = [unicodedata.bidirectional(c) or "L" for c in text]
    kinds = ["BN" if kind in _PASSED_OVER else kind for kind in kinds]
    retained = [k for k, kind in enumerate(kinds) if kind != "BN"]
    side = "RL"[base == 0]
    resolved = _resolve_neutral(_resolve_weak([kinds[k] for k in retained], side), side)
    levels = [base] * len(text)
    for k, kind in zip(retained, resolved, strict=True):
        if kind == "R":
            levels[k] = base | 1
        elif kind in ("EN", "AN"):  # numbers run to the right, within what runs to the left
            levels[k] = base + 2 if base % 2 == 0 else base + 1
        else:
            levels[k] = base + base % 2
    for k in range(1, len(text)):
        if kinds[k] == "BN":
            levels[k] = levels[k - 1]
    for k in reversed(range(len(text))):  # rule L1
        if kinds[k] not in ("WS", "B", "S", "BN"):
            break
        levels[k] = base
    return levels


def _resolve_weak(kinds: Sequence[str], side: str) -> list[str]:
    """Resolve numbers, their separators and marks (rules W1 to W7)."""
    resolved = list(kinds)
    for k, kind in enumerate(resolved):
        if kind == "NSM":
            resolved[k] = resolved[k - 1] if k else side
    strong = side
    for k, kind in enumerate(resolved):
        if kind in _STRONG:
            strong = kind
        elif kind == "EN" and strong == "AL":
            resolved[k] = "AN"
    resolved = ["R" if kind == "AL" else kind for kind in resolved]
    for k in range(1, len(resolved) - 1):
        before, after = resolved[k - 1], resolved[k + 1]
        if before == after and (
            (resolved[k] == "ES" and before == "EN")
            or (resolved[k] == "CS" and before in ("EN", "AN"))
        ):
            resolved[k] = before
    for order in (range(len(resolved)), reversed(range(len(resolved)))):
        beside = ""
        for k in order:
            if resolved[k] == "ET" and beside == "EN":
                resolved[k] = "EN"
            beside = resolved[k]
    resolved = ["ON" if kind in ("ES", "ET", "CS") else kind for kind in resolved]
    strong = side
    for k, kind in enumerate(resolved):
        if kind in ("L", "R"):
            strong = kind
        elif kind == "EN" and strong == "L":
            resolved[k] = "L"
    return resolved


def _resolve_neutral(kinds: Sequence[str], side: str) -> list[str]:
    """Resolve neutral characters by both neighbours, or by the line (rules N1 and N2)."""
    resolved = list(kinds)
    k = 0
    while k < len(resolved):
        if resolved[k] not in _NEUTRAL:
            k += 1
            continue
        end = k
        while end < len(resolved) and resolved[end] in _NEUTRAL:
            end += 1
        before = _as_letter(resolved[k - 1]) if k else side
        after = _as_letter(resolved[end]) if end < len(resolved) else side
        resolved[k:end] = [before if before == after else side] * (end - k)
        k = end
    return resolved


def _as_letter(kind: str) -> str:
    return "R" if kind in ("EN", "AN") else kind


def visual_order(levels: Sequence[int]) -> list[int]:
    """The indices of runs with these levels, from left to right (rule L2)."""
    order = list(range(len(levels)))
    for level in range(max(levels, default=0), 0, -1):
        k = 0
        while k < len(order):
            end = k
            while end < len(order) and levels[order[end]] >= level:
                end += 1
            order[k:end] = reversed(order[k:end])
            k = end + 1
    return order


# ---- Shaping -------------------------------------------------------------------------------------


DIRECTIONS = ("ltr", "rtl", "ttb")
_SHARED = ("Zyyy", "Zinh", "Zzzz")  # characters of no script of their own


@dataclass(frozen=True)
class Style:
    """Options of typesetting.

    Attributes
    ----------
    features : mapping
        Features of the font by their tags: 1 or 0, or the number of an alternate.
    direction : {"ltr", "rtl", "ttb"}, optional
        Of the lines; by default as the text begins.
    language : str, optional
        As in BCP 47, such as "ar" or "sr".
    """

    features: Mapping[str, int] = field(default_factory=dict)
    direction: str | None = None
    language: str | None = None


class ShapedGlyph(NamedTuple):
    """A glyph in a line, glyph units.

    Attributes
    ----------
    glyph : int
        Its number in the font.
    cluster : int
        The first character that it stands for.
    x, y : float
        Its origin, from the start of the line on the baseline (in columns: on the middle line).
    advance : float
        To the next one, along the line.
    is_rtl : bool
        Whether it is written from right to left.
    script : str
        As in ISO 15924.
    """

    glyph: int
    cluster: int
    x: float
    y: float
    advance: float
    is_rtl: bool
    script: str


class _Run(NamedTuple):
    start: int
    end: int
    level: int
    script: str


@dataclass(frozen=True, eq=False)
class Shaper:
    """Shapes lines of text in one font and style."""

    font: FontFile
    style: Style

    @property
    def is_vertical(self) -> bool:
        """Return whether lines run down."""
        return self.style.direction == "ttb"

    def is_rtl(self, text: str) -> bool:
        """Return whether a line begins on the right."""
        if self.style.direction is None:
            return base_level(text) == 1
        return self.style.direction == "rtl"

    def shape(self, text: str) -> list[ShapedGlyph]:
        """The glyphs of a line in the order in which they are read.

        A mark follows what it stands on.
        """
        runs = self._split_runs(text)
        order = visual_order([run.level for run in runs])
        shaped: dict[int, list[ShapedGlyph]] = {}
        pen = 0.0
        for k in order:
            shaped[k] = self._shape_run(text, runs[k], pen)
            pen += sum(one.advance for one in shaped[k])
            if runs[k].level % 2:
                shaped[k].reverse()
        return [one for k in range(len(runs)) for one in shaped[k]]

    def advances(self, text: str) -> list[float]:
        """Advance of each character, glyph units; 0 for all but the first of a cluster."""
        advances = [0.0] * len(text)
        for one in self.shape(text):
            advances[one.cluster] += one.advance
        return advances

    def _split_runs(self, text: str) -> list[_Run]:
        levels = [0] * len(text)
        if not self.is_vertical:
            levels = levels_of(text, int(self.is_rtl(text)))
        keys = list(zip(levels, _scripts(text), strict=True))
        runs, start = [], 0
        for (level, script), members in groupby(keys):
            end = start + len(list(members))
            runs.append(_Run(start, end, level, script))
            start = end
        return runs

    def _shape_run(self, text: str, run: _Run, pen: float) -> list[ShapedGlyph]:
        """The glyphs of a run from left to right, or from top to bottom."""
        hb = import_optional("uharfbuzz")
        buffer = hb.Buffer()
        buffer.add_str(text, run.start, run.end - run.start)
        is_rtl = run.level % 2 == 1
        buffer.direction = "ttb" if self.is_vertical else "rtl" if is_rtl else "ltr"
        buffer.script = run.script
        buffer.language = self.style.language or "und"
        hb.shape(self.font.font, buffer, dict(self.style.features))
        scale, shaped = self.font.scale, []
        for info, at in zip(buffer.glyph_infos, buffer.glyph_positions, strict=True):
            advance = scale * (-at.y_advance if self.is_vertical else at.x_advance)
            x, y = (0.0, -pen) if self.is_vertical else (pen, 0.0)
            x, y = x + scale * at.x_offset, y + scale * at.y_offset
            glyph = ShapedGlyph(info.codepoint, info.cluster, x, y, advance, is_rtl, run.script)
            shaped.append(glyph)
            pen += advance
        return shaped


def _scripts(text: str) -> list[str]:
    """The script of every character; those of none take that of what is before, or after."""
    script_of = import_optional("fontTools.unicodedata").script
    scripts = [script_of(c) for c in text]
    for order in (range(1, len(text)), reversed(range(len(text) - 1))):
        for k in order:
            beside = k - 1 if isinstance(order, range) else k + 1
            if scripts[k] in _SHARED and scripts[beside] not in _SHARED:
                scripts[k] = scripts[beside]
    return scripts
