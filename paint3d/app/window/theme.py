"""Light and dark: the colours of the window, the style sheet made of them, and icons in them.

Icons are drawn as lines on a square of 24: sharp at any size, in the theme's ink.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from PySide6 import QtCore, QtGui, QtSvg, QtWidgets

__all__ = [
    "DARK_THEME",
    "ICONS",
    "LIGHT_THEME",
    "STATES",
    "Theme",
    "apply_theme",
    "is_system_dark",
    "make_icon",
]


FONTS = ["Inter", "Noto Sans", "Noto Sans CJK SC", "Source Han Sans SC", "PingFang SC"]
_POINTS = 9.5

STATES = {"good": "●", "slow": "▲", "bad": "■", "off": "○"}
"""Shapes of the states: shape and text show a state, its colour only repeats it."""


@dataclass(frozen=True)
class Theme:
    """Colours by their purpose, as #rrggbb."""

    name: str
    window: str
    panel: str
    raised: str
    field: str
    line: str
    text: str
    faint: str
    accent: str
    on_accent: str
    chosen: str
    good: str
    slow: str
    bad: str

    def state_colour(self, state: str) -> str:
        """Return the colour of one of `STATES`."""
        return {"good": self.good, "slow": self.slow, "bad": self.bad}.get(state, self.faint)


LIGHT_THEME = Theme(
    name="light", window="#e9e6e0", panel="#f4f2ee", raised="#ffffff", field="#ffffff",
    line="#d3cec5", text="#2a2825", faint="#69635d", accent="#a8352a", on_accent="#ffffff",
    chosen="#efe0d8", good="#1f6f8b", slow="#8c5800", bad="#a8352a",
)  # fmt: skip
DARK_THEME = Theme(
    name="dark", window="#1f1e1d", panel="#292826", raised="#343230", field="#1b1a19",
    line="#45423e", text="#ece8e1", faint="#a39c92", accent="#d4644f", on_accent="#1b1a19",
    chosen="#4a342d", good="#6fbfd6", slow="#e0a94a", bad="#e8806c",
)  # fmt: skip


def is_system_dark(app: QtWidgets.QApplication) -> bool:
    """Return whether the desktop is dark."""
    return app.palette().color(QtGui.QPalette.ColorRole.Window).lightness() < 128


def apply_theme(app: QtWidgets.QApplication, theme: Theme) -> None:
    """Style the whole program, unless it has the style: each of its widgets is restyled."""
    sheet = _SHEET.format(**vars(theme))
    if app.styleSheet() == sheet:
        return
    if app.font().families()[: len(FONTS)] != list(FONTS):  # setting them again would restyle all
        app.setStyle("Fusion")
        font = QtGui.QFont()
        font.setFamilies([*FONTS, app.font().family()])
        font.setPointSizeF(_POINTS)
        app.setFont(font)
    app.setPalette(_palette(theme))
    app.setStyleSheet(sheet)


def _palette(theme: Theme) -> QtGui.QPalette:
    role, palette = QtGui.QPalette.ColorRole, QtGui.QPalette()
    colours = {
        role.Window: theme.panel, role.WindowText: theme.text, role.Base: theme.field,
        role.AlternateBase: theme.panel, role.Text: theme.text, role.Button: theme.raised,
        role.ButtonText: theme.text, role.Highlight: theme.accent, role.Mid: theme.line,
        role.HighlightedText: theme.on_accent, role.ToolTipBase: theme.raised,
        role.ToolTipText: theme.text, role.PlaceholderText: theme.faint, role.Link: theme.accent,
    }  # fmt: skip
    for key, colour in colours.items():
        palette.setColor(key, QtGui.QColor(colour))
    off = QtGui.QPalette.ColorGroup.Disabled
    for key in (role.WindowText, role.Text, role.ButtonText):
        palette.setColor(off, key, QtGui.QColor(theme.faint))
    return palette


