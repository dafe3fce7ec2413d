"""The paper of a sheet as pictures and the window show it: clouds and single fibres.

A sheet is felted of fibres some mm long, which lie denser here than there (see `surface.pores`).
They are drawn once on a tile that repeats, and shaders read it at a place on the object twice,
turned and in another size, so that nobody sees it repeat. It changes how bright the surface looks,
and nothing that is painted. How it looks is set by eye.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.view.vtk_parts import make_texture

__all__ = ["OF_CODES", "Paper", "show_paper"]

OF_CODES = 1.0 / 2.2
"""What of a small change of light is one of codes."""
_TILE_MM, _PIXELS = 64.0, 1024
_FIBRES = 5200  # on a tile
_LONG_MM = 8.0  # the longest
_STEP_MM = 0.05  # between points of a fibre
_BENDS = 0.03  # rad a step, standard deviation
_WIDE = 0.8  # pixels, standard deviation across
_PALE, _DARK = 1.0, -0.7  # of fibres, before they are scaled
_CLOUD_MM, _CLOUDS_FALL = 1.3, 0.12  # size below which clouds fade; per mm, from where they fall
_CLOUDS, _THREADS = 0.006, 0.010  # standard deviations of clouds and fibres, of linear light
_RANGE = 0.08  # of the light, from 0 to 255 of a tile


@lru_cache(maxsize=1)
def _tile() -> NDArray[np.uint8]:
    """Return the tile, (1024, 1024) uint8: 128 is the mean, wrapping on both axes."""
    from scipy.ndimage import gaussian_filter

    random = np.random.default_rng(5)
    cycles = np.fft.fftfreq(_PIXELS, _TILE_MM / _PIXELS)  # to the mm
    cycles = np.hypot(cycles[:, None], cycles[None, :])
    band = np.exp(-((cycles * _CLOUD_MM) ** 2)) / (1.0 + (cycles / _CLOUDS_FALL) ** 2) ** 0.75
    band[0, 0] = 0.0
    noise = np.fft.fft2(random.standard_normal((_PIXELS, _PIXELS)))
    clouds = np.fft.ifft2(noise * band).real

    steps = int(_LONG_MM / _STEP_MM)
    length = np.minimum(random.gamma(4.0, 1.0, _FIBRES) + 1.0, _LONG_MM)
    along = np.arange(steps) * _STEP_MM / length[:, None]
    turn = random.uniform(0.0, 2.0 * np.pi, (_FIBRES, 1))
    turn = turn + np.cumsum(random.normal(0.0, _BENDS, (_FIBRES, steps)), axis=1)
    start = random.uniform(0.0, _TILE_MM, (2, _FIBRES, 1))
    x = start[0] + np.cumsum(np.cos(turn), axis=1) * _STEP_MM
    y = start[1] + np.cumsum(np.sin(turn), axis=1) * _STEP_MM
    shade = random.choice([_PALE, _DARK], (_FIBRES, 1)) * random.uniform(0.3, 1.0, (_FIBRES, 1))
    shade = shade * np.sin(np.pi * np.clip(along, 0.0, 1.0))
    column, row = (np.floor(v * (_PIXELS / _TILE_MM)).astype(int) % _PIXELS for v in (x, y))
    drawn = np.bincount((row * _PIXELS + column).ravel(), shade.ravel(), _PIXELS**2)
    threads = gaussian_filter(drawn.reshape(_PIXELS, _PIXELS), _WIDE, mode="wrap")
    threads -= threads.mean()

    light = _CLOUDS * clouds / clouds.std() + _THREADS * threads / threads.std()
    tile: NDArray[np.uint8] = np.rint(255.0 * np.clip(0.5 + light / _RANGE, 0.0, 1.0)).astype(
        np.uint8
    )
    return tile


_SHADER = f"""
float paper(vec3 place, float amount) {{
  vec3 facing = abs(cross(dFdx(place), dFdy(place)));
  vec2 at = place.xy;
  if (facing.x > max(facing.y, facing.z)) at = place.yz;
  else if (facing.y > facing.z) at = place.zx;
  at /= {_TILE_MM};
  float light = texture(paperTile, at).r - 0.5;
  AGAIN
  return 1.0 + amount * {_RANGE:.3f} * light;
}}
"""
_TWICE = """vec2 other = 1.37 * mat2(0.8, -0.6, 0.6, 0.8) * at + vec2(0.31, 0.17);
  light += texture(paperTile, other).r - 0.5;"""
_ONCE = "light *= 1.4;"  # as uneven


class Paper:
    """The tile as a texture of one render window, and the shader that reads it.

    Parameters
    ----------
    quick : bool
        For drawing without a graphics card: read once, and without smaller copies of the tile.
    """

    def __init__(self, *, quick: bool = False) -> None:
        from vtkmodules.vtkRenderingCore import vtkTexture

        self._texture = make_texture(_tile()[..., None])
        self._texture.SetWrap(vtkTexture.Repeat)
        self._texture.SetMipmap(not quick)
        # in software that takes half a minute where a surface is seen at an angle
        self._texture.SetMaximumAnisotropicFiltering(1.0)
        self._text = _SHADER.replace("AGAIN", _ONCE if quick else _TWICE)

    def add_to(self, actor: Any, declared: str = "") -> None:
        """Have the shader of an actor know `paper`, after `declared`.

        GLSL calls `paper(place, amount)`, not within a branch: how bright a place of the object,
        mm, is over the mean, in linear light.
        """
        actor.GetProperty().SetTexture("paperTile", self._texture)
        mark = "//VTK::TCoord::Dec"  # VTK declares textures above it
        text = declared + self._text + mark
        actor.GetShaderProperty().AddFragmentShaderReplacement(mark, True, text, False)


def show_paper(actor: Any, mesh: Any, places: AnyArray, amount: float) -> None:
    """Have an actor of a mesh with a mapper of its own show paper.

    Parameters
    ----------
    actor, mesh
        See `edges.own_mapper`.
    places : (V, 3) float32
        Of the vertices on the object at rest, mm.
    amount : float
        As in `Gloss`.
    """
    from vtkmodules.util.numpy_support import numpy_to_vtk

    array = numpy_to_vtk(np.ascontiguousarray(places, np.float32), deep=True)
    array.SetName("place")
    mesh.GetPointData().AddArray(array)
    points = 0  # VTK's FIELD_ASSOCIATION_POINTS
    actor.GetMapper().MapDataArrayToVertexAttribute("place", "place", points, -1)
    Paper().add_to(actor, "in vec3 surfacePlace;")
    # other marks than those of `edges`: there is one text for each
    shader, (declare, assign, light) = actor.GetShaderProperty(), _MARKS
    given = f"{declare}\nin vec3 place;\nout vec3 surfacePlace;"
    shader.AddVertexShaderReplacement(declare, True, given, False)
    shader.AddVertexShaderReplacement(assign, True, f"{assign}\n  surfacePlace = place;", False)
    seen = f"""  float ofPaper = paper(surfacePlace, {amount:.3f});
  ambientColor *= ofPaper;
  diffuseColor *= ofPaper;
"""
    shader.AddFragmentShaderReplacement(light, True, seen + light, False)


_MARKS = "//VTK::Clip::Dec", "//VTK::Clip::Impl", "//VTK::Light::Impl"
