"""Fixtures that save work in tests which do not look at what is saved."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import fields, is_dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.support.examples import ALL

__all__ = [
    "by_few_lights",
    "coarse",
    "few_lights",
    "few_pixels",
    "nothing_planned_ahead",
    "sheets_found_once",
    "small_pictures",
]

_SPACING_MM = 1.2


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make surfaces ready with vertices this far apart at least; with --long as was asked for."""
    from paint3d.surface.painted_surface import PaintedSurface

    if ALL:
        return
    begin = PaintedSurface.__init__

    def begin_coarsely(self, mesh, resolution=0.4, *others, **named) -> None:
        spacing = None if resolution is None else max(resolution, _SPACING_MM)
        begin(self, mesh, spacing, *others, **named)

    monkeypatch.setattr(PaintedSurface, "__init__", begin_coarsely)


@pytest.fixture
def few_pixels(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take pictures of which no size is asked with a sixteenth of the usual pixels."""
    from paint3d.view import shot

    width, height = shot.SIZE
    monkeypatch.setattr(shot, "SIZE", (width // 4, height // 4))


@pytest.fixture(scope="module")
def nothing_planned_ahead() -> Iterator[None]:
    """Plan texts only when they are to be written: a process is started for each that is laid."""
    from paint3d.app.window.copybook import text_writing

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(text_writing, "plan_ahead", lambda *_: iter(()))
        yield


# ---- Light ---------------------------------------------------------------------------------------

_SMALL = (160, 120)


@contextmanager
def by_few_lights() -> Iterator[None]:
    """Light objects by every eighth of a studio's lights: all of them take seconds."""
    from paint3d.view import live_light, picture  # nobody else waits for them
    from paint3d.view.studio import light_samples

    with pytest.MonkeyPatch.context() as patch:
        for room in (live_light, picture):
            patch.setattr(room, "light_samples", lambda *a, **b: light_samples(*a, **b)[::8])
        yield


@pytest.fixture(scope="module")
def few_lights() -> Iterator[None]:
    """Light by few lights, for a file of tests; light itself is tested in tests/view."""
    with by_few_lights():
        yield


@pytest.fixture
def small_pictures(few_lights: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw what is exported as a picture small, and by few lights."""
    from paint3d.view import shot

    draw = shot.draw_picture
    monkeypatch.setattr(shot, "draw_picture", lambda *a, **b: draw(*a, **{**b, "size": _SMALL}))


# ---- Sheets of photographs -----------------------------------------------------------------------


@pytest.fixture(scope="module")
def sheets_found_once() -> Iterator[None]:
    """Look for the strokes of one photograph once for each thing that is asked of it.

    Looking takes a second. Nobody can change what was found: it is handed on to who asks next.
    """
    from paint3d.calligraphy.photo import copying

    found: dict[bytes, copying.CopiedSheet] = {}
    look = copying.copy_sheet

    def known(
        pixels: NDArray[np.uint8],
        name: str,
        asked: copying.Asked | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> copying.CopiedSheet:
        key = pickle.dumps((pixels, name, asked))
        if key not in found:
            found[key] = look(pixels, name, asked, progress)
            _hold(found[key])
        return found[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(copying, "copy_sheet", known)
        yield


def _hold(thing: object) -> None:
    """Make every array of a record read-only, however deep it lies."""
    if isinstance(thing, np.ndarray):
        thing.setflags(write=False)
    elif isinstance(thing, tuple | list):
        for one in thing:
            _hold(one)
    elif is_dataclass(thing):
        for one in fields(thing):
            _hold(getattr(thing, one.name))
