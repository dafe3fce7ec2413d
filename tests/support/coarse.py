"""Surfaces of few vertices, for tests that ask whether something runs and not how it looks."""

from __future__ import annotations

import pytest

from tests.support.examples import ALL

__all__ = ["coarse"]

_SPACING_MM = 1.2


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make surfaces ready with vertices this far apart at least; with --long as they are asked for."""
    from paint3d.surface.painted_surface import PaintedSurface

    if ALL:
        return
    begin = PaintedSurface.__init__

    def begin_coarsely(self, mesh, resolution=0.4, *others, **named) -> None:
        spacing = None if resolution is None else max(resolution, _SPACING_MM)
        begin(self, mesh, spacing, *others, **named)

    monkeypatch.setattr(PaintedSurface, "__init__", begin_coarsely)
