"""From a raster of strokes' bodies to polygons, with edges between the pixels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.hand_packages import package_of_the_hand

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

__all__ = ["polygons_in"]

_SMOOTH = 0.7  # pixels
_STRAY = 0.15  # pixels that an edge may be simplified by


def polygons_in(body: NDArray[np.bool_]) -> list[Polygon]:
    """The connected shapes of a raster (H, W), each with its holes; x to the right, y down."""
    import shapely
    from scipy.ndimage import find_objects, gaussian_filter, label

    measure = package_of_the_hand("skimage.measure")
    areas, _ = label(body, np.ones((3, 3)))
    found = []
    for k, box in enumerate(find_objects(areas)):
        part = np.pad((areas[box] == k + 1).astype(np.float32), 4)
        rings = measure.find_contours(gaussian_filter(part, _SMOOTH), 0.5)
        start = np.array([box[1].start, box[0].start]) - 4.0 + 0.5
        shapes = [shapely.Polygon(ring[:, ::-1] + start) for ring in rings if len(ring) > 4]
        found += _nested(sorted(shapes, key=lambda shape: -shape.area))
    return found


def _nested(shapes: list[Polygon]) -> list[Polygon]:
    """Rings, largest first, as polygons with holes: what lies in the first one is a hole of it."""
    import shapely

    if not shapes:
        return []
    outer = shapes[0]
    shapely.prepare(outer)
    holes = [ring for ring in shapes[1:] if outer.contains(ring.representative_point())]
    whole: Polygon | MultiPolygon = shapely.Polygon(
        outer.exterior, [hole.exterior for hole in holes]
    ).simplify(_STRAY)
    whole = whole if whole.is_valid else shapely.make_valid(whole)
    return [part for part in shapely.get_parts(whole) if part.geom_type == "Polygon"]
