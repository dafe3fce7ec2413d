"""Pictures of what is on the screen, and films."""

from __future__ import annotations

import queue
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, wait
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from PIL import Image
from PySide6 import QtWidgets

from paint3d.app.model.input.navigation import orbit
from paint3d.app.model.score.playing import begun, play, score_of_strokes
from paint3d.app.model.score.stepping import in_pieces, pass_step, seconds_of
from paint3d.app.window.files.target_dialog import Targets
from paint3d.app.window.forms import FormDialog, SizeBoxes, stored_number
from paint3d.app.window.job import JobProgress
from paint3d.app.window.wording import say, say_error
from paint3d.app.window.workspace import Workspace
from paint3d.core.arrays import AnyArray
from paint3d.core.atomic import write_atomically
from paint3d.errors import ExportError, InputError, Message, Paint3DError
from paint3d.files.pictures import Filmed, write_growth
from paint3d.files.progress import part_of
from paint3d.recording.recording import HandTime
from paint3d.view.film import MOST_PIXELS, Growth, film_form, is_held_whole, write_film
from paint3d.view.shot import Shot

__all__ = [
    "FILMS",
    "PICTURES",
    "FilmDialog",
    "FilmOptions",
    "Pictures",
    "stored_film",
    "write_growth_film",
    "write_turntable",
]

# ---- The dialog ----------------------------------------------------------------------------------
# A film's length, size and pictures a second.


_LONGEST_S, _FASTEST = 60.0, 30.0
_LEAST_PICTURES = 2


class FilmOptions(NamedTuple):
    """Length, rate and size of a film.

    A GIF counts hundredths of a second, so that not every rate is met exactly.
    """

    seconds: float = 5.0
    rate: float = 15.0
    size: tuple[int, int] | None = None  # pixels; None: as on the screen

    @property
    def n_pictures(self) -> int:
        """Number of pictures."""
        return max(_LEAST_PICTURES, round(self.seconds * self.rate))

    @property
    def is_too_long(self) -> bool:
        """True if its pictures take more memory than is allowed."""
        width, height = self.size or (0, 0)
        return width * height * self.n_pictures > MOST_PIXELS


def stored_film(stored: Mapping[str, object]) -> FilmOptions:
    """Return the film that was chosen last."""
    own = stored.get("film")
    own = own if isinstance(own, Mapping) else {}
    seconds = min(max(stored_number(own, "seconds", 5.0), 0.5), _LONGEST_S)
    rate = min(max(stored_number(own, "rate", 15.0), 1.0), _FASTEST)
    width, height = (round(stored_number(own, name, 0.0)) for name in ("width", "height"))
    return FilmOptions(seconds, rate, (width, height) if width > 0 and height > 0 else None)


class FilmDialog(FormDialog):
    """Asks for a film's length, rate and size.

    Parameters
    ----------
    parent : QWidget
    stored : FilmOptions
        The film that was chosen last.
    screen : (int, int)
        Width and height of the picture on the screen, pixels.
    any_length : bool
        Whether it may be of any length, since its pictures are not held in memory.
    title : str, optional
        By default that of a turntable.
    """

    def __init__(
        self,
        parent: QtWidgets.QWidget,
        stored: FilmOptions,
        screen: tuple[int, int],
        any_length: bool = False,
        title: str = "",
    ) -> None:
        self._any_length = any_length
        super().__init__(parent, (title or say("Turntable…")).rstrip("…"))
        self.seconds = self.add_number(say("Length"), 0.5, _LONGEST_S, stored.seconds, "s", 1)
        self.rate = self.add_number(say("Pictures a second"), 1, _FASTEST, stored.rate)
        self.size_boxes = SizeBoxes(stored.size or screen, screen)
        self.form.addRow(say("Size in pixels"), self.size_boxes)
        self.message_label = QtWidgets.QLabel()
        self.message_label.setObjectName("faint")
        self.form.addRow("", self.message_label)
        self.finish(say("Save"))
        for box in (self.seconds, self.rate, self.size_boxes.width_box, self.size_boxes.height_box):
            box.valueChanged.connect(self._show_count)
        self._show_count()

    def _show_count(self, _: object = None) -> None:
        """Show the number of pictures, and whether they are too many."""
        film = self.film()
        too_long = film.is_too_long and not self._any_length
        n = film.n_pictures
        pictures = say("{n} picture", "{n} pictures", n=n)
        self.message_label.setText(
            say("{pictures}: too many of this size", pictures=pictures) if too_long else pictures
        )
        below = self.findChild(QtWidgets.QDialogButtonBox)
        assert below is not None, "it was finished"
        below.button(QtWidgets.QDialogButtonBox.StandardButton.Ok).setEnabled(not too_long)

    def film(self) -> FilmOptions:
        """Return the chosen film."""
        size = self.size_boxes.size_in_pixels()
        return FilmOptions(self.seconds.value(), self.rate.value(), size)

    def chosen(self) -> dict[str, object]:
        """Return the same, as JSON can hold it."""
        film = self.film()
        width, height = self.size_boxes.size_in_pixels()
        return {"seconds": film.seconds, "rate": film.rate, "width": width, "height": height}


