"""The strokes of a painting: what was done, with what, when, and how long it took."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from paint3d.app.model.persistence.brush_words import brush_from_words
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BrushSpec, DipAmount
from paint3d.colour.pigments import Pigment
from paint3d.core.arrays import as_number
from paint3d.device.recorded import Recording
from paint3d.device.sample import DIP, ERASER, DeviceSample
from paint3d.errors import InputError, Message, RecordingError, SessionError
from paint3d.painter.ink_time import INK_STEP_NS
from paint3d.painter.recorded_tools import changes_at
from paint3d.pose.brush_pose import contacts_of
from paint3d.surface.painted_surface import PaintedSurface

__all__ = [
    "ERASES",
    "Stroke",
    "StrokeLog",
    "check_pairs",
    "names_apart",
    "parts_of",
    "recording_of",
    "strokes_of",
    "weights_of",
]

ERASES = "erases"
"""Tag of a stroke that took paint off."""

_PAUSE_NS = 200_000_000  # before a stroke whose clock is not that of those before it
_LANDING_NS = 1_000_000


@dataclass(eq=False)
class Stroke:
    """A stroke.

    Attributes
    ----------
    time_s : float
        When it began, s since 1970.
    brush : BrushSpec
    ink : dict
        Parts of the inks that the brush was dipped in last, by name.
    layer : str
        Name of the layer.
    dipped_since_stroke : bool
        Whether the brush was dipped since the stroke before.
    amount : DipAmount
        How much ink its dips took up.
    samples : list of DeviceSample
    tags : dict
        What else is known, as JSON holds it: character, participant, device set ...
    loads : tuple of (int, float)
        How much the brush came to hold at samples, fractions of a dip, where that was given.
    strengths : tuple of (int, float)
        What fraction of the ink it was then, the rest being water, where that was given.
    """

    time_s: float
    brush: BrushSpec
    ink: dict[str, float]
    layer: str
    dipped_since_stroke: bool = True
    amount: DipAmount = field(default_factory=DipAmount)
    samples: list[DeviceSample] = field(default_factory=list)
    tags: dict[str, object] = field(default_factory=dict)
    loads: tuple[tuple[int, float], ...] = ()
    strengths: tuple[tuple[int, float], ...] = ()

    @property
    def duration_s(self) -> float:
        """From the first sample to the last, s."""
        if not self.samples:
            return 0.0
        return (self.samples[-1].time_ns - self.samples[0].time_ns) * 1e-9

    def header(self, brush: str = "") -> dict[str, object]:
        """Header of the stroke's recording; its brush by that name, or by its own."""
        own: dict[str, object] = {}
        if self.amount != DipAmount():
            own["dip"] = self.amount.words()
        return (
            own
            | self.tool_changes()
            | {
                "brush": brush or self.brush.name,
                "ink": max(self.ink, key=self.ink.__getitem__) if self.ink else None,
                "parts": dict(self.ink),
                "layer": self.layer,
                "time_s": self.time_s,
                "dipped": self.dipped_since_stroke,
                "tags": dict(self.tags),
            }
        )

    def tool_changes(self, shift: int = 0) -> dict[str, list[list[float]]]:
        """Loads and strengths as a recording's header has them, times moved by `shift` ns."""
        changes = {}
        for name, pairs in (("loads", self.loads), ("strengths", self.strengths)):
            known = [one for one in pairs if one[0] < len(self.samples)]
            if known:
                changes[name] = [
                    [self.samples[k].time_ns + shift, fraction] for k, fraction in known
                ]
        return changes

    def recording(self, brush: str = "") -> Recording:
        """The stroke by itself; see `header`."""
        return recording_of(self.samples, self.header(brush))


