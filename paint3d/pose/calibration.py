"""Calibration of a device's frame: world_from_device, fitted to points that the user touched.

The rotation, shift and (optionally) scale that map the device's points onto the known ones with
least squares follow in closed form (Umeyama 1991, Eqs. 40-42).
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.core.atomic import write_atomically
from paint3d.core.quaternion import multiply, quaternions_from_matrices, rotate, turn
from paint3d.errors import DeviceError, ExportError

__all__ = ["DeviceCalibration", "fit_calibration", "load_calibration", "save_calibration"]

_FORMAT = "paint3d-calibration"
_FARTHEST_MM = 1e6
_SCALES = (0.01, 100.0)
_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


@dataclass(frozen=True, eq=False)
class DeviceCalibration:
    """world_from_device: ``world = scale * rotate(rotation, device) + shift``.

    Parameters
    ----------
    rotation : (4,) array_like
        Unit quaternion, w first.
    shift : (3,) array_like
        mm.
    scale : float
        World mm per device mm, 0.01 to 100.
    residual_mm : float
        Root mean square residual of the fit.

    Raises
    ------
    DeviceError
        If a value is not finite or out of range, or the quaternion is not of unit length.
    """

    rotation: NDArray[np.float64] = (1.0, 0.0, 0.0, 0.0)  # type: ignore[assignment]
    shift: NDArray[np.float64] = (0.0, 0.0, 0.0)  # type: ignore[assignment]
    scale: float = 1.0
    residual_mm: float = 0.0

    def __post_init__(self) -> None:
        rotation = as_array(self.rotation, "rotation", (4,), error=DeviceError).copy()
        length = math.hypot(*rotation)
        if abs(length - 1.0) > 1e-3:
            raise DeviceError(
                "rotation has length {length:.6g}; expected 1 within 0.001",
                length=length,
            )
        object.__setattr__(self, "rotation", rotation / length)
        shift = as_array(self.shift, "shift", (3,), error=DeviceError)
        for along, mm in zip("xyz", shift, strict=True):
            as_number(mm, f"shift in {along}", -_FARTHEST_MM, _FARTHEST_MM, DeviceError)
        object.__setattr__(self, "shift", shift.copy())
        as_number(self.scale, "scale", *_SCALES, DeviceError)
        as_number(self.residual_mm, "residual_mm", 0.0, _FARTHEST_MM, DeviceError)

    def to_world(self, points: AnyArray) -> AnyArray:
        """Transform points (..., 3), mm, from the device's frame to the world's."""
        return self.scale * rotate(self.rotation, points) + self.shift

    def to_device(self, points: AnyArray) -> AnyArray:
        """Transform points (..., 3), mm, from the world's frame to the device's."""
        return rotate(self.rotation * _CONJUGATE, (points - self.shift) / self.scale)

    def pose_to_world(self, point: AnyArray, orientation: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Transform one point (3,) and one orientation (4,) to the world's frame."""
        q = tuple(self.rotation.tolist())
        turned = np.array(multiply(q, tuple(orientation.tolist())))
        return self.scale * np.array(turn(q, tuple(point.tolist()))) + self.shift, turned

    def as_dict(self) -> dict[str, Any]:
        """Return all values, ready for JSON."""
        return {
            "format": _FORMAT,
            "rotation": self.rotation.tolist(),
            "shift": self.shift.tolist(),
            "scale": self.scale,
            "residual_mm": self.residual_mm,
        }


def fit_calibration(
    device_points: ArrayLike, world_points: ArrayLike, *, scaled: bool = False
) -> DeviceCalibration:
    """Fit a calibration that maps device points onto world points, by least squares.

    Parameters
    ----------
    device_points, world_points : (N, 3) array_like
        The same N >= 3 points in both frames, mm; not all on one line.
    scaled : bool
        Whether the device may be larger or smaller than the world.

    Raises
    ------
    DeviceError
        If there are too few points, or they lie on a line.
    """
    device = as_array(device_points, "device_points", (None, 3), error=DeviceError)
    world = as_array(world_points, "world_points", (None, 3), error=DeviceError)
    if len(device) != len(world) or len(device) < 3:
        raise DeviceError(
            "{n} and {world} points; expected as many, at least 3",
            n=len(device),
            world=len(world),
        )
    d, w = device - device.mean(axis=0), world - world.mean(axis=0)
    u, spread, vt = np.linalg.svd(w.T @ d / len(d))
    if spread[1] < 1e-6 * max(spread[0], 1e-12):
        raise DeviceError("the points lie on one line; expected a triangle at the least")
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    rotation = u * signs @ vt
    scale = float((spread * signs).sum() / (d**2).sum() * len(d)) if scaled else 1.0
    shift = world.mean(axis=0) - scale * rotation @ device.mean(axis=0)
    errors = world - (scale * device @ rotation.T + shift)
    residual = float(np.sqrt((errors**2).sum(axis=1).mean()))
    return DeviceCalibration(quaternions_from_matrices(rotation[None])[0], shift, scale, residual)


def load_calibration(path: str | os.PathLike[str]) -> DeviceCalibration:
    """Read a calibration.

    Raises
    ------
    DeviceError
        If the file cannot be read or is not a calibration.
    """
    try:
        stored = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as cause:
        raise DeviceError(
            "{file}: no calibration can be read ({cause})", file=path, cause=cause
        ) from None
    if not isinstance(stored, Mapping) or stored.get("format") != _FORMAT:
        raise DeviceError(
            "{file}: expected a JSON object with format {expected!r}",
            file=path,
            expected=_FORMAT,
        )
    try:
        return DeviceCalibration(
            stored["rotation"], stored["shift"], stored["scale"], stored.get("residual_mm", 0.0)
        )
    except (KeyError, TypeError) as cause:
        raise DeviceError("{file}: no {cause} in the calibration", file=path, cause=cause) from None
    except DeviceError as cause:
        raise DeviceError("{file}: {cause}", file=path, cause=cause) from None


def save_calibration(calibration: DeviceCalibration, path: str | os.PathLike[str]) -> None:
    """Write a calibration as JSON, atomically.

    Raises
    ------
    DeviceError
        If the file cannot be written.
    """
    try:
        with write_atomically(path) as part:
            part.write_text(json.dumps(calibration.as_dict(), indent=2) + "\n", encoding="utf-8")
    except ExportError as cause:
        raise DeviceError(cause) from None
