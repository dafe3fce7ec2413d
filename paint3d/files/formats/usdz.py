"""USDZ for phones, tablets and film: one painted mesh in an uncompressed package."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.spectra import decode_srgb
from paint3d.core.arrays import AnyArray
from paint3d.files.finish import Finish
from paint3d.files.formats.usd_crate import ListOp, Spec, SpecType, Type, Value, write_crate
from paint3d.files.load import UNITS_MM

__all__ = ["write_usdz"]

ALIGNMENT = 64  # of the data of every file in the package, by the USDZ specification
LOCAL_HEADER, EXTRA_HEADER = 30, 4
PADDING_TAG = 0x1986  # what Pixar's own packages mark the padding with
EARLIEST = (1980, 1, 1, 0, 0, 0)
SCENE, MESH, MATERIAL = "/Painting", "/Painting/Mesh", "/Painting/Material"
PLAIN = Finish()
SURFACE, COLOUR = f"{MATERIAL}/Surface", f"{MATERIAL}/Colour"
ROUGHNESS = f"{MATERIAL}/Roughness"


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
    OSError
        If the file cannot be written.
    """
    linear = decode_srgb(np.arange(256, dtype=np.uint8)).astype("<f4")
    told = linear[colours] if colours.dtype == np.uint8 else colours
    specs = [
        _root(finish.name, unit, up_axis),
        _prim(SCENE, "Xform", children=["Mesh", "Material"], kind=Value(Type.TOKEN, "component")),
        *_mesh(vertices, faces, normals, told, finish.each),
        *_material(finish.roughness, finish.each is not None),
    ]
    scene = io.BytesIO()
    write_crate(scene, specs)
    entry = zipfile.ZipInfo("painting.usdc", EARLIEST)
    header = LOCAL_HEADER + len(entry.filename) + EXTRA_HEADER
    padding = -header % ALIGNMENT
    entry.extra = PADDING_TAG.to_bytes(2, "little") + padding.to_bytes(2, "little") + bytes(padding)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as package:
        package.writestr(entry, scene.getbuffer())


def _root(name: str, unit: str, up_axis: str) -> Spec:
    fields = {
        "defaultPrim": Value(Type.TOKEN, SCENE[1:]),
        "documentation": Value(Type.STRING, f"{name}, painted with paint3d"),
        "metersPerUnit": Value(Type.DOUBLE, UNITS_MM[unit] / 1000.0),
        "upAxis": Value(Type.TOKEN, up_axis.upper()),
        "primChildren": Value(Type.TOKEN_VECTOR, [SCENE[1:]]),
    }
    return Spec("/", SpecType.ROOT, fields)


def _prim(
    path: str,
    type_name: str,
    properties: Sequence[str] = (),
    children: Sequence[str] = (),
    **others: Value,
) -> Spec:
    fields = {"specifier": Value(Type.SPECIFIER, 0), "typeName": Value(Type.TOKEN, type_name)}
    fields |= others
    for field, names in (("properties", properties), ("primChildren", children)):
        if names:
            fields[field] = Value(Type.TOKEN_VECTOR, names)
    return Spec(path, SpecType.PRIM, fields)


def _attribute(path: str, type_name: str, value: Value | None, **others: Value) -> Spec:
    fields = {"typeName": Value(Type.TOKEN, type_name)} | others
    if value is not None:
        fields["default"] = value
    return Spec(path, SpecType.ATTRIBUTE, fields)


