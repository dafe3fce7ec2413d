"""What an object is called."""

from __future__ import annotations

from paint3d.app.window.wording import say
from paint3d.files.load import BUILT_IN_OBJECTS

__all__ = ["named"]


def named(name: str) -> str:
    """An object's name in words: a built-in one's in the language that is spoken."""
    return say(f"object.{name}") if name in BUILT_IN_OBJECTS else name
