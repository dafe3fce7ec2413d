"""The layers and their groups: hidden, locked, and the one that is painted on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.theme import Theme, make_icon
from paint3d.app.window.wording import say, say_group, say_layer
from paint3d.core.arrays import AnyArray
from paint3d.errors import Message
from paint3d.surface.layer_stack import BLENDS, Group, Layer, group_span
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["PICTURE", "LayerPanel", "layer_pictures"]

# ---- Steps ---------------------------------------------------------------------------------------
# A layer or a group moved one step up or down, into groups and out of them.


def layer_step(layers: Sequence[Layer], index: int, by: int) -> tuple[int, int] | None:
    """Return the arguments `to` and `within` of `Document.move_layer` for a step by 1 or -1.

    Before a group it goes into it, and at the end of its own it goes out of it, each by a step
    of its own. None where there is no way to go.
    """
    own, beside = layers[index].group, index + by
    if not 0 <= beside < len(layers):
        return None if own is None else (index, -1)
    other = layers[beside].group
    if own is not None:
        return (beside, index) if other == own else (index, -1)
    return (beside, -1) if other is None else (index, beside)


def group_step(layers: Sequence[Layer], index: int, by: int) -> int | None:
    """Return the index of a group's lowest layer after a step past a layer or a group."""
    first, last = group_span(layers, index)
    beside = last + 1 if by > 0 else first - 1
    if not 0 <= beside < len(layers):
        return None
    low, high = group_span(layers, beside)
    return first + by * (high - low + 1)


# ---- Pictures ------------------------------------------------------------------------------------
# The paint of each layer over the bare object, from the front or above.


_FLAT = 0.05  # thickness over length of what is seen from above
_MARGIN = 0.04  # of the picture, around the object


def layer_pictures(surface: PaintedSurface, size: int) -> list[NDArray[np.uint8]]:
    """Draw the paint of each layer.

    Parameters
    ----------
    surface : PaintedSurface
    size : int
        Pixels along a side.

    Returns
    -------
    list of (size, size, 4) uint8
        sRGB and density, the first row at the top; of the lowest layer first.
    """
    stack, glaze = surface.use_layers(), surface.glaze
    pictures = [np.zeros((size, size, 4), np.uint8) for _ in range(len(stack))]
    if glaze is None:
        return pictures
    vertices = surface.paint_mesh.vertices
    base = vertices[: surface.paint_mesh.n_base_vertices]
    low, high = base.min(axis=0), base.max(axis=0)
    extent = (high - low).astype(np.float64)
    down = 1 if extent[2] < _FLAT * extent.max() else 2  # which axis goes up in the picture
    scale = (1.0 - 2.0 * _MARGIN) * size / max(extent[0], extent[down], 1e-9)
    for k, picture in enumerate(pictures):
        ids, codes = stack.colours_alone(glaze, k)
        if len(ids):
            off = vertices[ids].astype(np.float64) - 0.5 * (low + high)
            column = np.clip(0.5 * size + scale * off[:, 0], 0, size - 1).astype(np.int64)
            row = np.clip(0.5 * size - scale * off[:, down], 0, size - 1).astype(np.int64)
            _fill_pixels(picture, row * size + column, codes)
    return pictures


def _fill_pixels(picture: NDArray[np.uint8], at: AnyArray, codes: AnyArray) -> None:
    """Give pixels (N,) the mean of the colours (N, 3) that fall on each."""
    size = picture.shape[0] * picture.shape[1]
    count = np.bincount(at, minlength=size)
    painted = count > 0
    flat = picture.reshape(size, 4)
    for channel in range(3):
        total = np.bincount(at, codes[:, channel].astype(np.float64), minlength=size)
        flat[painted, channel] = np.rint(total[painted] / count[painted])
    flat[painted, 3] = 255


# ---- The panel -----------------------------------------------------------------------------------


PICTURE = 28
"""Pixels along a side of a layer's picture."""
_ROW = 34
_INDENT = 14  # pixels of the rows of a group's layers
_INDEX, _GROUP = QtCore.Qt.ItemDataRole.UserRole, QtCore.Qt.ItemDataRole.UserRole + 1
_SHEET = "#f2efe6"  # behind what is painted
_BLENDS = {"normal": Message("Normal"), "multiply": Message("Multiply")}


