"""A film of the object turning once on its foot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PIL import Image
from PySide6 import QtWidgets

from paint3d.app.model.navigation import orbit
from paint3d.app.window.wording import say
from paint3d.errors import ExportError
from paint3d.files.atomic import write_atomically

if TYPE_CHECKING:
    from paint3d.app.window.studio import StudioWindow

__all__ = ["write_turntable"]

_FRAME_MS = 70
_FORMATS = {".gif": "GIF", ".webp": "WEBP"}


def write_turntable(window: StudioWindow, path: Path, n_frames: int) -> None:
    """Draw the film frame by frame, with a bar, and write it; nothing if it was stopped.

    Raises
    ------
    ExportError
        If the suffix is not .gif or .webp, or the file cannot be written.
    """
    kind = _FORMATS.get(path.suffix.lower())
    if kind is None:
        raise ExportError(f"{path}: a film is written as .gif or .webp")
    bar = QtWidgets.QProgressDialog(
        say("Drawing the film…"), say("button.cancel"), 0, n_frames, window
    )
    bar.setMinimumDuration(300)
    camera, height, frames = window.hand.camera, window.canvas.height(), []
    for k in range(n_frames):
        window.stage.set_camera(orbit(camera, -2.0 * height * k / n_frames, 0.0, height))
        frames.append(Image.fromarray(window.stage.picture()[::-1, :, :3]))
        bar.setValue(k + 1)
        QtWidgets.QApplication.processEvents()
        if bar.wasCanceled():
            break
    window.stage.set_camera(camera)
    bar.close()
    if len(frames) < n_frames:
        return
    with write_atomically(path) as part:
        frames[0].save(
            part, format=kind, save_all=True, append_images=frames[1:], duration=_FRAME_MS, loop=0
        )
