"""References of a mesh file to other files: its pictures, materials and buffers.

The mesh is a stranger's: `refers_to` runs in a child process (`files.sandbox`).
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.sax.saxutils import unescape

from paint3d.errors import MeshError
from paint3d.files.contents import path_beside, plain_text, read_contents
from paint3d.files.formats.gltf import GltfFile
from paint3d.files.formats.obj import MAX_LIBRARY
from paint3d.files.sandbox import Found, read_apart

__all__ = ["child_references", "refers_to", "refers_to_apart"]

_LIBRARIES = re.compile(rb"^[ \t]*mtllib[ \t]+(.+)$", re.MULTILINE)
_MAPS = re.compile(rb"^[ \t]*(?:map_\w+|bump|norm|disp|decal|refl)[ \t]+(.+)$", re.MULTILINE | re.I)
_PLY_PICTURES = re.compile(rb"^comment[ \t]+TextureFile[ \t]+(.+)$", re.MULTILINE)
_COLLADA_FILES = re.compile(rb"<(?:init_from|ref)>([^<]+)<")
_PLY_END = b"end_header"
_MOST_WORDS = 40  # of a line in which names are looked for


def refers_to_apart(mesh: Path, file: Path) -> bool:
    """Return whether a mesh file speaks of another one: asked in a child with limits.

    Nothing is started where the names tell that it cannot. A mesh that reaches the limits speaks
    of nothing: whoever reads it says what is wrong with it.
    """
    if not _may_refer_to(mesh, file):
        return False
    reader = f"{__name__}:{child_references.__name__}"
    try:
        _, facts = read_apart(mesh, reader, [os.fsencode(file).hex()])
    except (MeshError, OSError):
        return False
    return facts.get("refers") is True


def child_references(path: Path, wanted: list[Any]) -> Found:
    """Answer `refers_to` in the child process; `wanted[0]` is the other file, in hexadecimal."""
    return {}, {"refers": refers_to(path, Path(os.fsdecode(bytes.fromhex(wanted[0]))))}


def _may_refer_to(mesh: Path, file: Path) -> bool:
    """Return whether a mesh file could refer to another one, by their names alone, unopened."""
    wanted, top = os.path.realpath(file), os.path.realpath(mesh.parent)
    try:
        inside = os.path.isfile(wanted) and os.path.commonpath([top, wanted]) == top
    except ValueError:  # on different drives, or no file name
        return False
    return inside and _suffix(mesh) in _NAMED


def refers_to(mesh: Path, file: Path) -> bool:
    """Return whether a mesh file speaks of another one, directly or in its materials.

    What cannot be read speaks of nothing: whoever reads the mesh says what is wrong with it.

    Parameters
    ----------
    mesh, file : Path
        `file` need not lie in the mesh's folder: then it is not spoken of.
    """
    wanted, top = os.path.realpath(file), os.path.realpath(mesh.parent)
    try:
        if not _may_refer_to(mesh, file):
            return False
        names = _NAMED[_suffix(mesh)](read_contents(mesh), Path(top))
        return any(path_beside(top, name) == wanted for name in names)
    except (MeshError, MemoryError, OSError, AttributeError, LookupError, TypeError, ValueError):
        return False


def _suffix(mesh: Path) -> str:
    inner = Path(mesh.stem) if mesh.suffix.lower() in (".gz", ".bz2") else mesh
    return inner.suffix.lower()


def _possible_names(line: bytes) -> Iterator[str]:
    """Yield every possible file name at the end of a line, after options or others."""
    words = line.strip().split()[:_MOST_WORDS]
    at = 0
    for word in words:
        at = line.index(word, at)
        yield line[at:].strip().decode("utf-8", "surrogateescape")
        yield word.decode("utf-8", "surrogateescape")
        at += len(word)


def _names_in_obj(data: bytes, folder: Path) -> Iterator[str]:
    for line in _LIBRARIES.findall(plain_text(data)):
        for name in _possible_names(line):
            yield name
            library = Path(path_beside(str(folder), name))
            if library.is_file():
                for line_end in _MAPS.findall(plain_text(read_contents(library, MAX_LIBRARY))):
                    yield from _possible_names(line_end)


def _names_in_ply(data: bytes, _: Path) -> Iterator[str]:
    for name in _PLY_PICTURES.findall(plain_text(data[: max(0, data.find(_PLY_END))])):
        yield name.strip().decode("utf-8", "surrogateescape")


def _names_in_collada(data: bytes, _: Path) -> Iterator[str]:
    for name in _COLLADA_FILES.findall(plain_text(data)):
        yield unescape(name.strip().decode("utf-8", "surrogateescape"))


def _names_in_gltf(data: bytes, folder: Path) -> Iterator[str]:
    document = GltfFile(data, folder).document
    for kind in ("buffers", "images"):
        for entry in document.get(kind, ()):
            if "uri" in entry and not entry["uri"].startswith("data:"):
                yield entry["uri"]


_NAMED = {
    ".obj": _names_in_obj,
    ".ply": _names_in_ply,
    ".gltf": _names_in_gltf,
    ".glb": _names_in_gltf,
}
_NAMED[".dae"] = _names_in_collada
