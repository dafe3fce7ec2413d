"""Conversion of a painting to trimesh, Open3D and PyVista, each imported only when needed.

Objects get all vertices, in the order of `PaintedSurface.mesh`, with colours and normals and,
where the type can hold them, the per-layer arrays (`layer_arrays`).
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.illuminants import colour_science
from paint3d.colour.spectra import WAVELENGTHS
from paint3d.core.arrays import AnyArray
from paint3d.errors import ExportError
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["open3d_of", "plot_painting", "pyvista_of", "spectral_of", "trimesh_of"]

_COLOURS = "srgb"


class Paintings(Protocol):
    """Interface of a painting to convert."""

    @property
    def mesh(self) -> TriangleMesh:
        """All vertices and faces, with colours and normals."""
        ...

    def layer_arrays(self) -> dict[str, NDArray[np.float32]]:
        """Return the ink of every layer, vertex by vertex."""
        ...


def trimesh_of(painting: Paintings) -> Any:
    """Return a trimesh.Trimesh; see `PaintedSurface.to_trimesh`."""
    trimesh, mesh = _package("trimesh"), painting.mesh
    return trimesh.Trimesh(
        np.array(mesh.vertices, np.float64),  # a copy: trimesh writes to its arguments
        np.array(mesh.faces, np.int64),
        vertex_normals=_normals(mesh),
        vertex_colors=np.array(mesh.colours),
        vertex_attributes=painting.layer_arrays(),
        metadata={"name": mesh.name, "units": "mm"},
        process=False,  # processing would merge vertices and lose their order
    )


def spectral_of(spectra: NDArray[np.float64], labels: AnyArray) -> Any:
    """Return a colour.MultiSpectralDistributions of spectra (N, 31), labelled (N,)."""
    named = [str(label) for label in labels.tolist()]
    return colour_science().MultiSpectralDistributions(spectra.T, WAVELENGTHS, labels=named)


def open3d_of(painting: Paintings, legacy: bool = False) -> Any:
    """Return an open3d.t.geometry.TriangleMesh, or a legacy one; see `PaintedSurface.to_open3d`."""
    open3d, mesh = _package("open3d"), painting.mesh
    colours = np.asarray(mesh.colours)
    if legacy:
        given = open3d.geometry.TriangleMesh(
            open3d.utility.Vector3dVector(mesh.vertices.astype(np.float64)),
            open3d.utility.Vector3iVector(np.array(mesh.faces)),
        )
        given.vertex_colors = open3d.utility.Vector3dVector(colours / 255.0)
        given.vertex_normals = open3d.utility.Vector3dVector(_normals(mesh).astype(np.float64))
        return given
    given = open3d.t.geometry.TriangleMesh(_tensor(mesh.vertices), _tensor(mesh.faces))
    for name, array in _arrays(painting, mesh, "colors", "normals").items():
        given.vertex[name] = _tensor(array)
    return given


def pyvista_of(painting: Paintings) -> Any:
    """Return a pyvista.PolyData; see `PaintedSurface.to_pyvista`."""
    pyvista, mesh = _package("pyvista"), painting.mesh
    given = pyvista.PolyData.from_regular_faces(np.array(mesh.vertices), np.array(mesh.faces))
    for name, array in _arrays(painting, mesh, _COLOURS, "Normals").items():
        given.point_data[name] = array
    given.point_data.active_normals_name = "Normals"
    given.point_data.active_scalars_name = _COLOURS
    return given


def plot_painting(painting: Paintings, *, lit: bool, plotter: Any, options: Any) -> Any:
    """Show a painting with PyVista; see `PaintedSurface.plot`."""
    pyvista = _package("pyvista")
    off_screen = options.pop("off_screen", None)
    window = pyvista.Plotter(off_screen=off_screen) if plotter is None else plotter
    window.add_mesh(
        pyvista_of(painting), scalars=_COLOURS, rgb=True, lighting=lit, smooth_shading=False,
        show_scalar_bar=False,
    )  # fmt: skip
    if plotter is not None:
        return window
    return window.show(**options)


def _arrays(
    painting: Paintings, mesh: TriangleMesh, colours: str, normals: str
) -> dict[str, AnyArray]:
    given: Mapping[str, AnyArray] = painting.layer_arrays()
    return {colours: np.array(mesh.colours), normals: _normals(mesh), **given}


def _normals(mesh: TriangleMesh) -> NDArray[np.float32]:
    return np.array(mesh.normals, np.float32)


def _tensor(array: AnyArray) -> Any:
    return _package("open3d").core.Tensor(np.ascontiguousarray(array))


def _package(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError as cause:
        raise ExportError(
            "{name} could not be loaded: {cause}; expected it installed",
            name=name,
            cause=cause,
            hint=f"pip install {name}",
        ) from None
