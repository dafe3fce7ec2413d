"""The studio as a page: what Python makes for it, as a folder of static files."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
