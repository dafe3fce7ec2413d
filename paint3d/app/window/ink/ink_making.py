"""Inks of one's own in the studio: any colour as a mixture, tables of pigments, pick-up."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from PySide6 import QtWidgets

from paint3d.app.model.held_ink import held_ink
from paint3d.app.model.persistence.own_pigments import fingerprint_of, own_pigments
from paint3d.app.window.ink.colour_dialog import ColourDialog
from paint3d.app.window.panels import Panels
from paint3d.app.window.wording import say, say_error
from paint3d.app.window.workspace import Workspace
from paint3d.calligraphy.dips import LEAST_LOAD
from paint3d.colour.nearest_mixture import Nearest
from paint3d.colour.pigments import load_pigments_csv
from paint3d.errors import Paint3DError

__all__ = ["InkMaking"]


class InkMaking:
    """For one window; ``do_<action>`` for each.

    Attributes
    ----------
    dialog : ColourDialog or None
        That was opened last.
    """

    def __init__(self, workspace: Workspace, panels: Panels) -> None:
        self._workspace, self._panels = workspace, panels
        self.dialog: ColourDialog | None = None
        workspace.opened.connect(lambda _: self.close_down())  # mixed for another ground
        panels.inks.colour_asked.connect(self.do_choose_colour)
        panels.inks.table_asked.connect(self.do_open_pigments)
        panels.inks.pickup_chosen.connect(lambda share: workspace.post("set_pickup", share))
        panels.inks.amount_chosen.connect(self._choose_amount)
        panels.inks.by_itself_chosen.connect(lambda on: workspace.keep(dips_by_itself=on))
        panels.inks.show_by_itself(workspace.settings.dips_by_itself)
        workspace.hand.began.connect(self._dip_by_itself)
        self._take_kept()

    def _choose_amount(self, words: Mapping[str, float] | None) -> None:
        self._workspace.amount = words

    def _dip_by_itself(self) -> None:
        """Before a stroke: dip the brush where too little of the last dip is left, if wanted.

        One that was rinsed stays so: it holds nothing, which none that only ran dry does.
        """
        workspace = self._workspace
        if not workspace.settings.dips_by_itself:
            return
        held = held_ink(workspace.document.painter)
        if 0.0 < held.share < LEAST_LOAD:
            workspace.dip()
            told = say("Dipped by itself: {percent:.0f} % was left", percent=100 * held.share)
            workspace.tell(told)

    def _take_kept(self) -> None:
        """Put the pigments of the tables that were opened before among the dishes."""
        tables = self._workspace.settings.pigment_tables
        if not tables:
            return
        own = own_pigments(tables)
        self._panels.inks.add_pigments(own.pigments.values(), "settings")
        if own.tables != tables:
            self._workspace.keep(pigment_tables=own.tables)
        if own.problems:
            self._workspace.tell_first("; ".join(map(say_error, own.problems)))

    def do_choose_colour(self) -> None:
        """Let a colour be chosen, and mix what comes nearest."""
        self.close_down()
        workspace, inks = self._workspace, self._panels.inks
        ground = workspace.document.surface.material.reflectance
        dialog = self.dialog = ColourDialog(
            workspace.window, workspace.theme, ground, tuple(inks.dishes.pigments.values())
        )
        dialog.mixed.connect(self._mix)
        dialog.dipped.connect(self._dip)
        dialog.show()

    def close_down(self) -> None:
        """Close the dialog, if it is open."""
        if self.dialog is not None:
            self.dialog.close()
            self.dialog.deleteLater()
            self.dialog = None

    def _mix(self, nearest: Nearest) -> None:
        self._panels.inks.show_mixture(nearest.parts)

    def _dip(self, nearest: Nearest) -> None:
        self._mix(nearest)
        self._panels.inks.dip_mixture()

    def do_open_pigments(self) -> None:
        """Ask for a table of pigments, and put them among the dishes."""
        path, _ = QtWidgets.QFileDialog.getOpenFileName(
            self._workspace.window,
            say("Open a table of pigments…").rstrip("…"),
            "",
            f"{say('Tables of pigments')} (*.csv);;{say('All files')} (*)",
        )
        if path:
            self.open_table(path)

    def open_table(self, path: str | Path) -> bool:
        """Put the pigments of a table among the dishes; what is wrong is told in one line."""
        kept = self._workspace.settings.pigment_tables
        try:
            self._panels.inks.add_pigments(load_pigments_csv(path).values(), str(path))
            table = {os.path.abspath(path): fingerprint_of(path)}
            self._workspace.keep(pigment_tables={**kept, **table})
        except Paint3DError as error:
            self._workspace.tell(say_error(error), state="bad", stays=True)
            return False
        return True

    def do_forget_pigments(self) -> None:
        """Take all pigments of one's own off the dishes; their tables are read no more."""
        self.close_down()
        self._panels.inks.put_away_own()
        self._workspace.keep(pigment_tables={})
        self._workspace.tell(say("Pigments of your own are put away; their files stay"))
