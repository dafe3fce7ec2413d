"""Fuzzed inputs that are copied: photographs and fonts; and spectra of lights and pigments."""

from __future__ import annotations

import io
import random
import zlib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from scripts.fuzz.mutation import damage
from scripts.fuzz.target import Target, file_of

__all__ = ["COPIED"]

# -- photographs --------------------------------------------------------------------------------

_PNG = b"\x89PNG\r\n\x1a\n"
_LONGEST = 48  # so that each is made smaller, too


def _photograph_seeds() -> list[tuple[str, bytes]]:
    from PIL import Image, ImageCms, TiffImagePlugin

    rows = np.arange(64 * 80, dtype=np.uint32).reshape(80, 64)
    codes = np.stack([rows // 20, rows // 33 + 90, 250 - rows // 25], axis=-1).astype(np.uint8)
    photo, seeds = Image.fromarray(codes), []
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    exif = Image.Exif()
    exif[0x0112] = 6  # turned a quarter

    def keep(picture: Any, suffix: str, form: str, **how: Any) -> None:
        out = io.BytesIO()
        picture.save(out, form, **how)
        seeds.append((suffix, out.getvalue()))

    grey, wide = photo.convert("L"), Image.fromarray((rows * 12).astype(np.uint16))
    keep(photo, ".jpg", "JPEG", exif=exif, icc_profile=_without_date(profile), progressive=True)
    keep(photo.convert("CMYK"), ".jpg", "JPEG")
    keep(photo.convert("RGBA"), ".png", "PNG", icc_profile=_without_date(profile))
    keep(photo.quantize(16), ".png", "PNG", transparency=3)
    keep(wide, ".png", "PNG")
    for how in ("tiff_lzw", "group4"):
        picture = grey.convert("1") if how == "group4" else photo
        keep(
            picture,
            ".tif",
            "TIFF",
            compression=how,
            tiffinfo=TiffImagePlugin.ImageFileDirectory_v2(),
        )
    keep(photo, ".webp", "WEBP", lossless=True, exif=exif)
    keep(photo.quantize(8), ".gif", "GIF", save_all=True, append_images=[grey])
    keep(photo, ".bmp", "BMP")
    keep(grey, ".pgm", "PPM")
    with suppress(ImportError):  # not every installation reads it
        import pillow_heif

        pillow_heif.register_heif_opener()
        keep(photo, ".heic", "HEIF", quality=60)
    return seeds


def _without_date(profile: bytes) -> bytes:
    """A profile that is the same tomorrow."""
    return profile[:24] + bytes(12) + profile[36:]


def _damage_photograph(data: bytes, chance: random.Random, others: Sequence[bytes]) -> bytes:
    """Damage a photograph; PNG chunks mostly keep valid checksums, or readers stop early."""
    if not data.startswith(_PNG) or chance.random() < 0.2:
        return damage(data, chance, others)
    chunks, at = [], len(_PNG)
    while at + 12 <= len(data):
        length = int.from_bytes(data[at : at + 4], "big")
        chunks.append((data[at + 4 : at + 8], data[at + 8 : at + 8 + length]))
        at += 12 + length
    for _ in range(chance.choice((1, 1, 2))):
        k = chance.randrange(len(chunks))
        kind, content = chunks[k]
        way = chance.random()
        if kind == b"IDAT" and way < 0.5:  # what it packs
            with suppress(zlib.error):  # it may be damaged already
                content = zlib.compress(damage(zlib.decompress(content), chance, []), 1)
            chunks[k] = (kind, content)
        elif way < 0.8:
            chunks[k] = (kind, damage(content, chance, [c for _, c in chunks]))
        elif way < 0.9:
            del chunks[k]
        else:
            chunks.insert(chance.randrange(len(chunks) + 1), chunks[k])
        if not chunks:
            break
    return _PNG + b"".join(
        len(content).to_bytes(4, "big")
        + kind
        + content
        + zlib.crc32(kind + content).to_bytes(4, "big")
        for kind, content in chunks
    )


def _check_photograph(suffix: str, content: bytes) -> None:
    from paint3d.files.photographs import read_photograph

    pixels, full = read_photograph(file_of(suffix, content), _LONGEST)
    assert pixels.dtype == np.uint8
    assert pixels.ndim == 3
    assert pixels.shape[2] == 3
    assert 0 < max(pixels.shape[:2]) <= _LONGEST
    assert (full[0] > full[1]) == (pixels.shape[0] > pixels.shape[1]) or 1 in pixels.shape


# -- fonts --------------------------------------------------------------------------------------

_LETTERS = "Aif"
_FEATURES = (
    "languagesystem DFLT dflt; languagesystem latn dflt;"
    "feature liga { sub f i by A; } liga; feature kern { pos A f -80; pos [A i] i 20; } kern;"
    "feature ss01 { sub A by i; } ss01;"
)


def _draw(pen: Any, k: int, *, quadratic: bool) -> None:
    pen.moveTo((50 + 20 * k, 0))
    pen.lineTo((50 + 20 * k, 700))
    if quadratic:
        pen.qCurveTo((300, 760), (420, 600), (400, 0))
    else:
        pen.curveTo((300, 760), (420, 600), (400, 0))
    pen.closePath()
    if k == 0:  # a hole
        pen.moveTo((150, 100))
        pen.lineTo((250, 100))
        pen.lineTo((200, 300))
        pen.closePath()


def _font(*, quadratic: bool, variable: bool = False, flavor: str | None = None) -> bytes:
    from fontTools.fontBuilder import FontBuilder
    from fontTools.pens.t2CharStringPen import T2CharStringPen
    from fontTools.pens.ttGlyphPen import TTGlyphPen

    names = [".notdef", *_LETTERS, "space"]
    builder = FontBuilder(1000, isTTF=quadratic)
    builder.setupGlyphOrder(names)
    builder.setupCharacterMap({**{ord(c): c for c in _LETTERS}, 32: "space"})
    drawn = {}
    for k, name in enumerate(names):
        pen = TTGlyphPen(None) if quadratic else T2CharStringPen(500, None)
        if name in _LETTERS:
            _draw(pen, k - 1, quadratic=quadratic)
        drawn[name] = pen.glyph() if quadratic else pen.getCharString()
    if quadratic:
        pen = TTGlyphPen(drawn)
        pen.addComponent("A", (0.5, 0, 0, 0.5, 10, 20))
        pen.addComponent("i", (1, 0, 0, 1, 300, 0))
        builder.setupGlyf({**drawn, "f": pen.glyph()})
    else:
        builder.setupCFF("Fuzz", {"FullName": "Fuzz"}, drawn, {})
    builder.setupHorizontalMetrics(dict.fromkeys(names, (500, 50)))
    builder.setupHorizontalHeader(ascent=800, descent=-200)
    builder.setupNameTable({"familyName": "Fuzz", "styleName": "Regular", "fullName": "Fuzz"})
    builder.setupOS2(sTypoAscender=800, sTypoDescender=-200, usWinAscent=900, usWinDescent=300)
    builder.setupPost()
    builder.addOpenTypeFeatures(_FEATURES)
    if variable:
        from fontTools.ttLib.tables.TupleVariation import TupleVariation

        builder.setupFvar([("wght", 100, 400, 900, "Weight")], [])
        moved = TupleVariation({"wght": (0.0, 1.0, 1.0)}, [(0, 0), (0, 60), (40, 0)] + [None] * 9)
        points = len(builder.font["glyf"]["i"].coordinates) + 4
        moved.coordinates = [(5 * n, -3 * n) for n in range(points)]
        builder.setupGvar({"i": [moved]})
    font, out = builder.font, io.BytesIO()
    font["head"].created = font["head"].modified = 3_600_000_000  # s since 1904
    font.recalcTimestamp = False
    font.cfg["fontTools.ttLib.tables.otBase:USE_HARFBUZZ_REPACKER"] = False  # older ones warn of it
    font.flavor = flavor
    font.save(out)
    return out.getvalue()


def _collection() -> bytes:
    from fontTools.ttLib import TTCollection, TTFont

    both, out = TTCollection(), io.BytesIO()
    both.fonts = [
        TTFont(io.BytesIO(_font(quadratic=True)), recalcTimestamp=False) for _ in range(2)
    ]
    both.save(out)
    return out.getvalue()


def _font_seeds() -> list[tuple[str, bytes]]:
    return [
        (".ttf", _font(quadratic=True)),
        (".otf", _font(quadratic=False)),
        (".ttf", _font(quadratic=True, variable=True)),
        (".ttc", _collection()),
        (".woff", _font(quadratic=True, flavor="woff")),
    ]


def _check_font(suffix: str, content: bytes) -> None:
    """Open a font, shape a text in it, and take the outlines of what comes out."""
    from paint3d.calligraphy.fonts.font_file import open_font
    from paint3d.calligraphy.fonts.shaping import Shaper, Style
    from paint3d.errors import InputError

    path = file_of(suffix, content)
    with suppress(InputError):
        open_font(path, variations={"wght": 650.0})
    opened = open_font(path, 1 if suffix == ".ttc" else 0)
    assert opened.licence
    text = "fi A"
    opened.check_has(text)
    assert np.isfinite(opened.extents).all()
    for style in (Style(), Style(direction="ttb")):
        for one in Shaper(opened, style).shape(text):
            assert np.isfinite([one.x, one.y, one.advance]).all()
            assert np.isfinite(opened.outline(one.glyph).area)


# -- spectra ------------------------------------------------------------------------------------


def _spectrum_seeds() -> list[tuple[str, bytes]]:
    import colour

    nm = range(380, 781, 20)
    data = {float(n): 0.2 + 0.5 * n / 780 for n in nm}
    plain = "# a lamp\nnm, W\n" + "".join(f"{n:g}, {p:.4f}\n" for n, p in data.items())
    seeds = [(".spd", plain.encode()), (".txt", plain.replace(", ", "\t").encode("utf-16"))]
    with TemporaryDirectory() as folder:
        for kind in ("reflectance", "relative"):
            path = Path(folder) / "a.spdx"
            head = colour.io.tm2714.Header_IESTM2714(description="a lamp", document_creator="me")
            colour.SpectralDistribution_IESTM2714(
                str(path), header=head, spectral_quantity=kind, data=data
            ).write()
            seeds.append((".spdx", path.read_bytes()))
    table = "BEGIN_DATA_FORMAT\nSAMPLE_NAME " + " ".join(f"nm{n}" for n in nm)
    table += "\nEND_DATA_FORMAT\nBEGIN_DATA\nA1 red " + " ".join(f"{p:.4f}" for p in data.values())
    seeds.append((".txt", (table + "\nEND_DATA\n").encode()))
    return seeds


def _check_spectrum(suffix: str, content: bytes) -> None:
    """A file as a light, and as a pigment's masstone: one of the two it may well not be."""
    import warnings

    from paint3d.colour.illuminants import find_illuminant
    from paint3d.colour.pigments import load_pigment
    from paint3d.errors import Paint3DError

    path = file_of(suffix, content)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # colour-science's own
        refused = []
        try:
            power = find_illuminant.__wrapped__(str(path))
            assert np.isfinite(power).all()
            assert power.min() >= 0.0
            assert power.max() > 0.0
        except Paint3DError as cause:
            refused.append(cause)
        try:
            pigment = load_pigment(f"{path}:a")
            assert np.isfinite(pigment.K).all()
        except Paint3DError as cause:
            refused.append(cause)
        for cause in refused:
            if "\n" in str(cause) or len(refused) == 2:
                raise cause


COPIED: dict[str, Target] = {
    "photograph": Target(
        "photographs and scans", _photograph_seeds, _check_photograph, _damage_photograph
    ),
    "font": Target("fonts", _font_seeds, _check_font),
    "spectrum": Target("lights and pigments by their spectra", _spectrum_seeds, _check_spectrum),
}
