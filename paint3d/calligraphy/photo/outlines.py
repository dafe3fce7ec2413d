"""From a raster of strokes' bodies to polygons, with edges between the pixels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.hand_packages import package_of_the_hand

if TYPE_CHECKING:
    from collections.abc import Sequence

    from shapely import Polygon

__all__ = ["polygons_in"]

_SMOOTH = 0.7  # pixels
_STRAY = 0.15  # pixels that an edge may be simplified by
_BIT = 0.5  # squares of a width: smaller bits that smoothing cuts off are no strokes


def polygons_in(body: NDArray[np.bool_], width: float) -> list[Polygon]:
    """The connected shapes of a raster, each with its holes; x to the right, y down.

    Edges are smoothed, so ink that hangs together by a neck of a pixel is a shape on either side.

    Parameters
    ----------
    body : (H, W) bool
    width : float
        Of a usual stroke, pixels.
    """
    import shapely
    from scipy.ndimage import find_objects, gaussian_filter, label

    measure = package_of_the_hand("skimage.measure")
    areas, _ = label(body, np.ones((3, 3)))
    found = []
    for k, box in enumerate(find_objects(areas)):
        part = np.pad((areas[box] == k + 1).astype(np.float32), 4)
        rings = measure.find_contours(gaussian_filter(part, _SMOOTH), 0.5)
        start = np.array([box[1].start, box[0].start]) - 4.0 + 0.5
        shapes = _nested(
            [shapely.Polygon(ring[:, ::-1] + start) for ring in rings if len(ring) > 4]
        )
        largest = max((shape.area for shape in shapes), default=0.0)
        least = min(_BIT * width**2, largest)
        found += [shape for shape in shapes if shape.area >= least]
    return found


def _nested(rings: Sequence[Polygon]) -> list[Polygon]:
    """The areas that an odd number of rings goes around, largest first, with their holes."""
    import shapely

    rings = sorted(rings, key=lambda ring: -ring.area)
    insides = [ring.representative_point() for ring in rings]
    around = np.array([shapely.contains(ring, insides) for ring in rings])  # [outer, inner]
    around = np.triu(around, 1)  # a ring lies in larger ones, wherever its inside is
    depth = around.sum(axis=0)
    parts: list[Polygon] = []
    for k in np.flatnonzero(depth % 2 == 0):
        holes = [rings[i].exterior for i in np.flatnonzero(around[k] & (depth == depth[k] + 1))]
        whole = shapely.Polygon(rings[k].exterior, holes).simplify(_STRAY)
        whole = whole if whole.is_valid else shapely.make_valid(whole)
        flat = shapely.get_parts(shapely.get_parts(whole))  # a collection may hold a multipolygon
        parts += [part for part in flat if part.geom_type == "Polygon"]
    return parts
