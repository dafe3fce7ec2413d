"""Films as .mp4, H.264: packed by FFmpeg, which runs as a program of its own beside this one.

Its licence is the GPL in most builds, so that no library of it is loaded here. It is the one that
comes with the package imageio-ffmpeg (BSD), else the one of the system.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import IO

import numpy as np
from PIL import Image

from paint3d.core.types import AnyArray
from paint3d.errors import ExportError

__all__ = ["find_encoder", "write_mp4"]

_ENCODERS = {  # by preference; how each is told to lose little
    "libx264": ("-crf", "16", "-preset", "medium"),
    "libopenh264": ("-b:v", "8M"),
    "mpeg4": ("-q:v", "2"),
}
_COLOURS = "bt709"
_LIST_S = 20.0
_FINEST_RATE = 1001  # denominator of a rate that is no whole number


def find_encoder() -> str:
    """The program that packs films.

    Raises
    ------
    ExportError
        If there is none.
    """
    with suppress(ImportError, RuntimeError):  # the second where the package brings no program
        from imageio_ffmpeg import get_ffmpeg_exe

        return str(get_ffmpeg_exe())
    found = shutil.which("ffmpeg")
    if found is None:
        raise ExportError(
            ".mp4 needs FFmpeg, which was not found; expected: pip install 'paint3d[film]', or "
            "FFmpeg of the system; .webp and .gif need nothing"
        )
    return found


def write_mp4(part: Path, pictures: Iterable[Image.Image], rate: float) -> None:
    """Write pictures, all of one size, as a film; they are asked for one after the other.

    An odd width or height becomes even by the last column or row once more: so the format wants it.
    Whatever stops it ends the program that packs.

    Parameters
    ----------
    part : Path
        Where; what is there is written over.
    pictures : iterable of Image
    rate : float
        Pictures a second.

    Raises
    ------
    ExportError
        If FFmpeg is not there, or cannot write it.
    """
    program = find_encoder()
    frames = (_even(picture) for picture in pictures)
    first = next(frames)
    height, width = first.shape[:2]
    with tempfile.TemporaryFile() as told:
        command = _command(program, (width, height), rate, part)
        packing = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=told,
            start_new_session=True,  # an interrupt of the terminal is this program's
        )
        try:
            assert packing.stdin is not None, "it was asked for"
            with suppress(BrokenPipeError):  # it says itself why
                _feed(packing.stdin, first, frames)
            failed = packing.wait() != 0
        finally:
            packing.kill()
            packing.wait()
        if failed:
            told.seek(0)
            raise ExportError(f"{part.name}: cannot write: {_reason(told.read())}")


def _feed(stream: IO[bytes], first: AnyArray, others: Iterator[AnyArray]) -> None:
    with stream:
        stream.write(first.tobytes())
        for frame in others:
            stream.write(frame.tobytes())


def _reason(told: bytes) -> str:
    lines = told.decode("utf-8", "replace").split("\n")
    said = [" ".join(line.split()) for line in lines if line.strip()]
    return said[0][:200] if said else "FFmpeg ended without a word"


def _even(picture: Image.Image) -> AnyArray:
    pixels = np.asarray(picture.convert("RGB"))
    odd = [(0, n % 2) for n in pixels.shape[:2]]
    return np.pad(pixels, (*odd, (0, 0)), mode="edge")


def _command(program: str, size: tuple[int, int], rate: float, part: Path) -> list[str]:
    encoder = _encoder_of(program)
    shown = f"scale=out_color_matrix={_COLOURS}:out_range=tv:flags=accurate_rnd+full_chroma_int"
    frequency = Fraction(rate).limit_denominator(_FINEST_RATE)
    return [
        program, "-hide_banner", "-loglevel", "error", "-nostdin", "-y",
        "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{size[0]}x{size[1]}",
        "-framerate", str(frequency), "-i", "pipe:0",
        "-an", "-vf", f"{shown},format=yuv420p", "-c:v", encoder, *_ENCODERS[encoder],
        "-colorspace", _COLOURS, "-color_primaries", _COLOURS, "-color_trc", _COLOURS,
        "-color_range", "tv", "-movflags", "+faststart", "-fflags", "+bitexact",
        "-flags:v", "+bitexact", "-f", "mp4", f"file:{part}",
    ]  # fmt: skip


def _encoder_of(program: str) -> str:
    """The encoder that is preferred of those that a build of FFmpeg has."""
    try:
        asked = subprocess.run(
            [program, "-hide_banner", "-encoders"],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_LIST_S,
            check=False,
        )
    except (OSError, subprocess.SubprocessError) as cause:
        raise ExportError(f"{program}: it does not run: {cause}") from None
    words = asked.stdout.decode("utf-8", "replace").split()
    for name in _ENCODERS:
        if name in words:
            return name
    raise ExportError(f"{program}: it has none of {', '.join(_ENCODERS)}; expected another FFmpeg")
