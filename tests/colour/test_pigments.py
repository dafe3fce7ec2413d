"""The palette, materials, users' tables, and the list of inks."""

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from paint3d.cli.lists.inks import swatches_table
from paint3d.cli.main import main
from paint3d.colour.difference import delta_e, lab_from_reflectance, lab_from_srgb
from paint3d.colour.layers import layer_reflectance
from paint3d.colour.materials import Material, load_material, load_materials, material_names
from paint3d.colour.pigments import (
    BANDS_NM,
    WATER,
    Pigment,
    load_drawdown_paints,
    load_palette,
    load_pigment,
    load_pigments_csv,
    pigment_names,
)
from paint3d.colour.spectra import xyz_from_reflectance
from paint3d.errors import PigmentError, UnknownNameError

ROOT = Path(__file__).parents[2]
MEASUREMENTS = ROOT / "../shared/pigments"


def table(tmp_path, *rows, nm=(400, 550, 700), columns="name"):
    header = columns + "".join(f",{letter}_{n}" for letter in "KS" for n in nm)
    path = tmp_path / "mine.csv"
    path.write_text("\n".join([header, *rows]) + "\n", "utf-8")
    return path


def test_palette_holds_inks_and_a_chinese_palette():
    palette = load_palette()
    assert {"pine soot", "oil soot", "cinnabar", "azurite", "malachite"} < set(palette)
    assert len(palette) >= 13
    assert pigment_names()[0] == "pine soot"
    assert list(palette) == pigment_names()


def test_every_row_says_where_it_is_from():
    for pigment in [*load_palette().values(), *load_drawdown_paints().values()]:
        assert pigment.source
        assert pigment.licence
        assert pigment.basis.split()[0] in {"measured", "masstone", "computed"}
        assert (pigment.K + pigment.S).min() > 0


def test_what_could_not_be_had_is_named_a_substitute():
    for name in ("carmine", "orpiment", "realgar"):
        assert "substitute" in load_pigment(name).basis


def test_drawdown_paints_are_glossy_and_apart_from_the_palette():
    paints = load_drawdown_paints()
    assert {"Vermillion", "ZincWhite", "BoneBlack"} < set(paints)
    assert all(p.saunderson for p in paints.values())
    assert not set(paints) & set(load_palette())
    assert load_pigment("Vermillion") is paints["Vermillion"]


def test_chinese_names_find_pigments():
    assert load_pigment("石青") is load_pigment("azurite")
    assert load_pigment("頭綠") is load_pigment("头绿") is load_pigment("malachite 1")
    assert load_pigment("硃砂") is load_pigment("cinnabar")


def lab_of(name, coats=1.0, material="xuan"):
    pigment, ground = load_pigment(name), load_material(material).reflectance
    return lab_from_reflectance(layer_reflectance(pigment.K, pigment.S, coats, ground))


@pytest.mark.parametrize(("stone", "chinese"), [("azurite", "青"), ("malachite", "绿")])
def test_grades_of_a_stone_go_from_deep_and_clear_to_pale_and_hiding(stone, chinese):
    grades = [load_pigment(f"{stone} {n}") for n in (1, 2, 3, 4)]
    assert grades[1] is load_pigment(stone) is load_pigment(f"二{chinese}")
    assert [p.chinese[-1] for p in grades] == [chinese] * 4
    light = [lab_of(p.name)[0] for p in grades]
    assert (np.diff(light) > 8.0).all()
    assert (np.diff([p.S.mean() for p in grades]) > 0.0).all()
    over_black = [xyz_from_reflectance(layer_reflectance(p.K, p.S, 1.0, 0.0))[1] for p in grades]
    over_white = [xyz_from_reflectance(layer_reflectance(p.K, p.S, 1.0, 0.8))[1] for p in grades]
    hides = np.array(over_black) / over_white
    assert (np.diff(hides) > 0.0).all()
    assert hides[1] == pytest.approx(0.98, abs=0.002)


def test_pigments_look_as_painters_know_them():
    hue = {n: np.degrees(np.arctan2(*lab_of(n)[:0:-1])) % 360.0 for n in ("cinnabar", "azurite 1")}
    chroma = {n: np.hypot(*lab_of(n)[1:]) for n in ("cinnabar", "azurite 1", "malachite")}
    assert 30.0 < hue["cinnabar"] < 45.0  # a red towards orange, not salmon
    assert chroma["cinnabar"] > 60.0
    assert chroma["azurite 1"] > 35.0  # blue, not slate
    assert 280.0 < hue["azurite 1"] < 300.0
    assert chroma["malachite"] > 20.0
    wash, full = lab_of("indigo", 0.1), lab_of("indigo", 2.0)
    assert np.hypot(*wash[1:]) < 12.0  # the grey blue of a wash
    assert full[0] < 35.0


