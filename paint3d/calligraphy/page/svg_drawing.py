"""An SVG drawing as a page: what is filled is taken apart into strokes, what is stroked is one.

Ink is ink: of colours only white counts, as paper that covers what lies below it. Elements whose
boxes overlap are laid as one, so that they lie on the object as they do on the page; they are one
piece as far as they follow each other in the document, whose order is that of the strokes.
"""

from __future__ import annotations

import logging
import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from io import BytesIO
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from paint3d.calligraphy.glyphs import EM_UNITS, Box, Glyph, GlyphStroke
from paint3d.calligraphy.optional_packages import import_optional
from paint3d.calligraphy.page.bands import fill_in_bands, is_wide
from paint3d.calligraphy.page.page import (
    Page,
    Piece,
    as_multipolygon,
    bounds_of,
    fill_rings,
    polygons_of,
)
from paint3d.calligraphy.page.svg_clips import (
    CLIPS,
    HREFS,
    SHAPES,
    elements_by_id,
    mark_clipped,
    reference_of,
    tag_like,
    tag_of,
)
from paint3d.calligraphy.page.svg_lengths import in_numbers
from paint3d.calligraphy.shapes.decompose import decompose, thinnest_within
from paint3d.core.arrays import AnyArray
from paint3d.core.foreign_xml import XmlFault, parse_xml
from paint3d.core.polyline import arc_lengths, bezier_points, interpolate
from paint3d.errors import InputError, Message

if TYPE_CHECKING:
    from shapely import MultiPolygon

__all__ = ["load_svg", "svg_shape"]

# ---- Numbers -------------------------------------------------------------------------------------
# The numbers of a drawing's shapes are checked: what is none is named, not painted over.
#
# Where a width is "nan" or a path breaks off, viewers leave the element out or draw half of it,
# each as it likes (SVG 1.1, appendix F.2 only asks that the document be said to be in error).


_TAGS = (*SHAPES, "a", "g", "svg", "switch", "symbol", "use")
_NAMESPACES = ("", "{http://www.w3.org/2000/svg}")
_SIZE_NAMES = ("width", "height", "r", "stroke-width")
_FRACTIONS = ("opacity", "fill-opacity", "stroke-opacity")
_LENGTHS = (*_SIZE_NAMES, *_FRACTIONS, "x", "y", "rx", "ry", "cx", "cy", "x1", "y1", "x2", "y2")
_STYLED = ("stroke-width", *_FRACTIONS)
_KEYWORDS = ("auto", "inherit", "initial", "unset", "revert", "none", "medium")
_UNITS = r"(?:px|pt|pc|mm|cm|in|em|ex|rem|ch|q|vw|vh|vmin|vmax|%)?"
# Possessive quantifiers (++, *+, ?+): on a stranger's megabytes a match must not backtrack.
_NUMBER = re.compile(r"[+-]?(?:\d++\.?+\d*+|\.\d++)(?:e[+-]?\d++)?+", re.IGNORECASE)
_LENGTH = re.compile(rf"({_NUMBER.pattern})\s*{_UNITS}", re.IGNORECASE)
_ANGLE = rf"{_NUMBER.pattern}(?:px|pt|pc|mm|cm|in|deg|rad|grad|turn|%)?"
_TRANSFORM = re.compile(  # one call; a sign or point may stand for the comma: rotate(1-2.5.5)
    rf"(?:matrix|translate|translatex|translatey|scale|scalex|scaley|rotate|skew|skewx|skewy)\s*"
    rf"\(\s*{_ANGLE}(?:[\s,]+{_ANGLE}|(?=[+.-]){_ANGLE})*\s*\)",
    re.IGNORECASE,
)
# Only a number with an exponent is checked for overflow: 1e999 is infinite as a float.
_EXPONENT = re.compile(r"[+-]?(?:\d++\.?\d*+|\.\d++)e[+-]?\d++", re.IGNORECASE)
_POINTS = re.compile(rf"(?:[\s,]++|{_NUMBER.pattern})*+", re.IGNORECASE)
_PATH_DATA = re.compile(rf"(?:[\s,MZLHVCSQTA]++|{_NUMBER.pattern})*+", re.IGNORECASE)
_SIGNED = re.compile("([MZLHVCSQTA])", re.IGNORECASE)  # splits path data by its commands
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
_CALLS = re.compile(r"\b(?:var|calc|env|min|max|clamp)\(", re.IGNORECASE)  # not evaluated here
_DECLARED = re.compile(rf"(?:^|[;{{\s])({'|'.join(_STYLED)})\s*:\s*([^;}}]*)", re.IGNORECASE)
_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_SHOWN = 24
_VIEW = Message("four numbers, the last two of them, its width and height, above 0")
_ALIGNMENT = Message("none, or xMidYMid and its like, and meet or slice")


