"""Known devices and their quirks, read from ``catalogue.json``.

The table names devices and lists deviations from their descriptors; it does not hold the positions
of axes. An unlisted 6-DOF mouse works by its descriptor.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from typing import Any

__all__ = ["MouseQuirks", "find_mouse_quirks", "is_listed_mouse", "is_never_six_dof"]


@dataclass(frozen=True, slots=True)
class MouseQuirks:
    """Properties of one model of 6-DOF mouse.

    Attributes
    ----------
    name : str or None
        None for an unlisted model, which is named by its product string.
    full_deflection : int
        Counts at full deflection; some caps go beyond, which is clamped.
    axes_signs : tuple of 6 int
        From the device's axes (x right, y towards the user, z down) to a right-handed frame with
        z up.
    buttons : int or None
        Number of buttons.
    receiver : bool
        True for a wireless receiver, behind which there may be another device.
    """

    name: str | None
    full_deflection: int
    axes_signs: tuple[int, ...]
    buttons: int | None = None
    receiver: bool = False


@lru_cache(maxsize=1)
def _read() -> dict[str, Any]:
    text = resources.files(__package__).joinpath("catalogue.json").read_text(encoding="utf-8")
    result: dict[str, Any] = json.loads(text)
    return result


def _find(table: str, vendor: int, product: int) -> dict[str, Any] | None:
    for row in _read()[table]:
        if int(row["vendor"], 16) == vendor and f"{product:04x}" in row["products"]:
            result: dict[str, Any] | None = row
            return result
    return None


def find_mouse_quirks(vendor: int, product: int) -> MouseQuirks:
    """Look up the quirks of a 6-DOF mouse; the defaults for an unlisted one."""
    defaults = _read()["six_dof_defaults"]
    row = _find("six_dof_mice", vendor, product) or {}
    return MouseQuirks(
        row.get("name"),
        row.get("full_deflection", defaults["full_deflection"]),
        tuple(row.get("axes_signs", defaults["axes_signs"])),
        row.get("buttons"),
        row.get("receiver", False),
    )


def is_never_six_dof(vendor: int, product: int) -> bool:
    """Return whether it is known as an ordinary mouse or keypad by a maker of 6-DOF mice."""
    return _find("not_six_dof", vendor, product) is not None


def is_listed_mouse(vendor: int, product: int) -> bool:
    """Return whether this model of 6-DOF mouse is in the table."""
    return _find("six_dof_mice", vendor, product) is not None
