"""Nothing that is painted changes while the code is moved, renamed or merged."""

from __future__ import annotations

import pytest

from tests.golden.cases import CASES
from tests.golden.hashes import hashes_of, known, machine


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_the_painting_is_what_it_was_to_the_bit(name):
    kept = known().get(machine())
    if kept is None:
        pytest.skip("no hashes of this machine: python -m tests.golden.hashes --record")
    assert hashes_of(name) == kept[name]
