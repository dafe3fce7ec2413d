"""The outer layers of glTF 2.0: the GLB container, buffers and accessors."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import ExportError, MeshError
from paint3d.files.contents import parse_json, read_beside
from paint3d.files.raw_mesh import check_count
from paint3d.files.finish import Finish

__all__ = [
    "GENERATOR",
    "INDEX_DATA",
    "VERTEX_DATA",
    "GltfFile",
    "check_kinds",
    "material",
    "unpack_draco",
    "unpack_meshopt",
    "vertex_accessor",
    "write_container",
]

# ---- The GLB container ---------------------------------------------------------------------------
# The GLB container: a JSON document, then the bytes of its buffer views.


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


# --------------------------------------------------------------------------------------------------


# ---- What is packed ------------------------------------------------------------------------------
# What is packed in a glTF: primitives by Draco (KHR_draco_mesh_compression, unpacked by DracoPy)
# and buffer views by meshopt (EXT_meshopt_compression, unpacked by meshoptimizer).


_HOW = "pip install 'paint3d[meshes]', or expected an uncompressed file"


def unpack_draco(
    data: bytes, primitive: dict[str, Any], asked: dict[str, int]
) -> dict[int, AnyArray]:
    """The values that a packed primitive's accessors stand for.

    Parameters
    ----------
    data : bytes
        The packed primitive.
    primitive : dict
        As the document has it: accessors by the names of attributes, and the indices'.
    asked : dict
        Draco's numbers of attributes by their names, as the extension says.

    Returns
    -------
    dict
        (N, width) arrays by the numbers of accessors; indices as one column.

    Raises
    ------
    MeshError
        If DracoPy is not installed, or does not understand the data.
    """
    try:
        import DracoPy
    except ImportError:
        raise MeshError(f"it is compressed with Draco, which needs DracoPy: {_HOW}") from None
    try:
        unpacked = DracoPy.decode(data)
    except Exception as cause:  # of its own kinds, not all of them derived from one
        raise MeshError(f"its Draco data cannot be unpacked: {cause}") from None
    held = {one["unique_id"]: one["data"] for one in unpacked.attributes}
    values = {}
    for name, number in asked.items():
        if number not in held:
            raise MeshError(f"its Draco data has no attribute {number} for {name}")
        if name in primitive["attributes"]:
            values[primitive["attributes"][name]] = held[number]
    faces = getattr(unpacked, "faces", None)
    if faces is not None and "indices" in primitive:
        values[primitive["indices"]] = faces.reshape(-1, 1)
    return values


def unpack_meshopt(data: bytes, packed: dict[str, Any]) -> bytes:
    """The bytes of a buffer view that is packed by meshopt.

    Parameters
    ----------
    data : bytes
        The packed bytes.
    packed : dict
        What the extension says: `count`, `byteStride`, `mode` and `filter`.

    Raises
    ------
    MeshError
        If meshoptimizer is not installed, or does not understand the data.
    """
    try:
        import meshoptimizer
    except ImportError:
        raise MeshError(
            f"it is compressed with meshopt, which needs meshoptimizer: {_HOW}"
        ) from None
    count, size = packed.get("count"), packed.get("byteStride")
    if not (isinstance(count, int) and isinstance(size, int) and count >= 0 and 0 < size <= 256):
        raise MeshError(f"its meshopt data is {count} elements of {size} bytes; expected numbers")
    filters = {
        "NONE": None,
        "OCTAHEDRAL": meshoptimizer.decode_filter_oct,
        "QUATERNION": meshoptimizer.decode_filter_quat,
        "EXPONENTIAL": meshoptimizer.decode_filter_exp,
    }
    mode, name = packed.get("mode"), packed.get("filter", "NONE")
    if name not in filters:
        raise MeshError(f"its meshopt filter is {name!r:.30}; expected one of {', '.join(filters)}")
    try:
        if mode == "ATTRIBUTES":
            element = np.dtype((np.void, size))
            values = meshoptimizer.decode_vertex_buffer(count, size, data, element)
            undo = filters[name]
            return bytes((values if undo is None else undo(values, count, size)).tobytes())
        if mode in ("TRIANGLES", "INDICES"):
            triangles = mode == "TRIANGLES"
            unpack = (
                meshoptimizer.decode_index_buffer
                if triangles
                else (meshoptimizer.decode_index_sequence)
            )
            return bytes(unpack(count, size, data).tobytes())[: count * size]  # room for four bytes
    except (ValueError, RuntimeError, MemoryError, OverflowError) as cause:
        raise MeshError(f"its meshopt data cannot be unpacked: {cause}") from None
    raise MeshError(f"its meshopt mode is {mode!r:.30}; expected ATTRIBUTES, TRIANGLES or INDICES")


# --------------------------------------------------------------------------------------------------


# ---- Kinds ---------------------------------------------------------------------------------------
# Whether the parts of a glTF document are of the kinds that the specification asks for.


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


# --------------------------------------------------------------------------------------------------


JSON_CHUNK, BIN_CHUNK = 0x4E4F534A, 0x004E4942
COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
MAX_ZEROS = 1 << 26  # elements of an accessor that has no data of its own


class GltfFile:
    """A parsed document with access to its numbers.

    Parameters
    ----------
    data : bytes
        A .glb or .gltf file.
    folder : Path
        Where the buffers of a .gltf lie.

    Raises
    ------
    MeshError
        If the container or the JSON is broken.
    """

    def __init__(self, data: bytes, folder: Path) -> None:
        self.folder = folder
        self.binary: bytes | None = None
        text = self._open_container(data) if data[:4] == b"glTF" else data
        self.document = parse_json(text)
        check_kinds(self.document)
        self._buffers: dict[int, bytes] = {}
        self._unpacked: dict[int, AnyArray] = {}
        self._views: dict[int, bytes] = {}

    def _open_container(self, data: bytes) -> bytes:
        version, length = (int.from_bytes(data[k : k + 4], "little") for k in (4, 8))
        if version != 2:
            raise MeshError(f"it is glTF version {version}; expected 2")
        if length > len(data):
            raise MeshError(f"it has {len(data)} of {length} bytes; the file is cut short")
        chunks, at = dict[int, bytes](), 12
        while at + 8 <= length:
            size, kind = (int.from_bytes(data[k : k + 4], "little") for k in (at, at + 4))
            if at + 8 + size > length:
                raise MeshError("a chunk reaches beyond the end; the file is cut short")
            chunks.setdefault(kind, data[at + 8 : at + 8 + size])
            at += 8 + size
        if JSON_CHUNK not in chunks:
            raise MeshError(
                f"it has no JSON chunk within the {length} bytes that its header speaks of, "
                f"of {len(data)}; expected one after the header"
            )
        self.binary = chunks.get(BIN_CHUNK)
        result: bytes = chunks[JSON_CHUNK]
        return result

    def item(self, kind: str, index: object) -> dict[str, Any]:
        """Return one entry of a top-level list such as "nodes".

        Raises
        ------
        MeshError
            If there is no such entry.
        """
        entries = self.document.get(kind, [])
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(entries):
            raise MeshError(f"it refers to {kind}[{index}], of which there are {len(entries)}")
        if not isinstance(entries[index], dict):
            raise MeshError(f"{kind}[{index}] is not an object")
        result: dict[str, Any] = entries[index]
        return result

    def numbers(self, index: object) -> AnyArray:
        """Return an accessor's values, (N, width), as stored or as floats where normalised.

        Raises
        ------
        MeshError
            If the accessor does not fit into its buffer.
        """
        accessor = self.item("accessors", index)
        if index in self._unpacked:
            return _unpacked(self._unpacked[index], accessor)
        dtype = np.dtype(COMPONENTS[accessor["componentType"]])
        width, count = WIDTHS[accessor["type"]], accessor["count"]
        if "bufferView" in accessor:
            start = accessor.get("byteOffset", 0)
            values = self._view(accessor["bufferView"], start, dtype, width, count)
        else:
            check_count(count, 1, MAX_ZEROS, "elements in an accessor")
            values = np.zeros((count, width), dtype)
        if "sparse" in accessor:
            values = self._with_sparse(values, accessor["sparse"], dtype, width)
        if accessor.get("normalized") and dtype.kind in "iu":
            return np.maximum(values / float(np.iinfo(dtype).max), -1.0)
        return values

    def unpack(self, primitive: dict[str, Any], packed: dict[str, Any]) -> None:
        """Have the numbers of a primitive that is packed by Draco, as its extension says.

        Raises
        ------
        MeshError
            If they cannot be unpacked.
        """
        if not isinstance(packed, dict) or not isinstance(packed.get("attributes"), dict):
            raise MeshError("its Draco extension is no object with attributes")
        data = self.view_bytes(packed["bufferView"])
        self._unpacked |= unpack_draco(data, primitive, packed["attributes"])

    def _with_sparse(
        self, values: AnyArray, sparse: dict[str, Any], dtype: np.dtype, width: int
    ) -> AnyArray:
        where, what, n = sparse["indices"], sparse["values"], sparse["count"]
        index_type = np.dtype(COMPONENTS[where["componentType"]])
        rows = self._view(where["bufferView"], where.get("byteOffset", 0), index_type, 1, n)[:, 0]
        if len(rows) and rows.max() >= len(values):
            raise MeshError(f"a sparse accessor replaces element {rows.max()} of {len(values)}")
        changed = values.copy()
        changed[rows] = self._view(what["bufferView"], what.get("byteOffset", 0), dtype, width, n)
        return changed

    def _view(self, index: int, start: int, dtype: np.dtype, width: int, count: int) -> AnyArray:
        """Return (count, width) values of a buffer view, without copying."""
        view = self.item("bufferViews", index)
        size = dtype.itemsize * width
        stride = view.get("byteStride") or size
        begin, length = view.get("byteOffset", 0), view["byteLength"]
        packed = view.get("extensions", {}).get("EXT_meshopt_compression")
        if packed is None:
            data = self._buffer(view["buffer"])
        else:
            data, begin = self._unpacked_view(index, packed), 0
        if min(begin, start, length, count) < 0 or stride < size or begin + length > len(data):
            raise MeshError(f"bufferViews[{index}] does not fit into its buffer")
        if count and start + (count - 1) * stride + size > length:
            raise MeshError(f"an accessor reads beyond the end of bufferViews[{index}]")
        return np.ndarray(
            (count, width), dtype, data, begin + start if count else 0, (stride, dtype.itemsize)
        )

    def _unpacked_view(self, index: int, packed: dict[str, Any]) -> bytes:
        if index not in self._views:
            begin, length = packed.get("byteOffset", 0), packed["byteLength"]
            data = self._buffer(packed["buffer"])
            if min(begin, length) < 0 or begin + length > len(data):
                raise MeshError(f"the packed bufferViews[{index}] does not fit into its buffer")
            self._views[index] = unpack_meshopt(data[begin : begin + length], packed)
        return self._views[index]

    def _buffer(self, index: int) -> bytes:
        if index not in self._buffers:
            buffer = self.item("buffers", index)
            data = self._load(buffer.get("uri"))
            if len(data) < buffer["byteLength"]:
                raise MeshError(
                    f"buffers[{index}] has {len(data)} of {buffer['byteLength']} bytes; "
                    "the file is cut short"
                )
            self._buffers[index] = data
        return self._buffers[index]

    def _load(self, uri: str | None) -> bytes:
        if uri is not None:
            return self.resource(uri)
        if self.binary is None:
            raise MeshError("a buffer has no data")
        return self.binary

    def resource(self, uri: str) -> bytes:
        """Return what a URI stands for: base64 data, or a file in the document's folder.

        Raises
        ------
        MeshError
            If it is broken, missing, or lies outside the folder.
        """
        if not uri.startswith("data:"):
            return read_beside(self.folder, uri)
        try:
            return base64.b64decode(uri.partition(",")[2], validate=True)
        except ValueError:
            raise MeshError("a data URI is not base64") from None

    def view_bytes(self, index: int) -> bytes:
        """Return the bytes of a buffer view, as for an image.

        Raises
        ------
        MeshError
            If the view does not fit into its buffer.
        """
        length = self.item("bufferViews", index)["byteLength"]
        return self._view(index, 0, np.dtype("u1"), 1, length).tobytes()


def _unpacked(values: AnyArray, accessor: dict[str, Any]) -> AnyArray:
    width, count = WIDTHS[accessor["type"]], accessor["count"]
    if values.shape != (count, width):
        raise MeshError(
            f"its Draco data has {values.shape[0]} x {values.shape[1]} numbers where the "
            f"accessor says {count} x {width}"
        )
    if accessor.get("normalized") and values.dtype.kind in "iu":
        return np.maximum(values / float(np.iinfo(values.dtype).max), -1.0)
    return values
