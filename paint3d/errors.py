"""Every exception that paint3d raises on purpose.

    Paint3DError                 catch this to catch them all
    |-- InputError               something handed in is wrong: what, where, what was expected
    |   |-- MeshError            a mesh file or mesh arrays
    |   |-- RecordingError       a recording
    |   |-- SessionError         a saved session, or a journal
    |   |-- PigmentError         a pigment, ink or material table
    |   |-- BrushError           a brush preset or parameter
    |   |-- GlyphError           characters of which no form is known
    |   |-- LayerError           a layer that takes no paint as it is
    |   `-- UnknownNameError     a name that is not among the known ones
    |-- DeviceError              a device, its reports or its driver
    |   `-- PermissionNeededError   it is plugged in and may not be opened: which node, and the rule
    |-- ExportError              a result that could not be written
    `-- KernelError              a hot loop that is not compiled, and cannot be

The command line turns each of them into one line on stderr and exit status 2.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable

__all__ = [
    "BrushError",
    "DeviceError",
    "ExportError",
    "GlyphError",
    "InputError",
    "KernelError",
    "LayerError",
    "MeshError",
    "Paint3DError",
    "PermissionNeededError",
    "PigmentError",
    "RecordingError",
    "SessionError",
    "UnknownNameError",
]


class Paint3DError(Exception):
    """Base of all exceptions raised by paint3d."""


class InputError(Paint3DError, ValueError):
    """Input that cannot be used: what was got, where, and what was expected."""


class MeshError(InputError):
    """A mesh that is empty, broken, or in a form that cannot be read."""


class RecordingError(InputError):
    """A recording that is broken; the message starts with ``file:line:`` where there is one."""


class SessionError(InputError):
    """A saved session or a journal that is damaged, or newer than this program."""


class PigmentError(InputError):
    """A pigment, palette or material with values that light cannot have."""


class BrushError(InputError):
    """A brush parameter outside the range in which the model holds."""


class GlyphError(InputError):
    """Characters of which no form is known; `characters` has each once."""

    def __init__(self, message: str, characters: str = "") -> None:
        super().__init__(message)
        self.characters = characters


class LayerError(InputError):
    """A layer that takes no paint; `layer` is its name, `state` "locked" or "hidden"."""

    def __init__(self, layer: str, state: str) -> None:
        super().__init__(f"the layer {layer!r} is {state}; expected another one")
        self.layer, self.state = layer, state


class UnknownNameError(InputError):
    """A name that is not known; the message lists the known ones, the nearest first."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        names = sorted(known)
        near = difflib.get_close_matches(name, names, n=1, cutoff=0.6)
        hint = f"did you mean {near[0]!r}? " if near else ""
        super().__init__(f"unknown {kind} {name!r}: {hint}expected one of {', '.join(names)}")


class DeviceError(Paint3DError):
    """A device that is not there, cannot be opened, has gone, or sends what cannot be."""


class PermissionNeededError(DeviceError):
    """A device is plugged in and may not be opened; the message holds the udev rule to add."""


class ExportError(Paint3DError):
    """A result that could not be written; nothing half-written is left behind."""


class KernelError(Paint3DError, RuntimeError):
    """A hot loop that was not compiled ahead for this machine, where numba is not installed."""
