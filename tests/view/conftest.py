"""What holds for the tests of pictures."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

import numpy as np
import pytest

from paint3d.core.arrays import AnyArray
from paint3d.view import picture
from paint3d.view.daylight import Occluder
from tests.support.less_work import by_few_lights

_KEPT = 2  # of 40 MB each


@pytest.fixture(autouse=True, scope="module")
def looked_at_once() -> Iterator[None]:
    """Keep what lights see of the last objects: the same one stands in many pictures.

    An object keeps by itself what each light sees of it; here it is known again by its bytes.
    """
    kept: dict[bytes, Occluder] = {}

    def known(vertices: AnyArray, faces: AnyArray) -> Occluder:
        said = hashlib.blake2b()
        for part in (vertices, faces):
            said.update(f"{part.dtype} {part.shape}".encode())
            said.update(np.ascontiguousarray(part).data)
        found = kept.pop(said.digest(), None)
        kept[said.digest()] = Occluder(vertices, faces) if found is None else found
        while len(kept) > _KEPT:
            del kept[next(iter(kept))]
        return kept[said.digest()]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(picture, "Occluder", known)
        yield


@pytest.fixture
def lit_by_few() -> Iterator[None]:
    """Light by every eighth of the lights, for tests that compare pictures lit alike."""
    with by_few_lights():
        yield
