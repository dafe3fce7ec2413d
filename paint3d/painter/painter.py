"""The painter: a brush, an ink, a surface, and poses in time.

One way through the stages, readable here in one screen: samples are turned into object-frame poses
(`pose`), and `brush_engine.stroke_loop` walks along them: foot point and bent brush, enclosing
sphere and plane, outline, sweep, ink. Nothing here has a clock, a file or a random source; the same
samples give the same painting to the bit, for any number of threads and any chunking.
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
)
from paint3d.brush_engine.tuft import Tuft
from paint3d.brush_engine.vertex_query import VISITED
from paint3d.colour.inks import load_ink
from paint3d.colour.pigments import Pigment, load_pigment
from paint3d.core.ahead import ahead
from paint3d.core.arrays import AnyArray, as_number, dots_of
from paint3d.device.sample import DIP, DeviceSample
from paint3d.errors import InputError
from paint3d.painter.flat_input import LaidPad
from paint3d.painter.ink_time import LOOKAHEAD, PIECE_S, Pauses, pieces_until
from paint3d.painter.recorded_tools import LEAST_INK, told_at
from paint3d.pose.brush_pose import BrushPath, brush_poses, joined_samples, object_poses, velocities
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface

if TYPE_CHECKING:
    from paint3d.painter.bristle_state import HairTuft  # brings the kernels of hairs

__all__ = ["Painter"]

_PART = 1 << 16  # samples of a recording that are made ready at once
_CHUNK = 2000  # samples between two calls of `progress`
_FOR_EVER_S = 1e9  # no ink is wet for so long
_RESERVOIRS = 12  # pieces of a tuft that is loaded differently along its length

Ink = str | Pigment | Mapping[Any, float]
"""An ink, or the parts of several that are stirred, by themselves or by their names."""


class Painter:
    """Paints on a surface with one brush.

    Parameters
    ----------
    surface : PaintedSurface
    brush : str or BrushSpec
    ink : str, Pigment, mapping or None
        What the brush is dipped in; see `dip`. None: it holds what the surface says that it held,
        as after opening a session.
    azimuth : {"commanded", "dragged"}
        Whether the pose's roll turns the tuft, or the surface pulls it.
    pickup : float, optional
        Share of the wet ink under the brush that it takes back per mm of travel at full pressure
        (0.05 is a thirsty brush); 0: it stays clean. None: as before, 0 on a new surface.
    hairs : int or BristleSpec, optional
        Paint with so many single hairs, or with these; 0 for a solid tuft. None: as the brush is.
    amount : DipAmount, optional
        How much ink a dip takes up; by default what the brush's preset says.

    Attributes
    ----------
    tuft : Tuft
        The brush as it bends, and gives ink on this surface, wetted as it is.
    amount : DipAmount
        How much ink a dip takes up.
    curves : Curves
        What drives it while it paints.
    hairs : HairTuft or None
        None in a solid tuft.
    scratch : Scratch
        What the kernels work in, and count.

    Raises
    ------
    UnknownNameError
        For a brush or an ink that is not known.
    InputError
        For no ink where the surface has never seen one.
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
            raise InputError(f"azimuth is {azimuth!r}; expected 'commanded' or 'dragged'")
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
        self._held: list[DeviceSample] = []
        self._told = _Told()
        self._n_let_go = 0  # of the stroke's samples, that are painted and not held any more
        self._origin_ns = 0
        self._n_samples = 0
        self._dip_down = False
        self._dipped: Ink = {}
        self._dips: tuple[tuple[Ink, float | None], ...] = ()
        if pickup is not None:
            surface.ink.transfer["pickup"] = as_number(pickup, "pickup (1/mm)", 0.0)
        if ink is None:
            self._take_up()
        else:
            self.dip(ink)

    # -- the brush --------------------------------------------------------------------------

    def dip(
        self,
        ink: Ink | None = None,
        reach: float | None = None,
        amount: DipAmount | None = None,
    ) -> None:
        """Rinse the brush and load it fully with `ink` (None: the same again, tip and belly).

        Parameters
        ----------
        ink : str, Pigment or mapping, optional
            An ink, or parts of several that are stirred: ``{"pine soot": 0.2, "water": 0.8}``, or
            the same in words, ``"pine soot:0.2,water:0.8"`` or ``"light"``; see `load_ink`.
        reach : float, optional
            Dip only so much of the tuft's length, from the tip, 0 to 1; the rest keeps what it
            holds: first the belly in light ink, then the tip in dark. A whole dip also brings
            single hairs to a point.
        amount : DipAmount, optional
            How much ink the brush takes up, now and at the dips after; None: as at the dip before.

        Raises
        ------
        InputError
            If a part is not a number above 0, the reach is not between 0 and 1, or there is an
            amount for the tip alone.
        """
        if amount is not None and reach is not None:
            raise InputError("an amount is said with a reach; expected it for a whole dip")
        if ink is None and reach is None and len(self._dips) > 1:
            self._take_amount(amount)
            for again in self._dips:
                self.dip(*again)
            return
        ink = _in_parts(self._dipped if ink is None else ink)
        parts = self._mixture(ink)
        share = 1.0 if reach is None else as_number(reach, "reach", 0.0, 1.0)
        self._take_amount(amount)
        if self.hairs is not None:
            self.hairs.hold(self.surface.ink.load)
        if reach is not None:
            self._dip_tip(parts, share)
        else:
            self._hold(parts * self.tuft.load)
        if self.hairs is not None:
            self.hairs.dip(self.surface.ink.load, self.tuft.load, share)
            self.surface.ink.load[:] = self.hairs.held()
            if reach is None:
                self.hairs.shape()
        deeper = () if reach is None else (d for d in self._dips if d[1] is None or d[1] > share)
        self._dips = (*deeper, (ink, None if reach is None else share))
        self._dipped = ink
        self.ink = self.surface.main_pigment(parts)
        self._fit_scratch()

    def _take_up(self) -> None:
        """Take the brush as it lies there: with what it holds, or dry."""
        surface = self.surface
        if not surface.pigments:
            raise InputError("ink is None and this surface has never seen any; expected an ink")
        held = surface.ink.load
        parts = held / held.sum() if held.any() else np.eye(len(held))[-1]
        self._dipped = {p: w for p, w in zip(surface.pigments, parts, strict=True) if w > 1e-9}
        self.ink = surface.main_pigment(parts)
        self._fit_scratch()
        accounts = self.ledger()
        self.loaded = sum(accounts.values()) - accounts["loaded"]

    def rinse(self) -> None:
        """Wash the brush out and shake it dry: it holds nothing."""
        self._hold(np.zeros(len(self.surface.pigments)))

    def wipe(self, share: float = 0.5) -> None:
        """Wipe a share of what the brush holds off, 0 to 1; what stays is what it was.

        Raises
        ------
        InputError
            If the share is not between 0 and 1.
        """
        share = as_number(share, "share", 0.0, 1.0)
        ink = self.surface.ink
        if len(ink.reservoirs) > 1:
            self._hold_along(ink.reservoirs * (1.0 - share))
        else:
            self._hold(ink.load * (1.0 - share))
        if self.hairs is not None:
            self.hairs.hold(self.surface.ink.load)
            self.surface.ink.load[:] = self.hairs.held()

    def fill_to(self, share: float) -> None:
        """Let the brush hold such a share, 0 to 1, of what a dip gives, in its own mixture.

        Raises
        ------
        InputError
            If the share is not between 0 and 1.
        """
        share = as_number(share, "share", 0.0, 1.0)
        ink = self.surface.ink
        held = float(ink.load.sum())
        if not held > 0.0:
            self.dip()
            held = float(ink.load.sum())
        factor = share * self.tuft.load / held
        if len(ink.reservoirs) > 1:
            self._hold_along(ink.reservoirs * factor)
        else:
            self._hold(ink.load * factor)
        if self.hairs is not None:
            self.hairs.hold(self.surface.ink.load)
            self.surface.ink.load[:] = self.hairs.held()

    def thin_to(self, share: float) -> None:
        """Let what the brush holds be such a share, up to 1, of what it was dipped in, and water.

        The next dip is in the ink itself again.

        Raises
        ------
        InputError
            If the share is not between 0.0001 and 1.
        """
        share = as_number(share, "share", LEAST_INK, 1.0)
        dips = self._dips or ((self._dipped, None),)
        water = None if share == 1.0 else self.surface.column_of(load_pigment("water"))
        whole, *tips = [self._mixture(_in_parts(ink)) for ink, _ in dips]
        along = np.tile(whole, (len(self.surface.ink.reservoirs), 1))
        middle = (np.arange(len(along)) + 0.5) / len(along)
        for parts, (_, reach) in zip(tips, dips[1:], strict=True):
            along[middle < (1.0 if reach is None else reach)] = parts
        along *= share
        if water is not None:
            along[:, water] += 1.0 - share
        self._mix(along)

    def _mix(self, along: AnyArray) -> None:
        """Let what the brush holds be of these parts (N, P) along the tuft, or all (1, P)."""
        field = self.surface.ink
        if self.hairs is not None:
            self.hairs.hold(field.load)
            self.hairs.load = np.outer(self.hairs.load.sum(axis=1), along.mean(axis=0))
            self._hold(self.hairs.held())
        elif len(field.reservoirs) > 1:
            self._hold_along(along * field.reservoirs.sum(axis=1)[:, None])
        else:
            self._hold(along[0] * field.load.sum())
        self._fit_scratch()

    def recolour(self, ink: Ink) -> None:
        """Let what the brush holds be another ink, as much of it as there is, hair by hair.

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
        """Take another brush into the hand, loaded fully with the same ink.

        Raises
        ------
        UnknownNameError, BrushError
            For a brush that is not known, or cannot be bent.
        """
        brush = load_brush(brush) if isinstance(brush, str) else brush
        self.tuft = self._dipped_tuft(brush)
        self.brush = brush
        self.curves = build_curves(brush.inputs)
        self.hairs = self._make_hairs()
        self.dip(self._dipped)

    def _take_amount(self, amount: DipAmount | None) -> None:
        """Take up so much ink from now on; None: as before."""
        if amount is not None:
            self.amount = amount
            self.tuft = self._dipped_tuft(self.brush)

    def _dipped_tuft(self, brush: BrushSpec) -> Tuft:
        """A brush on this surface, with the ink of a dip."""
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
            raise InputError(f"hairs is {wanted!r:.60}; expected a number or a BristleSpec")
        from paint3d.painter.bristle_state import HairTuft

        return HairTuft(self.brush, wanted)

    def shape(self) -> None:
        """Bring a tuft of single hairs to a point, as on the rim of an inkstone."""
        if self.hairs is not None:
            self.hairs.shape()

    @property
    def dipped(self) -> Ink:
        """What the brush was dipped in last."""
        return self._dipped

    @property
    def dips(self) -> tuple[tuple[Ink, float | None], ...]:
        """What `dip` without an ink does again: the whole tuft (reach None), then its tip."""
        return self._dips

    def keep(self) -> dict[str, object]:
        """What `restore` takes: all that is remembered between strokes, apart from the surface."""
        names = ("brush", "tuft", "amount", "loaded", "ink", "_dipped", "_dips", "hairs", "curves")
        kept = {name: getattr(self, name) for name in names}
        return kept | {"of_hairs": None if self.hairs is None else self.hairs.keep()}

    def restore(self, kept: Mapping[str, Any]) -> None:
        """Be as when it was kept; the surface is brought back by `surface.undo`."""
        of_hairs = kept.get("of_hairs")
        for name, value in kept.items():
            if name != "of_hairs":
                setattr(self, name, value)
        if self.hairs is not None and of_hairs is not None:
            self.hairs.restore(of_hairs)
        self._fit_scratch()

    def _mixture(self, ink: Ink) -> AnyArray:
        """(P,) parts of the pigments on the surface, of sum 1."""
        stirred: Mapping[Any, float] = ink if isinstance(ink, Mapping) else {ink: 1.0}
        if not stirred:
            raise InputError("the brush is dipped in nothing; expected an ink")
        columns, weights = [], []
        for name, weight in stirred.items():
            pigment = load_pigment(name) if isinstance(name, str) else name
            columns.append(self.surface.column_of(pigment))
            weights.append(as_number(weight, f"part of {pigment.name}", 1e-9))
        parts = np.zeros(len(self.surface.pigments))
        np.add.at(parts, columns, np.array(weights) / sum(weights))
        return parts

    def _hold(self, load: AnyArray) -> None:
        """Let the brush hold `load` (P,), alike all along the tuft."""
        surface = self.surface
        self.loaded += surface.lasting(load - surface.ink.load)
        surface.ink.load[:] = load
        surface.ink.transfer["capacity"] = self.tuft.load
        surface.ink = surface.ink._replace(reservoirs=np.zeros((1, len(load))))

    def _hold_along(self, reservoirs: AnyArray) -> None:
        """Let the brush hold `reservoirs` (N, P) along the tuft, tip first."""
        surface = self.surface
        reservoirs = np.ascontiguousarray(reservoirs)
        level_reservoirs(reservoirs)
        load = reservoirs.sum(axis=0)
        self.loaded += surface.lasting(load - surface.ink.load)
        surface.ink.load[:] = load
        surface.ink.transfer["capacity"] = self.tuft.load
        surface.ink.transfer["reservoir_mm"] = self.brush.length_mm / len(reservoirs)
        surface.ink = surface.ink._replace(reservoirs=reservoirs)

    def _dip_tip(self, parts: AnyArray, reach: float) -> None:
        held = self.surface.ink.reservoirs
        if len(held) == 1:
            held = np.repeat(self.surface.ink.load[None] / _RESERVOIRS, _RESERVOIRS, axis=0)
        middle = (np.arange(len(held)) + 0.5) / len(held)
        dipped = middle < reach
        held = np.where(dipped[:, None], parts * self.tuft.load / len(held), held)
        self._hold_along(held)

    def in_brush(self) -> float:
        """Pigment in the brush, coats x mm2."""
        return self.surface.lasting(self.surface.ink.load)

    @property
    def stamp(self) -> Stamp:
        """The footprint that was placed last."""
        return self._progress.after

    def contact(
        self,
        position: ArrayLike,
        orientation: ArrayLike,
        pressure: float | None = None,
        place: ArrayLike | None = None,
    ) -> Contact | None:
        """How the brush would stand on the surface in one pose; see `find_contact`."""
        surface = self.surface
        return find_contact(
            self.tuft, surface.paint_mesh, surface.contact_tree, position, orientation, pressure,
            place,
        )  # fmt: skip

    # -- painting ---------------------------------------------------------------------------

    def replay(
        self,
        recording: Recording | LaidPad,
        progress: Callable[[float], None] | None = None,
        frame_rate: float | None = None,
        wet: bool = False,
    ) -> None:
        """Paint a whole recording.

        Parameters
        ----------
        recording : Recording or LaidPad
            However long: 65,536 samples at a time are made ready for painting, the next ones while
            these are painted.
        progress : callable, optional
            Called with the fraction done, a few times a second, after every frame and pause.
        frame_rate : float, optional
            Bring the colours up to date this often, Hz of the recording's own time, as a live
            view would; the painting is the same without.
        wet : bool
            Let the ink spread and dry meanwhile, in the recording's own time (`painter.ink_time`).
        """
        self.finish()
        n, first, passed = len(recording), 0, 0
        start, at = int(recording.time_ns[0]), self._progress.at
        self._origin_ns = start
        ready = ahead(partial(self._prepare, recording, *span) for span in _spans(n))
        while True:
            last = min(n, first + _PART)
            times_ns, samples, refills = next(ready)
            time_s = (times_ns - start) * 1e-9
            known = last - first - 1 - (LOOKAHEAD if last < n else 0)
            pauses = Pauses(times_ns, samples.joined, passed - first)
            for stop, is_frame in _stops(time_s, int(at[0]), known, frame_rate):
                for pause, pieces in pauses.until(stop) if wet else ():
                    self._paint(samples, pause, refills)
                    self._let_pass(pieces, progress, max(0, first + pause + 1) / n)
                self._paint(samples, stop, refills)
                if is_frame or (frame_rate is not None and first + stop == n - 1):
                    self._refresh()
                if progress is not None:
                    progress((first + stop + 1) / n)
            if last == n:
                break
            passed = first + pauses.passed
            first += known - LOOKAHEAD
            at[0] = LOOKAHEAD
        self._n_samples += n
        self._begin()

    def _let_pass(
        self, pieces: int, progress: Callable[[float], None] | None, share: float
    ) -> bool:
        """Let pieces of time pass for the ink; whether it is dry, so that nothing more changes."""
        for _ in range(pieces):
            self.surface.follow_time(PIECE_S)
            if progress is not None:
                progress(share)
            if self.surface.flow.is_dry:
                return True
        return False

    def rest(
        self, last_ns: int, seconds: float, progress: Callable[[float], None] | None = None
    ) -> None:
        """Let the ink of a wet replay have more time, however long it takes to follow.

        Parameters
        ----------
        last_ns : int
            Time of the last sample, ns: the pieces of `painter.ink_time` go on from there.
        seconds : float
            Of the ink's time; no more passes once it is dry.
        progress : callable, optional
            Called with the fraction of that time that has passed, after every piece.

        Raises
        ------
        InputError
            If the time is not a finite number of at least 0.
        """
        seconds = min(as_number(seconds, "rest (s)", 0.0), _FOR_EVER_S)
        n = pieces_until(last_ns + round(1e9 * seconds)) - pieces_until(last_ns)
        passed, is_dry = 0, False
        while passed < n and not is_dry:
            passed += self.surface.keeps_up  # else no time passes
            is_dry = self._let_pass(1, progress, passed / n)

    def _prepare(
        self, recording: Recording | LaidPad, first: int, last: int
    ) -> tuple[AnyArray, Samples, list[_Refill]]:
        """The times of a part that follows the one before, its samples, what fills the brush."""
        started = time.perf_counter()
        part = recording.part(first, last)
        path = brush_poses(part)
        samples, origins = _samples(path, part.time_ns, self._origin_ns)
        self._origin_ns = int(origins[max(0, len(part) - 1 - 2 * LOOKAHEAD)])
        told, header = _Told(), recording.header
        if "loads" in header or "strengths" in header:
            told = _Told(*told_at(header, part.time_ns))
        prepared = part.time_ns, samples, _refills(path.buttons, told)
        self.seconds["poses"] += time.perf_counter() - started
        return prepared

    def expect(
        self,
        loads: Sequence[tuple[int, float]] = (),
        strengths: Sequence[tuple[int, float]] = (),
    ) -> None:
        """Let the brush hold what is told from these samples of the next live stroke on.

        Parameters
        ----------
        loads : sequence of (int, float)
            A sample, counted from 0, and a share of a dip, 0 to 1; see `fill_to`.
        strengths : sequence of (int, float)
            A sample, and a share of ink in water; see `thin_to`.
        """
        self._told = _Told(tuple(loads), tuple(strengths))

    def advance(self, samples: Iterable[DeviceSample]) -> None:
        """Paint live: the interval before the last two samples waits for what comes next."""
        if not self._held:
            samples = list(samples)
            self._origin_ns = samples[0].time_ns if samples else 0
        self._held.extend(samples)
        self._paint_held(len(self._held) - 1 - LOOKAHEAD)

    def lift(self) -> None:
        """Paint what still waits though the stroke goes on: its next sample is not joined to it."""
        self._paint_held(len(self._held) - 1)

    def finish(self) -> None:
        """Paint what still waits, and lift the brush."""
        self._paint_held(len(self._held) - 1)
        self._n_samples += len(self._held)
        self._let_go()

    def abandon(self) -> None:
        """Forget what still waits, and lift the brush; what was painted stays."""
        self._let_go()

    def _let_go(self) -> None:
        self._held, self._told, self._n_let_go = [], _Told(), 0
        self._begin()

    def _begin(self) -> None:
        self._progress.at[:] = 0
        self._progress.before.values[:] = 0.0
        self.scratch.warm[0] = 0.0

    def _paint_held(self, last: int) -> None:
        if last <= int(self._progress.at[0]):
            return
        started = time.perf_counter()
        path = object_poses(self._held)
        times = np.array([sample.time_ns for sample in self._held], np.int64)
        samples, origins = _samples(path, times, self._origin_ns)
        self.seconds["poses"] += time.perf_counter() - started
        told = self._told.part(self._n_let_go, len(times))
        self._paint(samples, last, _refills(path.buttons, told))
        done = max(0, int(self._progress.at[0]) - LOOKAHEAD)
        self._origin_ns = int(origins[done])
        self._n_samples += done
        self._held = self._held[done:]
        self._n_let_go += done
        self._progress.at[0] -= done

    def _paint(self, samples: Samples, last: int, refills: list[_Refill]) -> None:
        """Paint up to sample `last`, dipping the brush where the recording does."""
        first = int(self._progress.at[0])
        for stop, fill in refills:
            if not (first < stop <= last or stop == first == 0):
                continue
            self._run(samples, stop)
            fill(self)
        self._run(samples, last)

    def _run(self, samples: Samples, last: int) -> None:
        started = time.perf_counter()
        surface = self.surface
        scratch = self.scratch  # the surface may have grown, or another brush brought a pigment
        is_small = len(scratch.found.ids) != surface.paint_mesh.capacity + 1
        if is_small or len(scratch.part) != len(surface.pigments):
            self._fit_scratch()
        while True:
            state = self._run_kernel(samples, last)
            if state == FINISHED:
                break
            surface.make_room()
            self._fit_scratch()
        surface.ink.transfer["capacity"] = self.tuft.load  # whatever curves made of it
        self.seconds["stroke"] += time.perf_counter() - started

    def _run_kernel(self, samples: Samples, last: int) -> int:
        surface, progress, scratch = self.surface, self._progress, self.scratch
        brush = HeldBrush(self.tuft, self.curves, self.azimuth == "dragged")
        hairs = None if self.hairs is None else self.hairs.work(surface)
        canvas = Canvas(surface.contact_tree, surface.paint_mesh.arrays, surface.ink)
        if hairs is None:
            return int(paint_samples(samples, last, brush, canvas, progress, scratch))
        from paint3d.brush_engine.bristles.stroke_loop import paint_with_hairs

        return int(paint_with_hairs(samples, last, brush, canvas, progress, scratch, hairs))

    def _fit_scratch(self) -> None:
        """Let the scratch fit the surface and its pigments; counts, and what was begun, go on."""
        mesh, pigments = self.surface.paint_mesh, len(self.surface.pigments)
        self.scratch = grow_scratch(self.scratch, mesh, pigments)

    # -- accounts ---------------------------------------------------------------------------

    def ledger(self) -> dict[str, float]:
        """Where the ink is, coats x mm2: loaded = in_brush + wet + dry + off_surface.

        The terms of docs/model.md, equation (11). What ran off the surface can be less than 0: by
        what a mask gave back to the surface and the brush had no longer.
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
        """Counts, seconds by stage, and the ink ledger, ready for JSON."""
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
    """An ink in words by what it is made of; a pigment's own name stays as it is."""
    if not isinstance(ink, str):
        return ink
    stirred = load_ink(ink)
    pigment, *others = stirred
    if others:
        return stirred
    return ink if ink in (pigment.name, pigment.chinese) else pigment


