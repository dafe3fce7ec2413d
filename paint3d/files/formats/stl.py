"""STL, binary and ASCII: every corner is repeated, and equal positions become one vertex."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError, Message
from paint3d.files.raw_mesh import (
    FACE_COLOURS,
    RawMesh,
    check_count,
    left_out,
    parse_numbers,
    with_face_colours,
)

__all__ = ["read_stl"]

HEADER = 84
FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
VERTEX = re.compile(rb"^[^\S\n]*vertex\s+(\S+\s+\S+\s+\S+)", re.IGNORECASE | re.MULTILINE)
FACETS = re.compile(rb"^[^\S\n]*facet\b", re.IGNORECASE | re.MULTILINE)
COLOURS = re.compile(rb"^[^\S\n]*colou?r\s+[\d.]", re.IGNORECASE | re.MULTILINE)
ENDS = re.compile(rb"^[^\S\n]*endfacet\b", re.IGNORECASE | re.MULTILINE)


def read_stl(data: bytes, texture: bool = False) -> RawMesh:
    """Read an STL file.

    A file whose length fits the triangle count at byte 80 is binary, whatever its header says:
    many programs start a binary header with "solid".

    Parameters
    ----------
    data : bytes
        The whole file.
    texture : bool
        Whether colours of facets are wanted, which binary files may have.

    Raises
    ------
    MeshError
        If it is neither kind, or cut short.
    """
    binary = len(data) >= HEADER and len(data) == HEADER + FACET.itemsize * _count(data)
    if not binary and data[:512].lstrip().lower().startswith(b"solid") and FACETS.search(data):
        raw = RawMesh.of_triangles(*_merge(_read_ascii(data)))
        dropped = {FACE_COLOURS} if COLOURS.search(data) else set()
        return replace(raw, notes=left_out(dropped))
    facets = _read_binary(data)
    raw = RawMesh.of_triangles(*_merge(facets["corners"].reshape(-1, 3)))
    codes = _facet_colours(data[: HEADER - 4], facets["attribute"])
    return raw if codes is None else with_face_colours(raw, codes, texture)


def _facet_colours(header: bytes, attribute: NDArray[np.uint16]) -> NDArray[np.uint8] | None:
    """Return the colours (F, 3) that two programs put into the attributes of facets.

    Both have five bits a channel. Materialise Magics says the colour of the whole in the header,
    after "COLOR=", and a set 15th bit means that a facet has that; red is lowest. In VisCAM and
    SolidView a set 15th bit means that a facet has a colour of its own; blue is lowest. The others
    are white.
    """
    own = attribute >> 15 == 1
    at = header.find(b"COLOR=")
    default = np.full(3, 255, np.uint8)
    shifts = (10, 5, 0)
    if at >= 0 and len(header) >= at + 10:
        default = np.frombuffer(header, np.uint8, 3, at + 6)
        own, shifts = ~own, (0, 5, 10)
    if not own.any() and at < 0:
        return None
    bits = np.stack([(attribute >> shift) & 31 for shift in shifts], axis=1)
    return np.where(own[:, None], bits * 255 // 31, default).astype(np.uint8)


def _count(data: bytes) -> int:
    return int.from_bytes(data[80:HEADER], "little")


def _read_binary(data: bytes) -> AnyArray:
    if len(data) < HEADER:
        raise MeshError(
            "it has {n} bytes; a binary STL has at least {header}",
            n=len(data),
            header=HEADER,
        )
    check_count(_count(data), FACET.itemsize, len(data) - HEADER, Message("triangles"))
    return np.frombuffer(data, FACET, _count(data), HEADER)


def _read_ascii(data: bytes) -> NDArray[np.float64]:
    vertices = VERTEX.findall(data)
    n_facets, n_ends = len(FACETS.findall(data)), len(ENDS.findall(data))
    if len(vertices) != 3 * n_facets or n_ends != n_facets:
        raise MeshError(
            "it has {n_facets} facets, {n_ends} of them ended, with {n} vertices; expected "
            "{expected}: the file is cut short or damaged",
            n_facets=n_facets,
            n_ends=n_ends,
            n=len(vertices),
            expected=3 * n_facets,
        )
    return parse_numbers(b"\n".join(vertices), Message("a vertex")).reshape(-1, 3)


def _merge(corners: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Return the distinct positions in order of appearance, and the faces that refer to them."""
    keys = np.ascontiguousarray(corners + 0.0)  # makes -0.0 equal to 0.0, byte by byte
    rows = keys.view(np.dtype((np.void, keys.dtype.itemsize * 3))).ravel()
    _, first, back = np.unique(rows, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return keys[first[order]].astype(np.float64), rank[back].reshape(-1, 3)
