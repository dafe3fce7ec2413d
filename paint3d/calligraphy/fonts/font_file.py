"""Font files: their names, licences, and the outlines of their glyphs."""

from __future__ import annotations

import logging
import re
import subprocess
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from paint3d.calligraphy.glyphs import EM_UNITS
from paint3d.calligraphy.optional_packages import import_optional
from paint3d.calligraphy.page.page import fill_rings
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import bezier_points
from paint3d.errors import InputError, Message

if TYPE_CHECKING:
    from shapely import MultiPolygon

__all__ = [
    "FontFile",
    "SystemFont",
    "draws",
    "fonts_that_draw",
    "fonts_with",
    "is_handwriting",
    "list_fonts",
    "open_font",
]

# ---- Fonts of the system -------------------------------------------------------------------------
# Fonts of the system, by their names: asked of fontconfig.


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
    return sorted(
        _ask_fonts("fc-list", pattern), key=lambda font: (font.family, font.style, str(font.path))
    )


def fonts_with(text: str) -> list[SystemFont]:
    """Faces that list all characters of a text; none where nobody can be asked."""
    try:
        return list_fonts(text)
    except InputError:
        return []


def _match_font(name: str, number: int = 0) -> tuple[Path, int]:
    """The file of a font that the system knows by a name, and its face's number.

    Raises
    ------
    InputError
        If there is none; the message names some that there are.
    """
    matches = _ask_fonts("fc-match", name)
    exact = [font for font in list_fonts() if f"{font.family} {font.style}" == name]
    wanted = name.split(":")[0].split("-")[0].strip()  # the family of a pattern: DejaVu Sans:bold
    for font in exact or matches:
        names = {font.family.casefold(), f"{font.family} {font.style}".casefold()}
        if wanted.casefold() in names or name.casefold() in names:
            return font.path, number or font.number
    families = list(dict.fromkeys(font.family for font in list_fonts()))
    near = [family for family in families if name.split()[0].casefold() in family.casefold()]
    if not families:
        raise InputError(
            "no font {name!r} on this system, nor any other; expected a file", name=name
        )
    raise InputError(
        "no font {name!r} on this system; expected a file, or a name such as {names}",
        name=name,
        names=", ".join((near or families)[:6]),
        hint="paint3d fonts lists all",
    )


def _ask_fonts(command: str, pattern: str) -> list[SystemFont]:
    """The faces that a command of fontconfig names for a pattern."""
    fonts = []
    for line in _ask(command, "--format", _FORMAT, pattern).splitlines():
        if line.count(_SEPARATOR) == 3:
            family, style, number, path = line.split(_SEPARATOR)
            fonts.append(SystemFont(family, style, int(number or 0) & 0xFFFF, Path(path)))
    return fonts


def _ask(command: str, *arguments: str) -> str:
    try:
        done = subprocess.run(
            [command, *arguments], capture_output=True, check=True, timeout=_SECONDS
        )
    except (OSError, subprocess.SubprocessError):
        raise InputError(
            "{command} of fontconfig does not answer; expected it, or a font's file",
            command=command,
            hint="apt install fontconfig",
        ) from None
    return done.stdout.decode("utf-8", "replace")


# ---- The font ------------------------------------------------------------------------------------


_LOG = logging.getLogger(__name__)
_MOST_BYTES = 200_000_000
_KINDS = (b"\0\1\0\0", b"true", b"OTTO", b"ttcf")
_PACKED = (b"wOFF", b"wOF2")
_FLATNESS = 0.15  # glyph units that a chord may stray from its curve
_SUFFIXES = (".ttf", ".otf", ".ttc", ".otc", ".woff", ".woff2")
_NO_EMBEDDING = 0x2  # of fsType: restricted licence
_LICENCE, _LICENCE_URL, _COPYRIGHT, _FULL_NAME, _VERSION = 13, 14, 0, 4, 5
_BY_HAND = re.compile(
    r"\b(script|cursive|brush|hand|handwriting|handwritten|calligraph\w*|chancery)\b", re.IGNORECASE
)
_SCRIPTS, _HAND = 10, 3  # the family's class in OS/2; the kind of family in PANOSE
_SOME = 4  # fonts that are named where another one lacks a character

