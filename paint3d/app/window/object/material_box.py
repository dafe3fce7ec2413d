"""A box to choose a surface's material: by name, or from a file."""

from __future__ import annotations

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.files.file_dialogs import ask_file
from paint3d.app.window.wording import say, say_error, say_material
from paint3d.colour.materials import Material, load_material, load_materials
from paint3d.errors import Paint3DError

__all__ = ["MaterialBox"]


class MaterialBox(QtWidgets.QComboBox):
    """The known materials, and a choice to open a file.

    Signals
    -------
    chosen : str or Material
        Another one was chosen, by hand.
    failed : str
        A file cannot be used: why. What was chosen before stays.
    """

    chosen = QtCore.Signal(object)
    failed = QtCore.Signal(str)

    def __init__(self, material: str | Material) -> None:
        super().__init__()
        self.setToolTip(say("What the surface is made of; files of your own can describe others"))
        self._before = 0
        for name, known in load_materials().items():
            self.addItem(say_material(known), name)
        self._own = self.count()  # row of one of the user's own
        self.addItem(say("From a file…"), None)
        self.activated.connect(self._activated)
        self.show_material(material)

    def show_material(self, material: str | Material) -> None:
        """Show the material: a name, a file's, or the material itself."""
        name = material.name if isinstance(material, Material) else material
        row = self.findData(name)
        if row < 0 or isinstance(self.itemData(row), Material):
            made_of = load_material(material) if isinstance(material, str) else material
            row = self._own
            self.insertItem(row, say_material(made_of), material)
            if self.count() > self._own + 2:
                self.removeItem(self._own + 1)
        self.setCurrentIndex(row)
        self._before = row

    def material(self) -> str | Material:
        """Return the choice: a name, a file's, or a material that has neither.

        While a file is asked for it is what was chosen before.
        """
        row = self.currentIndex()
        data: str | Material = self.itemData(self._before if self.itemData(row) is None else row)
        return data

    def wheelEvent(self, event: QtGui.QWheelEvent) -> None:
        """Leave the wheel to the panel around: it never chooses another material."""
        event.ignore()

    def _activated(self, row: int) -> None:
        if self.itemData(row) is not None:
            changed, self._before = row != self._before, row
            if changed:
                self.chosen.emit(self.material())
            return
        self.setCurrentIndex(self._before)
        words = f"{say('Materials')} (*.toml *.json)"
        path = ask_file(self.window(), say("From a file…").rstrip("…"), words)
        if not path:
            return
        try:
            load_material(path)
            self.show_material(path)
        except Paint3DError as error:
            self.failed.emit(say_error(error))
            return
        self.chosen.emit(path)
