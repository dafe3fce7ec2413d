"""Pictures from named sides, flat ones, on nothing, in other light, and of objects that turn."""

from __future__ import annotations

import signal

import numpy as np
import pytest

from paint3d.errors import InputError, UnknownNameError
from paint3d.view.scene import quiet_vtk
from paint3d.view.shot import VIEWS, Shot, take_shot, take_turning
from tests.support.view_shapes import BARE, INK, ball, sheet
from tests.view.test_view_picture import needs_opengl

SIZE = (64, 48)
SIDES = {  # the colour of a ball around each of its axes
    "right": (200, 20, 20), "left": (20, 200, 20), "back": (20, 20, 200),
    "front": (200, 200, 20), "top": (20, 200, 200), "bottom": (200, 20, 200),
}  # fmt: skip
AXES = {"right": 0, "left": 0, "back": 1, "front": 1, "top": 2, "bottom": 2}


def six_sided():
    """A ball that tells from which side it is seen."""
    vertices, faces, normals = ball()
    srgb = np.zeros((len(vertices), 3), np.uint8)
    nearest = np.abs(normals).argmax(axis=1)
    for side, colour in SIDES.items():
        sign = 1.0 if side in ("right", "back", "top") else -1.0
        srgb[(nearest == AXES[side]) & (normals[:, AXES[side]] * sign > 0.0)] = colour
    return vertices, faces, normals, srgb


def drawn_sheet(width: float, height: float):
    """A sheet, red in its lower left quarter and blue along its upper border."""
    vertices, faces, normals = sheet(width, height)
    srgb = np.full((len(vertices), 3), 255, np.uint8)
    srgb[(vertices[:, 0] < 0.5 * width - 1) & (vertices[:, 1] < 0.5 * height - 1)] = (200, 20, 20)
    srgb[vertices[:, 1] > 0.9 * height] = (20, 20, 200)
    return vertices, faces, normals, srgb


@needs_opengl
@pytest.mark.parametrize("side", SIDES)
def test_a_side_is_seen_from_there(side: str) -> None:
    pixels = take_shot(six_sided(), Shot(side, SIZE, light="none"))
    assert pixels.shape == (48, 64, 3)
    assert tuple(pixels[24, 32]) == SIDES[side]  # without light: the code that was painted
    assert tuple(pixels[0, 0]) == (255, 255, 255)


def test_an_interrupt_waits_until_vtk_is_done() -> None:
    """One that came while a module of VTK was loaded made it crash."""
    done: list[bool] = []

    def draw() -> None:
        with quiet_vtk():
            signal.raise_signal(signal.SIGINT)
            done.append(True)

    before = signal.signal(
        signal.SIGINT, signal.default_int_handler
    )  # behind a shell it is ignored
    try:
        with pytest.raises(KeyboardInterrupt):
            draw()
    finally:
        signal.signal(signal.SIGINT, before)
    assert done


@needs_opengl
def test_right_and_left_are_where_they_are_from_in_front() -> None:
    pixels = take_shot(six_sided(), Shot((0.0, 0.0), SIZE, light="none")).astype(int)
    red, green = ((pixels == SIDES[side]).all(axis=2).nonzero()[1] for side in ("right", "left"))
    assert red.min() > 32 > green.max()
    turned = take_shot(six_sided(), Shot((90.0, 0.0), SIZE, light="none"))
    assert tuple(turned[24, 32]) == SIDES["right"]


@needs_opengl
def test_a_flat_picture_is_the_sheet_from_border_to_border() -> None:
    pixels = take_shot(drawn_sheet(80.0, 40.0), Shot("flat"))
    assert pixels.shape == (800, 1600, 3)
    assert tuple(pixels[600, 400]) == (200, 20, 20)
    assert tuple(pixels[600, 1200]) == (255, 255, 255)
    assert tuple(pixels[4, 800]) == (20, 20, 200)
    shaped = take_shot(drawn_sheet(80.0, 40.0), Shot("flat", (40, 40), transparent=True))
    assert shaped.shape == (40, 40, 4)
    assert (shaped[:9, :, 3] == 0).all()  # what is wanted wider than the sheet is empty
    assert (shaped[12:28, :, 3] == 255).all()


