"""The GLB container: a JSON document, then the bytes of its buffer views."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import ExportError
from paint3d.files.writers.finish import Finish

__all__ = [
    "GENERATOR",
    "INDEX_DATA",
    "VERTEX_DATA",
    "material",
    "vertex_accessor",
    "write_container",
]

GENERATOR = "paint3d"
"""What a file says made it."""
FLOAT = 5126
LARGEST = (1 << 32) - 1
VERTEX_DATA, INDEX_DATA = 34962, 34963
UNLIT = "KHR_materials_unlit"
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}


def write_container(
    path: Path, document: dict[str, Any], blocks: Sequence[tuple[AnyArray | bytes, int | None]]
) -> None:
    """Write a scene of one mesh, whose nodes, buffers and views are added to its document.

    Parameters
    ----------
    path : Path
    document : dict
        With meshes, materials and accessors; these refer to `blocks` by their places.
    blocks : sequence of (array or bytes, target or None)
        What the buffer views hold, in order, and what the graphics card takes them for.

    Raises
    ------
    ExportError
        If the file would be larger than the format can say.
    OSError
        If the file cannot be written.
    """
    name = document["meshes"][0]["name"]
    views, end = [], 0
    contents = [np.ascontiguousarray(b).data.cast("B") if isinstance(b, np.ndarray) else b
                for b, _ in blocks]  # fmt: skip
    for content, (_, target) in zip(contents, blocks, strict=True):
        view = {"buffer": 0, "byteOffset": end, "byteLength": len(content)}
        views.append(view | ({} if target is None else {"target": target}))
        end += len(content) + -len(content) % 4
    document = {
        "asset": {"version": "2.0", "generator": GENERATOR},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": name}],
        **document,
        "bufferViews": views,
        "buffers": [{"byteLength": end}],
    }
    if any(UNLIT in one.get("extensions", {}) for one in document["materials"]):
        document["extensionsUsed"] = [UNLIT]
    text = json.dumps(document, separators=(",", ":")).encode("utf-8")
    text += b" " * (-len(text) % 4)
    if 28 + len(text) + end > LARGEST:
        raise ExportError(f"a binary glTF holds 4 GiB at most; this one would have {end:,} bytes")
    with open(path, "wb") as file:
        for word in (0x46546C67, 2, 28 + len(text) + end, len(text), 0x4E4F534A):
            file.write(word.to_bytes(4, "little"))
        file.write(text)
        for word in (end, 0x004E4942):
            file.write(word.to_bytes(4, "little"))
        for content in contents:
            file.write(content)
            file.write(bytes(-len(content) % 4))


def material(finish: Finish, unlit: bool, **surface: object) -> dict[str, Any]:
    """Return a material that is no metal: without one, viewers would show metal."""
    surface |= {"metallicFactor": 0, "roughnessFactor": finish.roughness}
    extensions: dict[str, Any] = {"extensions": {UNLIT: {}}} if unlit else {}
    return {"name": finish.name, "pbrMetallicRoughness": surface, "doubleSided": True, **extensions}


def vertex_accessor(
    view: int, values: NDArray[np.float32], *, limits: bool = False
) -> dict[str, Any]:
    """Return the accessor of float32 numbers (V,) or vectors (V, 2 or 3), with limits if wanted."""
    accessor: dict[str, Any] = {"bufferView": view, "componentType": FLOAT, "count": len(values)}
    accessor["type"] = TYPES[values.size // len(values)]
    if limits:
        for key, limit in (("min", values.min(axis=0)), ("max", values.max(axis=0))):
            accessor[key] = limit.astype(float).tolist()
    return accessor
