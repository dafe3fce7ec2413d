"""Which examples the property tests try: the same ones every time, or new ones and more of them."""

from __future__ import annotations

import os

from hypothesis import settings

_MORE = "PAINT3D_MORE_EXAMPLES"  # set by scripts/check --long

settings.register_profile("same", derandomize=True)
settings.register_profile("new", print_blob=True)
settings.load_profile("new" if os.environ.get(_MORE) else "same")