_FILLERS = "\u115f\u1160\u3164\uffa0"
"""Letters of Hangul that stand for one that is not there."""


@dataclass(frozen=True, eq=False)
class FontFile:
    """A face of a font file, at its variations.

    Attributes
    ----------
    path : Path
    face, font : object
        HarfBuzz's.
    """

    path: Path
    face: Any = field(repr=False)
    font: Any = field(repr=False)
    _drawn: dict[int, MultiPolygon] = field(default_factory=dict, repr=False)

    @property
    def scale(self) -> float:
        """Glyph units (1024 an em) a unit of the font."""
        return EM_UNITS / float(self.face.upem)

    @cached_property
    def name(self) -> str:
        """Name that the font calls itself."""
        return str(self.face.get_name(_FULL_NAME) or self.path.name)

    @cached_property
    def licence(self) -> str:
        """Whose shapes they are and under what licence, as the font says."""
        notices = [self.face.get_name(k) for k in (_COPYRIGHT, _LICENCE, _LICENCE_URL)]
        version = self.face.get_name(_VERSION)
        parts = [" ".join(part.split())[:200] for part in notices if part]
        head = f"Font: {self.name}" + (f", {version}" if version else "")
        return "; ".join([head, *parts])

    @cached_property
    def extents(self) -> tuple[float, float, float]:
        """Ascender, descender (negative) and gap between lines, glyph units."""
        extents = self.font.get_font_extents("ltr")
        values = (extents.ascender, extents.descender, extents.line_gap)
        ascender, descender, gap = (self.scale * float(value) for value in values)
        return ascender, descender, gap

    def outline(self, glyph: int) -> MultiPolygon:
        """The ink of a glyph, glyph units from its origin on the baseline."""
        if glyph not in self._drawn:
            pen = _Rings(_FLATNESS / self.scale)
            self.font.draw_glyph_with_pen(glyph, pen)
            self._drawn[glyph] = fill_rings([self.scale * ring for ring in pen.rings()])
        return self._drawn[glyph]

    def is_mark(self, glyph: int) -> bool:
        """Return whether the font says that a glyph is a mark on another."""
        return int(self.face.get_layout_glyph_class(glyph)) == 3

    def check_has(self, text: str) -> None:
        """Refuse a text with characters that the font lacks.

        Raises
        ------
        InputError
            Which they are, and which fonts of the system have them.
        """
        missing = [c for c in dict.fromkeys(text) if _is_drawn(c) and self._lacks_glyph(c)]
        if not missing:
            return
        names = ", ".join(f"{c!r} (U+{ord(c):04X})" for c in missing[:12])
        if len(missing) > 12:
            names = Message("{names} and {n} more", names=names, n=len(missing) - 12)
        others = ", ".join(_families_that_draw("".join(missing)))
        if others:
            raise InputError(
                "{font} has no glyph for {names}; fonts that have them: {others}",
                font=self.name,
                names=names,
                others=others,
            )
        raise InputError(
            "{font} has no glyph for {names}; try another font", font=self.name, names=names
        )

    def is_empty(self, character: str) -> bool:
        """Return whether a character's glyph has no ink: some fonts list letters that they lack."""
        extents = self.font.get_glyph_extents(self.font.get_nominal_glyph(ord(character)))
        return extents is None or (extents.width == 0 and extents.height == 0)

    def _lacks_glyph(self, character: str) -> bool:
        if ord(character) not in self.face.unicodes:
            return not self._has_parts(character)
        kind = unicodedata.category(character)[0]
        return kind in "LN" and character not in _FILLERS and self.is_empty(character)

    def _has_parts(self, character: str) -> bool:
        """Return whether the font has a character's parts, such as a letter and its accent."""
        parts = unicodedata.normalize("NFD", character)
        return len(parts) > 1 and all(ord(part) in self.face.unicodes for part in parts)


