"""Faults of timers: a timer repeats its action and must not repeat its error messages."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable

__all__ = ["ReportOnce"]


class ReportOnce:
    """Runs an action and reports each distinct exception once, by where it was raised.

    Parameters
    ----------
    action : callable
    tell : callable
        Called with the fault's text, for the user.
    """

    def __init__(self, action: Callable[[], object], tell: Callable[[str], object]) -> None:
        self._action, self._tell = action, tell
        self._known: set[tuple[object, ...]] = set()

    def __call__(self) -> None:
        """Run the action; report an exception that is new."""
        try:
            self._action()
        except Exception as error:  # the next call may well succeed
            last = traceback.extract_tb(error.__traceback__)[-1]
            fault = type(error), last.filename, last.lineno
            if fault not in self._known:
                self._known.add(fault)
                sys.excepthook(type(error), error, error.__traceback__)
                self._tell(f"{type(error).__name__}: {error}")
