"""What can be chosen of a film: how long, how large, how many pictures a second."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from PySide6 import QtWidgets

from paint3d.app.window.dialogs.forms import FormDialog, SizeBoxes, kept_number
from paint3d.app.window.wording import say
from paint3d.view.film import MOST_PIXELS

__all__ = ["Film", "FilmDialog", "kept_film"]

_LONGEST_S, _FASTEST = 60.0, 30.0
_LEAST_PICTURES = 2


class Film(NamedTuple):
    """How a film is to be.

    A GIF counts hundredths of a second, so that not every rate is met exactly.
    """

    seconds: float = 5.0
    rate: float = 15.0
    size: tuple[int, int] | None = None  # pixels; None: as on the screen

    @property
    def n_pictures(self) -> int:
        """How many pictures it has."""
        return max(_LEAST_PICTURES, round(self.seconds * self.rate))

    @property
    def is_too_long(self) -> bool:
        """Whether its pictures take more memory than it may."""
        width, height = self.size or (0, 0)
        return width * height * self.n_pictures > MOST_PIXELS


def kept_film(kept: Mapping[str, object]) -> Film:
    """The film that was chosen last."""
    own = kept.get("film")
    own = own if isinstance(own, Mapping) else {}
    seconds = min(max(kept_number(own, "seconds", 5.0), 0.5), _LONGEST_S)
    rate = min(max(kept_number(own, "rate", 15.0), 1.0), _FASTEST)
    width, height = (round(kept_number(own, name, 0.0)) for name in ("width", "height"))
    return Film(seconds, rate, (width, height) if width > 0 and height > 0 else None)


class FilmDialog(FormDialog):
    """Ask how a film is to be.

    Parameters
    ----------
    parent : QWidget
    kept : Film
        What was chosen last.
    screen : (int, int)
        Width and height of the picture on the screen, pixels.
    any_length : bool
        Whether it may be of any length, since its pictures are not held in memory.
    title : str, optional
        By default that of a turntable.
    """

    def __init__(
        self,
        parent: QtWidgets.QWidget,
        kept: Film,
        screen: tuple[int, int],
        any_length: bool = False,
        title: str = "",
    ) -> None:
        self._any_length = any_length
        super().__init__(parent, (title or say("action.turntable")).rstrip("…"))
        self.seconds = self.add_number(say("Length"), 0.5, _LONGEST_S, kept.seconds, "s", 1)
        self.rate = self.add_number(say("Pictures a second"), 1, _FASTEST, kept.rate)
        self.size_boxes = SizeBoxes(kept.size or screen, screen)
        self.form.addRow(say("Size in pixels"), self.size_boxes)
        self.told = QtWidgets.QLabel()
        self.told.setObjectName("faint")
        self.form.addRow("", self.told)
        self.finish("button.save")
        for box in (self.seconds, self.rate, self.size_boxes.width_box, self.size_boxes.height_box):
            box.valueChanged.connect(self._tell)
        self._tell()

    def _tell(self, _: object = None) -> None:
        """Say how many pictures that makes, and whether they are too many."""
        film = self.film()
        too_long = film.is_too_long and not self._any_length
        text = "{n} pictures: too many of this size" if too_long else "{n} pictures"
        self.told.setText(say(text, n=film.n_pictures))
        below = self.findChild(QtWidgets.QDialogButtonBox)
        assert below is not None, "it was finished"
        below.button(QtWidgets.QDialogButtonBox.StandardButton.Ok).setEnabled(not too_long)

    def film(self) -> Film:
        """What was chosen."""
        size = self.size_boxes.size_in_pixels()
        return Film(self.seconds.value(), self.rate.value(), size)

    def chosen(self) -> dict[str, object]:
        """The same, as JSON can hold it."""
        film = self.film()
        width, height = self.size_boxes.size_in_pixels()
        return {"seconds": film.seconds, "rate": film.rate, "width": width, "height": height}