def _check_numbers(root: ElementTree.Element, name: str) -> None:
    """Refuse a drawing if a number of its shapes is malformed or not finite.

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
            faults = _find_faults(element, tag)
        else:
            continue
        for fault in faults:
            which = element.get("id")
            called = f"{tag} {which!r}" if which else f"{tag} {counts[tag]}"
            raise InputError("{name}: {called}: {fault}", name=name, called=called, fault=fault)


def _find_faults(element: ElementTree.Element, tag: str) -> Iterator[Message]:
    """Yield a message for each attribute that is no number, with what was expected."""
    for attribute, text in element.attrib.items():
        value = text.strip()
        if not value:
            continue  # as if it were not there
        if attribute in _LENGTHS:
            wanted = _fault_of_length(attribute, value)
            if wanted:
                yield _fault(attribute, value, wanted)
        elif attribute == "style":
            yield from _faults_of_style(value)
        elif attribute == "transform" and value.lower() not in _KEYWORDS:
            left = _TRANSFORM.sub(_find_infinite, value).strip(", \t\r\n")
            if left:
                yield _fault_within(attribute, left, Message("transforms of finite numbers"))
        elif attribute == "viewBox" and tag in _VIEWS and value.lower() != "none":
            if not _is_view(value):
                yield _fault(attribute, value, _VIEW)
        elif attribute == "preserveAspectRatio" and tag in _VIEWS:
            if not _ALIGNED.fullmatch(value):
                yield _fault(attribute, value, _ALIGNMENT)
        elif attribute == "points" and tag in ("polyline", "polygon"):
            yield from _faults_of_list(attribute, value, _POINTS, Message("finite numbers"))
        elif attribute == "d" and tag == "path" and value.lower() not in _KEYWORDS:
            yield from _faults_of_list(
                attribute, value, _PATH_DATA, Message("commands of paths, finite numbers")
            )
            yield from _faults_of_path(value)


def _is_view(value: str) -> bool:
    """Return whether a viewBox is four finite numbers, and has an area."""
    words = [word for word in re.split(r"\s*,\s*|\s+", value) if word]
    if len(words) != 4 or not all(_NUMBER.fullmatch(word) for word in words):
        return False
    numbers = [float(word) for word in words]
    return all(map(math.isfinite, numbers)) and min(numbers[2:]) > 0.0


def _fault(attribute: str, value: str, wanted: Message) -> Message:
    return Message(
        "{attribute} is {value!r}; expected {wanted}",
        attribute=attribute,
        value=value[:_SHOWN],
        wanted=wanted,
    )


def _fault_within(attribute: str, part: str, wanted: Message) -> Message:
    return Message(
        "{attribute} has {part!r}; expected {wanted}",
        attribute=attribute,
        part=part[:_SHOWN],
        wanted=wanted,
    )


def _faults_of_style(text: str) -> Iterator[Message]:
    """Yield the faults of the lengths and fractions among a style's declarations."""
    for declared in _DECLARED.finditer(_COMMENT.sub(" ", text)):
        attribute, value = declared[1].lower(), _IMPORTANT.sub("", declared[2]).strip()
        wanted = _fault_of_length(attribute, value) if value else None
        if wanted:
            yield _fault(attribute, value, wanted)


def _fault_of_length(attribute: str, value: str) -> Message | None:
    """The value expected for a malformed length or fraction; None of a well formed one."""
    if value.lower() in _KEYWORDS or _CALLS.match(value):
        return None
    match = _LENGTH.fullmatch(value)
    expected = Message("a number") if attribute in _FRACTIONS else Message("a length")
    if match is None or not math.isfinite(float(match[1])):
        return expected
    if attribute in _SIZE_NAMES and float(match[1]) < 0:
        return Message("{what}, not less than 0", what=expected)
    return None


def _faults_of_list(
    attribute: str, text: str, words: re.Pattern[str], expected: Message
) -> Iterator[Message]:
    """Fault of a list: its first word that is neither a finite number nor known."""
    good = words.match(text)
    end = good.end() if good else 0
    numbers = (match[0] for match in _EXPONENT.finditer(text, 0, end))
    bad = next((number for number in numbers if not math.isfinite(float(number))), "")
    bad = bad or re.split(r"[\s,]", text[end : end + _SHOWN])[0]
    if bad:
        yield _fault_within(attribute, bad, expected)


