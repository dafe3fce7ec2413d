"""Text that fills a sheet: size, columns, margins, and where a signature and a seal stand."""

from __future__ import annotations

import re
from itertools import product

import numpy as np
import pytest

from paint3d.calligraphy.composition import (
    compose,
    lines_of,
    place_on,
    seal_below,
    sign_beside,
)
from paint3d.calligraphy.layout import Layout, frames_for, layout_text
from paint3d.cli.info import info_lines
from paint3d.errors import InputError, MeshError
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.sheet_mesh import make_sheet, paper_bounds, writing_areas
from paint3d.mesh.sheets import parse_sheet
from tests.support.cases import long_but

POEM = "床前明月光\n疑是地上霜\n舉頭望明月\n低頭思故郷"
FORMS = ("scroll", "couplet", "square", "horizontal", "fan", "round-fan", "album", "a4")


def laid(name: str, text: str, **asked):
    sheet = parse_sheet(name)
    mesh = make_sheet(sheet)
    found = compose(sheet, text, **asked)
    layout = Layout(
        asked.get("order", "columns"), gap=found.gap, between=found.between, point=found.point
    )
    placed = layout_text(ClosestPoints(mesh), "\n".join(found.lines), found.em_mm, layout)
    return mesh, found, [one.square for one in placed]


def middles(squares) -> np.ndarray:
    return np.array([square.chart.frame.origin for square in squares])


@pytest.mark.parametrize(
    ("form", "text"),
    long_but(product(FORMS, [POEM, "永"]), product(FORMS, [POEM, "寧靜致遠", "永"])),
)
def test_text_fills_a_sheet_and_stays_within_it(form: str, text: str) -> None:
    mesh, found, squares = laid(form, text)
    assert "".join(found.lines) == text.replace("\n", "")
    corners = np.concatenate([square.points.reshape(-1, 3) for square in squares])
    low, high = mesh.bounds
    assert (corners >= low - 0.1).all()
    assert (corners <= high + 0.1).all()
    panels = writing_areas(mesh, False)
    room = sum(_area(area.mesh) for area in panels)
    assert len(squares) * found.em_mm**2 > (0.25 if len(squares) > 1 else 0.06) * room


def _area(mesh) -> float:
    corners = mesh.vertices[mesh.faces]
    crossed = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * float(np.linalg.norm(crossed, axis=1).sum())


def test_a_quatrain_on_a_scroll_stands_in_two_columns_from_the_right() -> None:
    _, found, squares = laid("scroll", POEM)
    assert found.lines == ("床前明月光疑是地上霜", "舉頭望明月低頭思故郷")
    right, left = np.split(middles(squares), 2)
    assert (right[:, 0] > left[:, 0] + found.em_mm - 0.1).all()
    assert (np.diff(right[:, 1]) < 0.0).all()


def test_marks_end_verses_and_letters_that_stand_in_lines_are_not_composed() -> None:
    marked = compose(parse_sheet("scroll"), "床前明月光，疑是地上霜。舉頭望明月，低頭思故郷。")
    assert marked == compose(parse_sheet("scroll"), POEM)
    assert compose(parse_sheet("scroll"), "Hello") is None


