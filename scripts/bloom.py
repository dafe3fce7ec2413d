#!/usr/bin/env python
"""Measure how wet ink spreads, stops and dries on each material: the figures of docs/ink.md.

Usage: python scripts/bloom.py [MATERIAL ...] [--spacing MM] [--share SHARE] [--ink NAME]
       python scripts/bloom.py xuan --inks

A drop of 3 coats on a disc of 3 mm radius (2.5 ul; by default a tenth of it ink, pine soot, the
rest water) spreads for 20 s on a flat sheet and dries. Printed as CSV, lengths in mm:

water, soot    radii of the discs as large as what is wet after 20 s, and as what bears at least
               half of the core's ink
halo           their difference
rim            the darkest ring of .5 mm over the mean within 1.5 mm: after 20 s, and dry
rim_width      breadth of the rings that are halfway from the core to the rim, or more, when dry
power          of the growth of the wet disc's radius with time, 1 to 8 s
rough          deviation of the dry outline's radius over its mean, of soot and of all ink
hurst          of the outline of all ink, from the growth of its differences over .6 to 2.4 mm
in_halo        ink between 1.5 and .5 mm within the water's radius after 20 s, over the core's
strip          power of the way along a strip 4 mm broad that drinks from a pool, 1 to 9 s
front          of the front of water that went up two sheets 45 mm broad from 3 coats along their
               edges, 20 s: the power with which its deviation within a window grows with the
               window, .8 to 6.4 mm; the highest wet place of each column counts, as where wet
               fronts in paper were measured (Buldyrev et al. 1992)
front_mm       that deviation within 6.4 mm

With --inks, what of each ink of the palette is fine, the diameter of its other grains (um), and for
a drop of it on each material the radius of the water, of the ink, the halo, the rim when dry, and
in_halo.
"""

from __future__ import annotations

import argparse

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.materials import material_names
from paint3d.colour.pigments import load_pigment, pigment_names
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.painted_surface import PaintedSurface

COATS, RADIUS, RING = 3.0, 3.0, 0.5
TURNS = 96  # directions in which an outline is looked for
NAMES = ("water", "soot", "halo", "rim_20s", "rim_dry", "rim_width", "power", "rough_soot",
         "rough_all", "hurst", "in_halo", "strip", "front", "front_mm")  # fmt: skip
OF_INKS = ("fine", "grain_um", "water", "radius", "halo", "rim_dry", "in_halo")
WINDOWS = (0.8, 1.2, 1.6, 2.4, 3.2, 4.8, 6.4)  # mm
FRONT_SPACING = 0.15


def sheet(width: float, height: float, spacing: float) -> TriangleMesh:
    """Make a flat sheet (mm) around the origin."""
    x, y = (np.linspace(-s / 2, s / 2, round(s / spacing) + 1) for s in (width, height))
    k = np.arange(len(x) * len(y)).reshape(len(y), len(x))
    a, b, c, d = (part.ravel() for part in (k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]))
    points = np.stack([*np.meshgrid(x, y), np.zeros(k.shape)], axis=-1).reshape(-1, 3)
    return TriangleMesh(points.astype(np.float32), np.vstack([np.c_[a, b, c], np.c_[a, c, d]]))


def lay(surface: PaintedSurface, coverage: NDArray[np.float64], inks: dict[str, float]) -> None:
    """Lay coats of inks where `share` (V,) of a vertex is covered."""
    ids = np.flatnonzero(coverage > 0.0).astype(np.int32)
    for name, coats in inks.items():
        column = surface.column_of(load_pigment(name))
        surface.ink.amounts[ids, column] += (coats * coverage[ids]).astype(np.float32)
    surface.ink.coverage[ids] = coverage[ids]
    surface.touch(ids)


