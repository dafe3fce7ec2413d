"""Exporting the painting in the formats of other programs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from paint3d.app.window.dialogs.export_dialog import ExportDialog, kept_options
from paint3d.app.window.dialogs.target_dialog import Targets
from paint3d.app.window.jobs.job import Progress, result_of
from paint3d.app.window.jobs.pictures import Pictures
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.files.export import EXPORT_SUFFIXES
from paint3d.files.export_options import ExportOptions
from paint3d.files.progress import part_of
from paint3d.files.project.session import SESSION_SUFFIX

__all__ = ["FORMATS", "Exporting"]

# What a file may be, by its ending, and how the dialog says it:
FORMATS = {
    ".glb": "glTF, for the web and most programs",
    ".ply": "PLY",
    ".obj": "Wavefront OBJ",
    ".3mf": "3MF, for printers",
    ".usdz": "USDZ, for Apple's devices",
    ".html": "Page that shows the object",
    ".png": "Picture, PNG",
    ".jpg": "Picture, JPEG",
    ".p3d.txt": "Records of the vertices",
    SESSION_SUFFIX: "Copy of the painting",
}
_TAKEN = 0.5  # of an export's time, about, until the painting may go on


class Exporting:
    """For one window."""

    def __init__(self, workspace: Workspace, targets: Targets, pictures: Pictures) -> None:
        self._workspace, self._targets, self._pictures = workspace, targets, pictures

    def do_export(self) -> None:
        """Ask for a name and a format, then for what can be chosen in that format; write it."""
        workspace = self._workspace
        kept = workspace.settings.exports
        path = self._targets.ask(say("action.export"), FORMATS, str(kept.get("format", "")))
        if path is None:
            return
        name = path.name.lower()
        suffix = max((s for s in FORMATS if name.endswith(s)), key=len)
        if suffix == SESSION_SUFFIX:
            self.export_to(path)
            return
        dialog = ExportDialog(
            workspace.window, suffix, kept_options(kept, suffix), workspace.canvas.pixel_size
        )
        if not dialog.exec():
            return
        workspace.keep(exports={**kept, "format": suffix, suffix: dialog.chosen()})
        if dialog.is_of_screen:
            self._pictures.picture_to(path, dialog.picture_size(), dialog.quality())
        else:
            self.export_to(path, **dialog.options())

    def export_to(self, path: Path, **options: Any) -> bool:
        """Write the painting in another format; say whether that went well.

        Parameters
        ----------
        path : Path
            Its suffix says the format.
        **options
            See `ExportOptions`.
        """
        workspace, clipped = self._workspace, list[int]()
        if path.name.lower().endswith(EXPORT_SUFFIXES) and path.suffix.lower() != SESSION_SUFFIX:
            work = self._beside(path, options, clipped)
        else:
            work = self._by_the_easel(path)
        if not workspace.went_well(workspace.run(say("Writing {name}…", name=path.name), work)):
            return False
        told = say("status.exported", name=path.name)
        if sum(clipped):
            n = f"{sum(clipped):,}"
            told += " " + say("{n} colours do not fit in and are the nearest that do.", n=n)
        workspace.tell(told, state="good")
        return True

    def _by_the_easel(self, path: Path) -> Callable[[Progress], None]:
        """Write it while nothing is painted."""
        easel = self._workspace.easel

        def work(progress: Progress) -> None:
            result_of(easel.post("export", path, progress=progress), progress)

        return work

    def _beside(
        self, path: Path, options: Mapping[str, Any], clipped: list[int]
    ) -> Callable[[Progress], None]:
        """Take what is needed from the painting, then write it while that may go on.

        How many colours did not fit in, is added to `clipped`.
        """
        easel = self._workspace.easel

        def work(progress: Progress) -> None:
            taken = part_of(progress, 0.0, _TAKEN)
            asked = easel.post("prepare_export", path, ExportOptions(**options), taken)
            prepared = result_of(asked, progress)
            clipped.append(prepared.painting.n_clipped)
            prepared.write(part_of(progress, _TAKEN, 1.0))

        return work
