"""Painting one stroke: pose, bent tuft, footprint, the vertices below it, ink that passes."""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
