"""glTF 2.0 (.gltf, .glb): scenes read as one mesh, paintings written with their colours."""

from __future__ import annotations

import base64
import io
import json
import struct
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.spectra import decode_srgb
from paint3d.core.arrays import AnyArray
from paint3d.errors import ExportError, MeshError, Message
from paint3d.files.colours import (
    NAMED_AS_COLOUR,
    REPEAT,
    Look,
    colour_fractions,
    open_picture,
    srgb_from_linear,
)
from paint3d.files.contents import parse_json, read_beside
from paint3d.files.finish import Finish, Texture
from paint3d.files.raw_mesh import RawMesh, check_count, join_meshes, left_out

__all__ = [
    "STEPS",
    "GltfFile",
    "GltfPaint",
    "find_steps",
    "material",
    "read_gltf",
    "unpack_meshopt",
    "write_glb",
    "write_textured_glb",
]

# ---- The GLB container ---------------------------------------------------------------------------
# The GLB container: a JSON document, then the bytes of its buffer views.


_GENERATOR = "paint3d"
"""What a file says made it."""
FLOAT = 5126
LARGEST = (1 << 32) - 1
_VERTEX_DATA, _INDEX_DATA = 34962, 34963
UNLIT = "KHR_materials_unlit"
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}


def _write_container(
    path: Path, document: dict[str, Any], blocks: Sequence[tuple[AnyArray | bytes, int | None]]
) -> None:
    """Write a scene of one mesh, whose nodes, buffers and views are added to its document.

    Parameters
    ----------
    path : Path
    document : dict
        With meshes, materials and accessors; these refer to `blocks` by index.
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
        "asset": {"version": "2.0", "generator": _GENERATOR},
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
        raise ExportError(
            "a binary glTF holds 4 GiB at most; this one would have {end:,} bytes",
            end=end,
        )
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


def _vertex_accessor(
    view: int, values: NDArray[np.float32], *, limits: bool = False
) -> dict[str, Any]:
    """Return the accessor of float32 numbers (V,) or vectors (V, 2 or 3), with limits if wanted."""
    accessor: dict[str, Any] = {"bufferView": view, "componentType": FLOAT, "count": len(values)}
    accessor["type"] = TYPES[values.size // len(values)]
    if limits:
        for key, limit in (("min", values.min(axis=0)), ("max", values.max(axis=0))):
            accessor[key] = limit.astype(float).tolist()
    return accessor


# ---- What is packed ------------------------------------------------------------------------------
# What is packed in a glTF: primitives by Draco (KHR_draco_mesh_compression, unpacked by DracoPy)
# and buffer views by meshopt (EXT_meshopt_compression, unpacked by meshoptimizer).


DRACO, MESHOPT = "KHR_draco_mesh_compression", "EXT_meshopt_compression"
_HOW = "pip install 'paint3d[meshes]'"


def _unpack_draco(
    data: bytes, primitive: dict[str, Any], asked: dict[str, int]
) -> dict[int, AnyArray]:
    """The values of a Draco-compressed primitive's accessors.

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
        raise MeshError(
            "it is compressed with Draco, which needs DracoPy; expected an uncompressed file",
            hint=_HOW,
        ) from None
    try:
        unpacked = DracoPy.decode(data)
    except Exception as cause:  # of its own kinds, not all of them derived from one
        raise MeshError("its Draco data cannot be unpacked: {cause}", cause=cause) from None
    attributes = {one["unique_id"]: one["data"] for one in unpacked.attributes}
    values = {}
    for name, number in asked.items():
        if number not in attributes:
            raise MeshError(
                "its Draco data has no attribute {number} for {name}",
                number=number,
                name=name,
            )
        if name in primitive["attributes"]:
            values[primitive["attributes"][name]] = attributes[number]
    faces = getattr(unpacked, "faces", None)
    if faces is not None and "indices" in primitive:
        values[primitive["indices"]] = faces.reshape(-1, 1)
    return values


def _undo_octahedra(values: AnyArray, count: int, size: int) -> AnyArray:
    """Unit vectors of codes on an octahedron: x, y, what is 1, and what stays, int8 or int16.

    By EXT_meshopt_compression, in float32; meshoptimizer's own takes the processor's estimate of
    1/sqrt, which rounds some otherwise on one of another make.
    """
    if size not in (4, 8):
        raise ValueError(f"octahedra of {size} bytes")
    kind = np.dtype(np.int8 if size == 4 else np.int16)
    codes = values.view(kind).reshape(count, 4)
    x, y, z = codes[:, :3].T.astype(np.float32)
    z = z - np.abs(x) - np.abs(y)
    fold = np.minimum(z, np.float32(0.0))
    folded = [part + np.where(part >= 0.0, fold, -fold) for part in (x, y)]
    vectors = np.stack([*folded, z], axis=1)
    lengths = np.sqrt(vectors[:, 0] ** 2 + vectors[:, 1] ** 2 + vectors[:, 2] ** 2)
    longest = np.float32(127 if size == 4 else 32767)
    vectors *= np.divide(longest, lengths, out=lengths.copy(), where=lengths > 0.0)[:, None]
    codes[:, :3] = np.rint(vectors)
    return codes


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
            "it is compressed with meshopt, which needs meshoptimizer; expected an uncompressed "
            "file",
            hint=_HOW,
        ) from None
    count, size = packed.get("count"), packed.get("byteStride")
    if not (isinstance(count, int) and isinstance(size, int) and count >= 0 and 0 < size <= 256):
        raise MeshError(
            "its meshopt data is {count} elements of {size} bytes; expected numbers",
            count=count,
            size=size,
        )
    filters = {
        "NONE": None,
        "OCTAHEDRAL": _undo_octahedra,
        "QUATERNION": meshoptimizer.decode_filter_quat,
        "EXPONENTIAL": meshoptimizer.decode_filter_exp,
    }
    mode, name = packed.get("mode"), packed.get("filter", "NONE")
    if name not in filters:
        raise MeshError(
            "its meshopt filter is {name!r:.30}; expected one of {filters}",
            name=name,
            filters=", ".join(filters),
        )
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
        raise MeshError("its meshopt data cannot be unpacked: {cause}", cause=cause) from None
    raise MeshError(
        "its meshopt mode is {mode!r:.30}; expected ATTRIBUTES, TRIANGLES or INDICES",
        mode=mode,
    )


