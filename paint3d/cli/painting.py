"""What `demo` and `replay` share: paint a recording on an object and account for it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from paint3d.cli.first_run import say_if_compiling
from paint3d.cli.progress import ProgressBar
from paint3d.cli.versions import find_versions
from paint3d.core.atomic import write_atomically
from paint3d.errors import PigmentError, RecordingError
from paint3d.files.readers.odd_names import json_text

if TYPE_CHECKING:
    from paint3d.colour.pigment import Pigment
    from paint3d.mesh.triangle_mesh import TriangleMesh
    from paint3d.painter.flat_input import LaidPad
    from paint3d.recording.recording import Recording
    from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["DEFAULT_INK", "PaintOptions", "Painting", "paint", "prepare", "timed", "write_report"]

_DEFAULT_BRUSH = "full"
DEFAULT_INK = "pine soot"


@dataclass(frozen=True)
class PaintOptions:
    """What the user asked for; brush and ink None stand for the recording's own.

    With `spread_s` the ink spreads and dries while it is painted, and so many seconds more. `hairs`
    says of how many single hairs the tuft is; 0: solid, None: as the brush has it.
    """

    brush: str | None = None
    ink: str | None = None
    material: str = "porcelain"
    resolution_mm: float = 0.4
    quiet: bool = False
    spread_s: float | None = None
    hairs: int | None = None

    def check(self) -> None:
        """Look up everything that is named, before any work.

        Raises
        ------
        InputError
            If the brush, the ink or the material is not known or cannot be read.
        """
        from paint3d.brush.presets import load_brush
        from paint3d.colour.materials import load_material
        from paint3d.colour.pigments import load_pigment

        load_material(self.material)
        if self.brush is not None:
            load_brush(self.brush)
        if self.ink is not None:
            load_pigment(self.ink)


@dataclass(frozen=True)
class Painting:
    """A painted surface, what painting it took, what made it, and the seconds of each step."""

    surface: PaintedSurface
    counts: dict[str, Any]
    seconds: dict[str, float]
    recordings: tuple[Recording | LaidPad, ...] = ()
    settings: dict[str, Any] = field(default_factory=dict)

    def whole_recordings(self) -> tuple[Recording, ...]:
        """The recordings in the world; a pad's is laid down as a whole."""
        from paint3d.painter.flat_input import LaidPad

        return tuple(r.whole() if isinstance(r, LaidPad) else r for r in self.recordings)

    def describe(self) -> dict[str, Any]:
        """Everything that ``--report`` writes: versions, seconds by stage, counts, ink ledger."""
        return {
            "versions": find_versions(),
            **self.counts,
            "seconds_by_step": {step: round(spent, 4) for step, spent in self.seconds.items()},
        }

    def summarize(self) -> str:
        """One line on what was painted."""
        return (
            f"{self.counts['samples']:,} samples, {self.counts['footprints']:,} footprints, "
            f"{self.counts['vertices_painted']:,} vertices painted in "
            f"{self.seconds['paint']:.1f} s"
        )


@contextmanager
def timed(seconds: dict[str, float], step: str) -> Iterator[None]:
    """Add the seconds spent inside to ``seconds[step]``."""
    started = time.perf_counter()
    yield
    seconds[step] = seconds.get(step, 0.0) + time.perf_counter() - started


def prepare(mesh: TriangleMesh, wanted: PaintOptions, seconds: dict[str, float]) -> PaintedSurface:
    """Make a mesh ready for painting, adding the time that takes to `seconds`.

    Raises
    ------
    InputError
        If the material is not known, or the mesh cannot be painted on at this resolution.
    """
    from paint3d.colour.materials import load_material
    from paint3d.surface.painted_surface import PaintedSurface

    material = load_material(wanted.material)
    say_if_compiling(quiet=wanted.quiet)
    with timed(seconds, "prepare"), ProgressBar("preparing", enabled=not wanted.quiet):
        return PaintedSurface(mesh, resolution=wanted.resolution_mm, material=material)


def paint(
    surface: PaintedSurface,
    recording: Recording | LaidPad,
    wanted: PaintOptions,
    seconds: dict[str, float],
) -> Painting:
    """Paint a recording on a surface of `prepare`, showing a progress bar on a terminal.

    Raises
    ------
    InputError
        If the brush, the ink or a sample cannot be used.
    """
    from paint3d.brush.presets import load_brush
    from paint3d.painter.painter import Painter

    brush = load_brush(wanted.brush or _named_in(recording, "brush", _DEFAULT_BRUSH))
    ink = _ink(recording, wanted.ink)
    with timed(seconds, "prepare"), ProgressBar("preparing", enabled=not wanted.quiet):
        azimuth = recording.header["azimuth"]
        painter = Painter(surface, brush, ink, azimuth, hairs=wanted.hairs)
    with (
        timed(seconds, "paint"),
        ProgressBar("painting", enabled=not wanted.quiet) as progress,
    ):
        rest_s = wanted.spread_s
        painter.replay(recording, progress, wet=rest_s is not None, rest_s=rest_s or 0.0)
        counts = painter.report()
    settings = {"brush": asdict(brush), "ink": ink.name, "azimuth": azimuth}
    if painter.hairs is not None:
        settings["hairs"] = asdict(painter.hairs.spec)
    return Painting(surface, counts, seconds, (recording,), settings)


def _ink(recording: Recording | LaidPad, wished: str | None) -> Pigment:
    """The ink that the user wants, or the recording's own, which names no file of this machine."""
    from paint3d.colour.pigments import load_pigment

    if wished:
        return load_pigment(wished)
    try:
        return load_pigment(_named_in(recording, "ink", DEFAULT_INK), own_tables=False)
    except PigmentError as cause:
        raise RecordingError(f"the header: {cause}, or --ink") from None


def _named_in(recording: Recording | LaidPad, what: str, default: str) -> str:
    """The recording's own brush or ink, or the default where it names none."""
    name = recording.header.get(what)
    if name is None:
        return default
    if not isinstance(name, str):
        raise RecordingError(f"the header's {what} is {name!r:.60}; expected a name")
    return name


def write_report(file: Path, painting: Painting) -> None:
    """Write the report as JSON, whole or not at all.

    Raises
    ------
    ExportError
        If the file cannot be written.
    """
    text = json_text(painting.describe(), indent=2, allow_nan=False)
    with write_atomically(file) as part:
        part.write_text(text + "\n", encoding="utf-8")
