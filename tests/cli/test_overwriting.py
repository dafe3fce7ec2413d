"""What a command reads from, it writes over only with --force, under whatever name it is given."""

from __future__ import annotations

import csv
import gzip
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from paint3d.app.model.studies.plan import make_plan, save_plan
from paint3d.cli import main
from paint3d.cli.batches.table import read_table
from paint3d.files.load import load_mesh
from paint3d.files.project.session import Session, save_session
from paint3d.files.references import refers_to
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.cases import long_but

SQUARE = "v -30 -30 0\nv 30 -30 0\nv 30 30 0\nv -30 30 0\nf 1 2 3 4\n"
HEADER = {"format": "paint3d-recording", "version": 1, "brush": "full", "ink": "pine soot"}


@pytest.fixture
def square(tmp_path: Path) -> Path:
    file = tmp_path / "square.obj"
    file.write_text(SQUARE)
    return file


@pytest.fixture
def strokes(tmp_path: Path) -> Path:
    file = tmp_path / "strokes.jsonl"
    lines = [HEADER]
    for i in range(20):
        lines.append(
            {
                "time_ns": i * 10_000_000,
                "position": [2.0 * i - 20.0, 0.0, 30.0],
                "orientation": [1.0, 0.0, 0.0, 0.0],
                "pressure": 0.2 if 0 < i < 19 else 0.0,
            }
        )
    file.write_text("".join(json.dumps(line) + "\n" for line in lines))
    return file


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """Run a command that is to be refused for what it would replace; return the one line."""
    assert main.main([str(word) for word in arguments]) == 2
    said = capsys.readouterr().err
    assert said.startswith("paint3d: error: ")
    assert said.count("\n") == 1
    return said


def other_names(file: Path) -> list[Path]:
    """Other paths to the same file: round about, by a symbolic link, by a hard link."""
    soft, hard = file.with_name("soft" + file.suffix), file.with_name("hard" + file.suffix)
    soft.symlink_to(file)
    os.link(file, hard)
    return [file, file.parent / ".." / file.parent.name / file.name, soft, hard]


def test_a_replay_does_not_replace_its_object(square, strokes, capsys) -> None:
    for out in other_names(square):
        said = refused(capsys, "replay", strokes, "--on", square, "--out", out)
        assert f"{out} would be replaced, and {square} is read from it" in said
        assert "--force" in said
    assert square.read_text() == SQUARE
    said = refused(capsys, "replay", strokes, "--on", square.parent / "soft.obj", "--out", square)
    assert f"{square} would be replaced" in said


def test_with_force_it_does_and_a_link_stays_one(square, strokes, tmp_path, capsys) -> None:
    link = tmp_path / "link.obj"
    link.symlink_to(square)
    told = ["replay", strokes, "--on", square, "--out", link, "--force", "--quiet"]
    assert main.main([str(word) for word in told]) == 0
    assert link.is_symlink()
    assert square.read_text() != SQUARE
    assert load_mesh(square).colours.min() < 100  # painted


def test_writing_does_not_replace_its_object(square, capsys) -> None:
    assert "would be replaced" in refused(capsys, "write", "一", "--on", square, "--out", square)


def test_results_do_not_replace_a_table_of_inks(tmp_path, capsys) -> None:
    table = tmp_path / "inks.csv"
    table.write_text("name\n")
    told = ("write", "一", "--on", "plane", "--out", tmp_path / "o.ply", "--recording", table)
    assert f"{table} is read from it" in refused(capsys, *told, "--ink", f"{table}:mine")
    assert table.read_text() == "name\n"


def pictured(folder: Path, kind: str) -> tuple[Path, Path]:
    """A mesh file of one square, and the picture that it refers to."""
    (folder / "looks").mkdir()
    picture = folder / "looks" / "a b.png"
    Image.fromarray(np.zeros((2, 2, 3), np.uint8)).save(picture)
    mesh = folder / f"square.{kind}"
    if kind == "obj":
        mesh.write_text(f"mtllib its own.mtl\nusemtl a\n{SQUARE}")
        told = "newmtl a\nKd 1 1 1\nmap_Kd -o 0 0 0 -clamp on looks\\a b.png\n"
        (folder / "its own.mtl").write_text(told)
    elif kind == "ply":
        rows = SQUARE.replace("v ", "").replace("f 1 2 3 4", "4 0 1 2 3")
        mesh.write_text(
            "ply\nformat ascii 1.0\ncomment TextureFile looks/a b.png\nelement vertex 4\n"
            "property float x\nproperty float y\nproperty float z\nelement face 1\n"
            f"property list uchar int vertex_indices\nend_header\n{rows}"
        )
    else:
        corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")
        (folder / "looks" / "a.bin.ply").write_bytes(corners.tobytes())
        view = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}
        document = {
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [view],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "buffers": [{"byteLength": 36, "uri": "looks/a.bin.ply"}],
            "images": [{"uri": "looks/a%20b.png"}, {"uri": "data:,"}],
        }
        mesh.write_text(json.dumps(document))
    return mesh, picture


