"""Parsing of untrusted XML: no entities, and a limited depth of nesting."""

from __future__ import annotations

from xml.etree import ElementTree
from xml.parsers import expat

__all__ = ["XmlFault", "parse_xml"]


class XmlFault(Exception):
    """The reason why XML is refused.

    Attributes
    ----------
    line : int
    what : str
        The fault in that line.
    """

    def __init__(self, line: int, what: str) -> None:
        super().__init__(f"line {line}: {what}")
        self.line, self.what = line, what


def parse_xml(data: bytes, most_depth: int, *, doctypes: bool) -> ElementTree.Element:
    """Parse an XML document; return its root, with names as ElementTree has them.

    Parameters
    ----------
    data : bytes
    most_depth : int
        Greatest depth of nested elements.
    doctypes : bool
        Whether a document type may be declared; entities never may.

    Raises
    ------
    XmlFault
        If it has a forbidden declaration, is nested too deep, or is not well-formed.
    """
    builder = ElementTree.TreeBuilder()
    parser = expat.ParserCreate(namespace_separator="}")
    depth = 0

    def fault(what: str) -> XmlFault:
        return XmlFault(parser.CurrentLineNumber, what)

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > most_depth:
            raise fault(f"elements are nested over {most_depth} deep")
        builder.start(_named(tag), {_named(key): value for key, value in attributes.items()})

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(_named(tag))

    def refuse_doctype(*_: object) -> None:
        raise fault("there is a document type")

    def refuse_entity(*_: object) -> None:
        raise fault("entities are declared")

    parser.buffer_text = True
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler = builder.data
    parser.EntityDeclHandler = refuse_entity
    if not doctypes:
        parser.StartDoctypeDeclHandler = refuse_doctype
    try:
        parser.Parse(data, True)
        return builder.close()
    except (expat.ExpatError, LookupError, ValueError, AssertionError) as cause:
        line = getattr(cause, "lineno", 1)
        raise XmlFault(line, f"not well-formed XML ({cause})") from None


def _named(tag: str) -> str:
    """Return a name of expat's, ``uri}tag``, as ElementTree writes it: ``{uri}tag``."""
    return "{" + tag if "}" in tag else tag
