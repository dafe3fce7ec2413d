"""Writing a text that lies on the object with the brush in hand, as `paint3d write` does."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from PySide6 import QtCore

from paint3d.app.model.frame import Snapshot
from paint3d.app.window.copybook.text_moving import ChosenText
from paint3d.app.window.job import JobProgress
from paint3d.app.window.object.detail import Detail
from paint3d.app.window.playing.player import Asked, Player, Tools
from paint3d.app.window.playing.recordings import samples_of, tool_changes_of, tools_in_hand
from paint3d.app.window.questions import Answer, ask
from paint3d.app.window.wording import say, say_brush, say_coarse, say_length
from paint3d.app.window.workspace import Workspace
from paint3d.brush.presets import brush_for, suits_size
from paint3d.calligraphy.layout import detail_or_size
from paint3d.calligraphy.page.laying import PlacedPiece
from paint3d.calligraphy.writing import WritingSettings, plan_ahead
from paint3d.core.machine import usable_cores
from paint3d.errors import Paint3DError

if TYPE_CHECKING:
    from paint3d.brush.spec import BrushSpec
    from paint3d.recording.recording import Recording

__all__ = ["TextWriting"]

_DIPS = "auto"  # dip before characters for which too little ink is left
_SETTLED_MS = 700  # after a text was laid
_VARIATION = 1.0  # as a practised hand's
_PLANNED = 0.6  # of the progress until the brush moves


class TextWriting:
    """Writes the chosen text on the object with the brush.

    Parameters
    ----------
    workspace : Workspace
    player : Player
        Paints the planned strokes.
    chosen_text : callable
        Returns the chosen text as it lies on the object, or None.
    resize : callable
        Lays it in another size, mm; where it cannot, it lies as before.
    detail : Detail
        Paints all anew on a finer surface.
    """

    def __init__(
        self,
        workspace: Workspace,
        player: Player,
        chosen_text: Callable[[], ChosenText | None],
        resize: Callable[[float], None],
        detail: Detail,
    ) -> None:
        self._workspace, self._player = workspace, player
        self._chosen_text, self._resize, self._detail = chosen_text, resize, detail
        self._ahead = 0  # times that planning ahead was begun or ended: only the last goes on
        self._timer = QtCore.QTimer(workspace, interval=_SETTLED_MS, singleShot=True)
        self._timer.timeout.connect(self._plan_ahead)

    def prepare(self) -> None:
        """Plan the chosen text beside the window, once it has stayed as it lies for a while."""
        self._ahead += 1
        self._timer.start()

    def _plan_ahead(self) -> None:
        chosen, paint_thread = self._chosen_text(), self._workspace.stage.paint_thread
        if chosen is None or paint_thread is None or not chosen.book.ghosts:
            return
        pieces = [PlacedPiece(ghost.glyph, ghost.square) for ghost in chosen.book.ghosts]
        brush, em = paint_thread.brush, chosen.laid.em_mm
        settings = _settings_for(brush if suits_size(brush, em) else brush_for(em), em)
        number = self._ahead

        def plan() -> None:
            with suppress(Paint3DError):  # shown when it is to be written
                for _ in plan_ahead(pieces, settings):
                    if number != self._ahead:
                        return

        threading.Thread(target=plan, name="paint3d-plans", daemon=True).start()

    def do_write_text(self) -> None:
        """Plan the strokes of the chosen text, and paint them as a hand would.

        As fast as it goes; the replay's bar slows it down.
        """
        workspace, chosen = self._workspace, self._chosen_text()
        if chosen is None or not chosen.book.ghosts:
            workspace.tell(say("There is no text to write; lay one out first"), state="bad")
            return
        workspace.hand.interrupt()
        self._timer.stop()
        self._ahead += 1
        workspace.actions["arrange_text"].setChecked(False)
        em = chosen.laid.em_mm
        if not self._is_fine_enough(em):
            return
        painting, brush = workspace.painting, workspace.paint_thread.brush
        in_hand = brush
        if not suits_size(in_hand, em):
            brush = brush_for(em)
        folder = workspace.settings.glyphs or None
        title = say("Planning the strokes…")
        planned = workspace.run(title, partial(_written_samples, chosen, painting, brush, folder))
        error = planned.exception()
        smaller = error.message.fields.get("smaller") if isinstance(error, Paint3DError) else None
        if isinstance(smaller, float):
            if self._offer_smaller(em, smaller):
                self.do_write_text()
        elif workspace.went_well(planned):
            samples, loads, strengths = planned.result()
            after = tools_in_hand(painting, in_hand)
            before: list[Asked] = [("set_azimuth", ("commanded",))]  # turned by the handle
            if brush != in_hand:
                before.append(("set_brush", (brush,)))
            before.append(("dip", (painting.dipped, None, painting.amount.words())))
            tools = Tools(before, after, loads, strengths, writes=True)
            self._player.play(samples, None, tools)
            if brush != in_hand:
                message = say(
                    "The brush is {brush}, for characters of {size}; Esc stops it",
                    brush=say_brush(brush.name),
                    size=say_length(em),
                )
                workspace.tell(message)

    def _is_fine_enough(self, em_mm: float) -> bool:
        """Offer a finer detail where characters would break up; return whether to write now."""
        needed = detail_or_size(em_mm, self._workspace.painting.resolution)
        if needed is None:
            return True
        accept = ""
        if self._detail.can_paint_anew:
            accept = say("Paint anew at {detail}", detail=say_length(needed[0]))
        answer = ask(
            self._workspace.window, say_coarse(em_mm, *needed),
            accept=accept, destroy=say("Write it so"), warns=True,
        )  # fmt: skip
        if answer is Answer.AcceptRole:
            return self._detail.paint_anew(needed[0])
        return answer is Answer.DestructiveRole

    def _offer_smaller(self, em_mm: float, smaller: float) -> bool:
        """Offer a smaller size where the brush has no room; return whether the text has it now."""
        message = say(
            "The brush has no room to write it here at {size}; at {smaller} it has",
            size=say_length(em_mm),
            smaller=say_length(smaller),
        )
        accept = say("Write it at {size}", size=say_length(smaller))
        window = self._workspace.window
        if ask(window, message, accept=accept, warns=True) is Answer.AcceptRole:
            self._resize(smaller)
        chosen = self._chosen_text()
        return chosen is not None and chosen.laid.em_mm == smaller


def _written_samples(
    chosen: ChosenText,
    painting: Snapshot,
    brush: BrushSpec,
    folder: str | None,
    progress: JobProgress,
) -> tuple[Any, ...]:
    """Plan a text; return its samples, and loads and strengths of the brush at them."""
    from paint3d.calligraphy.dips import apply_dip_option
    from paint3d.calligraphy.flying_white import with_ink

    def report(_: str, fraction: float) -> None:
        progress(_PLANNED * fraction)

    written = _plan(chosen, painting, brush, folder, report)
    dipped = apply_dip_option(written.recording, brush, _DIPS, painting.material)
    written = replace(written, recording=dipped)
    recording: Recording = with_ink(
        written.recording, written.dryness, written.strength, painting.material
    )
    return (samples_of(recording, progress), *tool_changes_of(recording))


def _plan(
    chosen: ChosenText,
    painting: Snapshot,
    brush: BrushSpec,
    folder: str | None,
    tell: Callable[[str, float], None],
) -> Any:
    from paint3d.calligraphy.fonts.fallback import with_fallback
    from paint3d.calligraphy.glyph_sources import open_glyphs
    from paint3d.calligraphy.writing import write_page, write_text

    laid, page = chosen.laid, chosen.book.page
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
