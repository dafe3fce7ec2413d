"""Pictures of what is on the screen, and films."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, wait
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from PySide6 import QtWidgets

from paint3d.app.window.dialogs.film_dialog import Film, FilmDialog, kept_film
from paint3d.app.window.jobs.growth_film import write_growth_film
from paint3d.app.window.jobs.job import Progress
from paint3d.app.window.jobs.targets import Targets
from paint3d.app.window.jobs.turntable import write_turntable
from paint3d.app.window.wording import say, say_error
from paint3d.app.window.workspace import Workspace
from paint3d.core.arrays import AnyArray
from paint3d.core.atomic import write_atomically
from paint3d.errors import ExportError, Paint3DError

__all__ = ["FILMS", "PICTURES", "Pictures"]

# What a file may be, by its ending, and how the dialog says it:
PICTURES = {".png": "Picture, PNG", ".jpg": "Picture, JPEG"}
FILMS = {".webp": "Film, WebP", ".gif": "Film, GIF", ".mp4": "Film, MP4"}
_FORMATS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG"}
_FINE_PIXELS = 4_500_000  # more are drawn without being smoothed, which needs four times as many
_QUALITY = 92
_DRAWN = 0.7  # of the time that a large picture takes, about
_LOOK_S = 0.05


class _Drawing:
    """What is seen, drawn in so many pixels: at once where that is the screen's size.

    A larger picture is drawn part by part while the window waits with a bar.

    Parameters
    ----------
    workspace : Workspace
    size : (int, int)
        Pixels.
    """

    def __init__(self, workspace: Workspace, size: tuple[int, int]) -> None:
        self._workspace, self._size = workspace, size
        self._fine = size[0] * size[1] <= _FINE_PIXELS
        self._share = 0.0
        self._pixels: Future[AnyArray] = Future()

    def __enter__(self) -> Callable[[], None] | None:
        """What is to be called again and again, in the window's thread, until all is drawn."""
        if self._size == self._workspace.canvas.pixel_size:
            self._take(self._workspace.stage.picture(fine=self._fine))
            return None
        self._workspace.hold()
        self._workspace.stage.set_size(self._size)
        self._parts = self._workspace.stage.picture_by_parts(fine=self._fine)
        return self._draw_part

    def __exit__(self, *_: object) -> None:
        self._workspace.stage.set_size(self._workspace.canvas.pixel_size)
        self._workspace.go_on()

    def _draw_part(self) -> None:
        if self._pixels.done():
            return
        self._share, pixels = next(self._parts)
        if self._share >= 1.0:
            self._take(pixels)

    def _take(self, pixels: AnyArray) -> None:
        self._pixels.set_result(np.array(pixels[::-1, :, :3]))

    def wait(self, progress: Progress) -> AnyArray:
        """(H, W, 3) uint8, the first row on top; called beside the window's thread."""
        while not wait([self._pixels], timeout=_LOOK_S).done:
            progress(_DRAWN * self._share)
        return self._pixels.result()


class Pictures:
    """For one window."""

    def __init__(self, workspace: Workspace, targets: Targets) -> None:
        self._workspace, self._targets = workspace, targets

    def do_screenshot(self) -> None:
        """Ask where, and save the picture as it is seen."""
        path = self._targets.ask(say("action.screenshot"), PICTURES)
        if path is not None:
            self.screenshot_to(path)

    def screenshot_to(self, path: Path) -> bool:
        """Write the picture as it is seen, without what lies over it."""
        return self.picture_to(path, self._workspace.canvas.pixel_size)

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
        drawing = _Drawing(self._workspace, size)

        def work(progress: Progress) -> None:
            if form is None:
                raise ExportError(f"{path}: a picture is written as .png or .jpg")
            pixels = drawing.wait(progress)
            progress(_DRAWN)
            with write_atomically(path, progress) as part:
                Image.fromarray(pixels).save(part, format=form, quality=quality)

        with drawing as draw:
            title = say("Writing {name}…", name=path.name)
            done = self._workspace.run(title, work, draw)
        if not self._workspace.went_well(done):
            return False
        self._workspace.tell(say("status.exported", name=path.name), state="good")
        return True

    def do_turntable(self) -> None:
        """Ask where and how, and save a film of the object turning."""
        self._ask_for_film(say("action.turntable"), self.turntable_to)

    def do_growth(self) -> None:
        """Ask where and how, and save a film of the painting as it grew."""
        self._ask_for_film(say("Film of the painting growing…"), self.growth_to)

    def _ask_for_film(self, title: str, write: Callable[[Path, Film], bool]) -> None:
        kept = self._workspace.settings.exports
        path = self._targets.ask(title, FILMS, str(kept.get("film_format", "")))
        if path is None:
            return
        dialog = FilmDialog(
            self._workspace.window, kept_film(kept), self._workspace.canvas.pixel_size,
            any_length=path.suffix.lower() == ".mp4", title=title,
        )  # fmt: skip
        if dialog.exec():
            now = {**kept, "film": dialog.chosen(), "film_format": path.suffix.lower()}
            self._workspace.keep(exports=now)
            write(path, dialog.film())

    def turntable_to(self, path: Path, film: Film | None = None) -> bool:
        """Write a film of the object turning once; say whether that went well."""
        return self._film_to(path, write_turntable, film or Film())

    def growth_to(self, path: Path, film: Film | None = None) -> bool:
        """Write a film of the painting as it grew; say whether that went well."""
        return self._film_to(path, write_growth_film, film or Film())

    def _film_to(
        self, path: Path, write: Callable[[Workspace, Path, Film], Future[Any]], film: Film
    ) -> bool:
        try:
            done = write(self._workspace, path, film)
        except Paint3DError as error:
            QtWidgets.QMessageBox.warning(self._workspace.window, "paint3d", say_error(error))
            return False
        if not self._workspace.went_well(done):
            return False
        self._workspace.tell(say("status.exported", name=path.name), state="good")
        return True
