"""Masks: what is covered keeps what it had, and the ledger closes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.app.model.document import Document
from paint3d.app.model.input.symmetry import MirrorPlane, Symmetry
from paint3d.app.model.mask import AngleMask, Mask, RegionPick, Stencil, face_at, region_faces
from paint3d.errors import InputError
from paint3d.mesh.triangle_mesh import TriangleMesh
from tests.support.app.hands import line, paint, same_vertices, small_plane
from tests.support.examples import examples

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from paint3d.view.camera import picture_axes
from tests.support.app.gestures import drag, live
from tests.support.app.windows import opened, settled

UP = (0.0, 0.0, 1.0)


def roof():
    """Two slopes that meet in a ridge at x = 0, and a flat piece apart."""
    vertices = [(x, y, 10.0 - abs(x) * 0.5) for x in (-40, 0, 40) for y in (-40, 40)]
    vertices += [(x, y, -60.0) for x in (-40, 40) for y in (-40, 40)]
    faces = [(0, 2, 1), (1, 2, 3), (2, 4, 3), (3, 4, 5), (6, 8, 7), (7, 8, 9)]
    return TriangleMesh(np.array(vertices, np.float32), np.array(faces, np.int32), None, "roof")


def close(document):
    accounts = document.painter.ledger()
    loaded = accounts.pop("loaded")
    assert sum(accounts.values()) == pytest.approx(loaded, rel=1e-6)
    return accounts


def test_regions_go_to_creases_or_to_the_end_of_the_piece():
    mesh = Document.new(roof(), 2.0).surface.paint_mesh
    tops = mesh.vertices[mesh.base_faces].mean(axis=1)
    left = int(np.flatnonzero((tops[:, 0] < 0) & (tops[:, 2] > -9))[0])
    slope = region_faces(mesh, RegionPick(left))
    np.testing.assert_array_equal(slope, (tops[:, 0] < 0) & (tops[:, 2] > -30))
    whole = region_faces(mesh, RegionPick(left, "piece"))
    np.testing.assert_array_equal(whole, tops[:, 2] > -30)
    blunt = region_faces(mesh, RegionPick(left, "crease", 60.0))
    np.testing.assert_array_equal(blunt, whole)
    for bad in (lambda: region_faces(mesh, RegionPick(99)), lambda: RegionPick(0, "edge")):
        with pytest.raises(InputError, match="expected"):
            bad()


@pytest.mark.parametrize("inverted", [False, True])
def test_paint_stays_in_the_region(inverted):
    document = Document.new(roof(), 2.0)
    mesh = document.surface.paint_mesh
    vertex = int(np.argmin(mesh.vertices[:, 0] + 100 * (mesh.vertices[:, 2] < -30)))
    document.set_mask(Mask(regions=(RegionPick(face_at(mesh, vertex)),), inverted=inverted))
    document.begin_stroke()
    document.feed(line((-30, 0), (30, 0), n=40))
    document.end_stroke()
    painted = document.surface.painted
    x = document.surface.paint_mesh.vertices[:, 0]
    assert painted.any()
    assert (x[painted] <= 0.0).all() if not inverted else (x[painted] >= 0.0).all()
    close(document)


def test_paint_stays_where_the_surface_looks_the_right_way():
    document = Document.new("sphere", 2.0)
    document.set_mask(Mask(AngleMask(UP, 20.0)))
    top = float(document.surface.source.vertices[:, 2].max())
    document.begin_stroke()
    document.feed(line((-30, 0), (30, 0), n=40, height=top + 35.0))
    document.end_stroke()
    surface = document.surface
    height = surface.paint_mesh.normals[surface.painted] @ UP
    assert len(height)
    assert height.min() >= np.cos(np.radians(20.0)) - 1e-6
    close(document)


def test_paint_stays_where_regions_and_the_angle_both_allow():
    """Triangles that are halved share corners with the new ones, which are the region's, too."""
    document = Document.new("sphere", 1.0)
    top = float(document.surface.source.vertices[:, 2].max())
    document.set_mask(Mask(AngleMask(UP, 20.0), (RegionPick(0, "piece"),)))
    document.begin_stroke()
    document.feed(line((-30, 0), (30, 0), n=40, height=top + 35.0))
    document.end_stroke()
    surface = document.surface
    height = surface.paint_mesh.normals[surface.painted] @ UP
    assert len(height)
    assert height.min() >= np.cos(np.radians(20.0)) - 1e-6


