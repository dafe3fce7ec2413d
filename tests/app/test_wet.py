"""Ink that spreads beside a hand: it gives way, keeps what passed, and is never late."""

from __future__ import annotations

import threading
import time
from concurrent.futures import CancelledError
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from paint3d.app.model import paint_thread as paint_threads
from paint3d.app.model.ink_clock import LATE_S, InkClock
from paint3d.app.model.paint_thread import Pace, PaintThread
from paint3d.app.model.persistence.recovery_folder import RecoveryFolder, recoverable
from paint3d.painter import painter as engine
from paint3d.painter.ink_time import INK_STEP_NS, INK_STEP_S
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.app.hands import line, paint, same_vertices, small_plane, wait_until

LIMIT_S = 300.0  # for what comes at once where the machine is not busy


class Clockwork:
    """Stands in for a document's ink: notes what is asked for, and lasts as long as it is held."""

    def __init__(self, document):
        self.document, self.done = document, []
        self.held, self.entered = threading.Event(), threading.Event()
        self.held.set()
        document.follow_time = self.follow_time

    def follow_time(self, seconds):
        self.entered.set()
        assert self.held.wait(LIMIT_S)
        self.done.append(seconds)
        return True


def wet_plane():
    document = small_plane(material="xuan")
    paint(document, (-20, 0), (20, 0))
    return document


class Wall:
    """The clock on the wall, which goes on when it is told to."""

    def __init__(self, monkeypatch):
        self.now = 1000.0
        names = {name: getattr(time, name) for name in ("monotonic", "thread_time", "sleep")}
        clock = SimpleNamespace(
            perf_counter=lambda: self.now, perf_counter_ns=lambda: round(1e9 * self.now), **names
        )
        monkeypatch.setattr(paint_threads, "time", clock)


@pytest.fixture
def wall(monkeypatch):
    return Wall(monkeypatch)


@pytest.fixture
def quick_wall(monkeypatch, wall):
    """Beside a machine that is as fast as need be."""
    monkeypatch.setattr(paint_threads.Pace, "most", lambda pace, behind_s: 1000)
    return wall


@pytest.fixture
def clockwork(wall):
    document = wet_plane()
    clockwork = Clockwork(document)
    clockwork.held.clear()
    clockwork.paint_thread = PaintThread(document, wet=True)
    wall.now += LATE_S + 1.1 * INK_STEP_S
    assert clockwork.entered.wait(LIMIT_S)
    yield clockwork
    clockwork.held.set()
    clockwork.paint_thread.stop()


@given(st.floats(1e-4, 1.0), st.floats(0.0, 1.0))
def test_painting_stays_near_the_hand_however_long_the_ink_takes(piece_s, behind_s):
    """What passes at once has been followed soon, or takes less than the time that it is."""
    pace = Pace()
    for _ in range(500):
        pace.took(piece_s)
    work_s = pace.most(behind_s) * piece_s
    if piece_s <= 0.8 * INK_STEP_S:
        assert piece_s < work_s <= 0.2
    elif behind_s <= 0.05:
        assert pace.most(behind_s) == 1 or behind_s + work_s <= 0.2
        assert work_s > 0.0
    else:
        assert work_s == 0.0 or behind_s + work_s <= 0.2


def test_whatever_is_asked_for_overtakes_the_ink(clockwork, wall):
    paint_thread, done = clockwork.paint_thread, clockwork.done
    for _ in range(3):
        paint_thread.post(lambda document: done.append("asked"))
    wall.now += 6 * INK_STEP_S
    assert paint_thread.queue_length == 3  # no time waits behind what was asked for
    last = paint_thread.post(lambda document: done.append("last"))
    clockwork.held.set()
    last.result(timeout=LIMIT_S)
    assert done[1:5] == ["asked", "asked", "asked", "last"]


def test_ink_that_moves_by_itself_is_nothing_that_was_asked_for(clockwork):
    """A hand that rests is never told that painting is behind."""
    paint_thread = clockwork.paint_thread
    paint_thread.take_frame()
    for _ in range(3):
        paint_thread.post("follow_time", INK_STEP_S)
    clockwork.held.set()
    frames = []
    wait_until(lambda: frames.append(paint_thread.take_frame()) or frames[-1] is not None)
    assert frames[-1].queue_length == 0


def test_no_ink_moves_once_it_is_switched_off(clockwork, wall):
    paint_thread = clockwork.paint_thread
    paint_thread.wet = False
    clockwork.held.set()
    for _ in range(3):
        paint_thread.post(lambda document: None).result(timeout=LIMIT_S)
        wall.now += 2 * INK_STEP_S
    assert len(clockwork.done) == 1  # the piece that was being done


