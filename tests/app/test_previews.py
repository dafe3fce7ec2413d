"""The brushes' previews: in whatever ink is in use, and never a flood of faults."""

from __future__ import annotations

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from paint3d.app.window.brush import brush_panel
from paint3d.app.window.previews import sorted_parts, stroke_preview
from paint3d.app.window.studio import StudioWindow
from paint3d.brush.presets import brush_names, load_brush
from paint3d.colour.pigments import load_pigment
from tests.support.app.gestures import KIND, drag, live, mouse, wait_for
from tests.support.app.windows import close_unasked, faults, opened, settled


@pytest.fixture(scope="module")
def window(program):
    with opened(program) as window:
        yield window


@pytest.mark.long
def test_a_mixture_that_was_picked_up_is_shown_in_the_previews(window) -> None:
    window.panels.inks.dipped.emit({"indigo": 0.8, "water": 0.2}, None)
    drag(window.canvas, (0.45, 0.5), (0.55, 0.5))
    settled(window)
    mouse(window.canvas, KIND.MouseMove, 0.5 * window.canvas.width(), 0.5 * window.canvas.height())
    with faults() as found:
        window.workspace.actions["pick_colour"].trigger()
        settled(window)
        picked = window.document.inks[0]
        assert {pigment.name for pigment in picked} == {"indigo", "water"}
        wait_for(lambda: not window.panels.brushes.is_busy)
        live(0.3)
    assert found == []
    assert window.panels.ink_name() in ("indigo + water", "water + indigo")


def test_previews_are_painted_when_the_window_waits_for_nothing(program, monkeypatch) -> None:
    """An object is opened sooner, and no ink is shown that is not the one in use."""
    inks: list[object] = []
    paint = brush_panel.stroke_preview
    monkeypatch.setattr(
        brush_panel, "stroke_preview", lambda brush, ink: inks.append(ink) or paint(brush, ink)
    )
    window = StudioWindow(program)
    try:
        window.show()
        window.workspace.quiet = True
        assert window.opening.open_path("plane", 3.0, "xuan", asked=True)
        assert inks == []
        wait_for(lambda: not window.panels.brushes.is_busy)
        assert inks == [window.document.inks[0]] * len(brush_names())
    finally:
        close_unasked(window)


def test_a_preview_is_the_same_by_name_and_by_ink() -> None:
    brush = load_brush("xiaokai")
    names = {"indigo": 0.7, "water": 0.3}
    inks = {load_pigment(name): part for name, part in reversed(names.items())}
    assert [part for _, part in sorted_parts(names)] == [part for _, part in sorted_parts(inks)]
    assert (stroke_preview(brush, names) == stroke_preview(brush, inks)).all()


def test_previews_that_fail_are_told_once_and_the_timer_rests(window, monkeypatch) -> None:
    def fail(brush, ink):
        raise ValueError("no preview today")

    monkeypatch.setattr(brush_panel, "stroke_preview", fail)
    told: list[str] = []
    window.panels.brushes.failed.connect(told.append)
    with faults() as found:
        for ink in ("azurite", "cinnabar"):
            window.panels.brushes.set_ink(ink)
            wait_for(lambda: not window.panels.brushes.is_busy)
            live(0.4)
    assert found == []
    assert told == ["ValueError: no preview today"]
    assert "no preview today" in window.status.told.text()
    monkeypatch.undo()
    window.panels.brushes.set_ink("pine soot")
    wait_for(lambda: not window.panels.brushes.is_busy)


def test_a_fault_in_every_tick_is_told_once_and_the_window_lives(window, monkeypatch) -> None:
    ticks: list[int] = []

    def fail() -> None:
        ticks.append(1)
        raise ValueError("nothing goes")

    before = window.tick
    monkeypatch.setattr(window, "tick", fail)
    with faults() as found:
        wait_for(lambda: len(ticks) > 5)
        assert found == ["ValueError: nothing goes"]
        assert "nothing goes" in window.status.told.text()
        monkeypatch.setattr(window, "tick", before)
        drag(window.canvas, (0.45, 0.4), (0.55, 0.4))
        settled(window)
        assert len(found) == 1