# ---- Kinds ---------------------------------------------------------------------------------------
# Whether the parts of a glTF document are of the kinds that the specification asks for.


KINDS = {
    dict: Message("an object"),
    list: Message("a list"),
    str: Message("a text"),
    type(None): "null",
    bool: Message("true or false"),
}
PARTS: dict[str, dict[str, type]] = {  # what is read of the entries of each list
    "accessors": {"sparse": dict},
    "buffers": {"uri": str},
    "bufferViews": {"extensions": dict},
    "images": {"uri": str},
    "materials": {"pbrMetallicRoughness": dict, "extensions": dict},
    "meshes": {"primitives": list},
    "nodes": {"extensions": dict, "children": list, "matrix": list, "rotation": list, "scale": list,
              "translation": list},
    "samplers": {},
    "scenes": {"nodes": list},
    "textures": {"extensions": dict},
}  # fmt: skip
PRIMITIVE = {"attributes": dict, "extensions": dict}
SURFACE = {"baseColorTexture": dict, "baseColorFactor": list}


def _check_kinds(document: Mapping[str, Any]) -> None:
    """Refuse a document of another version, or with parts of another type.

    Raises
    ------
    MeshError
        Naming the part, what it is, and what was expected.
    """
    _check_entry(document, {"asset": dict, "extensionsRequired": list, "extensionsUsed": list}, "")
    version = str(document.get("asset", {}).get("version", "2.0"))
    if not version.startswith("2."):
        raise MeshError("it is glTF version {version:.20}; expected 2", version=version)
    if isinstance(document.get("scenes"), dict):  # named, not counted, as in the first version
        raise MeshError("its scenes are named, as in glTF version 1; expected 2")
    _check_entry(document, dict.fromkeys(PARTS, list), "")
    for name, kinds in PARTS.items():
        for k, entry in enumerate(document.get(name, [])):
            where = f"{name}[{k}]"
            _expect(entry, dict, where)
            _check_entry(entry, kinds, f"{where}.")
            if name == "meshes":
                for j, primitive in enumerate(entry.get("primitives", [])):
                    _expect(primitive, dict, f"{where}.primitives[{j}]")
                    _check_entry(primitive, PRIMITIVE, f"{where}.primitives[{j}].")
            elif name == "materials":
                inner = entry.get("pbrMetallicRoughness", {})
                _check_entry(inner, SURFACE, f"{where}.pbrMetallicRoughness.")


def _check_entry(entry: Mapping[str, Any], kinds: Mapping[str, type], where: str) -> None:
    for name, kind in kinds.items():
        if name in entry:
            _expect(entry[name], kind, f"{where}{name}")


def _expect(value: object, kind: type, where: str) -> None:
    if not isinstance(value, kind):
        kind_name = KINDS.get(type(value), Message("a number"))
        raise MeshError(
            "its {place} is {found}; expected {kinds}",
            place=where,
            found=kind_name,
            kinds=KINDS[kind],
        )


