"""`--film`: a film of a painting as it grows, beside or instead of the painting itself."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import paint3d.cli.picture as pictures
from paint3d.cli.options import FILM, add_fps_option, check_output_file, group_of, parse_number
from paint3d.cli.progress import ProgressBar
from paint3d.errors import InputError

if TYPE_CHECKING:
    from paint3d.files.pictures import Filmed
    from paint3d.painter.flat_input import LaidPad
    from paint3d.recording.recording import Recording
    from paint3d.surface.painted_surface import PaintedSurface
    from paint3d.view.film import Growth
    from paint3d.view.shot import Shot

__all__ = ["FilmWanted", "Watch", "add_film_options", "film_of"]

_SUFFIXES = (".mp4", ".gif", ".webp")
_LONGEST_S = 20.0  # length of a film without --speed
_RATES = {".mp4": 24.0}
_RATE = 12.0
_MOST_PICTURES = 20_000
_OF_FILMS = ("fps", "speed", "turn", "view", "light", "zoom", "pixels")


def add_film_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--film`` and the options of films."""
    film = group_of(parser, FILM)
    film.add_argument(
        "--film",
        metavar="FILE",
        type=Path,
        help="the painting as it grows, in the hand's own time: .mp4 (with FFmpeg: "
        "pip install 'paint3d[film]'), .gif or .webp",
    )
    add_fps_option(film)
    film.add_argument(
        "--speed",
        metavar="X",
        type=lambda text: parse_number(
            text, "a speed", "0.01 to 1000", lambda n: 0.01 <= n <= 1000.0
        ),
        help="how many times as fast as the hand, whose rests count 1 s at most (default: 1, or "
        "what makes it 20 s long)",
    )
    film.add_argument(
        "--turn",
        metavar="S|DEG",
        type=_parse_turn,
        help="let the object turn: once in so many seconds (8), or by so many degrees in all "
        "(360deg)",
    )
    pictures.add_view_options(film, "640x480")


def _parse_turn(text: str) -> tuple[float, bool]:
    """Parse seconds or degrees; return the number, and whether it is degrees."""
    in_degrees = text.lower().endswith("deg")
    number = parse_number(
        text[:-3] if in_degrees else text.removesuffix("s"),
        "a turn",
        "seconds of 0.5 to 600, such as 8, or degrees of 1 to 36000, such as 360deg",
        lambda n: 1.0 <= n <= 36000.0 if in_degrees else 0.5 <= n <= 600.0,
    )
    return number, in_degrees


@dataclass(frozen=True, eq=False)
class FilmWanted:
    """The options of a film."""

    file: Path
    rate: float
    speed: float | None
    turn: tuple[float, bool] | None
    shot: Shot
    quiet: bool

    def of_recording(
        self, surface: PaintedSurface, recording: Recording | LaidPad, rest_s: float | None
    ) -> Watch:
        """Watch a recording; with `rest_s` ink spreads meanwhile, and so long afterwards."""
        from paint3d.recording.recording import HandTime

        clock = HandTime(in_full=rest_s is not None)
        clock.pass_samples(recording.time_ns)
        return self.begun(surface, clock.seconds + (rest_s or 0.0))

    def begun(self, surface: PaintedSurface, seconds: float) -> Watch:
        """Watch a painting that takes `seconds` of the hand's time.

        Raises
        ------
        InputError
            If that makes too many pictures.
        """
        from paint3d.view.film import Growth

        speed = self.speed or max(1.0, seconds / _LONGEST_S)
        n = seconds / speed * self.rate + 2.0
        if n > _MOST_PICTURES:
            raise InputError(
                "--film: {seconds:.0f} s of painting at {speed:g} times its speed are {n:.0f} "
                "pictures; expected {most} at most: a higher --speed",
                seconds=seconds,
                speed=speed,
                n=n,
                most=_MOST_PICTURES,
            )
        self.filmed(int(n)).check(self.file, self.shot, int(n))
        return Watch(self, Growth(surface, speed / self.rate), speed / self.rate)

    def filmed(self, n_pictures: int) -> Filmed:
        """Return its settings for so many pictures, not counting those of the finished painting."""
        from paint3d.files.pictures import Filmed

        filmed = Filmed(self.rate)
        if self.turn is None:
            return filmed
        turn, in_degrees = self.turn
        if in_degrees:  # from the first picture to the last
            turn = 360.0 / turn * (n_pictures + filmed.n_held - 1) / self.rate
        return filmed._replace(turn_s=turn)


