"""The painter: moves one inked brush over a surface along a sequence of timed poses.

Samples become poses in the object's frame (`pose`), along which `brush_engine.stroke_loop` runs the
pipeline: foot point and bent brush, enclosing sphere and plane, outline, sweep, ink. Painting is
deterministic: it depends on no clock, file or random source, and the same samples give the same
painting to the bit, for any number of threads and any chunking.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.brush.bending import tuft_on
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BristleSpec, BrushSpec, DipAmount, build_curves
from paint3d.brush_engine import placement
from paint3d.brush_engine.contact import Contact, find_contact
from paint3d.brush_engine.footprint import Stamp
from paint3d.brush_engine.ink_transfer import PAINTED, level_reservoirs
from paint3d.brush_engine.scratch import grow_scratch, make_scratch
from paint3d.brush_engine.stroke_loop import (
    FINISHED,
    FOOTPRINTS,
    SAMPLES,
    Canvas,
    HeldBrush,
    Samples,
    make_progress,
    paint_samples,
    prepare_samples,
)
from paint3d.brush_engine.tuft import Tuft
from paint3d.brush_engine.vertex_query import VISITED
from paint3d.colour.inks import load_ink
from paint3d.colour.pigments import Pigment, load_pigment
from paint3d.core.ahead import ahead
from paint3d.core.arrays import AnyArray, as_number
from paint3d.device.sample import DIP, ERASER, DeviceSample
from paint3d.errors import InputError, Message, RecordingError
from paint3d.painter.flat_input import LaidPad
from paint3d.painter.ink_time import INK_STEP_S, LOOKAHEAD, Pauses, ink_steps_until
from paint3d.painter.pose_check import fit_to_tuft, inspect_poses, log_warnings
from paint3d.painter.recorded_tools import LEAST_INK, changes_at, eraser_runs
from paint3d.painter.stroke_table import BrushState, StrokeTable
from paint3d.pose.brush_pose import BrushPath, brush_poses, object_poses
from paint3d.recording.recording import Recording
from paint3d.surface.eraser import Eraser
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.undo import BrushLoad

if TYPE_CHECKING:
    from paint3d.painter.bristle_state import HairTuft  # brings the kernels of hairs

__all__ = ["Painter"]

_PART = 1 << 16  # samples of a recording that are prepared at once
_CHUNK = 2000  # samples between two calls of `progress`
_LONGEST_REST_S = 1e9  # longer than any ink stays wet
_RESERVOIRS = 12  # segments of a tuft whose load varies along its length

Ink = str | Pigment | Mapping[Any, float]
"""One ink, or a mixture as parts by pigment; pigments as objects or by name."""


class Painter:
    """Paints on a surface with one brush.

    Parameters
    ----------
    surface : PaintedSurface
    brush : str or BrushSpec
        A name of the presets, or a brush file of one's own (.toml, .json).
    ink : str, Pigment, mapping or None
        What the brush is dipped in; see `dip`. None: it holds the load stored with the surface, as
        after opening a session.
    azimuth : {"commanded", "dragged"}
        Whether the pose's roll turns the tuft, or drag on the surface does.
    pickup : float, optional
        Fraction of the wet ink under the brush that it takes back per mm of travel at full pressure
        (0.05 is a thirsty brush); 0: it stays clean. None: leave the surface's value, 0 on a new
        one.
    hairs : int or BristleSpec, optional
        Paint with this many single hairs, or with these; 0 for a solid tuft. None: as the brush's
        preset.
    amount : DipAmount, optional
        How much ink a dip takes up; by default the preset's full load.

    Attributes
    ----------
    tuft : Tuft
        Bending and ink transfer of the brush on this surface, with the load of `amount`.
    amount : DipAmount
        How much ink a dip takes up.
    curves : Curves
        Input curves that modulate the brush while it paints.
    hairs : HairTuft or None
        None for a solid tuft.
    scratch : Scratch
        Working memory and counters of the kernels.

    Raises
    ------
    UnknownNameError
        For an unknown brush or ink.
    InputError
        If there is no ink and the surface has never had one.
    """

    def __init__(
        self,
        surface: PaintedSurface,
        brush: str | BrushSpec = "full",
        ink: Ink | None = "pine soot",
        azimuth: str = "commanded",
        pickup: float | None = None,
        hairs: int | BristleSpec | None = None,
        amount: DipAmount | None = None,
    ) -> None:
        if azimuth not in ("commanded", "dragged"):
            raise InputError(
                "azimuth is {azimuth!r}; expected 'commanded' or 'dragged'",
                azimuth=azimuth,
            )
        self.surface = surface
        self.brush = load_brush(brush) if isinstance(brush, str) else brush
        self.amount = amount or DipAmount()
        self.tuft = self._dipped_tuft(self.brush)
        self.curves = build_curves(self.brush.inputs)
        self._wanted_hairs = hairs
        self.hairs = self._make_hairs()
        self.azimuth = azimuth
        self.loaded = 0.0
        self.seconds = {"poses": 0.0, "stroke": 0.0, "colour": 0.0}
        self._progress = make_progress()
        self.scratch = make_scratch(surface.paint_mesh, len(surface.pigments))
        self._pending: list[DeviceSample] = []
        self._schedule = _Schedule()
        self._n_released = 0  # samples of the live stroke that are painted and dropped
        self._origin_ns = 0
        self._n_samples = 0
        self._dip_down = False
        self._eraser: Eraser | None = None  # while a recording's eraser end is down
        self._set_aside: tuple[dict[str, object], BrushLoad] | None = None  # the brush meanwhile
        self._dipped: Ink = {}
        self._dips: tuple[tuple[Ink, float | None], ...] = ()
        if pickup is not None:
            surface.ink.transfer["pickup"] = as_number(pickup, "pickup (1/mm)", 0.0)
        if ink is None:
            self._adopt_load()
        else:
            self.dip(ink)

    # -- the brush --------------------------------------------------------------------------

    def dip(
        self,
        ink: Ink | None = None,
        reach: float | None = None,
        amount: DipAmount | None = None,
    ) -> None:
        """Rinse the brush and load it with `ink` (None: repeat the last dips, whole and tip).

        Parameters
        ----------
        ink : str, Pigment or mapping, optional
            An ink, or a mixture by parts: ``{"pine soot": 0.2, "water": 0.8}``, or the same as
            text, ``"pine soot:0.2,water:0.8"`` or ``"light"``; see `load_ink`.
        reach : float, optional
            Dip only this fraction of the tuft's length, from the tip, 0 to 1; the rest keeps its
            load: first the belly in light ink, then the tip in dark. A whole dip also brings single
            hairs to a point.
        amount : DipAmount, optional
            How much ink the brush takes up, from now on; None: unchanged.

        Raises
        ------
        InputError
            If a part is not a number above 0, the reach is not between 0 and 1, or an amount is
            given for the tip alone.
        """
        if amount is not None and reach is not None:
            raise InputError("an amount is given with a reach; expected it for a whole dip alone")
        if ink is None and reach is None and len(self._dips) > 1:
            self._take_amount(amount)
            for again in self._dips:
                self.dip(*again)
            return
        ink = _in_parts(self._dipped if ink is None else ink)
        parts = self._mixture(ink)
        depth = 1.0 if reach is None else as_number(reach, "reach", 0.0, 1.0)
        self._take_amount(amount)
        if self.hairs is not None:
            self.hairs.rescale(self.surface.ink.load)
        if reach is None:
            self._hold(parts * self.tuft.load)
        else:
            along = self.surface.ink.reservoirs
            if len(along) == 1:
                along = np.repeat(self.surface.ink.load[None] / _RESERVOIRS, _RESERVOIRS, axis=0)
            is_dipped = (np.arange(len(along)) + 0.5) / len(along) < depth
            full = parts * self.tuft.load / len(along)
            self._hold_along(np.where(is_dipped[:, None], full, along))
        if self.hairs is not None:
            self.hairs.dip(self.surface.ink.load, self.tuft.load, depth)
            self.surface.ink.load[:] = self.hairs.total()
            if reach is None:
                self.hairs.shape()
        # A dip hides earlier ones of the same reach or less:
        deeper = () if reach is None else (d for d in self._dips if d[1] is None or d[1] > depth)
        self._dips = (*deeper, (ink, None if reach is None else depth))
        self._dipped = ink
        self.ink = self.surface.main_pigment(parts)
        self._fit_scratch()

    def _adopt_load(self) -> None:
        """Start with the load stored with the surface; with none, the brush is dry."""
        surface = self.surface
        if not surface.pigments:
            raise InputError("ink is None, and this surface has never had any; expected an ink")
        load = surface.ink.load
        parts = load / load.sum() if load.any() else np.eye(len(load))[-1]
        self._dipped = {p: w for p, w in zip(surface.pigments, parts, strict=True) if w > 1e-9}
        self.ink = surface.main_pigment(parts)
        self._fit_scratch()
        accounts = self.ledger()
        self.loaded = sum(accounts.values()) - accounts["loaded"]

    def rinse(self) -> None:
        """Empty the brush: wash it out and shake it dry."""
        self._hold(np.zeros(len(self.surface.pigments)))

    def wipe(self, fraction: float = 0.5) -> None:
        """Wipe off a fraction of the load, 0 to 1; the mixture stays the same.

        Raises
        ------
        InputError
            If the fraction is not between 0 and 1.
        """
        self._scale_load(1.0 - as_number(fraction, "fraction", 0.0, 1.0))

    def fill_to(self, fraction: float) -> None:
        """Set the load to a fraction, 0 to 1, of a full dip; the mixture stays the same.

        Raises
        ------
        InputError
            If the fraction is not between 0 and 1.
        """
        fraction = as_number(fraction, "fraction", 0.0, 1.0)
        if not self.surface.ink.load.sum() > 0.0:
            self.dip()
        self._scale_load(fraction * self.tuft.load / float(self.surface.ink.load.sum()))

    def _scale_load(self, factor: float) -> None:
        """Multiply the load, along the tuft and in every hair, by a factor."""
        ink = self.surface.ink
        if len(ink.reservoirs) > 1:
            self._hold_along(ink.reservoirs * factor)
        else:
            self._hold(ink.load * factor)
        if self.hairs is not None:
            self.hairs.rescale(self.surface.ink.load)
            self.surface.ink.load[:] = self.hairs.total()

    def thin_to(self, fraction: float) -> None:
        """Dilute the load to a fraction, up to 1, of the ink last dipped in, the rest water.

        The next dip is in undiluted ink again.

        Raises
        ------
        InputError
            If the fraction is not between 0.0001 and 1.
        """
        fraction = as_number(fraction, "fraction", LEAST_INK, 1.0)
        dips = self._dips or ((self._dipped, None),)
        water = None if fraction == 1.0 else self.surface.column_of(load_pigment("water"))
        whole, *tips = [self._mixture(_in_parts(ink)) for ink, _ in dips]
        along = np.tile(whole, (len(self.surface.ink.reservoirs), 1))
        middle = (np.arange(len(along)) + 0.5) / len(along)
        for parts, (_, reach) in zip(tips, dips[1:], strict=True):
            along[middle < (1.0 if reach is None else reach)] = parts
        along *= fraction
        if water is not None:
            along[:, water] += 1.0 - fraction
        self._mix(along)

    def _mix(self, along: AnyArray) -> None:
        """Give the load these parts: (N, P) along the tuft, or (1, P) throughout."""
        field = self.surface.ink
        if self.hairs is not None:
            self.hairs.rescale(field.load)
            self.hairs.load = np.outer(self.hairs.load.sum(axis=1), along.mean(axis=0))
            self._hold(self.hairs.total())
        elif len(field.reservoirs) > 1:
            self._hold_along(along * field.reservoirs.sum(axis=1)[:, None])
        else:
            self._hold(along[0] * field.load.sum())
        self._fit_scratch()

    def recolour(self, ink: Ink) -> None:
        """Replace the ink in the brush, keeping the amount, hair by hair.

        Raises
        ------
        InputError
            As in `dip`.
        """
        ink = _in_parts(ink)
        parts = self._mixture(ink)
        self._mix(parts[None])
        self._dips, self._dipped = ((ink, None),), ink
        self.ink = self.surface.main_pigment(parts)

    def change_brush(self, brush: str | BrushSpec) -> None:
        """Switch to another brush, fully loaded with the same ink.

        Raises
        ------
        UnknownNameError, BrushError
            For an unknown brush, or one whose bending cannot be solved.
        """
        brush = load_brush(brush) if isinstance(brush, str) else brush
        self.tuft = self._dipped_tuft(brush)
        self.brush = brush
        self.curves = build_curves(brush.inputs)
        self.hairs = self._make_hairs()
        self.dip(self._dipped)

    def _take_amount(self, amount: DipAmount | None) -> None:
        """Set the amount of ink that dips take up; None: unchanged."""
        if amount is not None:
            self.amount = amount
            self.tuft = self._dipped_tuft(self.brush)

    def _dipped_tuft(self, brush: BrushSpec) -> Tuft:
        """Build the tuft of a brush on this surface, with the load of one dip."""
        return self.amount.of_tuft(tuft_on(brush, self.surface.material))

    def _make_hairs(self) -> HairTuft | None:
        wanted = self._wanted_hairs
        if wanted is None:
            wanted = self.brush.bristles
        elif isinstance(wanted, int) and not isinstance(wanted, bool) and wanted != 0:
            wanted = dataclasses.replace(self.brush.bristles or BristleSpec(), n_hairs=wanted)
        if wanted is None or (wanted == 0 and not isinstance(wanted, bool)):
            return None
        if not isinstance(wanted, BristleSpec):
            raise InputError(
                "hairs is {wanted!r:.60}; expected a number or a BristleSpec",
                wanted=wanted,
            )
        from paint3d.painter.bristle_state import HairTuft

        return HairTuft(self.brush, wanted)

    def shape(self) -> None:
        """Bring a tuft of single hairs to a point, as on the rim of an inkstone."""
        if self.hairs is not None:
            self.hairs.shape()

    @property
    def dipped(self) -> Ink:
        """The ink last dipped in."""
        return self._dipped

    @property
    def dips(self) -> tuple[tuple[Ink, float | None], ...]:
        """Inks and reaches that `dip` repeats without an ink: the whole tuft (None), then tips."""
        return self._dips

    def keep(self) -> dict[str, object]:
        """Snapshot, for `restore`, all state between strokes except the surface."""
        names = ("brush", "tuft", "amount", "loaded", "ink", "_dipped", "_dips", "hairs", "curves")
        kept = {name: getattr(self, name) for name in names}
        return kept | {"of_hairs": None if self.hairs is None else self.hairs.keep()}

    def restore(self, kept: Mapping[str, Any]) -> None:
        """Return to a snapshot of `keep`; `surface.undo` restores the surface."""
        of_hairs = kept.get("of_hairs")
        for name, value in kept.items():
            if name != "of_hairs":
                setattr(self, name, value)
        if self.hairs is not None and of_hairs is not None:
            self.hairs.restore(of_hairs)
        self._fit_scratch()

    def _mixture(self, ink: Ink) -> AnyArray:
        """Fractions (P,) of the surface's pigments in an ink; they sum to 1."""
        stirred: Mapping[Any, float] = ink if isinstance(ink, Mapping) else {ink: 1.0}
        if not stirred:
            raise InputError("the ink has no parts; expected at least one pigment")
        columns, weights = [], []
        for name, weight in stirred.items():
            pigment = load_pigment(name) if isinstance(name, str) else name
            columns.append(self.surface.column_of(pigment))
            weights.append(as_number(weight, f"part of {pigment.name}", 1e-9))
        parts = np.zeros(len(self.surface.pigments))
        np.add.at(parts, columns, np.array(weights) / sum(weights))
        return parts

    def _hold(self, load: AnyArray) -> None:
        """Set the load (P,), uniform along the tuft."""
        surface = self.surface
        self.loaded += surface.lasting(load - surface.ink.load)
        surface.ink.load[:] = load
        surface.ink.transfer["capacity"] = self.tuft.load
        surface.ink = surface.ink._replace(reservoirs=np.zeros((1, len(load))))

    def _hold_along(self, reservoirs: AnyArray) -> None:
        """Set the load (N, P) along the tuft, tip first."""
        surface = self.surface
        reservoirs = np.ascontiguousarray(reservoirs)
        level_reservoirs(reservoirs)
        load = reservoirs.sum(axis=0)
        self.loaded += surface.lasting(load - surface.ink.load)
        surface.ink.load[:] = load
        surface.ink.transfer["capacity"] = self.tuft.load
        surface.ink.transfer["reservoir_mm"] = self.brush.length_mm / len(reservoirs)
        surface.ink = surface.ink._replace(reservoirs=reservoirs)

    def in_brush(self) -> float:
        """Pigment in the brush, coats x mm2."""
        return self.surface.lasting(self.surface.ink.load)

    @property
    def stamp(self) -> Stamp:
        """The footprint placed last."""
        return self._progress.after

    def contact(
        self,
        position: ArrayLike,
        orientation: ArrayLike,
        pressure: float | None = None,
        place: ArrayLike | None = None,
    ) -> Contact | None:
        """Compute the contact of the brush with the surface in one pose; see `find_contact`."""
        surface = self.surface
        return find_contact(
            self.tuft, surface.paint_mesh, surface.contact_tree, position, orientation, pressure,
            place,
        )  # fmt: skip

    # -- painting ---------------------------------------------------------------------------

    def stroke(
        self,
        points: ArrayLike,
        pressure: ArrayLike = 0.5,
        tilt: ArrayLike = 0.0,
        *,
        speed: float = 60.0,
        side: str | None = None,
        wet: bool = False,
    ) -> Recording:
        """Paint a line along points on the surface.

        Parameters
        ----------
        points : (N, 3) or (N, 2) array_like
            mm, moved to the closest points of the surface, or U,V from 0 to 1 as ``--at`` of the
            command line has them. They are joined by straight lines that lie on the surface.
        pressure : float or (M,) array_like
            0 to 1; several are spread evenly along the line and joined smoothly.
        tilt : float or (M,) array_like
            The handle's lean off the surface's normal, degrees, up to 60 in the direction of the
            line and down to -60 against it.
        speed : float
            mm/s.
        side : {"outside", "inside", "top", "bottom"}, optional
            The side from which U,V are seen; by default chosen by the object's shape.
        wet : bool
            Let ink spread and dry meanwhile.

        Returns
        -------
        Recording
            The line as a hand would have drawn it, to be saved or replayed.

        Raises
        ------
        InputError
            If there are fewer than two points, or a number is out of range.
        MeshError
            If there is no surface at U,V.

        Examples
        --------
        >>> import paint3d
        >>> surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=1.0)
        >>> painter = paint3d.Painter(surface, ink="cinnabar")
        >>> stroke = painter.stroke([(-30, 0, 0), (0, 8, 0), (30, 0, 0)], pressure=(0.1, 0.6, 0.2))
        >>> stroke.duration_s > 1.0
        True
        """
        from paint3d.painter.line import record_line

        recording = record_line(
            self.surface.closest_points, points, pressure, tilt,
            length_mm=self.brush.length_mm, speed=speed, side=side,
            header={"brush": self.brush.name, "ink": self.ink.name, "azimuth": self.azimuth},
        )  # fmt: skip
        self.replay(recording, wet=wet)
        return recording

    def replay(
        self,
        recording: Recording | LaidPad,
        progress: Callable[[float], None] | None = None,
        frame_rate: float | None = None,
        wet: bool = False,
        table: StrokeTable | None = None,
    ) -> None:
        """Paint a whole recording; where its pen's eraser end is down, erase (`Eraser`).

        Poses that seem to be wrong are logged: a handle that points into the surface and, where
        something is painted, a tip that is taken for the ferrule, and positions in another frame.

        Parameters
        ----------
        recording : Recording or LaidPad
            Of any length: 65,536 samples at a time are prepared, the next ones while these are
            painted.
        progress : callable, optional
            Called with the fraction done, a few times a second, after every frame and pause.
        frame_rate : float, optional
            Refresh the colours at this rate, Hz of the recording's own time, as a live view would;
            the painting is the same without.
        wet : bool
            Let the ink spread and dry meanwhile, in the recording's own time (`painter.ink_time`).
        table : StrokeTable, optional
            Takes a row for every stroke; the painting is the same without.

        Raises
        ------
        InputError
            If it is no recording, such as the name of a file.
        """
        if not isinstance(recording, Recording | LaidPad):
            raise InputError(
                "recording is a {kind}; expected a Recording, which load_recording(FILE) reads",
                kind=type(recording).__name__,
            )
        self.finish()
        warnings: tuple[Message | None, ...] = ()
        if isinstance(recording, Recording):
            if recording.is_pad:
                raise RecordingError(
                    "the recording's space is 'pad'; expected 'world': lay it on the object first, "
                    "by paint3d.painter.flat_input.lay_at, as in painter.replay(lay_at(recording, "
                    "mesh, (0.5, 0.5), width_mm=60))",
                    hint="points on the object are painted by painter.stroke(points, pressure=...)",
                )
            length_mm = self.brush.length_mm
            recording = fit_to_tuft(recording, length_mm)
            warnings = inspect_poses(recording, self.surface.closest_points, length_mm)
        laid = int(self.scratch.counters[FOOTPRINTS])
        n, first, passed = len(recording), 0, 0
        start, at = int(recording.time_ns[0]), self._progress.at
        self._origin_ns = start
        ready = ahead(partial(self._prepare, recording, *span) for span in _spans(n))
        while True:
            last = min(n, first + _PART)
            times_ns, samples, refills, buttons = next(ready)
            time_s = (times_ns - start) * 1e-9
            known = last - first - 1 - (LOOKAHEAD if last < n else 0)
            pauses = Pauses(times_ns, samples.joined, passed - first)
            if table is not None and first == 0:
                table.begin(start, float(samples.pressure[0]), self._brush_state())
            for stop, is_frame in _stops(time_s, int(at[0]), known, frame_rate):
                for pause, steps in pauses.until(stop) if wet else ():
                    self._paint_to(pause, samples, refills, buttons, times_ns, table)
                    self._step_ink(steps, progress, max(0, first + pause + 1) / n)
                self._paint_to(stop, samples, refills, buttons, times_ns, table)
                if is_frame or (frame_rate is not None and first + stop == n - 1):
                    self._refresh()
                if progress is not None:
                    progress((first + stop + 1) / n)
            if last == n:
                break
            passed = first + pauses.passed
            first += known - LOOKAHEAD
            at[0] = LOOKAHEAD
        self._turn(erases=False)
        self._n_samples += n
        self._begin()
        log_warnings(warnings if self.scratch.counters[FOOTPRINTS] > laid else warnings[:1])

    def _paint_to(
        self,
        last: int,
        samples: Samples,
        refills: list[_Refill],
        buttons: AnyArray | None,
        times_ns: AnyArray,
        table: StrokeTable | None,
    ) -> None:
        """Paint up to sample `last`, one by one where a table looks at each."""
        if table is None:
            self._paint_by_ends(samples, last, refills, buttons)
            return
        for k in range(max(0, min(int(self._progress.at[0]) + 1, last)), last + 1):
            self._paint_by_ends(samples, k, refills, buttons)
            table.add(int(times_ns[k]), float(samples.pressure[k]), self._brush_state())

    def _brush_state(self) -> BrushState:
        """Return what the brush has done so far, for a table of strokes."""
        stamp, load, counters = self.stamp.values[0], self.in_brush(), self.scratch.counters
        return BrushState(
            touches=bool(stamp["touches"] > 0.0),
            way_mm=float(stamp["way"]),
            ink_given=self.loaded - load,
            ink_held=load,
            footprints=int(counters[FOOTPRINTS]),
            contacts=int(counters[SAMPLES]),
        )

    def _step_ink(
        self, n_steps: int, progress: Callable[[float], None] | None, fraction: float
    ) -> bool:
        """Advance the ink by time steps; return whether it is dry, so that no more can change."""
        for _ in range(n_steps):
            self.surface.follow_time(INK_STEP_S)
            if progress is not None:
                progress(fraction)
            if self.surface.flow.is_dry:
                return True
        return False

    def rest(
        self, last_ns: int, seconds: float, progress: Callable[[float], None] | None = None
    ) -> None:
        """Continue to spread and dry the ink of a wet replay.

        Parameters
        ----------
        last_ns : int
            Time of the last sample, ns: the time steps of `painter.ink_time` continue from there.
        seconds : float
            Of the ink's time; it ends early when the ink is dry.
        progress : callable, optional
            Called with the fraction of that time that has passed, after every step.

        Raises
        ------
        InputError
            If the time is not a finite number of at least 0.
        """
        seconds = min(as_number(seconds, "rest (s)", 0.0), _LONGEST_REST_S)
        n = ink_steps_until(last_ns + round(1e9 * seconds)) - ink_steps_until(last_ns)
        passed, is_dry = 0, False
        while passed < n and not is_dry:
            passed += self.surface.keeps_up  # a surface that lags behind takes no new time
            is_dry = self._step_ink(1, progress, passed / n)

    def _prepare(
        self, recording: Recording | LaidPad, first: int, last: int
    ) -> tuple[AnyArray, Samples, list[_Refill], AnyArray | None]:
        """Prepare one part: its times (N,), ns, samples, refills, and buttons (N,).

        There are no buttons where no eraser end is down. Runs ahead on a thread. Parts must come in
        order: each needs the touch-down before it.
        """
        started = time.perf_counter()
        part = recording.part(first, last)
        path = brush_poses(part)
        samples, origins = _samples(path, part.time_ns, self._origin_ns)
        self._origin_ns = int(origins[max(0, len(part) - 1 - 2 * LOOKAHEAD)])
        schedule, header = _Schedule(), recording.header
        if "loads" in header or "strengths" in header:
            schedule = _Schedule(*changes_at(header, part.time_ns))
        buttons = np.asarray(path.buttons)
        erases = (buttons & ERASER).any()
        prepared = part.time_ns, samples, _refills(buttons, schedule), buttons if erases else None
        self.seconds["poses"] += time.perf_counter() - started
        return prepared

    def schedule(
        self,
        loads: Sequence[tuple[int, float]] = (),
        strengths: Sequence[tuple[int, float]] = (),
    ) -> None:
        """Schedule changes of load and strength for the next live stroke.

        Parameters
        ----------
        loads : sequence of (int, float)
            A sample, counted from 0, and the fraction of a dip, 0 to 1, that the load is from there
            on; see `fill_to`.
        strengths : sequence of (int, float)
            A sample, and the fraction of ink in water from there on; see `thin_to`.
        """
        self._schedule = _Schedule(tuple(loads), tuple(strengths))

    def advance(self, samples: Iterable[DeviceSample]) -> None:
        """Paint live; the last two samples stay pending until their successors arrive.

        The pen's eraser end is not looked at: whether a stroke erases is up to the caller.
        """
        if not self._pending:
            samples = list(samples)
            self._origin_ns = samples[0].time_ns if samples else 0
        self._pending.extend(samples)
        self._paint_pending(len(self._pending) - 1 - LOOKAHEAD)

    def lift(self) -> None:
        """Paint all pending samples in mid-stroke: the next one is not joined to them."""
        self._paint_pending(len(self._pending) - 1)

    def finish(self) -> None:
        """Paint all pending samples and end the stroke."""
        self._paint_pending(len(self._pending) - 1)
        self._n_samples += len(self._pending)
        self.abandon()

    def abandon(self) -> None:
        """Drop pending samples and end the stroke; what is painted stays."""
        self._pending, self._schedule, self._n_released = [], _Schedule(), 0
        self._begin()

    def _begin(self) -> None:
        """Reset the kernels' progress for a new stroke."""
        self._progress.at[:] = 0
        self._progress.before.values[:] = 0.0
        self.scratch.warm[0] = 0.0

    def _paint_pending(self, last: int) -> None:
        """Paint pending samples up to `last`, and release those that no later interval needs."""
        if last <= int(self._progress.at[0]):
            return
        started = time.perf_counter()
        path = object_poses(self._pending)
        times = np.array([sample.time_ns for sample in self._pending], np.int64)
        samples, origins = _samples(path, times, self._origin_ns)
        self.seconds["poses"] += time.perf_counter() - started
        schedule = self._schedule.part(self._n_released, len(times))
        self._paint(samples, last, _refills(path.buttons, schedule))
        done = max(0, int(self._progress.at[0]) - LOOKAHEAD)
        self._origin_ns = int(origins[done])
        self._n_samples += done
        self._pending = self._pending[done:]
        self._n_released += done
        self._progress.at[0] -= done

    def _paint(self, samples: Samples, last: int, refills: list[_Refill]) -> None:
        """Paint up to sample `last`, refilling the brush at the samples in between."""
        first = int(self._progress.at[0])
        for stop, fill in refills:
            if not (first < stop <= last or stop == first == 0):
                continue
            self._run(samples, stop)
            fill(self)
        self._run(samples, last)

    def _paint_by_ends(
        self, samples: Samples, last: int, refills: list[_Refill], buttons: AnyArray | None
    ) -> None:
        """Paint up to sample `last` as `_paint` does, or erase where the eraser end is down."""
        if buttons is None:
            self._turn(erases=False)
            self._paint(samples, last, refills)
            return
        first = int(self._progress.at[0])
        for begin, end, turned in eraser_runs(buttons[first : max(first, last) + 1]):
            self._turn(erases=turned)
            for k in range(first + begin, first + end) if turned else (first + end - 1,):
                self._paint(samples, k, refills)
                if self._eraser is not None:
                    self.loaded -= self._eraser.wipe()

    def _turn(self, *, erases: bool) -> None:
        """Switch to the pen's eraser end, as wet as a dipped brush, or back to the brush."""
        surface = self.surface
        if erases and self._eraser is None:
            self._set_aside = self.keep(), BrushLoad.of(surface)
            self.dip(self._dipped)
            self._eraser = Eraser(surface)
        elif not erases and self._eraser is not None:
            assert self._set_aside is not None, "the eraser end is down"
            kept, load = self._set_aside
            before, loaded = self.in_brush(), self.loaded
            off_surface = surface.ink.off_surface.copy()
            load.put(surface)
            surface.ink.off_surface[:] = off_surface
            loaded += self.in_brush() - before
            self.restore({**kept, "loaded": loaded})
            self._eraser = None

    def _run(self, samples: Samples, last: int) -> None:
        """Run the stroke kernel up to sample `last`, growing the surface as often as it asks."""
        started = time.perf_counter()
        surface = self.surface
        self._fit_scratch()  # the surface may have grown, or another brush brought a pigment
        brush = HeldBrush(self.tuft, self.curves, self.azimuth == "dragged")
        while True:
            progress, scratch = self._progress, self.scratch
            hairs = None if self.hairs is None else self.hairs.work(surface)
            canvas = Canvas(surface.contact_tree, surface.paint_mesh.arrays, surface.ink)
            if hairs is None:
                state = paint_samples(samples, last, brush, canvas, progress, scratch)
            else:
                from paint3d.brush_engine.bristles.stroke_loop import paint_with_hairs

                state = paint_with_hairs(samples, last, brush, canvas, progress, scratch, hairs)
            if state == FINISHED:
                break
            surface.make_room()
            self._fit_scratch()
        surface.ink.transfer["capacity"] = self.tuft.load  # input curves may have changed it
        self.seconds["stroke"] += time.perf_counter() - started

    def _fit_scratch(self) -> None:
        """Resize the scratch to the surface and its pigments; counters and progress carry over."""
        mesh, pigments, scratch = self.surface.paint_mesh, len(self.surface.pigments), self.scratch
        if len(scratch.found.ids) != mesh.capacity + 1 or len(scratch.part) != pigments:
            self.scratch = grow_scratch(scratch, mesh, pigments)

    # -- accounts ---------------------------------------------------------------------------

    def ledger(self) -> dict[str, float]:
        """Return the ink balance, coats x mm2: loaded = in_brush + wet + dry + off_surface.

        The terms of docs/model.md, equation (11). `off_surface`, the ink that ran off, can be
        negative: by what a mask gave back to the surface after the brush had lost it.
        """
        return {
            "loaded": self.loaded,
            "in_brush": self.in_brush(),
            "wet": self.surface.wet_ink(),
            "dry": self.surface.dry_ink(),
            "off_surface": self.surface.lasting(self.surface.ink.off_surface),
        }

    def _refresh(self) -> None:
        started = time.perf_counter()
        self.surface.refresh()
        self.seconds["colour"] += time.perf_counter() - started

    def report(self) -> dict[str, Any]:
        """Return counts, seconds by stage, and the ink ledger, ready for JSON."""
        self._refresh()
        counters = self.scratch.counters
        return {
            "brush": self.brush.name,
            "ink": self.ink.name,
            "azimuth": self.azimuth,
            "hairs": 0 if self.hairs is None else self.hairs.spec.n_hairs,
            "samples": self._n_samples,
            "samples_in_contact": int(counters[SAMPLES]),
            "footprints": int(counters[FOOTPRINTS]),
            "vertices": self.surface.n_vertices,
            "vertices_visited": int(counters[VISITED]),
            "vertices_painted": int(np.count_nonzero(self.surface.painted)),
            "deposits": int(counters[PAINTED]),
            "tilt_limited": int(counters[placement.TILT_LIMITED]),
            "overpressed": int(counters[placement.OVERPRESSED]),
            "leaning_over": int(counters[placement.LEANING_OVER]),
            "seconds": dict(self.seconds),
            "ink_ledger": self.ledger(),
        }