class StrokeLog:
    """Strokes that are there, and the one that is going on.

    Parameters
    ----------
    before : sequence of Recording
        Strokes of earlier sessions.
    brushes : mapping
        What the brushes that their headers name were, as `BrushSpec` takes it.

    Attributes
    ----------
    strokes : list of Stroke
    current : Stroke or None
    tags : dict
        Given to every stroke that begins from now on.
    """

    def __init__(
        self,
        before: Sequence[Recording] = (),
        brushes: Mapping[str, Mapping[str, Any]] | None = None,
    ) -> None:
        self._before = strokes_of(before, brushes)
        self.strokes: list[Stroke] = list(self._before)
        self.current: Stroke | None = None
        self.tags: dict[str, object] = {}

    @property
    def n_before(self) -> int:
        """Strokes of earlier sessions that no step takes back."""
        return len(self._before)

    def hold(self, count: int) -> None:
        """Count the last `count` strokes as steps that can be taken back, from now on."""
        self._before = self.strokes[: len(self.strokes) - count]

    def begin(
        self,
        brush: BrushSpec,
        ink: str | Pigment | Mapping[Any, float],
        layer: str,
        dipped_since_stroke: bool,
        time_s: float | None = None,
        amount: DipAmount | None = None,
    ) -> Stroke:
        """Start a stroke, now or at a time (s since 1970)."""
        at = time.time() if time_s is None else time_s
        self.current = Stroke(
            at,
            brush,
            parts_of(ink),
            layer,
            dipped_since_stroke,
            amount or DipAmount(),
            tags=dict(self.tags),
        )
        return self.current

    def check(self, samples: Sequence[DeviceSample]) -> None:
        """Refuse samples that cannot follow those of the stroke that is going on.

        Raises
        ------
        RecordingError
            If time does not increase, or some have a pressure and others have none.
        """
        own = self.current.samples[-1:] if self.current is not None else []
        times = [sample.time_ns for sample in (*own, *samples)]
        if any(b <= a for a, b in pairwise(times)):
            raise RecordingError("a sample is not later than the one before it")
        if len({sample.pressure is None for sample in (*own, *samples)}) > 1:
            raise RecordingError("pressure is given in some samples; expected it in all or none")

    def append(self, samples: Sequence[DeviceSample]) -> None:
        """Add to the stroke that is going on."""
        assert self.current is not None, "a stroke is going on"
        self.current.samples.extend(samples)

    def end(self) -> Stroke | None:
        """End it; None if it had no sample, and it is forgotten."""
        stroke, self.current = self.current, None
        if stroke is None or not stroke.samples:
            return None
        self.strokes.append(stroke)
        return stroke

    def cancel(self) -> None:
        """Forget the stroke that is going on."""
        self.current = None

    def follow(self, strokes: Sequence[Stroke]) -> None:
        """Replace the strokes after those of earlier sessions, after undo or redo."""
        self.strokes = [*self._before, *strokes]

    def recording(self, object_name: str, first: int = 0) -> Recording | None:
        """Strokes from index `first` on, one after the other; dips are on their lifted samples.

        They keep their times, and so the ink what passes between them.
        """
        strokes = self.strokes[first:]
        if not strokes:
            return None
        samples: list[DeviceSample] = []
        changes: dict[str, list[list[float]]] = {}
        shift = 0
        for stroke in strokes:
            own = _complete_samples(stroke)
            if samples:
                shift = _time_shift(samples[-1].time_ns, own[0].time_ns, shift)
            samples += [replace(s, time_ns=s.time_ns + shift) for s in own] if shift else own
            for name, pairs in stroke.tool_changes(shift).items():
                changes[name] = [*changes.get(name, []), *pairs]
        return recording_of(samples, {**strokes[0].header(), **changes, "object": object_name})


def check_pairs(
    name: str, changes: Sequence[tuple[int, float]], least: float = 0.0
) -> tuple[tuple[int, float], ...]:
    """Pairs of a stroke's samples and fractions, the fractions from `least` to 1.

    Raises
    ------
    InputError
        If they are no pairs of a sample and a fraction, one sample after the other.
    """
    expected = Message(
        "pairs of a sample, counted from 0, and a fraction from {least:g} to 1, in order",
        least=least,
    )
    try:
        pairs = [(k, as_number(fraction, "fraction", least, 1.0)) for k, fraction in changes]
    except (TypeError, ValueError, InputError):
        raise InputError(
            "{name} are {told!r:.60}; expected {expected}",
            name=name,
            told=changes,
            expected=expected,
        ) from None
    whole = all(type(k) is int and k >= 0 for k, _ in pairs)
    if not whole or any(b <= a for (a, _), (b, _) in pairwise(pairs)):
        raise InputError(
            "{name} are {told!r:.60}; expected {expected}",
            name=name,
            told=changes,
            expected=expected,
        )
    return tuple(pairs)


