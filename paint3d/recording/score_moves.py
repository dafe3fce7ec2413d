"""A stroke carried along the surface of an object: places, and how the brush stands on it.

The stroke is carried as a whole, like a stencil on a wall: from the tangent plane under its middle
to that at the place where it goes, by the smallest turn between the two normals. Then every sample
follows the surface under it: what lay under it comes to the nearest place, and the pose of the
brush to that place's normal as it was to the old one. On a plane this is a translation and a turn,
exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from paint3d.core.arrays import as_array, as_number
from paint3d.core.quaternion import (
    matrices_from_quaternions,
    multiply_quaternions,
    quaternions_from_matrices,
)
from paint3d.core.types import AnyArray
from paint3d.device.recorded import Recording
from paint3d.errors import InputError, RecordingError
from paint3d.mesh.closest_points import ClosestPoints
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["carried", "middle_of", "pressed_places", "tangents_at"]

_STEPS = 64  # of the way along the surface
_LEAST_STEP = 0.5  # a step that is shorter by so much has met an edge
_NO_WAY_MM = 1e-9
_MOST_TURN = 36000.0  # degrees
_UPRIGHT = 0.9  # cosine to the vertical above which a normal is that of a table, not of a wall
_BESIDE_MM, _BESIDE = 0.5, 0.35  # a place may be so far beside the nearest one's normal, and so
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


def middle_of(parts: Sequence[Recording], ground: ClosestPoints) -> tuple[AnyArray, AnyArray]:
    """The place of the surface under the middle of a stroke, and its normal; object's frame, mm."""
    places = np.concatenate([_in_object(part)[1] for part in parts])
    pressed = np.concatenate([_pressed(part) for part in parts])
    found = ground.find(places[pressed] if pressed.any() else places)
    middle = ground.find(found.points.mean(axis=0)[None])
    return middle.points[0], middle.normals[0]


def pressed_places(part: Recording) -> tuple[AnyArray, AnyArray]:
    """The places (N, 3) that a recording means, in the object's frame, mm, and where it presses.

    Both as `middle_of` counts them; the second is (N,) bool, all of it without a pressure.
    """
    return _in_object(part)[1], _pressed(part)


def carried(
    parts: Sequence[Recording],
    mesh: TriangleMesh | ClosestPoints,
    along: tuple[float, float] = (0.0, 0.0),
    turn_deg: float = 0.0,
    to: ArrayLike | None = None,
) -> list[Recording]:
    """Carry the samples of a stroke along the surface.

    Parameters
    ----------
    parts : sequence of Recording
    mesh : TriangleMesh or ClosestPoints
        The object.
    along : (float, float)
        mm along the surface; see `tangents_at`.
    turn_deg : float
        About the normal, counter-clockwise for who looks at the surface.
    to : (3,) or (2, 3), optional
        Where the middle of the stroke comes to, in the object's frame, mm; or the place where it is
        taken hold of, and where that comes to; before `along`.

    Raises
    ------
    RecordingError
        If the brush would come down beyond an edge of the object.
    InputError
        If a length, the turn or a place is no such thing.
    """
    way = as_array(along, "along (mm)", (2,))
    angle = as_number(turn_deg, "turn (degrees)", -_MOST_TURN, _MOST_TURN)
    ground = mesh if isinstance(mesh, ClosestPoints) else ClosestPoints(mesh)
    middle, normal = middle_of(parts, ground)
    place, up, turn = middle, normal, np.eye(3)
    if to is not None:
        ends = _ends(to)
        found = ground.find(ends)
        if len(ends) == 2:
            middle, normal = found.points[0], found.normals[0]
        place, up = found.points[-1], found.normals[-1]
        turn = _smallest_turns(normal[None], up[None])[0]
    ahead = way @ tangents_at(up)
    place, after, walked = _walk(ground, place, up, ahead)
    turn = _turn_about(after, np.radians(angle)) @ walked @ turn
    return [_follow(part, ground, middle, place, turn) for part in parts]


