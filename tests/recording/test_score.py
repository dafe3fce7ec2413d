"""Recordings of whole paintings: what a line may say is what the schema says."""

from __future__ import annotations

import dataclasses
import json
import re
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.app.model.commands import COMMANDS
from paint3d.cli.main import main
from paint3d.colour.pigments import Pigment
from paint3d.errors import ExportError, InputError, RecordingError
from paint3d.files.load import load_mesh
from paint3d.files.project.session import load_session
from paint3d.mesh.bvh import ClosestPoints
from paint3d.recording import change_brush, change_ink, delete_stroke, move_stroke, retime_stroke
from paint3d.recording.recording import Recording, load_recording
from paint3d.recording.score import (
    Score,
    check_command,
    check_header,
    check_sample,
    is_score,
    load_score,
    save_score,
    schema,
    write_score,
)
from paint3d.recording.score_edits import apply_stroke_edit, tangents_at
from paint3d.recording.score_steps import follow_steps

DOCS = Path(__file__).parents[2] / "docs" / "recordings.md"
EXAMPLE = Path(__file__).parents[2] / "examples" / "bamboo.score.jsonl"
HEADER = {"format": "paint3d-recording", "version": 2}
SAMPLE = {"time_ns": 5, "position": [0, 0, 35], "orientation": [1, 0, 0, 0], "pressure": 0.5}
GOOD = [
    HEADER,
    {**HEADER, "material": "xuan", "resolution_mm": None, "ink": {"water": 1.0}, "mine": [1]},
    SAMPLE,
    {**SAMPLE, "contact": None, "object": {"position": [0, 0, 0], "orientation": [1, 0, 0, 0]}},
    {"do": "begin_stroke", "time_s": 3.5},
    {"do": "dip"},
    {"do": "dip", "ink": {"pine soot": 0.2, "water": 0.8}, "reach": 0.5, "refused": True},
    {"do": "set_brush", "brush": {"name": "mine", "length_mm": 35.0}, "hairs": 100},
    {"do": "set_mask", "regions": [{"at": [0, 1, 2.5], "up_to": "piece"}], "inverted": True},
    {"do": "set_symmetry", "planes": [{"point": [0, 0, 0], "normal": [0, 1, 0]}]},
    {"do": "set_tags", "tags": {"any": [1, None]}},
]
BAD = [
    {**HEADER, "version": 3},
    {**HEADER, "version": True},
    {**HEADER, "ink": {}},
    {**HEADER, "space": "pad"},
    {**HEADER, "pigments": {"mine": {"K": [1.0], "S": [1.0]}}},
    {**SAMPLE, "pressure": 1.5},
    {**SAMPLE, "time_ns": 0.5},
    {**SAMPLE, "position": [0, 0]},
    {"do": "dipp"},
    {"do": "dip", "reach": -0.1},
    {"do": "dip", "reach": "half"},
    {"do": "dip", "ink": ""},
    {"do": "dip", "ink": {"water": 0}},
    {"do": "wipe", "shares": 0.5},
    {"do": "set_brush"},
    {"do": "select_layer", "place": -1},
    {"do": "select_layer", "place": True},
    {"do": "set_symmetry", "radial": {"count": 1}},
    {"do": "set_mask", "angle": {"direction": [0, 0, 1]}},
    {"do": "follow_time", "seconds": 0.05, "times": 0},
]


def is_taken(line: dict) -> bool:
    check = check_command if "do" in line else check_header if "format" in line else check_sample
    try:
        check(line)
    except RecordingError:
        return False
    return True


@pytest.fixture(scope="module")
def validator() -> Any:
    """Somebody else's reader of the schema, imported here: that takes 5 s of each process."""
    from jsonschema import Draft202012Validator

    return Draft202012Validator(schema())


def test_the_schema_is_one(validator: Any) -> None:
    validator.check_schema(schema())


@pytest.mark.parametrize("line", GOOD + BAD, ids=json.dumps)
def test_a_line_is_taken_where_the_schema_takes_it(line, validator: Any) -> None:
    """By somebody else's reading of the schema, too."""
    expected = line in GOOD and not any(line is bad for bad in BAD)
    assert validator.is_valid(line) == expected
    assert is_taken(line) == expected