def _complete_samples(stroke: Stroke) -> list[DeviceSample]:
    """A stroke's samples, dipped and with lifted ends; with the eraser end where it erases."""
    end = ERASER if stroke.tags.get(ERASES) else 0
    samples = [replace(s, buttons=s.buttons & ~ERASER | end) for s in stroke.samples]
    first, last = samples[0], samples[-1]
    if first.pressure is None:
        return samples
    if first.pressure > 0.0:
        samples.insert(0, replace(first, time_ns=first.time_ns - _LANDING_NS, pressure=0.0))
    if last.pressure is not None and last.pressure > 0.0:
        samples.append(replace(last, time_ns=last.time_ns + _LANDING_NS, pressure=0.0))
    if stroke.dipped_since_stroke:
        dip = replace(samples[0], time_ns=samples[0].time_ns - _LANDING_NS, buttons=DIP | end)
        samples.insert(0, dip)
    return samples


def _time_shift(end_ns: int, begin_ns: int, shift: int) -> int:
    """Offset for a stroke's times, ns: as of those before it, if it begins after them then.

    Else its clock is another one. It is moved by whole pieces of the ink's time, so that these end
    in it where they did.
    """
    if begin_ns + shift > end_ns:
        return shift
    return -((begin_ns - end_ns - _PAUSE_NS) // INK_STEP_NS) * INK_STEP_NS


def recording_of(samples: Sequence[DeviceSample], header: Mapping[str, object]) -> Recording:
    """Samples as a recording.

    Raises
    ------
    RecordingError
        If there are none, time does not increase, or only some have a pressure.
    """
    pressures = [s.pressure for s in samples]
    return Recording(
        time_ns=np.array([s.time_ns for s in samples], np.int64),
        position=np.array([s.position for s in samples]).reshape(-1, 3),
        orientation=np.array([s.orientation for s in samples]).reshape(-1, 4),
        pressure=None if None in pressures else np.array(pressures),
        buttons=np.array([s.buttons for s in samples], np.int32),
        object_position=np.array([s.object_position for s in samples]).reshape(-1, 3),
        object_orientation=np.array([s.object_orientation for s in samples]).reshape(-1, 4),
        header=dict(header),
        contact=contacts_of(samples),
    )


def strokes_of(recordings: Sequence[Recording], brushes: object = None) -> list[Stroke]:
    """Strokes that were saved; see `StrokeLog`.

    Raises
    ------
    SessionError
        If a header is not that of a stroke.
    """
    known = brushes if isinstance(brushes, Mapping) else {}
    return [_read_stroke(recording, known) for recording in recordings]


def _read_stroke(recording: Recording, brushes: Mapping[str, Mapping[str, Any]]) -> Stroke:
    """A stroke that was saved.

    Raises
    ------
    SessionError
        If its header is not that of a stroke.
    """
    header = recording.header
    try:
        name = header["brush"]
        words = brushes.get(name)
        brush = load_brush(name, own_files=False) if words is None else brush_from_words(words)
        ink = {str(k): float(w) for k, w in header["parts"].items()}
        loads, strengths = changes_at(header, recording.time_ns)
        return Stroke(
            float(header["time_s"]), brush, ink, str(header["layer"]), bool(header["dipped"]),
            DipAmount.of(header.get("dip", {})), list(recording.samples()), dict(header["tags"]),
            tuple(loads), tuple(strengths),
        )  # fmt: skip
    except (
        KeyError, TypeError, ValueError, AttributeError, InputError, RecordingError
    ) as cause:  # fmt: skip
        raise SessionError("a stroke of the session cannot be used: {cause}", cause=cause) from None


def names_apart(brushes: Iterable[BrushSpec]) -> dict[BrushSpec, str]:
    """A name for each brush that no other has; its own for the first that is called so."""
    names: dict[BrushSpec, str] = {}
    for brush in dict.fromkeys(brushes):
        name, n = brush.name, 1
        while name in names.values():
            n += 1
            name = f"{brush.name} ({n})"
        names[brush] = name
    return names


def weights_of(ink: str | Pigment | Mapping[Any, float]) -> dict[str, float]:
    """The weights of the inks in a mixture, by name, as they were given."""
    stirred = ink if isinstance(ink, Mapping) else {ink: 1.0}
    return {k if isinstance(k, str) else k.name: float(w) for k, w in stirred.items()}


def ink_of(stroke: Stroke, surface: PaintedSurface) -> dict[str | Pigment, float]:
    """A stroke's ink, with the surface's own pigments in place of their names."""
    known = {pigment.name: pigment for pigment in surface.pigments}
    return {known.get(name, name): part for name, part in stroke.ink.items()}


def parts_of(ink: str | Pigment | Mapping[Any, float]) -> dict[str, float]:
    """The weights of the inks in a mixture, of sum 1, by name."""
    weights = weights_of(ink)
    total = sum(weights.values())
    return {name: weight / total for name, weight in weights.items()}