class Watch:
    """Records how a painting grows, and writes the film of it.

    Attributes
    ----------
    step_s : float
        Between two pictures, s of the hand's time.
    """

    def __init__(self, wanted: FilmWanted, growth: Growth, step_s: float) -> None:
        self._wanted, self._growth, self.step_s = wanted, growth, step_s
        self._seconds = 0.0

    def at(self, seconds: float) -> None:
        """Record the painting at a time since the beginning, by the hand's time."""
        self._seconds = max(seconds, self._seconds)
        self._growth.at(self._seconds)

    def over(
        self,
        recording: Recording | LaidPad,
        rest_s: float | None,
        progress: Callable[[float], None],
    ) -> Callable[[float], None]:
        """Return a progress callback for `Painter.replay` that records, and calls another one."""
        from paint3d.painter.ink_time import INK_STEP_S
        from paint3d.recording.recording import HandTime

        wet, n = rest_s is not None, len(recording)
        when = HandTime(in_full=wet).pass_samples(recording.time_ns)
        before = -1

        def report(fraction: float) -> None:
            nonlocal before
            k = min(max(round(fraction * n) - 1, 0), n - 1)
            if k > before:
                self.at(float(when[k if wet else min(k + 1, n - 1)]))
            else:  # ink spreads
                self.at(self._seconds + INK_STEP_S)
            before = k
            progress(fraction)

        return report

    def resting(self, progress: Callable[[float], None]) -> Callable[[float], None]:
        """Return a progress callback for `Painter.rest` that records, and calls another one."""
        from paint3d.painter.ink_time import INK_STEP_S

        before = 0.0

        def report(fraction: float) -> None:
            nonlocal before
            if fraction > before:  # else the ink's time stands still
                self.at(self._seconds + INK_STEP_S)
            before = fraction
            progress(fraction)

        return report

    def write(self) -> int:
        """Write the film; return its number of pictures.

        Raises
        ------
        Paint3DError
            If it cannot be made or written.
        """
        from paint3d.files.pictures import write_growth

        wanted = self._wanted
        with self._growth as growth, ProgressBar("filming", enabled=not wanted.quiet) as progress:
            growth.end(self._seconds)
            filmed = wanted.filmed(growth.n_pictures)
            return write_growth(growth, wanted.file, wanted.shot, filmed, progress)


def film_of(options: argparse.Namespace) -> FilmWanted | None:
    """Return the film that the options of `add_film_options` ask for.

    Raises
    ------
    Paint3DError
        If it cannot be written here, or options of films are given without one.
    """
    if options.film is None:
        for name in _OF_FILMS:
            if getattr(options, name) is not None:
                option = "--" + name.replace("_", "-")
                raise InputError("{option} is of a film; expected --film FILE, too", option=option)
        return None
    check_output_file(options.film, _SUFFIXES)
    from paint3d.view.film import film_form
    from paint3d.view.shot import Shot

    film_form(options.film)
    shot = Shot(
        options.view or "auto",
        options.pixels or pictures.FILM_SIZE,
        options.light or "studio",
        zoom=1.0 if options.zoom is None else options.zoom,
    )
    rate = options.fps or _RATES.get(options.film.suffix.lower(), _RATE)
    return FilmWanted(options.film, rate, options.speed, options.turn, shot, options.quiet)
