"""From a mesh file to checked triangles, in one process; `sandbox` runs this in a child."""

from __future__ import annotations

import codecs
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from pkgutil import resolve_name
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError, Message
from paint3d.files.contents import PACKED, plain_text, read_contents
from paint3d.files.detail import Draped, show_pictures
from paint3d.files.package_meshes import package_class, read_object
from paint3d.files.progress import Progress
from paint3d.files.raw_mesh import RawMesh
from paint3d.files.sandbox import (
    MAX_IDLE_SECONDS,
    MAX_SECONDS,
    PICTURE_SECONDS,
    Found,
    notes_of,
    read_apart,
)
from paint3d.mesh.polygons import triangulate
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.mesh.upright import Upright, guess_up, turn_rows, turn_up

__all__ = [
    "MESH_SUFFIXES",
    "UNITS_MM",
    "ReadOptions",
    "Reading",
    "child_surface",
    "read_surface",
    "read_surface_apart",
    "take_object",
]

UNITS_MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
READERS = {  # modules of `paint3d.files.formats`, and what reads there
    ".ply": "ply:read_ply",
    ".obj": "obj:read_obj",
    ".stl": "stl:read_stl",
    ".off": "off:read_off",
    ".3mf": "threemf:read_3mf",
    ".glb": "gltf:read_gltf",
    ".gltf": "gltf:read_gltf",
    ".p3d.txt": "records:read_records_mesh",
    ".xyz": "xyz:read_xyz",
    ".dae": "collada:read_collada",
    ".zae": "collada:read_collada",
}
UNREAD = {  # what other programs read, and ours does not
    **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz"), "USD"),
    **dict.fromkeys((".wrl", ".vrml", ".x3d"), "VRML"),
    **{".fbx": "FBX", ".blend": "a .blend file"},
    **{".xaml": "XAML", ".ctm": "OpenCTM", ".3ds": "3DS"},
}
DRAWINGS = {".svg": "SVG", ".dxf": "DXF"}
RECORDS = ".p3d.txt"  # a suffix of two words, of which .txt alone is none
BESIDE = (".gltf", ".glb", ".obj", ".ply", ".dae", ".zae")  # may refer to others in their folder
WANT_TEXTURE = (".3mf", ".stl", ".off")
# Formats that hold their colours themselves (.stl and .off only those of faces) and refer to no
# other file: their readers take no folder, only whether colours are wanted.
MESH_SUFFIXES = tuple(READERS)
WIDE = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)

# What damaged structure makes a reader stumble over; the careful messages come before these.
SURPRISES = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)


class ReadOptions(NamedTuple):
    """Options of reading a file; see `paint3d.files.load.load_mesh`."""

    unit: str | None = None
    from_points: bool | None = None
    texture: bool = False
    up: str | None = None


@dataclass(frozen=True)
class Reading:
    """A mesh, and what is known of it.

    Attributes
    ----------
    mesh : TriangleMesh
    notes : tuple of Message
        What its reader has to tell the user.
    knows_up : bool
        Whether the file, or who asked, said which way is up.
    unit_mm : float
        Millimetres that one unit of the file was taken for.
    up : str
        The file's own axis that points up in the mesh, which stands with its z up.
    """

    mesh: TriangleMesh
    notes: tuple[Message, ...] = ()
    knows_up: bool = False
    unit_mm: float = 1.0
    up: str = "z"

    @cached_property
    def likely_up(self) -> Upright | None:
        """The likely up axis; None where it is known."""
        return None if self.knows_up else self.up_by_shape

    @cached_property
    def up_by_shape(self) -> Upright:
        """The up axis by the mesh's shape alone, whatever its file says."""
        return guess_up(self.mesh)

    @property
    def is_oddly_up(self) -> bool:
        """True if its shape surely stands otherwise than the mesh does."""
        return self.up_by_shape.sure and self.up_by_shape.up != "z"


AS_IT_IS = ReadOptions()


def take_object(mesh: object, wanted: ReadOptions = AS_IT_IS) -> Reading:
    """Check a mesh of another package (`files.package_meshes`) as one that was read.

    Raises
    ------
    MeshError
        One line with the object's class, reason and what was expected.
    """
    kind = package_class(mesh)
    name = kind or "this object"
    try:
        with np.errstate(all="ignore"):
            return _make_reading(read_object(mesh, wanted.texture), "mesh", wanted)
    except MeshError as cause:
        raise (MeshError("{name}: {cause}", name=name, cause=cause) if kind else cause) from None
    except SURPRISES as cause:
        raise MeshError(
            "{name}: its structure is damaged: {cause}",
            name=name,
            cause=_describe_damage(cause),
        ) from None


