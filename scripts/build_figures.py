#!/usr/bin/env python
"""Draw docs/figures/*.png from the program itself: run it in an environment with paint3d[docs]."""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Circle, Rectangle
from scipy.interpolate import splev, splprep

import paint3d
from paint3d.brush.bending import build_tuft
from paint3d.brush.presets import load_brush
from paint3d.brush_engine.outline import OUTLINE_CAPACITY, SCRATCH_SIZE, trace_outline
from paint3d.brush_engine.tuft import STATIONS, enclose_tuft, trace_spine
from paint3d.cli.sources import lay_on
from paint3d.colour.layers import layer_reflectance
from paint3d.colour.pigments import load_pigment
from paint3d.colour.spectra import srgb_from_reflectance
from paint3d.device.recorded import Recording

FIGURES = Path(__file__).parents[1] / "docs" / "figures"
UPRIGHT = 0.5 * np.pi
FORCES = (1.0, 3.0, 5.0, 7.9)


def outline(tuft, force: float, tilt: float) -> tuple[np.ndarray, np.ndarray]:
    """Reach and half width (mm) of the footprint under a force (N)."""
    reach, half = np.zeros(OUTLINE_CAPACITY), np.zeros(OUTLINE_CAPACITY)
    descent = force / tuft.spring
    pe = force / tuft.max_force
    n = trace_outline(tuft, descent, tilt, pe, np.zeros(SCRATCH_SIZE), reach, half)
    return reach[:n], half[:n]


def draw_footprints() -> plt.Figure:
    """Footprints of three brushes over the force, upright."""
    figure, rows = plt.subplots(3, 1, figsize=(8, 7), sharex=True, layout="constrained")
    for axes, name in zip(rows, ("full", "slender", "xiaokai"), strict=True):
        tuft = build_tuft(load_brush(name))
        for k, force in enumerate(FORCES):
            reach, half = outline(tuft, force, UPRIGHT)
            x = np.concatenate([reach, reach[::-1]]) + 26 * k
            y = np.concatenate([half, -half[::-1]])
            axes.fill(x, y, color="0.15")
            area = 2 * abs(np.trapezoid(half, reach))
            label = f"{force:g} N\n{np.ptp(reach):.1f} x {2 * half.max():.1f} mm, {area:.1f} mm²"
            axes.annotate(label, (26 * k + 6, -15), ha="center", fontsize=8)
        axes.set_aspect("equal")
        axes.set_ylim(-17, 12)
        axes.set_ylabel(f"{name}\nmm")
    rows[-1].set_xlabel("mm along the bend (each footprint shifted by 26 mm)")
    figure.suptitle("Footprints over the force, holder upright")
    return figure


def draw_nodes() -> plt.Figure:
    """The papers' footprint, a spline through the nodes that touch, over ours: three presses."""
    spec = load_brush("full")
    tuft = build_tuft(spec)
    joints = np.concatenate([[0.0], np.cumsum(spec.segment_lengths)])
    diameters = spec.diameters(joints)
    figure, columns = plt.subplots(1, 3, figsize=(9, 3.6), layout="constrained")
    for axes, force in zip(columns, (0.6, 2.0, 5.0), strict=True):
        reach, half = outline(tuft, force, UPRIGHT)
        axes.fill(np.r_[reach, reach[::-1]], np.r_[half, -half[::-1]], color="0.8", label="ours")
        spine = np.zeros((3, STATIONS))
        trace_spine(tuft, force / tuft.spring, UPRIGHT, spine)
        along, up, angle = (np.interp(joints, tuft.arcs, part) for part in spine)
        spread = 1.0 + tuft.spread * force / tuft.max_force
        wide, thick = spread * diameters, diameters / spread  # Guo 2017, Eqs. 2 and 3
        under_root = thick**2 - 4.0 * up**2 / np.cos(angle) ** 2
        touches = (under_root > 0.0) | (np.arange(len(joints)) == 0)
        x = (along - up * np.tan(angle))[touches]
        half = np.zeros_like(x)
        half[1:] = (0.5 * wide / np.maximum(thick, 1e-9) * np.sqrt(np.maximum(under_root, 0.0)))[
            touches
        ][1:]
        ring = np.stack([np.r_[x, x[:0:-1]], np.r_[half, -half[:0:-1]]])
        if len(x) > 2:
            closed = splprep(np.column_stack([ring, ring[:, :1]]), s=0.0, per=True)[0]
            axes.plot(*splev(np.linspace(0.0, 1.0, 400), closed), "tab:red", lw=1, label="papers'")
        axes.plot(*ring, "o", color="tab:red", ms=4)
        axes.set_aspect("equal")
        axes.set_title(f"{force:g} N: {len(x)} of {len(joints)} nodes touch", fontsize=9)
        axes.set_xlabel("mm along the bend")
    columns[1].legend(fontsize=8, loc="lower right")
    return figure


