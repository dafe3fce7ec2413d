"""Edges of paint between vertices, as sharp as the picture: what vertices give to shaders.

Vertices stand a resolution apart, and an edge drawn by interpolating their colours is a ramp as
wide, with the mesh's triangles in it. But the share of a vertex's area that paint covers tells
where between them it ends: where the interpolated share is half. A shader that knows it draws the
edge some two pixels wide at any scale, as letters are drawn from distance fields (Green, Improved
alpha-tested magnification for vector textures and special effects, 2007): docs/model.md,
equations (18) and (19).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.view.paper import Paper

__all__ = [
    "LEAST",
    "MIXED",
    "SRGB_CODES",
    "SRGB_LIGHT",
    "EdgeShaders",
    "Edges",
    "draw_edges",
    "edge_shares",
    "packed",
    "set_edges",
]

MIXED = 0.6  # of the neighbours in a vertex's share: shares alone end within one edge's length
LEAST = 1.5  # over the largest share around: a line thinner than the mesh is still drawn


class Edges(NamedTuple):
    """What a shader needs besides each vertex's colour.

    Attributes
    ----------
    bare : (V, 3) uint8
        sRGB without any paint.
    shares : (V, 2) uint8
        Codes of the share that is half where paint ends, and of the share that is painted.
    """

    bare: NDArray[np.uint8]
    shares: NDArray[np.uint8]

    def at(self, ids: AnyArray) -> Edges:
        """Return those of some vertices (N,)."""
        return Edges(self.bare[ids], self.shares[ids])


def edge_shares(faces: AnyArray, painted: AnyArray) -> NDArray[np.uint8]:
    """Return the shares (V, 2) of `Edges` on triangles (F, 3).

    Parameters
    ----------
    faces : (F, 3) int
    painted : (V,) uint8
        Share of each vertex's area that is under paint, 255: all.
    """
    n = len(painted)
    total, counts = np.zeros(n), np.zeros(n)
    for k in range(3):
        beside = painted[faces[:, k - 1]].astype(np.float64) + painted[faces[:, k - 2]]
        total += np.bincount(faces[:, k], beside, n)
        counts += 2.0 * np.bincount(faces[:, k], minlength=n)
    mean = np.where(counts > 0.0, total / np.maximum(counts, 1.0), painted)
    smooth = ((1.0 - MIXED) * painted + MIXED * mean) / 255.0
    top, of_face = smooth.copy(), smooth[faces].max(axis=1)
    for k in range(3):
        np.maximum.at(top, faces[:, k], of_face)
    share = smooth / np.clip(LEAST * top, 1e-9, 1.0)
    sharp = (255.0 * np.minimum(share, 1.0) + 0.5).astype(np.uint8)
    return np.stack([sharp, painted], axis=1)


def packed(codes: AnyArray) -> NDArray[np.float32]:
    """Return codes (N, 2 or 3) uint8 as a number (N, 1) each: VTK sends bytes as floats anyway."""
    number = codes[:, 0].astype(np.float32)
    for column in codes.T[1:]:
        number = number * np.float32(256.0) + column
    return number[:, None]


# ---- Shaders -------------------------------------------------------------------------------------

_WIDE = 1.5  # pixels from bare to painted
_UNPACKED = """
vec3 unpacked(float number) {  // of two codes the last two
  vec3 codes = floor(vec3(number / 65536.0, number / 256.0, number));
  return (codes - 256.0 * vec3(0.0, codes.xy)) / 255.0;
}
"""
_VERTEX = """
  bareCodes = unpacked(bare);
  bareLight = light_of(bareCodes);
  inkLight = light_of(scalarColor.rgb) - bareLight;
  sharesShown = unpacked(shares).yz;
"""
_SHARPENED = """
// The light where `bare` is that without paint and `ink` what paint adds to it, all interpolated,
// and an edge is `wide`, in shares.
vec3 sharpened(vec3 bare, vec3 ink, vec2 shares, float wide) {
  float drawn = clamp((shares.x - 0.5) / clamp(wide, 0.02, 1.0) + 0.5, 0.0, 1.0);
  vec3 light = max(bare + ink * (drawn / max(shares.y, 0.08)), 0.0);
  float mean = dot(light, vec3(1.0 / 3.0)); // of dark ink the codes of its edge tell no hue
  return mix(vec3(mean), light, min(mean / 0.03, 1.0));
}
"""
_TOOTH = 0.5  # shares that an edge is moved by where grain doubles what is seen of ink; by eye
_TORN = 60.0  # times as deep where the sheet is as much brighter: calm for long, then torn; by eye
_FRAGMENT = f"""
  painted = vertexColorVSOutput.xyz;  // as `.rgb` of it is replaced, see `draw_edges`
  float wide = {_WIDE:.1f} * length(vec2(dFdx(sharesShown.x), dFdy(sharesShown.x)));
  bool isEdge = sharesShown.x > 0.002 && sharesShown.x < 0.998 && wide < 1.0;
  if (isEdge) {{
    vec2 met = sharesShown + vec2({_TOOTH:.2f} * torn * moreInk, 0.0);
    vec3 light = sharpened(bareLight, inkLight, met, wide);
    painted = mix(codes_of(min(light, 1.0)), painted, smoothstep(0.5, 1.0, wide));
  }}
