"""Systems of equations whose matrix has three diagonals."""

from __future__ import annotations

from paint3d.core.kernel import kernel

__all__ = ["solve_tridiagonal"]


@kernel
def solve_tridiagonal(lower, diagonal, upper, right):  # type: ignore[no-untyped-def]
    """Solve for several right hand sides by elimination, exchanging rows where the pivot is small.

    In LAPACK's order (dgtsv), so that the last bits are those of SciPy's `solve_banded`.

    Parameters
    ----------
    lower, upper : (N - 1,) float64
        The diagonals beside the middle one; used up.
    diagonal : (N,) float64
        Used up. No pivot may be zero.
    right : (N, K) float64
        Right hand sides; the solutions afterwards.
    """
    n, columns = right.shape
    for i in range(n - 1):
        if abs(diagonal[i]) >= abs(lower[i]):
            share = lower[i] / diagonal[i]
            diagonal[i + 1] -= share * upper[i]
            for k in range(columns):
                right[i + 1, k] -= share * right[i, k]
            lower[i] = 0.0
        else:
            share = diagonal[i] / lower[i]
            diagonal[i], upper[i], diagonal[i + 1] = (
                lower[i],
                diagonal[i + 1],
                upper[i] - share * diagonal[i + 1],
            )
            lower[i] = 0.0  # from here on: what a row has two places to the right
            if i < n - 2:
                lower[i] = upper[i + 1]
                upper[i + 1] = -share * lower[i]
            for k in range(columns):
                above, below = right[i, k], right[i + 1, k]
                right[i, k], right[i + 1, k] = below, above - share * below
    for i in range(n - 1, -1, -1):
        for k in range(columns):
            value = right[i, k]
            if i < n - 1:
                value -= upper[i] * right[i + 1, k]
            if i < n - 2:
                value -= lower[i] * right[i + 2, k]
            right[i, k] = value / diagonal[i]
