"""Edits of a whole painting afterwards: strokes in the middle deleted, moved, in another ink.

Every function takes a score and gives a new one; what comes after the strokes stays as it was asked
for, and is painted anew when the score is played. Strokes count from 1, as `Score.strokes` has
them. `STROKE_EDITS` is all that can be done with strokes, by name: with one, or several as one.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.core.quaternion import (
    matrices_from_quaternions,
    multiply_quaternions,
    quaternions_from_matrices,
)
from paint3d.device.recorded import Recording
from paint3d.errors import InputError, RecordingError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.recording.score import Event, Score, check_command, join_adjacent
from paint3d.recording.score_steps import ScoreSteps, ScoreStroke, follow_steps, stroke_of

__all__ = [
    "STROKE_EDITS",
    "apply_seal_edit",
    "apply_stroke_edit",
    "change_brush",
    "change_ink",
    "delete_stroke",
    "move_stroke",
    "pressed_positions",
    "retime_stroke",
    "tangents_at",
]

# ---- Strokes on a surface ------------------------------------------------------------------------
# Strokes carried along the surface of an object, scaled or mirrored on it: positions, and how the
# brush stands on it.
#
# They go as a whole, like a stencil on a wall: from the tangent plane under their middle to that
# at the point where it goes, by the smallest turn between the two normals. Then every sample
# follows the surface under it: what lay under it comes to the nearest point, and the pose of the
# brush to that point's normal as it was to the old one. On a plane a move is a translation and a
# turn, exactly.


_STEPS = 64  # of the way along the surface
_LEAST_STEP = 0.5  # a step that is shorter by so much has met an edge
_NO_PATH_MM = 1e-9
_MOST_TURN = 36000.0  # degrees
_SMALLEST, _LARGEST = 0.05, 20.0  # scales
_UPRIGHT = 0.9  # cosine to the vertical above which a normal is that of a table, not of a wall
_BESIDE_MM, _BESIDE = 0.5, 0.35  # a point may be so far beside the nearest one's normal, and so
# many times its distance: farther, and it lies beyond an edge


def tangents_at(normal: ArrayLike) -> AnyArray:
    """The two directions that displacements along a surface are counted in, (2, 3).

    Where the surface lies (its normal is within 26 degrees of the vertical) the first is along x
    and the second along y, as seen from where the normal points; else the second is upwards, and
    the first to the right of who looks at it.
    """
    normal = np.asarray(normal, np.float64)
    if abs(normal[2]) > _UPRIGHT:
        first = np.array([1.0, 0.0, 0.0])
        first -= (first @ normal) * normal
        first /= np.linalg.norm(first)
        return np.array([first, np.cross(normal, first)])
    second = np.array([0.0, 0.0, 1.0]) - normal[2] * normal
    second /= np.linalg.norm(second)
    return np.array([np.cross(second, normal), second])


def pressed_positions(part: Recording) -> tuple[AnyArray, AnyArray]:
    """The points (N, 3) that a recording means, in the object's frame, mm, and where it presses.

    The second is (N,) bool, all of it without a pressure.
    """
    return _in_object(part)[1], _is_pressed(part)


@dataclass(frozen=True)
class _Stencil:
    """A map of the surface: from about one point of it to about another, in the object's frame.

    Attributes
    ----------
    middle, target : (3,) float64
        A point, and where it comes to, mm.
    turn : (3, 3) float64
        What it does to directions: a rotation, or a reflection of determinant -1.
    factor : float
        And to lengths.
    """

    middle: AnyArray
    target: AnyArray
    turn: AnyArray
    factor: float = 1.0


def _move_stencil(
    parts: Sequence[Recording],
    ground: ClosestPoints,
    along: tuple[float, float],
    turn_deg: float,
    to: ArrayLike | None,
) -> _Stencil:
    """The map of a move; see `move_stroke`."""
    displacement = as_array(along, "along (mm)", (2,))
    angle = as_number(turn_deg, "turn (degrees)", -_MOST_TURN, _MOST_TURN)
    middle, normal = _find_middle(parts, ground)
    position, up, turn = middle, normal, np.eye(3)
    if to is not None:
        ends = _check_ends(to)
        nearest = ground.find(ends)
        if len(ends) == 2:
            middle, normal = nearest.points[0], nearest.normals[0]
        position, up = nearest.points[-1], nearest.normals[-1]
        turn = _smallest_turns(normal[None], up[None])[0]
    ahead = displacement @ tangents_at(up)
    position, after, walked = _walk(ground, position, up, ahead)
    return _Stencil(middle, position, _turn_about(after, np.radians(angle)) @ walked @ turn)


def _find_middle(parts: Sequence[Recording], ground: ClosestPoints) -> tuple[AnyArray, AnyArray]:
    """The point of the surface under the middle of strokes, and its normal; object's frame, mm."""
    positions = np.concatenate([_in_object(part)[1] for part in parts])
    pressed = np.concatenate([_is_pressed(part) for part in parts])
    nearest = ground.find(positions[pressed] if pressed.any() else positions)
    middle = ground.find(nearest.points.mean(axis=0)[None])
    return middle.points[0], middle.normals[0]