def _faults_of_path(text: str) -> Iterator[Message]:
    """Yield a fault where a path of good words breaks off, or does not begin."""
    before, *parts = _SIGNED.split(text)
    if before.strip() or parts[0] not in "Mm":
        yield _fault_within("d", text, Message("M first"))
    for command, numbers in zip(parts[::2], parts[1::2], strict=True):
        wanted = _COUNTS[command.upper()]
        n = len(_NUMBER.findall(numbers))
        if wanted and command in "Aa" and _ARCS.fullmatch(numbers):
            continue
        if n % wanted if wanted and n else n != wanted:
            shown = f"{command}{numbers}".strip()[:_SHOWN]
            yield _fault_within(
                "d", shown, Message("{n} numbers to each {command}", n=wanted, command=command)
            )


def _find_infinite(call: re.Match[str]) -> str:
    """A transform whose numbers are not all finite; "" of any other."""
    finite = all(math.isfinite(float(number)) for number in _NUMBER.findall(call[0]))
    return "" if finite else call[0]


# ---- What is refused -----------------------------------------------------------------------------
# What is refused of an SVG before it is read: entities, what lies outside of it, endless uses.


_MOST_DEPTH = 200
_MOST_ELEMENTS = 100_000
# A reference to another file or page: url(...) but for url(#id), or @import.
_OUTSIDE = re.compile(r"""url\(\s*['"]?(?!['"]?\s*#)([^)'"]*)|@import\s+([^;]*)""", re.IGNORECASE)


def _check_svg(data: bytes, name: str) -> ElementTree.Element:
    """Refuse an SVG from strangers that declares entities, refers outside of itself, or explodes.

    Parameters
    ----------
    data : bytes
    name : str
        What to call it in messages.

    Returns
    -------
    Element
        Its root.

    Raises
    ------
    InputError
        Which of these it is, or that it is no SVG.
    """
    try:
        root = parse_xml(data, _MOST_DEPTH, doctypes=True)
    except XmlFault as fault:
        raise InputError(
            "{name}:{line}: {what}; expected a plain SVG",
            name=name,
            line=fault.line,
            what=fault.what,
        ) from None
    if tag_of(root) != "svg":
        raise InputError(
            "{name}: the outermost element is {tag!r}; expected svg",
            name=name,
            tag=root.tag,
        )
    for element in root.iter():
        for href in filter(None, map(element.get, HREFS)):
            tag = tag_of(element)
            if not href.startswith("#") and tag != "a":
                raise _external_references(name, href)
        for text in (element.text or "", *element.attrib.values()):
            outside = _OUTSIDE.search(text)
            if outside:
                raise _external_references(name, outside[1] or outside[2])
    _check_size(root, name)
    return root


def _external_references(name: str, reference: str) -> InputError:
    return InputError(
        "{name}: refers to {reference!r} outside of itself; expected a drawing that holds all that "
        "it shows",
        name=name,
        reference=reference[:60].strip(),
    )


def _check_size(root: ElementTree.Element, name: str) -> None:
    """Refuse a drawing with too many elements once what it uses stands in its place."""
    named = elements_by_id(root)
    sizes: dict[ElementTree.Element, int] = {}
    open_now: set[ElementTree.Element] = set()

    def size(element: ElementTree.Element) -> int:
        if element in open_now:
            raise InputError(
                "{name}: {id!r} refers to itself; expected no cycle of references",
                name=name,
                id=element.get("id"),
            )
        if element not in sizes:
            open_now.add(element)
            total = 1 + sum(size(child) for child in element)
            if tag_of(element) == "use":
                used = named.get(reference_of(element))
                total += 0 if used is None else size(used)
            open_now.discard(element)
            sizes[element] = total
        return sizes[element]

    try:
        n = size(root)
    except RecursionError:
        raise InputError("{name}: its uses are nested too deep", name=name) from None
    if n > _MOST_ELEMENTS:
        raise InputError(
            "{name}: {n:,} elements; expected {most:,} at most",
            name=name,
            n=n,
            most=_MOST_ELEMENTS,
        )


# ---- References ----------------------------------------------------------------------------------
# A drawing with what it refers to in its place, and without what is only there to be referred to.
#
# Symbols are not drawn but where they are used, each at the size of that use; masks and markers are
# no part of the picture; and a drawing within a drawing lies where its x and y say (SVG 1.1, 5.6
# and 7.9; SVG 2, 5.6). The package that reads drawings draws them all where they stand.


