"""Dragging a tuft along a whole track on the plane, and the handle's track that undoes the drag."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from paint3d.brush_engine.drag import drag_along
from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.errors import BrushError

__all__ = ["drag_track", "handle_track"]


def drag_track(handle: ArrayLike, slack: ArrayLike, start: ArrayLike = (0.0, 0.0)) -> AnyArray:
    """Track of the dragged contact Q under a track of the handle's foot H.

    Parameters
    ----------
    handle : (N, 2) array_like
        H, mm; the way between two is straight, and the slack on it linear.
    slack : float or (N,) array_like
        l at every sample, mm, more than 0.
    start : (2,) array_like
        Q - H at the first sample, mm, no longer than the slack there.

    Returns
    -------
    contact : (N, 2) float64
        Q, mm.

    Raises
    ------
    BrushError
        If an input has the wrong shape, is not finite, or breaks a limit above.
    """
    points = as_array(handle, "handle", (None, 2), error=BrushError)
    if len(points) == 0:
        raise BrushError("handle has no samples; expected at least 1")
    lengths = _as_slack(slack, len(points))
    first = as_array(start, "start", (2,), error=BrushError)
    distance = math.hypot(first[0], first[1])
    if distance > lengths[0] * (1.0 + 1e-9):
        raise BrushError(
            f"start is {distance:g} mm long; expected at most the slack {lengths[0]:g}"
        )
    contact = np.empty_like(points)
    drag_along(points, lengths, first[0], first[1], contact)
    return contact


def handle_track(contact: ArrayLike, slack: ArrayLike) -> AnyArray:
    """Track of the handle that drags the contact along a wanted track: H = Q + l T.

    The inverse of `drag_track` is exact where the track is smooth; T is the tangent by central
    differences. At a corner the handle turns round the resting contact, which is for the caller
    to plan.

    Parameters
    ----------
    contact : (N, 2) array_like
        Q, mm, N at least 2, neighbours apart.
    slack : float or (N,) array_like
        l at every sample, mm, more than 0.

    Returns
    -------
    handle : (N, 2) float64
        H, mm.

    Raises
    ------
    BrushError
        If an input has the wrong shape or is not finite, or the track stands still.
    """
    points = as_array(contact, "contact", (None, 2), error=BrushError)
    if len(points) < 2:
        raise BrushError(f"contact has {len(points)} samples; expected at least 2")
    lengths = _as_slack(slack, len(points))
    steps = np.hypot(*np.diff(points, axis=0).T)
    if not steps.all():
        raise BrushError(f"contact stands still after sample {int(np.argmin(steps))}")
    arcs = np.concatenate([[0.0], np.cumsum(steps)])
    order: Literal[1, 2] = 2 if len(points) > 2 else 1
    tangents: AnyArray = np.gradient(points, arcs, axis=0, edge_order=order)
    norms = np.hypot(*tangents.T)
    if not (norms > 1e-9).all():
        raise BrushError(f"contact turns straight back at sample {int(np.argmin(norms))}")
    result: AnyArray = points + lengths[:, None] * tangents / norms[:, None]
    return result


def _as_slack(slack: ArrayLike, n: int) -> AnyArray:
    if np.ndim(slack) == 0:
        return np.full(n, as_number(slack, "slack", low=1e-9, error=BrushError))
    lengths = as_array(slack, "slack", (n,), error=BrushError)
    if (lengths <= 0.0).any():
        where = int(np.argmin(lengths))
        raise BrushError(f"slack[{where}] is {lengths[where]:g}; expected more than 0")
    return lengths
