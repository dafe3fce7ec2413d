"""Bars of long work: they show what is done, and never much more."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtWidgets

from paint3d.app.model.persistence.recovery_folder import RecoveryFolder, recoverable
from paint3d.app.window import job as jobs
from paint3d.app.window.files import opening
from paint3d.app.window.job import run_beside
from paint3d.app.window.playing.pictures import FilmOptions
from tests.support.app.gestures import answer_bar, drag, wait_for
from tests.support.app.windows import faults, opened, settled

AHEAD = 0.05


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "plane", 2.0, "xuan") as window, faults() as found:
        for y in np.linspace(0.35, 0.65, 4):
            drag(window.canvas, (0.42, y), (0.58, y), n=12)
        settled(window)
        yield window
        assert not found


def test_a_bar_stays_by_what_is_told_however_often_that_is(window) -> None:
    """The share shown was the floor of the next one: 3000 reports of a third showed all done."""
    done, seen = [0.0], []

    def work(progress: jobs.JobProgress) -> None:
        wait_for_bar = time.monotonic() + 60.0
        while not seen and time.monotonic() < wait_for_bar:
            time.sleep(0.005)
        for k in range(3000):
            done[0] = k / 9000
            progress(done[0])
            time.sleep(2e-4)

    def watch(bar: QtWidgets.QProgressDialog) -> None:
        bar.findChild(QtWidgets.QProgressBar).valueChanged.connect(
            lambda value: seen.append((done[0], value / bar.maximum()))
        )

    answer_bar(watch)
    run_beside(window, "work", work).result()
    assert max(at for at, _ in seen[:-1]) > 0.2
    for at, shown in seen[:-1]:  # the last is that of work that is done
        assert shown <= at + AHEAD + 0.001  # the bar counts in thousandths


def test_a_bar_says_how_long_it_still_takes_once_that_is_known(
    window, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(jobs, "_KNOWN_S", 0.2)
    said: list[str] = []

    def work(progress: jobs.JobProgress) -> None:
        until = time.monotonic() + 60.0
        for done in (0.05, 0.5):
            progress(done)
            time.sleep(0.3)
        while not any("left" in text for text in said) and time.monotonic() < until:
            time.sleep(0.005)

    def watch(bar: QtWidgets.QProgressDialog) -> None:
        timer = QtCore.QTimer(bar, interval=10)
        timer.timeout.connect(lambda: said.append(bar.labelText()))
        timer.start()

    answer_bar(watch)
    run_beside(window, "work", work).result()
    assert said[0].splitlines()[0] == "work"  # a late first look may be at the time, too
    assert re.fullmatch(r"work\nabout \d+ s left", said[-1])


class _Watched(jobs.JobProgress):
    """Remembers what was said and what was shown."""

    def __init__(self) -> None:
        super().__init__()
        self.said: list[float] = [0.0]
        self.seen: list[tuple[float, float, float]] = []

    def __call__(self, share: float) -> None:
        super().__call__(share)
        self.said.append(share)
        self.look()

    def look(self) -> float:
        before = self.said[-1]
        shown = super().fraction
        self.seen.append((before, shown, self.said[-1]))
        return shown

    @property
    def fraction(self) -> float:
        return self.look()


def _recover(window, folder: Path) -> bool:
    with window.stage.paint_thread.paused() as document:
        sitting = RecoveryFolder(document)
    sitting.note({"do": "add_layer"})
    sitting.note({"do": "remove_layer", "with": [1]})
    sitting.close(keep=True)
    one = next(one for one in recoverable() if one.folder == sitting.folder)
    return window.recovery.recover(one)


def _save_and_open(window, folder: Path) -> bool:
    path = folder / "a.p3d"
    return window.saving.save_to(path) and window.opening.open_path(str(path), asked=True)


def _warm(window, folder: Path) -> bool:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(opening, "_warm", [])
        patch.setattr(opening, "is_warm", lambda: False)
        return window.opening.open_path("plane", 4.0, "xuan", asked=True)


def _refine(window, folder: Path) -> bool:
    window.painting.do_refine()
    return True


JOBS: dict[str, Callable[..., bool]] = {
    "growth": lambda w, at: w.pictures.growth_to(at / "a.gif", FilmOptions(0.5, 10.0, (160, 120))),
    "turntable": lambda w, at: w.pictures.turntable_to(
        at / "a.gif", FilmOptions(0.5, 8.0, (160, 120))
    ),
    "picture": lambda w, at: w.pictures.picture_to(at / "a.png", (900, 700)),
    "export": lambda w, at: w.exporting.export_to(at / "a.glb"),
    "text": lambda w, at: w.copying.layout_text("永和", 20.0, True),
    "edit": lambda w, at: w.editing.run_edit([1], {"do": "delete"}),
    "refine": _refine,
    "warm": _warm,
    "save": _save_and_open,
    "recover": _recover,
    "new": lambda w, at: w.opening.open_path("bowl", 2.0, "porcelain", asked=True),
}


@pytest.mark.parametrize("name", JOBS)
def test_the_bar_of_each_job_is_never_far_from_what_is_done(
    window, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    made: list[_Watched] = []

    def make() -> _Watched:
        made.append(_Watched())
        return made[-1]

    monkeypatch.setattr(jobs, "JobProgress", make)
    assert JOBS[name](window, tmp_path)
    assert made
    for progress in made:
        assert progress.said == sorted(progress.said)
        assert progress.said[-1] == 1.0
        for before, shown, after in progress.seen:
            assert before - 1e-9 <= shown <= after + AHEAD + 1e-9
    wait_for(lambda: not window.workspace.is_waiting)
