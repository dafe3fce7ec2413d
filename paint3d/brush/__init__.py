"""Brushes as parameters: presets, bent shapes, dynamics, and the footprint they leave."""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
