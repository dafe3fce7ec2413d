"""Where paint is refused is seen on the object, and only there."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from paint3d.app.model.mask import AngleMask, Mask
from paint3d.view.camera import picture_axes
from tests.support.app.gestures import drag, live
from tests.support.app.windows import opened, settled


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "sphere", 3.0, "porcelain") as window:
        yield window


def right_half(window) -> Mask:
    """Paint is taken in the right half of the picture."""
    right = picture_axes(window.hand.camera)[0]
    return Mask(AngleMask(tuple(float(x) for x in right), 90.0))


def picture(window) -> np.ndarray:
    settled(window)
    live(0.2)
    window.stage.hide_brush()
    return window.stage.picture(fine=False)[..., :3].astype(int)


def bluer(window, before) -> np.ndarray:
    """(H, W) bool: where the picture was veiled since `before`."""
    change = picture(window) - before
    return (change.sum(axis=2) < -40) & (change[..., 2] > change[..., 0])


def test_a_mask_is_hatched_and_only_while_it_is_there(window) -> None:
    before = picture(window)
    window.workspace.post("set_mask", right_half(window))
    veiled = bluer(window, before)
    height, width = veiled.shape
    left, right = veiled[:, : width // 2].sum(), veiled[:, width // 2 :].sum()
    assert left > 0.1 * height * width
    assert right < 0.02 * left
    row = picture(window)[height // 2, width // 2 - height // 4 : width // 2 - 10].sum(axis=1)
    assert np.abs(np.diff(np.sign(np.diff(np.convolve(row, np.ones(9) / 9, "valid"))))).sum() >= 4
    window.workspace.actions["show_mask"].setChecked(False)
    assert not bluer(window, before).any()
    window.workspace.actions["show_mask"].setChecked(True)
    assert (bluer(window, before) == veiled).mean() > 0.999
    window.workspace.post("set_mask", Mask())
    assert np.abs(picture(window) - before).max() <= 2


def test_a_mask_that_is_gone_is_told(window) -> None:
    window.workspace.actions["mask"].trigger()
    window.workspace.actions["clear_mask"].trigger()
    settled(window)
    assert window.document.mask == Mask()
    assert window.status.told.text() == "Paint is taken everywhere"


def test_a_stroke_over_the_stencil_leaves_the_hatching(window) -> None:
    window.workspace.post("set_mask", right_half(window))
    before = picture(window)
    drag(window.canvas, (0.40, 0.5), (0.60, 0.5))
    change = np.abs(picture(window) - before).sum(axis=2)
    width = change.shape[1]
    assert (change[:, width // 2 + 5 :] > 60).sum() > 200
    assert (change[:, : width // 2 - 12] > 60).sum() < 20
    window.workspace.post("set_mask", Mask())
    window.workspace.post("undo")
    settled(window)
