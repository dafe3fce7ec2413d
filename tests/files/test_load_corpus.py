"""Mesh files by many programs, good and bad: each must do what the corpus' manifest says."""

import csv
from pathlib import Path

import numpy as np
import pytest

from paint3d.errors import MeshError
from paint3d.files.load import load_mesh
from paint3d.files.reading import read_surface
from paint3d.surface.painted_surface import PaintedSurface

CORPUS = Path(__file__).parents[2] / "../shared/corpus"
# Its only triangle has three corners on one line: it can be loaded, but not painted.
WITHOUT_AREA = "assimp/number_formats.obj"
ISOLATED = (  # read in a child process too, with what must come of it
    "trimesh/cubevc.glb",
    "trimesh/empty.obj",
    "assimp/spider.obj",
    "3mf/pyramid_vertexcolor.3mf",
    "derived/featuretype_hugecount.STL",
)


def rows():
    manifest = CORPUS / "MANIFEST.csv"
    if not manifest.is_file():
        return []
    with open(manifest, encoding="utf-8", newline="") as file:
        return [(row["file"], row["expect"]) for row in csv.DictReader(file)]


def outcome(path):
    """Return the mesh and an empty message, or None and the message."""
    try:
        return read_surface(path).mesh, ""
    except MeshError as cause:
        return None, str(cause)


@pytest.mark.skipif(not rows(), reason="the corpus of meshes is not here")
@pytest.mark.parametrize(("name", "expect"), rows())
def test_the_manifest_is_met(name, expect):
    mesh, message = outcome(CORPUS / name)
    if mesh is None:
        assert "error" in expect
        assert message.startswith(f"{CORPUS / name}: ")
        assert "\n" not in message
    else:
        assert expect.startswith("loads")
        assert np.isfinite(mesh.vertices).all()
        assert 0 <= mesh.faces.min() <= mesh.faces.max() < mesh.n_vertices
        assert (mesh.area > 0) == (name != WITHOUT_AREA)


@pytest.mark.skipif(not rows(), reason="the corpus of meshes is not here")
def test_a_surface_without_area_is_loaded_and_not_painted():
    with pytest.raises(MeshError, match="number_formats: none of 1 faces has an area"):
        PaintedSurface(read_surface(CORPUS / WITHOUT_AREA).mesh)


@pytest.mark.skipif(not rows(), reason="the corpus of meshes is not here")
@pytest.mark.parametrize("name", ISOLATED)
def test_the_child_process_reads_what_its_parent_would(name):
    mesh, message = outcome(CORPUS / name)
    if mesh is None:
        with pytest.raises(MeshError) as caught:
            load_mesh(CORPUS / name)
        assert str(caught.value) == message
        return
    apart = load_mesh(CORPUS / name)
    for array in ("vertices", "faces", "colours", "normals"):
        np.testing.assert_array_equal(getattr(apart, array), getattr(mesh, array))
    assert apart.name == mesh.name


# Areas as other programs agree on them (mm2 as numbers in the file).
AREAS = {
    "trimesh/negative_indices.obj": 24.0,
    "assimp/Cube.off": 6.0,
    "draco/testdata/cube_quads.ply": 6.0,
    "assimp/cube_binary_starts_with_nl.ply": 6.0,
    "stl/stl_binary/CubeInvalidUnicode.stl": 24.0,
    "tinyobj/issue-295-trianguation-failure.obj": 14.0,
}


@pytest.mark.skipif(not rows(), reason="the corpus of meshes is not here")
@pytest.mark.parametrize("name", AREAS)
def test_known_areas(name):
    assert read_surface(CORPUS / name).mesh.area == pytest.approx(AREAS[name], rel=1e-5)


@pytest.mark.skipif(not rows(), reason="the corpus of meshes is not here")
def test_three_spellings_of_one_shelf_agree():
    names = ("platonic_shelf", "platonic_shelf_ascii", "platonic_shelf_big_endian")
    shelves = [read_surface(CORPUS / f"happly/{name}.ply").mesh for name in names]
    assert len({mesh.faces.tobytes() for mesh in shelves}) == 1
    assert [mesh.area for mesh in shelves] == pytest.approx([shelves[0].area] * 3, rel=1e-5)
