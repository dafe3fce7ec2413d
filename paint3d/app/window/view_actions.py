"""Commands of the view and the window, each by the name of its action."""

from __future__ import annotations

from PySide6 import QtCore, QtWidgets

from paint3d.app.window.hand.pen_test import PenTestDialog
from paint3d.app.window.hand.steering import STEPS, Steering
from paint3d.app.window.panels import Panels
from paint3d.app.window.questions import KeysDialog, PreferencesDialog
from paint3d.app.window.wording import choose_unit, say
from paint3d.app.window.workspace import Workspace

__all__ = ["ViewActions"]


class ViewActions:
    """Commands of the view, the panels and the window; ``do_<action>`` for each."""

    def __init__(self, workspace: Workspace, panels: Panels, steering: Steering) -> None:
        self._workspace, self._panels, self._steering = workspace, panels, steering

    def do_frame_all(self) -> None:
        """Show the whole object."""
        self._workspace.hand.show_all()

    def do_frame_selected(self) -> None:
        """Show the point under the pointer from near."""
        self._workspace.hand.show_place()

    def do_look_front(self) -> None:
        """Show it from the front."""
        self._workspace.hand.look_from("front")

    def do_look_back(self) -> None:
        """Show it from behind."""
        self._workspace.hand.look_from("back")

    def do_look_left(self) -> None:
        """Show it from the left."""
        self._workspace.hand.look_from("left")

    def do_look_right(self) -> None:
        """Show it from the right."""
        self._workspace.hand.look_from("right")

    def do_look_top(self) -> None:
        """Show it from above."""
        self._workspace.hand.look_from("top")

    def do_look_bottom(self) -> None:
        """Show it from below."""
        self._workspace.hand.look_from("bottom")

    def do_upright(self) -> None:
        """Roll the view upright."""
        self._steering.upright()

    def do_grips(self, on: bool) -> None:
        """Show the grips on the picture, or not."""
        self._steering.grips.shown = on
        self._workspace.canvas.update()

    def do_show_mask(self, on: bool) -> None:
        """Hatch where no paint is taken, or not."""
        self._workspace.stage.shows_mask = on

    def do_next_panel(self) -> None:
        """Go on to the next panel, with the keys."""
        self._panels.step(1)

    def do_previous_panel(self) -> None:
        """Go back to the panel before, with the keys."""
        self._panels.step(-1)

    def do_menus(self) -> None:
        """Open the first menu, with the keys."""
        bar = self._workspace.window.menuBar()
        bar.setActiveAction(bar.actions()[0])

    def do_brush(self, on: bool) -> None:
        """Draw the brush, or not."""
        self._workspace.stage.shows_brush = on
        if not on:
            self._workspace.stage.hide_brush()

    def do_panels(self) -> None:
        """Hide all panels, or show them again."""
        self._panels.toggle()

    def do_full_screen(self, on: bool) -> None:
        """Fill the screen, or not."""
        window = self._workspace.window
        window.showFullScreen() if on else window.showNormal()

    def do_dark(self, on: bool) -> None:
        """Change the theme."""
        self._workspace.set_dark(on)
        self._workspace.update_settings(theme="dark" if on else "light")

    def do_test_pen(self) -> None:
        """Show what a pen reports."""
        workspace = self._workspace
        PenTestDialog(workspace.window, workspace.theme, workspace.settings.curve).exec()

    def do_preferences(self) -> None:
        """Ask for language, theme, units and the other settings, and apply them."""
        workspace = self._workspace
        dialog = PreferencesDialog(workspace.window, workspace.settings)
        if not dialog.exec():
            return
        before, chosen = workspace.settings, dialog.chosen()
        workspace.update_settings(**chosen)
        workspace.hand.set_settings(pressure_by=chosen["pressure_by"])
        self._panels.hand.show_settings(workspace.hand.settings)
        workspace.canvas.finger = workspace.settings.finger
        choose_unit(workspace.settings.unit)
        self._panels.show_unit()
        workspace.canvas.update()
        paint_thread = workspace.stage.paint_thread
        if paint_thread is not None:
            paint_thread.set_autosave_interval(workspace.settings.autosave_s)
        if chosen["wet"] != before.wet and paint_thread is not None:
            wet = workspace.settings.wants_wet(workspace.painting.material)
            with QtCore.QSignalBlocker(workspace.actions["wet"]):
                workspace.actions["wet"].setChecked(wet)
            paint_thread.wet = wet
        if chosen["theme"] != before.theme:
            workspace.actions["dark"].setChecked(workspace.wants_dark())
        if chosen["language"] != before.language:
            workspace.tell(say("The language changes with the next start"))

    def do_quit(self) -> None:
        """Close the window."""
        self._workspace.window.close()

    def do_shortcuts(self) -> None:
        """Show all keys and gestures."""
        KeysDialog(self._workspace.window).exec()

    def do_about(self) -> None:
        """Show the program's version."""
        from paint3d import __version__

        message = say(
            "Paint calligraphy on objects with a brush that bends, spreads and runs dry as a real "
            "one does."
        )
        QtWidgets.QMessageBox.about(
            self._workspace.window, "paint3d", f"paint3d {__version__}\n\n{message}"
        )


for _step in STEPS:
    setattr(
        ViewActions,
        f"do_{_step}",
        lambda self, step=_step: self._steering.step(step),
    )
