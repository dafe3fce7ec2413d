"""Orientation, size and material of the user's own object: asked when it is opened, and later."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.model.own_object import (
    ObjectChoice,
    first_choice,
    is_implausible,
    longest_side,
    sensible_resolution,
)
from paint3d.app.window.files.open_result import OpenResult, open_with_progress
from paint3d.app.window.job import JobProgress
from paint3d.app.window.object.material_box import MaterialBox
from paint3d.app.window.questions import Answer, ask
from paint3d.app.window.wording import say, say_units
from paint3d.app.window.workspace import Workspace
from paint3d.colour.materials import Material
from paint3d.errors import Message
from paint3d.files.load import UNITS_MM, is_built_in
from paint3d.files.reading import Reading
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.mesh.upright import UP_AXES, stand_on, turn_up
from paint3d.view.preview import Preview

__all__ = [
    "ObjectDialog",
    "Standing",
    "format_length",
]

# ---- The dialog ----------------------------------------------------------------------------------


_PICTURE, _SMALL = 300, 84  # pixels
_QUARTERS = {
    "x": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "y": np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
    "z": np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]),
}


def format_length(size_mm: float) -> str:
    """Format a length in a unit that suits it."""
    for unit, mm in (("m", 1000.0), ("cm", 10.0)):
        if size_mm >= mm * 1.5:
            return f"{size_mm / mm:.3g} {unit}"
    return f"{size_mm:.3g} mm"


class ObjectDialog(QtWidgets.QDialog):
    """Ask how an object should stand, how large it is, and what it is made of.

    Parameters
    ----------
    parent : QWidget
    reading : Reading
        The object, and what its file says.
    material : str or Material
        Of its surface.
    resolution : float
        mm.
    title, accept : str
        Words for the window and the button that agrees.
    is_open : bool
        Whether it is open already: its unit is known, and how it stands.
    """

    def __init__(
        self,
        parent: QtWidgets.QWidget,
        reading: Reading,
        material: str | Material,
        resolution: float,
        *,
        title: str,
        accept: str,
        is_open: bool = False,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(title)
        self._mesh, self._unit_mm = reading.mesh, reading.unit_mm
        self._wanted = resolution
        self._turned = turn_up(reading.up)  # by who read it
        self._guess = reading.likely_up
        start = first_choice(reading, self._guess, material, resolution)
        self._likely = self._likely_axis(reading, is_open)
        self._turn, self._scale = start.turn, start.scale
        self._seen = Preview(reading.mesh, _PICTURE)
        self._plain = self._seen.plain()
        self.unit = QtWidgets.QComboBox()
        self.length = QtWidgets.QDoubleSpinBox()
        self.material = MaterialBox(material)
        self.resolution = QtWidgets.QDoubleSpinBox()
        self.colours = QtWidgets.QCheckBox(say("Keep its own colours and pictures"))
        self._resolution_chosen = False
        self._lay_out(reading, start, accept, is_open)
        self._show()

    def chosen(self) -> ObjectChoice:
        """Return the current choice."""
        coloured = self.colours.isChecked() or self._mesh.colours is None
        return ObjectChoice(
            self._turn, self._scale, self.material.material(), self.resolution.value(), coloured
        )

    # -- layout -----------------------------------------------------------------------------

    def _lay_out(self, reading: Reading, start: ObjectChoice, accept: str, is_open: bool) -> None:
        both = QtWidgets.QHBoxLayout(self)
        both.setContentsMargins(18, 16, 18, 14)
        both.setSpacing(18)
        left, right = QtWidgets.QVBoxLayout(), QtWidgets.QVBoxLayout()
        both.addLayout(left)
        both.addLayout(right, 1)
        self.picture = _Picture()
        self.picture.clicked.connect(self.stand_at)
        self.picture.setToolTip(say("Click the side it should stand on"))
        left.addWidget(self.picture)
        row = QtWidgets.QHBoxLayout()
        self.quarters: dict[str, QtWidgets.QPushButton] = {}
        for axis, word in (
            ("z", say("Turn round")),
            ("x", say("Tip forward")),
            ("y", say("Tip aside")),
        ):
            button = QtWidgets.QPushButton(word)
            button.setToolTip(say("A quarter turn about {axis}", axis=axis))
            button.setAutoDefault(False)
            button.clicked.connect(lambda _=False, axis=axis: self.turn_quarter(axis))
            self.quarters[axis] = button
            row.addWidget(button)
        left.addLayout(row)
        hint = QtWidgets.QLabel(say("Click the side it should stand on"))
        hint.setEnabled(False)
        left.addWidget(hint)
        left.addStretch(1)
        right.addWidget(self._heading(reading.up, is_open))
        right.addLayout(self._ways())
        right.addLayout(self._form(start, not is_open))
        self.notes = QtWidgets.QLabel("\n".join(map(_note_text, reading.notes)))
        self.notes.setWordWrap(True)
        self.notes.setVisible(bool(reading.notes))
        right.addWidget(self.notes)
        right.addStretch(1)
        standard = QtWidgets.QDialogButtonBox.StandardButton
        buttons = QtWidgets.QDialogButtonBox(standard.Ok | standard.Cancel)
        buttons.button(standard.Ok).setText(accept)
        buttons.button(standard.Ok).setDefault(True)
        buttons.button(standard.Cancel).setText(say("Cancel"))
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        right.addWidget(buttons)
        buttons.button(standard.Ok).setFocus()

    def _likely_axis(self, reading: Reading, is_open: bool) -> str | None:
        """Return the file's axis that is likely up; None if it is known and the shape agrees."""
        guess = self._guess
        if guess is None:
            if is_open or not reading.is_oddly_up:
                return None
            guess = reading.up_by_shape
        up = turn_up(guess.up)[2]
        return next(axis for axis in UP_AXES if np.array_equal(self._turn_for(axis)[2], up))

    def _heading(self, up: str, is_open: bool) -> QtWidgets.QLabel:
        guess = self._guess
        if is_open:
            text = say("This is how it stands now")
        elif guess is None and self._likely is not None:
            text = say(
                "The file says {axis} is up, its shape says {likely}", axis=up, likely=self._likely
            )
        elif guess is None:
            text = say("The file says which way is up")
        elif guess.sure:
            text = say("It would stand like this. Is that right?")
        else:
            text = say("Which way is up? The file does not say")
        head = QtWidgets.QLabel(text)
        head.setObjectName("title")
        return head

    def _ways(self) -> QtWidgets.QGridLayout:
        """Make a button with a picture for each axis that may point up."""
        grid = QtWidgets.QGridLayout()
        grid.setSpacing(6)
        preview = self._seen.smaller(_SMALL)
        self.ways: dict[str, QtWidgets.QToolButton] = {}
        for k, up in enumerate(UP_AXES):
            button = QtWidgets.QToolButton()
            button.setCheckable(True)
            button.setIcon(QtGui.QIcon(_pixmap(preview.draw(self._turn_for(up)))))
            button.setIconSize(QtCore.QSize(_SMALL, _SMALL))
            button.setToolButtonStyle(QtCore.Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
            text = say("{axis} up", axis=up)
            button.setText(f"{text} ({say('likely')})" if up == self._likely else text)
            button.clicked.connect(lambda _=False, up=up: self.stand_up(up))
            self.ways[up] = button
            grid.addWidget(button, k // 3, k % 3)
        return grid

    def _form(self, start: ObjectChoice, has_unit: bool) -> QtWidgets.QFormLayout:
        form = QtWidgets.QFormLayout()
        form.setVerticalSpacing(8)
        self.length.setRange(0.01, 1e6)
        self.length.setDecimals(2)
        self.length.setSuffix(" mm")
        self.length.setKeyboardTracking(False)
        self.length.valueChanged.connect(self._length_changed)
        if has_unit:
            for unit, words in say_units().items():
                self.unit.addItem("", unit)
                size = longest_side(self._mesh) * UNITS_MM[unit] / self._unit_mm
                self.unit.setItemText(self.unit.count() - 1, f"{words}   ({format_length(size)})")
            now = self._unit_mm * start.scale
            at = [k for k, mm in enumerate(UNITS_MM.values()) if math.isclose(mm, now)]
            self.unit.setCurrentIndex(at[0] if at else -1)
            self.unit.activated.connect(self._unit_changed)
            form.addRow(say("One unit of the file"), self.unit)
        form.addRow(say("Longest side"), self.length)
        self.material.failed.connect(lambda why: ask(self, why, accept=say("OK"), leave=""))
        form.addRow(say("Material"), self.material)
        self.resolution.setRange(0.05, 50.0)
        self.resolution.setSingleStep(0.05)
        self.resolution.setSuffix(" mm")
        self.resolution.setValue(start.resolution)
        self.resolution.valueChanged.connect(self._resolution_changed)
        form.addRow(say("Detail"), self.resolution)
        if self._mesh.colours is not None:
            self.colours.setChecked(True)
            self.colours.toggled.connect(self._show)
            form.addRow("", self.colours)
        return form

    # -- choosing ---------------------------------------------------------------------------

    def stand_up(self, up: str) -> None:
        """Stand it with an axis of its own up."""
        self._turn = self._turn_for(up)
        self._show()

    def _turn_for(self, up: str) -> NDArray[np.float64]:
        """Return the rotation that brings an axis of the file up, after its reader's own."""
        return turn_up(up) @ self._turned.T

    def turn_quarter(self, axis: str) -> None:
        """Turn it by 90 degrees about an axis of the room."""
        self._turn = _QUARTERS[axis] @ self._turn
        self._show()

    def stand_at(self, across: float, down: float) -> None:
        """Stand it on the side that is seen at a point of the picture, 0 to 1 each."""
        side = self._preview().side_at(self._turn, across, down)
        if side is not None:
            self._turn = _snap_rotation(stand_on(self._turn @ side) @ self._turn)
            self._show()

    def _preview(self) -> Preview:
        return self._seen if self.colours.isChecked() else self._plain

    def _show(self, *_: object) -> None:
        """Show the current choice."""
        self.picture.setPixmap(_pixmap(self._preview().draw(self._turn)))
        for up, button in self.ways.items():
            button.setChecked(np.array_equal(self._turn_for(up)[2], self._turn[2]))
        with QtCore.QSignalBlocker(self.length):
            self.length.setValue(longest_side(self._mesh) * self._scale)
        if not self._resolution_chosen:
            area = self._mesh.area * self._scale**2
            with QtCore.QSignalBlocker(self.resolution):
                self.resolution.setValue(sensible_resolution(area, self._wanted))

    def _unit_changed(self, _: int) -> None:
        self._scale = UNITS_MM[self.unit.currentData()] / self._unit_mm
        self._show()

    def _length_changed(self, length: float) -> None:
        self._scale = length / longest_side(self._mesh)
        self.unit.setCurrentIndex(-1)
        self._show()

    def _resolution_changed(self, _: float) -> None:
        self._resolution_chosen = True


class _Picture(QtWidgets.QLabel):
    """A picture that emits where it was clicked."""

    clicked = QtCore.Signal(float, float)

    def __init__(self) -> None:
        super().__init__()
        self.setFixedSize(_PICTURE, _PICTURE)
        self.setCursor(QtCore.Qt.CursorShape.PointingHandCursor)

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:
        """Emit where it was pressed, 0 to 1 each."""
        position = event.position()
        self.clicked.emit(position.x() / self.width(), position.y() / self.height())


def _pixmap(pixels: NDArray[np.uint8]) -> QtGui.QPixmap:
    height, width = pixels.shape[:2]
    form = QtGui.QImage.Format.Format_RGB888
    return QtGui.QPixmap.fromImage(QtGui.QImage(pixels.data, width, height, 3 * width, form))


def _snap_rotation(turn: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a rotation without rounding errors; one by quarter turns becomes exact."""
    u, _, v = np.linalg.svd(turn)
    rotation = u @ v
    whole = np.rint(rotation)
    result: NDArray[np.float64] = whole if np.abs(rotation - whole).max() < 1e-9 else rotation
    return result


def _note_text(note: Message) -> str:
    """Return a reader's note as a sentence."""
    words = say(note)
    return words[:1].upper() + words[1:]


# ---- The work ------------------------------------------------------------------------------------


def _is_bare(document: Document) -> bool:
    return not document.strokes and not document.surface.painted.any()


class Standing:
    """Asks for the orientation and size of objects, for one window.

    Parameters
    ----------
    workspace : Workspace
    may_leave : callable
        Asks whether the open painting may be left.
    """

    def __init__(self, workspace: Workspace, may_leave: Callable[[], bool]) -> None:
        self._workspace, self._may_leave = workspace, may_leave
        self._assumptions = ""

    def choose(
        self, path: str, reading: Reading, material: str, resolution: float, *, ask: bool = True
    ) -> ObjectChoice | None:
        """Choose the orientation and size of an object that was read; None: it is not to be opened.

        Parameters
        ----------
        path : str
        reading : Reading
        material : str
            Proposed for the surface.
        resolution : float
            Wanted, mm.
        ask : bool
            Whether the user is asked. If not, what is likely is assumed and shown, and the user is
            asked only where the unit cannot be right.
        """
        self._assumptions = ""
        if is_built_in(path):
            return ObjectChoice(np.eye(3), 1.0, material, resolution)
        if not ask and not is_implausible(longest_side(reading.mesh)):
            return self._likely(reading, material, resolution)
        name = Path(path).name
        dialog = ObjectDialog(
            self._workspace.window,
            reading,
            material,
            resolution,
            title=name,
            accept=say("Open…").rstrip("…"),
        )
        return self._answer(dialog)

    def report_assumptions(self) -> None:
        """Show what was assumed without asking."""
        if self._assumptions:
            self._workspace.tell(self._assumptions)

    def _likely(self, reading: Reading, material: str, resolution: float) -> ObjectChoice:
        guess = reading.likely_up
        notes = [*map(_note_text, reading.notes)]
        if guess is not None and not guess.sure:
            notes.append(
                say("Which way is up is uncertain; change it by Edit ▸ Turn and scale the object")
            )
        elif reading.is_oddly_up:
            notes.append(
                say(
                    "{axis} was taken as up; change it by Edit ▸ Turn and scale the object",
                    axis=reading.up if guess is None else guess.up,
                )
            )
        self._assumptions = "   ".join(notes)
        return first_choice(reading, guess, material, resolution)._replace(resolution=resolution)

    def _answer(self, dialog: ObjectDialog) -> ObjectChoice | None:
        accepted = dialog.exec()
        choice = dialog.chosen() if accepted else None
        if choice is not None:
            self._remember_material(choice.material)
        dialog.deleteLater()
        return choice

    def _remember_material(self, material: str | Material) -> None:
        """Begin with this material the next time, if it has a name by which it is found."""
        if isinstance(material, str):
            self._workspace.update_settings(material=material)

    # -- turning what is open ---------------------------------------------------------------

    def do_stand(self) -> None:
        """Ask how the object that is open should stand, and begin anew on it."""
        workspace = self._workspace
        if workspace.stage.paint_thread is None:
            return
        with workspace.paint_thread.paused() as document:
            assert document is not None, "it was waited for"
            surface, material = document.surface, document.surface.material
            resolution = surface.resolution or workspace.settings.resolution_mm
            is_bare = _is_bare(document)
        turned = say(
            "Turning the object starts a new painting on it, without the paint. You can save this "
            "one first."
        )
        if not is_bare and not self._may_begin_anew(turned):
            return
        reading = Reading(surface.source, knows_up=True)
        dialog = ObjectDialog(
            workspace.window, reading, material, resolution,
            title=say("Turn and scale the object…").rstrip("…"),
            accept=say("OK") if is_bare else say("Begin anew"), is_open=True,
        )  # fmt: skip
        choice = self._answer(dialog)
        if choice is not None and (is_bare or self._may_leave()):
            self._begin_anew(surface.source, choice)

    def take_material(self, material: str | Material) -> bool:
        """Begin anew on the open object in another material; return whether that was done."""
        workspace = self._workspace
        if workspace.stage.paint_thread is None:
            return False
        with workspace.paint_thread.paused() as document:
            assert document is not None, "it was waited for"
            surface, is_bare = document.surface, _is_bare(document)
            resolution = surface.resolution or workspace.settings.resolution_mm
        words = say(
            "Another material starts a new painting, without the paint. You can save this one "
            "first."
        )
        if not is_bare and not (self._may_begin_anew(words) and self._may_leave()):
            return False
        choice = ObjectChoice(np.eye(3), 1.0, material, resolution)
        if not self._begin_anew(surface.source, choice):
            return False
        self._remember_material(material)
        return True

    def _begin_anew(self, source: TriangleMesh, choice: ObjectChoice) -> bool:
        """Open an object as chosen instead of the current one, with the same brush and inks."""
        workspace = self._workspace
        with workspace.paint_thread.paused() as document:
            assert document is not None, "it was waited for"
            brush, inks = document.painter.brush, list(document.inks)

        def make(progress: JobProgress) -> OpenResult:
            document = Document.new(
                choice.apply(source), choice.resolution, choice.material, brush=brush, ink=inks[0],
                undo_bytes=int(workspace.settings.undo_megabytes * (1 << 20)),
            )  # fmt: skip
            document.inks[1] = inks[1]
            return open_with_progress(document, progress, 0.6)

        done = workspace.run(say("Opening {name}…", name=source.name), make)
        return bool(workspace.went_well(done) and workspace.show(done.result()))

    def _may_begin_anew(self, words: str) -> bool:
        answer = ask(self._workspace.window, words, accept=say("Begin anew"))
        return answer is Answer.AcceptRole
