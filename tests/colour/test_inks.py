"""Inks in words: tones, mixtures, tables, and what is refused."""

import numpy as np
import pytest

from paint3d.colour.difference import lab_from_reflectance
from paint3d.colour.ink_text import split_ink, tables_in, with_tables
from paint3d.colour.inks import TONES, describe_ink, load_ink, tone_names
from paint3d.colour.layers import mixture_reflectance
from paint3d.colour.materials import load_material
from paint3d.colour.pigments import WATER, load_pigment
from paint3d.errors import PigmentError, UnknownNameError

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
