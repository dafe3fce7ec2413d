"""USDZ as Pixar's own library reads it, and as its validators judge it."""

import importlib.util
import zipfile

import numpy as np
import pytest
import trimesh

from paint3d.colour.spectra import decode_srgb, srgb_from_linear
from paint3d.errors import ExportError
from paint3d.files.export import check_export_path, export
from paint3d.files.export_options import ExportOptions
from paint3d.mesh.triangle_mesh import TriangleMesh

Usd = pytest.importorskip("pxr.Usd")


def ball():
    solid = trimesh.creation.icosphere(subdivisions=3, radius=30.0)
    codes = (np.arange(solid.vertices.size) * 7 % 256).astype(np.uint8).reshape(-1, 3)
    return TriangleMesh(np.float32(solid.vertices), np.int32(solid.faces), codes)


@pytest.fixture
def stage(tmp_path):
    export(ball(), tmp_path / "a.usdz")
    return Usd.Stage.Open(str(tmp_path / "a.usdz"))


def test_the_mesh_and_its_linear_colours_arrive(stage):
    from pxr import UsdGeom

    mesh, wanted = UsdGeom.Mesh(stage.GetPrimAtPath("/Painting/Mesh")), ball()
    x, y, z = wanted.vertices.T / 1000.0
    points = np.array(mesh.GetPointsAttr().Get())
    np.testing.assert_allclose(points, np.stack([x, z, -y], axis=1), rtol=1e-6, atol=1e-9)
    indices = np.array(mesh.GetFaceVertexIndicesAttr().Get())
    np.testing.assert_array_equal(indices.reshape(-1, 3), wanted.faces)
    colours = np.array(mesh.GetDisplayColorPrimvar().Get())
    np.testing.assert_array_equal(srgb_from_linear(colours), wanted.colours)
    np.testing.assert_allclose(colours, decode_srgb(wanted.colours), rtol=1e-6)
    normals = np.array(mesh.GetNormalsAttr().Get())
    np.testing.assert_allclose(normals, points / 0.03, atol=2e-2)
    assert mesh.GetNormalsInterpolation() == "vertex"
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0


def test_the_colour_reaches_the_surface(stage):
    from pxr import UsdShade

    prim = stage.GetPrimAtPath("/Painting/Mesh")
    material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
    surface = material.ComputeSurfaceSource()[0]
    assert surface.GetShaderId() == "UsdPreviewSurface"
    source = surface.GetInput("diffuseColor").GetConnectedSources()[0][0].source
    reader = UsdShade.Shader(source.GetPrim())
    assert reader.GetShaderId() == "UsdPrimvarReader_float3"
    assert reader.GetInput("varname").Get() == "displayColor"


@pytest.mark.parametrize(("unit", "metres"), [("mm", 0.001), ("cm", 0.01), ("in", 0.0254)])
def test_unit_and_up_axis_are_told(tmp_path, unit, metres):
    from pxr import Gf, UsdGeom

    export(ball(), tmp_path / "a.usdz", ExportOptions(unit=unit, up_axis="z"))
    stage = Usd.Stage.Open(str(tmp_path / "a.usdz"))
    assert UsdGeom.GetStageMetersPerUnit(stage) == metres
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    extent = UsdGeom.Mesh(stage.GetPrimAtPath("/Painting/Mesh")).GetExtentAttr().Get()
    assert Gf.Vec3f(extent[1])[2] * metres == pytest.approx(0.03)


def test_pixars_validators_find_nothing(stage):
    UsdValidation = pytest.importorskip("pxr.UsdValidation")
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) > 10
    found = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [f"{error.GetName()}: {error.GetMessage()}" for error in found] == []


def test_the_package_is_stored_and_aligned(tmp_path):
    export(ball(), tmp_path / "a.usdz")
    with zipfile.ZipFile(tmp_path / "a.usdz") as package:
        (entry,) = package.infolist()
        assert package.testzip() is None
    assert entry.compress_type == zipfile.ZIP_STORED
    assert entry.filename.endswith(".usdc")
    data = (tmp_path / "a.usdz").read_bytes()
    assert data.index(b"PXR-USDC") % 64 == 0


def test_the_same_painting_gives_the_same_bytes(tmp_path):
    for name in ("a.usdz", "b.usdz"):
        export(ball(), tmp_path / name)
    assert (tmp_path / "a.usdz").read_bytes() == (tmp_path / "b.usdz").read_bytes()


def test_what_is_missing_is_said_before_any_work(tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ExportError, match=r"pip install 'paint3d\[usd\]'"):
        check_export_path(tmp_path / "a.usdz")
