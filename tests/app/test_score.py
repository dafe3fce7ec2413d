"""A sitting is a recording: played again it gives the same painting to the bit."""

from __future__ import annotations

import copy
import json
from dataclasses import fields
from functools import cache
from itertools import chain

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.app.model.commands import COMMANDS, arguments_of, line_of
from paint3d.app.model.document import Document
from paint3d.app.model.input.symmetry import MirrorPlane, RadialSymmetry, Symmetry
from paint3d.app.model.mask import AngleMask, Mask, RegionPick
from paint3d.app.model.score.playing import painted, score_of_strokes
from paint3d.app.model.score.words import Inks, Vocabulary
from paint3d.app.model.stroke_log import recording_of
from paint3d.brush.presets import load_brush
from paint3d.colour.pigments import Pigment
from paint3d.errors import Paint3DError, RecordingError
from paint3d.files.load import load_mesh
from paint3d.recording.recording import Recording
from paint3d.recording.score import (
    Score,
    check_command,
    command_names,
    load_score,
    save_score,
    schema,
    write_score,
)
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.app.hands import line, paint, small_plane
from tests.support.examples import examples

OWN = Pigment(
    "iron gall", "铁胆墨", np.linspace(2.0, 9.0, 31), np.full(31, 0.5), source="a recipe",
    basis="guessed", licence="none", saunderson=True, gloss=0.2, fine=0.3, grain_um=25.0,
)  # fmt: skip
PLACES = st.tuples(st.floats(-18, 18), st.floats(-18, 18))
STROKES = st.builds(
    lambda a, b, press, cut: ("stroke", a, b, press, cut),
    PLACES, PLACES, st.floats(0.2, 0.8), st.sampled_from(["", "", "dip", "wipe", "cancel", "undo"]),
)  # fmt: skip
INKS = st.sampled_from(
    ["cinnabar", {"pine soot": 0.2, "water": 0.8}, {OWN: 1.0}, {"indigo": 1.0, OWN: 2.0}]
)
MASKS = st.sampled_from(
    [Mask(), Mask(AngleMask((0.0, 0.3, 1.0), 40.0)), Mask(None, (RegionPick(0),)),
     Mask(None, (RegionPick(1, "piece"),), inverted=True)]
)  # fmt: skip
SYMMETRIES = st.sampled_from(
    [Symmetry(), Symmetry((MirrorPlane((0, 0, 0), (0, 1, 0)),)), Symmetry((), RadialSymmetry(3))]
)
COMMANDS_ASKED = st.one_of(
    st.tuples(st.just("back and again"), st.integers(1, 3), st.integers(0, 2)),
    st.tuples(st.just("back and again"), st.integers(1, 2), st.integers(1, 2)),
    st.tuples(st.just("dip"), INKS),
    st.tuples(st.just("dip"), st.just("pine soot"), st.floats(0.0, 1.0)),
    st.tuples(st.just("set_brush"), st.sampled_from(["feibai", "full", load_brush("xiaobaiyun")])),
    st.tuples(st.just("step_brush"), st.integers(-2, 2)),
    st.tuples(st.just("add_layer")),
    st.tuples(st.sampled_from(["select_layer", "remove_layer", "set_locked", "set_visible"]),
              st.integers(0, 2)),
    st.tuples(st.just("set_visible"), st.integers(0, 1), st.booleans()),
    st.tuples(st.just("move_layer"), st.integers(0, 1), st.integers(0, 1)),
    st.tuples(st.sampled_from(["undo", "undo", "redo", "rinse", "swap_inks", "dry"])),
    st.tuples(st.just("wipe"), st.floats(0.0, 1.0)),
    st.tuples(st.just("follow_time"), st.just(0.05)),
    st.tuples(st.just("let_time_pass"), st.floats(0.0, 0.3)),
    st.tuples(st.just("replay_history"), st.integers(0, 2), st.booleans()),
    st.tuples(st.just("set_mask"), MASKS),
    st.tuples(st.just("set_symmetry"), SYMMETRIES),
    st.tuples(st.just("pick_colour"), st.integers(0, 400)),
    st.tuples(st.just("set_pickup"), st.sampled_from([0.0, 0.05])),
    st.tuples(st.just("set_azimuth"), st.sampled_from(["commanded", "dragged"])),
)  # fmt: skip


