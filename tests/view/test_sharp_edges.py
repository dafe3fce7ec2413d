"""Edges of paint between vertices: as sharp as the picture, without the mesh in them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, median_filter

import paint3d
from paint3d.colour.pigments import load_pigment
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view.camera import Camera
from paint3d.view.edges import Edges, edge_shares, packed
from paint3d.view.live_edges import LiveEdges
from paint3d.view.live_object import LiveObject
from paint3d.view.live_scene import LIGHT, LiveScene
from paint3d.view.paper import Paper
from paint3d.view.scene import Frame, draw_flat
from paint3d.view.studio import NO_PAPER, Gloss
from tests.support import surface_cases
from tests.support.cases import long_but

NONE = np.empty(0, np.int32)
SPACING = 0.4  # mm, as in the studio
SIZE = (240, 180)
PITCHES = (0.2, 0.6)  # mm: the lattice of the mesh, along it and across


@pytest.fixture(scope="module")
def surface() -> PaintedSurface:
    sheet = PaintedSurface(surface_cases.sheet(surface_cases.flat, (11.0, 11.0), 3.0), SPACING)
    sheet.refine_all()
    sheet.column_of(load_pigment("pine soot"))
    return sheet


def paint_band(surface: PaintedSurface, turn: float, offset: float, width: float) -> None:
    """Cover a straight band through `offset` mm right of the middle, as a footprint covers it."""
    across = np.array([math.cos(turn), math.sin(turn)])
    depth = offset - surface.paint_mesh.vertices[:, :2].astype(np.float64) @ across
    soft = surface.paint_mesh.arrays.soft_edge
    inside = np.clip(depth / soft + 0.5, 0.0, 1.0) + np.clip((width - depth) / soft + 0.5, 0.0, 1.0)
    n = surface.n_vertices
    surface.ink.coverage[:n] = np.maximum(inside - 1.0, 0.0)
    surface.ink.amounts[:n, 0] = 2.0 * surface.ink.coverage[:n]
    surface.touch(np.arange(n, dtype=np.int32))


def edges_of(surface: PaintedSurface) -> Edges:
    shares = edge_shares(surface.paint_mesh.leaf_faces(), surface.coverage_codes())
    return Edges(surface.bare_codes, shares)


def flat(
    surface: PaintedSurface, turn: float, offset: float, scale: float, edges, paper=(0.0, 0.0)
):
    """A picture in which the band's edge goes straight up in the middle, scale in pixels a mm."""
    across, along = (np.array([f(turn), g(turn), 0.0]) for f, g in _TURNED)
    axes = np.stack([across, along, [0.0, 0.0, 1.0]])
    frame = Frame(axes, np.array([offset, 0.0]), SIZE[1] / scale)
    mesh = surface.mesh
    pixels = draw_flat(
        mesh.vertices, mesh.faces, surface.srgb, frame, SIZE, edges=edges, paper=paper
    )
    return pixels[..., 1].astype(np.float64)


_TURNED = (math.cos, math.sin), (lambda t: -math.sin(t), math.cos)


def live(surface: PaintedSurface, turn: float, offset: float, scale: float, of="porcelain"):
    """The same in the studio's window."""
    across, along = (np.array([f(turn), g(turn), 0.0]) for f, g in _TURNED)
    shown, scene = LiveObject(surface), LiveScene(SIZE, LIGHT)
    try:
        scene.clear(shown.centre, shown.radius, Gloss.of(of))
        scene.apply(shown.uploads(surface.refresh()))
        angle = math.radians(10.0)
        away = 0.5 * SIZE[1] / scale / math.tan(0.5 * angle)
        at = offset * across
        scene.set_camera(Camera(at + np.array([0.0, 0.0, away]), at, along, angle))
        return scene.draw(fine=True)[..., 1].astype(np.float64)
    finally:
        scene.close()


def measured(pixels: NDArray) -> tuple[NDArray, NDArray]:
    """Where the edge is in each row, px, and over how many pixels it goes from 10 to 90 %."""
    dark, bright = pixels.min(), np.quantile(pixels, 0.98)
    share = np.clip((pixels - dark) / (bright - dark), 0.0, 1.0)
    places = [
        [float(np.interp(level, np.maximum.accumulate(row), np.arange(len(row)))) for row in share]
        for level in (0.1, 0.5, 0.9)
    ]
    low, middle, high = np.array(places)
    return middle, high - low


def waves_at_pitch(places: NDArray, scale: float) -> float:
    """Deviation of the edge's place in waves as long as the mesh's pitch, mm."""
    rows = np.arange(len(places))
    away = places - np.polyval(np.polyfit(rows, places, 1), rows)
    power = np.abs(np.fft.rfft(away)) ** 2
    length = len(places) / scale / np.maximum(rows[: len(power)], 1e-9)
    chosen = (length > PITCHES[0]) & (length < PITCHES[1])
    return float(np.sqrt(2.0 * power[chosen].sum()) / len(places) / scale)


