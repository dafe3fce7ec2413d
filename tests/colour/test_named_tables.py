"""What somebody else wrote names no file of this machine: inks of recordings and sessions."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.app.model.document import Document
from paint3d.app.model.studies.plan import make_plan
from paint3d.app.model.studies.study import evaluate
from paint3d.cli import main
from paint3d.colour import pigments
from paint3d.errors import SessionError
from paint3d.files.load import load_mesh
from paint3d.files.project.session import Session, save_session
from paint3d.recording.recording import Recording, save_recording
from paint3d.surface.painted_surface import PaintedSurface

UPRIGHT = (1.0, 0.0, 0.0, 0.0)


@pytest.fixture
def table(tmp_path, monkeypatch):
    """A table of inks that must not be read unless its own user asks for it."""
    path = tmp_path / "mine.csv"
    columns = ",".join(f"{letter}_{n}" for letter in "KS" for n in (400, 550, 700))
    path.write_text(f"name,{columns}\nmine,1,2,3,4,4,4\n")
    read, asked = pigments.load_pigments_csv, []

    def noted(file):
        asked.extend([file] if str(file) == str(path) else [])
        return read(file)

    monkeypatch.setattr(pigments, "load_pigments_csv", noted)
    return path, asked


def recording(path, ink, **more):
    n = 20
    at = np.column_stack([np.linspace(-15, 15, n), np.zeros(n), np.full(n, 30.0)])
    pressure = np.where((np.arange(n) > 0) & (np.arange(n) < n - 1), 0.2, 0.0)
    times = np.arange(n, dtype=np.int64) * 10_000_000
    turned = np.tile(UPRIGHT, (n, 1))
    save_recording(Recording(times, at, turned, pressure, header={"ink": ink, **more}), path)
    return path


def test_a_recording_names_no_table(table, tmp_path, capsys):
    path, asked = table
    strokes = recording(tmp_path / "strokes.jsonl", f"{path}:mine")
    out = tmp_path / "out.ply"
    told = ["replay", str(strokes), "--on", "plane", "--out", str(out), "--quiet"]
    assert main.main(told) == 2
    said = capsys.readouterr().err
    assert "the header: the ink" in said
    assert "which a file may not name; expected an ink of the palette, or --ink" in said
    assert not asked
    assert not out.exists()
    assert main.main([*told, "--ink", f"{path}:mine"]) == 0  # who replays it may
    assert asked


def test_the_parts_of_a_recording_are_its_ink_and_name_no_table(table, tmp_path, capsys):
    path, asked = table
    codes = []
    for k, more in enumerate(({"parts": {"cinnabar": 0.2, "water": 0.8}}, {})):
        strokes = recording(tmp_path / f"{k}.jsonl", "cinnabar:0.2,water:0.8", **more)
        out = tmp_path / f"{k}.ply"
        told = ["replay", str(strokes), "--on", "plane", "--out", str(out), "--quiet"]
        assert main.main([*told, "--resolution", "2"]) == 0
        codes.append(out.read_bytes())
    assert codes[0] == codes[1]
    for parts, fault in (
        ({f"{path}:mine": 0.5, "water": 0.5}, "which a file may not name"),
        ({"cinnabar": "much", "water": 0.5}, "part of cinnabar is 'much'"),
    ):
        strokes = recording(tmp_path / "bad.jsonl", "cinnabar", parts=parts)
        told = ["replay", str(strokes), "--on", "plane", "--out", str(tmp_path / "a.ply")]
        assert main.main(told) == 2
        assert fault in capsys.readouterr().err
    assert not asked


def test_a_trial_of_a_study_names_no_table(table, tmp_path):
    path, asked = table
    plan = make_plan(1, character="一", on="plane")
    recording(tmp_path / "P01-I-1.jsonl", f"{path}:mine")
    measured = evaluate(tmp_path, plan)
    assert not asked
    assert "of a table on this machine" in str(measured.faulty) + str(measured.measured)


@pytest.mark.parametrize("key", ["ink", "inks", "dipped"])
def test_a_session_names_no_table(table, tmp_path, key):
    path, asked = table
    name = f"{path}:mine"
    surface = PaintedSurface(load_mesh("plane"), resolution=20.0)
    settings = {"ink": name} if key == "ink" else {key: {name: 1.0}}
    if key == "inks":
        settings = {"inks": [{name: 1.0}, {"cinnabar": 1.0}]}
    saved = tmp_path / "a.p3d"
    save_session(Session(surface, (), settings), saved)
    with pytest.raises(SessionError, match="of a table on this machine"):
        Document.open(saved)
    assert not asked


def test_outlines_are_written_in_an_ink_of_the_users_own(table, tmp_path):
    path, _ = table
    out = tmp_path / "one.svg"
    told = ["write", "一", "--on", "plane", "--out", str(out), "--ink", f"{path}:mine"]
    assert main.main([*told, "--processes", "1", "--quiet"]) == 0
    assert out.read_text().count("<path") == 1
