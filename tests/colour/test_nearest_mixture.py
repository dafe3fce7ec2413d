"""The mixture of the palette that is nearest to a colour."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.colour.difference import delta_e, lab_from_reflectance, lab_from_srgb
from paint3d.colour.layers import mixture_reflectance
from paint3d.colour.materials import load_material
from paint3d.colour.nearest_mixture import nearest_mixture
from paint3d.colour.pigments import WATER, load_palette
from paint3d.colour.spectra import srgb_from_reflectance
from paint3d.errors import InputError

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
