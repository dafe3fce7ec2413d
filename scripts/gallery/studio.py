"""Pictures of the studio, painted and photographed in a real window.

xvfb-run -a -s "-screen 0 1400x900x24" python scripts/gallery/studio.py --out docs/gallery
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image
from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from paint3d.app.model.input.navigation import dolly, orbit, pan
from paint3d.app.window.copybook.strokes_dialog import StrokesDialog
from paint3d.app.window.start import make_program
from paint3d.app.window.studio import StudioWindow
from paint3d.app.window.wording import choose_language
from paint3d.calligraphy.glyph_sources import open_glyphs

sys.path += [str(Path(__file__).parents[2]), str(Path(__file__).parent)]
from pieces import named_cup

from tests.support.app.windows import pretend_saved
from tests.support.photographs import Camera, photograph, sheet_of

KIND, BUTTON = QtCore.QEvent.Type, QtCore.Qt.MouseButton


def live(seconds: float) -> None:
    """Let the program live for a while."""
    until = time.perf_counter() + seconds
    while time.perf_counter() < until:
        QtWidgets.QApplication.processEvents(QtCore.QEventLoop.ProcessEventsFlag.AllEvents, 20)


def mouse(window: StudioWindow, kind: KIND, x: float, y: float, *, down: bool = False) -> None:
    """One event of the mouse, in pixels of the canvas."""
    held = BUTTON.LeftButton if down else BUTTON.NoButton
    button = BUTTON.NoButton if kind == KIND.MouseMove else BUTTON.LeftButton
    place = QtCore.QPointF(x, y)
    event = QtGui.QMouseEvent(
        kind, place, window.canvas.mapToGlobal(place), button, held,
        QtCore.Qt.KeyboardModifier.NoModifier,
    )  # fmt: skip
    QtWidgets.QApplication.sendEvent(window.canvas, event)


def follow(window: StudioWindow, line: np.ndarray) -> None:
    """Paint along a line (N, 3) on the object."""
    height = window.stage.scene.size[1]
    boxes = [window.stage.scene.screen_box(point[None]) for point in line]
    places = [((b[0] + b[2]) / 2, height - (b[1] + b[3]) / 2) for b in boxes]
    mouse(window, KIND.MouseMove, *places[0])
    mouse(window, KIND.MouseButtonPress, *places[0], down=True)
    for place in places:
        mouse(window, KIND.MouseMove, *place, down=True)
        live(0.05)
    mouse(window, KIND.MouseButtonRelease, *places[-1])
    window.stage.paint_thread.post(lambda document: None).result()
    live(0.5)


def opened(app: QtWidgets.QApplication, name: str, language: str, *, dark: bool) -> StudioWindow:
    """A window with an object in it, lit."""
    choose_language(language)
    window = StudioWindow(app, dark=dark)
    window.show()
    window.workspace.quiet = True
    window.opening.open_path(name, asked=True)
    while not window.stage.is_lit or window.panels.brushes.is_busy:
        live(0.1)
    return window


def choose(window: StudioWindow, name: str) -> None:
    """Click a panel's tab, by which it gets the height that it needs."""
    title = window.panels.docks[name].windowTitle()
    for bar in window.findChildren(QtWidgets.QTabBar):
        for k in range(bar.count()):
            if bar.tabText(k) == title:
                QtTest.QTest.mouseClick(bar, BUTTON.LeftButton, pos=bar.tabRect(k).center())
    live(0.2)


def keep(window: StudioWindow, path: Path) -> None:
    """Save what the window looks like, and close it."""
    live(1.6)  # so that the picture is drawn finely
    window.status.state.clear()  # how fast this machine draws tells nothing of others
    window.grab().save(str(path))
    Image.open(path).convert("RGB").save(path, optimize=True)
    pretend_saved(window.stage.paint_thread)
    window.close()


