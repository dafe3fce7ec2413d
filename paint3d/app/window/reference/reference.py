"""The reference picture: opened, drawn over the view or on the object, saved with the painting."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.window.copybook.copybook_guide import CopybookGuide
from paint3d.app.window.files.file_dialogs import look_at_names_only
from paint3d.app.window.reference.reference_panel import PLACES, ReferencePanel, image_of
from paint3d.app.window.wording import say, say_error
from paint3d.app.window.workspace import Workspace
from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.errors import MeshError, Paint3DError
from paint3d.files.photographs import PHOTOGRAPH_SUFFIXES, load_photograph
from paint3d.mesh.chart import SurfaceFrame, frame_at, make_chart
from paint3d.view.camera import picture_axes

__all__ = ["Reference"]

_EM_MM = 40.0  # of a copybook of it
_OPACITY = 0.5  # at first
_PINNED = 0.6  # of the view's size
_LAID = 0.45  # half of the picture on the object, as a fraction of its half diagonal
_SMALLER, _TRIES = 0.8, 8  # where there is no room
_CELLS = 12  # along each side of a picture on a curved object
_MOST_SCALE = 10.0


class Reference:
    """The picture that is painted after: in its panel, over the view, or on the object.

    Parameters
    ----------
    workspace : Workspace
    panel : ReferencePanel
    copying : CopybookGuide
        Lays its strokes out.
    mix : callable
        Mixes a colour of it.
    """

    def __init__(
        self,
        workspace: Workspace,
        panel: ReferencePanel,
        copying: CopybookGuide,
        mix: Callable[[QtGui.QColor], object],
    ) -> None:
        self._workspace, self._panel, self._copying = workspace, panel, copying
        self._file: Path | None = None
        self._image: QtGui.QImage | None = None
        self._point: AnyArray | None = None  # of the object, at the picture's middle
        self._up = np.array([0.0, 0.0, 1.0])
        self._grid: AnyArray | None = None  # (N, N, 3), the corners of its cells
        self._normals: AnyArray | None = None
        workspace.canvas.overlays.insert(0, self._paint)
        panel.asked.connect(self.do_reference)
        panel.closed.connect(self.close)
        panel.copied.connect(self._copy)
        panel.changed.connect(self._change)
        panel.picked.connect(mix)
        workspace.opened.connect(lambda opened: self._recall(opened.document))

    def do_reference(self) -> None:
        """Ask for a picture, and show it in the panel."""
        endings = " ".join("*" + kind for kind in PHOTOGRAPH_SUFFIXES)
        dialog = QtWidgets.QFileDialog(
            self._workspace.window, say("Open a picture…"), filter=f"{say('Pictures')} ({endings})"
        )
        dialog.setOption(QtWidgets.QFileDialog.Option.DontUseNativeDialog)
        dialog.setFileMode(QtWidgets.QFileDialog.FileMode.ExistingFile)
        look_at_names_only(dialog)
        if dialog.exec() and dialog.selectedFiles():
            self.open(dialog.selectedFiles()[0])

    def open(self, file: str | Path) -> bool:
        """Show a picture as the reference; return whether that succeeded."""
        path = Path(file)
        title = say("Opening {name}…", name=path.name)
        loaded = self._workspace.run(title, lambda _: load_photograph(path))
        if not self._workspace.went_well(loaded):
            return False
        self._take(path, image_of(loaded.result()[0]))
        self._post_to_painting()
        return True

    def _take(self, path: Path, image: QtGui.QImage) -> None:
        self._file, self._image = path, image
        self._grid = None
        self._panel.show_image(image)
        self._show_panel(True)
        self._workspace.canvas.update()

    def _show_panel(self, on: bool) -> None:
        for dock in self._workspace.window.findChildren(QtWidgets.QDockWidget):
            if dock.isAncestorOf(self._panel):
                dock.setVisible(on)

    def close(self) -> None:
        """Close the reference."""
        self._forget()
        self._show_panel(False)
        self._post_to_painting()
        self._workspace.canvas.update()

    def _forget(self) -> None:
        self._file = self._image = self._point = self._grid = None
        self._panel.show_image(None)
        self._panel.show_values(PLACES[0], _OPACITY, 1.0)

    def _copy(self) -> None:
        if self._file is not None:
            self._copying.layout_file(str(self._file), _EM_MM)

    def _change(self) -> None:
        if self._panel.values()["place"] != "laid":
            self._point = None  # it is laid anew at the view's middle
        self._grid = None
        self._post_to_painting()
        self._workspace.canvas.update()

    # -- with the painting ------------------------------------------------------------------

    def _post_to_painting(self) -> None:
        """Post the reference to the painting, which saves it."""
        words: dict[str, Any] | None = None
        if self._file is not None:
            words = {"file": str(self._file.absolute()), **self._panel.values()}
            if self._point is not None:
                words |= {"point": self._point.tolist(), "up": self._up.tolist()}
        if self._workspace.stage.paint_thread is not None:
            self._workspace.paint_thread.post("set_reference", words)

    def _recall(self, document: Document) -> None:
        """Show the reference of a painting that is being opened, if its file is still there."""
        self._forget()
        words = document.properties.get("reference")
        if isinstance(words, dict):
            try:
                self._read(words)
            except (Paint3DError, KeyError, TypeError, OSError) as error:
                why = say_error(error) if isinstance(error, Paint3DError) else f"{error}"
                self._workspace.tell_first(say("The reference is not shown: {why}", why=why))

    def _read(self, words: dict[str, Any]) -> None:
        path = Path(words["file"])
        if not path.name.lower().endswith(PHOTOGRAPH_SUFFIXES):
            return  # nothing but what is named as a picture is read
        where = words["place"] if words["place"] in PLACES else PLACES[0]
        opacity = as_number(words["opacity"], "opacity", 0.0, 1.0)
        scale = as_number(words["scale"], "scale", 0.01, _MOST_SCALE)
        pixels, _ = load_photograph(path)
        self._panel.show_values(where, opacity, scale)
        if "point" in words:
            self._point = as_array(words["point"], "point", (3,))
            self._up = as_array(words["up"], "up", (3,))
        self._take(path, image_of(pixels))

    # -- over the work ----------------------------------------------------------------------

    def _paint(self, painter: QtGui.QPainter, rect: QtCore.QRect) -> None:
        """Draw the picture over the view, or on the object as it is seen."""
        values = self._panel.values()
        image, place = self._image, values["place"]
        if image is None or place == "beside" or self._workspace.hand.camera is None:
            return
        painter.save()
        painter.setOpacity(values["opacity"])
        painter.setRenderHint(QtGui.QPainter.RenderHint.SmoothPixmapTransform)
        if place == "pinned":
            size = QtCore.QSizeF(image.size()).scaled(
                QtCore.QSizeF(rect.size()) * _PINNED * values["scale"],
                QtCore.Qt.AspectRatioMode.KeepAspectRatio,
            )
            box = QtCore.QRectF(QtCore.QPointF(), size)
            box.moveCenter(QtCore.QRectF(rect).center())
            painter.drawImage(box, image)
        else:
            painter.setCompositionMode(QtGui.QPainter.CompositionMode.CompositionMode_Multiply)
            self._paint_laid(painter, image, values["scale"])
        painter.restore()

    def _paint_laid(self, painter: QtGui.QPainter, image: QtGui.QImage, scale: float) -> None:
        """Draw the picture cell by cell where the object's outside is seen."""
        if self._grid is None:
            self._lay(image, scale)
        if self._grid is None or self._normals is None:
            return
        n = len(self._grid) - 1
        hand = self._workspace.hand
        pixels = hand.pixels_of(self._grid.reshape(-1, 3)).reshape(n + 1, n + 1, 2)
        towards = hand.open_camera.position - self._grid
        faces = (towards * self._normals).sum(axis=2) > 0.0
        faces &= hand.sees(self._grid.reshape(-1, 3)).reshape(n + 1, n + 1)
        width, height = image.width(), image.height()
        for row in range(n):
            for column in range(n):
                corners = [(row, column), (row, column + 1), (row + 1, column + 1),
                           (row + 1, column)]  # fmt: skip
                if not all(faces[k] and np.isfinite(pixels[k]).all() for k in corners):
                    continue
                x0, x1 = (round(width * k / n) for k in (column, column + 1))
                y0, y1 = (round(height * k / n) for k in (row, row + 1))
                source = QtCore.QRect(x0, y0, max(1, x1 - x0), max(1, y1 - y0))
                onto = _transform(source, [pixels[k] for k in corners])
                if onto is not None:
                    painter.save()
                    painter.setTransform(onto, True)
                    painter.drawImage(QtCore.QRectF(QtCore.QPointF(), source.size()), image, source)
                    painter.restore()

    def _lay(self, image: QtGui.QImage, scale: float) -> None:
        """Lay the picture at the view's middle, as large as there is room."""
        hand, points = self._workspace.hand, self._workspace.stage.points
        if self._point is None:
            canvas = self._workspace.canvas
            point = hand.place_at(0.5 * canvas.width(), 0.5 * canvas.height())
            self._point = points.mean(axis=0, dtype=np.float64) if point is None else point
            self._up = np.asarray(picture_axes(hand.open_camera)[1], np.float64)
            self._post_to_painting()
        frame = frame_at(hand.surface, self._point, self._up)
        half = _LAID * 0.5 * float(np.linalg.norm(np.ptp(points, axis=0))) * scale
        longer = max(image.width(), image.height())
        wide, high = half * image.width() / longer, half * image.height() / longer
        for _ in range(_TRIES):
            with suppress(MeshError):
                self._grid, self._normals = _lay_grid(hand.surface, frame, wide, high)
                return
            wide, high = _SMALLER * wide, _SMALLER * high
        self._workspace.tell(say("There is no room for the reference on the object"), state="bad")
        self._grid, self._normals = np.empty((1, 1, 3)), np.empty((1, 1, 3))


