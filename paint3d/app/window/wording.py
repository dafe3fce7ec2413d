"""The window's texts, in the chosen language.

All are written in English where they are used, and looked up by that in gettext's catalogue of
the language (`locale/`): texts by `say`, and messages that errors, notes and tables bring. Names of
pigments come from the column `chinese` of `palette.csv` instead, those of the user's materials from
their files, and the texts of Qt's own dialogs from Qt (`start.py`).
"""

from __future__ import annotations

import gettext
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from paint3d.brush.presets import brush_names
from paint3d.colour.materials import Material, load_materials
from paint3d.errors import Message, Paint3DError, UnknownNameError
from paint3d.files.load import UNITS_MM, is_built_in

__all__ = [
    "LANGUAGES",
    "choose_language",
    "choose_unit",
    "language",
    "say",
    "say_brush",
    "say_coarse",
    "say_error",
    "say_group",
    "say_hair",
    "say_layer",
    "say_left",
    "say_length",
    "say_material",
    "say_object",
    "say_purpose",
    "say_sides",
    "say_units",
    "system_language",
]

LANGUAGES = {"en": "English", "zh": "中文"}
"""Names of the languages, each in itself."""

_CATALOGUES = Path(__file__).with_name("locale")
_LOCALES = {"zh": "zh_CN"}
"""Of the languages that have a catalogue."""


def system_language(environment: Mapping[str, str] | None = None) -> str:
    """Return the code of the system's language if it is one of `LANGUAGES`; else "en"."""
    environment = os.environ if environment is None else environment
    for name in ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG"):
        value = environment.get(name, "").split(":")[0].split(".")[0].lower()
        if value:
            return value[:2] if value[:2] in LANGUAGES else "en"
    return "en"


_REASONS = (
    Message("No space left on device"),
    Message("Permission denied"),
    Message("Read-only file system"),
    Message("No such file or directory"),
    Message("Is a directory"),
    Message("Not a directory"),
    Message("File name too long"),
    Message("Input/output error"),
    Message("Connection refused"),
)
"""The system's messages about files, as errors quote them."""

_language = ["en"]
_catalogue = [gettext.NullTranslations()]
_unit = ["mm"]


def choose_language(code: str) -> None:
    """Choose "en", "zh" or the "system"'s language; texts that are shown already stay.

    Raises
    ------
    UnknownNameError
        For another language.
    FileNotFoundError
        If its catalogue was not compiled.
    """
    code = system_language() if code == "system" else code
    if code not in LANGUAGES:
        raise UnknownNameError("language", code, LANGUAGES)
    _catalogue[0] = (
        gettext.translation("paint3d", _CATALOGUES, [_LOCALES[code]])
        if code in _LOCALES
        else gettext.NullTranslations()
    )
    _language[0] = code


def language() -> str:
    """Return the chosen language: "en" or "zh"."""
    return _language[0]


def say(text: str, plural: str = "", /, **fields: Any) -> str:
    """Return a text in the chosen language, with its fields filled in.

    Parameters
    ----------
    text : str
        English, as the catalogue knows it, or a `Message`, which brings its fields.
    plural : str, optional
        The English for a field `n` other than 1.
    **fields
        Those that are messages are translated, too.
    """
    if isinstance(text, Message):
        plural, fields, text = text.plural, text.fields | fields, text.text
    if not text:
        return ""
    if plural:
        words = _catalogue[0].ngettext(text, plural, fields["n"])
    else:
        words = _catalogue[0].gettext(text)
    fields = {name: say(v) if isinstance(v, Message) else v for name, v in fields.items()}
    return words.format(**fields) if fields else words


def say_error(error: BaseException | str) -> str:
    """Return an error's message in the chosen language."""
    if isinstance(error, Paint3DError):
        error = error.message
    return say(error) if isinstance(error, Message) else str(error)


# ---- Names ---------------------------------------------------------------------------------------
# A name that the user gave stays as it is, even if the catalogue has it.

