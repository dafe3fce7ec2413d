"""Less work for tests that ask whether something runs, and not how it looks or how fast it is."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.support.examples import ALL

__all__ = ["coarse", "few_pixels", "nothing_planned_ahead"]

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