def draw_spheres() -> plt.Figure:
    """The bent spine and its enclosing sphere over the descent, for two tilts."""
    spec = load_brush("full")
    tuft = build_tuft(spec)
    figure, rows = plt.subplots(2, 4, figsize=(11, 6.5), layout="constrained")
    for axes_row, tilt in zip(rows, (UPRIGHT, np.radians(60)), strict=True):
        for axes, fraction in zip(axes_row, (0.02, 0.2, 0.35, 0.5), strict=True):
            descent = fraction * spec.length_mm
            pe = min(1.0, descent / tuft.full_press)
            spine = np.zeros((3, STATIONS))
            trace_spine(tuft, descent, tilt, spine)
            joints = np.concatenate([[0.0], np.cumsum(spec.segment_lengths)])
            nodes = np.stack([np.interp(joints, tuft.arcs, part) for part in spine[:2]])
            along, up, radius = enclose_tuft(tuft, descent, tilt, pe)
            axes.add_patch(Circle((along, up), radius, fill=False, ec="tab:blue"))
            axes.plot(*spine[:2], color="0.15")
            axes.plot(*nodes, "o", color="0.15", ms=3)
            axes.axhline(0, color="tab:brown", lw=1)
            axes.set_aspect("equal")
            axes.set_xlim(-22, 38)
            axes.set_ylim(-14, 42)
            title = f"tilt {np.degrees(tilt):.0f}°, descent {descent:.1f} mm\nr = {radius:.1f} mm"
            axes.set_title(title, fontsize=9)
    figure.suptitle("The bent spine of “full” and its enclosing sphere (mm)")
    return figure


def straight_stroke(pressure: float, length_mm: float) -> Recording:
    """An upright pen along x over the middle of the plane, at one pressure."""
    n = 200
    x = np.linspace(-0.5 * length_mm, 0.5 * length_mm, n)
    position = np.stack([x, np.zeros(n), np.full(n, 30.0)], axis=1)
    orientation = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    time_ns = (np.arange(n) * 10_000_000).astype(np.int64)
    return Recording(time_ns, position, orientation, np.full(n, pressure))


