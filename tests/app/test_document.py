"""A painting in the studio: strokes, the way back, files."""

import dataclasses

import numpy as np
import pytest

from paint3d.app.model.document import Document
from paint3d.colour.pigments import load_pigment
from paint3d.errors import ExportError, InputError, SessionError
from paint3d.files.project.session import load_session, save_session
from paint3d.painter.ink_time import INK_STEP_NS
from tests.support.app.hands import line, paint, same_vertices, sample, small_plane
from tests.support.app.repeating import repeated


def test_a_stroke_paints_and_is_remembered():
    document = small_plane()
    paint(document, (-20, 0), (20, 0))
    ids = document.refresh()
    assert len(ids) > 20
    assert document.surface.codes[ids].min() < 100
    assert not len(document.refresh())
    (stroke,) = document.strokes
    assert stroke.duration_s == pytest.approx(0.095)
    assert (stroke.brush.name, stroke.ink) == ("full", {"pine soot": 1.0})
    assert len(stroke.samples) == 20


def test_colours_asked_for_elsewhere_are_still_told(tmp_path):
    document = small_plane()
    paint(document, (-20, 0), (20, 0))
    assert document.surface.codes.min() > 200
    document.export(tmp_path / "plane.ply")
    assert len(document.refresh()) > 20


def test_samples_need_a_stroke():
    document = small_plane()
    with pytest.raises(InputError, match="begin_stroke"):
        document.feed(line((0, 0), (1, 0)))
    document.begin_stroke()
    for action in (document.begin_stroke, document.swap_inks, document.dry):
        with pytest.raises(InputError, match="during a stroke"):
            action()


def test_a_stroke_without_samples_is_no_step():
    document = small_plane()
    document.begin_stroke()
    document.end_stroke()
    assert not document.can_undo
    assert not document.strokes


def test_a_cancelled_stroke_has_never_been():
    document = small_plane()
    ledger = document.painter.ledger()
    document.begin_stroke()
    document.feed(line((-20, 0), (20, 0)))
    document.cancel_stroke()
    assert document.painter.ledger() == ledger
    assert not document.surface.painted.any()
    assert not document.can_undo
    assert not document.can_redo


def test_undo_keeps_the_brush_that_was_chosen_last():
    document = small_plane()
    paint(document, (-20, 0), (20, 0))
    document.swap_inks()
    document.set_brush("xiaobaiyun")
    document.undo()
    assert not document.surface.painted.any()
    assert document.painter.dipped == "cinnabar"
    assert document.painter.brush.name == "xiaobaiyun"
    accounts = document.painter.ledger()
    assert accounts["loaded"] == pytest.approx(accounts["in_brush"])
    document.redo()
    accounts = document.painter.ledger()
    assert accounts["loaded"] == pytest.approx(sum(accounts.values()) - accounts["loaded"])


def test_the_history_goes_to_any_stroke():
    document = small_plane()
    seen = [document.surface.srgb[: document.surface.paint_mesh.n_base_vertices].copy()]
    for y in (-20, 0, 20):
        paint(document, (-20, y), (20, y))
        seen.append(document.surface.srgb.copy())
    for upto in (1, 3, 0, 2):
        document.replay_history(upto)
        assert len(document.strokes) == upto
        n = len(seen[upto])
        np.testing.assert_array_equal(document.surface.srgb[:n], seen[upto])
    with pytest.raises(InputError, match="expected 0 to 3"):
        document.replay_history(4)


def test_x_swaps_inks():
    document = small_plane()
    document.swap_inks()
    assert document.painter.ink.name == "cinnabar"
    document.swap_inks()
    assert document.painter.ink.name == "pine soot"


def test_a_colour_is_picked_wet_or_dry():
    document = small_plane(ink={"pine soot": 0.25, "cinnabar": 0.75})
    paint(document, (-20, 0), (20, 0))
    vertex = int(np.argmax(document.surface.coverage))
    for _ in range(2):
        document.dip("pine soot")
        found = document.pick_colour(vertex)
        assert found == pytest.approx({"pine soot": 0.25, "cinnabar": 0.75}, abs=1e-6)
        document.dry()
    bare = int(np.argmin(document.surface.painted))
    assert document.pick_colour(bare) is None
    with pytest.raises(InputError, match="vertex"):
        document.pick_colour(10**7)