class LayerPanel(QtWidgets.QWidget):
    """A list of layers, the uppermost on top; a group has a row above those of its layers.

    Slider, blend and buttons are for the layer that is painted on; after a click on the row of a
    group they are for the group, until a layer is clicked.

    Signals
    -------
    asked : (str, tuple)
        A method of the document, and its arguments.
    turned : (str, int, Layer)
        A property of a layer, or of its group, is to be toggled: a method of the document, and the
        index and the layer as they are shown.
    """

    asked = QtCore.Signal(str, object)
    turned = QtCore.Signal(str, int, object)

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self._shown: tuple[Any, ...] = ()
        self._layers: tuple[Layer, ...] = ()
        self._active = 0
        self._group = 0  # key of the one that was clicked; 0 for none
        self._pictures: tuple[NDArray[np.uint8], ...] = ()
        self.list = QtWidgets.QListWidget()
        self.list.setObjectName("layers")
        self.list.setHorizontalScrollBarPolicy(QtCore.Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.setSelectionMode(QtWidgets.QAbstractItemView.SelectionMode.ContiguousSelection)
        self.list.itemClicked.connect(self._select)
        self.list.setAccessibleName(say("Layers"))
        self.opacity = QtWidgets.QSlider(QtCore.Qt.Orientation.Horizontal)
        self.opacity.setRange(0, 100)
        self.opacity.setPageStep(10)
        self.opacity.setToolTip(say("How much of the layer shows"))
        self.opacity.setAccessibleName(say("Opacity"))
        self.opacity.setTracking(False)  # one step of undo, when the slider is released
        self.opacity.sliderMoved.connect(self._show_percent)
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
            "plus": self._button("plus", say("New layer"), lambda: self._ask("add_layer")),
            "group": self._button("group", say("Group layers"), self.group_or_ungroup),
            "copy": self._button("copy", say("Duplicate layer"), self.duplicate),
            "merge": self._button("merge", say("Merge with the layer below"), self._merge),
            "minus": self._button("minus", say("Remove layer"), self.remove),
            "up": self._button("up", say("Move up"), lambda: self.step(1)),
            "down": self._button("down", say("Move down"), lambda: self.step(-1)),
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
        if self._group and active != self._active:
            self._group = 0  # another one is painted on
        wanted = tuple(layers), active, self._group
        if wanted == self._shown:
            return
        self._layers, self._active = tuple(layers), active
        if self._group not in {layer.group.key for layer in layers if layer.group is not None}:
            self._group = 0
        self._shown = self._layers, active, self._group
        bar = self.list.verticalScrollBar()
        scrolled = bar.value()
        self.list.clear()
        for index in reversed(range(len(layers))):
            group = layers[index].group
            if group is not None and group_span(layers, index)[1] == index:
                self._add_row(self._group_row(index, group), index, group.key)
            if group is None or not group.folded:
                self._add_row(self._row(index, layers[index]), index, 0)
        bar.setValue(scrolled)
        self._show_choice()

    def _add_row(self, row: QtWidgets.QWidget, index: int, group: int) -> None:
        item = QtWidgets.QListWidgetItem()
        item.setData(_INDEX, index)
        item.setData(_GROUP, group)
        item.setSizeHint(QtCore.QSize(100, _ROW))
        self.list.addItem(item)
        self.list.setItemWidget(item, row)
        is_it = group == self._group if self._group else not group and index == self._active
        if is_it:
            self.list.setCurrentItem(item)

    def _show_choice(self) -> None:
        """Show a layer's or a group's values and texts; enable the buttons that can act."""
        layers, active, index = self._layers, self._active, self._chosen_index()
        group = layers[index].group
        at_group = self._group != 0
        first, last = group_span(layers, index)
        self._show_look(group if at_group and group is not None else layers[active])
        whole = at_group and last - first + 1 == len(layers)
        self.buttons["minus"].setEnabled(len(layers) > 1 and not whole)
        below = layers[active - 1].group if active else None
        self.buttons["merge"].setEnabled(
            not at_group and active > 0 and below == layers[active].group
        )
        for name, by in (("up", 1), ("down", -1)):
            step = group_step(layers, index, by) if at_group else layer_step(layers, active, by)
            self.buttons[name].setEnabled(step is not None)
        for name, layer_text, group_text in (
            ("group", say("Group layers"), say("Ungroup layers")),
            ("copy", say("Duplicate layer"), say("Duplicate group")),
            ("minus", say("Remove layer"), say("Remove group")),
        ):
            text = group_text if at_group else layer_text
            self.buttons[name].setToolTip(text)
            self.buttons[name].setAccessibleName(text)
        self.buttons["group"].setIcon(make_icon("ungroup" if at_group else "group", self._theme))

    def _chosen_index(self) -> int:
        """Return the index of the active layer, or of one in the group that was clicked."""
        own = (k for k, one in enumerate(self._layers) if one.group is not None
               and one.group.key == self._group)  # fmt: skip
        return next(own, self._active) if self._group else self._active

    def show_pictures(self, pictures: Sequence[NDArray[np.uint8]]) -> None:
        """Show the layers' pictures, (PICTURE, PICTURE, 4) uint8, the lowest first."""
        self._pictures = tuple(pictures)
        for row in range(self.list.count()):
            item = self.list.item(row)
            widget = self.list.itemWidget(item)
            label = widget.findChild(QtWidgets.QLabel, "thumbnail")
            if label is not None:
                self._show_picture(label, item.data(_INDEX))

    def _show_picture(self, label: QtWidgets.QLabel, index: int) -> None:
        sheet = QtGui.QPixmap(PICTURE, PICTURE)
        sheet.fill(QtGui.QColor(_SHEET))
        if index < len(self._pictures):
            pixels = np.ascontiguousarray(self._pictures[index])
            height, width = pixels.shape[:2]
            form = QtGui.QImage.Format.Format_RGBA8888
            painter = QtGui.QPainter(sheet)
            painter.drawImage(0, 0, QtGui.QImage(pixels.data, width, height, 4 * width, form))
            painter.end()
        label.setPixmap(sheet)

    def _show_look(self, layer: Layer | Group) -> None:
        """Show the opacity and the blend of a layer or a group."""
        percent = round(100.0 * layer.opacity)
        with QtCore.QSignalBlocker(self.opacity):
            self.opacity.setValue(percent)
        self._show_percent(percent)
        self.blend.setCurrentIndex(self.blend.findData(layer.blend))

    def _show_percent(self, percent: int) -> None:
        self.percent.setText(f"{percent} %")

    def _row(self, index: int, layer: Layer) -> QtWidgets.QWidget:
        row, layout = self._make_row(_INDENT if layer.group is not None else 0)
        eye = self._eye(layer.visible, "set_visible", index)
        lock = self._button(
            "lock" if layer.locked else "unlocked",
            say("Unlock") if layer.locked else say("Lock"),
            lambda: self._turn("set_locked", index),
        )
        picture = QtWidgets.QLabel()
        picture.setObjectName("thumbnail")
        picture.setFixedSize(PICTURE, PICTURE)
        self._show_picture(picture, index)
        name = self._name(say_layer(layer.name), say("Name of the layer"), index, 0)
        name.setEnabled(layer.is_seen)
        layout.addWidget(eye)
        layout.addWidget(picture)
        layout.addWidget(name, 1)
        layout.addWidget(lock)
        return row

    def _group_row(self, index: int, group: Group) -> QtWidgets.QWidget:
        row, layout = self._make_row(0)
        eye = self._eye(group.visible, "set_group_visible", index)
        fold = self._button(
            "folded" if group.folded else "unfolded",
            say("Show its layers") if group.folded else say("Fold"),
            lambda: self._turn("set_group_folded", index),
        )
        fold.setObjectName("fold_group")
        name = self._name(say_group(group.name), say("Name of the group"), index, group.key)
        first, last = group_span(self._layers, index)
        count = QtWidgets.QLabel(str(last - first + 1))
        count.setObjectName("faint")
        count.setToolTip(say("Layers in the group"))
        layout.addWidget(eye)
        layout.addWidget(fold)
        layout.addWidget(name, 1)
        layout.addWidget(count)
        layout.addSpacing(8)
        return row

    def _eye(self, visible: bool, what: str, index: int) -> QtWidgets.QToolButton:
        return self._button(
            "eye" if visible else "hidden",
            say("Hide") if visible else say("Show"),
            lambda: self._turn(what, index),
        )

    def _make_row(self, indent: int) -> tuple[QtWidgets.QWidget, QtWidgets.QHBoxLayout]:
        row = QtWidgets.QWidget()
        row.setAttribute(QtCore.Qt.WidgetAttribute.WA_StyledBackground)
        layout = QtWidgets.QHBoxLayout(row)
        layout.setContentsMargins(4 + indent, 0, 4, 0)
        layout.setSpacing(2)
        return row, layout

    def _name(self, text: str, called: str, index: int, group: int) -> QtWidgets.QLineEdit:
        name = QtWidgets.QLineEdit(text)
        name.setAccessibleName(called)
        name.setFrame(False)
        name.setStyleSheet("QLineEdit { background: transparent; border: none; }")
        name.setReadOnly(True)
        name.installEventFilter(self)
        name.setProperty("place", index)
        name.setProperty("group", group)
        name.setProperty("shown", text)
        name.editingFinished.connect(lambda: self._renamed(index, group, name))
        return name

    def set_theme(self, theme: Theme) -> None:
        """Use other colours."""
        self._theme = theme
        for icon, button in self.buttons.items():
            button.setIcon(make_icon(icon, theme))
        self._shown = ()

    # -- the list ---------------------------------------------------------------------------

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Choose a layer by a click on its name; edit the name by a double click."""
        kind = QtCore.QEvent.Type
        if isinstance(watched, QtWidgets.QLineEdit):
            if event.type() == kind.MouseButtonDblClick:
                watched.setReadOnly(False)
                watched.setFocus()
                watched.selectAll()
                return True  # the line would choose the word under the pointer
            elif (
                isinstance(event, QtGui.QMouseEvent)
                and event.type() == kind.MouseButtonPress
                and watched.isReadOnly()
            ):
                index, group = watched.property("place"), watched.property("group")
                if event.modifiers() & QtCore.Qt.KeyboardModifier.ShiftModifier:
                    self._extend(index)
                else:
                    self._choose(index, group)
        return super().eventFilter(watched, event)

    def _renamed(self, index: int, group: int, name: QtWidgets.QLineEdit) -> None:
        if name.isReadOnly():
            return
        name.setReadOnly(True)
        text, shown = name.text().strip(), name.property("shown")
        if text and text != shown:  # a name in the window's language stays one
            self._ask("rename_group" if group else "rename_layer", index, text)
        else:
            name.setText(shown)

    def rename(self) -> None:
        """Edit the name of the active layer, or of the chosen group."""
        row = self.list.itemWidget(self.list.currentItem())
        name = row.findChild(QtWidgets.QLineEdit) if row is not None else None
        if name is not None:
            name.setReadOnly(False)
            name.setFocus()
            name.selectAll()

    def _ask(self, what: str, *arguments: object) -> None:
        self.asked.emit(what, arguments)

    def _ask_of_chosen(self, of_layer: str, of_group: str, *arguments: object) -> None:
        """Ask for something of the layer that is painted on, or of the group that was clicked."""
        self._ask(of_group if self._group else of_layer, self._chosen_index(), *arguments)

    def _select(self, item: QtWidgets.QListWidgetItem) -> None:
        modifiers = QtWidgets.QApplication.keyboardModifiers()
        if not modifiers & QtCore.Qt.KeyboardModifier.ShiftModifier:
            self._choose(item.data(_INDEX), item.data(_GROUP))

    def _choose(self, index: int, group: int) -> None:
        """Make a layer the active one, or direct the buttons to a group."""
        self._group = group
        self.show_layers(self._layers, self._active)
        if not group:
            self._ask("select_layer", index)

    def _extend(self, index: int) -> None:
        """Choose the rows between that of the layer that is painted on and another."""
        low, high = sorted((index, self._active))
        self.list.clearSelection()
        for row in range(self.list.count()):
            item = self.list.item(row)
            item.setSelected(low <= item.data(_INDEX) <= high and not item.data(_GROUP))

    # -- commands of buttons and keys -------------------------------------------------------

    def group_or_ungroup(self) -> None:
        """Make a group of the chosen layers, or dissolve the chosen group."""
        if self._group:
            self._ask("ungroup", self._chosen_index())
        else:
            self.group()

    def group(self) -> None:
        """Make a group of the chosen layers: of the one that is painted on, or several."""
        items = [item for item in self.list.selectedItems() if not item.data(_GROUP)]
        indices = [self._active, *(item.data(_INDEX) for item in items)]
        self._ask("add_group", min(indices), max(indices))

    def ungroup(self) -> None:
        """Dissolve the chosen group, or that of the layer that is painted on."""
        self._ask("ungroup", self._chosen_index())

    def remove(self) -> None:
        """Remove the active layer, or the chosen group."""
        self._ask_of_chosen("remove_layer", "remove_group")

    def duplicate(self) -> None:
        """Copy the active layer, or the chosen group."""
        self._ask_of_chosen("duplicate_layer", "duplicate_group")

    def _merge(self) -> None:
        self._ask("merge_layer", self._active)

    def _set_opacity(self, percent: int) -> None:
        self._show_percent(percent)
        self._ask_of_chosen("set_opacity", "set_group_opacity", percent / 100.0)

    def _set_blend(self, _: int) -> None:
        self._ask_of_chosen("set_blend", "set_group_blend", self.blend.currentData())

    def hide_or_show(self) -> None:
        """Hide or show the active layer, or the chosen group."""
        what = "set_group_visible" if self._group else "set_visible"
        self._turn(what, self._chosen_index())

    def lock_or_unlock(self) -> None:
        """Lock or unlock the active layer."""
        self._turn("set_locked", self._active)

    def _turn(self, what: str, index: int) -> None:
        """Ask to toggle a property of a layer that is shown, or of its group."""
        self.turned.emit(what, index, self._layers[index])

    def step(self, by: int) -> None:
        """Move the layer that is painted on, or the chosen group, one step up (1) or down (-1)."""
        index = self._chosen_index()
        if self._group:
            to = group_step(self._layers, index, by)
            if to is not None:
                self._ask("move_group", index, to)
            return
        step = layer_step(self._layers, index, by)
        if step is None:
            return
        group = self._layers[step[1]].group if step[1] >= 0 else None
        self._ask("move_layer", index, *step)
        if group is not None and group.folded:  # or it would have no row
            self._ask("set_group_folded", step[0], False)