"""


class EdgeShaders(NamedTuple):
    """GLSL that puts the sharpened colour of a place into `painted`: declarations and code.

    `bareCodes` are those of the place without any paint. Vertices have the attributes `bare` and
    `shares`: those of `Edges`, `packed`. Shares of paint and paper add in linear light, so
    interpolation of it takes the place of interpolated codes at edges alone.
    """

    vertex_declared: str
    vertex: str
    declared: str
    fragment: str

    def fragment_on(self, paper: Paper | None) -> str:
        """Return the code where `paper` is shown: its ink has grain, and edges have its teeth.

        They are finer than the vertices; coarser ones are painted (`mesh.kernels.paper`).
        """
        if paper is None:
            return f"  float moreInk = 0.0, torn = 0.0;\n{self.fragment}"
        return f"""  vec2 ofSheet = {paper.read};
  float moreInk = ofSheet.y, torn = pow(clamp(1.0 + {_TORN:.1f} * ofSheet.x, 0.1, 3.0), 1.5);
{self.fragment}
  painted = in_grain(painted, bareCodes, {paper.in_ink} * moreInk, surfacePlace);
"""

    @classmethod
    def between(cls, light_of: str, codes_of: str) -> EdgeShaders:
        """Return them for colours whose linear light has the GLSL expressions.

        Parameters
        ----------
        light_of : str
            From a vec3 `codes`.
        codes_of : str
            From a vec3 `light`, 0 to 1.
        """
        light = f"vec3 light_of(vec3 codes) {{ return {light_of}; }}\n"
        codes = f"vec3 codes_of(vec3 light) {{ return {codes_of}; }}\n"
        passed = "vec3 bareCodes, bareLight, inkLight; {0} vec2 sharesShown;\n"
        return cls(
            "in float bare, shares;\nout " + passed.format("out") + _UNPACKED + light,
            _VERTEX,
            "vec3 painted;\nin " + passed.format("in") + _SHARPENED + codes,
            _FRAGMENT,
        )


SRGB_LIGHT = """mix(codes / 12.92, pow((codes + 0.055) / 1.055, vec3(2.4)), step(0.04045, codes))"""
SRGB_CODES = (
    "mix(12.92 * light, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, light))"
)
"""GLSL expressions of sRGB."""


def draw_edges(
    actor: Any, mesh: Any, edges: Edges, shaders: EdgeShaders, paper: Paper | None = None
) -> None:
    """Have the actor of a mesh draw the edges of paint sharp.

    `paper` is what it shows (`show_paper`).
    """
    mapper, shader = actor.GetMapper(), actor.GetShaderProperty()
    points = 0  # VTK's FIELD_ASSOCIATION_POINTS
    for name in ("bare", "shares"):
        mapper.MapDataArrayToVertexAttribute(name, name, points, -1)
    set_edges(mesh, edges)
    declare, assign, colour = (f"//VTK::{part}" for part in _MARKS)
    for mark, text in ((declare, shaders.vertex_declared), (assign, shaders.vertex)):
        shader.AddVertexShaderReplacement(mark, True, f"{mark}\n{text}", False)
    shader.AddFragmentShaderReplacement(declare, True, f"{declare}\n{shaders.declared}", False)
    shader.AddFragmentShaderReplacement(
        colour, True, f"{shaders.fragment_on(paper)}\n{colour}", False
    )
    shader.AddFragmentShaderReplacement("vertexColorVSOutput.rgb", False, "painted", True)


def set_edges(mesh: Any, edges: Edges) -> None:
    """Set or replace the edges of a VTK mesh that `draw_edges` was called for."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    for name, values in zip(("bare", "shares"), edges, strict=True):
        array = numpy_to_vtk(packed(values), deep=True)
        array.SetName(name)
        mesh.GetPointData().AddArray(array)


_MARKS = "PositionVC::Dec", "PositionVC::Impl", "Color::Impl"
