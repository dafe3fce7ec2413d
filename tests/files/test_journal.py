"""Journals: whatever cuts or flips them, they open up to the damage and say so."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.device.sample import DeviceSample
from paint3d.errors import ExportError, RecordingError, SessionError
from paint3d.files.project.journal import SAMPLE, Journal, read_events, read_journal
from tests.support.full_disk import full_disk

ROOT = Path(__file__).parents[2]


def samples(first, n, pressure=0.5):
    turn = np.array([0.6, 0.0, 0.8, 0.0])
    return [
        DeviceSample(k * 1000, np.array([k, 0.5, -k]), turn, pressure, k % 3, np.ones(3), turn)
        for k in range(first, first + n)
    ]


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A closed journal of 5 x 4 samples, and where its blocks end."""
    path = tmp_path_factory.mktemp("journal") / "a.p3dj"
    ends = []
    with Journal(path, {"brush": "full", "ink": "墨"}) as journal:
        for k in range(5):
            journal.append(samples(4 * k, 4))
            ends.append(os.path.getsize(path))
    return path.read_bytes(), ends


def opened(tmp_path, data):
    path = tmp_path / "b.p3dj"
    path.write_bytes(data)
    return read_journal(path)


def test_a_closed_journal_comes_back_whole(tmp_path, written):
    recording, loss = opened(tmp_path, written[0])
    assert not loss
    assert recording.header["ink"] == "墨"
    for sample, expected in zip(recording.samples(), samples(0, 20), strict=True):
        for name in SAMPLE.names:
            np.testing.assert_array_equal(getattr(sample, name), getattr(expected, name))


def test_samples_are_with_the_system_when_append_returns(tmp_path):
    journal = Journal(tmp_path / "a.p3dj", {})
    journal.append(samples(0, 3, None))
    recording, loss = read_journal(tmp_path / "a.p3dj")
    assert len(recording) == 3
    assert recording.pressure is None
    assert "was not closed" in loss.reason
    journal.close()
    journal.close()
    assert not read_journal(tmp_path / "a.p3dj")[1]


def test_cut_anywhere_it_opens_up_to_the_cut(tmp_path, written):
    data, ends = written
    near_ends = {end + k for end in ends for k in (-1, 0, 1)}
    for length in sorted({*range(0, len(data), 29), *near_ends}):
        whole = 4 * sum(end <= length for end in ends)
        if not whole:
            with pytest.raises(SessionError):
                opened(tmp_path, data[:length])
            continue
        recording, loss = opened(tmp_path, data[:length])
        assert len(recording) == whole
        assert loss
        assert loss.n_bytes == length - max(end for end in ends if end <= length)
        assert loss.n_bytes == 0 or f"damaged at byte {loss.at:,}" in loss.reason


@settings(deadline=None, max_examples=60)
@given(st.data())
def test_flipped_anywhere_it_opens_up_to_the_flip(tmp_path_factory, written, data):
    content, ends = bytearray(written[0]), written[1]
    bit = data.draw(st.integers(0, 8 * len(content) - 1))
    content[bit // 8] ^= 1 << bit % 8
    whole = 4 * sum(end <= bit // 8 for end in ends)
    folder = tmp_path_factory.mktemp("flip")
    if not whole:
        with pytest.raises(SessionError):
            opened(folder, bytes(content))
        return
    recording, loss = opened(folder, bytes(content))
    assert recording.time_ns.tolist() == [1000 * k for k in range(whole)]
    assert loss.n_bytes == len(content) - max(end for end in ends if end <= bit // 8)


def test_a_journal_is_never_written_over(tmp_path):
    (tmp_path / "a.p3dj").write_text("what a crash left")
    with pytest.raises(ExportError, match="cannot start a journal: File exists"):
        Journal(tmp_path / "a.p3dj", {})
    with pytest.raises(ExportError, match="cannot start a journal: No such file"):
        Journal(tmp_path / "none" / "a.p3dj", {})
    with pytest.raises(SessionError, match="does not start as a journal"):
        read_journal(tmp_path / "a.p3dj")


def test_what_no_recording_can_hold_is_not_written(tmp_path):
    with Journal(tmp_path / "a.p3dj", {}) as journal:
        journal.append([])
        journal.append(samples(5, 2))
        for bad in (samples(6, 1), samples(9, 1) * 2, samples(9, 1, None)):
            with pytest.raises(RecordingError):
                journal.append(bad)
        journal.append(samples(7, 1))
    recording, loss = read_journal(tmp_path / "a.p3dj")
    assert recording.time_ns.tolist() == [5000, 6000, 7000]
    assert not loss
    for header in ({"version": 7}, {"x": object()}):
        with pytest.raises(RecordingError):
            Journal(tmp_path / "b.p3dj", header)
    assert not (tmp_path / "b.p3dj").exists()


def test_a_full_disk_leaves_a_whole_journal(tmp_path):
    path = tmp_path / "a.p3dj"
    journal = Journal(path, {})
    journal.append(samples(0, 4))
    size = path.stat().st_size
    with full_disk(size + 100):
        with pytest.raises(ExportError, match=r"a\.p3dj: cannot write: File too large"):
            journal.append(samples(4, 4))
        assert path.stat().st_size == size
    journal.append(samples(4, 4))
    journal.close()
    assert len(read_journal(path)[0]) == 8


def test_what_could_not_be_written_together_is_no_new_beginning(tmp_path):
    """After the note that was lost times and pressures began anew: nothing could be read."""
    path = tmp_path / "a.p3dj"
    journal = Journal(path, {})
    journal.append(samples(50, 4))

    def begin_anew():
        with journal.together():
            journal.note({"do": "begin_stroke"})
            journal.append(samples(0, 4, None))

    with full_disk(path.stat().st_size + 100), pytest.raises(ExportError, match="cannot write"):
        begin_anew()
    for another in (samples(4, 1, None), samples(4, 1), samples(60, 1, None)):
        with pytest.raises(RecordingError):
            journal.append(another)
    journal.append(samples(60, 2))
    journal.note({"do": "begin_stroke"})
    journal.append(samples(5, 1, None))
    journal.close()
    _, (first, _, second), loss = read_events(path)
    assert (len(first), len(second), bool(loss)) == (6, 1, False)


def test_killed_at_random_moments_it_loses_100_ms_at_most():
    code = "from scripts.kill_journal import kill_at_random; print(*kill_at_random(10))"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr
    kept, lost = map(int, done.stdout.split())
    assert kept > 100
    assert lost <= 100_000_000


@pytest.mark.parametrize("times", [1, pytest.param(5, marks=pytest.mark.long)])
def test_a_studio_killed_while_it_paints_comes_back(times):
    """How much it may lose, 100 ms, is asked for by the script alone: tests share the cores."""
    code = (
        "from scripts.kill_sitting import kill_at_random\n"
        f"for kill in kill_at_random({times}): print(kill.n_sent, kill.n_kept)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr
    kills = [list(map(int, line.split())) for line in done.stdout.splitlines()]
    assert len(kills) == times
    assert all(told >= kept > 10 for told, kept in kills)