def test_switching_on_wakes_whoever_sleeps():
    document = wet_plane()
    paint_thread = PaintThread(document)
    paint_thread.post(lambda document: None).result(timeout=LIMIT_S)
    time.sleep(0.05)  # it sleeps until something is asked for
    paint_thread.wet = True
    wait_until(lambda: document.surface.flow.steps > 0)
    paint_thread.stop()


def test_while_ink_cannot_be_followed_no_time_passes_for_it(monkeypatch):
    document, asked = small_plane(material="xuan"), []
    answers = iter([True, False, False, False, True, True])

    def follow(seconds):
        asked.append(seconds)
        return next(answers)

    monkeypatch.setattr(document.surface, "follow_flow", follow)
    keeps_up = [document.follow_time(0.05) for _ in range(6)]
    assert keeps_up == [True, False, False, False, True, True]
    assert asked == [0.05, 0.05, 0.0, 0.0, 0.0, 0.05]  # work goes on, time does not


def test_time_is_left_out_where_a_piece_takes_long(clockwork, wall):
    wall.now += 10 * INK_STEP_S
    clockwork.held.set()
    wait_until(lambda: clockwork.paint_thread.ink_clock.left_out > 0)
    for _ in range(3):
        clockwork.paint_thread.post(lambda document: None).result(timeout=LIMIT_S)
    with clockwork.paint_thread.paused():
        assert len(clockwork.done) <= 4  # of the ten that went by


PAUSES_S = (0.62, 4.7, 0.0)


def strokes():
    """Three that run into one another, of one hand, at 200 Hz by a clock of its own.

    In the last it is lifted for a while.
    """
    found, t0 = [], 1_000_000
    for k in range(3):
        found.append(line((-20, 6 * k), (20, 6 * k - 10), n=30, t0=t0))
        t0 = found[-1][-1].time_ns + round(1e9 * PAUSES_S[k])
    found[-1] += line((-20, -12), (20, -16), n=30, t0=t0 + 170_000_000)
    return found


def handed_over(wall, late_s, waits=False):
    """A painting of a hand whose samples come in bursts, none later than that."""
    document, began = small_plane(1.0, material="xuan"), wall.now
    paint_thread = PaintThread(document, wet=True)
    for number, stroke in enumerate(strokes()):
        burst = []
        paint_thread.post("begin_stroke")
        for sample in stroke:
            burst.append(sample)
            came = began + 1e-9 * sample.time_ns
            if sample is stroke[-1] or came >= began + 1e-9 * burst[0].time_ns + late_s:
                wall.now = max(wall.now, came)
                paint_thread.feed(burst)
                burst = []
        paint_thread.post("end_stroke")
        if waits and number < 2:
            paint_thread.post(lambda document: None).result(timeout=LIMIT_S)
            wall.now += PAUSES_S[number] - 0.05
            done = document.surface.flow.steps
            wait_until(lambda done=done: document.surface.flow.steps > done)
    paint_thread.wet = False
    paint_thread.stop()
    return document


@pytest.fixture
def painted_in_time(quick_wall):
    return handed_over(quick_wall, late_s=0.0, waits=True)


def same_ink(one, other):
    same_vertices(one, other)
    assert one.flow.water == other.flow.water > 0.0


def test_the_ink_has_the_hands_own_time_however_late_it_is_told(quick_wall, painted_in_time):
    for late_s in (0.0, 0.03, 0.2, 20.0):
        same_ink(painted_in_time.surface, handed_over(quick_wall, late_s).surface)


@pytest.mark.parametrize("part", [None, 7, pytest.param(40, marks=pytest.mark.long)])
def test_its_recording_gives_the_ink_the_same_time(monkeypatch, painted_in_time, part):
    if part is not None:
        monkeypatch.setattr(engine, "_PART", part)
    recording, source = painted_in_time.recording(), painted_in_time.surface.source
    surface = PaintedSurface(source, 1.0, "xuan")
    Painter(surface).replay(recording, wet=True)
    same_ink(painted_in_time.surface, surface)


@given(
    gaps=st.lists(st.floats(0.001, 0.9), min_size=1, max_size=40),
    lates=st.lists(st.floats(0.0, 0.24), min_size=40, max_size=40),
    looks=st.lists(st.integers(0, 4), min_size=40, max_size=40),
)
def test_the_same_pieces_of_time_pass_before_a_sample_however_late_it_comes(gaps, lates, looks):
    samples = 5 + np.cumsum(np.round(np.array(gaps) * 1e9).astype(np.int64))
    calm, late = InkClock(7_000), InkClock(7_000)
    at_once = [calm.advance_to(int(t), 0, 1000) for t in samples]
    come = np.maximum.accumulate(samples + np.round(1e9 * np.array(lates[: len(gaps)])))
    before, passed = int(come[0]), []
    for k, (t, now) in enumerate(zip(samples, come, strict=True)):
        waited = 0
        for look in np.linspace(before, int(now), looks[k], endpoint=False) if k else ():
            while late.wait(int(look), 1000):
                waited += 1
        passed.append(waited + late.advance_to(int(t), int(now), 1000))
        before = int(now)
    assert passed == at_once
    assert calm.left_out == late.left_out == 0
    assert sum(passed) == samples[-1] // INK_STEP_NS - samples[0] // INK_STEP_NS


