"""What the papers describe is reached by commands: each option of docs/papers.md acts."""

from __future__ import annotations

import dataclasses
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from paint3d.brush.presets import load_brush
from paint3d.cli.main import main
from paint3d.core.quaternion import matrices_from_quaternions
from paint3d.files.project.session import load_session
from paint3d.recording.recording import load_recording
from paint3d.surface.painted_surface import PaintedSurface

SIZE = ("--size", "30", "--resolution", "1", "--quiet", "--force")


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def written(*options: str, on: str = "plane", text: str = "一") -> PaintedSurface:
    """What `paint3d write` leaves."""
    assert main(["write", text, "--on", on, "--out", "a.p3d", *SIZE, *options]) == 0
    return load_session("a.p3d").surface


def places(surface: PaintedSurface, least: float = 0.0) -> np.ndarray:
    """(N, 3) vertices that are covered by more than this, mm."""
    ids = np.flatnonzero(surface.coverage > least)
    return surface.paint_mesh.vertices[ids].astype(float)


def ink(surface: PaintedSurface) -> float:
    """All ink on it, coats times vertices."""
    return float(surface.amounts.sum())


def width(surface: PaintedSurface) -> float:
    """How wide a horizontal stroke is, mm: in the middle 10 mm, in the mean."""
    points = places(surface, 0.5)
    middle = points[np.abs(points[:, 0] - np.median(points[:, 0])) < 5.0]
    columns = [middle[np.abs(middle[:, 0] - x) < 1.0] for x in np.unique(middle[:, 0])]
    return float(np.mean([np.ptp(column[:, 1]) for column in columns]))


@cache
def covered_by_brush(line: str) -> np.ndarray:
    """Coverage of what is written with a brush of one's own, which a line makes another."""
    Path("mine.toml").write_text(f'base = "full"\n{line}', encoding="utf-8")
    return written("--brush", "mine.toml").coverage