def test_a_header_may_say_of_a_pigment_all_that_there_is_to_say() -> None:
    """Or a painting with an ink of one's own could not be written down."""
    known = {field.name for field in dataclasses.fields(Pigment)} - {"name"}
    assert set(schema()["$defs"]["pigment"]["properties"]) == known


def test_the_guides_example_is_a_score_and_its_table_has_every_command(tmp_path) -> None:
    part = DOCS.read_text("utf-8").split("## Version 2")[1]
    (tmp_path / "a.jsonl").write_text(part.split("```json\n")[1].split("```")[0], "utf-8")
    score = load_score(tmp_path / "a.jsonl")
    assert score.n_samples == 2
    told = set(re.findall(r"`(\w+)`", part))
    assert {line["do"] for line in score.events if isinstance(line, dict)} <= told
    assert {rule["properties"]["do"]["const"] for rule in schema()["$defs"].values()
            if "do" in rule.get("required", ())} <= told  # fmt: skip


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ([SAMPLE], r"a.jsonl:2: a sample lies outside of a stroke"),
        ([{"do": "begin_stroke"}, SAMPLE, SAMPLE], r"a.jsonl:4: time_ns is 5; expected more"),
        ([{"do": "begin_stroke"}, SAMPLE, {"do": "dip"}, SAMPLE], r"a.jsonl:5: time_ns is 5"),
        ([{"do": "begin_stroke"}] * 2, r"a.jsonl:3: begin_stroke comes during a stroke"),
        ([{"do": "begin_stroke"}, {**SAMPLE, "orientation": [1, 1, 0, 0]}], "has length 1.41"),
        ([{"do": "wype"}], "did you mean 'wipe'"),
    ],
)
def test_a_wrong_line_is_named(tmp_path, lines, told) -> None:
    file = tmp_path / "a.jsonl"
    file.write_text("\n".join(json.dumps(line) for line in (HEADER, *lines)))
    assert is_score(file)
    with pytest.raises(RecordingError, match=told):
        load_score(file)
    with pytest.raises(RecordingError, match="whole painting"):
        load_recording(file)


@pytest.mark.parametrize("suffix", [".jsonl", ".score.jsonl.gz"])
def test_what_was_written_is_read_back(tmp_path, suffix) -> None:
    score = load_score(EXAMPLE)
    save_score(score, tmp_path / f"a{suffix}")
    again = load_score(tmp_path / f"a{suffix}")
    assert list(write_score(again)) == list(write_score(score))
    with pytest.raises(ExportError, match="suffix"):
        save_score(score, tmp_path / "a.csv")
    assert not is_score(tmp_path / "none")


def test_the_command_line_paints_it(tmp_path, capsys) -> None:
    out = tmp_path / "a.p3d"
    words = ["replay", str(EXAMPLE), "--on", "plane", "--out", str(out), "--resolution", "2"]
    assert main(words) == 0
    session = load_session(out)
    assert session.surface.painted.any()
    assert session.surface.material.name == "xuan"
    first = out.read_bytes()
    assert main([*words, "--force"]) == 0
    assert out.read_bytes() == first
    assert isinstance(session.score, Score)


@pytest.mark.parametrize(
    ("option", "value"),
    [("brush", "full"), ("ink", "cinnabar"), ("tip", "cinnabar"), ("pickup", ".05"),
     ("hairs", "0"), ("at", ".5,.5"), ("size", "20"), ("spread", "1")],
)  # fmt: skip
def test_the_command_line_refuses_what_a_score_says_itself(tmp_path, capsys, option, value) -> None:
    words = ["replay", str(EXAMPLE), "--on", "plane", "--out", str(tmp_path / "a.p3d")]
    assert main([*words, f"--{option}", value]) == 2
    assert f"expected no --{option}" in capsys.readouterr().err


# -- edits -------------------------------------------------------------------------------------