_NOT_DRAWN = ("marker", "mask", "symbol")
_SIZES, _PLACE = ("width", "height"), ("x", "y")


def _inline_symbols(root: Element) -> Element:
    """Resolve a drawing's symbols and nested drawings where they are used.

    Parameters
    ----------
    root : Element
        Of an SVG without cycles of references or references outside of itself; it is not changed.

    Returns
    -------
    Element
        The root of another one that draws the same.
    """
    return _place_element(root, elements_by_id(root))


def _place_element(element: Element, named: dict[str, Element]) -> Element:
    """An element and all below it, drawings within it where they lie."""
    placed = Element(element.tag, element.attrib)
    placed.text, placed.tail = element.text, element.tail
    for child in element:
        tag = tag_of(child)
        if tag in _NOT_DRAWN:
            continue
        used = _used_element(child, named) if tag == "use" else None
        if used is not None:
            child = _drawing_at(child, used)
        elif tag == "svg" and not child.get("viewBox") and any(map(child.get, _PLACE)):
            child = _translate(child)
        placed.append(_place_element(child, named))
    return placed


def _used_element(use: Element, named: dict[str, Element]) -> Element | None:
    """The symbol or drawing that a use is of; none where it is of something else."""
    used = named.get(reference_of(use))
    return used if used is not None and tag_of(used) in ("svg", "symbol") else None


def _drawing_at(use: Element, used: Element) -> Element:
    """A use that holds its symbol as a drawing as large as it says."""
    use_copy = _copy_without(use, (*HREFS, *_SIZES))
    drawing = deepcopy(used)
    drawing.tag, drawing.tail = tag_like(use, "svg"), None
    for key in _SIZES:
        asked = use.get(key) or drawing.get(key) or ("100%" if tag_of(used) == "symbol" else "")
        if asked:
            drawing.set(key, asked)
    if drawing.get("viewBox") and not any(map(drawing.get, _PLACE)):
        for key in _PLACE:  # of fractions of the view that the use is in
            drawing.set(key, use_copy.attrib.pop(key, "0"))
    use_copy.append(drawing)
    return use_copy


def _translate(drawing: Element) -> Element:
    """A drawing without a viewBox, as the use of one at its x and y."""
    use = Element(tag_like(drawing, "use"), {key: drawing.get(key) or "0" for key in _PLACE})
    use.append(_copy_without(drawing, _PLACE))
    use[0].extend(drawing)
    return use


def _copy_without(element: Element, attributes: tuple[str, ...]) -> Element:
    """An element by itself, without some of its attributes."""
    return Element(element.tag, {k: v for k, v in element.attrib.items() if k not in attributes})


# ---- The drawing ---------------------------------------------------------------------------------


_LOG = logging.getLogger(__name__)
_MOST_BYTES = 20_000_000
_FARTHEST = 1e12  # units, of any coordinate and width
_FLATNESS = 1.0 / 8192.0  # of the drawing's longer side
_FAINT = 20  # of 255: an opacity below it is none
_PAPER = 245  # of 255: what is lighter is paper
_CAPS = {"round": "round", "square": "square"}
_JOINS = {"round": "round", "bevel": "bevel"}
_NOT_PAINTED = ("text", "image", "mask", "foreignObject")
_UNEVEN = ("linearGradient", "radialGradient", "meshgradient", "pattern")
_PAINTS = re.compile(r"""url\(\s*['"]?#([^'")]+)""")  # the id of a gradient or pattern
_PAINT = re.compile(rf"""{_PAINTS.pattern}['"]?\s*\)([^;]*)""")  # and the fallback after it
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class _Ink:
    """The fill or stroke of an element, in the drawing's unit, y downwards."""

    name: str
    shape: MultiPolygon
    line: AnyArray | None  # of what is stroked, in the direction of its path
    closed: bool = False
    width: float = 0.0
    is_paper: bool = False


def load_svg(file: Path | str, ids: Sequence[str] = ()) -> Page:
    """Read a drawing as a page whose longer side is 1024 units.

    Parameters
    ----------
    file : path
    ids : sequence of str
        Only elements and groups of these names; by default all.

    Raises
    ------
    InputError
        If the file is no SVG, is not self-contained, has nothing to paint, or an id is not in it.
    """
    inks = _inks_of(file, ids)
    name = Path(file).name
    pieces = _make_pieces(inks)
    if not pieces:
        raise InputError("{file}: nothing but hairlines; expected shapes to fill", file=file)
    return Page(pieces, name, f"Drawing: {name}")


