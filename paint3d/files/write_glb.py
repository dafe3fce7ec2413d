"""Binary glTF 2.0 with linear vertex colours and a material that is no metal."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = ["write_glb"]

FLOAT, UNSIGNED_SHORT, UNSIGNED_INT = 5126, 5123, 5125
VERTEX_DATA, INDEX_DATA = 34962, 34963
UNLIT = "KHR_materials_unlit"


def write_glb(
    path: Path,
    vertices: NDArray[np.float32],
    faces: NDArray[np.int32],
    normals: NDArray[np.float32],
    srgb: NDArray[np.uint8],
    *,
    name: str = "painting",
    roughness: float = 0.5,
    unlit: bool = False,
) -> None:
    """Write one mesh with vertex colours.

    COLOR_0 is linear by the specification, and 16 bits wide: 8-bit linear codes would keep only
    183 of the 256 sRGB ones. Without a material of metallic factor 0 viewers would show metal.

    Parameters
    ----------
    path : Path
    vertices : (V, 3) float32
        As in the file; by the specification metres, y up.
    faces : (F, 3) int32
    normals : (V, 3) float32
        Unit.
    srgb : (V, 3) uint8
    name : str
        Of mesh and material.
    roughness : float
        Of the material, 0 to 1.
    unlit : bool
        Show the colours without light (KHR_materials_unlit).

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    positions = np.ascontiguousarray(vertices, "<f4")
    blocks = [positions, np.ascontiguousarray(normals, "<f4"), _linear(srgb), faces.astype("<u4")]
    sizes = [block.nbytes for block in blocks]
    starts = np.cumsum([0, *sizes]).tolist()
    document = {
        "asset": {"version": "2.0", "generator": "paint3d"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": name}],
        "meshes": [{"name": name, "primitives": [_primitive()]}],
        "materials": [_material(name, roughness, unlit)],
        "accessors": _accessors(positions, faces),
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": size, "target": target}
            for start, size, target in zip(
                starts[:4], sizes, [VERTEX_DATA] * 3 + [INDEX_DATA], strict=True
            )
        ],
        "buffers": [{"byteLength": starts[4]}],
    }
    if unlit:
        document["extensionsUsed"] = [UNLIT]
    text = json.dumps(document, separators=(",", ":")).encode("utf-8")
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        for word in (0x46546C67, 2, 28 + len(text) + starts[4], len(text), 0x4E4F534A):
            file.write(word.to_bytes(4, "little"))
        file.write(text)
        for word in (starts[4], 0x004E4942):
            file.write(word.to_bytes(4, "little"))
        for block in blocks:
            file.write(memoryview(block).cast("B"))


def _linear(srgb: NDArray[np.uint8]) -> NDArray[np.uint16]:
    """Return linear RGBA, (V, 4) normalised uint16, of sRGB codes (IEC 61966-2-1)."""
    code = np.arange(256) / 255.0
    curve = np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)
    table = np.floor(65535.0 * curve + 0.5).astype("<u2")
    rgba = np.full((len(srgb), 4), 65535, "<u2")
    rgba[:, :3] = table[srgb]
    return rgba


def _primitive() -> dict:
    attributes = {"POSITION": 0, "NORMAL": 1, "COLOR_0": 2}
    return {"attributes": attributes, "indices": 3, "material": 0, "mode": 4}


def _material(name: str, roughness: float, unlit: bool) -> dict:
    surface = {"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0, "roughnessFactor": roughness}
    extensions = {"extensions": {UNLIT: {}}} if unlit else {}
    return {"name": name, "pbrMetallicRoughness": surface, "doubleSided": True, **extensions}


def _accessors(positions: NDArray[np.float32], faces: NDArray[np.int32]) -> list[dict]:
    n = len(positions)
    low, high = (limit.astype(float).tolist() for limit in (positions.min(0), positions.max(0)))
    return [
        {"bufferView": 0, "componentType": FLOAT, "count": n, "type": "VEC3"}
        | {"min": low, "max": high},
        {"bufferView": 1, "componentType": FLOAT, "count": n, "type": "VEC3"},
        {"bufferView": 2, "componentType": UNSIGNED_SHORT, "count": n, "type": "VEC4"}
        | {"normalized": True},
        {"bufferView": 3, "componentType": UNSIGNED_INT, "count": faces.size, "type": "SCALAR"},
    ]