# ---- The file ------------------------------------------------------------------------------------


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
        _check_kinds(self.document)
        self._buffers: dict[int, bytes] = {}
        self._unpacked: dict[int, AnyArray] = {}
        self._views: dict[int, bytes] = {}

    def _open_container(self, data: bytes) -> bytes:
        version, length = (int.from_bytes(data[k : k + 4], "little") for k in (4, 8))
        if version != 2:
            raise MeshError("it is glTF version {version}; expected 2", version=version)
        if length > len(data):
            raise MeshError(
                "it has {n} of {length} bytes; the file is cut short",
                n=len(data),
                length=length,
            )
        chunks, at = dict[int, bytes](), 12
        while at + 8 <= length:
            size, kind = (int.from_bytes(data[k : k + 4], "little") for k in (at, at + 4))
            if at + 8 + size > length:
                raise MeshError("a chunk reaches beyond the end; the file is cut short")
            chunks.setdefault(kind, data[at + 8 : at + 8 + size])
            at += 8 + size
        if JSON_CHUNK not in chunks:
            raise MeshError(
                "it has no JSON chunk within the {length} bytes that its header speaks of, of {n}; "
                "expected one after the header",
                length=length,
                n=len(data),
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
            raise MeshError(
                "it refers to {kind}[{index}], of which there are {n}",
                kind=kind,
                index=index,
                n=len(entries),
            )
        if not isinstance(entries[index], dict):
            raise MeshError("{kind}[{index}] is not an object", kind=kind, index=index)
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
            return _check_unpacked(self._unpacked[index], accessor)
        dtype = np.dtype(COMPONENTS[accessor["componentType"]])
        width, count = WIDTHS[accessor["type"]], accessor["count"]
        if "bufferView" in accessor:
            start = accessor.get("byteOffset", 0)
            values = self._view(accessor["bufferView"], start, dtype, width, count)
        else:
            check_count(count, 1, MAX_ZEROS, Message("elements in an accessor"))
            values = np.zeros((count, width), dtype)
        if "sparse" in accessor:
            sparse = accessor["sparse"]  # rows that replace those of the accessor
            where, what, n = sparse["indices"], sparse["values"], sparse["count"]
            index_type = np.dtype(COMPONENTS[where["componentType"]])
            start = where.get("byteOffset", 0)
            rows = self._view(where["bufferView"], start, index_type, 1, n)[:, 0]
            if len(rows) and rows.max() >= len(values):
                raise MeshError(
                    "a sparse accessor replaces element {most} of {n}",
                    most=rows.max(),
                    n=len(values),
                )
            values, start = values.copy(), what.get("byteOffset", 0)
            values[rows] = self._view(what["bufferView"], start, dtype, width, n)
        if accessor.get("normalized") and dtype.kind in "iu":
            return np.maximum(values / float(np.iinfo(dtype).max), -1.0)
        return values

    def unpack(self, primitive: dict[str, Any], packed: dict[str, Any]) -> None:
        """Unpack the numbers of a primitive that is packed by Draco, as its extension says.

        Raises
        ------
        MeshError
            If they cannot be unpacked.
        """
        if not isinstance(packed, dict) or not isinstance(packed.get("attributes"), dict):
            raise MeshError("its Draco extension is no object with attributes")
        data = self.view_bytes(packed["bufferView"])
        self._unpacked |= _unpack_draco(data, primitive, packed["attributes"])

    def _view(self, index: int, start: int, dtype: np.dtype, width: int, count: int) -> AnyArray:
        """Return (count, width) values of a buffer view, without copying."""
        view = self.item("bufferViews", index)
        size = dtype.itemsize * width
        stride = view.get("byteStride") or size
        begin, length = view.get("byteOffset", 0), view["byteLength"]
        packed = view.get("extensions", {}).get(MESHOPT)
        if packed is None:
            data = self._buffer(view["buffer"])
        else:
            data, begin = self._unpack_view(index, packed), 0
        if min(begin, start, length, count) < 0 or stride < size or begin + length > len(data):
            raise MeshError("bufferViews[{index}] does not fit into its buffer", index=index)
        if count and start + (count - 1) * stride + size > length:
            raise MeshError("an accessor reads beyond the end of bufferViews[{index}]", index=index)
        return np.ndarray(
            (count, width), dtype, data, begin + start if count else 0, (stride, dtype.itemsize)
        )

    def _unpack_view(self, index: int, packed: dict[str, Any]) -> bytes:
        if index not in self._views:
            begin, length = packed.get("byteOffset", 0), packed["byteLength"]
            data = self._buffer(packed["buffer"])
            if min(begin, length) < 0 or begin + length > len(data):
                raise MeshError(
                    "the packed bufferViews[{index}] does not fit into its buffer",
                    index=index,
                )
            self._views[index] = unpack_meshopt(data[begin : begin + length], packed)
        return self._views[index]

    def _buffer(self, index: int) -> bytes:
        if index not in self._buffers:
            buffer = self.item("buffers", index)
            uri, data = buffer.get("uri"), self.binary
            if uri is not None:
                data = self.resource(uri)
            elif data is None:
                raise MeshError("a buffer has no data")
            if len(data) < buffer["byteLength"]:
                raise MeshError(
                    "buffers[{index}] has {n} of {bytelength} bytes; the file is cut short",
                    index=index,
                    n=len(data),
                    bytelength=buffer["byteLength"],
                )
            self._buffers[index] = data
        return self._buffers[index]

    def resource(self, uri: str) -> bytes:
        """Return the bytes of a URI: base64 data, or a file in the document's folder.

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


def _check_unpacked(values: AnyArray, accessor: dict[str, Any]) -> AnyArray:
    width, count = WIDTHS[accessor["type"]], accessor["count"]
    if values.shape != (count, width):
        raise MeshError(
            "its Draco data has {rows} x {columns} numbers where the accessor says {count} x "
            "{width}",
            rows=values.shape[0],
            columns=values.shape[1],
            count=count,
            width=width,
        )
    if accessor.get("normalized") and values.dtype.kind in "iu":
        return np.maximum(values / float(np.iinfo(values.dtype).max), -1.0)
    return values


# ---- Millimetres to the bit ----------------------------------------------------------------------
# What metres in float32 lose of millimetres in float32: at the most one unit in the last place.
#
# Between 1.953 and 2 times a power of two, metres lie nearly twice as far apart as the millimetres
# that they stand for, so that half of these would come back as their neighbours. A binary glTF,
# whose positions are metres, says which in an attribute of our own; other programs pass over it.


STEPS = "_POSITION_STEPS"
_METRE_MM = 1000.0
_PLACES = np.array([9, 3, 1])  # of x, y and z in a code: their steps from -1 to 1, in base 3
_MIDDLE = 13


def find_steps(
    vertices: NDArray[np.float32], metres: NDArray[np.float32]
) -> NDArray[np.float32] | None:
    """Return a code (V,) of the rounding steps between vertices and what metres give back.

    Parameters
    ----------
    vertices : (V, 3) float32
        mm; the steps tell numbers of more than 1e-34 mm exactly.
    metres : (V, 3) float32
        The same in m, rounded.

    Returns
    -------
    (V,) float32 or None
        Whole numbers from -13 to 13; None where all are 0.
    """
    back = _in_mm(metres)
    if np.array_equal(back, vertices):
        return None
    steps = np.clip(vertices.view(np.int32) - back.view(np.int32), -1, 1)  # of their magnitude
    result: NDArray[np.float32] | None = (steps @ _PLACES).astype(np.float32)
    return result


def _take_steps(metres: NDArray[np.float64], codes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return metres (V, 3) that give back, in float32, the mm that `find_steps` encoded (V,)."""
    known = np.clip(np.nan_to_num(codes), -_MIDDLE, _MIDDLE)
    steps = (np.rint(known).astype(np.int32) + _MIDDLE)[:, None] // _PLACES % 3 - 1
    mm = (_in_mm(metres).view(np.int32) + steps.astype(np.int32)).view(np.float32)
    return np.where(steps == 0, metres, mm.astype(np.float64) / _METRE_MM)


def _in_mm(metres: NDArray[np.floating]) -> NDArray[np.float32]:
    return (metres.astype(np.float64) * _METRE_MM).astype(np.float32)


# ---- Reading -------------------------------------------------------------------------------------


# ---- Materials -----------------------------------------------------------------------------------
# Base colours of glTF materials, and what else they say that paint3d cannot show.


WHITE = (1.0, 1.0, 1.0, 1.0)
WRAPPED = {10497: "repeat", 33071: "clamp", 33648: "mirror"}
LEFT_OUT = {  # what of a material is left out, by its key
    "normalTexture": Message("relief (a normal map)"),
    "occlusionTexture": Message("shadows baked into a picture"),
    "emissiveTexture": Message("light of its own"),
}
OWN_SHINE = Message(
    "the gloss of its ink (a painting, .p3d, keeps it)"
)  # of a painting: what it is painted on anew says how it shines
SRGB_WRITERS = ("trimesh", "Open3D", "VTK")  # write colours of vertices as they have them
TURNED = "KHR_texture_transform"
GLOSSY = "KHR_materials_pbrSpecularGlossiness"
WEBP = "EXT_texture_webp"


class GltfPaint:
    """Base colours of a document; every picture is opened once.

    Attributes
    ----------
    notes : list of Message
        Pictures that were not followed, and why.
    dropped : set of Message
        What materials say that is not shown.
    looks : list of Look
        In the order in which they were asked for.
    """

    def __init__(self, file: GltfFile) -> None:
        self.notes: list[Message] = []
        self.dropped: set[Message] = set()
        self.looks: list[Look] = []
        self._file = file
        asset = file.document.get("asset")
        generator = str(asset.get("generator")) if isinstance(asset, dict) else ""
        self._is_own = generator == _GENERATOR
        self._srgb_writer = next((name for name in SRGB_WRITERS if name in generator), None)
        self._pictures: dict[int, NDArray[np.uint8] | None] = {}
        self._known: dict[int, tuple[int, dict[str, Any]]] = {}

    def look_of(
        self, primitive: dict[str, Any], n: int, wanted: bool = True
    ) -> tuple[int, NDArray[np.float64] | None]:
        """Return which look a primitive of n vertices has, and its texture coordinates (n, 2).

        -1 where it has none that shows, or none is wanted: what is dropped is noted all the same.
        """
        if "material" not in primitive:
            return -1, None
        index = primitive["material"]
        if index not in self._known:
            self._known[index] = self._read_material(self._file.item("materials", index), wanted)
        number, texture = self._known[index]
        if number < 0 or self.looks[number].picture is None:
            return number, None
        turned = texture.get("extensions", {}).get(TURNED, {})
        name = f"TEXCOORD_{turned.get('texCoord', texture.get('texCoord', 0))}"
        if name not in primitive["attributes"]:
            self.notes.append(Message("a texture is left out: the mesh has no {name}", name=name))
            return number, None
        uv = self._file.numbers(primitive["attributes"][name]).astype(np.float64)
        if uv.shape != (n, 2):
            raise MeshError(
                "a primitive has {n} positions but {uv} of {name}",
                n=n,
                uv=len(uv),
                name=name,
            )
        return number, _transform_uv(uv, turned)

    def vertex_colours(self, values: AnyArray) -> NDArray[np.uint8] | None:
        """Return the sRGB codes (V, 3) of COLOR_0: of linear colours, but for some writers'."""
        fractions, notes = colour_fractions(values)
        self.notes += notes
        if fractions is None or self._srgb_writer is None:
            return None if fractions is None else srgb_from_linear(fractions)
        self.notes.append(
            Message(
                "its vertex colours are taken as sRGB, as {writer} writes them",
                writer=self._srgb_writer,
            )
        )
        return np.floor(255.0 * fractions + 0.5).astype(np.uint8)

    def _read_material(self, surface: dict[str, Any], wanted: bool) -> tuple[int, dict[str, Any]]:
        extensions = surface.get("extensions", {})
        colours = surface.get("pbrMetallicRoughness", {})
        factor, texture = colours.get("baseColorFactor", WHITE), colours.get("baseColorTexture")
        glossy = extensions.get(GLOSSY)
        if glossy is not None:  # says it all anew, for those who know it
            factor, texture = glossy.get("diffuseFactor", WHITE), glossy.get("diffuseTexture")
        factor = np.array(factor, np.float64)
        if not wanted:
            if texture is not None or (factor[:3] < 1.0).any():
                self.dropped.add(Message("its colours and pictures"))
            return -1, {}
        self.dropped |= {what for key, what in LEFT_OUT.items() if key in surface}
        if any(part > 0.0 for part in surface.get("emissiveFactor", ())):
            self.dropped.add(LEFT_OUT["emissiveTexture"])
        if "specularGlossinessTexture" in (glossy or {}):
            self.dropped.add(Message("metal and gloss from a picture"))
        elif glossy is None and "metallicRoughnessTexture" in colours:
            self.dropped.add(
                OWN_SHINE if self._is_own else Message("metal and gloss from a picture")
            )
        if surface.get("alphaMode", "OPAQUE") != "OPAQUE":
            self.dropped.add(Message("transparency"))
        if extensions.keys() - {TURNED, GLOSSY, UNLIT}:
            self.dropped.add(Message("extensions of its materials"))
        picture = None if texture is None else self._open_picture(texture["index"])
        wrap = REPEAT if picture is None else self._find_wrap(texture["index"])
        red, green, blue = factor[:3].tolist()
        self.looks.append(Look((red, green, blue), picture, wrap))
        return len(self.looks) - 1, texture or {}

    def _find_wrap(self, index: int) -> tuple[str, str]:
        sampler = self._file.item("textures", index).get("sampler")
        sampling = {} if sampler is None else self._file.item("samplers", sampler)
        u, v = (WRAPPED.get(sampling.get(key, 0), "repeat") for key in ("wrapS", "wrapT"))
        return u, v

    def _open_picture(self, index: int) -> NDArray[np.uint8] | None:
        if index not in self._pictures:
            try:
                image = self._file.item("images", _image_index(self._file.item("textures", index)))
                if "uri" in image:
                    data = self._file.resource(image["uri"])
                else:
                    data = self._file.view_bytes(image["bufferView"])
                self._pictures[index] = open_picture(data)
            except MeshError as cause:
                self.notes.append(Message("a texture is left out: {cause}", cause=cause))
                self._pictures[index] = None
        return self._pictures[index]


def _image_index(texture: dict[str, Any]) -> object:
    """Return the index of a texture's image: its own, or that of an extension."""
    packed = texture.get("extensions", {})
    if "source" not in texture and packed and WEBP not in packed:
        raise MeshError("it is packed by {packed}, which is not read", packed=min(packed))
    return texture.get("source", packed.get(WEBP, {}).get("source"))


def _transform_uv(uv: NDArray[np.float64], turned: dict[str, Any]) -> NDArray[np.float64]:
    """Texture coordinates after KHR_texture_transform: scaled, turned, moved."""
    angle = float(turned.get("rotation", 0.0))
    c, s = np.cos(angle), np.sin(angle)
    uv = uv * np.array(turned.get("scale", (1.0, 1.0)), np.float64)
    uv = np.stack([c * uv[:, 0] + s * uv[:, 1], c * uv[:, 1] - s * uv[:, 0]], axis=1)
    return uv + np.array(turned.get("offset", (0.0, 0.0)), np.float64)


# ---- The mesh ------------------------------------------------------------------------------------


TRIANGLES, STRIP, FAN = 4, 5, 6
THIN = {0: Message("points")} | dict.fromkeys(
    (1, 2, 3), Message("lines")
)  # modes of what has no surface
LIGHTS, VARIANTS = "KHR_lights_punctual", "KHR_materials_variants"
HIDDEN, INSTANCES = "KHR_node_visibility", "EXT_mesh_gpu_instancing"
MOST_INSTANCES = 1 << 17
KNOWN = {  # extensions that a file may require: read, or what they say is noted as left out
    *(DRACO, MESHOPT, "KHR_mesh_quantization"),
    *(HIDDEN, INSTANCES, LIGHTS, TURNED, WEBP, "KHR_texture_basisu", "EXT_texture_avif"),
    *("KHR_animation_pointer", "KHR_xmp_json_ld"),
}
MATERIALS = "KHR_materials_"  # with which names of others begin


def read_gltf(data: bytes, folder: Path, texture: bool = False) -> RawMesh:
    """Read the default scene, with the transforms of its nodes applied.

    Points and lines are passed over, as are skins and animations; that and what else is dropped
    is noted. COLOR_0 is linear by the specification and comes back as sRGB codes; some programs
    write those into it, and are known by the name that they give.

    Parameters
    ----------
    data : bytes
        A .gltf or .glb file.
    folder : Path
        Where the buffers and pictures of a .gltf lie; others are not followed.
    texture : bool
        Whether the materials' base colours and their pictures are read.

    Raises
    ------
    MeshError
        If the file is broken, or compressed by an extension.
    """
    file = GltfFile(data, folder)
    for name in file.document.get("extensionsRequired", ()):
        if name not in KNOWN and not str(name).startswith(MATERIALS):
            raise MeshError(
                "it requires the extension {name!r:.60}, which is not read; expected a file that "
                "does without (Blender saves one)",
                name=str(name),
            )
    paint = GltfPaint(file)
    parts = []
    for matrix, mesh in _placed_meshes(file):
        for primitive in mesh.get("primitives", []):
            part = _read_primitive(file, primitive, paint, texture)
            if part is not None:
                parts.append(_transform(part, matrix))
    if not parts:
        raise MeshError("its scene has no triangles; expected a surface")
    for part in parts:  # checked here: in the joined mesh, a wrong index would hit another part
        if len(part.corners) and int(part.corners.max()) >= len(part.vertices):
            raise MeshError(
                "a face refers to vertex {most}; expected 0 to {last}",
                most=int(part.corners.max()),
                last=len(part.vertices) - 1,
            )
    return replace(
        join_meshes(parts),
        unit_mm=_METRE_MM,
        up="y",
        notes=(*dict.fromkeys(paint.notes), *left_out(_find_dropped(file) | paint.dropped)),
        looks=tuple(paint.looks),
    )


def _find_dropped(file: GltfFile) -> set[Message]:
    """Names of the document's parts besides meshes and materials, which are left out."""
    things = (Message("animations"), Message("skins"), Message("cameras"))
    dropped = {kind for kind in things if file.document.get(kind)}
    if LIGHTS in file.document.get("extensions", {}):
        dropped.add(Message("lights"))
    others = sorted({str(name) for name in file.document.get("extensionsUsed", ())} - KNOWN)
    others = [name for name in others if not name.startswith(MATERIALS)]
    if others:
        dropped.add(Message("what the extensions {names} say", names=", ".join(others)[:60]))
    nodes = file.document.get("nodes", [])
    if any(_is_hidden(node) for node in nodes):
        dropped.add(Message("hidden parts"))
    if len(file.document.get("scenes", [])) > 1:
        dropped.add(Message("scenes other than the default one"))
    instanced = (node.get("extensions", {}).get(INSTANCES) for node in nodes)
    names = {str(name) for one in instanced if one for name in one.get("attributes", {})}
    for mesh in file.document.get("meshes", []):
        for primitive in mesh.get("primitives", []):
            names |= {str(name) for name in primitive.get("attributes", {})} - {"COLOR_0"}
            if VARIANTS in primitive.get("extensions", {}):
                dropped.add(Message("variants of its materials"))
            dropped |= {Message("morph targets")} if "targets" in primitive else set()
            mode = primitive.get("mode", TRIANGLES)
            dropped |= {THIN[mode]} if mode in THIN else set()
    unread = sorted(filter(NAMED_AS_COLOUR.search, names))
    if unread:
        dropped.add(Message("what it calls {names}", names=", ".join(unread)[:60]))
    return dropped


def _placed_meshes(file: GltfFile) -> Iterator[tuple[NDArray[np.float64], dict[str, Any]]]:
    """Yield each mesh of the scene with its world_from_mesh matrix (4, 4)."""
    if not file.document.get("scenes"):
        raise MeshError("it has no scene, so no triangles; expected a surface")
    scene = file.item("scenes", file.document.get("scene", 0))
    stack = [(index, np.eye(4)) for index in reversed(scene.get("nodes", []))]
    seen: set[int] = set()
    while stack:
        index, world_from_parent = stack.pop()
        node = file.item("nodes", index)
        if index in seen:
            raise MeshError("node {index} is reached twice; expected a tree of nodes", index=index)
        seen.add(index)
        if _is_hidden(node):
            continue
        world_from_node = world_from_parent @ _local_matrix(node)
        if "mesh" in node:
            mesh, instances = file.item("meshes", node["mesh"]), _find_instances(file, node)
            yield from ((world_from_node @ node_from_mesh, mesh) for node_from_mesh in instances)
        stack += [(child, world_from_node) for child in reversed(node.get("children", []))]


def _is_hidden(node: dict[str, Any]) -> bool:
    return node.get("extensions", {}).get(HIDDEN, {}).get("visible") is False


def _find_instances(file: GltfFile, node: dict[str, Any]) -> list[NDArray[np.float64]]:
    """Return where a node's mesh stands in the node: matrices (4, 4), one unless it is repeated."""
    repeated = node.get("extensions", {}).get(INSTANCES)
    if repeated is None:
        return [np.eye(4)]
    parts = {key: file.numbers(k).astype(np.float64) for key, k in repeated["attributes"].items()
             if key in ("TRANSLATION", "ROTATION", "SCALE")}  # fmt: skip
    n = min((len(values) for values in parts.values()), default=0)
    if n > MOST_INSTANCES:
        raise MeshError(
            "a mesh is repeated {n:,} times; expected {most:,} at most",
            n=n,
            most=MOST_INSTANCES,
        )
    return [
        _local_matrix({key.lower(): values[k] for key, values in parts.items()}) for k in range(n)
    ]


def _local_matrix(node: dict[str, Any]) -> NDArray[np.float64]:
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    x, y, z, w = np.array(node.get("rotation", (0.0, 0.0, 0.0, 1.0)), np.float64)
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = rotation * np.array(node.get("scale", (1.0, 1.0, 1.0)), np.float64)
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix


def _read_primitive(
    file: GltfFile, primitive: dict[str, Any], paint: GltfPaint, texture: bool
) -> RawMesh | None:
    """Return one primitive in its own frame, or None for points and lines."""
    mode = primitive.get("mode", TRIANGLES)
    if mode not in (TRIANGLES, STRIP, FAN):
        return None
    packed = primitive.get("extensions", {}).get(DRACO)
    if packed is not None:
        file.unpack(primitive, packed)
    attributes = primitive["attributes"]
    if "POSITION" not in attributes:
        raise MeshError("a primitive has no positions, so no triangles; expected a surface")
    vertices = file.numbers(attributes["POSITION"]).astype(np.float64)
    if "indices" in primitive:
        indices = file.numbers(primitive["indices"]).astype(np.int64).ravel()
    else:
        indices = np.arange(len(vertices))
    others: dict[str, AnyArray] = {}
    for name in ("NORMAL", "COLOR_0", STEPS):
        if name in attributes:
            others[name] = file.numbers(attributes[name]).astype(np.float64)[:, :3]
            if len(others[name]) != len(vertices):
                raise MeshError(
                    "a primitive has {n} positions but {name_others} of {name}",
                    n=len(vertices),
                    name_others=len(others[name]),
                    name=name,
                )  # fmt: skip
    if STEPS in others:
        vertices = _take_steps(vertices, others[STEPS][:, 0])
    colours = None
    if "COLOR_0" in others:
        colours = paint.vertex_colours(others["COLOR_0"])
    faces = _index_triangles(indices, mode)
    number, uv = paint.look_of(primitive, len(vertices), texture)
    if uv is not None:
        uv = uv[np.clip(faces, 0, len(vertices) - 1).ravel()]
    return RawMesh.of_triangles(
        vertices, faces, colours=colours, normals=others.get("NORMAL"),
        look_of=np.full(len(faces), number), uv=uv,
    )  # fmt: skip


def _index_triangles(indices: NDArray[np.int64], mode: int) -> NDArray[np.int64]:
    if mode == TRIANGLES:
        if len(indices) % 3:
            raise MeshError("a primitive has {n} indices; expected a multiple of 3", n=len(indices))
        return indices.reshape(-1, 3)
    n = max(len(indices) - 2, 0)
    k = np.arange(n)
    if mode == FAN:
        columns = (np.zeros(n, np.int64), k + 1, k + 2)
    else:
        columns = (k, k + 1 + k % 2, k + 2 - k % 2)
    return indices[np.stack(columns, axis=1)]


def _transform(part: RawMesh, matrix: NDArray[np.float64]) -> RawMesh:
    turn = matrix[:3, :3]
    vertices = part.vertices @ turn.T + matrix[:3, 3]
    faces = part.corners.reshape(-1, 3)
    normals, uv = part.normals, part.uv
    mirrored = np.linalg.det(turn) < 0.0
    if mirrored:
        faces = faces[:, ::-1]
        uv = None if uv is None else uv.reshape(-1, 3, 2)[:, ::-1].reshape(-1, 2)
    if normals is not None:
        cofactor = np.stack([np.cross(turn[(k + 1) % 3], turn[(k + 2) % 3]) for k in range(3)])
        normals = normals @ cofactor.T * (-1.0 if mirrored else 1.0)
    return RawMesh.of_triangles(
        vertices, faces, colours=part.colours, normals=normals, look_of=part.look_of, uv=uv
    )


# ---- Writing -------------------------------------------------------------------------------------


UNSIGNED_SHORT, UNSIGNED_INT = 5123, 5125
LINEAR, MIPMAPS, CLAMP = 9729, 9987, 33071
PLAIN_WHITE = [1, 1, 1, 1]
PNG_COMPRESSION = 6
PLAIN = Finish()


def write_glb(
    path: Path,
    vertices: NDArray[np.float32],
    faces: NDArray[np.int32],
    normals: NDArray[np.float32],
    srgb: NDArray[np.uint8],
    finish: Finish = PLAIN,
    *,
    unlit: bool = False,
    steps: NDArray[np.float32] | None = None,
) -> None:
    """Write one mesh with vertex colours.

    COLOR_0 is linear by the specification, and 16 bits wide: 8-bit linear codes would keep only
    183 of the 256 sRGB ones.

    Parameters
    ----------
    path : Path
    vertices : (V, 3) float32
        As in the file; by the specification metres, y up.
    faces : (F, 3) int32
    normals : (V, 3) float32
        Unit.
    srgb : (V, 3) uint8
    finish : Finish
        Of the material; its name is the mesh's too. Where vertices have roughnesses of their own,
        these are coordinates in a texture that is a scale of roughness: glTF has none at vertices.
    unlit : bool
        Show the colours without light (KHR_materials_unlit).
    steps : (V,) float32, optional
        From `paint3d.files.formats.gltf`.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    attributes = {"POSITION": 0, "NORMAL": 1, "COLOR_0": 2}
    colours = {"bufferView": 2, "componentType": UNSIGNED_SHORT, "count": len(srgb)}
    accessors = [
        _vertex_accessor(0, vertices, limits=True),
        _vertex_accessor(1, normals),
        colours | {"type": "VEC4", "normalized": True},
        _index_accessor(faces),
    ]
    blocks: list[tuple[AnyArray | bytes, int | None]]
    blocks = [(vertices, _VERTEX_DATA), (normals, _VERTEX_DATA), (_linear_rgba(srgb), _VERTEX_DATA)]
    blocks.append((faces.astype("<u4"), _INDEX_DATA))
    _add_steps(steps, attributes, accessors, blocks)
    surface: dict[str, Any] = {"baseColorFactor": PLAIN_WHITE}
    more: dict[str, Any] = {}
    if finish.each is not None and not unlit:
        more = _add_roughness_scale(finish.each, attributes, accessors, blocks)
        surface["metallicRoughnessTexture"] = {"index": 0}
        finish = finish._replace(roughness=1.0)  # what the texture's is multiplied by
    meshes = [{"name": finish.name, "primitives": [_written_primitive(attributes)]}]
    materials = [material(finish, unlit, **surface)]
    document = {"meshes": meshes, "materials": materials, "accessors": accessors, **more}
    _write_container(path, document, blocks)


def _add_roughness_scale(
    roughness: NDArray[np.float32],
    attributes: dict[str, int],
    accessors: list[dict[str, Any]],
    blocks: list[tuple[AnyArray | bytes, int | None]],
) -> dict[str, Any]:
    """Add a texture of all roughnesses from 0 to 1, and each vertex's coordinate in it."""
    png = _encode_png_row(_roughness_codes(np.arange(256.0)[None]))
    positions = np.full((len(roughness), 2), 0.5, "<f4")
    positions[:, 0] = (255.0 * np.clip(roughness, 0.0, 1.0) + 0.5) / 256.0
    attributes["TEXCOORD_0"] = len(accessors)
    accessors.append(_vertex_accessor(len(blocks), positions))
    blocks += [(positions, _VERTEX_DATA), (png, None)]
    return {
        "textures": [{"sampler": 0, "source": 0}],
        "images": [{"bufferView": len(blocks) - 1, "mimeType": "image/png"}],
        "samplers": [{"magFilter": LINEAR, "minFilter": LINEAR, "wrapS": CLAMP, "wrapT": CLAMP}],
    }


def write_textured_glb(
    path: Path,
    vertices: NDArray[np.float32],
    faces: NDArray[np.int32],
    normals: NDArray[np.float32],
    texture: Texture,
    finish: Finish = PLAIN,
    *,
    unlit: bool = False,
    steps: NDArray[np.float32] | None = None,
) -> None:
    """Write one mesh with its colours in a texture.

    Parameters
    ----------
    path, vertices, faces, normals, finish, unlit, steps
        As for `write_glb`, but that roughnesses of their own are those of texels.
    texture : Texture

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    attributes = {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}
    surface: dict[str, Any] = {"baseColorFactor": PLAIN_WHITE, "baseColorTexture": {"index": 0}}
    images = [_encode_png(texture.image)]
    if finish.each is not None and not unlit:
        images.append(_encode_png(_roughness_codes(np.rint(255.0 * finish.each))))
        surface["metallicRoughnessTexture"] = {"index": 1}
        finish = finish._replace(roughness=1.0)  # what the texture's is multiplied by
    accessors = [
        _vertex_accessor(0, vertices, limits=True),
        _vertex_accessor(1, normals),
        _vertex_accessor(2, texture.uv),
        _index_accessor(faces),
    ]
    blocks: list[tuple[AnyArray | bytes, int | None]]
    blocks = [(array, _VERTEX_DATA) for array in (vertices, normals, texture.uv)]
    blocks += [(faces.astype("<u4"), _INDEX_DATA), *((png, None) for png in images)]
    _add_steps(steps, attributes, accessors, blocks)
    document = {
        "meshes": [{"name": finish.name, "primitives": [_written_primitive(attributes)]}],
        "materials": [material(finish, unlit, **surface)],
        "textures": [{"sampler": 0, "source": k} for k in range(len(images))],
        "images": [{"bufferView": 4 + k, "mimeType": "image/png"} for k in range(len(images))],
        "samplers": [{"magFilter": LINEAR, "minFilter": MIPMAPS, "wrapS": CLAMP, "wrapT": CLAMP}],
        "accessors": accessors,
    }
    _write_container(path, document, blocks)


def _roughness_codes(values: AnyArray) -> NDArray[np.uint8]:
    """Pixels (H, W, 3) of roughnesses (H, W), 0 to 255: green says it, blue would be metal."""
    pixels = np.zeros((*values.shape, 3), np.uint8)
    pixels[..., 1] = values
    return pixels


def _encode_png(pixels: NDArray[np.uint8]) -> bytes:
    from PIL import Image

    png = io.BytesIO()
    Image.fromarray(pixels).save(png, "PNG", compress_level=PNG_COMPRESSION)
    return png.getvalue()


def _encode_png_row(pixels: NDArray[np.uint8]) -> bytes:
    """A PNG of pixels (1, W, 3), without Pillow: loading that takes longer than all the rest."""
    header = struct.pack(">IIBBBBB", pixels.shape[1], 1, 8, 2, 0, 0, 0)  # 8 bits, RGB
    parts = [(b"IHDR", header), (b"IDAT", zlib.compress(b"\0" + pixels.tobytes())), (b"IEND", b"")]
    chunks = [
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in parts
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


def _linear_rgba(srgb: NDArray[np.uint8]) -> NDArray[np.uint16]:
    """Return linear RGBA, (V, 4) normalised uint16, of sRGB codes."""
    curve = decode_srgb(np.arange(256, dtype=np.uint8))
    table = np.floor(65535.0 * curve + 0.5).astype("<u2")
    rgba = np.full((len(srgb), 4), 65535, "<u2")
    rgba[:, :3] = table[srgb]
    return rgba


def _written_primitive(attributes: dict[str, int]) -> dict[str, Any]:
    return {"attributes": attributes, "indices": 3, "material": 0, "mode": 4}


def _index_accessor(faces: NDArray[np.int32]) -> dict[str, Any]:
    return {"bufferView": 3, "componentType": UNSIGNED_INT, "count": faces.size, "type": "SCALAR"}


def _add_steps(
    steps: NDArray[np.float32] | None,
    attributes: dict[str, int],
    accessors: list[dict[str, Any]],
    blocks: list[tuple[AnyArray | bytes, int | None]],
) -> None:
    """Add the attribute that leads back to millimetres, if there is any."""
    if steps is not None:
        attributes[STEPS] = len(accessors)
        accessors.append(_vertex_accessor(len(blocks), steps))
        blocks.append((steps, _VERTEX_DATA))
