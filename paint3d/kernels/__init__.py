"""The hot loops: compiled by numba when they are first called, and kept for the next start."""
