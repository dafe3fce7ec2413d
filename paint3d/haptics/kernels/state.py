"""Places in the flat arrays of the force servo, and the flags of a step.

State and settings are flat float64 arrays, so that a process can keep them in shared memory.
Vectors take three places, quaternions (w first) four. "Object" means the painted object's frame.
"""

from __future__ import annotations

PATCH_SAMPLES = 6  # places around the foot at which the normal is averaged

# -- settings: see paint3d.haptics.settings ----------------------------------------------------
LENGTH, SPRING, FRICTION, LOWEST_SINE = 0, 1, 2, 3  # mm, N/mm, 1, 1
DEVICE_LIMIT, USER_LIMIT, STIFFEST, STICK = 4, 5, 6, 7  # N, N, N/mm, N/mm
RAMP_S, SLEW, MAX_POSE_AGE_S, MAX_SNAPSHOT_AGE_S = 8, 9, 10, 11  # s, N/s, s, s
START_FORCE, RISE_S, FOLLOW_S, PATCH = 12, 13, 14, 15  # N, s, s, mm
N_SETTINGS = 16

# -- state ------------------------------------------------------------------------------------
FORCE_X = 0  # last output, world, N
PROXY_X = 3  # where friction holds the foot, object, mm
LAST_X = 6  # last root, object, mm
LAST_FORCE_X = 9  # last output, object, N
OBJECT_X, OBJECT_W = 12, 15  # the object's pose as the servo follows it
WARM = 19  # 1 where there is a last foot; its triangle; its root (3)
TOUCHING, CONTACT_S, ENERGY, STORED = 24, 25, 26, 27  # flag, s, N mm, N mm
STARTED, RISEN_S, HAS_OBJECT, HAS_LAST = 28, 29, 30, 31
DESCENT, NORMAL_X, FOOT_X = 32, 33, 36  # mm; averaged, object; object, mm
FOOT_NORMAL_X = 39  # the foot's own, object
SLEWED_X = 42  # last force after the slew limit, object, N
SOFTENING = 45  # share of the stiffness that the servo's steadiness allows
SPENT = 46  # tree nodes of the last step
WANTED = 47  # size of the force before anything was made safe, N
CREDIT = 48  # N mm that turning or curvature put into the spring since the last step
NEAR = 49  # of every sample of the patch the triangle that it found last, plus 1
N_STATE = NEAR + PATCH_SAMPLES

# -- flags of a step --------------------------------------------------------------------------
NOT_FINITE, CLAMPED, SLEWED, TAMED = 1, 2, 4, 8
STALE_POSE, STALE_SNAPSHOT, WAITING, BUDGET_SPENT = 16, 32, 64, 128
STOPPING = 256