@pytest.mark.parametrize(
    ("form", "text"),
    long_but(product(FORMS, [POEM]), product(FORMS, [POEM, "寧靜致遠"])),
)
def test_signature_and_seal_stand_apart_from_the_text_on_the_paper(form: str, text: str) -> None:
    mesh, found, squares = laid(form, text, signature=7)
    surface = ClosestPoints(mesh)
    beside = sign_beside(mesh, squares, 7)
    assert 0.09 * found.em_mm < beside.em_mm < 0.5 * found.em_mm
    layout = Layout(point=tuple(beside.point.tolist()), between=beside.between)
    signature = layout_text(surface, "丙午年秋李白書", beside.em_mm, layout)
    signed = middles([one.square for one in signature])
    for other in (signed, beside.seal_point[None]):
        away = np.linalg.norm(other[:, None] - middles(squares), axis=2).min()
        assert away > 0.5 * (found.em_mm + beside.em_mm)
    half = 0.5 * beside.seal_mm
    rim = beside.seal_point + half * np.array([[1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]])
    assert np.linalg.norm(surface.find(rim).points - rim, axis=1).max() < 0.3 * half
    gap = np.linalg.norm(signed[-1] - beside.seal_point)
    assert gap < 1.5 * beside.em_mm + half
    below = seal_below([one.square for one in signature])
    assert np.linalg.norm(below.seal_point - beside.seal_point) < 0.3 * beside.em_mm


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("n", [2, 4, 5, 8, 20, 28, 56])
def test_columns_stand_farther_apart_than_their_characters(form: str, n: int) -> None:
    for signature in (None, 7):
        found = compose(parse_sheet(form), "一" * n, signature=signature)
        if parse_sheet(form).usual.panels == 1 and len(found.lines) > 1:
            assert found.between <= 0.5 * found.gap
            assert 0.19 < found.gap <= 0.8  # of a folding fan in the middle of its columns


@pytest.mark.parametrize("form", ["scroll", "square", "horizontal", "album", "a4"])
@pytest.mark.parametrize("text", [POEM, "寧靜致遠", "永"])
def test_a_signature_keeps_out_of_the_margin_and_its_seal_is_as_wide(form: str, text: str) -> None:
    mesh, found, squares = laid(form, text, signature=7)
    sheet, beside = parse_sheet(form), sign_beside(mesh, squares, 7)
    left, right = (middles(squares)[:, 0] + s * 0.41 * found.em_mm for s in (-1.0, 1.0))
    inked = beside.point[0] - 0.39 * beside.em_mm
    edge = 0.5 * sheet.width_mm - sheet.margin_mm
    assert -edge - 2.5 < inked
    assert right.max() < edge + 1.0
    assert left.min() - beside.point[0] > 0.6 * beside.em_mm
    assert 0.8 < beside.seal_mm / beside.em_mm < 0.95
    low = beside.seal_point[1] - 0.5 * beside.seal_mm
    assert low > middles(squares)[:, 1].min() - 0.45 * found.em_mm


@pytest.mark.parametrize("text", [POEM, "朝辭白帝彩雲間千里江陵一日還兩岸猿聲啼不住輕舟已過萬重山"])
def test_on_a_fan_a_seal_stands_clear_of_columns_that_draw_together(text: str) -> None:
    mesh, found, squares = laid("fan", text, signature=7)
    beside = sign_beside(mesh, squares, 7)
    away = np.linalg.norm(middles(squares) - beside.seal_point, axis=1).min()
    assert away > 0.5 * (found.em_mm + beside.seal_mm)


@pytest.mark.parametrize("form", ["scroll", "square", "fan", "sheet:340x1360"])
def test_a_seal_alone_stands_beside_the_end_of_a_text_in_the_middle(form: str) -> None:
    mesh, found, squares = laid(form, "山高水長", signature=0)
    sheet, beside = parse_sheet(form), sign_beside(mesh, squares, 0)
    ink = middles(squares)[:, 0]
    assert abs(ink.min() + ink.max()) < 0.01 * found.em_mm
    rim = 0.5 * beside.seal_mm
    away = squares[-1].chart.frame.origin - beside.seal_point
    x_axis, y_axis = squares[-1].chart.frame.x_axis, squares[-1].chart.frame.y_axis
    assert away @ x_axis > 0.41 * found.em_mm + rim + 0.1 * beside.seal_mm  # left of the ink
    assert away @ y_axis + rim == pytest.approx(0.41 * found.em_mm, abs=0.1 * found.em_mm)
    if form != "fan":
        assert beside.seal_point[0] - rim > -0.5 * sheet.width_mm + sheet.margin_mm - 0.1


