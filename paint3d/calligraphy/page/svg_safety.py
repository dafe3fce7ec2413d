"""What is refused of an SVG before it is read: entities, what lies outside of it, endless uses."""

from __future__ import annotations

import re
from xml.etree import ElementTree

from paint3d.calligraphy.page.svg_references import HREFS
from paint3d.core.foreign_xml import XmlFault, parse_xml
from paint3d.errors import InputError

__all__ = ["check_svg"]

_MOST_DEPTH = 200
_MOST_ELEMENTS = 100_000
_OUTSIDE = re.compile(r"""url\(\s*['"]?(?!['"]?\s*#)([^)'"]*)|@import\s+([^;]*)""", re.IGNORECASE)


def check_svg(data: bytes, name: str) -> ElementTree.Element:
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
        raise InputError(f"{name}:{fault.line}: {fault.what}; expected a plain SVG") from None
    if root.tag.rpartition("}")[2] != "svg":
        raise InputError(f"{name}: the outermost element is {root.tag!r}; expected svg")
    for element in root.iter():
        for href in filter(None, map(element.get, HREFS)):
            tag = element.tag.rpartition("}")[2]
            if not href.startswith("#") and tag != "a":
                raise _outside(name, href)
        for text in (element.text or "", *element.attrib.values()):
            outside = _OUTSIDE.search(text)
            if outside:
                raise _outside(name, outside[1] or outside[2])
    _count(root, name)
    return root


def _outside(name: str, reference: str) -> InputError:
    return InputError(
        f"{name}: refers to {reference[:60].strip()!r} outside of itself; "
        "expected a drawing that holds all that it shows"
    )


def _count(root: ElementTree.Element, name: str) -> None:
    """Refuse a drawing with too many elements once what it uses stands in its place."""
    named = {key: element for element in root.iter() if (key := element.get("id"))}
    sizes: dict[ElementTree.Element, int] = {}
    open_now: set[ElementTree.Element] = set()

    def size(element: ElementTree.Element) -> int:
        if element in open_now:
            raise InputError(f"{name}: {element.get('id')!r} uses itself; expected no circles")
        if element not in sizes:
            open_now.add(element)
            total = 1 + sum(size(child) for child in element)
            if element.tag.rpartition("}")[2] == "use":
                used = next(filter(None, map(element.get, HREFS)), "#").lstrip("#")
                total += size(named[used]) if used in named else 0
            open_now.discard(element)
            sizes[element] = total
        return sizes[element]

    try:
        n = size(root)
    except RecursionError:
        raise InputError(f"{name}: its uses are nested too deep") from None
    if n > _MOST_ELEMENTS:
        raise InputError(f"{name}: {n:,} elements; expected {_MOST_ELEMENTS:,} at most")
