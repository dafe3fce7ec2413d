"""Compile the kernels ahead of time, into a shared library beside the package: no user waits.

`python -m tools.kernels` needs numba and gcc. What it makes needs neither: `paint3d.core.kernel`
takes a kernel from the library where all sources that it was made from are unchanged, and from
numba where not.
"""
