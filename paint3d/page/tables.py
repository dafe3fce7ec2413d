"""Tables that a page paints with: constants, colours, brushes, materials, objects.

The page computes nothing that can be tabulated: sines and powers differ in the last bits between
NumPy and a browser, and the same recording must give the same bytes in both.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.bending import build_tuft
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import LARGEST_DRAG_FRACTION, build_curves
from paint3d.brush_engine.bristles.state import make_hairs
from paint3d.brush_engine.dry_contact import bundle_noise, contact_noise
from paint3d.brush_engine.footprint import PROFILE_CELLS
from paint3d.brush_engine.ink_transfer import LINES
from paint3d.brush_engine.outline import OUTLINE_CAPACITY, SCRATCH_SIZE
from paint3d.brush_engine.scratch import ROWS, make_scratch
from paint3d.brush_engine.vertex_query import CURSOR_SIZE, DISC_ROWS
from paint3d.colour.glazing import srgb_primaries
from paint3d.colour.layers import SAUNDERSON
from paint3d.colour.materials import Material
from paint3d.colour.pigments import WATER, Pigment, load_palette
from paint3d.colour.spectra import (
    decode_srgb,
    rgb_weights,
    srgb_codes,
    srgb_from_reflectance,
)
from paint3d.colour.vertex_colours import ColourModel, live_bands
from paint3d.core.arrays import AnyArray
from paint3d.mesh.base_surface import CREASE_ANGLE
from paint3d.mesh.bvh import ClosestPoints, build_contact_tree
from paint3d.mesh.kernels.bvh import FACES_PER_LEAF, LEAF_SIZE, ContactTree
from paint3d.mesh.kernels.paper import MOST_ASIDE_MM
from paint3d.mesh.kernels.refine import MOST_AROUND_EDGE
from paint3d.mesh.likeness import digest_of
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.mesh.sheet_mesh import sheet_of, writing_areas
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.page.shape_guess import differences
from paint3d.painter.bristle_state import HairTuft
from paint3d.surface.pores import fibre_frames, mobility_of, sieve_of
from paint3d.view.studio import Gloss

__all__ = ["Table", "brush_table", "common_table", "material_table", "object_table"]

Table = tuple[dict[str, Any], dict[str, AnyArray]]
"""Words and arrays of one file: see `page.bundle`."""

_RAYS = 96  # cast from each vertex for its openness
_GOLDEN_ANGLE = np.pi * (3.0 - np.sqrt(5.0))
_LIFTED_MM = 0.05
_SMOOTHINGS = 12
_UNREFINED = {"px", "py", "pz", "nx", "ny", "nz", "mx", "my", "mz", "take", "key", "parents",
              "vertex_sheet", "area_units", "area", "next_in_cell"}  # fmt: skip
_MEASURED = {"sheet_area", "sheet_normal", "sheet_centre", "sheet_pack"}  # by the page's kernels
_NODES = {"node_vertices", "node_root", "child", "longest", "node_area"}


def common_table(pigments: Sequence[Pigment]) -> Table:
    """Make the table of all paintings: sizes of scratch, noise, colours, and pigments."""
    bands, weights = live_bands()
    palette = load_palette()
    words = {
        "sizes": _sizes(),
        "saunderson": SAUNDERSON,
        "preparing": {
            "crease_cosine": float(np.cos(CREASE_ANGLE)),
            "most_around_edge": MOST_AROUND_EDGE,
            "most_aside_mm": MOST_ASIDE_MM,
            "leaf_sizes": {"contact": LEAF_SIZE, "closest": FACES_PER_LEAF},
        },
        "pigments": [
            {
                "name": pigment.name,
                "chinese": pigment.chinese,
                "saunderson": pigment.saunderson,
                "lasting": pigment is not WATER,
                "fine": pigment.fine,
                "in_palette": palette.get(pigment.name) is pigment,
            }
            for pigment in pigments
        ],
    }
    arrays: dict[str, AnyArray] = {
        "noise": contact_noise(),
        "bundles": bundle_noise(),
        "srgb_codes": srgb_codes(),
        "live_bands": bands.astype(np.int32),
        "live_weights": weights,
        "rgb_weights": rgb_weights(),
        "srgb_primaries": srgb_primaries().astype(np.float32),
        "fibre_frames": fibre_frames(),
        "decoded_codes": decode_srgb(np.arange(256, dtype=np.uint8)).astype(np.float32),
        **{f"K.{pigment.name}": pigment.K for pigment in pigments},
        **{f"S.{pigment.name}": pigment.S for pigment in pigments},
    }
    return words, arrays


def _sizes() -> dict[str, Any]:
    """Measure the kernels' scratch, as `brush_engine.scratch` makes it."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    smallest = TriangleMesh(corners, np.array([[0, 1, 2]], np.int32))
    scratch = make_scratch(PaintMesh.build(smallest, None), 1)
    return {
        "block": len(scratch.block.stretch),
        "counters": len(scratch.counters),
        "rows": ROWS,
        "cursor": CURSOR_SIZE,
        "disc_rows": DISC_ROWS,
        "tuft_scratch": SCRATCH_SIZE,
        "outline": OUTLINE_CAPACITY,
        "chords": {name: array.shape for name, array in scratch.chords._asdict().items()},
        "lines": LINES,
        "profile_cells": PROFILE_CELLS,
    }


