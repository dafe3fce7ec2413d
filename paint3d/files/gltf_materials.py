"""Base colours of glTF materials, read at the vertices of a primitive."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError
from paint3d.files.gltf_buffers import GltfFile
from paint3d.files.textures import open_picture, sample_picture

__all__ = ["GltfPaint"]

WHITE = (1.0, 1.0, 1.0, 1.0)


class GltfPaint:
    """Base colours of a document; every picture is opened once.

    Attributes
    ----------
    notes : list of str
        Textures that were not followed, and why.
    """

    def __init__(self, file: GltfFile) -> None:
        self.notes: list[str] = []
        self._file = file
        self._pictures: dict[int, NDArray[np.uint8] | None] = {}

    def base_colours(self, primitive: dict, n: int) -> NDArray[np.float64] | None:
        """Return linear base colours (n, 3) at a primitive's vertices; None: it has no material."""
        if "material" not in primitive:
            return None
        surface = self._file.item("materials", primitive["material"])
        surface = surface.get("pbrMetallicRoughness", {})
        factor = np.array(surface.get("baseColorFactor", WHITE), np.float64)[:3]
        colours = np.broadcast_to(factor, (n, 3))
        texture = surface.get("baseColorTexture")
        picture = None if texture is None else self._picture(texture["index"])
        if picture is None:
            return colours
        name = f"TEXCOORD_{texture.get('texCoord', 0)}"
        if name not in primitive["attributes"]:
            self.notes.append(f"a texture is left out: the mesh has no {name}")
            return colours
        uv = self._file.numbers(primitive["attributes"][name]).astype(np.float64)
        if uv.shape != (n, 2):
            raise MeshError(f"a primitive has {n} positions but {len(uv)} of {name}")
        return colours * sample_picture(picture, uv)

    def _picture(self, index: int) -> NDArray[np.uint8] | None:
        if index not in self._pictures:
            try:
                image = self._file.item("images", self._file.item("textures", index).get("source"))
                if "uri" in image:
                    data = self._file.resource(image["uri"])
                else:
                    data = self._file.view_bytes(image["bufferView"])
                self._pictures[index] = open_picture(data)
            except MeshError as cause:
                self.notes.append(f"a texture is left out: {cause}")
                self._pictures[index] = None
        return self._pictures[index]