PASSAGES = st.tuples(STROKES, COMMANDS_ASKED, COMMANDS_ASKED)
"""A stroke, and what comes before the next one."""


def do(document: Document, asked: tuple, at_ns: int) -> None:
    """One thing that a hand does; what is refused is refused."""
    name, *given = asked
    try:
        if name == "stroke":
            stroke(document, *given, at_ns)
        elif name == "back and again":
            for step in ("undo",) * given[0] + ("redo",) * given[1]:
                getattr(document, step)()
        else:
            getattr(document, name)(*given)
    except Paint3DError:
        pass


def stroke(document: Document, start, end, press: float, cut: str, at_ns: int) -> None:
    samples = line(start, end, n=8, pressure=press, t0=at_ns)
    document.begin_stroke()
    document.feed(samples[:5])
    if cut == "cancel":
        document.cancel_stroke()
    elif cut:
        getattr(document, cut)()
    document.feed(samples[5:])  # passed over where undo broke it off
    document.end_stroke()


def read_back(score: Score, folder) -> Score:
    save_score(score, folder / "a.jsonl")
    return load_score(folder / "a.jsonl")


def same_paintings(one: Document, other: Document) -> None:
    """To the bit: vertices in their order, ink, colours, layers, strokes, and the brush."""
    one.refresh(), other.refresh()
    for get in (
        lambda d: d.surface.paint_mesh.vertices,
        lambda d: d.surface.paint_mesh.leaf_faces(),
        lambda d: d.surface.amounts,
        lambda d: d.surface.coverage,
        lambda d: d.surface.srgb,
        lambda d: d.surface.ink.load,
        lambda d: np.array([len(stroke.samples) for stroke in d.strokes]),
        lambda d: np.array([stroke.time_s for stroke in d.strokes]),
    ):
        np.testing.assert_array_equal(get(one), get(other))
    assert one.layers == other.layers
    assert one.active_layer == other.active_layer
    assert one.painter.brush == other.painter.brush
    assert (len(one.steps.done), len(one.steps.undone)) == (
        len(other.steps.done), len(other.steps.undone)
    )  # fmt: skip


@settings(deadline=None, max_examples=examples(30))
@given(st.lists(PASSAGES, min_size=2, max_size=6), st.sampled_from(["xuan", "porcelain"]))
def test_a_random_sitting_and_its_replay_are_the_same_to_the_bit(
    tmp_path_factory, passages, material
) -> None:
    document = small_plane(2.5, material=material)
    for k, one in enumerate(chain.from_iterable(passages)):
        do(document, one, 1_000_000_000 * (k + 1))
    score = read_back(document.score, tmp_path_factory.mktemp("score"))
    again = painted(score, document.surface.source)
    same_paintings(document, again)
    assert "".join(write_score(again.score)) == "".join(write_score(score))


def sitting(document: Document) -> None:
    """A sitting with most of what there is."""
    document.dip({"pine soot": 0.3, "water": 0.7})
    paint(document, (-20, -10), (20, -10))
    document.set_symmetry(Symmetry((MirrorPlane((0, 0, 0), (0, 1, 0)),)))
    document.set_mask(Mask(AngleMask((0, 0, 1), 30.0), (RegionPick(3),)))
    document.step_brush(-2)
    document.add_layer("二")
    paint(document, (-20, 5), (20, 15))
    document.let_time_pass(0.4)
    document.undo()
    document.dip({OWN: 1.0}, 0.5)
    paint(document, (-10, -20), (20, 15))


@pytest.mark.parametrize("command", ["swap_inks", "pick_colour"])
def test_what_is_written_down_as_a_dip_is_dipped_in(tmp_path, command) -> None:
    document = small_plane(2.0)
    document.inks = [{"pine soot": 1.0}, {"cinnabar": 1.0}]
    paint(document, (-20, -10), (20, -10))
    document.dip("indigo")
    if command == "swap_inks":
        document.swap_inks()
    else:
        ids = np.flatnonzero(document.surface.amounts.sum(axis=1) > 0.1)
        document.pick_colour(int(ids[0]))
    assert document.painter.dipped != {"indigo": 1.0}
    paint(document, (-20, 10), (20, 10))
    same_paintings(document, painted(read_back(document.score, tmp_path), document.surface.source))