@pytest.mark.parametrize("form", ["couplet", "couplet:150x600", "couplet:300x1500"])
@pytest.mark.parametrize("n", [0, 4, 8])
def test_a_signed_couplet_is_hardly_smaller_and_its_signature_stands_clear(form: str, n: int):
    text = "白日依山盡黃河入海流"
    mesh, found, squares = laid(form, text, signature=n)
    assert found.em_mm > 0.9 * compose(parse_sheet(form), text).em_mm
    beside, low = sign_beside(mesh, squares, n), paper_bounds(mesh)[0]
    text_ink = squares[-1].chart.frame.origin[0] - 0.41 * found.em_mm
    half = 0.5 * max(beside.em_mm if n else 0.0, beside.seal_mm)
    assert text_ink - (beside.seal_point[0] + half) > 0.3 * half
    assert beside.seal_point[0] - half > low[0] + 0.4 * parse_sheet(form).margin_mm


def test_a_large_column_beside_its_signature_stays_on_the_paper() -> None:
    _, found, squares = laid("sheet:340x1360", "山高水長", signature=2)
    assert len(found.lines) == 1
    assert len(squares) == 4


def test_a_short_signature_is_composed_below_a_short_column() -> None:
    text = "朝辭白帝彩雲間千里江陵一日還兩岸猿聲啼不住輕舟已過萬重山"
    mesh, found, squares = laid("square", text, signature=3)
    beside = sign_beside(mesh, squares, 3)
    assert len(found.lines[-1]) < len(found.lines[0])
    assert beside.point[0] == pytest.approx(middles(squares)[-1, 0], abs=0.1)
    assert found.em_mm > compose(parse_sheet("square"), text, signature=7).em_mm


def test_a_signature_stands_below_a_last_column_that_is_short() -> None:
    mesh, _, squares = laid("square", "床前明月光疑是地上霜舉頭望明月低頭思故郷無", signature=7)
    lines = lines_of(squares)
    assert len(lines[-1]) < len(lines[0])
    beside = sign_beside(mesh, squares, 2)
    last = lines[-1][-1].chart.frame.origin
    assert beside.point[0] == pytest.approx(last[0], abs=0.1)
    assert beside.point[1] < last[1]


@pytest.mark.parametrize("n", [8, 28, 56])
def test_long_and_short_columns_take_turns_on_a_folding_fan(n: int) -> None:
    mesh, found, squares = laid("fan", "一" * n, signature=7)
    lengths = [len(line) for line in found.lines]
    assert len(set(lengths[::2])) == 1
    assert len(set(lengths[1::2])) == 1
    assert lengths[1] < lengths[0]
    assert [len(line) for line in lines_of(squares)] == lengths
    apex = writing_areas(mesh, False)[0].apex
    arms = [np.linalg.norm(line[0].chart.frame.origin - apex) for line in lines_of(squares)]
    assert np.ptp(arms) < 0.02 * found.em_mm  # they hang from one arc


def test_a_short_last_column_has_the_signature_below_it_wherever_one_fits() -> None:
    """It was asked with the least distance of characters, and a hole stayed below them."""
    for form, n in (("square", 28), ("square", 10), ("a4", 10), ("album", 28)):
        mesh, found, squares = laid(form, "一" * n, signature=7)
        assert len(found.lines[-1]) < len(found.lines[0])
        beside = sign_beside(mesh, squares, 7)
        last = middles(squares)[-1]
        assert beside.point[0] == pytest.approx(last[0], abs=0.1)
        assert beside.seal_point[1] > middles(squares)[:, 1].min() - 0.5 * found.em_mm
        top = beside.point[1] + 0.5 * 7 * beside.em_mm
        assert top < last[1] - 0.8 * found.em_mm  # it does not touch what stands above


@pytest.mark.parametrize("order", ["columns", "row"])
@pytest.mark.parametrize("form", FORMS)
def test_given_distances_hold(form: str, order: str) -> None:
    sheet = parse_sheet(form)
    for gap, between in ((0.3, 0.05), (0.0, 0.4)):
        found = compose(sheet, POEM, order, gap=gap, between=between)
        assert (found.gap, found.between) == (gap, between)
    assert compose(sheet, POEM, order, gap=0.3).gap == 0.3
    assert compose(sheet, POEM, order, between=0.3).between == 0.3