def _check_ends(to: ArrayLike) -> AnyArray:
    """Target point (1, 3), or source and target (2, 3)."""
    try:
        return as_array(to, "to (mm)", (2, 3))
    except InputError:
        return as_array(to, "to (mm)", (3,))[None]


def _walk(
    ground: ClosestPoints, position: AnyArray, normal: AnyArray, ahead: AnyArray
) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Walk straight ahead on the surface: its end, the normal there, and the rotation (3, 3)."""
    turn = np.eye(3)
    if np.linalg.norm(ahead) < _NO_PATH_MM:
        return position, normal, turn
    start = normal
    step = ahead / _STEPS
    for k in range(_STEPS):
        nearest = ground.find((position + turn @ step)[None])
        if np.linalg.norm(nearest.points[0] - position) < _LEAST_STEP * np.linalg.norm(step):
            raise RecordingError(
                "its middle would come to the edge of the object after {k:.0%} of its way; "
                "expected a place on it",
                k=k / _STEPS,
            )
        if np.array_equal(nearest.normals[0], start):
            position = nearest.points[0]
            continue
        turn = _smallest_turns(start[None], nearest.normals)[0] @ turn
        position, start = nearest.points[0], nearest.normals[0]
    return position, start, turn


def _carry_part(part: Recording, ground: ClosestPoints, stencil: _Stencil) -> Recording:
    """Map a part's samples by a stencil, and onto the surface under it."""
    position, positions, own = _in_object(part)
    turn, factor = stencil.turn, stencil.factor
    was = ground.find(positions)
    wanted = stencil.target + factor * (was.points - stencil.middle) @ turn.T
    now = ground.find(wanted)
    # a sample lies beyond an edge where its nearest point of the surface is not under it
    offsets = wanted - now.points
    distance = np.linalg.norm(offsets, axis=1)
    beside = np.linalg.norm(
        offsets - np.sum(offsets * now.normals, axis=1)[:, None] * now.normals, axis=1
    )
    beyond = np.asarray(beside > _BESIDE_MM + _BESIDE * distance)
    refused = beyond & _is_pressed(part)
    if refused.any():
        k = int(np.argmax(refused))
        off = float(np.linalg.norm(wanted[k] - now.points[k]))
        raise RecordingError(
            "its sample {k} would come to lie {off:.1f} mm beyond an edge of the object; expected "
            "a place on it",
            k=k + 1,
            off=off,
        )
    turns = _smallest_turns(was.normals @ turn.T, now.normals) @ turn
    turns[beyond] = turn  # in the air beside the object
    below = np.where(beyond[:, None], wanted, now.points)
    moved = below + factor * np.einsum("nij,nj->ni", turns, position - was.points)
    contact = part.contact
    if contact is not None:
        points = below + factor * np.einsum("nij,nj->ni", turns, positions - was.points)
        contact = np.where(np.isnan(contact), np.nan, _to_world(part, points))
    if np.linalg.det(turn) < 0.0:  # a mirrored brush is a brush again: its y the other way round
        frames = turns @ matrices_from_quaternions(own)
        frames[:, :, 1] *= -1.0
        orientation = quaternions_from_matrices(frames)
    else:
        orientation = multiply_quaternions(quaternions_from_matrices(turns), own)
    orientation = multiply_quaternions(part.object_orientation, orientation)
    orientation /= np.linalg.norm(orientation, axis=1)[:, None]
    return replace(part, position=_to_world(part, moved), orientation=orientation, contact=contact)