@settings(deadline=None, max_examples=examples(40))
@given(
    face=st.integers(0, 15_000),
    up_to=st.sampled_from(["crease", "piece"]),
    degrees=st.floats(1.0, 90.0),
    leaning=st.floats(1.0, 90.0),
    inverted=st.booleans(),
)
def test_a_mask_is_said_and_heard(face, up_to, degrees, leaning, inverted) -> None:
    vocabulary = Vocabulary(bowl(), Inks({}))
    angle = AngleMask((0.0, 0.6, 0.8), leaning)
    mask = Mask(angle, (RegionPick(face, up_to, degrees), RegionPick(7)), inverted)
    line = line_of("set_mask", {"mask": mask}, vocabulary)
    check_command(json.loads(json.dumps(line)))
    assert arguments_of(line, vocabulary)["mask"] == mask


@settings(deadline=None, max_examples=25)
@given(point=st.tuples(*[st.floats(-50, 50)] * 3), count=st.integers(2, 12))
def test_a_symmetry_is_said_and_heard(point, count) -> None:
    vocabulary = Vocabulary(bowl(), Inks({}))
    axis = (0.0, 0.6, 0.8)
    symmetry = Symmetry((MirrorPlane(point, axis),), RadialSymmetry(count, point, axis))
    line = line_of("set_symmetry", {"symmetry": symmetry}, vocabulary)
    check_command(json.loads(json.dumps(line)))
    assert arguments_of(line, vocabulary)["symmetry"] == symmetry


@cache
def bowl() -> PaintedSurface:
    return PaintedSurface(load_mesh("bowl"), 4.0)


def test_a_saved_painting_goes_on_with_its_score(tmp_path) -> None:
    document = small_plane(2.0, material="xuan")
    sitting(document)
    document.replay_history(1, passing=True)
    document.save(tmp_path / "a.p3d")
    opened = Document.open(tmp_path / "a.p3d")
    paint(opened, (-15, 12), (15, -12))
    opened.undo()
    paint(opened, (-15, 10), (15, -2))
    same_paintings(opened, painted(read_back(opened.score, tmp_path), document.surface.source))


def test_samples_become_recordings_once_however_often_it_is_saved(tmp_path, monkeypatch) -> None:
    """Of ink that is wet there are thirty pieces a second, and a base is saved again and again."""
    made: list[int] = []

    def counted(samples: list, header: dict) -> Recording:
        made.append(len(samples))
        return recording_of(samples, header)

    monkeypatch.setattr("paint3d.app.model.score.keeping.recording_of", counted)
    document, samples = small_plane(), line((-18, 0), (18, 0), n=60)
    document.begin_stroke()
    for k in range(0, 40, 10):
        document.feed(samples[k : k + 10])
        document.follow_time(0.05)
    assert [len(part) for part in recordings(document.score)] == [10, 10, 10, 10] == made
    document.feed(samples[40:45])
    assert [len(part) for part in recordings(document.score)] == [10, 10, 10, 10, 5]
    document.feed(samples[45:])
    document.end_stroke()
    assert [len(part) for part in recordings(document.score)] == [10, 10, 10, 10, 20]
    assert made == [10, 10, 10, 10, 5, 20]
    assert recordings(document.score)[-1].time_ns.tolist() == [s.time_ns for s in samples[40:]]


def recordings(score: Score) -> list[Recording]:
    return [event for event in score.events if isinstance(event, Recording)]


def test_what_cannot_be_known_is_not_said(tmp_path) -> None:
    """Of a painting from before scores, and one whose strokes were painted anew under others."""
    document = small_plane()
    paint(document, (-10, 0), (10, 0))
    document.keeper = None
    document.save(tmp_path / "old.p3d")
    opened = Document.open(tmp_path / "old.p3d")
    paint(opened, (-10, 5), (10, 5))
    assert opened.score is None
    score = read_back(score_of_strokes(opened.strokes, opened.surface), tmp_path)
    again = painted(score, document.surface.source)
    np.testing.assert_array_equal(again.surface.srgb, opened.surface.srgb)