def ink_of(surface: PaintedSurface) -> NDArray[np.float64]:
    """Sum wet and dry ink at each vertex (V,), coats."""
    ink = surface.amounts.sum(axis=1).astype(float)
    ink[surface.dry_layers.vertex_ids] += surface.dry_layers.amounts.sum(axis=1)
    return ink


def wet_of(surface: PaintedSurface) -> NDArray[np.bool_]:
    """Return which vertices (V,) are wet."""
    ids, depth = surface.flow.depths()
    wet = np.zeros(surface.n_vertices, bool)
    wet[ids] = depth > 0.0
    return wet


def outline(points: NDArray[np.float32], shown: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Measure the distance to the farthest shown point in each direction (TURNS,), mm."""
    own = points[shown]
    turn = (np.arctan2(own[:, 1], own[:, 0]) / (2.0 * np.pi) * TURNS).astype(int) % TURNS
    reach = np.zeros(TURNS)
    np.maximum.at(reach, turn, np.linalg.norm(own[:, :2], axis=1))
    known = np.flatnonzero(reach)
    return np.interp(np.arange(TURNS), known, reach[known], period=TURNS)


def hurst(reach: NDArray[np.float64]) -> float:
    """Fit the exponent with which an outline's differences grow with the distance along it."""
    per_mm = TURNS / (2.0 * np.pi * reach.mean())
    steps = np.unique(np.geomspace(0.6 * per_mm, 2.4 * per_mm, 8).astype(int))
    rms = [np.sqrt(((np.roll(reach, k) - reach) ** 2).mean()) for k in steps]
    return float(np.polyfit(np.log(steps), np.log(np.maximum(rms, 1e-9)), 1)[0])


def power_of(times: tuple[float, ...], lengths: list[float]) -> float:
    """Fit the exponent with which lengths grow with time."""
    return float(np.polyfit(np.log(times), np.log(lengths), 1)[0])


def measure_drop(
    material: str, spacing: float, fraction: float, ink: str = "pine soot"
) -> list[float]:
    """Measure the figures of a drop, in the order of NAMES."""
    surface = PaintedSurface(sheet(20.0, 20.0, spacing), None, material)
    points, areas = surface.paint_mesh.vertices, surface.vertex_areas
    away = np.linalg.norm(points[:, :2], axis=1)
    covered = np.clip((RADIUS - away) / 0.5 + 0.5, 0.0, 1.0)
    scale = COATS * np.pi * RADIUS**2 / (covered @ areas)
    lay(surface, covered, {ink: fraction * scale, "water": (1.0 - fraction) * scale})

    def disc(marked: NDArray[np.bool_]) -> float:
        return float(np.sqrt(areas[marked].sum() / np.pi))

    def rings() -> NDArray[np.float64]:
        ring = (away / RING).astype(int)
        return np.bincount(ring, ink_of(surface) * areas) / np.bincount(ring, areas)

    now, radii, times = 0.0, [], (1.0, 2.0, 4.0, 8.0)
    for time in times:
        surface.diffuse(time - now)
        now = time
        radii.append(disc(wet_of(surface)))
    surface.diffuse(20.0 - now)
    water, wet_rings = disc(wet_of(surface)), rings()
    soot = disc(ink_of(surface) > 0.5 * wet_rings[:3].mean())
    surface.diffuse(3.0 * 3600.0)
    dry, left = rings(), ink_of(surface)
    core = dry[:3].mean()
    broad = RING * np.count_nonzero(dry > 0.5 * (core + dry.max()))
    dark, all_ink = (outline(points, left > part * core) for part in (0.5, 1e-3))
    rough = [float(edge.std() / edge.mean()) for edge in (dark, all_ink)]
    rims = [wet_rings.max() / wet_rings[:3].mean(), dry.max() / core]
    first, last = (round((water - inside) / RING) for inside in (1.5, 0.5))
    in_halo = wet_rings[first:last].mean() / wet_rings[:3].mean()
    figures = [water, soot, water - soot, *rims, broad, power_of(times, radii), *rough]
    return [*figures, hurst(all_ink), float(in_halo)]


def compare_inks(material: str, spacing: float, fraction: float) -> None:
    """Print a line of OF_INKS for each ink of the palette."""
    for name in pigment_names():
        figures = measure_drop(material, spacing, fraction, name)
        water, ink, halo, _, rim = figures[:5]
        own = load_pigment(name)
        row = own.fine, own.grain_um, water, ink, halo, rim, figures[-1]
        shown = (f"{x:.3g}" for x in row)
        print(material, name, *shown, sep=",", flush=True)


def measure_strip(material: str, spacing: float) -> float:
    """Fit the exponent with which water advances along a strip that drinks from a pool."""
    surface = PaintedSurface(sheet(40.0, 4.0, spacing), None, material)
    points = surface.paint_mesh.vertices
    lay(surface, (points[:, 0] < -14.0).astype(float), {"water": 60.0})
    now, way, times = 0.0, [], (1.0, 3.0, 9.0)
    for time in times:
        surface.diffuse(time - now)
        now = time
        front = points[wet_of(surface), 0].reshape(-1)
        way.append(float(np.quantile(front, 0.98)) + 14.0)
    return power_of(times, way) if min(way) > 0.0 else 0.0


def front_widths(
    material: str, spacing: float, wide: float = 45.0, heights: tuple[float, ...] = (0.0, 37.0)
) -> NDArray[np.float64]:
    """Measure the deviation of a front within each of WINDOWS (7,), mm, over several sheets."""
    squares = []
    for z in heights:
        flat = sheet(wide, 14.0, spacing)
        moved = flat.vertices + np.array([0.0, 0.0, z], np.float32)
        surface = PaintedSurface(TriangleMesh(moved, flat.faces), None, material)
        x, y, _ = surface.paint_mesh.vertices.T
        coverage = (y < -4.0).astype(float)
        lay(surface, coverage, {"pine soot": 0.1 * COATS, "water": 0.9 * COATS})
        surface.diffuse(20.0)
        wet = wet_of(surface)
        column = np.rint((x + wide / 2) / spacing).astype(int)
        height = np.full(column.max() + 1, -4.0)
        np.maximum.at(height, column[wet], y[wet])
        n = [round(window / spacing) + 1 for window in WINDOWS]
        runs = [np.lib.stride_tricks.sliding_window_view(height, k) for k in n]
        squares.append([run.var(axis=1).mean() for run in runs])
    result: NDArray[np.float64] = np.sqrt(np.mean(squares, axis=0))
    return result


def measure_front(material: str, spacing: float = FRONT_SPACING) -> list[float]:
    """Fit the exponent of a front's roughness; return it and its largest deviation, mm."""
    widths = front_widths(material, spacing)
    exponent = power_of(WINDOWS, list(widths)) if widths.min() > 0.25 * spacing else float("nan")
    return [exponent, float(widths[-1])]


def main() -> None:
    """Run as the module's first lines say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("materials", metavar="MATERIAL", nargs="*", help="by default all")
    parser.add_argument("--spacing", type=float, default=0.2, help="of the vertices, mm")
    parser.add_argument("--share", type=float, default=0.1, help="of ink in the drop")
    parser.add_argument("--ink", default="pine soot", help="in the drop (default: %(default)s)")
    parser.add_argument("--inks", action="store_true", help="compare the inks of the palette")
    options = parser.parse_args()
    materials = options.materials or material_names()
    print("material", *(("ink", *OF_INKS) if options.inks else NAMES), sep=",")
    for material in materials:
        if options.inks:
            compare_inks(material, options.spacing, options.share)
            continue
        figures = measure_drop(material, options.spacing, options.share, options.ink)
        figures.append(measure_strip(material, options.spacing))
        figures += measure_front(material)
        print(material, *(f"{figure:.3g}" for figure in figures), sep=",", flush=True)


if __name__ == "__main__":
    main()
