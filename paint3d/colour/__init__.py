"""Pigments, inks and materials, and what colour a coat of them has on what lies below."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
