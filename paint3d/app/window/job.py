"""Long work beside the window, with a progress bar and a button to cancel it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, wait
from typing import Any

from PySide6 import QtCore, QtWidgets

from paint3d.app.window.wording import say, say_left

__all__ = ["JobProgress", "is_waiting", "result_of", "run_beside"]

_SOON_MS = 350  # shorter work shows no bar, unless the window itself works, too
_LOOK_MS = 40
_GRACE_S = 0.6  # that work has to stop in; then it is abandoned, and its result dropped
_AHEAD, _AHEAD_S = 0.05, 2.0  # the bar moves on by itself, at most so far, half of it in such time
_STEPS = 1000  # of the bar
_KNOWN_S, _KNOWN = 3.0, 0.1  # and of the work: from then on the time left is shown

_KIND = QtCore.QEvent.Type
_DEAF = frozenset(
    {
        _KIND.KeyPress, _KIND.Shortcut, _KIND.ShortcutOverride, _KIND.MouseButtonPress,
        _KIND.MouseButtonDblClick, _KIND.TabletPress, _KIND.TouchBegin, _KIND.Wheel,
        _KIND.ContextMenu, _KIND.DragEnter, _KIND.Drop, _KIND.Close,
    }
)  # fmt: skip
"""Events that the window does not get while it waits for work."""

_waiting: list[QtWidgets.QWidget] = []


class JobProgress:
    """Progress of work, and whether it should stop."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._stopped = self._settled = False
        self._reported = 0.0, time.monotonic()  # fraction done, and when it was reported

    def __call__(self, fraction: float) -> None:
        """Report progress, 0 to 1; with 1 it is done, and cannot be stopped any more.

        Progress never falls below what was reported before.

        Raises
        ------
        CancelledError
            If it is no longer wanted.
        """
        with self._lock:
            if self._stopped:
                raise CancelledError
            self._settled = self._settled or fraction >= 1.0
        self._reported = max(self._reported[0], float(fraction)), time.monotonic()

    @property
    def done(self) -> float:
        """The progress last reported, 0 to 1."""
        return self._reported[0]

    @property
    def fraction(self) -> float:
        """The progress to show, 0 to 1: that reported, and a little more as time goes by.

        It is at most 0.05 ahead of the report, so it goes back by no more than that.
        """
        done, since = self._reported
        gone = time.monotonic() - since
        return done + min(_AHEAD, 1.0 - done) * gone / (gone + _AHEAD_S)

    def check(self) -> None:
        """Raise CancelledError if it is no longer wanted."""
        if self._stopped:
            raise CancelledError

    def stop(self) -> None:
        """Ask the work to stop; if it is done, nothing happens."""
        with self._lock:
            self._stopped = not self._settled

    @property
    def is_stopped(self) -> bool:
        """True if it is no longer wanted."""
        return self._stopped


def result_of(future: Future[Any], progress: JobProgress) -> Any:
    """Wait for a result of another thread; if stopped while it is queued, it is not begun."""
    while not wait([future], timeout=_LOOK_MS / 1e3).done:
        try:
            progress.check()
        except CancelledError:
            future.cancel()
            raise
    return future.result()


def run_beside(
    parent: QtWidgets.QWidget,
    title: str,
    work: Callable[[JobProgress], object],
    here: Callable[[], None] | None = None,
) -> Future[Any]:
    """Run work in a thread of its own while the window lives on; returns when it has ended.

    Meanwhile the window takes no clicks and keys: nothing else can be begun that what is made
    would replace. When it is stopped, this returns within a second, whether the work has noticed
    or not; what it makes later is dropped.

    Parameters
    ----------
    parent : QWidget
        If it waits for other work already, nothing is done.
    title : str
        Text of the bar.
    work : callable
        Called with a `JobProgress`, which raises CancelledError once it is to stop.
    here : callable, optional
        Called again and again in the window's own thread while the work goes on, once the bar is
        seen.

    Returns
    -------
    Future
        Done: its result or its error; a CancelledError if it was stopped.
    """
    if parent in _waiting:
        return _cancelled()
    progress, future = JobProgress(), Future[Any]()
    worker = threading.Thread(target=_do, args=(work, progress, future), name="paint3d-work")
    _waiting.append(parent)
    try:
        bar = _Bar(parent, title, progress, future, here)
        worker.start()
        bar.wait()
    finally:
        _waiting.remove(parent)
    return future if future.done() else _cancelled()