def read_surface_apart(
    path: Path,
    wanted: ReadOptions,
    seconds: float | None = None,
    progress: Progress | None = None,
    idle_seconds: float = MAX_IDLE_SECONDS,
) -> Reading:
    """Read a mesh file in a child process with 2 GiB of memory and 20 s, with pictures 60 s.

    The seconds are of computing; waiting for a core costs none, and of standing still, as for a
    slow disk, there may be `idle_seconds` besides. `progress` is given a fraction guessed from the
    file's size; what it raises ends the child.

    Raises
    ------
    MeshError
        As the reader says, or that it crashed, took too long or needed too much memory.
    """
    if seconds is None:
        seconds = PICTURE_SECONDS if wanted.texture else MAX_SECONDS
    reader = f"{__name__}:{child_surface.__name__}"
    arrays, facts = read_apart(path, reader, list(wanted), seconds, idle_seconds, progress)
    mesh = TriangleMesh(
        arrays["vertices"],
        arrays["faces"],
        arrays.get("colours"),
        str(facts["name"]),
        arrays.get("normals"),
    )
    notes = (*map(Message.from_json, facts["notes"]), *notes_of(facts))
    knows_up, unit_mm, up = facts["knows_up"], facts["unit_mm"], facts["up"]
    return Reading(mesh, notes, bool(knows_up), float(unit_mm), str(up))


def child_surface(path: Path, wanted: list[Any]) -> Found:
    """Read a mesh file in the child process: what `read_surface_apart` makes a `Reading` of."""
    reading = read_surface(path, ReadOptions(*wanted))
    mesh = reading.mesh
    arrays: dict[str, AnyArray] = {"vertices": mesh.vertices, "faces": mesh.faces}
    arrays |= {} if mesh.normals is None else {"normals": mesh.normals}
    arrays |= {} if mesh.colours is None else {"colours": mesh.colours}
    facts: dict[str, object] = {
        "name": mesh.name,
        "notes": [note.to_json() for note in reading.notes],
    }
    facts |= {"knows_up": reading.knows_up, "unit_mm": reading.unit_mm, "up": reading.up}
    return arrays, facts


def read_surface(path: Path, wanted: ReadOptions = AS_IT_IS) -> Reading:
    """Read a file, check its polygons and turn them into a mesh in mm, z up.

    Raises
    ------
    MeshError
        One line with file, reason and what was expected, whatever the file holds.
    """
    try:
        with np.errstate(all="ignore"):  # what is not finite in the end is refused
            return _make_reading(read_raw(path, wanted.texture), path.name.split(".")[0], wanted)
    except MeshError as cause:
        raise MeshError("{file}: {cause}", file=path, cause=cause) from None
    except MemoryError:
        raise MeshError("{file}: it does not fit into memory", file=path) from None
    except SURPRISES as cause:
        raise MeshError(
            "{file}: its structure is damaged: {cause}",
            file=path,
            cause=_describe_damage(cause),
        ) from None


def read_raw(path: Path, texture: bool = False) -> RawMesh:
    """Return a file's polygons as it has them, by the reader that its suffix names.

    Raises
    ------
    MeshError
        If the suffix is not known or the reader refuses the file; the file is not named.
    """
    suffix = _known_suffix(path)
    read: Callable[..., RawMesh] = resolve_name(f"paint3d.files.formats.{READERS[suffix]}")
    data = read_contents(path)
    if data.startswith(WIDE):
        data = plain_text(data)
    if suffix in BESIDE:
        return read(data, path.parent, texture)
    return read(data, texture) if suffix in WANT_TEXTURE else read(data)


def _describe_damage(cause: Exception) -> Message:
    """Describe the damaged structure that made a reader fail."""
    if isinstance(cause, KeyError):
        return Message("it lacks {part}", part=_one_line(cause)[:60])
    if isinstance(cause, IndexError):
        return Message("it refers to something that it does not have")
    if isinstance(cause, AttributeError | TypeError):
        return Message("a part of it is of another kind than is expected there")
    if isinstance(cause, RecursionError):
        return Message("its parts are nested too deeply")
    return Message("near {place}", place=_one_line(cause)[:160])


def _one_line(cause: BaseException) -> str:
    return " ".join(str(cause).split())


def _known_suffix(path: Path) -> str:
    inner = Path(path.stem) if path.suffix.lower() in PACKED else path
    suffix = RECORDS if inner.name.lower().endswith(RECORDS) else inner.suffix.lower()
    if suffix in READERS:
        return suffix
    known = " ".join(MESH_SUFFIXES)
    if suffix in UNREAD:
        raise MeshError(
            "{kind} is not read (Blender saves it as .glb); expected one of {known}",
            kind=UNREAD[suffix],
            known=known,
        )
    if suffix in DRAWINGS:
        raise MeshError(
            "{kind} is a flat drawing, which is no surface to paint on; expected one of {known}",
            kind=DRAWINGS[suffix],
            known=known,
            hint="write --svg paints it" if suffix == ".svg" else "",
        )
    if suffix:
        raise MeshError(
            "the suffix {suffix!r} is not known; expected one of {known}",
            suffix=suffix,
            known=known,
        )
    raise MeshError("it has no suffix; expected one of {known}", known=known)


