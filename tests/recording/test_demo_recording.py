import functools
from pathlib import Path

import numpy as np

from paint3d.brush.bending import build_tuft
from paint3d.brush.presets import load_brush
from paint3d.core.quaternion import matrices_from_quaternions
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.pose.brush_pose import brush_poses
from paint3d.recording.recording import load_recording

FILE = Path(__file__).parents[2] / "paint3d/calligraphy/data/demo.jsonl.gz"


@functools.cache
def recording():
    return load_recording(FILE)


@functools.cache
def path():
    return brush_poses(recording())


def strokes():
    down = path().pressure > 0.0
    return np.count_nonzero(down[1:] & ~down[:-1]), down


def test_header_says_what_and_whose():
    header = recording().header
    assert [c["text"] for c in header["characters"]] == list("漫步人生")
    assert "Arphic Public License" in header["licence"]
    assert (FILE.parent / "LICENCE.md").read_text(encoding="utf-8").count("Arphic") >= 3
    assert (header["brush"], header["object"], header["space"]) == ("xiaobaiyun", "bowl", "world")


def test_it_takes_a_hand_s_time_and_little_room():
    assert 40.0 <= recording().duration_s <= 80.0
    assert FILE.stat().st_size < 1_500_000
    assert np.all(np.diff(recording().time_ns) == 4_000_000)


def test_every_stroke_is_written():
    n, down = strokes()
    assert n == 14 + 7 + 2 + 5
    assert not down[0]
    assert not down[-1]


def test_brush_is_dipped_once_a_character_and_only_lifted():
    dipped = recording().buttons == 2
    assert np.count_nonzero(np.diff(np.r_[0, dipped.astype(int)]) == 1) == 4
    assert (path().pressure[dipped] == 0.0).all()


def test_root_stands_over_the_bowl_as_the_pressure_says():
    """Root height is LE - D_s, and the upright holder follows the normal, on the outside."""
    tuft = build_tuft(load_brush(recording().header["brush"]))
    _, down = strokes()
    at = np.flatnonzero(down)[::20]
    up = matrices_from_quaternions(path().orientation[at])[:, :, 2]
    height = tuft.length - path().pressure[at] * tuft.full_press
    feet = path().position[at] - height[:, None] * up
    found = ClosestPoints(load_mesh("bowl")).find(feet)
    assert np.linalg.norm(found.points - feet, axis=1).max() < 0.05  # mm
    assert np.einsum("ij,ij->i", found.normals, up).min() > 0.999
    radius = np.linalg.norm(found.points[:, :2], axis=1)
    outward = np.einsum("ij,ij->i", found.normals[:, :2], found.points[:, :2]) / radius
    assert outward.min() > 0.5


def test_characters_stand_upright_in_a_column():
    frames = [c["frame"] for c in recording().header["characters"]]
    heights = [frame["origin"][2] for frame in frames]
    assert (np.diff(heights) < -5.0).all()
    for frame in frames:
        assert frame["y_axis"][2] > 0.6
        assert abs(frame["x_axis"][2]) < 0.02


def test_left_hand_turns_the_bowl_while_the_right_writes():
    turn = np.sum(recording().object_orientation[0] * recording().object_orientation, axis=1)
    degrees = np.degrees(2.0 * np.arccos(np.clip(np.abs(turn), 0.0, 1.0)))
    assert np.ptp(degrees) > 8.0
    _, down = strokes()
    step = np.abs(np.diff(degrees))
    assert step.max() * 250.0 < 60.0  # degrees a second
    assert np.median(step[down[1:]]) > 0.0


def test_hand_keeps_its_limits_on_the_bowl():
    speed = np.diff(path().position, axis=0) * 250.0
    _, down = strokes()
    near = down[1:] & down[:-1]
    assert np.linalg.norm(speed[near], axis=1).max() < 120.0
    acceleration = np.diff(speed, axis=0)[near[1:] & near[:-1]] * 250.0
    assert np.linalg.norm(acceleration, axis=1).max() < 1000.0
