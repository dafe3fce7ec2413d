"""Lengths of a drawing in its own numbers: percentages and those that are counted by a font's size.

A percentage is of the side of the view that it runs along, of a radius or a stroke's width of the
view's diagonal over the root of two (SVG 1.1, 7.10); em and ex are of the size of the element's
font, ex of half of it, rem of the drawing's. The package that reads drawings takes both otherwise.
"""

from __future__ import annotations

import math
import re
from typing import NamedTuple
from xml.etree.ElementTree import Element

from paint3d.calligraphy.page.svg_clips import SHAPES, tag_of

__all__ = ["in_numbers"]

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?"
_LENGTH = re.compile(rf"\s*({_NUMBER})\s*([a-z]*|%)\s*", re.IGNORECASE)
_PIXELS = {"": 1.0, "px": 1.0, "pt": 96 / 72, "pc": 16.0, "in": 96.0, "cm": 96 / 2.54}
_PIXELS |= {"mm": 96 / 25.4, "q": 96 / 101.6}
_ACROSS = ("x", "width", "cx", "rx", "x1", "x2")
_DOWN = ("y", "height", "cy", "ry", "y1", "y2")
_DIAGONAL = ("r", "stroke-width")
_STYLED = re.compile(r"(stroke-width\s*:\s*)([^;!]*)", re.IGNORECASE)
_FONT = re.compile(r"(?:^|;)\s*font-size\s*:\s*([^;!]*)", re.IGNORECASE)
_SIDE = 1000.0  # of a drawing that says none
_MEDIUM = 16.0  # px: a font whose size is not said
_SIZES = {"xx-small": 0.6, "x-small": 0.75, "small": 8 / 9, "medium": 1.0, "large": 1.2}
_SIZES |= {"x-large": 1.5, "xx-large": 2.0}
_STEPS = {"smaller": 1 / 1.2, "larger": 1.2}
_VIEWS = ("svg",)
_COUNTED = (*SHAPES, *_VIEWS, "g", "a", "use", "switch", "clipPath", "defs")


class _Context(NamedTuple):
    """The view that an element is in, and its font's size, in numbers of the drawing."""

    width: float
    height: float
    font: float
    root: tuple[float, float, float]  # of the drawing: width, height, font


def in_numbers(root: Element) -> None:
    """Write the lengths of a drawing's elements as plain numbers, where they are relative.

    Parameters
    ----------
    root : Element
        Changed in place; its own width and height stay.
    """
    font = _font_size(root, _MEDIUM, _MEDIUM)
    sides = _view_of(root, _SIDE, _SIDE, font)
    context = _Context(*sides, font, (*sides, font))
    stack = [(child, context) for child in root]
    while stack:
        element, context = stack.pop()
        tag = tag_of(element)
        if tag not in _COUNTED:
            continue
        context = context._replace(font=_font_size(element, context.font, context.root[2]))
        for names in (_ACROSS, _DOWN, _DIAGONAL):
            for name in names:
                if name in element.attrib:
                    element.set(name, _resolve_length(element.get(name, ""), name, context))
        if "style" in element.attrib:
            element.set("style", _resolve_width(element.get("style", ""), context))
        if tag in _VIEWS:
            width, height = _view_of(element, context.width, context.height, context.font)
            context = context._replace(width=width, height=height)
        stack += [(child, context) for child in element]


def _resolve_width(style: str, context: _Context) -> str:
    """A style whose width of strokes is a number, if it was a relative one."""
    return _STYLED.sub(
        lambda match: match[1] + _resolve_length(match[2], "stroke-width", context), style
    )


def _resolve_length(text: str, name: str, context: _Context) -> str:
    """A length as a number, if it is a relative one; as it is where not."""
    match = _LENGTH.fullmatch(text)
    unit = match[2].lower() if match else ""
    if match is None or unit in _PIXELS:
        return text
    number = float(match[1])
    unit_length = _unit_length(unit, name, context)
    return text if unit_length is None else repr(number * unit_length)


def _unit_length(unit: str, name: str, context: _Context) -> float | None:
    """Length of 1 of a relative unit."""
    if unit == "%":
        return 0.01 * _reference_side(name, context.width, context.height)
    width, height, font = context.root
    return {
        "em": context.font,
        "ex": 0.5 * context.font,
        "ch": 0.5 * context.font,
        "rem": font,
        "vw": 0.01 * width,
        "vh": 0.01 * height,
        "vmin": 0.01 * min(width, height),
        "vmax": 0.01 * max(width, height),
    }.get(unit)


def _reference_side(name: str, width: float, height: float) -> float:
    if name in _ACROSS:
        return width
    return height if name in _DOWN else math.hypot(width, height) / math.sqrt(2.0)


def _view_of(element: Element, width: float, height: float, font: float) -> tuple[float, float]:
    """Width and height of the view that a drawing opens, within one of these sides."""
    words = re.split(r"[\s,]+", element.get("viewBox", "").strip())
    if len(words) == 4 and all(re.fullmatch(_NUMBER, word, re.IGNORECASE) for word in words):
        return float(words[2]), float(words[3])
    sides = []
    for name, whole in (("width", width), ("height", height)):
        match = _LENGTH.fullmatch(element.get(name, "100%"))
        unit = match[2].lower() if match else ""
        number = float(match[1]) if match else 0.0
        factor = {"%": 0.01 * whole, "em": font, "ex": 0.5 * font}.get(unit, _PIXELS.get(unit))
        sides.append(number * factor if factor is not None and number > 0.0 else whole)
    return sides[0], sides[1]


def _font_size(element: Element, inherited: float, root: float) -> float:
    styled = _FONT.search(element.get("style", ""))
    text = (styled[1] if styled else element.get("font-size", "")).strip().lower()
    if text in _SIZES:
        return _MEDIUM * _SIZES[text]
    if text in _STEPS:
        return inherited * _STEPS[text]
    match = _LENGTH.fullmatch(text)
    if match is None:
        return inherited
    factor = {"%": 0.01 * inherited, "em": inherited, "ex": 0.5 * inherited, "rem": root}
    size = float(match[1]) * factor.get(match[2], _PIXELS.get(match[2], 0.0))
    return size if size > 0.0 else inherited
