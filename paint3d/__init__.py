"""Paint Chinese calligraphy and brushwork on 3-D objects with a physically modelled brush.

The names in ``__init__.pyi`` are loaded when they are first used, so that ``import paint3d`` itself
is quick and loads none of the heavy packages.

>>> import paint3d
>>> surface = paint3d.PaintedSurface(paint3d.load_mesh("bowl"), resolution=0.8)
>>> painter = paint3d.Painter(surface, brush="full", ink="pine soot")
>>> stroke = painter.stroke([(0.4, 0.6), (0.6, 0.6)], pressure=(0.1, 0.6, 0.2))
>>> paint3d.export(surface, "bowl.glb")
"""

from __future__ import annotations

import lazy_loader

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> object:
    if name != "__version__":
        value: object = _load(name)
        return value
    from importlib.metadata import PackageNotFoundError, version

    try:
        value = version("paint3d")
    except PackageNotFoundError:  # a source tree that was never installed
        value = "0+unknown"
    globals()[name] = value
    return value