def _families_that_draw(text: str) -> list[str]:
    """Some families of the system that have ink for all characters of a text."""
    families: list[str] = []
    for one in fonts_with(text):
        if one.family not in families and draws(one, text):
            families.append(one.family)
        if len(families) == _SOME:
            break
    return families


def fonts_that_draw(text: str) -> list[SystemFont]:
    """Faces of the system that have ink for all characters of a text; all, where it has none.

    Fonts of icons list the letters that their ligatures are typed by, and have no ink for them.

    Raises
    ------
    InputError
        If fontconfig, or a package that reads fonts, is not there.
    """
    return [one for one in list_fonts(text) if not text or draws(one, text)]


def draws(one: SystemFont, text: str) -> bool:
    """Return whether a face has ink for all characters of a text; none that cannot be read has."""
    hb = import_optional("uharfbuzz")
    try:
        face = hb.Face(hb.Blob(_font_data(one.path)), one.number)
    except InputError:
        return False
    font = FontFile(one.path, face, hb.Font(face))
    return not any(_is_drawn(character) and font._lacks_glyph(character) for character in text)


@lru_cache(maxsize=2048)
def is_handwriting(one: SystemFont) -> bool:
    """Return whether a face looks handwritten: by its family's name, or as its maker classed it.

    That is the class of scripts in OS/2, or a hand in its PANOSE number.
    """
    if _BY_HAND.search(one.family):
        return True
    hb = import_optional("uharfbuzz")
    try:
        face = hb.Face(hb.Blob.from_file_path(str(one.path)), one.number)
        os2 = bytes(face.reference_table("OS/2").data or b"")
    except (OSError, hb.HarfBuzzError):
        return False
    return len(os2) > 32 and (os2[30] == _SCRIPTS or os2[32] == _HAND)


def _is_drawn(character: str) -> bool:
    """Return whether a character asks for ink: controls, formats and spaces do not."""
    kind = unicodedata.category(character)
    variation = 0xFE00 <= ord(character) <= 0xFE0F or 0xE0100 <= ord(character) <= 0xE01EF
    return kind[0] not in "CZ" and not variation


def open_font(
    name: Path | str, number: int = 0, variations: Mapping[str, float] | None = None
) -> FontFile:
    """Open a font by its file, or by its name on this system.

    Parameters
    ----------
    name : path or str
        A .ttf, .otf, .ttc, .woff or .woff2, or a name such as "DejaVu Sans".
    number : int
        Which face of a collection, from 0.
    variations : mapping, optional
        Values of the axes of a variable font, such as ``{"wght": 700}``.

    Raises
    ------
    InputError
        If there is no such font, it cannot be read, has no outlines, is in colour, or an axis is
        not there.
    """
    path = Path(name)
    if not path.exists():
        if path.suffix.lower() in _SUFFIXES:
            raise InputError("{file}: no such file; expected a font", file=path)
        path, number = _match_font(str(name), number)
    hb = import_optional("uharfbuzz")
    face = hb.Face(hb.Blob(_font_data(path)), number)
    with path.open("rb") as file:
        head = file.read(12)
    n_faces = max(1, int.from_bytes(head[8:12], "big")) if head[:4] == b"ttcf" else 1
    if not 0 <= number < n_faces:
        raise InputError(
            "{file}: no face {number}; expected one of the {n_faces} that it has",
            file=path,
            number=number,
            n_faces=n_faces,
        )
    if face.glyph_count == 0:
        raise InputError(
            "{file}: damaged: face {number} has no glyphs; expected a whole font",
            file=path,
            number=number,
        )
    font = hb.Font(face)
    _check_is_drawn(path, face)
    _vary(path, face, font, variations or {})
    opened = FontFile(path, face, font)
    os2 = bytes(face.reference_table("OS/2").data or b"")
    if len(os2) > 10 and int.from_bytes(os2[8:10], "big") & _NO_EMBEDDING:
        _LOG.warning(
            "%s forbids embedding (fsType %d): ask its maker before you give away what is painted",
            opened.name,
            int.from_bytes(os2[8:10], "big"),
        )
    return opened


