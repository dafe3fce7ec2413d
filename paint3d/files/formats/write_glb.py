"""Binary glTF 2.0 with the colours at the vertices (linear), or in a texture (sRGB)."""

from __future__ import annotations

import io
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.spectra import decode_srgb
from paint3d.core.arrays import AnyArray
from paint3d.files.formats.gltf_buffers import (
    INDEX_DATA,
    VERTEX_DATA,
    material,
    vertex_accessor,
    write_container,
)
from paint3d.files.formats.position_steps import STEPS
from paint3d.files.finish import Finish, Texture

__all__ = ["write_glb", "write_textured_glb"]

UNSIGNED_SHORT, UNSIGNED_INT = 5123, 5125
LINEAR, MIPMAPS, CLAMP = 9729, 9987, 33071
WHITE = [1, 1, 1, 1]
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
        these are places in a texture that is a scale of roughness: glTF knows none at vertices.
    unlit : bool
        Show the colours without light (KHR_materials_unlit).
    steps : (V,) float32, optional
        From `paint3d.files.formats.position_steps`.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    attributes = {"POSITION": 0, "NORMAL": 1, "COLOR_0": 2}
    colours = {"bufferView": 2, "componentType": UNSIGNED_SHORT, "count": len(srgb)}
    accessors = [
        vertex_accessor(0, vertices, limits=True),
        vertex_accessor(1, normals),
        colours | {"type": "VEC4", "normalized": True},
        _index_accessor(faces),
    ]
    blocks: list[tuple[AnyArray | bytes, int | None]]
    blocks = [(vertices, VERTEX_DATA), (normals, VERTEX_DATA), (_linear(srgb), VERTEX_DATA)]
    blocks.append((faces.astype("<u4"), INDEX_DATA))
    _add_steps(steps, attributes, accessors, blocks)
    surface: dict[str, Any] = {"baseColorFactor": WHITE}
    more: dict[str, Any] = {}
    if finish.each is not None and not unlit:
        more = _roughness_scale(finish.each, attributes, accessors, blocks)
        surface["metallicRoughnessTexture"] = {"index": 0}
        finish = finish._replace(roughness=1.0)  # what the texture's is multiplied by
    meshes = [{"name": finish.name, "primitives": [_primitive(attributes)]}]
    materials = [material(finish, unlit, **surface)]
    document = {"meshes": meshes, "materials": materials, "accessors": accessors, **more}
    write_container(path, document, blocks)


def _roughness_scale(
    roughness: NDArray[np.float32],
    attributes: dict[str, int],
    accessors: list[dict[str, Any]],
    blocks: list[tuple[AnyArray | bytes, int | None]],
) -> dict[str, Any]:
    """Add a texture of all roughnesses from 0 to 1, and each vertex's place in it."""
    png = _png_of_row(_roughness_codes(np.arange(256.0)[None]))
    places = np.full((len(roughness), 2), 0.5, "<f4")
    places[:, 0] = (255.0 * np.clip(roughness, 0.0, 1.0) + 0.5) / 256.0
    attributes["TEXCOORD_0"] = len(accessors)
    accessors.append(vertex_accessor(len(blocks), places))
    blocks += [(places, VERTEX_DATA), (png, None)]
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
    surface: dict[str, Any] = {"baseColorFactor": WHITE, "baseColorTexture": {"index": 0}}
    images = [_png(texture.image)]
    if finish.each is not None and not unlit:
        images.append(_png(_roughness_codes(np.rint(255.0 * finish.each))))
        surface["metallicRoughnessTexture"] = {"index": 1}
        finish = finish._replace(roughness=1.0)  # what the texture's is multiplied by
    accessors = [
        vertex_accessor(0, vertices, limits=True),
        vertex_accessor(1, normals),
        vertex_accessor(2, texture.uv),
        _index_accessor(faces),
    ]
    blocks: list[tuple[AnyArray | bytes, int | None]]
    blocks = [(array, VERTEX_DATA) for array in (vertices, normals, texture.uv)]
    blocks += [(faces.astype("<u4"), INDEX_DATA), *((png, None) for png in images)]
    _add_steps(steps, attributes, accessors, blocks)
    document = {
        "meshes": [{"name": finish.name, "primitives": [_primitive(attributes)]}],
        "materials": [material(finish, unlit, **surface)],
        "textures": [{"sampler": 0, "source": k} for k in range(len(images))],
        "images": [{"bufferView": 4 + k, "mimeType": "image/png"} for k in range(len(images))],
        "samplers": [{"magFilter": LINEAR, "minFilter": MIPMAPS, "wrapS": CLAMP, "wrapT": CLAMP}],
        "accessors": accessors,
    }
    write_container(path, document, blocks)


def _roughness_codes(values: AnyArray) -> NDArray[np.uint8]:
    """Pixels (H, W, 3) of roughnesses (H, W), 0 to 255: green says it, blue would be metal."""
    pixels = np.zeros((*values.shape, 3), np.uint8)
    pixels[..., 1] = values
    return pixels


def _png(pixels: NDArray[np.uint8]) -> bytes:
    from PIL import Image

    png = io.BytesIO()
    Image.fromarray(pixels).save(png, "PNG", compress_level=PNG_COMPRESSION)
    return png.getvalue()


def _png_of_row(pixels: NDArray[np.uint8]) -> bytes:
    """A PNG of pixels (1, W, 3), without Pillow: loading that takes longer than all the rest."""
    header = struct.pack(">IIBBBBB", pixels.shape[1], 1, 8, 2, 0, 0, 0)  # 8 bits, RGB
    parts = [(b"IHDR", header), (b"IDAT", zlib.compress(b"\0" + pixels.tobytes())), (b"IEND", b"")]
    chunks = [
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in parts
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


def _linear(srgb: NDArray[np.uint8]) -> NDArray[np.uint16]:
    """Return linear RGBA, (V, 4) normalised uint16, of sRGB codes."""
    curve = decode_srgb(np.arange(256, dtype=np.uint8))
    table = np.floor(65535.0 * curve + 0.5).astype("<u2")
    rgba = np.full((len(srgb), 4), 65535, "<u2")
    rgba[:, :3] = table[srgb]
    return rgba


def _primitive(attributes: dict[str, int]) -> dict[str, Any]:
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
        accessors.append(vertex_accessor(len(blocks), steps))
        blocks.append((steps, VERTEX_DATA))
