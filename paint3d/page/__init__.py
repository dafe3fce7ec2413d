"""Builder of the studio as a web page: a folder of static files, or one file."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
