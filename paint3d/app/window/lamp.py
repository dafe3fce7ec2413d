"""The light in the window: its kind and the lamp's direction, saved with the painting."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from PySide6 import QtCore, QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.window.forms import FormDialog
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.core.arrays import as_number
from paint3d.errors import InputError, Message
from paint3d.view.live_light import LIVE_LIGHTS

__all__ = ["Lamp"]

_NAMES = {
    "studio": Message("Studio"),
    "soft": Message("Overcast sky"),
    "raking": Message("Low from the left"),
    "plain": Message("Even, without shadows"),
}
_A_PIXEL = math.radians(0.5)


class LightDialog(FormDialog):
    """Asks for a light and the lamp's direction; shown at once.

    Signals
    -------
    changed : (str, float)
        A light, and the turn of its lamp, radians.
    """

    changed = QtCore.Signal(str, float)

    def __init__(self, parent: QtWidgets.QWidget, kind: str, turn: float) -> None:
        super().__init__(parent, say("Light…").rstrip("…"))
        names = {name: say(text) for name, text in _NAMES.items()}
        self.kind_box = self.add_box(say("Light"), names, kind)
        self.turn = QtWidgets.QSlider(QtCore.Qt.Orientation.Horizontal)
        self.turn.setRange(-180, 180)
        self.turn.setMinimumWidth(220)
        self.turn.setAccessibleName(say("Lamp turned"))
        self.turn.setToolTip(say("Also by J held, and a drag"))
        self.turn.setValue(round(math.degrees(turn)))
        self.form.addRow(say("Lamp turned"), self.turn)
        self.finish(say("OK"))
        self.kind_box.currentIndexChanged.connect(self._tell)
        self.turn.valueChanged.connect(self._tell)

    def _tell(self) -> None:
        self.changed.emit(self.kind_box.currentData(), math.radians(self.turn.value()))


class Lamp:
    """Commands that choose and turn the light; ``do_<action>`` for each."""

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        workspace.hand.lamp_turned.connect(self.turn_by)

    def do_choose_light(self) -> None:
        """Ask for a light, showing it meanwhile; restore the one before if cancelled."""
        stage = self._workspace.stage
        before = stage.light
        dialog = LightDialog(self._workspace.window, *before)
        dialog.changed.connect(stage.set_light)
        if not dialog.exec():
            stage.set_light(*before)
        elif stage.light != before:
            self._set(*stage.light)
        dialog.deleteLater()

    def do_next_light(self) -> None:
        """Show the object in another light."""
        stage = self._workspace.stage
        kind = LIVE_LIGHTS[(LIVE_LIGHTS.index(stage.light[0]) + 1) % len(LIVE_LIGHTS)]
        self._set(kind, stage.light[1])
        self._workspace.tell(say("Light: {name}", name=say(_NAMES[kind])))

    def turn_by(self, pixels: float) -> None:
        """Turn the lamp around the object by a drag."""
        kind, turn = self._workspace.stage.light
        turn = (turn + _A_PIXEL * pixels + math.pi) % (2.0 * math.pi) - math.pi
        self._set(kind, turn)
        self._workspace.tell(say("Lamp turned by {degrees:.0f}°", degrees=math.degrees(turn)))

    def _set(self, kind: str, turn: float) -> None:
        """Show the object in a light, which is saved with the painting."""
        self._workspace.stage.set_light(kind, turn)
        self._workspace.post("set_light", kind, turn)

    def recall(self, document: Document) -> None:
        """Show a painting in its last light; by default the studio's."""
        kind, turn = _light_of(document.properties.get("light"))
        self._workspace.stage.set_light(kind, turn)


def _light_of(words: object) -> tuple[str, float]:
    if not isinstance(words, Mapping) or words.get("kind") not in LIVE_LIGHTS:
        return LIVE_LIGHTS[0], 0.0
    try:
        turn: Any = as_number(words.get("turn"), "turn", -math.pi, math.pi)
    except InputError:
        turn = 0.0
    return str(words["kind"]), float(turn)
