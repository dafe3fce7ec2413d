"""Which devices the studio opens itself, and which it leaves to the window system."""

from __future__ import annotations

from dataclasses import dataclass

from paint3d.app.model.document import Document
from paint3d.app.model.input.devices import Feedback
from paint3d.app.model.persistence.calibrations import kept_calibration
from paint3d.app.model.persistence.settings import Settings
from paint3d.brush.spec import BrushSpec
from paint3d.colour.materials import Material
from paint3d.device.hid_nodes import list_nodes
from paint3d.device.hot_plug import PluggedDevices
from paint3d.errors import Paint3DError
from paint3d.haptics.servo import ForceFeedback
from paint3d.haptics.settings import PHANTOM_DESKTOP, DeviceLimits, Feel
from paint3d.haptics.stylus_choice import find_stylus
from paint3d.pose.calibration import DeviceCalibration
from paint3d.pose.mouse_settings import MouseSettings

__all__ = ["Feeling", "plug_in_mice", "plug_in_pens", "start_feeling"]


def plug_in_mice(settings: MouseSettings | None = None) -> PluggedDevices | None:
    """The 6-DOF mice that are there or come; None where HID devices cannot be read.

    A pen is left to the window system, whose events say where it is in the picture, although its
    node may be opened: read here as well it would be a second brush, at the pad's place in the
    object's millimetres. Styli with motors are opened by who feels with them.
    """
    read = (settings or MouseSettings()).deflection()
    try:
        return PluggedDevices(find=lambda: list_nodes(("mouse",)), deflection=read)
    except (Paint3DError, ImportError, OSError):
        return None


def plug_in_pens() -> PluggedDevices | None:
    """The pads whose pens can be read, to calibrate one; None where HID devices cannot be read."""
    try:
        return PluggedDevices(find=lambda: list_nodes(("pen",)))
    except (Paint3DError, ImportError, OSError):
        return None


@dataclass
class Feeling:
    """A stylus that pushes back, and what its force is made of.

    Attributes
    ----------
    feedback : Feedback
    name, key : str
        Of the device: see `FoundStylus`.
    limits : DeviceLimits
    calibration : DeviceCalibration
        By which its readings come.
    """

    feedback: Feedback
    name: str = "stylus"
    key: str = "stylus"
    limits: DeviceLimits = PHANTOM_DESKTOP
    calibration: DeviceCalibration | None = None
    _felt: tuple[BrushSpec, Feel, Material] | None = None

    def follow(self, brush: BrushSpec, feel: Feel, material: Material) -> None:
        """Let the force be that of this brush, surface and choices from the next step on."""
        now, before = (brush, feel, material), self._felt
        if before is None or before[0] is not brush or before[1:] != now[1:]:
            self._felt = now
            self.feedback.settings = feel.settings(brush, self.limits, material)


def start_feeling(document: Document, settings: Settings) -> Feeling | None:
    """Start the force feedback of the stylus that was chosen; None where there is none.

    Raises
    ------
    Paint3DError
        If the one that was chosen is not there, saying what is missing; or it does not start.
    """
    found = find_stylus(settings.stylus)
    if found is None:
        return None
    feel, brush = Feel.from_words(settings.feel), document.painter.brush
    calibration = kept_calibration(found.key) or found.frame
    surface = document.surface
    felt = feel.settings(brush, found.limits, surface.material)
    feedback = ForceFeedback(found.port, surface.contact_tree, felt, calibration)
    return Feeling(feedback, found.name, found.key, found.limits, calibration)
