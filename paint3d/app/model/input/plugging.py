"""Which devices the studio opens itself, and which it leaves to the window system."""

from __future__ import annotations

from paint3d.device.hid_nodes import list_nodes
from paint3d.device.hot_plug import PluggedDevices
from paint3d.errors import Paint3DError

__all__ = ["plug_in_mice"]


def plug_in_mice() -> PluggedDevices | None:
    """The 6-DOF mice that are there or come; None where HID devices cannot be read.

    A pen is left to the window system, whose events say where it is in the picture, although its
    node may be opened: read here as well it would be a second brush, at the pad's place in the
    object's millimetres. Styli with motors are opened by who feels with them.
    """
    try:
        return PluggedDevices(find=lambda: list_nodes(("mouse",)))
    except (Paint3DError, ImportError, OSError):
        return None