def _in_parts(ink: Ink) -> Ink:
    """Resolve an ink given as text to its parts; a pigment's own name stays as it is."""
    if not isinstance(ink, str):
        return ink
    stirred = load_ink(ink)
    pigment, *others = stirred
    if others:
        return stirred
    return ink if ink in (pigment.name, pigment.chinese) else pigment


def _spans(n: int) -> Iterator[tuple[int, int]]:
    """Yield first samples and ends of the parts in which a recording of `n` samples is prepared.

    They overlap by what the spline needs: LOOKAHEAD samples on either side of an interval.
    """
    first = 0
    while first + _PART < n:
        yield first, first + _PART
        first += _PART - 1 - 2 * LOOKAHEAD
    yield first, n


_Refill = tuple[int, Callable[["Painter"], None]]
"""A sample, and the change to the brush after painting up to it."""


class _Schedule(NamedTuple):
    """Scheduled loads (fractions of a dip) and strengths (fractions of ink in water), by sample."""

    loads: Sequence[tuple[int, float]] = ()
    strengths: Sequence[tuple[int, float]] = ()

    def part(self, first: int, count: int) -> _Schedule:
        """Return the entries of `count` samples from `first` on, renumbered from 0."""
        if not self.loads and not self.strengths:
            return self
        return _Schedule(
            *(
                [(k - first, fraction) for k, fraction in entries if 0 <= k - first < count]
                for entries in self
            )
        )


