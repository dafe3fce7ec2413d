"""Meshes that others' packages unpack or read: packed glTF and COLLADA."""

from __future__ import annotations

import base64
import io
import json
import random
import struct
import warnings
import zipfile
from collections.abc import Sequence
from typing import Any

import numpy as np

from scripts.fuzz.mutation import damage, damage_archive, damage_json
from scripts.fuzz.target import Target, file_of

__all__ = ["PACKED", "check_mesh"]

_JSON, _BIN = b"JSON", b"BIN\0"
_IN_TEXT = b"data:;base64,"


def check_mesh(suffix: str, content: bytes) -> None:
    """Read a mesh as the child process does; what comes out must be a mesh."""
    from paint3d.files.reading import ReadOptions, read_surface
    from paint3d.files.references import refers_to

    wanted = ReadOptions(from_points=False, texture=True)
    path = file_of(suffix, content)
    (path.parent / "none.txt").touch()
    refers_to(path, path.parent / "none.txt")  # whatever it is, this is no error
    mesh = read_surface(path, wanted).mesh
    assert np.isfinite(mesh.vertices).all()
    assert 0 <= mesh.faces.min() <= mesh.faces.max() < mesh.n_vertices


def _check_foreign(suffix: str, content: bytes) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the child process shows nobody what packages warn of
        check_mesh(suffix, content)


# -- glTF -------------------------------------------------------------------------------------


def _binary(document: bytes, data: bytes) -> bytes:
    """A .glb of these parts, each as long as it says."""
    document += b" " * (-len(document) % 4)
    data += bytes(-len(data) % 4)
    head = struct.pack("<4sIIII4s", b"glTF", 2, 0, 0, len(document), _JSON)
    head = head[:12] + head[16:]
    whole = head + document + struct.pack("<I4s", len(data), _BIN) + data
    return whole[:8] + struct.pack("<I", len(whole)) + whole[12:]


def _damage_gltf(data: bytes, chance: random.Random, others: Sequence[bytes]) -> bytes:
    """Damage the document or what it packs, with lengths and letters that stay whole.

    Damage from outside mostly ends at the header of a .glb, or at the document's syntax.
    """
    if chance.random() < 0.1:
        return damage(data, chance, others)
    if data[:4] == b"glTF":
        length = int.from_bytes(data[12:16], "little")
        document, rest = data[20 : 20 + length], data[28 + length :]
        if chance.random() < 0.5:
            return _binary(_damage_document(document, chance, others), rest)
        return _binary(document, damage(rest, chance, []))
    at = data.find(_IN_TEXT)
    if at < 0 or chance.random() < 0.5:
        return _damage_document(data, chance, others)
    start = at + len(_IN_TEXT)
    end = data.index(b'"', start)
    packed = damage(base64.b64decode(data[start:end]), chance, [])
    return data[:start] + base64.b64encode(packed) + data[end:]


def _damage_document(text: bytes, chance: random.Random, others: Sequence[bytes]) -> bytes:
    if chance.random() < 0.3:
        return damage(text, chance, others)
    return damage_json(text, chance)


def _ball() -> tuple[np.ndarray, np.ndarray]:
    import trimesh

    ball = trimesh.creation.icosphere(1)
    return ball.vertices.astype("<f4"), ball.faces.astype("<u4").ravel()


def _document(views: list[dict[str, Any]], accessors: list[dict[str, Any]]) -> dict[str, Any]:
    attributes = {"POSITION": 0} | ({"NORMAL": 2} if len(accessors) > 2 else {})
    return {
        "asset": {"version": "2.0"},
        "bufferViews": views,
        "accessors": accessors,
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 1}]}],
        "nodes": [{"mesh": 0, "scale": [2, 2, 2]}],
        "scenes": [{"nodes": [0]}],
    }


