"""Windows for tests: opened on an object, settled, let go of; and what went wrong meanwhile."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext

import numpy as np
from PySide6 import QtCore, QtTest

from paint3d.app.model.document import Document
from paint3d.app.model.paint_thread import PaintThread
from paint3d.app.window import studio
from paint3d.app.window.brush import brush_panel
from paint3d.app.window.studio import StudioWindow
from paint3d.brush.spec import BrushSpec
from paint3d.core.arrays import AnyArray
from paint3d.view import live_light, live_picture, live_scene
from paint3d.view.studio import light_samples
from tests.support.app.gestures import live, type_key, wait_for

SMALL = (900, 640)
"""Of a window whose canvas has half of the pixels that it has at first."""
_FOLLOWED_S = 0.1  # so often a window that draws no pictures looks what has been painted


def draw_little() -> None:
    """Draw in this process as in the tests': by few lights, edges as they are, seldom."""
    brush_panel.stroke_preview = plain_preview
    live_light.light_samples = lambda n: light_samples(n)[::8]
    live_scene._JITTER, live_picture._BEST, studio._REST = ((0.0, 0.0),), 1, 4.0


def plain_preview(brush: BrushSpec, ink: object) -> AnyArray:
    """A patch in place of the stroke of a brush."""
    return np.full((84, 264, 3), 200, np.uint8)


@contextmanager
def opened(
    program, mesh="plane", resolution=1.5, material="xuan", settings=None, size=SMALL, drawn=True
):
    """A window with something to paint on; nothing of it is asked for when it closes.

    Most of a window's time is that of its pixels: it is a small one, and where nobody looks at
    pictures they need not be `drawn`. A `size` of None makes it as large as it is at first.
    """
    window = StudioWindow(program, settings)
    if size is not None:
        window.resize(*size)
    window.show()
    window.workspace.quiet = True
    assert window.opening.open_path(mesh, resolution, material, asked=True)
    wait_for(lambda: window.stage.is_lit)
    window.activateWindow()
    window.canvas.setFocus()
    live(0.1)
    with nullcontext() if drawn else blind(window):
        try:
            yield window
        finally:
            close_unasked(window)


@contextmanager
def blind(window: StudioWindow) -> Iterator[None]:
    """Draw no pictures meanwhile, and take what is painted for none: all else is hardly a third."""

    def draw() -> None:
        window._next_draw = time.perf_counter() + _FOLLOWED_S

    window.stage.draw, window.stage._take = draw, lambda: None
    window.setUpdatesEnabled(False)
    try:
        yield
    finally:
        del window.stage.draw, window.stage._take
        window.setUpdatesEnabled(True)


@contextmanager
def seen(window: StudioWindow) -> Iterator[None]:
    """Draw meanwhile in a window that draws no pictures, for a test that looks at some."""
    stage = vars(window.stage)
    undrawn = {name: stage.pop(name) for name in ("draw", "_take")}
    window.setUpdatesEnabled(True)
    try:
        yield
    finally:
        stage.update(undrawn)
        window.setUpdatesEnabled(False)


def close_unasked(window) -> None:
    """Close a window whatever is unsaved or still to be painted, as after a test that failed."""
    window.saving.may_leave = lambda: True
    window.close()


def settled(window) -> None:
    """Wait until everything asked for is painted and shown."""
    paint_thread = window.stage.paint_thread
    paint_thread.post(lambda document: None).result(300)
    wait_for(lambda: paint_thread.is_still or paint_thread.wet)
    live(0.1)


def press(window, *keys) -> None:
    """Press a key, with those that are held, over the picture, and wait for what it does."""
    window.canvas.setFocus()
    type_key(window.canvas, *keys)
    settled(window)


def row_place(window, row: int) -> QtCore.QPoint:
    """The middle of a row of the history, which is put on top."""
    window.panels.docks["history"].raise_()
    live(0.05)
    rows = window.panels.history.list
    return rows.visualItemRect(rows.item(row)).center()


def click_row(window, row: int) -> None:
    """Click a row of the history, and wait for what it does."""
    rows = window.panels.history.list.viewport()
    QtTest.QTest.mouseClick(rows, QtCore.Qt.MouseButton.LeftButton, pos=row_place(window, row))
    settled(window)


@contextmanager
def faults() -> Iterator[list[str]]:
    """Exceptions that nobody caught meanwhile, as in a slot or an event handler."""
    found: list[str] = []
    before = sys.excepthook
    sys.excepthook = lambda kind, error, trace: found.append(f"{kind.__name__}: {error}")
    try:
        yield found
    finally:
        sys.excepthook = before


def pretend_saved(paint_thread: PaintThread) -> None:
    """Mark everything as saved, or closing would ask."""
    paint_thread.post(_forget_changes).result(300)


def _forget_changes(document: Document) -> None:
    document.modified = False
