"""From readings of two hands' devices to the brush's pose in the object's frame."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