def _make_reading(raw: RawMesh, name: str, wanted: ReadOptions) -> Reading:
    _check_raw(raw)
    up = wanted.up or raw.up or "z"
    turn = turn_up(up)
    raw = replace(
        raw,
        vertices=turn_rows(raw.vertices, turn),
        normals=None if raw.normals is None else turn_rows(raw.normals, turn),
    )
    unit_mm = UNITS_MM[wanted.unit] if wanted.unit else raw.unit_mm or 1.0
    reading = _check_mesh(raw, raw.vertices * unit_mm, name, wanted)
    knows_up = (wanted.up or raw.up) is not None
    return replace(reading, knows_up=knows_up, unit_mm=unit_mm, up=up)


def _check_mesh(
    raw: RawMesh, vertices: NDArray[np.float64], name: str, wanted: ReadOptions
) -> Reading:
    if len(raw.sizes) == 0:
        return _make_from_points(raw, vertices, name, wanted.from_points)
    pictured = raw.look_of is not None and len(raw.looks) > 0
    corners = np.arange(len(raw.corners)) if pictured else raw.corners
    faces = triangulate(vertices[raw.corners] if pictured else vertices, corners, raw.sizes)
    corners, faces = faces, raw.corners[faces] if pictured else faces
    distinct = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    notes = raw.notes
    if not distinct.all() and distinct.any():
        n = int((~distinct).sum())
        notes += (
            Message(
                "left out {n:,} face that names a vertex twice",
                "left out {n:,} faces that name a vertex twice",
                n=n,
            ),
        )
        faces, corners = faces[distinct], corners[distinct]
    normals = _unit_normals(raw.normals, vertices, faces)
    if raw.uv is None or raw.look_of is None or not pictured:
        return Reading(TriangleMesh(vertices, faces, raw.colours, name, normals), notes)
    polygon = np.repeat(np.arange(len(raw.sizes)), raw.sizes)
    draped = Draped(raw.uv[corners], raw.look_of[polygon[corners[:, 0]]], raw.looks)
    of_corners = None if raw.corner_colours is None else raw.corner_colours[corners]
    shown = show_pictures(vertices, faces, draped, raw.colours, normals, corner_colours=of_corners)
    normals = _unit_normals(shown.normals, shown[0], shown[1])
    return Reading(TriangleMesh(*shown[:3], name, normals), notes)


def _check_raw(raw: RawMesh) -> None:
    if len(raw.vertices) == 0:
        raise MeshError("it has no vertices and no triangles; expected a surface")
    bad = np.flatnonzero(~np.isfinite(raw.vertices).all(axis=1))
    if len(bad):
        where = ", ".join(f"{x:g}" for x in raw.vertices[bad[0]])
        raise MeshError(
            "vertex {first} is ({where}); expected finite numbers",
            first=bad[0],
            where=where,
        )
    n = len(raw.vertices)
    outside = np.flatnonzero((raw.corners < 0) | (raw.corners >= n))
    if len(outside):
        face = int(np.searchsorted(np.cumsum(raw.sizes), outside[0], side="right"))
        index = int(raw.corners[outside[0]])
        raise MeshError(
            "face {face} refers to vertex {index}; expected 0 to {last}",
            face=face,
            index=index,
            last=n - 1,
        )


def _make_from_points(
    raw: RawMesh, vertices: NDArray[np.float64], name: str, from_points: bool | None
) -> Reading:
    if from_points is None and raw.announces:
        raise MeshError(
            "it has {n:,} points but no triangles, though it says it has {announces}; expected a "
            "surface",
            hint="--from-points builds one through the points",
            n=len(vertices),
            announces=raw.announces,
        )
    if from_points is False:
        raise MeshError("it has {n:,} points but no triangles; expected a surface", n=len(vertices))
    from paint3d.files.points import surface_through

    faces = surface_through(vertices, raw.normals)
    note = Message(
        "it is a point cloud: built {n:,} triangles through {points:,} points",
        n=len(faces),
        points=len(vertices),
    )
    mesh = TriangleMesh(
        vertices, faces, raw.colours, name, _unit_normals(raw.normals, vertices, faces)
    )
    return Reading(mesh, (*raw.notes, note))


def _unit_normals(
    normals: NDArray[np.float64] | None, vertices: NDArray[np.float64], faces: NDArray[np.int64]
) -> NDArray[np.float64] | None:
    """Return normals of length 1; None where the file has no usable ones.

    Those of no length, or that are no numbers, are worked out from the faces.
    """
    if normals is None:
        return None
    length = np.linalg.norm(normals, axis=1)
    sound = np.isfinite(length) & (length > 1e-6)
    if not sound.any():
        return None
    unit = normals / np.where(sound, length, 1.0)[:, None]
    if not sound.all():
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        doubled = np.repeat(np.cross(b - a, c - a), 3, axis=0)  # weighted by area
        sums = [np.bincount(faces.ravel(), doubled[:, k], len(vertices)) for k in range(3)]
        own = np.stack(sums, axis=1)[~sound]
        own[~own.any(axis=1)] = (0.0, 0.0, 1.0)  # of no triangle
        unit[~sound] = own / np.linalg.norm(own, axis=1, keepdims=True)
    return unit
