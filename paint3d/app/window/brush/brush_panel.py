"""The brushes, each shown by a stroke of its own in the ink that is in use."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.brush_in_hand import resized, size_limits
from paint3d.app.window.job import is_waiting
from paint3d.app.window.previews import stroke_preview
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import (
    say,
    say_brush,
    say_error,
    say_hair,
    say_length,
    say_purpose,
)
from paint3d.brush.presets import brush_names, load_brush
from paint3d.brush.spec import BrushSpec
from paint3d.core.arrays import AnyArray
from paint3d.errors import Paint3DError
from paint3d.painter.painter import Ink

__all__ = ["BrushPanel", "pixmap_of", "plain_icon", "plain_name"]

_ICON = QtCore.QSize(132, 42)
_SHORTEST_MM, _LONGEST_MM = 5.0, 200.0  # the slider's ends
_FAVOURITES = 0  # instead of a folder's name
_SEEN_ROWS = 8  # of brushes, where there is room for them
_SETTLE_MS = 160  # a new size is taken when the slider has stood so long


def pixmap_of(pixels: AnyArray, size: QtCore.QSize | None = None) -> QtGui.QPixmap:
    """Return a pixmap of (H, W, 3) uint8 pixels, the first row on top."""
    height, width = pixels.shape[:2]
    data = np.ascontiguousarray(pixels)
    image = QtGui.QImage(data.data, width, height, 3 * width, QtGui.QImage.Format.Format_RGB888)
    pixmap = QtGui.QPixmap.fromImage(image.copy())
    if size is None:
        return pixmap
    return pixmap.scaled(
        size,
        QtCore.Qt.AspectRatioMode.IgnoreAspectRatio,
        QtCore.Qt.TransformationMode.SmoothTransformation,
    )


class BrushPanel(QtWidgets.QWidget):
    """Choose a brush and its size.

    Signals
    -------
    chosen : BrushSpec
    favoured : tuple of str
        Brushes that are to be listed first from now on.
    filed : dict of str to str
        Folders by the brushes that are in them from now on.
    failed : str
        A preview could not be painted; emitted once for each reason.
    inked : Ink
        The ink of the previews from now on.
    edit, open_file : ()
        The brush in hand is to be changed, or one is to be taken from a file.
    """

    chosen = QtCore.Signal(object)
    favoured = QtCore.Signal(object)
    filed = QtCore.Signal(object)
    failed = QtCore.Signal(str)
    inked = QtCore.Signal(object)
    edit = QtCore.Signal()
    open_file = QtCore.Signal()

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self._ink: Ink = "pine soot"
        self._painter = ThreadPoolExecutor(1, thread_name_prefix="paint3d-preview")
        self._coming: dict[str, Future[Any]] = {}
        self._is_due = False
        self._failures: set[str] = set()
        self._brushes = {name: load_brush(name) for name in brush_names()}
        self._favourites: tuple[str, ...] = ()
        self._folders: dict[str, str] = {}
        self.brush = next(iter(self._brushes.values()))
        self._list = self._make_list()
        self.folder = QtWidgets.QComboBox()
        self.folder.setObjectName("brush_folder")
        self.folder.setAccessibleName(say("Folder"))
        self.folder.setToolTip(say("Which brushes are listed; the right button files one"))
        self.folder.currentIndexChanged.connect(lambda _: self._show_listed())
        self._size = QtWidgets.QSlider(QtCore.Qt.Orientation.Horizontal)
        self._size.setRange(0, 1000)
        self._size.setAccessibleName(say("Tuft"))
        self.length_label = QtWidgets.QLabel()
        self._reserve_width()
        self.length_label.setAlignment(QtCore.Qt.AlignmentFlag.AlignRight)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(QtWidgets.QLabel(say("Tuft")))
        row.addWidget(self._size, 1)
        row.addWidget(self.length_label)
        layout = QtWidgets.QVBoxLayout(self)
        layout.setContentsMargins(8, 6, 8, 8)
        layout.addWidget(self.folder)
        layout.addWidget(self._list, 1)
        layout.addLayout(row)
        layout.addLayout(self._make_buttons())
        self._size.valueChanged.connect(self._size_moved)
        self._timer = QtCore.QTimer(self)
        self._timer.setInterval(120)
        self._timer.timeout.connect(self._take_previews)
        self._wanted = self.brush.length_mm
        self._settle = QtCore.QTimer(self)
        self._settle.setSingleShot(True)
        self._settle.setInterval(_SETTLE_MS)
        self._settle.timeout.connect(self._size_settled)
        self.show_brush(self.brush)
        self.set_ink(self._ink)

    def _make_list(self) -> QtWidgets.QListWidget:
        view = QtWidgets.QListWidget(self)  # first child: keys that step to the panel reach it
        view.setObjectName("brushes")
        view.setAccessibleName(say("Brushes"))
        view.setIconSize(_ICON)
        view.setUniformItemSizes(True)
        view.setHorizontalScrollBarPolicy(QtCore.Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        for brush in self._brushes.values():
            view.addItem(_list_item(brush))
        view.itemClicked.connect(self._item_chosen)
        view.itemActivated.connect(self._item_chosen)
        view.setContextMenuPolicy(QtCore.Qt.ContextMenuPolicy.CustomContextMenu)
        view.customContextMenuRequested.connect(self._show_menu)
        return view

    def _make_buttons(self) -> QtWidgets.QHBoxLayout:
        row = QtWidgets.QHBoxLayout()
        for text, name, asked in (
            (say("Edit…"), "edit_brush", self.edit), (say("Open…"), "open_brush", self.open_file)
        ):  # fmt: skip
            button = QtWidgets.QPushButton(text)
            button.setObjectName(name)
            button.clicked.connect(lambda _=False, asked=asked: asked.emit())
            row.addWidget(button)
        return row

    # -- the user's own brushes --------------------------------------------------------------

    def show_own(self, brushes: Mapping[str, BrushSpec]) -> None:
        """List the user's own brushes by name, behind those that come with the program."""
        for brush in brushes.values():
            self.add_own(brush)

    def add_own(self, brush: BrushSpec) -> None:
        """List one more brush; it replaces one of the same name."""
        name = plain_name(brush)
        if name in brush_names():
            return
        known, self._brushes[name] = name in self._brushes, dataclasses.replace(brush, name=name)
        item = _list_item(self._brushes[name], name in self._favourites)
        row = list(self._brushes).index(name)
        if known:
            self._coming.pop(name, None)
            self._list.takeItem(row)
        self._list.insertItem(row, item)
        self._show_listed()
        self.set_ink(self._ink)

    def show_favourites(self, names: Sequence[str]) -> None:
        """List brushes of these names first."""
        self._favourites = tuple(name for name in names if name in self._brushes)
        usual = [name for name in brush_names() if name in self._brushes]
        own = [name for name in self._brushes if name not in usual]
        order = [*dict.fromkeys([*self._favourites, *usual, *own])]
        self._brushes = {name: self._brushes[name] for name in order}
        icons = {self._name(row): self._list.item(row).icon() for row in range(self._list.count())}
        self._list.clear()
        for name, brush in self._brushes.items():
            item = _list_item(brush, name in self._favourites)
            if name in icons:
                item.setIcon(icons[name])
            self._list.addItem(item)
        self.show_brush(self.brush)
        self.show_folders(self._folders)

    def show_folders(self, folders: Mapping[str, str]) -> None:
        """Offer these folders, by the brushes that are in them, above the list."""
        self._folders = dict(folders)
        asked = self.folder.currentData()
        with QtCore.QSignalBlocker(self.folder):
            self.folder.clear()
            self.folder.addItem(say("All brushes"), None)
            if self._favourites:
                self.folder.addItem(f"★ {say('Favourites')}", _FAVOURITES)
            for name in sorted(set(self._folders.values())):
                self.folder.addItem(name, name)
            self.folder.setCurrentIndex(max(0, self.folder.findData(asked)))
        self.folder.setVisible(self.folder.count() > 1)
        self._show_listed()

    def _show_listed(self) -> None:
        """List the brushes of the folder that is chosen."""
        asked = self.folder.currentData()
        for row in range(self._list.count()):
            name = self._name(row)
            filed = name in self._favourites if asked == _FAVOURITES else True
            if asked not in (None, _FAVOURITES):
                filed = self._folders.get(name) == asked
            self._list.setRowHidden(row, not filed)

    def _file(self, name: str, folder: str) -> None:
        """Put a brush into a folder; the empty name takes it out."""
        folders = {one: at for one, at in self._folders.items() if one != name}
        if folder:
            folders[name] = folder
        self.show_folders(folders)
        self.filed.emit(folders)

    def _file_anew(self, name: str) -> None:
        """Ask for the name of a folder, and put a brush into it."""
        folder, done = QtWidgets.QInputDialog.getText(
            self, say("New folder"), say("Name of the folder")
        )
        if done and folder.strip():
            self._file(name, folder.strip())

    def _show_menu(self, position: QtCore.QPoint) -> None:
        item = self._list.itemAt(position)
        if item is None:
            return
        name: str = item.data(QtCore.Qt.ItemDataRole.UserRole)
        menu = QtWidgets.QMenu(self._list)
        menu.setObjectName("brush_menu")
        menu.setAttribute(QtCore.Qt.WidgetAttribute.WA_DeleteOnClose)
        action = menu.addAction(say("Favourite"))
        action.setObjectName("favourite")
        action.setCheckable(True)
        action.setChecked(name in self._favourites)
        action.toggled.connect(lambda on: self._favour(name, on))
        folders = menu.addMenu(say("Folder"))
        folders.setObjectName("folders")
        inside = self._folders.get(name, "")
        for folder in ("", *sorted(set(self._folders.values()))):
            action = folders.addAction(folder or say("None"))
            action.setCheckable(True)
            action.setChecked(folder == inside)
            action.triggered.connect(lambda _=False, folder=folder: self._file(name, folder))
        folders.addSeparator()
        action = folders.addAction(say("New folder…"))
        action.setObjectName("new_folder")
        action.triggered.connect(lambda _=False: self._file_anew(name))
        menu.aboutToHide.connect(self._mark_in_hand)
        menu.popup(self._list.viewport().mapToGlobal(position))

    def _mark_in_hand(self) -> None:
        """Mark the brush in hand in the list: the right button marks another one."""
        names, name = list(self._brushes), plain_name(self.brush)
        self._list.setCurrentRow(names.index(name) if name in names else -1)

    def _favour(self, name: str, on: bool) -> None:
        rest = [one for one in self._favourites if one != name]
        self.show_favourites([*rest, name] if on else rest)
        self.favoured.emit(self._favourites)

    # -- choice -----------------------------------------------------------------------------

    def show_brush(self, brush: BrushSpec) -> None:
        """Show the brush in use."""
        self.brush = brush
        self._mark_in_hand()
        self._wanted = brush.length_mm
        with QtCore.QSignalBlocker(self._size):
            self._size.setValue(_step_of(brush.length_mm))
        self.length_label.setText(say_length(brush.length_mm))

    def show_unit(self) -> None:
        """Show lengths in the chosen unit."""
        for row in range(self._list.count()):
            brush = self._brushes[self._name(row)]
            self._list.item(row).setText(_describe(brush, self._name(row) in self._favourites))
        self.length_label.setText(say_length(self._wanted))
        self._reserve_width()

    def _reserve_width(self) -> None:
        """Reserve the width of any length, so that the panel never grows and the picture stays."""
        texts = [say_length(mm) for mm in (_SHORTEST_MM, 45.25, 88.88, _LONGEST_MM)]
        self.length_label.setMinimumWidth(max(map(self.fontMetrics().horizontalAdvance, texts)) + 2)

    def set_ink(self, ink: Ink) -> None:
        """Paint the previews in this ink, soon: a name, or parts by name."""
        self._ink = ink
        self._is_due = True
        self._timer.start()
        self.inked.emit(ink)

    def set_theme(self, theme: Theme) -> None:
        """Use other colours."""
        self._theme = theme
        self.set_ink(self._ink)

    @property
    def is_busy(self) -> bool:
        """True if previews are still to be painted."""
        return self._is_due or bool(self._coming)

    @property
    def is_settling(self) -> bool:
        """True if a size has been chosen that is not yet taken."""
        return self._settle.isActive()

    def resize_brush(self, factor: float) -> None:
        """Choose the brush larger by a factor, once the size has settled."""
        self._want(self._wanted * factor)
        with QtCore.QSignalBlocker(self._size):
            self._size.setValue(_step_of(self._wanted))

    def close_down(self) -> None:
        """Paint no more previews; do not wait for the one in work."""
        self._timer.stop()
        self._painter.shutdown(wait=False, cancel_futures=True)

    def _name(self, row: int) -> str:
        result: str = self._list.item(row).data(QtCore.Qt.ItemDataRole.UserRole)
        return result

    def height_with_brushes(self) -> int:
        """Return the height at which eight brushes are seen, or all there are."""
        rows = min(_SEEN_ROWS, self._list.count()) * max(self._list.sizeHintForRow(0), 0)
        return self.sizeHint().height() - self._list.sizeHint().height() + rows

    def _item_chosen(self, item: QtWidgets.QListWidgetItem) -> None:
        self.chosen.emit(self._brushes[item.data(QtCore.Qt.ItemDataRole.UserRole)])

    def _size_moved(self, value: int) -> None:
        self._want(_SHORTEST_MM * (_LONGEST_MM / _SHORTEST_MM) ** (value / 1000))

    def _want(self, length: float) -> None:
        least, most = size_limits(self.brush)
        self._wanted = min(max(length, 1.0001 * least), 0.9999 * most)
        self.length_label.setText(say_length(self._wanted))
        self._settle.start()

    def _size_settled(self) -> None:
        self.chosen.emit(resized(self.brush, self._wanted))

    def _take_previews(self) -> None:
        """Begin due previews, unless the window waits for a job; show those that are done."""
        if self._is_due and not is_waiting(self.window()):
            self._is_due = False
            for row in range(self._list.count()):
                name = self._name(row)
                brush = self._brushes[name]
                self._coming[name] = self._painter.submit(stroke_preview, brush, self._ink)
        for row in range(self._list.count()):
            coming = self._coming.get(self._name(row))
            if coming is None or not coming.done():
                continue
            del self._coming[self._name(row)]
            if coming.cancelled():
                continue
            error = coming.exception()
            if error is not None:
                self._failed(error)
                continue
            icon = plain_icon(_framed(coming.result(), self._theme))
            self._list.item(row).setIcon(icon)
        if not self.is_busy:
            self._timer.stop()

    def _failed(self, error: BaseException) -> None:
        """Emit that a preview cannot be shown, once for each reason: painting goes on without."""
        known = isinstance(error, Paint3DError)
        reason = say_error(error) if known else f"{type(error).__name__}: {error}"
        if reason not in self._failures:
            self._failures.add(reason)
            self.failed.emit(reason)


