"""The layers: which are seen, which are locked, and which one is painted on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.theme import Theme, make_icon
from paint3d.app.window.wording import say, say_layer
from paint3d.errors import Message
from paint3d.surface.layer_stack import BLENDS, Layer

__all__ = ["PICTURE", "LayerPanel"]

PICTURE = 28
"""Pixels along a side of a layer's picture."""
_ROW = 34
_SHEET = "#f2efe6"  # behind what is painted
_BLENDS = {"normal": Message("Normal"), "multiply": Message("Multiply")}


class LayerPanel(QtWidgets.QWidget):
    """A list of layers, the uppermost on top.

    Signals
    -------
    asked : (str, ...)
        A method of the document, and its arguments.
    """

    asked = QtCore.Signal(str, object, object)

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self._shown: tuple[Any, ...] = ()
        self._active = 0
        self._pictures: tuple[NDArray[np.uint8], ...] = ()
        self.list = QtWidgets.QListWidget()
        self.list.setObjectName("layers")
        self.list.setHorizontalScrollBarPolicy(QtCore.Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.itemClicked.connect(self._select)
        self.list.setAccessibleName(say("Layers"))
        self.opacity = QtWidgets.QSlider(QtCore.Qt.Orientation.Horizontal)
        self.opacity.setRange(0, 100)
        self.opacity.setPageStep(10)
        self.opacity.setToolTip(say("How much of the layer shows"))
        self.opacity.setAccessibleName(say("Opacity"))
        self.opacity.setTracking(False)  # a step of undo where it is let go
        self.opacity.sliderMoved.connect(self._tell_opacity)
        self.opacity.valueChanged.connect(self._set_opacity)
        self.percent = QtWidgets.QLabel()
        self.percent.setObjectName("faint")
        self.percent.setMinimumWidth(self.percent.fontMetrics().horizontalAdvance("100 %"))
        self.blend = QtWidgets.QComboBox()
        for kind in BLENDS:
            self.blend.addItem(say(_BLENDS[kind]), kind)
        self.blend.setToolTip(say("How the layer lies on those below it"))
        self.blend.setAccessibleName(say("Blend"))
        self.blend.activated.connect(self._set_blend)
        layout = QtWidgets.QVBoxLayout(self)
        layout.setContentsMargins(8, 6, 8, 8)
        looks = QtWidgets.QHBoxLayout()
        for widget, stretch in ((self.blend, 0), (self.opacity, 1), (self.percent, 0)):
            looks.addWidget(widget, stretch)
        layout.addLayout(looks)
        layout.addWidget(self.list, 1)
        row = QtWidgets.QHBoxLayout()
        self.buttons = {
            "plus": self._button(
                "plus", say("New layer"), lambda: self.asked.emit("add_layer", None, None)
            ),
            "copy": self._button("copy", say("Duplicate layer"), self._duplicate),
            "merge": self._button("merge", say("Merge with the layer below"), self._merge),
            "minus": self._button("minus", say("Remove layer"), self._remove),
            "up": self._button("up", say("Move up"), lambda: self._move(1)),
            "down": self._button("down", say("Move down"), lambda: self._move(-1)),
        }
        for button in self.buttons.values():
            row.addWidget(button)
        row.addStretch(1)
        layout.addLayout(row)

    def _button(self, icon: str, text: str, do: Callable[[], object]) -> QtWidgets.QToolButton:
        button = QtWidgets.QToolButton()
        button.setIcon(make_icon(icon, self._theme))
        button.setToolTip(text)
        button.setAccessibleName(text)
        button.clicked.connect(do)
        return button

    # -- showing ----------------------------------------------------------------------------

    def show_layers(self, layers: Sequence[Layer], active: int) -> None:
        """Show these layers, the lowest first, and which is painted on."""
        message = tuple(layers), active
        if message == self._shown:
            return
        self._shown, self._active = message, active
        self.list.clear()
        for place in reversed(range(len(layers))):
            item = QtWidgets.QListWidgetItem()
            item.setData(QtCore.Qt.ItemDataRole.UserRole, place)
            item.setSizeHint(QtCore.QSize(100, _ROW))
            self.list.addItem(item)
            self.list.setItemWidget(item, self._row(place, layers[place]))
            if place == active:
                self.list.setCurrentItem(item)
        self.buttons["minus"].setEnabled(len(layers) > 1)
        self.buttons["merge"].setEnabled(active > 0)
        self._show_look(layers[active])
        self.buttons["up"].setEnabled(active < len(layers) - 1)
        self.buttons["down"].setEnabled(active > 0)

    def show_pictures(self, pictures: Sequence[NDArray[np.uint8]]) -> None:
        """Show what is on each layer, (PICTURE, PICTURE, 4) uint8, the lowest first."""
        self._pictures = tuple(pictures)
        for row in range(self.list.count()):
            item = self.list.item(row)
            widget = self.list.itemWidget(item)
            label = widget.findChild(QtWidgets.QLabel, "thumbnail")
            if label is not None:
                self._show_picture(label, item.data(QtCore.Qt.ItemDataRole.UserRole))

    def _show_picture(self, label: QtWidgets.QLabel, place: int) -> None:
        sheet = QtGui.QPixmap(PICTURE, PICTURE)
        sheet.fill(QtGui.QColor(_SHEET))
        if place < len(self._pictures):
            pixels = np.ascontiguousarray(self._pictures[place])
            height, width = pixels.shape[:2]
            form = QtGui.QImage.Format.Format_RGBA8888
            painter = QtGui.QPainter(sheet)
            painter.drawImage(0, 0, QtGui.QImage(pixels.data, width, height, 4 * width, form))
            painter.end()
        label.setPixmap(sheet)

    def _show_look(self, layer: Layer) -> None:
        """Show how much of a layer shows, and how it lies on those below."""
        percent = round(100.0 * layer.opacity)
        with QtCore.QSignalBlocker(self.opacity):
            self.opacity.setValue(percent)
        self._tell_opacity(percent)
        self.blend.setCurrentIndex(self.blend.findData(layer.blend))

    def _tell_opacity(self, percent: int) -> None:
        self.percent.setText(f"{percent} %")

    def _row(self, place: int, layer: Layer) -> QtWidgets.QWidget:
        row = QtWidgets.QWidget()
        row.setAttribute(QtCore.Qt.WidgetAttribute.WA_StyledBackground)
        layout = QtWidgets.QHBoxLayout(row)
        layout.setContentsMargins(4, 0, 4, 0)
        layout.setSpacing(2)
        eye = self._button(
            "eye" if layer.visible else "hidden",
            say("Hide") if layer.visible else say("Show"),
            lambda: self.asked.emit("set_visible", place, not layer.visible),
        )
        lock = self._button(
            "lock" if layer.locked else "unlocked",
            say("Unlock") if layer.locked else say("Lock"),
            lambda: self.asked.emit("set_locked", place, not layer.locked),
        )
        picture = QtWidgets.QLabel()
        picture.setObjectName("thumbnail")
        picture.setFixedSize(PICTURE, PICTURE)
        self._show_picture(picture, place)
        name = QtWidgets.QLineEdit(say_layer(layer.name))
        name.setAccessibleName(say("Name of the layer"))
        name.setFrame(False)
        name.setStyleSheet("QLineEdit { background: transparent; border: none; }")
        name.setReadOnly(True)
        name.installEventFilter(self)
        name.setProperty("place", place)
        name.editingFinished.connect(lambda: self._renamed(place, name))
        layout.addWidget(eye)
        layout.addWidget(picture)
        layout.addWidget(name, 1)
        layout.addWidget(lock)
        return row

    def set_theme(self, theme: Theme) -> None:
        """Use other colours."""
        self._theme = theme
        for icon, button in self.buttons.items():
            button.setIcon(make_icon(icon, theme))
        self._shown = ()

    # -- being told -------------------------------------------------------------------------

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """A click on a name chooses the layer, a double click lets it be written anew."""
        kind = QtCore.QEvent.Type
        if isinstance(watched, QtWidgets.QLineEdit):
            if event.type() == kind.MouseButtonDblClick:
                watched.setReadOnly(False)
                watched.selectAll()
            elif event.type() == kind.MouseButtonPress and watched.isReadOnly():
                self.asked.emit("select_layer", watched.property("place"), None)
        return super().eventFilter(watched, event)

    def _renamed(self, place: int, name: QtWidgets.QLineEdit) -> None:
        if not name.isReadOnly() and name.text().strip():
            name.setReadOnly(True)
            self.asked.emit("rename_layer", place, name.text().strip())

    def rename(self) -> None:
        """Let the name of the layer that is painted on be written."""
        row = self.list.itemWidget(self.list.currentItem())
        name = row.findChild(QtWidgets.QLineEdit)
        assert name is not None, "every row has one"
        name.setReadOnly(False)
        name.setFocus()
        name.selectAll()

    def _select(self, item: QtWidgets.QListWidgetItem) -> None:
        self.asked.emit("select_layer", item.data(QtCore.Qt.ItemDataRole.UserRole), None)

    def _remove(self) -> None:
        self.asked.emit("remove_layer", self._active, None)

    def _duplicate(self) -> None:
        self.asked.emit("duplicate_layer", self._active, None)

    def _merge(self) -> None:
        self.asked.emit("merge_layer", self._active, None)

    def _set_opacity(self, percent: int) -> None:
        self._tell_opacity(percent)
        self.asked.emit("set_opacity", self._active, percent / 100.0)

    def _set_blend(self, _: int) -> None:
        self.asked.emit("set_blend", self._active, self.blend.currentData())

    def _move(self, by: int) -> None:
        self.asked.emit("move_layer", self._active, self._active + by)
