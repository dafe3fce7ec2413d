"""Strokes of photographed sheets, found once for each thing that is asked of one."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

__all__ = ["sheets_found_once"]


@pytest.fixture(scope="module")
def sheets_found_once() -> Iterator[None]:
    """Look for the strokes of one photograph once for each thing that is asked of it.

    Looking takes a second. Nobody can change what was found: it is handed on to who asks next.
    """
    from paint3d.calligraphy.photo import copying

    found: dict[bytes, copying.CopiedSheet] = {}
    look = copying.copy_sheet

    def known(
        pixels: NDArray[np.uint8],
        name: str,
        asked: copying.Asked | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> copying.CopiedSheet:
        key = pickle.dumps((pixels, name, asked))
        if key not in found:
            found[key] = look(pixels, name, asked, progress)
            _hold(found[key])
        return found[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(copying, "copy_sheet", known)
        yield


def _hold(thing: object) -> None:
    """Let nobody write to any array of a record, however deep it lies."""
    if isinstance(thing, np.ndarray):
        thing.setflags(write=False)
    elif isinstance(thing, tuple | list):
        for one in thing:
            _hold(one)
    elif is_dataclass(thing):
        for one in fields(thing):
            _hold(getattr(thing, one.name))
