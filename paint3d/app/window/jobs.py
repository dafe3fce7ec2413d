"""Long work beside the window: a bar that shows how far it is, and a button that ends it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor

from PySide6 import QtCore, QtWidgets

from paint3d.app.window.wording import say

__all__ = ["Progress", "run_beside"]

_SOON_MS = 350  # work that is done by then shows no bar
_LOOK_MS = 40


class Progress:
    """Given to the work: how far it is, and whether it should stop."""

    def __init__(self) -> None:
        self.share: float | None = None
        self._stopped = threading.Event()

    def __call__(self, share: float) -> None:
        """Say how far it is, 0 to 1.

        Raises
        ------
        CancelledError
            If it is no longer wanted.
        """
        self.share = float(share)
        self.check()

    def check(self) -> None:
        """Raise CancelledError if it is no longer wanted."""
        if self._stopped.is_set():
            raise CancelledError

    def stop(self) -> None:
        """Want it no longer."""
        self._stopped.set()


def run_beside(
    parent: QtWidgets.QWidget, title: str, work: Callable[[Progress], object]
) -> Future[object]:
    """Run work in a thread of its own while the window lives on; returns when it has ended.

    Parameters
    ----------
    parent : QWidget
    title : str
        What is being done.
    work : callable
        Called with a `Progress`; `Progress.check` raises CancelledError once it is to stop.

    Returns
    -------
    Future
        Done: its result, its error, or cancelled.
    """
    progress, loop = Progress(), QtCore.QEventLoop()
    dialog = QtWidgets.QProgressDialog(title, say("button.cancel"), 0, 0, parent)
    dialog.setWindowTitle(say("Please wait"))
    dialog.setWindowModality(QtCore.Qt.WindowModality.WindowModal)
    dialog.setMinimumDuration(_SOON_MS)
    dialog.setAutoClose(False)
    dialog.setAutoReset(False)
    dialog.canceled.connect(progress.stop)
    soon = QtCore.QTimer(singleShot=True, interval=_SOON_MS)
    soon.timeout.connect(dialog.show)
    with ThreadPoolExecutor(1, thread_name_prefix="paint3d-work") as beside:
        future = beside.submit(work, progress)
        look = QtCore.QTimer(interval=_LOOK_MS)

        def looked() -> None:
            if progress.share is not None:
                dialog.setRange(0, 1000)
                dialog.setValue(round(1000 * progress.share))
            if future.done():
                loop.quit()

        look.timeout.connect(looked)
        look.start()
        soon.start()
        loop.exec()
        soon.stop()
        look.stop()
    dialog.close()
    dialog.deleteLater()
    return future
