"""`paint3d replay` of robots' logs: what differs from a pen's poses is said, or painted right."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import paint3d
from paint3d.cli.main import main
from paint3d.errors import RecordingError
from paint3d.painter.flat_input import lay_at
from paint3d.painter.stroke_table import BrushState, StrokeTable

UP, DOWN = "0,0,0,1", "1,0,0,0"
POSE = "qx,qy,qz,qw"


def log(
    columns: str,
    quaternion: str = UP,
    *,
    to_mm: float = 1.0,
    height: float = 0.0,
    middle: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> str:
    """A log of two strokes of 20 mm on a plane with a way through the air, as `robot.csv`."""
    lines = [f"time,{columns}"]
    for k in range(60):
        in_air = 20 <= k < 40  # on the way back
        x = 9.0 - k % 20 if in_air else k % 20 - 10.0
        lifted, force = (20.0, 0.0) if in_air else (0.0, 1.5)
        place = np.array([x, 5.0 * (k >= 20), height + lifted]) + middle
        cells = [0.02 * k, *(place / to_mm).round(7)]
        lines.append(",".join(map(str, cells)) + f",{quaternion},{force}")
    Path("robot.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return "robot.csv"


def painted(capsys: pytest.CaptureFixture[str], file: str, *more: str) -> tuple[int, str]:
    """The exit status and all that is said."""
    on = ("--on", "plane", "--resolution", "2", "--force", "--stroke-table", "table.csv")
    status = main(["replay", file, *on, "--out", "a.p3d", *more])
    return status, capsys.readouterr().err


def lengths() -> list[float]:
    with open("table.csv", encoding="utf-8", newline="") as table:
        return [float(row["length_mm"]) for row in csv.DictReader(table)]


@pytest.fixture(autouse=True)
def _alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_log_of_tips_with_a_tool_frame_is_painted_where_it_was(capsys) -> None:
    columns = "tip_x_m,tip_y_m,tip_z_m,tool_qx,tool_qy,tool_qz,tool_qw,fz"
    status, said = painted(capsys, log(columns, DOWN, to_mm=1000.0))
    assert (status, said) == (0, "")
    assert lengths() == pytest.approx([19.0, 19.0], abs=3.5)  # it slides where it comes down


def test_a_handle_that_points_into_the_surface_is_refused_with_the_cure(capsys) -> None:
    status, said = painted(capsys, log(f"x_mm,y_mm,z_mm,{POSE},fz", DOWN, height=35.0))
    assert status == 2
    assert "robot.csv: in 100% of the samples near the surface the handle points into it" in said
    assert "tool_qw, tool_qx, tool_qy, tool_qz" in said
    assert not Path("a.p3d").exists()


def test_a_ferrule_at_the_surface_asks_whether_it_is_the_tip(capsys) -> None:
    file = log(f"x_mm,y_mm,z_mm,{POSE},fz")
    status, said = painted(capsys, file)
    assert status == 0
    assert said.count("if the tip was logged") == 1
    assert main(["replay", file, "--on", "a.p3d", "--out", "b.p3d"]) == 0  # by steps
    assert capsys.readouterr().err.count("if the tip was logged") == 1
    status, said = painted(capsys, log(f"x_mm,y_mm,z_mm,{POSE},fz", height=32.0))
    assert (status, said) == (0, "")


def test_places_in_a_robots_base_frame_are_asked_about_and_carried(capsys) -> None:
    base = (0.0, 0.0, 400.0)
    columns = f"x_mm,y_mm,z_mm,{POSE},fz"
    status, said = painted(capsys, log(columns, height=32.0, middle=base))
    assert status == 0
    assert "the brush is 432 mm from the object where it presses" in said
    file = Path(log(columns, height=32.0, middle=base))
    names, *rows = file.read_text(encoding="utf-8").splitlines()
    with_object = [f"{names},object_x_cm,object_y_cm,object_z_cm", *(f"{r},0,0,40" for r in rows)]
    file.write_text("\n".join(with_object) + "\n", encoding="utf-8")
    assert painted(capsys, str(file)) == (0, "")


def test_a_replay_that_paints_no_vertex_is_refused(capsys) -> None:
    file = log(f"x_m,y_m,z_m,{POSE},fz", to_mm=1e6, height=34.999)  # a way of 20 um, hardly there
    text = Path(file).read_text(encoding="utf-8").replace(",1.5", ",0.001")
    Path(file).write_text(text, encoding="utf-8")
    status, said = painted(capsys, file, "--resolution", "10")
    assert status == 2, said
    assert "paints no vertex of it" in said
    assert not Path("a.p3d").exists()


def test_a_table_has_no_row_without_a_footprint() -> None:
    table = StrokeTable()
    before = BrushState(False, 0.0, 0.0, 9.0, footprints=0, contacts=0)
    table.begin(0, 0.1, before)
    for k, (footprints, contacts) in enumerate([(0, 1), (0, 1), (0, 2), (3, 3), (3, 3)], 1):
        touches = k in (1, 3, 4)
        state = before._replace(touches=touches, footprints=footprints, contacts=contacts)
        table.add(k * 100_000_000, 0.1, state)
    assert [(row.stroke, row.start_s, row.footprints) for row in table.rows] == [(1, 0.2, 3)]


def test_in_python_a_tip_is_that_of_the_painters_brush() -> None:
    columns = f"tip_x_mm,tip_y_mm,tip_z_mm,{POSE},fx"
    recording = paint3d.load_recording(log(columns, height=-3.0))
    widths = []
    for brush in ("full", "slender"):
        surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=1.0)
        painter = paint3d.Painter(surface, brush)
        painter.replay(recording)
        widths.append(int(surface.painted.sum()))
    assert min(widths) > 20, widths


def test_in_python_a_pad_says_how_to_lay_it() -> None:
    Path("pad.csv").write_text("time,x_mm,y_mm,pressure\n0,0,0,.3\n.2,9,0,.5\n.4,20,0,.2\n")
    recording, mesh = paint3d.load_recording("pad.csv"), paint3d.load_mesh("plane")
    surface = paint3d.PaintedSurface(mesh, resolution=1.0)
    painter = paint3d.Painter(surface)
    with pytest.raises(RecordingError, match=r"painter\.replay\(lay_at\(recording, mesh"):
        painter.replay(recording)
    table = paint3d.StrokeTable()
    painter.replay(lay_at(recording, mesh, (0.5, 0.5), width_mm=60), table=table)
    assert [row.length_mm for row in table.rows] == pytest.approx([60.0], abs=2.0)


def test_in_python_doubts_are_logged(caplog: pytest.LogCaptureFixture) -> None:
    recording = paint3d.load_recording(log(f"x_mm,y_mm,z_mm,{POSE},fz", DOWN, height=35.0))
    surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=2.0)
    paint3d.Painter(surface).replay(recording)
    assert "the handle points into it" in caplog.text