@settings(deadline=None, max_examples=examples(25))
@given(st.lists(st.tuples(st.floats(-20, 20), st.floats(-20, 20)), min_size=1, max_size=3))
def test_what_is_covered_keeps_its_ink_wet_or_dry_and_undo_brings_all_back(ends):
    document = small_plane(material="xuan")
    document.painter.surface.ink.transfer["pickup"] = 0.05  # a thirsty brush
    paint(document, (-20, 0), (20, 0), n=10)
    document.let_time_pass(0.2)
    document.steps.end_part()
    before = document.surface.amounts.copy()
    document.dip("cinnabar")
    document.set_mask(Mask(AngleMask((0, 0, -1), 10.0)))  # the plane looks up: all is covered
    for start, end in ends:
        paint(document, (start, -20), (end, 20), n=10)
        n = len(before)
        np.testing.assert_array_equal(document.surface.amounts[:n, :1], before)
        assert not document.surface.amounts[:, 1].any()
        close(document)
    while len(document.strokes) > 1:
        document.undo()
    np.testing.assert_array_equal(document.surface.amounts[: len(before), :1], before)


COVERED = Mask(AngleMask((0, 0, -1), 10.0))  # the plane looks up: all of it


@pytest.mark.parametrize("tuft", ["solid", "two inks", "hairs"])
def test_a_stencil_drinks_no_ink(tuft):
    document = small_plane(brush="feibai" if tuft == "hairs" else "full")
    if tuft == "two inks":
        document.dip({"indigo": 0.1, "water": 0.9})
        document.dip("pine soot", 0.35)
    document.set_mask(COVERED)
    ink = document.surface.ink
    before, reservoirs = ink.load.copy(), ink.reservoirs.copy()
    for k in range(3):
        paint(document, (-30, 5 * k), (30, 5 * k), t0=10_000_000_000 * (k + 1))
    np.testing.assert_allclose(document.surface.ink.load, before, rtol=1e-6)
    assert not document.surface.painted.any()
    assert close(document)["off_surface"] == pytest.approx(0.0, abs=1e-3 * before.sum())
    if tuft == "two inks":
        np.testing.assert_allclose(
            document.surface.ink.reservoirs.sum(axis=1), reservoirs.sum(axis=1), rtol=1e-6
        )
    document.set_mask(Mask())
    paint(document, (-30, 0), (30, 0), t0=90_000_000_000)
    assert document.surface.painted.any()
    close(document)


@settings(deadline=None, max_examples=examples(25))
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.3]))
def test_what_was_painted_through_a_stencil_opens_again(tmp_path_factory, seed, pickup):
    path = tmp_path_factory.getbasetemp() / "stencil.p3d"
    document = small_plane(4.0)
    random = np.random.default_rng(seed)
    for k, mask in enumerate([Mask(), Mask(regions=(RegionPick(0),)), COVERED]):
        document.set_mask(mask)
        document.painter.surface.ink.transfer["pickup"] = pickup
        start, end = random.uniform(-30.0, 30.0, (2, 2))
        paint(document, start, end, t0=10_000_000_000 * (k + 1))
    if pickup == 0.0:
        assert (document.surface.ink.off_surface >= 0.0).all()
    close(document)
    document.save(path)
    again = Document.open(path)
    np.testing.assert_array_equal(again.surface.ink.off_surface, document.surface.ink.off_surface)


def test_images_of_a_stroke_keep_their_own_ink_from_the_stencil():
    document = small_plane()
    document.set_symmetry(Symmetry((MirrorPlane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),)))
    document.set_mask(COVERED)
    before = document.surface.ink.load.copy()
    paint(document, (-30, -5), (-10, 10))
    np.testing.assert_allclose(document.surface.ink.load, before, rtol=1e-6)
    close(document)
    document.set_mask(Mask())
    paint(document, (-30, -5), (-10, 10), t0=10_000_000_000)
    close(document)


@pytest.mark.parametrize("retention", [0.0, 0.05])
@pytest.mark.parametrize("shown", [False, True])
def test_how_samples_come_in_batches_makes_no_difference_under_a_mask(retention, shown):
    ends = []
    for size in (1, 7, 40):
        document = Document.new(roof(), 2.0)
        mesh = document.surface.paint_mesh
        document.surface.ink.transfer["pickup"] = retention
        paint(document, (-30, -10), (30, -10))
        vertex = int(np.argmin(mesh.vertices[:, 0] + 100 * (mesh.vertices[:, 2] < -30)))
        document.set_mask(Mask(regions=(RegionPick(face_at(mesh, vertex)),)))
        samples = line((30, -12), (-30, 8), n=40, t0=10_000_000_000)
        document.begin_stroke()
        for k in range(0, len(samples), size):
            document.feed(samples[k : k + size])
            if shown:
                document.refresh()
        document.end_stroke()
        close(document)
        ends.append(document)
    for other in ends[1:]:
        same_vertices(ends[0].surface, other.surface)
        np.testing.assert_array_equal(ends[0].surface.ink.load, other.surface.ink.load)