def test_strokes_alone_keep_their_brushes_inks_and_layers(tmp_path) -> None:
    document = small_plane(2.0)
    for k, (brush, ink) in enumerate(
        (("full", "pine soot"), ("feibai", "cinnabar"), ("full", {"indigo": 0.4, "water": 0.6}))
    ):
        document.set_brush(brush)
        document.dip(ink)
        if k == 1:
            document.add_layer("二")
        paint(document, (-20, 8 * k), (20, 8 * k - 3))
    document.select_layer(0)
    paint(document, (-20, -14), (20, -8))
    score = read_back(score_of_strokes(document.strokes, document.surface), tmp_path)
    again = painted(score, document.surface.source)
    np.testing.assert_array_equal(again.surface.srgb, document.surface.srgb)
    assert [layer.name for layer in again.layers] == [layer.name for layer in document.layers]


def test_the_registry_the_document_and_recordings_know_the_same_commands() -> None:
    changing = {name for name, one in COMMANDS.items() if one.codec is not None}
    assert set(command_names()) == changing - {"edit_stroke", "pick_colour", "swap_inks"}
    assert all(callable(getattr(Document, name)) for name in changing)


def test_a_score_on_another_object_is_told_where_it_does_not_fit() -> None:
    document = small_plane()
    sitting(document)
    lines = [*document.score.events, {"do": "remove_layer", "place": 7}]
    with pytest.raises(RecordingError, match=r"event \d+: remove_layer: .* expected"):
        painted(Score(document.score.header, tuple(lines)), document.surface.source)
    header = {**document.score.header, "brush": "borad"}
    with pytest.raises(RecordingError, match="header: unknown brush 'borad'"):
        painted(Score(header, ()), document.surface.source)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ({"ink": "mine.csv:iron gall"}, "of a table on this machine"),
        ({"ink": {"sut": 1.0}}, "unknown ink"),
        ({"ink": "cinnabar", "reach": 1.5}, r"dip: reach is 1.5; expected a number \(0 to 1\)"),
        ({"inc": "cinnabar"}, "dip has 'inc'; expected ink, reach"),
    ],
)
def test_a_dip_that_cannot_be_is_refused(words, told) -> None:
    document = small_plane()
    with pytest.raises(RecordingError, match=told):
        painted(Score({}, ({"do": "dip", **words},)), document.surface.source)


def test_what_a_score_says_of_an_ink_of_ones_own_is_its_spectrum(tmp_path) -> None:
    document = small_plane()
    document.dip({OWN: 1.0, "water": 2.0})
    paint(document, (-10, 0), (10, 0))
    score = read_back(document.score, tmp_path)
    assert score.header["pigments"]["iron gall"]["K"] == OWN.K.tolist()
    (dip,) = [e for e in score.events if isinstance(e, dict) and e["do"] == "dip"]
    assert dip["ink"] == {"iron gall": 1.0, "water": 2.0}
    header = copy.deepcopy(dict(score.header))
    header["pigments"]["iron gall"]["K"][3] = -1
    with pytest.raises(RecordingError, match=r"iron gall K \d+ is -1; expected a number \(0 to 1e"):
        Score(header, score.events)
    assert json.dumps(score.header["pigments"])


def test_an_ink_of_ones_own_comes_back_as_it_was(tmp_path) -> None:
    """Scores refused inks when their grains came, for the schema did not know them."""
    document = small_plane()
    document.dip({OWN: 1.0, "water": 2.0})
    again = painted(read_back(document.score, tmp_path), document.surface.source)
    (ink,) = [pigment for pigment in again.surface.pigments if pigment.name == OWN.name]
    assert ink.is_like(OWN)
    assert (ink.chinese, ink.source, ink.basis, ink.licence) == (
        OWN.chinese, OWN.source, OWN.basis, OWN.licence
    )  # fmt: skip


def test_a_score_may_say_all_that_a_pigment_has() -> None:
    said = schema()["$defs"]["pigment"]["properties"]
    assert {"name", *said} == {own.name for own in fields(Pigment) if own.init}
    for name, least, most in (("gloss", 0.0, 1.0), ("fine", 0.0, 1.0), ("grain_um", 0.0, 1000.0)):
        assert (said[name]["minimum"], said[name]["maximum"]) == (least, most)
