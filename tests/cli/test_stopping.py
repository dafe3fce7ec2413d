"""Work that takes long tells how far it is, and leaves everything as it was when it is stopped."""

from __future__ import annotations

import os
import time
from concurrent.futures import CancelledError
from pathlib import Path

import numpy as np
import pytest

import paint3d
from paint3d.app.model.document import Document
from paint3d.core.atomic import write_atomically
from paint3d.errors import ExportError, MeshError
from paint3d.files.export import FORMATS, prepare_export
from paint3d.files.export_options import ExportOptions
from paint3d.files.load import load_mesh
from paint3d.files.project.session import load_session
from paint3d.files.reading import ReadOptions, read_surface_apart
from paint3d.mesh.refined_mesh import PaintMesh
from tests.support.app.hands import paint, small_plane


def stop_at(share: float):
    """A progress that stops the work there."""

    def told(now: float) -> None:
        if now >= share:
            raise CancelledError

    return told


@pytest.fixture(scope="module")
def painted() -> Document:
    document = small_plane(0.6)
    paint(document, (-40.0, 0.0), (40.0, 5.0))
    document.refresh()
    return document


def test_the_file_behind_a_link_is_replaced_and_the_link_stays(tmp_path: Path) -> None:
    real, link = tmp_path / "real.txt", tmp_path / "there" / "link.txt"
    link.parent.mkdir()
    real.write_text("old")
    link.symlink_to(real)
    with write_atomically(link) as part:
        part.write_text("new")
    assert link.is_symlink()
    assert real.read_text() == "new"
    dangling = tmp_path / "dangling.txt"
    dangling.symlink_to(tmp_path / "to come.txt")
    with write_atomically(dangling) as part:
        part.write_text("made")
    assert dangling.is_symlink()
    assert (tmp_path / "to come.txt").read_text() == "made"


def test_a_link_that_leads_to_itself_is_refused(tmp_path: Path) -> None:
    loop = tmp_path / "loop.txt"
    loop.symlink_to(loop)
    with pytest.raises(ExportError, match=r"loop\.txt: cannot write"), write_atomically(loop):
        pytest.fail("it was written")


def test_refining_that_is_stopped_leaves_the_mesh_as_it_was() -> None:
    mesh = PaintMesh.build(load_mesh("sphere"), 2.0)
    before = {name: np.copy(array) for name, array in mesh.arrays._asdict().items()}
    with pytest.raises(CancelledError):
        mesh.refine_all(stop_at(0.5))
    after = mesh.arrays._asdict()
    n, nodes = (int(x) for x in mesh.arrays.counts)
    assert (n, nodes) == tuple(before["counts"])
    for name, array in before.items():
        now, then = np.atleast_1d(after[name]), np.atleast_1d(array)
        same = min(len(then), {"px": n, "child": nodes}.get(name, len(then)))
        np.testing.assert_array_equal(now[:same], then[:same], err_msg=name)
    shares: list[float] = []
    mesh.refine_all(shares.append)
    again = PaintMesh.build(load_mesh("sphere"), 2.0)
    again.refine_all()
    assert mesh.n_vertices == again.n_vertices > n
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_a_session_is_saved_and_opened_by_shares(painted: Document, tmp_path: Path) -> None:
    file, shares = tmp_path / "a.p3d", []
    painted.save(file, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    before = file.read_bytes()
    with pytest.raises(CancelledError):
        painted.save(file, progress=stop_at(1.0))
    assert file.read_bytes() == before
    assert os.listdir(tmp_path) == ["a.p3d"]
    opened: list[float] = []
    load_session(file, opened.append)
    assert opened == sorted(opened)
    assert len(opened) > 5
    with pytest.raises(CancelledError):
        load_session(file, stop_at(0.5))


@pytest.mark.parametrize("suffix", [s for s in FORMATS if s != ".png"])
def test_an_export_that_is_stopped_writes_nothing(
    painted: Document, tmp_path: Path, suffix: str
) -> None:
    file = tmp_path / f"a{suffix}"
    prepared = painted.prepare_export(file, ExportOptions())
    with pytest.raises(CancelledError):
        prepared.write(stop_at(1.0))
    assert os.listdir(tmp_path) == []
    prepared.write()
    whole = file.read_bytes()
    paint3d.export(painted.surface, file)
    assert file.read_bytes() == whole


def test_what_an_export_takes_is_told_by_shares_and_can_be_stopped(painted: Document) -> None:
    shares: list[float] = []
    prepare_export(painted.surface, "a.glb", ExportOptions(), shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    with pytest.raises(CancelledError):
        prepare_export(painted.surface, "a.glb", ExportOptions(), stop_at(0.0))


def test_a_childs_reading_is_ended_at_once(tmp_path: Path) -> None:
    shares: list[float] = []

    def told(share: float) -> None:
        shares.append(share)
        raise CancelledError

    big = tmp_path / "big.obj"
    big.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "f 1 2 3\n" * 2_000_000)
    began = time.process_time()
    with pytest.raises(CancelledError):
        read_surface_apart(big, ReadOptions(), progress=told)
    assert len(shares) == 1
    assert 0.0 < shares[0] < 1.0
    assert time.process_time() - began < 1.0
    if Path("/proc/self/task").is_dir():
        kin = " ".join(file.read_text() for file in Path("/proc/self/task").glob("*/children"))
        told = [Path(f"/proc/{number}/cmdline").read_bytes() for number in kin.split()]
        assert not any(b"paint3d.files.sandbox" in line for line in told)
    with pytest.raises(MeshError, match=r"took longer than 0\.1 s"):
        read_surface_apart(big, ReadOptions(), 0.1, lambda share: None)
