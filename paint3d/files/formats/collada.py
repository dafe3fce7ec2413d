"""COLLADA (.dae, and .zae, a ZIP of it), read by trimesh and pycollada.

They are imported here, in the child process, and given bytes. Of other files that one refers to it
gets pictures in its folder.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from paint3d.core.foreign_xml import XmlFault, parse_xml
from paint3d.errors import MeshError, Message
from paint3d.files.colours import VERTEX_COLOURS, open_picture
from paint3d.files.contents import read_beside
from paint3d.files.package_meshes import read_trimesh
from paint3d.files.raw_mesh import RawMesh, left_out

__all__ = ["read_collada"]

DEEPEST = 512  # elements nested in one another
MOST_BYTES = 1 << 28  # of an unpacked archive
UP = {"X_UP": "x", "Y_UP": "y", "Z_UP": "z"}


class _Beside:
    """Gives trimesh the pictures beside a file, and keeps what it could not give."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.notes: list[Message] = []

    def get(self, name: str) -> bytes:
        """Return a file's bytes."""
        try:
            data = read_beside(self._folder, str(name))
            open_picture(data)  # of one that is none, trimesh says nothing
        except MeshError as cause:
            self.notes.append(Message("a texture is left out: {cause}", cause=cause))
            raise
        return data


def read_collada(data: bytes, folder: Path, texture: bool = False) -> RawMesh:
    """Read a COLLADA document, plain or packed, with its unit and the axis that is up.

    Parameters
    ----------
    data : bytes
        The whole file; what begins with "PK" is a ZIP.
    folder : Path
        Where its pictures lie; others are not followed.
    texture : bool
        Whether to take colours of materials and their pictures.

    Raises
    ------
    MeshError
        If pycollada is missing, the XML declares entities, or there is nothing to paint on.
    """
    trimesh = _import_package("trimesh")
    _import_package("collada")
    packed = data[:2] == b"PK"
    up, is_painted = None, False
    for root in _unpack_documents(data) if packed else (_parse_document(data),):
        up = up or _find_up(root)
        is_painted |= any(element.get("semantic") == "COLOR" for element in root.iter())
    beside = {"resolver": _Beside(folder)} if texture and not packed else {}
    try:
        scene = trimesh.load_scene(io.BytesIO(data), file_type="zae" if packed else "dae", **beside)
        raw = read_trimesh(scene, texture)  # looks at what was only noted down until now
    except MeshError:
        raise
    except Exception as cause:  # of any kind: its readers trust what they read
        words = " ".join(str(cause).split()) or type(cause).__name__
        raise MeshError(
            "COLLADA is read by trimesh, which says: {words:.200}", words=words
        ) from None
    notes = tuple(dict.fromkeys(beside["resolver"].notes)) if beside else ()
    notes += left_out([VERTEX_COLOURS]) if is_painted and raw.colours is None else ()
    up = up or "y"  # as COLLADA says where a file does not
    return replace(raw, up=up, notes=raw.notes + notes)


def _import_package(module: str) -> Any:
    try:
        return import_module(module)
    except ImportError:
        raise MeshError(
            "COLLADA needs {package}, which is not installed; expected the object in a format that "
            "needs nothing, such as .glb",
            package=module,
            hint="pip install 'paint3d[meshes]'",
        ) from None


def _parse_document(data: bytes) -> ElementTree.Element:
    try:
        return parse_xml(data, DEEPEST, doctypes=False)
    except XmlFault as fault:
        raise MeshError("it is not COLLADA that is read: {fault}", fault=fault) from None


def _unpack_documents(data: bytes) -> Iterator[ElementTree.Element]:
    """Yield every XML in an archive, after a look that it declares no entities."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as package:
            if sum(entry.file_size for entry in package.infolist()) > MOST_BYTES:
                raise MeshError(
                    "it unpacks to more than {most:,} bytes; expected less",
                    most=MOST_BYTES,
                )
            for entry in package.infolist():
                content = package.read(entry)
                if content.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] == b"<":
                    yield _parse_document(content)
    except MeshError:
        raise
    except Exception as cause:  # of any kind: every packing has its own
        raise MeshError(
            "packed COLLADA is a ZIP, which cannot be unpacked: {cause}", cause=cause
        ) from None


def _find_up(root: ElementTree.Element) -> str | None:
    for element in root.iter():
        if element.tag.rpartition("}")[2] == "up_axis":
            return UP.get((element.text or "").strip())
    return None
