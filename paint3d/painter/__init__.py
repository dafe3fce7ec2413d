"""The painter: runs recordings and live hands through the brush engine onto a surface."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
