"""The papers' timing study: files of what was painted to times, likeness, and a paired test.

Guo 2017, Fig. 12: six volunteers painted one character with two sets of devices; with the haptic
one they needed nearly half the time. What is read here are saved paintings or recordings, so the
table needs neither devices nor a display.
"""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from paint3d.app.model.copybook import Ghost
from paint3d.app.model.score.playing import painted
from paint3d.app.model.studies.plan import NEITHER, Answer, StudyPlan, Trial, load_answers
from paint3d.brush.presets import load_brush
from paint3d.calligraphy.glyph_sources import GlyphSource, open_glyphs
from paint3d.calligraphy.layout import layout_text
from paint3d.colour.inks import load_ink
from paint3d.device.recorded import Recording
from paint3d.errors import InputError, Paint3DError
from paint3d.files.load import load_mesh
from paint3d.files.project.session import SESSION_SUFFIX, load_session
from paint3d.mesh.bvh import ClosestPoints
from paint3d.painter.painter import Painter
from paint3d.recording.recording import HandTime, load_recording
from paint3d.recording.score import is_score, load_score
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["Measured", "PairedTest", "StudyTable", "Summary", "evaluate", "find_file", "measure"]

SUFFIXES = (
    SESSION_SUFFIX,
    ".score.jsonl",
    ".score.jsonl.gz",
    ".jsonl",
    ".jsonl.gz",
    ".csv",
    ".csv.gz",
    ".inkml",
)
_ANOTHER_CLOCK_NS = 3_600_000_000_000
_RESOLUTION_MM = 0.5  # of paintings made from recordings
_DEFAULT_BRUSH, _DEFAULT_INK = "zhongbaiyun", "pine soot"


@dataclass(frozen=True)
class Measured:
    """Measurements of one trial.

    Attributes
    ----------
    trial : Trial
    file : str
    seconds : float
        Drawing time: from the first touch to the last lift, s.
    stroke_seconds : tuple of float
        Of each stroke, s.
    likeness : float or None
        IoU with the copybook; None where it cannot be measured.
    """

    trial: Trial
    file: str
    seconds: float
    stroke_seconds: tuple[float, ...]
    likeness: float | None

    @property
    def pen_down_seconds(self) -> float:
        """Time in which the brush touched, s."""
        return sum(self.stroke_seconds)


@dataclass(frozen=True)
class Summary:
    """Mean and standard deviation (of a sample; NaN for one) over n values."""

    n: int
    mean: float
    sd: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Summary:
        """Summarise some values."""
        n = len(values)
        mean = float(np.mean(values)) if n else math.nan
        return cls(n, mean, float(np.std(values, ddof=1)) if n > 1 else math.nan)


@dataclass(frozen=True)
class PairedTest:
    """Two device sets compared within participants, by their mean drawing times.

    Attributes
    ----------
    first, second : str
        Device sets.
    n : int
        Participants who have both.
    ratio : float
        Mean time with the second over that with the first.
    t, p : float
        Of the paired t test, two-sided; NaN for less than two participants.
    wilcoxon_p : float
        Of Wilcoxon's signed-rank test, two-sided.
    """

    first: str
    second: str
    n: int
    ratio: float
    t: float
    p: float
    wilcoxon_p: float