def _carry_strokes(
    score: Score,
    numbers: Sequence[int],
    mesh: TriangleMesh | ClosestPoints | None,
    stencil_of: Callable[[Sequence[Recording], ClosestPoints], _Stencil],
) -> Score:
    """Map strokes by one stencil, made of the samples of all."""
    if mesh is None:
        raise InputError("strokes lie on an object; expected one to move, scale or mirror them on")
    ground = mesh if isinstance(mesh, ClosestPoints) else ClosestPoints(mesh)
    events = list(score.events)
    parts = [
        (number, k, event)
        for number in numbers
        for stroke in [stroke_of(score, number)[0]]
        for k in range(stroke.begin, stroke.end)
        if isinstance(event := events[k], Recording)
    ]
    which = ", ".join(map(str, numbers))
    try:
        stencil = stencil_of([part for _, _, part in parts], ground)
        for number, k, part in parts:
            which = str(number)
            events[k] = _carry_part(part, ground, stencil)
    except RecordingError as cause:
        raise RecordingError("stroke {number}: {cause}", number=which, cause=cause) from None
    return _with_events(score, events)


def _is_pressed(part: Recording) -> AnyArray:
    if part.pressure is None:
        return np.ones(len(part), bool)
    return np.asarray(part.pressure > 0.0)