_SHEET = """
QMainWindow, QDialog {{ background: {panel}; }}
QMainWindow::separator {{ background: {window}; width: 4px; height: 4px; }}
QDialogButtonBox {{ dialogbuttonbox-buttons-have-icons: 0; }}
QMenuBar {{ background: {panel}; padding: 2px 6px; border-bottom: 1px solid {line}; }}
QMenuBar::item {{ padding: 4px 9px; border-radius: 4px; background: transparent; }}
QMenuBar::item:selected {{ background: {chosen}; }}
QMenu {{ background: {raised}; border: 1px solid {line}; padding: 4px; }}
QMenu::item {{ padding: 5px 26px 5px 22px; border-radius: 4px; }}
QMenu::item:selected {{ background: {chosen}; color: {text}; }}
QMenu::item:disabled {{ color: {faint}; }}
QMenu::separator {{ height: 1px; background: {line}; margin: 4px 8px; }}
QToolBar {{ background: {panel}; border: none; border-right: 1px solid {line}; padding: 5px 4px;
    spacing: 3px; }}
QToolBar::separator {{ background: {line}; height: 1px; margin: 5px 6px; }}
QToolButton {{ border: 1px solid transparent; border-radius: 6px; padding: 5px; }}
QToolBar[tight="1"] {{ padding: 2px 4px; spacing: 0px; }}
QToolBar[tight="1"]::separator {{ margin: 2px 6px; }}
QToolBar[tight="1"] QToolButton {{ padding: 3px; }}
QToolBar[tight="2"] {{ padding: 0px 4px; spacing: 0px; }}
QToolBar[tight="2"]::separator {{ margin: 0px 6px; }}
QToolBar[tight="2"] QToolButton {{ padding: 2px 3px; }}
QToolButton#qt_toolbar_ext_button {{ background: {raised}; border: 1px solid {line};
    min-height: 14px; padding: 1px; }}
QToolButton#fold, QToolButton#fold:checked {{ background: transparent; border: none; padding: 1px;
    color: {faint}; }}
QToolButton#fold:hover, QToolButton#fold:focus {{ color: {accent}; }}
QToolButton:focus, QPushButton:focus {{ border-color: {accent}; }}
QSlider:focus, QCheckBox:focus {{ background: {chosen}; border-radius: 4px; }}
QListView:focus {{ border-color: {accent}; }}
QToolButton:hover {{ background: {raised}; border-color: {line}; }}
QToolButton:checked {{ background: {chosen}; border: 1px solid {accent}; }}
QToolButton:pressed {{ background: {chosen}; }}
QPushButton {{ background: {raised}; border: 1px solid {line}; border-radius: 6px;
    padding: 5px 12px; }}
QPushButton:hover {{ border-color: {faint}; }}
QPushButton:pressed, QPushButton:checked {{ background: {chosen}; border-color: {accent}; }}
QPushButton:default {{ border: 1px solid {accent}; }}
QPushButton:disabled {{ color: {faint}; }}
QDockWidget {{ titlebar-close-icon: none; font-weight: 600; }}
QDockWidget::title {{ background: {panel}; padding: 7px 10px 5px 10px; text-align: left; }}
QTabBar {{ qproperty-drawBase: 0; }}
QTabBar::tab {{ background: transparent; color: {faint}; padding: 6px 10px; margin: 0 1px;
    border-bottom: 2px solid transparent; }}
QTabBar::tab:selected {{ color: {text}; border-bottom: 2px solid {accent}; font-weight: 600; }}
QTabBar::tab:hover {{ color: {text}; }}
QListView, QTreeView, QTableView, QScrollArea {{ background: {field}; border: 1px solid {line};
    border-radius: 6px; outline: 0; }}
QListView::item {{ padding: 2px; border-radius: 5px; border: 1px solid transparent; }}
QListView::item:hover {{ background: {panel}; }}
QListView::item:selected {{ background: {chosen}; color: {text}; border: 1px solid {accent}; }}
QScrollArea#plain {{ background: {panel}; border: none; }}
QScrollArea#plain > QWidget > QWidget {{ background: {panel}; }}
QLineEdit {{ background: {field};
    border: 1px solid {line}; border-radius: 5px; padding: 4px 6px; min-height: 18px;
    selection-background-color: {accent}; selection-color: {on_accent}; }}
QLineEdit:focus {{ border-color: {accent}; }}
QSlider:horizontal {{ min-height: 18px; }}
QSlider::groove:horizontal {{ height: 4px; background: {line}; border-radius: 2px; }}
QSlider::sub-page:horizontal {{ background: {accent}; border-radius: 2px; }}
QSlider::handle:horizontal {{ background: {raised}; border: 1px solid {faint}; width: 13px;
    margin: -6px 0; border-radius: 7px; }}
QSlider::handle:horizontal:hover {{ border-color: {accent}; }}
QProgressBar {{ background: {field}; border: 1px solid {line}; border-radius: 5px; height: 12px;
    text-align: center; }}
QProgressBar::chunk {{ background: {chosen}; border: 1px solid {accent}; border-radius: 4px; }}
QStatusBar {{ background: {panel}; border-top: 1px solid {line}; color: {faint}; }}
QStatusBar::item {{ border: none; }}
QScrollBar:vertical {{ background: transparent; width: 10px; margin: 0; }}
QScrollBar::handle:vertical {{ background: {line}; border-radius: 5px; min-height: 24px; }}
QScrollBar::handle:vertical:hover {{ background: {faint}; }}
QScrollBar:horizontal {{ background: transparent; height: 10px; margin: 0; }}
QScrollBar::handle:horizontal {{ background: {line}; border-radius: 5px; min-width: 24px; }}
QScrollBar::add-line, QScrollBar::sub-line {{ width: 0; height: 0; }}
QScrollBar::add-page, QScrollBar::sub-page {{ background: transparent; }}
QToolTip {{ background: {raised}; color: {text}; border: 1px solid {line}; padding: 4px 6px; }}
QLabel#faint {{ color: {faint}; }}
QLabel#title {{ font-weight: 600; }}
QLabel#heading {{ color: {accent}; font-weight: 700; padding-bottom: 2px; }}
QFrame#card {{ background: {raised}; border: 1px solid {line}; border-radius: 8px; }}
QCheckBox {{ spacing: 6px; }}
"""

