"""Where a brush meets a surface: the contact of one pose, for looking at, drawing and checking.

Painting itself runs this for every footprint inside `paint3d.brush_engine.stroke_loop`; here is the
same kernel for one pose, with its result by name.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.brush_engine.footprint import make_stamp
from paint3d.brush_engine.placement import REACH, place_stamp
from paint3d.brush_engine.scratch import Scratch, make_scratch
from paint3d.brush_engine.tuft import Tuft
from paint3d.core.arrays import as_array, as_number
from paint3d.errors import InputError
from paint3d.mesh.kernels.bvh import ContactTree
from paint3d.mesh.refined_mesh import PaintMesh

__all__ = ["Contact", "find_contact"]

_KEPT = threading.local()  # the scratch of each thread: a stylus asks for 1000 contacts a second


@dataclass(frozen=True, eq=False)
class Contact:
    """Contact of a bent brush with a surface (object frame, mm, rad).

    Attributes
    ----------
    foot : (3,) float64
        P'_m, the surface point whose normal passes through the tuft's root; or the place that the
        hand means.
    origin : (3,) float64
        Where the outline is counted from, in the plane.
    normal : (3,) float64
        Of the plane: the mean over the patch of surface within the sphere (Guo 2017, Fig. 7).
    bend : (3,) float64
        Unit direction in the plane from the root's foot to the tip.
    sphere_centre, sphere_radius : (3,) float64, float
        Smallest enclosing sphere of the bent brush (Guo 2017, Eqs. 10, 11).
    descent, tilt, pressure : float
        D_s (mm), theta (rad), and pe of Eq. 2.
    length, width, area : float
        Of the footprint in the plane; 0 where nothing touches.
    """

    foot: NDArray
    origin: NDArray
    normal: NDArray
    bend: NDArray
    sphere_centre: NDArray
    sphere_radius: float
    descent: float
    tilt: float
    pressure: float
    length: float
    width: float
    area: float


def find_contact(
    tuft: Tuft,
    mesh: PaintMesh,
    tree: ContactTree,
    position: ArrayLike,
    orientation: ArrayLike,
    pressure: float | None = None,
    place: ArrayLike | None = None,
) -> Contact | None:
    """The contact of one pose, or None where no surface that faces the brush is within reach.

    Who presses touches the surface under the root, however far it is.

    Parameters
    ----------
    tuft : Tuft
        From `paint3d.brush.bending.build_tuft`.
    mesh : PaintMesh
    tree : ContactTree
        From `paint3d.mesh.bvh.build_contact_tree`.
    position : (3,)
        The tuft's root P_m, mm.
    orientation : (4,)
        Unit quaternion, w first: z runs up the handle, x is the commanded bend.
    pressure : float in [0, 1], optional
        Force over the greatest force; None: the descent follows from the position.
    place : (3,), optional
        The place on the surface that the hand means, mm, in the middle of the footprint; only with
        a pressure.

    Raises
    ------
    InputError
        If the pose is not finite, the quaternion not of unit length, the pressure out of range, or
        a place is given without it.
    """
    pose = _pose(position, orientation, pressure, place)
    stamp, scratch = make_stamp(), _scratch(mesh)
    place_stamp(pose, False, stamp, stamp, tuft, tree, mesh.arrays, scratch)
    v = stamp.values[0]
    if v["triangle"] < 0:
        return None
    touches = v["touches"] > 0.0
    far = np.linalg.norm(pose[:3] - v["foot"]) > REACH * tuft.length
    if far and not touches:
        return None
    return Contact(
        foot=v["foot"].copy(),
        origin=v["origin"].copy(),
        normal=v["normal"].copy(),
        bend=v["bend"].copy(),
        sphere_centre=v["sphere_centre"].copy(),
        sphere_radius=float(v["radius"]),
        descent=float(v["descent"]),
        tilt=float(v["tilt"]),
        pressure=float(v["pressure"]),
        length=float(v["tip"] - v["heel"]) if touches else 0.0,
        width=float(2.0 * v["widest"]) if touches else 0.0,
        area=float(v["area"]) if touches else 0.0,
    )


def _scratch(mesh: PaintMesh) -> Scratch:
    """This thread's scratch as if it were new; a stamp needs of the mesh how many sheets it has."""
    kept: Scratch | None = getattr(_KEPT, "scratch", None)
    if kept is None or len(kept.patch.sheets) != mesh.n_sheets:
        kept = _KEPT.scratch = make_scratch(mesh, 0)
    kept.warm.fill(0.0)
    return kept


def _pose(
    position: ArrayLike, orientation: ArrayLike, pressure: float | None, place: ArrayLike | None
) -> NDArray:
    """The pose (9,) of `place_stamp`; errors as in `find_contact`."""
    pose = np.zeros(9)
    pose[:3] = as_array(position, "position", (3,))
    if place is not None:
        if pressure is None:
            raise InputError("a place is given without a pressure; expected both")
        pose[:3], pose[8] = as_array(place, "place", (3,)), 1.0
    pose[3:7] = as_array(orientation, "orientation", (4,))
    if abs(np.linalg.norm(pose[3:7]) - 1.0) > 1e-3:
        raise InputError(
            "orientation has length {pose:g}; expected 1",
            pose=np.linalg.norm(pose[3:7]),
        )
    pose[7] = np.nan if pressure is None else as_number(pressure, "pressure", 0.0, 1.0)
    return pose