@pytest.mark.parametrize("coats", [1.0, 2.0])
def test_water_makes_cinnabar_paler(coats):
    """Four fifths of water under a light stroke and under a pressed one."""
    full, thinned = lab_of("cinnabar", coats), lab_of("cinnabar", 0.2 * coats)
    assert thinned[0] > full[0] + 15.0


def test_gamboge_is_lemon_when_thin_and_golden_when_thick():
    hues = [np.degrees(np.arctan2(*lab_of("gamboge", x)[:0:-1])) for x in (2.0, 1.0, 0.4, 0.2)]
    assert (np.diff(hues) > 3.0).all()
    assert hues[0] < 82.0
    assert hues[-1] > 96.0
    thick = lab_from_srgb(np.array([228, 155, 15]) / 255.0)  # Maerz and Paul, 1930
    assert delta_e(lab_of("gamboge", 2.0), thick) < 6.0


def test_indigo_is_dull():
    """Before it was greyed, a full coat had a chroma of 32 and a coat of .4 one of 23."""
    for coats, most in ((2.0, 20.0), (1.0, 26.0), (0.4, 18.0)):
        lab = lab_of("indigo", coats)
        assert 0.0 < np.hypot(*lab[1:]) < most
        assert 240.0 < np.degrees(np.arctan2(*lab[:0:-1])) % 360.0 < 285.0


def test_full_coats_stand_in_order_of_lightness():
    order = [
        "oil soot", "pine soot", "azurite 1", "indigo", "azurite", "ochre", "cinnabar",
        "azurite 4", "minium", "malachite 4", "gamboge", "orpiment", "shell white",
        "titanium white",
    ]  # fmt: skip
    light = [lab_of(name)[0] for name in order]
    assert (np.diff(light) > 1.0).all()


def test_a_density_of_ones_own_is_read_and_checked(tmp_path):
    path = tmp_path / "mine.csv"
    head = "name,density,K_400,K_700,S_400,S_700\n"
    path.write_text(f"{head}oil,2.5,1,1,2,2\nwash,,1,1,2,2\n", "utf-8")
    mine = load_pigments_csv(path)
    assert (mine["oil"].density, mine["wash"].density) == (2.5, None)
    for bad in ("0", "31", "heavy"):
        path.write_text(f"{head}oil,{bad},1,1,2,2\n", "utf-8")
        wrong = rf"mine\.csv:2: density is '{bad}'; expected a number from 0\.01 to 30"
        with pytest.raises(PigmentError, match=wrong):
            load_pigments_csv(path)
    with pytest.raises(PigmentError, match="density of x"):
        Pigment("x", "", np.ones(31), np.ones(31), density=0.0)


def test_pigments_cannot_be_changed():
    pigment = load_pigment("pine soot")
    with pytest.raises(ValueError, match="read-only"):
        pigment.K[0] = 1
    with pytest.raises(TypeError):
        load_palette()["mine"] = pigment


@pytest.mark.parametrize("name", ["pine sot", "", "nothing like it"])
def test_unknown_ink_lists_the_known(name):
    with pytest.raises(UnknownNameError, match=r"expected one of .*pine soot"):
        load_pigment(name)


def test_own_table_is_read_and_interpolated(tmp_path):
    path = table(tmp_path, "mine,1,2,3,4,4,4")
    mine = load_pigments_csv(path)["mine"]
    assert mine.K[0] == 1
    assert mine.K[15] == pytest.approx(2)
    assert mine.K[30] == 3
    assert (mine.S == 4).all()
    assert not mine.saunderson


def test_a_gloss_of_ones_own_is_read_and_checked(tmp_path):
    path = tmp_path / "mine.csv"
    head = "name,gloss,K_400,K_700,S_400,S_700\n"
    path.write_text(f"{head}lacquer,.8,1,1,2,2\nchalk,,1,1,2,2\n", "utf-8")
    mine = load_pigments_csv(path)
    assert mine["lacquer"].gloss == 0.8
    assert mine["chalk"].gloss == 0.0
    for bad in ("2", "shiny", "-1", "nan"):
        path.write_text(f"{head}lacquer,{bad},1,1,2,2\n", "utf-8")
        with pytest.raises(
            PigmentError, match=rf"mine\.csv:2: gloss is '{bad}'; expected a number"
        ):
            load_pigments_csv(path)
    assert load_pigment("oil soot").gloss > load_pigment("pine soot").gloss == 0.0


