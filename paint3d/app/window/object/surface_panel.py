"""The surface: its material, its resolution, whether ink runs on it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.frame import Snapshot
from paint3d.app.window.object.material_box import MaterialBox
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say, say_length, say_material
from paint3d.colour.materials import Material, load_materials
from paint3d.colour.spectra import srgb_from_reflectance
from paint3d.errors import Message

__all__ = ["SurfacePanel"]

_SWATCH = 44
_NUMBERS = (
    ("absorbency", Message("Absorbency")),
    ("grain", Message("Grain")),
    ("coat", Message("Glaze")),
    ("friction", Message("Friction")),
)


class SurfacePanel(QtWidgets.QWidget):
    """The object's material, and commands for the whole object.

    Parameters
    ----------
    actions : iterable of QAction
        Shown as buttons.

    Signals
    -------
    asked : str or Material
        The object is to be of this material.
    failed : str
        A file of a material cannot be used: why.
    """

    asked = QtCore.Signal(object)
    failed = QtCore.Signal(str)

    def __init__(self, actions: Iterable[QtGui.QAction]) -> None:
        super().__init__()
        self._shown: tuple[Any, ...] = ()
        self.swatch = QtWidgets.QLabel()
        self.name = QtWidgets.QLabel()
        self.name.setObjectName("title")
        self.fineness = QtWidgets.QLabel()
        self.fineness.setObjectName("faint")
        self.fineness.setWordWrap(True)
        self._numbers: dict[str, QtWidgets.QLabel] = {}
        head = QtWidgets.QHBoxLayout()
        head.addWidget(self.swatch)
        words = QtWidgets.QVBoxLayout()
        words.addWidget(self.name)
        words.addWidget(self.fineness)
        head.addLayout(words, 1)
        form = QtWidgets.QFormLayout()
        self.material = MaterialBox(next(iter(load_materials())))
        self.material.chosen.connect(self._chosen)
        self.material.failed.connect(self.failed)
        form.addRow(say("Material"), self.material)
        for key, text in _NUMBERS:
            number = self._numbers[key] = QtWidgets.QLabel()
            number.setAlignment(QtCore.Qt.AlignmentFlag.AlignRight)
            form.addRow(say(text), number)
        layout = QtWidgets.QVBoxLayout(self)
        layout.setContentsMargins(10, 8, 10, 8)
        layout.addLayout(head)
        layout.addLayout(form)
        for action in actions:
            button = QtWidgets.QToolButton()
            button.setDefaultAction(action)
            button.setToolButtonStyle(QtCore.Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            button.setSizePolicy(
                QtWidgets.QSizePolicy.Policy.Expanding, QtWidgets.QSizePolicy.Policy.Fixed
            )
            layout.addWidget(button)
        layout.addStretch(1)

    def show_surface(self, surface: Snapshot) -> None:
        """Show a surface's material and resolution."""
        message = surface.material, surface.resolution, surface.n_vertices
        if message == self._shown:
            return
        self._shown = message
        material = surface.material
        self.name.setText(say_material(material))
        self.setToolTip("\n".join(filter(None, (material.basis, material.note))))
        is_known = material.name in load_materials()
        self.material.show_material(material.name if is_known else material)
        fine = "" if surface.resolution is None else f"{say_length(surface.resolution)}  ·  "
        self.fineness.setText(fine + say("{count:,} vertices", count=surface.n_vertices))
        for key, number in self._numbers.items():
            number.setText(f"{100 * getattr(material, key):.0f} %")
        red, green, blue = (int(code) for code in srgb_from_reflectance(material.reflectance))
        pixels = QtGui.QPixmap(_SWATCH, _SWATCH)
        pixels.fill(QtGui.QColor(red, green, blue))
        self.swatch.setPixmap(pixels)

    def _chosen(self, material: str | Material) -> None:
        """Emit the material; the panel shows it once the object has it."""
        self._shown = ()
        self.asked.emit(material)

    def show_unit(self) -> None:
        """Show lengths in the chosen unit, the next time."""
        self._shown = ()

    def set_theme(self, theme: Theme) -> None:
        """Do nothing: the panel has no drawings of its own."""
