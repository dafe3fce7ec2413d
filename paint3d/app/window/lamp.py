"""The light in the window: which, and whither its lamp is turned; kept with the painting."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from paint3d.app.model.document import Document
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


class Lamp:
    """Commands that choose and turn the light; ``do_<action>`` for each."""

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        workspace.hand.lamp_turned.connect(self.turn_by)

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
        """Show the object in a light, which is kept with the painting."""
        self._workspace.stage.set_light(kind, turn)
        self._workspace.post("set_light", kind, turn)

    def recall(self, document: Document) -> None:
        """Show a painting in the light it was seen in last; the studio's where it says none."""
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
