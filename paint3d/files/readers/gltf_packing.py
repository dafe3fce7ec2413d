"""What is packed in a glTF: primitives by Draco (KHR_draco_mesh_compression, unpacked by DracoPy)
and buffer views by meshopt (EXT_meshopt_compression, unpacked by meshoptimizer)."""

from __future__ import annotations

from typing import Any

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError

__all__ = ["unpack_draco", "unpack_meshopt"]

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
