"""Mesh files by many programs, good and bad: each must do what the corpus' manifest says."""

import csv
from pathlib import Path

import pytest

from paint3d.errors import MeshError
from paint3d.files.load import load_mesh

CORPUS = Path(__file__).parents[2] / "../shared/corpus"
# Its only triangle has three corners on one line; we refuse objects without any area.
WITHOUT_AREA = "assimp/number_formats.obj"


def rows():
    manifest = CORPUS / "MANIFEST.csv"
    if not manifest.is_file():
        return []
    with open(manifest, encoding="utf-8", newline="") as file:
        return [(row["file"], row["expect"]) for row in csv.DictReader(file)]


def outcome(path):
    """Return the mesh and an empty message, or None and the message."""
    try:
        return load_mesh(path), ""
    except MeshError as cause:
        return None, str(cause)


@pytest.mark.skipif(not rows(), reason="the corpus of meshes is not here")
@pytest.mark.parametrize(("name", "expect"), rows())
def test_the_manifest_is_met(name, expect):
    mesh, message = outcome(CORPUS / name)
    if mesh is None:
        assert "error" in expect or name == WITHOUT_AREA
        assert message.startswith(f"{CORPUS / name}: ")
        assert "\n" not in message
    else:
        assert expect.startswith("loads")
        assert mesh.area > 0


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
    assert load_mesh(CORPUS / name).area == pytest.approx(AREAS[name], rel=1e-5)


@pytest.mark.skipif(not rows(), reason="the corpus of meshes is not here")
def test_three_spellings_of_one_shelf_agree():
    names = ("platonic_shelf", "platonic_shelf_ascii", "platonic_shelf_big_endian")
    shelves = [load_mesh(CORPUS / f"happly/{name}.ply") for name in names]
    assert len({mesh.faces.tobytes() for mesh in shelves}) == 1
    assert [mesh.area for mesh in shelves] == pytest.approx([shelves[0].area] * 3, rel=1e-5)
