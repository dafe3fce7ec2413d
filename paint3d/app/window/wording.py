"""What the window says, in the language that was chosen.

Most texts are the studio model's, by key. What only the window says is written here in English,
which is its key, and in Chinese beside it (`chinese`).
"""

from __future__ import annotations

from typing import Any

from paint3d.app.model.error_texts import in_chinese
from paint3d.app.model.texts import Texts, load_texts
from paint3d.app.window.chinese import CHINESE
from paint3d.brush.presets import brush_names
from paint3d.colour.materials import Material, load_materials
from paint3d.errors import GlyphError, LayerError
from paint3d.files.load import UNITS_MM

__all__ = [
    "choose_language",
    "choose_unit",
    "language",
    "say",
    "say_brush",
    "say_error",
    "say_layer",
    "say_length",
    "say_material",
]

_texts = [Texts("en")]
_unit = ["mm"]


def choose_language(code: str) -> None:
    """Speak "en", "zh" or as the "system" from now on; what is open keeps its words."""
    _texts[0] = Texts(code)


def choose_unit(unit: str) -> None:
    """Tell lengths in "mm", "cm", "m" or "in" from now on."""
    _unit[0] = unit


def say_length(mm: float) -> str:
    """A length in words, in the unit that was chosen."""
    number = mm / UNITS_MM[_unit[0]]
    return f"{number:.0f} {_unit[0]}" if number >= 100.0 else f"{number:.3g} {_unit[0]}"


def language() -> str:
    """The language that is spoken: "en" or "zh"."""
    return _texts[0].language


def say(text: str, **values: Any) -> str:
    """The words for a key or an English text, with values put in."""
    if text in load_texts():
        return _texts[0](text, **values)
    words = CHINESE.get(text, text) if language() == "zh" else text
    return words.format(**values) if values else words


def say_layer(name: str) -> str:
    """What a layer is called: one that nobody named has only a number."""
    return say("layer.name", number=name) if name.isdigit() else name


def say_brush(name: str) -> str:
    """What a brush is called: one of the user's own as its file says, were it a text's key."""
    return say(name) if name in brush_names() else name


def say_material(material: Material) -> str:
    """What a material is called: one of the user's own as its file says."""
    if material.name in load_materials():
        return say(f"surface.{material.name.replace(' ', '_')}")
    return material.chinese if language() == "zh" and material.chinese else material.name


def say_error(error: BaseException | str) -> str:
    """What went wrong, in the language that is spoken."""
    if isinstance(error, LayerError):
        return say(f"layer.is_{error.state}", name=say_layer(error.layer))
    if isinstance(error, GlyphError):
        return say(
            "No form of {characters} is known: install a font that has one, such as Noto Serif "
            "CJK, or choose another font",
            characters=error.characters,
        )
    return in_chinese(str(error)) if language() == "zh" else str(error)