def test_what_a_stencil_catches_is_the_same_in_any_order():
    document = small_plane()
    document.begin_stroke()
    document.feed(line((-30, -12), (30, 8), n=40))
    ink = document.surface.ink
    amounts, coverage, load = ink.amounts.copy(), ink.coverage.copy(), ink.load.copy()
    dirty = ink.dirty_ids[: int(ink.n_dirty[0])]
    given, random = set(), np.random.default_rng(4)
    for _ in range(10):
        ink.amounts[:], ink.coverage[:], ink.load[:] = amounts, coverage, load
        dirty[:] = random.permutation(dirty)
        stencil = Stencil(document.surface, COVERED)
        back = stencil.wipe(
            lambda ids: (np.zeros((len(ids), amounts.shape[1])), np.zeros(len(ids)))
        )
        given.add(back.tobytes())
    assert back.sum() > 0.0
    assert len(given) == 1


def test_what_is_no_mask_is_told():
    for bad in (
        lambda: AngleMask((0, 0, 0), 10.0),
        lambda: AngleMask(UP, 181.0),
        lambda: small_plane().set_mask(Mask(regions=(RegionPick(-1),))),
    ):
        with pytest.raises(InputError, match="expected"):
            bad()
    document = small_plane()
    document.set_mask(Mask())
    paint(document, (-20, 0), (20, 0))
    assert document.surface.painted.any()


# -- masks on the screen -----------------------------------------------------------------------


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "sphere", 3.0, "porcelain") as window:
        yield window


def right_half(window) -> Mask:
    """Paint is taken in the right half of the picture."""
    right = picture_axes(window.hand.camera)[0]
    return Mask(AngleMask(tuple(float(x) for x in right), 90.0))


def picture(window) -> np.ndarray:
    settled(window)
    live(0.2)
    window.stage.hide_brush()
    return window.stage.picture(fine=False)[..., :3].astype(int)


def bluer(window, before) -> np.ndarray:
    """(H, W) bool: where the picture was veiled since `before`."""
    change = picture(window) - before
    return (change.sum(axis=2) < -40) & (change[..., 2] > change[..., 0])


def test_a_mask_is_hatched_and_only_while_it_is_there(window) -> None:
    before = picture(window)
    window.workspace.post("set_mask", right_half(window))
    veiled = bluer(window, before)
    height, width = veiled.shape
    left, right = veiled[:, : width // 2].sum(), veiled[:, width // 2 :].sum()
    assert left > 0.1 * height * width
    assert right < 0.02 * left
    row = picture(window)[height // 2, width // 2 - height // 4 : width // 2 - 10].sum(axis=1)
    assert np.abs(np.diff(np.sign(np.diff(np.convolve(row, np.ones(9) / 9, "valid"))))).sum() >= 4
    window.workspace.actions["show_mask"].setChecked(False)
    assert not bluer(window, before).any()
    window.workspace.actions["show_mask"].setChecked(True)
    assert (bluer(window, before) == veiled).mean() > 0.999
    window.workspace.post("set_mask", Mask())
    assert np.abs(picture(window) - before).max() <= 2


def test_a_mask_that_is_gone_is_told(window) -> None:
    window.workspace.actions["mask"].trigger()
    window.workspace.actions["clear_mask"].trigger()
    settled(window)
    assert window.document.mask == Mask()
    assert window.status.message_label.text() == "Paint is taken everywhere"


def test_a_stroke_over_the_stencil_leaves_the_hatching(window) -> None:
    window.workspace.post("set_mask", right_half(window))
    before = picture(window)
    drag(window.canvas, (0.40, 0.5), (0.60, 0.5))
    change = np.abs(picture(window) - before).sum(axis=2)
    width = change.shape[1]
    assert (change[:, width // 2 + 5 :] > 60).sum() > 200
    assert (change[:, : width // 2 - 12] > 60).sum() < 20
    window.workspace.post("set_mask", Mask())
    window.workspace.post("undo")
    settled(window)