def svg_shape(file: Path | str, ids: Sequence[str] = ()) -> MultiPolygon:
    """All that a drawing inks as one shape, in the drawing's unit with y upwards.

    Raises
    ------
    InputError
        As `load_svg`.
    """
    from shapely import transform, unary_union

    whole = unary_union([ink.shape for ink in _inks_of(file, ids)])
    return as_multipolygon(transform(whole, lambda points: points * np.array([1.0, -1.0])))


def _inks_of(file: Path | str, ids: Sequence[str]) -> list[_Ink]:
    """Inked shapes of a file, without what white covers."""
    path = Path(file)
    try:
        data = path.read_bytes()
    except OSError as cause:
        raise InputError("{file}: {cause}", file=path, cause=cause) from None
    if len(data) > _MOST_BYTES:
        raise InputError(
            "{file}: {n:,} bytes; expected {most:,} at most",
            file=path,
            n=len(data),
            most=_MOST_BYTES,
        )
    root = _check_svg(data, path.name)
    _check_numbers(root, path.name)
    placed = _inline_symbols(root)
    in_numbers(placed)
    _resolve_paints(placed, {element.get("id") for element in root.iter()})
    paths, others = mark_clipped(placed)
    clips = _Clips(paths, path.name)
    inks = _cover_by_white(list(_read_inks(ElementTree.tostring(placed), path.name, ids, clips)))
    if not inks:
        raise InputError(
            "{file}: nothing is filled or stroked that is more than a hairline; expected shapes "
            "(text has to be turned into paths, pictures into drawings)",
            file=path,
        )
    tags = {tag_of(element) for element in root.iter()}
    left_out = [tag for tag in _NOT_PAINTED if tag in tags]
    if left_out:
        _LOG.warning("%s: not painted: %s", path.name, ", ".join(left_out))
    if others:
        _LOG.warning("%s: painted whole, without clip-path: %s", path.name, ", ".join(others))
    even = [tag for tag in _UNEVEN if tag in tags and _is_used(tag, root)]
    if even:
        _LOG.warning("%s: painted in one even ink: %s", path.name, ", ".join(even))
    return inks


def _resolve_paints(root: Element, names: set[str | None]) -> None:
    """Replace references to missing paints by their fallback colour, or none.

    The package takes any reference for black.
    """
    for element in root.iter():
        for key in ("fill", "stroke", "style"):
            if "url(" in element.get(key, ""):
                text = _PAINT.sub(
                    lambda match: match[0] if match[1] in names else match[2].strip() or "none",
                    element.get(key, ""),
                )
                element.set(key, text)


def _is_used(tag: str, root: Element) -> bool:
    """Return whether something in a drawing is filled or stroked by an element of this tag."""
    names = {element.get("id") for element in root.iter() if tag_of(element) == tag}
    texts = (
        text for element in root.iter() for text in (element.text or "", *element.attrib.values())
    )
    return any(name in names for text in texts for name in _PAINTS.findall(text))


class _Clips:
    """Shapes of clip paths, read on first use."""

    def __init__(self, paths: list[bytes], name: str) -> None:
        self._paths, self._name = paths, name
        self._shapes: dict[int, MultiPolygon] = {}

    def cut(self, ink: _Ink, shape: Any) -> _Ink | None:
        """An ink clipped to its clip paths; None if nothing is left."""
        for number in map(int, shape.values.get(CLIPS, "").split()):
            left = as_multipolygon(ink.shape.intersection(self._clip_remainder(number)))
            if left.is_empty:
                return None
            if left.area < ink.shape.area * (1.0 - _ROUNDING):
                ink = replace(ink, shape=left, line=None)
        return ink

    def _clip_remainder(self, number: int) -> MultiPolygon:
        from shapely import unary_union

        if number not in self._shapes:
            inks = _read_inks(self._paths[number], self._name, ())
            self._shapes[number] = as_multipolygon(unary_union([ink.shape for ink in inks]))
        return self._shapes[number]


# -- reading ------------------------------------------------------------------------------------


