"""Films: pictures one after the other, in a file."""

from __future__ import annotations

import math
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from fractions import Fraction
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import IO, Any, BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from paint3d.core.arrays import AnyArray
from paint3d.core.machine import reserve_space
from paint3d.errors import ExportError
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view.studio import Gloss

__all__ = [
    "FILMS",
    "MOST_PIXELS",
    "Grown",
    "Growth",
    "film_form",
    "find_encoder",
    "is_held_whole",
    "write_film",
    "write_mp4",
]

# ---- MP4 -----------------------------------------------------------------------------------------
# Films as .mp4, H.264: packed by FFmpeg, which runs as a program of its own beside this one.
#
# Its licence is the GPL in most builds, so that no library of it is loaded here. It is the one that
# comes with the package imageio-ffmpeg (BSD), else the one of the system.


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


# --------------------------------------------------------------------------------------------------


FILMS = {".mp4": "MP4", ".webp": "WEBP", ".gif": "GIF"}
"""What the formats of films are called by who writes them."""
MOST_PIXELS = 4e8
"""Of all pictures of a film that is held in memory until it is written."""


def film_form(path: Path) -> str:
    """The format of a film by its suffix, if it can be written here.

    Raises
    ------
    ExportError
        If the suffix is that of no film, or what writes .mp4 is not installed.
    """
    form = FILMS.get(path.suffix.lower())
    if form is None:
        raise ExportError(f"{path}: a film is written as {', '.join(FILMS)}")
    if form == "MP4":
        find_encoder()
    return form


def is_held_whole(form: str) -> bool:
    """Whether pictures of such a film stay in memory until it is written."""
    return form != "MP4"


def write_film(
    part: Path,
    pictures: Iterator[Image.Image],
    n: int,
    form: str,
    rate: float,
    how: Mapping[str, Any] | None = None,
) -> None:
    """Write a film; its pictures are asked for one after the other.

    What it will take of the disk is kept free for it when two pictures are there: where there is no
    room for it, no more are asked for. For an .mp4, whose size nobody can tell, nothing is.

    Parameters
    ----------
    part : Path
        A file that is there, and is written over.
    pictures : iterator of Image
        All of one size.
    n : int
        How many, 2 at least.
    form : str
        One of those of `FILMS`.
    rate : float
        Pictures a second. A GIF counts hundredths of a second, a WebP thousandths.
    how : mapping, optional
        What Pillow is told besides for a GIF or a WebP, such as its quality and its profile.

    Raises
    ------
    ExportError, OSError
        If it cannot be written.
    """
    if form == "MP4":
        write_mp4(part, pictures, rate)
        return
    how = how or {}
    with open(part, "r+b") as file:
        first, second = next(pictures), next(pictures)
        reserve_space(file, _film_bytes(first, second, n, form, how))
        _write(file, first, chain([second], pictures), form, rate, how)
        file.truncate()


def _write(
    file: BinaryIO,
    first: Image.Image,
    others: Iterable[Image.Image],
    form: str,
    rate: float,
    how: Mapping[str, Any],
) -> None:
    duration = round(1e3 / rate)
    first.save(file, form, save_all=True, append_images=others, duration=duration, loop=0, **how)


def _film_bytes(
    first: Image.Image, second: Image.Image, n: int, form: str, how: Mapping[str, Any]
) -> int:
    """About what a film of n pictures takes that begins with these two."""
    sizes = []
    for others in ([], [second]):
        _write(short := BytesIO(), first, others, form, 1.0, how)
        sizes.append(len(short.getvalue()))
    return sizes[0] + (n - 1) * max(0, sizes[1] - sizes[0])


# ---- How a painting came about -------------------------------------------------------------------
# How the colours of a painting came about: what is kept while it is painted, for a film of it.


_IN_MEMORY = 64_000_000  # bytes; more goes to the disk
_ROUND = 1e-9


class Grown(NamedTuple):
    """One picture: colours as they are seen, and roughness, None where all is as the material."""

    srgb: NDArray[np.uint8]  # (V, 3)
    roughness: NDArray[np.float32] | None  # (V,)


class Growth:
    """How a surface looked at equal steps of time, kept as what changed; used with `with`.

    Vertices that come later are shown from the beginning, bare until something is painted on them.
    Nothing that is painted becomes otherwise by being looked at.

    Parameters
    ----------
    surface : PaintedSurface
        As the film begins.
    step_s : float
        Between two pictures, s of the painting's own time.

    Attributes
    ----------
    surface : PaintedSurface
    """

    def __init__(self, surface: PaintedSurface, step_s: float) -> None:
        self.surface, self._step_s = surface, step_s
        self._material = Gloss.of(surface.material).seen_roughness
        self._is_plain = True  # nothing was wet, and all ink dried as its material is
        self._start = self._seen()
        self._last = self._start
        self._lengths: list[int] = []
        self._file = tempfile.SpooledTemporaryFile(max_size=_IN_MEMORY)  # noqa: SIM115

    def __enter__(self) -> Growth:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    @property
    def n_pictures(self) -> int:
        """How many there are by now; the first is as the film begins."""
        return 1 + len(self._lengths)

    def at(self, seconds: float) -> None:
        """Keep what is there, if it is time for a picture, or for more than one.

        Parameters
        ----------
        seconds : float
            Since the beginning; does not go back.
        """
        due = math.floor(seconds / self._step_s + _ROUND) - len(self._lengths)
        if due > 0:
            self._lengths += [0] * (due - 1)
            self._keep()

    def end(self, seconds: float) -> None:
        """Keep what is there as the last picture."""
        self.at(seconds)
        self._keep()

    def _keep(self) -> None:
        now, last = self._seen(), self._last
        changed = np.flatnonzero((now[: len(last)] != last).any(axis=1))
        ids = np.concatenate([changed, np.arange(len(last), len(now))]).astype(np.int32)
        self._file.write(ids.tobytes() + now[ids].tobytes())
        self._lengths.append(len(ids))
        self._last = now

    def _seen(self) -> NDArray[np.uint8]:
        """(V, 4): colours as they are seen, and roughness in steps of 1/255."""
        codes, look = self.surface.srgb, self.surface.wet_look
        if look is None:
            return self._with_roughness(codes, self._material)
        self._is_plain = False
        return self._with_roughness(look.seen(codes), look.roughness(self._material))

    @staticmethod
    def _with_roughness(codes: AnyArray, roughness: AnyArray | float) -> NDArray[np.uint8]:
        seen = np.empty((len(codes), 4), np.uint8)
        seen[:, :3], seen[:, 3] = codes, np.rint(255.0 * np.asarray(roughness))
        return seen

    def pictures(self) -> Iterator[Grown]:
        """Each picture, of all vertices there are in the end.

        What comes out is another one's next time: it is to be used before the next is asked for.
        """
        seen = self._with_roughness(self.surface.bare_codes, self._material)
        seen[: len(self._start)] = self._start
        yield self._grown(seen)
        self._file.seek(0)
        for n in self._lengths:
            ids = np.frombuffer(self._file.read(4 * n), np.int32)
            seen[ids] = np.frombuffer(self._file.read(4 * n), np.uint8).reshape(n, 4)
            yield self._grown(seen)

    def _grown(self, seen: NDArray[np.uint8]) -> Grown:
        rough = None if self._is_plain else seen[:, 3].astype(np.float32) / np.float32(255.0)
        return Grown(seen[:, :3], rough)
