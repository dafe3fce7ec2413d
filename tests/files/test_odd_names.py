"""Names that are no UTF-8, and names that no text format holds: files, materials, objects."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest
import trimesh

from paint3d.app.model.studies.plan import load_plan, make_plan, save_plan
from paint3d.cli import main
from paint3d.cli.results import PaintingResult, write_report
from paint3d.colour.materials import load_material
from paint3d.files.export import EXPORT_SUFFIXES, export
from paint3d.files.load import load_mesh
from paint3d.files.project.session import Session, load_session, save_session
from paint3d.surface.painted_surface import PaintedSurface

NO_UTF8 = os.fsdecode(b"\xff\xfe\xe5")
ODD = ("\ud800", "\x01", "a\x00b", NO_UTF8, "\x1b[31m\x9b\ufffe\uffff", '"]]>&<\n')
ON_DISK = tuple(s for s in EXPORT_SUFFIXES if s != ".png")  # no picture says a name


def named(material: str) -> PaintedSurface:
    material = replace(load_material("porcelain"), name=material)
    return PaintedSurface(load_mesh("plane"), resolution=30.0, material=material)


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    file = tmp_path / f"{NO_UTF8}.p3d"
    save_session(Session(named("porcelain")), file)
    return file


@pytest.mark.parametrize("suffix", ON_DISK)
@pytest.mark.parametrize("material", ODD)
def test_any_material_in_any_format(tmp_path, suffix, material) -> None:
    path = tmp_path / f"{NO_UTF8}{suffix}"
    export(named(material), path)
    data = path.read_bytes()
    if suffix in (".obj", ".html", ".p3d.txt"):
        text = data.decode("utf-8")
        assert not any(c < " " and c not in "\n\r\t" for c in text)
    if suffix == ".3mf":
        with zipfile.ZipFile(path) as package:
            root = ElementTree.fromstring(package.read("3D/3dmodel.model"))
        assert len(list(root.iter())) > 10
    if suffix == ".glb":
        text = data[20 : 20 + int.from_bytes(data[12:16], "little")].decode("utf-8")
        name = json.loads(text)["materials"][0]["name"]
        assert name.encode("utf-8").decode("utf-8") == name
        assert all(c >= " " for c in name)
    if suffix in (".glb", ".3mf", ".obj", ".ply"):
        file_type = suffix.removeprefix(".")
        with open(path, "rb") as file:
            assert trimesh.load(file, file_type=file_type).bounds is not None


@pytest.mark.parametrize("material", ODD)
def test_a_session_with_any_material_is_saved_again_and_exported(tmp_path, material) -> None:
    first, second = tmp_path / "a.p3d", tmp_path / "b.p3d"
    save_session(Session(named(material)), first)
    assert main.main(["export", str(first), str(second), "--quiet"]) == 0
    assert load_session(second).surface.material.name == material
    assert main.main(["export", str(second), str(tmp_path / "b.3mf"), "--quiet"]) == 0


@pytest.mark.parametrize("encoding", ["utf-8", "gbk", "ascii"])
def test_names_are_told_as_the_bytes_they_are(saved, encoding) -> None:
    out = saved.with_name(NO_UTF8 + "碗.html")
    environment = {**os.environ, "PYTHONIOENCODING": f"{encoding}:strict", "PYTHONUTF8": "0"}
    command = [sys.executable, "-m", "paint3d", "export", saved, out, "--view-only"]
    done = subprocess.run(command, capture_output=True, env=environment, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"\xff\xfe\xe5" in done.stdout
    assert out.is_file()


def test_mesh_recording_and_report_of_any_name(tmp_path, capsys) -> None:
    mesh = tmp_path / f"{NO_UTF8}.obj"
    mesh.write_text("v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n")
    found = load_mesh(mesh)
    assert found.name == NO_UTF8
    surface = PaintedSurface(found, resolution=3.0)
    file = tmp_path / f"{NO_UTF8}.json"
    write_report(
        file, PaintingResult(surface, {"object": found.name, "samples": 0}, {"paint": 0.0})
    )
    assert json.loads(file.read_text("utf-8"))["object"] == NO_UTF8
    missing = str(tmp_path / f"{NO_UTF8} no.jsonl")
    told = ["replay", missing, "--on", str(mesh), "--out", str(tmp_path / "a.ply")]
    assert main.main(told) == 2
    assert "there is no such file" in capsys.readouterr().err


def test_a_study_on_an_object_of_any_name(tmp_path) -> None:
    plan = make_plan(2, ("I", "II"), "目", NO_UTF8, 30.0, 1, 0)
    save_plan(plan, tmp_path)
    assert load_plan(tmp_path).object == NO_UTF8