def _read_inks(
    data: bytes, name: str, ids: Sequence[str], clips: _Clips | None = None
) -> Iterator[_Ink]:
    """The inks of a drawing in document order, clipped."""
    svg = import_optional("svgelements")
    try:
        document = svg.SVG.parse(BytesIO(data), reify=False)
    except Exception as cause:  # of its many kinds, none is documented
        raise InputError(
            "{name}: cannot be read ({cause}); expected SVG", name=name, cause=cause
        ) from None
    shapes = list(_choose_shapes(document, set(ids), not ids, svg))
    missing = [one for one in ids if one not in _ids_below(document, svg)]
    if missing:
        known = ", ".join(sorted(_ids_below(document, svg))[:12]) or "none"
        raise InputError(
            "{name}: no id {missing}; it has {known}",
            name=name,
            missing=", ".join(map(repr, missing)),
            known=known,
        )
    drawn = [_Drawn(shape.segments(transformed=False), shape) for shape in shapes]
    with np.errstate(all="ignore"):  # it computes with what is not finite, too
        boxes = [box for one in drawn if (box := one.box(svg)) is not None]
    if not boxes:
        return
    widths = [one.width for one in drawn]
    _check_reach(name, np.array([side for box in boxes for side in box] + widths))
    left, upper, right, lower = bounds_of(boxes)
    flatness = _FLATNESS * max(right - left, lower - upper, 1e-9)
    for k, one in enumerate(drawn):
        label = one.shape.id or Message("element {n}", n=k + 1)
        with np.errstate(all="ignore"):
            lines = one.lines(flatness, svg)
        if not all(np.isfinite(points).all() for points, _ in lines):
            raise InputError(
                "{name}: {label} has an arc of no finite points; expected a radius",
                name=name,
                label=label,
            )
        for points, _ in lines:  # the boxes of some curves are too small
            _check_reach(name, points)
        for ink in _inks_of_element(lines, one, label):
            clipped = ink if clips is None else clips.cut(ink, one.shape)
            if clipped is not None:
                yield clipped


@dataclass(frozen=True, eq=False)
class _Drawn:
    """An element's segments as they are written, and the element, whose transform moves them.

    The package moves segments, too, but not all: arcs that are sheared, and basic shapes that are
    turned, come out elsewhere.
    """

    segments: Sequence[Any]
    shape: Any

    @property
    def width(self) -> float:
        """Of its stroke, the drawing's unit."""
        return float(self.shape.implicit_stroke_width or 0.0)

    def box(self, svg: Any) -> Box | None:
        """Its box, the drawing's unit, y downwards; none where there is nothing."""
        box = svg.Path(*self.segments).bbox() if self.segments else None
        if box is None:
            return None
        corners = self._translate(np.array([[x, y] for x in box[::2] for y in box[1::2]]))
        (left, upper), (right, lower) = corners.min(axis=0), corners.max(axis=0)
        return float(left), float(upper), float(right), float(lower)

    def lines(self, flatness: float, svg: Any) -> list[tuple[AnyArray, bool]]:
        """Its lines (N, 2), and whether they are closed; the drawing's unit, y downwards."""
        turn = self.shape.transform
        stretch = max(float(np.hypot(turn.a, turn.b)), float(np.hypot(turn.c, turn.d)), 1e-12)
        written = _flatten_subpaths(self.segments, flatness / (np.sqrt(2.0) * stretch), svg)
        return [(self._translate(points), closed) for points, closed in written]

    def _translate(self, points: AnyArray) -> AnyArray:
        turn = self.shape.transform
        across = np.array([[turn.a, turn.b], [turn.c, turn.d]], np.float64)
        moved: AnyArray = points @ across + np.array([turn.e, turn.f], np.float64)
        return moved


def _check_reach(name: str, lengths: AnyArray) -> None:
    farthest = np.abs(lengths).max(initial=0.0)
    if not farthest <= _FARTHEST:
        raise InputError(
            "{name}: reaches as far as {farthest:g}; expected {most:g} at most",
            name=name,
            farthest=farthest,
            most=_FARTHEST,
        )


def _choose_shapes(element: Any, ids: set[str], taken: bool, svg: Any) -> Iterator[Any]:
    """The shapes below an element that are asked for, in document order."""
    taken = taken or element.values.get("id") in ids
    if isinstance(element, svg.Shape):
        values = element.values
        hidden = values.get("visibility") in ("hidden", "collapse")
        if taken and not hidden and values.get("display") != "none":
            yield element
    elif isinstance(element, svg.Group | svg.Use):  # the document is a group, too
        for child in element:
            yield from _choose_shapes(child, ids, taken, svg)


def _ids_below(element: Any, svg: Any) -> set[str]:
    """All ids at and below an element."""
    names = {element.values.get("id")} - {None}
    if isinstance(element, svg.Group | svg.Use) and not isinstance(element, svg.Shape):
        for child in element:
            names |= _ids_below(child, svg)
    return names


