"""A 3-D mouse in the page: its reports are decoded, and the object turns, as in the window."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from paint3d.core.quaternion import turn
from paint3d.device.catalogue import find_mouse_quirks
from paint3d.device.descriptor import parse_descriptor
from paint3d.device.six_dof import MouseReading, find_mouse_layout
from paint3d.device.space_mouse import DeflectionSettings, deflection
from paint3d.page.folder import KERNELS, PageObject, build_page
from paint3d.pose.steering import SteeringOptions, SteeringState, advance, report
from tests.support.descriptors import SPACENAVIGATOR, combined_mouse, split_mouse
from tests.support.web_page import as_a_browser_has_it, replay_script, why_no_kernels

pytestmark = pytest.mark.skipif(bool(why_no_kernels(KERNELS)), reason=why_no_kernels(KERNELS))
MICE = {"captured": SPACENAVIGATOR, "split": split_mouse(), "combined": combined_mouse()}
SECONDS = 0.1


def reports_of(descriptor: bytes) -> list[tuple[int, list[int]]]:
    """Reports as such a mouse sends them: axes within and beyond their range, then buttons."""
    layout = find_mouse_layout(parse_descriptor(descriptor))
    chance, reports = np.random.default_rng(7), []
    for _ in range(12):
        counts = chance.integers(-380, 381, 6)
        for number in sorted({field.report_id for field in layout.axes if field is not None}):
            own = [k for k, field in enumerate(layout.axes) if field and field.report_id == number]
            reports.append((number, list(counts[own].astype("<i2").tobytes())))
        reports.append((3, list(chance.bytes(layout.descriptor.size(layout.buttons[0].kind, 3)))))
    return reports


@pytest.fixture(scope="module")
def in_node(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder: Path = tmp_path_factory.mktemp("page")
    build_page(folder, [PageObject("a4", 4.0)], ["zhongkai"], ["pine soot"], page=None)
    asked = []
    for descriptor in MICE.values():
        mouse = {"collections": as_a_browser_has_it(descriptor), "reports": reports_of(descriptor)}
        asked.append(json.dumps({"mouse": mouse, "seconds": SECONDS}))
    script = replay_script(tmp_path_factory.mktemp("replay"))
    done = subprocess.run(
        ["node", script, os.fspath(folder), *asked], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return dict(zip(MICE, map(json.loads, done.stdout.splitlines()), strict=True))


@pytest.mark.parametrize("name", MICE)
def test_reports_say_the_same_axes_buttons_and_deflections(
    name: str, in_node: dict[str, Any]
) -> None:
    layout = find_mouse_layout(parse_descriptor(MICE[name]))
    quirks, reading = find_mouse_quirks(0, 0), MouseReading()
    for (number, body), found in zip(
        reports_of(MICE[name]), in_node[name]["readings"], strict=True
    ):
        reading = layout.decode(bytes([number, *body]), reading)
        assert (tuple(found["axes"]), found["buttons"]) == (reading.axes, reading.buttons)
        ours = deflection(reading.axes, quirks, DeflectionSettings())
        np.testing.assert_allclose(found["deflection"], ours, rtol=1e-12, atol=1e-15)
    assert any(reading.axes)


@pytest.mark.parametrize("name", MICE)
def test_the_object_goes_and_turns_as_in_the_window(name: str, in_node: dict[str, Any]) -> None:
    found = in_node[name]
    right, up, back = map(np.array, found["axes"])
    view = Rotation.from_matrix(np.column_stack([right, -back, up])).as_quat(scalar_first=True)
    options = SteeringOptions(pivot=(1.0, 2.0, 3.0), world_from_view=tuple(view.tolist()))
    last = found["readings"][-1]["deflection"]
    state = advance(options, report(options, SteeringState(0), 0, last), int(1e9 * SECONDS))
    orientation = tuple(state.pose.orientation.tolist())
    for place, before, after in zip(found["places"], found["before"], found["after"], strict=True):
        there = np.array(turn(orientation, tuple(place))) + state.pose.position
        seen = [float(axis @ (there - found["eye"])) for axis in (right, up, back)]
        np.testing.assert_allclose(after, seen, atol=1e-6)
        assert np.linalg.norm(np.subtract(after, before)) > 0.1
