"""Colour tags of pictures: an ICC profile (ICC.1:2022, matrix and curve) and `cICP`."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np

from paint3d.colour.spectra import WHITE_XYZ
from paint3d.colour.viewing import ADAPTATIONS, GAMUTS, adapt_white
from paint3d.core.arrays import AnyArray

__all__ = ["icc_profile", "picture_tags"]

_D50 = (0.9642, 1.0, 0.8249)  # the profile connection space's white, ICC.1, 7.2.16
_CURVE = (2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)  # sRGB's: g, a, b, c, d of type 3
_SRGB_TRANSFER = 13  # H.273
_COPYRIGHT = "No copyright, use freely"


def picture_tags(gamut: str, form: str) -> dict[str, Any]:
    """Arguments for Pillow to tag a PNG or WEBP picture with a gamut; none for sRGB."""
    if gamut == "srgb":
        return {}
    tags: dict[str, Any] = {"icc_profile": icc_profile(gamut)}
    if form == "PNG":
        from PIL.PngImagePlugin import PngInfo

        chunks = PngInfo()
        chunks.add(b"cICP", bytes((GAMUTS[gamut].h273, _SRGB_TRANSFER, 0, 1)))
        tags["pnginfo"] = chunks
    return tags


def icc_profile(gamut: str) -> bytes:
    """An ICC profile, version 4, of a gamut with the transfer function of sRGB."""
    matrix = np.asarray(ADAPTATIONS["bradford"])
    to_d50 = adapt_white(matrix, WHITE_XYZ, np.array(_D50))
    primaries = to_d50 @ np.linalg.inv(GAMUTS[gamut].rgb_from_xyz)
    curve = b"para" + struct.pack(">IHH", 0, 3, 0) + _pack_fixed(_CURVE)
    tags = [
        (b"desc", _multilingual_text(GAMUTS[gamut].title)),
        (b"cprt", _multilingual_text(_COPYRIGHT)),
        (b"wtpt", b"XYZ " + bytes(4) + _pack_fixed(_D50)),
        (b"chad", b"sf32" + bytes(4) + _pack_fixed(to_d50.ravel())),
        *(
            (b"%cXYZ" % c, b"XYZ " + bytes(4) + _pack_fixed(primaries[:, k]))
            for k, c in enumerate(b"rgb")
        ),
        *((b"%cTRC" % c, curve) for c in b"rgb"),
    ]
    start = 128 + 4 + 12 * len(tags)
    offsets: dict[bytes, int] = {}
    table, body = struct.pack(">I", len(tags)), b""
    for name, data in tags:
        padded = data + bytes(-len(data) % 4)
        if padded not in offsets:  # the three curves are one
            offsets[padded] = start + len(body)
            body += padded
        table += name + struct.pack(">II", offsets[padded], len(data))
    return _icc_header(start + len(body)) + table + body


def _icc_header(size: int) -> bytes:
    return (
        struct.pack(">I4sI4s4s4s", size, bytes(4), 0x04400000, b"mntr", b"RGB ", b"XYZ ")
        + struct.pack(">6H", 2026, 1, 1, 0, 0, 0)  # a fixed day: the same painting, the same bytes
        + b"acsp"
        + bytes(28)
        + _pack_fixed(_D50)
        + bytes(48)
    )


def _multilingual_text(words: str) -> bytes:
    utf16 = words.encode("utf-16-be")
    return b"mluc" + struct.pack(">IIIHHII", 0, 1, 12, 0x656E, 0x5553, len(utf16), 28) + utf16


def _pack_fixed(numbers: AnyArray | tuple[float, ...]) -> bytes:
    """Numbers as s15Fixed16."""
    return np.rint(np.asarray(numbers, np.float64) * 65536.0).astype(">i4").tobytes()
