"""What can be asked of the view and the window, each by the name of its action."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6 import QtCore, QtWidgets

from paint3d.app.window.dialogs.questions import KeysDialog, PreferencesDialog
from paint3d.app.window.input.steering import STEPS
from paint3d.app.window.wording import say

if TYPE_CHECKING:
    from paint3d.app.window.studio import StudioWindow

__all__ = ["ViewActions"]


class ViewActions:
    """For one window; ``do_<action>`` for each."""

    def __init__(self, window: StudioWindow) -> None:
        self._window = window

    def do_frame_all(self) -> None:
        """See the whole object."""
        self._window.hand.show_all()

    def do_frame_selected(self) -> None:
        """See what is under the pointer from near."""
        self._window.hand.show_place()

    def do_look_front(self) -> None:
        """See it from the front."""
        self._window.hand.look_from("front")

    def do_look_back(self) -> None:
        """See it from behind."""
        self._window.hand.look_from("back")

    def do_look_left(self) -> None:
        """See it from the left."""
        self._window.hand.look_from("left")

    def do_look_right(self) -> None:
        """See it from the right."""
        self._window.hand.look_from("right")

    def do_look_top(self) -> None:
        """See it from above."""
        self._window.hand.look_from("top")

    def do_look_bottom(self) -> None:
        """See it from below."""
        self._window.hand.look_from("bottom")

    def do_upright(self) -> None:
        """Roll the picture back."""
        self._window.steering.upright()

    def do_grips(self, on: bool) -> None:
        """Show the grips on the picture, or not."""
        self._window.steering.grips.shown = on
        self._window.canvas.update()

    def do_show_mask(self, on: bool) -> None:
        """Hatch where no paint is taken, or not."""
        self._window.stage.shows_mask = on

    def do_next_panel(self) -> None:
        """Go on to the next panel, with the keys."""
        self._window.panels.step(1)

    def do_previous_panel(self) -> None:
        """Go back to the panel before, with the keys."""
        self._window.panels.step(-1)

    def do_menus(self) -> None:
        """Open the first menu, with the keys."""
        bar = self._window.menuBar()
        bar.setActiveAction(bar.actions()[0])

    def do_brush(self, on: bool) -> None:
        """Draw the brush, or not."""
        self._window.stage.shows_brush = on
        if not on:
            self._window.stage.hide_brush()

    def do_panels(self) -> None:
        """Hide all panels, or show them again."""
        self._window.panels.toggle()

    def do_full_screen(self, on: bool) -> None:
        """Fill the screen, or not."""
        self._window.showFullScreen() if on else self._window.showNormal()

    def do_dark(self, on: bool) -> None:
        """Change the theme."""
        self._window.set_dark(on)
        self._window.keep(theme="dark" if on else "light")

    def do_preferences(self) -> None:
        """Ask for language, theme, units, and how much is kept."""
        window = self._window
        dialog = PreferencesDialog(window, window.settings)
        if not dialog.exec():
            return
        before, chosen = window.settings, dialog.chosen()
        window.keep(**chosen)
        window.hand.set_settings(pressure_by=chosen["pressure_by"])
        window.canvas.finger = chosen["finger"]
        window.show_unit()
        easel = window.stage.easel
        if easel is not None:
            easel.keep_every(window.settings.autosave_s)
        if chosen["wet"] != before.wet and easel is not None:
            wet = window.settings.wants_wet(window.document.surface.material)
            with QtCore.QSignalBlocker(window.actions_by_name["wet"]):
                window.actions_by_name["wet"].setChecked(wet)
            easel.wet = wet
        if chosen["theme"] != before.theme:
            window.actions_by_name["dark"].setChecked(window.wants_dark())
        if chosen["language"] != before.language:
            window.tell(say("The language changes with the next start"))

    def do_shortcuts(self) -> None:
        """Show all keys and gestures."""
        KeysDialog(self._window).exec()

    def do_about(self) -> None:
        """Say what this is."""
        from paint3d import __version__

        told = say(
            "Paint calligraphy on objects with a brush that bends, spreads and runs dry as a real "
            "one does."
        )
        QtWidgets.QMessageBox.about(self._window, "paint3d", f"paint3d {__version__}\n\n{told}")


for _step in STEPS:
    setattr(
        ViewActions,
        f"do_{_step}",
        lambda self, step=_step: self._window.steering.step(step),
    )