@pytest.mark.parametrize("form", long_but(["fan"], ["a4", "couplet", "fan"]))
def test_a_text_too_long_for_a_sheet_is_refused_with_what_would_fit(form: str) -> None:
    sheet = parse_sheet(form)
    with pytest.raises(InputError, match="60000 characters would fill") as told:
        compose(sheet, "一" * 60_000)
    fits = int(re.search(r"at most (\d+) characters", str(told.value))[1])
    assert compose(sheet, "一" * fits).em_mm >= 4.0
    with pytest.raises(InputError, match="expected at most"):
        compose(sheet, "一" * (fits + 1))


@pytest.mark.parametrize("name", ["scroll:mounted", "couplet", "fan", "a4"])
def test_a_point_of_a_sheet_is_the_place_of_its_fractions(name: str) -> None:
    sheet = parse_sheet(name)
    surface = ClosestPoints(make_sheet(sheet))
    point = surface.find(np.array([[-70.0, 30.0, 0.0]])).points[0]
    at = place_on(sheet, point)
    (frame,) = frames_for(surface, at, None)
    np.testing.assert_allclose(frame.origin[:2], point[:2], atol=0.01)


def test_a_place_between_panels_is_on_the_nearest_and_a_sheet_has_no_back() -> None:
    surface = ClosestPoints(make_sheet(parse_sheet("couplet")))
    (frame,) = frames_for(surface, (0.55, 0.5), None)
    assert frame.origin[0] == pytest.approx(60.0, abs=0.01)  # the right one's rim
    with pytest.raises(MeshError, match="seen from the back the surface faces away"):
        list(frames_for(surface, (0.2, 0.5), "back"))


@pytest.mark.parametrize("name", ["scroll", "scroll:mounted", "couplet", "couplet:mounted", "fan"])
def test_info_tells_fractions_as_text_is_placed_by_them(name: str) -> None:
    surface = ClosestPoints(make_sheet(parse_sheet(name)))
    lines = list(info_lines(surface))
    (told,) = [line for line in lines if "U along x" in line]
    left, right, front, back = map(
        float,
        re.search(
            r"from (\S+) \(0\) to (\S+) mm \(1\), V along y from (\S+) to (\S+)", told
        ).groups(),
    )
    for u, v in ((0.2, 0.6), (0.8, 0.7)):
        (frame,) = frames_for(surface, (u, v), None)
        there = left + u * (right - left), front + v * (back - front)
        np.testing.assert_allclose(frame.origin[:2], there, atol=0.1)
    (tenths,) = [line for line in lines if "0.1 of U is" in line]
    u, v = map(float, re.findall(r"is (\S+) mm", tenths))
    assert (u, v) == pytest.approx((0.1 * (right - left), 0.1 * (back - front)), abs=0.1)


def test_info_tells_how_far_a_tenth_of_u_goes_round_a_body_and_which_way() -> None:
    surface = ClosestPoints(load_mesh("vase"))
    outside = "\n".join(info_lines(surface)).partition("--side outside")[2].partition("--side")[0]
    rows = re.findall(r"^ +([\d.]+) +[\d.]+ +(\d+) +([\d.]+)$", outside, re.MULTILINE)
    assert len(rows) >= 3
    for v, girth, tenth in (map(float, row) for row in rows[1:-1]):
        turns = np.linspace(0.45, 0.55, 9)
        ring = [next(iter(frames_for(surface, (u, v), "outside"))).origin for u in turns]
        way = np.linalg.norm(np.diff(ring, axis=0), axis=1).sum()
        assert tenth == pytest.approx(way, rel=0.02)
        assert girth == pytest.approx(10.0 * tenth, abs=1.0)
        assert ring[-1][0] > ring[0][0]  # to the right, as seen from its front