def is_waiting(window: QtWidgets.QWidget) -> bool:
    """Return whether a window waits for work beside it."""
    return window in _waiting


def _do(work: Callable[[JobProgress], object], progress: JobProgress, future: Future[Any]) -> None:
    try:
        result = work(progress)
        progress(1.0)  # from here on it is done; if it was stopped before, it does not count
        future.set_result(result)
    except BaseException as error:
        future.set_exception(error)


def _cancelled() -> Future[Any]:
    future: Future[object] = Future()
    future.set_exception(CancelledError())
    return future


class _Bar(QtCore.QObject):
    """Shows the progress of work, until it has ended or is abandoned."""

    def __init__(
        self,
        parent: QtWidgets.QWidget,
        title: str,
        progress: JobProgress,
        future: Future[Any],
        here: Callable[[], None] | None,
    ) -> None:
        super().__init__()
        self._window, self._progress, self._future, self._here = parent, progress, future, here
        self._error: BaseException | None = None
        self._stopped_at: float | None = None
        self._began = time.monotonic()
        self._title = title
        self._loop = QtCore.QEventLoop()
        self._dialog = dialog = QtWidgets.QProgressDialog(title, say("Cancel"), 0, _STEPS, parent)
        dialog.setWindowTitle(say("Please wait"))
        dialog.setWindowModality(QtCore.Qt.WindowModality.WindowModal)
        dialog.setMinimumDuration(10 * _SOON_MS)  # `_show` is earlier
        dialog.setMinimumWidth(360)
        dialog.setAutoClose(False)
        dialog.setAutoReset(False)
        dialog.canceled.connect(self._stop)

    def wait(self) -> None:
        """Run an event loop until the work has ended."""
        soon = QtCore.QTimer(singleShot=True, interval=_SOON_MS)
        soon.timeout.connect(self._show)
        look = QtCore.QTimer(interval=_LOOK_MS if self._here is None else 0)
        look.timeout.connect(self._look)
        program = QtWidgets.QApplication.instance()
        assert program is not None, "a window has one"
        program.sendEvent(self._window, QtCore.QEvent(QtCore.QEvent.Type.WindowBlocked))
        program.installEventFilter(self)
        soon.start(_SOON_MS if self._here is None else 0)
        look.start()
        self._loop.exec()
        soon.stop()
        look.stop()
        program.removeEventFilter(self)
        self._dialog.close()
        self._dialog.deleteLater()
        if self._error is not None:
            raise self._error

    def _show(self) -> None:
        if self._stopped_at is None:
            self._dialog.show()

    def _stop(self) -> None:
        if self._stopped_at is None:
            self._stopped_at = time.monotonic()
            self._progress.stop()

    def _look(self) -> None:
        self._dialog.setValue(round(_STEPS * min(self._progress.fraction, 1.0)))
        spent, done = time.monotonic() - self._began, self._progress.done
        if spent > _KNOWN_S and _KNOWN <= done < 1.0:
            to_come = say_left(spent * (1.0 - done) / done)
            self._dialog.setLabelText(f"{self._title}\n{to_come}")
        stopped = self._stopped_at if self._progress.is_stopped else None
        left = stopped is not None and time.monotonic() - stopped > _GRACE_S
        if self._future.done() or left:
            self._loop.quit()
        elif self._here is not None and self._stopped_at is None and self._is_seen():
            self._do_here(self._here)

    def _is_seen(self) -> bool:
        """Return whether the bar is on the screen, or should have been for a while."""
        seen = self._dialog.isVisible() and self._dialog.windowHandle().isExposed()
        return seen or time.monotonic() - self._began > 1e-3 * _SOON_MS

    def _do_here(self, here: Callable[[], None]) -> None:
        try:
            here()
        except Exception as error:
            self._error = error
            self._progress.stop()
            self._loop.quit()

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Keep clicks and keys from the window."""
        if event.type() not in _DEAF or not self._belongs_to_window(watched):
            return False
        event.setAccepted(event.type() == _KIND.ShortcutOverride)  # else it becomes a shortcut
        return True

    def _belongs_to_window(self, watched: QtCore.QObject) -> bool:
        """Return whether an event is for the window, something in it, or one of its actions."""
        if isinstance(watched, QtWidgets.QWidget):
            return watched.window() is self._window
        return watched is self._window.windowHandle() or watched.parent() is self._window
