"""The paper of a sheet as pictures and the window show it: clouds, single fibres, and grain in ink.

A sheet is felted of fibres some mm long, which lie denser here than there (see `surface.pores`).
They are drawn once on a tile that repeats, and shaders read it at a place on the object twice,
turned and in another size, so that nobody sees it repeat. It changes how bright the surface looks,
and nothing that is painted. Ink lies unevenly in it: single fibres and pits stay paler or take
more. This grain is the tile's second channel, and is the exponent of what ink lets through, so
that bare paper and ink that hides stay as they are. How it looks is set by eye, grain beside scans
of old paintings: `paper.json`, which pages read too.
"""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.view.vtk_parts import make_texture

__all__ = ["RECIPE", "SHADER", "Paper", "show_paper"]

RECIPE: dict[str, Any] = json.loads(Path(__file__).with_name("paper.json").read_text("utf-8"))
"""How the tile is drawn and read.

`clouds`, `fibres`: the standard deviation of their linear `light` at one read of the tile, of the
two that are added, and `light_range` from 0 to 255; clouds fade below `smallest_mm`, and fall from
so many cycles to the mm. `specks`, `short_fibres`: the `weight` of each in the grain, whose
standard deviation is `grain`, as an exponent, and which is `grain_range` from 0 to 255. Of fibres:
`bends` is a standard deviation, rad a `step_mm`, and `dark` what dark ones are where pale ones are
1. `black` is what ink that hides shows of the bare sheet, `in_dark` what dark ink has of the
grain, and `pits` how many times more of it is seen where it is paler by more than `pit_from`.
Where grain doubles what is seen of ink, a place shows that of one `carried_mm` beside it.
"""
SHADER = Path(__file__).with_name("paper.glsl").read_text("utf-8")
"""GLSL that reads it; `Paper.add_to` says what it is called by."""
_READ = (
    "tile_mm", "pixels", "light_range", "grain_range", "black", "in_dark", "pits", "pit_from",
    "carried_mm",
)  # fmt: skip
_CONSTANTS = "".join(f"const float {name.upper()} = {float(RECIPE[name])!r};\n" for name in _READ)
"""GLSL: the numbers of the recipe that it reads."""
_OF_CODES = 1.0 / 2.2  # what of a small change of light is one of codes


@lru_cache(maxsize=1)
def _tile() -> NDArray[np.uint8]:
    """Return the tile, (1024, 1024, 2) uint8: 128 is the mean, wrapping on both axes."""
    from scipy.ndimage import gaussian_filter

    random = np.random.default_rng(5)
    n, clouds, fibres = RECIPE["pixels"], RECIPE["clouds"], RECIPE["fibres"]
    cycles = np.fft.fftfreq(n, RECIPE["tile_mm"] / n)  # to the mm
    cycles = np.hypot(cycles[:, None], cycles[None, :])
    fall = (1.0 + (cycles / clouds["falls_from"]) ** 2) ** 0.75
    band = np.exp(-((cycles * clouds["smallest_mm"]) ** 2)) / fall
    noise = np.fft.fft2(random.standard_normal((n, n)))
    light = clouds["light"] * _evened(np.fft.ifft2(noise * band).real)
    light += fibres["light"] * _fibres(fibres, random)

    short = RECIPE["short_fibres"]
    grain = -short["weight"] * _fibres(short, random)  # pale ones take less
    for specks in RECIPE["specks"]:
        white = random.standard_normal((n, n))
        soft = gaussian_filter(white, specks["size_px"], mode="wrap")
        grain += specks["weight"] * _evened(soft)
    grain = np.sqrt(0.5) * RECIPE["grain"] * _evened(grain)  # the tile is read twice
    parts = light / RECIPE["light_range"], grain / RECIPE["grain_range"]
    tile = np.rint(128.0 + 255.0 * np.stack(parts, axis=-1))
    return np.clip(tile, 0.0, 255.0).astype(np.uint8)


def _evened(field: AnyArray) -> AnyArray:
    """Return a field with mean 0 and standard deviation 1."""
    evened: AnyArray = (field - field.mean()) / field.std()
    return evened