def _in_object(part: Recording) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Positions, the points that are meant (N, 3), and orientations (N, 4), in the object."""
    back = matrices_from_quaternions(part.object_orientation).transpose(0, 2, 1)
    position = np.einsum("nij,nj->ni", back, part.position - part.object_position)
    points = position
    if part.contact is not None:
        meant = np.einsum("nij,nj->ni", back, part.contact - part.object_position)
        points = np.where(np.isnan(meant), position, meant)
    inverse = part.object_orientation * np.array([1.0, -1.0, -1.0, -1.0])
    return position, points, multiply_quaternions(inverse, part.orientation)


def _to_world(part: Recording, points: AnyArray) -> AnyArray:
    turns = matrices_from_quaternions(part.object_orientation)
    world: AnyArray = np.einsum("nij,nj->ni", turns, points) + part.object_position
    return world


def _smallest_turns(a: AnyArray, b: AnyArray) -> AnyArray:
    """The smallest rotations (N, 3, 3) that bring unit vectors a (N, 3) to b (N, 3).

    1 + K + K K / (1 + a.b) with K the cross product's matrix of a x b (Rodrigues).
    """
    cross, cosine = np.cross(a, b), np.sum(a * b, axis=1)
    opposite = cosine < -1.0 + 1e-9  # any turn by half a circle will do
    if opposite.any():
        beside = np.eye(3)[np.argmin(np.abs(a), axis=1)]
        axis = np.cross(a, beside)
        axis /= np.linalg.norm(axis, axis=1)[:, None]
        half = 2.0 * axis[:, :, None] * axis[:, None, :] - np.eye(3)
    k = np.zeros((len(a), 3, 3))
    k[:, [2, 0, 1], [1, 2, 0]] = cross
    k[:, [1, 2, 0], [2, 0, 1]] = -cross
    scale = 1.0 / np.where(opposite, 1.0, 1.0 + cosine)
    turns: AnyArray = np.eye(3) + k + (k @ k) * scale[:, None, None]
    if opposite.any():
        turns[opposite] = half[opposite]
    return turns


def _turn_about(axis: AnyArray, angle: float) -> AnyArray:
    """The rotation (3, 3) about a unit axis."""
    x, y, z = axis
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn: AnyArray = np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * (k @ k)
    return turn


# ---- Edits ---------------------------------------------------------------------------------------


_TIME_STEP_S = 0.05  # of the ink's time beside a hand
_SHORTEST, _LONGEST = 1e-3, 1e3  # that a stroke becomes of its length
_LATEST_NS = 1 << 62  # or earliest below 0: as a line of a score may say it


def delete_stroke(score: Score, number: int) -> Score:
    """Take a stroke out, as if it had never been painted.

    With it go the time that passed during it, and the undos and redos that were for it. A brush
    that was dipped in another ink, or in more or less of it, during it stays dipped.

    Raises
    ------
    RecordingError
        If there is no such stroke.
    """
    stroke, steps = stroke_of(score, number)
    events: list[Event] = []
    for k, event in enumerate(score.events):
        if stroke.begin <= k < stroke.end:
            events += _remaining_events(k, event, stroke, number < len(steps.strokes))
        elif k in steps.affected_steps and not isinstance(event, Recording):
            events += _history_command_without(k, event, stroke, steps)
        else:
            events.append(event)
    return _with_events(score, events)


def _remaining_events(k: int, event: Event, stroke: ScoreStroke, goes_on: bool) -> list[Event]:
    """Events that remain of an event of a deleted stroke."""
    if isinstance(event, Recording):
        return []
    if k == stroke.begin and stroke.emptied_redo:  # a stroke of nothing forgets as it did
        return [event, {"do": "end_stroke"}]
    lasts = event["do"] == "dip" and ("ink" in event or "amount" in event)
    return [event] if goes_on and lasts else []


def _history_command_without(
    k: int, event: Mapping[str, Any], stroke: ScoreStroke, steps: ScoreSteps
) -> list[Event]:
    """An undo, redo or replay with a stroke removed."""
    if event["do"] == "replay_history":
        n_left = sum(one is not stroke for one in steps.strokes_after[k])
        return [{**event, "upto": n_left}] if not event.get("refused") else [event]
    affected = steps.affected_steps[k]
    idle = k > stroke.begin and not affected and event["do"] == "redo"
    return [] if idle or any(step is stroke for step in affected) else [event]


def move_stroke(
    score: Score,
    number: int,
    mesh: TriangleMesh | ClosestPoints,
    along: tuple[float, float] = (0.0, 0.0),
    turn_deg: float = 0.0,
    to: ArrayLike | None = None,
) -> Score:
    """Carry a stroke along the surface.

    Parameters
    ----------
    score : Score
    number : int
    mesh : TriangleMesh or ClosestPoints
        The object that it is painted on.
    along : (float, float)
        mm: on a lying surface along x and y, on a standing one to the right and upwards.
    turn_deg : float
        About the surface's normal, counter-clockwise for who looks at it.
    to : (3,) or (2, 3), optional
        Where its middle comes to, in the object's frame, mm, or where a point comes to at which it
        is taken hold of; before `along`.

    Raises
    ------
    RecordingError
        If there is no such stroke, or it would come to lie beyond an edge of the object.
    InputError
        If a length, the turn or a point is no such thing.
    """
    return _move(score, [number], mesh, along, turn_deg, to)


def _move(
    score: Score,
    numbers: Sequence[int],
    mesh: TriangleMesh | ClosestPoints | None,
    along: tuple[float, float] = (0.0, 0.0),
    turn_deg: float = 0.0,
    to: ArrayLike | None = None,
) -> Score:
    return _carry_strokes(
        score, numbers, mesh, lambda p, ground: _move_stencil(p, ground, along, turn_deg, to)
    )


def _scale(
    score: Score,
    numbers: Sequence[int],
    mesh: TriangleMesh | ClosestPoints | None,
    factor: float,
    brushes: Sequence[str | Mapping[str, Any]],
) -> Score:
    factor = as_number(factor, "factor", _SMALLEST, _LARGEST)
    if len(brushes) != len(numbers):
        raise InputError(
            "there are {brushes} brushes for {strokes} strokes; expected one for each",
            brushes=len(brushes),
            strokes=len(numbers),
        )

    def stencil(parts: Sequence[Recording], ground: ClosestPoints) -> _Stencil:
        middle, _ = _find_middle(parts, ground)
        return _Stencil(middle, middle, np.eye(3), factor)

    score = _carry_strokes(score, numbers, mesh, stencil)
    for number, brush in zip(numbers, brushes, strict=True):
        score = change_brush(score, number, brush)
    return score


def _mirror(
    score: Score,
    numbers: Sequence[int],
    mesh: TriangleMesh | ClosestPoints | None,
    across: str = "x",
) -> Score:
    if across not in ("x", "y"):
        raise InputError("across is {across!r}; expected 'x' or 'y'", across=across)

    def stencil(parts: Sequence[Recording], ground: ClosestPoints) -> _Stencil:
        middle, normal = _find_middle(parts, ground)
        axis = tangents_at(normal)["xy".index(across)]
        return _Stencil(middle, middle, np.eye(3) - 2.0 * np.outer(axis, axis))

    return _carry_strokes(score, numbers, mesh, stencil)


def change_ink(
    score: Score,
    number: int,
    ink: str | Mapping[str, float],
    pigments: Mapping[str, Any] | None = None,
) -> Score:
    """Paint a stroke in another ink.

    The brush holds as much of it as it held of its own ink at that moment.

    Parameters
    ----------
    score : Score
    number : int
    ink : str or mapping
        A name of the palette or of the header's pigments, or the parts of several.
    pigments : mapping, optional
        Properties of inks that are no palette's, as a header says them.

    Raises
    ------
    RecordingError
        If there is no such stroke, or this is no ink.
    """
    words = dict(ink) if isinstance(ink, Mapping) else ink
    changed = _with_begin(score, number, {"ink": words})
    if not pigments:
        return changed
    known = {**changed.header.get("pigments", {}), **pigments}
    return replace(changed, header={**changed.header, "pigments": known})


def change_brush(score: Score, number: int, brush: str | Mapping[str, Any]) -> Score:
    """Paint a stroke with another brush, dipped in the same ink; the own one waits meanwhile.

    Parameters
    ----------
    score : Score
    number : int
    brush : str or mapping
        A preset's name, or all parameters of a brush.

    Raises
    ------
    RecordingError
        If there is no such stroke, or this is no brush.
    """
    words = dict(brush) if isinstance(brush, Mapping) else brush
    return _with_begin(score, number, {"brush": words})


def _with_begin(score: Score, number: int, words: Mapping[str, Any]) -> Score:
    stroke, _ = stroke_of(score, number)
    events = list(score.events)
    begin = events[stroke.begin]
    assert not isinstance(begin, Recording), "a stroke begins with a command"
    events[stroke.begin] = changed = {**begin, **words}
    try:
        check_command(changed)
    except RecordingError as cause:
        raise RecordingError("stroke {number}: {cause}", number=number, cause=cause) from None
    return _with_events(score, events)


def retime_stroke(
    score: Score,
    number: int,
    factor: float = 1.0,
    *,
    seconds: float | None = None,
    shift_s: float = 0.0,
) -> Score:
    """Stretch a stroke to another duration, or shift its beginning.

    Where ink runs meanwhile, its time in the stroke becomes longer or shorter with it, in time
    steps as they were; a shift takes from the pause on one side and gives to that on the other.

    Parameters
    ----------
    score : Score
    number : int
    factor : float
        How many times as long as it was.
    seconds : float, optional
        How long, instead.
    shift_s : float
        How much later it begins, s.

    Raises
    ------
    RecordingError
        If there is no such stroke, the time is out of range, or there is no pause to move it in.
    """
    stroke, _ = stroke_of(score, number)
    events = list(score.events)
    own = events[stroke.begin : stroke.end]
    parts = [event for event in own if isinstance(event, Recording)]
    first, last = int(parts[0].time_ns[0]), int(parts[-1].time_ns[-1])
    if seconds is not None:
        if last == first:
            raise RecordingError(
                "stroke {number} is one sample; expected several to give it time",
                number=number,
            )
        factor = as_number(seconds, "time of a stroke (s)") / ((last - first) * 1e-9)
    factor = as_number(factor, "factor")
    if not _SHORTEST <= factor <= _LONGEST:
        raise RecordingError(
            "stroke {number} would take {factor:.4g} times its time; expected {least:g} to "
            "{most:g}",
            number=number,
            factor=factor,
            least=_SHORTEST,
            most=_LONGEST,
        )
    length = round((last - first) * factor)
    most = 1e-9 * _LATEST_NS
    shift = round(1e9 * as_number(shift_s, f"shift of stroke {number} (s)", -most, most,
                                  RecordingError))  # fmt: skip
    ends = [first + shift, first + shift + length]
    if max(map(abs, ends)) > _LATEST_NS:
        raise RecordingError(
            "stroke {number} would be at {first:.4g} to {second:.4g} s; expected it within "
            "{most:.4g} s of 0",
            number=number,
            first=1e-9 * ends[0],
            second=1e-9 * ends[1],
            most=most,
        )
    try:
        own = _stretch_times(own, first, factor, shift)
    except RecordingError:
        raise RecordingError(
            "stroke {number} would have two samples at one time with a factor of {factor:.4g}",
            number=number,
            factor=factor,
        ) from None
    begin = own[0]
    if shift_s and isinstance(begin, Mapping) and "time_s" in begin:
        own[0] = {**begin, "time_s": max(0.0, begin["time_s"] + shift_s)}
    before, after = events[: stroke.begin], events[stroke.end :]
    if shift_s and any(not isinstance(e, Recording) and _is_ink_time(e) for e in events):
        n_steps = round(shift_s / _TIME_STEP_S)
        _adjust_pause(before, n_steps, len(before), number)
        _adjust_pause(after, -n_steps, 0, number)
    return _with_events(score, [*before, *own, *after])


def _is_ink_time(event: Event) -> bool:
    return not isinstance(event, Recording) and event["do"] == "follow_time"


def _stretch_times(own: Sequence[Event], first: int, factor: float, shift: int) -> list[Event]:
    """Scale the times of a stroke's events: of samples, and of the ink between them."""
    stretched: list[Event] = []
    passed, given = 0, 0
    for event in own:
        if isinstance(event, Recording):
            since = event.time_ns - first
            times = first + shift + np.rint(since * factor).astype(np.int64)
            stretched.append(replace(event, time_ns=times))
        elif _is_ink_time(event):
            passed += event.get("times", 1)
            n_steps = int(np.floor(passed * factor + 0.5)) - given
            given += n_steps
            if n_steps:
                stretched.append({**event, "times": n_steps})
        else:
            stretched.append(event)
    return join_adjacent(stretched)


