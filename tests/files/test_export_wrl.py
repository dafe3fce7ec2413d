"""VRML as VTK reads it."""

import numpy as np
import pytest
import trimesh
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImport import vtkVRMLImporter

from paint3d.files.export import export
from paint3d.files.export_options import ExportOptions
from paint3d.mesh.triangle_mesh import TriangleMesh


def ball():
    solid = trimesh.creation.icosphere(subdivisions=2, radius=30.0)
    codes = (np.arange(solid.vertices.size) * 7 % 256).astype(np.uint8).reshape(-1, 3)
    return TriangleMesh(np.float32(solid.vertices), np.int32(solid.faces), codes)


def read_vrml(path):
    importer = vtkVRMLImporter()
    importer.SetFileName(str(path))
    importer.Update()
    actors = importer.GetRenderer().GetActors()
    actors.InitTraversal()
    mapper = actors.GetNextActor().GetMapper()
    mapper.Update()
    return mapper, mapper.GetInput()


def test_vtk_reads_points_triangles_normals_and_colours(tmp_path):
    export(ball(), tmp_path / "a.wrl")
    mapper, solid = read_vrml(tmp_path / "a.wrl")
    wanted = ball()
    x, y, z = wanted.vertices.T / 1000.0
    points = vtk_to_numpy(solid.GetPoints().GetData())
    np.testing.assert_allclose(points, np.stack([x, z, -y], axis=1), rtol=1e-6, atol=1e-9)
    corners = vtk_to_numpy(solid.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    np.testing.assert_array_equal(corners, wanted.faces)
    assert vtk_to_numpy(solid.GetPointData().GetNormals()).shape == points.shape
    table = mapper.GetLookupTable()
    colours = [table.GetTableValue(k)[:3] for k in range(len(points))]
    np.testing.assert_allclose(colours, wanted.colours / 255.0, atol=0.5 / 255.0)


@pytest.mark.parametrize(("unit", "size"), [("mm", 60.0), ("in", 60.0 / 25.4)])
def test_the_unit_is_chosen_and_named(tmp_path, unit, size):
    export(ball(), tmp_path / "a.wrl", ExportOptions(unit=unit, up_axis="z"))
    _, solid = read_vrml(tmp_path / "a.wrl")
    assert np.ptp(vtk_to_numpy(solid.GetPoints().GetData())[:, 2]) == pytest.approx(size)
    text = (tmp_path / "a.wrl").read_text(encoding="utf-8")
    assert text.startswith("#VRML V2.0 utf8\n")
    assert {"mm": "millimetres", "in": "inches"}[unit] in text
