"""Layers: each lies on those below as if they had dried first."""

import random
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.app.model.document import Document
from paint3d.colour.difference import delta_e, lab_from_srgb
from paint3d.colour.kernels.glazing import GROUNDS, see_through
from paint3d.colour.wet_look import shine_of_inks
from paint3d.errors import InputError, LayerError, Paint3DError, SessionError
from paint3d.files.load import load_mesh
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.sheen import PLAIN_SHINE
from paint3d.surface.state import restore_surface, surface_state
from tests.support.app.hands import line, paint, same_vertices, small_plane
from tests.support.cases import long_but
from tests.support.examples import examples

ACROSS, ALONG = ((-20, 0), (20, 0)), ((0, -20), (0, 20))


def shown(document):
    return document.surface.srgb.copy()


def differences(one, two):
    n = min(len(one), len(two))
    return delta_e(lab_from_srgb(one[:n] / 255.0), lab_from_srgb(two[:n] / 255.0))


def coloured_plane():
    plane = load_mesh("plane")
    red = np.tile(np.uint8([200, 120, 90]), (plane.n_vertices, 1))
    return TriangleMesh(plane.vertices, plane.faces, red, "plane")


def refined(mesh):
    """A painting whose vertices are all there, so that they have the same numbers in another."""
    document = small_plane(2.5, mesh=mesh)
    document.surface.refine_all()
    return document


def dried_then_glazed(mesh="plane"):
    """Cinnabar over soot that has dried, on one layer: how it must look."""
    document = refined(mesh)
    paint(document, *ACROSS)
    document.dry()
    document.dip("cinnabar")
    paint(document, *ALONG)
    return shown(document)


@pytest.mark.parametrize("mesh", ["plane", coloured_plane()], ids=["plain", "coloured"])
@pytest.mark.parametrize("dried", [False, True])
@pytest.mark.parametrize("first", ["lower", "upper"])
def test_a_layer_glazes_over_what_is_below_whichever_was_painted_first(mesh, dried, first):
    wanted = dried_then_glazed(mesh)
    document = refined(mesh)
    document.add_layer("over")
    for place in [0, 1] if first == "lower" else [1, 0]:
        document.select_layer(place)
        document.dip(["pine soot", "cinnabar"][place])
        paint(document, *[ACROSS, ALONG][place])
        if dried:
            document.dry()
    apart = differences(shown(document), wanted)  # a step of a code is up to 0.7, seldom two
    assert apart.max() < (1.5 if dried else 1.0)
    assert apart.sum() < 0.3 * np.count_nonzero(document.surface.painted)
    assert differences(shown(document), shown(refined(mesh))).max() > 30.0


def test_hiding_and_showing_brings_the_same_colours_back():
    document = small_plane()
    bare = shown(document)
    paint(document, *ACROSS)
    lower = shown(document)
    document.add_layer()
    document.dip("cinnabar")
    paint(document, *ALONG)
    both = shown(document)
    document.set_visible(1, False)
    alone = shown(document)[: len(lower)].astype(int)  # by bands, not by the table of one ink
    assert np.abs(alone - lower).max() <= 1
    document.set_visible(0, False)
    np.testing.assert_array_equal(shown(document)[: len(bare)], bare)
    document.set_visible(0)
    document.set_visible(1)
    np.testing.assert_array_equal(shown(document), both)


def test_order_matters_and_comes_back():
    document = small_plane()
    document.dip("cinnabar")
    paint(document, *ACROSS)
    document.add_layer()
    document.dip("pine soot")
    paint(document, *ALONG)
    below = shown(document)
    document.move_layer(1, 0)
    assert [layer.name for layer in document.layers] == ["2", "1"]
    assert differences(shown(document), below).max() > 5.0
    document.undo()
    np.testing.assert_array_equal(shown(document), below)


