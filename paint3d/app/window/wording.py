"""What the window says, in the language that was chosen.

English is the key: what has no translation is shown as it is written in the code.
"""

from __future__ import annotations

from paint3d.app.window.chinese import CHINESE

__all__ = ["LANGUAGES", "choose_language", "language", "say"]

LANGUAGES = {"en": "English", "zh": "中文"}
_chosen = ["en"]


def choose_language(code: str) -> None:
    """Speak "en" or "zh" from now on; windows that are open keep their words."""
    _chosen[0] = code if code in LANGUAGES else "en"


def language() -> str:
    """The language that is spoken."""
    return _chosen[0]


def say(english: str) -> str:
    """The words for an English text, in the language that was chosen."""
    if _chosen[0] == "zh":
        return CHINESE.get(english, english)
    return english
