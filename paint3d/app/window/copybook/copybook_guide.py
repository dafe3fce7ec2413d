"""Writing after a copybook: ghosts on the object, each character judged when it is done."""

from __future__ import annotations

import datetime
import os
import re
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore, QtWidgets

from paint3d.app.model.copybook import Copybook
from paint3d.app.model.document import Document
from paint3d.app.model.input.navigation import turn_to_see
from paint3d.app.model.laid_text import LaidText
from paint3d.app.model.stroke_log import Stroke
from paint3d.app.window.copybook.copybook_panel import CopybookPanel
from paint3d.app.window.copybook.strokes_dialog import (
    CorrectionSteps,
    Photographed,
    StrokesDialog,
)
from paint3d.app.window.copybook.text_moving import ChosenText, TextMover
from paint3d.app.window.files.open_result import OpenResult
from paint3d.app.window.questions import Answer, ask
from paint3d.app.window.seal import ProposedSeal
from paint3d.app.window.wording import (
    say,
    say_brush,
    say_coarse,
    say_error,
    say_fonts,
    say_length,
)
from paint3d.app.window.workspace import Workspace
from paint3d.brush.presets import brush_for, suits_size
from paint3d.calligraphy.composition import compose, seal_below, sign_beside
from paint3d.calligraphy.layout import LEAST_EM_MM, Layout, detail_or_size
from paint3d.calligraphy.page.opening import open_page
from paint3d.calligraphy.page.page import Composer, Page, Photograph, digest_of
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError, Paint3DError
from paint3d.files.photographs import PHOTOGRAPH_SUFFIXES, load_photograph
from paint3d.files.progress import Progress
from paint3d.mesh.sheet_mesh import sheet_of

if TYPE_CHECKING:
    from paint3d.brush.spec import BrushSpec
    from paint3d.calligraphy.photo.copying import CopiedSheet, SheetPicture

__all__ = ["CopybookGuide"]

_OUTLINE, _NEXT = (176, 60, 44, 120), (176, 60, 44, 235)
_SIGNATURE_EM_MM = 15.0  # where there is no text that it belongs to
_NAMELESS = "□□"  # where a name goes that is not known
_USUAL_SIGNATURE = 7  # characters: a year, a season, a name
_BY_ITSELF = {"em_mm", "point", "turn", "gap", "between"}  # a text with one fills no sheet
_MOVES = {"point", "turn"}
_CHOICES = {"around", "order"}  # where one does not fit, a size that does is offered
_BREAK_ANEW = {"grid", *_CHOICES}  # values with which the text's lines may break otherwise
_STEMS, _BRANCHES = "甲乙丙丁戊己庚辛壬癸", "子丑寅卯辰巳午未申酉戌亥"
_NUMERALS = r"\d〇零○一二三四五六七八九十"
_DATED = re.compile(  # a year, and the other parts of a date in a signature
    rf"(?:歲次|岁次|公元|西元|民國|民国)?(?:[{_STEMS}][{_BRANCHES}]|[{_NUMERALS}百千廿卅]+)\s*年\s*"
    rf"(?:[孟仲季]?[春夏秋冬](?!月))?\s*(?:[{_NUMERALS}正冬臘腊]+\s*月)?\s*"
    rf"(?:[{_NUMERALS}初廿卅]+\s*日)?"
)
_SIGNED = "書书寫写題题識识記记作畫画 "  # verbs of who signs: wrote, painted, inscribed
_LONGEST_TITLE = 16
_LAID = 0.3  # of the progress, before ghosts are made
_SOME = 500  # samples after which strokes are counted again
_FRAME, _MEDIAN = (90, 84, 76, 110), (60, 90, 140, 150)


@dataclass
class _TextLayout:
    """The page of a file that lies on the object, and where it came from."""

    em_mm: float
    layout: Layout
    file: Path | None = None
    photographed: Photographed | None = None
    note: str = ""
    state: str = "off"  # of the note
    unused: CorrectionSteps | None = None  # corrections that could not be laid out


