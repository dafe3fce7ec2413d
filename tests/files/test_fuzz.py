"""Damaged inputs of each kind are read or refused; `python -m scripts.fuzz` has more."""

import random
import subprocess
import sys
from pathlib import Path

import pytest

from paint3d.errors import MeshError
from paint3d.files.formats.records import read_records
from paint3d.recording.recording import RecordingError, load_recording
from scripts.fuzz.campaign import Campaign, make_case, try_case
from scripts.fuzz.mutation import damage_json
from scripts.fuzz.targets import TARGETS, Target

ROOT = Path(__file__).parents[2]


DEAR = ["session", "seal", "drawn_seal", "letters"]  # most of the time is theirs


@pytest.mark.parametrize(
    ("names", "cases"),
    [
        ([name for name in TARGETS if name not in DEAR], 25),
        (DEAR, 5),
        pytest.param([*TARGETS], 1000, marks=(pytest.mark.long, pytest.mark.timeout(7200))),
    ],
)
def test_damaged_inputs_of_each_kind(names, cases):
    command = [sys.executable, "-m", "scripts.fuzz", *names, "--cases", str(cases)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == len(names)
    for name, line in zip(names, lines, strict=True):
        assert line.startswith(f"{name}: {cases:,} cases in ")
        assert line.endswith(", 0 bugs")
        assert cases < 25 or ", 0 read" not in line  # of a few, all may be past reading


def test_a_case_is_made_from_its_number_alone():
    target = TARGETS["recording"]
    seeds = target.seeds()
    cases = [make_case(target, seeds, "recording", k) for k in range(50)]
    random.seed(3)
    assert cases == [make_case(target, target.seeds(), "recording", k) for k in range(50)]
    assert len(set(cases)) > 40


def test_damage_to_a_document_is_made_from_its_chance_alone():
    """Values that were put into a document were damaged in it, and were so for all that follow."""
    text = b'{"x": [1, {"a": 2}], "y": {}, "z": {"b": [3]}}'
    cases = [damage_json(text, random.Random(k)) for k in range(300)]
    assert cases[::-1] == [damage_json(text, random.Random(k)) for k in reversed(range(300))]


def crash(_suffix: str, content: bytes) -> None:
    import os
    import signal

    if content.startswith(b"K"):
        os.kill(os.getpid(), signal.SIGSEGV)
    if content.startswith(b"M"):
        bytearray(3 << 30)
    if content.startswith(b"V"):
        raise ValueError("unexpected")
    if content.startswith(b"L"):
        raise MeshError("two\nlines")


def test_crashes_memory_and_tracebacks_are_noticed_and_the_rest_goes_on(monkeypatch):
    kinds = (b"good", b"K", b"M", b"V", b"L")

    def damage(_data, chance, _others):
        return kinds[chance.randrange(len(kinds))]

    target = Target("for this test", lambda: [("", b"good")], crash, damage)
    monkeypatch.setitem(TARGETS, "test", target)
    campaign = Campaign("test", 0, 40)
    campaign.run()
    assert campaign.n_done == 40
    made = {k: make_case(target, target.seeds(), "test", k)[1] for k in range(40)}
    assert set(campaign.bugs) == {k for k, content in made.items() if content != b"good"}
    words = {b"K": "SIGSEGV", b"M": "MemoryError", b"V": "unexpected", b"L": "several lines"}
    for k, what in campaign.bugs.items():
        assert words[made[k]] in what
    assert campaign.n_read == sum(content == b"good" for content in made.values())


def test_a_case_that_cannot_be_made_is_noted_and_the_rest_goes_on(monkeypatch):
    def damage(_data, chance, _others):
        if chance.random() < 0.3:
            raise KeyError("the fuzzer's own fault")
        return b"good"

    target = Target("for this test", lambda: [("", b"good")], crash, damage)
    monkeypatch.setitem(TARGETS, "test", target)
    campaign = Campaign("test", 0, 12)
    campaign.run()
    assert campaign.n_done == 12
    assert campaign.n_read == 12 - len(campaign.bugs) > 0
    assert campaign.bugs
    assert set(campaign.bugs.values()) == {"it could not be tried: making it failed"}


def test_what_fuzzing_found(tmp_path):
    """Each was a traceback, or a number that is none."""
    table = "time_ns,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n1,0,0,0,1,0,2e9,0\n"
    (tmp_path / "a.csv").write_text(table)
    with pytest.raises(RecordingError, match=r"a\.csv:3: qy is 2e\+09"):
        load_recording(tmp_path / "a.csv")
    (tmp_path / "a.txt").write_text("InitialPosition={1e999, 0, 0}\n{1,2,3,4,5,6,7}\n")
    with pytest.raises(MeshError, match="a position is not finite"):
        read_records(tmp_path / "a.txt")


def test_warnings_are_bugs():
    import numpy as np

    def check(_suffix: str, _content: bytes) -> None:
        np.array([1e308]) * 10.0

    target = Target("for this test", list, check)
    assert "RuntimeWarning" in try_case(target, "", b"")[1]
