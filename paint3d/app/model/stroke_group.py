"""Edits of several strokes at once: moved, turned, scaled, mirrored as one, re-inked or deleted.

What lies on the object moves as `recording.score_edits` carries a single stroke: like a stencil
that follows the surface under it. Strokes that are scaled are painted with a brush that is scaled
with them, dipped anew.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from paint3d.app.model.brush_in_hand import scaled
from paint3d.app.model.score.words import brush_named
from paint3d.brush.spec import BrushSpec
from paint3d.core.arrays import AnyArray, as_number, cross
from paint3d.core.quaternion import (
    matrices_from_quaternions,
    multiply_quaternions,
    quaternions_from_matrices,
)
from paint3d.errors import InputError, RecordingError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score
from paint3d.recording.score_edits import (
    carried,
    change_brush,
    edit_stroke,
    middle_of,
    pressed_places,
    tangents_at,
)
from paint3d.recording.score_steps import stroke_of

__all__ = ["GROUP_EDITS", "edit_group"]

GROUP_EDITS = {
    "move": {"along", "turn_deg", "to"}, "scale": {"factor"}, "mirror": {"across"},
    "ink": {"ink", "pigments"}, "brush": {"brush"}, "delete": set[str](),
}  # fmt: skip
"""What can be done with several strokes, and the words that say how."""
_SMALLEST, _LARGEST = 0.05, 20.0
_BESIDE_MM = 1.0  # that a place may come to lie off the object


def edit_group(
    score: Score,
    numbers: Sequence[int],
    brushes: Sequence[BrushSpec],
    edit: Mapping[str, Any],
    mesh: TriangleMesh,
) -> Score:
    """Edit several strokes of a score as one.

    Parameters
    ----------
    score : Score
    numbers : sequence of int
        From 1, as `Score.strokes` has them.
    brushes : sequence of BrushSpec
        With which each was painted.
    edit : mapping
        ``do``: "move", with ``along``, ``turn_deg`` and ``to`` as `score_edits.carried` takes them,
        about the middle of all; "scale", with ``factor``; "mirror", with ``across``: "x", left and
        right, or "y"; "ink", "brush" and "delete" as `score_edits.edit_stroke` takes them.
    mesh : TriangleMesh
        The object.

    Raises
    ------
    InputError
        If there is no such edit.
    RecordingError
        If there is no such stroke, or one would come to lie beside the object.
    """
    do, words = edit.get("do"), {key: value for key, value in edit.items() if key != "do"}
    if do not in GROUP_EDITS or set(words) - GROUP_EDITS[do]:
        raise InputError(
            "edit of strokes is {edit}; expected {known}",
            edit=f"{dict(edit)!r:.60}",
            known=", ".join(GROUP_EDITS),
        )
    if do in ("ink", "brush", "delete"):
        for number in sorted(numbers, reverse=True):  # those before keep their numbers
            score = edit_stroke(score, number, edit, mesh)
        return score
    ground = ClosestPoints(mesh)
    events, places = list(score.events), list[int]()
    for number in numbers:
        stroke, _ = stroke_of(score, number)
        own = range(stroke.begin, stroke.end)
        places += [k for k in own if isinstance(events[k], Recording)]
    parts = [event for k in places if isinstance(event := events[k], Recording)]
    if do == "move":
        moved = carried(parts, ground, **words)
    else:
        moved = _shaped(parts, ground, do, words)
    for k, part in zip(places, moved, strict=True):
        events[k] = part
    score = replace(score, events=tuple(events), lines=())
    if do == "scale":
        factor = float(words["factor"])
        for number, brush in zip(numbers, brushes, strict=True):
            score = change_brush(score, number, brush_named(scaled(brush, factor)))
    return score


def _shaped(
    parts: Sequence[Recording], ground: ClosestPoints, do: str, words: Mapping[str, Any]
) -> list[Recording]:
    """The samples of strokes scaled or mirrored about the middle of all, on the surface."""
    middle, normal = middle_of(parts, ground)
    factor, flip = 1.0, np.eye(3)
    if do == "scale":
        factor = as_number(words.get("factor"), "factor", _SMALLEST, _LARGEST)
    else:
        across = words.get("across", "x")
        if across not in ("x", "y"):
            raise InputError("across is {across!r}; expected 'x' or 'y'", across=across)
        axis = tangents_at(normal)["xy".index(across)]
        flip -= 2.0 * np.outer(axis, axis)
    return [_follow(part, ground, middle, factor, flip) for part in parts]


def _follow(
    part: Recording, ground: ClosestPoints, middle: AnyArray, factor: float, flip: AnyArray
) -> Recording:
    """One recording: each sample to where it is wanted, and as far above the surface there."""
    places, pressed = pressed_places(part)
    object_turns = matrices_from_quaternions(part.object_orientation)
    position = np.einsum("nji,nj->ni", object_turns, part.position - part.object_position)
    inverse = part.object_orientation * np.array([1.0, -1.0, -1.0, -1.0])
    frames = matrices_from_quaternions(multiply_quaternions(inverse, part.orientation))
    was = ground.find(places)
    wanted = middle + factor * (was.points - middle) @ flip.T
    now = ground.find(wanted)
    off = now.points - wanted
    beside = np.linalg.norm(off - np.sum(off * now.normals, axis=1)[:, None] * now.normals, axis=1)
    if (pressed & (beside > _BESIDE_MM)).any():
        raise RecordingError(
            "a stroke would come to lie {off:.1f} mm beside the object; expected a place on it",
            off=float(beside[pressed].max()),
        )
    turns = _smallest_turns(was.normals @ flip.T, now.normals)

    def moved(points: AnyArray) -> AnyArray:
        away = factor * (points - was.points) @ flip.T
        there = now.points + np.einsum("nij,nj->ni", turns, away)
        world: AnyArray = np.einsum("nij,nj->ni", object_turns, there) + part.object_position
        return world

    flipped = np.einsum("nij,njk->nik", turns @ flip, frames)
    x, z = flipped[:, :, 0], flipped[:, :, 2]  # a mirrored brush is a brush again
    own = quaternions_from_matrices(np.stack([x, cross(z, x), z], axis=-1))
    orientation = multiply_quaternions(part.object_orientation, own)
    orientation /= np.linalg.norm(orientation, axis=1)[:, None]
    contact = part.contact
    if contact is not None:
        contact = np.where(np.isnan(contact), np.nan, moved(places))
    return replace(part, position=moved(position), orientation=orientation, contact=contact)


def _smallest_turns(a: AnyArray, b: AnyArray) -> AnyArray:
    """The smallest rotations (N, 3, 3) that bring unit vectors a (N, 3) to b (N, 3)."""
    half = a + b
    half /= np.maximum(np.linalg.norm(half, axis=1, keepdims=True), 1e-12)
    q = np.concatenate([np.sum(a * half, axis=1)[:, None], np.cross(a, half)], axis=1)
    q /= np.linalg.norm(q, axis=1)[:, None]
    return matrices_from_quaternions(q)