def test_undo_brings_a_removed_layer_back_with_its_ink():
    document = small_plane()
    paint(document, *ACROSS)
    document.dry()
    document.add_layer()
    paint(document, *ALONG)
    before, ledger = shown(document), document.painter.ledger()
    document.remove_layer(0)
    assert document.painter.ledger()["dry"] == 0.0
    close(document)
    assert len(document.layers) == 1
    document.undo()
    np.testing.assert_array_equal(shown(document), before)
    assert document.painter.ledger() == ledger
    document.redo()
    assert len(document.layers) == 1
    close(document)


def close(document):
    accounts = document.painter.ledger()
    loaded = accounts.pop("loaded")
    assert sum(accounts.values()) == pytest.approx(loaded, rel=1e-6)


ACTIONS = st.sampled_from(
    ["stroke", "stroke", "stroke", "erase", "dry", "blot", "time", "add", "copy", "merge", "remove",
     "up", "down", "select", "dip", "opacity", "multiply"]
)  # fmt: skip


@settings(deadline=None, max_examples=examples(25))
@given(st.lists(st.tuples(ACTIONS, st.integers(0, 3), st.floats(-20, 20)), max_size=9))
def test_undo_leads_back_through_layers_to_the_bit(actions):
    document = small_plane(material="xuan")
    for ink in ("cinnabar", "pine soot"):
        document.dip(ink)
    seen = [everything(document)]
    for action, place, y in actions:
        done = len(document.steps.done)
        place = min(place, len(document.layers) - 1)
        if action == "stroke":
            paint(document, (-15, y), (15, -y), n=8)
        elif action == "dry":
            document.dry()
        elif action == "time":
            document.let_time_pass(0.3)
        elif action == "dip":
            document.swap_inks()
        elif action == "select":
            document.select_layer(place)
        elif action == "add":
            document.add_layer(place=place)
        elif action == "erase":
            document.begin_stroke(erase=True)
            document.feed(line((y, -15), (-y, 15), n=8))
            document.end_stroke()
        elif action == "blot":
            document.blot()
        elif action == "copy":
            document.duplicate_layer(place)
        elif action == "merge":
            if place:
                document.merge_layer(place)
        elif action == "opacity":
            document.set_opacity(place, abs(y) / 20.0)
        elif action == "multiply":
            document.set_blend(place, "multiply")
        elif len(document.layers) > 1 and action == "remove":
            document.remove_layer(place)
        elif len(document.layers) > 1:
            document.move_layer(place, 0 if action == "down" else len(document.layers) - 1)
        close(document)
        if len(document.steps.done) == done:
            seen[-1] = everything(document)
        else:
            seen.append(everything(document))
    for k in [*range(len(seen) - 2, -1, -1), *range(1, len(seen)), *range(len(seen) - 2, -1, -1)]:
        document.undo() if len(document.steps.done) > k else document.redo()
        if k:
            same(everything(document), seen[k])
        close(document)


def everything(document):
    surface = document.surface
    names = tuple(layer.name for layer in document.layers)
    n, at = surface.n_vertices, document.active_layer
    return names, at, surface.amounts.copy(), surface.coverage.copy(), surface.srgb[:n].copy()


def same(now, then):
    assert now[:2] == then[:2]
    for one, two in zip(now[2:], then[2:], strict=True):
        np.testing.assert_array_equal(one[: len(two)], two)


def test_water_waits_on_the_layers_that_are_not_painted_on():
    document = small_plane(material="xuan")
    paint(document, *ACROSS)
    document.let_time_pass(0.3)
    surface = document.surface
    water, amounts = surface.flow.water, surface.amounts.copy()
    document.add_layer()
    assert surface.flow.water == 0.0
    paint(document, *ALONG)
    document.let_time_pass(30.0)
    document.select_layer(0)
    assert surface.flow.water == water > 0.0
    np.testing.assert_array_equal(surface.amounts[: len(amounts)], amounts)
    document.let_time_pass(1.0)
    assert surface.flow.water < water


def test_a_locked_or_hidden_layer_takes_no_paint():
    document = small_plane()
    document.set_locked(0)
    for action in (document.begin_stroke, document.dry):
        with pytest.raises(LayerError) as refused:
            action()
        assert document.layers[0].name in refused.value.message.fields["layer"]
    document.set_locked(0, False)
    document.set_visible(0, False)
    with pytest.raises(LayerError, match="hidden"):
        document.begin_stroke()