@pytest.mark.parametrize("scale", long_but([15.0], [15.0, 60.0]))
@settings(max_examples=4, deadline=None)
@given(turn=st.floats(0.0, 2.0 * math.pi), offset=st.floats(-1.0, 1.0))
def test_an_edge_is_two_pixels_wide_in_pictures(surface, scale, turn, offset) -> None:
    paint_band(surface, turn, offset, 100.0)
    places, widths = measured(flat(surface, turn, offset, scale, edges_of(surface)))
    assert np.quantile(widths, 0.9) < 2.2
    assert abs(places.mean() - SIZE[0] / 2) < 0.01 * scale + 0.8
    assert waves_at_pitch(places, scale) < 0.017
    blurred = measured(flat(surface, turn, offset, scale, None))[1]
    assert np.median(blurred) > 0.12 * scale  # what it would be without


@pytest.mark.parametrize("scale", [15.0, 60.0])
@settings(max_examples=2, deadline=None)
@given(turn=st.floats(0.0, 2.0 * math.pi), offset=st.floats(-1.0, 1.0))
def test_an_edge_is_two_pixels_wide_in_the_window(surface, scale, turn, offset) -> None:
    paint_band(surface, turn, offset, 100.0)
    places, widths = measured(live(surface, turn, offset, scale))
    assert np.quantile(widths, 0.9) < 2.6
    assert waves_at_pitch(places, scale) < 0.017