def _adjust_pause(events: list[Event], n_steps: int, at: int, number: int) -> None:
    """Add time steps (remove below 0) beside a stroke, at one end of events."""
    wanted, step = abs(n_steps) * _TIME_STEP_S, -1 if at else 1
    k = at + (step if at else 0)
    while n_steps < 0 and 0 <= k < len(events):
        event = events[k]
        if isinstance(event, Recording) or event["do"] in ("begin_stroke", "end_stroke"):
            break
        if _is_ink_time(event):
            taken = min(-n_steps, event.get("times", 1))
            events[k] = {**event, "times": event.get("times", 1) - taken}
            n_steps += taken
        k += step
    if n_steps < 0 and 0 <= k < len(events):
        pause = wanted + n_steps * _TIME_STEP_S
        if at:
            raise RecordingError(
                "stroke {number} cannot begin {wanted:.2f} s earlier: the pause before it is "
                "{pause:.2f} s; expected a shift within it",
                number=number,
                wanted=wanted,
                pause=pause,
            )
        raise RecordingError(
            "stroke {number} cannot begin {wanted:.2f} s later: the pause after it is "
            "{pause:.2f} s; expected a shift within it",
            number=number,
            wanted=wanted,
            pause=pause,
        )
    if n_steps > 0:
        events.insert(at, {"do": "follow_time", "seconds": _TIME_STEP_S, "times": n_steps})
    events[:] = [e for e in events if isinstance(e, Recording) or e.get("times", 1) > 0]


