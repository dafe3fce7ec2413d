"""The built-in objects: their shape, their quality, and that the files are what the code makes."""

import hashlib
import math
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh

from paint3d.files.load import BUILT_IN_OBJECTS, load_mesh
from scripts import solids
from scripts.solids import sample_profile, vessel_profile

MESHES = Path(__file__).parents[2] / "meshes"
WALL = [((34.0, 8.5), (63.0, 8.5), (65.0, 43.0), (73.5, 66.5))]
SIZES = {
    "bowl": (150, 150, 68),
    "plate": (220, 220, 26),
    "vase": (260, 260, 600),
    "sphere": (150, 150, 150),
    "plane": (200, 200, 0),
}


@pytest.fixture(params=BUILT_IN_OBJECTS)
def name(request):
    return request.param


def test_the_file_is_what_the_code_makes(name):
    made, loaded = getattr(solids, f"make_{name}")(), load_mesh(name)
    assert loaded.name == name
    np.testing.assert_allclose(loaded.vertices, made.vertices, atol=1e-4)
    np.testing.assert_array_equal(loaded.faces, made.faces)
    np.testing.assert_allclose(loaded.normals, made.normals, atol=1e-6)


def test_the_table_lists_every_file_with_its_checksum():
    rows = re.findall(r"\| (\w+)\.ply \|.*\| ([0-9a-f]{64}) \|", (MESHES / "README.md").read_text())
    assert [row[0] for row in rows] == list(BUILT_IN_OBJECTS)
    for stem, digest in rows:
        assert hashlib.sha256((MESHES / f"{stem}.ply").read_bytes()).hexdigest() == digest


def test_size_and_place(name):
    low, high = load_mesh(name).bounds
    np.testing.assert_allclose(high - low, SIZES[name], atol=0.05)
    np.testing.assert_allclose((high + low)[:2], 0.0, atol=0.05)
    floor = {"sphere": -75.0}.get(name, 0.0)
    assert low[2] == pytest.approx(floor, abs=1e-4)


def test_closed_consistent_and_outward(name):
    mesh = load_mesh(name)
    other = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert other.is_winding_consistent
    assert other.is_watertight == (name != "plane")
    assert name == "plane" or other.volume > 0
    assert other.euler_number == (1 if name == "plane" else 2)


def test_triangles_are_well_shaped_and_normals_agree_with_them(name):
    mesh = load_mesh(name)
    angles = np.degrees(trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).face_angles)
    assert angles.min() > 10.0
    assert np.median(angles.min(axis=1)) > 40.0
    agree = np.einsum("ij,ij->i", mesh.face_normals, mesh.normals[mesh.faces].mean(axis=1))
    assert agree.min() > 0.94
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-6)


def test_known_areas_and_volumes():
    assert load_mesh("plane").area == pytest.approx(40_000.0)
    sphere = load_mesh("sphere")
    assert sphere.area == pytest.approx(4 * math.pi * 75**2, rel=1e-3)
    np.testing.assert_allclose(np.linalg.norm(sphere.vertices, axis=1), 75.0, atol=1e-4)


def test_a_vessel_has_one_wall_thickness():
    points, normals = sample_profile(vessel_profile(WALL, 3.0, 30.5, 7.0), 0.05, 0.02)
    wall = (points[:, 1] > 20.0) & (points[:, 1] < 60.0) & (normals[:, 1] > 0.0)
    through = points[wall] - 3.0 * normals[wall]
    miss = np.linalg.norm(through[:, None] - points[None], axis=2).min(axis=1)
    assert wall.sum() > 500
    assert miss.max() < 0.03  # half the distance of neighbours


def test_a_profile_is_smooth_and_its_normals_are_square_to_it():
    points, normals = sample_profile(vessel_profile(WALL, 3.0, 30.5, 7.0), 0.05, 0.02)
    step = np.diff(points, axis=0)
    step /= np.linalg.norm(step, axis=1, keepdims=True)
    middle = normals[1:] + normals[:-1]
    assert np.abs(np.einsum("ij,ij->i", step, middle)).max() < 0.03
    assert np.einsum("ij,ij->i", step[1:], step[:-1]).min() > 0.99
