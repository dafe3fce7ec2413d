"""The hot loops, compiled by numba and kept for the next start."""

from paint3d.core.compile_cache import drop_stale

drop_stale()