def test_a_stroke_that_was_refused_passes_over_its_samples():
    document = small_plane()
    document.set_locked(0)
    with pytest.raises(LayerError):
        document.begin_stroke()
    document.feed(line((-20, 0), (20, 0)))
    document.set_locked(0, False)  # half a stroke would be worse than none
    document.feed(line((20, 0), (-20, 0)))
    document.end_stroke()
    assert not document.surface.painted.any()
    assert not len(document.strokes)
    paint(document, (-20, 0), (20, 0))
    assert document.surface.painted.any()
    document.begin_stroke()
    document.feed(line((0, -20), (0, 20)))
    document.undo()  # in the middle of it: the hand goes on for a while
    document.feed(line((0, 20), (0, -20), t0=10_000_000_000))
    document.end_stroke()
    assert len(document.strokes) == 1
    with pytest.raises(InputError, match="begin_stroke"):
        document.feed(line((0, 0), (1, 0)))


def test_what_is_no_layer_is_told():
    document = small_plane()
    for action in (
        lambda: document.select_layer(1),
        lambda: document.remove_layer(0),
        lambda: document.move_layer(0, 2),
        lambda: document.add_layer(place=5),
        lambda: document.rename_layer(0, "  "),
        lambda: document.rename_layer(-1, "x"),
    ):
        with pytest.raises(InputError, match="expected"):
            action()
    assert len(document.layers) == 1


def test_a_colour_is_picked_from_the_highest_layer_that_shows():
    document = small_plane()
    paint(document, *ACROSS)
    document.add_layer()
    document.dip("cinnabar")
    paint(document, *ALONG)
    own = document.surface.coverage.copy()
    document.select_layer(0)
    centre = int(np.argmax(own * document.surface.coverage))
    assert document.pick_colour(centre) == {"cinnabar": 1.0}
    document.set_visible(1, False)
    assert document.pick_colour(centre) == {"pine soot": 1.0}


def test_dry_paint_of_a_layer_is_picked_after_another_pigment_has_come():
    document = small_plane()
    paint(document, *ACROSS)
    centre = int(np.argmax(document.surface.coverage))
    document.dry()
    document.add_layer()
    document.dip("cinnabar")
    paint(document, *ALONG)
    document.set_visible(1, False)
    assert document.pick_colour(centre) == {"pine soot": 1.0}


@settings(deadline=None, max_examples=60)
@given(st.floats(0.01, 8.0), st.floats(0.0, 8.0), st.floats(0.0, 3.0), st.floats(0.1, 1.0))
def test_three_grounds_tell_what_shows_over_any(k, s, coats, cover):
    from paint3d.colour.layers import layer_reflectance

    grounds = np.array([*GROUNDS, *np.linspace(0.03, 1.0, 28)])
    layer = layer_reflectance(np.full(31, k), np.full(31, s), np.full(31, coats), grounds)
    wanted = (1.0 - cover) * grounds + cover * layer
    rows = [np.full((1, 31), np.rint(wanted[i] * 65535), np.uint16) for i in range(3)]
    spectra = np.rint(grounds * 65535).astype(np.uint16)[None]
    see_through(np.zeros(1, np.int32), np.zeros(1, np.int32), *rows, spectra)
    apart = np.abs(spectra[0] / 65535.0 - wanted).max()
    assert apart < (1e-3 if cover == 1.0 else 0.02)