def _refills(buttons: AnyArray, schedule: _Schedule) -> list[_Refill]:
    """List dips (the button goes down), loads and strengths by sample; at one, in this order."""
    if not (buttons.any() or schedule.loads or schedule.strengths):
        return []
    down = buttons & DIP
    dips = np.flatnonzero(down[1:] > down[:-1]) + 1 if down.any() else ()
    refills: list[_Refill] = [(int(k), Painter.dip) for k in dips]
    refills += [(k, partial(Painter.fill_to, fraction=load)) for k, load in schedule.loads]
    refills += [(k, partial(Painter.thin_to, fraction=part)) for k, part in schedule.strengths]
    return sorted(refills, key=lambda refill: refill[0])  # stable


def _stops(
    time_s: AnyArray, first: int, last: int, frame_rate: float | None
) -> Iterator[tuple[int, bool]]:
    """Yield the samples after `first`, up to `last`, to stop at, and whether a frame ends there.

    Without a frame rate these are every 2000 samples; `time_s` counts from the recording's start.
    """
    if frame_rate is None:
        ends = np.arange(first + _CHUNK, last, _CHUNK)
    else:
        start = first + 1 if first else 0  # the part before yielded the frame that ends at `first`
        frames = np.floor(time_s[start : last + 2] * frame_rate).astype(np.int64)
        ends = start + np.flatnonzero(np.diff(frames))
    for end in ends:
        yield int(end), frame_rate is not None
    if not len(ends) or ends[-1] != last:
        yield last, False


def _samples(
    path: BrushPath, time_ns: NDArray[np.int64], origin_ns: int
) -> tuple[Samples, AnyArray]:
    """Prepare a path for interpolation by the kernels.

    Time counts from the latest touch-down, whatever was painted before: so a stroke is the same to
    the bit by itself and in a recording of many.

    Parameters
    ----------
    path : BrushPath
    time_ns : (N,) int64
    origin_ns : int
        Time of the latest touch-down before the first sample.

    Returns
    -------
    samples : Samples
    origins : (N,) int64
        Time of the latest touch-down before each sample, ns.
    """
    n = len(path)
    samples = Samples(
        time=np.empty(n),
        position=np.empty((n, 3)),
        velocity=np.empty((n, 3)),
        orientation=np.empty((n, 4)),
        pressure=np.array(path.pressures),  # a read-only one is another type to the kernel
        joined=np.empty(n, bool),
        on_surface=path.has_contact,
    )
    origins = np.empty(n, np.int64)
    points = np.ascontiguousarray(path.points)
    prepare_samples(time_ns, origin_ns, path.orientation, points, samples, origins)
    return samples, origins
