"""Mirror planes and turns about an axis: what is painted once appears in all its images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, as_array, cross
from paint3d.core.quaternion import matrices_from_quaternions, quaternions_from_matrices
from paint3d.device.sample import DeviceSample
from paint3d.errors import InputError
from paint3d.pose.brush_pose import object_poses

__all__ = ["MirrorPlane", "RadialSymmetry", "Symmetry", "transform_samples"]

MOST_IMAGES = 64
_REST = np.array([1.0, 0.0, 0.0, 0.0])
_SAME = 1e-9


@dataclass(frozen=True)
class MirrorPlane:
    """A plane in the object's frame: a point on it (mm) and its normal, of any length."""

    point: tuple[float, float, float]
    normal: tuple[float, float, float]


@dataclass(frozen=True)
class RadialSymmetry:
    """Turns by an n-th of a circle about an axis in the object's frame.

    Attributes
    ----------
    count : int
        n, 2 to 64.
    point, axis : (float, float, float)
        A point on the axis (mm), and its direction.
    """

    count: int
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Symmetry:
    """Which images a stroke has: of every set of the planes, turned by every turn.

    Attributes
    ----------
    planes : tuple of MirrorPlane
    radial : RadialSymmetry or None

    Raises
    ------
    InputError
        If a normal or axis has no direction, or there are more than 64 images.
    """

    planes: tuple[MirrorPlane, ...] = ()
    radial: RadialSymmetry | None = None

    def __post_init__(self) -> None:
        self.images()

    def images(self) -> list[AnyArray]:
        """The (4, 4) transforms of all images but the stroke itself, in a fixed order."""
        turns = self.radial.count if self.radial else 1
        if isinstance(turns, bool) or not isinstance(turns, int) or not 1 <= turns <= MOST_IMAGES:
            raise InputError(
                "radial symmetry has {turns!r} images; expected 2 to {most}",
                turns=turns,
                most=MOST_IMAGES,
            )
        if turns * 2 ** len(self.planes) > MOST_IMAGES:
            raise InputError(
                "{turns} turns and {n} planes make too many images; expected {most} at most",
                turns=turns,
                n=len(self.planes),
                most=MOST_IMAGES,
            )
        images = [np.eye(4)]
        for plane in self.planes:
            mirror = _mirror_matrix(plane)
            images += [mirror @ image for image in images]
        if self.radial is not None:
            turned = [_turn_matrix(self.radial, k) for k in range(turns)]
            images = [turn @ image for turn in turned for image in images]
        distinct: list[AnyArray] = []
        for candidate in images:
            if all(np.abs(candidate - other).max() > _SAME for other in distinct):
                distinct.append(candidate)
        return distinct[1:]


def _mirror_matrix(plane: MirrorPlane) -> AnyArray:
    normal, point = _direction(plane.normal), as_array(plane.point, "point", (3,))
    image = np.eye(4)
    image[:3, :3] -= 2.0 * np.outer(normal, normal)
    image[:3, 3] = 2.0 * (normal @ point) * normal
    return image


def _turn_matrix(radial: RadialSymmetry, k: int) -> AnyArray:
    axis, point = _direction(radial.axis), as_array(radial.point, "point", (3,))
    half = np.pi * k / radial.count
    q = np.array([np.cos(half), *(np.sin(half) * axis)])
    image = np.eye(4)
    image[:3, :3] = matrices_from_quaternions(q[None])[0]
    image[:3, 3] = point - image[:3, :3] @ point
    return image


def _direction(vector: Sequence[float]) -> AnyArray:
    direction: AnyArray = as_array(vector, "normal or axis", (3,))
    length = float(np.linalg.norm(direction))
    if length < 1e-12:
        raise InputError("a normal or axis of symmetry is 0; expected a direction")
    unit: AnyArray = direction / length
    return unit


def transform_samples(
    samples: Sequence[DeviceSample], image: NDArray[np.float64]
) -> list[DeviceSample]:
    """Transform samples of a hand to one of its images, in the frame of an object at rest.

    A mirrored brush is a brush again: its handle and bend are mirrored, and its third axis follows
    from them.

    Parameters
    ----------
    samples : sequence of DeviceSample
    image : (4, 4) float64
        One of `Symmetry.images`.
    """
    path = object_poses(samples)
    turn = image[:3, :3]
    frames = turn @ matrices_from_quaternions(path.orientation)
    x, z = frames[:, :, 0], frames[:, :, 2]
    orientation = quaternions_from_matrices(np.stack([x, cross(z, x), z], axis=-1))
    position = path.position @ turn.T + image[:3, 3]
    contact = None if path.contact is None else path.contact @ turn.T + image[:3, 3]
    return [
        DeviceSample(s.time_ns, position[i], orientation[i], s.pressure, s.buttons, np.zeros(3),
                     _REST, None if s.contact is None or contact is None else contact[i])
        for i, s in enumerate(samples)
    ]  # fmt: skip
