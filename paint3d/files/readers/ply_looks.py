"""Pictures and colours of the faces of a PLY file, as MeshLab and others write them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError
from paint3d.files.readers.contents import read_beside
from paint3d.files.readers.ply_tables import Element, Tables
from paint3d.files.readers.raw_mesh import index_array
from paint3d.files.readers.textures import Look, open_picture
from paint3d.files.readers.vertex_colours import COLOUR_NAMES, colour_codes

__all__ = ["PlyLooks", "has_face_colours", "picture_names", "ply_looks"]

KEYWORD = "TextureFile"
PLACE_NAMES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))  # of vertices
MAX_PICTURES = 1000


@dataclass(frozen=True)
class PlyLooks:
    """What the faces look like; see `RawMesh`. No looks: nothing is said of them."""

    looks: tuple[Look, ...] = ()
    look_of: NDArray[np.int64] | None = None
    uv: NDArray[np.float64] | None = None
    corner_colours: NDArray[np.uint8] | None = None
    notes: tuple[str, ...] = ()


def picture_names(tables: Tables) -> list[str]:
    """Names of the pictures that the header speaks of."""
    found = (comment.partition(" ") for comment in tables.comments)
    return [name.strip() for word, _, name in found if word == KEYWORD]


def has_face_colours(tables: Tables) -> bool:
    """Whether the faces have colours of their own."""
    return any(_colour_names(element) for element in tables.elements if element.name == "face")


def ply_looks(
    tables: Tables, corners: NDArray[np.int64], sizes: NDArray[np.int64], folder: Path
) -> PlyLooks:
    """Return what the faces look like: their pictures, else their own colours.

    Places on the pictures are those of the faces' corners (texcoord), else of the vertices (s, t);
    they count from the lower left in the file.

    Parameters
    ----------
    tables : Tables
    corners : (N,) int64
        Of all polygons; within the vertices or not.
    sizes : (P,) int64
        The first polygons are those of the element face.
    folder : Path
        Of the file; pictures elsewhere are not followed.
    """
    faces = [e for e in tables.elements if e.name == "face" and e.list_sizes]
    names = picture_names(tables)
    if not names or len(faces) > 1:
        return _face_colours(faces, sizes)
    uv = _places(tables, faces, corners, sizes)
    if uv is None:
        return PlyLooks(notes=("a texture is left out: the mesh has no places on it",))
    looks, number, notes = [], [], []
    for name in names[:MAX_PICTURES]:
        number.append(-1)
        try:
            looks.append(Look(picture=open_picture(read_beside(folder, _as_file(name)))))
            number[-1] = len(looks) - 1
        except MeshError as cause:
            notes.append(f"a texture is left out: {cause}")
    if not looks:
        return PlyLooks(notes=tuple(dict.fromkeys(notes)))
    which = _numbers(faces, len(sizes))
    inside = (which >= 0) & (which < len(number))
    look_of = np.where(inside, np.array(number)[np.where(inside, which, 0)], -1)
    return PlyLooks(tuple(looks), look_of, uv, notes=tuple(dict.fromkeys(notes)))


def _as_file(name: str) -> str:
    """The header was read byte by byte; a name is UTF-8, or what it is."""
    return name.encode("latin-1").decode("utf-8", "surrogateescape")


def _places(
    tables: Tables, faces: Sequence[Element], corners: NDArray[np.int64], sizes: NDArray[np.int64]
) -> NDArray[np.float64] | None:
    """Places (N, 2) of the corners from the upper left, nan where unknown; None: there are none."""
    uv = np.full((len(corners), 2), np.nan)
    vertex = next(e for e in tables.elements if e.name == "vertex")
    pair = next((p for p in PLACE_NAMES if set(p) <= set(vertex.values)), None)
    listed = faces[0].list_sizes.get("texcoord") if faces else None
    if listed is not None:
        own = np.repeat(sizes[: len(listed)], sizes[: len(listed)])
        told = np.repeat(listed, sizes[: len(listed)]) == 2 * own  # others have none, or too few
        values = faces[0].values["texcoord"].astype(np.float64)
        whole = np.repeat(listed == 2 * sizes[: len(listed)], listed)
        uv[: len(told)][told] = values[whole].reshape(-1, 2)
    elif pair is not None:
        table = np.stack([vertex.values[name] for name in pair], axis=1).astype(np.float64)
        uv = table[np.clip(corners, 0, len(table) - 1)]
    else:
        return None
    return uv * (1.0, -1.0) + (0.0, 1.0)


def _numbers(faces: Sequence[Element], n: int) -> NDArray[np.int64]:
    """Which picture each of n polygons has; the first where nothing is said."""
    which = np.zeros(n, np.int64)
    if faces and "texnumber" in faces[0].values and "texnumber" not in faces[0].list_sizes:
        told = index_array(faces[0].values["texnumber"].astype(np.float64), "a face's texnumber")
        which[: len(told)] = told
    return which


def _colour_names(element: Element) -> tuple[str, ...] | None:
    scalars = set(element.values) - set(element.list_sizes)
    return next((names for names in COLOUR_NAMES if set(names) <= scalars), None)


def _face_colours(faces: Sequence[Element], sizes: NDArray[np.int64]) -> PlyLooks:
    names = _colour_names(faces[0]) if len(faces) == 1 else None
    if names is None:
        return PlyLooks()
    codes, notes = colour_codes(np.stack([faces[0].values[k] for k in names], axis=1))
    notes = tuple(note.replace("vertex colours", "colours of faces") for note in notes)
    if codes is None:
        return PlyLooks(notes=notes)
    every = np.full((len(sizes), 3), 255, np.uint8)
    every[: len(codes)] = codes
    uv = np.full((int(sizes.sum()), 2), np.nan)
    look_of = np.zeros(len(sizes), np.int64)
    return PlyLooks((Look(),), look_of, uv, np.repeat(every, sizes, axis=0), notes)