def test_a_session_keeps_layers_wet_and_dry_and_the_strokes(tmp_path):
    document = small_plane(material="xuan")
    paint(document, *ACROSS)
    document.add_layer("二")
    document.dip("cinnabar")
    paint(document, *ALONG)
    document.let_time_pass(0.5)
    document.add_layer("top")
    paint(document, (-20, -10), (20, 10))
    document.dry()
    document.set_visible(1, False)
    document.set_locked(2)
    document.select_layer(1)
    document.save(tmp_path / "a.p3d")
    document.save(tmp_path / "b.p3d")
    assert (tmp_path / "a.p3d").read_bytes() == (tmp_path / "b.p3d").read_bytes()
    again = Document.open(tmp_path / "a.p3d")
    assert again.layers == document.layers
    assert again.active_layer == 1
    for place in (1, 0, 2):
        for each in (document, again):
            each.select_layer(place)
            each.set_visible(1)
        same_vertices(again.surface, document.surface)
    assert [s.layer for s in again.strokes] == ["1", "二", "top"]
    assert [s.duration_s for s in again.strokes] == [s.duration_s for s in document.strokes]
    assert again.strokes[1].ink == {"cinnabar": 1.0}
    close(again)
    again.save()
    assert Document.open(tmp_path / "a.p3d").layers == again.layers


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"active": 5}, "layer 5 of 2"),
        ({"active": True}, "layer True"),
        ({"layers": [{"name": "a"}, {"name": "b"}]}, "incomplete near|described by"),
        ({"layers": [{"name": "", "visible": True, "locked": False}] * 2}, "name"),
        ({"layers": [{"name": "a", "visible": 1, "locked": False}] * 2}, "described by"),
        ({"layers": 7}, "incomplete near"),
    ],
)
def test_bad_layers_of_a_session_are_told(changes, message):
    document = small_plane()
    paint(document, *ACROSS)
    document.add_layer()
    state = surface_state(document.surface) | changes
    with pytest.raises(SessionError, match=message):
        restore_surface(document.surface.source, state)


def test_redo_paints_on_its_own_layer_whatever_was_chosen_since():
    document = small_plane()
    document.add_layer("over")
    paint(document, *ACROSS)
    then = everything(document)
    document.undo()
    document.select_layer(0)
    document.redo()
    same(everything(document), then)


@pytest.mark.parametrize(
    ("seed", "material"),
    long_but([(1, "porcelain"), (2, "xuan")], [(0, "porcelain"), (1, "porcelain"), (2, "xuan")]),
)
def test_how_it_shines_is_followed_whatever_is_done(seed, material) -> None:
    """Layers added, hidden, moved and removed, other pigments, ink that dries, all of it undone."""
    chance, document = random.Random(seed), small_plane(material=material)
    surface, time_ns = document.surface, 1_000_000
    watch = surface.watch_wet()

    def stroke() -> None:
        nonlocal time_ns
        ends = [(chance.uniform(-20, 20), chance.uniform(-20, 20)) for _ in range(2)]
        document.dip(chance.choice(["pine soot", "oil soot", "cinnabar"]))
        samples = line(*ends, n=8, t0=time_ns)
        time_ns = samples[-1].time_ns + 10_000_000
        document.begin_stroke()
        document.feed(samples)
        document.end_stroke()

    def place() -> int:
        return chance.randrange(len(document.layers))

    actions = [
        stroke, stroke, stroke, document.dry, document.undo, document.undo, document.redo,
        lambda: document.follow_time(chance.choice([0.05, 5.0, 800.0])),
        lambda: document.add_layer("above", place() + 1), lambda: document.remove_layer(place()),
        lambda: document.move_layer(place(), place()), lambda: document.select_layer(place()),
        lambda: document.set_visible(place(), chance.random() < 0.7),
    ]  # fmt: skip
    n_shining = 0
    for _ in range(40):
        with suppress(Paint3DError):
            chance.choice(actions)()
        watch.follow(document.refresh())
        every = np.arange(surface.n_vertices)
        shine, look = np.zeros(surface.n_vertices), surface.wet_look
        if look is not None:
            dried = shine_of_inks(surface.material.seen_roughness, look.gloss, look.hidden)
            shine = dried + look.film * (1.0 - dried)
        found = PLAIN_SHINE + 0.0 * shine if watch.is_plain else watch.shine(every).astype(float)
        np.testing.assert_allclose((found - PLAIN_SHINE) / 127.0, shine, atol=0.09)
        n_shining += bool(np.abs(shine).max() > 0.3)
    assert n_shining > 10
