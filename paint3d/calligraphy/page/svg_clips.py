"""Clipping of a drawing's elements by clip paths.

The package that reads drawings knows none of them. So each element below one is given its name in
an attribute, which is inherited and comes out with its shape; and the path itself is a drawing of
its own, in place of what refers to it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from copy import deepcopy
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

__all__ = [
    "CLIPS",
    "HREFS",
    "SHAPES",
    "elements_by_id",
    "mark_clipped",
    "reference_of",
    "tag_like",
    "tag_of",
]

CLIPS = "data-paint3d-clips"
"""The attribute with the indices, into what `mark_clipped` returns, of a shape's clipping paths."""
HREFS = ("href", "{http://www.w3.org/1999/xlink}href")
"""Attributes that refer to another element."""
SHAPES = ("path", "rect", "circle", "ellipse", "line", "polyline", "polygon")
"""Tags of the elements that are drawn."""
_USING = (*HREFS, "x", "y", "width", "height")
_REFERENCE = re.compile(r"""\s*url\(\s*['"]?#([^'")]+)['"]?\s*\)\s*""")  # url(#id), the whole value
_STYLED = re.compile(r"(?:^|;)\s*clip-path\s*:\s*([^;!]*)", re.IGNORECASE)
_RULE = re.compile(r"(?:^|;)\s*clip-rule\s*:\s*([^;!\s]*)", re.IGNORECASE)
_PLACING = ("transform", "x", "y", "width", "height", "viewBox", "preserveAspectRatio")
_LOOKS = ("fill", "stroke", "stroke-width", "style", "class", "opacity", "fill-opacity", "display")
_MOST = 64  # paths that clip each other


def mark_clipped(root: Element) -> tuple[list[bytes], set[str]]:
    """Note at each element of a drawing the paths that clip it.

    Parameters
    ----------
    root : Element
        Changed in place.

    Returns
    -------
    list of bytes
        The paths, as drawings that fill what they leave.
    set of str
        What clips and is no such path: its words.
    """
    named = elements_by_id(root)
    if any(map(_property_of, root.iter())):
        _inline_uses(root, named)
    paths: list[bytes] = []
    others: set[str] = set()

    def walk(element: Element, above: Sequence[Element], clips: tuple[int, ...]) -> None:
        if tag_of(element) == "clipPath":
            return
        text = _property_of(element)
        here = [*above, element]
        seen: set[str] = set()
        while text and text != "none":
            match = _REFERENCE.fullmatch(text)
            path = named.get(match[1]) if match else None
            if match is None or (path is not None and not _is_plain(path)):
                others.add(text.strip()[:40])
                break
            if path is None or match[1] in seen or len(paths) >= _MOST * _MOST:
                break
            seen.add(match[1])
            clips = (*clips, len(paths))
            paths.append(_clip_drawing(here, path, named))
            text = _property_of(path)  # itself clipped
        if clips:
            element.set(CLIPS, " ".join(map(str, clips)))
        for child in element:
            walk(child, here, clips)

    walk(root, [], ())
    return paths, others


def _inline_uses(element: Element, named: dict[str, Element]) -> None:
    """Put what is used in place of its uses, where it may be clipped otherwise."""
    for k, child in enumerate(element):
        used = named.get(reference_of(child)) if tag_of(child) == "use" else None
        if used is not None:
            group = Element(
                tag_like(child, "g"), {k: v for k, v in child.attrib.items() if k not in _USING}
            )
            group.set("transform", _transform(child))
            group.append(deepcopy(used))
            element[k] = child = group
        _inline_uses(child, named)


def _transform(use: Element) -> str:
    return f"{use.get('transform', '')} translate({use.get('x', '0')} {use.get('y', '0')})".strip()


def _property_of(element: Element) -> str:
    styled = _STYLED.search(element.get("style", ""))
    return (styled[1] if styled else element.get("clip-path", "")).strip()


def _is_plain(path: Element) -> bool:
    return (
        tag_of(path) == "clipPath"
        and path.get("clipPathUnits", "userSpaceOnUse") == "userSpaceOnUse"
    )


def _clip_drawing(ancestors: Sequence[Element], path: Element, named: dict[str, Element]) -> bytes:
    """A drawing that fills a path in place of the last of these elements, from the root."""
    root, *inner = ancestors
    drawing = Element(root.tag, {k: v for k, v in root.attrib.items() if k in _PLACING})
    at = drawing
    for element in inner:
        attributes = {k: v for k, v in element.attrib.items() if k in _PLACING}
        tag = element.tag
        if tag_of(element) not in ("svg", "use"):  # of a shape its x and y are no place
            attributes = {k: v for k, v in attributes.items() if k == "transform"}
            tag = tag_like(element, "g")
        at = ElementTree.SubElement(at, tag, attributes)
    moved = {"transform": path.get("transform", "")}
    at = ElementTree.SubElement(at, tag_like(path, "g"), moved)
    rule = _rule_of(path)
    at.extend(filled for child in path for filled in _fill_element(child, rule, named, 0))
    return ElementTree.tostring(drawing)


def _fill_element(
    element: Element, rule: str, named: dict[str, Element], depth: int
) -> Sequence[Element]:
    """An element of a clip path, filled; a use is replaced by its target."""
    if tag_of(element) == "clipPath" or depth > _MOST:
        return ()
    rule = _rule_of(element) or rule
    hidden = element.get("display") == "none" or "display:none" in re.sub(
        r"\s+", "", element.get("style", "").lower()
    )
    if hidden:
        return ()
    attributes = {k: v for k, v in element.attrib.items() if k not in _LOOKS}
    if tag_of(element) == "use":
        used = named.get(reference_of(element))
        if used is None:
            return ()
        group = Element(tag_like(element, "g"), {"transform": _transform(element)})
        group.extend(_fill_element(used, rule, named, depth + 1))
        return (group,)
    copy = Element(element.tag, {**attributes, "fill": "#000", "stroke": "none"})
    if rule:
        copy.set("fill-rule", rule)
    for child in element:
        copy.extend(_fill_element(deepcopy(child), rule, named, depth + 1))
    return (copy,)


def _rule_of(element: Element) -> str:
    styled = _RULE.search(element.get("style", ""))
    return styled[1] if styled else element.get("clip-rule", "")


def elements_by_id(root: Element) -> dict[str, Element]:
    """Elements of a drawing by id."""
    return {key: element for element in root.iter() if (key := element.get("id"))}


def reference_of(element: Element) -> str:
    """The id that an element refers to; "" for none."""
    return next(filter(None, map(element.get, HREFS)), "").lstrip("#")


def tag_of(element: Element) -> str:
    """An element's tag without its namespace."""
    return element.tag.rpartition("}")[2]


def tag_like(element: Element, tag: str) -> str:
    """A tag in the namespace of an element's."""
    return element.tag.rpartition("}")[0] + "}" * ("}" in element.tag) + tag