def _with_events(score: Score, events: Sequence[Event]) -> Score:
    return replace(score, events=tuple(events), lines=())


# -- seals ------------------------------------------------------------------------------------


def apply_seal_edit(score: Score, number: int, edit: Mapping[str, Any]) -> Score:
    """Delete a seal, press it elsewhere, or in another paste.

    Parameters
    ----------
    score : Score
    number : int
        From 1, among the seals that are there.
    edit : mapping
        ``do``: "delete"; "move", with ``at`` and ``up`` as `press_seal` takes them; or "ink", with
        ``ink``, and ``pigments`` for those that no palette has.

    Raises
    ------
    InputError
        If there is no such edit.
    RecordingError
        If there is no such seal, or it cannot be pressed so.
    """
    steps = follow_steps(score)
    if not 1 <= number <= len(steps.seals):
        raise RecordingError(
            "seal {number}; expected one of {count}", number=number, count=len(steps.seals)
        )
    seal = steps.seals[number - 1]
    takes = {"delete": set[str](), "move": {"at", "up"}, "ink": {"ink", "pigments"}}
    do, words = edit.get("do"), {key: value for key, value in edit.items() if key != "do"}
    if do not in takes or set(words) - takes[do]:
        raise InputError(
            "edit of a seal is {edit}; expected {known}",
            edit=f"{dict(edit)!r:.60}",
            known=", ".join(takes),
        )
    if do == "delete":
        remaining: list[Event] = []
        for k, event in enumerate(score.events):
            if k in steps.affected_steps and not isinstance(event, Recording):
                remaining += _history_command_without(k, event, seal, steps)
            elif k != seal.begin:
                remaining.append(event)
        return _with_events(score, remaining)
    events, pigments = list(score.events), words.pop("pigments", {})
    pressed = events[seal.begin]
    assert not isinstance(pressed, Recording), "a seal is a command"
    events[seal.begin] = changed = {**pressed, **words}
    check_command(changed)
    known = {**score.header.get("pigments", {}), **pigments}
    header = {**score.header, "pigments": known} if pigments else score.header
    return _with_events(replace(score, header=header), events)


