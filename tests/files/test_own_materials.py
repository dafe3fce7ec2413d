"""A painting on a material of one's own shines as that says, in pictures and in files."""

from __future__ import annotations

import dataclasses
import json
import struct
from pathlib import Path

import pytest

from paint3d.colour.materials import load_material
from paint3d.files.export import export, gloss_of
from paint3d.files.export_options import ExportOptions
from paint3d.files.load import load_mesh
from paint3d.files.project.painting import Painting, read_painting
from paint3d.files.project.session import Session, load_session, save_session
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view.studio import Gloss

LACQUER = dataclasses.replace(
    load_material("porcelain"), name="lacquer", roughness=0.37, coat=0.4, tooth_mm=0.0
)


def test_pictures_of_it_shine_so(tmp_path: Path) -> None:
    save_session(Session(PaintedSurface(load_mesh("plane"), 20.0, LACQUER)), tmp_path / "a.p3d")
    read = read_painting(load_session(tmp_path / "a.p3d").surface, ExportOptions())
    assert isinstance(read, Painting)
    assert gloss_of(read) == Gloss(0.37, 0.4)
    bare = read_painting(load_mesh("plane"), ExportOptions())
    assert isinstance(bare, Painting)
    assert gloss_of(bare) is None


def test_those_of_the_program_shine_in_pictures_as_before() -> None:
    for name, gloss in (("porcelain", Gloss(0.3, 0.9)), ("xuan", Gloss(0.95, 0.0))):
        assert Gloss.of(name) == Gloss.of(load_material(name)) == gloss
    silk = load_material("silk")
    assert Gloss.of("silk") == Gloss(silk.roughness, silk.coat)
    assert Gloss.of(LACQUER) == Gloss(0.37, 0.4)


@pytest.mark.parametrize("texture", [None, 64])
def test_a_glb_is_as_rough(tmp_path: Path, texture: int | None) -> None:
    if texture is not None:
        pytest.importorskip("xatlas")
    surface = PaintedSurface(load_mesh("plane"), 20.0, LACQUER)
    export(surface, tmp_path / "a.glb", options=ExportOptions(texture=texture or False))
    data = (tmp_path / "a.glb").read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20 : 20 + length])
    assert document["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] == 0.37
