"""A film of the object turning once on its foot."""

from __future__ import annotations

import queue
from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from paint3d.app.model.input.navigation import orbit
from paint3d.app.window.dialogs.film_dialog import Film
from paint3d.app.window.jobs.job import Progress
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.core.atomic import write_atomically
from paint3d.errors import ExportError
from paint3d.view.film import film_form, is_held_whole, write_film

__all__ = ["write_turntable"]

_AHEAD = 3  # pictures that are drawn before they are written
_DRAWN = 0.9  # of the time, about, that drawing takes
_LOOK_S = 0.05


def write_turntable(workspace: Workspace, path: Path, film: Film) -> Future[Any]:
    """Draw a film picture by picture, with a bar, and write it; nothing if it was stopped.

    What it will take of the disk is kept free for it when two pictures are there: where there is no
    room for it, no more are drawn.

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
            f"{path}: {film.n_pictures} pictures of {width} x {height} pixels are too many; "
            "expected a shorter or smaller film"
        )
    camera, drawn = workspace.hand.open_camera, queue.Queue[Image.Image](_AHEAD)
    n, turn = film.n_pictures, 2.0 * workspace.canvas.height()
    parts = _parts(workspace, [-turn * k / n for k in range(n)])

    def draw() -> None:
        if not drawn.full() and (picture := next(parts, None)) is not None:
            drawn.put(picture)

    def work(progress: Progress) -> None:
        pictures = _taken(drawn, n, progress)
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
        for share, pixels in workspace.stage.picture_by_parts():
            done = share >= 1.0
            yield Image.fromarray(np.array(pixels[::-1, :, :3])) if done else None


def _taken(drawn: queue.Queue[Image.Image], n: int, progress: Progress) -> Iterator[Image.Image]:
    """Pictures as they are drawn."""
    for k in range(n):
        progress(_DRAWN * k / n)
        while True:
            progress.check()
            try:
                picture = drawn.get(timeout=_LOOK_S)
                break
            except queue.Empty:
                continue
        yield picture
    progress(_DRAWN)
