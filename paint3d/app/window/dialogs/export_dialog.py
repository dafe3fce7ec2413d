"""What can be chosen when a painting is exported: what its format knows, and no more."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6 import QtWidgets

from paint3d.app.window.dialogs.forms import FormDialog, SizeBoxes, kept_number
from paint3d.app.window.wording import say
from paint3d.files.export import FORMATS
from paint3d.files.export_options import MOST_FILAMENTS, UP_AXES
from paint3d.files.load import UNITS_MM

__all__ = ["ExportDialog", "kept_options"]

_PICTURES = (".png", ".jpg")
_STUDIO_SIZE = (1600, 1200)
_TEXTURES = (1024, 2048, 4096, 8192)
_QUALITY = 92
_FILAMENTS = 6


def kept_options(kept: Mapping[str, object], suffix: str) -> Mapping[str, object]:
    """What was chosen last for a format, of all that was kept."""
    own = kept.get(suffix)
    return own if isinstance(own, Mapping) else {}


class ExportDialog(FormDialog):
    """Ask how a format is to be written.

    Parameters
    ----------
    parent : QWidget
    suffix : str
        Of the format: one of `FORMATS`, or ".jpg".
    kept : mapping
        What `chosen` returned the last time.
    screen : (int, int)
        Width and height of the picture on the screen, pixels.
    """

    def __init__(
        self,
        parent: QtWidgets.QWidget,
        suffix: str,
        kept: Mapping[str, object],
        screen: tuple[int, int],
    ) -> None:
        super().__init__(parent, f"{say('action.export').rstrip('…')}  {suffix}")
        self.suffix, self._kept, self._screen = suffix, kept, screen
        self._takes = FORMATS[suffix].takes if suffix in FORMATS else frozenset()
        self.boxes: dict[str, QtWidgets.QWidget] = {}
        if suffix in _PICTURES:
            self._add_picture()
        else:
            self._add_mesh()
        self._add_filaments()
        self.finish("button.save")
        self._follow()

    # -- rows -------------------------------------------------------------------------------

    def _add_picture(self) -> None:
        views = {"screen": say("As on the screen")}
        if self.suffix in FORMATS:
            views["studio"] = say("The painted side, in the studio's light")
        view = self.add_box(say("menu.view"), views, self._kept.get("view"))
        self.boxes["view"] = view
        size = self._kept_size(self._screen)
        self.boxes["size"] = SizeBoxes(size, self._screen)
        self.form.addRow(say("Size in pixels"), self.boxes["size"])
        if self.suffix == ".jpg":
            quality = kept_number(self._kept, "quality", _QUALITY)
            self.boxes["quality"] = self.add_number(say("Quality"), 1, 100, quality, "%")
        view.currentIndexChanged.connect(self._view_chosen)

    def _kept_size(self, default: tuple[int, int]) -> tuple[int, int]:
        kept = self._kept.get("size")
        usable = isinstance(kept, list | tuple) and len(kept) == 2
        return tuple(kept) if usable and all(isinstance(n, int) for n in kept) else default

    def _view_chosen(self) -> None:
        """Begin with the size that is usual for a view."""
        boxes = self.boxes["size"]
        boxes.kept.setChecked(self.is_of_screen)
        width, height = self._screen if self.is_of_screen else _STUDIO_SIZE
        boxes.width_box.setValue(width)
        boxes.height_box.setValue(height)
        self._follow()

    def _add_mesh(self) -> None:
        if "unit" in self._takes:
            own = say("As the format has it")
            units = {None: own} | {unit: say(f"unit.{unit}") for unit in UNITS_MM}
            self.boxes["unit"] = self.add_box(say("Unit"), units, self._kept.get("unit"))
            axes = {None: own} | {axis: axis.upper() for axis in UP_AXES}
            self.boxes["up_axis"] = self.add_box(say("Up"), axes, self._kept.get("up_axis"))
        if "texture" in self._takes:
            ways = {False: say("At the vertices"), True: say("As a texture")}
            ways |= {n: say("As a texture of {n} pixels", n=n) for n in _TEXTURES}
            kept = self._kept.get("texture", False)
            self.boxes["texture"] = self.add_box(say("Colours"), ways, kept)
            self.boxes["texture"].currentIndexChanged.connect(self._follow)
        tolerance = kept_number(self._kept, "tolerance", 1.0)
        self.boxes["tolerance"] = self.add_number(
            say("Colours may miss by"), 0.0, 20.0, tolerance, "ΔE", 1
        )
        self.boxes["exact"] = self.add_check(
            say("Every vertex, none left out"), self._kept.get("exact") is True
        )
        self.boxes["exact"].toggled.connect(self._follow)
        if "unlit" in self._takes:
            on = self._kept.get("unlit") is True
            self.boxes["unlit"] = self.add_check(say("Colours as they are, without light"), on)
        if "packed_normals" in self._takes:
            on = self._kept.get("packed_normals") is True
            self.boxes["packed_normals"] = self.add_check(say("Normals in one number"), on)

    def _add_filaments(self) -> None:
        if "filaments" not in self._takes:
            return
        kept = self._kept.get("filaments")
        count = kept if isinstance(kept, int) and 1 <= kept <= MOST_FILAMENTS else None
        on = self.add_check(say("Few colours, one for each triangle"), count is not None)
        number = self.add_number(say("How many"), 1, MOST_FILAMENTS, count or _FILAMENTS)
        self.boxes |= {"few": on, "filaments": number}
        on.toggled.connect(self._follow)

    def _follow(self, _: object = None) -> None:
        """Let only that be chosen which has an effect beside the rest."""
        boxes = self.boxes
        few = "few" in boxes and boxes["few"].isChecked()
        if "few" in boxes:
            possible = not self.is_of_screen and not self._has_texture()
            boxes["few"].setEnabled(possible)
            boxes["filaments"].setEnabled(possible and few)
        if "texture" in boxes:
            boxes["texture"].setEnabled(not few)
        if "tolerance" in boxes:
            whole = boxes["exact"].isChecked() or self._has_texture()
            boxes["tolerance"].setEnabled(not whole and not few)
            boxes["exact"].setEnabled(not self._has_texture())

    def _has_texture(self) -> bool:
        box = self.boxes.get("texture")
        return box is not None and box.currentData() is not False

    # -- what was chosen --------------------------------------------------------------------

    @property
    def is_of_screen(self) -> bool:
        """Whether the picture is the one on the screen."""
        return "view" in self.boxes and self.boxes["view"].currentData() == "screen"

    def size(self) -> tuple[int, int]:
        """Of a picture, pixels."""
        result: tuple[int, int] = self.boxes["size"].size_in_pixels()
        return result

    def quality(self) -> int:
        """Of a JPEG, 1 to 100."""
        return round(self.boxes["quality"].value()) if "quality" in self.boxes else _QUALITY

    def options(self) -> dict[str, object]:
        """What `ExportOptions` takes."""
        if self.suffix in _PICTURES:
            options: dict[str, object] = {"size": self.size()}
        else:
            options = {"exact": self.boxes["exact"].isChecked()}
            options["tolerance"] = self.boxes["tolerance"].value()
        for name in ("unit", "up_axis", "texture"):
            if name in self.boxes:
                options[name] = self.boxes[name].currentData()
        for name in ("unlit", "packed_normals"):
            if name in self.boxes:
                options[name] = self.boxes[name].isChecked()
        if "few" in self.boxes and self.boxes["few"].isChecked() and self.boxes["few"].isEnabled():
            options["filaments"] = round(self.boxes["filaments"].value())
        return options

    def chosen(self) -> dict[str, object]:
        """Everything, as JSON can hold it, to begin with the next time."""
        if self.suffix not in _PICTURES:
            return self.options()
        kept = {"view": self.boxes["view"].currentData(), "size": list(self.size())}
        if "quality" in self.boxes:
            kept["quality"] = self.quality()
        return kept