@pytest.mark.parametrize(
    "change",
    [
        {"n_segments": 13}, {"tip_segment_mm": 1.4}, {"hardness": 0.4}, {"friction": 0.3},
        {"spread_by_pressure": 1.8}, {"root_diameter_mm": 6.0},
    ],
    ids=str,
)  # fmt: skip
def test_a_brush_file_writes_otherwise(change: dict[str, float]) -> None:
    ((name, value),) = change.items()
    marks = covered_by_brush(""), covered_by_brush(f"{name} = {value}\n")
    assert marks[0].shape != marks[1].shape or not np.array_equal(*marks)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("n_segments = 14", "n_segments"), ("n_segments = 7", "n_segments"),
        ("hardness = 9", "hardness"), ("[bristles]\nn_hairs = 20000", "n_hairs"),
    ],
)  # fmt: skip
def test_a_brush_file_out_of_range_is_one_line(line: str, told: str, capsys) -> None:
    Path("mine.toml").write_text(f'base = "full"\n{line}\n', encoding="utf-8")
    assert main(["write", "一", "--on", "plane", "--out", "a.p3d", "--brush", "mine.toml"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("paint3d: error: mine.toml")
    assert told in said
    assert said.count("\n") == 1
    assert not Path("a.p3d").exists()


def test_what_is_shown_of_a_brush_is_the_brush(capsys) -> None:
    for name in ("full", "slender"):
        assert main(["brushes", "show", name]) == 0
        Path("mine.toml").write_text(capsys.readouterr().out, encoding="utf-8")
        mine = dataclasses.replace(load_brush("mine.toml"), name=name)
        assert mine == load_brush(name)


def test_ranges_are_told_with_every_parameter(capsys) -> None:
    assert main(["brushes", "show", "full"]) == 0
    lines = capsys.readouterr().out.splitlines()
    (segments,) = [line for line in lines if line.startswith("n_segments")]
    assert "8 to 13" in segments
    numbers = [line for line in lines if " = " in line and line.split(" = ")[1][0].isdigit()]
    assert len(numbers) > 10
    assert all(" to " in line for line in numbers)


def test_the_technique_is_how_the_tip_is_held() -> None:
    """The tip points along the way, across it, or between: by the pose that is planned."""
    along, marks = {}, {}
    for name in ("zhongfeng", "cefeng", "pianfeng"):
        marks[name] = ink(written("--technique", name, "--recording", "a.jsonl", "--brush", "full"))
        hand = load_recording("a.jsonl")
        bend = matrices_from_quaternions(hand.orientation)[:, :2, 0]
        way = np.gradient(hand.position[:, :2], axis=0)
        fast = (hand.pressure > 0.0) & (np.abs(way[:, 0]) > 0.5 * np.abs(way[:, 0]).max())
        bend, way = bend[fast], way[fast]
        lengths = np.linalg.norm(bend, axis=1) * np.linalg.norm(way, axis=1)
        along[name] = np.degrees(np.arccos(np.abs(np.sum(bend * way, axis=1)) / lengths)).mean()
    assert along["zhongfeng"] < 25.0 < along["cefeng"] < 65.0 < along["pianfeng"]
    assert len(set(marks.values())) == 3


def test_the_azimuth_is_commanded_or_dragged() -> None:
    commanded, dragged = (written("--azimuth", one, text="乙") for one in ("commanded", "dragged"))
    apart = places(commanded).shape != places(dragged).shape
    assert apart or not np.allclose(places(commanded), places(dragged))


def test_inside_a_bowl_the_paint_lies_inside() -> None:
    sides = {}
    for side in ("inside", "outside"):
        surface = written("--side", side, on="bowl")
        ids = np.flatnonzero(surface.coverage > 0.0)
        normals = surface.paint_mesh.normals[ids].astype(float)
        outward = places(surface) * (1.0, 1.0, 0.0)
        sides[side] = float(np.sum(normals * outward, axis=1).mean())
    assert sides["inside"] < 0.0 < sides["outside"]


def test_single_hairs_paint_about_as_wide_as_the_solid_tuft() -> None:
    solid, hairs = (written("--hairs", n) for n in ("0", "300"))
    assert width(hairs) == pytest.approx(width(solid), rel=0.25)
    marks = solid.coverage, hairs.coverage
    assert marks[0].shape != marks[1].shape or not np.array_equal(*marks)


def dark(surface: PaintedSurface) -> int:
    """Vertices that look painted."""
    return int((surface.srgb[:, 1] < 200).sum())


def test_ink_that_spreads_runs_and_dries() -> None:
    sheet = ("--material", "xuan", "--resolution", "0.6")
    dry, wet = (written(*sheet, *more) for more in ((), ("--spread", "20")))
    assert dark(wet) > 1.04 * dark(dry)
    assert wet.dry_ink() > 0.0 == dry.dry_ink()


def test_a_replay_spreads_and_takes_up_ink_where_it_is_asked_to() -> None:
    written("--recording", "a.jsonl", text="十")
    kept = {}
    for name, options in (
        ("plain", ()), ("spread", ("--spread", "20")), ("pickup", ("--pickup", "0.5")),
    ):  # fmt: skip
        words = ["replay", "a.jsonl", "--on", "plane", "--material", "xuan", "--out", "b.p3d"]
        assert main([*words, "--resolution", "0.6", "--quiet", "--force", *options]) == 0
        kept[name] = load_session("b.p3d").surface
    assert dark(kept["spread"]) > 1.04 * dark(kept["plain"])
    assert ink(kept["pickup"]) < ink(kept["plain"])  # what lay there is in the brush again
    assert float(kept["pickup"].ink.transfer["pickup"].item()) == 0.5


@pytest.mark.parametrize("number", ["friction", "absorbency"])
def test_a_material_of_ones_own_acts(number: str, capsys) -> None:
    assert main(["materials", "show", "bisque"]) == 0
    assert f"\n{number} = " in capsys.readouterr().out
    marks = []
    for value in ("0.3", "0.9"):
        text = f'base = "bisque"\n{number} = {value}\n'
        Path("mine.toml").write_text(text, encoding="utf-8")
        marks.append(ink(written("--material", "mine.toml")))
    assert marks[0] != marks[1]


def test_the_papers_records_are_exported_and_written_on() -> None:
    written()
    assert main(["export", "a.p3d", "a.p3d.txt", "--quiet"]) == 0
    again = written("--at", "0.8,0.2", on="a.p3d.txt")
    under = np.abs(again.paint_mesh.vertices[:, :2]).max(axis=1) < 5.0
    assert (again.srgb[under].min(axis=1) < 60).any()  # what was painted before is its ground
    assert np.abs(places(again)[:, :2]).max() > 20.0
