"""A sitting is a recording: played again it gives the same painting to the bit."""

from __future__ import annotations

import copy
import json
from dataclasses import fields
from functools import cache
from itertools import chain

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from paint3d.app.model import paint_thread as paint_threads
from paint3d.app.model.commands import COMMANDS, decode_arguments, encode_line
from paint3d.app.model.document import Document
from paint3d.app.model.input.symmetry import MirrorPlane, RadialSymmetry, Symmetry
from paint3d.app.model.laid_text import LaidText
from paint3d.app.model.mask import AngleMask, Mask, RegionPick
from paint3d.app.model.paint_thread import PaintThread
from paint3d.app.model.score import playing
from paint3d.app.model.score.codecs import InkTable, Vocabulary
from paint3d.app.model.score.playing import begun, painted, score_of_strokes
from paint3d.app.model.stroke_log import recording_of
from paint3d.brush.presets import load_brush
from paint3d.cli.main import main
from paint3d.colour.pigments import Pigment
from paint3d.device.sample import DeviceSample
from paint3d.errors import Paint3DError, RecordingError
from paint3d.files.load import load_mesh
from paint3d.files.project.session import load_session
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.likeness import digest_of
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.recording import change_brush, change_ink, delete_stroke
from paint3d.recording.recording import Recording
from paint3d.recording.score import (
    Score,
    check_command,
    command_names,
    load_score,
    save_score,
    schema,
    undo_kinds,
    write_score,
)
from paint3d.recording.score_steps import follow_steps
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.app.hands import UPRIGHT, line, paint, same_vertices, small_plane
from tests.support.cases import long_but
from tests.support.examples import examples

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from tests.app.test_wet import Wall
from tests.support.app.gestures import drag
from tests.support.app.windows import opened, settled

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
    st.tuples(st.sampled_from(["duplicate_layer", "merge_layer"]), st.integers(0, 2)),
    st.tuples(st.just("set_opacity"), st.integers(0, 1), st.sampled_from([0.0, 0.4, 1.0])),
    st.tuples(st.just("set_blend"), st.integers(0, 1), st.sampled_from(["normal", "multiply"])),
    st.tuples(st.just("blot")),
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


STROKE_ON_HIDDEN = (  # which is refused
    ("set_visible", 0, False), ("stroke", (0.0, 0.0), (0.0, 0.0), 0.5, ""),
)  # fmt: skip


@settings(deadline=None, max_examples=examples(30))
@given(
    passages=st.lists(PASSAGES, min_size=2, max_size=6),
    material=st.sampled_from(["xuan", "porcelain"]),
)
@example(passages=[STROKE_ON_HIDDEN], material="porcelain")
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
    vocabulary = Vocabulary(bowl(), InkTable({}))
    angle = AngleMask((0.0, 0.6, 0.8), leaning)
    mask = Mask(angle, (RegionPick(face, up_to, degrees), RegionPick(7)), inverted)
    line = encode_line("set_mask", {"mask": mask}, vocabulary)
    check_command(json.loads(json.dumps(line)))
    assert decode_arguments(line, vocabulary)["mask"] == mask


@settings(deadline=None, max_examples=25)
@given(point=st.tuples(*[st.floats(-50, 50)] * 3), count=st.integers(2, 12))
def test_a_symmetry_is_said_and_heard(point, count) -> None:
    vocabulary = Vocabulary(bowl(), InkTable({}))
    axis = (0.0, 0.6, 0.8)
    symmetry = Symmetry((MirrorPlane(point, axis),), RadialSymmetry(count, point, axis))
    line = encode_line("set_symmetry", {"symmetry": symmetry}, vocabulary)
    check_command(json.loads(json.dumps(line)))
    assert decode_arguments(line, vocabulary)["symmetry"] == symmetry


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


@pytest.mark.parametrize("command", ["dry", "blot"])
def test_a_command_that_ends_looking_back_leaves_nothing_to_end(tmp_path, command) -> None:
    document = small_plane(2.0, material="xuan")
    sitting(document)
    document.replay_history(1, passing=True)
    getattr(document, command)()
    document.save(tmp_path / "a.p3d")
    opened = Document.open(tmp_path / "a.p3d").score
    last = [event["do"] for event in opened.events if not isinstance(event, Recording)]
    assert last.count("replay_history") == 1