SMALL = st.floats(-8.0, 8.0)
EDITS = st.one_of(
    st.just({"do": "delete"}),
    st.builds(
        lambda x, y, turn: {"do": "move", "along": (x, y), "turn_deg": turn},
        SMALL, SMALL, st.floats(-180, 180),
    ),
    st.builds(lambda ink: {"do": "ink", "ink": ink}, st.sampled_from(["cinnabar", {"water": 1}])),
    st.just({"do": "brush", "brush": "feibai"}),
    st.builds(lambda f: {"do": "time", "factor": f}, st.floats(0.01, 100.0)),
    st.builds(lambda across: {"do": "mirror", "across": across}, st.sampled_from("xy")),
    st.builds(
        lambda f: {"do": "scale", "factor": f, "brushes": ["feibai"]}, st.floats(0.1, 1.2)
    ),
)  # fmt: skip


@cache
def ground(name: str = "plane") -> ClosestPoints:
    return ClosestPoints(load_mesh(name))


def stroke(*parts: list, **begin) -> list:
    """A stroke of some samples, with commands between them."""
    events: list = [{"do": "begin_stroke", **begin}]
    at = 0
    for part in parts:
        if isinstance(part, dict):
            events.append(part)
            continue
        n = len(part)
        times = 10_000_000 * np.arange(at, at + n)
        places = np.column_stack([part, np.zeros(n), np.full(n, 35.0)])
        events.append(Recording(times, places, np.tile([1.0, 0, 0, 0], (n, 1)), np.full(n, 0.4)))
        at += n
    return [*events, {"do": "end_stroke"}]


def kinds(score: Score) -> list[str]:
    return ["samples" if isinstance(e, Recording) else e["do"] for e in score.events]


def said(score: Score, key: str) -> list:
    return [e[key] for e in score.events if not isinstance(e, Recording) and key in e]


A, B, C = ([float(k), k + 1.0, k + 2.0] for k in (0, 10, 20))


@settings(deadline=None, max_examples=25)
@given(st.lists(st.tuples(st.integers(1, 6), EDITS), min_size=1, max_size=4))
def test_an_edited_score_fits_the_schema_and_the_old_one_stays(tmp_path_factory, validator, edits):
    score = load_score(EXAMPLE)
    before = list(write_score(score))
    edited = score
    for number, edit in edits:
        edited = apply_stroke_edit(edited, [min(number, len(edited.strokes()))], edit, ground())
    assert list(write_score(score)) == before
    lines = list(write_score(edited))
    for line in lines:
        validator.validate(json.loads(line))
    file = tmp_path_factory.mktemp("edited") / "a.jsonl"
    save_score(edited, file)
    assert list(write_score(load_score(file))) == lines


@settings(deadline=None, max_examples=25)
@given(st.integers(1, 7), SMALL, SMALL, st.floats(-180, 180))
def test_a_stroke_that_is_moved_and_moved_back_is_where_it_was(number, x, y, turn):
    score = load_score(EXAMPLE)
    there = move_stroke(score, number, ground(), (x, y), turn)
    middles = [one.strokes()[number - 1].position[1:-1].mean(axis=0) for one in (score, there)]
    np.testing.assert_allclose(middles[1] - middles[0], [x, y, 0.0], atol=1e-9)
    back = move_stroke(move_stroke(there, number, ground(), (0, 0), -turn), number, ground(),
                       (-x, -y))  # fmt: skip
    for own, other in zip(score.strokes(), back.strokes(), strict=True):
        np.testing.assert_allclose(other.position, own.position, atol=1e-6)
        np.testing.assert_allclose(other.orientation, own.orientation, atol=1e-9)