@dataclass(frozen=True)
class StudyTable:
    """The results of a study.

    Attributes
    ----------
    plan : StudyPlan
    measured : tuple of Measured
    missing : tuple of str
        Stems of trials without a file.
    faulty : tuple of (str, str)
        Files that cannot be used, and why.
    answers : mapping
        What participants prefer, by their names.
    """

    plan: StudyPlan
    measured: tuple[Measured, ...]
    missing: tuple[str, ...]
    faulty: tuple[tuple[str, str], ...]
    answers: Mapping[str, Answer] = field(default_factory=dict)

    def preferences(self) -> dict[str, int]:
        """Number of participants who prefer each device set, and neither."""
        counts = Counter(answer.prefers for answer in self.answers.values())
        return {name: counts[name] for name in (*self.plan.devices, NEITHER)}

    def preference_p(self) -> float:
        """Of the two-sided sign test between two device sets; NaN for others, or nobody."""
        from scipy.stats import binomtest

        counts = [self.preferences()[devices] for devices in self.plan.devices]
        if len(counts) != 2 or not sum(counts):
            return math.nan
        return float(binomtest(counts[0], sum(counts)).pvalue)

    def summary(self, devices: str, value: Callable[[Measured], float | None]) -> Summary:
        """Of a value over participants (the mean of each one's trials) with a device set."""
        return Summary.of(list(self.by_participant(devices, value).values()))

    def by_participant(
        self, devices: str, value: Callable[[Measured], float | None]
    ) -> dict[str, float]:
        """A value of each participant with a device set: the mean of their trials."""
        by_name: dict[str, list[float]] = {}
        for one in self.measured:
            number = value(one)
            if one.trial.devices == devices and number is not None:
                by_name.setdefault(one.trial.participant, []).append(number)
        return {name: float(np.mean(numbers)) for name, numbers in by_name.items()}

    def tests(self) -> list[PairedTest]:
        """Every device set against the first."""
        first, *others = self.plan.devices
        return [self._compare(first, other) for other in others]

    def _compare(self, first: str, second: str) -> PairedTest:
        from scipy.stats import ttest_rel, wilcoxon

        one, two = (self.by_participant(d, lambda m: m.seconds) for d in (first, second))
        both = [name for name in one if name in two]
        a, b = np.array([one[n] for n in both]), np.array([two[n] for n in both])
        ratio = float(b.mean() / a.mean()) if len(both) else math.nan
        t = p = rank_p = math.nan
        if len(both) > 1 and np.ptp(a - b) > 0.0:
            tested = ttest_rel(a, b)
            t, p = float(tested.statistic), float(tested.pvalue)
            rank_p = float(wilcoxon(a, b).pvalue)
        return PairedTest(first, second, len(both), ratio, t, p, rank_p)

    def to_json(self) -> dict[str, object]:
        """Everything as JSON holds it; what is not known is null."""
        values = {
            "seconds": lambda m: m.seconds,
            "pen_down_seconds": lambda m: m.pen_down_seconds,
            "strokes": lambda m: float(len(m.stroke_seconds)),
            "likeness": lambda m: m.likeness,
        }
        return {
            "character": self.plan.character,
            "object": self.plan.object,
            "devices": {
                devices: {
                    name: _without_nans(vars(self.summary(devices, value)))
                    for name, value in values.items()
                }
                for devices in self.plan.devices
            },
            "preferences": {
                "counts": self.preferences(),
                **_without_nans({"p": self.preference_p()}),
                "answers": {name: vars(answer) for name, answer in self.answers.items()},
            },
            "tests": [_without_nans(vars(test)) for test in self.tests()],
            "trials": [
                {
                    **vars(one.trial),
                    "file": one.file,
                    "seconds": one.seconds,
                    "stroke_seconds": list(one.stroke_seconds),
                    "likeness": one.likeness,
                }
                for one in self.measured
            ],
            "missing": list(self.missing),
            "faulty": [list(pair) for pair in self.faulty],
        }


def _without_nans(values: dict[str, object]) -> dict[str, object]:
    return {
        name: None if isinstance(value, float) and math.isnan(value) else value
        for name, value in values.items()
    }


def find_file(folder: Path, trial: Trial) -> Path | None:
    """The file of a trial: a session, else a recording; None where there is none."""
    for suffix in SUFFIXES:
        file = folder / f"{trial.stem}{suffix}"
        if file.is_file():
            return file
    return None


def evaluate(
    folder: Path,
    plan: StudyPlan,
    *,
    likeness: bool = True,
    source: GlyphSource | None = None,
    progress: Callable[[float], None] | None = None,
) -> StudyTable:
    """Measure all trials of a folder; files that cannot be used do not stop the others.

    Parameters
    ----------
    folder : Path
    plan : StudyPlan
    likeness : bool
        Compare with the copybook as well, which takes a second or so a trial.
    source : GlyphSource, optional
        Of the copybook.
    progress : callable, optional
        Called with the fraction done.

    Raises
    ------
    InputError
        If there is no copybook for the character, or no place for it on the object.
    """
    answers = load_answers(folder, plan)
    judge = _Judge(plan, source) if likeness else None
    measured, missing, faulty = [], [], []
    schedule = plan.schedule()
    for k, trial in enumerate(schedule):
        file = find_file(folder, trial)
        if file is None:
            missing.append(trial.stem)
        else:
            try:
                measured.append(measure(file, trial, judge, plan.object))
            except Paint3DError as cause:
                faulty.append((file.name, str(cause)))
        if progress is not None:
            progress((k + 1) / len(schedule))
    return StudyTable(plan, tuple(measured), tuple(missing), tuple(faulty), answers)


