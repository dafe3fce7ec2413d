"""Garbage collection in the window's thread alone.

Python collects unreachable cycles in whatever thread happens to make the next object. A closed
window is such a cycle, and Qt's objects must not be destroyed in another thread than their own:
while the window's thread delivers them an event, that crashes the program.
"""

from __future__ import annotations

import gc
import threading
import time

from PySide6 import QtCore

from paint3d.core.machine import give_back_memory

__all__ = ["collect_all", "collect_garbage", "collect_here", "collect_later"]

_LOOK_MS = 250
_LATER_MS = 3000  # when what was opened instead has been drawn, and lit
_YOUNG = 700  # objects, Python's own thresholds
_ROUNDS = 10
_REST_S = 60.0  # between searches among all objects, some .05 s each


class _Search:
    """The time of the last full collection."""

    at_s = 0.0


def collect_garbage() -> None:
    """Collect generations that are due, as Python itself would, in the calling thread."""
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
    """Collect all generations, and give their memory back to the system.

    Giving back takes up to a tenth of a second, so a thread of its own does it.
    """
    _Search.at_s = time.monotonic()
    gc.collect(2)
    threading.Thread(target=give_back_memory, name="paint3d-memory", daemon=True).start()


def collect_later(owner: QtCore.QObject) -> QtCore.QTimer:
    """Return a timer that collects all a while after its last start, as long as its owner lives.

    It is started when a painting is closed: paintings are cycles too, of some hundred megabytes.
    """
    timer = QtCore.QTimer(owner, interval=_LATER_MS, singleShot=True)
    timer.timeout.connect(collect_all)
    return timer


def collect_here(owner: QtCore.QObject) -> None:
    """Collect garbage in this thread only, as long as the owner lives."""
    gc.disable()
    gc.freeze()  # what was imported stays: half of what a whole search looks at
    timer = QtCore.QTimer(owner, interval=_LOOK_MS)
    timer.timeout.connect(collect_garbage)
    timer.start()
