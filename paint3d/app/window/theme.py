"""Light and dark: the colours of the window, and the style sheet made of them.

Warm paper and ink, with the red of a seal for what is chosen. Nothing is told by hue alone: a
chosen thing also has a frame or a mark, and every state has its own shape and word.
"""

from __future__ import annotations

from dataclasses import dataclass

from PySide6 import QtGui, QtWidgets

__all__ = ["DARK_THEME", "LIGHT_THEME", "STATES", "Theme", "apply_theme", "is_system_dark"]

FONTS = ["Inter", "Noto Sans", "Noto Sans CJK SC", "Source Han Sans SC", "PingFang SC"]
_POINTS = 9.5

STATES = {"good": "●", "slow": "▲", "bad": "■", "off": "○"}
"""State to its shape; the shape and a word tell it, the colour only repeats it."""


@dataclass(frozen=True)
class Theme:
    """Colours by what they are for, as #rrggbb."""

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
        """Of one of `STATES`."""
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
    """Whether the desktop is dark."""
    return app.palette().color(QtGui.QPalette.ColorRole.Window).lightness() < 128


def apply_theme(app: QtWidgets.QApplication, theme: Theme) -> None:
    """Dress the whole program, unless it is dressed so already: each of its widgets is restyled."""
    sheet = _SHEET.format(**vars(theme))
    if app.styleSheet() == sheet:
        return
    if app.font().families()[: len(FONTS)] != list(FONTS):  # or all are restyled once more
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