@settings(deadline=None, max_examples=25)
@given(st.floats(-25, 25), st.floats(-12, 12), st.floats(-60, 60), st.floats(0.2, 0.6))
def test_on_a_bowl_places_and_brush_follow_the_surface(x, y, turn, lean):
    """The root stays as high over the surface, and the handle leans as it did to its normal."""
    bowl = ground("bowl")
    angles = np.linspace(-0.25, 0.25, 9)
    out = np.column_stack([np.cos(angles), np.sin(angles), np.full(9, 0.1)])
    found = bowl.find(80.0 * out)
    up = found.normals + lean * np.array([0.0, 0.0, 1.0])
    up /= np.linalg.norm(up, axis=1)[:, None]
    turns = np.column_stack([1 + up[:, 2], -up[:, 1], up[:, 0], np.zeros(9)])
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    part = Recording(
        10_000_000 * np.arange(9), found.points + 20.0 * up, turns, np.full(9, 0.4),
        contact=found.points,
    )  # fmt: skip
    score = Score({}, ({"do": "begin_stroke"}, part, {"do": "end_stroke"}))
    moved = move_stroke(score, 1, bowl, (x, y), turn).strokes()[0]
    now = bowl.find(moved.contact)
    np.testing.assert_allclose(now.points, moved.contact, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(moved.position - moved.contact, axis=1), 20.0)
    handle = (moved.position - moved.contact) / 20.0
    leans = np.sum(handle * now.normals, axis=1), np.sum(up * found.normals, axis=1)
    np.testing.assert_allclose(*leans, atol=0.02)  # the normals of a mesh are those of facets
    middle = bowl.find(found.points.mean(axis=0)[None])
    way = moved.contact[4] - found.points[4]
    first, second = tangents_at(middle.normals[0])
    assert np.linalg.norm(way) <= np.hypot(x, y) + 1.0
    assert way @ first * x >= -1e-6 or abs(x) < 2.0
    assert way @ second * y >= -1e-6 or abs(y) < 2.0


def test_a_stroke_is_carried_to_a_place() -> None:
    score = load_score(EXAMPLE)
    moved = move_stroke(score, 3, ground(), to=(20.0, 10.0, 5.0)).strokes()[2]
    np.testing.assert_allclose(moved.position[1:-1].mean(axis=0), [20.0, 10.0, 35.0], atol=0.5)
    held = move_stroke(score, 3, ground(), to=((0.0, 0.0, 1.0), (4.0, -3.0, 1.0))).strokes()[2]
    own = score.strokes()[2].position
    np.testing.assert_allclose(held.position - own, np.tile([4.0, -3.0, 0.0], (len(own), 1)))


@pytest.mark.parametrize("across", "xy")
def test_strokes_that_are_mirrored_twice_are_what_they_were(across: str) -> None:
    score, edit = load_score(EXAMPLE), {"do": "mirror", "across": across}
    once = apply_stroke_edit(score, [1, 3], edit, ground())
    twice = apply_stroke_edit(once, [1, 3], edit, ground())
    for k in (0, 2):
        was, other, again = (s.strokes()[k] for s in (score, once, twice))
        assert np.abs(other.position - was.position).max() > 1.0
        np.testing.assert_allclose(again.position, was.position, atol=1e-9)
        same = np.abs(np.sum(again.orientation * was.orientation, axis=1))
        np.testing.assert_allclose(same, 1.0, atol=1e-9)
    np.testing.assert_array_equal(once.strokes()[1].position, score.strokes()[1].position)


def test_strokes_are_scaled_about_the_middle_of_all_and_have_their_brushes() -> None:
    score = load_score(EXAMPLE)
    edit = {"do": "scale", "factor": 0.5, "brushes": ["feibai", "full"]}
    small = apply_stroke_edit(score, [1, 3], edit, ground())
    a, b = (np.concatenate([s.strokes()[k].position for k in (0, 2)]) for s in (score, small))
    np.testing.assert_allclose(np.ptp(b, axis=0), 0.5 * np.ptp(a, axis=0), atol=1e-9)
    begins = [e for e in small.events if not isinstance(e, Recording) and e["do"] == "begin_stroke"]
    assert [begins[k]["brush"] for k in (0, 2)] == ["feibai", "full"]
    with pytest.raises(InputError, match=r"0 brushes for 2 strokes"):
        apply_stroke_edit(score, [1, 3], {**edit, "brushes": []}, ground())
    with pytest.raises(InputError, match=r"scale does not take 'factor'; it takes .*brushes"):
        apply_stroke_edit(score, [1, 3], {"do": "scale", "factor": 0.5}, ground())