# ---- Icons ---------------------------------------------------------------------------------------


ICONS = {
    "new": "M6 3h8l4 4v14H6z M14 3v4h4 M12 11v6 M9 14h6",
    "open": "M3 6h6l2 2h10v11H3z M3 11h18",
    "save": "M4 4h13l3 3v13H4z M8 4v5h7V4 M7 20v-7h10v7",
    "export": "M12 15V3 M8 7l4-4 4 4 M5 12v8h14v-8",
    "brush": "M20 3l-8.5 9.5 M11.5 12.5l-3-2.5c-2 1-3 3-3 5.5 0 2.5-1 4-2.5 5 4.5.6 8.3-1 9.5-5z",
    "orbit": "M12 4a8 8 0 1 0 8 8 M20 5v7h-7 M12 9v6 M9 12h6",
    "move": "M12 3v18 M3 12h18 M9 6l3-3 3 3 M9 18l3 3 3-3 M6 9l-3 3 3 3 M18 9l3 3-3 3",
    "zoom": "M10.5 4a6.5 6.5 0 1 0 0 13 6.5 6.5 0 0 0 0-13z M15.500 15.500L20 20"
        " M8 10.500h5 M10.5 8v5",
    "roll": "M19 12a7 7 0 1 1-3-5.700 M16 2v4.500h-4.500 M9 12h6",
    "frame": "M4 8V4h4 M16 4h4v4 M20 16v4h-4 M8 20H4v-4 M9 9h6v6H9z",
    "undo": "M8 5L4 9l4 4 M4 9h9a6 6 0 0 1 0 12h-3",
    "redo": "M16 5l4 4-4 4 M20 9h-9a6 6 0 0 0 0 12h3",
    "dip": "M3 13h18c0 4-4 7-9 7s-9-3-9-7z M17 3l-5 10",
    "eraser": "M4 15l9-9 6 6-8 8H8z M9 10l6 6 M8 20h12",
    "rinse": "M12 3c3.5 4.4 6 7.2 6 10.5a6 6 0 0 1-12 0C6 10.2 8.5 7.4 12 3z M9 14a3 3 0 0 0 3 3",
    "swap": "M4 8h13 M13 4l4 4-4 4 M20 16H7 M11 12l-4 4 4 4",
    "pick": "M14 4l6 6 M12 6l6 6 M15 9l-9 9-3 3 M13 7l-9 9-1 5 5-1 9-9",
    "mirror": "M12 3v18 M8 7l-5 5 5 5z M16 7l5 5-5 5z",
    "radial": "M12 12V3 M12 12l7.8 4.5 M12 12l-7.8 4.5 M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18z",
    "mask": "M4 4h16v16H4z M4 14L14 4 M8 20L20 8 M4 20L20 4",
    "refine": "M12 3l9 16H3z M12 3v16 M7.5 11l4.5 8 M16.5 11L12 19",
    "layers": "M12 4l9 5-9 5-9-5z M3 13.500l9 5 9-5",
    "group": "M3 6h6l2 2h10v11H3z M12 11v5 M9.500 13.500h5",
    "ungroup": "M3 6h6l2 2h10v11H3z M9.500 13.500h5",
    "folded": "M9 6l6 6-6 6",
    "unfolded": "M6 9l6 6 6-6",
    "camera": "M4 8h4l2-3h4l2 3h4v11H4z M12 10a3.5 3.5 0 1 0 0 7 3.5 3.5 0 0 0 0-7z",
    "record": "M12 5a7 7 0 1 0 0 14 7 7 0 0 0 0-14z M12 9.500a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5z",
    "play": "M7 4l13 8-13 8z",
    "stop": "M6 6h12v12H6z",
    "help": "M9 9a3 3 0 1 1 4.5 2.600c-1 .6-1.5 1.2-1.5 2.4 M12 18v.5"
        " M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18z",
    "dry": "M12 7a5 5 0 1 0 0 10 5 5 0 0 0 0-10z M12 2v2 M12 20v2 M2 12h2"
        " M20 12h2 M5 5l1.5 1.5 M17.5 17.5L19 19 M5 19l1.5-1.5 M17.5 6.500L19 5",
    "eye": "M2 12c3-5 6.5-7 10-7s7 2 10 7c-3 5-6.5 7-10 7s-7-2-10-7z"
        " M12 9a3 3 0 1 0 0 6 3 3 0 0 0 0-6z",
    "hidden": "M2 12c3-5 6.5-7 10-7s7 2 10 7c-3 5-6.5 7-10 7s-7-2-10-7z M4 20L20 4",
    "lock": "M6 11h12v9H6z M8.5 11V8a3.5 3.5 0 0 1 7 0v3 M12 14v3",
    "unlocked": "M6 11h12v9H6z M8.5 11V7a3.5 3.5 0 0 1 6.800-1.2",
    "plus": "M12 5v14 M5 12h14",
    "minus": "M5 12h14",
    "copy": "M8 8h12v12H8z M16 8V4H4v12h4",
    "merge": "M4 6h16 M12 9v7 M9 13l3 3 3-3 M4 20h16",
    "up": "M12 19V5 M6 11l6-6 6 6",
    "down": "M12 5v14 M6 13l6 6 6-6",
    "water": "M3 8c3-2.5 6 2.5 9 0s6 2.5 9 0 M3 13c3-2.5 6 2.5 9 0s6 2.5 9 0"
        " M3 18c3-2.5 6 2.5 9 0s6 2.5 9 0",
    "device": "M7 3h10v18H7z M10 17h4 M10 6h4v6h-4z",
    "book": "M12 6c-2-1.5-5-2-9-2v14c4 0 7 .5 9 2 2-1.5 5-2 9-2V4c-4 0-7 .5-9 2z M12 6v14",
}  # fmt: skip
"""Name to the path of its lines."""

_SVG = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 24 24"><path d="{path}" fill="none"
stroke="{colour}" stroke-width="1.6" stroke-linecap="round" stroke-linejoin="round"/></svg>"""
_SIZES = (16, 20, 24, 32, 48, 64)


@cache
def make_icon(name: str, theme: Theme) -> QtGui.QIcon:
    """Return the icon of a name, fainter for what is disabled; drawn once."""
    icon = QtGui.QIcon()
    modes = {QtGui.QIcon.Mode.Normal: theme.text, QtGui.QIcon.Mode.Disabled: theme.line}
    for mode, colour in modes.items():
        picture = QtSvg.QSvgRenderer(_SVG.format(path=ICONS[name], colour=colour).encode())
        for size in _SIZES:
            pixels = QtGui.QPixmap(size, size)
            pixels.fill(QtCore.Qt.GlobalColor.transparent)
            painter = QtGui.QPainter(pixels)
            picture.render(painter)
            painter.end()
            icon.addPixmap(pixels, mode)
    return icon