def _ends(to: ArrayLike) -> AnyArray:
    """Where something goes (1, 3), or from where to where (2, 3)."""
    try:
        return as_array(to, "to (mm)", (2, 3))
    except InputError:
        return as_array(to, "to (mm)", (3,))[None]


def _walk(
    ground: ClosestPoints, place: AnyArray, normal: AnyArray, ahead: AnyArray
) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Go straight ahead on the surface: where that leads, the normal there, and the turn (3, 3)."""
    turn = np.eye(3)
    if np.linalg.norm(ahead) < _NO_WAY_MM:
        return place, normal, turn
    start = normal
    step = ahead / _STEPS
    for k in range(_STEPS):
        found = ground.find((place + turn @ step)[None])
        if np.linalg.norm(found.points[0] - place) < _LEAST_STEP * np.linalg.norm(step):
            raise RecordingError(
                f"its middle would come to the edge of the object after {k / _STEPS:.0%} of its "
                "way; expected a place on it"
            )
        if np.array_equal(found.normals[0], start):
            place = found.points[0]
            continue
        turn = _smallest_turns(start[None], found.normals)[0] @ turn
        place, start = found.points[0], found.normals[0]
    return place, start, turn


def _follow(
    part: Recording, ground: ClosestPoints, middle: AnyArray, place: AnyArray, turn: AnyArray
) -> Recording:
    """The samples of a part where the stencil's turn and the surface under it bring them."""
    position, places, own = _in_object(part)
    was = ground.find(places)
    wanted = place + (was.points - middle) @ turn.T
    now = ground.find(wanted)
    beyond = _beyond(wanted - now.points, now.normals)
    refused = beyond & _pressed(part)
    if refused.any():
        k = int(np.argmax(refused))
        off = float(np.linalg.norm(wanted[k] - now.points[k]))
        raise RecordingError(
            f"its sample {k + 1} would come to lie {off:.1f} mm beyond an edge of the object; "
            "expected a place on it"
        )
    turns = _smallest_turns(was.normals @ turn.T, now.normals) @ turn
    turns[beyond] = turn  # in the air beside the object
    below = np.where(beyond[:, None], wanted, now.points)
    moved = below + np.einsum("nij,nj->ni", turns, position - was.points)
    contact = part.contact
    if contact is not None:
        kept = below + np.einsum("nij,nj->ni", turns, places - was.points)
        contact = np.where(np.isnan(contact), np.nan, _to_world(part, kept))
    orientation = multiply_quaternions(
        part.object_orientation,
        multiply_quaternions(quaternions_from_matrices(turns), own),
    )
    orientation /= np.linalg.norm(orientation, axis=1)[:, None]
    return replace(part, position=_to_world(part, moved), orientation=orientation, contact=contact)


def _beyond(offsets: AnyArray, normals: AnyArray) -> AnyArray:
    """(N,) bool: places whose nearest one on the surface does not lie under them."""
    distance = np.linalg.norm(offsets, axis=1)
    beside = np.linalg.norm(offsets - np.sum(offsets * normals, axis=1)[:, None] * normals, axis=1)
    return np.asarray(beside > _BESIDE_MM + _BESIDE * distance)


def _pressed(part: Recording) -> AnyArray:
    if part.pressure is None:
        return np.ones(len(part), bool)
    return np.asarray(part.pressure > 0.0)


def _in_object(part: Recording) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Positions, the places that are meant (N, 3), and orientations (N, 4), in the object."""
    back = matrices_from_quaternions(part.object_orientation).transpose(0, 2, 1)
    position = np.einsum("nij,nj->ni", back, part.position - part.object_position)
    places = position
    if part.contact is not None:
        meant = np.einsum("nij,nj->ni", back, part.contact - part.object_position)
        places = np.where(np.isnan(meant), position, meant)
    inverse = part.object_orientation * np.array([1.0, -1.0, -1.0, -1.0])
    return position, places, multiply_quaternions(inverse, part.orientation)


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