def test_strokes_become_a_recording_that_paints_the_same():
    document = small_plane()
    paint(document, (-20, -10), (20, -10))
    document.dip()
    paint(document, (-20, 10), (20, 10))
    recording = document.recording()
    again = small_plane()
    again.painter.replay(recording)
    np.testing.assert_allclose(again.surface.amounts, document.surface.amounts, atol=1e-5)
    assert again.painter.ledger() == pytest.approx(document.painter.ledger(), rel=1e-6, abs=1e-3)


def test_strokes_keep_their_times_in_a_recording_unless_a_clock_began_anew():
    document = small_plane()
    starts = [5_003_000_000, 5_160_000_000, 20_000_000, 150_000_000]  # strokes take 95 ms
    for k, t0 in enumerate(starts):
        paint(document, (-20, 6 * k), (20, 6 * k), t0=t0)
    paint(document, (-20, 30), (20, 30), t0=5_400_000_000)
    times = document.recording().time_ns
    first = np.flatnonzero(np.diff(times, prepend=0) > 5_000_000)
    begun = times[first]
    begun[0] += 1_000_000  # its dip comes before it
    np.testing.assert_array_equal(begun[:2], starts[:2])
    moved = begun[2:] - [*starts[2:], 5_400_000_000]
    assert moved[0] == moved[1] > 5_000_000_000  # of one clock
    assert moved[2] == moved[0]
    assert not (moved % INK_STEP_NS).any()


def test_saving_needs_a_name_and_keeps_everything(tmp_path):
    document = small_plane()
    with pytest.raises(ExportError, match="no file yet"):
        document.save()
    with pytest.raises(ExportError, match=r"\.p3d"):
        document.save(tmp_path / "a.glb")
    document.set_brush("xiaobaiyun")
    paint(document, (-20, 0), (20, 0))
    assert document.modified
    document.save(tmp_path / "a.p3d")
    assert not document.modified
    again = Document.open(tmp_path / "a.p3d")
    assert again.painter.brush == document.painter.brush
    assert again.painter.in_brush() == document.painter.in_brush()
    paint(document, (-20, 30), (20, 30))
    paint(again, (-20, 30), (20, 30))
    np.testing.assert_array_equal(
        np.sort(again.surface.amounts, axis=0), np.sort(document.surface.amounts, axis=0)
    )


def test_an_opened_painting_goes_on_with_what_the_brush_was_dipped_in(tmp_path):
    document = small_plane()
    document.dip({"pine soot": 1.0, "water": 3.0})
    document.dip({"cinnabar": 1.0}, 0.5)
    document.dip({"pine soot": 2.0, "water": 1.0}, 0.2)
    paint(document, (-20, 0), (20, 0))
    document.save(tmp_path / "a.p3d")
    again = Document.open(tmp_path / "a.p3d")
    assert again.painter.dipped == {"pine soot": 2.0, "water": 1.0}
    for each in (document, again):
        each.dip()
    np.testing.assert_array_equal(again.surface.ink.load, document.surface.ink.load)
    paint(again, (-20, 9), (20, 9))
    again.undo()
    assert [stroke.ink for stroke in again.strokes] == [document.strokes[0].ink]


def test_brushes_of_one_name_are_told_apart_when_a_painting_is_opened(tmp_path):
    document = small_plane()
    own = dataclasses.replace(document.painter.brush, name="mine")
    brushes = [own, dataclasses.replace(own, hardness=0.4), own]
    for y, brush in zip((-20, 0, 20), brushes, strict=True):
        document.set_brush(brush)
        paint(document, (-20, y), (20, y))
    document.save(tmp_path / "a.p3d")
    assert [stroke.brush for stroke in Document.open(tmp_path / "a.p3d").strokes] == brushes


def test_what_cannot_be_opened_is_told(tmp_path):
    (tmp_path / "bad.p3d").write_bytes(b"no session")
    with pytest.raises(SessionError, match=r"bad\.p3d"):
        Document.open(tmp_path / "bad.p3d")