@pytest.mark.parametrize("kind", ["obj", "ply", "gltf"])
def test_what_the_object_refers_to_is_not_replaced(kind, strokes, tmp_path, capsys) -> None:
    mesh, picture = pictured(tmp_path, kind)
    before = picture.read_bytes()
    soft = tmp_path / "soft.png"
    soft.symlink_to(picture)
    for out in (picture, soft, tmp_path / "looks" / ".." / "looks" / "a b.png"):
        said = refused(capsys, "replay", strokes, "--on", mesh, "--out", out)
        assert f"{out} would be replaced, and {mesh} refers to it" in said
        assert "--force" in said
        assert "refers to it" in refused(capsys, "write", "一", "--on", mesh, "--out", out)
    assert picture.read_bytes() == before
    if kind == "gltf":
        buffer = tmp_path / "looks" / "a.bin.ply"
        assert "refers to it" in refused(capsys, "write", "一", "--on", mesh, "--out", buffer)
    other = tmp_path / "looks" / "b.png"  # in the same folder, but nobody speaks of it
    other.write_bytes(before)
    assert not refers_to(mesh, other)
    assert refers_to(mesh, picture)


def test_who_speaks_of_a_file_may_be_packed_or_damaged(tmp_path) -> None:
    mesh, picture = pictured(tmp_path, "obj")
    packed = tmp_path / "packed.obj.gz"
    packed.write_bytes(gzip.compress(mesh.read_bytes()))
    assert refers_to(packed, picture)
    assert refers_to(packed, tmp_path / "its own.mtl")
    for kind, content in {"gltf": b'{"images": [3]}', "obj": b"mtllib \0\n", "ply": b""}.items():
        broken = tmp_path / f"broken.{kind}"
        broken.write_bytes(content)
        assert not refers_to(broken, picture)
    assert not refers_to(tmp_path / "none.obj", picture)
    elsewhere = tmp_path / "looks" / "in.obj"
    elsewhere.write_text("mtllib ../its own.mtl\n")  # outside its folder: never read
    assert not refers_to(elsewhere, tmp_path / "its own.mtl")


MOST_MB = 200  # of the program itself; what the packed file holds is as much

WATCHED = """
import sys
from paint3d.cli import main
status = main.main(sys.argv[1:])
with open("/proc/self/status") as told:
    highest = next(line for line in told if line.startswith("VmHWM"))
print(status, int(highest.split()[1]) // 1024)
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is not told here")
@pytest.mark.parametrize("kind", long_but(["obj"], ["obj", "ply"]))
def test_a_mesh_that_unpacks_to_much_takes_no_memory_of_the_program(strokes, tmp_path, kind):
    packed = tmp_path / f"bomb.{kind}.gz"
    with gzip.open(packed, "wb", compresslevel=1) as file:
        for _ in range(20):
            file.write(bytes(10 << 20))
    out = tmp_path / "there.ply"
    out.write_text("it is in the mesh's folder")
    told = [
        sys.executable,
        "-c",
        WATCHED,
        "replay",
        strokes,
        "--on",
        packed,
        "--out",
        out,
        "--quiet",
    ]
    done = subprocess.run(list(map(str, told)), capture_output=True, text=True, check=False)
    status, highest = map(int, done.stdout.split())
    assert status == 2
    assert f"{packed}: " in done.stderr  # refused by who reads it
    assert highest < MOST_MB
    assert out.read_text() == "it is in the mesh's folder"


@pytest.mark.usefixtures("small_pictures")
def test_with_force_a_picture_is_replaced(strokes, tmp_path) -> None:
    mesh, picture = pictured(tmp_path, "obj")
    before = picture.read_bytes()
    told = ["replay", strokes, "--on", mesh, "--out", picture, "--force", "--quiet"]
    assert main.main([str(word) for word in told]) == 0
    assert picture.read_bytes() != before


def test_two_results_are_two_files(strokes, tmp_path, capsys) -> None:
    out, report = tmp_path / "o.ply", tmp_path / "report.json"
    report.symlink_to(out)
    told = ("replay", strokes, "--on", "plane", "--out", out, "--report", report, "--force")
    assert f"{report} is {out}; expected a file for each" in refused(capsys, *told)


def test_an_export_does_not_replace_its_session(square, tmp_path, capsys) -> None:
    saved = tmp_path / "saved.p3d"
    save_session(Session(PaintedSurface(load_mesh(square), resolution=2.0)), saved)
    before = saved.read_bytes()
    for out in other_names(saved):
        assert "would be replaced" in refused(capsys, "export", saved, out)
    assert saved.read_bytes() == before
    assert main.main(["export", str(saved), str(saved), "--force", "--quiet"]) == 0


def test_a_study_does_not_replace_its_plan(tmp_path, capsys) -> None:
    save_plan(make_plan(2, ("I", "II"), "目", "bowl", 30.0, 1, 0), tmp_path)
    said = refused(capsys, "study", "table", tmp_path, "--json", tmp_path / "study.json")
    assert "would be replaced" in said


def test_a_device_recording_does_not_replace_its_calibration(tmp_path, capsys) -> None:
    known = tmp_path / "known.json"
    known.write_text("{}")
    told = ("devices", "record", tmp_path / "r.jsonl", "--raw", known, "--calibration", known)
    assert "would be replaced" in refused(capsys, *told)


def test_a_table_of_paintings_can_ask_for_it(square, strokes, tmp_path, capsys) -> None:
    table = tmp_path / "table.csv"
    with open(table, "w", encoding="utf-8", newline="") as file:
        row = csv.writer(file)
        row.writerow(("recording", "object", "output", "force"))
        row.writerow((strokes, square, square, "no"))
    assert "1 of 1 rows failed" in refused_rows(capsys, table)
    table.write_text(table.read_text().replace(",no", ",yes"))
    rows, others = read_table(table)
    assert (len(rows), others) == (1, [])
    assert "--force" in rows[0].arguments


def refused_rows(capsys: pytest.CaptureFixture[str], table: Path) -> str:
    assert main.main(["batch", str(table), "--processes", "1", "--quiet"]) == 2
    said = capsys.readouterr().err
    assert "would be replaced" in said
    return said
