"""Garbage is collected in the window's thread alone.

Python looks for cycles of objects that nobody holds in whatever thread happens to make the next
object. A window that was closed is such a cycle, and Qt's objects must not die in another thread
than their own: while the window's thread hands them an event, the program ends there and then.
"""

from __future__ import annotations

import gc
import time

from PySide6 import QtCore

from paint3d.core.machine import give_back_memory

__all__ = ["collect_all", "collect_garbage", "collect_here", "collect_soon"]

_LOOK_MS = 250
_SOON_MS = 2000  # when what was opened instead has been drawn
_YOUNG = 700  # objects, Python's own thresholds
_ROUNDS = 10
_REST_S = 60.0  # between searches among all objects, some .05 s each


class _Search:
    """When all objects were last searched."""

    at_s = 0.0


def collect_garbage() -> None:
    """Collect what is due, as Python itself would, in the thread that calls."""
    young, middle, old = gc.get_count()
    now = time.monotonic()
    if old > _ROUNDS and now - _Search.at_s > _REST_S:
        _Search.at_s = now
        gc.collect(2)
    elif middle > _ROUNDS:
        gc.collect(1)
    elif young > _YOUNG:
        gc.collect(0)


def collect_all() -> None:
    """Collect all that is due, and give its memory back to the system."""
    _Search.at_s = time.monotonic()
    gc.collect(2)
    give_back_memory()


def collect_soon(owner: QtCore.QObject) -> None:
    """Collect all in a moment, if the owner still lives: after a painting was let go of.

    Paintings are circles of objects too, of some hundred megabytes.
    """
    QtCore.QTimer.singleShot(_SOON_MS, owner, collect_all)


def collect_here(owner: QtCore.QObject) -> None:
    """From now on collect garbage in this thread only, as long as its owner lives."""
    gc.disable()
    gc.freeze()  # what was imported stays: half of what a whole search looks at
    timer = QtCore.QTimer(owner, interval=_LOOK_MS)
    timer.timeout.connect(collect_garbage)
    timer.start()
