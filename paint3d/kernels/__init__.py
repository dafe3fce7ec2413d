"""The hot loops, compiled by numba and kept for the next start."""

from pathlib import Path

from paint3d.kernels.kept_code import compiled_code, drop_stale

drop_stale(Path(__file__).parent, compiled_code())
