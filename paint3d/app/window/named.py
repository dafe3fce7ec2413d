"""What an object and a painting are called."""

from __future__ import annotations

import numpy as np

from paint3d.app.model.document import Document
from paint3d.app.window.wording import say, say_length, say_material
from paint3d.files.load import BUILT_IN_OBJECTS

__all__ = ["described", "named"]


def named(name: str) -> str:
    """An object's name in words: a built-in one's in the language that is spoken."""
    return say(f"object.{name}") if name in BUILT_IN_OBJECTS else name


def described(document: Document) -> str:
    """What is painted on, in words: the object, its material and its size."""
    surface = document.surface
    sides = sorted(np.ptp(surface.source.vertices, axis=0), reverse=True)
    told = [say_length(side) for side in sides if side > 0.05 * sides[0]]
    size = " × ".join([*(length.split()[0] for length in told[:-1]), told[-1]])
    return f"{named(surface.source.name)}, {say_material(surface.material)}, {size}"