@needs_opengl
@pytest.mark.usefixtures("lit_by_few")
@pytest.mark.parametrize("light", ["studio", "none"])
def test_on_nothing_there_is_the_object_and_its_edge(light: str) -> None:
    vertices, faces, normals = ball()
    srgb = np.tile(BARE, (len(vertices), 1))
    pixels = take_shot(
        (vertices, faces, normals, srgb), Shot("front", (96, 72), light, transparent=True)
    )
    seen = pixels[..., 3].astype(int)
    assert seen[36, 48] == 255
    assert seen[0, 0] == seen[71, 95] == seen[0, 95] == 0
    partly = (seen > 0) & (seen < 255)
    assert 20 < partly.sum() < 400  # a rim of one pixel
    assert pixels[partly][:, :3].min() > 60  # of the object's colour, not of something dark behind


@needs_opengl
def test_light_from_another_side_is_other_light() -> None:
    vertices, faces, normals = ball()
    arrays = vertices, faces, normals, np.tile(BARE, (len(vertices), 1))
    shots = {
        name: take_shot(arrays, Shot("front", (96, 72), name)).astype(int)
        for name in ("raking", "soft")
    }
    left, right = (shots["raking"][30:42, x].mean() for x in (slice(26, 36), slice(60, 70)))
    assert left > 1.5 * right
    left, right = (shots["soft"][30:42, x].mean() for x in (slice(26, 36), slice(60, 70)))
    assert left == pytest.approx(right, rel=0.03)
    assert shots["soft"][22:26, 44:52].mean() > shots["soft"][46:50, 44:52].mean()  # from above


@needs_opengl
def test_an_object_turns_once_and_keeps_its_size() -> None:
    shot = Shot("front", SIZE, light="none", transparent=True)
    pictures = list(take_turning(six_sided(), shot, 4))
    assert [tuple(p[24, 32][:3]) for p in pictures] == [
        SIDES[side] for side in ("front", "right", "back", "left")
    ]
    covered = [(p[..., 3] > 127).sum() for p in pictures]
    assert max(covered) == min(covered)


@needs_opengl
@pytest.mark.usefixtures("lit_by_few")
@pytest.mark.parametrize("light", ["none", "soft"])
def test_a_long_object_is_not_cut_off_as_it_turns(light) -> None:
    """Its ends come nearer and go farther than all of it was in the first picture."""
    vertices, faces, normals = ball()
    stretched = (vertices * [9.0, 1.0, 1.0]).astype(np.float32)
    grey = np.full((len(vertices), 3), 120, np.uint8)
    shot = Shot("front", SIZE, light=light, transparent=True)
    pictures = take_turning((stretched, faces, normals, grey), shot, 8)
    widths = [np.flatnonzero((p[..., 3] > 0).any(axis=0)) for p in pictures]
    wide = [int(columns[-1] - columns[0]) for columns in widths]
    assert min(wide[1], wide[3], wide[5], wide[7]) > 0.6 * wide[0]
    assert max(wide[2], wide[6]) < 0.4 * wide[0]


@pytest.mark.long
@needs_opengl
def test_a_lit_object_turns_under_one_light() -> None:
    vertices, faces, normals = ball()
    half = np.where(normals[:, :1] > 0.0, BARE, INK).astype(np.uint8)
    pictures = list(
        take_turning((vertices, faces, normals, half), Shot((90.0, 15.0), SIZE, "raking"), 2)
    )
    bright, dark = (float(p[18:30, 24:40].mean()) for p in pictures)
    assert bright > 3.0 * dark
    floor = [p[40:, :8].astype(int) for p in pictures]
    assert np.abs(floor[0] - floor[1]).max() <= 3


def test_what_cannot_be_taken_is_named() -> None:
    with pytest.raises(UnknownNameError, match="unknown view 'frnt': did you mean 'front'"):
        Shot("frnt")
    with pytest.raises(UnknownNameError, match="unknown light 'moon'"):
        Shot(light="moon")
    with pytest.raises(InputError, match="height of the view"):
        Shot((0.0, 120.0))
    with pytest.raises(InputError, match="zoom is 0"):
        Shot(zoom=0.0)
    with pytest.raises(InputError, match="size is"):
        Shot(size=(5, 5))
    with pytest.raises(InputError, match="seen from the side; expected another view"):
        next(take_turning(drawn_sheet(20.0, 20.0), Shot("top", SIZE), 3))


@needs_opengl
def test_a_lying_sheet_turns_as_seen_from_the_side() -> None:
    picture = next(take_turning(drawn_sheet(40.0, 40.0), Shot(size=SIZE, light="none"), 3))
    assert (picture == (20, 20, 200)).all(axis=2).any()
    assert set(VIEWS) >= {"above"}
