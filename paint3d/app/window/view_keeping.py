"""Views saved with a painting: by name, and the last one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from PySide6 import QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.window.lamp import Lamp
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.core.arrays import as_array, as_number
from paint3d.errors import InputError
from paint3d.view.camera import Camera, picture_axes

__all__ = ["ViewKeeping"]

_MOST = 100


class ViewKeeping:
    """Saves views by name and goes back to them; ``do_<action>`` for each."""

    def __init__(self, workspace: Workspace, lamp: Lamp) -> None:
        self._workspace, self._lamp = workspace, lamp
        self.views: dict[str, Camera] = {}
        workspace.before_saving = self._write_view

    def do_keep_view(self) -> None:
        """Ask for a name, and save the view by it."""
        workspace = self._workspace
        name, agreed = QtWidgets.QInputDialog.getText(
            workspace.window, say("Keep this view…").rstrip("…"), say("Its name"),
            text=say("View {n}", n=len(self.views) + 1),
        )  # fmt: skip
        name = name.strip()
        if not agreed or not name:
            return
        if name not in self.views and len(self.views) >= _MOST:
            workspace.tell(say("There are {n} views; expected no more", n=_MOST), state="bad")
            return
        self.views[name] = workspace.hand.open_camera
        words = {name: _words_of(camera) for name, camera in self.views.items()}
        workspace.paint_thread.post("set_views", words)
        workspace.tell(say("The view is kept as {name}", name=name), state="good")

    def do_recall_view(self) -> None:
        """Ask for a saved view, and go back to it."""
        workspace = self._workspace
        if not self.views:
            workspace.tell(say("No view is kept; Ctrl+Shift+B keeps this one"), state="bad")
            return
        name, agreed = QtWidgets.QInputDialog.getItem(
            workspace.window, say("Kept views…").rstrip("…"), say("View"), list(self.views),
            editable=False,
        )  # fmt: skip
        if agreed and name in self.views:
            workspace.hand.look(self.views[name])

    def recall_last(self, document: Document) -> None:
        """Restore the view, the light and the named views of a painting."""
        self.views = {}
        self._lamp.recall(document)
        words = document.properties.get("views")
        if isinstance(words, Mapping):
            for name, view in list(words.items())[:_MOST]:
                camera = _camera_of(view)
                if camera is not None:
                    self.views[str(name)] = camera
        last = _camera_of(document.properties.get("view"))
        if last is not None:
            self._workspace.hand.look(last)

    def _write_view(self, document: Document) -> None:
        """Write the current view into a painting that is about to be saved."""
        camera = self._workspace.hand.camera
        if camera is not None:
            document.properties["view"] = _words_of(camera)


def _words_of(camera: Camera) -> dict[str, Any]:
    return {
        "position": [float(x) for x in camera.position],
        "focus": [float(x) for x in camera.focus],
        "up": [float(x) for x in camera.up],
        "angle": float(camera.view_angle),
    }


def _camera_of(words: object) -> Camera | None:
    """Return a saved camera; None if it is invalid."""
    if not isinstance(words, Mapping):
        return None
    try:
        position, focus, up = (
            as_array(words[name], name, (3,)) for name in ("position", "focus", "up")
        )
        camera = Camera(position, focus, up, as_number(words["angle"], "angle", 1e-3, 3.0))
        picture_axes(camera)  # raises if it has no direction
        return camera
    except (KeyError, InputError):
        return None