def brush_table(name: str, chinese: str) -> Table:
    """Make the table of a brush: tuft, input curves and hairs; see `page.shape_guess`."""
    brush = load_brush(name)
    tuft, curves = build_tuft(brush)._asdict(), build_curves(brush.inputs)._asdict()
    guessed = differences(tuft, brush.length_mm)
    arrays = {f"apart.{key}": value for key, value in guessed.items()}
    arrays |= {
        f"tuft.{key}": value
        for key, value in tuft.items()
        if isinstance(value, np.ndarray) and key not in guessed
    }
    words: dict[str, Any] = {
        "name": name,
        "chinese": chinese,
        "length_mm": brush.length_mm,
        "rubbing": brush.spread_by_friction * brush.friction,
        "farthest_drag": LARGEST_DRAG_FRACTION,
        "tuft": {key: value for key, value in tuft.items() if isinstance(value, float)},
    }
    arrays |= {f"curves.{key}": value for key, value in curves.items()}
    if brush.bristles is not None:
        words["hairs"], hairs = _hairs_table(HairTuft(brush, brush.bristles))
        arrays |= hairs
    return words, arrays


def _hairs_table(tuft: HairTuft) -> Table:
    """Make the table of a tuft's hairs and of the arrays that kernels work in (`make_hairs`)."""
    one, two = (
        _leaves(make_hairs(tuft.bristles, np.zeros((tuft.spec.n_hairs, n)), tuft.memory))
        for n in (1, 2)
    )
    arrays: dict[str, AnyArray] = {}
    words: dict[str, Any] = {"count": tuft.spec.n_hairs, "numbers": {}, "shapes": {}}
    for name, value in one.items():
        if not isinstance(value, np.ndarray):
            words["numbers"][name] = value
        elif value.dtype.names is None:
            if value.shape == two[name].shape:
                arrays[f"hairs.{name}"] = value
            elif name != "load":  # zeros, whose shape depends on the number of pigments
                pairs = zip(value.shape, two[name].shape, strict=True)
                shape = [[2 * a - b, b - a] for a, b in pairs]
                words["shapes"][name] = {"kind": value.dtype.str[1:], "shape": shape}
    return words, arrays


def _leaves(row: Any, before: str = "") -> dict[str, Any]:
    """Flatten a named tuple of named tuples, by dotted names."""
    leaves: dict[str, Any] = {}
    for name, value in row._asdict().items():
        if hasattr(value, "_asdict"):
            leaves |= _leaves(value, f"{before}{name}.")
        else:
            leaves[before + name] = value
    return leaves


def material_table(material: Material, pigments: Sequence[Pigment]) -> Table:
    """Make the table of a material, with the colours of each pigment alone on it."""
    words: dict[str, Any] = {
        "name": material.name,
        "chinese": material.chinese,
        "grain": material.grain,
        "tooth_mm": material.tooth_mm,
        "uptake": material.uptake,
        "friction": material.friction,
        "seen_roughness": material.seen_roughness,
        "paper": Gloss.of(material).paper,
        "pores_mm": material.pores_mm,
        "residual": material.residual,
        "advance": material.advance,
        "spread_mm2_s": material.spread_mm2_s,
        "passing": material.passing,
        "drying_mm_s": material.drying_mm_s,
        "sieve": sieve_of(material),
        "mobility": {
            pigment.name: float(mobility_of(material, np.array([pigment.grain_um], float))[0])
            for pigment in pigments
        },
        "bends": {},
    }
    reflectance = np.asarray(material.reflectance, np.float64)
    arrays: dict[str, AnyArray] = {
        "reflectance": reflectance.astype(np.float32),
        "bare": srgb_from_reflectance(material.reflectance),
        "bare_linear_rgb": ColourModel(pigments[:1], reflectance).bare_linear_rgb,
    }
    for pigment in pigments:
        table = ColourModel([pigment], reflectance).single
        words["bends"][pigment.name] = float(table.bend)
        arrays |= {f"table.{pigment.name}": table.table, f"shades.{pigment.name}": table.shades}
    return words, arrays