def plain_name(brush: BrushSpec) -> str:
    """Return the name of the brush that this is a size of."""
    return brush.name.split(" @")[0]


def _describe(brush: BrushSpec, favourite: bool = False) -> str:
    mark = "★ " if favourite else ""
    purpose = say_purpose(plain_name(brush))
    return f"{mark}{say_brush(brush.name)}  ·  {say_length(brush.length_mm)}\n{purpose}"


def _list_item(brush: BrushSpec, favourite: bool = False) -> QtWidgets.QListWidgetItem:
    item = QtWidgets.QListWidgetItem(_describe(brush, favourite))
    item.setData(QtCore.Qt.ItemDataRole.UserRole, brush.name)
    purpose = say_purpose(plain_name(brush))
    item.setToolTip(
        (purpose + "\n" if purpose else "")
        + say(
            "{hair}, {length:g} mm long, {width:g} mm thick",
            hair=say_hair(brush.hair),
            length=brush.length_mm,
            width=brush.root_diameter_mm,
        )
    )
    blank = QtGui.QPixmap(_ICON * 2)  # until the stroke is painted: rows keep their height
    blank.fill(QtCore.Qt.GlobalColor.transparent)
    blank.setDevicePixelRatio(2.0)
    item.setIcon(plain_icon(blank))
    return item


