"""A film of the painting as it grew, painted again beside the window from its score."""

from __future__ import annotations

from concurrent.futures import Future
from pathlib import Path
from typing import Any

from paint3d.app.model.score.of_strokes import score_of_strokes
from paint3d.app.model.score.playback import in_pieces, pass_step, seconds_of
from paint3d.app.model.score.playing import begun, play
from paint3d.app.window.dialogs.film_dialog import Film
from paint3d.app.window.jobs.job import Progress
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.errors import InputError
from paint3d.files.pictures import Filmed, write_growth
from paint3d.files.progress import part_of
from paint3d.recording.recording import HandTime
from paint3d.view.film import Growth, film_form
from paint3d.view.shot import Shot

__all__ = ["write_growth_film"]

_HOLD_S = 1.0  # that the finished painting is shown
_PAINTED = 0.3  # of the time, about, that painting takes


def write_growth_film(workspace: Workspace, path: Path, film: Film) -> Future[Any]:
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
    with workspace.easel.paused() as document:
        assert document is not None, "it was waited for"
        score, mesh = document.score, document.surface.source
        original = document.surface.original
        if score is None and document.strokes:
            score = score_of_strokes(document.strokes, document.surface)
    if score is None or not score.n_samples:
        raise InputError(f"{path}: nothing has been painted yet; expected a stroke to film")
    known = in_pieces(score)
    size = film.size or workspace.canvas.pixel_size
    shot, hold = Shot(size=size), min(_HOLD_S, 0.3 * film.seconds)
    filmed = Filmed(film.rate, 0.0, hold)
    filmed.check(path, shot, round((film.seconds - hold) * film.rate) + 2)
    step_s = max(seconds_of(score), 1e-3) / ((film.seconds - hold) * film.rate)

    def work(progress: Progress) -> None:
        painting = begun(known, mesh, painted_on=None if original is None else original.mesh)
        clock, told = HandTime(), part_of(progress, 0.0, _PAINTED)
        with Growth(painting.surface, step_s) as growth:
            for step in play(painting, known):
                pass_step(clock, step)
                growth.at(clock.seconds)
                told(step.share)
            if painting.in_stroke:
                painting.end_stroke()
            growth.end(clock.seconds)
            write_growth(growth, path, shot, filmed, part_of(progress, _PAINTED, 1.0))

    return workspace.run(say("Drawing the film…"), work)