def _by_meshopt() -> bytes:
    import meshoptimizer as packer

    places, indices = _ball()
    n, m = len(places), len(indices)
    normals = np.round(127 * np.column_stack([places, np.ones(n)])).astype("i1")
    parts = [
        packer.encode_vertex_buffer(places, n, 12), packer.encode_index_buffer(indices, m, n),
        packer.encode_vertex_buffer(normals.view("<u4"), n, 4),
    ]  # fmt: skip
    at = np.cumsum([0, *map(len, parts)]).tolist()
    kinds = (("ATTRIBUTES", 12, n), ("TRIANGLES", 4, m), ("ATTRIBUTES", 4, n))
    views = [
        {"buffer": 1, "byteLength": size * count, "extensions": {"EXT_meshopt_compression": {
            "buffer": 0, "byteOffset": at[k], "byteLength": len(parts[k]), "byteStride": size,
            "count": count, "mode": mode, **({"filter": "OCTAHEDRAL"} if k == 2 else {})}}}
        for k, (mode, size, count) in enumerate(kinds)
    ]  # fmt: skip
    document = _document(
        views,
        [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": n},
            {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": m},
            {"bufferView": 2, "componentType": 5120, "type": "VEC3", "count": n,
             "normalized": True},
        ],
    )  # fmt: skip
    uri = (_IN_TEXT + base64.b64encode(b"".join(parts))).decode()
    document["buffers"] = [{"byteLength": at[-1], "uri": uri}, {"byteLength": 16 * n + 4 * m}]
    return json.dumps(document).encode()


def _quantized() -> bytes:
    """Positions as normalized int16 (KHR_mesh_quantization), sparse ones, and colours."""
    places, indices = _ball()
    n, m = len(places), len(indices)
    codes = np.round(32767 * np.column_stack([places, np.zeros(n)])).astype("<i2")
    few = np.array([0, 3, 5], "<u2").tobytes() + codes[[1, 2, 4], :3].astype("<i2").tobytes()
    data = codes.tobytes() + indices.astype("<u2").tobytes()
    views = [
        {"buffer": 0, "byteLength": 8 * n, "byteStride": 8},
        {"buffer": 0, "byteOffset": 8 * n, "byteLength": 2 * m},
        {"buffer": 0, "byteOffset": len(data), "byteLength": 6},
        {"buffer": 0, "byteOffset": len(data) + 6, "byteLength": 18},
    ]
    sparse = {"count": 3, "indices": {"bufferView": 2, "componentType": 5123},
              "values": {"bufferView": 3}}  # fmt: skip
    document = _document(
        views,
        [
            {"bufferView": 0, "componentType": 5122, "type": "VEC3", "count": n,
             "normalized": True, "sparse": sparse},
            {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": m},
        ],
    )  # fmt: skip
    document["extensionsRequired"] = ["KHR_mesh_quantization"]
    document["buffers"] = [{"byteLength": len(data) + 24}]
    return _binary(json.dumps(document).encode(), data + few)


def _by_draco() -> bytes:
    import trimesh

    ball = trimesh.creation.icosphere(1, radius=0.02)
    ball.visual.vertex_colors = np.tile([200, 30, 40, 255], (len(ball.vertices), 1))
    scene = trimesh.Scene({"ball": ball, "box": trimesh.creation.box((0.01, 0.02, 0.03))})
    return bytes(trimesh.exchange.gltf.export_glb(scene, extension_draco=True))


def _packed_seeds() -> list[tuple[str, bytes]]:
    return [(".gltf", _by_meshopt()), (".glb", _quantized()), (".glb", _by_draco())]


# -- what trimesh reads -------------------------------------------------------------------------


def _collada() -> bytes:
    import trimesh

    box = trimesh.creation.box((1.0, 2.0, 3.0))
    box.visual.vertex_colors = np.arange(32).reshape(8, 4).astype(np.uint8)
    found = box.export(file_type="dae")
    text = found if isinstance(found, bytes) else found.encode()
    start, _, rest = text.partition(b"<created>")  # the day is no part of a case
    _, _, text = rest.partition(b"</created>")
    start, rest = start + b"<created>2020-01-01T00:00:00</created>", text
    before, found_tag, text = rest.partition(b"<modified>")
    if found_tag:
        _, _, text = text.partition(b"</modified>")
        rest = before + b"<modified>2020-01-01T00:00:00</modified>" + text
    return start + rest


def _foreign_seeds() -> list[tuple[str, bytes]]:
    dae, package = _collada(), io.BytesIO()
    with zipfile.ZipFile(package, "w") as archive:
        archive.writestr(zipfile.ZipInfo("a.dae"), dae)
    return [
        (".dae", dae),
        (".zae", package.getvalue()),
    ]


def _damage_foreign(data: bytes, chance: random.Random, others: Sequence[bytes]) -> bytes:
    return (damage_archive if data.startswith(b"PK") else damage)(data, chance, others)


PACKED: dict[str, Target] = {
    "packed": Target(
        "glTF packed by Draco, meshopt, quantized", _packed_seeds, check_mesh, _damage_gltf
    ),
    "foreign": Target("meshes that trimesh reads", _foreign_seeds, _check_foreign, _damage_foreign),
}
