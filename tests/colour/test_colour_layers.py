"""Mixtures as measured, the nearest one to a colour, inks in words, and bad input."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from paint3d.colour.difference import delta_e, lab_from_reflectance, lab_from_srgb
from paint3d.colour.ink_text import split_ink, tables_in, with_tables
from paint3d.colour.inks import TONES, describe_ink, load_ink, tone_names
from paint3d.colour.layers import (
    layer_reflectance,
    mix_pigments,
    mixture_reflectance,
    stack_reflectance,
)
from paint3d.colour.materials import load_material
from paint3d.colour.nearest_mixture import nearest_mixture
from paint3d.colour.pigments import (
    BANDS_NM,
    WATER,
    load_drawdown_paints,
    load_palette,
    load_pigment,
)
from paint3d.colour.spectra import srgb_from_reflectance
from paint3d.errors import InputError, PigmentError, UnknownNameError

DRAWDOWNS = Path(__file__).parents[2] / "../shared/pigments/drawdowns.csv"
WHITE = np.full(31, 0.85)


@pytest.mark.skipif(not DRAWDOWNS.exists(), reason="the drawdowns lie beside the checkout")
def test_measured_drawdowns_are_met():
    with DRAWDOWNS.open(newline="") as stream:
        rows = list(csv.DictReader(stream))

    def spectrum(row, kind):
        return np.array([float(row[f"{kind}_{nm:.0f}"]) for nm in BANDS_NM])

    apart = []
    for row in rows:
        recipe = json.loads(row["mass_fractions_json"])
        for side in ("black", "white"):
            film = mixture_reflectance(recipe, 1.0, spectrum(row, f"chart_{side}"))
            measured = spectrum(row, f"over_{side}")
            apart.append(delta_e(lab_from_reflectance(film), lab_from_reflectance(measured)))
    assert len(apart) == 68  # 1.40, .75 and 7.2: films are .57 to 1.38 coats thick, and no one coat
    assert np.mean(apart) < 1.45
    assert np.median(apart) < 0.8
    assert np.max(apart) < 7.5


def test_scattering_changes_slowly_with_wavelength():
    """What tints that no fit has seen are predicted by: it is held five times as fast as K."""
    steps = {
        letter: np.mean(
            [
                np.abs(np.diff(np.log(getattr(p, letter)))).mean()
                for p in load_drawdown_paints().values()
            ]
        )
        for letter in "KS"
    }
    assert steps["S"] < 0.45 * steps["K"]


def test_no_paint_leaves_the_backing_with_and_without_gloss():
    for name in ("cinnabar", "Vermillion"):
        np.testing.assert_allclose(mixture_reflectance({name: 1}, 0, WHITE), WHITE, atol=1e-12)


def test_only_proportions_count():
    one = mixture_reflectance({"cinnabar": 1, "lead white": 3}, 0.5, WHITE)
    two = mixture_reflectance({"cinnabar": 0.25, "lead white": 0.75}, 0.5, WHITE)
    np.testing.assert_allclose(one, two, atol=1e-15)


@pytest.mark.parametrize(
    ("name", "density"),
    [("ZincWhite", 2.87), ("LeadWhite", 4.13), ("BoneBlack", 1.38), ("Minium", 4.79),
     ("Vermillion", 3.76), ("PrussianBlue", 1.23), ("ViridianGreen", 1.63)],
)  # fmt: skip
def test_weighed_paints_have_the_densities_of_pigment_and_oil(name, density):
    assert load_pigment(name).density == density


def test_a_recipe_by_mass_is_mixed_by_volume():
    """A tenth of bone black by mass is a fifth of the film, and much darker than a tenth of it."""
    white, black = load_pigment("ZincWhite"), load_pigment("BoneBlack")
    recipe = {white: 0.9 * white.density, black: 0.1 * black.density}
    by_mass, by_volume = mix_pigments(recipe), mix_pigments({white: 0.9, black: 0.1}, True)
    np.testing.assert_allclose(by_mass[0], by_volume[0], rtol=1e-12)
    np.testing.assert_allclose(by_mass[1], by_volume[1], rtol=1e-12)
    films = [mixture_reflectance({white: 0.9, black: 0.1}, 1, WHITE, by_volume=v) for v in (0, 1)]
    light = lab_from_reflectance(films)[:, 0]
    assert light[0] < light[1] - 5.0


def test_parts_of_the_palette_are_volume():
    assert all(pigment.density is None for pigment in load_palette().values())
    red, white = load_pigment("cinnabar"), load_pigment("lead white")
    k, s, _ = mix_pigments({red: 1, white: 3})
    np.testing.assert_allclose(k, 0.25 * red.K + 0.75 * white.K, rtol=1e-12)
    np.testing.assert_allclose(s, 0.25 * red.S + 0.75 * white.S, rtol=1e-12)


def test_gloss_follows_the_paints_unless_told():
    for water in (0.0, 3.0):
        assert mix_pigments({"Vermillion": 1, "water": water}, by_volume=True)[2] == 1.0
        half = mix_pigments({"Vermillion": 1, "cinnabar": 1, "water": water}, by_volume=True)
        assert half[2] == pytest.approx(0.5)
    glossy = mixture_reflectance({"Vermillion": 1}, 1, WHITE)
    matt = mixture_reflectance({"Vermillion": 1}, 1, WHITE, saunderson=False)
    assert glossy.min() >= 0.03
    assert not np.allclose(glossy, matt, atol=0.01)
    plain = mixture_reflectance({"cinnabar": 1}, 1, WHITE)
    assert (plain == mixture_reflectance({"cinnabar": 1}, 1, WHITE, saunderson=False)).all()


def test_the_two_fits_of_one_paint_agree_where_it_was_measured():
    chart = np.full(31, 0.85)
    glossy = mixture_reflectance({"Vermillion": 1}, 1, chart)
    less_gloss = (glossy - 0.04) / (1.0 - 0.04)  # the palette's leave it to the picture
    matt = mixture_reflectance({"cinnabar": 1}, 1 / 0.065, chart)  # so many coats to a drawdown
    assert delta_e(lab_from_reflectance(less_gloss), lab_from_reflectance(matt)) < 1.0


def test_order_of_different_glazes_matters():
    red, blue = (load_pigment(name) for name in ("cinnabar", "azurite"))
    layers = [(red.K, red.S, 0.5), (blue.K, blue.S, 0.5)]
    labs = [lab_from_reflectance(stack_reflectance(o, WHITE)) for o in (layers, layers[::-1])]
    assert delta_e(*labs) > 5


def lightness(name, coats, ground):
    return lab_from_reflectance(mixture_reflectance({name: 1}, coats, ground))


def test_soot_is_black_and_oil_soot_blacker():
    """A full black is L* 7.3 and 2.1 without its gloss; pine soot's is warm, oil soot's cool."""
    for material in ("xuan", "porcelain"):
        ground = load_material(material).reflectance
        pine, oil = (lightness(name, 3.0, ground) for name in ("pine soot", "oil soot"))
        assert oil[0] < 3.0 < pine[0] < 8.0
        assert oil[2] < 0.0 < pine[2]
        for name in ("pine soot", "oil soot"):
            assert lightness(name, 1.0, ground)[0] < 12.0


def test_a_wash_of_soot_has_eight_even_steps():
    """Nine amounts of ink that lie evenly in lightness, from dipped black to bare paper."""
    paper = load_material("xuan").reflectance
    coats = np.geomspace(1e-4, 3.0, 2000)
    for name in ("pine soot", "oil soot"):
        light = np.array([lightness(name, c, paper)[0] for c in coats])
        assert np.all(np.diff(light) <= 1e-9)
        steps = np.linspace(lightness(name, 0.0, paper)[0], light[-1] + 0.5, 9)
        needed = np.interp(-steps[1:], -light, coats)
        assert np.all(np.diff(needed) > 0.02 * needed[:-1])
        assert -np.diff(steps).max() > 9.0


def test_a_wash_of_fine_soot_is_browner():
    """Small particles take up blue more than red (Mie), as makers say of oil soot."""
    paper = load_material("xuan").reflectance
    for coats in (0.03, 0.1, 0.3):
        pine, oil = (lightness(name, coats, paper) for name in ("pine soot", "oil soot"))
        assert oil[2] > pine[2] + 0.8
        assert abs(pine[1]) < 2.0


def test_layer_shapes_broadcast():
    film = layer_reflectance(np.ones((4, 1)), np.ones(31), 0.5, WHITE)
    assert film.shape == (4, 31)
    assert layer_reflectance(1.0, 1.0, 1.0, 0.5).shape == ()


@pytest.mark.parametrize(
    ("fractions", "coats", "backing", "message"),
    [
        ({}, 1.0, WHITE, "no paint"),
        ({"cinnabar": 0.0}, 1.0, WHITE, "no paint"),
        ({"cinnabar": -0.1}, 1.0, WHITE, "fraction of cinnabar"),
        ({"cinnabar": np.nan}, 1.0, WHITE, "fraction of cinnabar"),
        ({"cinnabar": 1.0}, -1.0, WHITE, "coats"),
        ({"cinnabar": 1.0}, np.inf, WHITE, "coats"),
        ({"cinnabar": 1.0}, 1.0, WHITE[:30], "backing"),
        ({"cinnabar": 1.0}, 1.0, WHITE + 1, "backing"),
        ({"cinnabar": 1.0}, 1.0, WHITE * np.nan, "backing"),
    ],
)
def test_bad_input_is_named(fractions, coats, backing, message):
    with pytest.raises(InputError, match=message):
        mixture_reflectance(fractions, coats, backing)


def test_unknown_paint_is_named_with_the_nearest():
    with pytest.raises(UnknownNameError, match="did you mean 'cinnabar'"):
        mixture_reflectance({"cinabar": 1.0}, 1.0, WHITE)


def test_layer_refuses_negative_strength():
    with pytest.raises(InputError, match="scattering holds -1"):
        layer_reflectance(1.0, -1.0, 1.0, 0.5)


# -- the nearest mixture -----------------------------------------------------------------------


GROUND = load_material("xuan").reflectance


def coat(parts):
    """Reflectance of a coat of a mixture on xuan."""
    inked = {ink: share for ink, share in parts.items() if ink is not WATER}
    return mixture_reflectance(inked, sum(inked.values()), GROUND)


def test_colours_of_mixtures_are_found_again() -> None:
    """Twenty mixtures of three pigments and water by chance; .02 in the mean, .16 at most."""
    draw, inks = np.random.default_rng(5), list(load_palette().values())
    off = []
    for _ in range(20):
        three = draw.choice(len(inks), 3, replace=False)
        shares = draw.dirichlet((1, 1, 1, 1))
        mixture = {inks[k]: share for k, share in zip(three, shares, strict=False)}
        found = nearest_mixture(srgb_from_reflectance(coat(mixture)), GROUND)
        off.append(found.difference)
    assert np.mean(off) < 0.1
    assert max(off) < 0.5


@pytest.mark.parametrize("code", [(255, 0, 0), (20, 60, 200), (120, 120, 120), (0, 0, 0)])
def test_what_is_said_of_a_mixture_is_so(code) -> None:
    found = nearest_mixture(code, GROUND)
    assert sum(found.parts.values()) == pytest.approx(1.0)
    assert len([ink for ink in found.parts if ink is not WATER]) <= 3
    lab = lab_from_reflectance(coat(found.parts))
    wanted = lab_from_srgb(np.array(code) / 255.0)
    assert found.difference == pytest.approx(float(delta_e(lab, wanted)), abs=1e-9)
    assert found.srgb == tuple(srgb_from_reflectance(coat(found.parts)))
    for ink in load_palette().values():  # no single one, thinned or not, is nearer
        singles = [coat({ink: share, WATER: 1.0 - share}) for share in (1.0, 0.4, 0.1)]
        assert (
            delta_e(lab_from_reflectance(np.array(singles)), wanted).min() > found.difference - 0.3
        )


def test_only_what_there_is_is_mixed() -> None:
    palette = load_palette()
    one = nearest_mixture((200, 60, 40), GROUND, [palette["cinnabar"]])
    assert set(one.parts) <= {palette["cinnabar"], WATER}
    two = nearest_mixture((200, 60, 40), GROUND, [palette["cinnabar"], palette["gamboge"], WATER])
    assert two.difference <= one.difference + 0.005  # what the search misses
    bare = nearest_mixture(srgb_from_reflectance(GROUND), GROUND)
    assert bare.difference < 0.6


@pytest.mark.parametrize(
    ("code", "ground", "told"),
    [((0, 0), GROUND, "sRGB"), ((0, 0, 300), GROUND, "expected three numbers from 0 to 255"),
     ((0, 0, 0), GROUND + 1.0, "ground is")],
)  # fmt: skip
def test_what_is_no_colour_is_refused(code, ground, told) -> None:
    with pytest.raises(InputError, match=told):
        nearest_mixture(code, ground)
    with pytest.raises(InputError, match="no pigment"):
        nearest_mixture((0, 0, 0), GROUND, [WATER])


# -- inks in words -----------------------------------------------------------------------------


PINE, OIL = load_pigment("pine soot"), load_pigment("oil soot")


@pytest.fixture
def table(tmp_path):
    file = tmp_path / "my, own.csv"
    columns = ",".join(f"{letter}_{n}" for letter in "KS" for n in (400, 550, 700))
    file.write_text(f"name,{columns}\nmine,1,2,3,4,4,4\n")
    return file


@pytest.mark.parametrize(
    ("text", "stirred"),
    [
        ("oil soot", {OIL: 1.0}),
        ("pine soot:0.2,water:0.8", {PINE: 0.2, WATER: 0.8}),
        (" pine soot : 2 , water ", {PINE: 2.0, WATER: 1.0}),
        ("pine soot:1,松烟墨:2", {PINE: 3.0}),
        ("light", {PINE: 0.09, WATER: 0.91}),
        ("burnt oil soot", {OIL: 1.0}),
        ("淡墨", {PINE: 0.09, WATER: 0.91}),
        ("濃油烟墨", {OIL: 0.25, WATER: 0.75}),
        ("light oil soot:1,water:1", {OIL: 0.09, WATER: 1.91}),
    ],
)
def test_inks_are_found_by_their_words(text, stirred):
    found = load_ink(text)
    assert list(found) == list(stirred)
    assert list(found.values()) == pytest.approx(list(stirred.values()))
    again = load_ink(describe_ink(found))
    shares = [np.array([*mixture.values()]) for mixture in (again, found)]
    np.testing.assert_allclose(*(parts / parts.sum() for parts in shares), rtol=1e-5)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("pine soot:x", r"has 'x' parts of 'pine soot'; expected a number above 0"),
        ("pine soot:nan", "expected a number above 0"),
        ("pine soot:0", "expected a number above 0"),
        ("pine soot,,water", "a part without a name"),
        (":3", "a part without a name"),
    ],
)
def test_what_is_no_mixture_is_told(text, message):
    with pytest.raises(PigmentError, match=message):
        load_ink(text)


def test_an_unknown_ink_lists_the_tones_too():
    with pytest.raises(UnknownNameError, match=r"did you mean 'light'"):
        load_ink("lihgt")
    with pytest.raises(UnknownNameError, match="unknown ink 'nothing'"):
        load_ink("light nothing")


def test_the_five_tones_and_the_paper_lie_evenly_apart():
    paper = load_material("xuan").reflectance
    assert tone_names() == list(TONES)
    for name in ("pine soot", "oil soot"):
        films = [
            mixture_reflectance(dict(load_ink(f"{tone} {name}").items()), 1.0, paper)
            for tone in TONES
        ]
        steps = np.diff(lab_from_reflectance([*films, paper])[:, 0])
        assert steps.min() > 14.0
        assert steps.max() < 20.5  # oil soot is blacker: its first step is the widest


def test_own_tables_are_read_where_they_are_asked_for_alone(table):
    assert [p.name for p in load_ink(f"{table}:mine")] == ["mine"]
    plain = table.rename(table.with_name("own.csv"))
    assert [p.name for p in load_ink(f"{plain}:mine:1,water:3")] == ["mine", "water"]
    assert split_ink(f"{plain}:mine:1,water:3") == [(f"{plain}:mine", 1.0), ("water", 3.0)]
    assert tables_in(f"water:3,{plain}:mine:1") == [str(plain)]
    assert tables_in(None) == tables_in("light:1,water:2") == []
    assert with_tables("own.csv:a:1,water:3", lambda f: f"/x/{f}") == "/x/own.csv:a:1,water:3"
    for text in (f"{plain}:mine", f"{plain}:mine,water:1", f"water:1, {plain}:mine:2"):
        with pytest.raises(PigmentError, match="of a table on this machine"):
            load_ink(text, own_tables=False)
