"""The user's own brushes: the editor, files, and the list of those that are saved."""

from __future__ import annotations

from pathlib import Path

from paint3d.app.model.persistence.own_brushes import keep_brush, own_brush_folder, own_brushes
from paint3d.app.window.brush.brush_editor import BrushEditor
from paint3d.app.window.files.file_dialogs import ask_file
from paint3d.app.window.panels import Panels
from paint3d.app.window.wording import say, say_error
from paint3d.app.window.workspace import Workspace
from paint3d.brush.presets import load_presets, read_brush
from paint3d.brush.spec import BrushSpec
from paint3d.errors import Paint3DError
from paint3d.painter.painter import Ink

__all__ = ["BrushMaking"]


class BrushMaking:
    """Commands that edit and open brushes; ``do_<action>`` for each.

    Attributes
    ----------
    editor : BrushEditor or None
        That was opened last.
    """

    def __init__(self, workspace: Workspace, panels: Panels) -> None:
        self._workspace, self._panels = workspace, panels
        self.editor: BrushEditor | None = None
        panels.brushes.edit.connect(self.do_edit_brush)
        panels.brushes.open_file.connect(self.do_open_brush)
        panels.brushes.inked.connect(self._follow_ink)
        panels.brushes.favoured.connect(
            lambda names: workspace.update_settings(favourite_brushes=names)
        )
        panels.brushes.filed.connect(
            lambda folders: workspace.update_settings(brush_folders=folders)
        )
        self._load_own()

    def _load_own(self) -> None:
        """List the saved brushes; show the first problem with them."""
        own, problems = own_brushes()
        self._panels.brushes.show_own(own)
        self._panels.brushes.show_favourites(self._workspace.settings.favourite_brushes)
        self._panels.brushes.show_folders(self._workspace.settings.brush_folders)
        for problem in problems[:1]:
            self._workspace.tell_first(say_error(problem))

    # -- the editor -------------------------------------------------------------------------

    def do_edit_brush(self) -> None:
        """Open the editor on the brush in hand."""
        self.close_down()
        workspace, panels = self._workspace, self._panels
        editor = self.editor = BrushEditor(
            workspace.window, workspace.theme, panels.brushes.brush, panels.inks.ink
        )
        editor.taken.connect(self._take)
        editor.kept.connect(self._keep)
        editor.show()

    def close_down(self) -> None:
        """Close the editor, if it is open."""
        if self.editor is not None:
            self.editor.close()
            self.editor.deleteLater()
            self.editor = None

    def _follow_ink(self, ink: Ink) -> None:
        if self.editor is not None and self.editor.isVisible():
            self.editor.set_ink(ink)

    def _take(self, brush: BrushSpec) -> None:
        self._panels.brushes.add_own(brush)
        self._panels.brushes.chosen.emit(brush)

    def _keep(self, brush: BrushSpec) -> None:
        try:
            path = keep_brush(brush)
        except Paint3DError as error:
            if self.editor is not None:
                self.editor.show_message(error)
            return
        self._take(brush)
        message = say("{name} is saved in {path}", name=brush.name, path=path)
        self._workspace.tell(message, state="good")
        if self.editor is not None:
            self.editor.show_message(message)

    # -- files ------------------------------------------------------------------------------

    def do_open_brush(self) -> None:
        """Ask for a brush file, and paint with it."""
        folder = own_brush_folder()
        path = ask_file(
            self._workspace.window,
            say("Open a brush…").rstrip("…"),
            f"{say('Brush files')} (*.toml *.json);;{say('All files')} (*)",
            str(folder) if folder.is_dir() else "",
        )
        if path:
            self.open_file(path)

    def open_file(self, path: str | Path) -> bool:
        """Paint with the brush of a file; show a fault; return whether that succeeded."""
        try:
            brush = read_brush(path, load_presets())
        except Paint3DError as error:
            self._workspace.tell(say_error(error), state="bad", stays=True)
            return False
        self._take(brush)
        return True
