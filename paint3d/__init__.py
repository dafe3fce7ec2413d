"""Paint Chinese calligraphy and brushwork on 3-D objects with a physically modelled brush.

The names below are loaded when they are first used, so that ``import paint3d`` itself is quick
and loads none of the heavy packages.

>>> import paint3d
>>> surface = paint3d.PaintedSurface(paint3d.load_mesh("bowl"), resolution=0.4)
>>> painter = paint3d.Painter(surface, brush="full", ink="pine soot")
>>> painter.replay(paint3d.load_recording("strokes.jsonl"))
>>> paint3d.export(surface, "bowl.glb")
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from paint3d import errors
    from paint3d.colour.layers import mixture_reflectance
    from paint3d.files.export import export
    from paint3d.files.export_options import ExportOptions
    from paint3d.files.load import load_mesh
    from paint3d.files.project.session import Session, load_session, save_session
    from paint3d.mesh.triangle_mesh import TriangleMesh
    from paint3d.painter.painter import Painter
    from paint3d.recording.recording import Recording, load_recording
    from paint3d.surface.painted_surface import PaintedSurface

    __version__: str

__all__ = [
    "ExportOptions",
    "PaintedSurface",
    "Painter",
    "Recording",
    "Session",
    "TriangleMesh",
    "__version__",
    "errors",
    "export",
    "load_mesh",
    "load_recording",
    "load_session",
    "mixture_reflectance",
    "save_session",
]

_HOME_OF = {
    "ExportOptions": "paint3d.files.export_options",
    "PaintedSurface": "paint3d.surface.painted_surface",
    "Painter": "paint3d.painter.painter",
    "Recording": "paint3d.recording.recording",
    "Session": "paint3d.files.project.session",
    "TriangleMesh": "paint3d.mesh.triangle_mesh",
    "export": "paint3d.files.export",
    "load_mesh": "paint3d.files.load",
    "load_recording": "paint3d.recording.recording",
    "load_session": "paint3d.files.project.session",
    "mixture_reflectance": "paint3d.colour.layers",
    "save_session": "paint3d.files.project.session",
}


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import PackageNotFoundError, version

        try:
            value: object = version("paint3d")
        except PackageNotFoundError:  # a source tree that was never installed
            value = "0+unknown"
    elif name == "errors":
        value = import_module("paint3d.errors")
    elif name in _HOME_OF:
        value = getattr(import_module(_HOME_OF[name]), name)
    else:
        raise AttributeError(f"module 'paint3d' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
