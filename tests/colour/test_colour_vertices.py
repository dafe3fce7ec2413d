"""Fast vertex colours against a slow, obvious twin."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from paint3d.colour.difference import delta_e, lab_from_linear_rgb
from paint3d.colour.layers import SAUNDERSON, layer_reflectance, to_internal, to_measured
from paint3d.colour.materials import load_material
from paint3d.colour.pigments import WATER, Pigment, load_pigment, pigment_names
from paint3d.colour.spectra import linear_rgb_from_reflectance, srgb_from_linear
from paint3d.colour.vertex_colours import ColourModel
from paint3d.errors import InputError

BACKING = load_material("porcelain").reflectance
MIXES = [
    ["pine soot"],
    ["Vermillion"],
    ["pine soot", "cinnabar"],
    ["indigo", "gamboge", "carmine"],
    ["Vermillion", "ZincWhite", "PrussianBlue"],
    ["pine soot", "Vermillion", "cinnabar"],
    ["Vermillion", "pine soot", "water"],
    pigment_names()[2:10],
]


def random_paint(n_pigments, count=3001, seed=3):
    rng = np.random.default_rng(seed)
    coverage = rng.uniform(0, 1, count).astype(np.float32)
    coverage[: count // 3] = 1.0
    coverage[-5:] = 0.0
    coats = 10 ** rng.uniform(-3, 1, (count, 1)) * rng.dirichlet(np.ones(n_pigments), count)
    return (coats * coverage[:, None]).astype(np.float32), coverage


def twin(pigments, amounts, coverage):
    """Linear RGB (V, 3) by the formula, in doubles, 31 bands."""
    c = coverage.astype(float)[:, None]
    coats = np.divide(amounts, c, out=np.zeros(amounts.shape), where=c > 0)
    glossy = coats @ np.array([float(p.saunderson) for p in pigments])
    film = np.maximum(coats @ np.array([float(p is not WATER) for p in pigments]), 1e-12)
    gloss = [loss * (glossy / film)[:, None] for loss in SAUNDERSON]
    k, s = (coats @ np.array([getattr(p, letter) for p in pigments]) for letter in "KS")
    ground = np.maximum(to_internal(BACKING, *gloss), 0)
    layer = to_measured(layer_reflectance(k, s, 1.0, ground), *gloss)
    return (1 - c) * linear_rgb_from_reflectance(BACKING) + c * linear_rgb_from_reflectance(layer)


def colours(model, amounts, coverage, ids=None):
    out = np.zeros((coverage.size, 3), np.uint8)
    linear = np.zeros((coverage.size, 3), np.float32)
    model.srgb(amounts, coverage, out, ids, linear_rgb=linear)
    return out, linear


def differences(one, two):
    return delta_e(*(lab_from_linear_rgb(np.clip(rgb, 0, 1)) for rgb in (one, two)))


@pytest.mark.parametrize("names", MIXES, ids=lambda names: "+".join(names[:3]))
def test_reference_path_equals_its_twin(names):
    pigments = [load_pigment(name) for name in names]
    amounts, coverage = random_paint(len(names))
    out, linear = colours(ColourModel(pigments, BACKING, "reference"), amounts, coverage)
    wanted = twin(pigments, amounts, coverage)
    assert differences(linear, wanted).max() < 0.02
    assert np.abs(out.astype(int) - srgb_from_linear(wanted)).max() <= 1


@pytest.mark.parametrize("names", MIXES, ids=lambda names: "+".join(names[:3]))
def test_live_path_is_within_the_stated_difference(names):
    pigments = [load_pigment(name) for name in names]
    amounts, coverage = random_paint(len(names))
    _, linear = colours(ColourModel(pigments, BACKING), amounts, coverage)
    apart = differences(linear, twin(pigments, amounts, coverage))
    assert apart.mean() < (0.1 if len(names) > 1 else 0.005)
    assert apart.max() < (0.6 if len(names) > 1 else 0.02)


def test_live_mixtures_of_the_whole_palette():
    rng = np.random.default_rng(77)
    apart = []
    for _ in range(60):
        names = rng.choice(pigment_names(), rng.integers(2, 5), replace=False)
        pigments = [load_pigment(str(name)) for name in names]
        amounts, coverage = random_paint(len(names), 50, int(rng.integers(1 << 30)))
        coverage[:] = 1.0
        _, linear = colours(ColourModel(pigments, BACKING), amounts, coverage)
        apart.append(differences(linear, twin(pigments, amounts, coverage)))
    assert np.mean(apart) < 0.1
    assert np.max(apart) < 0.6


def test_mixtures_beyond_the_palette_take_all_bands():
    own = Pigment("mine", "", np.full(31, 2.0), np.linspace(0, 1, 31))
    for pigments in ([own, load_pigment("cinnabar")], [load_pigment("Eosin"), own]):
        amounts, coverage = random_paint(2)
        live, reference = (
            colours(ColourModel(pigments, BACKING, path), amounts, coverage)
            for path in ("live", "reference")
        )
        assert (live[1] == reference[1]).all()


def test_a_glossy_paint_shines_where_it_lies_and_only_there():
    """As after a dip in one: what was painted before, in soot, keeps its black."""
    soot, glossy = load_pigment("pine soot"), load_pigment("Vermillion")
    amounts, coverage = random_paint(1)
    before, _ = colours(ColourModel([soot], BACKING), amounts, coverage)
    both = np.column_stack([amounts, np.zeros_like(amounts)])
    after, _ = colours(ColourModel([soot, glossy], BACKING), both, coverage)
    assert np.abs(before.astype(int) - after).max() <= 1
    alone, _ = colours(ColourModel([glossy], BACKING), amounts, coverage)
    with_soot, _ = colours(ColourModel([soot, glossy], BACKING), both[:, ::-1].copy(), coverage)
    assert np.abs(alone.astype(int) - with_soot).max() <= 1
    steps = np.linspace(0, 1, 201, dtype=np.float32)[:, None]  # from all of one to all of the other
    mixed = np.hstack([1 - steps, steps]).astype(np.float32)
    _, linear = colours(ColourModel([soot, glossy], BACKING), mixed, np.ones(201, np.float32))
    assert differences(linear[1:], linear[:-1]).max() < 2.0


@pytest.mark.parametrize("path", ["live", "reference"])
@pytest.mark.parametrize("names", MIXES[:3], ids=lambda names: "+".join(names))
def test_bits_do_not_depend_on_order_or_threads(names, path):
    model = ColourModel([load_pigment(name) for name in names], BACKING, path)
    amounts, coverage = random_paint(len(names))
    once, linear = colours(model, amounts, coverage)
    order = np.random.default_rng(0).permutation(coverage.size).astype(np.int32)
    again, again_linear = np.zeros_like(once), np.zeros_like(linear)
    with ThreadPoolExecutor(3) as threads:
        parts = np.array_split(order, 17)
        list(
            threads.map(lambda ids: model.srgb(amounts, coverage, again, ids, again_linear), parts)
        )
    assert (again == once).all()
    assert (again_linear.view(np.int32) == linear.view(np.int32)).all()


@pytest.mark.parametrize("names", MIXES[:3], ids=lambda names: "+".join(names))
def test_only_named_vertices_are_written(names):
    model = ColourModel([load_pigment(name) for name in names], BACKING)
    amounts, coverage = random_paint(len(names))
    out = np.full((coverage.size, 3), 7, np.uint8)
    model.srgb(amounts, coverage, out, np.array([5, 0, 2000], np.int32))
    written = np.flatnonzero((out != 7).any(axis=1))
    assert written.tolist() == [0, 5, 2000]
    model.srgb(amounts, coverage, out, np.empty(0, np.int32))


@pytest.mark.parametrize("names", [["pine soot"], ["pine soot", "cinnabar"]])
def test_extreme_amounts_stay_colours(names):
    model = ColourModel([load_pigment(name) for name in names], BACKING)
    amounts = np.array([[0], [1e-30], [1e30], [1], [3e38]], np.float32)
    amounts = np.repeat(amounts, len(names), axis=1)
    coverage = np.array([0, 1e-38, 1, 1e-20, 1], np.float32)
    out, linear = colours(model, amounts, coverage)
    assert np.isfinite(linear).all()
    assert out[0].tolist() == srgb_from_linear(model.bare_linear_rgb).tolist()
    assert np.abs(out[2].astype(int) - out[4]).max() <= 1
    assert (out[2] < 150).all()


def test_a_pigment_that_does_nothing_shows_the_surface():
    water = Pigment("water", "", np.zeros(31), np.zeros(31))
    amounts, coverage = random_paint(1)
    for path in ("live", "reference"):
        model = ColourModel([water], BACKING, path)
        out, _ = colours(model, amounts, coverage)
        assert (np.abs(out.astype(int) - srgb_from_linear(model.bare_linear_rgb)) <= 1).all()


@pytest.mark.parametrize(
    ("pigments", "backing", "path", "message"),
    [
        ([], BACKING, "live", "at least one"),
        (["pine soot"], BACKING, "fast", "path is 'fast'"),
        (["pine soot"], BACKING + 1, "live", "backing"),
        (["pine soot"], BACKING[:3], "live", "backing"),
    ],
)
def test_bad_models_are_refused(pigments, backing, path, message):
    with pytest.raises(InputError, match=message):
        ColourModel([load_pigment(name) for name in pigments], backing, path)


def test_bad_arrays_are_refused():
    model = ColourModel([load_pigment("pine soot")], BACKING)
    amounts, coverage = random_paint(1, 10)
    out = np.zeros((10, 3), np.uint8)
    for bad, message in [
        ((amounts.astype(float), coverage, out), "amounts"),
        ((amounts[:5], coverage, out), "amounts"),
        ((amounts, coverage, out[:5]), "out"),
        ((amounts, coverage, out, np.array([10], np.int32)), "vertex_ids"),
        ((amounts, coverage, out, np.array([-1], np.int32)), "vertex_ids"),
        ((amounts, coverage, out, np.array([1])), "vertex_ids"),
    ]:
        with pytest.raises(InputError, match=message):
            model.srgb(*bad)
