"""Video files, and the recording of how a painting came about."""

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
# H.264 in .mp4, encoded by FFmpeg as a separate process.
#
# Most builds of FFmpeg are under the GPL, so none of its libraries is loaded. The program is the
# one that comes with the package imageio-ffmpeg (BSD), else that of the system.


_ENCODERS = {  # in order of preference, with options for high quality
    "libx264": ("-crf", "16", "-preset", "medium"),
    "libopenh264": ("-b:v", "8M"),
    "mpeg4": ("-q:v", "2"),
}
_COLOURS = "bt709"
_LIST_S = 20.0  # longest wait for the list of encoders, s
_FINEST_RATE = 1001  # greatest denominator of a fractional frame rate


def find_encoder() -> str:
    """Return the path of FFmpeg.

    Raises
    ------
    ExportError
        If there is none.
    """
    with suppress(ImportError, RuntimeError):  # the latter if the package has no program
        from imageio_ffmpeg import get_ffmpeg_exe

        return str(get_ffmpeg_exe())
    found = shutil.which("ffmpeg")
    if found is None:
        raise ExportError(
            ".mp4 needs FFmpeg, which was not found; expected FFmpeg of the system, or a film in "
            ".webp or .gif, which need nothing",
            hint="pip install 'paint3d[film]'",
        )
    return found


def write_mp4(part: Path, pictures: Iterable[Image.Image], rate: float) -> None:
    """Write pictures, all of one size, as a film; they are consumed one at a time.

    The format needs even dimensions: of an odd width or height the last column or row is repeated.
    On any exception the FFmpeg process is killed.

    Parameters
    ----------
    part : Path
        File to write, overwritten if it exists.
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
    with tempfile.TemporaryFile() as messages:
        command = _command(program, (width, height), rate, part)
        encoding = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=messages,
            start_new_session=True,  # Ctrl-C in the terminal must reach only this process
        )
        try:
            assert encoding.stdin is not None, "stdin is a pipe"
            with suppress(BrokenPipeError):  # FFmpeg's own message says why it quit
                _feed(encoding.stdin, first, frames)
            failed = encoding.wait() != 0
        finally:
            encoding.kill()
            encoding.wait()
        if failed:
            messages.seek(0)
            raise ExportError(
                "{part}: cannot write: {reason}",
                part=part.name,
                reason=_reason(messages.read()),
            )


def _feed(stream: IO[bytes], first: AnyArray, others: Iterator[AnyArray]) -> None:
    with stream:
        stream.write(first.tobytes())
        for frame in others:
            stream.write(frame.tobytes())


def _reason(messages: bytes) -> str:
    lines = messages.decode("utf-8", "replace").split("\n")
    reasons = [" ".join(line.split()) for line in lines if line.strip()]
    return reasons[0][:200] if reasons else "FFmpeg ended without a word"


def _even(picture: Image.Image) -> AnyArray:
    """Return the pixels (H, W, 3), padded to even dimensions."""
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
    """Return the preferred one of the encoders that a build of FFmpeg has."""
    try:
        listing = subprocess.run(
            [program, "-hide_banner", "-encoders"],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_LIST_S,
            check=False,
        )
    except (OSError, subprocess.SubprocessError) as cause:
        raise ExportError(
            "{program}: it does not run: {cause}", program=program, cause=cause
        ) from None
    words = listing.stdout.decode("utf-8", "replace").split()
    for name in _ENCODERS:
        if name in words:
            return name
    raise ExportError(
        "{program}: it has none of {encoders}; expected another FFmpeg",
        program=program,
        encoders=", ".join(_ENCODERS),
    )


# ---- Film formats --------------------------------------------------------------------------------


FILMS = {".mp4": "MP4", ".webp": "WEBP", ".gif": "GIF"}
"""Format of a film by its suffix, as Pillow names it."""
MOST_PIXELS = 4e8
"""Greatest number of pixels, all pictures together, of a film that is held in memory."""


def film_form(path: Path) -> str:
    """Return the format of a film by its suffix, if it can be written here.

    Raises
    ------
    ExportError
        If the suffix is not that of a film, or FFmpeg for .mp4 is not installed.
    """
    form = FILMS.get(path.suffix.lower())
    if form is None:
        raise ExportError("{file}: a film is written as {films}", file=path, films=", ".join(FILMS))
    if form == "MP4":
        find_encoder()
    return form


def is_held_whole(form: str) -> bool:
    """Return whether all pictures of such a film stay in memory until it is written."""
    return form != "MP4"


def write_film(
    part: Path,
    pictures: Iterator[Image.Image],
    n: int,
    form: str,
    rate: float,
    how: Mapping[str, Any] | None = None,
) -> None:
    """Write a film; its pictures are consumed one at a time.

    Its disk space is estimated from the first two pictures and reserved, so that a full disk is
    noticed before the others are made. For an .mp4, whose size is unpredictable, it is not.

    Parameters
    ----------
    part : Path
        An existing file, which is overwritten.
    pictures : iterator of Image
        All of one size.
    n : int
        Number of pictures, at least 2.
    form : str
        One of those of `FILMS`.
    rate : float
        Pictures a second. A GIF counts hundredths of a second, a WebP thousandths.
    how : mapping, optional
        Further options of Pillow for a GIF or a WebP, such as quality and profile.

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
    """Estimate the size of a film of n pictures that begins with these two, bytes."""
    sizes = []
    for others in ([], [second]):
        _write(short := BytesIO(), first, others, form, 1.0, how)
        sizes.append(len(short.getvalue()))
    return sizes[0] + (n - 1) * max(0, sizes[1] - sizes[0])


# ---- Recording a painting ------------------------------------------------------------------------
# Recording of a surface's colours while it is painted, for a film of it.


_IN_MEMORY = 64_000_000  # bytes of a recording; more goes to disk
_ROUND = 1e-9


class Grown(NamedTuple):
    """One picture: visible colours and roughness, None if all is as rough as the material."""

    srgb: NDArray[np.uint8]  # (V, 3)
    roughness: NDArray[np.float32] | None  # (V,)


class Growth:
    """Delta-coded recording of a surface at equal time steps; a context manager.

    Vertices that are added later are in all pictures, bare until they are painted on. Recording
    does not affect the painting.

    Parameters
    ----------
    surface : PaintedSurface
        In its state at the beginning of the film.
    step_s : float
        Time between two pictures, s of the painting's own time.

    Attributes
    ----------
    surface : PaintedSurface
    """

    def __init__(self, surface: PaintedSurface, step_s: float) -> None:
        self.surface, self._step_s = surface, step_s
        self._material = Gloss.of(surface.material).seen_roughness
        self._is_plain = True  # so far nothing was wet, and all ink dried as rough as the material
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
        """Number of pictures so far, including that of the beginning."""
        return 1 + len(self._lengths)

    def at(self, seconds: float) -> None:
        """Record the present state if one picture or more are due.

        Parameters
        ----------
        seconds : float
            Time since the beginning; must not decrease.
        """
        due = math.floor(seconds / self._step_s + _ROUND) - len(self._lengths)
        if due > 0:
            self._lengths += [0] * (due - 1)
            self._keep()

    def end(self, seconds: float) -> None:
        """Record the present state as the last picture."""
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
        """Return visible colours and roughness (V, 4), the latter in steps of 1/255."""
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
        """Yield each picture, with all vertices that exist in the end.

        The arrays are reused: use a picture before taking the next.
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