def _spans(n: int) -> Iterator[tuple[int, int]]:
    """First samples and ends of the parts of a recording that are made ready at once.

    They overlap: an interval waits for the samples beyond it, and needs those before it again.
    """
    first = 0
    while first + _PART < n:
        yield first, first + _PART
        first += _PART - 1 - 2 * LOOKAHEAD
    yield first, n


_Refill = tuple[int, Callable[["Painter"], None]]
"""A sample up to which is painted first, and what is done with the brush then."""


class _Told(NamedTuple):
    """What the brush comes to hold at samples: shares of a dip, and of ink in water."""

    loads: Sequence[tuple[int, float]] = ()
    strengths: Sequence[tuple[int, float]] = ()

    def part(self, first: int, count: int) -> _Told:
        """What is told of so many samples from the first on, which are counted from 0 then."""
        return _Told(
            *([(k - first, share) for k, share in one if 0 <= k - first < count] for one in self)
        )


def _refills(buttons: AnyArray, told: _Told) -> list[_Refill]:
    """Samples at which the dip button goes down, or load or strength are told, in this order."""
    down = (np.asarray(buttons) & DIP) != 0
    found: list[_Refill] = [
        (int(k), Painter.dip) for k in np.flatnonzero(down[1:] & ~down[:-1]) + 1
    ]
    found += [(k, partial(Painter.fill_to, share=share)) for k, share in told.loads]
    found += [(k, partial(Painter.thin_to, share=share)) for k, share in told.strengths]
    return sorted(found, key=lambda one: one[0])