def _flatten_subpaths(
    segments: Sequence[Any], flatness: float, svg: Any
) -> Iterator[tuple[AnyArray, bool]]:
    """Yield each subpath as points (N, 2), and whether it is closed; a dot may be one point."""
    points: list[AnyArray] = []
    controls: AnyArray = np.empty((0, 2))  # of the segment before
    for segment, before in zip(segments, (None, *segments), strict=False):
        controls = _control_points(segment, controls)
        if isinstance(segment, svg.Move):
            if len(points) > 1:
                yield np.array(points), False
            points = [_point(segment.end)]
        elif isinstance(segment, svg.Close):
            if len(points) > 1 or isinstance(before, svg.Move):
                yield _open_ring(np.array(points)), True
            points = points[:1]
        else:
            points.extend(_flatten_segment(segment, controls, flatness, svg))
    if len(points) > 1:
        yield np.array(points), False


def _control_points(segment: Any, before: AnyArray) -> AnyArray:
    """The control points (0..4, 2) of a segment, its ends among them; an arc has none but these.

    Of a smooth curve the first mirrors the last of the curve before, if it is one of its kind (SVG
    1.1, 8.3.6 and 8.3.7), which the package does after any curve.
    """
    names = ("start", "control", "control1", "control2", "end")
    points = [_point(p) for name in names if (p := getattr(segment, name, None)) is not None]
    controls = np.array(points).reshape(-1, 2)
    if len(controls) > 2 and getattr(segment, "smooth", False):
        mirrors = len(before) == len(controls)
        controls[1] = 2.0 * controls[0] - before[-2] if mirrors else controls[0]
    return controls


def _flatten_segment(segment: Any, controls: AnyArray, flatness: float, svg: Any) -> AnyArray:
    """Points of a segment after its start."""
    if isinstance(segment, svg.Arc):
        radius = max(abs(segment.rx), abs(segment.ry), 1e-12)
        step = 2.0 * np.arccos(max(0.0, 1.0 - flatness / radius))
        n = int(min(max(4.0, np.ceil(abs(segment.sweep) / max(step, 1e-3))), 2000))
        return np.array([_point(segment.point(t)) for t in np.linspace(0.0, 1.0, n + 1)[1:]])
    return bezier_points(controls, flatness)


def _point(point: Any) -> AnyArray:
    return np.array([point.x, point.y], np.float64)


def _open_ring(points: AnyArray) -> AnyArray:
    """A ring without its first point at its end."""
    closes = len(points) > 2 and np.allclose(points[0], points[-1])
    return np.array(points[:-1] if closes else points)


def _inks_of_element(
    lines: list[tuple[AnyArray, bool]], drawn: _Drawn, name: str
) -> Iterator[_Ink]:
    """Yield the shapes that an element fills and strokes; white covers earlier ones."""
    from shapely import LineString, Point

    shape, width = drawn.shape, drawn.width
    if _is_seen(shape.fill):
        rings = [points for points, _ in lines if len(points) > 2]
        filled = fill_rings(rings, even_odd=shape.values.get("fill-rule") == "evenodd")
        if not filled.is_empty:
            yield _Ink(name, filled, None, is_paper=_is_white(shape.fill))
    if not _is_seen(shape.stroke) or width <= 0.0:
        return
    cap = _CAPS.get(shape.values.get("stroke-linecap", ""), "flat")
    join = _JOINS.get(shape.values.get("stroke-linejoin", ""), "mitre")
    for points, closed in lines:
        line = np.concatenate([points, points[:1]]) if closed else points
        white = _is_white(shape.stroke)
        if width < thinnest_within(line):
            _refuse_hairline(name)
        elif np.ptp(line, axis=0).max() > 0.0:
            band = LineString(line).buffer(0.5 * width, cap_style=cap, join_style=join)
            yield _Ink(name, as_multipolygon(band), line, closed, width, white)
        elif cap != "flat":  # a path without length is a dot
            dot = Point(points[0]).buffer(0.5 * width, cap_style=cap)
            yield _Ink(name, as_multipolygon(dot), None, is_paper=white)


def _is_seen(colour: Any) -> bool:
    return colour is not None and colour.value is not None and (colour.alpha or 0) > _FAINT


def _is_white(colour: Any) -> bool:
    return bool(min(colour.red, colour.green, colour.blue) >= _PAPER)


def _cover_by_white(inks: Sequence[_Ink]) -> list[_Ink]:
    """The inks without what white elements above them cover."""
    left: list[_Ink] = []
    for ink in inks:
        if not ink.is_paper:
            left.append(ink)
            continue
        cut = [
            replace(one, shape=as_multipolygon(one.shape.difference(ink.shape)))
            if one.shape.intersects(ink.shape)
            else one
            for one in left
        ]
        left = [one for one in cut if not one.shape.is_empty]
    return left


