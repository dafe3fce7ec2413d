"""Pigments, inks and materials, and what colour a coat of them has on what lies below."""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
