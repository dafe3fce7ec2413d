"""What Python programs call: a painter that also writes, draws, copies and presses seals."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
