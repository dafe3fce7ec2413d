"""Exported files before other people's judges; those that are not installed are passed over."""

import runpy
from pathlib import Path

import numpy as np
import pytest
import trimesh

import paint3d
from paint3d.colour.pigments import load_pigment
from paint3d.mesh.triangle_mesh import TriangleMesh

SCRIPT = runpy.run_path(str(Path(__file__).parents[2] / "scripts" / "validate_exports.py"))
JUDGES = [name for name in SCRIPT["CHECKS"] if name != "chromium"]  # has tests of its own


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A painted box, whose edges have two normals, in every format."""
    pytest.importorskip("xatlas")
    solid = trimesh.creation.box((30.0, 40.0, 50.0)).subdivide()
    mesh = TriangleMesh(np.float32(solid.vertices), np.int32(solid.faces))
    surface = paint3d.PaintedSurface(mesh, resolution=4.0)
    surface.refine_all()
    column = surface.column_of(load_pigment("cinnabar"))
    ids = np.arange(0, surface.n_vertices, 3, dtype=np.int32)
    surface.ink.amounts[ids, column] = np.linspace(0.0, 1.0, len(ids))
    surface.ink.coverage[ids] = 1.0
    surface.touch(ids)
    path = tmp_path_factory.mktemp("exports")
    SCRIPT["write_variants"](surface, path)
    return path


SLOW = {"checker": pytest.mark.long}  # reads all formats anew, as the others do one by one


@pytest.mark.parametrize("judge", [pytest.param(j, marks=SLOW.get(j, ())) for j in JUDGES])
def test_the_judge_finds_nothing(folder, judge):
    try:
        found = SCRIPT["CHECKS"][judge](folder)
    except SCRIPT["MissingToolError"] as missing:
        pytest.skip(f"not here: {missing}")
    assert found == []


def test_the_judges_would_find_something(folder, tmp_path):
    text = (folder / "painting.obj").read_text(encoding="ascii")
    for path in folder.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    first = text.splitlines()[2].split()
    first[4] = str((float(first[4]) + 0.5) % 1.0)
    lines = [*text.splitlines()[:2], " ".join(first), *text.splitlines()[3:]]
    (tmp_path / "painting.obj").write_text("\n".join(lines), encoding="ascii")
    assert SCRIPT["CHECKS"]["readers"](tmp_path) != []