@pytest.mark.parametrize(
    ("column", "given", "usual", "above", "most"),
    [("fine", 1.0, 0.12, "1.5", 1), ("grain_um", 40.0, 0.0, "1001", 1000)],
)
def test_how_an_own_pigment_runs_is_read_and_checked(column, given, usual, above, most, tmp_path):
    path = tmp_path / "mine.csv"
    head = f"name,{column},K_400,K_700,S_400,S_700\n"
    path.write_text(f"{head}dye,{given},1,1,2,2\nearth,,1,1,2,2\n", "utf-8")
    mine = load_pigments_csv(path)
    assert (getattr(mine["dye"], column), getattr(mine["earth"], column)) == (given, usual)
    path.write_text(f"{head}dye,{above},1,1,2,2\n", "utf-8")
    wrong = rf"mine\.csv:2: {column} is '{above}'; expected a number from 0 to {most}"
    with pytest.raises(PigmentError, match=wrong):
        load_pigments_csv(path)
    with pytest.raises(PigmentError, match=f"{column} of x"):
        Pigment("x", "", np.ones(31), np.ones(31), **{column: -0.1})


def test_grades_of_stone_have_grains_of_their_sizes():
    grains = {name: pigment.grain_um for name, pigment in load_palette().items()}
    for stone in ("azurite", "malachite"):
        grades = [grains[f"{stone}{grade}"] for grade in (" 1", "", " 3", " 4")]
        assert grades == [40.0, 20.0, 10.0, 5.0]
    assert grains["pine soot"] == grains["carmine"] == 0.0


def test_coarser_grains_have_less_that_runs_with_water():
    fine = {name: pigment.fine for name, pigment in load_palette().items()}
    assert fine["pine soot"] == 0.3  # the halo was set by it
    assert fine["carmine"] > fine["gamboge"] > fine["indigo"] > fine["oil soot"]
    for stone in ("azurite", "malachite"):
        grades = [fine[f"{stone} 1"], fine[stone], fine[f"{stone} 3"], fine[f"{stone} 4"]]
        assert grades == sorted(grades)
        assert grades[-1] < fine["pine soot"]


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([], "holds no pigment"),
        (["mine,1,2,3,4,4,4", "yours,1,-2,3,4,4,4"], r"mine\.csv:3: K_550 is -2"),
        (["mine,1,2,3,4,nan,4"], r"mine\.csv:2: S_550 is nan"),
        (["mine,1,2,3,4,inf,4"], r"mine\.csv:2: S_550 is inf"),
        (["mine,1,2,3,4,x,4"], r"mine\.csv:2: S_550 is 'x'"),
        (["mine,1,2,3"], r"mine\.csv:2: S_400 is None"),
        ([",1,2,3,4,4,4"], r"mine\.csv:2: name is empty"),
        (["a,1,2,3,4,4,4", "a,1,2,3,4,4,4"], r"mine\.csv:3: 'a' occurs twice"),
    ],
)
def test_bad_rows_are_named(tmp_path, rows, message):
    with pytest.raises(PigmentError, match=message):
        load_pigments_csv(table(tmp_path, *rows))


@pytest.mark.parametrize(
    ("nm", "message"),
    [((550, 400, 700), "rising"), ((400, 400, 700), "rising"), ((400, 500, 600), "cover")],
)
def test_bad_wavelengths_are_named(tmp_path, nm, message):
    with pytest.raises(PigmentError, match=rf"mine\.csv:1: .*{message}"):
        load_pigments_csv(table(tmp_path, "mine,1,2,3,4,4,4", nm=nm))


def test_a_masstone_gives_its_own_colour_and_hides(tmp_path):
    path = tmp_path / "mine.csv"
    path.write_text("name,chinese,R_400,R_600,R_700\nclay,泥,0.2,0.6,0.6\n", "utf-8")
    clay = load_pigments_csv(path)["clay"]
    assert clay.basis == "masstone"
    assert clay.chinese == "泥"
    black, white = (layer_reflectance(clay.K, clay.S, 1.0, ground) for ground in (0.0, 0.8))
    thick = layer_reflectance(clay.K, clay.S, 1e4, 0.0)
    np.testing.assert_allclose(thick, np.interp(BANDS_NM, [400, 600, 700], [0.2, 0.6, 0.6]))
    light = [xyz_from_reflectance(film)[1] for film in (black, white)]
    assert light[0] / light[1] == pytest.approx(0.98, abs=0.002)
    assert load_pigment(f"{path}:clay").name == "clay"
    with pytest.raises(UnknownNameError, match=r"unknown ink of .*mine\.csv 'mud'.*clay"):
        load_pigment(f"{path}:mud")


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("x,0.1,0.0,0.5", r":2: R is 0 at 550 nm"),
        ("x,0.1,1e-300,0.5", r":2: R is 1e-300 at 550 nm; expected a reflectance from 1e-06"),
        ("x,0.1,1.2,0.5", r":2: R is 1.2 at 550 nm"),
        ("x,0.1,-0.2,0.5", r":2: R_550 is -0.2"),
    ],
)
def test_a_masstone_must_be_a_reflectance(tmp_path, row, message):
    path = tmp_path / "mine.csv"
    path.write_text(f"name,R_400,R_550,R_700\n{row}\n", "utf-8")
    with pytest.raises(PigmentError, match=message):
        load_pigments_csv(path)