def _lay_grid(
    surface: Any, frame: SurfaceFrame, wide: float, high: float
) -> tuple[AnyArray, AnyArray]:
    """Return points and normals (N, N, 3) of a picture's cells on the object, upper left first."""
    chart = make_chart(surface, frame, wide, high, 2.0 * max(wide, high) / _CELLS)
    x, y = np.linspace(-wide, wide, _CELLS + 1), np.linspace(high, -high, _CELLS + 1)
    xy = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    shape = (_CELLS + 1, _CELLS + 1, 3)
    return chart.points(xy).reshape(shape), chart.normals(xy).reshape(shape)


def _transform(source: QtCore.QRect, corners: list[AnyArray]) -> QtGui.QTransform | None:
    """Return the transform of a rectangle of the source's size at the origin to four corners."""
    width, height = float(source.width()), float(source.height())
    flat = QtGui.QPolygonF(
        [
            QtCore.QPointF(0, 0),
            QtCore.QPointF(width, 0),
            QtCore.QPointF(width, height),
            QtCore.QPointF(0, height),
        ]
    )
    seen = QtGui.QPolygonF([QtCore.QPointF(float(x), float(y)) for x, y in corners])
    if not math.isfinite(seen.boundingRect().width()):
        return None
    onto = QtGui.QTransform()
    return onto if QtGui.QTransform.quadToQuad(flat, seen, onto) else None
