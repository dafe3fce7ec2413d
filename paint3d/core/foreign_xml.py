"""Parsing of untrusted XML: no entities (defusedxml), and a limited depth of nesting."""

from __future__ import annotations

from xml.etree import ElementTree

from defusedxml import DefusedXmlException, DTDForbidden
from defusedxml.ElementTree import XMLParser

from paint3d.errors import Message, Paint3DError

__all__ = ["XmlFault", "parse_xml"]


class XmlFault(Paint3DError):
    """The reason why XML is refused.

    Attributes
    ----------
    line : int
    what : str
        The fault in that line.
    """

    def __init__(self, line: int, what: Message) -> None:
        super().__init__(Message("line {line}: {what}", line=line, what=what))
        self.line, self.what = line, what


class _TooDeepError(Exception):
    """Elements are nested deeper than allowed."""


class _ShallowBuilder(ElementTree.TreeBuilder):
    def __init__(self, most_depth: int) -> None:
        super().__init__()
        self._left = most_depth

    def start(self, tag: str, attributes: dict[str, str]) -> ElementTree.Element:
        self._left -= 1
        if self._left < 0:
            raise _TooDeepError
        return super().start(tag, attributes)

    def end(self, tag: str) -> ElementTree.Element:
        self._left += 1
        return super().end(tag)


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
    parser = XMLParser(target=_ShallowBuilder(most_depth), forbid_dtd=not doctypes)
    line = 1
    try:
        parser.feed(data)
        root: ElementTree.Element = parser.close()
        return root
    except _TooDeepError:
        what = Message("elements are nested over {most} deep", most=most_depth)
    except DTDForbidden:
        what = Message("there is a document type")
    except DefusedXmlException:
        what = Message("entities are declared")
    except (ElementTree.ParseError, LookupError, ValueError, AssertionError) as cause:
        line = getattr(cause, "position", (1, 0))[0]
        raise XmlFault(line, Message("not well-formed XML ({cause})", cause=cause)) from None
    raise XmlFault(parser.parser.CurrentLineNumber, what)