def test_the_command_checks_an_own_table(tmp_path, capsys):
    path = table(tmp_path, "mine,1,2,3,4,4,4")
    assert main(["inks", str(path)]) == 0
    assert "mine" in capsys.readouterr().out
    assert main(["inks", str(table(tmp_path, "mine,1,-2,3,4,4,4"))]) == 2
    told = capsys.readouterr().err
    assert told.startswith("paint3d: error: ")
    assert "mine.csv:2: K_550 is -2" in told
    assert told.count("\n") == 1


def films(tmp_path, k, s, white=0.82, black=0.04, grounds="0.82,0.04", noise=0.0):
    """A table of a film over two grounds, as an instrument would measure it."""
    over = noise + np.array(
        [layer_reflectance(k, s, np.ones(31), np.full(31, g)) for g in (white, black)]
    )
    names = ",".join(f"{letter}_{nm:.0f}" for letter in "WB" for nm in BANDS_NM)
    values = ",".join(repr(float(v)) for v in np.concatenate(over))
    path = tmp_path / "films.csv"
    path.write_text(f"name,white,black,{names}\nmine,{grounds},{values}\n", "utf-8")
    return path


@pytest.mark.parametrize("name", ["pine soot", "azurite", "gamboge", "titanium white"])
def test_a_film_over_white_and_black_tells_what_absorbs_and_scatters(name, tmp_path):
    found, thin = load_palette()[name], 0.3
    ink = load_pigments_csv(films(tmp_path, thin * found.K, thin * found.S))["mine"]
    np.testing.assert_allclose(ink.K, thin * found.K, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(ink.S, thin * found.S, rtol=1e-5, atol=1e-6)
    assert ink.basis == "film over white and black"


def test_a_white_film_measured_a_thousandth_too_light_is_one(tmp_path):
    """It seems to let through more than there is."""
    white = load_palette()["titanium white"]
    noise = np.array([[1e-3], [0.0]])
    path = films(tmp_path, 0.02 * white.K, 0.02 * white.S, noise=noise)
    ink = load_pigments_csv(path)["mine"]
    assert np.abs(ink.S - 0.02 * white.S).max() < 0.1 * 0.02 * white.S.max()


def test_a_film_that_only_absorbs_is_one_too(tmp_path):
    k = np.linspace(0.1, 1.0, 31)
    ink = load_pigments_csv(films(tmp_path, k, np.zeros(31)))["mine"]
    np.testing.assert_allclose(ink.K, k, rtol=1e-6)
    np.testing.assert_allclose(ink.S, 0.0, atol=1e-5)


@pytest.mark.parametrize(
    ("strength", "grounds", "message"),
    [
        (9.0, "0.82,0.04", "films.csv:2: the film hides its ground at 400 nm"),
        (0.3, "0.3,0.04", "films.csv:2: at 400 nm no film is 0..* over a ground of 0.3"),
        (0.3, "0.04,0.82", "films.csv:2: white is '0.04' and black '0.82'; expected"),
        (-0.3, "0.82,0.04", "films.csv:2: the film is darker over white than over black"),
        (0.3, "0.82,", "films.csv:2: white is '0.82' and black ''; expected"),
    ],
)
def test_films_that_tell_nothing_are_refused(strength, grounds, message, tmp_path):
    film = np.full(31, abs(strength))
    sides = (0.82, 0.04) if strength > 0.0 else (0.04, 0.82)
    path = films(tmp_path, film, film, *sides, grounds=grounds)
    with pytest.raises(PigmentError, match=message):
        load_pigments_csv(path)


def test_water_does_nothing_to_light():
    assert load_pigment("water") is load_pigment("水") is WATER
    assert not WATER.K.any()
    assert not WATER.S.any()


def test_tables_without_columns_or_files_are_named(tmp_path):
    path = tmp_path / "mine.csv"
    for text, message in [
        ("", "no column 'name'"),
        ("name,K_400\nx,1\n", "has columns K_<nm> .1.; exp"),
    ]:
        path.write_text(text)
        with pytest.raises(PigmentError, match=message):
            load_pigments_csv(path)
    path.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(PigmentError, match="cannot be read"):
        load_pigments_csv(path)
    with pytest.raises(PigmentError, match="cannot be read"):
        load_pigments_csv(tmp_path / "none.csv")


def test_a_pigment_checks_itself():
    good = np.ones(31)
    with pytest.raises(PigmentError, match="S of x is -1 at 420 nm"):
        Pigment("x", "", good, np.where(BANDS_NM == 420, -1, 1))
    with pytest.raises(PigmentError, match="S of x is 1e\\+07 at 420 nm; expected 0 to 1e\\+06"):
        Pigment("x", "", good, np.where(BANDS_NM == 420, 1e7, 1))
    with pytest.raises(PigmentError, match="K of x is not an array of numbers"):
        Pigment("x", "", [10**400] * 31, good)
    with pytest.raises(PigmentError, match="shape"):
        Pigment("x", "", good[:5], good)
    with pytest.raises(PigmentError, match="no name"):
        Pigment("", "", good, good)


def test_materials_are_the_promised_ones():
    assert {"porcelain", "bisque", "xuan", "plaster"} <= set(material_names())
    for material in load_materials().values():
        assert material.source
        assert material.basis
        assert material.reflectance.shape == (31,)
    assert load_material("porcelain").coat > load_material("bisque").coat
    assert load_material("xuan").absorbency > load_material("porcelain").absorbency


def test_bad_materials_are_refused():
    with pytest.raises(UnknownNameError, match="did you mean 'porcelain'"):
        load_material("porcelan")
    with pytest.raises(PigmentError, match="expected 0 to 1"):
        Material("x", np.full(31, 1.1), 0, 0, 0, 0)
    with pytest.raises(PigmentError, match="roughness of x"):
        Material("x", np.ones(31), 2, 0, 0, 0)


@pytest.mark.skipif(not MEASUREMENTS.exists(), reason="measurements lie beside the checkout")
@pytest.mark.parametrize("name", [pytest.param("palette", marks=pytest.mark.long), "materials"])
def test_shipped_table_is_what_its_script_builds(tmp_path, name):
    script, built = ROOT / f"scripts/build_{name}.py", tmp_path / "built.csv"
    subprocess.run(
        [sys.executable, str(script), str(MEASUREMENTS), "--out", str(built)], check=True, cwd=ROOT
    )
    shipped = ROOT / f"paint3d/colour/data/{name}.csv"
    with built.open(encoding="utf-8") as one, shipped.open(encoding="utf-8") as two:
        for fresh, kept in zip(csv.reader(one), csv.reader(two), strict=True):
            assert fresh[:5] == kept[:5]
            for a, b in zip(fresh[5:], kept[5:], strict=True):
                assert a == b or float(a) == pytest.approx(float(b), rel=0.02)


def test_list_of_inks_has_a_line_each_and_colour_only_when_asked():
    palette = load_palette().values()
    plain, coloured = swatches_table(palette), swatches_table(palette, colour=True)
    assert len(plain) == len(coloured) == len(pigment_names()) + 1
    assert not any("\x1b" in line for line in plain)
    assert all("\x1b[48;2;" in line for line in coloured[1:])
    soot = next(line for line in plain if line.startswith("pine soot"))
    assert "松烟墨" in soot
    assert "#1" in soot
    assert "computed" in soot


def test_a_name_that_somebody_else_wrote_leads_to_no_file(tmp_path):
    own = f"{table(tmp_path, 'mine,1,2,3,4,4,4')}:mine"
    assert load_pigment(own).name == "mine"
    with pytest.raises(PigmentError, match=r"mine\.csv:mine' is of a table on this machine"):
        load_pigment(own, own_tables=False)
    assert load_pigment("pine soot", own_tables=False).name == "pine soot"


@pytest.mark.parametrize("column", ["thin_400", "T_400.5", "saundersn", "grain"])
def test_a_column_that_would_be_passed_over_is_refused(tmp_path, column) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"name,R_400,R_700,{column},remark\nred,0.05,0.7,0.3,mine\n", encoding="utf-8")
    with pytest.raises(PigmentError, match=f"a.csv:1: '{column}' is no column.*grain_um"):
        load_pigments_csv(path)
    path.write_text("name,R_400,R_700,remark\nred,0.05,0.7,mine\n", encoding="utf-8")
    assert list(load_pigments_csv(path)) == ["red"]