def _stops(
    time_s: AnyArray, first: int, last: int, frame_rate: float | None
) -> Iterator[tuple[int, bool]]:
    """Samples after `first`, up to `last`, that are painted up to, and whether a frame ends there.

    Without a rate these are every 2000 samples; times are counted from the recording's start.
    """
    if frame_rate is None:
        ends = np.arange(first + _CHUNK, last, _CHUNK)
    else:
        start = first + 1 if first else 0  # what ended at the last part's end has ended
        frames = np.floor(time_s[start : last + 2] * frame_rate).astype(np.int64)
        ends = start + np.flatnonzero(np.diff(frames))
    for end in ends:
        yield int(end), frame_rate is not None
    if not len(ends) or ends[-1] != last:
        yield last, False


def _samples(
    path: BrushPath, time_ns: NDArray[np.int64], origin_ns: int
) -> tuple[Samples, AnyArray]:
    """Make a path ready for interpolation.

    Time counts from where the brush came down last, whatever was painted before: so a stroke is the
    same to the bit by itself and in a recording of many.

    Parameters
    ----------
    path : BrushPath
    time_ns : (N,) int64
    origin_ns : int
        When the brush came down that was there before the first sample.

    Returns
    -------
    samples : Samples
    origins : (N,) int64
        When it came down before each, ns.
    """
    pressure = path.pressure
    if pressure is None:
        pressure = np.full(len(path.time_s), np.nan)
    joined = joined_samples(path)
    came_down = np.where(joined, 0, np.arange(len(path)))
    origins = np.where(came_down > 0, time_ns, origin_ns)[np.maximum.accumulate(came_down)]
    since = np.asarray((time_ns - origins) * 1e-9, np.float64)
    path = dataclasses.replace(path, time_s=since)
    samples = Samples(
        time=np.ascontiguousarray(path.time_s, np.float64),
        position=np.ascontiguousarray(path.way, np.float64),
        velocity=velocities(path, joined),
        orientation=_one_hemisphere(path.orientation),
        pressure=np.array(pressure, np.float64),  # one that is read-only would be compiled anew
        joined=joined,
        on_surface=path.has_contact,
    )
    return samples, origins


def _one_hemisphere(quaternions: AnyArray) -> AnyArray:
    """Flip signs so that neighbouring quaternions (N, 4) lie less than a right angle apart."""
    q = np.array(quaternions, dtype=np.float64)
    flips = dots_of(q[1:], q[:-1]) < 0.0
    signs = np.where(np.cumsum(flips) % 2 == 1, -1.0, 1.0)
    q[1:] *= signs[:, None]
    return q
