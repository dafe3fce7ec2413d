"""The hot loops, compiled by numba and kept for the next start."""

from pathlib import Path

from paint3d.kernels.kept_code import compiled_code, drop_stale

_TUPLES_ELSEWHERE = ("colour/glazing.py", "projection/room.py", "surface/painted_surface.py")

_here = Path(__file__).parent
drop_stale(_here, compiled_code(), [_here.parent / name for name in _TUPLES_ELSEWHERE])
