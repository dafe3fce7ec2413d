"""Names for types that many rooms use."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

__all__ = ["AnyArray"]

AnyArray = NDArray[Any]
"""An array whose elements may be of several types, or are said in the documentation alone."""
