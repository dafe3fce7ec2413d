"""Photographs as cameras and strangers write them."""

from __future__ import annotations

import importlib.util
import os
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from paint3d.errors import InputError
from paint3d.files.photographs import load_photograph, read_photograph


def halves(width: int = 120, height: int = 80) -> Image.Image:
    """A picture whose left half is red, the right one black."""
    pixels = np.zeros((height, width, 3), np.uint8)
    pixels[:, : width // 2] = (200, 30, 20)
    return Image.fromarray(pixels)


def read(path: Path, longest: int = 500) -> np.ndarray:
    return read_photograph(path, longest)[0]


def test_a_photograph_is_read_apart(tmp_path: Path) -> None:
    file = tmp_path / "a.jpg"
    halves(4000, 1000).save(file, quality=95)
    pixels, scale = load_photograph(file)
    assert max(pixels.shape) <= 3200
    assert scale == pytest.approx(4000 / pixels.shape[1])
    assert np.abs(pixels[10, 10].astype(int) - (200, 30, 20)).max() < 12
    assert pixels[10, -10].max() < 12


def test_exif_says_which_way_is_up(tmp_path: Path) -> None:
    file = tmp_path / "a.jpg"
    exif = Image.Exif()
    exif[0x0112] = 6  # the camera was turned: its picture stands on its side
    halves().save(file, exif=exif, quality=95)
    pixels, full = read_photograph(file, 500)
    assert pixels.shape[:2] == full == (120, 80)
    assert pixels[10, 40, 0] > 150
    assert pixels[110, 40].max() < 20


def test_cmyk_alpha_palettes_and_16_bits_are_read(tmp_path: Path) -> None:
    halves().convert("CMYK").save(tmp_path / "cmyk.jpg", quality=95)
    assert np.abs(read(tmp_path / "cmyk.jpg")[40, 20].astype(int) - (200, 30, 20)).max() < 12
    clear = halves().convert("RGBA")
    clear.putalpha(Image.fromarray(np.repeat([[255] * 60 + [0] * 60], 80, axis=0).astype(np.uint8)))
    clear.save(tmp_path / "clear.png")
    assert read(tmp_path / "clear.png")[40, 100].tolist() == [255, 255, 255]
    halves().convert("P", palette=Image.Palette.ADAPTIVE).save(tmp_path / "palette.gif")
    assert np.abs(read(tmp_path / "palette.gif")[40, 20].astype(int) - (200, 30, 20)).max() < 12
    deep = np.zeros((80, 120), np.uint16)
    deep[:, :60] = 40000
    Image.fromarray(deep).save(tmp_path / "deep.png")
    assert read(tmp_path / "deep.png")[40, 20].tolist() == [156, 156, 156]
    assert read(tmp_path / "deep.png")[40, 100].tolist() == [0, 0, 0]


def test_a_profile_is_heeded(tmp_path: Path) -> None:
    from PIL import ImageCms

    lab = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    halves().save(tmp_path / "tagged.png", icc_profile=lab)
    assert np.abs(read(tmp_path / "tagged.png")[40, 20].astype(int) - (200, 30, 20)).max() < 3
    halves().save(tmp_path / "broken.png", icc_profile=b"no profile")
    assert read(tmp_path / "broken.png")[40, 20].tolist() == [200, 30, 20]


def test_a_decompression_bomb_is_refused(tmp_path: Path) -> None:
    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    head = struct.pack(">IIBBBBB", 60000, 60000, 8, 2, 0, 0, 0)
    file = tmp_path / "bomb.png"
    packed = zlib.compress(b"\0" * 1000)
    file.write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", packed) + chunk(b"IEND", b"")
    )
    with pytest.raises(InputError, match=r"60,000 x 60,000 pixels; expected 134,217,728"):
        load_photograph(file)


def test_what_is_no_picture_is_refused_in_one_line(tmp_path: Path) -> None:
    file = tmp_path / "a.jpg"
    file.write_bytes(b"no picture\n" * 50)
    with pytest.raises(InputError, match=r"no picture that can be read \(of no known kind\)"):
        load_photograph(file)
    halves().save(tmp_path / "whole.png")
    file.write_bytes((tmp_path / "whole.png").read_bytes()[:120])
    with pytest.raises(InputError, match="no picture that can be read"):
        load_photograph(file)
    with pytest.raises(InputError, match="no such file"):
        load_photograph(tmp_path / "none.jpg")
    with pytest.raises(InputError, match="it is a folder; expected a photograph"):
        load_photograph(tmp_path)
    if os.path.exists(os.devnull):
        with pytest.raises(InputError, match="it is no plain file; expected a photograph"):
            load_photograph(os.devnull)
    with pytest.raises(InputError, match="File name too long"):
        load_photograph(tmp_path / f"{300 * 'a'}.jpg")
    Image.new("RGB", (40, 400)).save(tmp_path / "slim.png")
    with pytest.raises(InputError, match="40 x 400 pixels; expected 64"):
        load_photograph(tmp_path / "slim.png")


def test_other_kinds_are_refused_by_their_content(tmp_path: Path) -> None:
    """PostScript and the like, which Pillow would hand to other programs, whatever the name."""
    file = tmp_path / "a.png"
    file.write_bytes(b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 100 100\n")
    with pytest.raises(InputError, match="no picture that can be read"):
        load_photograph(file)


def test_heic_says_what_it_needs(tmp_path: Path, monkeypatch) -> None:
    file = tmp_path / "a.heic"
    file.write_bytes(b"\0\0\0\x18ftypheic" + b"\0" * 100)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InputError, match="pip install pillow-heif"):
        read_photograph(file, 500)


def test_heic_is_read(tmp_path: Path) -> None:
    heif = pytest.importorskip("pillow_heif")
    heif.register_heif_opener()
    file = tmp_path / "a.HEIC"
    halves(1600, 1200).save(file, "HEIF", quality=90)
    pixels, scale = load_photograph(file)
    assert pixels.shape == (1200, 1600, 3)
    assert scale == 1.0
    assert np.abs(pixels[40, 20].astype(int) - (200, 30, 20)).max() < 25
    assert pixels[40, -20].max() < 12
    file.write_bytes(file.read_bytes()[:2000])
    with pytest.raises(InputError, match="no picture that can be read"):
        load_photograph(file)


def test_grey_of_real_numbers_goes_to_1(tmp_path: Path) -> None:
    grey = np.full((80, 120), 0.5, np.float32)
    grey[:, :60] = 1.0
    grey[0, 0] = np.nan
    Image.fromarray(grey).save(tmp_path / "a.tif")
    assert read(tmp_path / "a.tif")[40, 20].tolist() == [255, 255, 255]
    assert read(tmp_path / "a.tif")[40, 100].tolist() == [128, 128, 128]
