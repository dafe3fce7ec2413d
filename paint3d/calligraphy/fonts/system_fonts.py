"""Fonts of the system, by their names: asked of fontconfig."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

from paint3d.errors import InputError

__all__ = ["SystemFont", "fonts_with", "list_fonts", "match_font"]

_SECONDS = 20.0
_SEPARATOR = "\t"
_FORMAT = "%{family[0]}\t%{style[0]}\t%{index}\t%{file}\n"


@dataclass(frozen=True)
class SystemFont:
    """A face that the system has.

    Attributes
    ----------
    family, style : str
    number : int
        Of the face in its file.
    path : Path
    """

    family: str
    style: str
    number: int
    path: Path


def list_fonts(text: str = "") -> list[SystemFont]:
    """The faces of outlines that have all characters of a text, by family and style.

    Raises
    ------
    InputError
        If fontconfig is not there to be asked.
    """
    wanted = ["scalable=true", "color=false"]
    codes = " ".join(f"{ord(c):x}" for c in dict.fromkeys(text) if not c.isspace())
    pattern = ":" + ":".join([*wanted, f"charset={codes}"] if codes else wanted)
    lines = _ask("fc-list", "--format", _FORMAT, pattern).splitlines()
    fonts = [_parsed(line) for line in lines if line.count(_SEPARATOR) == 3]
    return sorted(fonts, key=lambda font: (font.family, font.style, str(font.path)))


def fonts_with(text: str) -> list[SystemFont]:
    """Faces that list all characters of a text; none where nobody can be asked."""
    try:
        return list_fonts(text)
    except InputError:
        return []


def match_font(name: str, number: int = 0) -> tuple[Path, int]:
    """The file of a font that the system knows by a name, and its face's number.

    Raises
    ------
    InputError
        If there is none; the message names some that there are.
    """
    for font in _parsed_all(name):
        names = {font.family.casefold(), f"{font.family} {font.style}".casefold()}
        if _family_of(name).casefold() in names or name.casefold() in names:
            return font.path, number or font.number
    families = list(dict.fromkeys(font.family for font in list_fonts()))
    near = [family for family in families if name.split()[0].casefold() in family.casefold()]
    told = ", ".join((near or families)[:6]) or "none"
    raise InputError(
        f"no font {name!r} on this system; expected a file, or a name that `paint3d fonts` lists, "
        f"such as {told}"
    )


def _parsed_all(name: str) -> list[SystemFont]:
    lines = _ask("fc-match", "--format", _FORMAT, name).splitlines()
    found = [_parsed(line) for line in lines if line.count(_SEPARATOR) == 3]
    whole = [font for font in list_fonts() if f"{font.family} {font.style}" == name]
    return whole or found


def _family_of(pattern: str) -> str:
    """The family of a fontconfig pattern such as ``DejaVu Sans:bold``."""
    return pattern.split(":")[0].split("-")[0].strip()


def _parsed(line: str) -> SystemFont:
    family, style, number, path = line.split(_SEPARATOR)
    return SystemFont(family, style, int(number or 0) & 0xFFFF, Path(path))


def _ask(command: str, *arguments: str) -> str:
    try:
        done = subprocess.run(
            [command, *arguments], capture_output=True, check=True, timeout=_SECONDS
        )
    except (OSError, subprocess.SubprocessError):
        raise InputError(
            f"{command} of fontconfig does not answer; expected it (apt install fontconfig), or a "
            "font's file"
        ) from None
    return done.stdout.decode("utf-8", "replace")
