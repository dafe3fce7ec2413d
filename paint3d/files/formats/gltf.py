"""glTF 2.0 (.gltf, .glb): a scene's triangles as one mesh, colours from linear to sRGB."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError
from paint3d.files.formats.gltf_buffers import GENERATOR, GltfFile
from paint3d.files.formats.position_steps import METRE_MM, STEPS, take_steps
from paint3d.files.raw_mesh import RawMesh, left_out
from paint3d.files.colours import REPEAT, Look, open_picture, srgb_from_linear
from paint3d.files.vertex_colours import colour_shares

__all__ = ["GltfPaint", "read_gltf"]

# ---- Materials -----------------------------------------------------------------------------------
# Base colours of glTF materials, and what else they say that paint3d cannot show.


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


# --------------------------------------------------------------------------------------------------


TRIANGLES, STRIP, FAN = 4, 5, 6
THIN = {0: "points"} | dict.fromkeys((1, 2, 3), "lines")  # modes of what has no surface
LIGHTS = "KHR_lights_punctual"


def read_gltf(data: bytes, folder: Path, texture: bool = False) -> RawMesh:
    """Read the default scene, with the transforms of its nodes applied.

    Points and lines are passed over, as are skins and animations; that and what else is dropped
    is noted. COLOR_0 is linear by the specification and comes back as sRGB codes.

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
    paint = GltfPaint(file)
    parts = []
    for matrix, mesh in _placed_meshes(file):
        for primitive in mesh.get("primitives", []):
            part = _primitive(file, primitive, paint, texture)
            if part is not None:
                parts.append(_transformed(part, matrix))
    if not parts:
        raise MeshError("its scene has no triangles; expected a surface")
    return _merged(parts, paint, _dropped(file))


def _dropped(file: GltfFile) -> set[str]:
    """What a document says besides its meshes and materials."""
    dropped = {kind for kind in ("animations", "skins", "cameras") if file.document.get(kind)}
    if LIGHTS in file.document.get("extensions", {}):
        dropped.add("lights")
    for mesh in file.document.get("meshes", []):
        for primitive in mesh.get("primitives", []):
            dropped |= {"morph targets"} if "targets" in primitive else set()
            mode = primitive.get("mode", TRIANGLES)
            dropped |= {THIN[mode]} if mode in THIN else set()
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
            raise MeshError(f"node {index} is reached twice; expected a tree of nodes")
        seen.add(index)
        world_from_node = world_from_parent @ _local(node)
        if "mesh" in node:
            yield world_from_node, file.item("meshes", node["mesh"])
        stack += [(child, world_from_node) for child in reversed(node.get("children", []))]


def _local(node: dict[str, Any]) -> NDArray[np.float64]:
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


def _primitive(
    file: GltfFile, primitive: dict[str, Any], paint: GltfPaint, texture: bool
) -> RawMesh | None:
    """Return one primitive in its own frame, or None for points and lines."""
    mode = primitive.get("mode", TRIANGLES)
    if mode not in (TRIANGLES, STRIP, FAN):
        return None
    packed = primitive.get("extensions", {}).get("KHR_draco_mesh_compression")
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
                raise MeshError(f"a primitive has {len(vertices)} positions but "
                                f"{len(others[name])} of {name}")  # fmt: skip
    if STEPS in others:
        vertices = take_steps(vertices, others[STEPS][:, 0])
    colours = None
    if "COLOR_0" in others:
        shares, notes = colour_shares(others["COLOR_0"])
        paint.notes += notes
        colours = None if shares is None else srgb_from_linear(shares)
    faces = _triangles(indices, mode)
    number, uv = paint.look_of(primitive, len(vertices), texture)
    if uv is not None:
        uv = uv[np.clip(faces, 0, len(vertices) - 1).ravel()]
    return RawMesh.of_triangles(
        vertices, faces, colours=colours, normals=others.get("NORMAL"),
        look_of=np.full(len(faces), number), uv=uv,
    )  # fmt: skip


def _triangles(indices: NDArray[np.int64], mode: int) -> NDArray[np.int64]:
    if mode == TRIANGLES:
        if len(indices) % 3:
            raise MeshError(f"a primitive has {len(indices)} indices; expected a multiple of 3")
        return indices.reshape(-1, 3)
    n = max(len(indices) - 2, 0)
    k = np.arange(n)
    if mode == FAN:
        columns = (np.zeros(n, np.int64), k + 1, k + 2)
    else:
        columns = (k, k + 1 + k % 2, k + 2 - k % 2)
    return indices[np.stack(columns, axis=1)]


def _transformed(part: RawMesh, matrix: NDArray[np.float64]) -> RawMesh:
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


def _merged(parts: list[RawMesh], paint: GltfPaint, dropped: set[str]) -> RawMesh:
    first = np.cumsum([0, *(len(part.vertices) for part in parts)])
    for part in parts:  # checked here: after merging, a wrong index would hit another part
        if len(part.corners) and int(part.corners.max()) >= len(part.vertices):
            raise MeshError(
                f"a face refers to vertex {int(part.corners.max())}; "
                f"expected 0 to {len(part.vertices) - 1}"
            )
    corners = [part.corners + start for part, start in zip(parts, first, strict=False)]
    colours = None
    if any(part.colours is not None for part in parts):
        white = [np.full((len(p.vertices), 3), 255, np.uint8) for p in parts]
        known = [w if p.colours is None else p.colours for p, w in zip(parts, white, strict=True)]
        colours = np.concatenate(known)
    normals = None
    given = [part.normals for part in parts if part.normals is not None]
    if len(given) == len(parts):
        normals = np.concatenate(given)
    return RawMesh(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate(corners),
        np.concatenate([part.sizes for part in parts]),
        colours,
        normals,
        unit_mm=METRE_MM,
        up="y",
        notes=(*dict.fromkeys(paint.notes), *left_out(dropped | paint.dropped)),
        looks=tuple(paint.looks),
        look_of=np.concatenate([part.look_of for part in parts]) if paint.looks else None,
        uv=np.concatenate([_uv(part) for part in parts]) if paint.looks else None,
    )


def _uv(part: RawMesh) -> NDArray[np.float64]:
    return np.full((len(part.corners), 2), np.nan) if part.uv is None else part.uv