def draw_ink() -> plt.Figure:
    """Ink along a stroke, painted, against the closed form."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
    mesh = paint3d.load_mesh("plane")
    for pressure in (0.2, 0.4, 0.8):
        colour = plt.cm.viridis(pressure)
        lengths = np.linspace(20.0, 180.0, 5)
        fractions = []
        for length in lengths:
            surface = paint3d.PaintedSurface(mesh, resolution=1.0)
            painter = paint3d.Painter(surface, brush="full")
            painter.replay(straight_stroke(pressure, length))
            ledger = painter.report()["ink_ledger"]
            fractions.append(ledger["in_brush"] / ledger["loaded"])
        rate = load_brush("full").transfer_per_mm
        line = np.linspace(0.0, 180.0, 100)
        left.plot(line, np.exp(-rate * pressure * line), color=colour, label=f"pe = {pressure:g}")
        left.plot(lengths, fractions, "o", color=colour)
    left.set(
        xlabel="way, mm", ylabel="share left in the brush", title="painted (dots), exp(-η' pe s)"
    )
    left.legend()
    samples = np.array([50, 100, 200, 500, 1000])
    right.semilogx(samples, (1 - 0.005) ** samples, "s--", label="Eq. 13, η pe = 0.005")
    right.semilogx(samples, np.full(len(samples), np.exp(-0.5)), "o-", label="per mm of way")
    right.set(xlabel="samples of one and the same stroke", title="what is left after it")
    right.legend()
    return figure


def presses(depths: tuple[float, ...], apart_mm: float) -> Recording:
    """Upright presses side by side on a pad, down and up again."""
    rows = [
        (apart_mm * (k - 1), fraction * pe) for k, pe in enumerate(depths) for fraction in (0, 1, 0)
    ]
    n = len(rows)
    position = np.array([[x, 0.0, 0.0] for x, _ in rows])
    position[:, 2] = 30.0
    return Recording(
        (np.arange(n) * 200_000_000).astype(np.int64),
        position,
        np.tile([1.0, 0.0, 0.0, 0.0], (n, 1)),
        np.array([pressure for _, pressure in rows]),
        header={"space": "pad"},
    )


def draw_projection() -> plt.Figure:
    """The same three presses on a plane and on the bowl's wall."""
    figure, rows = plt.subplots(2, 1, figsize=(8, 5.6), sharex=True, layout="constrained")
    depths = (0.15, 0.3, 0.5)
    for axes, name in zip(rows, ("plane", "bowl"), strict=True):
        mesh = paint3d.load_mesh(name)
        surface = paint3d.PaintedSurface(mesh, resolution=0.3)
        recording = lay_on(mesh, presses(depths, 25.0), (0.5, 0.5), None)
        paint3d.Painter(surface, brush="full").replay(recording)
        vertices, cover = surface.paint_mesh.vertices, surface.coverage
        area = float(cover @ surface.vertex_areas)
        up = 1 if name == "plane" else 2
        shown = (cover > 0) & (vertices[:, 1] < 0 if up == 2 else True)
        points = vertices[shown]
        middle = np.median(points[:, up])
        axes.scatter(points[:, 0], points[:, up] - middle, c=1 - cover[shown], cmap="gray", s=1)
        axes.set(
            title=f"{name}: {area:.0f} mm² covered", ylabel="mm", aspect="equal", ylim=(-12, 12)
        )
    rows[-1].set_xlabel("mm; the bowl seen from the front")
    return figure


def draw_colours() -> plt.Figure:
    """The colour of a layer over white and over black, over its quantity."""
    names = ("pine soot", "cinnabar", "azurite", "gamboge")
    coats = np.geomspace(0.02, 8.0, 120)
    figure, rows = plt.subplots(len(names), 1, figsize=(8, 5), sharex=True, layout="constrained")
    for axes, name in zip(rows, names, strict=True):
        pigment = load_pigment(name)
        for row, backing in enumerate((0.9, 0.03)):
            layers = layer_reflectance(pigment.K, pigment.S, coats[:, None], backing)
            for x0, x1, srgb in zip(
                coats[:-1], coats[1:], srgb_from_reflectance(layers), strict=False
            ):
                colour = np.asarray(srgb, float) / 255
                axes.add_patch(Rectangle((x0, row), x1 - x0, 1, color=colour, lw=0))
        axes.set(xscale="log", xlim=(coats[0], coats[-1]), ylim=(0, 2), ylabel=name)
        axes.set_yticks([0.5, 1.5], ["on white", "on black"], fontsize=7)
    rows[-1].set_xlabel("quantity, coats")
    return figure


def main() -> None:
    """Draw the figures named, or all of them."""
    drawings = {
        "footprints": draw_footprints,
        "nodes": draw_nodes,
        "spheres": draw_spheres,
        "projection": draw_projection,
        "ink": draw_ink,
        "colours": draw_colours,
    }
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(drawings))
    FIGURES.mkdir(parents=True, exist_ok=True)
    for name in parser.parse_args().names or drawings:
        drawings[name]().savefig(FIGURES / f"{name}.png", dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
