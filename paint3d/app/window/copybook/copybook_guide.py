"""Writing after a copybook: ghosts on the object, each character judged when it is done."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.app.model.copybook import Copybook
from paint3d.app.model.document import Document
from paint3d.app.model.stroke_log import Stroke
from paint3d.app.window.copybook.copybook_panel import CopybookPanel
from paint3d.app.window.copybook.strokes_dialog import CorrectionState, Photographed, StrokesDialog
from paint3d.app.window.questions import Answer, ask
from paint3d.app.window.wording import say, say_error
from paint3d.app.window.workspace import Workspace
from paint3d.calligraphy.layout import Layout
from paint3d.calligraphy.page.correcting import Steps
from paint3d.calligraphy.page.opening import opened_page, set_in
from paint3d.calligraphy.page.page import Composer, Page, Photograph, digest_of
from paint3d.errors import InputError, Paint3DError
from paint3d.files.photographs import PHOTOGRAPH_SUFFIXES, load_photograph

if TYPE_CHECKING:
    from paint3d.calligraphy.photo.copying import CopiedSheet, SheetPicture

__all__ = ["CopybookGuide"]

_OUTLINE, _NEXT = (176, 60, 44, 120), (176, 60, 44, 235)
_FRAME, _MEDIAN = (90, 84, 76, 110), (60, 90, 140, 150)


@dataclass
class _Laid:
    """What lies on the object, and how it came there."""

    em_mm: float
    layout: Layout
    file: Path | None = None
    photographed: Photographed | None = None
    note: str = ""
    state: str = "off"  # of the note
    unused: Steps[CorrectionState] | None = None  # corrections that could not be laid out


class CopybookGuide:
    """For one window."""

    def __init__(self, workspace: Workspace, panel: CopybookPanel) -> None:
        self._workspace, self._panel = workspace, panel
        self._laid = _Laid(40.0, Layout())
        workspace.may_drop = self.may_drop
        workspace.opened.connect(self._forget)
        panel.asked.connect(self.layout_text)
        panel.opened.connect(self.layout_file)
        panel.corrected.connect(self.correct)
        panel.hidden.connect(self.hide)
        workspace.hand.ended.connect(self._judge)

    def layout_text(self, text: str, em_mm: float, columns: bool, font: str = "") -> bool:
        """Lay a text on the object as ghosts, in a font or as known characters.

        Returns
        -------
        bool
            Whether that went well.
        """

        def composed() -> str | Composer:
            return set_in(text, font, columns=columns) if font else text

        laid = _Laid(em_mm, Layout(order="columns" if columns else "row"))
        return self.may_drop() and self._lay(composed, laid)

    def layout_file(self, file: str, em_mm: float) -> bool:
        """Lay a drawing, a file of strokes or a photographed sheet; whether that went well."""
        laid = _Laid(em_mm, Layout(), file=Path(file))

        def composed() -> Composer:
            if file.lower().endswith(PHOTOGRAPH_SUFFIXES):
                sheet, laid.photographed = _photographed(Path(file))
                laid.note = say("; ").join(map(say, sheet.notes))
                return sheet.page
            page = opened_page(file)
            if page.photograph is not None:
                try:
                    laid.photographed = _photographed_again(page, page.photograph)
                except Paint3DError as error:
                    laid.note = say("The strokes lie over their ink: {why}", why=say_error(error))
                    laid.state = "bad"
                else:
                    read = os.path.realpath(page.photograph.file)
                    laid.note = say("The strokes lie over the photograph {file}", file=read)
            return page

        return self.may_drop() and self._lay(composed, laid)

    def correct(self) -> None:
        """Show the strokes over their picture; what was corrected is laid out instead."""
        copybook, laid = self._panel.copybook, self._laid
        if copybook is None or copybook.page is None:
            return
        workspace = self._workspace
        page, beside = copybook.page, laid.file
        photographed = laid.photographed
        dialog = StrokesDialog(
            workspace.window, workspace.theme, page, photographed, beside, laid.unused
        )
        accepted = dialog.exec()
        dialog.deleteLater()
        laid.unused = None
        if accepted and dialog.is_changed:  # else what was written after them stays judged
            corrected = dialog.page
            laid.unused = dialog.steps  # until they lie on the object
            now = _Laid(laid.em_mm, laid.layout, laid.file, dialog.photographed)
            if not self._lay(lambda: corrected, now):
                workspace.tell(say("The corrections are kept; check the strokes again"))

    def may_drop(self) -> bool:
        """Whether nothing is lost by another page in its place, by none, or by another painting.

        Corrections that do not lie on the object are asked for.
        """
        if self._laid.unused is None:
            return True
        message = say("Corrected strokes could not be laid out and are not saved")
        window = self._workspace.window
        return ask(window, message, destroy=say("Drop them"), warns=True) is Answer.DestructiveRole

    def _lay(self, compose: Callable[[], str | Composer], laid: _Laid) -> bool:
        workspace = self._workspace
        mesh = workspace.painting.source

        def make(_: object) -> Copybook:
            copybook = Copybook(mesh, compose(), laid.em_mm, laid.layout)
            for ghost in copybook.ghosts:
                _ = ghost.outlines, ghost.medians, ghost.frame  # found here, beside the window
            return copybook

        done = workspace.run(say("Lay out"), make)
        if not workspace.went_well(done):
            return False
        copybook, self._laid = done.result(), laid
        self._panel.show_copybook(copybook)
        self._draw()
        taken = [
            say("{characters} taken from the font {font}", characters=text, font=font)
            for font, text in copybook.from_fonts.items()
        ]
        note = say("; ").join([*taken, *filter(None, [laid.note])])
        if note:
            workspace.tell(note, state=laid.state)
        return True

    def hide(self) -> None:
        """Take the ghosts away."""
        if not self.may_drop():
            return
        self._laid.unused = None
        self._panel.show_copybook(None)
        self._draw()

    def _forget(self) -> None:
        """Nothing lies on a painting that is opened."""
        self._laid = _Laid(40.0, Layout())

    def follow(self) -> None:
        """Take what strokes were judged to be."""
        panel, copybook = self._panel, self._panel.copybook
        if panel.follow() and copybook is not None:
            self._draw()
            for place, ghost in enumerate(copybook.ghosts):
                percent = panel.percent(place)
                if percent is not None and place == self._last(copybook):
                    message = say(
                        "{character}: {percent:.0f} %", character=ghost.text, percent=percent
                    )
                    self._workspace.tell(message, state="good")

    def _last(self, copybook: Copybook) -> int:
        """Place of the character before the next one."""
        following = copybook.next
        return (len(copybook.ghosts) if following is None else following) - 1

    def _judge(self, ended: Future[Stroke | None]) -> None:
        copybook = self._panel.copybook
        if copybook is None:
            return

        def note(document: Document) -> object:
            copybook.follow(document.strokes)
            stroke = ended.result()  # it was done before; None where a layer refused it
            return None if stroke is None else copybook.note(stroke, document.surface)

        self._panel.expect(self._workspace.paint_thread.post(note))

    def _draw(self) -> None:
        copybook, stage = self._panel.copybook, self._workspace.stage
        ghosts = copybook.ghosts if copybook is not None else ()
        following = copybook.next if copybook is not None else None
        waiting = [g for k, g in enumerate(ghosts) if k != following]
        current = [ghosts[following]] if following is not None else []
        stage.show_lines("ghost frames", [g.frame for g in ghosts], _FRAME, 1.0)
        stage.show_lines("ghosts", [line for g in waiting for line in g.outlines], _OUTLINE, 1.4)
        stage.show_lines("next ghost", [line for g in current for line in g.outlines], _NEXT, 2.2)
        stage.show_lines("next way", [line for g in current for line in g.medians], _MEDIAN, 1.2)


def _photographed(file: Path) -> tuple[CopiedSheet, Photographed]:
    """A photograph and its strokes; where no sheet stands out in it, it is one."""
    from paint3d.calligraphy.photo.copying import Asked, copy_sheet

    pixels, scale = load_photograph(file)
    sheet = copy_sheet(pixels, file.name, Asked(or_whole=True)).taken_from(file, scale)
    return sheet, Photographed(pixels, sheet, _finds(file, pixels, scale, invert=False))


def _photographed_again(page: Page, there: Photograph) -> Photographed:
    """The photograph that the strokes of a file are from, laid flat as it was then.

    Which file that is the file of strokes says: nothing but what is named as a picture is read.
    """
    from paint3d.calligraphy.photo.copying import seen_again

    if not there.file.name.lower().endswith(PHOTOGRAPH_SUFFIXES):
        raise InputError("{file}: not named as a picture; expected a photograph", file=there.file)
    pixels, scale = load_photograph(there.file)  # which says what is no file
    if there.digest not in ("", digest_of(there.file)):
        raise InputError(
            "{file}: another picture than the strokes were found in; expected that one there",
            file=there.file,
        )
    sheet = seen_again(page, pixels, scale)
    return Photographed(pixels, sheet, _finds(there.file, pixels, scale, invert=there.invert))


def _finds(
    file: Path, pixels: NDArray[np.uint8], scale: float, *, invert: bool
) -> Callable[[NDArray[np.float64]], SheetPicture]:
    """What finds the strokes anew in a sheet of other corners."""
    from paint3d.calligraphy.photo.copying import Asked, copy_sheet

    def find(corners: NDArray[np.float64]) -> SheetPicture:
        found = copy_sheet(pixels, file.name, Asked(corners, invert=invert))
        return found.taken_from(file, scale, invert=invert)

    return find
