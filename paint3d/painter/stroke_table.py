"""What every stroke of a replay did, in numbers: how long, how hard, how much ink it left."""

from __future__ import annotations

import csv
import math
import os
from dataclasses import astuple, dataclass, fields
from typing import TYPE_CHECKING

from paint3d.brush_engine.stroke_loop import FOOTPRINTS
from paint3d.core.atomic import write_atomically
from paint3d.device.recorded import MAX_FORCE_N

if TYPE_CHECKING:
    from paint3d.painter.flat_input import LaidPad
    from paint3d.painter.painter import Painter
    from paint3d.recording.recording import Recording

__all__ = ["StrokeRow", "StrokeTable"]


@dataclass
class StrokeRow:
    """One stroke: from where the tuft touches the surface to where it leaves it.

    Attributes
    ----------
    stroke : int
        From 1.
    start_s, end_s : float
        Times of the last sample before it touched and of the last one that did, since the
        recording's first.
    length_mm : float
        That the footprint went on the surface.
    mean_force_n, most_force_n : float or None
        Over its time; None where the recording tells none.
    footprints : int
    ink_left : float
        Pigment that went from the brush to the surface, coats x mm2.
    ink_in_brush : float
        That the brush holds where the stroke ends, coats x mm2.
    """

    stroke: int
    start_s: float
    end_s: float
    length_mm: float = 0.0
    mean_force_n: float | None = None
    most_force_n: float | None = None
    footprints: int = 0
    ink_left: float = 0.0
    ink_in_brush: float = 0.0


class StrokeTable:
    """Rows that fill while a painter replays recordings: `painter.replay(..., table=table)`.

    Attributes
    ----------
    rows : list of StrokeRow

    Examples
    --------
    >>> import paint3d
    >>> surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=1.0)
    >>> painter = paint3d.Painter(surface)
    >>> line = painter.stroke([(-30, 0, 0), (30, 0, 0)], pressure=(0.1, 0.5, 0.1))
    >>> table = paint3d.StrokeTable()
    >>> painter.replay(line, table=table)
    >>> [round(row.length_mm) for row in table.rows]
    [60]
    """

    def __init__(self) -> None:
        self.rows: list[StrokeRow] = []

    def begin(self, painter: Painter, recording: Recording | LaidPad) -> None:
        """Take the rows that come from a recording."""
        self._painter, self._start_ns = painter, int(recording.time_ns[0])
        self._open: StrokeRow | None = None
        self._last = -1.0, 0.0  # time and force of the sample before
        self._impulse = 0.0  # N s
        self._note_before()
        if recording.pressure is not None:
            self._last = 0.0, MAX_FORCE_N * float(recording.pressure[0])

    def see(self, time_ns: int, pressure: float) -> None:
        """Take the sample that the painter has just come to; a pressure of NaN is none."""
        time_s, force = 1e-9 * (time_ns - self._start_ns), MAX_FORCE_N * pressure
        before_s, before = self._last
        if time_s <= before_s:
            return
        self._last = time_s, force
        stamp = self._painter.stamp.values[0]
        if not stamp["touches"] > 0.0:
            self._account()  # of what it gave while it left the surface
            self.end()
            self._note_before()
            return
        if self._open is None:
            self._open = StrokeRow(len(self.rows) + 1, max(before_s, 0.0), time_s)
            self.rows.append(self._open)
            self._impulse = 0.0
        row = self._open
        row.end_s, row.length_mm = time_s, float(stamp["way"])
        self._account()
        if not math.isnan(pressure):
            self._impulse += 0.5 * (before + force) * (time_s - max(before_s, 0.0))
            row.most_force_n = max(before, force, row.most_force_n or 0.0)
            row.mean_force_n = self._impulse / max(row.end_s - row.start_s, 1e-9)

    def _account(self) -> None:
        row, painter = self._open, self._painter
        if row is not None:
            row.ink_in_brush = painter.in_brush()
            row.ink_left = painter.loaded - row.ink_in_brush - self._before[0]
            row.footprints = int(painter.scratch.counters[FOOTPRINTS]) - self._before[1]

    def end(self) -> None:
        """Close the row of the stroke that was painted last."""
        self._open = None

    def _note_before(self) -> None:
        painter = self._painter
        counters = painter.scratch.counters
        self._before = painter.loaded - painter.in_brush(), int(counters[FOOTPRINTS])

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the rows as CSV, whole or not at all; what is not told is an empty cell.

        Raises
        ------
        ExportError
            If the file cannot be written.
        """
        with write_atomically(path) as temporary, open(temporary, "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow([field.name for field in fields(StrokeRow)])
            for row in self.rows:
                writer.writerow("" if value is None else value for value in astuple(row))