def plain_icon(pixmap: QtGui.QPixmap) -> QtGui.QIcon:
    """Return an icon that looks the same when it is chosen."""
    icon = QtGui.QIcon(pixmap)
    icon.addPixmap(pixmap, QtGui.QIcon.Mode.Selected)
    return icon


def _step_of(length: float) -> int:
    """Return the slider's value for a length."""
    result: int = round(1000 * np.log(length / _SHORTEST_MM) / np.log(_LONGEST_MM / _SHORTEST_MM))
    return result


def _framed(pixels: AnyArray, theme: Theme) -> QtGui.QPixmap:
    """Draw a stroke as a slip of paper with rounded corners, twice as fine as it is shown."""
    size = _ICON * 2
    whole = QtGui.QPixmap(size)
    whole.fill(QtCore.Qt.GlobalColor.transparent)
    painter = QtGui.QPainter(whole)
    painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
    path = QtGui.QPainterPath()
    path.addRoundedRect(QtCore.QRectF(1, 1, size.width() - 2, size.height() - 2), 10, 10)
    painter.setClipPath(path)
    painter.drawPixmap(0, 0, pixmap_of(pixels, size))
    painter.setClipping(False)
    painter.setPen(QtGui.QPen(QtGui.QColor(theme.line), 2))
    painter.drawPath(path)
    painter.end()
    whole.setDevicePixelRatio(2.0)
    return whole
