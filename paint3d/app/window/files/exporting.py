"""Exporting the painting in other programs' formats, each with the options that it has."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from PySide6 import QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.window.files.target_dialog import Targets
from paint3d.app.window.forms import LEAST_PIXELS, FormDialog, SizeBoxes, stored_number
from paint3d.app.window.job import JobProgress, result_of
from paint3d.app.window.playing.pictures import Pictures
from paint3d.app.window.wording import say, say_units
from paint3d.app.window.workspace import Workspace
from paint3d.colour.viewing import GAMUTS, Viewing
from paint3d.errors import Message
from paint3d.files.export import EXPORT_SUFFIXES, FORMATS
from paint3d.files.export_options import MOST_FILAMENTS, UP_AXES, ExportOptions
from paint3d.files.pictures import write_picture
from paint3d.files.progress import part_of
from paint3d.files.project.session import SESSION_SUFFIX
from paint3d.mesh.sheet_mesh import sheet_of
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.view.shot import AUTO, FLAT, UNLIT, Shot, flat_size

__all__ = [
    "FORMAT_NAMES",
    "ExportDialog",
    "Exporting",
    "stored_options",
]

# ---- The dialog ----------------------------------------------------------------------------------


_PICTURES = (".png", ".jpg")
_STUDIO_SIZE = (1600, 1200)
_VIEWS = {
    "front": Message("From the front"),
    "right": Message("From the right"),
    "back": Message("From behind"),
    "left": Message("From the left"),
    "above": Message("From the front and above"),
    "top": Message("From above"),
    FLAT: Message("The sheet to its edges, without light"),
}
_LIGHTS = {
    "studio": Message("Studio"),
    "soft": Message("Overcast sky"),
    "raking": Message("Low from the left"),
    UNLIT: Message("Flat: colours as they were painted"),
}
_TEXTURES = (1024, 2048, 4096, 8192)
_QUALITY = 92
_FILAMENTS = 6


def stored_options(stored: Mapping[str, object], suffix: str) -> Mapping[str, object]:
    """Return the options that were chosen last for a format."""
    own = stored.get(suffix)
    return own if isinstance(own, Mapping) else {}


class ExportDialog(FormDialog):
    """Asks for a format's options.

    Parameters
    ----------
    parent : QWidget
    suffix : str
        Of the format: one of `FORMATS`, or ".jpg".
    stored : mapping
        The last result of `chosen`.
    screen : (int, int)
        Width and height of the picture on the screen, pixels.
    sheet : (float, float), optional
        Width and height of the sheet that is painted on, mm.
    """

    def __init__(
        self,
        parent: QtWidgets.QWidget,
        suffix: str,
        stored: Mapping[str, object],
        screen: tuple[int, int],
        sheet: tuple[float, float] | None = None,
    ) -> None:
        super().__init__(parent, f"{say('Export…').rstrip('…')}  {suffix}")
        self.suffix, self._stored, self._screen, self._sheet = suffix, stored, screen, sheet
        self._takes = FORMATS[suffix].takes if suffix in FORMATS else frozenset()
        self.choices: dict[str, QtWidgets.QComboBox] = {}
        self.checks: dict[str, QtWidgets.QCheckBox] = {}
        self.numbers: dict[str, QtWidgets.QDoubleSpinBox] = {}
        self.size_boxes: SizeBoxes | None = None
        if suffix in _PICTURES:
            self._add_picture()
        else:
            self._add_mesh()
        self._add_gamut()
        self._add_filaments()
        self.finish(say("Save"))
        self._follow()

    # -- rows -------------------------------------------------------------------------------

    def _add_picture(self) -> None:
        views = {"screen": say("As on the screen")}
        if self.suffix in FORMATS:
            views["studio"] = say("The painted side, in the studio's light")
            views |= {name: say(text) for name, text in _VIEWS.items()}
        flat = FLAT if self._sheet is not None and FLAT in views else None
        view = self.add_box(say("View"), views, self._stored.get("view", flat))
        self.choices["view"] = view
        size = self._usual_size()
        match self._stored.get("size"):
            case [int(width), int(height)]:
                size = width, height
        self.size_boxes = SizeBoxes(size, self._screen)
        self.form.addRow(say("Size in pixels"), self.size_boxes)
        if self.suffix == ".jpg":
            quality = stored_number(self._stored, "quality", _QUALITY)
            self.numbers["quality"] = self.add_number(say("Quality"), 1, 100, quality, "%")
        if self.suffix in FORMATS:
            lights = {name: say(text) for name, text in _LIGHTS.items()}
            self.choices["light"] = self.add_box(say("Light"), lights, self._stored.get("light"))
            self._add_stored_check("transparent", say("Without ground and background"))
        view.currentIndexChanged.connect(self._view_chosen)

    def _view_chosen(self) -> None:
        """Show the size that is usual for the chosen view."""
        boxes = self._sizes()
        boxes.keeps_ratio.setChecked(self.is_of_screen)
        width, height = self._usual_size()
        boxes.width_box.setValue(width)
        boxes.height_box.setValue(height)
        self._follow()

    def _usual_size(self) -> tuple[int, int]:
        """Return the size that is usual for the view, pixels."""
        if self._sheet is not None and self.choices["view"].currentData() == FLAT:
            width, height = flat_size(*self._sheet)
            return max(LEAST_PIXELS, width), max(LEAST_PIXELS, height)
        return self._screen if self.is_of_screen else _STUDIO_SIZE

    def _add_mesh(self) -> None:
        if "unit" in self._takes:
            own = say("As the format has it")
            units = {None: own} | say_units()
            self.choices["unit"] = self.add_box(say("Unit"), units, self._stored.get("unit"))
            axes = {None: own} | {axis: axis.upper() for axis in UP_AXES}
            self.choices["up_axis"] = self.add_box(say("Up"), axes, self._stored.get("up_axis"))
        if "texture" in self._takes:
            choices: dict[bool | int, str] = {
                False: say("At the vertices"),
                True: say("As a texture"),
            }
            choices |= {n: say("As a texture of {n} pixels", n=n) for n in _TEXTURES}
            where = self._stored.get("texture", False)
            self.choices["texture"] = self.add_box(say("Colours"), choices, where)
            self.choices["texture"].currentIndexChanged.connect(self._follow)
        tolerance = stored_number(self._stored, "tolerance", 1.0)
        self.numbers["tolerance"] = self.add_number(
            say("Colours may miss by"), 0.0, 20.0, tolerance, "ΔE", 1
        )
        self._add_stored_check("exact", say("Every vertex, none left out"))
        self.checks["exact"].toggled.connect(self._follow)
        if "unlit" in self._takes:
            self._add_stored_check("unlit", say("Colours as they are, without light"))
        if "packed_normals" in self._takes:
            self._add_stored_check("packed_normals", say("Normals in one number"))

    def _add_stored_check(self, name: str, text: str) -> None:
        self.checks[name] = self.add_check(text, self._stored.get(name) is True)

    def _add_gamut(self) -> None:
        if "gamut" in self._takes:
            screens = {name: gamut.title for name, gamut in GAMUTS.items()}
            gamut_name = self._stored.get("gamut", "srgb")
            self.choices["gamut"] = self.add_box(say("Colours of a screen"), screens, gamut_name)

    def _add_filaments(self) -> None:
        if "filaments" not in self._takes:
            return
        stored = self._stored.get("filaments")
        count = stored if isinstance(stored, int) and 1 <= stored <= MOST_FILAMENTS else None
        on = self.add_check(say("Few colours, one for each triangle"), count is not None)
        number = self.add_number(say("How many"), 1, MOST_FILAMENTS, count or _FILAMENTS)
        self.checks["few"], self.numbers["filaments"] = on, number
        on.toggled.connect(self._follow)

    def _follow(self, _: object = None) -> None:
        """Enable only options that have an effect together with the others."""
        few = self._is_on("few")
        if "few" in self.checks:
            possible = not self.is_of_screen and not self._has_texture()
            self.checks["few"].setEnabled(possible)
            self.numbers["filaments"].setEnabled(possible and few)
        if "texture" in self.choices:
            self.choices["texture"].setEnabled(not few)
        if "gamut" in self.choices:
            self.choices["gamut"].setEnabled(not self.is_of_screen)
        if "light" in self.choices:
            is_flat = self.choices["view"].currentData() == FLAT
            self.choices["light"].setEnabled(not self.is_of_screen and not is_flat)
            self.checks["transparent"].setEnabled(not self.is_of_screen)
        if "tolerance" in self.numbers:
            whole = self._is_on("exact") or self._has_texture()
            self.numbers["tolerance"].setEnabled(not whole and not few)
            self.checks["exact"].setEnabled(not self._has_texture())

    def _is_on(self, name: str) -> bool:
        return name in self.checks and self.checks[name].isChecked()

    def _has_texture(self) -> bool:
        box = self.choices.get("texture")
        return box is not None and box.currentData() is not False

    # -- result -----------------------------------------------------------------------------

    @property
    def is_of_screen(self) -> bool:
        """True if the picture is the one on the screen."""
        return "view" in self.choices and self.choices["view"].currentData() == "screen"

    @property
    def is_taken_otherwise(self) -> bool:
        """True for a picture with another view, light or ground than the studio's own."""
        if "light" not in self.choices or self._is_on("few"):
            return False
        return self.shot() != Shot(size=self.picture_size())

    def shot(self) -> Shot:
        """Return the chosen view and light, where they are not the screen's."""
        view = self.choices["view"].currentData()
        light = self.choices["light"].currentData() if "light" in self.choices else "studio"
        return Shot(
            AUTO if view == "studio" else view,
            self.picture_size(),
            light,
            self._is_on("transparent"),
        )

    def picture_size(self) -> tuple[int, int]:
        """Return a picture's size, pixels."""
        return self._sizes().size_in_pixels()

    def _sizes(self) -> SizeBoxes:
        assert self.size_boxes is not None, "a picture has a size"
        return self.size_boxes

    def quality(self) -> int:
        """Return a JPEG's quality, 1 to 100."""
        return round(self.numbers["quality"].value()) if "quality" in self.numbers else _QUALITY

    def options(self) -> dict[str, object]:
        """Return the arguments of `ExportOptions`."""
        options = self._plain_options()
        if "gamut" in self.choices and not self.is_of_screen:
            options["viewing"] = Viewing(gamut=self.choices["gamut"].currentData())
        return options

    def _plain_options(self) -> dict[str, object]:
        if self.suffix in _PICTURES:
            options: dict[str, object] = {"size": self.picture_size()}
        else:
            options = {"exact": self._is_on("exact")}
            options["tolerance"] = self.numbers["tolerance"].value()
        for name in ("unit", "up_axis", "texture"):
            if name in self.choices:
                options[name] = self.choices[name].currentData()
        for name in ("unlit", "packed_normals"):
            if name in self.checks:
                options[name] = self._is_on(name)
        if self._is_on("few") and self.checks["few"].isEnabled():
            options["filaments"] = round(self.numbers["filaments"].value())
        return options

    def chosen(self) -> dict[str, object]:
        """Return all choices, as JSON can hold them, to begin with the next time."""
        gamut = {n: box.currentData() for n, box in self.choices.items() if n == "gamut"}
        if self.suffix not in _PICTURES:
            return self._plain_options() | gamut
        choices: dict[str, object] = {
            "view": self.choices["view"].currentData(), "size": list(self.picture_size()), **gamut
        }  # fmt: skip
        if "quality" in self.numbers:
            choices["quality"] = self.quality()
        if "light" in self.choices:
            choices["light"] = self.choices["light"].currentData()
            choices["transparent"] = self._is_on("transparent")
        return choices