def _fibres(about: dict[str, Any], random: np.random.Generator) -> AnyArray:
    """Return bent fibres, pale and dark, that fade at their ends; evened."""
    from scipy.ndimage import gaussian_filter

    pixels, count, step, size = (
        RECIPE["pixels"],
        about["count"],
        RECIPE["step_mm"],
        RECIPE["tile_mm"],
    )
    steps = int(about["longest_mm"] / step)
    length = about["shortest_mm"] + about["scale_mm"] * random.gamma(4.0, 1.0, count)
    along = np.arange(steps) * step / np.minimum(length, about["longest_mm"])[:, None]
    turn = random.uniform(0.0, 2.0 * np.pi, (count, 1))
    turn = turn + np.cumsum(random.normal(0.0, about["bends"], (count, steps)), axis=1)
    start = random.uniform(0.0, size, (2, count, 1))
    x = start[0] + np.cumsum(np.cos(turn), axis=1) * step
    y = start[1] + np.cumsum(np.sin(turn), axis=1) * step
    shade = random.choice([1.0, about["dark"]], (count, 1)) * random.uniform(0.3, 1.0, (count, 1))
    shade = shade * np.sin(np.pi * np.clip(along, 0.0, 1.0))
    column, row = (np.floor(v * (pixels / size)).astype(int) % pixels for v in (x, y))
    drawn = np.bincount((row * pixels + column).ravel(), shade.ravel(), pixels**2)
    return _evened(gaussian_filter(drawn.reshape(pixels, pixels), about["wide_px"], mode="wrap"))


class Paper:
    """The tile as a texture of one render window, and the shader that reads it.

    Parameters
    ----------
    amount : (2,) of float
        As `Gloss.paper`.
    quick : bool
        For drawing without a graphics card: read once, and without smaller copies of the tile.
    """

    def __init__(self, amount: tuple[float, float], *, quick: bool = False) -> None:
        from vtkmodules.vtkRenderingCore import vtkTexture

        self._amount = amount
        tile = _tile()
        spare = np.zeros_like(tile[..., :1])  # VTK takes two channels for grey and alpha
        self._texture = make_texture(np.concatenate([tile, spare], axis=-1))
        self._texture.SetWrap(vtkTexture.Repeat)
        self._texture.SetMipmap(not quick)
        # in software that takes half a minute where a surface is seen at an angle
        self._texture.SetMaximumAnisotropicFiltering(1.0)
        self._declared = f"const bool QUICK = {str(quick).lower()};\n{_CONSTANTS}{SHADER}"

    def add_to(self, actor: Any, declared: str = "") -> None:
        """Add `paper` and `in_grain` to the shader of an actor, after `declared`.

        What it calls them for reads `surfacePlace`, mm, and none of it may be within a branch.
        """
        actor.GetProperty().SetTexture("paperTile", self._texture)
        mark = "//VTK::TCoord::Dec"  # VTK declares textures above it
        text = f"{declared}\n{self._declared}{mark}"
        actor.GetShaderProperty().AddFragmentShaderReplacement(mark, True, text, False)

    def light(self, *, codes: bool) -> str:
        """GLSL: the factor of a place's linear light or, near enough, of its codes."""
        amount = self._amount[0] * (_OF_CODES if codes else 1.0)
        return f"(1.0 + {amount:.3f} * paper(surfacePlace).x)"

    @property
    def read(self) -> str:
        """GLSL: a vec2 of a place, 0 on average.

        How bright its paper is, and how much more ink raw paper would show there, as an exponent.
        """
        return f"{self._amount[0]:.3f} * paper(surfacePlace)"

    @property
    def in_ink(self) -> str:
        """GLSL: how much of that exponent is seen in ink."""
        return f"{self._amount[1] / max(self._amount[0], 1e-6):.3f}"


def show_paper(actor: Any, mesh: Any, places: AnyArray, paper: Paper, *, codes: bool) -> None:
    """Show paper on the actor of a mesh.

    Parameters
    ----------
    actor, mesh
        See `edges.draw_edges`.
    places : (V, 3) float32
        Of the vertices on the object at rest, mm.
    paper : Paper
    codes : bool
        Whether colours are codes, not linear light.
    """
    from vtkmodules.util.numpy_support import numpy_to_vtk

    array = numpy_to_vtk(np.ascontiguousarray(places, np.float32), deep=True)
    array.SetName("place")
    mesh.GetPointData().AddArray(array)
    points = 0  # VTK's FIELD_ASSOCIATION_POINTS
    actor.GetMapper().MapDataArrayToVertexAttribute("place", "place", points, -1)
    paper.add_to(actor, "in vec3 surfacePlace;")
    # other marks than those of `edges`: there is one text for each
    shader, (declare, assign, light) = actor.GetShaderProperty(), _MARKS
    given = f"{declare}\nin vec3 place;\nout vec3 surfacePlace;"
    shader.AddVertexShaderReplacement(declare, True, given, False)
    shader.AddVertexShaderReplacement(assign, True, f"{assign}\n  surfacePlace = place;", False)
    seen = f"""  float ofPaper = {paper.light(codes=codes)};
  ambientColor *= ofPaper;
  diffuseColor *= ofPaper;
"""
    shader.AddFragmentShaderReplacement(light, True, seen + light, False)


_MARKS = "//VTK::Clip::Dec", "//VTK::Clip::Impl", "//VTK::Light::Impl"
