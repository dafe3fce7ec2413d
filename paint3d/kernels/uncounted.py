"""Compiling kernels that many arrays are handed to, without counting who holds them.

numba counts references to every array of every named tuple that a kernel is handed, up at its
beginning and down at its end, with a locked instruction each. Painting calls a dozen kernels for a
footprint, and the surface and the room for work are a hundred arrays: some three thousand such
instructions, a quarter of the time. Whoever calls holds the arrays anyway.

A kernel compiled so may make no arrays (nor assign one to a slice of another, which may raise an
error with a text), and return none: give such a one, and one that is called by such a kernel and
does, `counted`. Both take what `njit` takes.
"""

from __future__ import annotations

from functools import partial

from numba import njit

__all__ = ["counted", "uncounted"]

uncounted = partial(njit, cache=True, nogil=True, _nrt=False)
counted = partial(njit, cache=True, nogil=True, _nrt=True)