def test_several_strokes_are_shifted_where_each_alone_would_have_no_pause() -> None:
    second = {"do": "follow_time", "seconds": 0.05, "times": 20}
    events = [*stroke(A), {**second, "times": 2}, *stroke(B), second, *stroke(C)]
    edit = {"do": "time", "shift_s": 0.5}
    with pytest.raises(RecordingError, match=r"the pause after it is 0\.10 s"):
        apply_stroke_edit(Score({}, tuple(events)), [1], edit)
    later = apply_stroke_edit(Score({}, tuple(events)), [1, 2], edit)
    assert said(later, "times") == [10, 2, 10]


def test_a_stroke_does_not_go_beyond_an_edge() -> None:
    score, (width, *_) = load_score(EXAMPLE), np.ptp(load_mesh("plane").vertices, axis=0)
    with pytest.raises(RecordingError, match=r"stroke 2: its middle .* edge .* after \d\d% of its"):
        move_stroke(score, 2, ground(), (float(width), 0.0))
    with pytest.raises(RecordingError, match=r"stroke 2: its sample \d+ .* mm beyond an edge"):
        move_stroke(score, 2, ground(), (0.48 * float(width), 0.0), 90.0)


def test_deleting_takes_what_was_undone_of_the_stroke_with_it() -> None:
    undo, redo, dry = {"do": "undo"}, {"do": "redo"}, {"do": "dry"}
    score = Score({}, (*stroke(A), *stroke(B), undo, redo, dry, undo, undo, *stroke(C), redo))
    steps = follow_steps(score)
    assert [s.number for s in steps.done] == [1, 3]
    assert [s.is_there for s in steps.strokes] == [True, False, True]
    without = delete_stroke(score, 2)
    assert kinds(without) == [
        "begin_stroke", "samples", "end_stroke", "dry", "undo", "begin_stroke", "samples",
        "end_stroke",
    ]  # fmt: skip
    assert [s.number for s in follow_steps(without).done] == [1, 2]
    assert "undo" in kinds(delete_stroke(score, 1))


def test_deleting_counts_the_strokes_that_are_gone_back_to() -> None:
    back = {"do": "replay_history", "upto": 2, "passing": True}
    score = Score({}, (*stroke(A), *stroke(B), *stroke(C), back, *stroke(A)))
    assert [s.number for s in follow_steps(score).done] == [1, 2, 3, 4]
    first = delete_stroke(score, 1)
    assert said(first, "upto") == [1]
    assert [s.number for s in follow_steps(first).done] == [1, 2, 3]
    last = delete_stroke(score, 4)  # with it everything came back
    assert kinds(last)[-2:] == ["begin_stroke", "end_stroke"]
    assert [s.number for s in follow_steps(last).done] == [1, 2, 3]


def test_deleting_keeps_a_dip_for_the_strokes_after_it() -> None:
    dip, passing = {"do": "dip", "ink": "cinnabar"}, {"do": "follow_time", "seconds": 0.05}
    score = Score({}, (*stroke(A, dip, passing, B), passing, *stroke(C)))
    assert kinds(delete_stroke(score, 1))[:3] == ["dip", "follow_time", "begin_stroke"]
    assert kinds(delete_stroke(score, 2))[-1] == "follow_time"


def test_a_stroke_takes_another_time_with_the_ink_in_it() -> None:
    passing = {"do": "follow_time", "seconds": 0.05, "times": 3}
    score = Score({}, tuple(stroke(A, passing, B, passing, C, time_s=100.0)))
    slow, fast = retime_stroke(score, 1, 2.0), retime_stroke(score, 1, seconds=0.0064)
    assert slow.strokes()[0].time_ns.tolist() == [20_000_000 * k for k in range(9)]
    assert said(slow, "times") == [6, 6]
    assert fast.strokes()[0].time_ns[-1] == 6_400_000
    assert kinds(fast) == ["begin_stroke", "samples", "end_stroke"]
    later = retime_stroke(score, 1, shift_s=-0.5)
    assert later.strokes()[0].time_ns[0] == -500_000_000
    assert later.events[0]["time_s"] == 99.5


