"""What holds for the tests of files."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True, scope="module")
def lit_by_few(few_lights: None) -> None:
    """Light what is painted by few lights: how it is lit is tested in tests/view."""