# ---- A film of the object turning ----------------------------------------------------------------


_AHEAD = 3  # pictures that are drawn before they are written
_FILM_DRAWN = 0.9  # of the time, about, that drawing takes


def write_turntable(workspace: Workspace, path: Path, film: FilmOptions) -> Future[Any]:
    """Draw a film picture by picture, with a bar, and write it; nothing if it was stopped.

    Its space on the disk is reserved after two pictures: where there is not enough, no more are
    drawn.

    Raises
    ------
    ExportError
        If the suffix is that of no film, an .mp4 cannot be written here, or the pictures are too
        many for their size.
    """
    form = film_form(path)
    width, height = film.size or workspace.canvas.pixel_size
    film = film._replace(size=(width, height))
    if film.is_too_long and is_held_whole(form):
        raise ExportError(
            "{file}: {n_pictures} pictures of {width} x {height} pixels are too many; expected a "
            "shorter or smaller film",
            file=path,
            n_pictures=film.n_pictures,
            width=width,
            height=height,
        )
    camera, drawn = workspace.hand.open_camera, queue.Queue[Image.Image](_AHEAD)
    n, turn = film.n_pictures, 2.0 * workspace.canvas.height()
    parts = _parts(workspace, [-turn * k / n for k in range(n)])

    def draw() -> None:
        if not drawn.full() and (picture := next(parts, None)) is not None:
            drawn.put(picture)

    def work(progress: JobProgress) -> None:
        pictures = _drawn_pictures(drawn, n, progress)
        with write_atomically(path, progress) as part:
            write_film(part, pictures, n, form, film.rate)

    workspace.hold()
    workspace.stage.hide_brush()
    workspace.stage.set_size((width, height))
    try:
        return workspace.run(say("Drawing the film…"), work, draw)
    finally:
        workspace.stage.set_size(workspace.canvas.pixel_size)
        workspace.stage.set_camera(camera)
        workspace.go_on()


def _parts(workspace: Workspace, turns: Sequence[float]) -> Iterator[Image.Image | None]:
    """Draw a picture for each turn of the view (pixels that it is dragged by), part by part.

    Yields None between the parts of a picture, then the picture.
    """
    camera = workspace.hand.open_camera
    for turn in turns:
        workspace.stage.set_camera(orbit(camera, turn, 0.0, workspace.canvas.height()))
        for fraction, pixels in workspace.stage.picture_by_parts():
            done = fraction >= 1.0
            yield Image.fromarray(np.array(pixels[::-1, :, :3])) if done else None


def _drawn_pictures(
    drawn: queue.Queue[Image.Image], n: int, progress: JobProgress
) -> Iterator[Image.Image]:
    """Yield pictures as they are drawn."""
    for k in range(n):
        progress(_FILM_DRAWN * k / n)
        while True:
            progress.check()
            try:
                picture = drawn.get(timeout=_LOOK_S)
                break
            except queue.Empty:
                continue
        yield picture
    progress(_FILM_DRAWN)


# ---- A film of the painting growing --------------------------------------------------------------
# The painting is painted again beside the window, from its score.


_HOLD_S = 1.0  # that the finished painting is shown
_PAINTED = 0.3  # of the time, about, that painting takes


def write_growth_film(workspace: Workspace, path: Path, film: FilmOptions) -> Future[Any]:
    """Write a film of all that happened, in the studio's light; nothing if it was stopped.

    Raises
    ------
    ExportError
        If the suffix is that of no film, an .mp4 cannot be written here, or the pictures are too
        many for their size.
    InputError
        If nothing has been painted.
    """
    film_form(path)
    with workspace.paint_thread.paused() as document:
        assert document is not None, "it was waited for"
        score, mesh = document.score, document.surface.source
        original = document.surface.original
        if score is None and document.strokes:
            score = score_of_strokes(document.strokes, document.surface)
    if score is None or not score.n_samples:
        raise InputError(
            "{file}: nothing has been painted yet; expected a stroke to film",
            file=path,
        )
    known = in_pieces(score)
    size = film.size or workspace.canvas.pixel_size
    shot, hold = Shot(size=size), min(_HOLD_S, 0.3 * film.seconds)
    filmed = Filmed(film.rate, 0.0, hold)
    filmed.check(path, shot, round((film.seconds - hold) * film.rate) + 2)
    step_s = max(seconds_of(score), 1e-3) / ((film.seconds - hold) * film.rate)

    def work(progress: JobProgress) -> None:
        painting = begun(known, mesh, painted_on=None if original is None else original.mesh)
        clock, message = HandTime(), part_of(progress, 0.0, _PAINTED)
        with Growth(painting.surface, step_s) as growth:
            for step in play(painting, known):
                pass_step(clock, step)
                growth.at(clock.seconds)
                message(step.fraction)
            if painting.in_stroke:
                painting.end_stroke()
            growth.end(clock.seconds)
            write_growth(growth, path, shot, filmed, part_of(progress, _PAINTED, 1.0))

    return workspace.run(say("Drawing the film…"), work)


