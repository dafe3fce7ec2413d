"""A drawing with what it refers to in its place, and without what is only there to be referred to.

Symbols are not drawn but where they are used, each at the size of that use; masks and markers are
no part of the picture; and a drawing within a drawing lies where its x and y say (SVG 1.1, 5.6 and
7.9; SVG 2, 5.6). The package that reads drawings draws them all where they stand.
"""

from __future__ import annotations

from copy import deepcopy
from xml.etree.ElementTree import Element

__all__ = ["HREFS", "in_place"]

HREFS = ("href", "{http://www.w3.org/1999/xlink}href")
_NOT_DRAWN = ("marker", "mask", "symbol")
_SIZES, _PLACE = ("width", "height"), ("x", "y")


def in_place(root: Element) -> Element:
    """A drawing whose symbols stand where they are used.

    Parameters
    ----------
    root : Element
        Of an SVG that has no circles and refers to nothing outside of itself; it stays as it is.

    Returns
    -------
    Element
        The root of another one that draws the same.
    """
    named = {key: element for element in root.iter() if (key := element.get("id"))}
    return _placed(root, named)


def _placed(element: Element, named: dict[str, Element]) -> Element:
    """An element and all below it, drawings within it where they lie."""
    placed = Element(element.tag, element.attrib)
    placed.text, placed.tail = element.text, element.tail
    for child in element:
        tag = _tag(child)
        if tag in _NOT_DRAWN:
            continue
        used = _used(child, named) if tag == "use" else None
        if used is not None:
            child = _drawing_at(child, used)
        elif tag == "svg" and not child.get("viewBox") and any(map(child.get, _PLACE)):
            child = _moved(child)
        placed.append(_placed(child, named))
    return placed


def _used(use: Element, named: dict[str, Element]) -> Element | None:
    """The symbol or drawing that a use is of; none where it is of something else."""
    href = next(filter(None, map(use.get, HREFS)), "#")
    used = named.get(href.lstrip("#"))
    return used if used is not None and _tag(used) in ("svg", "symbol") else None


def _drawing_at(use: Element, used: Element) -> Element:
    """A use that holds its symbol as a drawing as large as it says."""
    place = _without(use, (*HREFS, *_SIZES))
    drawing = deepcopy(used)
    drawing.tag, drawing.tail = _like(use, "svg"), None
    for key in _SIZES:
        asked = use.get(key) or drawing.get(key) or ("100%" if _tag(used) == "symbol" else "")
        if asked:
            drawing.set(key, asked)
    if drawing.get("viewBox") and not any(map(drawing.get, _PLACE)):
        for key in _PLACE:  # of shares of the view that the use is in
            drawing.set(key, place.attrib.pop(key, "0"))
    place.append(drawing)
    return place


def _moved(drawing: Element) -> Element:
    """A drawing without a viewBox, at its place."""
    place = Element(_like(drawing, "use"), {key: drawing.get(key) or "0" for key in _PLACE})
    place.append(_without(drawing, _PLACE))
    place[0].extend(drawing)
    return place


def _without(element: Element, attributes: tuple[str, ...]) -> Element:
    """An element by itself, without some of its attributes."""
    return Element(element.tag, {k: v for k, v in element.attrib.items() if k not in attributes})


def _tag(element: Element) -> str:
    return element.tag.rpartition("}")[2]


def _like(element: Element, tag: str) -> str:
    """A tag in the namespace of an element's."""
    return element.tag.rpartition("}")[0] + "}" * ("}" in element.tag) + tag
