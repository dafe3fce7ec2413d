"""Ink that spreads beside a hand: it gives way, keeps what passed, and is never late."""

from __future__ import annotations

import threading
import time
from concurrent.futures import CancelledError

import pytest

from paint3d.app.model import easel as easels
from paint3d.app.model.easel import Easel
from paint3d.app.model.sitting import Sitting, recoverable
from tests.app.hands import line, paint, same_vertices, small_plane


class Clockwork:
    """Stands in for a document's ink: notes what is asked for, and lasts as long as it is held."""

    def __init__(self, document, answers=()):
        self.document, self.done, self.answers = document, [], list(answers)
        self.held, self.entered = threading.Event(), threading.Event()
        self.held.set()
        document.let_time_pass = self.let_time_pass

    def let_time_pass(self, seconds):
        self.entered.set()
        assert self.held.wait(60)
        self.done.append(seconds)
        return self.answers.pop(0) if self.answers else True


def wet_plane():
    document = small_plane(material="xuan")
    paint(document, (-20, 0), (20, 0))
    return document


@pytest.fixture
def clockwork():
    document = wet_plane()
    clockwork = Clockwork(document)
    clockwork.held.clear()
    clockwork.easel = Easel(document, wet=True)
    assert clockwork.entered.wait(60)
    yield clockwork
    clockwork.held.set()
    clockwork.easel.stop()


def wait_for(condition):
    until = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.005)


def test_whatever_is_asked_for_overtakes_the_ink(clockwork):
    easel, done = clockwork.easel, clockwork.done
    for _ in range(3):
        easel.post(lambda document: done.append("asked"))
    time.sleep(0.2)  # as long as six pieces of time
    assert easel.queue_length == 3  # no time waits behind what was asked for
    last = easel.post(lambda document: done.append("last"))
    clockwork.held.set()
    last.result(timeout=60)
    assert done[1:5] == ["asked", "asked", "asked", "last"]


def test_no_ink_moves_once_it_is_switched_off(clockwork):
    easel = clockwork.easel
    easel.wet = False
    clockwork.held.set()
    for _ in range(3):
        easel.post(lambda document: None).result(timeout=60)
        time.sleep(0.05)
    assert len(clockwork.done) == 1  # the piece that was being done


def test_switching_on_wakes_whoever_sleeps():
    document = wet_plane()
    easel = Easel(document)
    easel.post(lambda document: None).result(timeout=60)
    time.sleep(0.05)  # it sleeps until something is asked for
    easel.wet = True
    wait_for(lambda: document.surface.flow.steps > 0)
    easel.stop()


def test_what_cannot_be_followed_is_not_made_up_for():
    document = wet_plane()
    clockwork = Clockwork(document, [True, False, False, False, True, True])
    easel = Easel(document, wet=True)
    wait_for(lambda: len(clockwork.done) >= 7)
    easel.stop()
    behind = clockwork.done[2:5]
    assert behind == [0.0, 0.0, 0.0]  # work goes on, time does not
    assert all(0.03 < seconds <= 0.05 for seconds in clockwork.done[:2] + clockwork.done[5:7])


def test_time_that_was_late_is_cut(clockwork):
    time.sleep(0.5)
    clockwork.held.set()
    wait_for(lambda: len(clockwork.done) >= 5)
    clockwork.easel.wet = False
    assert max(clockwork.done) <= 0.05
    late = sum(clockwork.done[1:5])  # before any more time can have passed
    assert late <= 0.2 + 1e-9


def test_nothing_is_written_down_where_all_is_dry(tmp_path):
    document = small_plane(material="xuan")
    sitting = Sitting(document, tmp_path)
    noted = []
    sitting.note = noted.append
    easel = Easel(document, wet=True, sitting=sitting)
    time.sleep(0.3)
    easel.stop()
    assert noted == []


def wet_sitting(folder, base_every_s=1e9):
    """Strokes that run into one another while the clock goes on."""
    document = small_plane(1.0, material="xuan")
    easel = Easel(document, wet=True, sitting=Sitting(document, folder), base_every_s=base_every_s)
    for k in range(4):
        easel.post("begin_stroke")
        for sample in line((-20, 6 * k), (20, 6 * k - 10), n=40):
            easel.feed([sample])
            time.sleep(0.002)
        easel.post("end_stroke")
    easel.post("undo")
    wait_for(lambda: easel.queue_length == 0)
    time.sleep(0.2)
    easel.stop(keep=True)
    return document


def test_a_wet_sitting_comes_back_to_the_bit(tmp_path):
    document = wet_sitting(tmp_path)
    shares = []
    recovered = recoverable(tmp_path)[0].recover(shares.append)
    same_vertices(recovered.document.surface, document.surface)
    assert recovered.document.surface.flow.water == document.surface.flow.water > 0.0
    assert recovered.refused == ()
    assert shares == sorted(shares)
    assert shares[0] == 0.0
    assert shares[-1] == pytest.approx(1.0)
    assert len(shares) > 10


def test_recovery_can_be_stopped_and_done_later(tmp_path):
    document = wet_sitting(tmp_path)
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
    same_vertices(recoverable(tmp_path)[0].recover().document.surface, document.surface)


def test_a_new_base_is_saved_before_recovering_takes_long(tmp_path, monkeypatch):
    monkeypatch.setattr(easels, "_DEAR_S", 0.02)
    document = wet_sitting(tmp_path)
    (unfinished,) = recoverable(tmp_path)
    (base,) = unfinished.folder.glob("base-*")
    assert int(base.stem.split("-")[1]) > 1
    same_vertices(unfinished.recover().document.surface, document.surface)
