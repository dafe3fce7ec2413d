"""Base colours of glTF materials, and what else they say that paint3d cannot show."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError
from paint3d.files.glb_container import GENERATOR
from paint3d.files.gltf_buffers import GltfFile
from paint3d.files.readers.textures import REPEAT, Look, open_picture

__all__ = ["GltfPaint"]

WHITE = (1.0, 1.0, 1.0, 1.0)
WRAPPED = {10497: "repeat", 33071: "clamp", 33648: "mirror"}
LEFT_OUT = {  # what of a material is left out, by its key
    "normalTexture": "relief (a normal map)",
    "occlusionTexture": "shadows baked into a picture",
    "emissiveTexture": "light of its own",
}
OWN_SHINE = "how its ink shines"  # of a painting: what it is painted on anew says how it shines
TURNED = "KHR_texture_transform"


class GltfPaint:
    """Base colours of a document; every picture is opened once.

    Attributes
    ----------
    notes : list of str
        Pictures that were not followed, and why.
    dropped : set of str
        What materials say that is not shown.
    looks : list of Look
        In the order in which they were asked for.
    """

    def __init__(self, file: GltfFile) -> None:
        self.notes: list[str] = []
        self.dropped: set[str] = set()
        self.looks: list[Look] = []
        self._file = file
        asset = file.document.get("asset")
        self._is_own = isinstance(asset, dict) and asset.get("generator") == GENERATOR
        self._pictures: dict[int, NDArray[np.uint8] | None] = {}
        self._known: dict[int, tuple[int, dict[str, Any]]] = {}

    def look_of(
        self, primitive: dict[str, Any], n: int, wanted: bool = True
    ) -> tuple[int, NDArray[np.float64] | None]:
        """Return which look a primitive of n vertices has, and its places (n, 2) on the picture.

        -1 where it has none that shows, or none is wanted: what is dropped is noted all the same.
        """
        if "material" not in primitive:
            return -1, None
        index = primitive["material"]
        if index not in self._known:
            self._known[index] = self._read(self._file.item("materials", index), wanted)
        number, texture = self._known[index]
        if number < 0 or self.looks[number].picture is None:
            return number, None
        turned = texture.get("extensions", {}).get(TURNED, {})
        name = f"TEXCOORD_{turned.get('texCoord', texture.get('texCoord', 0))}"
        if name not in primitive["attributes"]:
            self.notes.append(f"a texture is left out: the mesh has no {name}")
            return number, None
        uv = self._file.numbers(primitive["attributes"][name]).astype(np.float64)
        if uv.shape != (n, 2):
            raise MeshError(f"a primitive has {n} positions but {len(uv)} of {name}")
        return number, _placed(uv, turned)

    def _read(self, surface: dict[str, Any], wanted: bool) -> tuple[int, dict[str, Any]]:
        colours = surface.get("pbrMetallicRoughness", {})
        factor = np.array(colours.get("baseColorFactor", WHITE), np.float64)
        texture = colours.get("baseColorTexture")
        if not wanted:
            if texture is not None or (factor[:3] < 1.0).any():
                self.dropped.add("its colours and pictures")
            return -1, {}
        self.dropped |= {what for key, what in LEFT_OUT.items() if key in surface}
        if any(part > 0.0 for part in surface.get("emissiveFactor", ())):
            self.dropped.add(LEFT_OUT["emissiveTexture"])
        if "metallicRoughnessTexture" in colours:
            self.dropped.add(OWN_SHINE if self._is_own else "metal and gloss from a picture")
        if surface.get("alphaMode", "OPAQUE") != "OPAQUE":
            self.dropped.add("transparency")
        if any(key != TURNED for key in surface.get("extensions", {})):
            self.dropped.add("extensions of its materials")
        picture = None if texture is None else self._picture(texture["index"])
        wrap = REPEAT if picture is None else self._wrap(texture["index"])
        red, green, blue = factor[:3].tolist()
        self.looks.append(Look((red, green, blue), picture, wrap))
        return len(self.looks) - 1, texture or {}

    def _wrap(self, index: int) -> tuple[str, str]:
        sampler = self._file.item("textures", index).get("sampler")
        said = {} if sampler is None else self._file.item("samplers", sampler)
        u, v = (WRAPPED.get(said.get(key, 0), "repeat") for key in ("wrapS", "wrapT"))
        return u, v

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


def _placed(uv: NDArray[np.float64], turned: dict[str, Any]) -> NDArray[np.float64]:
    """Places after KHR_texture_transform: scaled, turned, moved."""
    angle = float(turned.get("rotation", 0.0))
    c, s = np.cos(angle), np.sin(angle)
    uv = uv * np.array(turned.get("scale", (1.0, 1.0)), np.float64)
    uv = np.stack([c * uv[:, 0] + s * uv[:, 1], c * uv[:, 1] - s * uv[:, 0]], axis=1)
    return uv + np.array(turned.get("offset", (0.0, 0.0)), np.float64)
