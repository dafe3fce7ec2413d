"""What the force servo works with: its settings, its state, and the flags of a step.

Both are arrays of one record of float64, so that a process can keep them in shared memory.
Quaternions have w first. "Object" means the painted object's frame.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

PATCH_SAMPLES = 6  # places around the foot at which the normal is averaged

_VECTOR = ("f8", (3,))

SETTINGS = np.dtype(  # see paint3d.haptics.settings
    [
        ("length", "f8"),  # mm
        ("spring", "f8"),  # N/mm
        ("friction", "f8"),
        ("lowest_sine", "f8"),
        ("device_limit", "f8"),  # N
        ("user_limit", "f8"),  # N
        ("stiffest", "f8"),  # N/mm
        ("stick", "f8"),  # N/mm
        ("ramp_s", "f8"),
        ("slew", "f8"),  # N/s
        ("max_pose_age_s", "f8"),
        ("max_snapshot_age_s", "f8"),
        ("start_force", "f8"),  # N
        ("rise_s", "f8"),
        ("follow_s", "f8"),
        ("patch", "f8"),  # mm
        ("ahead", "f8"),  # mm before the surface from which it is felt
        ("ahead_n", "f8"),  # N at contact
        ("click_n", "f8"),  # N
        ("clicks", "f8"),  # how many were asked for
    ]
)
N_SETTINGS = len(SETTINGS)

STATE = np.dtype(
    [
        ("force", *_VECTOR),  # last output, world, N
        ("proxy", *_VECTOR),  # where friction holds the foot, object, mm
        ("last", *_VECTOR),  # last root, object, mm
        ("last_force", *_VECTOR),  # last output, object, N
        ("object_place", *_VECTOR),  # the object's pose as the servo follows it, mm
        ("object_turn", "f8", (4,)),
        ("warm", "f8", (5,)),  # 1 where there is a last foot; its triangle; its root (3)
        ("touching", "f8"),  # 1 or 0
        ("contact_s", "f8"),
        ("energy", "f8"),  # N mm
        ("stored", "f8"),  # N mm
        ("started", "f8"),  # 1 or 0
        ("risen_s", "f8"),
        ("has_object", "f8"),  # 1 or 0
        ("has_last", "f8"),  # 1 or 0
        ("descent", "f8"),  # mm
        ("normal", *_VECTOR),  # averaged, object
        ("foot", *_VECTOR),  # object, mm
        ("foot_normal", *_VECTOR),  # the foot's own, object
        ("slewed", *_VECTOR),  # last force after the slew limit, object, N
        ("softening", "f8"),  # share of the stiffness that the servo's steadiness allows
        ("spent", "f8"),  # tree nodes of the last step
        ("wanted", "f8"),  # size of the force before anything was made safe, N
        ("credit", "f8"),  # N mm that turning or curvature put into the spring since the last step
        ("clicks_heard", "f8"),
        ("click_s", "f8"),  # what is left of a click
        ("near", "f8", (PATCH_SAMPLES,)),  # every sample's triangle of the last patch, plus 1
    ]
)


class Moment(NamedTuple):
    """When a step is made."""

    dt: float  # s since the last one
    pose_age: float  # s
    snapshot_age: float  # s
    stopping: bool


# -- flags of a step --------------------------------------------------------------------------
NOT_FINITE, CLAMPED, SLEWED, TAMED = 1, 2, 4, 8
STALE_POSE, STALE_SNAPSHOT, WAITING, BUDGET_SPENT = 16, 32, 64, 128
STOPPING = 256