def _sheet_size(mesh: TriangleMesh) -> tuple[float, float] | None:
    """Return width and height of a sheet with its frame, mm; None for an object."""
    if sheet_of(mesh) is None:
        return None
    width, height, _ = np.ptp(mesh.vertices, axis=0)
    return float(width), float(height)


# ---- The work ------------------------------------------------------------------------------------


# Kinds of files by their suffix, as the dialog names them:
FORMAT_NAMES = {
    ".glb": Message("glTF, for the web and most programs"),
    ".ply": Message("PLY"),
    ".obj": Message("Wavefront OBJ"),
    ".3mf": Message("3MF, for printers"),
    ".usdz": Message("USDZ, for Apple's devices"),
    ".html": Message("Page that shows the object"),
    ".png": Message("Picture, PNG"),
    ".jpg": Message("Picture, JPEG"),
    ".p3d.txt": Message("Records of the vertices"),
    SESSION_SUFFIX: Message("Copy of the painting"),
}
_PICTURES_FIRST = {s: FORMAT_NAMES[s] for s in (*_PICTURES, *FORMAT_NAMES)}  # of a flat sheet
_TAKEN = 0.5  # of an export's time, about, until the painting may go on


class Exporting:
    """Asks for a name, a format and its options, and exports the painting."""

    def __init__(self, workspace: Workspace, targets: Targets, pictures: Pictures) -> None:
        self._workspace, self._targets, self._pictures = workspace, targets, pictures

    def do_export(self) -> None:
        """Ask for a name and a format, then for the format's options; write the file."""
        workspace = self._workspace
        stored = workspace.settings.exports
        extent = _sheet_size(workspace.painting.source)
        remembered = "format" if extent is None else "format of sheets"
        names = FORMAT_NAMES if extent is None else _PICTURES_FIRST
        path = self._targets.ask(say("Export…"), names, str(stored.get(remembered, "")))
        if path is None:
            return
        name = path.name.lower()
        suffix = max((s for s in FORMAT_NAMES if name.endswith(s)), key=len)
        if suffix == SESSION_SUFFIX:
            self.export_to(path)
            return
        dialog = ExportDialog(
            workspace.window, suffix, stored_options(stored, suffix), workspace.canvas.pixel_size,
            extent,
        )  # fmt: skip
        if not dialog.exec():
            return
        workspace.update_settings(exports={**stored, remembered: suffix, suffix: dialog.chosen()})
        if dialog.is_of_screen:
            self._pictures.picture_to(path, dialog.picture_size(), dialog.quality())
        elif dialog.is_taken_otherwise:
            self.shot_to(path, dialog.shot(), dialog.options().get("viewing"))
        else:
            self.export_to(path, **dialog.options())

    def export_to(self, path: Path, **options: Any) -> bool:
        """Write the painting in another format; return whether that succeeded.

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
            work = self._in_paint_thread(path)
        if not workspace.went_well(workspace.run(say("Writing {name}…", name=path.name), work)):
            return False
        message = say("Exported {name}", name=path.name)
        if sum(clipped):
            n = f"{sum(clipped):,}"
            message += " " + say("{n} colours do not fit in and are the nearest that do.", n=n)
        workspace.tell(message, state="good")
        return True

    def shot_to(self, path: Path, shot: Shot, viewing: Any = None) -> bool:
        """Write a picture by a named view and light; return whether that succeeded."""
        workspace = self._workspace
        paint_thread = workspace.paint_thread

        def work(progress: JobProgress) -> None:
            def write(document: Document) -> None:
                write_picture(document.surface, path, shot, progress=progress, viewing=viewing)

            result_of(paint_thread.post(write), progress)

        if not workspace.went_well(workspace.run(say("Writing {name}…", name=path.name), work)):
            return False
        workspace.tell(say("Exported {name}", name=path.name), state="good")
        return True

    def _in_paint_thread(self, path: Path) -> Callable[[JobProgress], None]:
        """Return work that writes it in the painting thread: nothing is painted meanwhile."""
        paint_thread = self._workspace.paint_thread

        def work(progress: JobProgress) -> None:
            result_of(paint_thread.post("export", path, progress=progress), progress)

        return work

    def _beside(
        self, path: Path, options: Mapping[str, Any], clipped: list[int]
    ) -> Callable[[JobProgress], None]:
        """Return work that copies what it needs of the painting, then writes beside it.

        The number of colours outside the gamut is appended to `clipped`.
        """
        paint_thread = self._workspace.paint_thread

        def work(progress: JobProgress) -> None:
            taken = part_of(progress, 0.0, _TAKEN)
            asked = paint_thread.post("prepare_export", path, ExportOptions(**options), taken)
            prepared = result_of(asked, progress)
            clipped.append(prepared.painting.n_clipped)
            prepared.write(part_of(progress, _TAKEN, 1.0))

        return work
