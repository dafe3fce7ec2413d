"""What tests of the compiled kernels need: that they were compiled, all, from what is here."""

from __future__ import annotations

import shutil
import sys

import pytest

from paint3d.core.kernel_library import library

__all__ = ["needs_library"]

_CAN_BE = sys.platform == "linux" and shutil.which("gcc") is not None
needs_library = pytest.mark.skipif(
    library() is None and not _CAN_BE, reason="kernels are compiled ahead with gcc on Linux"
)
