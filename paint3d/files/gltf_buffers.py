"""The outer layers of glTF 2.0: the GLB container, buffers and accessors."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError
from paint3d.files.readers.contents import parse_json, read_beside
from paint3d.files.readers.gltf_kinds import check_kinds
from paint3d.files.readers.gltf_packing import unpack_draco, unpack_meshopt
from paint3d.files.readers.raw_mesh import check_count

__all__ = ["GltfFile"]

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