# -- edits by name ----------------------------------------------------------------------------


def apply_stroke_edit(
    score: Score,
    numbers: Sequence[int],
    edit: Mapping[str, Any],
    mesh: TriangleMesh | ClosestPoints | None = None,
) -> Score:
    """Edit one stroke, or several as one: ``{"do": "move", "along": [5, 0], "turn_deg": 30}``.

    Parameters
    ----------
    score : Score
    numbers : sequence of int
        From 1, each once.
    edit : mapping
        ``do``, one of `EDITS`, and its words:

        - "move": ``along``, ``turn_deg`` and ``to``, as `move_stroke` takes them, of the middle of
          all strokes and about it;
        - "scale": ``factor``, about the middle, and ``brushes``: with which each stroke is painted
          then, a preset's name or all parameters;
        - "mirror": ``across`` the first direction of `tangents_at`, "x", or the second, "y";
        - "ink", "brush" and "time", as `change_ink`, `change_brush` and `retime_stroke` take them;
        - "delete".
    mesh : TriangleMesh or ClosestPoints, optional
        The object, for strokes that are moved, scaled or mirrored.

    Raises
    ------
    InputError
        If there is no such edit, it takes other words, or a word is no such thing.
    RecordingError
        If there is no such stroke, or it would come to lie beyond an edge of the object.
    """
    do, words = edit.get("do"), {key: value for key, value in edit.items() if key != "do"}
    if not isinstance(do, str) or do not in STROKE_EDITS:
        raise InputError(
            "edit is {do!r:.40}; expected one of {edits}", do=do, edits=", ".join(STROKE_EDITS)
        )
    takes = inspect.signature(STROKE_EDITS[do])
    try:
        takes.bind(score, numbers, mesh, **words)
    except TypeError:
        raise InputError(
            "{do} does not take {words!r:.80}; it takes ({takes})",
            do=do,
            words=", ".join(words),
            takes=", ".join(list(takes.parameters)[3:]),
        ) from None
    return STROKE_EDITS[do](score, numbers, mesh, **words)


def _delete(score: Score, numbers: Sequence[int], _: object) -> Score:
    for number in sorted(numbers, reverse=True):  # those before keep their numbers
        score = delete_stroke(score, number)
    return score


def _ink(
    score: Score,
    numbers: Sequence[int],
    _: object,
    ink: str | Mapping[str, float],
    pigments: Mapping[str, Any] | None = None,
) -> Score:
    for number in numbers:
        score = change_ink(score, number, ink, pigments)
    return score


def _brush(
    score: Score, numbers: Sequence[int], _: object, brush: str | Mapping[str, Any]
) -> Score:
    for number in numbers:
        score = change_brush(score, number, brush)
    return score


def _time(
    score: Score,
    numbers: Sequence[int],
    _: object,
    factor: float = 1.0,
    seconds: float | None = None,
    shift_s: float = 0.0,
) -> Score:
    # A stroke is shifted into the pause beside it: the last one first where they begin later.
    is_later = isinstance(shift_s, int | float) and shift_s > 0.0
    for number in sorted(numbers, reverse=is_later):
        score = retime_stroke(score, number, factor, seconds=seconds, shift_s=shift_s)
    return score


STROKE_EDITS: Mapping[str, Callable[..., Score]] = {
    "delete": _delete,
    "move": _move,
    "scale": _scale,
    "mirror": _mirror,
    "ink": _ink,
    "brush": _brush,
    "time": _time,
}
"""Edits of strokes by name: of a score, their numbers, the object, and the edit's words."""
