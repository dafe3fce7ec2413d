"""Pictures of the brush editor and of the dialog that mixes any colour, in a real window.

xvfb-run -a -s "-screen 0 1400x900x24" python scripts/gallery/brush_editor.py --out docs/gallery
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from pathlib import Path

from PIL import Image
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.start import make_program
from paint3d.app.window.studio import StudioWindow
from paint3d.app.window.wording import choose_language
from tests.support.app.windows import pretend_saved


def live(seconds: float) -> None:
    """Let the program live for a while."""
    until = time.perf_counter() + seconds
    while time.perf_counter() < until:
        QtWidgets.QApplication.processEvents(QtCore.QEventLoop.ProcessEventsFlag.AllEvents, 20)


def keep(dialog: QtWidgets.QWidget, path: Path) -> None:
    """Save what it looks like, and close it."""
    live(0.3)
    dialog.grab().save(str(path))
    Image.open(path).convert("RGB").save(path, optimize=True)
    dialog.close()


def editor(window: StudioWindow, path: Path) -> None:
    """The brush of flying white, with coarser hairs that come apart."""
    window.workspace.post("set_brush", "feibai")
    live(0.5)
    window.workspace.actions["edit_brush"].trigger()
    dialog = window.brushes.editor
    assert dialog is not None, "it was opened"
    dialog.tabs.setCurrentIndex(2)
    for name, value in (("n_hairs", 120.0), ("hair_mm", 0.25), ("levelling_mm", 4.0)):
        dialog.rows[name].box.setValue(value)
    while dialog.drawing.is_busy:
        live(0.1)
    keep(dialog, path)


def colour(window: StudioWindow, path: Path) -> None:
    """A green-blue of three pigments."""
    window.workspace.actions["choose_colour"].trigger()
    dialog = window.inks.dialog
    assert dialog is not None, "it was opened"
    dialog.picker.setCurrentColor(QtGui.QColor(80, 140, 150))
    while dialog.is_busy:
        live(0.1)
    keep(dialog, path)


def main() -> None:
    """Make the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs/gallery"))
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        os.environ.update(PAINT3D_CONFIG=folder, PAINT3D_STATE=folder)
        app = make_program()
        choose_language("en")
        window = StudioWindow(app, dark=False)
        window.show()
        window.workspace.quiet = True
        window.opening.open_path("plane", 1.0, "xuan", asked=True)
        while not window.stage.is_lit or window.panels.brushes.is_busy:
            live(0.1)
        editor(window, options.out / "brush_editor.png")
        colour(window, options.out / "colour.png")
        pretend_saved(window.stage.paint_thread)
        window.close()


if __name__ == "__main__":
    main()