def _mesh(
    vertices: AnyArray,
    faces: AnyArray,
    normals: AnyArray,
    colours: AnyArray,
    roughness: AnyArray | None,
) -> list[Spec]:
    limits = np.stack([vertices.min(axis=0), vertices.max(axis=0)]).astype("<f4")
    each_vertex = {"interpolation": Value(Type.TOKEN, "vertex")}
    uniform = {"variability": Value(Type.VARIABILITY, 1)}
    floats = {
        "extent": ("float3[]", limits, {}),
        "normals": ("normal3f[]", normals, each_vertex),
        "points": ("point3f[]", vertices, {}),
        "primvars:displayColor": ("color3f[]", colours, each_vertex),
    }
    counts = np.full(len(faces), 3, "<i4")
    attributes = [
        _attribute(f"{MESH}.doubleSided", "bool", Value(Type.BOOL, True), **uniform),
        _attribute(f"{MESH}.faceVertexCounts", "int[]", Value(Type.INT, counts)),
        _attribute(
            f"{MESH}.faceVertexIndices", "int[]", Value(Type.INT, faces.reshape(-1).astype("<i4"))
        ),
        Spec(
            f"{MESH}.material:binding",
            SpecType.RELATIONSHIP,
            {"targetPaths": Value(Type.PATH_LIST_OP, ListOp([MATERIAL])), **uniform},
        ),
        *(
            _attribute(
                f"{MESH}.{name}", kind, Value(Type.VEC3F, np.ascontiguousarray(data, "<f4")), **more
            )
            for name, (kind, data, more) in floats.items()
        ),
        *(
            _attribute(
                f"{MESH}.primvars:roughness",
                "float[]",
                Value(Type.FLOAT, np.ascontiguousarray(each, "<f4")),
                **each_vertex,
            )
            for each in ([] if roughness is None else [roughness])
        ),
        _attribute(f"{MESH}.subdivisionScheme", "token", Value(Type.TOKEN, "none"), **uniform),
    ]
    properties = [spec.path.partition(".")[2] for spec in attributes]
    schemas = Value(Type.TOKEN_LIST_OP, ListOp(["MaterialBindingAPI"], explicit=False))
    return [_prim(MESH, "Mesh", properties, apiSchemas=schemas), *attributes]


def _material(roughness: float, is_uneven: bool) -> list[Spec]:
    uniform = {"variability": Value(Type.VARIABILITY, 1)}

    def connected(path: str, type_name: str, source: str) -> Spec:
        link = Value(Type.PATH_LIST_OP, ListOp([source]))
        return _attribute(path, type_name, None, connectionPaths=link)

    def identity(path: str, shader: str) -> Spec:
        return _attribute(f"{path}.info:id", "token", Value(Type.TOKEN, shader), **uniform)

    def reader(path: str, kind: str, primvar: str) -> list[Spec]:
        return [
            _prim(path, "Shader", ["info:id", "inputs:varname", "outputs:result"]),
            identity(path, f"UsdPrimvarReader_{kind}"),
            _attribute(f"{path}.inputs:varname", "string", Value(Type.STRING, primvar)),
            _attribute(f"{path}.outputs:result", kind, None),
        ]

    rough, parts = f"{SURFACE}.inputs:roughness", ["Surface", "Colour"]
    roughly = _attribute(rough, "float", Value(Type.FLOAT, roughness))
    if is_uneven:
        roughly = connected(rough, "float", f"{ROUGHNESS}.outputs:result")
        parts.append("Roughness")
    inputs = ["info:id", "inputs:diffuseColor", "inputs:metallic", "inputs:roughness"]
    return [
        _prim(MATERIAL, "Material", ["outputs:surface"], parts),
        connected(f"{MATERIAL}.outputs:surface", "token", f"{SURFACE}.outputs:surface"),
        _prim(SURFACE, "Shader", [*inputs, "outputs:surface"]),
        identity(SURFACE, "UsdPreviewSurface"),
        connected(f"{SURFACE}.inputs:diffuseColor", "color3f", f"{COLOUR}.outputs:result"),
        _attribute(f"{SURFACE}.inputs:metallic", "float", Value(Type.FLOAT, 0.0)),
        roughly,
        _attribute(f"{SURFACE}.outputs:surface", "token", None),
        *reader(COLOUR, "float3", "displayColor"),
        *(reader(ROUGHNESS, "float", "roughness") if is_uneven else []),
    ]
