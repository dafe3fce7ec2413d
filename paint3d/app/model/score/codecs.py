"""Codecs of commands: their arguments as the words of a line, and back again.

A recording names no vertices, no faces and no files of one machine: so it can be played on the same
object from elsewhere, or on one that was meshed anew. A region of a mask is a point in it, an ink
of one's own table its spectrum. Which command has which codec is in `paint3d.app.model.commands`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np

from paint3d.app.model.brush_in_hand import resized
from paint3d.app.model.input.symmetry import MirrorPlane, RadialSymmetry, Symmetry
from paint3d.app.model.mask import AngleMask, Mask, RegionPick
from paint3d.app.model.persistence.brush_words import brush_from_words, brush_words
from paint3d.brush.presets import brush_names, load_brush
from paint3d.brush.spec import BristleSpec, BrushSpec
from paint3d.colour.ink_text import table_of
from paint3d.colour.materials import Material, load_material, material_names
from paint3d.colour.pigments import Pigment, load_pigment
from paint3d.core.array_state import record_words
from paint3d.errors import Paint3DError, PigmentError, RecordingError, UnknownNameError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.likeness import digest_of
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.painted_surface import PaintedSurface

__all__ = [
    "BRUSH",
    "DIP",
    "EDIT",
    "MASK",
    "PLAIN",
    "SEAL",
    "STROKE",
    "SYMMETRY",
    "TAGS",
    "Codec",
    "InkTable",
    "Vocabulary",
    "decode_brush",
    "decode_material",
    "encode_brush",
    "make_header",
]

JsonObject = dict[str, Any]
_REST = (0.0, 0.0, 0.0)
_UP = (0.0, 0.0, 1.0)


class InkTable:
    """Inks by the names that a score has for them.

    Parameters
    ----------
    table : dict
        Of the score's header: properties of pigments that are no palette's, by name; what is
        named comes into it.
    apart : bool
        Whether a second ink of the same name is distinguished from the first by a number.
    own_tables : bool
        Whether an ink may be that of a table on this machine; not where a file names it.
    """

    def __init__(
        self, table: dict[str, Any], *, apart: bool = False, own_tables: bool = True
    ) -> None:
        self.table, self._apart, self._own_tables = table, apart, own_tables
        self._own: dict[str, Pigment] = {}

    @classmethod
    def of(cls, words: Mapping[str, Any], *, apart: bool = False) -> InkTable:
        """The table of a header or a line, which has its inks under "pigments"."""
        return cls(dict(words.get("pigments", {})), apart=apart)

    def encode(self, ink: str | Pigment | Mapping[Any, float]) -> str | dict[str, float]:
        """Encode an ink, or a mixture of several.

        Raises
        ------
        RecordingError
            If there are two inks of one name, and they are not distinguished.
        Paint3DError
            If an ink is not known, or of a table that may not be read.
        """
        if not isinstance(ink, Mapping):
            return self._name(ink)
        parts: dict[str, float] = {}
        for one, weight in ink.items():
            name = self._name(one)
            parts[name] = parts.get(name, 0.0) + float(weight)
        return parts

    def _name(self, ink: str | Pigment) -> str:
        if isinstance(ink, str) and table_of(ink) is None:
            return ink
        pigment = load_pigment(ink, own_tables=self._own_tables) if isinstance(ink, str) else ink
        names = (pigment.name if k == 1 else f"{pigment.name} ({k})" for k in count(1))
        for name in names if self._apart else (pigment.name,):
            known = self._known(name)
            if known is None:
                self._own[name] = pigment
                given = record_words(pigment)
                self.table[name] = {k: v for k, v in given.items() if v is not None and k != "name"}
                if name != pigment.name:
                    self.table[name]["name"] = pigment.name
                return name
            if known.is_like(pigment):
                return name
        raise RecordingError(
            "there are two inks named {pigment!r}; expected one",
            pigment=pigment.name,
        )

    def _known(self, name: str) -> Pigment | None:
        try:
            return self._pigment(name)
        except Paint3DError:
            return None

    def decode(self, words: str | Mapping[str, float]) -> str | Pigment | dict[Any, float]:
        """Decode the ink that a score writes so.

        Raises
        ------
        PigmentError, UnknownNameError
            If one is not known, or of a table on this machine.
        """
        if isinstance(words, str):
            return self._own_or_name(words)
        return {self._own_or_name(name): float(weight) for name, weight in words.items()}

    def _own_or_name(self, name: str) -> str | Pigment:
        pigment = self._pigment(name)
        return pigment if name in self.table else name

    def _pigment(self, name: str) -> Pigment:
        if name in self.table and name not in self._own:
            self._own[name] = Pigment(**{"name": name, "chinese": "", **self.table[name]})
        return self._own.get(name) or load_pigment(name, own_tables=False)


def encode_brush(brush: BrushSpec) -> str | JsonObject:
    """Encode a brush: by its name where it is a preset, else with all its parameters."""
    if brush.name in brush_names() and load_brush(brush.name) == brush:
        return brush.name
    return brush_words(brush)


def decode_brush(words: Mapping[str, Any], default: str) -> BrushSpec:
    """The brush that a line or a header says, of the length and with the hairs that it says.

    Raises
    ------
    UnknownNameError, BrushError
        If there is no such preset, or it describes no brush.
    """
    value = words.get("brush", default)
    if isinstance(value, str):
        if value not in brush_names():  # a recording names no files of this machine
            raise UnknownNameError("brush", value, brush_names())
        brush = load_brush(value)
    else:
        brush = brush_from_words(value)
    if "length_mm" in words:
        brush = resized(brush, words["length_mm"])
    if "hairs" in words:
        hairs = None
        if words["hairs"]:
            spec = brush.bristles or BristleSpec()
            hairs = dataclasses.replace(spec, n_hairs=words["hairs"])
        brush = dataclasses.replace(brush, bristles=hairs)
    return brush


def make_header(
    surface: PaintedSurface,
    brush: BrushSpec,
    ink: str | Pigment | Mapping[Any, float],
    inks: InkTable,
) -> JsonObject:
    """Header of a score: the object, and the brush in hand at the beginning."""
    original, first = surface.original, JsonObject()
    if original is not None:
        first["painted_on"] = _encode_mesh(original.mesh, original.resolution)
    return first | {
        **_encode_mesh(surface.source, surface.resolution),
        "material": _encode_material(surface.material),
        "brush": encode_brush(brush),
        "ink": inks.encode(ink),
    }


def _encode_mesh(mesh: TriangleMesh, resolution: float | None) -> JsonObject:
    return {"object": mesh.name, "mesh": digest_of(mesh), "resolution_mm": resolution}


def _encode_material(material: Material) -> str | JsonObject:
    if material.name in material_names() and load_material(material.name) is material:
        return material.name
    return record_words(material)


_RATED = ("rated_absorbency", "rated_friction")  # before model 10; brushes are rated on xuan since


def decode_material(header: Mapping[str, Any]) -> Material:
    """The material that a header says; porcelain where it says none.

    Raises
    ------
    UnknownNameError, PigmentError
        If there is none of that name, or it describes none.
    """
    value = header.get("material", "porcelain")
    if isinstance(value, str):
        if value not in material_names():  # a recording names no files of this machine
            raise UnknownNameError("material", value, material_names())
        return load_material(value)
    try:
        return Material(**{key: value[key] for key in value if key not in _RATED})
    except TypeError as cause:
        raise PigmentError("this describes no material: {cause}", cause=cause) from None


# ---- Codecs --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Vocabulary:
    """Objects that the fields of a line refer to.

    Attributes
    ----------
    surface : PaintedSurface
        Of the painting that is asked.
    inks : InkTable
    exact : bool
        Whether the line is only for this painting, so that it may name faces by their numbers.
    """

    surface: PaintedSurface
    inks: InkTable
    exact: bool = False


_Conversion = Callable[[Mapping[str, Any], Vocabulary], dict[str, Any]]


@dataclass(frozen=True)
class Codec:
    """Encoding and decoding of a command's arguments.

    Attributes
    ----------
    encode : callable
        From arguments by name to the fields of a line. Raises RecordingError for a value that no
        line can hold, another Paint3DError for one that the document refuses.
    decode : callable
        And back. Raises Paint3DError where a brush or an ink is not known, or a value is out of its
        range.
    """

    encode: _Conversion
    decode: _Conversion


def _encode_value(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _encode_value(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_encode_value(item) for item in value]
    if isinstance(value, str | int | float | bool) or value is None:
        return value
    raise RecordingError(
        "a recording cannot hold a value of type {kind}", kind=type(value).__name__
    )


def _encode_plain(arguments: Mapping[str, Any], _: Vocabulary) -> JsonObject:
    return {key: _encode_value(value) for key, value in arguments.items()}


PLAIN = Codec(_encode_plain, lambda fields, _: dict(fields))
"""Numbers, texts, lists and mappings of them, as they are."""

TAGS = Codec(
    lambda arguments, _: {"tags": _encode_value(arguments.get("tags", {}))},
    lambda fields, _: dict(fields["tags"]),
)
"""Of a method that takes whatever it is given by name."""


def _encode_brush_argument(arguments: Mapping[str, Any], _: Vocabulary) -> JsonObject:
    brush = arguments["brush"]
    if isinstance(brush, Mapping):
        brush = brush_from_words(brush)
    return {"brush": encode_brush(brush) if isinstance(brush, BrushSpec) else brush}


BRUSH = Codec(_encode_brush_argument, lambda fields, _: {"brush": decode_brush(fields, "")})
"""A brush, by its name or by all its parameters."""


def _encode_ink(arguments: Mapping[str, Any], vocabulary: Vocabulary) -> JsonObject:
    inks = vocabulary.inks
    return {k: inks.encode(v) if k == "ink" else _encode_value(v) for k, v in arguments.items()}


def _decode_ink(fields: Mapping[str, Any], vocabulary: Vocabulary) -> dict[str, Any]:
    return {**fields} | ({"ink": vocabulary.inks.decode(fields["ink"])} if "ink" in fields else {})


DIP = SEAL = Codec(_encode_ink, _decode_ink)
"""An ink, and plain values."""


def _encode_stroke(arguments: Mapping[str, Any], vocabulary: Vocabulary) -> JsonObject:
    empty = {key for key in ("loads", "strengths") if key in arguments and not len(arguments[key])}
    own = _encode_brush_argument(arguments, vocabulary) if "brush" in arguments else {}
    rest = {key: value for key, value in arguments.items() if key not in empty | {"brush"}}
    return _encode_ink(rest, vocabulary) | own


def _decode_stroke(fields: Mapping[str, Any], vocabulary: Vocabulary) -> dict[str, Any]:
    own = {"brush": decode_brush(fields, "")} if "brush" in fields else {}
    return _decode_ink(fields, vocabulary) | own


STROKE = Codec(_encode_stroke, _decode_stroke)
"""What a stroke begins with."""


def _encode_edit(arguments: Mapping[str, Any], vocabulary: Vocabulary) -> JsonObject:
    edit = dict(arguments["edit"])
    if isinstance(edit.get("brush"), BrushSpec):
        edit["brush"] = encode_brush(edit["brush"])
    which = {key: _encode_value(value) for key, value in arguments.items() if key != "edit"}
    return which | {"edit": _encode_ink(edit, vocabulary)}


def _decode_edit(fields: Mapping[str, Any], vocabulary: Vocabulary) -> dict[str, Any]:
    # as older journals call them, all from 0
    now = {"places": "indices", "numbers": "indices", "place": "index", "number": "index"}
    which = {now.get(key, key): value for key, value in fields.items()}
    return {**which, "edit": _decode_ink(fields["edit"], vocabulary)}


EDIT = Codec(_encode_edit, _decode_edit)
"""Which strokes or which seal, and an edit as `Document.edit_strokes` or `edit_seal` takes it."""


def _encode_symmetry(arguments: Mapping[str, Any], _: Vocabulary) -> JsonObject:
    symmetry = arguments["symmetry"]
    fields: JsonObject = {}
    if symmetry.planes:
        fields["planes"] = [
            {"point": _encode_value(plane.point), "normal": _encode_value(plane.normal)}
            for plane in symmetry.planes
        ]
    if symmetry.radial is not None:
        radial = symmetry.radial
        fields["radial"] = {"count": radial.count, "point": _encode_value(radial.point),
                          "axis": _encode_value(radial.axis)}  # fmt: skip
    return fields


def _decode_symmetry(fields: Mapping[str, Any], _: Vocabulary) -> dict[str, Any]:
    planes = tuple(
        MirrorPlane(tuple(plane["point"]), tuple(plane["normal"]))
        for plane in fields.get("planes", ())
    )
    radial = fields.get("radial")
    turns = None
    if radial is not None:
        point, axis = tuple(radial.get("point", _REST)), tuple(radial.get("axis", _UP))
        turns = RadialSymmetry(radial["count"], point, axis)
    return {"symmetry": Symmetry(planes, turns)}


SYMMETRY = Codec(_encode_symmetry, _decode_symmetry)


def _encode_mask(arguments: Mapping[str, Any], vocabulary: Vocabulary) -> JsonObject:
    mask, fields = arguments["mask"], JsonObject()
    if mask.angle is not None:
        fields["angle"] = {
            "direction": _encode_value(mask.angle.direction),
            "degrees": mask.angle.degrees,
        }
    if mask.regions:
        fields["regions"] = [
            {
                **({"face": int(pick.face)} if vocabulary.exact
                   else {"at": _face_centre(vocabulary.surface, pick.face)}),
                "up_to": pick.up_to,
                "degrees": pick.degrees,
            }
            for pick in mask.regions
        ]  # fmt: skip
    return fields | ({"inverted": True} if mask.inverted else {})


def _face_centre(surface: PaintedSurface, face: int) -> list[float]:
    mesh = surface.paint_mesh
    if not 0 <= face < len(mesh.base_faces):
        raise RecordingError("face {face} is none of the object's", face=face)
    corners = mesh.vertices[mesh.base_faces[face]].astype(np.float64)
    middle: list[float] = corners.mean(axis=0).tolist()
    return middle


def _decode_mask(fields: Mapping[str, Any], vocabulary: Vocabulary) -> dict[str, Any]:
    angle, regions = fields.get("angle"), fields.get("regions", ())
    faces = [region.get("face") for region in regions]
    if None in faces:
        mesh = vocabulary.surface.paint_mesh
        bare = TriangleMesh(mesh.vertices[: mesh.n_base_vertices], mesh.base_faces)
        points = np.array([region["at"] for region in regions])
        faces = ClosestPoints(bare).find(points).faces.tolist()
    picks = tuple(
        RegionPick(face, region.get("up_to", "crease"), region.get("degrees", 30.0))
        for face, region in zip(faces, regions, strict=True)
    )
    leaning = None if angle is None else AngleMask(tuple(angle["direction"]), angle["degrees"])
    return {"mask": Mask(leaning, picks, fields.get("inverted", False))}


MASK = Codec(_encode_mask, _decode_mask)
