"""The force on the hand as a pure step in simulated time: what the servo runs a thousand times a
second."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import as_array
from paint3d.errors import DeviceError
from paint3d.haptics.kernels import state as hs
from paint3d.haptics.kernels.step import servo_step
from paint3d.haptics.servo_process import new_state
from paint3d.haptics.settings import HapticSettings
from paint3d.mesh.kernels.bvh import ContactTree

__all__ = ["ForceModel", "ForceStep", "flag_names"]

FLAGS = {
    "not finite": hs.NOT_FINITE,
    "clamped": hs.CLAMPED,
    "slew limited": hs.SLEWED,
    "energy limited": hs.TAMED,
    "pose too old": hs.STALE_POSE,
    "surface too old": hs.STALE_SNAPSHOT,
    "waiting to be lifted": hs.WAITING,
    "search cut short": hs.BUDGET_SPENT,
    "stopping": hs.STOPPING,
}
"""What a step may have done to the force."""

_AT_ORIGIN = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True, eq=False, slots=True)
class ForceStep:
    """Outcome of one step.

    Attributes
    ----------
    force : (3,) float64
        On the hand, in the world, N.
    flags : int
        See `FLAGS`.
    wanted : float
        Size of the force before anything was made safe, N.
    descent : float
        D_s, mm; 0 off the surface.
    proxy : (3,) float64
        Where friction holds the brush, in the object's frame, mm.
    """

    force: NDArray[np.float64]
    flags: int
    wanted: float
    descent: float
    proxy: NDArray[np.float64]


def flag_names(flags: int) -> list[str]:
    """The names of the flags that are set."""
    return [name for name, bit in FLAGS.items() if flags & bit]


class ForceModel:
    """Force feedback on one surface, step by step, without any clock.

    Parameters
    ----------
    tree : ContactTree
        Of the surface (`PaintedSurface.contact_tree`).
    settings : HapticSettings
    awake : bool
        Skip the start (waiting to be lifted, slow rise).
    """

    def __init__(self, tree: ContactTree, settings: HapticSettings, awake: bool = False) -> None:
        self.tree = tree
        self.settings = settings
        self._settings = settings.as_record()
        self.state = new_state()
        self._out = np.zeros(3)
        self.clicks = 0
        if awake:
            self.state["started"] = 1.0
            self.state["risen_s"] = settings.rise_s

    def step(
        self,
        position: ArrayLike,
        orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        dt: float = 0.001,
        *,
        object_pose: ArrayLike = _AT_ORIGIN,
        pose_age: float = 0.0,
        snapshot_age: float = 0.0,
        stopping: bool = False,
    ) -> ForceStep:
        """The force at the next instant.

        Parameters
        ----------
        position, orientation : (3,) and (4,) array_like
            world_from_pen: the tuft's root, mm, and unit quaternion, w first. Values that are not
            finite are what a fault looks like: they give no force.
        dt : float
            Since the last step, s.
        object_pose : (7,) array_like
            world_from_object.
        pose_age, snapshot_age : float
            s.
        stopping : bool

        Raises
        ------
        DeviceError
            If a shape is wrong.
        """
        self._settings["clicks"] = self.clicks
        pose = np.concatenate([np.ravel(position), np.ravel(orientation)]).astype(np.float64)
        if pose.shape != (7,):
            raise DeviceError(f"the pose has {pose.size} numbers; expected 3 and 4")
        target = as_array(object_pose, "object_pose", (7,), error=DeviceError)
        moment = hs.Moment(dt, pose_age, snapshot_age, stopping)
        flags = servo_step(self.tree, self._settings, self.state, target, pose, moment, self._out)
        state = self.state[0]
        return ForceStep(
            self._out.copy(),
            int(flags),
            float(state["wanted"]),
            float(state["descent"]),
            state["proxy"].copy(),
        )
