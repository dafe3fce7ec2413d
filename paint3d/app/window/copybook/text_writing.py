"""Writing a text that is laid on the object with the brush in hand, as `paint3d write` does."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from PySide6 import QtCore

from paint3d.app.model.frame import Snapshot
from paint3d.app.window.copybook.text_moving import HeldText
from paint3d.app.window.job import JobProgress
from paint3d.app.window.playing.player import Asked, Player, Tools
from paint3d.app.window.playing.recordings import samples_of, tool_changes_of, tools_in_hand
from paint3d.app.window.questions import Answer, ask
from paint3d.app.window.wording import say, say_brush, say_length
from paint3d.app.window.workspace import Workspace
from paint3d.brush.presets import brush_for, suits_size
from paint3d.calligraphy.page.laying import PlacedPiece
from paint3d.calligraphy.writing import WritingSettings, plan_ahead
from paint3d.core.machine import usable_cores
from paint3d.errors import Paint3DError

if TYPE_CHECKING:
    from paint3d.brush.spec import BrushSpec
    from paint3d.recording.recording import Recording

__all__ = ["TextWriting"]

_DIPS = "auto"  # before the characters for which there is not enough ink left
_SETTLED_MS = 700  # after a text was laid
_VARIATION = 1.0  # as a practised hand's
_PLANNED = 0.6  # of the time until the brush moves


class TextWriting:
    """Has the brush write the text that lies on the object.

    Parameters
    ----------
    workspace : Workspace
    player : Player
        Paints what was planned.
    held : callable
        The text that is chosen, as it lies there, or None.
    resize : callable
        Lays it in another size, mm; where it cannot, it lies as before.
    """

    def __init__(
        self,
        workspace: Workspace,
        player: Player,
        held: Callable[[], HeldText | None],
        resize: Callable[[float], None],
    ) -> None:
        self._workspace, self._player = workspace, player
        self._held, self._resize = held, resize
        self._ahead = 0  # times that planning ahead was begun or ended: only the last goes on
        self._timer = QtCore.QTimer(workspace, interval=_SETTLED_MS, singleShot=True)
        self._timer.timeout.connect(self._plan_ahead)

    def prepare(self) -> None:
        """Plan the text that is chosen beside the window, once it is left as it lies."""
        self._ahead += 1
        self._timer.start()

    def _plan_ahead(self) -> None:
        held, paint_thread = self._held(), self._workspace.stage.paint_thread
        if held is None or paint_thread is None or not held.book.ghosts:
            return
        pieces = [PlacedPiece(ghost.glyph, ghost.square) for ghost in held.book.ghosts]
        brush, em = paint_thread.brush, held.laid.em_mm
        settings = _settings_for(brush if suits_size(brush, em) else brush_for(em), em)
        number = self._ahead

        def plan() -> None:
            with suppress(Paint3DError):  # told when it is to be written
                for _ in plan_ahead(pieces, settings):
                    if number != self._ahead:
                        return

        threading.Thread(target=plan, name="paint3d-plans", daemon=True).start()

    def do_write_text(self) -> None:
        """Plan the strokes of the text that is chosen, and paint them as a hand would.

        As fast as it goes; the bar of what is played slows it down.
        """
        workspace, held = self._workspace, self._held()
        if held is None or not held.book.ghosts:
            workspace.tell(say("There is no text to write; lay one out first"), state="bad")
            return
        workspace.hand.interrupt()
        self._timer.stop()
        self._ahead += 1
        workspace.actions["arrange_text"].setChecked(False)
        painting, brush = workspace.painting, workspace.paint_thread.brush
        in_hand, em = brush, held.laid.em_mm
        if not suits_size(in_hand, em):
            brush = brush_for(em)
        folder = workspace.settings.glyphs or None
        title = say("Planning the strokes…")
        planned = workspace.run(title, partial(_made_ready, held, painting, brush, folder))
        error = planned.exception()
        smaller = error.message.fields.get("smaller") if isinstance(error, Paint3DError) else None
        if isinstance(smaller, float):
            if self._lies_smaller(em, smaller):
                self.do_write_text()
        elif workspace.went_well(planned):
            samples, loads, strengths = planned.result()
            after = tools_in_hand(painting, in_hand)
            before = _fresh(painting)
            if brush != in_hand:
                before.insert(1, ("set_brush", (brush,)))
            tools = Tools(before, after, loads, strengths, writes=True)
            self._player.play(samples, None, tools)
            if brush != in_hand:
                told = say(
                    "The brush is {brush}, for characters of {size}; Esc stops it",
                    brush=say_brush(brush.name),
                    size=say_length(em),
                )
                workspace.tell(told)

    def _lies_smaller(self, em_mm: float, smaller: float) -> bool:
        """Whether a text for which the brush has no room lies in a size now for which it has."""
        message = say(
            "The brush has no room to write it here at {size}; at {smaller} it has",
            size=say_length(em_mm),
            smaller=say_length(smaller),
        )
        accept = say("Write it at {size}", size=say_length(smaller))
        window = self._workspace.window
        if ask(window, message, accept=accept, warns=True) is Answer.AcceptRole:
            self._resize(smaller)
        held = self._held()
        return held is not None and held.laid.em_mm == smaller


def _fresh(painting: Snapshot) -> list[Asked]:
    """The brush in hand, dipped as it was last, and turned by the handle."""
    return [
        ("set_azimuth", ("commanded",)),
        ("dip", (painting.dipped, None, painting.amount.words())),
    ]


def _made_ready(
    held: HeldText, painting: Snapshot, brush: BrushSpec, folder: str | None, progress: JobProgress
) -> tuple[Any, ...]:
    """The samples of a text that is written, and what the brush comes to hold at them."""
    from paint3d.calligraphy.dips import apply_dip_option
    from paint3d.calligraphy.flying_white import with_ink

    def tell(_: str, fraction: float) -> None:
        progress(_PLANNED * fraction)

    written = _plan(held, painting, brush, folder, tell)
    dipped = apply_dip_option(written.recording, brush, _DIPS, painting.material)
    written = replace(written, recording=dipped)
    recording: Recording = with_ink(
        written.recording, written.dryness, written.strength, painting.material
    )
    return (samples_of(recording, progress), *tool_changes_of(recording))


def _plan(
    held: HeldText,
    painting: Snapshot,
    brush: BrushSpec,
    folder: str | None,
    tell: Callable[[str, float], None],
) -> Any:
    from paint3d.calligraphy.fonts.fallback import with_fallback
    from paint3d.calligraphy.glyph_sources import open_glyphs
    from paint3d.calligraphy.writing import write_page, write_text

    laid, page = held.laid, held.book.page
    options: dict[str, Any] = {
        "settings": _settings_for(brush, laid.em_mm),
        "layout": laid.layout,
        "progress": tell,
    }
    options["processes"] = usable_cores()
    if page is not None:
        return write_page(painting.source, page, **options)
    source = with_fallback(open_glyphs(folder), laid.text)
    return write_text(painting.source, laid.text, source, **options)


def _settings_for(brush: BrushSpec, em_mm: float) -> WritingSettings:
    return WritingSettings(brush, em_mm, variation=_VARIATION, seed=1)
