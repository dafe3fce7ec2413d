"""USDZ, for Apple's devices: binary USD with its colours, written by Pixar's own library."""

from __future__ import annotations

import importlib.util
import tempfile
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.spectra import decode_srgb
from paint3d.core.arrays import AnyArray
from paint3d.errors import ExportError
from paint3d.files.finish import Finish
from paint3d.files.load import UNITS_MM

__all__ = ["check_usd", "write_usdz"]

ALIGNMENT = 64  # of the data of every file in the package, by the USDZ specification
LOCAL_HEADER, EXTRA_HEADER = 30, 4
PADDING_TAG = 0x1986  # what Pixar's own packages mark the padding with
EARLIEST = (1980, 1, 1, 0, 0, 0)
SCENE, MESH, MATERIAL = "/Painting", "/Painting/Mesh", "/Painting/Material"
PLAIN = Finish()


def check_usd() -> None:
    """Raise ExportError where Pixar's library is not installed; it is not imported."""
    if importlib.util.find_spec("pxr") is None:
        raise ExportError(
            "USDZ needs usd-core, which is not installed; expected another format, such as .glb",
            hint="pip install 'paint3d[usd]'",
        )


def write_usdz(
    path: Path,
    vertices: NDArray[np.float32],
    faces: NDArray[np.int32],
    normals: NDArray[np.float32],
    colours: NDArray[np.uint8] | NDArray[np.float32],
    finish: Finish = PLAIN,
    *,
    unit: str = "m",
    up_axis: str = "y",
) -> None:
    """Write a mesh with displayColor, and a material that reads its colour from there.

    Colours in USD are linear. The scene says its unit and up axis.

    Parameters
    ----------
    path : Path
    vertices : (V, 3) float32
    faces : (F, 3) int32
    normals : (V, 3) float32, unit
    colours : (V, 3) uint8 or float32
        sRGB codes, or linear sRGB, which is below 0 or above 1 where a colour is outside sRGB.
    finish : Finish
        Of the material; its name goes into the scene's documentation. Where vertices have
        roughnesses of their own, the material reads them like the colour.
    unit : {"mm", "cm", "m", "in"}
        Of the vertices.
    up_axis : {"y", "z"}

    Raises
    ------
    ExportError
        If usd-core is not installed.
    OSError
        If the file cannot be written.
    """
    check_usd()
    from pxr import Tf, Usd, UsdGeom, UsdShade

    with tempfile.TemporaryDirectory() as folder:
        crate = Path(folder) / "painting.usdc"
        stage = Usd.Stage.CreateNew(str(crate))
        stage.GetRootLayer().documentation = f"{finish.name}, painted with paint3d"
        UsdGeom.SetStageMetersPerUnit(stage, UNITS_MM[unit] / 1000.0)
        UsdGeom.SetStageUpAxis(stage, up_axis.upper())
        scene = UsdGeom.Xform.Define(stage, SCENE).GetPrim()
        Usd.ModelAPI(scene).SetKind("component")
        stage.SetDefaultPrim(scene)
        mesh = _add_mesh(stage, vertices, faces, normals, colours, finish.each)
        UsdShade.MaterialBindingAPI.Apply(mesh).Bind(_add_material(stage, finish))
        try:
            stage.GetRootLayer().Save()
        except Tf.ErrorException as cause:
            reason = str(cause).strip().split("\n")[0]  # without where in the library's sources
            reason = reason.rpartition(" : ")[2].strip("' ")
            raise OSError(f"usd-core says: {reason}") from None
        _pack(path, crate.read_bytes())


def _add_mesh(
    stage: Any,
    vertices: NDArray[np.float32],
    faces: NDArray[np.int32],
    normals: NDArray[np.float32],
    colours: NDArray[np.uint8] | NDArray[np.float32],
    roughness: NDArray[np.float32] | None,
) -> Any:
    from pxr import Sdf, UsdGeom, Vt

    linear = decode_srgb(np.arange(256, dtype=np.uint8)).astype("<f4")
    shown = linear[colours] if colours.dtype == np.uint8 else colours

    def vectors(array: AnyArray) -> Any:
        return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(array, "<f4"))

    mesh = UsdGeom.Mesh.Define(stage, MESH)
    mesh.CreatePointsAttr(vectors(vertices))
    mesh.CreateExtentAttr(vectors(np.stack([vertices.min(axis=0), vertices.max(axis=0)])))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(faces), 3, "<i4")))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(faces.ravel().astype("<i4")))
    mesh.CreateNormalsAttr(vectors(normals))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    mesh.CreateDoubleSidedAttr(True)
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    primvars, kinds = UsdGeom.PrimvarsAPI(mesh), Sdf.ValueTypeNames
    colour = primvars.CreatePrimvar("displayColor", kinds.Color3fArray, UsdGeom.Tokens.vertex)
    colour.Set(vectors(shown))
    if roughness is not None:
        rough = primvars.CreatePrimvar("roughness", kinds.FloatArray, UsdGeom.Tokens.vertex)
        rough.Set(Vt.FloatArray.FromNumpy(np.ascontiguousarray(roughness, "<f4")))
    return mesh.GetPrim()


def _add_material(stage: Any, finish: Finish) -> Any:
    from pxr import Sdf, UsdShade

    kinds = Sdf.ValueTypeNames
    material = UsdShade.Material.Define(stage, MATERIAL)
    surface = UsdShade.Shader.Define(stage, f"{MATERIAL}/Surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("metallic", kinds.Float).Set(0.0)
    material.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", kinds.Token))

    def read(part: str, kind: str, primvar: str) -> Any:
        reader = UsdShade.Shader.Define(stage, f"{MATERIAL}/{part}")
        reader.CreateIdAttr(f"UsdPrimvarReader_{kind}")
        reader.CreateInput("varname", kinds.String).Set(primvar)
        return reader.CreateOutput("result", kinds.Float3 if kind == "float3" else kinds.Float)

    diffuse = surface.CreateInput("diffuseColor", kinds.Color3f)
    diffuse.ConnectToSource(read("Colour", "float3", "displayColor"))
    rough = surface.CreateInput("roughness", kinds.Float)
    if finish.each is None:
        rough.Set(finish.roughness)
    else:
        rough.ConnectToSource(read("Roughness", "float", "roughness"))
    return material


def _pack(path: Path, crate: bytes) -> None:
    """Write the package: one file, stored, its data aligned and its date fixed."""
    entry = zipfile.ZipInfo("painting.usdc", EARLIEST)
    header = LOCAL_HEADER + len(entry.filename) + EXTRA_HEADER
    padding = -header % ALIGNMENT
    entry.extra = PADDING_TAG.to_bytes(2, "little") + padding.to_bytes(2, "little") + bytes(padding)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as package:
        package.writestr(entry, crate)
