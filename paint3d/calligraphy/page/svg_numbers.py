"""Whether the numbers of a drawing's shapes are numbers: what is none is named, not painted over.

Where a width is "nan" or a path breaks off, viewers leave the element out or draw half of it, each
as it likes (SVG 1.1, appendix F.2 only asks that the document be said to be in error).
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator
from xml.etree import ElementTree

from paint3d.errors import InputError

__all__ = ["check_numbers"]

_SHAPES = ("path", "rect", "circle", "ellipse", "line", "polyline", "polygon")
_TAGS = (*_SHAPES, "a", "g", "svg", "switch", "symbol", "use")
_NAMESPACES = ("", "{http://www.w3.org/2000/svg}")
_SIZES = ("width", "height", "r", "stroke-width")
_SHARES = ("opacity", "fill-opacity", "stroke-opacity")
_LENGTHS = (*_SIZES, *_SHARES, "x", "y", "rx", "ry", "cx", "cy", "x1", "y1", "x2", "y2")
_STYLED = ("stroke-width", *_SHARES)
_KEYWORDS = ("auto", "inherit", "initial", "unset", "revert", "none", "medium")
_UNITS = r"(?:px|pt|pc|mm|cm|in|em|ex|rem|ch|q|vw|vh|vmin|vmax|%)?"
_NUMBER = re.compile(r"[+-]?(?:\d++\.?+\d*+|\.\d++)(?:e[+-]?\d++)?+", re.IGNORECASE)
_LENGTH = re.compile(rf"({_NUMBER.pattern})\s*{_UNITS}", re.IGNORECASE)
_ANGLE = rf"{_NUMBER.pattern}(?:px|pt|pc|mm|cm|in|deg|rad|grad|turn|%)?"
_TRANSFORM = re.compile(
    rf"(?:matrix|translate|translatex|translatey|scale|scalex|scaley|rotate|skew|skewx|skewy)\s*"
    rf"\(\s*{_ANGLE}(?:[\s,]+{_ANGLE}|(?=[+.-]){_ANGLE})*\s*\)",
    re.IGNORECASE,
)
_EXPONENT = re.compile(r"[+-]?(?:\d++\.?\d*+|\.\d++)e[+-]?\d++", re.IGNORECASE)
_POINTS = re.compile(rf"(?:[\s,]++|{_NUMBER.pattern})*+", re.IGNORECASE)
_WAY = re.compile(rf"(?:[\s,MZLHVCSQTA]++|{_NUMBER.pattern})*+", re.IGNORECASE)
_SIGNED = re.compile("([MZLHVCSQTA])", re.IGNORECASE)
_COUNTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
_VIEWS = ("svg", "symbol")
_ALIGNED = re.compile(
    r"(?:none|x(?:min|mid|max)y(?:min|mid|max))(?:\s+(?:meet|slice))?", re.IGNORECASE
)
_ARCS = re.compile(  # whose flags may stand before other numbers without anything between
    rf"(?:[\s,]*+(?:{_NUMBER.pattern}[\s,]*+){{3}}(?:[01][\s,]*+){{2}}"
    rf"(?:{_NUMBER.pattern}[\s,]*+){{2}})++",
    re.IGNORECASE,
)
_IMPORTANT = re.compile(r"!\s*important\s*$", re.IGNORECASE)
_CALLS = re.compile(r"\b(?:var|calc|env|min|max|clamp)\(", re.IGNORECASE)
_DECLARED = re.compile(rf"(?:^|[;{{\s])({'|'.join(_STYLED)})\s*:\s*([^;}}]*)", re.IGNORECASE)
_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_SHOWN = 24
_VIEW = "four numbers, the last two of them, its width and height, above 0"
_ALIGNMENT = "none, or xMidYMid and its like, and meet or slice"


def check_numbers(root: ElementTree.Element, name: str) -> None:
    """Refuse a drawing of whose shapes a number is none.

    Parameters
    ----------
    root : Element
        Of the SVG.
    name : str
        What to call it in messages.

    Raises
    ------
    InputError
        Which element and attribute it is, what stands there, and what was expected.
    """
    counts: Counter[str] = Counter()
    for element in root.iter():
        namespace, _, tag = element.tag.rpartition("}")
        tag = tag if f"{namespace}}}" * bool(namespace) in _NAMESPACES else ""
        counts[tag] += 1
        if tag == "style":
            faults = _faults_of_style(element.text or "")
        elif tag in _TAGS:
            faults = _faults(element, tag)
        else:
            continue
        for fault in faults:
            which = element.get("id")
            called = f"{tag} {which!r}" if which else f"{tag} {counts[tag]}"
            raise InputError(f"{name}: {called}: {fault}")


def _faults(element: ElementTree.Element, tag: str) -> Iterator[str]:
    """Which attribute of an element is no number, and what was expected."""
    for attribute, text in element.attrib.items():
        value = text.strip()
        if not value:
            continue  # as if it were not there
        if attribute in _LENGTHS:
            wanted = _fault_of_length(attribute, value)
            if wanted:
                yield f"{attribute} is {value[:_SHOWN]!r}; expected {wanted}"
        elif attribute == "style":
            yield from _faults_of_style(value)
        elif attribute == "transform" and value.lower() not in _KEYWORDS:
            left = _TRANSFORM.sub(_unless_finite, value).strip(", \t\r\n")
            if left:
                yield f"transform has {left[:_SHOWN]!r}; expected transforms of finite numbers"
        elif attribute == "viewBox" and tag in _VIEWS and value.lower() != "none":
            if not _is_view(value):
                yield f"viewBox is {value[:_SHOWN]!r}; expected {_VIEW}"
        elif attribute == "preserveAspectRatio" and tag in _VIEWS:
            if not _ALIGNED.fullmatch(value):
                yield f"preserveAspectRatio is {value[:_SHOWN]!r}; expected {_ALIGNMENT}"
        elif attribute == "points" and tag in ("polyline", "polygon"):
            yield from _faults_of_list(attribute, value, _POINTS, "finite numbers")
        elif attribute == "d" and tag == "path" and value.lower() not in _KEYWORDS:
            yield from _faults_of_list(attribute, value, _WAY, "commands of paths, finite numbers")
            yield from _faults_of_way(value)


def _is_view(value: str) -> bool:
    """Whether a viewBox is four finite numbers, and has an area."""
    words = [word for word in re.split(r"\s*,\s*|\s+", value) if word]
    if len(words) != 4 or not all(_NUMBER.fullmatch(word) for word in words):
        return False
    numbers = [float(word) for word in words]
    return all(map(math.isfinite, numbers)) and min(numbers[2:]) > 0.0


def _faults_of_style(text: str) -> Iterator[str]:
    """The same of declarations."""
    for declared in _DECLARED.finditer(_COMMENT.sub(" ", text)):
        attribute, value = declared[1].lower(), _IMPORTANT.sub("", declared[2]).strip()
        wanted = _fault_of_length(attribute, value) if value else ""
        if wanted:
            yield f"{attribute} is {value[:_SHOWN]!r}; expected {wanted}"


def _fault_of_length(attribute: str, value: str) -> str:
    """What was expected of a length or share that is none; "" where it is one."""
    if value.lower() in _KEYWORDS or _CALLS.match(value):
        return ""
    found = _LENGTH.fullmatch(value)
    expected = "a number" if attribute in _SHARES else "a length"
    if found is None or not math.isfinite(float(found[1])):
        return expected
    return f"{expected}, not less than 0" if attribute in _SIZES and float(found[1]) < 0 else ""


def _faults_of_list(
    attribute: str, text: str, words: re.Pattern[str], expected: str
) -> Iterator[str]:
    """The same of a list: the first word that is neither a finite number nor known."""
    good = words.match(text)
    end = good.end() if good else 0
    numbers = (found[0] for found in _EXPONENT.finditer(text, 0, end))
    bad = next((number for number in numbers if not math.isfinite(float(number))), "")
    bad = bad or re.split(r"[\s,]", text[end : end + _SHOWN])[0]
    if bad:
        yield f"{attribute} has {bad!r}; expected {expected}"


def _faults_of_way(text: str) -> Iterator[str]:
    """Where a path of good words breaks off, or does not begin."""
    before, *parts = _SIGNED.split(text)
    if before.strip() or parts[0] not in "Mm":
        yield f"d has {text[:_SHOWN]!r}; expected M first"
    for command, numbers in zip(parts[::2], parts[1::2], strict=True):
        wanted = _COUNTS[command.upper()]
        n = len(_NUMBER.findall(numbers))
        if wanted and command in "Aa" and _ARCS.fullmatch(numbers):
            continue
        if n % wanted if wanted and n else n != wanted:
            shown = f"{command}{numbers}".strip()[:_SHOWN]
            yield f"d has {shown!r}; expected {wanted} numbers to each {command}"


def _unless_finite(call: re.Match[str]) -> str:
    """A transform whose numbers are not all finite; "" of any other."""
    finite = all(math.isfinite(float(number)) for number in _NUMBER.findall(call[0]))
    return "" if finite else call[0]
