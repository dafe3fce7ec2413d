"""Whether the parts of a glTF document are of the kinds that the specification asks for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from paint3d.errors import MeshError

__all__ = ["check_kinds"]

KINDS = {
    dict: "an object",
    list: "a list",
    str: "a text",
    type(None): "null",
    bool: "true or false",
}
PARTS: dict[str, dict[str, type]] = {  # what is read of the entries of each list
    "accessors": {"sparse": dict},
    "buffers": {"uri": str},
    "bufferViews": {"extensions": dict},
    "images": {"uri": str},
    "materials": {"pbrMetallicRoughness": dict, "extensions": dict},
    "meshes": {"primitives": list},
    "nodes": {"children": list, "matrix": list, "rotation": list, "scale": list,
              "translation": list},
    "samplers": {},
    "scenes": {"nodes": list},
    "textures": {},
}  # fmt: skip
PRIMITIVE = {"attributes": dict, "extensions": dict}
SURFACE = {"baseColorTexture": dict, "baseColorFactor": list}


def check_kinds(document: Mapping[str, Any]) -> None:
    """Refuse a document that is of another version, or whose parts are of another kind.

    Raises
    ------
    MeshError
        Naming the part, what it is, and what was expected.
    """
    _check(document, {"asset": dict}, "")
    version = str(document.get("asset", {}).get("version", "2.0"))
    if not version.startswith("2."):
        raise MeshError(f"it is glTF version {version:.20}; expected 2")
    if isinstance(document.get("scenes"), dict):  # named, not counted, as in the first version
        raise MeshError("its scenes are named, as in glTF version 1; expected 2")
    _check(document, dict.fromkeys(PARTS, list), "")
    for name, kinds in PARTS.items():
        for k, entry in enumerate(document.get(name, [])):
            place = f"{name}[{k}]"
            _expect(entry, dict, place)
            _check(entry, kinds, f"{place}.")
            if name == "meshes":
                for j, primitive in enumerate(entry.get("primitives", [])):
                    _expect(primitive, dict, f"{place}.primitives[{j}]")
                    _check(primitive, PRIMITIVE, f"{place}.primitives[{j}].")
            elif name == "materials":
                inner = entry.get("pbrMetallicRoughness", {})
                _check(inner, SURFACE, f"{place}.pbrMetallicRoughness.")


def _check(entry: Mapping[str, Any], kinds: Mapping[str, type], place: str) -> None:
    for name, kind in kinds.items():
        if name in entry:
            _expect(entry[name], kind, f"{place}{name}")


def _expect(value: object, kind: type, place: str) -> None:
    if not isinstance(value, kind):
        found = KINDS.get(type(value), "a number")
        raise MeshError(f"its {place} is {found}; expected {KINDS[kind]}")