def test_samples_become_recordings_once_however_often_it_is_saved(tmp_path, monkeypatch) -> None:
    """Of ink that is wet there are thirty pieces a second, and a base is saved again and again."""
    made: list[int] = []

    def counted(samples: list, header: dict) -> Recording:
        made.append(len(samples))
        return recording_of(samples, header)

    monkeypatch.setattr("paint3d.app.model.score.recorder.recording_of", counted)
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
    document.recorder = None
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
    unwritten = {
        "edit_seal",
        "edit_strokes",
        "pick_colour",
        "set_light",
        "set_reference",
        "set_views",
        "swap_inks",
    }  # a score has the outcome, and nothing of how it is looked at
    assert set(command_names()) == changing - unwritten
    assert all(callable(getattr(Document, name)) for name in changing)


SQUARE = [[(-2, -2), (2, -2), (2, 2), (-2, 2)]]
ARGUMENTS = {  # of every command that changes a painting, on `of_everything`
    "undo": (), "redo": (), "cancel_stroke": (), "dip": ("cinnabar",), "rinse": (), "wipe": (0.5,),
    "swap_inks": (), "pick_colour": (0,), "dry": (), "blot": (), "add_layer": ("new",),
    "remove_layer": (1,), "rename_layer": (1, "new"), "duplicate_layer": (1,), "merge_layer": (2,),
    "add_group": (0, 0), "ungroup": (1,), "begin_stroke": (), "end_stroke": (), "lift": (),
    "follow_time": (0.05,), "let_time_pass": (0.05,), "set_brush": ("feibai",),
    "scale_brush": (1.1,), "resize_brush": (30.0,), "step_brush": (1,),
    "set_azimuth": ("dragged",), "set_pickup": (0.1,),
    "set_symmetry": (Symmetry((), RadialSymmetry(3)),), "set_mask": (Mask(None, (RegionPick(0),)),),
    "set_tags": (), "set_reference": ({},), "set_views": ({},), "set_light": ("studio", 0.0),
    "select_layer": (0,), "move_layer": (0, 2), "set_opacity": (1, 0.5),
    "set_blend": (1, "multiply"), "set_visible": (1, False), "duplicate_group": (1,),
    "move_group": (1, 0), "remove_group": (1,), "set_group_opacity": (1, 0.5),
    "set_group_blend": (1, "multiply"), "rename_group": (1, "new"), "set_group_visible": (1, False),
    "set_group_folded": (1,), "set_locked": (1,), "lay_text": (LaidText("二").words(),),
    "remove_text": (0,), "press_seal": (SQUARE, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    "replay_history": (1,), "edit_strokes": ([1], {"do": "ink", "ink": "cinnabar"}),
    "edit_seal": (0, {"do": "delete"}),
}  # fmt: skip
IN_A_STROKE = {"end_stroke", "cancel_stroke", "lift"}


def of_everything() -> Document:
    """A stroke, a group of layers, a text, and a stroke in the group."""
    document = small_plane(4.0, material="porcelain")
    paint(document, (-2, -10), (2, -10), n=6)
    document.add_layer("二")
    document.add_layer("三")
    document.add_group(1, 2, "group")
    document.lay_text(LaidText("永").words())
    paint(document, (-2, 5), (2, 8), n=6)
    return document


@pytest.mark.parametrize("name", [name for name, row in COMMANDS.items() if row.codec is not None])
def test_every_command_makes_the_step_of_undo_that_its_row_and_its_line_say(name: str) -> None:
    """Or an edit of strokes reaches the wrong stroke, once somebody has undone that."""
    row, document = COMMANDS[name], of_everything()
    if name == "edit_seal":
        document.press_seal(*ARGUMENTS["press_seal"])
    if name in IN_A_STROKE:
        document.begin_stroke()
        document.feed(line((0, -18), (3, -18), n=6, t0=10**10))
    steps = list(document.steps.done)
    getattr(document, name)(*ARGUMENTS[name])
    if name in ("edit_strokes", "edit_seal"):  # what follows was painted anew
        assert document.edits.has_any
    elif row.undo_label:
        assert document.steps.done == [*steps, row.undo_label]
    elif name not in ("undo", "replay_history", "cancel_stroke", "begin_stroke"):
        assert document.steps.done == steps
    known = command_names()
    assert (undo_kinds().get(name) in ("step", "layers")) == bool(row.undo_label and name in known)
    if document.in_stroke:
        document.end_stroke()
    document.undo()
    there = follow_steps(document.score)
    assert [len(there.done), len(there.undone)] == [
        len(document.strokes), len(document.undone_strokes)
    ]  # fmt: skip


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


# -- edits -------------------------------------------------------------------------------------


ENDS = st.tuples(st.floats(-18, 18), st.floats(-18, 18))
BETWEEN = st.sampled_from([None, None, ("dip", "indigo"), ("let_time_pass", 0.3), ("wipe", 0.5),
                           ("step_brush", -1), ("dip", "cinnabar", 0.5)])  # fmt: skip
STROKE_DRAWN = st.tuples(ENDS, ENDS, st.floats(0.2, 0.8), BETWEEN)


def edited_sitting(strokes, **options) -> list[Document]:
    """A sitting; the painting as it was after each stroke, and before the first."""
    document = small_plane(5.0, **options)
    for start, end, press, between in strokes:
        if between:
            getattr(document, between[0])(*between[1:])
        paint(document, start, end, n=6, pressure=press)
    return document


def same_bits(one: Document, other: Document) -> None:
    for get in (
        lambda d: d.surface.paint_mesh.vertices,
        lambda d: d.surface.amounts,
        lambda d: d.surface.coverage,
        lambda d: d.surface.srgb,
        lambda d: d.surface.ink.load,
    ):
        one.refresh(), other.refresh()
        np.testing.assert_array_equal(get(one), get(other))


@settings(deadline=None, max_examples=examples(25))
@given(st.lists(STROKE_DRAWN, min_size=1, max_size=3), st.sampled_from(["xuan", "porcelain"]))
def test_without_the_last_stroke_it_is_as_before_that(strokes, material) -> None:
    document = edited_sitting(strokes, material=material)
    mesh, before = document.surface.source, document.score
    paint(document, (-10, 3), (15, -9))
    document.follow_time(0.05)
    after = document.score
    shorter = Score(after.header, after.events[: len(before.events)])
    same_bits(painted(shorter, mesh), painted(before, mesh))
    without = delete_stroke(after, len(strokes) + 1)
    assert without.events[-1] == {"do": "follow_time", "seconds": 0.05}
    same_bits(painted(Score(without.header, without.events[:-1]), mesh), painted(before, mesh))


@settings(deadline=None, max_examples=examples(25))
@given(st.lists(STROKE_DRAWN, min_size=2, max_size=3), st.integers(1, 3), st.sampled_from([0, 30]))
def test_another_ink_lies_where_the_first_did_and_as_thick(strokes, number, hairs) -> None:
    document = edited_sitting([(*stroke[:3], None) for stroke in strokes])
    score = document.score
    both = [{"do": "dip", "ink": ink} for ink in ("cinnabar", "pine soot")]  # rounding differs by
    header = {**score.header, **({"hairs": hairs} if hairs else {})}  # how many inks there are
    score = Score(header, (*both, *score.events))
    number = min(number, len(strokes))
    one = painted(score, document.surface.source)
    other = painted(change_ink(score, number, "cinnabar"), document.surface.source)
    np.testing.assert_array_equal(
        other.surface.paint_mesh.vertices, one.surface.paint_mesh.vertices
    )
    np.testing.assert_allclose(other.surface.coverage, one.surface.coverage, atol=1e-6)
    sums = [d.surface.amounts.sum(axis=1) for d in (other, one)]
    np.testing.assert_allclose(*sums, atol=2e-6)
    assert [s.ink for s in other.strokes][number - 1] == {"cinnabar": 1.0}
    assert {*other.strokes[number - 1].ink} != {*one.strokes[number - 1].ink}
    assert other.painter.dipped == one.painter.dipped
    ledger = other.painter.ledger()
    assert ledger["loaded"] == pytest.approx(sum(ledger.values()) - ledger["loaded"])


def test_another_brush_is_for_one_stroke_and_leaves_the_own_one_as_it_was() -> None:
    document = edited_sitting([((-15, y), (15, y), 0.5, None) for y in (-9, 0, 9)])
    mesh, score = document.surface.source, document.score
    other = painted(change_brush(score, 2, "feibai"), mesh)
    assert [s.brush.name for s in other.strokes] == ["full", "feibai", "full"]
    assert other.painter.brush.name == "full"
    without = painted(delete_stroke(score, 2), mesh)
    np.testing.assert_allclose(without.surface.ink.load, other.surface.ink.load, rtol=0.01)
    ledger = other.painter.ledger()
    assert ledger["loaded"] == pytest.approx(sum(ledger.values()) - ledger["loaded"])


@pytest.mark.parametrize("end", ["end_stroke", "cancel_stroke", "undo"])
def test_what_was_lent_for_a_stroke_comes_back_however_it_ends(end) -> None:
    document = small_plane(2.0, brush="full", ink="pine soot")
    load, loaded = document.surface.ink.load.copy(), document.painter.loaded
    document.begin_stroke(brush=document.painter.brush, ink={"cinnabar": 1.0})
    document.feed(line((-10, 0), (10, 0)))
    getattr(document, end)()
    assert document.painter.dipped == "pine soot"
    np.testing.assert_array_equal(document.surface.ink.load[: len(load)], load)
    if end != "end_stroke":
        assert document.painter.loaded == loaded
        assert not document.strokes


def test_a_stroke_with_an_ink_that_is_none_does_not_begin() -> None:
    document = small_plane(2.0)
    with pytest.raises(Paint3DError, match="unknown ink"):
        document.begin_stroke(ink="sut")
    document.feed(line((-10, 0), (10, 0)))  # passed over
    document.end_stroke()
    assert not document.strokes
    assert not document.steps.done
    assert not document.surface.painted.any()
    paint(document, (-10, 0), (10, 0))
    assert len(document.strokes) == 1


# -- saved by the menu -------------------------------------------------------------------------


@pytest.fixture
def window(program):
    with opened(program, "plane", 2.0, "porcelain", drawn=False) as window:
        yield window


def test_what_is_saved_is_painted_to_the_bit_by_the_command_and_in_the_window(
    window, tmp_path, monkeypatch
) -> None:
    for k, ink in enumerate(("cinnabar", {"indigo": 0.3, "water": 0.7}, "pine soot")):
        window.workspace.post("dip", ink)
        drag(window.canvas, (0.42, 0.4 + 0.05 * k), (0.58, 0.45 + 0.05 * k), n=20)
        settled(window)
        window.workspace.actions[("add_layer", "undo", "dry")[k]].trigger()
    settled(window)
    file, out = tmp_path / "a.score.jsonl", tmp_path / "a.p3d"
    monkeypatch.setattr(window.targets, "ask", lambda *asked: file)
    window.workspace.actions["save_recording"].trigger()
    before = window.document
    assert main(["replay", str(file), "--on", "plane", "--out", str(out), "--quiet"]) == 0
    monkeypatch.setattr(window.recordings, "_may_leave", lambda: True)
    assert window.recordings.replay_file(str(file))
    settled(window)
    assert window.document is not before
    for again in (window.document, Document.open(out)):
        same_vertices(again.surface, before.surface)
        np.testing.assert_array_equal(again.surface.srgb, before.surface.srgb)
        assert again.layers == before.layers
        assert len(again.strokes) == len(before.strokes) == 2


# -- hands at random ---------------------------------------------------------------------------


def stroke_of_hands(rng: np.random.Generator, t0: int, has_place: bool) -> list[DeviceSample]:
    """A bow by a hand that trembles, stops, and may lift the brush within."""
    n = int(rng.integers(4, 150))
    along = np.linspace(0.0, 1.0, n)[:, None]
    start = rng.uniform(-30.0, 30.0, 2)
    way, bow, wave = rng.uniform(-25.0, 25.0, (3, 2))
    xy = start + along * way + along**2 * bow + 0.3 * np.sin(5.0 * along) * wave
    xy += rng.normal(0.0, 0.02, (n, 2))
    pressure = np.clip(
        0.5 * np.sin(np.pi * along[:, 0]) ** 0.5 + rng.normal(0.0, 0.03, n), 0.0, 1.0
    )
    pressure[[0, -1]] = 0.0
    if n > 30 and rng.random() < 0.4:
        at = int(rng.integers(8, n - 8))
        pressure[at : at + 3] = 0.0
    steps = rng.integers(1_000_000, 20_000_000, n)
    steps[rng.random(n) < 0.01] += 700_000_000
    turn = rng.uniform(0.0, np.pi)
    held = np.array([np.cos(turn), 0.0, 0.0, np.sin(turn)])
    return [
        DeviceSample(
            int(time_ns), np.array([*at, 35.0]), held, float(press), 0, np.zeros(3), UPRIGHT,
            np.array([*at, 0.0]) if has_place else None,
        )
        for at, press, time_ns in zip(xy, pressure, t0 + np.cumsum(steps), strict=True)
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("brush", "seed", "wet"),
    [("full", 42, True), ("feibai", 2, True), ("feibai", 34, False)]
    + [pytest.param("full", 8, True, marks=pytest.mark.long)]
    + [pytest.param(b, k, w, marks=pytest.mark.long)
       for b in ("full", "feibai", "zhongbaiyun") for k in range(43, 47) for w in (False, True)],
)  # fmt: skip
def test_a_recording_paints_the_same_to_the_bit(monkeypatch, brush, seed, wet):
    rng, wall = np.random.default_rng(seed), Wall(monkeypatch)
    monkeypatch.setattr(paint_threads.Pace, "most", lambda pace, behind_s: 10**9)
    document = small_plane(2.0, material="xuan", brush=brush)
    paint_thread, t0 = PaintThread(document, wet=wet), int(rng.integers(0, 10**15))
    wall.now = 1e-9 * t0
    for number in range(4):
        samples = stroke_of_hands(rng, t0, bool(seed % 2))
        if number and rng.random() < 0.4:
            paint_thread.post("dip")
        paint_thread.post("begin_stroke")
        paint_thread.feed(samples)
        paint_thread.post("end_stroke")
        t0 = samples[-1].time_ns + int(rng.uniform(4e6, (3e7, 2e8, 4e9)[number % 3]))
    paint_thread.stop()
    surface = PaintedSurface(document.surface.source, 2.0, "xuan")
    Painter(surface, brush).replay(document.recording(), wet=wet)
    same_vertices(document.surface, surface)
    if wet:
        assert surface.flow.water == document.surface.flow.water > 0.0


# -- on a bowl meshed anew ---------------------------------------------------------------------


RESOLUTION_MM = 0.5
MOST_MM = 0.7  # off where it was: on the rim, .64 beside vertices .5 apart
PLAIN = """{"format": "paint3d-recording", "version": 1}
{"time_ns": 0, "position": [0, 0, 60], "orientation": [1, 0, 0, 0], "pressure": 0.3}
{"time_ns": 8000000, "position": [1, 0, 60], "orientation": [1, 0, 0, 0], "pressure": 0.3}
"""


@cache
def the_bowl() -> TriangleMesh:
    return load_mesh("bowl")


def arc(angles, heights, meant: bool, n: int = 30) -> list:
    """A stroke around the outside of the bowl; by the place that is meant, or the root's."""
    around = np.linspace(*angles, n)
    out = [120.0 * np.cos(around), 120.0 * np.sin(around), np.linspace(*heights, n)]
    return held_at(np.column_stack(out), meant)


def held_at(places: np.ndarray, meant: bool) -> list:
    """A stroke along the places (n, 3) of the bowl that are nearest, the brush upright on it."""
    found, n = ClosestPoints(the_bowl()).find(places), len(places)
    up = found.normals
    turns = np.column_stack([1.0 + up[:, 2], -up[:, 1], up[:, 0], np.zeros(n)])
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    pressure = np.full(n, 0.45)
    pressure[[0, -1]] = 0.0
    samples = Recording(
        8_000_000 * np.arange(n), found.points + 30.0 * up, turns, pressure,
        contact=found.points if meant else None,
    )  # fmt: skip
    return [{"do": "begin_stroke"}, samples, {"do": "end_stroke"}]


@cache
def score() -> Score:
    """Strokes with a mask of a region and an angle, and one with a mirror image."""
    outside = ClosestPoints(the_bowl()).find(np.array([[120.0, 0.0, 30.0]])).points[0].tolist()
    mask = {"do": "set_mask", "regions": [{"at": outside, "up_to": "crease", "degrees": 40}],
            "angle": {"direction": [1, 0, 0.2], "degrees": 50}}  # fmt: skip
    mirror = {"do": "set_symmetry", "planes": [{"point": [0, 0, 0], "normal": [0, 1, 0]}]}
    events = (
        *arc((-0.5, 0.2), (22, 38), True), mask, *arc((0.2, 1.2), (44, 30), False),
        {"do": "set_mask"}, mirror, *arc((2.0, 2.5), (26, 40), True),
    )  # fmt: skip
    return Score({"object": "bowl", "resolution_mm": RESOLUTION_MM}, events)


@cache
def first(of=score) -> Document:
    return painted(of(), the_bowl())


def over_the_rim(around: float, slant: float, n: int = 40) -> list:
    """A stroke up the bowl's outside, over its rim and down inside."""
    way = np.linspace(-12.0, 12.0, n)
    at, beside = around + slant * way / 75.0, np.where(way < 0.0, 80.0, 66.0)
    return held_at(
        np.column_stack([beside * np.cos(at), beside * np.sin(at), 68.0 - np.abs(way)]), True
    )


@cache
def rim() -> Score:
    """Along the rim, on it, and over it, the place being meant."""
    strokes = (
        arc((0.3, 0.8), (61, 65), True), arc((1.5, 2.0), (68, 63), True),
        over_the_rim(2.8, 0.3), over_the_rim(3.5, -0.7), arc((4.2, 4.7), (66, 66), True),
    )  # fmt: skip
    return Score(score().header, tuple(event for one in strokes for event in one))


def subdivided() -> TriangleMesh:
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(the_bowl().vertices, the_bowl().faces, process=False).subdivide()
    return TriangleMesh(mesh.vertices, mesh.faces)


def decimated(share: int = 3) -> TriangleMesh:
    open3d = pytest.importorskip("open3d")
    mesh = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(the_bowl().vertices.astype(float)),
        open3d.utility.Vector3iVector(np.array(the_bowl().faces)),
    )
    mesh = mesh.simplify_quadric_decimation(the_bowl().n_faces // share)
    return TriangleMesh(np.asarray(mesh.vertices), np.asarray(mesh.triangles))


def halved() -> TriangleMesh:
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.PolyData.from_regular_faces(the_bowl().vertices.astype(float), the_bowl().faces)
    mesh = mesh.decimate(0.5)
    return TriangleMesh(mesh.points, mesh.regular_faces)


def shifted() -> TriangleMesh:
    """Its vertices lie elsewhere on the bowl, as where it is sampled anew."""
    mesh, chance = the_bowl(), np.random.default_rng(5)
    places = mesh.vertices + chance.normal(0.0, 0.12, mesh.vertices.shape)
    return TriangleMesh(ClosestPoints(the_bowl()).find(places).points, mesh.faces)


def inked(document: Document) -> np.ndarray:
    return inked_of(document.surface)


def inked_of(surface: PaintedSurface) -> np.ndarray:
    return surface.paint_mesh.vertices[surface.coverage > 0.0].astype(float)


def check_places(of, mesh: TriangleMesh, resolution: float) -> None:
    one, other = inked(first(of)), inked(painted(of(), mesh, resolution))
    off = [cKDTree(b).query(a)[0] for a, b in ((one, other), (other, one))]
    for distances in off:
        print(f"median {np.median(distances):.3f} mm, worst {distances.max():.3f} mm")
        assert np.median(distances) <= 0.5 * MOST_MM
        assert distances.max() <= MOST_MM


@pytest.mark.parametrize(
    ("mesh", "resolution"),
    [(subdivided, 0.5), pytest.param(decimated, 0.4, marks=pytest.mark.long),
     pytest.param(decimated, 0.5, marks=pytest.mark.long), (the_bowl, 0.3)],
    ids=["subdivided", "decimated", "decimated, as fine", "finer paint"],
)  # fmt: skip
def test_strokes_lie_where_they_lay(mesh, resolution) -> None:
    check_places(score, mesh(), resolution)


@pytest.mark.parametrize(
    ("mesh", "resolution"),
    long_but(
        [(decimated, 0.5), (shifted, 0.3), (the_bowl, 0.7)],
        [(subdivided, 0.5), (decimated, 0.5), (shifted, 0.3), (the_bowl, 0.7), (decimated, 0.3),
         (halved, 0.4), (the_bowl, 0.3)],
    ),
)  # fmt: skip
def test_strokes_over_the_rim_lie_where_they_lay(mesh, resolution) -> None:
    check_places(rim, mesh(), resolution)


def test_the_rim_needs_what_was_painted_on(monkeypatch) -> None:
    """Without it they do not: or what is above would say nothing of it."""
    monkeypatch.setattr(playing, "_original", lambda *_: None)
    with pytest.raises(AssertionError):
        check_places(rim, decimated(), 0.3)


def test_on_the_object_that_it_was_painted_on_nothing_is_taken_over() -> None:
    assert first().surface.original is None
    plain = PaintedSurface(the_bowl(), RESOLUTION_MM)
    np.testing.assert_array_equal(
        plain.paint_mesh.arrays.sheet_pack, first().surface.paint_mesh.arrays.sheet_pack
    )


def without_normals(mesh: TriangleMesh) -> TriangleMesh:
    return TriangleMesh(mesh.vertices, mesh.faces, name=mesh.name)


def test_a_mesh_that_only_lost_its_normals_takes_them_over() -> None:
    """Its own are computed of the triangles, and lean otherwise on the rim."""
    bare = painted(rim(), without_normals(the_bowl()))
    same_vertices(bare.surface, first(rim).surface)


def test_a_file_that_is_called_like_a_built_in_object_is_none() -> None:
    """What was painted on it is painted on it again to the bit, by its score's header."""
    own = decimated()
    own = TriangleMesh(own.vertices, own.faces, name="bowl")
    header = {**rim().header, "object": "another"}
    document = painted(Score(header, rim().events), own)
    assert document.surface.original is None
    again = painted(document.score, own)
    assert again.surface.original is None
    same_vertices(document.surface, again.surface)
    finer = begun(document.score, own, 0.4).surface.original  # its own mesh is what it was
    assert finer is not None
    assert finer.mesh is own
    assert begun(document.score, the_bowl()).surface.original is None
    assert begun(first(rim).score, own).surface.original is not None


def test_another_file_than_was_painted_on_is_warned_of(caplog) -> None:
    for painted_on, n in ((the_bowl(), 0), (without_normals(the_bowl()), 1)):
        begun(first(rim).score, decimated(), painted_on=painted_on)
        assert sum("not to the bit" in one.message for one in caplog.records) == n


def test_an_object_that_was_changed_stands_for_itself_there() -> None:
    """Half of the bowl grows by a tenth: its other half is the bowl's still."""
    vertices = the_bowl().vertices.copy()
    grown = vertices[:, 0] > 0.0
    vertices[grown, 0] *= 1.1
    surface = painted(score(), TriangleMesh(vertices, the_bowl().faces)).surface
    assert surface.original is not None
    off = ClosestPoints(TriangleMesh(vertices, the_bowl().faces)).find(inked_of(surface)).points
    np.testing.assert_allclose(off, inked_of(surface), atol=0.01)
    sphere = painted(score(), load_mesh("sphere"), 0.5).surface
    assert sphere.original is None


def test_a_session_and_its_score_know_what_was_painted_on(tmp_path) -> None:
    document = painted(rim(), decimated(), 0.4)
    document.save(tmp_path / "a.p3d")
    again = Document.open(tmp_path / "a.p3d")
    of_bowl = {"object": "bowl", "mesh": digest_of(the_bowl()), "resolution_mm": 0.5}
    for one in (document, again):
        assert one.score.header["painted_on"] == of_bowl
        assert one.score.header["mesh"] == digest_of(decimated())
    first, second = document.surface.paint_mesh.arrays, again.surface.paint_mesh.arrays
    np.testing.assert_array_equal(first.sheet_pack, second.sheet_pack)
    for one in (document, again):
        for event in arc((5.2, 5.6), (64, 67), True):
            one.feed(list(event.samples())) if isinstance(event, Recording) else getattr(
                one, event["do"]
            )()
    same_vertices(document.surface, again.surface)
    played = painted(document.score, decimated(), painted_on=the_bowl())
    same_vertices(document.surface, played.surface)


@pytest.mark.long
@pytest.mark.parametrize("resolution", [0.3, 0.4, 0.5])
@pytest.mark.parametrize("share", [2, 3])
def test_strokes_over_the_rim_lie_where_they_lay_however_coarse(share, resolution) -> None:
    check_places(rim, decimated(share), resolution)


def test_a_mask_and_a_mirror_do_what_they_did() -> None:
    """They hold something back and paint something, or what is above would say nothing of them."""
    plain = Score(score().header, tuple(
        e for e in score().events
        if isinstance(e, Recording) or e["do"] not in ("set_mask", "set_symmetry")
    ))  # fmt: skip
    without, of_all = inked(painted(plain, the_bowl())), inked(first())
    far = cKDTree(of_all).query(without)[0]
    assert (far > 2.0).sum() > 100
    assert (cKDTree(without).query(of_all)[0] > 2.0).sum() > 100


def test_the_command_is_told_what_it_was_painted_on(tmp_path, capsys) -> None:
    """A file of the bowl has another name than the score's object, which is none of ours."""
    file, out = tmp_path / "a.score.jsonl", tmp_path / "a.p3d"
    save_score(Score({**rim().header, "object": "jar"}, rim().events), file)
    for name, mesh in (("jar.obj", the_bowl()), ("coarse.obj", decimated())):
        normals = np.empty((0, 3)) if mesh.normals is None else mesh.normals
        form = "f {0} {1} {2}" if mesh.normals is None else "f {0}//{0} {1}//{1} {2}//{2}"
        lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in mesh.vertices]
        lines += [f"vn {x:.9g} {y:.9g} {z:.9g}" for x, y, z in normals]
        lines += [form.format(*face) for face in mesh.faces + 1]
        (tmp_path / name).write_text("\n".join(lines) + "\n")
    words = ["replay", str(file), "--on", str(tmp_path / "coarse.obj"), "--out", str(out)]
    assert main([*words, "--painted-on", str(tmp_path / "jar.obj"), "--quiet"]) == 0
    again = load_session(out)
    assert again.surface.original is not None
    jar, coarse = load_mesh(tmp_path / "jar.obj"), load_mesh(tmp_path / "coarse.obj")
    same_vertices(again.surface, painted(load_score(file), coarse, painted_on=jar).surface)
    (tmp_path / "b.jsonl").write_text(PLAIN)
    words = ["replay", str(tmp_path / "b.jsonl"), "--on", "bowl", "--out", str(out), "--force"]
    assert main([*words, "--painted-on", "bowl"]) == 2
    assert "is no whole painting" in capsys.readouterr().err