def demo(app: QtWidgets.QApplication, path: Path) -> None:
    """A cup with plum blossom inside, and the brush above it."""
    with tempfile.TemporaryDirectory() as folder:
        window = opened(app, str(named_cup(Path(folder))), "en", dark=False)
    height = window.canvas.height()
    window.hand.look(dolly(orbit(window.hand.camera, -10.0, 0.12 * height, height), 1.2))
    window.workspace.post("set_brush", "xiaobaiyun")
    window.workspace.post("dip", "cinnabar")
    for name in ("layers", "inks"):
        choose(window, name)
    live(2.0)  # so that the camera is where it goes
    mouse(window, KIND.MouseMove, 0.66 * window.canvas.width(), 0.70 * height)
    live(1.0)
    mouse(window, KIND.MouseMove, 0.67 * window.canvas.width(), 0.71 * height)
    keep(window, path)


def copybook(app: QtWidgets.QApplication, path: Path) -> None:
    """Writing after a copybook on the vase, in Chinese and in the dark."""
    window = opened(app, "vase", "zh", dark=True)
    window.copying.layout_text("永和九年", 38.0, True)
    choose(window, "copybook")
    window.workspace.post("set_brush", "zhongkai")
    window.hand.look(dolly(pan(window.hand.camera, 20.0, -50.0, window.canvas.height()), 2.3))
    window.hand.hand.force = 1.4
    window.hand.set_settings(landing_s=0.01)
    live(0.5)
    ghosts = window.panels.copybook.copybook.ghosts
    lines = [*ghosts[0].medians, *ghosts[1].medians[:3]]
    for line in lines:
        follow(window, line[:: max(1, len(line) // 24)])
    live(1.0)
    keep(window, path)


def strokes(app: QtWidgets.QApplication, path: Path) -> None:
    """Strokes over the photograph that they were found in; one is about to be split."""
    window = opened(app, "plane", "en", dark=False)
    known = open_glyphs(None)
    sheet = sheet_of([known.load(one) for one in "永和"], 7, dry=0.8, longest=1200)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "sheet.png")
        Image.fromarray(photograph(sheet, 7, Camera(size=1600)).pixels).save(file)
        window.copying.layout_file(str(file), 40.0)

    def look() -> None:
        dialog = QtWidgets.QApplication.activeModalWidget()
        assert isinstance(dialog, StrokesDialog), "the button opens it"
        dialog.resize(1340, 820)
        live(0.5)
        for key in (QtCore.Qt.Key.Key_Right, QtCore.Qt.Key.Key_S):
            QtWidgets.QApplication.sendEvent(
                dialog, QtGui.QKeyEvent(KIND.KeyPress, key, QtCore.Qt.KeyboardModifier.NoModifier)
            )
        live(0.5)
        dialog.grab().save(str(path))
        dialog.done(0)

    QtCore.QTimer.singleShot(1000, look)
    window.panels.copybook.correct_button.click()
    Image.open(path).convert("RGB").save(path, optimize=True)
    pretend_saved(window.stage.paint_thread)
    window.close()


_PICTURES = {
    "studio.png": demo, "studio_copybook.png": copybook, "studio_strokes.png": strokes,
}  # fmt: skip


def main() -> None:
    """Make the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs/gallery"))
    parser.add_argument("--only", choices=tuple(_PICTURES), help="(default: all)")
    options = parser.parse_args()
    try:  # before any window: one that an error leaves open ends the program in a fault
        options.out.mkdir(parents=True, exist_ok=True)
    except OSError as cause:
        parser.error(f"--out {options.out}: {cause.strerror}")
    with tempfile.TemporaryDirectory() as folder:
        os.environ.update(XDG_CONFIG_HOME=folder, PAINT3D_STATE=folder)
        app = make_program()
        for name, draw in _PICTURES.items():
            if options.only in (None, name):
                draw(app, options.out / name)


if __name__ == "__main__":
    main()