class CopybookGuide:
    """Lays on the object what is written after: texts, drawings, strokes, photographs.

    Texts belong to the painting, and are steps of its history; a drawing, strokes or a photograph
    lies there until something else takes its place.

    Attributes
    ----------
    mover : TextMover
    laid_out : callable
        Called when a text has been laid, or laid otherwise.
    """

    def __init__(self, workspace: Workspace, panel: CopybookPanel) -> None:
        self._workspace, self._panel = workspace, panel
        self._laid = _TextLayout(40.0, Layout())
        self._books: dict[LaidText, Copybook | None] = {}  # None: it cannot be laid here
        self._shown: tuple[LaidText, ...] = ()
        self._loose: Copybook | None = None  # of a file
        self._active: int | None = None  # of the texts; None: the loose one, or none
        self._coming: Future[Any] | None = None  # a change of the texts
        self._making: Future[Any] | None = None  # copybooks of texts that came with the painting
        self._claimed: int | None = None  # the text that a stroke was for
        self.laid_out: Callable[[], None] = lambda: None
        # texts that a brush was chosen for, in all layouts; the brush before, and the chosen one
        self._fitted: list[tuple[set[LaidText], BrushSpec, BrushSpec]] = []
        self._counting: Future[Any] | None = None  # strokes, for the characters
        self._counted: object = None  # which strokes, for which texts
        self.mover = TextMover(workspace, self.chosen_text, self._choose_at)
        self.mover.changed.connect(self.change)
        self.mover.removed.connect(self.hide)
        self.mover.turned_on.connect(self._show_moving)
        workspace.may_drop = self.may_drop
        workspace.opened.connect(self._begin_anew)
        panel.asked.connect(self.ask)
        panel.opened.connect(self.layout_file)
        panel.corrected.connect(self.correct)
        panel.hidden.connect(self.hide)
        panel.chosen.connect(self.choose)
        panel.changed.connect(self.change)
        panel.nudged.connect(self.nudge)
        panel.moving.connect(lambda on: self.mover.begin() if on else self.mover.end())
        panel.signed.connect(self.do_sign)
        workspace.hand.ended.connect(self._judge)

    # -- commands ---------------------------------------------------------------------------

    def do_lay_out(self) -> None:
        """Show the panel, to write what is to be laid out."""
        for dock in self._workspace.window.findChildren(QtWidgets.QDockWidget):
            if dock.isAncestorOf(self._panel):
                dock.show()
                dock.raise_()
        self._panel.text.setFocus()
        self._panel.text.selectAll()

    def do_arrange_text(self, on: bool) -> None:
        """Switch between drags that move texts and drags that paint."""
        if on:
            self.mover.begin()
        else:
            self.mover.end()

    def do_sign(self) -> None:
        """Ask for a line of signature and date, and lay it smaller beside the text."""
        workspace = self._workspace
        name = workspace.settings.signer or _NAMELESS
        line = date_line(datetime.date.today(), name)
        dialog = QtWidgets.QInputDialog(workspace.window)
        dialog.setWindowTitle(say("Signature and date…").rstrip("…"))
        dialog.setLabelText(say("Date and name, as the line beside the text says them"))
        dialog.setTextValue(line)
        edit = dialog.findChild(QtWidgets.QLineEdit)
        assert edit is not None, "it asks for a line"
        # once it is shown, which selects the whole line: what is typed replaces the name alone
        name_alone = partial(edit.setSelection, line.rindex(name), len(name))
        QtCore.QTimer.singleShot(0, name_alone)
        agreed, text = dialog.exec(), dialog.textValue().replace(_NAMELESS, "")
        dialog.deleteLater()
        if not agreed or not text.strip():
            return
        workspace.update_settings(signer=signer_in(text))
        em_mm = self._signature_em_mm("".join(text.split()))
        signature = LaidText(text.strip(), em_mm, grid="none", is_signature=True)
        texts = self._workspace.painting.texts
        mains = [one for one in texts if one.text.strip() and not one.is_signature]
        if self._active is not None and self._active < len(texts):
            mains = [one for one in mains if one == texts[self._active]] or mains
        if mains:
            signature = self._beside(mains[-1], text.strip())
        if self._put(signature, None) and signature.point is None:
            self.mover.begin()

    def _signature_em_mm(self, words: str) -> float:
        """Return the size of a signature without a text: at most half of a sheet's height."""
        sheet = sheet_of(self._workspace.painting.source)
        if sheet is None:
            return _SIGNATURE_EM_MM
        half = 0.5 * (sheet.height_mm - 2.0 * sheet.margin_mm)
        return min(_SIGNATURE_EM_MM, max(LEAST_EM_MM, float(f"{half / len(words):.2g}")))

    def signature(self) -> ProposedSeal | None:
        """Return the signer's seal, below the signature; None without a text."""
        texts = self._workspace.painting.texts
        lines = [text for text in texts if text.is_signature]
        written = lines or [text for text in texts if text.text.strip()]
        if not written:
            return None
        laid, signer = written[-1], self._workspace.settings.signer
        book = self._books.get(laid)
        if book is None:
            return None
        mesh = self._workspace.painting.source
        if lines:
            signer, beside = signer_in(laid.text), seal_below(book.squares)
        else:
            beside = sign_beside(mesh, book.squares, 0, laid.order)
        return ProposedSeal(signer, beside.seal_mm, beside.seal_point, beside.up)

    def _beside(self, main: LaidText, words: str) -> LaidText:
        """Return a signature beside a text, smaller, below its last column or left of it."""
        book = self._books.get(main)
        signature = LaidText(words, main.em_mm, main.font, main.order, turn=main.turn,
                             grid="none", is_signature=True)  # fmt: skip
        if book is None:
            return signature.moved(em_mm=self._signature_em_mm("".join(words.split())))
        count = len("".join(words.split()))
        beside = sign_beside(self._workspace.painting.source, book.squares, count, main.order)
        point = self._workspace.hand.surface.find(beside.point[None]).points[0].tolist()
        signature = signature.moved(em_mm=beside.em_mm, between=beside.between)
        placed = signature.moved(point=tuple(point))
        try:
            self._copybook_of(placed)
        except Paint3DError:  # there is no room: it lies where it fits, to be moved
            return signature
        return placed

    def _filling(self, values: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return the values of a text that fills the sheet and leaves room for a signature."""
        sheet = sheet_of(self._workspace.painting.source)
        text = values["text"]
        if sheet is None or not text.strip():
            return values
        composition = compose(sheet, text, values["order"], signature=_USUAL_SIGNATURE)
        if composition is None:  # letters that do not stand in squares
            return values
        composed = {
            "text": "\n".join(composition.lines),
            "em_mm": composition.em_mm,
            "point": composition.point,
        }
        composed |= {"gap": composition.gap, "between": composition.between, "turn": 0.0}
        return {**values, **composed}

    def ask(self, values: Mapping[str, Any], another: bool) -> bool:
        """Lay out the panel's text: another one, or the chosen one with other values."""
        texts = self._workspace.painting.texts
        number = None if another else self._active
        base = LaidText()
        if number is not None and number < len(texts):
            base = texts[number]
        values = dict(values)
        fills = values.pop("fills", False) and not (another and texts) and not base.is_signature
        try:
            if fills:
                values = self._filling(values)
            laid = base.moved(**values)
        except Paint3DError as error:
            self._workspace.tell(say_error(error), state="bad")
            return False
        return self.may_drop() and self._put(laid, number)

    def layout_text(self, text: str, em_mm: float, columns: bool, font: str = "") -> bool:
        """Lay a text on the object as ghosts, in a font or as known characters.

        Returns
        -------
        bool
            Whether that succeeded.
        """
        order = "columns" if columns else "row"
        return self.ask({"text": text, "em_mm": em_mm, "order": order, "font": font}, False)

    def change(self, values: Mapping[str, Any]) -> None:
        """Give the chosen text other values: its size, position, turn, distances, grid.

        One that fills the sheet is composed anew where its order changes.
        """
        if not _BY_ITSELF.isdisjoint(values):
            self._panel.fill_box.setChecked(False)
        chosen = self.chosen_text()
        if chosen is None:
            return
        laid = chosen.laid
        if not values.keys() <= _BREAK_ANEW and "\n" not in laid.text and chosen.book.lines:
            laid = laid.moved(text=chosen.book.lines)  # it breaks where it did before
        try:
            if "order" in values and self._panel.fills and not laid.is_signature:
                values = self._filling({"text": laid.text, **values})
            laid = laid.moved(**values)
            if laid.around:  # it lies level
                laid = laid.moved(turn=0.0)
        except Paint3DError as error:
            self._workspace.tell(say_error(error), state="bad")
            return
        if self._active is not None:
            moves = values.keys() <= _MOVES
            if not self._put(laid, self._active, quiet=_CHOICES.isdisjoint(values), moves=moves):
                self._show_active()
            return
        page = chosen.book.page
        assert page is not None, "it is loose"
        now = replace(self._laid, em_mm=laid.em_mm, layout=laid.layout, note="")
        self._lay(lambda: page, now)

    def nudge(self, right: float, up: float) -> None:
        """Move the chosen text, mm."""
        chosen = self.chosen_text()
        if chosen is not None:
            frame = chosen.book.block.frame
            moved = frame.origin + right * frame.x_axis + up * frame.y_axis
            point = self._workspace.hand.surface.find(moved[None]).points[0].tolist()
            self.change({"point": tuple(point)})

    def choose(self, number: int) -> None:
        """Choose a text by its number."""
        if 0 <= number < len(self._shown):
            self._active = number
            self._show_active()

    def _choose_at(self, point: AnyArray) -> bool:
        """Choose the text at a point (3,) of the object; return whether there is one."""
        books = [self._books.get(text) for text in self._shown]
        for number, book in enumerate([*books, self._loose]):
            if book is not None and _lies_in(book, point):
                self._active = number if number < len(books) else None
                self._show_active()
                return True
        return False

    def chosen_text(self) -> ChosenText | None:
        """Return the chosen text as it lies on the object; None without one."""
        if self._active is not None and self._active < len(self._shown):
            laid = self._shown[self._active]
            book = self._books.get(laid)
            if book is None:
                return None
            lines = book.lines.split("\n")
            n, longest = len(lines), max(map(len, lines))
            shape = (n, longest) if laid.order == "columns" else (longest, n)
            if not laid.text.strip():
                shape = laid.cells
            return ChosenText(laid, book, (1, 1) if book.page is not None else shape)
        if self._loose is None:
            return None
        layout = self._laid.layout
        laid = LaidText(em_mm=self._laid.em_mm, turn=layout.turn, point=layout.point)
        return ChosenText(laid, self._loose, (1, 1))

    def _show_moving(self, on: bool) -> None:
        self._panel.show_moving(on)
        action = self._workspace.actions["arrange_text"]
        with QtCore.QSignalBlocker(action):
            action.setChecked(on)

    # -- laying -----------------------------------------------------------------------------

    def _make(self, laid: LaidText, progress: Progress = lambda _: None) -> Copybook:
        """Make the copybook of a text on the open object, with its ghosts."""
        book = self._copybook_of(laid)
        for n, ghost in enumerate(book.ghosts):
            progress(_LAID + (1.0 - _LAID) * n / len(book.ghosts))
            _ = ghost.outlines, ghost.medians, ghost.frame  # computed here, beside the window
        _ = book.block
        return book

    def _copybook_of(self, laid: LaidText) -> Copybook:
        """Make the copybook of a text; its ghosts are not yet projected."""
        workspace = self._workspace
        return Copybook.of(workspace.painting.source, laid, workspace.settings.glyphs or None)

    def _put(
        self, laid: LaidText, number: int | None, *, quiet: bool = False, moves: bool = False
    ) -> bool:
        """Lay a text instead of one, or beside the others; return whether that succeeded.

        One that would fit at a smaller size is laid at that size if this is agreed to. One that
        moves breaks nowhere else than it did: without room for its one column it stays.
        """
        workspace = self._workspace
        texts = workspace.painting.texts
        if number is not None and number < len(texts) and texts[number] == laid:
            return True
        done = workspace.run(say("Lay out"), partial(self._make, laid))
        error = done.exception()
        if quiet and isinstance(error, Paint3DError):
            workspace.tell(say_error(error), state="bad")
            return False
        if isinstance(error, Paint3DError) and "smaller" in error.message.fields:
            smaller = error.message.fields["smaller"]
            question = say("The text does not fit there at {size}", size=say_length(laid.em_mm))
            accept = say("Lay out at {size}", size=say_length(smaller))
            if ask(workspace.window, question, accept=accept, warns=True) is Answer.AcceptRole:
                return self._put(laid.moved(em_mm=smaller), number)
            return False
        if not workspace.went_well(done):
            return False
        book: Copybook = done.result()
        old = None if number is None or number >= len(texts) else texts[number]
        before = None if old is None else self._books.get(old)
        if moves and before is not None and book.lines != before.lines:
            workspace.tell(say("There is no room for the text there; make it smaller"), state="bad")
            return False
        if old is not None and before is not None and old.moved(grid=laid.grid) == laid:
            book.go_on_from(before)
        else:
            laid = laid.moved(n_before=len(workspace.painting.strokes))
            book.begin_after(workspace.painting.strokes)
        self._books[laid] = book
        self._loose = None
        self._laid.unused = None
        index = number if number is not None and number < len(texts) else None
        self._coming = workspace.paint_thread.post("lay_text", laid.words(), index)
        self._active = len(texts) if index is None else index
        self._shown = (*texts[: self._active], laid, *texts[self._active + 1 :])
        self._show_active()
        if not moves:
            self._turn_to(book)
        notes = [self._fit_brush(laid, old)]
        needed = detail_or_size(laid.em_mm, workspace.painting.resolution)
        if needed is not None and laid.text.strip():
            notes.insert(0, say_coarse(laid.em_mm, *needed))
        note = say("; ").join(filter(None, notes))
        self._tell_fonts(book, note, "off" if needed is None else "bad")
        self.laid_out()
        return True

    def _turn_to(self, book: Copybook) -> None:
        """Turn the view to a text that has come to lie on the far side of the object."""
        hand, frames = self._workspace.hand, [square.chart.frame for square in book.squares]
        seen = turn_to_see(
            hand.open_camera, [one.origin for one in frames], [one.normal for one in frames]
        )
        if seen is not hand.open_camera:
            hand.look(seen)

    def _fit_brush(self, laid: LaidText, old: LaidText | None) -> str:
        """Choose a brush for a text that is new or of another size than before; return a note.

        None is chosen for a signature, which follows the text, nor if the brush in hand suits.
        """
        paint_thread, em_mm = self._workspace.paint_thread, laid.em_mm
        is_new = old is None or not old.text.strip() or old.em_mm != em_mm
        is_main = bool(laid.text.strip()) and not laid.is_signature
        if not is_new or not is_main or suits_size(paint_thread.brush, em_mm):
            for layouts, _, _ in self._fitted:
                if old in layouts:
                    layouts.add(laid)
            return ""
        brush = brush_for(em_mm)
        self._fitted.append(({laid}, paint_thread.brush, brush))
        paint_thread.post("set_brush", brush)
        return say(
            "The brush is now {brush}, for characters of {size}; undo takes it back",
            brush=say_brush(brush.name),
            size=say_length(em_mm),
        )

    def _tell_fonts(self, book: Copybook, note: str = "", state: str = "off") -> None:
        message = say("; ").join([*say_fonts(book.from_fonts), *filter(None, [note])])
        if message:
            self._workspace.tell(message, state=state)

    def _show_active(self) -> None:
        """Show the chosen text in the panel, and draw all."""
        chosen = self.chosen_text()
        book = None if chosen is None else chosen.book
        self._panel.show_texts([_title(text) for text in self._shown], self._active)
        self._panel.show_values(chosen.laid if chosen and self._active is not None else None)
        if book is not self._panel.copybook:
            self._panel.show_copybook(book)
        self._draw()

    def _sync(self) -> None:
        """Follow the painting's texts, which undo, redo and recovery change, too."""
        if self._coming is not None:
            if not self._coming.done():
                return
            self._coming = None
        if self._making is not None:
            if not self._making.done():
                return
            done, self._making = self._making, None
            self._take_made(done)
        texts = self._workspace.painting.texts
        missing = [text for text in texts if text not in self._books]
        if missing:
            self._making = Future()
            run = (self._make_all, missing, self._making)
            threading.Thread(target=run[0], args=run[1:], name="paint3d-texts", daemon=True).start()
        elif texts != self._shown:
            self._shown = texts
            self._restore_brush()
            if self._active is not None and self._active >= len(texts):
                self._active = len(texts) - 1 if texts else None
            if self._active is None and self._loose is None and texts:
                self._active = len(texts) - 1
            self._show_active()

    def _restore_brush(self) -> None:
        """Take back the brush from before a text that undo has removed, unless changed since."""
        paint_thread = self._workspace.paint_thread
        while self._fitted and self._fitted[-1][0].isdisjoint(self._shown):
            _, before, chosen = self._fitted.pop()
            if paint_thread.brush == chosen:
                paint_thread.post("set_brush", before)

    def _make_all(self, texts: Sequence[LaidText], done: Future[Any]) -> None:
        made: dict[LaidText, Copybook | Paint3DError] = {}
        for text in texts:
            try:
                made[text] = self._make(text)
            except Paint3DError as error:
                made[text] = error
        done.set_result(made)

    def _take_made(self, done: Future[Any]) -> None:
        strokes = self._workspace.painting.strokes
        for text, book in done.result().items():
            if isinstance(book, Copybook):
                book.begin_after(strokes[: text.n_before])
                self._books[text] = book
            else:
                self._books[text] = None
                self._workspace.tell(say_error(book), state="bad")

    def layout_file(self, file: str, em_mm: float) -> bool:
        """Lay out a drawing, strokes or a photographed sheet; return whether that succeeded."""
        laid = _TextLayout(em_mm, Layout(), file=Path(file))

        def composed() -> Composer:
            if file.lower().endswith(PHOTOGRAPH_SUFFIXES):
                sheet, laid.photographed = _read_photograph(Path(file))
                laid.note = say("; ").join(map(say, sheet.notes))
                return sheet.page
            page = open_page(file)
            if page.photograph is not None:
                try:
                    laid.photographed = _read_photograph_again(page, page.photograph)
                except Paint3DError as error:
                    laid.note = say("The strokes lie over their ink: {why}", why=say_error(error))
                    laid.state = "bad"
                else:
                    read = os.path.realpath(page.photograph.file)
                    laid.note = say("The strokes lie over the photograph {file}", file=read)
            return page

        return self.may_drop() and self._lay(composed, laid)

    def correct(self) -> None:
        """Show the strokes over their picture, and lay out the corrected ones instead."""
        copybook, laid, chosen = self._panel.copybook, self._laid, self.chosen_text()
        if copybook is None or copybook.page is None or chosen is None:
            return
        workspace, number = self._workspace, self._active
        if number is not None:  # a text in a font
            laid = _TextLayout(chosen.laid.em_mm, chosen.laid.layout)
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
            now = _TextLayout(laid.em_mm, laid.layout, laid.file, dialog.photographed)
            if not self._lay(lambda: corrected, now):
                workspace.tell(say("The corrections are kept; check the strokes again"))
            elif number is not None:  # they take the text's place
                self._remove(number)

    def may_drop(self) -> bool:
        """Return whether the page may be replaced or removed, or another painting opened.

        Asks the user where corrections do not lie on the object.
        """
        if self._laid.unused is None:
            return True
        message = say("Corrected strokes could not be laid out and are not saved")
        window = self._workspace.window
        return ask(window, message, destroy=say("Drop them"), warns=True) is Answer.DestructiveRole

    def _lay(self, compose: Callable[[], Composer], laid: _TextLayout) -> bool:
        """Lay a page on the object, instead of the chosen text."""
        workspace = self._workspace
        mesh = workspace.painting.source

        def make(_: object) -> Copybook:
            copybook = Copybook(mesh, compose(), laid.em_mm, laid.layout)
            for ghost in copybook.ghosts:
                _ = ghost.outlines, ghost.medians, ghost.frame  # computed here, beside the window
            return copybook

        done = workspace.run(say("Lay out"), make)
        if not workspace.went_well(done):
            return False
        self._loose, self._laid, self._active = done.result(), laid, None
        self._loose.begin_after(workspace.painting.strokes)
        self._show_active()
        self._tell_fonts(self._loose, laid.note, laid.state)
        return True

    def hide(self) -> None:
        """Remove the chosen text."""
        if not self.may_drop():
            return
        self._laid.unused = None
        number = self._active
        if number is None:
            self._loose = None
        elif number < len(self._shown):
            self._remove(number)
        count = len(self._shown)
        self._active = min(number or 0, count - 1) if count else None
        self._show_active()

    def _remove(self, number: int) -> None:
        self._coming = self._workspace.paint_thread.post("remove_text", number)
        self._shown = self._shown[:number] + self._shown[number + 1 :]

    def _begin_anew(self, opened: OpenResult) -> None:
        """Forget the texts of the painting before; a text fills its sheet again."""
        self._laid = _TextLayout(40.0, Layout())
        self._books, self._shown, self._loose = {}, (), None
        self._active = self._coming = self._making = self._claimed = None
        self._counting = self._counted = None
        self._fitted = []
        self._panel.show_texts([], None)
        self._panel.begin_anew(on_sheet=sheet_of(opened.surface.mesh) is not None)

    def follow(self) -> None:
        """Take the judgements of strokes, and the texts that the painting has now."""
        self._sync()
        self._count()
        claimed, self._claimed = self._claimed, None
        if claimed is not None and claimed != self._active:
            self.choose(claimed)
        panel, copybook = self._panel, self._panel.copybook
        if panel.follow() and copybook is not None:
            self._draw()
            following = copybook.next  # the character before it was judged now
            last = (len(copybook.ghosts) if following is None else following) - 1
            for index, ghost in enumerate(copybook.ghosts):
                percent = panel.percent(index)
                if percent is not None and index == last:
                    message = say(
                        "{character}: {percent:.0f} %", character=ghost.text, percent=percent
                    )
                    self._workspace.tell(message, state="good")

    def _count(self) -> None:
        """Count strokes for the characters that they wrote, whoever painted them."""
        if self._counting is not None:
            if not self._counting.done():
                return
            done, self._counting = self._counting, None
            if not done.cancelled() and done.exception() is None and done.result():
                self._panel.show_counts()
                self._draw()
        books = [book for _, book in self._all_books()]
        paint_thread = self._workspace.stage.paint_thread
        if not books or paint_thread is None:
            return
        strokes = paint_thread.painting.strokes
        so_far = paint_thread.n_painted // _SOME
        state = [*map(id, books)], len(strokes), id(strokes[-1]) if strokes else 0, so_far
        if state == self._counted:
            return
        self._counted = state

        def count(document: Document) -> bool:
            before = [len(ghost.strokes) for book in books for ghost in book.ghosts]
            for book in books:
                book.follow(document.strokes, document.current_stroke)
            return before != [len(ghost.strokes) for book in books for ghost in book.ghosts]

        self._counting = paint_thread.post(count)

    def _all_books(self) -> list[tuple[int | None, Copybook]]:
        """Return all copybooks that lie on the object, with the numbers of their texts."""
        books: list[tuple[int | None, Copybook]] = [
            (number, book)
            for number, text in enumerate(self._shown)
            if (book := self._books.get(text)) is not None
        ]
        return books if self._loose is None else [*books, (None, self._loose)]

    def _judge(self, ended: Future[Stroke | None]) -> None:
        books = self._all_books()
        if not books:
            return
        active = self._active
        books.sort(key=lambda one: one[0] != active)  # of two that lie there the chosen one

        def note(document: Document) -> object:
            for _, book in books:
                book.follow(document.strokes)
            stroke = ended.result()  # it was done before; None where a layer refused it
            if stroke is None:
                return None
            for number, book in books:
                score = book.note(stroke, document.surface)
                if score is not None:
                    self._claimed = number
                    return score
            return None

        self._panel.expect(self._workspace.paint_thread.post(note))

    def _draw(self) -> None:
        stage = self._workspace.stage
        if stage.paint_thread is None:
            return
        chosen = self._panel.copybook
        books = [(text, self._books.get(text)) for text in self._shown]
        left = [g for _, book in self._all_books() for g in book.ghosts if not g.is_written]
        following = chosen.next if chosen is not None else None
        current = [chosen.ghosts[following]] if chosen is not None and following is not None else []
        waiting = [ghost for ghost in left if not any(ghost is one for one in current)]
        frames = [
            line
            for text, book in books
            if book is not None
            for line in book.grid(text.grid, text.order == "columns", unwritten=True)
        ]
        if self._loose is not None:
            frames += [ghost.frame for ghost in self._loose.ghosts if not ghost.is_written]
        stage.show_lines("ghost frames", frames, _FRAME, 1.0)
        stage.show_lines("ghosts", [line for g in waiting for line in g.outlines], _OUTLINE, 1.4)
        stage.show_lines("next ghost", [line for g in current for line in g.outlines], _NEXT, 2.2)
        stage.show_lines("next way", [line for g in current for line in g.medians], _MEDIAN, 1.2)


def _title(text: LaidText) -> str:
    """Return a text's name in a list."""
    words = " ".join(text.text.split())
    if not words:
        return say("Grid of {across} × {down}", across=text.cells[0], down=text.cells[1])
    return words if len(words) <= _LONGEST_TITLE else words[: _LONGEST_TITLE - 1] + "…"


def _lies_in(book: Copybook, point: AnyArray) -> bool:
    """Return whether a point (3,) lies within a copybook's block."""
    frame, corners = book.block.frame, book.block.corners
    axes = np.stack([frame.x_axis, frame.y_axis], axis=1)
    across = (point - frame.origin) @ axes
    flat = (corners - frame.origin) @ axes
    near = bool(((across >= flat.min(axis=0)) & (across <= flat.max(axis=0))).all())
    reach = float(np.linalg.norm(corners - frame.origin, axis=1).max())
    return near and abs(float((point - frame.origin) @ frame.normal)) <= reach


def signer_in(line: str) -> str:
    """Return the name in a signature, without its date and its verb."""
    return _DATED.sub("", line, count=1).strip(_SIGNED)


def date_line(day: datetime.date, signer: str = "") -> str:
    """Return a year of the sixty, its season and a name, as signatures give a date.

    Both begin with 立春, the 4th of February: January belongs to the winter before.
    """
    months = 12 * day.year + day.month - 2  # since a February; seasons begin within a week of 1st
    year = months // 12 - 4
    season = "春夏秋冬"[months % 12 // 3]
    return f"{_STEMS[year % 10]}{_BRANCHES[year % 12]}年{season}{signer}書"


def _read_photograph(file: Path) -> tuple[CopiedSheet, Photographed]:
    """Read a photograph and its strokes; one in which no sheet stands out is taken whole."""
    from paint3d.calligraphy.photo.copying import Asked, copy_sheet

    pixels, scale = load_photograph(file)
    sheet = copy_sheet(pixels, file.name, Asked(or_whole=True)).taken_from(file, scale)
    return sheet, Photographed(pixels, sheet, _reader(file, pixels, scale, invert=False))


def _read_photograph_again(page: Page, there: Photograph) -> Photographed:
    """Read the photograph that the strokes of a file are from, laid flat as it was then.

    Its path comes from the file of strokes, so that only a file named as a picture is read.
    """
    from paint3d.calligraphy.photo.copying import find_photographed_sheet

    if not there.file.name.lower().endswith(PHOTOGRAPH_SUFFIXES):
        raise InputError("{file}: not named as a picture; expected a photograph", file=there.file)
    pixels, scale = load_photograph(there.file)  # refuses what is no file
    if there.digest not in ("", digest_of(there.file)):
        raise InputError(
            "{file}: another picture than the strokes were found in; expected that one there",
            file=there.file,
        )
    sheet = find_photographed_sheet(page, pixels, scale)
    return Photographed(pixels, sheet, _reader(there.file, pixels, scale, invert=there.invert))


def _reader(
    file: Path, pixels: NDArray[np.uint8], scale: float, *, invert: bool
) -> Callable[[NDArray[np.float64]], SheetPicture]:
    """Return a function that reads the strokes again from a sheet of other corners."""
    from paint3d.calligraphy.photo.copying import Asked, copy_sheet

    def find(corners: NDArray[np.float64]) -> SheetPicture:
        sheet = copy_sheet(pixels, file.name, Asked(corners, invert=invert))
        return sheet.taken_from(file, scale, invert=invert)

    return find