def _font_data(path: Path) -> bytes:
    """The bytes of a font that HarfBuzz reads."""
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise InputError(
                "{file}: larger than {most:,} bytes; expected a font",
                file=path,
                most=_MOST_BYTES,
            )
        data = path.read_bytes()
    except OSError as cause:
        raise InputError("{file}: {cause}", file=path, cause=cause) from None
    if data[:4] in _PACKED:
        return _unpack_web_font(path, data)
    if data[:4] not in _KINDS:
        raise InputError(
            "{file}: not a font; expected TrueType or OpenType (.ttf, .otf, .ttc)",
            file=path,
        )
    return data


def _unpack_web_font(path: Path, data: bytes) -> bytes:
    """The font in a web font."""
    tables = import_optional("fontTools.ttLib")
    out = BytesIO()
    try:
        font = tables.TTFont(BytesIO(data))
        font.flavor = None
        font.save(out)
    except ImportError:
        raise InputError(
            "{file}: a web font packed by Brotli, which is not installed; expected a .ttf or .otf",
            file=path,
            hint="pip install brotli",
        ) from None
    except Exception as cause:  # of its many kinds, few are documented
        raise InputError(
            "{file}: broken web font ({cause}); expected .ttf or .otf",
            file=path,
            cause=cause,
        ) from None
    return out.getvalue()


def _check_is_drawn(path: Path, face: Any) -> None:
    """Refuse fonts of pictures: paint3d paints outlines."""
    if face.has_color_layers or face.has_color_paint or face.has_color_svg:
        kind = Message("a colour font")
    elif not _has_any(face, ("glyf", "CFF ", "CFF2")):
        bitmaps = _has_any(face, ("CBDT", "EBDT", "bdat", "sbix"))
        kind = Message("a bitmap font") if bitmaps else Message("without outlines")
    else:
        return
    name = face.get_name(_FULL_NAME) or path.name
    raise InputError(
        "{file}: {name} is {kind}; expected a font of outlines in one colour",
        file=path,
        name=name,
        kind=kind,
    )


def _has_any(face: Any, tags: tuple[str, ...]) -> bool:
    """Return whether a font has one of these tables; a damaged font may have unnamed ones."""
    return any(face.reference_table(tag).data for tag in tags)


def _vary(path: Path, face: Any, font: Any, variations: Mapping[str, float]) -> None:
    if not variations:
        return
    try:
        axes = {axis.tag: axis for axis in face.axis_infos}
    except UnicodeDecodeError:
        raise InputError(
            "{file}: damaged: an axis has no name; expected a whole font", file=path
        ) from None
    for tag, value in variations.items():
        if tag not in axes:
            known = ", ".join(axes) or "none: it is not variable"
            raise InputError(
                "{file}: no axis {tag!r}; it has {known}",
                file=path,
                tag=tag,
                known=known,
            )
        low, high = axes[tag].min_value, axes[tag].max_value
        if not low <= value <= high:
            raise InputError(
                "{file}: {tag} is {value:g}; expected {low:g} to {high:g}",
                file=path,
                tag=tag,
                value=value,
                low=low,
                high=high,
            )
    font.set_variations(dict(variations))


class _Rings:
    """A pen that HarfBuzz draws with, in the manner of fontTools' pens."""

    def __init__(self, flatness: float) -> None:
        self._flatness = flatness
        self._rings: list[list[AnyArray]] = []

    def rings(self) -> list[AnyArray]:
        """The closed curves (N, 2) drawn so far."""
        return [np.array(ring) for ring in self._rings if len(ring) > 2]

    def moveTo(self, point: tuple[float, float]) -> None:
        self._rings.append([np.array(point, np.float64)])

    def lineTo(self, point: tuple[float, float]) -> None:
        self._rings[-1].append(np.array(point, np.float64))

    def qCurveTo(self, *points: tuple[float, float]) -> None:
        self.curveTo(*points)

    def curveTo(self, *points: tuple[float, float]) -> None:
        controls = np.array([self._rings[-1][-1], *points], np.float64)
        self._rings[-1].extend(bezier_points(controls, self._flatness))

    def closePath(self) -> None:
        pass

    def endPath(self) -> None:
        pass