# -- strokes ------------------------------------------------------------------------------------


def _make_pieces(inks: Sequence[_Ink]) -> tuple[Piece, ...]:
    """The inks' strokes in glyph units, those whose boxes overlap together."""
    from shapely import transform

    left, upper, right, lower = bounds_of(ink.shape.bounds for ink in inks)
    scale = EM_UNITS / max(right - left, lower - upper)
    flip = np.array([scale, -scale])

    def placed(points: AnyArray) -> AnyArray:
        moved: AnyArray = (points - np.array([left, lower])) * flip
        return moved

    scaled = [
        replace(
            ink,
            shape=as_multipolygon(transform(ink.shape, placed)),
            line=None if ink.line is None else placed(ink.line),
            width=scale * ink.width,
        )
        for ink in inks
    ]
    pieces = []
    for run, box in _runs(scaled):
        made = [_make_strokes(ink) for ink in run]
        strokes = tuple(stroke for of_ink in made for stroke in of_ink)
        if strokes:
            solid = any(ink.line is None for ink in run)
            joined = any(len(of_ink) > 1 for of_ink in made)
            glyph = Glyph(run[0].name, strokes, box, solid, joined)
            pieces.append(Piece(glyph, glyph.middle))
    return tuple(pieces)


def _runs(inks: Sequence[_Ink]) -> list[tuple[list[_Ink], Box]]:
    """Inks that follow each other and are laid as one, each with the box that it is laid by."""
    group_of: dict[int, int] = {}
    boxes = []
    for k, group in enumerate(_group_overlapping(inks)):
        boxes.append(bounds_of(ink.shape.bounds for ink in group))
        group_of |= {id(ink): k for ink in group}
    runs = groupby(inks, lambda ink: group_of[id(ink)])
    return [(list(run), boxes[k]) for k, run in runs]


def _group_overlapping(inks: Sequence[_Ink]) -> list[list[_Ink]]:
    """Groups of inks whose boxes overlap."""
    groups: list[list[_Ink]] = []
    for ink in inks:
        hits = [group for group in groups if _overlap(group, ink)]
        for group in hits[1:]:
            hits[0].extend(group)
            groups.remove(group)
        if hits:
            hits[0].append(ink)
        else:
            groups.append([ink])
    return groups


def _overlap(group: Sequence[_Ink], ink: _Ink) -> bool:
    one, two = bounds_of(other.shape.bounds for other in group), ink.shape.bounds
    across = one[0] < two[2] and two[0] < one[2]
    return bool(across and one[1] < two[3] and two[1] < one[3])


def _make_strokes(ink: _Ink) -> list[GlyphStroke]:
    """The strokes of an ink, what is wider than the brush in bands."""
    if ink.line is None:
        taken = _decompose_ink(ink)
    elif len(ink.shape.geoms) == 1:
        taken = [GlyphStroke.filling(ink.shape.geoms[0], _extend_closed(ink))]
    else:  # white has cut it
        taken = _decompose_ink(ink)
    if not any(is_wide(stroke) for stroke in taken):
        return taken
    return _fill_bands(ink, taken)


def _decompose_ink(ink: _Ink) -> list[GlyphStroke]:
    try:
        return decompose(ink.shape)
    except InputError:  # nothing that a brush could fill
        _refuse_hairline(ink.name)
        return []


def _refuse_hairline(name: str) -> None:
    _LOG.warning("%s: not painted: it is a hairline", name)


def _fill_bands(ink: _Ink, taken: Sequence[GlyphStroke]) -> list[GlyphStroke]:
    from shapely import Polygon

    strokes: list[GlyphStroke] = []
    for stroke in taken:
        if is_wide(stroke):
            for area in polygons_of(Polygon(stroke.outline, stroke.holes).buffer(0.0)):
                strokes += fill_in_bands(area)
        else:
            strokes.append(stroke)
    return strokes


def _extend_closed(ink: _Ink) -> AnyArray:
    """Centre line of a stroke; a closed one overlaps its start by half its width."""
    assert ink.line is not None
    if not ink.closed:
        return ink.line
    along = arc_lengths(ink.line)
    after = np.flatnonzero((along > 0.0) & (along < 0.5 * ink.width))
    last = interpolate([0.5 * ink.width], along, ink.line)
    result: AnyArray = np.concatenate([ink.line, ink.line[after], last])
    return result
