"""Small pieces of VTK that the live view is built from: meshes, textures, lights."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.view.kernels.chunks import mark_changed

if TYPE_CHECKING:
    from vtkmodules.vtkRenderingCore import vtkLight, vtkTexture

__all__ = ["DrawnMesh", "camera_light", "make_texture", "quiet_vtk"]


def quiet_vtk() -> None:
    """Suppress VTK's messages about its search for a display."""
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)


_KINDS = {"float32": "vtkFloatArray", "int32": "vtkIntArray", "uint8": "vtkUnsignedCharArray"}
_RGB = 3


class DrawnMesh:
    """Triangles or lines on screen, whose arrays can be replaced.

    Parameters
    ----------
    fourth : int
        Fourth channel of points whose colours have three.

    Attributes
    ----------
    actor : vtkActor
        For setting its appearance.
    data : vtkPolyData
        What its mapper draws, for attributes of other kinds.
    """

    def __init__(self, fourth: int = 255) -> None:
        from vtkmodules.vtkCommonDataModel import vtkPolyData
        from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

        self._fourth = fourth
        self.data = vtkPolyData()
        self._mapper = vtkPolyDataMapper()
        self._mapper.SetInputData(self.data)
        self._mapper.SetColorModeToDirectScalars()
        self._mapper.SetStatic(1)
        self._faces: AnyArray | None = None
        self._points = np.empty((0, 3), np.float32)
        self._normals: AnyArray | None = None
        self._sent = np.empty((0, 4), np.uint8)  # with four channels: VTK copies any other number
        self._place: Any = None
        self._vtk_normals: Any = None
        self._vtk_colours: Any = None
        self._attributes: dict[str, tuple[AnyArray, Any]] = {}
        self._shown = True
        self._strands: tuple[int, ...] = ()
        self.actor = vtkActor()
        self.actor.SetMapper(self._mapper)
        self.actor.PickableOff()

    def set_shape(self, points: AnyArray, faces: AnyArray, normals: AnyArray | None = None) -> None:
        """Replace the triangles: points (K, 3) float32, faces (L, 3) int32, normals (K, 3).

        If `faces` is the same array as last time, only positions and normals are sent. The faces
        are not copied, so they must not be changed afterwards.
        """
        if faces is self._faces and self._move(points, normals):
            return
        make = _makers()
        self._faces = faces
        self._points = np.array(points, np.float32, order="C")
        self._place = make["vtkPoints"]()
        self._place.SetData(_shared(self._points))
        cells = make["vtkCellArray"]()
        cells.SetData(3, _shared(np.ascontiguousarray(faces, np.int32).reshape(-1, 1)))
        self.data.SetPoints(self._place)
        self.data.SetPolys(cells)
        if normals is not None:
            self._normals = np.array(normals, np.float32, order="C")
            self._vtk_normals = _shared(self._normals)
            self.data.GetPointData().SetNormals(self._vtk_normals)

    def _move(self, points: AnyArray, normals: AnyArray | None) -> bool:
        """Replace positions and normals of equally many points; return whether possible."""
        if self._points.shape != points.shape or (normals is None) != (self._normals is None):
            return False
        self._points[:] = points
        self._place.GetData().Modified()
        self._place.Modified()
        if normals is not None and self._normals is not None:
            self._normals[:] = normals
            self._vtk_normals.Modified()
        return True

    def set_line(self, points: AnyArray, *, closed: bool) -> None:
        """Replace everything by one line through the points (K, 3), as `set_strands` does."""
        ring = np.concatenate([points, points[:1]]) if closed else points
        self.set_strands(ring[None])

    def set_lines(self, lines: Sequence[AnyArray]) -> None:
        """Replace everything by lines, each through its own points (K, 3)."""
        from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkCellArray

        points = np.concatenate([np.empty((0, 3), np.float32), *lines]).astype(np.float32)
        starts = np.concatenate([[0], np.cumsum([len(line) for line in lines])])
        place, cells = vtkPoints(), vtkCellArray()
        place.SetData(numpy_to_vtk(points, deep=True))
        cells.SetData(
            numpy_to_vtkIdTypeArray(starts.astype(np.int64), deep=True),
            numpy_to_vtkIdTypeArray(np.arange(len(points), dtype=np.int64), deep=True),
        )
        self.data.SetPoints(place)
        self.data.SetLines(cells)

    def set_strands(self, points: AnyArray) -> None:
        """Replace everything by lines of as many points each (L, S, 3).

        If there are as many as last time, only positions are sent.
        """
        flat = points.reshape(-1, 3)
        if self._strands == points.shape[:2] and self._move(flat, None):
            return
        from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkCellArray

        self._strands = points.shape[:2]
        self._points = np.array(flat, np.float32, order="C")
        self._place, cells = vtkPoints(), vtkCellArray()
        self._place.SetData(numpy_to_vtk(self._points, deep=False))
        starts = points.shape[1] * np.arange(points.shape[0] + 1, dtype=np.int64)
        cells.SetData(
            numpy_to_vtkIdTypeArray(starts, deep=True),
            numpy_to_vtkIdTypeArray(np.arange(len(flat), dtype=np.int64), deep=True),
        )
        self.data.SetPoints(self._place)
        self.data.SetLines(cells)

    def set_colours(self, colours: AnyArray) -> None:
        """Replace the colours (K, 3) or (K, 4) uint8 of the points."""
        if self._vtk_colours is not None and len(self._sent) == len(colours):
            self._sent[:] = self._four(colours)
            self._vtk_colours.Modified()
            return
        if colours.shape[1] == _RGB:
            self.actor.ForceOpaqueOn()  # or VTK searches the colours for translucent ones
        self._sent = np.array(self._four(colours), np.uint8, order="C")
        self._vtk_colours = _shared(self._sent)
        self.data.GetPointData().SetScalars(self._vtk_colours)

    def _four(self, colours: AnyArray) -> AnyArray:
        """Return colours with four channels."""
        if colours.shape[1] > _RGB:
            return colours
        four = np.full((len(colours), _RGB + 1), self._fourth, np.uint8)
        four[:, :_RGB] = colours
        return four

    def set_attribute(self, name: str, values: AnyArray) -> None:
        """Replace an attribute (K, 1) float32 of the points; see `read_attributes`."""
        sent, held = self._attributes.get(name, (values[:0], None))
        if len(sent) == len(values):
            if not np.array_equal(sent, values):
                sent[:] = values
                held.Modified()
            return
        sent = np.array(values, np.float32, order="C")
        held = _shared(sent)
        held.SetName(name)
        self.data.GetPointData().AddArray(held)
        self._attributes[name] = sent, held

    def read_attributes(self) -> None:
        """Declare the attributes set so far in the shaders, each as `in float name`."""
        points = 0  # VTK's FIELD_ASSOCIATION_POINTS
        for name in self._attributes:
            self._mapper.MapDataArrayToVertexAttribute(name, name, points, -1)

    def changed_by(self, colours: AnyArray, **attributes: AnyArray) -> AnyArray:
        """Return the corners (N, 3) float32 of all triangles that new values would change.

        Parameters
        ----------
        colours : (K, C) uint8
        **attributes : (K, 1) float32
            By name, as `set_attribute` takes them.
        """
        if self._faces is None or self._vtk_colours is None:
            return self._points
        marks = np.empty(len(colours), np.uint8)
        mark_changed(self._sent, self._four(colours), self._faces, marks)
        changed = marks.astype(bool)
        for name, values in attributes.items():
            sent = self._attributes[name][0]
            if len(sent) != len(values) or not np.array_equal(sent, values):
                bytes_sent, bytes_now = sent.view(np.uint8), values.view(np.uint8)
                mark_changed(bytes_sent, bytes_now, self._faces, marks)
                changed |= marks.astype(bool)
        result: AnyArray = self._points[changed]
        return result

    def keep_places(self) -> None:
        """Pass points to shaders unchanged: by default VTK may shift and scale them."""
        self._mapper.SetVBOShiftScaleMethod(0)

    def drop_nothing(self) -> None:
        """Remove `discard` from the shader, which prevents the early depth test.

        In software that costs a fifth of an object's time. Other shader replacements must come
        after this one.
        """
        shader = self.actor.GetShaderProperty()
        shader.AddFragmentShaderReplacement("discard;", True, "", False)

    def show(self, on: bool) -> None:
        """Set the visibility."""
        if on != self._shown:
            self._shown = on
            self.actor.SetVisibility(on)

    def draw_before(self) -> None:
        """Offset its depth so that it is drawn over a coincident surface."""
        self._mapper.SetResolveCoincidentTopologyToPolygonOffset()
        self._mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(-2.0, -2.0)
        self._mapper.SetRelativeCoincidentTopologyLineOffsetParameters(-2.0, -4.0)

    def set_texture(self, pixels: AnyArray, corners: AnyArray) -> None:
        """Set a texture (H, W, 4) uint8, bottom row first; corners (K, 2) are the points' u, v."""
        self.set_texture_coordinates(corners)
        self.actor.SetTexture(make_texture(pixels))

    def set_texture_coordinates(self, corners: AnyArray) -> None:
        """Set the points' places u, v (K, 2) in textures."""
        from vtkmodules.util.numpy_support import numpy_to_vtk

        array = numpy_to_vtk(np.ascontiguousarray(corners, np.float32), deep=True)
        self.data.GetPointData().SetTCoords(array)