def test_a_shift_takes_from_the_pause() -> None:
    passing = {"do": "follow_time", "seconds": 0.05, "times": 10}
    score = Score({}, (*stroke(A), passing, *stroke(B), passing, *stroke(C)))
    later = retime_stroke(score, 2, shift_s=0.2)
    assert said(later, "times") == [10, 4, 6]
    earlier = retime_stroke(score, 2, shift_s=-0.5)
    assert said(earlier, "times") == [10, 10]
    for shift, side in ((0.6, "later: the pause after"), (-0.6, "earlier: the pause before")):
        with pytest.raises(RecordingError, match=f"2 cannot begin 0.60 s {side} it is 0.50 s"):
            retime_stroke(score, 2, shift_s=shift)


@pytest.mark.parametrize(
    ("edit", "told"),
    [
        (lambda s: delete_stroke(s, 8), "bamboo.score.jsonl: there is no stroke 8"),
        (lambda s: delete_stroke(s, 0), "stroke 0; expected 1 to 7"),
        (lambda s: change_ink(s, 2, {}), "stroke 2: begin_stroke: ink is {}; expected a text"),
        (
            lambda s: change_brush(s, 2, {"length_mm": 3}),
            "stroke 2: begin_stroke: brush is .* expected a text",
        ),
        (lambda s: retime_stroke(s, 2, 0.0), "stroke 2 would take 0 times its time"),
        (lambda s: delete_stroke(Score({}, ()), 1), "it has no strokes"),
    ],
)
def test_what_cannot_be_edited_is_said_with_the_number(edit, told) -> None:
    with pytest.raises(RecordingError, match=told):
        edit(load_score(EXAMPLE))


def test_an_edit_that_is_none_is_refused() -> None:
    score = load_score(EXAMPLE)
    with pytest.raises(InputError, match="edit is 'colour'; expected one of delete, move"):
        apply_stroke_edit(score, [1], {"do": "colour"}, ground())
    with pytest.raises(InputError, match="delete does not take 'far'"):
        apply_stroke_edit(score, [1], {"do": "delete", "far": 1}, ground())


NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    "edit",
    [
        *({"do": "time", "shift_s": shift} for shift in (NAN, INF, 1e300, -1e300, 9e9, "1")),
        *({"do": "time", "factor": factor} for factor in (NAN, INF, -1.0, "2")),
        *({"do": "time", "seconds": seconds} for seconds in (NAN, INF, 0.0)),
        *({"do": "move", "along": way} for way in (5, "ab", (1, 2, 3), (NAN, 0.0), (0.0, INF))),
        *({"do": "move", "turn_deg": turn} for turn in (NAN, INF, 1e300, "90")),
        *({"do": "move", "to": to} for to in ("x", (1, 2), [[1, 2, 3]] * 3, (NAN, 0, 0))),
        *({"do": "ink", "ink": ink} for ink in (5, {"pine soot": NAN}, {"pine soot": -1.0}, [])),
        *({"do": "brush", "brush": brush} for brush in (5, {}, [])),
        {"do": ["delete"]},
        {"do": None},
        {},
    ],
    ids=str,
)
def test_an_edit_with_values_that_are_none_is_refused(edit: dict) -> None:
    """In a score without time for the ink, where no pause says how far a stroke may be shifted."""
    score = Score({}, (*stroke(A), *stroke(B)))
    with pytest.raises(InputError) as caught:
        apply_stroke_edit(score, [1], edit, ground())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("shift", [1e9, -1e9, 4.6e9])
def test_a_score_with_a_large_shift_is_read_again(tmp_path: Path, shift: float) -> None:
    score = retime_stroke(Score({}, (*stroke(A), *stroke(B))), 1, shift_s=shift)
    save_score(score, tmp_path / "a.jsonl")
    assert load_score(tmp_path / "a.jsonl").n_samples == score.n_samples


@pytest.mark.parametrize(
    "name",
    [n for n, command in COMMANDS.items() if command.undo_label and not n.startswith("edit_")],
)
def test_a_command_with_a_step_of_undo_is_one_in_a_score(name: str) -> None:
    """Else an undo after it would be taken for one of the stroke before."""
    bare = SimpleNamespace(events=(*stroke(A), {"do": name}, {"do": "undo"}))  # no arguments
    steps = follow_steps(cast("Score", bare))
    assert [step.number for step in steps.done] == [1]