def test_paper_is_seen_where_edges_are_sharp(surface) -> None:
    paint_band(surface, 0.3, 0.0, 100.0)
    edges = edges_of(surface)
    pictures = (
        flat(surface, 0.3, 0.0, 15.0, edges, (1.0, 1.0)),
        live(surface, 0.3, 0.0, 15.0, "xuan"),
    )
    for picture in pictures:
        _, widths = measured(median_filter(picture, (9, 1)))  # without single pits
        assert np.quantile(widths, 0.9) < 4.0  # fibres beside it
        assert 0.5 < picture[:, SIZE[0] // 2 + 20 :].std() < 4.0
        assert np.median(picture[:, : SIZE[0] // 2 - 20]) < 0.3 * np.median(picture[:, -20:])
    bare = flat(surface, 0.3, 0.0, 15.0, edges)[:, SIZE[0] // 2 + 20 :]
    assert bare.std() < 0.1


def test_ink_has_grain_on_paper_and_nowhere_else(surface) -> None:
    """Greys most, black little; with `--light none`, which draws no paper, and on glaze none."""
    levels = {}
    for coats in (0.0, 0.05, 0.15, 2.0):
        paint_band(surface, 0.3, 0.0, 100.0)
        surface.ink.amounts[:] *= 0.5 * coats
        surface.ink.coverage[:] *= coats > 0.0
        surface.touch(np.arange(surface.n_vertices, dtype=np.int32))
        surface.refresh()
        edges, inked = edges_of(surface), (slice(None), slice(SIZE[0] // 4, SIZE[0] // 2 - 10))
        papers = (NO_PAPER, Gloss.of("xuan").paper, Gloss.of("sized xuan").paper)
        plain, grained, on_glue = (flat(surface, 0.3, -2.0, 15.0, edges, p)[inked] for p in papers)
        window = live(surface, 0.3, -2.0, 15.0, "xuan")[inked]
        assert plain.std() < 0.3
        assert live(surface, 0.3, -2.0, 15.0)[inked].std() < 0.5
        assert abs(grained.mean() - plain.mean()) < 3.0
        levels[coats] = grained.std(), window.std()
        if coats in (0.05, 0.15):  # as in washes on album leaves that drink, and on crisp ones
            assert 0.4 < on_glue.std() / grained.std() < 0.6
    for bare, pale, grey, black in zip(*levels.values(), strict=True):
        assert bare < 2.5
        assert black < 2.5
        assert 5.0 < pale < 12.0
        assert 9.0 < grey < 16.0


def test_dark_ink_has_single_pits_and_little_other_grain(surface) -> None:
    """Photographs and scans of it deviate by 2 to 3 codes, their noise included."""
    paint_band(surface, 0.3, 0.0, 100.0)
    surface.ink.amounts[:] *= 0.2
    surface.touch(np.arange(surface.n_vertices, dtype=np.int32))
    surface.refresh()
    ink = flat(surface, 0.3, -2.0, 15.0, edges_of(surface), (1.0, 1.0))[
        :, SIZE[0] // 4 : SIZE[0] // 2 - 10
    ]
    fine = ink - gaussian_filter(ink, 3.0)
    assert 25.0 < ink.mean() < 45.0
    assert 0.4 < fine.std() < 3.0
    assert fine.max() > 5.0 * fine.std()


def test_fibres_carry_ink_on_where_it_grows_paler(surface) -> None:
    """As from the core of ink that has spread to its halo, all of it covered."""
    across = surface.paint_mesh.vertices[:, :2] @ np.array([math.cos(0.3), math.sin(0.3)])
    n = surface.n_vertices
    surface.ink.coverage[:n] = 1.0
    surface.ink.amounts[:n, 0] = np.interp(across, [-0.5, 0.5], [0.5, 0.02])
    surface.touch(np.arange(n, dtype=np.int32))
    surface.refresh()
    edges = edges_of(surface)
    for amount, least, most in ((0.0, 0.0, 0.4), (1.0, 1.0, 3.0)):
        picture = flat(surface, 0.3, 0.0, 15.0, edges, (amount, amount))
        level = 0.5 * (np.median(picture[:, :60]) + np.median(picture[:, -60:]))
        ends = (picture < level).sum(axis=1)
        assert least <= (ends - median_filter(ends, 41)).std() < most


def test_bare_paper_is_the_same_to_the_code_where_ink_has_grain(surface, monkeypatch) -> None:
    paint_band(surface, 0.3, 0.0, 100.0)
    bare = np.s_[:, SIZE[0] // 2 + 10 :]
    edges = edges_of(surface)
    seen = [
        picture[bare]
        for read in (Paper.read, property(lambda _: "vec2(0.0)"))
        for _ in [monkeypatch.setattr(Paper, "read", read)]
        for picture in (
            flat(surface, 0.3, 0.0, 15.0, edges, (1.0, 1.0)),
            live(surface, 0.3, 0.0, 15.0, "xuan"),
        )
    ]
    np.testing.assert_array_equal(seen[:2], seen[2:])


def test_edges_have_teeth_of_the_paper_that_are_finer_than_vertices(surface) -> None:
    """Without any the edge of this band is straight."""
    paint_band(surface, 0.3, 0.0, 100.0)
    edges = edges_of(surface)
    for amount, least, most in ((0.0, 0.0, 0.4), (1.0, 0.5, 2.0)):
        picture = flat(surface, 0.3, 0.0, 15.0, edges, (amount, amount))
        ends = (picture < 0.5 * np.median(picture[:, -20:])).sum(axis=1)
        teeth = ends - median_filter(ends, 41)
        assert least <= teeth.std() < most


def test_from_afar_and_inside_all_is_as_interpolated(surface) -> None:
    paint_band(surface, 0.3, 0.0, 100.0)
    edges = edges_of(surface)
    plain = flat(surface, 0.3, 0.0, 0.5, None)
    np.testing.assert_allclose(flat(surface, 0.3, 0.0, 0.5, edges), plain, atol=1.0)
    inside = flat(surface, 0.3, -20.0, 15.0, edges), flat(surface, 0.3, -20.0, 15.0, None)
    np.testing.assert_array_equal(*inside)


def test_a_line_thinner_than_the_mesh_is_not_lost(surface) -> None:
    paint_band(surface, 0.3, 0.0, 0.11)  # covers no vertex's area by half
    pixels = flat(surface, 0.3, 0.0, 30.0, edges_of(surface))
    middle = pixels[:, SIZE[0] // 2 - 8 : SIZE[0] // 2 + 8]
    assert np.mean(middle.min(axis=1) < 0.5 * pixels.max()) > 0.5


def test_codes_come_out_of_numbers_as_they_were() -> None:
    codes = np.array([[255, 254, 253], [0, 1, 255], [0, 0, 0]], np.uint8)
    numbers = packed(codes)[:, 0].astype(np.int64)
    np.testing.assert_array_equal(
        np.stack([numbers >> 16, numbers >> 8 & 255, numbers & 255], 1), codes
    )


@settings(max_examples=5, deadline=None)
@given(places=st.lists(st.tuples(*[st.floats(-8.0, 8.0)] * 2), min_size=2, max_size=5))
def test_what_is_followed_is_what_would_be_computed_anew(places) -> None:
    """While paint comes, and the mesh is refined below it, and when it goes again."""
    surface = PaintedSurface(paint3d.load_mesh("bowl"), 2.0)
    surface.column_of(load_pigment("pine soot"))
    edges, cells = LiveEdges(surface), surface.paint_mesh.arrays
    edges.follow(surface.refresh())
    for k, (x, y) in enumerate(places):
        if k == 1:
            surface.refine_all()
        cells = surface.paint_mesh.vertices
        away = np.hypot(cells[:, 0] - 4.0 * x, cells[:, 1] - 4.0 * y)
        ids = np.flatnonzero(away < 9.0).astype(np.int32)
        surface.ink.coverage[ids] = 0.0 if k == 3 else np.clip((8.0 - away[ids]) / 2.0, 0.0, 1.0)
        surface.ink.amounts[ids, 0] = surface.ink.coverage[ids]
        surface.touch(ids)
        edges.follow(surface.refresh())
    every = np.arange(surface.n_vertices, dtype=np.int32)
    anew = edge_shares(surface.paint_mesh.leaf_faces(), surface.coverage_codes())
    np.testing.assert_allclose(edges.shares(every), anew, atol=1.0)
