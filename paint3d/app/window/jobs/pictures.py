"""Pictures of what is on the screen, and films."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image
from PySide6 import QtWidgets

from paint3d.app.window.dialogs.film_dialog import Film, FilmDialog, kept_film
from paint3d.app.window.jobs.job import Progress, run_beside
from paint3d.app.window.jobs.turntable import write_turntable
from paint3d.app.window.wording import say, say_error
from paint3d.core.atomic import write_atomically
from paint3d.errors import ExportError, Paint3DError

if TYPE_CHECKING:
    from paint3d.app.window.studio import StudioWindow

__all__ = ["Pictures"]

_PICTURES = {".png": "Picture, PNG", ".jpg": "Picture, JPEG"}
_FILMS = {".webp": "Film, WebP", ".gif": "Film, GIF"}
_FORMATS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG"}
_FINE_PIXELS = 4_500_000  # more are drawn without being smoothed, which needs four times as many
_QUALITY = 92


class Pictures:
    """For one window; a part of `Files`."""

    _window: StudioWindow
    went_well: Callable[[Future], bool]
    ask_target: Callable[..., Path | None]

    def screenshot(self) -> None:
        """Ask where, and save the picture as it is seen."""
        path = self.ask_target(say("action.screenshot"), _PICTURES)
        if path is not None:
            self.screenshot_to(path)

    def screenshot_to(self, path: Path) -> bool:
        """Write the picture as it is seen, without what lies over it."""
        return self.picture_to(path, self._window.canvas.pixel_size)

    def picture_to(self, path: Path, size: tuple[int, int], quality: int = _QUALITY) -> bool:
        """Write what is on the screen, without what lies over it; say whether that went well.

        Parameters
        ----------
        path : Path
            .png or .jpg.
        size : (int, int)
            Width and height, pixels; what the height shows stays the same.
        quality : int
            Of a JPEG, 1 to 100.
        """
        form = _FORMATS.get(path.suffix.lower())

        def work(progress: Progress) -> None:
            if form is None:
                raise ExportError(f"{path}: a picture is written as .png or .jpg")
            progress.expect(0.0, 0.95, 0.5)
            with write_atomically(path, progress) as part:
                Image.fromarray(pixels).save(part, format=form, quality=quality)

        pixels = self._drawn(size)
        done = run_beside(self._window, say("Writing {name}…", name=path.name), work)
        if not self.went_well(done):
            return False
        self._window.tell(say("status.exported", name=path.name), state="good")
        return True

    def _drawn(self, size: tuple[int, int]) -> np.ndarray:
        """(H, W, 3) uint8, the first row on top: what is seen, in so many pixels."""
        window = self._window
        window.stage.set_size(size)
        try:
            fine = size[0] * size[1] <= _FINE_PIXELS
            return np.array(window.stage.picture(fine=fine)[::-1, :, :3])
        finally:
            window.stage.set_size(window.canvas.pixel_size)
            window.stage.touch()

    def turntable(self) -> None:
        """Ask where and how, and save a film of the object turning."""
        kept = self._window.settings.exports
        path = self.ask_target(say("action.turntable"), _FILMS, str(kept.get("film_format", "")))
        if path is None:
            return
        dialog = FilmDialog(self._window, kept_film(kept), self._window.canvas.pixel_size)
        if dialog.exec():
            now = {**kept, "film": dialog.chosen(), "film_format": path.suffix.lower()}
            self._window.keep(exports=now)
            self.turntable_to(path, dialog.film())

    def turntable_to(self, path: Path, film: Film | None = None) -> bool:
        """Write a film of the object turning once; say whether that went well."""
        try:
            done = write_turntable(self._window, path, film or Film())
        except Paint3DError as error:
            QtWidgets.QMessageBox.warning(self._window, "paint3d", say_error(error))
            return False
        if not self.went_well(done):
            return False
        self._window.tell(say("status.exported", name=path.name), state="good")
        return True
