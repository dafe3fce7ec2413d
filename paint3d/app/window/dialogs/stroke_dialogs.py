"""By how much a stroke is moved, and how long it is to take: two small questions."""

from __future__ import annotations

from typing import Any

from PySide6 import QtWidgets

from paint3d.app.window.dialogs.forms import FormDialog
from paint3d.app.window.wording import say

__all__ = ["MoveDialog", "TimeDialog"]

_FARTHEST_MM, _LATEST_S = 2000.0, 600.0
_SHORTEST_S, _LONGEST = 0.01, 100.0  # s, and times as long


class MoveDialog(FormDialog):
    """Ask how far along the surface, and how far about its normal.

    Parameters
    ----------
    parent : QWidget
    number : int
        Of the stroke, from 1.
    """

    def __init__(self, parent: QtWidgets.QWidget, number: int) -> None:
        super().__init__(parent, say("Move stroke {n}", n=number))
        far = _FARTHEST_MM
        self.right = self.add_number(say("To the right (x)"), -far, far, 0.0, "mm", 2)
        self.up = self.add_number(say("Upwards (y)"), -far, far, 0.0, "mm", 2)
        self.turn = self.add_number(say("Turn to the left"), -360.0, 360.0, 0.0, "°", 1)
        self.finish("Move")

    @property
    def edit(self) -> dict[str, Any]:
        """What was chosen, as `score_edits.edit_stroke` takes it."""
        along = [self.right.value(), self.up.value()]
        return {"do": "move", "along": along, "turn_deg": self.turn.value()}


class TimeDialog(FormDialog):
    """Ask how long a stroke is to take, and how much later it is to begin.

    Parameters
    ----------
    parent : QWidget
    number : int
        Of the stroke, from 1.
    seconds : float
        That it takes now.
    """

    def __init__(self, parent: QtWidgets.QWidget, number: int, seconds: float) -> None:
        super().__init__(parent, say("Time of stroke {n}", n=number))
        self._was = seconds
        least, longest = min(_SHORTEST_S, seconds), max(1.0, _LONGEST * seconds)
        self.seconds = self.add_number(say("It takes"), least, longest, seconds, "s", 2)
        late = _LATEST_S
        self.shift = self.add_number(say("It begins later by"), -late, late, 0.0, "s", 2)
        self.finish("Change")

    @property
    def edit(self) -> dict[str, Any]:
        """What was chosen, as `score_edits.edit_stroke` takes it."""
        words: dict[str, Any] = {"do": "time", "shift_s": self.shift.value()}
        if abs(self.seconds.value() - self._was) > 0.005:  # of what the box shows
            words["seconds"] = self.seconds.value()
        return words