_OBJECTS = {
    "bowl": Message("Bowl"),
    "plate": Message("Plate"),
    "vase": Message("Vase"),
    "sphere": Message("Sphere"),
    "plane": Message("Plane"),
    "scroll": Message("Hanging scroll"),
    "couplet": Message("Couplet"),
    "square": Message("Square"),
    "horizontal": Message("Horizontal"),
    "fan": Message("Folding fan"),
    "round-fan": Message("Round fan"),
    "album": Message("Album leaf"),
    "handscroll": Message("Handscroll"),
    "a4": Message("A4"),
    "a3": Message("A3"),
    "sheet": Message("Free size"),
}
_MATERIALS = {
    "porcelain": Message("Porcelain"),
    "bisque": Message("Bisque"),
    "xuan": Message("Xuan paper"),
    "plaster": Message("Plaster"),
    "terracotta": Message("Terracotta"),
    "sized xuan": Message("Sized xuan paper"),
    "tinted xuan": Message("Tinted xuan paper"),
    "silk": Message("Silk"),
}
_BRUSHES = {
    "full": Message("full"),
    "slender": Message("slender"),
    "calibrated": Message("calibrated"),
    "xiaokai": Message("xiaokai"),
    "zhongkai": Message("zhongkai"),
    "dakai": Message("dakai"),
    "gongbi": Message("gongbi"),
    "baiyun": Message("baiyun"),
    "xiaobaiyun": Message("xiaobaiyun"),
    "zhongbaiyun": Message("zhongbaiyun"),
    "dabaiyun": Message("dabaiyun"),
    "feibai": Message("feibai"),
    "langhao": Message("langhao"),
    "yanghao": Message("yanghao"),
    "jianhao": Message("jianhao"),
    "tidou": Message("tidou"),
}
_PURPOSES = {
    "full": Message("large, for trying out"),
    "slender": Message("thin, for its side"),
    "calibrated": Message("as one was measured"),
    "xiaokai": Message("writing, 8 to 25 mm"),
    "zhongkai": Message("writing, 30 to 60 mm"),
    "dakai": Message("writing, over 80 mm"),
    "gongbi": Message("for outlines"),
    "baiyun": Message("for leaves and washes"),
    "xiaobaiyun": Message("kaishu, 8 to 22 mm"),
    "zhongbaiyun": Message("kaishu, 22 to 60 mm"),
    "dabaiyun": Message("kaishu, 60 to 200 mm"),
    "feibai": Message("flying white, hairs"),
    "langhao": Message("elastic, sharp point"),
    "yanghao": Message("soft, for washes"),
    "jianhao": Message("for running script"),
    "tidou": Message("kaishu, 200 to 350 mm"),
}
_HAIRS = {
    "goat": Message("goat hair"),
    "weasel": Message("weasel hair"),
    "mixed": Message("mixed hair"),
}
_UNITS = {
    "mm": Message("millimetres"),
    "cm": Message("centimetres"),
    "m": Message("metres"),
    "in": Message("inches"),
}


def say_object(name: str) -> str:
    """Return the name of a built-in object or a sheet; another one as it is."""
    form = name.split(":")[0]
    return say(_OBJECTS[form]) if is_built_in(name) else name


def say_material(material: Material) -> str:
    """Return a material's name; one of the user's own as in its file."""
    if material.name in load_materials():
        return say(_MATERIALS[material.name])
    return material.chinese if language() == "zh" and material.chinese else material.name


def say_brush(name: str) -> str:
    """Return a brush's name; one of the user's own as in its file."""
    return say(_BRUSHES[name]) if name in _BRUSHES and name in brush_names() else name


def say_fonts(characters: Mapping[str, str]) -> list[str]:
    """Return a note for each system font that stands in for characters."""
    return [
        say("{characters} taken from the font {font}", characters=taken, font=font)
        for font, taken in characters.items()
    ]


def say_purpose(name: str) -> str:
    """Return the purpose of a preset brush; empty for one of the user's own."""
    return say(_PURPOSES[name]) if name in _PURPOSES and name in brush_names() else ""


def say_hair(hair: str) -> str:
    """Return the name of a brush's hair."""
    return say(_HAIRS[hair])


def say_layer(name: str) -> str:
    """Return a layer's name; one that the user did not name has a number only."""
    return say("Layer {number}", number=name) if name.isdigit() else name


def say_group(name: str) -> str:
    """Return a group's name; one that the user did not name has a number only."""
    return say("Group {number}", number=name) if name.isdigit() else name


def choose_unit(unit: str) -> None:
    """Choose "mm", "cm", "m" or "in" for lengths."""
    _unit[0] = unit


def say_units() -> dict[str, str]:
    """Return the names of the units of length."""
    return {unit: say(_UNITS[unit]) for unit in UNITS_MM}


def say_length(mm: float) -> str:
    """Format a length in the chosen unit."""
    number = mm / UNITS_MM[_unit[0]]
    return f"{number:.0f} {_unit[0]}" if number >= 100.0 else f"{number:.3g} {_unit[0]}"


def say_coarse(em_mm: float, detail_mm: float, larger_mm: float) -> str:
    """Return a text on vertices too far apart for characters, and what detail or size would do."""
    return say(
        "Characters of {size} break up on this surface: they need a detail of {detail}, or to be "
        "{larger} large",
        size=say_length(em_mm),
        detail=say_length(detail_mm),
        larger=say_length(larger_mm),
    )


def say_sides(*sides_mm: float) -> str:
    """Format lengths of sides in the chosen unit."""
    *others, last = (say_length(side) for side in sides_mm)
    return " × ".join([*(other.split()[0] for other in others), last])


def say_left(seconds: float) -> str:
    """Return a text on the time left."""
    if seconds < 57.5:
        return say("about {n} s left", n=max(5, 5 * round(seconds / 5.0)))
    return say("about {n} min left", n=round(seconds / 60.0))