def test_bad_samples_are_refused_and_the_stroke_goes_on():
    document = small_plane()
    document.begin_stroke()
    samples = line((-20, 0), (20, 0))
    document.feed(samples[:10])
    for bad in (samples[5:12], samples[10:12][::-1], [sample(10**10, 0, 0, None)]):
        with pytest.raises(InputError, match=r"later|pressure"):
            document.feed(bad)
    document.feed(samples[10:])
    document.end_stroke()
    alone = small_plane()
    paint(alone, (-20, 0), (20, 0))
    np.testing.assert_array_equal(document.surface.amounts, alone.surface.amounts)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"brush": {"name": "x"}}, "no brush"),
        ({"brush": "besom"}, "besom"),
        ({"dipped": 5}, "an ink is 5"),
        ({"dipped": {"pine soot": -1.0}}, "weight of pine soot"),
        ({"inks": [3, 4]}, "an ink is 3"),
        ({"inks": {"a": 1}}, "expected two"),
        ({"azimuth": 7}, "azimuth is 7"),
        ({"brushes": {"full": {"hair": 1}}}, "no brush"),
    ],
)
def test_settings_from_strangers_are_checked(tmp_path, changes, message):
    document = small_plane()
    paint(document, (-20, 0), (20, 0))
    document.save(tmp_path / "a.p3d")
    session = load_session(tmp_path / "a.p3d")
    session.settings.update(changes)
    save_session(session, tmp_path / "b.p3d")
    with pytest.raises(SessionError, match=message):
        Document.open(tmp_path / "b.p3d")


def test_settings_that_do_not_matter_are_passed_over(tmp_path):
    document = small_plane()
    paint(document, (-20, 0), (20, 0))
    document.save(tmp_path / "a.p3d")
    session = load_session(tmp_path / "a.p3d")
    session.settings.update({"unit": "parsec", "brushes": None, "inks": None})
    save_session(session, tmp_path / "b.p3d")
    again = Document.open(tmp_path / "b.p3d")
    assert again.unit == "mm"
    again.swap_inks()
    assert again.painter.ink.name == "cinnabar"


def test_an_ink_of_ones_own_is_at_hand_again(tmp_path):
    document = small_plane()
    own = dataclasses.replace(load_pigment("cinnabar"), name="my red")
    document.dip({own: 1.0})
    paint(document, (-20, 0), (20, 0))
    document.swap_inks()
    document.save(tmp_path / "a.p3d")
    again = Document.open(tmp_path / "a.p3d")
    again.swap_inks()
    assert again.painter.ink.name == "my red"


def test_a_painting_is_replayed_from_its_strokes_also_those_of_earlier_sittings(tmp_path):
    document = small_plane()
    paint(document, (-20, 0), (20, 0))
    document.add_layer("over")
    document.dip({"cinnabar": 0.5, "water": 0.5})
    document.scale_brush(0.7)
    paint(document, (0, -20), (0, 20))
    paint(document, (5, -20), (5, 20))
    document.save(tmp_path / "a.p3d")
    opened = Document.open(tmp_path / "a.p3d")
    again = repeated(opened)
    same_vertices(again.surface, document.surface)
    assert [layer.name for layer in again.layers] == ["1", "over"]
    assert len(repeated(opened, 1).strokes) == 1


def test_a_stroke_knows_whether_the_brush_was_dipped_before_it():
    document = small_plane()
    paint(document, (-20, 0), (20, 0))
    paint(document, (-20, 9), (20, 9))
    document.dip()
    paint(document, (-20, 18), (20, 18))
    assert [stroke.dipped_since_stroke for stroke in document.strokes] == [True, False, True]
    document.undo()
    paint(document, (-20, 27), (20, 27))
    assert document.strokes[-1].dipped_since_stroke
    document.undo()
    document.undo()
    document.swap_inks()
    document.undo()
    paint(document, (-20, 27), (20, 27))
    assert [stroke.dipped_since_stroke for stroke in document.strokes] == [True]
