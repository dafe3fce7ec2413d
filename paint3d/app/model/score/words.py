"""What is asked of a document, as a line of a score says it, and back again.

A score knows no numbers of vertices and faces and no files of one machine: so it can be played on
the same object from elsewhere, or on one that was meshed anew. A colour that was picked is the dip
that it led to, a region of a mask a place in it, an ink of one's own table its spectrum.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from paint3d.app.model.brush_size import resized
from paint3d.app.model.input.symmetry import MirrorPlane, RadialSymmetry, Symmetry
from paint3d.app.model.mask import AngleMask, Mask, RegionPick
from paint3d.app.model.persistence.brush_words import brush_from_words, brush_words
from paint3d.brush.presets import brush_names, load_brush
from paint3d.brush.spec import BristleSpec, BrushSpec
from paint3d.colour.ink_text import table_of
from paint3d.colour.materials import Material, load_material, material_names
from paint3d.colour.pigments import Pigment, load_pigment
from paint3d.errors import Paint3DError, PigmentError, RecordingError, UnknownNameError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.likeness import digest_of
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["Inks", "asked_by", "brush_in", "brush_named", "header_of", "line_of", "material_in"]

Words = dict[str, Any]
_REST = (0.0, 0.0, 0.0)
_UP = (0.0, 0.0, 1.0)


class Inks:
    """Inks by the names that a score has for them.

    Parameters
    ----------
    table : dict
        Of the score's header: properties of pigments that are no palette's, by name; what is
        named comes into it.
    """

    def __init__(self, table: dict[str, Any]) -> None:
        self.table = table
        self._own: dict[str, Pigment] = {}

    def words(self, ink: str | Pigment | Mapping[Any, float]) -> str | dict[str, float]:
        """How a score says an ink, or a mixture of several.

        Raises
        ------
        RecordingError
            If there are two inks of one name.
        Paint3DError
            If an ink is not known.
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
        pigment = load_pigment(ink) if isinstance(ink, str) else ink
        known = self._known(pigment.name)
        if known is None:
            self._own[pigment.name] = pigment
            self.table[pigment.name] = _pigment_words(pigment)
        elif not known.is_like(pigment):
            raise RecordingError(f"there are two inks named {pigment.name!r}; expected one")
        return pigment.name

    def _known(self, name: str) -> Pigment | None:
        try:
            return self._pigment(name)
        except Paint3DError:
            return None

    def mixture(self, words: str | Mapping[str, float]) -> str | Pigment | dict[Any, float]:
        """The ink that was said.

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
            self._own[name] = Pigment(name, **{"chinese": "", **self.table[name]})
        return self._own.get(name) or load_pigment(name, own_tables=False)


def _pigment_words(pigment: Pigment) -> Words:
    given = {f.name: getattr(pigment, f.name) for f in fields(pigment) if f.name != "name"}
    return {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in given.items()}


def brush_named(brush: BrushSpec) -> str | Words:
    """How a score says a brush: by its name where it is a preset, else with all its parameters."""
    if brush.name in brush_names() and load_brush(brush.name) == brush:
        return brush.name
    return brush_words(brush)


def brush_in(words: Mapping[str, Any], default: str) -> BrushSpec:
    """The brush that a line or a header says, of the length and with the hairs that it says.

    Raises
    ------
    UnknownNameError, BrushError
        If there is no such preset, or it describes no brush.
    """
    said = words.get("brush", default)
    if isinstance(said, str):
        if said not in brush_names():  # a recording names no files of this machine
            raise UnknownNameError("brush", said, brush_names())
        brush = load_brush(said)
    else:
        brush = brush_from_words(said)
    if "length_mm" in words:
        brush = resized(brush, words["length_mm"])
    if "hairs" in words:
        hairs = None
        if words["hairs"]:
            spec = brush.bristles or BristleSpec()
            hairs = dataclasses.replace(spec, n_hairs=words["hairs"])
        brush = dataclasses.replace(brush, bristles=hairs)
    return brush


def header_of(
    surface: PaintedSurface, brush: BrushSpec, ink: str | Pigment | Mapping[Any, float], inks: Inks
) -> Words:
    """What a header says of the object, and of the brush that is in hand at the beginning."""
    original, first = surface.original, Words()
    if original is not None:
        first["painted_on"] = _mesh_said(original.mesh, original.resolution)
    return first | {
        **_mesh_said(surface.source, surface.resolution),
        "material": _material_said(surface.material),
        "brush": brush_named(brush),
        "ink": inks.words(ink),
    }


def _mesh_said(mesh: TriangleMesh, resolution: float | None) -> Words:
    return {"object": mesh.name, "mesh": digest_of(mesh), "resolution_mm": resolution}


def _material_said(material: Material) -> str | Words:
    if material.name in material_names() and load_material(material.name) is material:
        return material.name
    words = {f.name: getattr(material, f.name) for f in fields(material)}
    return {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in words.items()}


def material_in(header: Mapping[str, Any]) -> Material:
    """The material that a header says; porcelain where it says none.

    Raises
    ------
    UnknownNameError, PigmentError
        If there is none of that name, or it describes none.
    """
    said = header.get("material", "porcelain")
    if isinstance(said, str):
        if said not in material_names():  # a recording names no files of this machine
            raise UnknownNameError("material", said, material_names())
        return load_material(said)
    try:
        return Material(**said)
    except TypeError as cause:
        raise PigmentError(f"this describes no material: {cause}") from None


# -- a command as a line --------------------------------------------------------------------


def line_of(name: str, asked: Mapping[str, Any], surface: PaintedSurface, inks: Inks) -> Words:
    """A command as a score says it.

    Parameters
    ----------
    name : str
        Of a method of `Document`.
    asked : mapping
        What it was called with, by the names of its parameters.
    surface : PaintedSurface
    inks : Inks

    Raises
    ------
    RecordingError
        If it is nothing that a score can say.
    """
    say = _SAID.get(name, _plainly)
    given = {key: value for key, value in asked.items() if value is not None and value != ""}
    return {"do": name, **say(given, surface, inks)}


def _plainly(asked: Mapping[str, Any], _: PaintedSurface, __: Inks) -> Words:
    return {key: _plain(value) for key, value in asked.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, str | int | float | bool) or value is None:
        return value
    raise RecordingError(f"{type(value).__name__} is nothing that a recording can say")


def _brush_said(asked: Mapping[str, Any], _: PaintedSurface, __: Inks) -> Words:
    brush = asked["brush"]
    if isinstance(brush, Mapping):
        brush = brush_from_words(brush)
    return {"brush": brush_named(brush) if isinstance(brush, BrushSpec) else brush}


def _dip_said(asked: Mapping[str, Any], _: PaintedSurface, inks: Inks) -> Words:
    said = {"ink": inks.words(asked["ink"])} if "ink" in asked else {}
    said |= {"amount": _plain(asked["amount"])} if "amount" in asked else {}
    return said | ({"reach": float(asked["reach"])} if "reach" in asked else {})


def _stroke_said(asked: Mapping[str, Any], surface: PaintedSurface, inks: Inks) -> Words:
    said: Words = {"time_s": asked["time_s"]} if "time_s" in asked else {}
    own = _brush_said(asked, surface, inks) if "brush" in asked else {}
    own |= {name: _plain(asked[name]) for name in ("loads", "strengths") if asked.get(name)}
    return said | own | ({"ink": inks.words(asked["ink"])} if "ink" in asked else {})


def _seal_said(asked: Mapping[str, Any], _: PaintedSurface, inks: Inks) -> Words:
    said: Words = _plain({key: value for key, value in asked.items() if key != "ink"})
    return said | ({"ink": inks.words(asked["ink"])} if "ink" in asked else {})


def _symmetry_said(asked: Mapping[str, Any], _: PaintedSurface, __: Inks) -> Words:
    symmetry = asked["symmetry"]
    said: Words = {}
    if symmetry.planes:
        said["planes"] = [
            {"point": _plain(plane.point), "normal": _plain(plane.normal)}
            for plane in symmetry.planes
        ]
    if symmetry.radial is not None:
        radial = symmetry.radial
        said["radial"] = {"count": radial.count, "point": _plain(radial.point),
                          "axis": _plain(radial.axis)}  # fmt: skip
    return said


def _mask_said(asked: Mapping[str, Any], surface: PaintedSurface, _: Inks) -> Words:
    mask, said = asked["mask"], dict[str, Any]()
    if mask.angle is not None:
        said["angle"] = {"direction": _plain(mask.angle.direction), "degrees": mask.angle.degrees}
    if mask.regions:
        said["regions"] = [
            {"at": _middle_of(surface, pick.face), "up_to": pick.up_to, "degrees": pick.degrees}
            for pick in mask.regions
        ]
    return said | ({"inverted": True} if mask.inverted else {})


def _middle_of(surface: PaintedSurface, face: int) -> list[float]:
    mesh = surface.paint_mesh
    if not 0 <= face < len(mesh.base_faces):
        raise RecordingError(f"face {face} is none of the object's")
    corners = mesh.vertices[mesh.base_faces[face]].astype(np.float64)
    middle: list[float] = corners.mean(axis=0).tolist()
    return middle


_SAID: Mapping[str, Callable[[Mapping[str, Any], PaintedSurface, Inks], Words]] = {
    "begin_stroke": _stroke_said,
    "set_brush": _brush_said,
    "dip": _dip_said,
    "press_seal": _seal_said,
    "set_symmetry": _symmetry_said,
    "set_mask": _mask_said,
    "set_tags": lambda asked, _, __: {"tags": _plain(asked.get("tags", {}))},
}


# -- a line as a command --------------------------------------------------------------------


def asked_by(line: Mapping[str, Any], surface: PaintedSurface, inks: Inks) -> Words:
    """What a document's method of the line's name is to be called with.

    Raises
    ------
    Paint3DError
        If a brush or an ink is not known, or a value is out of its range.
    """
    name = line["do"]
    given = {key: value for key, value in line.items() if key not in ("do", "refused", "times")}
    if name in _ASKED:
        return _ASKED[name](given, surface, inks)
    return given


def _symmetry_asked(given: Mapping[str, Any], _: PaintedSurface, __: Inks) -> Words:
    planes = tuple(
        MirrorPlane(tuple(plane["point"]), tuple(plane["normal"]))
        for plane in given.get("planes", ())
    )
    radial = given.get("radial")
    turns = None
    if radial is not None:
        point, axis = tuple(radial.get("point", _REST)), tuple(radial.get("axis", _UP))
        turns = RadialSymmetry(radial["count"], point, axis)
    return {"symmetry": Symmetry(planes, turns)}


def _mask_asked(given: Mapping[str, Any], surface: PaintedSurface, _: Inks) -> Words:
    angle = given.get("angle")
    regions = given.get("regions", ())
    faces = _faces_at(surface, [region["at"] for region in regions]) if regions else []
    picks = tuple(
        RegionPick(face, region.get("up_to", "crease"), region.get("degrees", 30.0))
        for face, region in zip(faces, regions, strict=True)
    )
    leaning = None if angle is None else AngleMask(tuple(angle["direction"]), angle["degrees"])
    return {"mask": Mask(leaning, picks, given.get("inverted", False))}


def _faces_at(surface: PaintedSurface, places: list[list[float]]) -> list[int]:
    mesh = surface.paint_mesh
    bare = TriangleMesh(mesh.vertices[: mesh.n_base_vertices], mesh.base_faces)
    found: list[int] = ClosestPoints(bare).find(np.array(places)).faces.tolist()
    return found


def _stroke_asked(given: Mapping[str, Any], _: PaintedSurface, inks: Inks) -> Words:
    own = dict(given)
    if "brush" in given:
        own["brush"] = brush_in(given, "")
    if "ink" in given:
        own["ink"] = inks.mixture(given["ink"])
    return own


def _dip_asked(given: Mapping[str, Any], _: PaintedSurface, inks: Inks) -> Words:
    own = {"ink": inks.mixture(given["ink"])} if "ink" in given else {}
    own |= {"amount": given["amount"]} if "amount" in given else {}
    return own | ({"reach": given["reach"]} if "reach" in given else {})


def _seal_asked(given: Mapping[str, Any], _: PaintedSurface, inks: Inks) -> Words:
    own = {"ink": inks.mixture(given["ink"])} if "ink" in given else {}
    return {**given, **own}


_ASKED: Mapping[str, Callable[[Mapping[str, Any], PaintedSurface, Inks], Words]] = {
    "begin_stroke": _stroke_asked,
    "set_brush": lambda given, _, __: {"brush": brush_in(given, "")},
    "dip": _dip_asked,
    "press_seal": _seal_asked,
    "set_symmetry": _symmetry_asked,
    "set_mask": _mask_asked,
    "set_tags": lambda given, _, __: dict(given["tags"]),
}