@cache
def _makers() -> dict[str, Any]:
    """Return VTK's classes by name; cached, since Qt's import hook slows every local import."""
    from vtkmodules import vtkCommonCore, vtkCommonDataModel

    classes = {"vtkCellArray": vtkCommonDataModel.vtkCellArray}
    names = ("vtkPoints", *_KINDS.values())
    return classes | {name: getattr(vtkCommonCore, name) for name in names}


def _shared(array: AnyArray) -> Any:
    """Wrap a C-contiguous array (N, C) in a VTK array that shares its memory and keeps it alive.

    The same as `numpy_to_vtk`, which takes five times as long because of its checks.
    """
    made = _makers()[_KINDS[array.dtype.name]]()
    made.SetNumberOfComponents(array.shape[1])
    made.SetVoidArray(array, array.size, 1)
    holder = made.GetBuffer() if hasattr(made, "GetBuffer") else made  # as in `numpy_to_vtk`
    holder._numpy_reference = array
    return made


def make_texture(pixels: AnyArray) -> vtkTexture:
    """Return a linearly filtered texture of (H, W, C) uint8 pixels, first row at the bottom."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkRenderingCore import vtkTexture

    height, width, channels = pixels.shape
    image = vtkImageData()
    image.SetDimensions(width, height, 1)
    flat = np.ascontiguousarray(pixels).reshape(-1, channels)
    image.GetPointData().SetScalars(numpy_to_vtk(flat, deep=True))
    texture = vtkTexture()
    texture.SetInputData(image)
    texture.SetColorModeToDirectScalars()
    texture.InterpolateOn()
    texture.SetWrap(vtkTexture.ClampToEdge)
    return texture


def camera_light(
    position: tuple[float, float, float],
    intensity: float,
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> vtkLight:
    """Return a parallel light fixed to the camera: x right, y up, z from the object to the eye."""
    from vtkmodules.vtkRenderingCore import vtkLight

    light = vtkLight()
    light.SetLightTypeToCameraLight()
    light.SetPosition(*position)
    light.SetFocalPoint(0.0, 0.0, 0.0)
    light.SetIntensity(intensity)
    light.SetColor(*colour)
    return light
