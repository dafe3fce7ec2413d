"""Materials of one's own as files, and what the surface does to brush and ink."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from paint3d.app.model.score.codecs import InkTable, decode_material, make_header
from paint3d.brush.bending import build_tuft, tuft_on
from paint3d.brush.presets import brush_names, load_brush
from paint3d.colour.materials import (
    Material,
    load_material,
    material_names,
    material_text,
)
from paint3d.colour.spectra import srgb_from_reflectance
from paint3d.errors import PigmentError, UnknownNameError
from paint3d.files.load import load_mesh
from paint3d.files.project.session import Session, load_session, save_session
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.state import restore_surface, surface_state

NEEDED = "roughness = 0.9\ncoat = 0\nabsorbency = 1\ngrain = 0.5\n"


def written(folder: Path, text: str, name: str = "mine.toml") -> str:
    (folder / name).write_text(text, encoding="utf-8")
    return str(folder / name)


def values(material: Material) -> dict[str, object]:
    told = {f.name: getattr(material, f.name) for f in dataclasses.fields(material)}
    return told | {"reflectance": material.reflectance.tolist()}


@pytest.mark.parametrize("name", material_names())
def test_what_is_shown_is_read_back(name: str, tmp_path: Path) -> None:
    material = load_material(name)
    read = load_material(written(tmp_path, material_text(material)))
    assert values(read) == values(material) | {"name": "mine"}


@pytest.mark.parametrize("name", material_names())
def test_each_number_has_a_source_or_was_set_by_eye(name: str) -> None:
    material = load_material(name)
    assert "set by eye" in material.note
    assert material.source
    assert material.basis
    assert material.licence
    assert material.chinese


def test_a_file_may_start_from_a_material(tmp_path: Path) -> None:
    toml = written(tmp_path, 'base = "silk"\nfriction = 1.2\ncolour = "#e8d9b0"\n')
    same = {"base": "silk", "name": "mine", "friction": 1.2, "colour": "#E8D9B0"}
    read = load_material(toml)
    assert values(read) == values(load_material(written(tmp_path, json.dumps(same), "o.JSON")))
    silk = load_material("silk")
    assert (read.friction, read.absorbency, read.grain) == (1.2, silk.absorbency, silk.grain)
    assert srgb_from_reflectance(read.reflectance).tolist() == [0xE8, 0xD9, 0xB0]
    assert (read.basis, read.source, read.licence) == ("of the colour #e8d9b0", "", "")
    plain = load_material(written(tmp_path, 'base = "silk"\n'))
    assert (plain.basis, plain.note, plain.chinese) == ("as silk", "", "")
    whole = load_material(written(tmp_path, NEEDED + 'colour = "#ffffff"\n'))
    assert whole.reflectance.min() > 0.999
    pairs = "reflectance = [[380, 0.2], [700, 0.84]]"
    ramp = load_material(written(tmp_path, NEEDED + pairs))
    assert np.allclose(ramp.reflectance, np.linspace(0.24, 0.84, 31))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("grain = 0.4", "says no colour, roughness, coat, absorbency"),
        ('base = "sil"', "base is 'sil'; expected one of porcelain"),
        ('base = "silk"\nfriktion = 1', "there is no 'friktion': did you mean 'friction'"),
        ('base = "silk"\nfriction = 0.1', "friction of mine is 0.1; expected 0.2 to 2"),
        ('base = "silk"\ngrain = "coarse"', "grain of mine is 'coarse'; expected a number"),
        ('base = "silk"\nname = "xuan"', "a material that comes with the program"),
        ('base = "silk"\nname = "a.toml"', "no file's name"),
        ('base = "silk"\nsource = 3', "source is 3; expected at most 500 letters"),
        ('base = "silk"\ncolour = "white"', "colour is 'white'; expected sRGB such as"),
        ('base = "silk"\ncolour = "#fff"', "colour is '#fff'; expected sRGB"),
        ('base = "silk"\nreflectance = 3', "reflectance is of the shape (); expected 31 numbers"),
        ('base = "silk"\nreflectance = ["a"]', "reflectance is ['a']; expected 31 numbers"),
        ('base = "silk"\nreflectance = [[450, 1], [700, 1]]', "from 450 to 700 nm; expected"),
        ('base = "silk"\nreflectance = [[380, 1], [700, 3]]', "is 1.125 to 3; expected 0 to 1"),
        (
            'base = "silk"\ncolour = "#ffffff"\nreflectance = [[380, 1], [700, 1]]',
            "says a colour and a reflectance",
        ),
        ('base = "silk"\nreflectance = [true, false]', "reflectance is [True, False]; expected 31"),
        (f'base = "silk"\nreflectance = {["0.5"] * 31}', "reflectance is ['0.5', "),
        (f'base = "silk"\nreflectance = [{"9" * 400}]', "reflectance is [9999"),
        ('base = "silk"\nnote = "a\\u007fb"', "no control characters"),
        ('base = "silk"\nchinese = "\\u001b[2J"', "no control characters"),
        (f'base = "silk"\nreflectance = {"[" * 300}1{"]" * 300}', "reflectance is [[[[["),
        ("base = ", "cannot be read as TOML"),
    ],
)
def test_a_bad_file_says_where_and_what(text: str, told: str, tmp_path: Path) -> None:
    file = written(tmp_path, text)
    with pytest.raises(PigmentError) as refused:
        load_material(file)
    assert str(refused.value).startswith(f"{file}: ")
    assert told in str(refused.value)


def test_half_a_character_is_refused_before_a_session_cannot_be_saved(tmp_path: Path) -> None:
    file = written(tmp_path, json.dumps({"base": "silk", "note": "a\ud800"}), "half.json")
    with pytest.raises(PigmentError, match="no halves of one"):
        load_material(file)
    lines = json.dumps({"base": "silk", "note": "first\nsecond\t\u3000绢"})
    read = load_material(written(tmp_path, lines, "lines.json"))
    again = load_material(written(tmp_path, material_text(read)))
    assert again.note == read.note == "first\nsecond\t\u3000绢"


def test_a_name_that_no_file_can_have_is_no_file() -> None:
    with pytest.raises(PigmentError, match=r"a\.toml: "):
        load_material("a" * 300 + ".toml")


def test_names_out_of_files_open_no_files(tmp_path: Path) -> None:
    file = written(tmp_path, 'base = "silk"')
    with pytest.raises(PigmentError, match="which a file may not name"):
        load_material(file, own_files=False)
    with pytest.raises(UnknownNameError):
        decode_material({"material": file})  # of a score
    assert load_material("silk", own_files=False) is load_material("silk")


def test_paintings_keep_the_whole_material_and_no_file(tmp_path: Path) -> None:
    mine = load_material(written(tmp_path, 'base = "silk"\nfriction = 1.2\n'))
    surface = PaintedSurface(load_mesh("plane"), 20.0, mine)
    save_session(Session(surface), tmp_path / "a.p3d")
    (tmp_path / "mine.toml").unlink()
    assert values(load_session(tmp_path / "a.p3d").surface.material) == values(mine)
    said = make_header(surface, load_brush("full"), "pine soot", InkTable({}))
    assert values(decode_material(json.loads(json.dumps(said)))) == values(mine)


def test_surfaces_from_before_friction_are_of_the_materials_that_they_name() -> None:
    stone = PaintedSurface(load_mesh("plane"), 20.0, "terracotta")
    state = surface_state(stone)
    for name in ("friction", "note"):
        del state["material"][name]
    again = restore_surface(load_mesh("plane"), state)
    assert again.material is load_material("terracotta")
    state["material"]["grain"] = 0.1  # but not where it differs
    assert restore_surface(load_mesh("plane"), state).material.grain == 0.1


# -- what it does --------------------------------------------------------------------------


def test_recordings_of_before_brushes_were_rated_on_xuan_say_their_material() -> None:
    stone = dataclasses.replace(load_material("terracotta"), name="stone", friction=1.5)
    surface = PaintedSurface(load_mesh("plane"), 20.0, stone)
    said = make_header(surface, load_brush("full"), "pine soot", InkTable({}))
    said["material"] |= {"rated_absorbency": 0.8, "rated_friction": 1.25}
    assert values(decode_material(said)) == values(stone)


def test_brushes_are_rated_on_raw_xuan_and_give_less_on_what_drinks_less() -> None:
    for spec in map(load_brush, brush_names()):
        assert tuft_on(spec, load_material("xuan")) == build_tuft(spec)
        glaze = tuft_on(spec, load_material("porcelain"))
        assert glaze.transfer_per_mm == pytest.approx(2 / 3 * build_tuft(spec).transfer_per_mm)


def test_friction_of_the_surface_spreads_the_hairs_and_drags_them() -> None:
    """Guo 2015, Eq. 2: b + c mu, where mu is that of brush and surface."""
    spec, xuan = load_brush("full"), load_material("xuan")
    for friction in (0.5, 1.0, 2.0):
        tuft = tuft_on(spec, dataclasses.replace(xuan, friction=friction))
        mu = spec.friction * friction
        spread = spec.spread_by_pressure + spec.spread_by_friction * mu
        assert tuft.spread == pytest.approx(spread, rel=1e-12)
        assert tuft.drag_fraction == pytest.approx(min(0.5, spec.drag_fraction * friction))
    with pytest.raises(PigmentError, match=r"expected 0.2 to 2"):
        dataclasses.replace(xuan, friction=2.5)