def measure(
    file: Path, trial: Trial, judge: _Judge | None = None, on: str | None = None
) -> Measured:
    """Measure one file; a whole painting is painted `on` the study's object.

    Raises
    ------
    Paint3DError
        If it cannot be read, or holds no stroke.
    """
    surface = None
    if file.name.endswith(SESSION_SUFFIX):
        session = load_session(file)
        surface = session.surface
        recordings = [*session.recordings, *_align_clocks(session.strokes)]
    elif is_score(file):
        surface, recordings = _paint_whole(file, on)
    else:
        recordings = [load_recording(file)]
    spans = sorted(span for recording in recordings for span in _touches(recording))
    if not spans:
        raise InputError("{file}: no stroke was painted; expected the character", file=file)
    start, end = spans[0][0], max(last for _, last in spans)
    likeness = None
    if judge is not None:
        likeness = judge.compare(surface if surface is not None else judge.painted(recordings[0]))
    seconds = tuple((last - first) * 1e-9 for first, last in spans)
    return Measured(trial, file.name, (end - start) * 1e-9, seconds, likeness)


def _paint_whole(file: Path, on: str | None) -> tuple[PaintedSurface, list[Recording]]:
    """Paint a whole painting; return its surface, and its strokes in one clock."""
    score = load_score(file)
    document = painted(score, load_mesh(on or str(score.header.get("object", ""))))
    strokes = [stroke.recording(stroke.brush.name) for stroke in document.strokes]
    clock, moved = HandTime(in_full=True), []
    for stroke in strokes:  # of clocks that began anew a short rest is thought to lie between
        when = clock.pass_samples(stroke.time_ns)
        moved.append(dataclasses.replace(stroke, time_ns=np.rint(when * 1e9).astype(np.int64)))
    return document.surface, moved


def _align_clocks(strokes: Sequence[Recording]) -> list[Recording]:
    """Strokes of several sittings, whose clocks started anew, one after the other.

    The devices' own times stay where they can be of one clock; else the time of day, which is
    less exact, says how much later a stroke began.
    """
    moved: list[Recording] = []
    for stroke in strokes:
        if moved:
            before = moved[-1]
            own = int(stroke.time_ns[0]) - int(before.time_ns[0])
            day = [float(one.header.get("time_s", math.nan)) for one in (before, stroke)]
            by_day = (day[1] - day[0]) * 1e9
            apart = int(stroke.time_ns[0]) < int(before.time_ns[-1])
            if math.isfinite(by_day) and (apart or own - by_day > _ANOTHER_CLOCK_NS):
                shift = round(by_day) - own
                stroke = dataclasses.replace(stroke, time_ns=stroke.time_ns + shift)
        moved.append(stroke)
    return moved


def _touches(recording: Recording) -> list[tuple[int, int]]:
    """First and last time (ns) of each run of samples in which the brush is pressed.

    A recording without pressure is one stroke.
    """
    times = recording.time_ns
    if recording.pressure is None:
        return [(int(times[0]), int(times[-1]))]
    down = np.concatenate([[False], recording.pressure > 0.0, [False]])
    starts = np.flatnonzero(down[1:] & ~down[:-1]).tolist()
    ends = np.flatnonzero(down[:-1] & ~down[1:]).tolist()
    last = len(times) - 1
    return [
        (int(times[max(0, start - 1)]), int(times[min(last, end)]))
        for start, end in zip(starts, ends, strict=True)
    ]


class _Judge:
    """Compares paintings with the copybook of a plan."""

    def __init__(self, plan: StudyPlan, source: GlyphSource | None) -> None:
        self._mesh = load_mesh(plan.object)
        closest = ClosestPoints(self._mesh)
        (placed,) = layout_text(closest, plan.character, plan.em_mm)
        glyph = (source or open_glyphs(None)).load(plan.character)
        self._ghost = Ghost(glyph, placed.square, closest)

    def compare(self, surface: PaintedSurface) -> float | None:
        likeness = self._ghost.compare(surface)
        return None if likeness is None else likeness.iou

    def painted(self, recording: Recording) -> PaintedSurface:
        """Paint a recording with its own brush and ink; return the surface."""
        header = recording.header
        surface = PaintedSurface(self._mesh, _RESOLUTION_MM)
        brush = load_brush(str(header.get("brush") or _DEFAULT_BRUSH), own_files=False)
        ink = load_ink(str(header.get("ink") or _DEFAULT_INK), own_tables=False)
        Painter(surface, brush, ink, str(header["azimuth"])).replay(recording)
        return surface
