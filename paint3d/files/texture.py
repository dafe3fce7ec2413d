"""Baking of a painting into a texture on the mesh as it was before refinement.

The object's own triangles are laid out in a square by xatlas; every triangle that painting made of
them is then drawn there with its colours. Texels that no triangle covers get the nearest colour, so
that filtering and mipmaps never mix in what was not painted.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import ExportError

__all__ = ["Detail", "TexturedMesh", "bake_detail"]

Detail = tuple[AnyArray, ...]
"""The object and what is painted on it.

Own vertices (B, 3), faces (R, 3) and normals (B, 3); all vertices (V, 3), faces (F, 3), the own
face that each lies in (F,), and sRGB codes (V, 3), or other pictures' besides.
"""

PADDING = 4  # texels between charts
FILLED = 0.6  # fraction of a texture that xatlas covers, nearly
SIZES = (256, 4096)  # pixels that are chosen between by themselves
FEW_FACES = 10_000  # more are cut into many charts, since large ones take xatlas minutes
SMALL_CHART = 0.002  # of the area


class TexturedMesh(NamedTuple):
    """A mesh with texture coordinates (0, 0 at the top left)."""

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    normals: NDArray[np.float32]
    uv: NDArray[np.float32]


def bake_detail(
    detail: Detail, size: int | None = None
) -> tuple[TexturedMesh, list[NDArray[np.uint8]]]:
    """Bake a painting; return the mesh, and each picture (H, W, 3).

    Parameters
    ----------
    detail : Detail
    size : int, optional
        Pixels of the texture's longer side; by default two for each of the smallest edges.

    Raises
    ------
    ExportError
        If xatlas is not installed, or cannot lay out the mesh.
    """
    vertices, faces, normals, points, triangles, owners, *pictures = detail
    areas = _double_areas(vertices, faces) / 2.0
    if size is None:
        size = _enough_pixels(areas.sum(), _double_areas(points, triangles) / 2.0)
    source, corners, uv, shape = _lay_out(vertices, faces, areas, size)
    scale = size / max(shape)
    width, height = (max(1, round(side * scale)) for side in shape)
    texels = uv.astype(np.float64) * (width, height)
    texels_of_corners = _find_texels(vertices, faces, points, triangles, owners, texels[corners])
    drawn = [
        _draw_texture(texels_of_corners, codes[triangles].reshape(-1, 3), width, height)
        for codes in pictures
    ]
    return TexturedMesh(vertices[source], corners, normals[source], uv), drawn


def _double_areas(vertices: AnyArray, faces: AnyArray) -> NDArray[np.float64]:
    a, b, c = (vertices[faces[:, k]].astype(np.float64) for k in range(3))
    result: NDArray[np.float64] = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return result


def _enough_pixels(area: float, areas: NDArray[np.float64]) -> int:
    """Return the side at which the smaller triangles have two texels an edge."""
    edge = np.sqrt(2.3 * np.percentile(areas[areas > 0.0], 5.0))
    side = np.sqrt(area / FILLED) / (edge / 2.0)
    return int(np.clip(np.ceil(side / 64.0) * 64.0, *SIZES))


def _lay_out(
    vertices: AnyArray, faces: AnyArray, areas: AnyArray, size: int
) -> tuple[AnyArray, NDArray[np.int32], NDArray[np.float32], tuple[int, int]]:
    """Return the vertices used, again for each chart; faces, coordinates, the atlas's size."""
    try:
        import xatlas
    except ImportError:
        raise ExportError(
            "a baked texture needs xatlas, which is not installed; expected colours at the "
            "vertices",
            hint="pip install 'paint3d[texture]'",
        ) from None
    charts, pack = xatlas.ChartOptions(), xatlas.PackOptions()
    if len(faces) > FEW_FACES:
        charts.max_chart_area = SMALL_CHART * float(areas.sum())
    pack.resolution, pack.padding = size, PADDING
    atlas = xatlas.Atlas()
    atlas.add_mesh(np.ascontiguousarray(vertices, np.float32), faces.astype(np.uint32))
    atlas.generate(charts, pack)
    if atlas.atlas_count != 1:
        raise ExportError(
            "xatlas made {atlas_count} textures of the object; expected one",
            atlas_count=atlas.atlas_count,
        )
    source, corners, uv = atlas[0]
    return source, corners.astype(np.int32), uv, (atlas.width, atlas.height)


def _find_texels(
    vertices: AnyArray,
    faces: AnyArray,
    points: AnyArray,
    triangles: AnyArray,
    owners: AnyArray,
    corner_texels: AnyArray,
) -> NDArray[np.float64]:
    """Return the texel coordinates of each corner (3 F, 2) of the painted triangles."""
    a, b, c = (vertices[faces[:, k]].astype(np.float64) for k in range(3))
    ab, ac = b - a, c - a
    bb, bc, cc = (np.einsum("ij,ij->i", x, y) for x, y in ((ab, ab), (ab, ac), (ac, ac)))
    whole = bb * cc - bc * bc
    flat = whole <= 0.0
    whole[flat] = 1.0
    texels = np.empty((len(triangles), 3, 2))
    for corner in range(3):
        offset = points[triangles[:, corner]].astype(np.float64) - a[owners]
        along_b = np.einsum("ij,ij->i", offset, ab[owners])
        along_c = np.einsum("ij,ij->i", offset, ac[owners])
        v = (cc[owners] * along_b - bc[owners] * along_c) / whole[owners]
        w = (bb[owners] * along_c - bc[owners] * along_b) / whole[owners]
        v[flat[owners]] = w[flat[owners]] = 0.0
        weights = np.stack([1.0 - v - w, v, w], axis=1)
        texels[:, corner] = np.einsum("fk,fkd->fd", weights, corner_texels[owners])
    return texels.reshape(-1, 2)


def _draw_texture(
    corners_px: AnyArray, srgb: AnyArray, width: int, height: int
) -> NDArray[np.uint8]:
    """Return the texture (H, W, 3), every texel filled."""
    from scipy.ndimage import distance_transform_edt

    from paint3d.files.kernels.bake import fill_triangles

    image = np.zeros((height, width, 3), np.uint8)
    filled = np.zeros((height, width), np.uint8)
    corners = np.arange(len(corners_px), dtype=np.int32).reshape(-1, 3)
    fill_triangles(corners_px, corners, np.ascontiguousarray(srgb), image, filled)
    if not filled.any():
        raise ExportError(
            "a texture of {width} x {height} pixels is too small for the object",
            width=width,
            height=height,
        )
    rows, columns = distance_transform_edt(filled == 0, return_distances=False, return_indices=True)
    result: NDArray[np.uint8] = image[rows, columns]
    return result