def object_table(mesh: TriangleMesh, resolution: float) -> Table:
    """Make the table of an object: its surface before there is paint."""
    paint_mesh = PaintMesh.build(mesh, resolution)
    field, n = paint_mesh.arrays, paint_mesh.n_base_vertices
    sheet, apex = sheet_of(mesh), writing_areas(mesh)[0].apex
    roots = len(paint_mesh.base_faces) if paint_mesh.refines else 0
    words = {
        "name": mesh.name,
        "mesh": digest_of(mesh),
        "resolution": resolution,
        "refines": paint_mesh.refines,
        "n_base_vertices": n,
        "usual_material": "porcelain" if sheet is None else sheet.usual.material,
        "apex": None if apex is None else apex.tolist(),
        "most_around_edge": MOST_AROUND_EDGE,
        "most_aside_mm": MOST_ASIDE_MM,
        "leaf_sizes": {"contact": LEAF_SIZE, "closest": FACES_PER_LEAF},
        "field": {k: v for k, v in field._asdict().items() if isinstance(v, float)},
    }
    closest = ClosestPoints(mesh)
    arrays: dict[str, AnyArray] = {
        "base_faces": paint_mesh.base_faces,
        "openness": _openness(
            closest, paint_mesh.vertices[:n], paint_mesh.normals[:n], paint_mesh.base_faces
        ),
    }
    for name, array in field._asdict().items():
        if isinstance(array, np.ndarray) and name not in _MEASURED:
            used = n if name in _UNREFINED else roots if name in _NODES else len(array)
            arrays[f"field.{name}"] = array[: 3 * roots if name == "radial" else used]
    arrays["field.path"] = np.zeros_like(field.path)  # scratch
    arrays |= _tree(build_contact_tree(paint_mesh), "contact")
    return words, arrays | _tree(closest.tree, "closest")


def _openness(
    surface: ClosestPoints, points: AnyArray, normals: AnyArray, faces: AnyArray
) -> NDArray[np.uint8]:
    """Compute how open each vertex is to an even sky (N,), 255 if nothing occludes it."""
    k = np.arange(_RAYS)
    fraction, azimuth = (k + 0.5) / _RAYS, _GOLDEN_ANGLE * k
    # cosine-weighted directions about the normal (Malley's method)
    across, up = np.sqrt(fraction), np.sqrt(1.0 - fraction)
    seen = np.zeros(len(points))
    normal = normals.astype(np.float64)
    aside = np.cross(normal, np.eye(3)[np.abs(normal).argmin(axis=1)])
    aside /= np.linalg.norm(aside, axis=1)[:, None]
    ahead = np.cross(normal, aside)
    starts = points + _LIFTED_MM * normal
    for a, h, u in zip(across * np.cos(azimuth), across * np.sin(azimuth), up, strict=True):
        seen += ~surface.cast(starts, a * aside + h * ahead + u * normal).hit
    return np.rint(255.0 * _smoothed(seen / _RAYS, faces)).astype(np.uint8)


def _smoothed(values: AnyArray, faces: AnyArray) -> AnyArray:
    """Smooth values of vertices (N,), which are noisy from few rays: repeated neighbour means."""
    for _ in range(_SMOOTHINGS):
        sums, counts = values.copy(), np.ones(len(values))
        means = values[faces].mean(axis=1)
        for corner in faces.T:
            sums += np.bincount(corner, means, len(values))
            counts += np.bincount(corner, minlength=len(values))
        values = sums / counts
    return values


def _tree(tree: ContactTree, name: str) -> dict[str, AnyArray]:
    """Return a tree's arrays without its boxes, which the page rebuilds."""
    arrays = tree._asdict()
    del arrays["boxes"]
    return {f"{name}.{key}": value for key, value in arrays.items()}
