"""Measurements of every stroke of a replay: times, length, force and ink."""

from __future__ import annotations

import csv
import math
import os
from dataclasses import astuple, dataclass, fields
from typing import NamedTuple

from paint3d.core.atomic import write_atomically
from paint3d.device.recorded import MAX_FORCE_N

__all__ = ["BrushState", "StrokeRow", "StrokeTable"]


class BrushState(NamedTuple):
    """Totals of a painter's brush so far."""

    touches: bool
    way_mm: float  # since it touched
    ink_given: float  # coats x mm2, ever
    ink_held: float
    footprints: int  # ever
    contacts: int  # samples that met the surface, ever


@dataclass
class StrokeRow:
    """One stroke: from where the tuft touches the surface to where it leaves it, with a footprint.

    Attributes
    ----------
    stroke : int
        From 1.
    start_s, end_s : float
        Times of the last sample before it touched and of the last one that did, since the
        recording's first.
    length_mm : float
        Path of the footprint on the surface, up to the last sample that touches.
    mean_force_n, most_force_n : float or None
        Over its time; None if the recording has no pressure.
    footprints : int
    ink_left : float
        Pigment that went from the brush to the surface, coats x mm2; below 0 where the pen's
        eraser end takes it off.
    ink_in_brush : float
        Held by the brush where the stroke ends, coats x mm2.
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
    """Rows that a painter adds while it replays recordings: `painter.replay(..., table=table)`.

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

    def begin(self, time_ns: int, pressure: float, brush: BrushState) -> None:
        """Take the first sample of a recording, before it is painted; a pressure of NaN is none."""
        self._start_ns, self._before = time_ns, brush
        self._open: StrokeRow | None = None
        self._last = 0.0, MAX_FORCE_N * pressure  # time and force of the sample before
        self._impulse = 0.0  # N s
        self._contacts = brush.contacts

    def add(self, time_ns: int, pressure: float, brush: BrushState) -> None:
        """Take the next sample, after painting up to it."""
        time_s, force = 1e-9 * (time_ns - self._start_ns), MAX_FORCE_N * pressure
        before_s, before = self._last
        if time_s <= before_s:
            return
        self._last = time_s, force
        # `touches` alone may be left from before
        painted, self._contacts = brush.contacts > self._contacts, brush.contacts
        if painted and self._open is None:
            self._open = StrokeRow(len(self.rows) + 1, before_s, time_s)
            self._impulse = 0.0
        row = self._open
        if row is not None:
            row.ink_left = brush.ink_given - self._before.ink_given  # also while it lifts off
            row.ink_in_brush = brush.ink_held
            row.footprints = brush.footprints - self._before.footprints
            if row.footprints and row.stroke > len(self.rows):
                self.rows.append(row)
        if not (painted and brush.touches):
            self._open, self._before = None, brush
            return
        assert row is not None, "it touches"
        row.end_s, row.length_mm = time_s, brush.way_mm
        if not math.isnan(pressure):
            self._impulse += 0.5 * (before + force) * (time_s - before_s)
            row.most_force_n = max(before, force, row.most_force_n or 0.0)
            row.mean_force_n = self._impulse / (row.end_s - row.start_s)

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the rows as CSV, atomically; None is an empty cell.

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
