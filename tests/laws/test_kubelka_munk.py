"""Laws of light in layers of paint, and the known answers."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.colour.kernels.kubelka_munk import TANH_RATIO, layer_bands
from paint3d.colour.layers import (
    SAUNDERSON,
    layer_reflectance,
    mix_pigments,
    mixture_reflectance,
    stack_reflectance,
    to_internal,
    to_measured,
)
from paint3d.colour.pigments import Pigment, load_drawdown_paints, pigment_names

KNOWN = Path(__file__).parents[2] / "../shared/pigments/km_known_answers.json"

laws = settings(deadline=None, max_examples=60)
strengths = st.one_of(st.just(0.0), st.floats(1e-12, 1e4))
coats = st.one_of(st.just(0.0), st.floats(1e-9, 1e3))
grounds = st.floats(0.0, 1.0)
names = st.sampled_from(pigment_names())
weighed = st.sampled_from(list(load_drawdown_paints().values()))
masses = st.floats(0.01, 100.0)


def layer(k, s, x, ground):
    given_values = [np.array([float(v)]) for v in (k, s, x, ground)]
    results = [np.empty(1) for _ in range(3)]
    layer_bands(*given_values, *results)
    return tuple(float(r[0]) for r in results)


@pytest.mark.skipif(not KNOWN.exists(), reason="the known answers lie beside the checkout")
def test_known_answers_to_rounding():
    rows = np.array(json.loads(KNOWN.read_text())["rows"])
    results = [np.empty(len(rows)) for _ in range(3)]
    layer_bands(*np.ascontiguousarray(rows[:, :4].T), *results)
    assert len(rows) == 1260
    np.testing.assert_allclose(np.array(results).T, rows[:, 4:], rtol=0, atol=2e-15)


@laws
@given(strengths, strengths, coats, grounds)
def test_light_is_neither_made_nor_negative(k, s, x, ground):
    reflected, alone, through = layer(k, s, x, ground)
    assert -1e-15 <= reflected <= 1 + 1e-15
    assert 0 <= alone <= 1
    assert 0 <= through <= 1
    assert alone + through <= 1 + 1e-12


@laws
@given(strengths, strengths, coats, grounds)
def test_two_halves_are_one_layer(k, s, x, ground):
    below = layer(k, s, x / 2, ground)[0]
    assert layer(k, s, x / 2, below)[0] == pytest.approx(layer(k, s, x, ground)[0], abs=1e-11)


@laws
@given(strengths, strengths, grounds)
def test_no_paint_shows_the_ground(k, s, ground):
    assert layer(k, s, 0.0, ground) == (pytest.approx(ground, abs=1e-16), 0.0, 1.0)


@laws
@given(strengths, strengths, coats, grounds)
def test_reflected_is_alone_plus_what_the_ground_sends_back(k, s, x, ground):
    reflected, alone, through = layer(k, s, x, ground)
    if ground * alone < 1 - 1e-6:
        bounced = alone + through**2 * ground / (1 - ground * alone)
        assert reflected == pytest.approx(bounced, abs=1e-9)


@laws
@given(st.floats(0.01, 1e3), st.floats(0.01, 1e3))
def test_thick_paint_reaches_its_masstone(k, s):
    ratio = k / s
    masstone = 1 / (1 + ratio + np.sqrt(ratio * ratio + 2 * ratio))
    for ground in (0.0, 1.0):
        assert layer(k, s, 1e7, ground)[0] == pytest.approx(masstone, rel=1e-9)


@laws
@given(st.floats(0, 100), st.floats(1e-6, 100), grounds)
def test_clear_white_and_clear_black_limits(s, x, ground):
    only_white = (ground + s * x * (1 - ground)) / (1 + s * x * (1 - ground))
    assert layer(0.0, s, x, ground)[0] == pytest.approx(only_white, abs=1e-14)
    assert layer(s, 0.0, x, ground)[0] == pytest.approx(ground * np.exp(-2 * s * x), abs=1e-14)


@laws
@given(strengths, strengths, coats, coats, grounds)
def test_more_black_is_darker(k, s, x, more, ground):
    assert layer(k + more, s, x, ground)[0] <= layer(k, s, x, ground)[0] + 1e-12


@laws
@given(names, st.floats(0.01, 0.99), st.floats(0, 5))
def test_mixing_a_paint_with_itself_changes_nothing(name, share, thickness):
    ground = np.full(31, 0.7)
    k, s, _ = mix_pigments({name: 1.0})
    both = [(k, s, share * thickness), (k, s, (1 - share) * thickness)]
    np.testing.assert_allclose(
        stack_reflectance(both, ground),
        mixture_reflectance({name: 3.0}, thickness, ground),
        atol=1e-12,
    )


@laws
@given(names, names, st.floats(0.05, 0.95), st.floats(0, 5))
def test_a_mixture_lies_between_its_paints_in_absorption(one, two, share, thickness):
    k, s, _ = mix_pigments({one: 1 - share, two: share} if one != two else {one: 1.0})
    (k1, s1, _), (k2, s2, _) = mix_pigments({one: 1.0}), mix_pigments({two: 1.0})
    assert (k >= np.minimum(k1, k2) - 1e-12).all()
    assert (s <= np.maximum(s1, s2) + 1e-12).all()
    film = layer_reflectance(k, s, thickness, 0.5)
    assert ((film >= 0) & (film <= 1)).all()


@laws
@given(st.floats(0, 1))
def test_gloss_can_be_undone(reflectance):
    measured = to_measured(reflectance, *SAUNDERSON)
    assert 0.03 - 1e-15 <= measured <= 1 + 1e-15
    assert to_internal(measured, *SAUNDERSON) == pytest.approx(reflectance, abs=1e-14)


def test_tanh_ratio_of_the_fast_kernels_is_as_close_as_stated():
    u = np.linspace(1e-9, 36, 20001)
    top, bottom = (np.polynomial.polynomial.polyval(u, c) for c in TANH_RATIO)
    exact = np.tanh(np.sqrt(u)) / np.sqrt(u)
    assert np.abs(top / bottom / exact - 1).max() < 8e-6
    assert 1 - np.tanh(6.0) < 1.3e-5


@laws
@given(weighed, masses)
def test_a_mixture_of_one_paint_is_the_paint(paint, mass):
    k, s, glossy = mix_pigments({paint: mass})
    np.testing.assert_allclose(k, paint.K, rtol=1e-12)
    np.testing.assert_allclose(s, paint.S, rtol=1e-12)
    assert glossy == pytest.approx(1.0)


@laws
@given(st.lists(weighed, min_size=3, max_size=3, unique_by=id), st.tuples(masses, masses, masses))
def test_mixing_by_mass_is_associative_and_adds_volumes(paints, parts):
    """Two paints, stirred and weighed, are a paint: a third in it gives the mixture of all."""
    (a, b, c), (of_a, of_b, of_c) = paints, parts
    k, s, _ = mix_pigments({a: of_a, b: of_b})
    density = (of_a + of_b) / (of_a / a.density + of_b / b.density)
    stirred = Pigment("stirred", "", k, s, saunderson=True, density=density)
    at_once = mix_pigments({a: of_a, b: of_b, c: of_c})
    for one, other in zip(mix_pigments({stirred: of_a + of_b, c: of_c}), at_once, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9)
    volumes = [m / p.density for m, p in zip(parts, paints, strict=True)]
    amounts = sum(v * p.K for v, p in zip(volumes, paints, strict=True))
    np.testing.assert_allclose(at_once[0] * sum(volumes), amounts, rtol=1e-9)