# ---- Pictures, and the commands ------------------------------------------------------------------


# Kinds of files by their suffix, as the dialog names them:
PICTURES = {".png": Message("Picture, PNG"), ".jpg": Message("Picture, JPEG")}
FILMS = {".webp": Message("Film, WebP"), ".gif": Message("Film, GIF"), ".mp4": Message("Film, MP4")}
_FORMATS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG"}
_FINE_PIXELS = 4_500_000  # more are drawn without being smoothed, which needs four times as many
_QUALITY = 92
_DRAWN = 0.7  # of the time that a large picture takes, about
_LOOK_S = 0.05


class _Drawing:
    """The view, drawn in so many pixels: at once in the screen's size.

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
        self._fraction = 0.0
        self._pixels: Future[AnyArray] = Future()

    def __enter__(self) -> Callable[[], None] | None:
        """Return a function to call repeatedly, in the window's thread, until all is drawn."""
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
        self._fraction, pixels = next(self._parts)
        if self._fraction >= 1.0:
            self._take(pixels)

    def _take(self, pixels: AnyArray) -> None:
        self._pixels.set_result(np.array(pixels[::-1, :, :3]))

    def wait(self, progress: JobProgress) -> AnyArray:
        """Return (H, W, 3) uint8, the first row on top; called beside the window's thread."""
        while not wait([self._pixels], timeout=_LOOK_S).done:
            progress(_DRAWN * self._fraction)
        return self._pixels.result()


class Pictures:
    """Commands that save pictures and films of the painting; ``do_<action>`` for each."""

    def __init__(self, workspace: Workspace, targets: Targets) -> None:
        self._workspace, self._targets = workspace, targets

    def do_screenshot(self) -> None:
        """Ask where, and save the picture as it is seen."""
        path = self._targets.ask(say("Screenshot"), PICTURES)
        if path is not None:
            self.screenshot_to(path)

    def screenshot_to(self, path: Path) -> bool:
        """Write the picture as it is seen, without what lies over it."""
        return self.picture_to(path, self._workspace.canvas.pixel_size)

    def picture_to(self, path: Path, size: tuple[int, int], quality: int = _QUALITY) -> bool:
        """Write what is on the screen, without what lies over it; return whether that succeeded.

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

        def work(progress: JobProgress) -> None:
            if form is None:
                raise ExportError("{file}: a picture is written as .png or .jpg", file=path)
            pixels = drawing.wait(progress)
            progress(_DRAWN)
            with write_atomically(path, progress) as part:
                Image.fromarray(pixels).save(part, format=form, quality=quality)

        with drawing as draw:
            title = say("Writing {name}…", name=path.name)
            done = self._workspace.run(title, work, draw)
        if not self._workspace.went_well(done):
            return False
        self._workspace.tell(say("Exported {name}", name=path.name), state="good")
        return True

    def do_turntable(self) -> None:
        """Ask where and how, and save a film of the object turning."""
        self._ask_for_film(say("Turntable…"), self.turntable_to)

    def do_growth(self) -> None:
        """Ask where and how, and save a film of the painting as it grew."""
        self._ask_for_film(say("Film of the painting growing…"), self.growth_to)

    def _ask_for_film(self, title: str, write: Callable[[Path, FilmOptions], bool]) -> None:
        stored = self._workspace.settings.exports
        path = self._targets.ask(title, FILMS, str(stored.get("film_format", "")))
        if path is None:
            return
        dialog = FilmDialog(
            self._workspace.window, stored_film(stored), self._workspace.canvas.pixel_size,
            any_length=path.suffix.lower() == ".mp4", title=title,
        )  # fmt: skip
        if dialog.exec():
            now = {**stored, "film": dialog.chosen(), "film_format": path.suffix.lower()}
            self._workspace.update_settings(exports=now)
            write(path, dialog.film())

    def turntable_to(self, path: Path, film: FilmOptions | None = None) -> bool:
        """Write a film of the object turning once; return whether that succeeded."""
        return self._film_to(path, write_turntable, film or FilmOptions())

    def growth_to(self, path: Path, film: FilmOptions | None = None) -> bool:
        """Write a film of the painting as it grew; return whether that succeeded."""
        return self._film_to(path, write_growth_film, film or FilmOptions())

    def _film_to(
        self,
        path: Path,
        write: Callable[[Workspace, Path, FilmOptions], Future[Any]],
        film: FilmOptions,
    ) -> bool:
        try:
            done = write(self._workspace, path, film)
        except Paint3DError as error:
            QtWidgets.QMessageBox.warning(self._workspace.window, "paint3d", say_error(error))
            return False
        if not self._workspace.went_well(done):
            return False
        self._workspace.tell(say("Exported {name}", name=path.name), state="good")
        return True