def test_the_wall_goes_on_for_a_hand_that_is_silent():
    clock, pieces, now = InkClock(0), 0, 0
    assert clock.advance_to(10**12, now, 1000) == 0
    for _ in range(1000):
        now += max(1000, round(1e9 * clock.patience(now)))
        pieces += clock.wait(now, 1000)
    assert pieces >= 499  # it is looked at no oftener than need be
    assert pieces == (now - 250_000_000) // 50_000_000


def test_a_clock_that_starts_anew_and_one_that_stood_still_do_no_harm():
    clock = InkClock(0)
    assert clock.advance_to(10**15, 0, 5) == 0  # of a hand whose clock is another one
    assert clock.advance_to(10**15 + 10**9, 0, 5) == 5
    assert clock.left_out == 15
    assert clock.advance_to(10**15 + 10**12, 0, 10**9) == 19_980  # however long it was silent
    assert clock.advance_to(2 * 10**15, 0, 70) == 70
    assert clock.advance_to(77, 0, 10**9) == 0
    assert clock.advance_to(77 + 10**8, 0, 10**9) == 2


def test_nothing_is_written_down_where_all_is_dry(tmp_path):
    document = small_plane(material="xuan")
    sitting = RecoveryFolder(document, tmp_path)
    noted = []
    sitting.note = noted.append
    paint_thread = PaintThread(document, wet=True, recovery=sitting)
    time.sleep(0.3)
    paint_thread.stop()
    assert noted == []


@pytest.fixture
def autosave_interval_s():
    """No base but the first."""
    return 1e9


@pytest.fixture
def wet_sitting(quick_wall, tmp_path, autosave_interval_s):
    """Strokes that run into one another, while time goes on; left to be recovered."""
    document = small_plane(1.0, material="xuan")
    paint_thread = PaintThread(
        document, True, RecoveryFolder(document, tmp_path), autosave_interval_s
    )
    for k in range(4):
        paint_thread.post("begin_stroke")
        for sample in line((-20, 6 * k), (20, 6 * k - 10), n=40):
            quick_wall.now += 0.002
            paint_thread.feed([sample])
        paint_thread.post("end_stroke")
    paint_thread.post("undo").result(timeout=LIMIT_S)
    done = document.surface.flow.steps
    quick_wall.now += LATE_S + 4.1 * INK_STEP_S
    wait_until(lambda: document.surface.flow.steps > done)
    paint_thread.stop(keep=True)
    return document


def test_a_wet_sitting_comes_back_to_the_bit(wet_sitting, tmp_path):
    document = wet_sitting
    shares = []
    recovered = recoverable(tmp_path)[0].recover(shares.append)
    same_vertices(recovered.document.surface, document.surface)
    assert recovered.document.surface.flow.water == document.surface.flow.water > 0.0
    assert recovered.refused == ()
    assert shares == sorted(shares)
    assert shares[0] == 0.0
    assert shares[-1] == pytest.approx(1.0)
    assert len(shares) > 10


def test_recovery_can_be_stopped_and_done_later(wet_sitting, tmp_path):
    (unfinished,) = recoverable(tmp_path)
    before = {file.name: file.read_bytes() for file in unfinished.folder.iterdir()}
    shares = []

    def stop(share):
        shares.append(share)
        if share > 0.5:
            raise CancelledError

    with pytest.raises(CancelledError):
        unfinished.recover(progress=stop)
    assert 0.5 < shares[-1] < 0.7
    assert {file.name: file.read_bytes() for file in unfinished.folder.iterdir()} == before
    same_vertices(recoverable(tmp_path)[0].recover().document.surface, wet_sitting.surface)


@pytest.mark.parametrize("autosave_interval_s", [-1.0])  # the clock stands still
def test_a_wet_sitting_comes_back_to_the_bit_from_a_later_base(wet_sitting, tmp_path):
    (unfinished,) = recoverable(tmp_path)
    (base,) = unfinished.folder.glob("base-*")
    assert int(base.stem.split("-")[1]) > 1
    same_vertices(unfinished.recover().document.surface, wet_sitting.surface)
