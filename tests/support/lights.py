"""Light for tests that do not look at light: it is found for hundreds of objects."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

__all__ = ["by_few_lights", "few_lights", "small_pictures"]

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
