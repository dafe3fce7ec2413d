"""A page that shows the object in three dimensions, all in one file: no server, no network."""

from __future__ import annotations

import base64
import html
import json
import math
import re
import zlib
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.view.edges import Edges
from paint3d.view.paper import RECIPE, SHADER

__all__ = ["write_html"]

RESOURCES = "viewer"
MARK = re.compile(r"\{\{(\w+)\}\}")
VERTEX = np.dtype(
    [
        ("place", "<u2", 3),
        ("shares", "u1", 2),
        ("normal", "i1", 4),
        ("colour", "u1", 4),
        ("bare", "u1", 4),
    ]
)
COMPRESSION = 4


def write_html(
    path: Path,
    vertices: NDArray[np.float32],
    faces: NDArray[np.int32],
    normals: NDArray[np.float32],
    srgb: NDArray[np.uint8],
    *,
    title: str = "painting",
    edges: Edges | None = None,
    paper: tuple[float, float] = (0.0, 0.0),
    note: str = "",
) -> None:
    """Write a viewer with the object, seen first from its painted side.

    Places are rounded to 1/65535 of the object's size in each direction; colours are exact.

    Parameters
    ----------
    path : Path
    vertices : (V, 3) float32
        z up.
    faces : (F, 3) int32
    normals : (V, 3) float32, unit
    srgb : (V, 3) uint8
    title : str
    edges : Edges, optional
        Those of the paint (V vertices), shown sharp; by default colours are interpolated there.
    paper : (2,) of float
        As in `Gloss`.
    note : str
        What is said below it.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    low, high = (limit.astype(np.float64) for limit in (vertices.min(axis=0), vertices.max(axis=0)))
    azimuth, elevation = _first_view(vertices, faces, normals, srgb)
    about: dict[str, Any] = {
        "vertices": len(vertices),
        "indices": int(faces.size),
        "low": low.tolist(),
        "high": high.tolist(),
        "azimuth": azimuth,
        "elevation": elevation,
    }
    if any(paper):
        about["paper"] = {"amount": paper, "recipe": RECIPE, "shader": SHADER}
    if edges is None:
        edges = Edges(srgb, np.full((len(srgb), 2), 255, np.uint8))
    rows = _interleave(vertices, normals, srgb, edges, low, high)
    data = rows.tobytes() + faces.astype("<u4").tobytes()
    parts = {
        "title": html.escape(title),
        "note": html.escape(note),
        "about": json.dumps(about),
        "mesh": base64.b64encode(zlib.compress(data, COMPRESSION)).decode("ascii"),
        "style": _resource("viewer.css"),
        "paper": _resource("paper.js").replace("export ", "") if any(paper) else "",
        "script": _resource("viewer.js"),
    }
    page = MARK.sub(lambda mark: parts[mark[1]], _resource("viewer.html"))
    path.write_text(page, encoding="utf-8", newline="\n")


def _resource(name: str) -> str:
    return files("paint3d.files").joinpath(RESOURCES, name).read_text(encoding="utf-8")


def _interleave(
    vertices: AnyArray,
    normals: AnyArray,
    srgb: AnyArray,
    edges: Edges,
    low: AnyArray,
    high: AnyArray,
) -> AnyArray:
    """Return the interleaved vertex buffer, (V,) of `VERTEX`."""
    span = np.where(high > low, high - low, 1.0)
    out = np.zeros(len(vertices), VERTEX)
    out["place"] = np.rint((vertices - low) / span * 65535.0)
    out["normal"][:, :3] = np.rint(normals * 127.0)
    out["colour"][:, :3] = srgb
    out["bare"][:, :3] = edges.bare
    out["shares"] = edges.shares
    return out


def _first_view(
    vertices: AnyArray, faces: AnyArray, normals: AnyArray, srgb: AnyArray
) -> tuple[float, float]:
    """Return azimuth and elevation of the camera, degrees."""
    from paint3d.view.camera import find_view, vertex_areas

    view = find_view(vertices, normals, srgb, vertex_areas(vertices, faces))
    x, y, z = np.asarray(view.direction, np.float64).tolist()
    elevation = math.degrees(math.asin(max(-1.0, min(1.0, z))))
    if math.hypot(x, y) < 1e-6:  # from above or below: what is up in the view gives the azimuth
        up = np.asarray(view.up, np.float64).tolist()
        x, y = (-math.copysign(1.0, z) * value for value in up[:2])
    return math.degrees(math.atan2(y, x)), elevation
