"""Which way each character of a line runs: the levels of Unicode's bidirectional algorithm.

Of UAX #9 all rules are here but those of explicit formatting characters (X1 to X8), which are
passed over, and of paired brackets (N0).
"""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence

__all__ = ["base_level", "levels_of", "visual_order"]

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
    kept = [k for k, kind in enumerate(kinds) if kind != "BN"]
    side = "RL"[base == 0]
    found = _neutral(_weak([kinds[k] for k in kept], side), side)
    levels = [base] * len(text)
    for k, kind in zip(kept, found, strict=True):
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


def _weak(kinds: Sequence[str], side: str) -> list[str]:
    """Numbers, their separators and marks as letters or neutral ones (rules W1 to W7)."""
    found = list(kinds)
    for k, kind in enumerate(found):
        if kind == "NSM":
            found[k] = found[k - 1] if k else side
    strong = side
    for k, kind in enumerate(found):
        if kind in _STRONG:
            strong = kind
        elif kind == "EN" and strong == "AL":
            found[k] = "AN"
    found = ["R" if kind == "AL" else kind for kind in found]
    for k in range(1, len(found) - 1):
        before, after = found[k - 1], found[k + 1]
        if before == after and (
            (found[k] == "ES" and before == "EN") or (found[k] == "CS" and before in ("EN", "AN"))
        ):
            found[k] = before
    for order in (range(len(found)), reversed(range(len(found)))):
        beside = ""
        for k in order:
            if found[k] == "ET" and beside == "EN":
                found[k] = "EN"
            beside = found[k]
    found = ["ON" if kind in ("ES", "ET", "CS") else kind for kind in found]
    strong = side
    for k, kind in enumerate(found):
        if kind in ("L", "R"):
            strong = kind
        elif kind == "EN" and strong == "L":
            found[k] = "L"
    return found


def _neutral(kinds: Sequence[str], side: str) -> list[str]:
    """Neutral ones as what stands on both of their sides, or as the line (rules N1 and N2)."""
    found = list(kinds)
    k = 0
    while k < len(found):
        if found[k] not in _NEUTRAL:
            k += 1
            continue
        end = k
        while end < len(found) and found[end] in _NEUTRAL:
            end += 1
        before = _as_letter(found[k - 1]) if k else side
        after = _as_letter(found[end]) if end < len(found) else side
        found[k:end] = [before if before == after else side] * (end - k)
        k = end
    return found


def _as_letter(kind: str) -> str:
    return "R" if kind in ("EN", "AN") else kind


def visual_order(levels: Sequence[int]) -> list[int]:
    """The places of runs with these levels, from left to right (rule L2)."""
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
